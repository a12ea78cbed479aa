"""Moment ratio against central condensation: the polytropes' curve, what no body can be, and the solar system."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.bodies.planets import OWN
from astroinertia.plots import style

MARKED_INDICES = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)
STATUS_COLOURS = {
    "measured": style.BLUE, "hydrostatic": style.GREEN, "model": style.ORANGE, OWN: style.PURPLE,
}  # fmt: skip
STATUS_WORDS = {
    "measured": "ratio measured",
    "hydrostatic": "from gravity, if hydrostatic",
    "model": "model, not measured",
    OWN: "your own",
}
CONDENSATION_MARKERS = {"published": "o", "two layers": "s", "polytrope": "D"}
CONDENSATION_WORDS = {
    "published": "central density from seismology or a solar model",
    "two layers": "central density of the inversion to uniform layers",
    "polytrope": "put on the curve: central density unknown",
}
_NEAR = (0.93, 2.75, 0.298, 0.412)  # limits of the panel of solid bodies
_DISTANCES, _DIRECTIONS = (11.0, 17.0, 26.0, 37.0), 16  # where a label may stand, in points and around the clock


def moment_ratio_figure(bodies: xr.Dataset, polytropes: xr.Dataset) -> Figure:
    """I/(M R^2) of mean moment and mean radius against rho_c over the mean density, whole and for the solid bodies.

    bodies: as studies.moment_ratio.moment_ratio gives it; polytropes: as studies.moment_ratio.polytropes does.

    >>> from astroinertia.studies.moment_ratio import moment_ratio, polytropes
    >>> figure = moment_ratio_figure(moment_ratio(), polytropes())
    >>> print("Mars" in "".join(text.get_text() for axes in figure.axes for text in axes.texts))
    True
    """
    plotted = bodies.where(np.isfinite(bodies["central_condensation"]) & np.isfinite(bodies["moment_ratio"]), drop=True)
    with style.styled():
        figure = style.page("How centrally condensed are stars, planets and moons?", (12.4, 6.6))
        left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.25])
        for panel in (left, right):
            _curve(panel, polytropes)
            _points(panel, plotted)
            panel.set_xlabel(r"central condensation $\rho_c/\bar\rho$")
        left.set(ylabel=r"moment ratio $I/(MR^2)$, mean moment and mean radius", xlim=(0.93, 240), ylim=(0.0, 0.43))
        left.set_xscale("log")
        style.plain_log(left.xaxis, 1.0, 240.0)
        left.set_title("All")
        right.set(title="Solid bodies", xlim=_NEAR[:2], ylim=_NEAR[2:])
        low, high, bottom, top = _NEAR
        left.add_patch(_frame(low, bottom, high - low, top - bottom))
        left.text(high * 1.04, top - 0.016, "on the right", fontsize=8, color=style.GREY, va="top")
        left.text(26, 0.118, "polytropes", fontsize=9.5, color=style.INK, rotation=-28)
        left.text(
            1.12, 0.115, "impossible:\nless than a bare\nsphere as dense\nas the centre", fontsize=8.5, color=style.GREY
        )
        right.text(
            0.958, 0.31, "denser outside than at the centre", fontsize=8.5, color=style.GREY, rotation=90, ha="center"
        )
        for handles, place in ((_status_handles(plotted), "lower left"), (_marker_handles(plotted), "upper right")):
            (left if place == "lower left" else right).legend(handles=handles, loc=place)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # the layout is settled before labels are put beside points
        inside = _inside(plotted, _NEAR)
        _labels(canvas, left, plotted.isel(body=~inside), polytropes, _index_labels(left, polytropes))
        _labels(canvas, right, plotted.isel(body=inside), polytropes, _index_labels(right, polytropes))
        return figure


def _frame(x: float, y: float, width: float, height: float) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x, y), width, height, fill=False, edgecolor=style.GREY, linewidth=0.8, linestyle=(0, (3, 2)))


def _curve(panel, polytropes: xr.Dataset) -> None:
    panel.plot(*_dense_curve(polytropes).T, color=style.INK, linewidth=1.6, zorder=2)
    panel.axhline(UNIFORM, color=style.GREY, linewidth=0.8, linestyle=(0, (2, 2)), zorder=1)
    # All mass in a sphere of the central density, nothing around it: no density that falls outwards has less.
    x = np.geomspace(1.0, 300.0, 400)
    panel.fill_between(x, 0.0, UNIFORM * x ** (-2 / 3), color=style.PALE, alpha=0.55, linewidth=0, zorder=0.5)
    panel.axvspan(0.5, 1.0, color=style.PALE, alpha=0.55, linewidth=0, zorder=0.5)


def _dense_curve(polytropes: xr.Dataset) -> np.ndarray:
    fine = polytropes.interp(index=np.linspace(0, float(polytropes["index"][-1]), 900), method="cubic")
    return np.stack([fine["central_condensation"].values, fine["moment_ratio"].values], axis=-1)


def _points(panel, bodies: xr.Dataset) -> None:
    for one in (bodies.isel(body=k) for k in range(bodies.sizes["body"])):
        colour = STATUS_COLOURS[str(one["status"].values)]
        source = str(one["central_condensation_source"].values)
        panel.errorbar(
            float(one["central_condensation"]),
            float(one["moment_ratio"]),
            xerr=_size(one, "central_condensation"),
            yerr=_size(one, "moment_ratio"),
            color=colour,
            marker=CONDENSATION_MARKERS[source],
            markerfacecolor="white" if source == "polytrope" else colour,
            markersize=6.5,
            markeredgewidth=1.5,
            elinewidth=1.1,
            capsize=0,
            zorder=4,
        )


def _size(one: xr.Dataset, name: str) -> float:
    value = float(one[f"{name}_uncertainty"])
    return value if np.isfinite(value) else 0.0


def _inside(bodies: xr.Dataset, limits) -> np.ndarray:
    x, y = bodies["central_condensation"].values, bodies["moment_ratio"].values
    return (x > limits[0]) & (x < limits[1]) & (y > limits[2]) & (y < limits[3])


def _status_handles(bodies: xr.Dataset) -> list[Any]:
    from matplotlib.lines import Line2D

    present = set(bodies["status"].values.tolist())
    return [
        Line2D([], [], color=colour, marker="o", linestyle="none", markersize=6.5, label=STATUS_WORDS[status])
        for status, colour in STATUS_COLOURS.items()
        if status in present
    ]


def _marker_handles(bodies: xr.Dataset) -> list[Any]:
    from matplotlib.lines import Line2D

    present = set(bodies["central_condensation_source"].values.tolist())
    return [
        Line2D([], [], color=style.GREY, marker=marker, linestyle="none", markersize=6.5, markeredgewidth=1.5,
               markerfacecolor="white" if source == "polytrope" else style.GREY, label=CONDENSATION_WORDS[source])
        for source, marker in CONDENSATION_MARKERS.items()
        if source in present
    ]  # fmt: skip


def _index_labels(panel, polytropes: xr.Dataset) -> list[Any]:
    """Ticks along the curve with the polytropic index."""
    written = []
    x_low, x_high = panel.get_xlim()
    y_low, y_high = panel.get_ylim()
    for index in MARKED_INDICES:
        one = polytropes.interp(index=index, method="cubic")
        x, y = float(one["central_condensation"]), float(one["moment_ratio"])
        if not (x_low < x < x_high and y_low < y < y_high):
            continue
        panel.plot(x, y, marker="|", color=style.INK, markersize=9, markeredgewidth=1.4, zorder=3)
        written.append(
            panel.annotate(
                f"$n$ = {index:g}" if index in (0.0, 3.0) else f"{index:g}",
                (x, y), xytext=(5, 3) if index == 0 else (-3, -5), textcoords="offset points", fontsize=8,
                color=style.INK, ha="left" if index == 0 else "right", va="bottom" if index == 0 else "top",
            )
        )  # fmt: skip
    return written


def _labels(canvas: FigureCanvasAgg, panel, bodies: xr.Dataset, polytropes: xr.Dataset, taken: list[Any]) -> None:
    """Write the names where they cover neither each other nor points, error bars, the curve or its ticks."""
    if not bodies.sizes["body"]:
        return
    renderer, scale = canvas.get_renderer(), canvas.figure.dpi / 72
    obstacles = [panel.transData.transform(_dense_curve(polytropes))]
    x, y = bodies["central_condensation"].values, bodies["moment_ratio"].values
    for across, up in zip(x, y, strict=True):
        obstacles.append(panel.transData.transform([[across, up]]))
    for name, axis in (("central_condensation", 0), ("moment_ratio", 1)):
        error = np.nan_to_num(bodies[f"{name}_uncertainty"].values)
        for share in np.linspace(-1, 1, 15):
            moved = np.stack([x, y], axis=-1)
            moved[:, axis] += share * error
            obstacles.append(panel.transData.transform(moved))
    spots = np.concatenate(obstacles)
    boxes = [artist.get_window_extent(renderer) for artist in taken]
    legend = panel.get_legend()
    if legend is not None:
        boxes.append(legend.get_window_extent(renderer))
    frame = panel.get_window_extent(renderer)
    points = panel.transData.transform(np.stack([x, y], axis=-1))
    between = np.hypot(*(points[:, None] - points).T) + 1e9 * np.eye(len(points))
    for k in np.argsort(between.min(axis=0)):  # the most crowded first
        text = panel.annotate(
            str(bodies["body"].values[k]), (x[k], y[k]), xytext=(0, 0), textcoords="offset points", fontsize=9,
            ha="center", va="center", zorder=6, color=style.INK,
            path_effects=[withStroke(linewidth=2.2, foreground="white")],
        )  # fmt: skip
        box = text.get_window_extent(renderer)
        best = None
        for distance in _DISTANCES:
            for turn in np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS:
                shift = np.array([np.cos(turn), np.sin(turn)])
                reach = distance * scale * shift + 0.5 * np.array([box.width, box.height]) * np.sign(shift) * (
                    np.abs(shift) > 0.3
                )
                moved = box.translated(*reach).padded(1.5 * scale)
                cost = distance + 60 * sum(_shared(moved, other) for other in boxes)
                cost += 25 * int(((spots > [moved.x0, moved.y0]) & (spots < [moved.x1, moved.y1])).all(axis=1).sum())
                outside = moved.x0 < frame.x0 or moved.x1 > frame.x1 or moved.y0 < frame.y0 or moved.y1 > frame.y1
                middle = np.array([moved.x0 + moved.x1, moved.y0 + moved.y1]) / 2
                away = np.hypot(*((points - middle) / [box.width / 2 + 1, box.height]).T)
                cost += 1000 * outside + 60 * int(np.argmin(away) != k)
                if best is None or cost < best[0]:
                    best = (cost, reach / scale, moved)
        assert best is not None
        text.set_position(best[1])
        boxes.append(best[2])
        gap = np.maximum(np.abs(best[1]) - 0.5 * np.array([box.width, box.height]) / scale, 0)
        if np.hypot(*gap) > 12:  # far enough to be taken for another point's
            end = np.sign(best[1]) * gap
            line = {"arrowstyle": "-", "color": style.GREY, "linewidth": 0.7, "shrinkB": 4}
            panel.annotate("", (x[k], y[k]), xytext=end, textcoords="offset points", zorder=3, arrowprops=line)


def _shared(one, other) -> bool:
    return one.x0 < other.x1 and other.x0 < one.x1 and one.y0 < other.y1 and other.y0 < one.y1
