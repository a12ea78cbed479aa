"""Inertia tensors of a long series of snapshots, a few at a time: the file may be far larger than the memory.

Tests: tests/unit/studies/test_moments_series.py; tests/benchmarks/inertia_tensors.py measures it.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr
from numba import njit

from astroinertia.inertia import tensor
from astroinertia.inertia.principal import ROUND_OFF_GAP, principal_gap, tracked_frame
from astroinertia.units import in_unit, stated, unit_of

BUFFER = 2**23  # bytes of particles that are read at a time, which a cache still holds when they are summed
_BLOCK = 256  # particles summed by themselves before they join the total, which keeps the digits of a long sum


def moments_series(
    snapshots: xr.Dataset,
    about: Sequence[float] | None = None,
    series: str = "snapshot_time",
    particle: str = "particle",
    component: str = "i",
    tolerance: float = ROUND_OFF_GAP,
    buffer: int = BUFFER,
) -> xr.Dataset:
    """Mass, centre of mass, inertia tensor and principal axes of every snapshot.

    snapshots: opened lazily (xarray.open_dataset, open_mfdataset, a zarr store), with `position` (series, particle,
    component) and `mass` (series, particle) or (particle,), in any units and in any order of dimensions, with
    components in the order x, y, z or in that of their labels; nothing else is read. about: a fixed point (3,), in the
    unit of the positions or with units; the centre of mass of each snapshot where none is given. tolerance: principal
    moments nearer than this share of the largest count as equal; axes are continuous in time (principal.tracked_frame).
    buffer: bytes of particles to hold at a time; the next are read while these are summed. netCDF's own cache, 64 MB a
    variable, comes on top (netCDF4.set_chunk_cache). A chunk of the file that holds many snapshots is unpacked again
    for every buffer: store one snapshot a chunk. ValueError for dimensions or variables that are not there.

    >>> series = moments_series(ds.inertia.snapshots)
    >>> print(bool(series.inertia_tensor[-1, 2, 2] < series.inertia_tensor[0, 2, 2]))  # the star falls together
    True
    """
    position, mass = _arranged(snapshots, series, particle, component)
    point = None if about is None else _in_unit_of(position, about)
    count = position.sizes[series]
    snapshot_bytes = position.sizes[particle] * (3 * position.dtype.itemsize + mass.dtype.itemsize)
    step = max(1, buffer // max(snapshot_bytes, 1))
    slices = [slice(first, min(first + step, count)) for first in range(0, count, step)]
    total, centre, second = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
    fixed = mass.values[None] if series not in mass.dims else None
    for some, (masses, points) in zip(slices, _read_ahead(position, mass, fixed, series, slices), strict=True):
        _sum(masses, points, total[some], centre[some], second[some])
    inertia = tensor.inertia_from_second_moment(second)
    if point is not None:
        inertia = tensor.about_point(inertia, total, point - centre)
    return _dataset(snapshots, series, position, mass, total, centre, inertia, point, tolerance)


def _in_unit_of(position: xr.DataArray, about: Any) -> np.ndarray:
    """The numbers (3,) of a point in the unit of the positions; ValueError where they have none, or it is no point."""
    own = str(position.attrs.get("units", ""))

    def number(value: Any) -> Any:
        given = stated(value)
        if given is None:
            return value
        if not own:
            raise ValueError("about must have no unit, for the positions state none")
        return in_unit(given, own)

    of_all = number(about)
    values = of_all if of_all is not about else [number(value) for value in about]
    point = np.asarray(values, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(f"about must be three finite numbers, not {about!r:.60}")
    return point


def _arranged(snapshots: xr.Dataset, series: str, particle: str, component: str) -> tuple[xr.DataArray, xr.DataArray]:
    for name in ("position", "mass"):
        if name not in snapshots:
            raise ValueError(f"the snapshots have no variable {name!r}")
    position, mass = snapshots["position"], snapshots["mass"]
    if set(position.dims) != {series, particle, component} or position.sizes[component] != 3:
        raise ValueError(f"position has the dimensions {position.dims}, not ({series}, {particle}, {component}: 3)")
    if set(mass.dims) not in ({series, particle}, {particle}):
        raise ValueError(f"mass has the dimensions {mass.dims}, not ({series}, {particle}) nor ({particle},)")
    if not position.sizes[series] or not position.sizes[particle]:
        raise ValueError("there are no snapshots, or no particles in them")
    order = [dim for dim in (series, particle) if dim in mass.dims]
    return _from_x_to_z(position, component).transpose(series, particle, component), mass.transpose(*order)


def _from_x_to_z(position: xr.DataArray, component: str) -> xr.DataArray:
    """Positions with their components in the order x, y, z, which labels may say otherwise."""
    if component not in position.coords:
        return position
    labels = position[component].values
    if labels.dtype.kind in "fiu" and (np.diff(labels) > 0).all():
        return position
    # Other programs than xarray write text as characters, which xarray reads as bytes.
    letters = [str(label.decode() if isinstance(label, bytes) else label).lower() for label in labels.tolist()]
    if sorted(letters) != ["x", "y", "z"]:
        raise ValueError(f"the components of position are {', '.join(letters)}, and not x, y, z")
    return position if letters == ["x", "y", "z"] else position.isel({component: np.argsort(letters)})


def _read_ahead(
    position: xr.DataArray, mass: xr.DataArray, fixed: np.ndarray | None, series: str, slices: list[slice]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Masses and positions of each slice; while the caller works on one, a thread reads the next."""

    def read(some: slice) -> tuple[np.ndarray, np.ndarray]:
        here = {series: some}
        if fixed is not None:
            return fixed, position.isel(here).values
        return _without_accreted(mass.isel(here).values, position.isel(here).values)

    with ThreadPoolExecutor(1) as reader:
        coming = reader.submit(read, slices[0])
        for following in slices[1:]:
            ready = coming.result()
            coming = reader.submit(read, following)
            yield ready
            del ready  # before the next but one is read
        yield coming.result()


