"""The look that all figures share: colours, type, units in sensible prefixes, and how a figure is begun and saved."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from PIL import Image

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.plots.shown_units import LARGEST_PLAIN, SMALLEST_PLAIN, raised as raised, scale_of as scale_of
from astroinertia.storage import overwriting
from astroinertia.storage.atomic import write_whole
from astroinertia.units import known_size, quantity, readable as readable, unit_of as unit_of

# Okabe & Ito's palette, distinct in all common kinds of colour blindness (jfly.uni-koeln.de/color).
BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, YELLOW = (
    "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#B8A800",
)  # fmt: skip
COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, YELLOW)  # of things beside each other, in this order
INK, GREY, PALE = "#1c1c1c", "#707070", "#d9d9d9"
COMPONENTS = (SKY, ORANGE, BLUE)
# Of three curves that may lie on each other: each shows through the gaps of those that are drawn after it.
DASHES: tuple[Any, ...] = ("-", (0, (6, 4)), (0, (1.6, 2.4)))
PALETTE = {
    "blue": BLUE, "vermillion": VERMILLION, "green": GREEN, "orange": ORANGE, "purple": PURPLE, "sky": SKY,
    "yellow": YELLOW,
}  # fmt: skip
EFFECTS = {"motion": INK, "rigidity": SKY} | {
    kind: PALETTE[entry.colour] for kind, entry in CATALOGUE.items() if entry.colour
}
SPARE = (PURPLE, SKY, ORANGE, YELLOW, GREEN, BLUE, VERMILLION)
TIME_MAP, DENSITY_MAP = "viridis", "inferno"
RESOLUTION = 160  # dots an inch of files
NOTEBOOK = 72.0  # the same of what notebooks show, as IPython's own pictures have
MOST_TURNS = 200  # of a curve across a panel, beyond which it fills it with ink
MOST_TRAVEL = 50  # up and down, over the range of the curve; a curve that turns within its own width stays a line
BAND_PIECES = 120  # of time, over each of which the band of such a curve has its extremes
COMPRESSION = 2  # takes a third of the time of matplotlib's 6, for files a tenth larger

STYLE = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 10,
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # nothing stands on top of a panel that a title would have to give way to
    "axes.titlepad": 8,
    "axes.labelsize": 10,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#e8e8e8",
    "grid.linewidth": 0.7,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.frameon": True,
    "legend.facecolor": "white",
    "legend.edgecolor": "none",
    "legend.framealpha": 0.85,
    "legend.fontsize": 9,
    "legend.handlelength": 1.9,
    "lines.linewidth": 1.7,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "savefig.dpi": RESOLUTION,
}


@contextmanager
def styled() -> Iterator[None]:
    """Figures made inside have the shared look; nothing else changes."""
    # From matplotlib's own defaults, so that a user's style sheet does not half apply; the backend is theirs.
    defaults: Any = {
        name: value for name, value in matplotlib.rcParamsDefault.items() if not name.startswith("backend")
    }
    with matplotlib.rc_context(defaults | STYLE):
        yield


class Picture(Figure):
    """A figure that notebooks show as what a cell gives, also where nothing has imported pyplot before."""

    def _repr_png_(self) -> bytes:
        png = BytesIO()
        write_png(self, png, NOTEBOOK)
        return png.getvalue()


def page(title: str, size: tuple[float, float]) -> Figure:
    """An empty figure with a title, in inches; no pyplot, so nothing is shown or kept."""
    figure = Picture(figsize=size, layout="constrained")
    figure.get_layout_engine().set(h_pad=0.09, w_pad=0.09, hspace=0.03, wspace=0.03)  # type: ignore[union-attr]
    figure.suptitle(title, x=0.012, ha="left", fontsize=13, fontweight="bold", color=INK, parse_math=False)
    return figure


def begin(dataset: xr.Dataset, title: str, size: tuple[float, float]) -> Figure:
    """An empty figure with the run's name."""
    name = str(dataset.attrs.get("name", "")).replace("_", " ")
    figure = page(f"{name}: {title}" if name else title, size)
    if dataset["time"].attrs.get("units") == "1":
        figure.text(0.988, 0.99, "units in which G = 1", ha="right", va="top", fontsize=9, color=GREY)
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write a PNG, whole or not at all; ArchiveError where that cannot be done, or would destroy what is no PNG."""
    overwriting.check(path, overwriting.PNG)
    write_whole(path, partial(write_png, figure))
    return path


def write_png(figure: Figure, target: Any, resolution: float = RESOLUTION) -> None:
    """Write a PNG to a file, open or by its path, of so many dots an inch; opaque, laid out and drawn once.

    `savefig` draws everything a second time where a layout is to be found.
    """
    canvas, before = figure.canvas, figure.dpi
    try:
        with styled():
            figure.set_dpi(resolution)
            drawn = FigureCanvasAgg(figure)
            drawn.draw()
            opaque = np.ascontiguousarray(np.asarray(drawn.buffer_rgba())[..., :3])
            Image.fromarray(opaque).save(target, "png", dpi=(resolution, resolution), compress_level=COMPRESSION)
    finally:
        figure.set_canvas(canvas)
        figure.set_dpi(before)


def label(name: str, unit: str) -> str:
    """An axis label with its unit; none for pure numbers."""
    return name if unit == "1" else f"{name} ({raised(unit)})"


def shown_times(dataset: xr.Dataset) -> tuple[np.ndarray, float, str]:
    """Times in the unit that the dataset has for them, else in a readable one, the factor, and the axis label."""
    time = dataset["time"]
    own = unit_of(time)
    wanted = str(time.attrs.get("display_unit", own))
    factor, unit = (
        scale_of(own, time.values)
        if wanted == own
        else (known_size(wanted, own) or quantity(f"1 {wanted}", "time"), wanted)
    )
    return time.values / factor, factor, label("time", unit)


def number(value: float, digits: int = 3) -> str:
    """A number for running text, with a proper power of ten where it needs one."""
    if not np.isfinite(value):
        return "undefined"
    if value == 0 or SMALLEST_PLAIN <= abs(value) < LARGEST_PLAIN:
        return f"{value:.{digits}g}"
    exponent = int(np.floor(np.log10(abs(value))))
    return raised(f"{value / 10.0**exponent:.{digits - 1}f} × 10^{exponent}")


def effect_colour(name: str, names: list[str]) -> str:
    """The colour of an effect, the same in every figure of a run: its own, unless an effect before it has that one."""
    taken: list[str] = []
    for effect in [*names[: names.index(name)], name] if name in names else [name]:
        own = EFFECTS.get(effect, SPARE[0])
        free = (colour for colour in (own, *SPARE) if colour not in taken)
        taken.append(next(free, own))
    return taken[-1]


def words(name: str) -> str:
    """A name of the dataset as it is said."""
    return name.replace("_", " ").replace("enclosing 99", "enclosing 99 %")


def compression_time(dataset: xr.Dataset) -> int | None:
    """Number of the output of greatest density, if it is a maximum within the run and not an end of it."""
    density = dataset["density_max"].values
    if not np.isfinite(density).any():
        return None
    index = int(np.nanargmax(density))
    inside = 0 < index < len(density) - 1
    return index if inside and density[index] > 1.5 * max(density[0], np.nanmin(density)) else None


def mark_compression(axes: Any, dataset: xr.Dataset, factor: float, named: bool = False) -> None:
    """A thin line at the greatest density, with its name in the panels that ask for it."""
    index = compression_time(dataset)
    if index is None:
        return
    at = float(dataset["time"][index]) / factor
    axes.axvline(at, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)), zorder=0.5)
    if named:
        late = index > 0.6 * dataset.sizes["time"] or at > 0.6 * float(dataset["time"][-1]) / factor
        axes.annotate(
            "maximum density", (at, 1.0), xycoords=("data", "axes fraction"), xytext=(-4 if late else 4, -2),
            textcoords="offset points", fontsize=8, color=GREY, va="top", ha="right" if late else "left",
            bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1}, zorder=1,
        )  # fmt: skip
        if axes.get_legend():
            axes.get_legend().borderaxespad = 1.6  # below that name


def time_axis(axes: Any, dataset: xr.Dataset, last: bool = True) -> None:
    """Limits and label of a time axis, after what is drawn over it: a single record is drawn as dots."""
    times, _, text = shown_times(dataset)
    if len(times) > 1:
        axes.set_xlim(times[0], times[-1])
    else:
        for line in axes.lines:
            if len(line.get_xdata()) == 1:
                line.set_marker("o")
    if last:
        axes.set_xlabel(text)
    else:
        axes.tick_params(labelbottom=False)


def plain_log(axis: Any, low: float, high: float, parts: Sequence[float] = (1.0, 2.0, 5.0)) -> None:
    """Ticks of a logarithmic axis as plain numbers where these are short, at 1, 2 and 5 over short ranges.

    parts: of a decade that have numbers there, fewer on a short axis.
    """
    decades = np.log10(high / low)
    axis.set_major_locator(LogLocator(subs=parts if decades < 2.5 else (1.0,), numticks=12))
    axis.set_minor_formatter(NullFormatter())
    if not 2.5 <= decades <= 4.5:  # between 1, 2 and 5 they say little, and in many decades they are a grey band
        axis.set_minor_locator(NullLocator())
    if low >= 1e-3 and high <= 1e5:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    elif decades < 2.5:
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 1)))
    else:
        axis.set_major_formatter(FuncFormatter(lambda value, _: raised(f"10^{round(np.log10(value))}")))


def from_zero_or_log(axes: Any, values: np.ndarray, scale: float) -> None:
    """An axis from zero for values over `scale`, or in logarithms where they differ by more than a factor of 20."""
    least, most = np.nanmin(values), np.nanmax(values)
    if most > 20 * least > 0:
        axes.set_yscale("log")
        plain_log(axes.yaxis, least / scale, most / scale)
    else:
        axes.set_ylim(0, 1.08 * most / scale)


def level(axes: Any, value: float, text: str, colour: str) -> None:
    """A dashed horizontal line, named in the margin on the right."""
    axes.axhline(value, color=colour, linewidth=1, linestyle="--", zorder=1)
    axes.annotate(
        text, (1, value), xycoords=("axes fraction", "data"), xytext=(5, 0), textcoords="offset points",
        ha="left", va="center", fontsize=8, color=colour,
    )  # fmt: skip


def note(axes: Any, text: str, timed: bool = False) -> None:
    """Say in an empty panel why it is empty. timed: its axis along time stays, for the panels above have the same."""
    axes.text(0.5, 0.5, text, ha="center", va="center", color=GREY, transform=axes.transAxes, wrap=True)
    if not timed:
        axes.set_xticks([])
    axes.set_yticks([])


def curve(axes: Any, times: np.ndarray, values: Any, **look: Any) -> None:
    """A line; where it turns too often to be seen, the band between its extremes, through which others show."""
    values = np.asarray(values, dtype=float)
    known = values[np.isfinite(values)]
    rises = np.diff(known)
    turns = np.count_nonzero(rises[1:] * rises[:-1] < 0)
    if turns <= MOST_TURNS or abs(rises).sum() <= MOST_TRAVEL * np.ptp(known) or "marker" in look:
        axes.plot(times, values, **look)
        return
    starts = np.unique(np.linspace(0, len(values), BAND_PIECES + 1).astype(int)[:-1])
    low, high = (bound.reduceat(values, starts) for bound in (np.fmin, np.fmax))
    middles = (times[starts] + times[np.append(starts[1:], len(values)) - 1]) / 2.0
    middles[0], middles[-1] = times[0], times[-1]
    edge = 0.6 * look.get("linewidth", 1.5)  # so that a narrow band is seen, too
    look = {name: value for name, value in look.items() if name in ("color", "label", "zorder")}
    band = axes.fill_between(middles, low, high, alpha=0.5, linewidth=edge, **look)
    band.set_edgecolor(look["color"])


def legend(axes: Any, *named: Any, room: float = 0.16, **look: Any) -> None:
    """A legend in one row, and room for it above all curves, a share of the panel: those that swing leave no other."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** room if axes.get_yscale() == "log" else high + room * (high - low))
    entries = named[0] if named else axes.get_legend_handles_labels()[0]
    axes.legend(*named, **{"loc": "best", "ncols": len(entries), "columnspacing": 1.4} | look)


