"""Particle tables in netCDF: the last snapshot of a run, or columns as variables, from files of anybody's.

Files of netCDF-4 are HDF5, and are looked at before netCDF opens them. Those of the classic format are read by scipy,
in Python: netCDF's own reader believes what their headers say, and damaged ones have crashed it.
Tests: tests/unit/sph/test_initial_particles.py, tests/hard/test_malformed_files.py.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import AstroinertiaError, SceneError
from astroinertia.storage import hdf5_structure, trailer
from astroinertia.storage.bounded import check_proportion, plain_text
from astroinertia.storage.table_hdf5 import VECTORS

_CLASSIC = (b"CDF\x01", b"CDF\x02")
_OF_A_SNAPSHOT = {"mass": "mass", "position": "position", "velocity": "velocity", "u": "internal_energy"}


def netcdf_columns(path: Path, names: tuple[str, ...], most: int, named: Callable[[str], str]) -> dict[str, np.ndarray]:
    """Columns by name, of which `names` are wanted, as float64, (N,) or those of vectors (N, 3); N at most `most`.

    named: a column's own name. SceneError that says what is wrong with the file.
    """
    what = f"particle table {path}"
    try:
        if hdf5_structure.is_hdf5(path):
            hdf5_structure.check(path)
            trailer.check(path)
            return _netcdf4(path, names, most, named)
        return _classic(path, names, most, named)
    except AstroinertiaError:
        raise
    except Exception as error:  # netCDF and scipy pass on what they find as errors of many kinds
        reason = plain_text(error)
        raise SceneError(f"{what} is not the result of a run, nor a netCDF file of columns ({reason})") from error


def _netcdf4(path: Path, names: tuple[str, ...], most: int, named: Callable[[str], str]) -> dict[str, np.ndarray]:
    import netCDF4  # only here: most runs read no file

    with netCDF4.Dataset(path) as file:
        snapshots = file.groups.get("snapshots")
        if snapshots is not None:
            if len(snapshots.dimensions["particle"]) > most:
                raise SceneError(f"particle table {path} has more than {most} particles")
            chosen = {name: snapshots[own] for name, own in _OF_A_SNAPSHOT.items()}
            count = snapshots["mass"].shape[0]
            _check(path, chosen, most * count, 1 / count)
            return {name: _plain(variable[-1]) for name, variable in chosen.items()}
        chosen = _chosen(file.variables, names, named)
        _check(path, chosen, most)
        return {name: _plain(variable[:]) for name, variable in chosen.items()}


def _classic(path: Path, names: tuple[str, ...], most: int, named: Callable[[str], str]) -> dict[str, np.ndarray]:
    from scipy.io import netcdf_file

    with path.open("rb") as file:
        if file.read(4) not in _CLASSIC:
            raise ValueError("it cannot be read as netCDF: it begins neither as netCDF-4 nor as classic files do")
    with netcdf_file(path, mmap=False, maskandscale=True) as file:
        chosen = _chosen(file.variables, names, named)
        if any(len(variable.shape) > 2 or max(variable.shape, default=0) > most for variable in chosen.values()):
            raise SceneError(f"particle table {path} has more than {most} particles")
        return {name: _plain(_written(variable)) for name, variable in chosen.items()}


def _written(variable: Any) -> np.ma.MaskedArray:
    """A variable without what was never written: scipy knows only of fill values that the file tells."""
    values = np.ma.asarray(variable[:])
    if variable.data.itemsize == 1 or hasattr(variable, "_FillValue") or hasattr(variable, "missing_value"):
        return values
    return np.ma.masked_where(np.ma.getdata(values) == fill_value(variable.data.dtype), values)


def fill_value(dtype: np.dtype) -> Any:
    """What netCDF writes where nothing is given, for numbers of a type."""
    import netCDF4  # only here: most runs read no file

    return netCDF4.default_fillvals[dtype.str[1:]]


def _chosen(variables: Any, names: tuple[str, ...], named: Callable[[str], str]) -> dict[str, Any]:
    own = {named(name): variable for name, variable in variables.items()}
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


def _plain(values: Any) -> np.ndarray:
    array = np.ma.filled(np.ma.asarray(values).astype(float), np.nan)
    if array.dtype.kind != "f":
        raise ValueError("a column is not of numbers")
    return array
