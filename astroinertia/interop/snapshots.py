"""Snapshots of a run, one at a time, as other codes' formats want them: particles of one moment, in SI.

Tests: tests/unit/interop/test_export.py.
"""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from astroinertia import dataset
from astroinertia.dataset.files import loaded
from astroinertia.errors import ArchiveError, SceneError
from astroinertia.sph.kernels import KERNELS
from astroinertia.storage.atomic import archive_errors
from astroinertia.units import quantity


@dataclass(frozen=True)
class Snapshot:
    """The particles of one moment, and what is to be said of them.

    arrays: (N,) or (N, 3) by the names of the dataset's schema, in the order of identity (N,), which counts from 1.
    time, arrays and box are in SI, or without units where dimensionless is true (G = 1). support: radius of the
    kernel's support in smoothing lengths, None where the file does not tell the kernel. box: lengths along x, y and z
    of a box that repeats itself along all three, else None.
    """

    name: str
    number: int
    time: float
    identity: np.ndarray
    arrays: dict[str, np.ndarray]
    dimensionless: bool
    gravitational_constant: float
    kernel: str | None
    box: tuple[float, float, float] | None
    source: str

    @property
    def support(self) -> float | None:
        """Radius of the kernel's support in smoothing lengths."""
        return KERNELS[self.kernel].support if self.kernel in KERNELS else None


def chosen_numbers(count: int, which: str, path: Path) -> list[int]:
    """Numbers of snapshots from 0, of `count`: "last", "all", or one, counted from the end where it is negative.

    SceneError for what is none of these.

    >>> print(chosen_numbers(3, "last", Path("star.nc")))
    [2]
    """
    if which == "all":
        return list(range(count))
    try:
        number = -1 if which == "last" else int(which)
    except ValueError:
        raise SceneError(f"--snapshot takes a number from 0, last or all, not '{which:.40}'") from None
    if not -count <= number < count:
        raise SceneError(f"{path} has {count} snapshots, numbered from 0: there is no {number}")
    return [number % count]


def snapshots_of(path: Path, which: str) -> Iterator[Snapshot]:
    """The chosen snapshots of a run's folder or file, read one after the other; SceneError where there is none.

    >>> print([f"{each.time:.0f} s" for each in snapshots_of(Path('runs/star'), 'all')])
    ['0 s', '600 s', '1200 s']
    """
    headline = dataset.open(path)
    particles = dataset.open_snapshots(path)
    if particles is None:
        model = headline.attrs.get("model", "unknown")
        raise SceneError(f"{path} has no snapshots of particles (its model is {model}); csv and zarr take the series")
    if "snapshot_time" not in particles.sizes:
        raise ArchiveError(f"{path} does not say when its snapshots are.")
    for number in chosen_numbers(particles.sizes["snapshot_time"], which, path):
        one = loaded(path, particles.isel(snapshot_time=number))
        with archive_errors(path, "does not hold the particles of a run"):
            snapshot = _snapshot(headline, one, number)
        yield snapshot


def _snapshot(headline: xr.Dataset, one: xr.Dataset, number: int) -> Snapshot:
    arrays = {
        str(name): (values.transpose("particle", "i") if "i" in values.dims else values).values
        for name, values in one.data_vars.items()
        if set(values.dims) in ({"particle"}, {"particle", "i"})
    }
    there = np.isfinite(arrays["mass"])  # what a sink has accreted is NaN
    arrays = {name: values[there] for name, values in arrays.items()}
    attrs = headline.attrs
    dimensionless = str(attrs.get("units_system", "SI")) != "SI"
    return Snapshot(
        name=str(attrs["name"]),
        number=number,
        time=float(one["snapshot_time"]),
        identity=np.flatnonzero(there).astype(np.uint64) + 1,
        arrays={name: values for name, values in arrays.items() if np.isfinite(values).all()},
        dimensionless=dimensionless,
        gravitational_constant=float(attrs["gravitational_constant"]),
        kernel=attrs.get("kernel"),
        box=_box(str(attrs.get("scene", ""))),
        source=str(attrs["source"]),
    )


def _box(scene: str) -> tuple[float, float, float] | None:
    box = tomllib.loads(scene).get("box")
    if box is None or "".join(sorted(box.get("periodic", "xyz"))) != "xyz":
        return None
    x, y, z = (quantity(length, "length") if isinstance(length, str) else float(length) for length in box["lengths"])
    return x, y, z
