"""A user's own particles: columns mass, x, y, z and, if wanted, vx, vy, vz and u, or the last snapshot of a run.

u is the specific internal energy, and may be called specific_internal_energy. An nc file is the result of an earlier
run, or has the columns as variables; of csv, npz, h5 and hdf5 files, columns.py tells, of snapshots of other codes
table_gadget.py and table_phantom.py. Density, smoothing_length and pressure may be columns, too, and are passed over.
Tests: tests/unit/sph/test_initial_particles.py, tests/unit/storage/test_table_hdf5.py,
tests/unit/sph/test_table_of_snapshots.py, tests/unit/sph/test_table_phantom.py.
"""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from astroinertia.errors import SceneError, SceneWarning
from astroinertia.sph.table_gadget import SI, UNKNOWN, snapshot_columns
from astroinertia.sph.table_netcdf import netcdf_columns
from astroinertia.sph.table_phantom import is_dump, read_dump
from astroinertia.storage.columns import Columns, check_file, check_numbers, check_size, csv_columns, hdf5, npz_columns
from astroinertia.storage.table_hdf5 import SUFFIXES as HDF5_SUFFIXES, split_vectors

REQUIRED = ("mass", "x", "y", "z")
OPTIONAL = ("vx", "vy", "vz", "u")
PASSED_OVER = ("density", "smoothing_length", "pressure")  # what exported tables have besides
MAX_PARTICLES = 10_000_000
FEWEST_PARTICLES = 4  # that have a volume
COLUMNS = Columns("particle table", REQUIRED, OPTIONAL + PASSED_OVER, MAX_PARTICLES, {"specific_internal_energy": "u"})


@dataclass(frozen=True)
class Table:
    """mass (N,), position (N, 3), velocity (N, 3) (zero where not given), internal_energy (N,) or None.

    units: SI or UNKNOWN of a snapshot of another code; None where they are those of whoever made the table. note: what
    of the file is among the particles or left out; unfit: what it has that a scene's body cannot; both may be empty.
    """

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray | None
    units: str | None = None
    note: str = ""
    unfit: str = ""


def read_table(path: str | Path, fewest: int = FEWEST_PARTICLES) -> Table:
    """Particles of a file, `fewest` or more, in the file's own units; SceneError that says what is wrong with it."""
    path = Path(path)
    if is_dump(path):
        check_size(path, COLUMNS.what)
        dump = read_dump(path, MAX_PARTICLES, COLUMNS.what)
        return replace(_checked(path, dump.columns, fewest, dump.units), note=dump.note, unfit=dump.unfit)
    check_file(path, COLUMNS.what, tuple(_READERS))
    suffix = path.suffix.lower()
    snapshot = snapshot_columns(path, MAX_PARTICLES, COLUMNS.what) if suffix in HDF5_SUFFIXES else None
    columns, units = (_READERS[suffix](path, COLUMNS), None) if snapshot is None else snapshot
    return _checked(path, columns, fewest, units)


def read_body(path: str | Path, dimensionless: bool) -> Table:
    """Particles of a file for a scene, in SI or in the code units of a dimensionless one.

    SceneError also for a snapshot of another code whose units are not those of the scene, or that is no fluid; a
    SceneWarning tells what is left out.
    """
    table = read_table(path)
    if table.unfit:
        raise SceneError(f"particle table {path} has {table.unfit}, so it cannot be a body; `moments` takes it")
    if table.note:
        warnings.warn(f"particle table {path}: {table.note}.", SceneWarning, stacklevel=2)
    if table.units == UNKNOWN and not dimensionless:
        raise SceneError(f'particle table {path} does not tell its units: it can be a body where units = "code"')
    if table.units == SI and dimensionless:
        raise SceneError(f'particle table {path} has units, so it cannot be a body where units = "code"')
    return table


def _netcdf(path: Path, wanted: Columns) -> dict[str, np.ndarray]:
    arrays = netcdf_columns(path, REQUIRED + OPTIONAL, MAX_PARTICLES, wanted.named)
    columns = split_vectors(f"{wanted.what} {path}", arrays)
    wanted.check(path, list(columns))
    return columns


_READERS = {".csv": csv_columns, ".npz": npz_columns, ".nc": _netcdf} | dict.fromkeys(HDF5_SUFFIXES, hdf5)


def _checked(path: Path, columns: dict[str, np.ndarray], fewest: int, units: str | None) -> Table:
    count = columns["mass"].size
    check_numbers(path, COLUMNS.what, columns, "particle")
    if not fewest <= count <= MAX_PARTICLES:
        raise SceneError(f"particle table {path} has {count} particles, not {fewest} to {MAX_PARTICLES}")
    if not (columns["mass"] > 0).all():
        raise SceneError(f"particle table {path}: mass of row {int(np.argmin(columns['mass'])) + 1} is not positive")
    if "u" in columns and not (columns["u"] >= 0).all():
        raise SceneError(f"particle table {path}: u of row {int(np.argmin(columns['u'])) + 1} is negative")
    nothing = np.zeros(count)
    return Table(
        mass=columns["mass"],
        position=np.stack([columns[name] for name in "xyz"], axis=1),
        velocity=np.stack([columns.get(name, nothing) for name in ("vx", "vy", "vz")], axis=1),
        internal_energy=columns.get("u"),
        units=units,
    )
