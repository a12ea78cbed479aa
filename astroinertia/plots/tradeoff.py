"""Work and precision: error against processor time of all settings of a tradeoff, one panel an observable."""

import math

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from astroinertia.plots import style

_COLOURS = (*style.COLOURS, style.GREY)
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h")
_BALANCED = ("*", style.INK)  # of settings in which several knobs are turned
_FLOOR = 1e-17  # smallest error that is drawn
_TRIANGLE = 0.22  # width of an order triangle, in decades of time over those of the panel
_NOTE = 8
_FARTHEST = 1.0  # decades below all errors of the scene's own model at which those of other models are drawn at least
_FEW_DECADES = 2.0  # of an axis, which then has ticks at 1, 2 and 5


def tradeoff_figure(table: xr.Dataset) -> Figure:
    """Error against processor time in logarithms, a colour and marker a knob, joined in the order of its values.

    The base is ringed, the Pareto front drawn, its knee marked; a triangle shows the slope that the fitted order of the
    knob that limits the error gives, with the cost as it was measured.

    >>> from pathlib import Path
    >>> from astroinertia.accuracy import table, tradeoff
    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> study = tradeoff.carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print(len(tradeoff_figure(table.dataset(study)).axes))  # a panel an observable
    2
    """
    names = [str(name) for name in table["observable"].values]
    with style.styled():
        figure = style.page(f"{style.words(table.attrs.get('name', ''))}: what accuracy costs", (6.6 * len(names), 6.4))
        panels = figure.subplots(1, len(names), squeeze=False)[0]
        for panel, name in zip(panels, names, strict=True):
            _panel(panel, table, name)
        _legend(figure, table)
        return figure


def _panel(panel, table: xr.Dataset, name: str) -> None:
    one = table.sel(observable=name)
    seconds, error = one["cpu_time"].values, one["error"].values
    good = np.isfinite(seconds) & np.isfinite(error)
    panel.set_title(style.words(name))
    if not good.any():
        style.note(panel, "no setting has an error that is known")
        return
    accuracy = float(one["reference_accuracy"])
    error = np.maximum(error, max(_FLOOR, 0.1 * accuracy if math.isfinite(accuracy) else 0.0))
    rungs = one["knob_turned"].values.astype(str) == "model"
    error = _raised(error, good & rungs, good & ~rungs)
    _front(panel, one, seconds, error)
    knobs = [str(knob) for knob in table["knob"].values]
    turned = one["knob_turned"].values.astype(str)
    base = one["is_base"].values.astype(bool)
    other = table["knob_is_alternative"].values.astype(bool)
    for number, knob in enumerate(knobs):
        around = number > 0 and not other[number] and bool((turned == knob).any())
        of_knob = good & ((turned == knob) | (base & around))
        _line(panel, one, seconds, error, of_knob, knob, *_look(number))
    together = good & (turned == "balanced")
    marker, colour = _BALANCED
    panel.plot(seconds[together], error[together], marker, color=colour, markersize=10, zorder=4)
    if (good & base).any():
        panel.plot(
            seconds[base], error[base], "o", markersize=17, markerfacecolor="none", markeredgecolor=style.INK,
            markeredgewidth=1.3, zorder=5,
        )  # fmt: skip
    panel.set(xscale="log", yscale="log", xlabel="processor time of the steps (s)", ylabel="relative error at the end")
    _limits(panel, seconds[good], error[good])
    if math.isfinite(accuracy) and panel.get_ylim()[0] < accuracy:
        panel.axhspan(panel.get_ylim()[0], accuracy, color=style.PALE, alpha=0.45, zorder=0.2)
        panel.annotate(
            "below the accuracy of the reference", (0.99, accuracy), xycoords=("axes fraction", "data"),
            xytext=(0, -3), textcoords="offset points", ha="right", va="top", fontsize=_NOTE, color=style.GREY,
        )  # fmt: skip
    for number in map(int, np.flatnonzero(good & rungs)):
        panel.annotate(
            _rung(one, number, error[number]), (seconds[number], error[number]), xytext=(8, 0),
            textcoords="offset points", va="center", fontsize=9, color=style.INK,
        )  # fmt: skip
    _triangle(panel, table, name)
    _knee(panel, one, seconds, error)


