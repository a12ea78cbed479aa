"""Principal moments and axes of a run's inertia tensor, also of one that has taken the place of the recorded one.

And the axes that the accessor's methods are asked for: letters, vectors, and vectors for each time.
Tests: tests/unit/dataset/test_principal.py, tests/unit/dataset/test_accessor.py.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.dataset.arranged import from_x_to_z, in_seconds, with_labels
from astroinertia.inertia import principal

NAMES = ("principal_moments", "principal_axes", "principal_gap", "figure_rotation_rate")
_SINGLE = 1e-6  # of the largest moment: records may have been made single precision
_NO_RATE = "it follows from the rate of the recorded inertia tensor, in whose place there is another"


def of_its_tensor(recorded: xr.Dataset, inertia: xr.DataArray) -> xr.Dataset:
    """Moments, axes and gaps as recorded where they are of this inertia tensor (time, i, j), found from it elsewhere.

    recorded: NAMES of one run. The rate at which the axes turn follows from dI/dt, and is NaN for another tensor.

    >>> larger = ds.assign(inertia_tensor=2.0 * ds.inertia_tensor)
    >>> moments = of_its_tensor(ds[list(NAMES)], larger.inertia_tensor).principal_moments
    >>> print(bool((moments == 2.0 * ds.principal_moments).all()))
    True
    """
    tensor = inertia.transpose("time", "i", "j").values.astype(float)
    tolerance = float(recorded["principal_axes"].attrs.get("tolerance", principal.ROUND_OFF_GAP))
    ordered = recorded.transpose("time", "principal", ...)
    if _belong(ordered["principal_moments"].values, ordered["principal_axes"].values, tensor, tolerance):
        return recorded
    moments, axes = principal.tracked_frame(tensor, tolerance)
    found = moments, axes, principal.principal_gap(moments), np.full_like(moments, np.nan)
    given = ordered.assign({name: ordered[name].copy(data=values) for name, values in zip(NAMES, found, strict=True)})
    given[NAMES[-1]].attrs["reason"] = _NO_RATE
    return given


def _belong(moments: np.ndarray, axes: np.ndarray, tensor: np.ndarray, tolerance: float) -> bool:
    """Whether moments (T, 3) about axes (T, 3, 3) are a tensor's (T, 3, 3); axes of equal moments may be any."""
    largest = abs(tensor).max((1, 2))[:, None]
    same = abs(np.sort(moments) - principal.principal_frame(tensor)[0]) <= _SINGLE * largest
    about = np.einsum("tki,tij,tlj->tkl", axes, tensor, axes) - moments[:, :, None] * np.eye(3)
    along = abs(about) <= max(2.0 * tolerance, _SINGLE) * largest[..., None]
    return bool(np.all((same.all(-1) & along.all((1, 2))) | ~np.isfinite(tensor).all((1, 2))))


Axis = str | Sequence[float] | np.ndarray | xr.DataArray


def directions(axis: Axis, times: xr.DataArray) -> np.ndarray:
    """Unit vectors along "x", "y", "z", a vector (3,), or one for each of these times, (time, i).

    ValueError for what is none.
    """
    if isinstance(axis, str):
        if axis not in ("x", "y", "z"):
            raise ValueError(f'an axis is "x", "y", "z", "spin" or a vector, not {axis!r}')
        return np.eye(3)["xyz".index(axis)]
    if isinstance(axis, xr.DataArray):
        axis = with_labels(in_seconds(from_x_to_z(axis)), "time", times)
        vectors = axis.transpose(..., "i").values
    else:
        vectors = np.asarray(axis, dtype=float)
    if vectors.shape[-1:] != (3,):
        raise ValueError(f"an axis has three components, not the shape {vectors.shape}")
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if vectors.ndim == 1 and not 0.0 < sizes < np.inf:
        raise ValueError("an axis must have a direction: its components are all 0, or one of them is no finite number")
    return vectors / np.where(sizes > 0.0, sizes, np.nan)


def axis_text(axis: Any) -> str:
    """An axis in words."""
    if isinstance(axis, str):
        return "the spin axis" if axis == "spin" else axis
    return "an axis that moves" if np.ndim(axis) > 1 else f"({', '.join(f'{float(x):.3g}' for x in axis)})"
