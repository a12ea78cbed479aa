"""A dataset as the accessor reads it, however xarray has cut it: times along a dimension, components from x to z.

Tests: tests/unit/dataset/test_accessor.py.
"""

from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.errors import AbsentError
from astroinertia.observables.quantities import DERIVED, RECORDED
from astroinertia.units import astropy_quantity, shown, unit_of


def require_tensor(opened: xr.Dataset | xr.DataTree) -> None:
    """ValueError for what is no record of a run, which says where that is."""
    if "inertia_tensor" in opened:
        return
    members = [name for name in getattr(opened, "children", ()) if name.startswith("member-")]
    more = f"; each run of a sweep has its own, such as tree[{members[0]!r}].inertia" if members else ""
    more = "; these are particles: ask that of their run" if "snapshot_time" in opened.coords else more
    raise ValueError(f"this dataset has no inertia_tensor; the accessor is for datasets of astroinertia{more}")


def along(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset of which one time, one effect or one mode was chosen, with that as the only one."""
    if "time" not in dataset.coords:
        raise ValueError(f"the dataset has no times: {_way_to_times(dataset['inertia_tensor'])}")
    if dataset["time"].dims not in ((), ("time",)):
        dim = dataset["time"].dims[0]
        stacked = getattr(dataset.indexes.get(dim), "nlevels", 1) > 1
        way = f"unstack({dim!r})" if stacked else f"swap_dims({dim}='time')"
        raise ValueError(f"the times are along {dim}; the accessor takes records along time: ds.{way} has them so")
    for dim in ("i", "j"):
        if dim in dataset.coords and dim not in dataset.dims:
            raise ValueError(f"vectors and tensors must be whole: along {dim} there is {dataset[dim].values} alone")
        if dim not in dataset["inertia_tensor"].dims:
            raise ValueError(f"inertia_tensor has no dimension {dim}: components are along i and j")
    schema = RECORDED | DERIVED
    others = {dim for quantity in schema.values() for dim in quantity.dims} - {"time", "i", "j"}
    if spread := sorted(others & {str(dim) for dim in dataset["inertia_tensor"].dims}):
        raise ValueError(
            f"inertia_tensor is along {spread[0]}, too, as a mask along it leaves it: "
            f"mask what is along {spread[0]} alone, such as ds.work.where(...)"
        )
    # A mask of times, as of Dataset.where, gives what is of the whole run, such as spectra, times as well.
    spread = [
        str(name)
        for name, values in dataset.data_vars.items()
        if name in schema and "time" in values.dims and "time" not in schema[str(name)].dims
    ]
    dataset = dataset.assign({name: dataset[name].max("time", keep_attrs=True) for name in spread})
    for dim in ("time", "effect", "mode"):
        if dim in dataset.coords and dim not in dataset.dims:
            names = [name for name in dataset.data_vars if name not in schema or dim in schema[str(name)].dims]
            chosen = {name: dataset[name].expand_dims(dim) for name in names if dim == "time" or name in schema}
            dataset = dataset.drop_vars(dim).assign(chosen)
    return dataset


def _way_to_times(tensor: xr.DataArray) -> str:
    """How records along another dimension, as groups or under another name, are records along time again."""
    others = [str(dim) for dim in tensor.dims if dim not in ("i", "j")]
    if len(others) != 1:
        return "the accessor is for records of a run, not for what is made of them"
    (dim,) = others
    if dim == "time":
        return "those of its records have been lost, and ds.assign_coords(time=...) has them again"
    binned = hasattr(tensor.indexes.get(dim), "mid")  # as an index of intervals has
    bins = f".assign_coords({dim}=[bin.mid for bin in ds[{dim!r}].values])" if binned else ""
    return f"its records are along {dim}; where that is a time in seconds, ds{bins}.rename({dim}='time') has them"


def in_seconds(series: Any) -> Any:
    """A dataset or a series whose times are timedelta64, as resampling needs them, with seconds.

    ValueError for times in another unit.
    """
    if "time" not in series.coords:
        return series
    times = series["time"]
    if times.dtype.kind == "M":
        raise ValueError("the times are dates; the accessor takes seconds or timedelta64")
    if times.dtype.kind == "m":
        seconds = times.copy(data=times.values / np.timedelta64(1, "s"))
        return series.assign_coords(time=seconds.assign_attrs({**times.attrs, "units": "s"}))
    if _is_unit_but_of_seconds(stated := unit_of(times)):
        raise ValueError(f"the times are in {shown(stated)}; the accessor takes seconds or timedelta64")
    return series


def _is_unit_but_of_seconds(stated: str) -> bool:
    if stated in ("1", "s", "seconds"):
        return False
    with suppress(ValueError, TypeError):
        return bool(astropy_quantity(1.0, stated) != astropy_quantity(1.0, "s"))
    return False  # no unit at all


def with_labels(series: xr.DataArray, dim: str, labels: xr.DataArray) -> xr.DataArray:
    """A series with these labels along a dimension, in their order, in whatever order it has them and more.

    One without this dimension, or without labels along it, stays as it is. ValueError where it lacks a label.
    """
    if dim not in series.dims or dim not in series.coords:
        return series
    own, wanted = series[dim].values.tolist(), labels.values.tolist()
    if own == wanted:
        return series
    places = {label: place for place, label in enumerate(own)}
    for label in wanted:
        if label not in places:
            raise ValueError(f"what is given along {dim} has no value at {label}, which the dataset has")
    return series.isel({dim: [places[label] for label in wanted]})


def gravitational_constant(dataset: xr.Dataset) -> float:
    """That of a dataset's units; AbsentError where xarray has left out the attributes."""
    if "gravitational_constant" not in dataset.attrs:
        raise AbsentError(
            "this dataset has lost its attribute gravitational_constant: keep attributes, as "
            "xarray.set_options(keep_attrs=True) does."
        )
    return float(dataset.attrs["gravitational_constant"])


def require_own_units(dataset: xr.Dataset) -> None:
    """ValueError for a variable that is in another unit than the accessor writes, as after a conversion."""
    for name, quantity in (RECORDED | DERIVED).items():
        if name not in dataset.variables:
            continue
        stated, own = unit_of(dataset[name]), quantity.unit
        if stated not in ("1", own) and astropy_quantity(1.0, stated) != astropy_quantity(1.0, own):
            raise ValueError(
                f"{name} is in {shown(stated)}; the accessor takes datasets in their own units, here {own}"
            )


def require_room(dataset: xr.Dataset) -> None:
    """ValueError where numbers became infinite as they were made single precision: what follows would be NaN."""
    for name in RECORDED | DERIVED:
        if name not in dataset.variables or dataset[name].dtype.kind != "f" or dataset[name].dtype.itemsize >= 8:
            continue
        if bool(np.isinf(dataset[name]).any()):
            raise ValueError(
                f"{name} is infinite in {dataset[name].dtype}, which ends at {np.finfo(dataset[name].dtype).max:.2g}: "
                "keep float64"
            )


def from_x_to_z(series: Any) -> Any:
    """A dataset or a series with its components from x to z, whose order xarray lets anyone change."""
    for dim in {"i", "j"} & set(series.dims) & set(series.coords):
        labels = series[dim].values.tolist()
        if sorted(labels) != ["x", "y", "z"]:
            raise ValueError(f"vectors and tensors must be whole: along {dim} there is {', '.join(map(str, labels))}")
        series = series if labels == ["x", "y", "z"] else series.sel({dim: ["x", "y", "z"]})
    return series
