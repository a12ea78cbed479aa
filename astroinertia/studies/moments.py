"""The inertia of what a file holds - particles, a mesh, a snapshot of a run - in one call: a file in, xarray out."""

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.errors import ArchiveError, SceneError
from astroinertia.inertia import tensor
from astroinertia.inertia.body import Body
from astroinertia.inertia.gravity_field import GravityField, mesh_field, particle_field
from astroinertia.inertia.mesh import FORMATS, mesh_body, read_mesh
from astroinertia.inertia.principal import ROUND_OFF_GAP, principal_frame, principal_gap, undefined_axes
from astroinertia.process.quantities import InputError, with_quantities
from astroinertia.sph.table import MAX_PARTICLES, SI, read_table
from astroinertia.sph.table_netcdf import fill_value
from astroinertia.storage.columns import check_there
from astroinertia.storage.hdf5_structure import is_hdf5
from astroinertia.units import in_si, quantity, unit_of, with_unit

PLAIN = ("1", "1")
SAME_VOLUME = "radius of the sphere of the same volume"
OUTERMOST = "distance of the outermost particle from the centre of mass"


@dataclass(frozen=True)
class Matter:
    """What a file holds: the body; points (N, 3) of it; a radius to compare with, and what that is.

    The points are particles of masses (N,), or vertices of a mesh with faces (F, 3).
    units: SI, or 1 for numbers whose unit is not known, of mass and of length. gap_tolerance: how near principal
    moments must be to count as equal, as a share of the largest. text: what it is, in words.
    """

    body: Body
    points: np.ndarray
    radius: float
    radius_convention: str
    units: tuple[str, str]
    gap_tolerance: float
    text: str
    masses: np.ndarray | None = None
    faces: np.ndarray | None = None
    file_length: float = 1.0  # the file's unit of length, in that of this record


def _in_its_units(function: Callable) -> Callable:
    """What a function takes besides a Matter, as numbers in its units: SI, or plain ones where those are not known."""
    names = tuple(inspect.signature(function).parameters)
    called_in_si = with_quantities(about="m")(function)

    @functools.wraps(called_in_si)
    def called(*args: Any, **options: Any) -> Any:
        given = dict(zip(names, args, strict=False)) | options
        matter = given.get("matter")
        if isinstance(matter, Matter) and matter.units == PLAIN:
            for name in {"about", "radius", "origin"} & given.keys():
                values = given[name] if isinstance(given[name], list | tuple) else [given[name]]
                if any(isinstance(value, str) or with_unit(value) is not None for value in values):
                    raise InputError(f"{name} must have no unit, for that of {matter.text} is not known.")
        return called_in_si(*args, **options)

    return called


def read_matter(
    path: str | Path, units: tuple[str, str] = PLAIN, snapshot: int | None = None, density: Any = None
) -> Matter:
    """The matter of a particle table (.csv, .npz, .nc, .h5, .hdf5, a dump of Phantom), a closed mesh (.stl, .obj, .ply,
    .off) or a run.

    units: of mass and length in the file, such as ("Msun", "Rsun"); the result is then in SI. A run knows its own, as
    do most snapshots of GADGET, SWIFT and Phantom.
    snapshot: which one of a run, from 0, or from the end if negative; the last where none is given. density: of the
    inside of a mesh, 1 where none is given, in the units of the file, or a quantity where these are given.
    SceneError or ArchiveError for a file that is not such, and for units that are none.

    >>> print(f"{read_matter('runs/star').body.mass / 1.98841e30:.3f}")  # solar masses, of the last snapshot
    1.000
    """
    path = Path(path)
    if path.suffix.lower() in FORMATS and snapshot is None:
        return _mesh(path, units, 1.0 if density is None else _in_file(density, units))
    if density is not None:
        raise SceneError(f"{path} is not a mesh, so its density is not to be given")
    if path.is_dir() or (path.is_file() and path.suffix.lower() == ".nc" and is_hdf5(path)):
        matter = _run_matter(path, units, -1 if snapshot is None else snapshot)
        if matter is not None:
            return matter
    if snapshot is not None:
        raise SceneError(f"{path} has no snapshots to choose from")
    table = read_table(path, fewest=1, beside=FORMATS)
    if table.units == SI and units != PLAIN:
        raise SceneError(f"{path} says which units it is in; leave --units out")
    text = ", ".join(filter(None, [_counted(table.mass.size), table.note]))
    matter = _particles(table.mass, table.position, units, ROUND_OFF_GAP, text)
    return replace(matter, units=("kg", "m")) if table.units == SI else matter


