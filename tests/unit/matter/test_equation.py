"""Whether functions of an equation of state belong together: what is right passes, and each fault is named."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from astroinertia.matter import Matter
from astroinertia.matter.equation import disagreement

K, DENSITY = 0.3, 0.7


@dataclass(frozen=True)
class Gas(Matter):
    """P = K rho^2 + A rho^(5/3), with an energy that is counted from a constant."""

    cold: float = K
    constant: float = 0.0

    kind: ClassVar[str] = "gas"
    thermal: ClassVar[bool] = True

    def pressure(self, xp: Any, rho: Any, A: Any) -> Any:
        """P, (N,)."""
        return self.cold * rho**2 + A * rho ** (5 / 3)

    def internal_energy(self, xp: Any, rho: Any, A: Any) -> Any:
        """u, (N,)."""
        return self.constant + self.cold * rho + 1.5 * A * rho ** (2 / 3)

    def sound_speed(self, xp: Any, rho: Any, A: Any) -> Any:
        """c, (N,)."""
        return xp.sqrt(2 * self.cold * rho + 5 / 3 * A * rho ** (2 / 3))

    def entropy(self, xp: Any, rho: Any, u: Any) -> Any:
        """A, (N,)."""
        return (u - self.constant - self.cold * rho) / (1.5 * rho ** (2 / 3))

    def entropy_rate(self, xp: Any, rho: Any, q: Any) -> Any:
        """dA/dt, (N,)."""
        return q / (1.5 * rho ** (2 / 3))


@pytest.mark.parametrize("matter", [Gas(), Gas(cold=0.0), Gas(constant=1e8), Gas(constant=-1e9)], ids=str)
def test_matter_that_agrees_is_taken(matter: Matter) -> None:
    """Without pressure where it is coldest, too, and with a constant in its energy that leaves few digits to it."""
    assert disagreement(matter, DENSITY) == ""


class Heated(Gas):
    """A thermal pressure that lacks a hundredth."""

    def pressure(self, xp: Any, rho: Any, A: Any) -> Any:
        """P, (N,)."""
        return self.cold * rho**2 + 0.99 * A * rho ** (5 / 3)


class Saturated(Gas):
    """A thermal pressure that stays where it is from 3/2 of the first entropy on that is compared."""

    def pressure(self, xp: Any, rho: Any, A: Any) -> Any:
        """P, (N,)."""
        return self.cold * rho**2 + xp.minimum(A, 3.0 * K * rho ** (1 / 3)) * rho ** (5 / 3)


class Frozen(Gas):
    """A sound speed that warmth does not change."""

    def sound_speed(self, xp: Any, rho: Any, A: Any) -> Any:
        """c, (N,)."""
        return xp.sqrt(2 * self.cold * rho)


class Unsound(Gas):
    """A sound speed that is no number."""

    def sound_speed(self, xp: Any, rho: Any, A: Any) -> Any:
        """c, (N,)."""
        return np.nan * rho


class Squared(Gas):
    """The square root of the gas's A as A."""

    def pressure(self, xp: Any, rho: Any, A: Any) -> Any:
        """P, (N,)."""
        return super().pressure(xp, rho, A**2)

    def internal_energy(self, xp: Any, rho: Any, A: Any) -> Any:
        """u, (N,)."""
        return super().internal_energy(xp, rho, A**2)

    def sound_speed(self, xp: Any, rho: Any, A: Any) -> Any:
        """c, (N,)."""
        return super().sound_speed(xp, rho, A**2)

    def entropy(self, xp: Any, rho: Any, u: Any) -> Any:
        """A, (N,)."""
        return xp.sqrt(xp.maximum(super().entropy(xp, rho, u), 0.0))


class Opposite(Gas):
    """Minus the gas's A as A, which falls with heat."""

    def pressure(self, xp: Any, rho: Any, A: Any) -> Any:
        """P, (N,)."""
        return super().pressure(xp, rho, -A)

    def internal_energy(self, xp: Any, rho: Any, A: Any) -> Any:
        """u, (N,)."""
        return super().internal_energy(xp, rho, -A)

    def sound_speed(self, xp: Any, rho: Any, A: Any) -> Any:
        """c, (N,)."""
        return super().sound_speed(xp, rho, -A)

    def entropy(self, xp: Any, rho: Any, u: Any) -> Any:
        """A, (N,)."""
        return -super().entropy(xp, rho, u)

    def entropy_rate(self, xp: Any, rho: Any, q: Any) -> Any:
        """dA/dt, (N,)."""
        return -super().entropy_rate(xp, rho, q)


class Dust(Gas):
    """Matter that is never warm, and without pressure."""

    thermal: ClassVar[bool] = False


@pytest.mark.parametrize(
    ("matter", "sentence"),
    [
        (Heated(), "its `pressure` is not rho^2 du/drho of its `internal_energy`"),
        (Saturated(), "its `pressure` is not rho^2 du/drho of its `internal_energy`"),
        (Frozen(), "its `sound_speed` is not the root of dP/drho of its `pressure`"),
        (Unsound(), "its functions are not finite"),
        (Squared(), "its `internal_energy` is not linear in A"),
        (Opposite(), "its `entropy` is not the A that `internal_energy` has that energy at"),
        (Dust(cold=0.0), "its `sound_speed` is not positive"),
    ],
    ids=lambda each: type(each).__name__ if isinstance(each, Matter) else "",
)
def test_a_fault_that_shows_in_warm_or_in_cold_matter_alone_is_named(matter: Matter, sentence: str) -> None:
    assert disagreement(matter, DENSITY) == sentence
