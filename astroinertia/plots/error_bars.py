"""Error bars of a run over the values that they belong to, against time."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style

_SUFFIX = "_error"
_LEAST_DRAWN = 1e-5  # of the greatest
_SHOWN = {
    "inertia_tensor": (style.BLUE, "-"),
    "attitude": (style.SKY, "-"),
    "angular_momentum": (style.GREY, "-"),
    "angular_velocity": (style.VERMILLION, "-"),
    "mean_radius": (style.GREEN, "-"),
    "ellipsoid_flattening": (style.PURPLE, "-"),
    "moment_ratio": (style.SKY, (0, (4, 2))),
    "kinetic_energy": (style.ORANGE, "-"),
    "internal_energy": (style.YELLOW, "-"),
    "gravitational_energy": (style.ORANGE, (0, (4, 2))),
    "rotational_to_gravitational": (style.VERMILLION, (0, (4, 2))),
    "density_max": (style.INK, (0, (1.2, 1.6))),
}


def known_bars(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Error bars (T,) over the size of what they belong to, of vectors and tensors over all components."""
    bars = {}
    for name in _SHOWN:
        if f"{name}{_SUFFIX}" not in dataset or not np.isfinite(dataset[f"{name}{_SUFFIX}"]).any():
            continue
        sizes = []
        for variable in (f"{name}{_SUFFIX}", name):
            values = dataset[variable].transpose("time", ...).values
            sizes.append(np.linalg.norm(values.reshape(len(values), -1), axis=1))
        bars[name] = np.divide(*sizes, out=np.full(len(sizes[0]), np.nan), where=sizes[1] > 0.0)
    return bars


@with_absent
def error_bars_figure(dataset: xr.Dataset) -> Figure:
    """All error bars of a run in one panel.

    >>> with_error = ds.assign(inertia_tensor_error=0.01 * ds.inertia_tensor * (1 + ds.time / ds.time[-1]))
    >>> (axes,) = error_bars_figure(with_error).axes
    >>> print(f"{axes.lines[0].get_ydata().max():.2f}", axes.get_yscale())
    0.02 log
    """
    with style.styled():
        figure = style.begin(dataset, "error bars", (9.0, 4.6))
        axes = figure.subplots()
        bars = known_bars(dataset)
        if not bars:
            style.note(axes, "no error bars: run with --error-bars")
            return figure
        times, factor, _ = style.shown_times(dataset)
        greatest = max(float(np.nanmax(bar)) for bar in bars.values())
        if not greatest > 0.0:
            style.note(axes, "all error bars are zero")
            return figure
        axes.set_yscale("log")
        axes.set_ylim(_LEAST_DRAWN * greatest, 3.0 * greatest)  # first: bars may be the same at all times
        style.plain_log(axes.yaxis, *axes.get_ylim())
        for name, bar in bars.items():
            if not np.nanmax(bar) > _LEAST_DRAWN * greatest:
                continue  # of what is kept to rounding
            colour, dashes = _SHOWN[name]
            shown = np.where(bar > 0.0, bar, np.nan)
            axes.plot(times, shown, color=colour, linestyle=dashes, linewidth=1.5, label=style.words(name))
        axes.set(ylabel="error bar / value", title="Estimated errors, over the values")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        style.mark_compression(axes, dataset, factor)
        style.time_axis(axes, dataset)
        return figure