def relative_sizes(
    axes: Any, times: np.ndarray, lines: Sequence[tuple[np.ndarray, str, dict[str, Any]]], **place: Any
) -> None:
    """Positive values, each with its name and look, in logarithms; a note where there are none.

    place: of the legend, without it in a row above the curves.
    """
    drawn = [values for values, _, _ in lines if (values > 0).any()]
    if not drawn:
        note(axes, "nothing to the last bit", timed=True)
        return
    for values, text, look in lines:
        if (values > 0).any():
            curve(axes, times, np.where(values > 0, values, np.nan), label=text, **{"linewidth": 1.3, **look})
    low, high = robust_limits(np.concatenate(drawn), 1e-18)
    axes.set(yscale="log", ylim=(low, max(high, 30 * low)), ylabel="relative size")
    if place:
        axes.legend(**place)
    else:
        legend(axes)
    plain_log(axes.yaxis, *axes.get_ylim())


def time_colours(dataset: xr.Dataset) -> ScalarMappable:
    """The colours of times, in the unit of the time axis."""
    times, _, _ = shown_times(dataset)
    return ScalarMappable(Normalize(times[0], max(times[-1], np.nextafter(times[0], np.inf))), TIME_MAP)


def time_bar(figure: Figure, panels: Any, dataset: xr.Dataset, chosen: np.ndarray, **place: Any) -> None:
    """A bar of these colours beside panels, with a line at each output that was drawn."""
    times, _, text = shown_times(dataset)
    bar = figure.colorbar(time_colours(dataset), ax=list(panels), aspect=28, label=text, **place)
    bar.outline.set_visible(False)
    for index in chosen:
        bar.ax.plot([0, 1], [times[index]] * 2, color="white", linewidth=1.2)


