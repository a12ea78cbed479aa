"""Columns of an HDF5 file, which may come from anywhere: read as plain numbers, bounded, and only from itself.

The columns, such as mass, x, y, z of particles, stand at the root, or in the one group that holds them, as datasets of
those names, or with position and velocity of shape (N, 3) instead; or as the fields of one structured dataset, as
astropy and PyTables write them. Units of a column are its attribute `units`, or what astropy keeps beside a structured
dataset. Other datasets are passed over. Links to other files are not followed.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.storage.bounded import check_proportion, plain_text

SUFFIXES = (".h5", ".hdf5")
VECTORS = {"position": ("x", "y", "z"), "velocity": ("vx", "vy", "vz")}
_SAID = re.compile(r"(?:^-? *|[{,] *)(name|unit): *['\"]?([^,}'\"]{1,40})")
_OF_ASTROPY = ".__table_column_meta__"  # the dataset of such lines beside a structured one
_MASK = ".mask"  # what astropy adds to the name of a field for that which says of what rows it is masked
# What netCDF says of numbers, also in files of its older versions, which have no _NCProperties.
_OF_NETCDF = {"_FillValue", "_Unsigned", "add_offset", "missing_value", "scale_factor"}
_OF_NETCDF |= {"valid_max", "valid_min", "valid_range"}
_MOST_MEMBERS = 1000  # names that are looked at in a group
_MOST_BYTES = 2**20  # of what says units
Member = tuple[Any, str | None]
"""A dataset of h5py, and its field where it is structured."""


def hdf5_columns(
    path: Path, names: tuple[str, ...], most: int, what: str
) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Columns (N,) of a file by name, as float64, of which `names` are wanted, and the units that it states of them.

    N is at most `most`. what: how messages call the file.

    SceneError that says what is wrong with the file, or that h5py is not installed.
    """
    wanted, name = (*names, *VECTORS), f"{what} {path}"
    with opened(path, name) as (h5py, file):
        columns = members(h5py, name, file, wanted)
        for group in () if columns else group_names(h5py, name, file):
            inside = members(h5py, name, file[group], wanted)
            if inside and columns:
                raise SceneError(f"{name} has columns in more than one group")
            columns = columns or inside
        for column, (dataset, _) in columns.items():
            if {"scale_factor", "add_offset"}.intersection(dataset.attrs):
                raise SceneError(f"{name}: {column} is packed (scale_factor, add_offset), not plain numbers")
        return split_vectors(name, numbers(path, name, columns, most)), split_units(_units(h5py, name, columns))


def netcdf_group(path: Path, names: tuple[str, ...], what: str) -> str | None:
    """The place of the columns in a file that was written as netCDF, which states packed numbers and labels there.

    None for any other file, and where columns are in several groups.
    """
    name, wanted = f"{what} {path}", (*names, *VECTORS)
    with opened(path, name) as (h5py, file):
        holders = {place: found for place in ("/", *group_names(h5py, name, file))
                   if (found := members(h5py, name, file[place], wanted))}  # fmt: skip
        place = "/" if "/" in holders or len(holders) != 1 else next(iter(holders))
        columns = holders.get(place, {})
        said = (_OF_NETCDF.intersection(dataset.attrs) for dataset, field in columns.values() if field is None)
        return place if columns and ("_NCProperties" in file.attrs or any(said)) else None


def h5py_for(path: Path) -> Any:
    """The library h5py; SceneError, naming a file that needs it, where it is not installed."""
    try:
        import h5py  # pyright: ignore[reportMissingImports]  an extra: only these files need it
    except ImportError:
        raise SceneError(f"{path}: HDF5 files need h5py; install it with: pip install 'astroinertia[hdf5]'") from None
    return h5py


@contextmanager
def opened(path: Path, name: str) -> Iterator[tuple[Any, Any]]:
    """h5py and the file, open for reading; whatever HDF5 finds wrong with it meanwhile becomes a SceneError."""
    h5py = h5py_for(path)
    try:
        with h5py.File(path, "r") as file:
            yield h5py, file
    except SceneError:
        raise
    except Exception as error:  # h5py passes on what HDF5 finds as errors of many kinds
        raise SceneError(f"{name} is not an HDF5 file that can be read ({plain_text(error)})") from error


