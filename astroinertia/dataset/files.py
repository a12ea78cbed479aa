"""netCDF files of the package as xarray reads them, from anywhere: bounded, checked, with an error where damaged.

Tests: tests/unit/dataset/test_dataset.py, tests/crash/test_flipped_bits.py, tests/hard/test_malformed_files.py.
"""

import math
import stat
from collections.abc import Mapping
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from astroinertia.dataset.schema import FORMAT
from astroinertia.errors import ArchiveError
from astroinertia.observables.quantities import RENAMED
from astroinertia.storage import hdf5_structure, trailer
from astroinertia.storage.archive import way_to_rewrite
from astroinertia.storage.atomic import archive_errors
from astroinertia.storage.bounded import check_proportion


def headline(path: Path) -> xr.Dataset:
    """The headline series of a file, in memory; ArchiveError where it is damaged, or not of this package."""
    _look(path)
    with archive_errors(path):
        _check_sizes(path, None)
        dataset = xr.load_dataset(path, engine="netcdf4")
    version = dataset.attrs.get("astroinertia_format")
    if version is None:
        raise ArchiveError(f"{path} is a netCDF file, but not one of this package.")
    with archive_errors(path, "does not say which format it has"):
        version = int(version)
    if version > FORMAT:
        raise ArchiveError(f"{path} has format {version} of a newer version; this one reads up to {FORMAT}.")
    with archive_errors(path):
        dataset = dataset.assign(
            {now: dataset[before] for before, now in RENAMED.items() if before in dataset and now not in dataset}
        )
        labels = [name for name, coord in dataset.coords.items() if coord.dtype.kind == "O"]
        dataset = dataset.assign_coords({name: dataset[name].astype(str) for name in labels})
    return dataset


def numbers(path: Path, name: str) -> xr.DataArray:
    """One series of numbers of a file, along its times; ArchiveError as `headline`, and for a file without it."""
    _look(path)
    # no labels are read: netCDF crashes as `snapshots` says
    with archive_errors(path), netCDF4.Dataset(path) as file:
        series, times = file[name], file["time"]
        check_proportion(name, series.dtype.itemsize * math.prod(map(float, series.shape)), path)
        return xr.DataArray(np.asarray(series[:]), {"time": np.asarray(times[:])}, series.dimensions)


def snapshots(path: Path, chunks: Mapping[str, int] | None) -> xr.Dataset | None:
    """The particles of a file, lazily, without the label "i"; None where there are none. ArchiveError as `headline`."""
    _look(path)
    # netCDF (4.10) crashes when a file that is open elsewhere in the process is opened once more after a variable of
    # strings was read from it and it was closed. Files have had their labels as characters since; of older ones those
    # of the snapshots are not read, and none is opened just to see what is in it.
    with archive_errors(path):
        if not _check_sizes(path, "snapshots"):
            return None
        return xr.open_dataset(path, group="snapshots", engine="netcdf4", drop_variables="i", chunks=chunks)


def loaded(path: Path, opened: xr.Dataset) -> xr.Dataset:
    """What was opened lazily from a file, in memory; ArchiveError where the file is damaged there."""
    with archive_errors(path, "is damaged"):
        check_proportion("it", sum(_size(variable) for variable in opened.variables.values()), path)
        return opened.load()


def _size(variable: xr.Variable) -> float:
    """Bytes of a variable in memory, with the chunk that it is unpacked by, which may be larger."""
    return variable.nbytes + variable.dtype.itemsize * math.prod(map(float, variable.encoding.get("chunksizes") or ()))


def _check_sizes(path: Path, group: str | None) -> bool:
    """Whether there is that group; ValueError where what xarray reads when it opens it is out of proportion."""
    with netCDF4.Dataset(path) as file:
        if group is None:
            read = list(file.variables.values())
        elif group not in file.groups:
            return False
        else:  # of other groups only what labels dimensions
            read = [labels for name, labels in file.groups[group].variables.items() if name in labels.dimensions]
        whole, largest = 0.0, 0.0
        for variable in read:
            item = getattr(variable.dtype, "itemsize", None) or 1
            whole += item * math.prod(map(float, variable.shape))
            chunks = variable.chunking()
            largest = max(largest, item * math.prod(map(float, () if isinstance(chunks, str) else chunks)))
        check_proportion("it", whole + largest, path)
    return True


def _look(path: Path) -> None:
    """ArchiveError for what is not worth opening, with the way to a whole file where there is one."""
    try:
        _must_be_whole(path)
    except ArchiveError as error:
        raise ArchiveError(f"{error}{way_to_rewrite(path)}") from error


def _must_be_whole(path: Path) -> None:
    """ArchiveError for no file, no HDF5, or not what was written."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # a pipe would be waited for
            raise ArchiveError(f"{path} is not a file.")
        if not hdf5_structure.is_hdf5(path):
            raise ArchiveError(f"{path} cannot be read as netCDF: it does not begin as a netCDF-4 file does.")
        trailer.check(path)
        hdf5_structure.check(path)
    except OSError as error:
        raise ArchiveError(f"{path} cannot be read: {error.strerror or error}.") from error
    except ValueError as error:
        raise ArchiveError(f"{path} cannot be read as netCDF: {error}.") from error