def _without_accreted(mass: np.ndarray, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What sinks have accreted, NaN in mass (S, N), as nothing where the first particle is that is still there."""
    gone = np.isnan(mass)
    if not gone.any():
        return mass, position
    first = np.argmin(gone, axis=1)
    places = position[np.arange(len(mass)), first][:, None]
    return np.where(gone, 0.0, mass), np.where(gone[..., None], places, position)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum(mass, position, total, centre, second):
    """Mass, centre and Q about the centre of each snapshot: mass (S or 1, N), position (S, N, 3)."""
    count = position.shape[1]
    for s in range(position.shape[0]):
        m, x = mass[s % mass.shape[0]], position[s]
        # About one of the particles first, and then about the centre: nothing is lost far from the origin.
        x0, y0, z0 = np.float64(x[0, 0]), np.float64(x[0, 1]), np.float64(x[0, 2])
        whole = cx = cy = cz = 0.0
        for first in range(0, count, _BLOCK):
            w = px = py = pz = 0.0
            for n in range(first, min(first + _BLOCK, count)):
                w += m[n]
                px += m[n] * (x[n, 0] - x0)
                py += m[n] * (x[n, 1] - y0)
                pz += m[n] * (x[n, 2] - z0)
            whole += w
            cx += px
            cy += py
            cz += pz
        x0, y0, z0 = x0 + cx / whole, y0 + cy / whole, z0 + cz / whole
        xx = yy = zz = xy = xz = yz = 0.0
        for first in range(0, count, _BLOCK):
            a = b = c = d = e = f = 0.0
            for n in range(first, min(first + _BLOCK, count)):
                u, v, w = x[n, 0] - x0, x[n, 1] - y0, x[n, 2] - z0
                mu, mv = m[n] * u, m[n] * v
                a += mu * u
                b += mv * v
                c += m[n] * w * w
                d += mu * v
                e += mu * w
                f += mv * w
            xx += a
            yy += b
            zz += c
            xy += d
            xz += e
            yz += f
        total[s] = whole
        centre[s, 0], centre[s, 1], centre[s, 2] = x0, y0, z0
        second[s, 0, 0], second[s, 1, 1], second[s, 2, 2] = xx, yy, zz
        second[s, 0, 1] = second[s, 1, 0] = xy
        second[s, 0, 2] = second[s, 2, 0] = xz
        second[s, 1, 2] = second[s, 2, 1] = yz


def _dataset(snapshots, series, position, mass, total, centre, inertia, about, tolerance) -> xr.Dataset:
    principal, axes = tracked_frame(inertia, tolerance)
    gap = principal_gap(principal)
    mass_unit, length_unit = map(unit_of, (mass, position))
    moment_unit = "1" if (mass_unit, length_unit) == ("1", "1") else f"{mass_unit} {length_unit}2"
    where = "about the centre of mass" if about is None else f"about the point {tuple(map(float, about))}"
    variables = {
        "mass": ((), total, mass_unit, "total mass"),
        "centre_of_mass": (("i",), centre, length_unit, "centre of mass"),
        "inertia_tensor": (("i", "j"), inertia, moment_unit, f"inertia tensor {where}"),
        "principal_moments": (("principal",), principal, moment_unit, f"principal moments of inertia {where}"),
        "principal_axes": (("principal", "i"), axes, "1", "principal axes, unit vectors, continuous in the series"),
        "principal_gap": (
            ("principal",), gap, "1", "distance of each principal moment from the nearest other, over the largest",
        ),
    }  # fmt: skip
    coords = {series: snapshots[series]} if series in snapshots.coords else {}
    dataset = xr.Dataset(
        {
            name: ((series, *dims), values, {"units": unit, "long_name": text})
            for name, (dims, values, unit, text) in variables.items()
        },
        coords={**coords, "i": list("xyz"), "j": list("xyz"), "principal": [1, 2, 3]},
        attrs={"title": f"inertia tensors of {position.sizes[series]} snapshots", "gap_tolerance": tolerance},
    )
    for name in ("principal_axes", "principal_gap"):
        dataset[name].attrs["tolerance"] = tolerance
    return dataset
