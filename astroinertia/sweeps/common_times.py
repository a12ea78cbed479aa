"""The times that the members of a sweep have in common in its result, and a member's records at those times.

Members with the same cadence share their times, and one that ends before the others has its own part of them: nothing
is interpolated then.
"""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

ROUND_OFF = 1e-12  # by which times differ that members convert from units of their own
MOST = 4  # times as many common times as the longest member has records
_NEAREST = ("_axes", "_axis", "_phase")  # directions and angles, which have no straight line between them
_NUMBERS = ("attitude", "step", "timestep_limit")


def common(times: Sequence[np.ndarray]) -> np.ndarray:
    """All times of members, each (K,) ascending; where those are too many, equal parts of the longest run, and ends.

    The parts are as short as the shortest mean time between records of a member, and at most MOST as many as the member
    with most records has.

    >>> print(common([np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 2.0, 3.0])]))
    [0. 1. 2. 3.]
    """
    union = _distinct(np.concatenate(times))
    longest = max(map(len, times))
    if len(union) <= MOST * longest:
        return union
    ends = [own[-1] for own in times]
    shortest = min(own[-1] / (len(own) - 1) for own in times if len(own) > 1)
    parts = min(math.ceil(max(ends) / shortest * (1.0 - ROUND_OFF)), MOST * longest)
    return _distinct(np.concatenate([np.linspace(0.0, max(ends), parts + 1), ends]))


def at_times(data: xr.Dataset, times: np.ndarray) -> tuple[xr.Dataset, bool]:
    """A member's series at those of the common times (K,) that it reached, and whether some are interpolated.

    Between two records they are linear in time; directions, phases, numbers and texts are those of the nearest record.

    >>> between, interpolated = at_times(ds, np.array([0.0, 0.5 * float(ds.time[1])]))
    >>> print(between.sizes["time"], interpolated)
    2 True
    """
    own = data["time"].values
    reached = times[times <= own[-1] * (1.0 + ROUND_OFF)]
    after = np.clip(np.searchsorted(own, reached), min(1, len(own) - 1), len(own) - 1)
    before = np.maximum(after - 1, 0)
    share = (reached - own[before]) / np.where(after > before, own[after] - own[before], 1.0)
    nearest = np.where(share < 0.5, before, after)
    exact = np.abs(reached - own[nearest]) <= ROUND_OFF * np.abs(reached)

    def moved(name: str, variable: xr.Variable) -> xr.Variable:
        if "time" not in variable.dims:
            return variable
        axis = variable.dims.index("time")
        series = np.moveaxis(variable.values, axis, 0)
        values = series[nearest]
        if variable.dtype.kind == "f" and not name.endswith(_NEAREST) and name not in _NUMBERS:
            weight = share.reshape(-1, *[1] * (series.ndim - 1))
            between = (1.0 - weight) * series[before] + weight * series[after]
            values[~exact] = between[~exact]
        return xr.Variable(variable.dims, np.moveaxis(values, 0, axis), variable.attrs)

    variables = {str(name): moved(str(name), variable) for name, variable in data.variables.items() if name != "time"}
    coords = {name: variables.pop(str(name)) for name in data.coords if name != "time"}
    return xr.Dataset(variables, {**coords, "time": ("time", reached)}, data.attrs), not exact.all()


def _distinct(times: np.ndarray) -> np.ndarray:
    ordered = np.unique(times)
    return ordered[np.diff(ordered, prepend=-np.inf) > ROUND_OFF * np.abs(ordered)]
