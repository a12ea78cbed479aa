"""Tops in closed form: polhode, herpolhode and rates of a free one; where the axis of a heavy one goes."""

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from astroinertia.inertia.principal import EQUAL_MOMENTS
from astroinertia.plots import style
from astroinertia.plots.ellipsoid import AXES, LEAST_MOMENT, draw_curves, draw_inertia_ellipsoid, view_of
from astroinertia.rotation import heavy_top as heavy
from astroinertia.rotation.free_top import FreeTop, angular_velocity, free_top, period
from astroinertia.rotation.heavy_top import HeavyTop
from astroinertia.rotation.polhodes import herpolhode, herpolhode_radii, polhode

_PERIODS, _POINTS = 8, 6001  # of the wobble that a herpolhode is drawn for
_NUTATIONS = 5


def free_top_figure(top: FreeTop, name: str = "") -> Figure:
    """The polhode on the inertia ellipsoid, the herpolhode on its plane and the rates in the body, of a free top.

    >>> from astroinertia.rotation.free_top import free_top
    >>> figure = free_top_figure(free_top([1.0, 2.0, 3.0], [0.1, 1.0, 0.1]), "racket")
    >>> print(figure.axes[2].get_title(loc="left"))
    Rates in the body: period 22.9963
    """
    with style.styled():
        figure = style.page(f"{name}: free rotation" if name else "free rotation", (14.0, 5.4))
        on_ellipsoid, on_plane, rates = figure.subplots(1, 3, width_ratios=(1.0, 0.95, 1.1))
        _on_ellipsoid(on_ellipsoid, top)
        _on_plane(on_plane, top)
        _rates(rates, top)
        return figure


def heavy_top_figure(tops: Mapping[str, HeavyTop], name: str = "") -> Figure:
    """The paths of the axes of heavy tops, each with its name, seen from above, between their least and greatest tilt.

    The distance from the middle is twice the sine of half the tilt, so that equal areas of the sphere look equal.

    >>> from astroinertia.rotation.heavy_top import heavy_top
    >>> (axes,) = heavy_top_figure({"let go": heavy_top(1.0, 0.6, 0.8, 0.7, (0.0, 0.0, 5.0))}).axes
    >>> print(axes.texts[0].get_text().splitlines()[0])  # 0.7 rad and below
    tilt 40.11 to 48.25 deg
    """
    with style.styled():
        figure = style.page(f"{name}: heavy tops" if name else "heavy tops", (4.6 * len(tops), 5.2))
        panels = figure.subplots(1, len(tops), squeeze=False)[0]
        for panel, (title, top) in zip(panels, tops.items(), strict=True):
            _axis_path(panel, title, top)
        return figure


def _span(top: FreeTop) -> np.ndarray:
    """Times of a few periods; where there is none, of a few turns or from one end of the separatrix to the other."""
    once = period(top)
    if math.isfinite(once):
        return np.linspace(0.0, _PERIODS * once, _POINTS)
    if top.motion == "separatrix":
        return np.linspace(-12.0, 12.0, _POINTS) / float(top.argument_rate)
    size = math.sqrt(sum(float(rate) ** 2 for rate in top.start)) or 1.0
    return np.linspace(0.0, 2.0 * np.pi * _PERIODS / size, _POINTS)


def _on_ellipsoid(panel, top: FreeTop) -> None:
    order = np.argsort(top.moments, kind="stable")
    frame = np.eye(3)[order]
    moments = np.maximum(top.moments[order], LEAST_MOMENT * top.moments.max())
    gaps = np.diff(moments) > EQUAL_MOMENTS * moments[2]
    defined = np.array([gaps[0], gaps.all(), gaps[1]])
    frame[1] *= round(float(np.linalg.det(frame)))
    view = view_of(frame)
    reach = draw_inertia_ellipsoid(panel, moments, frame, defined, view)
    rates = np.array([float(rate) for rate in top.start])
    if rates.any():
        # a thin rod is drawn thicker than it is, and so is its motion
        drawn = top if (moments == top.moments[order]).all() else free_top((moments @ abs(frame)).tolist(), top.start)
        path = polhode(drawn, 721) / math.sqrt(2.0 * drawn.energy)
        draw_curves(panel, path[None], moments, frame, view, reach, style.PURPLE, 2.6)
        begin = view @ (rates / math.sqrt(2.0 * drawn.energy)) / reach
        if begin[2] > 0:
            panel.plot(*begin[:2], "o", color=style.PURPLE, markersize=6, zorder=8)
    panel.set(xticks=[], yticks=[], title=r"Polhode: the tip of $\omega$ in the body")


