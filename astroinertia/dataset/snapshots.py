"""The snapshots of a run: how the particles of a run folder are opened without reading them, and written to netCDF.

Tests: tests/unit/dataset/test_dataset.py, tests/scale/test_opening.py.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from astroinertia.dataset.schema import SNAPSHOT, SNAPSHOT_TIME, attributes, code_units, converted, label
from astroinertia.errors import ArchiveError
from astroinertia.observables.quantities import LABELS, Quantity
from astroinertia.storage.archive import Archive
from astroinertia.storage.outputs import SNAPSHOT as STORED, Snapshots
from astroinertia.units import CodeUnits


def snapshot_quantity(name: str, shape: tuple[int, ...]) -> Quantity:
    """The schema's entry for a per-particle array, or one that says that the schema does not know it."""
    if name == "time":
        return SNAPSHOT_TIME
    quantity = SNAPSHOT.get(name)
    if quantity is not None and len(quantity.dims) == len(shape) + 1:
        return quantity
    dims = ("snapshot_time", "particle", *(f"{name}_{axis}" for axis in range(len(shape) - 1)))
    return Quantity(dims[: len(shape) + 1], None, "1", name.replace("_", " "), "not in the schema; in code units")


def present(snapshot: xr.Dataset) -> xr.Dataset:
    """One snapshot without the particles that sinks have accreted, which are NaN in it."""
    there = np.isfinite(snapshot["mass"].values)
    return snapshot if there.all() else snapshot.isel(particle=there)


class RunFolder(BackendEntrypoint):
    """Opens the snapshots of a run folder by xarray, which keeps what was read, or gives it to dask."""

    def open_dataset(
        self, filename_or_obj: Any, *, drop_variables: Any = None, files: Sequence[Snapshots], metadata: Mapping
    ) -> xr.Dataset:
        """The dataset of these files; of each snapshot only its time is known until it is read."""
        layout, units = dict(files[0].layout), code_units(metadata)
        if any(file.layout != layout for file in files):
            raise ArchiveError(f"the particles of {filename_or_obj} do not stay the same from snapshot to snapshot.")
        del layout["time"]
        times = np.concatenate([file.times for file in files])
        variables = {}
        for name, (dtype, shape) in layout.items():
            quantity = snapshot_quantity(name, shape)
            data = indexing.LazilyIndexedArray(_Rows(files, name, dtype, (len(times), *shape), quantity, units))
            chunks = dict(zip(quantity.dims, (1, *shape), strict=True))
            variables[name] = xr.Variable(
                quantity.dims, data, attributes(quantity, metadata), {"preferred_chunks": chunks}
            )
        moments = converted(times, SNAPSHOT_TIME, units)
        labels = {"snapshot_time": (SNAPSHOT_TIME.dims, moments, attributes(SNAPSHOT_TIME, metadata)), "i": label("i")}
        return xr.Dataset(variables, labels)


class _Rows(BackendArray):
    """A quantity of all snapshots in SI, (snapshot_time, particle, ...)."""

    def __init__(
        self,
        files: Sequence[Snapshots],
        name: str,
        dtype: np.dtype,
        shape: tuple[int, ...],
        quantity: Quantity,
        units: CodeUnits,
    ) -> None:
        self.places = [(file.rows, number) for file in files for number in range(len(file.times))]
        self.name, self.dtype, self.shape = name, dtype, shape
        self.quantity, self.units = quantity, units

    def __getitem__(self, key: Any) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._taken)

    def _taken(self, key: tuple) -> np.ndarray:
        """What a key takes of each axis: a number, a slice, or numbers."""
        times, *others = key
        if isinstance(times, int | np.integer):
            return self._row(int(times), others)
        numbers = np.arange(len(self.places))[times]
        rows = [self._row(number, others) for number in numbers]
        return np.stack(rows) if rows else _along_axes(np.empty((1, *self.shape[1:]), self.dtype), others)[:0]

    def _row(self, number: int, others: Sequence) -> np.ndarray:
        rows, place = self.places[number]
        values = rows.row(f"{STORED}{self.name}", place)
        if values.shape != self.shape[1:] or values.dtype != self.dtype:
            raise ArchiveError(f"{rows.path} holds '{self.name}' in another shape or type than its manifest says.")
        return converted(_along_axes(values[None], others)[0], self.quantity, self.units)


def _along_axes(values: np.ndarray, keys: Sequence) -> np.ndarray:
    """What the keys take of all axes but the first; the last axis first, since a number takes one away."""
    for axis in range(len(keys), 0, -1):
        values = values[(slice(None),) * axis + (keys[axis - 1],)]
    return values


def append_snapshots(group: Any, count: int, layout: Mapping[str, tuple[int, ...]], archive: Archive) -> None:
    """Write all snapshots of a run to a group of a netCDF file, segment by segment."""
    units, made = code_units(archive.metadata), {}
    first = 0
    for part in archive.read_snapshots():
        for name, array in part.items():
            if array.shape[1:] != layout.get(name):
                raise ArchiveError(f"'{name}' has another shape in a later snapshot; the particles must stay the same.")
            quantity = snapshot_quantity(name, array.shape[1:])
            if name not in made:
                made[name] = _snapshot_variable(group, name, quantity, count, array, archive.metadata)
            made[name][first : first + len(array)] = converted(array, quantity, units)
        first += len(part["time"])
    if "i" in group.dimensions:
        group.createDimension("character", 1)
        labels = group.createVariable("i", "S1", ("i", "character"), fletcher32=True)
        labels.setncatts({"long_name": LABELS["i"][1], "_Encoding": "utf-8"})
        labels.set_auto_chartostring(False)
        labels[:] = np.array(LABELS["i"][0], dtype="S1")[:, None]


def _snapshot_variable(group: Any, name: str, quantity: Quantity, count: int, array: np.ndarray, metadata: Any) -> Any:
    shape = (count, *array.shape[1:])
    for dim, size in zip(quantity.dims, shape, strict=True):
        if dim not in group.dimensions:
            group.createDimension(dim, size)
    if name == "time":
        variable = group.createVariable("snapshot_time", array.dtype, quantity.dims, fletcher32=True)
    else:
        # One chunk a snapshot and the fastest compression: particle arrays hardly compress, and runs should not wait.
        chunks = (1, *shape[1:])
        variable = group.createVariable(
            name, array.dtype, quantity.dims, compression="zlib", complevel=1, chunksizes=chunks, fletcher32=True
        )
    variable.setncatts(attributes(quantity, metadata))
    return variable
