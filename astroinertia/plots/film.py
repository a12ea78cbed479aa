"""The frames of a film: the body side-on and pole-on with its principal axes, and what I and the spin do meanwhile."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from astroinertia.plots import style
from astroinertia.plots.axis_scales import angular_momentum_scale, has_values
from astroinertia.plots.density import column_unit, draw_density, frame_view, name_view, scale_of_colours
from astroinertia.plots.ellipsoid import BODY_COLOUR, lit_ellipsoid
from astroinertia.plots.matter import (
    POLE_ON,
    SIDE_ON,
    Matter,
    completed,
    draw_sinks,
    draw_triad,
    matter,
    reach,
    triads,
    triads_of_series,
)
from astroinertia.plots.render import column_density

VIEWS = ((SIDE_ON, "side-on"), (POLE_ON, "pole-on"))
MOST_FRAMES = 240  # of a film without particles, whose outputs may be many thousands
SAMPLED = 9  # frames that the scale of colours is found from
FOLLOWS_FROM = 4.0  # ratio of the largest to the smallest extent from which on the camera follows
SMOOTHED = 5  # frames that the camera's distance is smoothed over
MARGIN = 1.35  # half the width of a picture over the longest semi-axis
LEAST_THICKNESS = 0.01  # of the longest semi-axis, so that a disc or rod is seen
LOG_FROM = 30.0  # ratio of the largest to the smallest value from which on a strip is logarithmic
STEADY = 0.01  # of its size: a series that changes by less
_MOST_DIGITS = 5  # of a time
_MISSED = 0.02  # of the time between frames, by which a time that is shown may be off
_SIZE = (9.6, 6.8)  # inches
_PIXELS = 260
_EYE = {SIDE_ON: np.eye(3)[[0, 2, 1]] * [[1], [1], [-1]], POLE_ON: np.eye(3)}  # rightwards, upwards, towards the eye


@dataclass(frozen=True)
class _Subject:
    """What is filmed: times (T,), extents (T,), and how one frame of one view is painted into a panel."""

    times: np.ndarray
    extents: np.ndarray
    unit: str
    paint: Callable[[Any, int, tuple[int, int], float, float], None]
    colours: tuple[LogNorm, str] | None = None
    note: str = ""


def chosen(dataset: xr.Dataset, snapshots: xr.Dataset | None, every: int | None = None) -> np.ndarray:
    """Numbers of the snapshots, or of the outputs of a model without particles, that a film shows.

    Every one, or every so many; of outputs at most MOST_FRAMES where it is not said.
    """
    count = dataset.sizes["time"] if snapshots is None else snapshots.sizes["snapshot_time"]
    if every is None and snapshots is None and count > MOST_FRAMES:
        return np.linspace(0, count - 1, MOST_FRAMES).round().astype(int)
    return np.arange(0, count, every or 1)


def frames(
    dataset: xr.Dataset, snapshots: xr.Dataset | None, numbers: np.ndarray, dpi: int = 100
) -> Iterator[np.ndarray]:
    """Pictures (height, width, 3) in bytes, all of one size, with one scale of colours and one frame of axes.

    numbers: as `chosen` gives them. ArchiveError for a body that has no shape. Tests: tests/unit/plots/test_film.py.
    """
    subject = _ellipsoid(dataset, numbers) if snapshots is None else _fluid(completed(dataset, snapshots), numbers)
    widths = camera(subject.extents)
    length, length_unit = style.scale_of(subject.unit, widths)
    with style.styled():
        figure = Figure(figsize=_SIZE, dpi=dpi)
        canvas = FigureCanvasAgg(figure)
        panels = _pages(figure, dataset, subject, length_unit)
        stamp = figure.text(0.98, 0.985, "", va="top", ha="right", fontsize=13, color=style.INK, animated=True)
        marks = _strips(figure, dataset)
        shown, factor, unit = _clock(subject, dataset)
    ground: Any = None
    for k, width in enumerate(widths / length):
        with style.styled():
            if k == 0 or width != widths[k - 1] / length:  # axes with their numbers are drawn only when they change
                for panel in panels:
                    panel.set(xlim=(-width, width), ylim=(-width, width))
                canvas.draw()
                ground = canvas.copy_from_bbox(figure.bbox)
            canvas.restore_region(ground)
            for panel, (plane, name) in zip(panels, VIEWS, strict=True):
                subject.paint(panel, k, plane, widths[k], length)
                name_view(panel, name)
                _draw_and_forget(panel)
            stamp.set_text(f"t = {shown[k]} {style.raised(unit)}".removesuffix(" 1"))
            figure.draw_artist(stamp)
            for mark in marks:
                mark(subject.times[k] / factor)
            yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _draw_and_forget(panel: Any) -> None:
    """Draw what was painted into a panel, and its frame, on the ground that is there already."""
    painted = sorted([*panel.images, *panel.lines, *panel.texts], key=lambda artist: artist.get_zorder())
    for artist in [*painted, *panel.spines.values()]:
        panel.draw_artist(artist)
    for artist in painted:
        artist.remove()


def _fluid(snapshots: xr.Dataset, numbers: np.ndarray) -> _Subject:
    def at(k: int) -> Matter:
        return matter(snapshots.isel(snapshot_time=int(numbers[k])).load())

    # One at a time: all snapshots together may be larger than memory.
    frames = range(len(numbers))
    axes, extents = triads(at(k) for k in frames), np.array([reach(at(k)) for k in frames])
    widths = camera(extents)
    densest = int(np.argmax([snapshots["density"].isel(snapshot_time=int(number)).max() for number in numbers]))
    sampled = {densest, *np.linspace(0, len(numbers) - 1, SAMPLED).round().astype(int).tolist()}
    norm = scale_of_colours([_column(at(k), plane, float(widths[k])) for k in sorted(sampled) for plane, _ in VIEWS])

    def paint(panel, k, plane, width, length) -> None:
        particles = at(k)
        draw_density(panel, _column(particles, plane, width), norm, width / length)
        draw_triad(panel, axes[k], plane, length, width)
        draw_sinks(panel, particles.sinks, plane, length)

    label = style.label("column density", column_unit(snapshots["density"]))
    times = snapshots["snapshot_time"].values[numbers]
    return _Subject(times, extents, style.unit_of(snapshots["position"]), paint, (norm, label))


def _column(particles: Matter, plane: tuple[int, int], width: float) -> np.ndarray:
    seen = particles.repeated(plane)
    return column_density(seen.position, seen.mass, seen.size, plane, width, _PIXELS)


def _ellipsoid(dataset: xr.Dataset, numbers: np.ndarray) -> _Subject:
    axes = triads_of_series(dataset, numbers)
    extents = np.array([MARGIN * triad.lengths.max() for triad in axes])

    def paint(panel, k, plane, width, length) -> None:
        triad = axes[k]
        thick = np.maximum(triad.lengths, LEAST_THICKNESS * triad.lengths.max())
        image, half = lit_ellipsoid(thick / length, triad.axes, _EYE[plane], BODY_COLOUR, _PIXELS)
        panel.imshow(image, extent=(-half, half, -half, half), origin="lower", interpolation="bilinear", zorder=2)
        draw_triad(panel, triad, plane, length, width)

    note = "drawn as the homogeneous ellipsoid that has its inertia tensor"
    return _Subject(dataset["time"].values[numbers], extents, style.unit_of(dataset["mean_radius"]), paint, note=note)


def camera(extents: np.ndarray) -> np.ndarray:
    """Half the width of every frame: one for the whole film, or one that follows a body that changes by much."""
    if extents.max() <= FOLLOWS_FROM * extents.min():
        return np.full(len(extents), extents.max())
    padded = np.pad(np.log(extents), SMOOTHED // 2, mode="edge")
    return np.exp(np.convolve(padded, np.full(SMOOTHED, 1.0 / SMOOTHED), mode="valid"))


def _pages(figure: Figure, dataset: xr.Dataset, subject: _Subject, unit: str) -> list[Any]:
    name = str(dataset.attrs.get("name", "")).replace("_", " ")
    figure.text(0.02, 0.985, name, va="top", fontsize=13, fontweight="bold", color=style.INK, parse_math=False)
    right = 0.87 if subject.colours else 0.98
    grid = figure.add_gridspec(1, 2, left=0.09, right=right, top=0.92, bottom=0.38, wspace=0.28)
    if subject.colours:
        norm, label = subject.colours
        place = figure.add_axes((0.905, 0.38, 0.016, 0.54))
        bar = figure.colorbar(ScalarMappable(norm, style.DENSITY_MAP), cax=place)
        bar.set_label(label)
        bar.outline.set_visible(False)
    if subject.note:
        figure.text(0.09, 0.305, subject.note, fontsize=8.5, color=style.GREY, va="top")
    panels = [figure.add_subplot(cell, facecolor="black", aspect="equal", autoscale_on=False) for cell in grid]
    for panel, (plane, _) in zip(panels, VIEWS, strict=True):
        frame_view(panel, plane, unit)
    return panels


def _strips(figure: Figure, dataset: xr.Dataset) -> list[Callable[[float], None]]:
    """Draw the series below the pictures; what draws the mark on each at a time in the unit of the axis."""
    series = [(dataset.inertia.about_axis("z"), "$I_{zz}$", style.BLUE)]
    if angular_momentum_scale(dataset)[1]:
        series.append((dataset.inertia.spin_rate(), "mean spin", style.VERMILLION))
    elif has_values(dataset, "density_max"):
        series.append((dataset["density_max"], "maximum density", style.VERMILLION))
    grid = figure.add_gridspec(1, len(series), left=0.09, right=0.98, top=0.26, bottom=0.085, wspace=0.28)
    return [_strip(figure.add_subplot(grid[0, column]), dataset, *curve) for column, curve in enumerate(series)]


def _strip(axes, dataset: xr.Dataset, series: xr.DataArray, name: str, colour: str) -> Callable[[float], None]:
    times, _, _ = style.shown_times(dataset)
    scale, unit = style.scale_of(style.unit_of(series), series.values)
    values = series.values / scale
    axes.plot(times, values, color=style.PALE, linewidth=1.7)
    (past,) = axes.plot([], [], color=colour, linewidth=1.9, animated=True)
    (now,) = axes.plot([], [], "o", color=colour, markersize=6, markeredgecolor="white", animated=True, clip_on=False)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    axes.margins(y=0.12)
    if high > LOG_FROM * low > 0:
        axes.set_yscale("log")
        style.plain_log(axes.yaxis, low, high)
    elif high - low < STEADY * abs(high):  # what stays is drawn as a level, not as its rounding
        axes.set_ylim(low - STEADY * abs(high), high + STEADY * abs(high))
    axes.set_ylabel(style.label(name, unit), fontsize=9)
    style.time_axis(axes, dataset)

    def mark(time: float) -> None:
        value = float(np.interp(time, times, values))
        before = times < time
        past.set_data(np.append(times[before], time), np.append(values[before], value))
        now.set_data([time], [value])
        axes.draw_artist(past)
        axes.draw_artist(now)

    return mark


def _clock(subject: _Subject, dataset: xr.Dataset) -> tuple[list[str], float, str]:
    """The times as they are shown, with as many digits as say which they are, the factor and the unit."""
    _, factor, _ = style.shown_times(dataset)
    unit = style.scale_of(style.unit_of(dataset["time"]), dataset["time"].values)[1]
    times = subject.times / factor
    apart = float(np.diff(times).min()) if len(times) > 1 else 1.0
    digits = int(np.clip(np.ceil(-np.log10(apart)), 0, 4)) if apart > 0 else 2
    while digits < _MOST_DIGITS and (abs(times - times.round(digits)) > _MISSED * apart).any():
        digits += 1
    return [f"{time:.{digits}f}" for time in times], factor, unit
