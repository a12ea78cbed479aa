"""What a method of `ds.inertia` says of a run, said of every member of a sweep at once."""

from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.dataset import numbers
from astroinertia.dataset.arranged import with_labels
from astroinertia.errors import AbsentError, SceneError
from astroinertia.process.quantities import InputError
from astroinertia.storage.atomic import own_folder

_OF_A_RUN = {"time", "i", "j"}
_SINGLE = 1e-6  # of the largest: records may have been made single precision


def swept(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dimensions that members of a sweep are along; none of a single run."""
    return tuple(str(dim) for dim in dataset["inertia_tensor"].dims if dim not in _OF_A_RUN)


def reached(dataset: xr.Dataset) -> xr.Dataset:
    """A run up to its own end, without the times that only other members of its sweep reached."""
    recorded = np.flatnonzero(np.isfinite(dataset["mass"].values))
    end = recorded[-1] + 1 if len(recorded) else 0
    return dataset if end in (0, dataset.sizes["time"]) else dataset.isel(time=slice(0, end))


def begun(dataset: xr.Dataset) -> xr.Dataset:
    """A run from its first record with a value: a mean over several, or a mask, leaves the first without.

    SceneError where none has one.
    """
    must_have_times(dataset)
    if "mass" not in dataset:
        return dataset
    if not np.isfinite(mass := dataset["mass"].values).any():
        raise SceneError("nothing is recorded in this dataset: it has no values.")
    return dataset.isel(time=slice(int(np.isfinite(mass).argmax()), None))


def earliest(times: xr.DataArray, values: np.ndarray) -> int:
    """Which of the values, one a record in any order, is the first that is not masked."""
    return int(np.where(np.isfinite(values), times.values, np.inf).argmin())


def source_of(dataset: xr.Dataset) -> Path | None:
    """The file of a run, or the folder of the member that was chosen from a sweep; None where that is not known.

    Of several that were put together, xarray keeps the first file's name: it has to hold the dataset's own records.
    """
    source = dataset.encoding.get("source")
    if source is None or not Path(source).exists() or swept(dataset):
        return None
    path = Path(source)
    if "member" in dataset.coords:
        path = own_folder(path.parent, f"member-{int(dataset['member']):04d}")
    return path if _holds(path, dataset) else None


def _holds(path: Path, dataset: xr.Dataset) -> bool:
    """Whether a file or folder has the records of a dataset, or such between which its are linear.

    Known by the computer's clock, which no two runs have alike; without it, by the trace of the inertia tensor.
    """
    name = "wall_time" if "wall_time" in dataset else "inertia_tensor"

    def one(series: xr.DataArray) -> np.ndarray:
        return series.values if name == "wall_time" else np.trace(series.transpose("time", ...).values, 0, 1, 2)

    recorded = numbers(path, name)
    if not recorded.size or set(recorded.dims) - _OF_A_RUN:  # it holds several runs itself
        return False
    times, own = dataset["time"].values, one(dataset[name])
    found = np.interp(times, recorded["time"].values, one(recorded))
    size = np.fmax.reduce(abs(found), initial=0.0)
    return bool(np.allclose(own, found, rtol=0.0, atol=_SINGLE * size, equal_nan=True))


def must_have_times(dataset: xr.Dataset) -> None:
    """SceneError for a dataset of which no time is left."""
    if not dataset.sizes.get("time", 1):
        raise SceneError("nothing is recorded in this dataset: it has no times.")


def must_be_of_one_run(dataset: xr.Dataset, what: str) -> None:
    """InputError for all members of a sweep together, which names one; AbsentError for a member without records."""
    _must_have_result(dataset)
    if not (dims := swept(dataset)):
        return
    tensor = dataset["inertia_tensor"]
    recorded = tensor.notnull().any([dim for dim in tensor.dims if dim in _OF_A_RUN]).values
    first = zip(dims, np.argwhere(recorded)[0] if recorded.any() else (0,) * len(dims), strict=True)
    one = ", ".join(f"{dim}={place}" for dim, place in first)
    raise InputError(f"{what} is of one member of a sweep: take one, such as ds.isel({one}).inertia")


def _must_have_result(dataset: xr.Dataset) -> None:
    """AbsentError for a member of a sweep that has no records, with the reason."""
    alone = "failure" in dataset.coords and not swept(dataset)
    if alone and not dataset["inertia_tensor"].notnull().any():
        why = dataset["failure"].item()
        raise AbsentError(f"this member of the sweep has no result{f': {why}' if why else '.'}")


def of_each_member(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method of the accessor that answers for each member of a sweep by itself, along the sweep's dimensions.

    Arguments that are DataArrays may differ from member to member, and are matched by labels where they have some.
    Members without records, and times after a member's end, are NaN. SceneError where there are no times, ValueError
    where no member has records, AbsentError for one by itself that has none.
    """

    @wraps(method)
    def answered(accessor: Any, *arguments: Any, **options: Any) -> Any:
        data, dims = accessor.dataset, swept(accessor.dataset)
        must_have_times(data)
        if not dims:
            _must_have_result(data)
            return method(accessor, *arguments, **options)
        arguments = tuple(_arranged(value, data, dims) for value in arguments)
        options = {name: _arranged(value, data, dims) for name, value in options.items()}
        recorded = data["inertia_tensor"].isel(i=0, j=0, drop=True).notnull().transpose(*dims, "time").values
        answers = {}
        for place in zip(*np.nonzero(recorded.any(axis=-1)), strict=True):
            at = dict(zip(dims, place, strict=True))
            one = type(accessor)(data.isel(at))
            own = at | {"time": slice(0, one.dataset.sizes["time"])}
            values = [_selected(value, own) for value in arguments]
            answers[place] = method(one, *values, **{name: _selected(value, own) for name, value in options.items()})
        if not answers:
            raise ValueError("no member of this sweep has records")
        first = next(iter(answers.values()))
        if isinstance(first, xr.DataArray):
            return _together(data, dims, answers)
        series = {name: {place: answer[name] for place, answer in answers.items()} for name in first.data_vars}
        return xr.Dataset({name: _together(data, dims, parts) for name, parts in series.items()}, attrs=first.attrs)

    return answered


def _arranged(value: Any, data: xr.Dataset, dims: tuple[str, ...]) -> Any:
    if isinstance(value, xr.DataArray):
        for dim in set(dims) & set(data.coords):
            value = with_labels(value, dim, data[dim])
    return value


def _selected(value: Any, at: Mapping[str, Any]) -> Any:
    if not isinstance(value, xr.DataArray):
        return value
    return value.isel({dim: place for dim, place in at.items() if dim in value.dims}, drop=True)


def _together(data: xr.Dataset, dims: tuple[str, ...], parts: Mapping[tuple[int, ...], xr.DataArray]) -> xr.DataArray:
    first = next(iter(parts.values()))
    sizes = {**{dim: data.sizes[dim] for dim in dims}, **first.sizes}
    if "time" in first.dims:
        sizes["time"] = data.sizes["time"]
    values = np.full(tuple(sizes.values()), np.nan)
    for place, part in parts.items():
        values[(*place, *(slice(0, length) for length in part.shape))] = part.values
    coords = {
        name: labels.variable
        for name, labels in {**first.coords, **data.coords}.items()
        if set(labels.dims) <= set(sizes) and all(labels.sizes[dim] == sizes[dim] for dim in labels.dims)
    }
    return xr.DataArray(values, coords, tuple(sizes), first.name, first.attrs)
