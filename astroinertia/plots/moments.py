"""The inertia tensor: evolved by its own equation against summed directly, with the closure."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from astroinertia.dataset import bounds
from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style
from astroinertia.plots.axis_scales import has_values
from astroinertia.plots.error_bars import error_of, shade

STEADY = 0.05  # a body whose moments change by less is shown by the change
CLOSURE_BAR = 1e-12  # what double precision should keep, over the largest inertia tensor of the run


@with_absent
def inertia_figure(dataset: xr.Dataset) -> Figure:
    """Diagonal of I(t), its rate, and the difference between the evolved and the direct tensor.

    >>> print([axes.get_ylabel().split(" (")[0] for axes in inertia_figure(ds).axes])
    ['moment of inertia', 'd$I$/d$t$', 'closure']
    """
    with style.styled():
        below = [
            draw for draw, name in ((_rate, "inertia_rate"), (_closure, "ledger_closure")) if has_values(dataset, name)
        ]
        figure = style.begin(dataset, "inertia tensor", (9.0, 4.4 + 2.1 * len(below)))
        panels = figure.subplots(1 + len(below), 1, height_ratios=[2.4, *[1.3] * len(below)], squeeze=False)[:, 0]
        for draw, axes in zip((_moments, *below), panels, strict=True):
            draw(axes, dataset)
            style.time_axis(axes, dataset, last=axes is panels[-1])
        return figure


def _moments(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    direct, evolved = dataset["inertia_tensor"], dataset["inertia_tensor_evolved"]
    diagonal = np.einsum("tii->ti", direct.transpose("time", "i", "j").values)
    nearly_constant = (np.nanmax(abs(diagonal - diagonal[0]), axis=0) < STEADY * diagonal[0]).all() and len(times) > 1

    both = bool(evolved.notnull().any())
    wide = 5.0 if error_of(dataset, "inertia_tensor", i="z", j="z") is None else 2.6  # that no line looks like a bar
    tensors = [(direct, wide, 0.4), (evolved, 1.5, 1.0)] if both else [(direct, 1.7, 1.0)]

    def shown(tensor: xr.DataArray, name: str) -> np.ndarray:
        values = tensor.sel(i=name, j=name).values
        return values / direct.sel(i=name, j=name).values[0] - 1 if nearly_constant else values

    scale, unit = style.scale_of(
        "1" if nearly_constant else style.unit_of(direct), *(shown(direct, name) for name in "xyz")
    )
    for tensor, width, alpha in tensors:
        for name, colour, dashes in zip("xyz", style.COMPONENTS, style.DASHES, strict=True):
            style.curve(
                axes, times, shown(tensor, name) / scale, color=colour, linewidth=width, alpha=alpha,
                linestyle="-" if alpha < 1.0 else dashes,
            )  # fmt: skip
    bands = []
    for k, (name, colour) in enumerate(zip("xyz", style.COMPONENTS, strict=True)):
        size = scale * (diagonal[0, k] if nearly_constant else 1.0)
        bands.append((shown(direct, name) / scale, error_of(dataset, "inertia_tensor", size, i=name, j=name), colour))
    shade(axes, times, bands)
    if nearly_constant:
        axes.axhline(0, color=style.GREY, linewidth=0.8)
        axes.set_ylabel("change since the start" + (f" ({style.raised(unit)})" if unit != "1" else ""))
    else:
        axes.set_ylabel(style.label("moment of inertia", unit))
        style.from_zero_or_log(axes, diagonal, scale)
    axes.set_title("Evolved by its own equation, and of the body itself" if both else "Of the body itself")
    _legend(axes, evolved=both)
    style.mark_compression(axes, dataset, factor, named=True)


def _legend(axes, evolved: bool) -> None:
    looks = zip(style.COMPONENTS, style.DASHES, strict=True)
    handles = [Line2D([], [], color=colour, linestyle=dashes, linewidth=1.7) for colour, dashes in looks]
    names = ["$I_{xx}$", "$I_{yy}$", "$I_{zz}$"]
    if evolved:
        handles.append(Line2D([], [], color=style.GREY, linewidth=1.5))
        handles.append(Line2D([], [], color=style.GREY, linewidth=5, alpha=0.4))
        names += ["evolved", "direct"]
    style.legend(axes, handles, names, handlelength=3.0)


def _rate(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    rate = dataset["inertia_rate"]
    scale, unit = style.scale_of(style.unit_of(rate), rate.values)
    for name, colour, dashes in zip("xyz", style.COMPONENTS, style.DASHES, strict=True):
        style.curve(axes, times, rate.sel(i=name, j=name) / scale, color=colour, linestyle=dashes)
    axes.axhline(0, color=style.GREY, linewidth=0.8)
    axes.set(ylabel=style.label("d$I$/d$t$", unit), title="Its rate, from the mixed moment")
    style.mark_compression(axes, dataset, factor)


def _closure(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    closure = dataset["ledger_closure"].values
    axes.set_title("Closure: |evolved \N{MINUS SIGN} direct| over the largest |I| so far")
    if not (closure > 0).any():
        style.note(axes, "the two agree to the last bit", timed=True)
        return
    axes.semilogy(times, np.where(closure > 0, closure, np.nan), color=style.INK, linewidth=1.2)
    style.level(axes, float(np.finfo(float).eps), "round-off", style.GREEN)
    kept = np.nanmax(closure) < CLOSURE_BAR
    bar, text = (CLOSURE_BAR, "limit of the tests") if kept else (bounds.CLOSURE, "limit of a run")
    style.level(axes, bar, text, style.VERMILLION)
    low, high = style.robust_limits(closure, 1e-18)
    axes.set_ylim(min(low, 5e-17), max(high, 10.0 * bar))
    style.plain_log(axes.yaxis, *axes.get_ylim())
    axes.set_ylabel("closure")
    style.mark_compression(axes, dataset, factor)
