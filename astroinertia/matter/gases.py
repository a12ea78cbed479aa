"""Equations of state of particles, and the gases of one exponent.

P = P_cold(rho) + A rho^gamma, with A the entropy function that each particle has.

Without dissipation A is constant, so that the internal energy depends on positions alone and the equations of motion
are Hamiltonian (Springel & Hernquist 2002, MNRAS 333, 649). Barotropic equations of state have the cold part only;
what dissipation heats is then radiated.

Every class is a frozen pytree whose numbers are leaves. Methods take the array namespace `xp` (numpy or jax.numpy),
densities `rho` > 0 and entropy functions `A` >= 0 of one shape, and work in any consistent units:

    pressure(xp, rho, A)           P
    internal_energy(xp, rho, A)    u, specific; P = rho^2 du/drho at constant A
    sound_speed(xp, rho, A)        c, from c^2 = dP/drho at constant A
    entropy(xp, rho, u)            A of matter with specific internal energy u (zero where barotropic)
    entropy_rate(xp, rho, q)       dA/dt from specific heating q = du/dt at constant density (zero where barotropic)
    state(xp, rho, A)              P, c, u, its thermal part and dA/dq of particles (N,), in one go
    energy(xp, rho, A)             u of particles (N,), likewise

`thermal` says whether A matters; `curved`, whether u is not linear in A, and then there is

    heated(xp, rho, A, q, least)   A of matter with the heat q besides, not below `least`, and what u misses of that

Tests: tests/unit/matter/test_gases_and_cold_matter.py.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from astroinertia.engines.elementwise import elementwise
from astroinertia.engines.pytree import pytree

LEAST_ABOVE = 1e-6  # of gamma above 1


def check(**named: float) -> None:
    """Raise ValueError unless every named number is finite and positive; gammas must be above 1 as well.

    By so much that energies, which go as 1/(gamma - 1), keep ten digits of their differences.
    """
    for name, value in named.items():
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"equation of state: {name} must be positive and finite, not {value!r}")
        if name.startswith("gamma") and value - 1 < LEAST_ABOVE:
            least = f"must be above 1, by {LEAST_ABOVE:g} at least"
            raise ValueError(f"equation of state: {name} {least}, not {value!r} (1 is kind 'isothermal')")


def polytrope_pressure(xp, rho, K, gamma):
    """K rho^gamma."""
    return K * (rho * xp.power(rho, gamma - 1))


def polytrope_energy(xp, rho, K, gamma):
    """The u of which that is rho^2 du/drho."""
    return K * xp.power(rho, gamma - 1) / (gamma - 1)


def polytrope_stiffness(xp, rho, K, gamma):
    """Its dP/drho."""
    return gamma * K * xp.power(rho, gamma - 1)


def entropy_per_energy(xp, rho, gamma):
    """A of unit specific energy."""
    return (gamma - 1) / xp.power(rho, gamma - 1)


def ideal_state(xp, rho, A, gamma):
    """P, c, u, all of it thermal, and dA/dq."""
    energy = polytrope_energy(xp, rho, A, gamma)
    speed = xp.sqrt(polytrope_stiffness(xp, rho, A, gamma))
    return polytrope_pressure(xp, rho, A, gamma), speed, energy, energy, entropy_per_energy(xp, rho, gamma)


def ideal_energy(xp, rho, A, gamma):
    """u."""
    return (polytrope_energy(xp, rho, A, gamma),)


@pytree
@dataclass(frozen=True)
class Ideal:
    """Ideal gas, P = A rho^gamma = (gamma - 1) rho u."""

    gamma: float
    thermal: ClassVar[bool] = True
    curved: ClassVar[bool] = False

    def pressure(self, xp, rho, A):
        """P, like rho."""
        return polytrope_pressure(xp, rho, A, self.gamma)

    def internal_energy(self, xp, rho, A):
        """Specific internal energy u, like rho."""
        return polytrope_energy(xp, rho, A, self.gamma)

    def sound_speed(self, xp, rho, A):
        """Adiabatic sound speed, like rho."""
        return xp.sqrt(polytrope_stiffness(xp, rho, A, self.gamma))

    def entropy(self, xp, rho, u):
        """A of matter with specific internal energy u."""
        return u * entropy_per_energy(xp, rho, self.gamma)

    def entropy_rate(self, xp, rho, q):
        """dA/dt of matter heated by q per mass and time."""
        return q * entropy_per_energy(xp, rho, self.gamma)

    def state(self, xp, rho, A):
        """P, c, u, its thermal part and dA/dq, each (N,)."""
        return elementwise(xp, ideal_state, rho, A, self.gamma)

    def energy(self, xp, rho, A):
        """u, (N,)."""
        return elementwise(xp, ideal_energy, rho, A, self.gamma)[0]


class Barotropic(ABC):
    """What a fluid without a thermal part shares: the entropy function is zero and stays so."""

    thermal: ClassVar[bool] = False
    curved: ClassVar[bool] = False

    @abstractmethod
    def cold_state(self, xp, rho) -> tuple:
        """P, c and u, each (N,)."""

    def entropy(self, xp, rho, u):
        """Zero: nothing is kept."""
        return xp.zeros_like(rho)

    def entropy_rate(self, xp, rho, q):
        """Zero: heat is radiated."""
        return xp.zeros_like(rho)

    def state(self, xp, rho, A):
        """P, c, u, its thermal part and dA/dq, each (N,)."""
        none = xp.zeros_like(rho)
        return (*self.cold_state(xp, rho), none, none)

    def energy(self, xp, rho, A):
        """u, (N,)."""
        return self.cold_state(xp, rho)[2]


def isothermal_state(xp, rho, speed, reference_density):
    """P, c and the free energy."""
    return speed**2 * rho, speed + 0.0 * rho, speed**2 * xp.log(rho / reference_density)


@pytree
@dataclass(frozen=True)
class Isothermal(Barotropic):
    """P = c^2 rho; the "internal energy" is the free energy c^2 ln(rho/reference_density), up to a constant."""

    speed: float
    reference_density: float = 1.0

    def pressure(self, xp, rho, A):
        """P, like rho."""
        return self.speed**2 * rho

    def internal_energy(self, xp, rho, A):
        """Specific free energy, like rho."""
        return self.speed**2 * xp.log(rho / self.reference_density)

    def sound_speed(self, xp, rho, A):
        """The one sound speed, like rho."""
        return self.speed * xp.ones_like(rho)

    def cold_state(self, xp, rho):
        """P, c and u, each (N,)."""
        return elementwise(xp, isothermal_state, rho, self.speed, self.reference_density)


@pytree
@dataclass(frozen=True)
class Polytropic(Barotropic):
    """P = K rho^gamma with one constant K for the whole body."""

    gamma: float
    constant: float

    def pressure(self, xp, rho, A):
        """P, like rho."""
        return polytrope_pressure(xp, rho, self.constant, self.gamma)

    def internal_energy(self, xp, rho, A):
        """Specific internal energy u, like rho."""
        return polytrope_energy(xp, rho, self.constant, self.gamma)

    def sound_speed(self, xp, rho, A):
        """Adiabatic sound speed, like rho."""
        return xp.sqrt(polytrope_stiffness(xp, rho, self.constant, self.gamma))

    def cold_state(self, xp, rho):
        """P, c and u, each (N,)."""
        return elementwise(xp, ideal_state, rho, self.constant, self.gamma)[:3]


def polytropic_constant(density: float, pressure: float, gamma: float) -> float:
    """Return K of P = K rho^gamma through one point; `constant`s are so carried between systems of units."""
    return pressure * density**-gamma


def ideal(gamma: float) -> Ideal:
    """Return the ideal gas of adiabatic index gamma; ValueError unless gamma > 1."""
    check(gamma=gamma)
    return Ideal(float(gamma))


def isothermal(sound_speed: float, reference_density: float = 1.0) -> Isothermal:
    """Return the isothermal gas of one sound speed; ValueError unless it is positive."""
    check(sound_speed=sound_speed, reference_density=reference_density)
    return Isothermal(float(sound_speed), float(reference_density))


def polytropic(gamma: float, constant: float) -> Polytropic:
    """Return the barotrope P = constant rho^gamma; ValueError unless gamma > 1 and constant > 0."""
    check(gamma=gamma, constant=constant)
    return Polytropic(float(gamma), float(constant))
