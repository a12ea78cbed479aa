"""Cold matter of several exponents, and the equation of state of core collapse: that with a thermal part.

Tests: tests/unit/matter/test_gases_and_cold_matter.py.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from astroinertia.engines.elementwise import elementwise
from astroinertia.engines.pytree import pytree
from astroinertia.matter.gases import (
    Barotropic,
    Ideal,
    check,
    entropy_per_energy,
    polytrope_energy,
    polytrope_pressure,
    polytrope_stiffness,
)

# Newtonian core collapse: relativistic degenerate electrons at an electron fraction of one half, in SI.
# K = 4.897e14 in cgs, whatever gamma_1: the pressure at 1 g/cm^3 is 4.897e14 dyn/cm^2. A gamma_1 below 4/3 at the same
# K is the pressure deficit that starts the collapse (Zwerger & Mueller 1997; Dimmelmeier et al. 2002, sect. 2.2 and 3).
CORE_COLLAPSE = {
    "reference_density": 1.0e3,  # kg/m^3
    "reference_pressure": 4.897e13,  # Pa
    "nuclear_density": 2.0e17,  # kg/m^3
    "gamma_1": 1.325,  # 1.28 to 1.325 in the papers
    "gamma_2": 2.5,
    "gamma_thermal": 1.5,
}


def piece_state(xp, rho, pressure, stiffness, energy, start, gamma, K, offset):
    """P, c^2 and u of a piece above its start; below it, those given."""
    above = rho >= start
    return (
        xp.where(above, polytrope_pressure(xp, rho, K, gamma), pressure),
        xp.where(above, polytrope_stiffness(xp, rho, K, gamma), stiffness),
        xp.where(above, polytrope_energy(xp, rho, K, gamma) + offset, energy),
    )


@pytree
@dataclass(frozen=True)
class PiecewisePolytropic(Barotropic):
    """P = K_i rho^gamma_i between the densities, with P and u continuous and K_0 = constant.

    `gammas` has one number more than `densities`, which ascend. Source: Read et al. 2009, PRD 79, 124032, eqs. 1-7
    (here without the rest mass).
    """

    densities: tuple[float, ...]
    gammas: tuple[float, ...]
    constant: float

    def _pieces(self):
        """Yield (density where the piece begins, gamma, K, constant of integration of u)."""
        start, gamma, constant, offset = 0.0, self.gammas[0], self.constant, 0.0
        yield start, gamma, constant, offset
        for start, following in zip(self.densities, self.gammas[1:], strict=True):
            specific = constant * start ** (gamma - 1)
            offset = offset + specific / (gamma - 1) - specific / (following - 1)
            constant = constant * start ** (gamma - following)
            gamma = following
            yield start, gamma, constant, offset

    def _choose(self, xp, rho, formula):
        result = None
        for start, gamma, constant, offset in self._pieces():
            value = formula(gamma, constant, offset)
            result = value if result is None else xp.where(rho >= start, value, result)
        return result

    def pressure(self, xp, rho, A):
        """P, like rho."""
        return self._choose(xp, rho, lambda gamma, K, offset: polytrope_pressure(xp, rho, K, gamma))

    def internal_energy(self, xp, rho, A):
        """Specific internal energy u, like rho."""
        return self._choose(xp, rho, lambda gamma, K, offset: polytrope_energy(xp, rho, K, gamma) + offset)

    def squared_sound_speed(self, xp, rho):
        """c^2, like rho."""
        return self._choose(xp, rho, lambda gamma, K, offset: polytrope_stiffness(xp, rho, K, gamma))

    def sound_speed(self, xp, rho, A):
        """Adiabatic sound speed, like rho."""
        return xp.sqrt(self.squared_sound_speed(xp, rho))

    def stiff_state(self, xp, rho):
        """P, c^2 and u, each (N,)."""
        state = (rho, rho, rho)
        for piece in self._pieces():
            state = elementwise(xp, piece_state, rho, *state, *piece)
        return state

    def cold_state(self, xp, rho):
        """P, c and u, each (N,)."""
        pressure, stiffness, energy = self.stiff_state(xp, rho)
        return pressure, xp.sqrt(stiffness), energy


def hybrid_state(xp, rho, A, gamma, cold_pressure, cold_stiffness, cold_energy):
    """P, c, u, its thermal part and dA/dq, from the cold parts."""
    thermal = polytrope_energy(xp, rho, A, gamma)
    return (
        cold_pressure + polytrope_pressure(xp, rho, A, gamma),
        xp.sqrt(cold_stiffness + polytrope_stiffness(xp, rho, A, gamma)),
        cold_energy + thermal,
        thermal,
        entropy_per_energy(xp, rho, gamma),
    )


@pytree
@dataclass(frozen=True)
class Hybrid:
    """Cold matter that stiffens at nuclear density, and a thermal part that shocks fill.

    P = K rho^gamma_1 below nuclear_density and K_2 rho^gamma_2 above it (P and u continuous), plus A rho^gamma_thermal.
    Source: Janka, Zwerger & Mueller 1993, A&A 268, 360; Zwerger & Mueller 1997, A&A 320, 209; Dimmelmeier, Font &
    Mueller 2002, A&A 388, 917, sect. 2.2.
    """

    nuclear_density: float
    gamma_1: float
    gamma_2: float
    gamma_thermal: float
    constant: float
    thermal: ClassVar[bool] = True
    curved: ClassVar[bool] = False

    def _cold(self) -> PiecewisePolytropic:
        return PiecewisePolytropic((self.nuclear_density,), (self.gamma_1, self.gamma_2), self.constant)

    def _hot(self) -> Ideal:
        return Ideal(self.gamma_thermal)

    def pressure(self, xp, rho, A):
        """P, like rho."""
        return self._cold().pressure(xp, rho, A) + self._hot().pressure(xp, rho, A)

    def internal_energy(self, xp, rho, A):
        """Specific internal energy u, like rho."""
        return self._cold().internal_energy(xp, rho, A) + self._hot().internal_energy(xp, rho, A)

    def sound_speed(self, xp, rho, A):
        """Adiabatic sound speed, like rho."""
        hot = polytrope_stiffness(xp, rho, A, self.gamma_thermal)
        return xp.sqrt(self._cold().squared_sound_speed(xp, rho) + hot)

    def entropy(self, xp, rho, u):
        """A of matter with internal energy u; matter colder than the cold part has none."""
        excess = u - self._cold().internal_energy(xp, rho, 0.0)
        return self._hot().entropy(xp, rho, xp.maximum(excess, 0.0))

    def entropy_rate(self, xp, rho, q):
        """dA/dt of matter heated by q per mass and time."""
        return self._hot().entropy_rate(xp, rho, q)

    def state(self, xp, rho, A):
        """P, c, u, its thermal part and dA/dq, each (N,)."""
        return elementwise(xp, hybrid_state, rho, A, self.gamma_thermal, *self._cold().stiff_state(xp, rho))

    def energy(self, xp, rho, A):
        """u, (N,)."""
        return self.state(xp, rho, A)[2]


def piecewise_polytropic(densities, gammas, constant: float) -> PiecewisePolytropic:
    """Return the barotrope with gammas[i] above densities[i-1]; ValueError if lengths, order or signs are wrong."""
    densities, gammas = tuple(map(float, densities)), tuple(map(float, gammas))
    check(constant=constant)
    for density in densities:
        check(densities=density)
    for gamma in gammas:
        check(gammas=gamma)
    if len(gammas) != len(densities) + 1:
        raise ValueError(
            f"equation of state: {len(densities)} densities need {len(densities) + 1} gammas, not {len(gammas)}"
        )
    if any(b <= a for a, b in pairwise(densities)):
        raise ValueError("equation of state: densities must ascend")
    made = PiecewisePolytropic(densities, gammas, float(constant))
    check_pieces(made)
    return made


def hybrid(nuclear_density: float, gamma_1: float, gamma_2: float, gamma_thermal: float, constant: float) -> Hybrid:
    """Return the core-collapse equation of state; ValueError unless gammas exceed 1 and the rest is positive."""
    check(
        nuclear_density=nuclear_density,
        gamma_1=gamma_1,
        gamma_2=gamma_2,
        gamma_thermal=gamma_thermal,
        constant=constant,
    )
    made = Hybrid(float(nuclear_density), float(gamma_1), float(gamma_2), float(gamma_thermal), float(constant))
    check_pieces(made._cold())
    return made


def check_pieces(cold: "PiecewisePolytropic") -> None:
    """Raise ValueError unless the constants of all pieces are finite and positive."""
    try:
        held = all(0.0 < constant < math.inf and math.isfinite(offset) for _, _, constant, offset in cold._pieces())
    except (OverflowError, ZeroDivisionError):
        held = False
    if not held:
        raise ValueError(
            "equation of state: pressures that are continuous at these densities, with these exponents, are beyond "
            "what numbers hold"
        )
