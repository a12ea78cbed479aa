"""Gravitational waves of the quadrupole formula: strain, and spectrum."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style
from astroinertia.units import PARSEC

_TEN_KILOPARSECS = 1e4 * PARSEC  # the usual distance of a galactic supernova
COARSE = 0.2  # of the largest strain: records between which it changes by more do not resolve it


@with_absent
def waves_figure(dataset: xr.Dataset) -> Figure:
    """Strain times distance, plus and cross, from the pole and the equatorial plane, and the characteristic strain.

    >>> print(len(waves_figure(ds).axes))  # seen from the pole, from the equator, and by frequency
    3
    """
    with style.styled():
        figure = style.begin(dataset, "gravitational waves", (9.0, 8.8))
        *panels, spectrum = figure.subplots(3, 1)
        plus, cross = dataset["gw_strain_plus"], dataset["gw_strain_cross"]
        if plus.isnull().all():
            for axes in (*panels, spectrum):
                style.note(axes, str(plus.attrs.get("reason", "not known")))
            return figure
        times, factor, _ = style.shown_times(dataset)
        observers = ("equatorial", "polar")
        titles = ("Seen from the equatorial plane, along x", "Seen from the pole, along z")
        for axes, observer, title in zip(panels, observers, titles, strict=True):
            pair = (plus.sel(observer=observer), cross.sel(observer=observer))
            scale, unit = style.scale_of("m", *(strain.values for strain in pair))
            for strain, colour, name in zip(pair, (style.BLUE, style.ORANGE), (r"h_+", r"h_\times"), strict=True):
                axes.plot(times, strain / scale, color=colour, linewidth=1.3, label=f"${name}$")
            axes.axhline(0, color=style.GREY, linewidth=0.8)
            axes.set(ylabel=style.label(r"$h \times$ distance", unit), title=title)
            axes.legend(loc="best", ncols=2)
            largest = max(float(abs(strain).max()) for strain in pair) / _TEN_KILOPARSECS
            axes.annotate(
                f"largest at 10 kpc: {style.number(largest, 2)}", (1, 1), xycoords="axes fraction", xytext=(0, 6),
                textcoords="offset points", ha="right", fontsize=9, color=style.GREY,
            )  # fmt: skip
            style.mark_compression(axes, dataset, factor, named=axes is panels[0])
            style.time_axis(axes, dataset, last=axes is panels[-1])
            axes.set_xlim(left=_onset(times, (plus, cross)))
            _at_least(axes, np.array([strain.values for strain in pair]) / scale)
            if undersampled(pair):
                _mark_records(axes)
        _spectrum(spectrum, dataset)
        return figure


def undersampled(strains: Iterable[xr.DataArray]) -> bool:
    """Whether the strain changes by more between two records than a curve through them can tell of."""
    series = [strain.values for strain in strains]
    largest = max(float(np.nanmax(abs(values))) for values in series)
    steps = [float(np.nanmax(abs(np.diff(values)), initial=0.0)) for values in series]
    return max(steps) > COARSE * largest


def _mark_records(axes: Any) -> None:
    for line in axes.lines[:2]:
        line.set(marker="o", markersize=3.5)
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.16 * (high - low), high)  # room for the words beneath the curves
    axes.annotate(
        "too few records (dots) to resolve this: a shorter output.series_every has more", (0, 0),
        xycoords="axes fraction", xytext=(4, 4), textcoords="offset points", fontsize=8.5, color=style.VERMILLION,
    )  # fmt: skip


def _spectrum(axes: Any, dataset: xr.Dataset) -> None:
    # What energy goes into which frequency, down to a ten-thousandth of the largest strain.
    if "gw_characteristic_strain" not in dataset:
        style.note(axes, "this file is older than spectra")
        return
    strain = dataset["gw_characteristic_strain"]
    frequency, size = strain["frequency"].values[1:], strain.values[1:]
    if not np.isfinite(size).any() or not (size > 0).any():
        style.note(axes, str(strain.attrs.get("reason", "no waves")))
        return
    frequencies, hertz = style.scale_of("Hz", frequency)
    scale, unit = style.scale_of("m", size)
    axes.plot(frequency / frequencies, size / scale, color=style.BLUE, linewidth=1.3)
    least, top = float(size[size > 0].min()) / scale, float(size.max()) / scale
    axes.set(xscale="log", yscale="log", ylim=(max(1e-4 * top, 0.5 * least), 3.0 * top))
    style.plain_log(axes.xaxis, *axes.get_xlim())
    style.plain_log(axes.yaxis, *axes.get_ylim())
    axes.set(xlabel=style.label("frequency", hertz), ylabel=style.label(r"$h_{\mathrm{char}} \times$ distance", unit))
    axes.set_title("Characteristic strain of the whole run")
    energy = float(dataset["gw_energy"][-1])
    axes.annotate(
        f"energy carried away: {style.number(energy, 2)} J", (1, 1), xycoords="axes fraction", xytext=(0, 6),
        textcoords="offset points", ha="right", fontsize=9, color=style.GREY,
    )  # fmt: skip


def _onset(times: np.ndarray, strains: tuple[xr.DataArray, xr.DataArray]) -> float:
    # A long quiet beginning is cut off: the picture starts a little before 5% of the largest amplitude is reached.
    size = np.max([abs(strain.transpose("time", "observer").values).max(axis=1) for strain in strains], axis=0)
    loud = times[int(np.argmax(size > 0.05 * np.nanmax(size)))]
    begin = times[-1] - 1.25 * (times[-1] - loud)
    return float(begin if begin > times[0] + 0.4 * (times[-1] - times[0]) else times[0])


def _at_least(axes, values: np.ndarray) -> None:
    # Room for the legend, and no collapse of the axis where all is zero.
    reach = float(np.nanmax(abs(values))) or 1.0
    axes.set_ylim(-1.15 * reach, 1.35 * reach)
