"""A sweep of two-layer bodies as what it is: curves over a parameter that was swept, one for each value of a second."""

import math
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from astroinertia.errors import SceneError
from astroinertia.plots import style

_NAMES = ("core_radius", "moment_ratio", "core_density", "mantle_density", "core_mass_fraction", "love_number")
_CONSTANT = 1e-9  # relative, of what does not vary
_IN_LEGEND = 6  # curves, beyond which a bar of colours says which is which


def ratio_sweep_figure(family: xr.Dataset) -> Figure:
    """What varies in a sweep of studies.moment_ratio.two_layer_sweep, over the parameter of the most values.

    A second parameter has a curve for each of its values; the published radius of the core is marked where there is
    one. SceneError for a sweep of more parameters. Test: tests/unit/plots/test_ratio_sweep.py.

    >>> from astroinertia.studies.moment_ratio import two_layer_sweep
    >>> figure = ratio_sweep_figure(two_layer_sweep("Mars", {"core_density": [6000.0, 6500.0, 7000.0]}))
    >>> print(figure.axes[-1].get_xlabel(), "|", figure.axes[0].get_ylabel())
    density of the core (kg m⁻³) | radius of the core (km)
    """
    if len(family.sizes) > 2:
        raise SceneError(f"a picture of a sweep shows one or two parameters, not {len(family.sizes)}")
    across, *second = sorted(map(str, family.sizes), key=lambda name: -family.sizes[name])
    shown = [name for name in _NAMES if name in family.data_vars and _varies(family[name].values)]
    with style.styled():
        columns = 2 if len(shown) > 1 else 1
        rows = max(1, math.ceil(len(shown) / columns))
        figure = style.page(str(family.attrs["title"]), (5.6 * columns, 3.4 * rows + 0.4))
        panels: Any = figure.subplots(rows, columns, squeeze=False, sharex=True)
        for panel in panels.ravel()[len(shown) :]:
            panel.set_axis_off()
        for panel, name in zip(panels.ravel(), shown, strict=False):
            _curves(panel, family[name], across, second)
            if name == "core_radius":
                _published(panel, family)
        for panel in panels[-1] if len(shown) == rows * columns else panels.ravel()[: len(shown)]:
            panel.set_xlabel(_label(family[across]))
            panel.tick_params(labelbottom=True)
        if second:
            _key(figure, panels.ravel()[0], family[second[0]])
        return figure


def _varies(values: np.ndarray) -> bool:
    values = values[np.isfinite(values)]
    return values.size > 0 and float(np.ptp(values)) > _CONSTANT * float(abs(values).max())


def _curves(panel: Any, values: xr.DataArray, across: str, second: list[str]) -> None:
    lines = values.transpose(across, *second).values.reshape(values.sizes[across], -1) / _scale(values)
    for line, colour in zip(lines.T, _colours(lines.shape[1]), strict=True):
        panel.plot(values[across] / _scale(values[across]), line, color=colour, marker="." if len(line) < 40 else None)
    panel.set_ylabel(_label(values))


def _colours(count: int) -> list[Any]:
    import matplotlib

    return [style.BLUE] if count == 1 else list(matplotlib.colormaps["viridis"](np.linspace(0.0, 0.9, count)))


def _published(panel: Any, family: xr.Dataset) -> None:
    radius = family.attrs.get("published_core_radius", math.nan) / 1e3
    error = family.attrs.get("published_core_radius_uncertainty", math.nan) / 1e3
    if not math.isfinite(radius):
        return
    if math.isfinite(error):
        panel.axhspan(radius - error, radius + error, color=style.PALE, alpha=0.55, linewidth=0, zorder=0.5)
    style.level(panel, radius, "published", style.GREY)


def _key(figure: Figure, panel: Any, second: xr.DataArray) -> None:
    values = second.values / _scale(second)
    if len(values) <= _IN_LEGEND:
        lines, texts = panel.get_lines()[: len(values)], [f"{value:.6g}" for value in values]
        how = {"title": _label(second), "title_fontsize": 9, "ncols": len(texts)}
        figure.legend(lines, texts, loc="outside lower center", **how)
        return
    from matplotlib.cm import ScalarMappable

    colours = ScalarMappable(Normalize(values.min(), values.max() + (np.ptp(values)) / 9.0), "viridis")
    figure.colorbar(
        colours, ax=figure.axes, label=_label(second), boundaries=np.linspace(values.min(), values.max(), 200)
    )


def _scale(variable: xr.DataArray) -> float:
    return 1e3 if style.unit_of(variable) == "m" else 1.0


def _label(variable: xr.DataArray) -> str:
    unit = style.unit_of(variable)
    return style.label(str(variable.attrs["long_name"]), "km" if unit == "m" else unit)
