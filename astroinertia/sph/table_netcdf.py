"""Particle tables in netCDF: the last snapshot of a run, or columns as variables, from files of anybody's.

Vectors have their components in the order that labels of a dimension say, which is then the last; units are attributes.
Files of netCDF-4 are HDF5, and are looked at before netCDF opens them. Those of the classic format are read by scipy,
in Python: netCDF's own reader believes what their headers say, and damaged ones have crashed it.
Tests: tests/unit/sph/test_table_netcdf.py, tests/unit/sph/test_initial_particles.py,
tests/hard/test_malformed_files.py.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import AstroinertiaError, SceneError
from astroinertia.storage import hdf5_structure, trailer
from astroinertia.storage.bounded import check_proportion, plain_text
from astroinertia.storage.table_hdf5 import VECTORS, stated_unit
from astroinertia.units import shown

_CLASSIC, _CDF5 = (b"CDF\x01", b"CDF\x02"), b"CDF\x05"
_LONGEST_LABELS = 300  # characters of the labels of three components
_OF_A_SNAPSHOT = {"mass": "mass", "position": "position", "velocity": "velocity", "u": "internal_energy"}

_Read = tuple[dict[str, np.ndarray], dict[str, str]]


def netcdf_columns(
    path: Path, names: tuple[str, ...], most: int, named: Callable[[str], str], group: str = "/"
) -> _Read:
    """Columns by name, of which `names` are wanted, as float64, (N,) or those of vectors (N, 3), and units of them.

    N is at most `most`. named: a column's own name. group: that of the columns, / of none. SceneError that says
    what is wrong with the file.
    """
    what = f"particle table {path}"
    try:
        if hdf5_structure.is_hdf5(path):
            hdf5_structure.check(path)
            trailer.check(path)
            return _netcdf4(path, names, most, named, group)
        return _classic(path, names, most, named)
    except AstroinertiaError:
        raise
    except Exception as error:  # netCDF and scipy pass on what they find as errors of many kinds
        reason = plain_text(error)
        raise SceneError(f"{what} is not the result of a run, nor a netCDF file of columns ({reason})") from error


def _netcdf4(path: Path, names: tuple[str, ...], most: int, named: Callable[[str], str], group: str) -> _Read:
    import netCDF4  # only here: most runs read no file

    with netCDF4.Dataset(path) as file:
        snapshots = file.groups.get("snapshots")
        if snapshots is not None:
            if len(snapshots.dimensions["particle"]) > most:
                raise SceneError(f"particle table {path} has more than {most} particles")
            chosen = {name: snapshots[own] for name, own in _OF_A_SNAPSHOT.items()}
            count = snapshots["mass"].shape[0]
            _check(path, chosen, most * count, 1 / count)
            labels = _labels(path, snapshots.variables, chosen)
            last = {name: variable[-1] for name, variable in chosen.items()}
            if gone := int(np.isnan(np.ma.filled(last["mass"], 0.0)).sum()):
                lost = f"{gone} of its {last['mass'].size} particles are in sinks, which a table has not"
                raise SceneError(f"particle table {path} is of a run that ended as no whole body: {lost}")
            return _read(path, chosen, last, labels)
        variables = file.groups.get(group, file).variables
        chosen = _chosen(path, variables, names, named)
        _check(path, chosen, most)
        labels = _labels(path, {**file.variables, **variables}, chosen)
        return _read(path, chosen, {name: variable[:] for name, variable in chosen.items()}, labels)


def _classic(path: Path, names: tuple[str, ...], most: int, named: Callable[[str], str]) -> _Read:
    from scipy.io import netcdf_file

    with path.open("rb") as file:
        begins = file.read(4)
        if begins == _CDF5:
            raise ValueError("it has netCDF's format CDF-5, which is not read; `nccopy -k nc4` makes netCDF-4 of it")
        if begins not in _CLASSIC:
            raise ValueError("it cannot be read as netCDF: it begins neither as netCDF-4 nor as classic files do")
    with netcdf_file(path, mmap=False) as file:
        chosen = _chosen(path, file.variables, names, named)
        if any(len(variable.shape) > 2 or max(variable.shape, default=0) > most for variable in chosen.values()):
            raise SceneError(f"particle table {path} has more than {most} particles")
        labels = _labels(path, file.variables, chosen)
        return _read(path, chosen, {name: _written(variable) for name, variable in chosen.items()}, labels)


def _written(variable: Any) -> np.ma.MaskedArray:
    """A variable unpacked, and without what was never written or is not valid, as netCDF's own library has it.

    scipy unpacks, too, but knows neither numbers without a sign, nor valid ranges, nor what is written by default.
    """
    stored = np.array(variable[:])
    unsigned = getattr(variable, "_Unsigned", b"").lower() == b"true"
    raw = stored.view(stored.dtype.str.replace("i", "u")) if unsigned else stored

    def stated(name: str) -> np.ndarray:
        values = np.ravel(getattr(variable, name, ()))
        return values.astype(stored.dtype).view(raw.dtype) if values.dtype.kind in "fiu" else raw[:0]

    hidden = np.isin(raw, [*stated("_FillValue"), *stated("missing_value")])
    if stored.itemsize > 1 and not hasattr(variable, "_FillValue"):
        hidden |= stored == fill_value(stored.dtype)
    bounds = stated("valid_range")
    for lowest in (*stated("valid_min"), *bounds[:1]):
        hidden |= raw < lowest
    for highest in (*stated("valid_max"), *bounds[1:]):
        hidden |= raw > highest
    scale, offset = (float(getattr(variable, *of)) for of in (("scale_factor", 1.0), ("add_offset", 0.0)))
    return np.ma.masked_where(hidden, raw.astype(float) * scale + offset)


def fill_value(dtype: np.dtype) -> Any:
    """What netCDF writes where nothing is given, for numbers of a type."""
    import netCDF4  # only here: most runs read no file

    return netCDF4.default_fillvals[dtype.str[1:]]


def _chosen(path: Path, variables: Any, names: tuple[str, ...], named: Callable[[str], str]) -> dict[str, Any]:
    own: dict[str, Any] = {}
    for name, variable in variables.items():
        if named(name) in own and named(name) in names:
            raise SceneError(f"particle table {path} has columns more than once, namely {named(name)}")
        own[named(name)] = variable
    grids = [name for name, variable in own.items() if len(variable.shape) == 3 and min(variable.shape) > 3]
    if grids and ("mass" not in own or "mass" in grids):
        cells = " x ".join(map(str, own[grids[0]].shape))
        raise SceneError(
            f"particle table {path} has {shown(grids[0])} on a grid of {cells} cells; give each cell as a particle, "
            "with its mass (density times volume) and its middle x, y, z"
        )
    return {name: own[name] for name in (*names, *VECTORS) if name in own}


def _check(path: Path, chosen: dict[str, Any], most: int, share: float = 1.0) -> None:
    """Refuse variables that are not of numbers, have too many rows, or are out of proportion to the file.

    share: of each, that is read.
    """
    whole = 0.0
    for name, variable in chosen.items():
        if np.dtype(variable.dtype).kind not in "fiu":
            raise ValueError(f"{name} is not of numbers")
        size = np.prod(variable.shape, dtype=float)
        if size > 3.0 * most:
            raise SceneError(f"particle table {path} has more than {most} particles")
        chunks = variable.chunking()
        whole += 8.0 * size * share
        whole += 0.0 if isinstance(chunks, str) else variable.dtype.itemsize * np.prod(chunks, dtype=float)
    check_proportion("it", whole, path)


def _read(path: Path, chosen: dict[str, Any], values: dict[str, Any], labels: dict[str, list[str]]) -> _Read:
    columns = {}
    for name, column in values.items():
        dims = chosen[name].dimensions[-column.ndim :]  # without that of the snapshots
        columns[name] = _in_order(path, name, _plain(column), [labels.get(dim) for dim in dims])
    units = {name: stated_unit(getattr(variable, "units", "")) for name, variable in chosen.items()}
    return columns, {name: unit for name, unit in units.items() if unit}


def _labels(path: Path, variables: Any, chosen: dict[str, Any]) -> dict[str, list[str]]:
    """Labels of dimensions of vectors that have three, where they are text or do not just count upwards."""
    found = {}
    for dim in {dim for name in VECTORS if name in chosen for dim in chosen[name].dimensions}:
        variable = variables.get(dim)
        if variable is None or variable.shape[:1] != (3,) or np.prod(variable.shape) > _LONGEST_LABELS:
            continue
        chunks = getattr(variable, "chunking", str)()  # netCDF's own may be larger than the variable
        if not isinstance(chunks, str):
            check_proportion("it", 16 * np.prod(chunks, dtype=float), path)
        values = np.ma.getdata(variable[:])
        if values.dtype.kind in "fiu" and values.ndim == 1 and (np.diff(values) > 0).all():
            continue
        rows = [np.ravel(row).tolist() for row in values]
        found[dim] = ["".join(part.decode() if isinstance(part, bytes) else str(part) for part in row) for row in rows]
    return found


def _in_order(path: Path, name: str, column: np.ndarray, labels: list[list[str] | None]) -> np.ndarray:
    """A vector with x, y, z last and in this order, where labels say which is which; SceneError for other labels."""
    if name not in VECTORS:
        return column
    for axis, own in enumerate(labels):
        letters = [label.strip("\0 ").lower().removeprefix("v") for label in own or ()]
        if sorted(letters) == ["x", "y", "z"]:
            return np.moveaxis(column, axis, -1)[..., np.argsort(letters)]
    if labels and labels[-1] is not None:
        said = shown(", ".join(labels[-1]))
        raise SceneError(f"particle table {path}: the components of {name} are {said}, and not x, y, z")
    return column


def _plain(values: Any) -> np.ndarray:
    array = np.ma.filled(np.ma.asarray(values).astype(float), np.nan)
    if array.dtype.kind != "f":
        raise ValueError("a column is not of numbers")
    return array
