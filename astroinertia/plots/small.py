"""A picture that is smaller than it was drawn: its lines and margins shrink with it, and its type as far as it must."""

import itertools
import warnings
from collections.abc import Iterator
from typing import Any

import matplotlib
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.offsetbox import DrawingArea, PackerBase
from matplotlib.patches import FancyArrowPatch, Patch
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Affine2D

from astroinertia.plots.style import RESOLUTION, STYLE, styled

READABLE = (6.0, 5.5, 5.0, 4.5)  # points, the best first: journals ask for 6 in print
TITLE = float(STYLE["axes.titlesize"])
_PLACES = ("original", "active")  # of a panel, before and after its aspect is seen to
_FEWEST = 2  # parts between the numbers of an axis
_SPACE = 0.25  # of their height, that is between texts of one line
_TOUCH = 0.02  # inches by which the boxes of two texts may overlap: less than the room around their letters


def resize(figure: Figure, size: tuple[float, float]) -> float:
    """Give a figure another size, in inches; what is measured in points shrinks with it, and does not grow.

    Returns the share by which that shrinks: the smaller of those of width and height, so that all text has its room.
    Type below 6 points stays as near to that as keeps all text apart, titles in several lines where it must be, and no
    smaller than the titles of the panels, shrunk. An axis has fewer numbers where these have less room.
    Test: tests/unit/plots/test_small.py.

    >>> figure = Figure(figsize=(9.0, 6.0), layout="constrained")
    >>> axes = figure.subplots()
    >>> label = axes.set_ylabel("closure", fontsize=9)
    >>> print(f"{resize(figure, (6.0, 4.0)):.3f}")
    0.667
    >>> label.get_fontsize()
    6.0
    """
    share = min(1.0, *(asked / own for asked, own in zip(size, figure.get_size_inches(), strict=True)))
    figure.set_size_inches(*size)
    if share == 1.0:
        return share
    engine: Any = figure.get_layout_engine()
    engine.set(**{name: share * engine.get()[name] for name in ("h_pad", "w_pad")})
    shown = (
        figure.dpi,
        RESOLUTION / share,
    )  # on a screen and in a file: by the dots of an inch, letters have other widths
    with styled():
        artists = figure.findobj()
        sizes = [(artist, float(artist.get_fontsize())) for artist in artists if isinstance(artist, Text)]
        axes: list[tuple[Any, dict[str, float]]] = [
            (artist, _tick_sizes(artist)) for artist in artists if isinstance(artist, Axis)
        ]
        numbers = [(found, found._nbins, ticks["major"]) for axis, ticks in axes if (found := _counting(axis))]
        for artist in artists:
            _shrink(artist, share)
        panels: list[Any] = figure.axes
        places = [(panel, which, panel.get_position(which == "original")) for panel in panels for which in _PLACES]
        for least in (*READABLE, 0.0):
            for text, own in sizes:
                text.set_fontsize(_type_size(own, share, least))
            for axis, ticks in axes:
                for which, own in ticks.items():
                    axis.set_tick_params(which, labelsize=_type_size(own, share, least))
            for locator, most, own in numbers:
                locator.set_params(nbins=max(_FEWEST, int(most * share * own / _type_size(own, share, least))))
            for panel in panels:
                panel._left_title.set_wrap(least > 0.0)
            fits = not least or all(_is_legible(figure, dots) for dots in shown)
            figure.set_dpi(shown[0])
            for panel, which, place in places:  # a layout begins where the one before it has left the panels
                panel._set_position(place, which)
            if fits:
                break
    return share


def _is_legible(figure: Figure, dots: float) -> bool:
    """Whether at so many dots an inch texts are apart and on the page, frames in images and legends off curves."""
    figure.set_dpi(dots)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("error", "constrained_layout not applied")  # no room for the panels at all
            figure.draw_without_rendering()
    except UserWarning:
        return False
    touch = _TOUCH * dots
    page, boxes = figure.bbox, [text.get_window_extent() for text in _shown(figure)]
    if any(box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1 for box in boxes):
        return False
    for text in _shown(figure):
        frame: Any = text.get_bbox_patch()
        if frame and text.axes and text.axes.images and frame.get_window_extent().x1 > text.axes.bbox.x1 + touch:
            return False
    for one, other in itertools.combinations(boxes, 2):
        across, upward = min(one.x1, other.x1) - max(one.x0, other.x0), min(one.y1, other.y1) - max(one.y0, other.y0)
        height = min(one.height, other.height)
        if min(across, upward) > touch or (upward > 0.5 * height and across > -_SPACE * height):
            return False
    for panel in figure.axes:
        legend: Any = panel.get_legend()
        for line in panel.lines if legend else ():
            path = line.get_path().transformed(line.get_transform()).cleaned(remove_nans=True)
            if len(path) > 3 and path.intersects_bbox(legend.get_window_extent(), filled=False):
                return False
    return True


