"""The posterior of an interior: every parameter against every other."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axis import Axis
from matplotlib.figure import Figure

from astroinertia.errors import SceneError
from astroinertia.plots import style
from astroinertia.units import shown, unit_of

SHOWN = ("core_radius", "core_radius_ratio", "core_density", "mantle_density", "moment_ratio", "love_number")
_SCALES = {"m": (1e3, "km")}
_FREE = 0.1  # of a panel's side, at both ends, in which numbers would lie on those of the next panel
_LEVELS = (0.393, 0.865)  # what one and two standard deviations of a Gaussian in two dimensions enclose


def posterior_figure(
    posterior: xr.Dataset, names: Sequence[str] | None = None, marks: Mapping[str, float] | None = None
) -> Figure:
    """Draw the marginal posteriors of `names` (those of SHOWN that there are) and of each two of them.

    posterior: as studies.interior_inference gives it; marks: a value of each name, in SI, to be drawn as a line. The
    titles have the median and the 16th and 84th percentiles. SceneError without the package corner, for a name that the
    posterior does not have, and for fewer draws than names.

    >>> draws = np.random.default_rng(1).normal(size=(2, 1000))
    >>> posterior = xr.Dataset({"core_density": ("draw", 8000 + 60 * draws[0]), "moment_ratio": ("draw", draws[1])})
    >>> print(len(posterior_figure(posterior).axes))
    4
    """
    try:
        import corner  # pyright: ignore[reportMissingImports]  an extra: only this picture needs it
    except ImportError:
        raise SceneError("this picture needs corner: pip install 'astroinertia[inference]'") from None
    if names is None:
        names = [name for name in SHOWN if name in posterior]
        names = [name for name in names if name != "core_radius_ratio" or "core_radius" not in names]
    if lacking := [name for name in names if name not in posterior]:
        raise SceneError(
            f"the posterior has no '{shown(lacking[0])}'; it has {', '.join(map(str, posterior.data_vars))}"
        )
    if not names or min(posterior[name].size for name in names) <= len(names):
        raise SceneError("a picture of a posterior needs a parameter and more draws than parameters")
    columns, labels, lines = [], [], []
    for name in names:
        unit = unit_of(posterior[name])
        scale, short = _SCALES.get(unit, (1.0, unit))
        columns.append(posterior[name].values.ravel() / scale)
        labels.append(style.label(style.words(name), short))
        lines.append(None if marks is None or name not in marks else marks[name] / scale)
    with style.styled():
        size = 2.3 * len(names) + 0.6
        figure = style.Picture(figsize=(size, size))
        corner.corner(
            np.stack(columns, axis=-1),
            labels=labels,
            truths=lines if any(line is not None for line in lines) else None,
            truth_color=style.VERMILLION,
            color=style.BLUE,
            levels=_LEVELS,
            quantiles=[0.16, 0.84],
            plot_datapoints=False,
            fill_contours=True,
            smooth=1.0,
            bins=40,
            max_n_ticks=4,
            fig=figure,
        )
        for axes in figure.axes:
            axes.grid(False)
            _keep_ends_free(axes.xaxis)
            _keep_ends_free(axes.yaxis)
        for k, values in enumerate(columns):
            low, middle, high = np.quantile(values, [0.16, 0.5, 0.84])
            digits = max(0, 1 - math.floor(math.log10(min(high - middle, middle - low) or 1.0)))
            label = f"${middle:.{digits}f}^{{+{high - middle:.{digits}f}}}_{{-{middle - low:.{digits}f}}}$"
            figure.axes[k * len(columns) + k].set_title(label, loc="center", fontsize=11)
        body = str(posterior.attrs.get("body", ""))
        title = str(posterior.attrs.get("title", "interiors"))
        figure.suptitle(
            f"{body}: {title}" if body else title, x=0.98, ha="right", fontsize=13, fontweight="bold", color=style.INK
        )
        return figure


def _keep_ends_free(axis: Axis) -> None:
    """Leave out the marks whose numbers would lie on those of the next panel."""
    low, high = sorted(axis.get_view_interval())
    free = _FREE * (high - low)
    axis.set_ticks([mark for mark in axis.get_majorticklocs() if low + free <= mark <= high - free])