@_in_its_units
def moments(
    matter: Matter,
    about: Sequence[float] | None = None,
    axis: Sequence[float] | None = None,
    radius: float | None = None,
    field_degree: int | None = None,
    normalization: str = "4pi",
    field_in_principal_axes: bool = False,
) -> xr.Dataset:
    """Tensor, principal moments and axes, ratios, radii and equivalent ellipsoid of a body.

    All of them are about one point: `about` (3,), or the centre of mass, which the ellipsoid always is about. axis
    (3,): one more moment, about the line through that point along it. radius: R of the ratio I/(M R^2), else the one
    that the matter has. In the units of the matter and the axes of its file. principal_axes has unit vectors in rows,
    right-handed; where axis_defined is false the direction is arbitrary within the plane of equal moments. triaxiality
    is (a^2 - b^2) / (a^2 - c^2) of the semi-axes a >= b >= c, 0 for an oblate body and 1 for a prolate one (Franx,
    Illingworth & de Zeeuw 1991, ApJ 383, 112), NaN for a sphere. field_degree: also the harmonics of the gravity field
    to this degree, about that point, with R and a normalization as of inertia.gravity_field, in the axes of the file or
    the principal ones. ValueError for an axis without a direction, a radius that is not positive, and moments that
    overflow.

    >>> summary = moments(read_matter("runs/star"))
    >>> print(float(summary.principal_moments[-1] / summary.principal_moments[0]) < 1.1)  # nearly round
    True
    """
    body, origin = matter.body, np.asarray(matter.body.centre if about is None else about, dtype=float)
    radius, convention = (matter.radius, matter.radius_convention) if radius is None else (radius, "as given")
    if convention == "as given" and not 0 < radius < np.inf:
        raise ValueError(f"the radius of the ratio I/(M R^2) must be positive, not {radius:g}")
    with np.errstate(over="ignore", invalid="ignore"):
        inertia = np.asarray(body.inertia if about is None else body.about(origin))
    if not np.isfinite(inertia).all():
        raise ValueError("the moments are too large for a number")
    principal, axes = _principal(inertia, matter.gap_tolerance)
    gap, undefined = principal_gap(principal), undefined_axes(principal, matter.gap_tolerance)
    gyration = tensor.radius_of_gyration(np.where(principal < 0, np.nan, principal), body.mass)
    size = float(body.mass) * radius * radius
    mass, length, moment = matter.units[0], matter.units[1], _moment_unit(matter.units)
    p = ("principal",)
    variables = {
        "mass": ((), float(body.mass), mass, "total mass"),
        "centre_of_mass": (("i",), np.asarray(body.centre), length, "centre of mass"),
        "origin": (("i",), origin, length, "point that all moments are about"),
        "inertia_tensor": (("i", "j"), inertia, moment, "inertia tensor"),
        "principal_moments": (p, principal, moment, "principal moments of inertia, ascending"),
        "principal_axes": ((*p, "i"), axes, "1", "principal axes, unit vectors"),
        "principal_gap": (p, gap, "1", "distance of each principal moment from the nearest other, over the largest"),
        "axis_defined": (p, ~undefined, "1", "whether the principal axis has a direction of its own"),
        "radius_of_gyration": (p, gyration, length, "radii of gyration"),
        "moment_ratio": (p, principal / size if size > 0 else np.full(3, np.nan), "1", "I / (M R^2)"),
        "reference_radius": ((), radius, length, f"R: {convention}"),
        **_equivalent_ellipsoid(matter, principal if about is None else None),
        **({} if axis is None else _about_axis(matter, np.asarray(axis, dtype=float), inertia, principal[-1])),
    }
    harmonics, labels = {}, {}
    if field_degree is not None:
        from astroinertia.dataset.gravity_field import field_labels, field_variables  # netCDF takes its time

        field = gravity_field(matter, field_degree, radius, origin)
        field = field.in_principal_axes() if field_in_principal_axes else field
        harmonics, labels = field_variables([field], (), normalization, 1), field_labels(field_degree)
    return xr.Dataset(
        {
            name: (dims, value, {"units": unit, "long_name": long_name})
            for name, (dims, value, unit, long_name) in variables.items()
        }
        | harmonics,
        coords={"i": list("xyz"), "j": list("xyz"), "principal": [1, 2, 3], **labels},
        attrs={
            "title": f"inertia of {matter.text}",
            "about": "centre of mass" if about is None else "a given point",
            "radius_convention": convention,
            "gap_tolerance": matter.gap_tolerance,
        },
    )


