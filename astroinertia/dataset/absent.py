"""What a run does not have: NaN with a reason in its file, left out where a user opens it, and back for code that asks.

Tests: tests/unit/dataset/test_absent.py.
"""

import functools
import json
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from astroinertia.dataset.arranged import from_x_to_z
from astroinertia.dataset.regions import QUANTITIES as REGIONAL
from astroinertia.dataset.schema import label
from astroinertia.observables.quantities import DERIVED, LABELS, RECORDED
from astroinertia.units import DIMENSIONLESS

ATTRIBUTE = "absent"  # of a dataset without them: names and reasons, as JSON
_F = TypeVar("_F", bound=Callable[..., Any])


def reasons(dataset: xr.Dataset) -> dict[str, str]:
    """The quantities that a run does not have, each with the reason, whether they are in the dataset as NaN or not."""
    left_out = json.loads(dataset.attrs.get(ATTRIBUTE, "{}"))
    there = {str(name): dataset.variables[name].attrs for name in dataset.data_vars}
    return left_out | {name: str(attrs["reason"]) for name, attrs in there.items() if "reason" in attrs}


def without_absent(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset without what the run does not have, nor labels of nothing; `whole` brings it back."""
    absent = reasons(dataset)
    if not absent:
        return dataset
    kept = dataset.drop_vars([name for name in absent if name in dataset.data_vars])
    used = {dim for variable in kept.data_vars.values() for dim in variable.dims}
    labels = [name for name, coordinate in kept.coords.items() if not set(coordinate.dims) <= used]
    return kept.drop_vars(labels).assign_attrs({ATTRIBUTE: json.dumps(absent)})


def whole(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset with NaN, and the reason, for what was left out of it because the run does not have it."""
    absent = reasons(dataset)
    schema = {name: quantity for name, quantity in (RECORDED | DERIVED | REGIONAL).items() if name in absent}
    chosen = {name for name, labels in dataset.coords.items() if not labels.dims}  # of which one label is left
    missing = {
        name: quantity for name, quantity in schema.items() if name not in dataset and not chosen & set(quantity.dims)
    }
    if not missing or "time" not in dataset.sizes:
        return dataset
    dimensionless = dataset.attrs.get("code_unit_time") == DIMENSIONLESS.time
    variables = {}
    for name, quantity in missing.items():
        sizes = [dataset.sizes.get(dim, len(LABELS[dim][0]) if dim in LABELS else 1) for dim in quantity.dims]
        unit = "1" if dimensionless and quantity.dimension is not None else quantity.unit
        attrs = {"units": unit, "long_name": quantity.long_name, "reason": absent[name]}
        variables[name] = (quantity.dims, np.full(sizes, np.nan), attrs)
    dims = {dim for quantity in missing.values() for dim in quantity.dims if dim not in dataset.coords}
    labels = {dim: label(dim) if dim in LABELS else (dim, np.zeros(1)) for dim in dims - {"time", "effect", "region"}}
    others = {name: reason for name, reason in absent.items() if name not in missing}
    kept = {name: value for name, value in dataset.attrs.items() if name != ATTRIBUTE}
    kept |= {ATTRIBUTE: json.dumps(others)} if others else {}
    completed = dataset.merge(xr.Dataset(variables, coords=labels))
    completed.attrs, completed.encoding = kept, dict(dataset.encoding)
    return completed


def with_absent(function: _F) -> _F:
    """A function of a dataset, or of several, that is given them whole, with their components from x to z."""

    @functools.wraps(function)
    def of_whole(dataset: Any, *args: Any, **options: Any) -> Any:
        several = isinstance(dataset, list | tuple)
        given = [_arranged(one) for one in dataset] if several else _arranged(dataset)
        return function(given, *args, **options)

    return of_whole  # type: ignore[return-value]


def _arranged(dataset: Any) -> Any:
    """A dataset whole, with all that is left of its components in order: xarray lets anyone change it."""
    dataset = whole(dataset)
    complete = all(
        sorted(map(str, dataset[dim].values.ravel())) == ["x", "y", "z"] for dim in ("i", "j") if dim in dataset.coords
    )
    return from_x_to_z(dataset) if complete else dataset
