"""A user's own particles: columns mass, x, y, z and, if wanted, vx, vy, vz and u, or the last snapshot of a run.

u is the specific internal energy, and may be called internal_energy or specific_internal_energy; mass m, M or masses;
capitals are as good. An nc file is the result of an earlier run, or has the columns as variables; of csv, npz, h5
and hdf5 files, columns.py tells, of snapshots of other codes table_gadget.py and table_phantom.py. Density (rho),
smoothing_length (h, hsml) and pressure may be columns, too, and are passed over. Tests:
tests/unit/sph/test_initial_particles.py, tests/unit/storage/test_table_hdf5.py,
tests/unit/sph/test_table_of_snapshots.py, tests/unit/sph/test_table_phantom.py.
"""

import math
import warnings
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from astroinertia.errors import SceneError, SceneWarning
from astroinertia.sph.table_gadget import FileUnits, snapshot_columns, snapshot_units
from astroinertia.sph.table_netcdf import netcdf_columns
from astroinertia.sph.table_phantom import is_dump, read_dump
from astroinertia.storage.columns import (
    Columns,
    Read,
    check_file,
    check_numbers,
    check_size,
    csv_columns,
    hdf5,
    npz_columns,
    scaled,
    suffix_of,
    unit_scales,
)
from astroinertia.storage.table_hdf5 import SUFFIXES as HDF5_SUFFIXES, netcdf_group, split_units, split_vectors
from astroinertia.units import DIMENSIONLESS, CodeUnits

REQUIRED = ("mass", "x", "y", "z")
OPTIONAL = ("vx", "vy", "vz", "u")
PASSED_OVER = ("density", "smoothing_length", "pressure")  # what exported tables have besides
MAX_PARTICLES = 10_000_000
FEWEST_PARTICLES = 4  # that have a volume
_ALIASES = {
    "m": "mass", "masses": "mass", "specific_internal_energy": "u", "internal_energy": "u", "rho": "density",
    "h": "smoothing_length", "hsml": "smoothing_length",
}  # fmt: skip
_DIMENSIONS = (
    {"mass": "mass", "u": "specific_energy", "density": "density", "pressure": "pressure", "smoothing_length": "length"}
    | dict.fromkeys("xyz", "length")
    | dict.fromkeys(("vx", "vy", "vz"), "velocity")
)
COLUMNS = Columns("particle table", REQUIRED, OPTIONAL + PASSED_OVER, MAX_PARTICLES, _ALIASES, _DIMENSIONS)
SI, UNKNOWN = "SI", "unknown"

_OF_SERIES = b"time ["  # how those of a run begin (interop/tables.py), and no table of particles


@dataclass(frozen=True)
class Table:
    """mass (N,), position (N, 3), velocity (N, 3) (zero where not given), internal_energy (N,) or None.

    units: SI of a file that states its units, UNKNOWN of a snapshot of another code that states none, None of a table
    that does not, which is in SI where the scene has units. own: those that a snapshot states. note: what of the file
    is among the particles or left out; unfit: what it has that a scene's body cannot; both may be empty. columns: those
    of the file that are taken.
    """

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray | None
    units: str | None = None
    own: FileUnits | None = None
    note: str = ""
    unfit: str = ""
    columns: tuple[str, ...] = ()


def read_table(path: str | Path, fewest: int = FEWEST_PARTICLES, beside: tuple[str, ...] = ()) -> Table:
    """Particles of a file, `fewest` or more, in SI where it states its units; SceneError that says what is wrong.

    beside: endings of other files that the caller takes, for what is said of a file that is neither.
    """
    path = Path(path)
    if is_dump(path):
        check_size(path, COLUMNS.what)
        dump = read_dump(path, MAX_PARTICLES, COLUMNS.what)
        return replace(_checked(path, dump.columns, fewest, dump.units, True), note=dump.note, unfit=dump.unfit)
    check_file(path, COLUMNS.what, (*_READERS, *beside))
    suffix = suffix_of(path)
    snapshot = snapshot_columns(path, MAX_PARTICLES, COLUMNS.what) if suffix in HDF5_SUFFIXES else None
    if snapshot is not None:
        columns, own, note = snapshot
        return replace(_checked(path, columns, fewest, own, True), note=note)
    if suffix == ".csv":
        _refuse_series(path)
    reader = _READERS[suffix]
    if suffix in HDF5_SUFFIXES and (place := netcdf_group(path, COLUMNS.spellings, COLUMNS.what)):
        reader = partial(_netcdf, group=place)
    columns, stated = reader(path, COLUMNS)
    return replace(_checked(path, columns, fewest, None, False), units=SI if stated else None)


def _refuse_series(path: Path) -> None:
    with path.open("rb") as file:
        if file.read(len(_OF_SERIES)) == _OF_SERIES:
            raise SceneError(
                f"{path} has the headline series of a run, as `astroinertia export RUN --to csv` writes them, and no "
                "particles; with --snapshot last it writes a particle table. `astroinertia show` is for the run itself"
            )


def read_body(path: str | Path, units: CodeUnits, velocity_unit: float | None = None) -> Table:
    """Particles of a file for a scene of those code units, in them (see `in_code_units`).

    SceneError also for what is no fluid; a SceneWarning tells what is left out.
    """
    table = read_table(path)
    if table.unfit:
        raise SceneError(f"particle table {path} has {table.unfit}, so it cannot be a body; `moments` takes it")
    if table.note:
        warnings.warn(f"particle table {path}: {table.note}.", SceneWarning, stacklevel=2)
    return in_code_units(table, path, units, velocity_unit)


