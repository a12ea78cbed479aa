"""Error bars as shaded bands about the series that have them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.plots import style

_OPACITY = 0.22
Band = tuple[np.ndarray, np.ndarray | None, str]
"""Values (T,), their error (T,) or None, and the colour of the line."""


def error_of(dataset: xr.Dataset, name: str, scale: float = 1.0, **labels: Any) -> np.ndarray | None:
    """The error bar of a series over `scale`, of a vector without labels that of its length; None where there is none.

    Test: tests/unit/accuracy/test_error_bars.py.
    """
    if f"{name}_error" not in dataset:
        return None
    bar = dataset[f"{name}_error"].sel(labels).transpose("time", ...).values / scale
    bar = np.linalg.norm(bar, axis=1) if bar.ndim == 2 else bar
    return bar if np.isfinite(bar).any() else None


def shade(axes: Any, times: np.ndarray, bands: Sequence[Band]) -> None:
    """Draw bands of value +- error, and say once in the panel what they are."""
    drawn = [(values, error, colour) for values, error, colour in bands if error is not None]
    for values, error, colour in drawn:
        low, high = values - error, values + error
        axes.fill_between(times, low, high, color=colour, alpha=_OPACITY, linewidth=0, zorder=1.5)
    if drawn:
        axes.annotate(
            "shaded: error bars", (1, 1), xycoords="axes fraction", xytext=(0, 4), textcoords="offset points",
            ha="right", va="bottom", fontsize=8, color=style.GREY,
        )  # fmt: skip