def split_vectors(file: str, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns with position and velocity (N, 3), where there are such, as three columns each."""
    split = {}
    for name, column in columns.items():
        if name not in VECTORS:
            split[name] = column[:, 0] if column.ndim == 2 and column.shape[1] == 1 else column
        elif column.ndim != 2 or column.shape[1] != 3:
            raise SceneError(f"{file}: {name} is not three numbers a particle")
        elif twice := [part for part in VECTORS[name] if part in columns]:
            raise SceneError(f"{file} has columns more than once, namely {name} and {', '.join(twice)}")
        else:
            split |= dict(zip(VECTORS[name], column.T, strict=True))
    return split


def split_units(units: Mapping[str, str]) -> dict[str, str]:
    """The units by column, those of position and velocity as three columns' each."""
    return {part: unit for name, unit in units.items() for part in VECTORS.get(name, (name,))}


def stated_unit(attribute: Any) -> str:
    """The text of an attribute `units`; empty for a number without a unit, and where there is none."""
    value = attribute.item() if isinstance(attribute, np.ndarray | np.generic) and attribute.size == 1 else attribute
    text = (value.decode(errors="replace") if isinstance(value, bytes) else str(value)).strip()
    return "" if text == "1" else text


def _units(h5py: Any, file_name: str, columns: Mapping[str, Member]) -> dict[str, str]:
    """What is stated of the units of columns, by name."""
    units = {}
    for name, (dataset, field) in columns.items():
        if field is None and "units" in dataset.attrs:
            if dataset.attrs.get_id("units").get_storage_size() > _MOST_BYTES:
                raise SceneError(f"{file_name}: the units of {name} are no text")
            units[name] = stated_unit(dataset.attrs["units"])
        elif field is not None:
            units[name] = _of_astropy(h5py, dataset).get(field, "")
    return {name: unit for name, unit in units.items() if unit}


def _of_astropy(h5py: Any, table: Any) -> dict[str, str]:
    """The units by field of a table that astropy has written with them."""
    beside = table.name.rpartition("/")[2] + _OF_ASTROPY
    if not _is_own(h5py, table.parent, beside):
        return {}
    lines = table.parent[beside]
    if not isinstance(lines, h5py.Dataset) or lines.dtype.kind != "S" or lines.is_virtual or lines.external:
        return {}
    if lines.dtype.itemsize * max(lines.size, np.prod(lines.chunks or (), dtype=float)) > _MOST_BYTES:
        return {}
    return units_in_head(line.decode(errors="replace") for line in np.ravel(lines[()]))


def units_in_head(lines: Iterable[str]) -> dict[str, str]:
    """Units by column that the YAML says which astropy keeps beside a table, or ECSV has in its comments.

    A column has one line, as astropy writes it, or a line for each thing that is said of it, as other programs do.
    """
    units: dict[str, str] = {}
    own: dict[str, str] = {}
    inside = False
    for line in lines:
        text = line.removeprefix("#").removeprefix(" ").rstrip()
        if re.match(r"\w+:", text):
            inside = text == "datatype:"
        elif inside:
            own = {} if text.startswith("-") else own
            for key, value in _SAID.findall(text.strip()):
                own.setdefault(key, value.strip())
            if len(own) == 2:
                units[own["name"]] = own["unit"]
    return units


def members(h5py: Any, file_name: str, group: Any, wanted: tuple[str, ...]) -> dict[str, Member]:
    """The wanted columns in a group: the dataset of each, and its field in that where it is structured."""
    own = {name: group[name] for name in _names(file_name, group) if _is_own(h5py, group, name)}
    datasets = {name: member for name, member in own.items() if isinstance(member, h5py.Dataset)}
    columns: dict[str, Member] = {name: (datasets[name], None) for name in wanted if name in datasets}
    tables = [member for member in datasets.values() if member.dtype.names]
    if columns or len(tables) != 1:
        return columns
    return {name: (tables[0], name) for name in wanted if name in tables[0].dtype.names}


def group_names(h5py: Any, file_name: str, file: Any) -> list[str]:
    """The groups of a file that are its own."""
    return [
        name
        for name in _names(file_name, file)
        if _is_own(h5py, file, name) and file.get(name, getclass=True) is h5py.Group and file[name] != file
    ]


def _names(file_name: str, group: Any) -> list[str]:
    if len(group) > _MOST_MEMBERS:
        raise SceneError(f"{file_name} has more than {_MOST_MEMBERS} members in a group")
    return list(group)


def _is_own(h5py: Any, group: Any, name: str) -> bool:
    """Whether a name stands for something in this file and not for a path, here or in another file."""
    return isinstance(group.get(name, getlink=True), h5py.HardLink)


def numbers(path: Path, file_name: str, columns: Mapping[str, Member], most: int) -> dict[str, np.ndarray]:
    """Columns as float64, (N,) or (N, 3), all of which are looked at before one is read.

    SceneError for what is not of numbers, too large or in another file, ValueError where the columns, or the chunks
    that they are unpacked by, are out of proportion to the file: a chunk may say that it is larger than its dataset.
    """
    whole, chunk = 0.0, 0.0
    for name, (dataset, field) in columns.items():
        kind = dataset.dtype if field is None else dataset.dtype[field]
        shape = (*(dataset.shape or ()), *kind.shape)
        if kind.base.kind not in "fiu":
            raise SceneError(f"{file_name}: {name} is not of numbers")
        if not shape or shape[0] > most or np.prod(shape[1:], dtype=float) > 3:
            few = f"{most} rows, each of one number or of three"
            raise SceneError(f"{file_name}: {name} has the shape {shape}, and is to have at most {few}")
        if dataset.is_virtual or dataset.external:
            raise SceneError(f"{file_name}: {name} is kept in another file, which is not read")
        whole += 8.0 * np.prod(shape, dtype=float)
        chunk = max(chunk, dataset.dtype.itemsize * np.prod(dataset.chunks or (), dtype=float))
        if field is not None and f"{field}{_MASK}" in dataset.dtype.names:
            whole += dataset.dtype.itemsize * np.prod(dataset.shape, dtype=float)
    check_proportion("it", whole + chunk, path)
    for name, (dataset, field) in columns.items():
        if field is not None and f"{field}{_MASK}" in dataset.dtype.names:
            masked = np.asarray(dataset.fields(f"{field}{_MASK}")[:])
            if masked.dtype.kind in "biu" and masked.any():
                raise SceneError(f"{file_name}: {name} of row {int(np.argwhere(masked)[0, 0]) + 1} is masked")
    return {
        name: np.asarray(dataset[:] if field is None else dataset.fields(field)[:], dtype=float)
        for name, (dataset, field) in columns.items()
    }
