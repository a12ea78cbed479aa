"""Profiles over shells of equal mass, at several times."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style
from astroinertia.plots.axis_scales import angular_momentum_scale

CURVES = 8
_PROFILES = (
    ("density_profile", "density", "Density"),
    ("rotation_profile", r"angular velocity about $z$", "Rotation"),
    ("specific_angular_momentum_profile", r"$\langle j_z \rangle$", "Specific angular momentum"),
)


@with_absent
def profiles_figure(dataset: xr.Dataset) -> Figure:
    """Density and, of a body that spins, rotation and specific angular momentum against the radius of equal shells.

    >>> print([axes.get_ylabel().split(" (")[0] for axes in profiles_figure(ds).axes[:2]])
    ['density', 'angular velocity about $z$']
    """
    spins = angular_momentum_scale(dataset)[1]
    drawn = _PROFILES if spins else _PROFILES[:1]
    with style.styled():
        figure = style.begin(dataset, "profiles", (9.0, 9.6) if spins else (7.0, 4.9))
        panels = np.atleast_1d(figure.subplots(len(drawn), 1, sharex=True))
        chosen = style.picked_times(dataset, CURVES)
        for axes, (name, text, title) in zip(panels, drawn, strict=True):
            _profile(axes, dataset, name, text, chosen)
            axes.set_title(title)
        style.time_bar(figure, panels, dataset, chosen, pad=0.01)
        return figure


def _profile(axes, dataset: xr.Dataset, name: str, text: str, chosen: np.ndarray) -> None:
    variable = dataset[name].transpose("time", "radius_bin")
    radius = dataset["radius_profile"].transpose("time", "radius_bin")
    if variable.isnull().all() or radius.isnull().all():
        style.note(axes, str(variable.attrs.get("reason", radius.attrs.get("reason", "not known"))))
        return
    length_scale, length_unit = style.scale_of(style.unit_of(radius), radius.values[chosen])
    values = variable.values[chosen]
    positive = values[np.isfinite(values)]
    logarithmic = len(positive) > 0 and (positive > 0).all() and positive.max() > 20 * positive.min()
    scale, unit = (1.0, style.unit_of(variable)) if logarithmic else style.scale_of(style.unit_of(variable), values)
    colours = style.time_colours(dataset).to_rgba(style.shown_times(dataset)[0])
    for index in chosen:
        axes.plot(radius[index] / length_scale, variable[index] / scale, color=colours[index], linewidth=1.6)
    reach = radius.values[chosen] / length_scale
    axes.set_xscale("log")
    style.plain_log(axes.xaxis, np.nanmin(reach), np.nanmax(reach))
    if logarithmic:
        axes.set_yscale("log")
        style.plain_log(axes.yaxis, positive.min() / scale, positive.max() / scale)
    elif (positive >= 0).all():
        axes.set_ylim(0, 1.12 * positive.max() / scale or 1.0)
    if axes.get_subplotspec().is_last_row():
        axes.set_xlabel(style.label("radius", length_unit))
    axes.set_ylabel(style.label(text, unit))