def _equivalent_ellipsoid(matter: Matter, principal: np.ndarray | None) -> dict[str, tuple]:
    """Semi-axes and triaxiality, from the principal moments about the centre where these are known."""
    if principal is None:
        principal = _principal(np.asarray(matter.body.inertia), matter.gap_tolerance)[0]
    lengths = tensor.equivalent_semi_axes(matter.body.mass, principal)
    a2, b2, c2 = np.sort(lengths)[::-1] ** 2
    round_body = undefined_axes(principal, matter.gap_tolerance).all()
    text = "semi-axes of the homogeneous ellipsoid with this mass and the tensor about its centre"
    return {
        "semi_axes": (("principal",), lengths, matter.units[1], text),
        "triaxiality": ((), np.nan if round_body else (a2 - b2) / (a2 - c2), "1", "triaxiality"),
    }


def _about_axis(matter: Matter, direction: np.ndarray, inertia: np.ndarray, largest: float) -> dict[str, tuple]:
    """The moment about the line along a direction (3,) through the point that the tensor is about."""
    if not np.linalg.norm(direction) > 0:
        raise ValueError("an axis needs a direction")
    about_axis = float(_not_below(tensor.moment_about(inertia, direction), matter.gap_tolerance * largest))
    gyration, unit = tensor.radius_of_gyration(max(about_axis, 0.0), matter.body.mass), _moment_unit(matter.units)
    direction = direction / np.linalg.norm(direction)
    return {
        "axis": (("i",), direction, "1", "direction of the chosen axis, through the origin of the moments"),
        "axis_moment": ((), about_axis, unit, "moment of inertia about the chosen axis"),
        "axis_radius_of_gyration": ((), gyration, matter.units[1], "radius of gyration about the chosen axis"),
    }


@_in_its_units
def gravity_field(matter: Matter, degree: int, radius: float | None = None, origin: Any = None) -> GravityField:
    """The gravity field of the particles, or of the inside of the mesh, about the centre of mass or an origin (3,).

    radius: the reference radius, else the one that the matter has.

    >>> field = gravity_field(read_matter("runs/star"), degree=4)
    >>> print(abs(field.centre_of_mass).max() < 1e-12 * field.radius)  # about which it is
    True
    """
    size = matter.radius if radius is None else radius
    origin = matter.body.centre if origin is None else origin
    if matter.faces is not None:
        return mesh_field(matter.points, matter.faces, degree, size, mass=float(matter.body.mass), origin=origin)
    return particle_field(matter.masses, matter.points, degree, size, origin)