def picked_times(dataset: xr.Dataset, count: int) -> np.ndarray:
    """Outputs to draw: both ends, the greatest density, and others spread evenly over time and over change of size."""
    total = dataset.sizes["time"]
    size = np.log(np.maximum(np.nan_to_num(dataset["mean_radius"].values, nan=1.0), 1e-300))
    path = np.concatenate([[0.0], np.cumsum(abs(np.diff(size)))])
    share = np.linspace(0, 1, total) + (path / path[-1] if path[-1] > 0 else 0.0)
    picked = np.unique(np.searchsorted(share, np.linspace(0, share[-1], count) * (1 - 1e-12)))
    index = compression_time(dataset)
    if index is not None and len(picked) > 2:
        inner = picked[1:-1]
        inner[np.argmin(abs(share[inner] - share[index]))] = index
        picked = np.unique(np.concatenate([picked[:1], inner, picked[-1:]]))
    return np.minimum(picked, total - 1)


def robust_limits(values: np.ndarray, floor: float) -> tuple[float, float]:
    """Limits of a logarithmic axis that hold all positive values, from `floor` up."""
    positive = values[np.isfinite(values) & (values > floor)]
    if not len(positive):
        return floor, 10 * floor
    return max(positive.min() / 3, floor), positive.max() * 4
