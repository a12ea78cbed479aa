"""What a standard problem is made of: its particles at time 0, and what they should be later."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

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
