"""A picture that is smaller than it was drawn: its type, lines and margins shrink with it."""

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

from astroinertia.plots.style import STYLE, styled

SMALLEST_TYPE = 5.0  # points; smaller type is hardly read in print
TITLE = float(STYLE["axes.titlesize"])


def resize(figure: Figure, size: tuple[float, float]) -> float:
    """Give a figure another size, in inches; what is measured in points shrinks with it, and does not grow.

    Returns the share by which that shrinks: the smaller of those of width and height, so that all text has its room.
    Small print is lifted towards 5 points. Test: tests/unit/plots/test_small.py.

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
    with styled():
        for artist in figure.findobj():
            _shrink(artist, share)
    return share


def _shrink(artist: Artist, share: float) -> None:
    thing: Any = artist
    if isinstance(artist, Axes):
        thing._set_title_offset_trans(share * matplotlib.rcParams["axes.titlepad"])
    elif isinstance(artist, Axis):
        _shrink_axis(thing, share)
    elif isinstance(artist, Text):
        thing.set_fontsize(_type_size(thing.get_fontsize(), share))
        if isinstance(artist, Annotation) and thing.anncoords == "offset points":
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


def _type_size(size: float, share: float) -> float:
    """Small print is lifted towards 5 points, at most to the type of the panels' titles, which fill their width."""
    return min(size, max(share * size, min(SMALLEST_TYPE, share * TITLE)))


def _shrink_axis(axis: Any, share: float) -> None:
    axis.labelpad *= share
    style: Any = matplotlib.rcParams
    name = f"{axis.axis_name}tick"
    for which in ("major", "minor"):
        known = axis.get_tick_params(which)
        lengths = {"length": "size", "width": "width", "pad": "pad"}
        found = {key: known.get(key, style[f"{name}.{which}.{rc}"]) for key, rc in lengths.items()}
        found["grid_linewidth"] = known.get("grid_linewidth", style["grid.linewidth"])
        size = known.get("labelsize", style[f"{name}.labelsize"])
        axis.set_tick_params(
            which, labelsize=_type_size(size, share), **{key: share * value for key, value in found.items()}
        )


def _shrink_box(box: Any, share: float) -> None:
    """A part of a legend, whose lengths are points of its type."""
    if isinstance(box, PackerBase):
        box.pad, box.sep = share * (box.pad or 0.0), share * (box.sep or 0.0)
        return
    for name in ("width", "height", "xdescent", "ydescent"):
        setattr(box, name, share * getattr(box, name))
    for child in box.get_children():
        child.set_transform(Affine2D().scale(share) + Artist.get_transform(child))
