"""Sweeps: a model over every combination of parameter values, as a Dataset with a dimension for each parameter."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities

CHUNK = 65536  # members of a chunk: some megabytes of intermediate results
LARGEST = 50_000_000  # members; more than that in memory at once is a mistake more often than a wish


@dataclass(frozen=True)
class Model:
    """A function of arrays of one shape (members,), by name, that returns arrays of that shape, by name.

    inputs and outputs: unit and a few words for each name. A member that is impossible is NaN in every output. A name
    may be in both, for what follows where it is not given.
    """

    function: Callable[..., Mapping[str, Any]]
    inputs: Mapping[str, tuple[str, str]]
    outputs: Mapping[str, tuple[str, str]]


@with_quantities()
def sweep(
    model: Model,
    values: Mapping[str, Sequence[float] | np.ndarray],
    fixed: Mapping[str, float] | None = None,
    dask: bool = False,
    chunk: int = CHUNK,
) -> xr.Dataset:
    """Return the model's outputs over all combinations of `values`, one dimension for each name in them.

    An output that `values` gives is the coordinate of that name, and no variable.

    fixed: inputs that stay as they are. dask: the arrays are lazy and computed in chunks of about `chunk` members, in
    parallel by the scheduler that dask is set to, when they are asked for (needs the extra astroinertia[dask]).
    SceneError for a name that the model does not have, and for values that are none, not finite or too many.

    >>> squares = Model(lambda x: {"y": x**2, "z": x**3}, {"x": ("m", "")}, {"y": ("m2", ""), "z": ("m3", "")})
    >>> print(sweep(squares, {"x": [1.0, 2.0, 3.0]}).y.values)
    [1. 4. 9.]
    """
    fixed = {} if fixed is None else dict(fixed)
    for name in (*values, *fixed):
        if name not in model.inputs:
            raise SceneError(f"there is no parameter '{name}' here; there is {', '.join(model.inputs)}")
        if name in values and name in fixed:
            raise SceneError(f"{name} is swept and has one value besides: give one of the two")
    axes = {name: np.atleast_1d(np.asarray(axis, dtype=float)) for name, axis in values.items()}
    for name, axis in axes.items():
        if axis.ndim != 1 or not axis.size or not np.isfinite(axis).all():
            raise SceneError(f"a sweep needs a list of finite values of {name}, not {axis.tolist()!r:.60}")
    members = math.prod(axis.size for axis in axes.values())
    if members > LARGEST:
        raise SceneError(f"{members} combinations are more than the {LARGEST} that a sweep may have")
    if not axes:
        raise SceneError("a sweep needs at least one parameter with its values")
    names, wanted = list(axes), [name for name in model.outputs if name not in axes]
    points = [xr.DataArray(axis, dims=[name], coords={name: axis}) for name, axis in axes.items()]
    if dask:
        points = _chunked(points, members, chunk)

    def columns(*inputs: np.ndarray) -> tuple[np.ndarray, ...]:
        same = np.broadcast_arrays(*inputs)
        outputs = model.function(**{name: axis.ravel() for name, axis in zip(names, same, strict=True)}, **fixed)
        return tuple(np.asarray(outputs[name], dtype=float).reshape(same[0].shape) for name in wanted)

    outputs = xr.apply_ufunc(
        columns,
        *points,
        output_core_dims=[[] for _ in wanted],
        output_dtypes=[float] * len(wanted),
        dask="parallelized" if dask else "forbidden",
    )
    outputs = (outputs,) if len(wanted) == 1 else outputs
    dataset = xr.Dataset(dict(zip(wanted, outputs, strict=True)))
    described = {name: model.outputs[name] for name in wanted} | {name: model.inputs[name] for name in names}
    for name, (unit, text) in described.items():
        dataset[name].attrs = {"units": unit, "long_name": text}
    dataset.attrs = {name: float(value) for name, value in fixed.items()}
    return dataset


def _chunked(points: list[xr.DataArray], members: int, chunk: int) -> list[xr.DataArray]:
    """Split the first dimensions, so that a block of all of them has about `chunk` members."""
    try:
        import dask.array  # noqa: F401  # pyright: ignore[reportMissingImports]  xarray's chunk() needs it
    except ImportError:
        raise SceneError("a sweep in parallel needs dask: pip install 'astroinertia[dask]'") from None
    rest, split = members, []
    for point in points:
        rest //= point.size
        length = min(point.size, max(1, chunk // max(rest, 1)))
        split.append(point.chunk({point.dims[0]: length}))
    return split