def _shown(figure: Figure) -> Iterator[Text]:
    """All text that is drawn: of tick labels those within the limits of their axis."""
    axes: Any = figure.findobj(Axis)
    drawn = {id(label) for axis in axes for tick in axis._update_ticks() for label in (tick.label1, tick.label2)}
    ticks = [tick for axis in axes for tick in (*axis.majorTicks, *axis.minorTicks)]
    left_out = {id(label) for tick in ticks for label in (tick.label1, tick.label2)} - drawn
    for text in figure.findobj(Text):
        if isinstance(text, Text) and text.get_visible() and text.get_text().strip() and id(text) not in left_out:
            yield text


def _shrink(artist: Artist, share: float) -> None:
    thing: Any = artist
    if isinstance(artist, Axes):
        thing._set_title_offset_trans(share * matplotlib.rcParams["axes.titlepad"])
    elif isinstance(artist, Axis):
        _shrink_axis(thing, share)
    elif isinstance(artist, Annotation) and thing.anncoords == "offset points":
        thing.xyann = tuple(share * length for length in thing.xyann)
    elif isinstance(artist, Line2D):
        for name in ("linewidth", "markersize", "markeredgewidth"):
            thing.set(**{name: share * getattr(thing, f"get_{name}")()})
    elif isinstance(artist, Patch):
        thing.set_linewidth(share * thing.get_linewidth())
        if isinstance(artist, FancyArrowPatch):
            thing.set_mutation_scale(share * thing.get_mutation_scale())
            thing.shrinkA, thing.shrinkB = share * thing.shrinkA, share * thing.shrinkB
    elif isinstance(artist, Collection):
        thing.set_linewidth(share * thing.get_linewidth())
        if thing.get_offset_transform() is not thing.get_transform() and hasattr(artist, "set_sizes"):
            thing.set_sizes(share**2 * thing.get_sizes())
    elif isinstance(artist, Legend):
        thing._fontsize *= share
        for box in thing.findobj(lambda part: isinstance(part, PackerBase | DrawingArea)):
            _shrink_box(box, share)


def _type_size(size: float, share: float, least: float) -> float:
    """The size of type, at least that of the panels' titles as they shrink to below the smallest that is readable."""
    return min(size, max(share * size, least, min(READABLE[-1], share * TITLE)))


def _tick_sizes(axis: Any) -> dict[str, float]:
    """The type of an axis's labels, by which ticks they are at."""
    style: Any = matplotlib.rcParams
    usual = style[f"{axis.axis_name}tick.labelsize"]
    return {which: axis.get_tick_params(which).get("labelsize", usual) for which in ("major", "minor")}


def _counting(axis: Any) -> Any:
    """What places the numbers of an axis, where it is asked for so many at most; None where it looks for their room."""
    locator = axis.get_major_locator()
    return locator if getattr(locator, "_nbins", "auto") != "auto" else None


def _shrink_axis(axis: Any, share: float) -> None:
    axis.labelpad *= share
    style: Any = matplotlib.rcParams
    name = f"{axis.axis_name}tick"
    for which in ("major", "minor"):
        known = axis.get_tick_params(which)
        lengths = {"length": "size", "width": "width", "pad": "pad"}
        found = {key: known.get(key, style[f"{name}.{which}.{rc}"]) for key, rc in lengths.items()}
        found["grid_linewidth"] = known.get("grid_linewidth", style["grid.linewidth"])
        axis.set_tick_params(which, **{key: share * value for key, value in found.items()})


def _shrink_box(box: Any, share: float) -> None:
    """A part of a legend, whose lengths are points of its type."""
    if isinstance(box, PackerBase):
        box.pad, box.sep = share * (box.pad or 0.0), share * (box.sep or 0.0)
        return
    for name in ("width", "height", "xdescent", "ydescent"):
        setattr(box, name, share * getattr(box, name))
    for child in box.get_children():
        child.set_transform(Affine2D().scale(share) + Artist.get_transform(child))