def _principal(inertia: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    moments, axes = principal_frame(inertia)
    return _not_below(moments, tolerance * moments[-1]), axes


def _not_below(moments: np.ndarray, round_off: float) -> np.ndarray:
    """Moments, 0 where they are below it by no more than round-off of the tensor: no body has less."""
    return np.where((moments < 0) & (moments >= -round_off), 0.0, moments)


def _moment_unit(units: tuple[str, str]) -> str:
    return "1" if units == PLAIN else "kg m2"


def _run_matter(path: Path, units: tuple[str, str], snapshot: int) -> Matter | None:
    """A snapshot of a run; None for a netCDF file without any."""
    from astroinertia import dataset  # only here: a table need not wait for it
    from astroinertia.dataset.derived import PARTICLE_GAP_TOLERANCE
    from astroinertia.dataset.files import loaded
    from astroinertia.dataset.snapshots import present
    from astroinertia.storage.atomic import archive_errors

    snapshots = dataset.open_snapshots(path)
    if snapshots is None:
        try:
            attributes = dataset.open(path).attrs
        except ArchiveError:
            if path.is_dir():
                raise
            return None
        if "sweep" in attributes:
            raise SceneError(f"{path} is of a sweep, whose members have the particles: give the folder of one of them")
        model = attributes.get("model", "sph")
        if model != "sph":
            raise SceneError(
                f"the run {path} has no snapshots, for its model is {model}, which has no particles; its moments "
                "are in its dataset, as inertia_tensor"
            )
        raise SceneError(f"the run {path} has no snapshots")
    # Not closed here: xarray shares the handle with whoever else has this file open in the process.
    if not {"snapshot_time", "particle"} <= set(snapshots.sizes):
        raise ArchiveError(f"{path} does not hold the particles of a run.")
    count = snapshots.sizes["snapshot_time"]
    if not -count <= snapshot < count:
        raise SceneError(f"{path} has {count} snapshots, numbered from 0: there is no {snapshot}")
    if snapshots.sizes["particle"] > MAX_PARTICLES:
        raise SceneError(f"{path} has more than {MAX_PARTICLES} particles")
    if units != PLAIN:
        raise SceneError(f"{path} says which units it is in; leave --units out")
    with archive_errors(path, "does not hold the particles of a run"):
        one = loaded(path, snapshots[["mass", "position", "snapshot_time"]].isel(snapshot_time=snapshot))
        mass, position, time = _of_a_snapshot(present(one))
    own = (unit_of(one["mass"]), unit_of(one["position"]))
    unit = unit_of(time).removeprefix("1")
    text = f"snapshot {snapshot % count} of {count}, at time {float(time):.6g} {unit}".strip()
    matter = _particles(mass, position, PLAIN, PARTICLE_GAP_TOLERANCE, f"{_counted(mass.size)}, {text}")
    return replace(matter, units=own)


def _of_a_snapshot(one: xr.Dataset) -> tuple[np.ndarray, np.ndarray, xr.DataArray]:
    """Masses (N,), places (N, 3) and the time; ValueError where they are not such."""
    mass, position, time = one["mass"].values, one["position"].transpose("particle", "i").values, one["snapshot_time"]
    count = mass.size
    if mass.shape != (count,) or position.shape != (count, 3) or time.ndim or not count:
        raise ValueError("masses and positions are not those of particles")
    if any(array.dtype.kind not in "fiu" for array in (mass, position, time)):
        raise ValueError("masses, positions or times are not numbers")
    if not all((np.isfinite(array) & (array != fill_value(array.dtype))).all() for array in (mass, position)):
        raise ValueError("masses or positions were never written, or are not finite")
    return mass, position, time


def _in_file(density: Any, units: tuple[str, str]) -> float:
    """A density in the units of a file: a number as it is, or one with a unit of its own."""
    try:
        own = with_unit(density)
        if own is None and not isinstance(density, str):
            return float(density)
        if units == PLAIN:
            raise SceneError("must be a plain number where the units of the mesh are not given.")
        in_this_record = float(in_si(own, "density")) if own is not None else quantity(str(density), "density")
    except (SceneError, TypeError, ValueError) as error:
        raise InputError(f"density: {error}") from None
    mass_unit, length_unit = _sizes(units)
    return in_this_record * length_unit**3 / mass_unit


def _mesh(path: Path, units: tuple[str, str], density: float) -> Matter:
    check_there(path, "mesh")
    if not 0 < density < np.inf:
        raise SceneError(f"the density of a mesh must be positive, not {density:g}")
    vertices, faces = read_mesh(path)
    mass_unit, length_unit = _sizes(units)
    density *= mass_unit / length_unit**3
    try:
        body = mesh_body(vertices * length_unit, faces, density=density)
    except ValueError as error:
        raise SceneError(f"mesh {path}: {error}") from error
    radius = (3 * float(body.mass) / density / (4 * np.pi)) ** (1 / 3)
    text = f"a mesh of {len(faces)} triangles, of density {density:g}{'' if units == PLAIN else ' kg/m3'}"
    return Matter(
        body, vertices * length_unit, radius, SAME_VOLUME, _own_units(units), ROUND_OFF_GAP, text, None, faces,
        length_unit,
    )  # fmt: skip


def _counted(count: int) -> str:
    return "1 particle" if count == 1 else f"{count} particles"


def _sizes(units: tuple[str, str]) -> tuple[float, float]:
    """The units of mass and length in a file, in those of the result."""
    if units == PLAIN:
        return 1.0, 1.0
    mass, length = (quantity(f"1 {unit}", kind) for unit, kind in zip(units, ("mass", "length"), strict=True))
    return mass, length


def _own_units(units: tuple[str, str]) -> tuple[str, str]:
    return PLAIN if units == PLAIN else ("kg", "m")


def _particles(mass: np.ndarray, position: np.ndarray, units: tuple[str, str], tolerance: float, text: str) -> Matter:
    mass_unit, length_unit = _sizes(units)
    mass, position = mass * mass_unit, position * length_unit
    with np.errstate(over="ignore", invalid="ignore"):  # `moments` says so of what is too large
        centre = tensor.centre_of_mass(mass, position)
        body = Body(mass.sum(), centre, tensor.inertia_tensor(mass, position, centre))
        radius = float(np.sqrt(((position - centre) ** 2).sum(-1).max()))
    return Matter(body, position, radius, OUTERMOST, _own_units(units), tolerance, text, mass, None, length_unit)