def _on_plane(panel, top: FreeTop) -> None:
    momentum = np.array([float(rate) for rate in top.start]) * top.moments
    size = np.linalg.norm(momentum)
    upwards = momentum / size if size else np.array([0.0, 0.0, 1.0])
    across = np.cross(upwards, np.eye(3)[np.argmin(abs(upwards))])
    across /= np.linalg.norm(across)
    start = np.stack([across, np.cross(upwards, across), upwards], axis=-1)  # inertial axes with L upwards
    curve = herpolhode(top, _span(top), start)
    panel.plot(curve[:, 0], curve[:, 1], color=style.PURPLE, linewidth=1.1)
    panel.plot(*herpolhode(top, 0.0, start)[:2], "o", color=style.PURPLE, markersize=6)
    panel.plot(0, 0, "+", color=style.INK, markersize=9)
    radii = herpolhode_radii(top)
    turn = np.linspace(0, 2 * np.pi, 361)
    for radius in radii:
        panel.plot(radius * np.cos(turn), radius * np.sin(turn), color=style.GREY, linewidth=0.8, linestyle="--")
    most = 1.12 * radii[1] or 1.0
    panel.set(xlim=(-most, most), ylim=(-most, most), aspect="equal", xlabel=r"$\omega_x$ (rad per time)")
    panel.set_ylabel(r"$\omega_y$ (rad per time)")
    span = f"{_PERIODS} periods" if math.isfinite(period(top)) else "the whole motion"
    panel.set_title(f"Herpolhode, from above L: {span}")


def _rates(panel, top: FreeTop) -> None:
    once = period(top)
    times = _span(top)
    if math.isfinite(once):
        times = np.linspace(0.0, 2.0 * once, _POINTS)
    rates = angular_velocity(top, times)
    for rank, k in enumerate(np.argsort(top.moments, kind="stable")):
        panel.plot(times, rates[:, k], color=AXES[rank], label=f"axis {rank + 1}, $I$ = {top.moments[k]:.4g}")
    panel.axhline(0, color=style.GREY, linewidth=0.8)
    panel.set(xlim=(times[0], times[-1]), xlabel="time", ylabel="rad per time")
    style.legend(panel, room=0.2, loc="upper left", columnspacing=0.9, handlelength=1.2)
    motion_text = {"steady": "steady", "separatrix": "separatrix"}.get(top.motion)
    panel.set_title(f"Rates in the body: {motion_text or f'period {once:.6g}'}")


def _axis_path(panel, title: str, top: HeavyTop) -> None:
    once = heavy.nutation_period(top)
    span = _NUTATIONS * once if math.isfinite(once) else 24.0 / float(top.argument_rate)
    axis = heavy.attitude(top, np.linspace(0.0, span, _POINTS))[:, 2]
    out = np.sqrt(2.0 / np.maximum(1.0 + axis[:, 2], 1e-12))[:, None]
    path = axis[:, :2] * out
    low, high = heavy.tilt_range(top)
    turn = np.linspace(0, 2 * np.pi, 361)
    for limit in (low, high):
        radius = 2.0 * math.sin(0.5 * limit)
        panel.plot(radius * np.cos(turn), radius * np.sin(turn), color=style.GREY, linewidth=0.9, linestyle="--")
    panel.plot(*path.T, color=style.BLUE, linewidth=1.6)
    panel.plot(*path[0], "o", color=style.BLUE, markersize=6)
    panel.plot(0, 0, "+", color=style.INK, markersize=9)
    most = 1.12 * 2.0 * math.sin(0.5 * high) or 1.0
    panel.set(xlim=(-most, most), ylim=(-1.35 * most, most), aspect="equal", xticks=[], yticks=[])
    panel.grid(False)
    for side in panel.spines.values():
        side.set_visible(False)
    panel.set_title(title)
    panel.text(
        0.0, -1.33 * most,
        f"tilt {math.degrees(low):.4g} to {math.degrees(high):.4g} deg\n"
        f"nutation every {once:.4g}, precession {heavy.precession_rate(top):.4g} rad per time",
        ha="center", va="bottom", fontsize=9, color=style.GREY,
    )  # fmt: skip
