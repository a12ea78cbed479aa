"""The shape: semi-axes of the equivalent ellipsoid, their ratios, and the ellipsoid itself through time."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.inertia.tensor import equivalent_semi_axes, second_moment_from_inertia
from astroinertia.plots import style

OUTLINES = 9
ROUND = 1e-9  # departure, in the same, below which a body is a sphere
LARGEST_DEPARTURE = 0.45  # of an enlarged outline from the sphere, in the logarithm of an axis
_NAMES = ("$a$, longest", "$b$", "$c$, shortest")
_CIRCLE = np.stack([np.cos(np.linspace(0, 2 * np.pi, 181)), np.sin(np.linspace(0, 2 * np.pi, 181))])


@with_absent
def shape_figure(dataset: xr.Dataset) -> Figure:
    """Semi-axes and their ratios against time; outlines of the inertia ellipsoid seen along z and along y.

    >>> print([axes.get_ylabel().split(" (")[0] for axes in shape_figure(ds).axes[:2]])
    ['semi-axis', 'ratio of semi-axes']
    """
    with style.styled():
        figure = style.begin(dataset, "shape", (10.0, 8.8))
        grid = figure.add_gridspec(2, 2, height_ratios=[1, 1.25])
        semi_axes = figure.add_subplot(grid[0, 0])
        ratios = figure.add_subplot(grid[0, 1])
        _semi_axes(semi_axes, ratios, dataset)
        for axes in (semi_axes, ratios):
            style.time_axis(axes, dataset)
        views = [figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])]
        _outlines(figure, views, dataset)
        return figure


def _semi_axes(left, right, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    moments = dataset["principal_moments"].transpose("time", "principal").values
    lengths = equivalent_semi_axes(dataset["mass"].values, moments)
    scale, unit = style.scale_of(style.unit_of(dataset["mean_radius"]), lengths)
    # The longest first, whatever their numbers; where two are equal, which is which means nothing.
    lengths = -np.sort(-lengths, axis=1)
    colours = (style.VERMILLION, style.ORANGE, style.BLUE)
    for k, (name, colour, dashes) in enumerate(zip(_NAMES, colours, style.DASHES, strict=True)):
        left.plot(times, lengths[:, k] / scale, color=colour, linestyle=dashes, label=name)
    style.from_zero_or_log(left, lengths, scale)
    left.set(ylabel=style.label("semi-axis", unit), title="Semi-axes of the equivalent ellipsoid")
    style.legend(left)
    for k, name, colour in ((1, "b/a", style.ORANGE), (2, "c/a", style.BLUE)):
        ratio = lengths[:, k] / lengths[:, 0]
        right.plot(times, ratio, color=colour, linestyle=style.DASHES[k], label=f"${name}$")
    right.axhline(1, color=style.GREY, linewidth=0.8)
    low = right.get_ylim()[0]
    right.set_ylim(min(low, 0.9), 1.0 + 0.05 * (1.0 - min(low, 0.9)))
    gap = dataset["principal_gap"]
    tolerance = float(gap.attrs.get("tolerance", 0.0))
    vague = (gap.transpose("time", "principal").values < tolerance).any(axis=1)
    if vague.any():
        right.fill_between(
            times, 0, 1, where=vague, transform=right.get_xaxis_transform(), color=style.PALE, alpha=0.45,
            linewidth=0, label="two axes equal", zorder=0.4,
        )  # fmt: skip
    right.set(ylabel="ratio of semi-axes", title="Axis ratios")
    style.legend(right)
    for axes in (left, right):
        style.mark_compression(axes, dataset, factor, named=axes is left)


def _outlines(figure: Figure, views: list, dataset: xr.Dataset) -> None:
    chosen = style.picked_times(dataset, OUTLINES)
    colours = style.time_colours(dataset).to_rgba(style.shown_times(dataset)[0])
    inertia = dataset["inertia_tensor"].transpose("time", "i", "j").values
    shapes = 5.0 * second_moment_from_inertia(inertia) / dataset["mass"].values[:, None, None]
    larger = _enlargement(shapes[chosen])
    reach = 0.0
    for axes, (first, second), title in zip(views, ((0, 1), (0, 2)), ("seen along z", "seen along y"), strict=True):
        axes.plot(*_CIRCLE, color=style.GREY, linewidth=0.9, linestyle=(0, (3, 3)), zorder=1)
        for index in chosen:
            size = float(dataset["mean_radius"][index])
            if not (np.isfinite(shapes[index]).all() and size > 0):
                continue
            # The shadow of an ellipsoid x.S^-1.x = 1 on a plane is that of the block of S in the plane.
            enlarged = _power(shapes[index] / size**2, larger)[np.ix_([first, second], [first, second])]
            outline = _power(enlarged, 0.5) @ _CIRCLE
            reach = max(reach, float(abs(outline).max()))
            axes.plot(*outline, color=colours[index], linewidth=1.8)
        axes.set(aspect="equal", xlabel="$" + "xyz"[first] + r"\,/\,$mean radius")
        axes.set(ylabel="$" + "xyz"[second] + r"\,/\,$mean radius", title=f"Its outline {title}")
    for axes in views:
        axes.set(xlim=(-1.08 * max(reach, 1), 1.08 * max(reach, 1)), ylim=(-1.08 * max(reach, 1), 1.08 * max(reach, 1)))
        axes.locator_params(nbins=6)
    if larger > 1:
        views[1].annotate(
            f"departures from the sphere\nenlarged {larger:g} times", (0.5, 0.5), xycoords="axes fraction",
            ha="center", va="center", fontsize=8, color=style.GREY,
        )  # fmt: skip
    style.time_bar(figure, views, dataset, chosen, shrink=0.8, pad=0.02)


def _enlargement(shapes: np.ndarray) -> float:
    # Ratios of the axes of a nearly round body are drawn to a power, which multiplies small departures from 1.
    values = np.maximum(np.linalg.eigvalsh(shapes[np.isfinite(shapes).all((1, 2))]), 1e-300)
    departure = float(np.max(abs(0.5 * np.log(values / values.prod(1, keepdims=True) ** (1 / 3))), initial=0.0))
    if departure < ROUND:  # nothing to enlarge
        return 1.0
    return next((factor for factor in (50.0, 20.0, 10.0, 5.0, 2.0) if factor * departure < LARGEST_DEPARTURE), 1.0)


def _power(matrix: np.ndarray, exponent: float) -> np.ndarray:
    values, vectors = np.linalg.eigh(matrix)
    return vectors * np.maximum(values, 0.0) ** exponent @ vectors.T