def in_code_units(table: Table, path: str | Path, units: CodeUnits, velocity_unit: float | None = None) -> Table:
    """The table in the code units of a scene.

    Numbers of a file that states no units are such already, but for velocities where their unit (m/s) is said. Where
    the scene is dimensionless, what has units is in its own of mass and length, and of time with G = 1, which changes
    velocities if G is not 1 in the file's. SceneError for a velocity_unit of a file or a scene that has no use for it.
    """
    dimensionless = units == DIMENSIONLESS
    if velocity_unit is not None and (table.units != UNKNOWN or dimensionless):
        why = 'units = "code"' if dimensionless else "its file has units"
        raise SceneError(f"[body] has a velocity_unit, but {why}; leave it out")
    if table.units == UNKNOWN:
        fast = 1.0 if velocity_unit is None else velocity_unit / units.unit("velocity")
        return _scaled(table, 1.0, 1.0, fast)
    if dimensionless and table.units == SI and table.own is None:
        raise SceneError(f'particle table {path} states units, but the scene has none (units = "code")')
    if dimensionless and table.own is not None:
        own = table.own
        return _scaled(table, 1.0 / own.mass, 1.0 / own.length, 1.0 / own.velocity / math.sqrt(own.in_itself))
    return _scaled(table, *(1.0 / units.unit(name) for name in ("mass", "length", "velocity")))


def _scaled(table: Table, mass: float, length: float, velocity: float) -> Table:
    energy = table.internal_energy
    return replace(
        table, mass=table.mass * mass, position=table.position * length, velocity=table.velocity * velocity,
        internal_energy=None if energy is None else energy * velocity**2,
    )  # fmt: skip


def units_for(path: Path, in_si: bool) -> tuple[float, float] | None:
    """Units of mass (kg) and length (m) for a scene that has none, from a table; None where its numbers have none.

    Those that a snapshot states; of a table whose columns have units, and of any plain one that is in SI (in_si),
    its mass, and the distance of its outermost particle from the centre of mass. SceneError for what cannot be read.
    """
    if is_dump(path):
        check_size(path, COLUMNS.what)
        own = read_dump(path, MAX_PARTICLES, COLUMNS.what).units
        return None if own is None or own.all_one else (own.mass, own.length)
    check_file(path, COLUMNS.what, tuple(_READERS))
    own = snapshot_units(path, COLUMNS.what) if path.suffix.lower() in HDF5_SUFFIXES else None
    if own is not None:
        return None if own.all_one else (own.mass, own.length)
    facts = path.stat()
    return _extent(path, in_si, facts.st_size, facts.st_mtime_ns)


@lru_cache(maxsize=8)  # members of a sweep have one table
def _extent(path: Path, in_si: bool, size: int, changed: int) -> tuple[float, float] | None:
    table = read_table(path)
    if table.units != SI and (table.units == UNKNOWN or not in_si):
        return None
    total = float(table.mass.sum())
    about = np.linalg.norm(table.position - table.mass @ table.position / total, axis=1).max()
    if not (math.isfinite(total) and math.isfinite(about) and about > 0.0):
        raise SceneError(f"particle table {path} has no extent that units could be taken from: give [units]")
    return total, float(about)


def _netcdf(path: Path, wanted: Columns, group: str = "/") -> Read:
    arrays, units = netcdf_columns(path, REQUIRED + OPTIONAL, MAX_PARTICLES, wanted.named, group)
    columns = split_vectors(f"{wanted.what} {path}", arrays)
    wanted.check(path, list(columns))
    return scaled(columns, unit_scales(path, wanted, columns, split_units(units)))


_READERS = (
    dict.fromkeys((".csv", ".ecsv"), csv_columns)
    | {".npz": npz_columns, ".nc": _netcdf}
    | dict.fromkeys(HDF5_SUFFIXES, hdf5)
)


def _checked(path: Path, columns: dict[str, np.ndarray], fewest: int, units: FileUnits | None, snapshot: bool) -> Table:
    count = columns["mass"].size
    check_numbers(path, COLUMNS.what, columns, "particle")
    if not fewest <= count <= MAX_PARTICLES:
        raise SceneError(f"particle table {path} has {count} particles, not {fewest} to {MAX_PARTICLES}")
    if not (columns["mass"] > 0).all():
        raise SceneError(
            f"particle table {path}: mass of row {int(np.argmax(columns['mass'] <= 0)) + 1} is not positive"
        )
    if "u" in columns and not (columns["u"] >= 0).all():
        raise SceneError(f"particle table {path}: u of row {int(np.argmax(columns['u'] < 0)) + 1} is negative")
    nothing = np.zeros(count)
    return Table(
        mass=columns["mass"],
        position=np.stack([columns[name] for name in "xyz"], axis=1),
        velocity=np.stack([columns.get(name, nothing) for name in ("vx", "vy", "vz")], axis=1),
        internal_energy=columns.get("u"),
        units=(UNKNOWN if units is None else SI) if snapshot else None,
        own=units,
        columns=tuple(name for name in REQUIRED + OPTIONAL if name in columns),
    )
