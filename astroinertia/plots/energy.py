"""Energies: where they are, who moved them, and what nobody accounts for."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style
from astroinertia.plots.axis_scales import energy_scale, has_values, known_effects, moved
from astroinertia.plots.error_bars import Band, error_of, shade

_KINDS = (
    ("kinetic_energy", "kinetic", style.ORANGE, "-"),
    ("rotational_energy", "of the mean angular velocity", style.PURPLE, (0, (1.2, 1.6))),
    ("internal_energy", "internal", style.VERMILLION, "-"),
    ("gravitational_energy", "self-gravity", style.BLUE, "-"),
)


@with_absent
def energy_figure(dataset: xr.Dataset) -> Figure:
    """Energies, each effect's work and heating, and the errors of energy and of the ledger.

    >>> print([axes.get_ylabel().split(" (")[0] for axes in energy_figure(ds).axes])
    ['energy', 'energy given', 'relative size']
    """
    with style.styled():
        drawn = [(_energies, 1.8), *([(_given, 1.5)] if moved(dataset, "work", "heating") else []), (_errors, 1.3)]
        figure = style.begin(dataset, "energy", (9.0, 2.0 * sum(height for _, height in drawn)))
        panels = figure.subplots(len(drawn), 1, height_ratios=[height for _, height in drawn])
        for (draw, _), axes in zip(drawn, panels, strict=True):
            draw(axes, dataset)
            style.time_axis(axes, dataset, last=axes is panels[-1])
        return figure


def _energies(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    present = [kind for kind in _KINDS if has_values(dataset, kind[0])]
    scale, unit = style.scale_of(style.unit_of(dataset["total_energy"]), *(dataset[kind[0]].values for kind in present))
    bands: list[Band] = []
    for name, text, colour, dashes in present:
        size = float(abs(dataset[name]).max())
        if name == "rotational_energy" and size < 1e-6 * scale:
            continue
        if name == "rotational_energy" and float(abs(dataset["kinetic_energy"] - dataset[name]).max()) < 1e-6 * size:
            continue  # all of the motion is the mean angular velocity, so the two would lie on each other
        axes.plot(times, dataset[name] / scale, color=colour, linestyle=dashes, label=text)
        bands.append((dataset[name].values / scale, error_of(dataset, name, scale), colour))
    others = dataset["potential_energy"] - dataset["gravitational_energy"].fillna(0.0)
    if has_values(dataset, "potential_energy") and float(abs(others).max()) > 1e-6 * scale:
        axes.plot(times, others / scale, color=style.SKY, label="other potentials")
    # Wide and pale behind the others, which may lie on it.
    axes.plot(
        times, dataset["total_energy"] / scale, color=style.INK, linewidth=5, alpha=0.4, zorder=1.8, label="total"
    )
    bands.append((dataset["total_energy"].values / scale, error_of(dataset, "total_energy", scale), style.INK))
    shade(axes, times, bands)
    axes.axhline(0, color=style.GREY, linewidth=0.8)
    axes.set(ylabel=style.label("energy", unit), title="Where the energy is")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    style.mark_compression(axes, dataset, factor, named=True)


def _given(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    names = [str(name) for name in dataset["effect"].values]
    work, heating = (np.nan_to_num(dataset[name].transpose("time", "effect").values) for name in ("work", "heating"))
    axes.set_title("What each effect has given since the start")
    scale, unit = style.scale_of(style.unit_of(dataset["work"]), work, heating)
    floor = 1e-9 * max(float(abs(work).max()), float(abs(heating).max()))
    for name in known_effects(dataset, "work"):
        index = names.index(name)
        colour = style.effect_colour(name, names)
        style.curve(axes, times, work[:, index] / scale, color=colour, label=f"{style.words(name)}: work")
        if abs(heating[:, index]).max() > floor:
            axes.plot(
                times, heating[:, index] / scale, color=colour, linestyle=(0, (4, 2)),
                label=f"{style.words(name)}: heating",
            )  # fmt: skip
    axes.axhline(0, color=style.GREY, linewidth=0.8)
    axes.set_ylabel(style.label("energy given", unit))
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    style.mark_compression(axes, dataset, factor)


def _errors(axes, dataset: xr.Dataset) -> None:
    times, factor, _ = style.shown_times(dataset)
    largest = energy_scale(dataset)
    axes.set_title("Change of the total, and what no effect accounts for, over the largest energy")
    total = dataset["total_energy"].values
    error = abs(dataset["integration_energy_error"].values) / largest
    lines = [
        (abs(total - total[0]) / largest, "change of the total", {"color": style.GREY, "linewidth": 3.2, "alpha": 0.6}),
        (error, "integration error", {"color": style.VERMILLION}),
        (dataset["ledger_closure"].values, "ledger closure", {"color": style.GREEN}),
    ]
    style.relative_sizes(axes, times, lines, loc="center left", bbox_to_anchor=(1.0, 0.5))
    style.mark_compression(axes, dataset, factor)
