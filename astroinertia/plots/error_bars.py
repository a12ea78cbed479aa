"""Error bars of a run over the values that they belong to, against time, and as shaded bands about their series."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style

_SUFFIX = "_error"
_LEAST_DRAWN = 1e-5  # of the greatest
_SHOWN = {
    "inertia_tensor": (style.BLUE, "-"),
    "attitude": (style.SKY, "-"),
    "angular_momentum": (style.GREY, "-"),
    "angular_velocity": (style.VERMILLION, "-"),
    "mean_radius": (style.GREEN, "-"),
    "ellipsoid_flattening": (style.PURPLE, "-"),
    "moment_ratio": (style.SKY, (0, (4, 2))),
    "kinetic_energy": (style.ORANGE, "-"),
    "internal_energy": (style.YELLOW, "-"),
    "gravitational_energy": (style.ORANGE, (0, (4, 2))),
    "rotational_to_gravitational": (style.VERMILLION, (0, (4, 2))),
    "density_max": (style.INK, (0, (1.2, 1.6))),
}


def known_bars(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Error bars (T,) over the size of what they belong to, of vectors and tensors over all components."""
    bars = {}
    for name in _SHOWN:
        if f"{name}{_SUFFIX}" not in dataset or not np.isfinite(dataset[f"{name}{_SUFFIX}"]).any():
            continue
        sizes = []
        for variable in (f"{name}{_SUFFIX}", name):
            values = dataset[variable].transpose("time", ...).values
            sizes.append(np.linalg.norm(values.reshape(len(values), -1), axis=1))
        bars[name] = np.divide(*sizes, out=np.full(len(sizes[0]), np.nan), where=sizes[1] > 0.0)
    return bars


@with_absent
def error_bars_figure(dataset: xr.Dataset) -> Figure:
    """All error bars of a run in one panel.

    >>> with_error = ds.assign(inertia_tensor_error=0.01 * ds.inertia_tensor * (1 + ds.time / ds.time[-1]))
    >>> (axes,) = error_bars_figure(with_error).axes
    >>> print(f"{axes.lines[0].get_ydata().max():.2f}", axes.get_yscale())
    0.02 log
    """
    with style.styled():
        figure = style.begin(dataset, "error bars", (9.0, 4.6))
        axes = figure.subplots()
        bars = known_bars(dataset)
        if not bars:
            style.note(axes, "no error bars: run with --error-bars")
            return figure
        times, factor, _ = style.shown_times(dataset)
        greatest = max(float(np.nanmax(bar)) for bar in bars.values())
        if not greatest > 0.0:
            style.note(axes, "all error bars are zero")
            return figure
        axes.set_yscale("log")
        axes.set_ylim(_LEAST_DRAWN * greatest, 3.0 * greatest)  # first: bars may be the same at all times
        style.plain_log(axes.yaxis, *axes.get_ylim())
        for name, bar in bars.items():
            if not np.nanmax(bar) > _LEAST_DRAWN * greatest:
                continue  # of what is kept to rounding
            colour, dashes = _SHOWN[name]
            shown = np.where(bar > 0.0, bar, np.nan)
            axes.plot(times, shown, color=colour, linestyle=dashes, linewidth=1.5, label=style.words(name))
        axes.set(ylabel="error bar / value", title="Estimated errors, over the values")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        style.mark_compression(axes, dataset, factor)
        style.time_axis(axes, dataset)
        return figure


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