def _raised(error: np.ndarray, rungs: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Errors (S,), those of other rungs no farther below all others than is drawn: they may be exact."""
    if not others.any():
        return error
    return np.where(rungs, np.maximum(error, error[others].min() * 10.0**-_FARTHEST), error)


def _front(panel, one: xr.Dataset, seconds: np.ndarray, error: np.ndarray) -> None:
    on_front = one["pareto"].values.astype(bool)
    order = np.flatnonzero(on_front)[np.argsort(seconds[on_front])]
    panel.plot(seconds[order], error[order], color=style.PALE, linewidth=7, zorder=1, solid_joinstyle="round")


def _line(
    panel, one: xr.Dataset, seconds: np.ndarray, error: np.ndarray, which: np.ndarray, knob: str, marker: str,
    colour: str,
) -> None:  # fmt: skip
    if not which.any():
        return
    steps, numbers = one["step_size"].values, np.flatnonzero(which)
    own = numbers[one["knob_turned"].values[numbers].astype(str) == knob]
    if np.isfinite(steps[own]).any() and len(numbers) > 1:  # a knob with an order: its values are joined, the base too
        ranked = own[np.argsort(-steps[own])] if len(own) == len(numbers) else numbers[np.argsort(seconds[numbers])]
        panel.plot(seconds[ranked], error[ranked], color=colour, linewidth=1.1, alpha=0.75, zorder=2)
    panel.plot(seconds[own], error[own], marker, color=colour, markersize=6.5, zorder=3, markeredgecolor="white")


def _knee(panel, one: xr.Dataset, seconds: np.ndarray, error: np.ndarray) -> None:
    for number in np.flatnonzero(one["knee"].values):
        label = str(one["setting"].values[number])
        place = panel.transAxes.inverted().transform(panel.transData.transform((seconds[number], error[number])))
        side = -1 if place[0] > 0.35 else 1  # where there is room for the label
        panel.annotate(
            f"knee: {label}" if len(label) < 40 else "knee", (seconds[number], error[number]), xytext=(side * 14, -26),
            textcoords="offset points", ha="right" if side < 0 else "left", fontsize=9, color=style.INK,
            arrowprops={"arrowstyle": "->", "color": style.INK, "linewidth": 0.9, "shrinkB": 6},
        )  # fmt: skip


def _triangle(panel, table: xr.Dataset, name: str) -> None:
    """The slope of error over time along the knob that errs most: its order over that of its cost."""
    of_knobs = table.sel(observable=name)
    errors = np.where(np.isfinite(of_knobs["order"].values), of_knobs["knob_error"].values, np.nan)
    if not np.isfinite(errors).any():
        return
    number = int(np.nanargmax(errors))
    order, growth = float(of_knobs["order"][number]), float(of_knobs["cost_order"][number])
    if not (order > 0 and growth > 0):
        return
    (left, right), (low, high) = np.log10(panel.get_xlim()), np.log10(panel.get_ylim())
    slope = order / growth
    width = min(_TRIANGLE * (right - left), 0.25 * (high - low) / slope)
    x, y = right - 0.08 * (right - left) - width, high - 0.07 * (high - low)
    corners = [(x, y), (x + width, y), (x + width, y - slope * width), (x, y)]
    colour = _look(number)[1]
    panel.plot(*(10.0 ** np.array(corners)).T, color=colour, linewidth=1.1, zorder=6)
    spread = float(of_knobs["order_uncertainty"][number])
    note = f"order {order:.2f}" + (f" ± {spread:.2f}" if math.isfinite(spread) else "")
    theory = float(table["expected_order"][number])
    note += f", theory {theory:g}" if math.isfinite(theory) else ""
    panel.annotate(
        f"{style.words(str(table['knob'].values[number]))}: {note}", (10.0 ** (x + width), 10.0**y), xytext=(0, 5),
        textcoords="offset points", ha="right", fontsize=_NOTE + 0.5, color=colour,
    )  # fmt: skip


def _legend(figure, table: xr.Dataset) -> None:
    drawn = np.isfinite(table["cpu_time"]) & np.isfinite(table["error"])
    turned = set(table["knob_turned"].where(drawn, "").values.astype(str).ravel())
    handles = []
    for number, knob in enumerate(table["knob"].values):
        if str(knob) in turned:
            marker, colour = _look(number)
            handles.append(Line2D([], [], marker=marker, color=colour, markersize=6.5, label=style.words(str(knob))))
    if "balanced" in turned:
        marker, colour = _BALANCED
        handles.append(
            Line2D([], [], marker=marker, color=colour, linestyle="", markersize=10, label="several, balanced")
        )
    if bool((drawn & table["is_base"]).any()):
        handles.append(
            Line2D([], [], marker="o", linestyle="", markersize=13, markerfacecolor="none", markeredgecolor=style.INK,
                   label="base")
        )  # fmt: skip
    if bool(((table["pareto"] & drawn).sum("setting") > 1).any()):  # one point alone is no line
        handles.append(Line2D([], [], color=style.PALE, linewidth=7, label="Pareto front"))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5))


def _limits(panel, seconds: np.ndarray, error: np.ndarray) -> None:
    for axis, values, limit in ((panel.xaxis, seconds, panel.set_xlim), (panel.yaxis, error, panel.set_ylim)):
        low, high = np.log10(values.min()), np.log10(values.max())
        room = max(0.12 * (high - low), 0.25)
        limit(10.0 ** (low - room), 10.0 ** (high + 1.6 * room))
        if high - low < _FEW_DECADES:
            style.plain_log(axis, 10.0**low, 10.0**high)
        else:
            axis.set_major_locator(LogLocator(numticks=10))
            axis.set_minor_formatter(NullFormatter())


def _rung(one: xr.Dataset, number: int, drawn: float) -> str:
    """What is written beside another rung: its name, and its error, for it may be drawn above it."""
    error, accuracy = float(one["error"][number]), float(one["reference_accuracy"])
    note = "exact" if error < accuracy else f"error {style.number(error, 2)}"
    note += " \N{DOWNWARDS ARROW}" if drawn > error else ""
    return f"{one['value'].values[number]}: {note}"


def _look(number: int) -> tuple[str, str]:
    return _MARKERS[number % len(_MARKERS)], _COLOURS[number % len(_COLOURS)]
