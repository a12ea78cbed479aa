"""Particle columns of an HDF5 file, which may come from anywhere: read as plain numbers, bounded, and only from itself.

The columns stand at the root, or in the one group that holds them, as datasets mass, x, y, z (and vx, vy, vz, u), or
with position and velocity of shape (N, 3) instead; or as the fields of one structured dataset, as astropy and PyTables
write them. Other datasets are passed over. Links to other files are not followed.
Tests: tests/unit/test_hdf5_tables.py.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError

SUFFIXES = (".h5", ".hdf5")
VECTORS = {"position": ("x", "y", "z"), "velocity": ("vx", "vy", "vz")}
_MOST_MEMBERS = 1000  # names that are looked at in a group


def hdf5_columns(path: Path, known: tuple[str, ...], most: int) -> dict[str, np.ndarray]:
    """Columns (N,) of a file by name, as float64, of which `known` are wanted; N at most `most`.

    SceneError that says what is wrong with the file, or that h5py is not installed.
    """
    try:
        import h5py  # pyright: ignore[reportMissingImports]  an extra: only these files need it
    except ImportError:
        raise SceneError(f"{path}: HDF5 files need h5py; install it with: pip install 'astroinertia[hdf5]'") from None
    wanted = (*known, *VECTORS)
    try:
        with h5py.File(path, "r") as file:
            found = _members(h5py, path, file, wanted)
            for name in () if found else _group_names(h5py, path, file):
                inside = _members(h5py, path, file[name], wanted)
                if inside and found:
                    raise SceneError(f"particle table {path} has columns in more than one group")
                found = found or inside
            return split_vectors(path, {name: _numbers(path, name, member, most) for name, member in found.items()})
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
        raise SceneError(f"particle table {path} is not an HDF5 file that can be read") from error


def split_vectors(path: Path, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns with position and velocity (N, 3), where there are such, as three columns each."""
    split = {}
    for name, column in columns.items():
        if name not in VECTORS:
            split[name] = column
        elif column.ndim != 2 or column.shape[1] != 3:
            raise SceneError(f"particle table {path}: {name} is not three numbers a particle")
        else:
            split |= dict(zip(VECTORS[name], column.T, strict=True))
    return split


def _members(h5py: Any, path: Path, group: Any, wanted: tuple[str, ...]) -> dict[str, tuple[Any, str | None]]:
    """The wanted columns in a group: the dataset of each, and its field in that where it is structured."""
    own = {name: group[name] for name in _names(path, group) if _is_own(h5py, group, name)}
    datasets = {name: member for name, member in own.items() if isinstance(member, h5py.Dataset)}
    found: dict[str, tuple[Any, str | None]] = {name: (datasets[name], None) for name in wanted if name in datasets}
    tables = [member for member in datasets.values() if member.dtype.names]
    if found or len(tables) != 1:
        return found
    return {name: (tables[0], name) for name in wanted if name in tables[0].dtype.names}


def _group_names(h5py: Any, path: Path, file: Any) -> list[str]:
    return [
        name
        for name in _names(path, file)
        if _is_own(h5py, file, name) and file.get(name, getclass=True) is h5py.Group and file[name] != file
    ]


def _names(path: Path, group: Any) -> list[str]:
    if len(group) > _MOST_MEMBERS:
        raise SceneError(f"particle table {path} has more than {_MOST_MEMBERS} members in a group")
    return list(group)


def _is_own(h5py: Any, group: Any, name: str) -> bool:
    """Whether a name stands for something in this file and not for a path, here or in another file."""
    return isinstance(group.get(name, getlink=True), h5py.HardLink)


def _numbers(path: Path, name: str, member: tuple[Any, str | None], most: int) -> np.ndarray:
    dataset, field = member
    kind = dataset.dtype if field is None else dataset.dtype[field]
    shape = (*(dataset.shape or ()), *kind.shape)
    if kind.base.kind not in "fiu":
        raise SceneError(f"particle table {path}: {name} is not of numbers")
    if not shape or shape[0] > most or np.prod(shape[1:], dtype=float) > 3:
        raise SceneError(f"particle table {path}: {name} has the shape {shape}, not that of at most {most} particles")
    if dataset.is_virtual or dataset.external:
        raise SceneError(f"particle table {path}: {name} is kept in another file, which is not read")
    return np.asarray(dataset[:] if field is None else dataset.fields(field)[:], dtype=float)
