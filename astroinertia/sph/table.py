"""A user's own particles: columns mass, x, y, z and, if wanted, vx, vy, vz and u, or the last snapshot of a run.

u is the specific internal energy, and may be called specific_internal_energy. A CSV file names its columns in the first
line that is not a comment (#); an npz file holds one array a column, never pickled objects; an nc file is the result of
an earlier run, or has the columns as variables; of h5 and hdf5 files, table_hdf5.py tells.
Tests: tests/unit/test_initial.py, tests/unit/test_hdf5_tables.py.
"""

import csv
import itertools
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.sph.table_hdf5 import SUFFIXES as HDF5_SUFFIXES
from astroinertia.sph.table_hdf5 import VECTORS, hdf5_columns, split_vectors

REQUIRED = ("mass", "x", "y", "z")
OPTIONAL = ("vx", "vy", "vz", "u")
MAX_BYTES = 2**30
MAX_PARTICLES = 10_000_000
FEWEST_PARTICLES = 4  # that have a volume
_MAX_LINE = 1024
_ALIASES = {"specific_internal_energy": "u"}


@dataclass(frozen=True)
class Table:
    """mass (N,), position (N, 3), velocity (N, 3) (zero where not given), internal_energy (N,) or None."""

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray | None


def read_table(path: str | Path, fewest: int = FEWEST_PARTICLES) -> Table:
    """Particles of a file, `fewest` or more, in the file's own units; SceneError that says what is wrong with it."""
    path = Path(path)
    if not path.is_file():
        raise SceneError(f"particle table {path} is {'a directory' if path.is_dir() else 'not there'}")
    if path.stat().st_size > MAX_BYTES:
        raise SceneError(f"particle table {path} is larger than {MAX_BYTES >> 20} MiB")
    if path.suffix.lower() not in _READERS:
        raise SceneError(f"particle table {path} must be a .csv, .npz, .nc, .h5 or .hdf5 file")
    return _checked(path, _READERS[path.suffix.lower()](path), fewest)


def _csv_columns(path: Path) -> dict[str, np.ndarray]:
    rows: list[list[float]] = []
    try:
        with path.open(newline="", encoding="utf-8") as file:
            limited = (_short(path, number, line) for number, line in enumerate(file, 1))
            lines = csv.reader(line for line in limited if line.strip() and not line.startswith("#"))
            names = [_ALIASES.get(name.strip(), name.strip()) for name in next(lines, [])]
            _check_names(path, names)
            for row in itertools.islice(lines, MAX_PARTICLES + 1):
                if len(row) != len(names):
                    raise SceneError(
                        f"particle table {path}: row {len(rows) + 1} has {len(row)} values, not {len(names)}"
                    )
                rows.append([float(value) for value in row])
    except UnicodeDecodeError as error:
        raise SceneError(f"particle table {path} is not text") from error
    except (ValueError, csv.Error) as error:
        raise SceneError(f"particle table {path}: row {len(rows) + 1} is not numbers ({error})") from error
    return dict(zip(names, np.array(rows, dtype=float).reshape(-1, len(names)).T, strict=True))


def _short(path: Path, number: int, line: str) -> str:
    if len(line) > _MAX_LINE:
        raise SceneError(f"particle table {path}: line {number} is longer than {_MAX_LINE} characters")
    return line


def _npz_columns(path: Path) -> dict[str, np.ndarray]:
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > MAX_BYTES:
                raise SceneError(f"particle table {path} unpacks to more than {MAX_BYTES >> 20} MiB")
        with np.load(path, allow_pickle=False) as stored:
            files = [str(name) for name in stored.files]
            names = [_ALIASES.get(name, name) for name in files]
            _check_names(path, names)
            return {name: np.asarray(stored[file], dtype=float) for name, file in zip(names, files, strict=True)}
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, RuntimeError) as error:
        raise SceneError(f"particle table {path} is not an npz file of plain numbers") from error


def _netcdf_columns(path: Path) -> dict[str, np.ndarray]:
    import netCDF4  # only here: most runs read no file

    try:
        with netCDF4.Dataset(path) as file:
            if "snapshots" in file.groups:
                return _snapshot_columns(path, file.groups["snapshots"])
            named = {_ALIASES.get(name, name): variable for name, variable in file.variables.items()}
            found = {name: named[name] for name in (*REQUIRED, *OPTIONAL, *VECTORS) if name in named}
            if any(variable.size > 3 * MAX_PARTICLES for variable in found.values()):
                raise SceneError(f"particle table {path} has more than {MAX_PARTICLES} particles")
            columns = {name: np.ma.filled(variable[:].astype(float), np.nan) for name, variable in found.items()}
    except (OSError, KeyError, IndexError, ValueError, RuntimeError) as error:
        raise SceneError(f"particle table {path} is not the result of a run, nor a netCDF file of columns") from error
    columns = split_vectors(path, columns)
    _check_names(path, list(columns))
    return columns


def _snapshot_columns(path: Path, group: Any) -> dict[str, np.ndarray]:
    if len(group.dimensions["particle"]) > MAX_PARTICLES:
        raise SceneError(f"particle table {path} has more than {MAX_PARTICLES} particles")
    names = ("mass", "position", "velocity", "internal_energy")
    mass, position, velocity, energy = (np.ma.filled(group[name][-1], np.nan).T for name in names)
    return dict(zip(REQUIRED + OPTIONAL, [mass, *position, *velocity, energy], strict=True))


def _hdf5_columns(path: Path) -> dict[str, np.ndarray]:
    columns = hdf5_columns(path, (*REQUIRED, *OPTIONAL, *_ALIASES), MAX_PARTICLES)
    columns = {_ALIASES.get(name, name): column for name, column in columns.items()}
    _check_names(path, list(columns))
    return columns


_READERS = {".csv": _csv_columns, ".npz": _npz_columns, ".nc": _netcdf_columns} | dict.fromkeys(
    HDF5_SUFFIXES, _hdf5_columns
)


def _check_names(path: Path, names: list[str]) -> None:
    known = REQUIRED + OPTIONAL
    missing = [name for name in REQUIRED if name not in names]
    unknown = [name for name in names if name not in known]
    if missing or unknown or len(set(names)) != len(names):
        wrong = f"lacks {', '.join(missing)}" if missing else f"has unknown or repeated columns {unknown[:4]!r:.80}"
        raise SceneError(
            f"particle table {path} {wrong}; its columns are {', '.join(REQUIRED)} and maybe {', '.join(OPTIONAL)}"
        )


def _checked(path: Path, columns: dict[str, np.ndarray], fewest: int) -> Table:
    count = columns["mass"].size
    for name, column in columns.items():
        if column.shape != (count,):
            raise SceneError(f"particle table {path}: column {name} is not one number a particle")
        if not np.isfinite(column).all():
            raise SceneError(
                f"particle table {path}: {name} of row {int(np.argmin(np.isfinite(column))) + 1} is not finite"
            )
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
    )
