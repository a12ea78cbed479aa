"""The fluid itself: slices of the density at the start, at the greatest compression and at the end."""

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from astroinertia.plots import style
from astroinertia.plots.render import density_slice, flow

PLANES = ((0, 2), (0, 1))  # meridional, equatorial
PIXELS = 320
STEADY = 1.2  # a density that rises by less has no moment of compression
ARROWS = 11
DECADES = 8.0  # of density shown below the greatest, at most
FAINTEST = 8.0  # percentile of the picture that is drawn black
SHARE_SHOWN = 0.9  # of the mass, which the width of a picture follows


def density_figure(dataset: xr.Dataset, snapshots: xr.Dataset) -> Figure:
    """Meridional and equatorial slices, each column with its own width and its own scale of density."""
    chosen = moments_to_show(snapshots)
    with style.styled():
        figure = style.begin(dataset, "density and flow", (3.9 * len(chosen) + 0.6, 8.4))
        panels = figure.subplots(2, len(chosen), squeeze=False)
        for column, (index, title) in enumerate(chosen):
            _column(figure, panels[:, column], snapshots.isel(snapshot_time=index).load(), title, first=column == 0)
        return figure


def moments_to_show(snapshots: xr.Dataset) -> list[tuple[int, str]]:
    """Numbers and names of the snapshots worth a picture: start, greatest density, end."""
    count = snapshots.sizes["snapshot_time"]
    highest = snapshots["density"].max("particle").values
    densest = int(np.argmax(highest))
    if count == 1:
        return [(0, "start")]
    if highest[densest] < STEADY * min(highest[0], highest[-1]):
        return [(0, "start"), *([(count // 2, "half-way")] if count > 2 else []), (count - 1, "end")]
    if densest in (0, count - 1):
        middle = [(count // 2, "half-way")] if count > 2 else []
        ends = ("start, densest", "end") if densest == 0 else ("start", "end, densest")
        return [(0, ends[0]), *middle, (count - 1, ends[1])]
    return [(0, "start"), (densest, "densest snapshot"), (count - 1, "end")]


def _column(figure: Figure, panels, snapshot: xr.Dataset, title: str, first: bool) -> None:
    mass, size = snapshot["mass"].values, snapshot["smoothing_length"].values
    position = snapshot["position"].transpose("particle", "i").values
    velocity = snapshot["velocity"].transpose("particle", "i").values
    # The picture follows the densest matter, which is where the body is.
    weight = mass * snapshot["density"].values
    position = position - weight @ position / weight.sum()
    velocity = velocity - mass @ velocity / mass.sum()
    radius = np.linalg.norm(position, axis=1)
    order = np.argsort(radius)
    inside = np.searchsorted(np.cumsum(mass[order]), SHARE_SHOWN * mass.sum())
    reach = min(1.3 * radius[order[min(inside, len(order) - 1)]], 1.25 * radius.max())
    length_scale, length_unit = style.scale_of(style.unit_of(snapshot["position"]), reach)
    unit = style.unit_of(snapshot["density"])
    slices = [density_slice(position, mass, size, plane, reach, PIXELS) for plane in PLANES]
    highest = max(float(image.max()) for image in slices)
    lit = np.concatenate([image[image > highest * 10.0**-DECADES] for image in slices])
    lowest = float(np.percentile(lit, FAINTEST))
    norm = LogNorm(min(lowest, 0.5 * highest), highest)
    extent = tuple(np.array([-reach, reach, -reach, reach]) / length_scale)
    for axes, density, plane in zip(panels, slices, PLANES, strict=True):
        shown = np.maximum(density, norm.vmin)  # type: ignore[type-var]
        axes.imshow(shown, origin="lower", extent=extent, norm=norm, cmap=style.DENSITY_MAP, interpolation="bilinear")
        axes.grid(False)
        axes.set_xlabel(style.label("$xyz$"[0] + "xyz"[plane[0]] + "$", length_unit))
        axes.set_ylabel(style.label("$" + "xyz"[plane[1]] + "$", length_unit))
        for side in ("top", "right"):
            axes.spines[side].set_visible(True)
    _arrows(panels, position, velocity, mass, size, reach, length_scale)
    panels[0].set_title(title + _moment(snapshot["snapshot_time"]))
    if first:
        for axes, text in zip(panels, ("meridional plane", "equatorial plane"), strict=True):
            axes.annotate(
                text, (0.035, 0.96), xycoords="axes fraction", va="top", color="white", fontsize=9, zorder=5,
                bbox={"facecolor": "black", "alpha": 0.55, "edgecolor": "none", "pad": 3},
            )  # fmt: skip
    bar = figure.colorbar(
        ScalarMappable(norm, style.DENSITY_MAP), ax=list(panels), location="bottom", shrink=0.9, aspect=26, pad=0.015
    )
    bar.set_label(style.label("density", unit))
    bar.outline.set_visible(False)  # type: ignore[operator]


def _moment(time: xr.DataArray) -> str:
    if float(time) == 0.0:
        return ""
    factor, unit = style.scale_of(style.unit_of(time), time.values)
    return f", {float(time) / factor:.4g} {style.pretty(unit)}" if unit != "1" else f", time {float(time):.4g}"


def _arrows(panels, position, velocity, mass, size, reach: float, length_scale: float) -> None:
    flows = [flow(position, velocity, mass, size, plane, reach, ARROWS) for plane in PLANES]
    fastest = max(float(np.max(np.hypot(across, up), where=np.isfinite(up), initial=0.0)) for _, across, up in flows)
    if fastest == 0.0:
        return
    # The fastest arrow of a column is one cell long: lengths compare within a column, not between columns.
    cell = 2 * reach / ARROWS / length_scale
    for axes, (centres, across, up) in zip(panels, flows, strict=True):
        moving = np.hypot(across, up) > 0.02 * fastest
        axes.quiver(
            *(centres / length_scale,) * 2, np.where(moving, across, np.nan), np.where(moving, up, np.nan),
            color="white", edgecolor="#00000090", linewidth=0.4, pivot="middle", angles="xy", scale_units="xy",
            scale=fastest / cell, width=0.004, headwidth=3.6, headlength=4,
        )  # fmt: skip
