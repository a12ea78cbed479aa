"""The ledger: which effect does what to the size, the shape and the spin."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style
from astroinertia.plots.axis_scales import angular_impulse, angular_momentum_scale


@with_absent
def ledger_figure(dataset: xr.Dataset) -> Figure:
    """Each effect's share in d2I_zz/dt2, absolute and relative, and the angular momentum that each has given.

    >>> figure = ledger_figure(ds)
    >>> print({"gravity", "pressure", "viscosity"} <= {line.get_label() for line in figure.axes[0].lines})
    True
    """
    with style.styled():
        impulse = angular_impulse(dataset)
        turned, none = bool((abs(impulse) > 0).any()), not _above_round_off(dataset, impulse)
        figure = style.begin(dataset, "the ledger of effects", (9.0, 6.8 + 2.4 * turned - 1.4 * (turned and none)))
        panels = list(figure.subplots(2 + turned, 1, height_ratios=[1.7, 1.5, 0.35 if none else 1.3][: 2 + turned]))
        top = panels[0]
        shares = dataset.inertia.acceleration_shares("z")
        _absolute(top, dataset, shares)
        _relative(panels[1], dataset, shares)
        if turned:
            _angular_momentum(panels[2], dataset, impulse)
        for axes in panels:
            style.time_axis(axes, dataset, last=axes is panels[-1])
        names = _present(shares)
        handles, texts = top.get_legend_handles_labels()
        figure.legend(handles, texts, loc="outside lower center", ncols=min(len(names) + 1, 6))
        return figure


def _absolute(axes, dataset: xr.Dataset, shares: xr.DataArray) -> None:
    times, factor, _ = style.shown_times(dataset)
    scale, unit = style.scale_of(style.unit_of(shares), shares.values)
    names = [str(name) for name in shares["share"].values]
    for name in _present(shares):
        dashes, said = ((0, (4, 2)), "motion (kinetic tensor)") if name == "motion" else ("-", style.words(name))
        colour = style.effect_colour(name, names)
        axes.plot(times, shares.sel(share=name) / scale, color=colour, linestyle=dashes, label=said)
    total = shares.sum("share").values
    axes.plot(times, total / scale, color=style.GREY, linewidth=3.2, alpha=0.55, label="all together", zorder=1.5)
    spread = np.nanmax(abs(shares.values)), np.median(np.nansum(abs(shares.values), axis=1))
    if spread[0] > 30 * spread[1] > 0:
        _signed_log(axes, shares.values / scale, spread[1] / scale)
    axes.axhline(0, color=style.GREY, linewidth=0.8)
    axes.set_ylabel(style.label("share in d$^2I_{zz}$/d$t^2$", unit))
    axes.set_title(r"What drives the moment of inertia:  d$^2I$/d$t^2$ from motion and from each effect")
    style.mark_compression(axes, dataset, factor, named=True)


def _signed_log(axes, values: np.ndarray, middle: float) -> None:
    threshold = 10.0 ** np.floor(np.log10(middle))
    axes.set_yscale("symlog", linthresh=threshold, linscale=0.6)
    decades = int(np.ceil(np.log10(np.nanmax(abs(values)) / threshold)))
    every = max(1, decades // 3)
    levels = threshold * 10.0 ** np.arange(0, decades + 1, every)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    axes.set_yticks(
        [-level for level in levels[::-1] if -level > 2 * low] + [0.0] + [x for x in levels if x < 2 * high]
    )
    axes.minorticks_off()


def _relative(axes, dataset: xr.Dataset, shares: xr.DataArray) -> None:
    times, factor, _ = style.shown_times(dataset)
    size = abs(shares).sum("share")
    relative = (shares / size.where(size > 0)).fillna(0.0)
    names = [str(name) for name in shares["share"].values]
    colours = [style.effect_colour(name, names) for name in names]
    for sign in (1.0, -1.0):
        axes.stackplot(
            times, *(np.maximum(sign * relative.sel(share=name).values, 0.0) * sign for name in names),
            colors=colours, alpha=0.72, linewidth=0,
        )  # fmt: skip
    axes.plot(times, relative.sum("share"), color="white", linewidth=3.6)
    axes.plot(times, relative.sum("share"), color=style.INK, linewidth=1.4)
    axes.axhline(0, color="white", linewidth=0.8)
    outward, inward = (relative.clip(low, high).sum("share") for low, high in ((0, None), (None, 0)))
    axes.set_ylim(1.12 * min(float(inward.min()), -0.05), 1.12 * max(float(outward.max()), 0.05))
    axes.grid(False)
    axes.set(ylabel="share", title="The same as shares of all pushing, outward and inward; the line is the sum")
    style.mark_compression(axes, dataset, factor)


def _above_round_off(dataset: xr.Dataset, impulse: np.ndarray) -> bool:
    size = angular_momentum_scale(dataset)[0]
    return bool(np.nanmax(np.linalg.norm(impulse, axis=-1), initial=0.0) > np.finfo(float).eps * size)


def _angular_momentum(axes, dataset: xr.Dataset, impulse: np.ndarray) -> None:
    times, factor, _ = style.shown_times(dataset)
    axes.set_title("Angular momentum that each effect has given since the start")
    size, turning = angular_momentum_scale(dataset)
    names = [str(name) for name in dataset["effect"].values]
    sizes = np.linalg.norm(impulse, axis=-1) / size
    if not _above_round_off(dataset, impulse):
        style.note(axes, "none has given any, to round-off", timed=True)
        return
    for index, name in enumerate(names):
        values = np.where(sizes[:, index] > 0, sizes[:, index], np.nan)
        axes.semilogy(times, values, color=style.effect_colour(name, names), linewidth=1.4)
    round_off = float(np.finfo(float).eps)
    low, high = style.robust_limits(sizes, 0.1 * round_off)
    axes.set_ylim(low, high)
    style.plain_log(axes.yaxis, low, high)
    if low < round_off:
        style.level(axes, round_off, "round-off", style.GREY)
    axes.set_ylabel(r"$|\Delta L_e|\,/\,|L|$" if turning else r"$|\Delta L_e|$ / largest possible")
    style.mark_compression(axes, dataset, factor)


def _present(shares: xr.DataArray) -> list[str]:
    """Motion and the effects that the model has; rows of effects that it skips are NaN."""
    return [str(name) for name in shares["share"].values[shares.notnull().any("time").values]]
