"""The spin: how fast the body turns, and what the scaling laws would have said."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.bodies.bar_limits import DYNAMICAL, SECULAR
from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.rotational_share import differential, rotational_share
from astroinertia.plots import style
from astroinertia.plots.axis_scales import angular_momentum_scale, has_values
from astroinertia.plots.error_bars import error_of, shade

STAYS = 1e-9  # of a spin: a smaller change is round-off, and not drawn as if it were more
UNBOUND = 1.0  # T/|W| of what is torn apart rather than unstable to a bar


@with_absent
def spin_figure(dataset: xr.Dataset) -> Figure:
    """Spin against the scalings with 1/I and R^-2, their ratio to it, and T/|W|.

    >>> print(len(spin_figure(ds).axes))  # the spin, over what L/I and others predict, T/|W|
    3
    """
    with style.styled():
        turning = angular_momentum_scale(dataset)[1]
        drawn = [(_spin, 2.4)]
        if turning and _laws(dataset):
            drawn.append((_ratios, 1.3))
        if turning and has_values(dataset, "rotational_to_gravitational"):
            drawn.append((_rotational_energy, 1.3))
        figure = style.begin(dataset, "spin and its scaling laws", (9.0, 1.2 + 1.48 * sum(size for _, size in drawn)))
        panels = figure.subplots(len(drawn), 1, height_ratios=[size for _, size in drawn], squeeze=False)[:, 0]
        for (draw, _), axes in zip(drawn, panels, strict=True):
            if turning:
                draw(axes, dataset)
            else:
                style.note(axes, "the body does not spin")
            style.time_axis(axes, dataset, last=axes is panels[-1])
        return figure


def _laws(dataset: xr.Dataset) -> list[tuple]:
    inertia = dataset.inertia
    laws = [
        (inertia.spin_scaling("inertia").values, style.VERMILLION, (0, (5, 2)), r"$\omega_0\, I_0/I$"),
        (inertia.spin_scaling("radius").values, style.GREEN, (0, (1.2, 1.6)), r"$\omega_0\,(R_0/R)^2$"),
    ]
    return [law for law in laws if np.nan_to_num(law[0]).any()]  # none of a disc's radius, or of a body first at rest


def _spin(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    rate = dataset.inertia.spin_rate()
    laws = _laws(dataset)
    scale, unit = style.scale_of(style.unit_of(rate), rate.values)
    error = error_of(dataset, "angular_velocity", scale)
    look: dict[str, Any] = {"linewidth": 5, "alpha": 0.4} if error is None else {}  # that no line looks like a bar
    axes.plot(times, rate / scale, color=style.BLUE, **look, label="mean angular velocity")
    shade(axes, times, [(rate.values / scale, error, style.BLUE)])
    for values, colour, dashes, name in laws:
        axes.plot(times, values / scale, color=colour, linestyle=dashes, label=f"scaling {name}")
    values = np.concatenate([rate.values, *(law[0] for law in laws)])
    if (values > 0).all() and values.max() > 8 * values.min():
        axes.set_yscale("log")
        style.plain_log(axes.yaxis, values.min() / scale, values.max() / scale)
    middle = float(np.nanmean(values)) / scale
    if np.ptp(axes.get_ylim()) < STAYS * abs(middle):
        axes.set_ylim(*sorted((0.99 * middle, 1.01 * middle)))
    axes.set_ylabel(style.label(r"spin $\omega$", unit))
    axes.set_title("Mean spin, and what its start value and a scaling law predict" if laws else "Mean spin")
    style.legend(axes)
    style.mark_compression(axes, dataset, factor, named=True)
    if axes.get_yscale() != "log":
        return  # on a linear axis periods would bunch up
    period = 2 * np.pi / abs(rate.values[np.isfinite(rate.values) & (rate.values != 0)])
    time_unit = "s" if style.unit_of(dataset["time"]) == "s" else "1"
    period_scale, period_unit = style.scale_of(time_unit, np.median(period))
    convert = _period(scale * period_scale)
    second = axes.secondary_yaxis("right", functions=(convert, convert))
    style.plain_log(second.yaxis, period.min() / period_scale, period.max() / period_scale)
    second.set_ylabel(style.label("period", period_unit))
    second.spines["right"].set_visible(True)


def _period(scale: float):
    def convert(values):
        with np.errstate(divide="ignore"):
            return 2 * np.pi / (np.asarray(values, dtype=float) * scale)

    return convert


def _ratios(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    rate, laws = dataset.inertia.spin_rate().values, _laws(dataset)
    for values, colour, dashes, name in laws:
        axes.plot(times, rate / values, color=colour, linestyle=dashes, label=f"over {name}")
    axes.axhline(1, color=style.GREY, linewidth=0.8)
    low, high = axes.get_ylim()
    if high - low < 0.02:
        axes.set_ylim(min(low, 0.99), max(high, 1.01))
    axes.set(ylabel=r"$\omega$ / predicted", title="Spin over prediction: 1 where the law holds")
    style.legend(axes, room=0.22)
    style.mark_compression(axes, dataset, factor)


def _rotational_energy(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    shells, mean = rotational_share(dataset), dataset["rotational_to_gravitational"].values
    top = float(np.nanmax(shells))
    scale, unit = style.scale_of("1", top)
    axes.set_title("Rotational over gravitational energy")
    error = error_of(dataset, "rotational_to_gravitational", scale)
    if differential(shells, mean):
        axes.plot(times, shells / scale, color=style.VERMILLION, label="shell by shell")
        axes.plot(times, mean / scale, color=style.BLUE, label="of the mean angular velocity")
    else:
        axes.plot(times, mean / scale, color=style.BLUE)
    shade(axes, times, [(mean / scale, error, style.BLUE)])
    axes.set_ylim(0, 1.15 * top / scale or 1.0)
    for level, name in ((SECULAR, "secular bar instability"), (DYNAMICAL, "dynamical bar instability")):
        if 0.5 * level < top < UNBOUND:
            axes.set_ylim(top=max(axes.get_ylim()[1], 1.15 * level))
            axes.axhline(level, color=style.PURPLE, linewidth=1, linestyle="--")
            above = not shells[0] > level  # the name is where the curve begins not
            axes.annotate(
                f"{name} ({level:.2g})", (0, level), xycoords=("axes fraction", "data"), xytext=(4, 2 if above else -2),
                textcoords="offset points", fontsize=8, color=style.PURPLE, va="bottom" if above else "top",
            )  # fmt: skip
    if axes.get_legend_handles_labels()[0]:
        style.legend(axes, room=0.2)
    axes.set_ylabel(style.label("$T/|W|$", unit))
    style.mark_compression(axes, dataset, factor)
