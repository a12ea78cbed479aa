"""What an equation of state of a user's own derives from, and whether its functions agree with each other.

Tests: tests/unit/matter/test_equation.py, tests/unit/test_matter_door.py.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np

from astroinertia.units import Option

Array = Any
AROUND = (0.8, 0.9, 1.0, 1.1, 1.25)  # of the body's mean density, where functions are compared
STEP = 1e-4  # of ln rho, in differences: their error goes as its square, 1e-8
AGREED = 1e-5  # of P/rho and c^2; what is wrong in a formula is larger
ROUNDED = 1e-10  # of u, what differences over that step lose to its rounding


class Matter(ABC):
    """Base of equations of state that are not of this package: P, u and c of density and an entropy function A.

    A subclass is a frozen dataclass registered as a pytree (@pytree above @dataclass(frozen=True)); numbers are leaves,
    an option that is a choice is static. Each of its fields is an option, and comes in code units (G = 1). Functions
    are written over xp, numpy or jax.numpy, for arrays rho > 0 and A >= 0 of shape (N,), without changing them.

    A barotrope leaves `entropy` and `entropy_rate` as they are: A is zero, and what dissipation heats is radiated.
    Matter that can be warm says `thermal = True` and gives both; u must be linear in A, and A = 0 the coldest matter.
    Barotropes serve particles, ellipsoids and scaling laws; matter that can be warm, particles and scaling laws.

    Energy is conserved only where P = rho^2 du/drho and c^2 = dP/drho at constant A: runs check it around the mean
    density of the body (`disagreement`). Source of the form: Springel & Hernquist 2002, MNRAS 333, 649.
    """

    kind: ClassVar[str]
    options: ClassVar[Mapping[str, Option]] = {}
    """Each field: its dimension, default, limits and meaning."""
    source: ClassVar[str] = "no source is stated"
    """Where its equations come from."""
    thermal: ClassVar[bool] = False
    """Whether A matters."""
    curved: ClassVar[bool] = False
    """u is linear in A."""

    @classmethod
    def from_options(cls, options: dict[str, Any]) -> Self:
        """The matter from its options in consistent units; raises ValueError, in one sentence, where they contradict.

        Plans call it with options in SI, runs with options in code units.
        """
        return cls(**options)

    @abstractmethod
    def pressure(self, xp: Any, rho: Array, A: Array) -> Array:
        """P, (N,)."""

    @abstractmethod
    def internal_energy(self, xp: Any, rho: Array, A: Array) -> Array:
        """Specific internal energy u, (N,), up to a constant; of a barotrope, whatever P = rho^2 du/drho makes it."""

    @abstractmethod
    def sound_speed(self, xp: Any, rho: Array, A: Array) -> Array:
        """c, (N,), positive."""

    def entropy(self, xp: Any, rho: Array, u: Array) -> Array:
        """A >= 0 of matter with the specific internal energy u, (N,)."""
        return xp.zeros_like(rho)

    def entropy_rate(self, xp: Any, rho: Array, q: Array) -> Array:
        """dA/dt of matter heated by q per mass and time at constant density, (N,)."""
        return xp.zeros_like(rho)

    def state(self, xp: Any, rho: Array, A: Array) -> tuple[Array, Array, Array, Array, Array]:
        """P, c, u, its thermal part and dA/dq, each (N,)."""
        none, energy = xp.zeros_like(rho), self.internal_energy(xp, rho, A)
        warmth = xp.maximum(energy - self.internal_energy(xp, rho, none), 0.0) if self.thermal else none
        per_heat = self.entropy_rate(xp, rho, none + 1.0)
        return self.pressure(xp, rho, A), self.sound_speed(xp, rho, A), energy, warmth, per_heat

    def energy(self, xp: Any, rho: Array, A: Array) -> Array:
        """u, (N,)."""
        return self.internal_energy(xp, rho, A)


def disagreement(matter: Matter, density: float) -> str:
    """What is wrong with the functions of an equation of state around that density, in words; empty where they agree.

    density: in the units of its options. Each relation is compared by differences, matter that can be warm also at two
    entropy functions above zero.
    """
    rho = density * np.array(AROUND)
    none = np.zeros_like(rho)
    with np.errstate(all="ignore"):
        cold, speed = matter.internal_energy(np, rho, none), matter.sound_speed(np, rho, none)
        extent = np.abs(matter.pressure(np, rho, none)) / rho + speed**2
        if not matter.thermal:
            return _mechanics(matter, rho, none)
        warmth = np.where(extent > 0.0, extent, 1.0)  # matter may be without pressure where it is coldest
        one, two = (matter.entropy(np, rho, cold + share * warmth) for share in (1.0, 2.0))
        size = AGREED * warmth + ROUNDED * np.abs(cold)
        if not _all(np.abs(matter.internal_energy(np, rho, one) - cold - warmth) <= size) or not _all(one > 0.0):
            return "its `entropy` is not the A that `internal_energy` has that energy at"
        if not _all(np.abs(two - 2.0 * one) <= AGREED * one + ROUNDED * np.abs(cold) / warmth * one):
            return "its `internal_energy` is not linear in A"
        if not _all(np.abs(matter.entropy_rate(np, rho, warmth) - one) <= AGREED * one):
            return "its `entropy_rate` is not dA/du of its `internal_energy`"
        return (
            _mechanics(matter, rho, none, coldest=True) or _mechanics(matter, rho, one) or _mechanics(matter, rho, two)
        )


def _mechanics(matter: Matter, rho: Array, A: Array, coldest: bool = False) -> str:
    low, high = rho * np.exp(-0.5 * STEP), rho * np.exp(0.5 * STEP)
    pressure, speed = matter.pressure(np, rho, A), matter.sound_speed(np, rho, A)
    energy = matter.internal_energy(np, rho, A)
    if not _all(np.isfinite(pressure) & np.isfinite(energy) & np.isfinite(speed)):
        return "its functions are not finite"
    if not coldest and not _all(speed > 0.0):
        return "its `sound_speed` is not positive"
    extent = np.abs(pressure) / rho + speed**2
    slope = (matter.internal_energy(np, high, A) - matter.internal_energy(np, low, A)) / STEP
    if not _all(np.abs(slope - pressure / rho) <= AGREED * extent + ROUNDED * np.abs(energy)):
        return "its `pressure` is not rho^2 du/drho of its `internal_energy`"
    slope = (matter.pressure(np, high, A) - matter.pressure(np, low, A)) / (rho * STEP)
    if not _all(np.abs(slope - speed**2) <= AGREED * extent):
        return "its `sound_speed` is not the root of dP/drho of its `pressure`"
    return ""


def _all(right: Any) -> bool:
    return bool(np.all(right))
