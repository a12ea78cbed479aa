"""What a standard problem is made of: its particles at time 0, and what they should be later.

Particles are put on face-centred cubic lattices that fill boxes: close-packed, as a settled fluid of equal masses is.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from astroinertia.errors import SceneError

# Kind in a scene: the module of astroinertia.test_problems, and the function's first arguments there.
PROBLEMS = {
    "sod": ("shock_tube", "SOD"),
    "strong_tube": ("shock_tube", "STRONG"),
    "sedov": ("sedov", "SEDOV"),
    "noh": ("noh", "NOH"),
    "gresho": ("gresho", "GRESHO"),
    "kelvin_helmholtz": ("kelvin_helmholtz", "KELVIN_HELMHOLTZ"),
    "square": ("square", "SQUARE"),
    "keplerian_disc": ("keplerian_disc", "KEPLERIAN_DISC"),
}


@dataclass(frozen=True)
class Matter:
    """mass (N,), position (N, 3), velocity (N, 3) and specific internal energy (N,)."""

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray


@dataclass(frozen=True)
class Solution:
    """density (N,), velocity (N, 3) and pressure (N,) that the exact flow has at some points."""

    density: np.ndarray
    velocity: np.ndarray
    pressure: np.ndarray


def _everywhere(position: np.ndarray, time: float, lengths: np.ndarray) -> np.ndarray:
    return np.ones(len(position), bool)


@dataclass(frozen=True)
class Standard:
    """A problem: how its matter is placed, and its exact flow where there is one.

    place(count, lengths, gamma); exact(position, time, lengths, gamma), None where it is known of other quantities.
    boxed: whether it fills a periodic box; the lengths of another are infinite. compared(position, time, lengths):
    where errors are taken, (N,) bool. begins(mass, gamma): time from which particles of that mass follow the exact
    flow, where that is not at once.
    """

    place: Callable[[int, np.ndarray, float], Matter]
    exact: Callable[[np.ndarray, float, np.ndarray, float], Solution] | None
    boxed: bool
    source: str
    compared: Callable[[np.ndarray, float, np.ndarray], np.ndarray] = _everywhere
    begins: Callable[[float, float], float] | None = None


def standard(problem: str) -> Standard:
    """The problem of that name, importing no other; KeyError for one that is unknown."""
    module, name = PROBLEMS[problem]
    return getattr(import_module(f"astroinertia.test_problems.{module}"), name)


def l1_errors(computed: Any, exact: Solution, chosen: np.ndarray) -> dict[str, float]:
    """Mean |f - f_exact| over the largest |f_exact|, of density, velocity and pressure, over chosen particles.

    The norm of Price 2007 (PASA 24, 159, appendix); of velocities the length of the difference is taken.
    """
    errors = {}
    for name in ("density", "velocity", "pressure"):
        value, right = np.asarray(getattr(computed, name))[chosen], getattr(exact, name)[chosen]
        apart, size = np.abs(value - right), np.abs(right)
        if value.ndim == 2:
            apart, size = np.linalg.norm(value - right, axis=1), np.linalg.norm(right, axis=1)
        largest = float(size.max(initial=0.0))
        errors[name] = float(apart.mean()) / (largest if largest > 0.0 else 1.0)
    return errors


MOST_OVER = 8.0  # times the number of particles that was asked for, or the fewest that a body has
FEWEST = 16.0
BASIS = np.array([[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]])  # of a unit cell


def filled(cells: tuple[int, int, int], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Positions (4 n_x n_y n_z, 3) of a lattice with so many unit cells from one corner of a box to the other."""
    corners = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    fractions = (corners + BASIS).reshape(-1, 3) / np.array(cells)
    return low + fractions * (np.asarray(high) - low)


def cells_for(count: float, lengths: np.ndarray, even: bool = False) -> tuple[int, int, int]:
    """Unit cells along each side of a box, as near to cubes as it allows, that hold about so many particles."""
    side = (np.prod(lengths) * 4.0 / count) ** (1 / 3)
    step = 2 if even else 1
    cells = tuple(int(step * max(1, round(length / (step * side)))) for length in lengths)
    # A side shorter than a cell has one all the same, and with it many more particles than were asked for.
    if 4 * math.prod(cells) > MOST_OVER * max(count, FEWEST):
        raise SceneError(
            f"a box of {' by '.join(f'{length:.3g}' for length in lengths)} is too flat for a lattice of about "
            f"{count:.0f} particles: it would have {4 * math.prod(cells):.3g}; make its sides more alike, or ask for "
            "more particles."
        )
    return cells  # type: ignore[return-value]


def in_box(position: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Where particles (N, 3), or their images, lie in a box around the origin that repeats itself."""
    return position - lengths * np.round(position / lengths)


def centred(lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corner of a box around the origin."""
    half = 0.5 * np.asarray(lengths)
    return -half, half
