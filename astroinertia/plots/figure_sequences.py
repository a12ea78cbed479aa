"""Homogeneous ellipsoids in one picture: bodies with their flow, where they exist, how they spin, what tears them."""

import math
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from astroinertia.bodies import jacobi, maclaurin, riemann
from astroinertia.bodies.ellipsoid_secular import FrictionalModes, radiative_modes, viscous_modes
from astroinertia.bodies.ellipsoid_stability import spectrum
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.bodies.riemann import RiemannEllipsoid
from astroinertia.plots import style
from astroinertia.plots.ellipsoid import draw_curves, draw_ellipsoid, view_of

MACLAURIN, JACOBI, DEDEKIND, IRROTATIONAL = style.INK, style.BLUE, style.GREEN, style.PURPLE
COMPACTNESS, VISCOSITY = 0.2, 1e-3  # G M/(R c^2), and nu/(R^2 (pi G rho)^(1/2)), of the growth times that are drawn
_SHOWN = 0.8  # of a panel's half-width, the mean radius of a body
_LEVELS = (-0.55, 0.0, 0.55)  # of the polar axis, at which streamlines are drawn
_LABELLED = (-1.0, -0.5, 0.5, 1.0)  # f of the thin lines
_OUTLINE: Any = [withStroke(linewidth=2.5, foreground="white")]


def figure_sequences(points: int = 40) -> Figure:
    """Maclaurin, Jacobi, Dedekind and Riemann S figures, with their stability to second harmonics.

    points: the number of figures along each line, and of axis ratios of the map in both directions; ValueError below 8.
    Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium. Test: tests/unit/plots/test_figure_sequences.py.

    >>> print(figure_sequences(10).axes[6].get_title(loc="left"))
    Where Riemann ellipsoids exist
    """
    if points < 8:
        raise ValueError(f"the sequences need at least 8 points, not {points!r}")
    with style.styled():
        figure = style.page("Homogeneous figures of equilibrium", (13.2, 9.4))
        halves: Any = figure.subfigures(2, 1, height_ratios=[1.0, 2.75])
        upper, lower = halves
        for panel, (body, name, colour) in zip(upper.subplots(1, 6), _bodies(), strict=True):
            _draw_body(panel, body, name, colour)
        left, right = lower.subfigures(1, 2, width_ratios=[1.0, 1.0])
        _map(left, points)
        spin, growth = right.subplots(2, 1)
        _spins(spin, points)
        _growth(growth, points)
        return figure


def _bodies() -> list[tuple[HomogeneousEllipsoid, str, str]]:
    return [
        (maclaurin.from_eccentricity(0.5), "Maclaurin, $e$ = 0.5", MACLAURIN),
        (maclaurin.bifurcation(), "Maclaurin, $e$ = 0.8127:\nsecular limit", MACLAURIN),
        (maclaurin.dynamical_limit(), "Maclaurin, $e$ = 0.9529:\ndynamical limit", MACLAURIN),
        (jacobi.pear_bifurcation(), "Jacobi, $b/a$ = 0.432:\nturns rigidly", JACOBI),
        (riemann.dedekind(0.55), "Dedekind, $b/a$ = 0.55:\nrests, the fluid runs round", DEDEKIND),
        (riemann.irrotational(0.55), "irrotational, $b/a$ = 0.55:\nturns, without vorticity", IRROTATIONAL),
    ]


def _draw_body(panel, body: HomogeneousEllipsoid, name: str, colour: str) -> None:
    lengths = _SHOWN * body.axes / body.mean_radius
    view = view_of(np.eye(3))
    draw_ellipsoid(panel, lengths, np.eye(3), view, "#d9c8a9")
    if isinstance(body, RiemannEllipsoid):
        turn = np.linspace(0, 2 * np.pi, 181)
        ring = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
        for level in _LEVELS:
            curve = (ring * math.sqrt(1 - level**2) + [0, 0, level]) * lengths
            draw_curves(panel, curve[None], lengths**-2, np.eye(3), view, 1.0, colour, 1.3)
    panel.set(xlim=(-1.38, 1.38), ylim=(-1.6, 1.0))
    panel.text(0.5, 0.0, name, transform=panel.transAxes, ha="center", va="bottom", fontsize=9.5, color=colour)


