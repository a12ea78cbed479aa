"""An equation of state from outside the package: the logotrope."""

from dataclasses import dataclass
from typing import Any, ClassVar

from astroinertia.matter import REQUIRED, Matter, positive, pytree


@pytree
@dataclass(frozen=True)
class Logotrope(Matter):
    """P = P0 (1 + A ln(rho/rho0)), the pressure of a molecular cloud, thermal and turbulent, with P0 at its centre.

    A barotrope: c^2 = A P0/rho is positive at every density, and u = -P0 (1 + A + A ln(rho/rho0))/rho has
    rho^2 du/drho = P. The pressure is negative below rho0 exp(-1/A), where a cloud ends.
    """

    reference_pressure: Any
    reference_density: Any
    slope: Any = 0.2

    kind: ClassVar[str] = "logotrope"
    source: ClassVar[str] = "McLaughlin & Pudritz 1996, ApJ 469, 194"
    options: ClassVar = {
        "reference_pressure": positive("pressure", REQUIRED, "P0"),
        "reference_density": positive("density", REQUIRED, "rho0, the density at which P = P0"),
        "slope": positive("dimensionless", 0.2, "A, about 0.2 in clouds"),
    }

    def pressure(self, xp, rho, A):
        """P, (N,)."""
        return self.reference_pressure * (1.0 + self.slope * xp.log(rho / self.reference_density))

    def internal_energy(self, xp, rho, A):
        """u, (N,), of which P is rho^2 du/drho."""
        return -(self.pressure(xp, rho, A) + self.reference_pressure * self.slope) / rho

    def sound_speed(self, xp, rho, A):
        """c, (N,)."""
        return xp.sqrt(self.slope * self.reference_pressure / rho)
