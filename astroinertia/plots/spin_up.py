"""Spin-up pictures: period against radius at constant angular momentum, and the P-P' diagram of pulsars."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from astroinertia.plots import style
from astroinertia.rotation import accretion, pulsars
from astroinertia.rotation.pulsar_table import Pulsar, pulsars as observed

_YEAR, _HOUR = 365.25 * 86400, 3600.0
_COMPACT = 1e6  # m; what ends smaller is a neutron star here
_KINDS = {
    "ordinary": ("o", style.BLUE, "ordinary"),
    "recycled": ("D", style.VERMILLION, "spun up by accretion"),
    "magnetar": ("^", style.PURPLE, "magnetar"),
    "isolated": ("s", style.GREEN, "thermal X-rays only"),
}
_NAMED = ("Crab", "Vela", "B1509-58", "Geminga", "B1919+21", "J2144-3933", "Hulse-Taylor", "B1937+21", "J0437-4715",
          "SGR 1806-20", "1E 2259+586", "J0250+5854", "J0737-3039A", "B1957+20")  # fmt: skip
_PERIODS, _SLOWING = (1e-3, 50.0), (1e-21, 3e-9)
_GAUSS = (1e8, 1e10, 1e12, 1e14)
_AGES = ((1e3, "1 kyr"), (1e5, "100 kyr"), (1e7, "10 Myr"), (1e10, "10 Gyr"))
_POWERS, _LABELLED = (1e32, 1e28, 1e24), 7e-12  # W, and the derivative at which they are written
# Radio emission needs a voltage of the polar cap: B/P^2 above 1.7e11 G/s^2 (Bhattacharya et al. 1992, A&A 254, 198).
_DEATH = 1.7e7  # T s-2


def period_radius_figure(dataset: xr.Dataset) -> Figure:
    """Period along shrinking radius for each case, as studies.spinup.period_against_radius gives it.

    Compact remnants have a panel of their own. Dashed is the period of an orbit at the equator, grey what is faster;
    a cross ends a body that reaches it and can shrink no further.

    >>> from astroinertia.studies.spinup import period_against_radius
    >>> print([axes.get_xlabel() for axes in period_radius_figure(period_against_radius()).axes])
    ['radius (km)', 'radius (km)']
    """
    compact = dataset["radius"].values[:, -1] < _COMPACT
    groups = [(np.flatnonzero(which), title) for which, title in
              ((compact, "To a neutron star"), (~compact, "To a disc, a planet, a star")) if which.any()]  # fmt: skip
    with style.styled():
        figure = style.page("Spin-up at constant angular momentum", (6.6 * len(groups), 6.4))
        panels = figure.subplots(1, len(groups), squeeze=False)[0]
        for axes, (rows, title) in zip(panels, groups, strict=True):
            _period_panel(axes, dataset.isel(case=rows), int(rows[0]))
            axes.set(title=title, xlabel="radius (km)")
        panels[0].set_ylabel("period (s)")
        return figure


def _period_panel(axes: Any, dataset: xr.Dataset, first: int) -> None:
    radius, period = dataset["radius"].values / 1e3, dataset["period"].values
    low, high = radius.min() / 4, radius.max()
    least, most = dataset["kepler_period"].values.min() / 3, period.max() * 20
    line = np.geomspace(low, high * 100, 200)
    kepler = dataset["kepler_period"].values[:, 0] / (radius[:, 0]) ** 1.5
    axes.fill_between(line, least, kepler.min() * line**1.5, color=style.PALE, alpha=0.6, linewidth=0, zorder=0.5)
    for factor in kepler:
        axes.plot(line, factor * line**1.5, color=style.GREY, linewidth=0.8, linestyle=(0, (5, 3)), zorder=1)
    for number in range(dataset.sizes["case"]):
        colour = style.COLOURS[(first + number) % len(style.COLOURS)]
        allowed = ~dataset["beyond_kepler"].values[number]
        x, y, last = radius[number], period[number], int(np.flatnonzero(allowed)[-1])
        stopped = last < len(allowed) - 1
        axes.plot(x[allowed], y[allowed], color=colour, linewidth=2.2, zorder=3)
        axes.plot(x, y, color=colour, linewidth=1.0, linestyle=(0, (1, 1.5)), zorder=2)
        axes.plot(x[0], y[0], color=colour, marker="o", markersize=5, zorder=4)
        axes.plot(x[last], y[last], color=colour, marker="X" if stopped else "v", markersize=8 if stopped else 6,
                  zorder=4)  # fmt: skip
        axes.annotate(
            f"{dataset['case'].values[number]}\n{_period_text(y[0])} to {_period_text(y[last])}", (x[0], y[0]),
            xytext=(0, 7), textcoords="offset points", fontsize=8.5, color=colour, ha="center", va="bottom", zorder=5,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", xlim=(low, high * (high / low) ** 0.15), ylim=(least, most))
    axes.text(0.98, 0.03, "faster than an orbit at the equator", fontsize=9, color=style.GREY, ha="right",
              transform=axes.transAxes)  # fmt: skip


def _period_text(period: float) -> str:
    if _HOUR <= period < 48 * _HOUR:
        return f"{period / _HOUR:.3g} h"
    scale, unit = style.scale_of("s", period)
    return f"{period / scale:.3g} {unit}"


def pulsar_diagram(
    stars: Iterable[Pulsar] | None = None, tracks: Iterable[tuple[str, float, float, float]] = ()
) -> Figure:
    """P against P' of pulsars, with lines of field, age and spin-down luminosity, spin-up line and death line.

    The spin-up line is that of accretion at Eddington's rate from the whole Alfven radius. stars: the package's table
    without it. tracks: (label, P in s, P', braking index) of stars to be followed to where their law leads in a million
    years, and back to a period of 10 ms.

    >>> from astroinertia.rotation.pulsar_table import pulsar
    >>> crab = pulsar("Crab")
    >>> (axes,) = pulsar_diagram(tracks=[("Crab", crab.period, crab.period_derivative, 2.51)]).axes
    >>> print(axes.get_xscale(), axes.get_xlabel(), "Crab" in [text.get_text() for text in axes.texts])
    log period $P$ (s) True
    """
    chosen = observed() if stars is None else tuple(stars)
    with style.styled():
        figure = style.page("Pulsars by period and period derivative", (10.0, 8.0))
        axes = figure.subplots()
        axes.set(xscale="log", yscale="log", xlim=_PERIODS, ylim=_SLOWING)
        axes.grid(False)
        period = np.geomspace(*_PERIODS, 400)
        _lines(axes, period)
        for kind, (marker, colour, words) in _KINDS.items():
            for binary in (False, True):
                some = [star for star in chosen if star.kind == kind and star.binary == binary]
                if some:
                    axes.plot(
                        [star.period for star in some], [star.period_derivative for star in some], linestyle="none",
                        marker=marker, color=colour, markersize=6, zorder=4, markeredgewidth=1.3,
                        markerfacecolor="white" if binary else colour,
                        label=f"{words}, in a binary" if binary else words,
                    )  # fmt: skip
        for star in chosen:
            if star.name in _NAMED:
                axes.annotate(
                    star.name, (star.period, star.period_derivative), xytext=(7, 5), textcoords="offset points",
                    fontsize=8.5, color=style.INK, zorder=6,
                    path_effects=[withStroke(linewidth=2.5, foreground="white")],
                )  # fmt: skip
        for name, start, slowing, index in tracks:
            _track(axes, name, start, slowing, index)
        axes.set(xlabel="period $P$ (s)", ylabel=r"period derivative $\dot P$")
        axes.legend(loc="upper left", fontsize=8.5, ncols=1)
        return figure


def _lines(axes: Any, period: np.ndarray) -> None:
    def write(x: float, y: float, text: str, slope: float, colour: str) -> None:
        if _SLOWING[0] < y < _SLOWING[1]:
            axes.annotate(
                text, (x, y), fontsize=8, color=colour, rotation=_angle(axes, slope), rotation_mode="anchor",
                xytext=(0, 3), textcoords="offset points", va="bottom", zorder=2,
            )  # fmt: skip

    for gauss in _GAUSS:
        slowing = pulsars.dipole_period_derivative(period, 1e-4 * gauss)
        axes.plot(period, slowing, color=style.GREY, linewidth=0.8, linestyle=(0, (5, 3)), zorder=1)
        at = 25.0
        write(at, float(np.interp(at, period, slowing)), f"$10^{{{np.log10(gauss):.0f}}}$ G", -1, style.GREY)
    for years, words in _AGES:
        slowing = period / (2 * years * _YEAR)
        axes.plot(period, slowing, color=style.GREEN, linewidth=0.8, linestyle=(0, (1.5, 2)), zorder=1)
        write(1.15e-3, 1.15e-3 / (2 * years * _YEAR), words, 1, style.GREEN)
    for power in _POWERS:
        slowing = power * period**3 / (4 * np.pi**2 * pulsars.CANONICAL_MOMENT)
        axes.plot(period, slowing, color=style.ORANGE, linewidth=0.8, linestyle=(0, (6, 2, 1, 2)), zorder=1)
        at = min(20.0, (_LABELLED / power * 4 * np.pi**2 * pulsars.CANONICAL_MOMENT) ** (1 / 3))
        write(at, float(np.interp(at, period, slowing)), f"$10^{{{np.log10(power):.0f}}}$ W", 3, style.ORANGE)
    line = accretion.spin_up_line(period, coefficient=1.0)
    axes.plot(period, line, color=style.VERMILLION, linewidth=1.2, zorder=1)
    at = 0.06
    write(at, float(np.interp(at, period, line)), "spin-up line", 4 / 3, style.VERMILLION)
    death = pulsars.dipole_period_derivative(period, _DEATH * period**2)
    axes.fill_between(period, _SLOWING[0], death, color=style.PALE, alpha=0.6, linewidth=0, zorder=0.3)
    write(0.35, float(np.interp(0.35, period, death)) / 12, "few radio pulses", 3, style.GREY)


def _angle(axes: Any, slope: float) -> float:
    """The angle on the page, in degrees, of a line of that slope in the logarithms."""
    box = axes.get_position()
    width, height = axes.figure.get_size_inches()
    decades = np.log10(_SLOWING[1] / _SLOWING[0]), np.log10(_PERIODS[1] / _PERIODS[0])
    return float(np.degrees(np.arctan(slope * box.height * height / decades[0] * decades[1] / (box.width * width))))


def _track(axes: Any, name: str, period: float, slowing: float, index: float) -> None:
    born = pulsars.true_age(period, slowing, 0.01, index)
    times = np.concatenate([-np.geomspace(born, 1.0, 200), np.geomspace(1.0, 1e6 * _YEAR, 200)])
    x = pulsars.period_history(times, period, slowing, index)
    y = pulsars.period_derivative_history(times, period, slowing, index)
    axes.plot(x, y, color=style.INK, linewidth=1.5, zorder=3)
    axes.annotate(
        f"{name}, n = {index:g}", (x[-1], y[-1]), xytext=(6, 0), textcoords="offset points", fontsize=8.5,
        color=style.INK, path_effects=[withStroke(linewidth=2.5, foreground="white")], zorder=6,
    )  # fmt: skip
    for years in (1e3, 1e4, 1e5, 1e6):
        after = pulsars.period_history(years * _YEAR, period, slowing, index)
        axes.plot(after, pulsars.period_derivative_history(years * _YEAR, period, slowing, index), marker="|",
                  color=style.INK, markersize=8, zorder=3)  # fmt: skip
