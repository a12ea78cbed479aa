"""Axes that the accessor's methods are asked for: letters, vectors, and vectors for each time.

Tests: tests/unit/dataset/test_accessor.py.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.dataset.arranged import from_x_to_z, in_seconds, with_labels

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