def _map(figure, points: int) -> None:
    """Where ellipsoids exist, and how fast they are torn up, over both axis ratios."""
    panel = figure.subplots(1, 1)
    ratios = np.concatenate([np.geomspace(0.02, 0.1, points // 4, endpoint=False), np.linspace(0.1, 1.0, points)])
    turns = np.tan(np.linspace(-1, 1, points | 1) * np.pi / 4)  # Lambda/Omega from -1 to 1
    bodies = [[riemann.from_rate_ratio(float(b), float(x)) for x in turns] for b in ratios]
    heights = np.array([[body.c_over_a for body in row] for row in bodies])
    unit = math.sqrt(math.pi * bodies[0][0].density)
    growth = np.array([[spectrum(body).growth_rate / unit for body in row] for row in bodies])
    growth[-1] = 0.0  # a spheroid has its own colours
    colours = LinearSegmentedColormap.from_list("growth", ["#e4eef6", "#fbd9a6", style.ORANGE, style.VERMILLION])
    across = np.broadcast_to(ratios[:, None], heights.shape)
    mesh = panel.pcolormesh(across, heights, growth, cmap=colours, shading="gouraud", vmin=0, rasterized=True)
    for x, text, place in ((1.0, r"$\Omega = \Lambda$", (0.83, 0.235)), (-1.0, r"$\Omega = -\Lambda$", (0.40, 0.60))):
        column = 0 if x < 0 else -1
        panel.plot(ratios, heights[:, column], color=style.GREY, linewidth=1.2)
        panel.text(*place, text, fontsize=9.5, color=style.GREY, ha="center")
    for f in _LABELLED:
        line = np.array([[b, riemann.from_vorticity_ratio(float(b), f).c_over_a] for b in ratios])
        panel.plot(*line.T, color=style.GREY, linewidth=0.6)
        panel.text(0.985, line[-1, 1], f"$f={f:g}$", fontsize=8, color=style.GREY, ha="right", va="center",
                   path_effects=_OUTLINE)  # fmt: skip
    _mapped_sequences(panel, ratios)
    panel.set(xlim=(0, 1.06), ylim=(0, 1.04), aspect="equal", xlabel="$b/a$")
    panel.set(ylabel="$c/a$, along the axis of rotation", title="Where Riemann ellipsoids exist")
    bar = figure.colorbar(mesh, ax=panel, orientation="horizontal", shrink=0.7, aspect=32, pad=0.02)
    bar.set_label(r"growth rate of second harmonics$\,/\sqrt{\pi G\rho}$; pale: stable")
    bar.outline.set_visible(False)


def _mapped_sequences(panel, ratios: np.ndarray) -> None:
    pear = jacobi.pear_bifurcation()
    lines = {
        "Jacobi and Dedekind": (JACOBI, 0.0, (0.75, 0.447), 17),
        "irrotational": (IRROTATIONAL, -2.0, (0.66, 0.735), 36),
    }
    for name, (colour, f, place, slope) in lines.items():
        line = np.array([[b, riemann.from_vorticity_ratio(float(b), f).c_over_a] for b in ratios])
        panel.plot(*line.T, color=colour, linewidth=2.2)
        panel.text(*place, name, color=colour, fontsize=9.5, rotation=slope, ha="center", va="bottom",
                   rotation_mode="anchor", path_effects=_OUTLINE)  # fmt: skip
    fork, limit = maclaurin.bifurcation().c_over_a, maclaurin.dynamical_limit().c_over_a
    for ends, dashes in (((fork, 1.0), "-"), ((limit, fork), (0, (4, 1.5))), ((0.0, limit), (0, (1, 1.2)))):
        panel.plot([1.0, 1.0], ends, color=MACLAURIN, linewidth=2.6, linestyle=dashes, solid_capstyle="butt")
    panel.text(1.02, 0.8, "Maclaurin", color=MACLAURIN, fontsize=9.5, rotation=90, va="center")
    panel.plot([1.0, 1.0], [fork, limit], "o", color="white", markeredgecolor=MACLAURIN, markersize=6, zorder=5)
    panel.plot(pear.b_over_a, pear.c_over_a, "D", color="white", markeredgecolor=JACOBI, markersize=5.5, zorder=5)
    panel.annotate("pear", (pear.b_over_a, pear.c_over_a), xytext=(7, -9), textcoords="offset points", fontsize=8.5,
                   color=JACOBI, path_effects=_OUTLINE)  # fmt: skip


def _spins(panel, points: int) -> None:
    """Omega^2 against angular momentum."""
    fork, limit = maclaurin.bifurcation(), maclaurin.dynamical_limit()
    ends = [0.01, fork.second_eccentricity, limit.second_eccentricity, 12.0]
    styles = (
        ("-", "stable"),
        ((0, (4, 1.5)), "unstable with friction, or to pears"),
        ((0, (1, 1.2)), "unstable without friction"),
    )
    for begin, end, (dashes, name) in zip(ends[:-1], ends[1:], styles, strict=True):
        bodies = [maclaurin.from_second_eccentricity(float(l)) for l in np.geomspace(begin, end, points)]  # noqa: E741
        panel.plot(*_spin(bodies), color=MACLAURIN, linestyle=dashes, label=name)
    pear = jacobi.pear_bifurcation().b_over_a
    for ratios, dashes in ((np.linspace(1, pear, points), "-"), (np.linspace(pear, 0.12, points), (0, (4, 1.5)))):
        panel.plot(*_spin([jacobi.from_axis_ratio(float(b)) for b in ratios]), color=JACOBI, linestyle=dashes)
    for colour, f in ((IRROTATIONAL, -2.0), (DEDEKIND, math.inf)):
        panel.plot(*_spin([riemann.from_vorticity_ratio(b, f) for b in np.linspace(1, 0.12, points)]), color=colour)
    named = {
        "Maclaurin": (MACLAURIN, 0.145, 0.17), "Jacobi": (JACOBI, 0.44, 0.285), "Dedekind": (DEDEKIND, 0.32, -0.002),
        "irrotational": (IRROTATIONAL, 0.33, 0.135),
    }  # fmt: skip
    for name, (colour, *place) in named.items():
        side = "right" if name == "Maclaurin" else "left"
        panel.text(*place, name, color=colour, fontsize=9.5, ha=side, path_effects=_OUTLINE)
    panel.plot(*_spin([fork]), "o", color="white", markeredgecolor=MACLAURIN, zorder=5)
    panel.plot(*_spin([limit]), "o", color="white", markeredgecolor=MACLAURIN, zorder=5)
    panel.set(xlim=(0, 0.85), ylim=(-0.012, 0.68), xlabel=r"$L\,/\sqrt{GM^3R}$", ylabel=r"$\Omega^2/\pi G\rho$")
    panel.set_title("How they spin")
    panel.legend(loc="upper right", fontsize=8.5, handlelength=2.6)


def _spin(bodies) -> tuple[list[float], list[float]]:
    return [body.angular_momentum for body in bodies], [body.omega2 for body in bodies]


def _growth(panel, points: int) -> None:
    """Growth of bars along the Maclaurin sequence, by viscosity, radiation and without friction."""
    first, second = (
        body.rotational_to_gravitational for body in (maclaurin.bifurcation(), maclaurin.dynamical_limit())
    )
    share = np.sin(np.linspace(0, np.pi / 2, points + 2)[1:-1]) ** 2  # crowded at both ends, where rates change
    slow = first + (second - first) * share
    bodies = [maclaurin.from_energy_ratio(float(ratio)) for ratio in slow]
    unit = math.sqrt(math.pi * bodies[0].density)
    light = 1 / math.sqrt(COMPACTNESS)
    viscous = [_fastest(viscous_modes(body, VISCOSITY * unit)) / unit for body in bodies]
    radiative = [_fastest(radiative_modes(body, light)) / unit for body in bodies]
    fast = second + (0.42 - second) * np.linspace(0, 1, points) ** 2
    dynamical = [spectrum(maclaurin.from_energy_ratio(float(ratio))).growth_rate / unit for ratio in fast[1:]]
    panel.plot(slow, viscous, color=style.SKY, label=rf"viscosity, $\nu = {VISCOSITY:g}\,R^2\sqrt{{\pi G\rho}}$")
    panel.plot(slow, radiative, color=style.GREEN, label=f"gravitational radiation, $GM/Rc^2 = {COMPACTNESS:g}$")
    panel.plot(fast[1:], dynamical, color=style.VERMILLION, label="without friction")
    for at, name in ((first, "$e$ = 0.8127"), (second, "$e$ = 0.9529")):
        panel.axvline(at, color=style.GREY, linewidth=0.8, linestyle=(0, (2, 2)), zorder=0.5)
        panel.annotate(name, (at, 1.0), xycoords=("data", "axes fraction"), xytext=(4, -3), textcoords="offset points",
                       fontsize=8.5, color=style.GREY, va="top")  # fmt: skip
    panel.set(yscale="log", ylim=(1e-7, 2.0), xlim=(0.1, 0.42), xlabel="$T/|W|$ of Maclaurin spheroids")
    panel.set(ylabel=r"growth rate$\,/\sqrt{\pi G\rho}$", title="What makes bars grow")
    panel.legend(loc="lower right", fontsize=8.5)


def _fastest(modes: FrictionalModes) -> float:
    return float(np.max(np.real(modes.changes)))
