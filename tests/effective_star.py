"""Cold stars in hydrostatic equilibrium under the effective relativistic potential: a reference without particles.

In G = c = 1, with H = ln(1 + eta), eta = (e + P)/rho - 1, from the centre outwards (Marek et al. 2006, A&A 445, 273,
case A at rest):

    dH/dr = -(m + 4 pi r^3 P)/(r^2 Gamma^2),   dm/dr = 4 pi r^2 e Gamma,   dM/dr = 4 pi r^2 rho,   Gamma^2 = 1 - 2 m/r.

The first is that of TOV: what differs is Gamma in m, and a rest mass M in flat space. Without Gamma in m and with it
under M these are the equations of TOV.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from astroinertia.matter.compact_stars import Barotrope

_START = 1e-4  # radius, in G Msun/c^2


@dataclass(frozen=True)
class EffectiveStar:
    """Radii from the centre to the surface, mass m, rest mass M, density, pressure and specific energy there, (K,)."""

    radius: np.ndarray
    mass: np.ndarray
    rest_mass: np.ndarray
    density: np.ndarray
    pressure: np.ndarray
    energy: np.ndarray


def effective_star(matter: Barotrope, rest_mass: float, points: int = 2000) -> EffectiveStar:
    """The star of that rest mass, of those whose centre has eta between 0.1 and 0.6."""
    central = brentq(lambda eta: _integrated(matter, eta).y[2, -1] - rest_mass, 0.1, 0.6, xtol=1e-9)
    solution: Any = _integrated(matter, central)
    radius = np.linspace(_START, solution.t[-1], points)
    enthalpy, mass, rest = solution.sol(radius)
    eta = np.expm1(np.maximum(enthalpy, 1e-9))
    density, pressure, _ = np.array([matter.piece_at(value).at(value) for value in eta]).T
    return EffectiveStar(radius, mass, rest, density, pressure, eta - pressure / density)


def _integrated(matter: Barotrope, central: float) -> Any:
    def slopes(r: float, values: np.ndarray) -> list[float]:
        enthalpy, mass, _ = values
        eta = math.expm1(max(enthalpy, 1e-12))
        density, pressure, _ = matter.piece_at(eta).at(eta)
        square, area = 1 - 2 * mass / r, 4 * math.pi * r**2
        pull = (mass + area * r * pressure) / (r**2 * square)
        return [-pull, area * (density * (1 + eta) - pressure) * math.sqrt(square), area * density]

    def surface(r: float, values: np.ndarray) -> float:
        return values[0]

    surface.terminal = True  # type: ignore[attr-defined]
    density, pressure, _ = matter.piece_at(central).at(central)
    volume = 4 / 3 * math.pi * _START**3
    start = [math.log1p(central), volume * (density * (1 + central) - pressure), volume * density]
    return solve_ivp(
        slopes, (_START, 100.0), start, rtol=1e-8, atol=1e-12, events=surface, dense_output=True, max_step=0.1
    )
