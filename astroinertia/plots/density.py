"""The fluid itself: slices and projections of the density at the start, when it is densest and at the end."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.picture_methods import missing_named
from astroinertia.plots import style
from astroinertia.plots.matter import POLE_ON, SIDE_ON, Matter, completed, draw_sinks, draw_triad, matter, reach, triads
from astroinertia.plots.render import column_density, density_slice, flow
from astroinertia.plots.shown_units import raised, written

PLANES = (SIDE_ON, POLE_ON)
PIXELS = 320
STEADY = 1.2  # a density that rises by less has no moment of compression
ARROWS = 11
DECADES = 8.0  # of density shown below the greatest, at most
MANY = 10.0**2.5  # of the faintest density, beyond which a bar has a tick a decade
SEVERAL = 10.0**1.3  # of it, beyond which a bar has no room for 1, 2 and 5 of each
FAINTEST = 8.0  # percentile of the picture that is drawn black
SLICES, COLUMNS = ("meridional plane", "equatorial plane"), ("side-on", "pole-on")


@with_absent
def density_figure(dataset: xr.Dataset, snapshots: xr.Dataset) -> Figure:
    """Meridional and equatorial slices with the flow, each column with its own width and its own scale of density.

    >>> figure = density_figure(ds, ds.inertia.snapshots)
    >>> print(sum(len(axes.images) for axes in figure.axes))  # from the side and from above: at start, densest, end
    6
    """
    return _figure(dataset, snapshots, "density and flow", SLICES)


@with_absent
def projection_figure(dataset: xr.Dataset, snapshots: xr.Dataset) -> Figure:
    """Column density side-on and pole-on, with the principal axes as long as the tensor makes them.

    >>> figure = projection_figure(ds, ds.inertia.snapshots)
    >>> print(figure.axes[-1].get_xlabel().split(" (")[0])
    column density
    """
    return _figure(dataset, snapshots, "column density and principal axes", COLUMNS)


def column_unit(density: xr.DataArray) -> str:
    """The unit of a column density."""
    return "1" if style.unit_of(density) == "1" else "kg m-2"


def scale_of_colours(images: list[np.ndarray]) -> LogNorm:
    """Colours for densities of several pictures: from what is faint in them to the greatest."""
    highest = max(float(image.max()) for image in images)
    lit = np.concatenate([image[image > highest * 10.0**-DECADES] for image in images])
    return LogNorm(min(float(np.percentile(lit, FAINTEST)), 0.5 * highest), highest)


def draw_density(axes: Any, image: np.ndarray, norm: LogNorm, width: float) -> None:
    """One picture of a density, `width` from its middle to its edge."""
    shown = np.maximum(image, norm.vmin)  # type: ignore[type-var]
    extent = (-width, width, -width, width)
    axes.imshow(shown, origin="lower", extent=extent, norm=norm, cmap=style.DENSITY_MAP, interpolation="bilinear")


def frame_view(axes: Any, plane: tuple[int, int], unit: str) -> None:
    """Labels and a frame for what is seen on a plane."""
    axes.grid(False)
    axes.xaxis.set_major_locator(MaxNLocator(5))  # so few that numbers of four digits do not touch
    axes.set(xlabel=style.label(f"${'xyz'[plane[0]]}$", unit), ylabel=style.label(f"${'xyz'[plane[1]]}$", unit))
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)


def name_view(axes: Any, text: str, height: float = 0.96) -> Any:
    """Say in a corner of a picture from where it is seen, or what else it needs."""
    return axes.annotate(
        text, (0.035, height), xycoords="axes fraction", va="top" if height > 0.5 else "bottom", color="white",
        fontsize=9, zorder=5,
        bbox={"facecolor": "black", "alpha": 0.75, "edgecolor": "none", "pad": 3},
    )  # fmt: skip


def _figure(dataset: xr.Dataset, snapshots: xr.Dataset, title: str, views: tuple[str, str]) -> Figure:
    if "snapshot_time" not in snapshots.dims:  # one of them was chosen
        snapshots = snapshots.expand_dims("snapshot_time")
    with missing_named("figures of particles are drawn"):
        chosen, snapshots = moments_to_show(snapshots), completed(dataset, snapshots)
        with style.styled():
            figure = style.begin(dataset, title, (3.9 * len(chosen) + 0.6, 8.4))
            panels = figure.subplots(2, len(chosen), squeeze=False)
            for column, (index, name) in enumerate(chosen):
                _column(figure, panels[:, column], snapshots.isel(snapshot_time=index).load(), name, views is SLICES)
            with_stars = "; stars are sinks" if "sink_position" in snapshots else ""
            for axes, text in zip(panels[:, 0], views, strict=True):
                name_view(axes, text + with_stars)
            return figure


def moments_to_show(snapshots: xr.Dataset) -> list[tuple[int, str]]:
    """Numbers and names of the snapshots worth a picture: start, greatest density, end."""
    count = snapshots.sizes["snapshot_time"]
    highest = snapshots["density"].max("particle").values
    densest = int(np.argmax(highest))
    if count == 1:
        return [(0, "snapshot" if snapshots["snapshot_time"][0] > 0 else "start")]
    if highest[densest] < STEADY * min(highest[0], highest[-1]):
        return [(0, "start"), *([(count // 2, "half-way")] if count > 2 else []), (count - 1, "end")]
    if densest in (0, count - 1):
        middle = [(count // 2, "half-way")] if count > 2 else []
        ends = ("start, densest snapshot", "end") if densest == 0 else ("start", "end, densest snapshot")
        return [(0, ends[0]), *middle, (count - 1, ends[1])]
    return [(0, "start"), (densest, "densest snapshot"), (count - 1, "end")]


def _column(figure: Figure, panels, snapshot: xr.Dataset, title: str, sliced: bool) -> None:
    particles = matter(snapshot, densest=True)
    half_width = reach(particles)
    length_scale, length_unit = style.scale_of(style.unit_of(snapshot["position"]), half_width)
    render = density_slice if sliced else column_density
    images = []
    for plane in PLANES:
        seen = particles.repeated(range(3) if sliced else plane)
        images.append(render(seen.position, seen.mass, seen.size, plane, half_width, PIXELS))
    norm, frame = scale_of_colours(images), triads([particles])[0]
    for axes, image, plane in zip(panels, images, PLANES, strict=True):
        draw_density(axes, image, norm, half_width / length_scale)
        frame_view(axes, plane, length_unit)
        axes.set(xlim=np.array([-1, 1]) * half_width / length_scale, ylim=np.array([-1, 1]) * half_width / length_scale)
        if not sliced:
            draw_triad(axes, frame, plane, length_scale, half_width)
        draw_sinks(axes, particles.sinks, plane, length_scale)
    if sliced:
        _arrows(panels, particles, half_width, length_scale, style.unit_of(snapshot["velocity"]))
    panels[0].set_title(title + _moment(snapshot["snapshot_time"]))
    density = snapshot["density"]
    name, own = ("density", style.unit_of(density)) if sliced else ("column density", column_unit(density))
    # Over many decades the bar has powers of ten itself.
    many = norm.vmax > MANY * norm.vmin
    scale, unit = (1.0, own) if many else style.scale_of(own, norm.vmax)
    scaled = LogNorm(norm.vmin / scale, norm.vmax / scale)  # type: ignore[operator]
    bar = figure.colorbar(
        ScalarMappable(scaled, style.DENSITY_MAP), ax=list(panels), location="bottom", shrink=0.9, aspect=26, pad=0.015
    )
    bar.set_label(style.label(name, unit))
    several = norm.vmax > SEVERAL * norm.vmin
    parts = (1.0, 3.0) if several else (1.0, 2.0, 5.0)
    style.plain_log(bar.ax.xaxis, scaled.vmin, scaled.vmax, parts)  # type: ignore[arg-type]
    bar.minorticks_off()  # a short bar has no room for them, and each takes its time
    bar.outline.set_visible(False)


def _moment(time: xr.DataArray) -> str:
    if float(time) == 0.0:
        return ""
    factor, unit = style.scale_of(style.unit_of(time), time.values)
    return f", {float(time) / factor:.4g} {style.raised(unit)}" if unit != "1" else f", time {float(time):.4g}"


def _arrows(panels, particles: Matter, half_width: float, length_scale: float, unit: str) -> None:
    flows = [
        flow(particles.position, particles.velocity, particles.mass, particles.size, plane, half_width, ARROWS)
        for plane in PLANES
    ]
    fastest = max(float(np.max(np.hypot(across, up), where=np.isfinite(up), initial=0.0)) for _, across, up in flows)
    if fastest == 0.0:
        return
    # The fastest arrow of a column is one cell long: lengths compare within a column, not between columns.
    cell = 2 * half_width / ARROWS / length_scale
    for axes, (centres, across, up) in zip(panels, flows, strict=True):
        moving = np.hypot(across, up) > 0.02 * fastest
        axes.quiver(
            *(centres / length_scale,) * 2, np.where(moving, across, np.nan), np.where(moving, up, np.nan),
            color="white", edgecolor="#00000090", linewidth=0.4, pivot="middle", angles="xy", scale_units="xy",
            scale=fastest / cell, width=0.004, headwidth=3.6, headlength=4,
        )  # fmt: skip
    speed = raised(written(float(f"{fastest:.2g}"), *style.scale_of(unit, fastest)))
    name_view(panels[-1], f"longest arrow\n{speed}", 0.035)
