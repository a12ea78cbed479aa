"""A rotor before and after balancing: its two unbalance vectors, and its products of inertia."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from astroinertia.inertia.balancing import unbalance_of_body
from astroinertia.inertia.body import Body
from astroinertia.plots import style

BEFORE, AFTER = style.VERMILLION, style.BLUE
SMALLEST = 1e-17  # of the reference: below the round-off of a sum; less is shown as this
_REACH = 1.3  # of a panel, in lengths of the longest vector
_STATES = (("before", BEFORE), ("after", AFTER))


def balance_figure(before: Body, after: Body, mass_unit: str = "kg", length_unit: str = "m", name: str = "") -> Figure:
    """Static and dynamic unbalance as vectors that turn with the rotor, and the products of inertia they come from.

    The rotor spins about z through the origin. The last panel shows shares of M k for the static unbalance, and of
    I_zz = M k^2 for the products.

    >>> from astroinertia.inertia import shapes
    >>> wheel = shapes.disc(10.0, 0.3)
    >>> figure = balance_figure(wheel + shapes.point(0.02, (0.3, 0.0, 0.05)), wheel)
    >>> print([axes.get_title(loc="left") for axes in figure.axes][2])
    Unbalance and products of inertia
    """
    with style.styled():
        figure = style.page(f"{name}: balancing" if name else "balancing", (12.0, 4.6))
        panels: Any = figure.subplots(1, 3, width_ratios=[1, 1, 1.25])
        pairs = zip(unbalance_of_body(before), unbalance_of_body(after), strict=True)
        titles = ("Static: $U = M\\,c$", "Dynamic: $D = -(I_{xz}, I_{yz})$")
        units = (_product(mass_unit, length_unit), _product(mass_unit, length_unit, 2))
        for panel, vectors, title, unit in zip(panels[:2], pairs, titles, units, strict=True):
            _vectors(panel, [np.asarray(vector) for vector in vectors], title, unit)
        _shares_moved(panels[2], before, after)
        return figure


def _product(mass_unit: str, length_unit: str, power: int = 1) -> str:
    if mass_unit == "1":
        return "1"
    return f"{mass_unit} {length_unit}{power if power > 1 else ''}"


def _vectors(panel, vectors: list[np.ndarray], title: str, unit: str) -> None:
    scale, unit = style.scale_of(unit, *vectors)
    reach = max(float(np.linalg.norm(vector)) for vector in vectors) / scale or 1.0
    for share in (0.5, 1.0):
        panel.add_patch(Circle((0, 0), share * reach, fill=False, color=style.PALE, linewidth=0.8))
    for (state, colour), vector in zip(_STATES, vectors, strict=True):
        panel.plot([], [], color=colour, linewidth=2.4, label=state)
        u, v = vector / scale
        if np.hypot(u, v) > 0.04 * reach:
            panel.annotate(
                "", (u, v), (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.4,
                                                "shrinkA": 0, "shrinkB": 0}, zorder=4,
            )  # fmt: skip
        else:
            panel.plot(u, v, "o", color=colour, markersize=7, zorder=5)
    panel.set(aspect="equal", xlim=(-_REACH * reach, _REACH * reach), ylim=(-_REACH * reach, _REACH * reach))
    panel.set(xlabel=style.label("along $x$ of the rotor", unit), ylabel=style.label("along $y$", unit), title=title)
    panel.legend(loc="upper right")


def _shares_moved(panel, before: Body, after: Body) -> None:
    rows = ("$U_x$", "$U_y$", "$I_{xz}$", "$I_{yz}$", "$I_{xy}$\n(harmless)")  # to a rotor that turns about z
    shares = [np.maximum(_shares(body), SMALLEST) for body in (before, after)]
    for row, ends in enumerate(zip(*shares, strict=True)):
        panel.plot(ends, (row, row), color=style.PALE, linewidth=3.0, zorder=2)
    for (_, colour), share, size in zip(_STATES, shares, (11, 6), strict=True):
        panel.plot(share, range(len(rows)), "o", color=colour, markersize=size, zorder=3, clip_on=False)
    panel.set_xscale("log")
    panel.set_yticks(range(len(rows)), rows)
    panel.set_ylim(len(rows) - 0.4, -0.6)
    low, round_off = max(float(np.min(shares)) / 30, SMALLEST), float(np.finfo(float).eps)
    panel.set_xlim(low, 3 * max(float(np.max(shares)), 1e-3))
    if low < round_off:
        panel.axvline(round_off, color=style.GREEN, linewidth=1, linestyle="--", zorder=1)
        panel.annotate(
            "round-off", (round_off, 1.0), xycoords=("data", "axes fraction"), xytext=(4, -2),
            textcoords="offset points", fontsize=8, color=style.GREEN, va="top",
        )  # fmt: skip
    panel.set(xlabel="share of $M k$ and of $I_{zz} = M k^2$", title="Unbalance and products of inertia")


def _shares(body: Body) -> np.ndarray:
    inertia = np.asarray(body.about(np.zeros(3)))
    static, _ = unbalance_of_body(body)
    arm = np.sqrt(abs(inertia[2, 2] / body.mass))
    products = np.array([inertia[0, 2], inertia[1, 2], inertia[0, 1]])
    return abs(np.concatenate([np.asarray(static) / (body.mass * arm), products / inertia[2, 2]]))
