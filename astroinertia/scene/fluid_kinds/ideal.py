"""Ideal gases in a scene."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.fluids import MONATOMIC, Fluid, Gamma
from astroinertia.units import CodeUnits


class IdealGas(Fluid):
    """P = A rho^gamma with an entropy A of each particle that only dissipation raises."""

    kind: Literal["ideal"]
    rank: ClassVar[int] = 1
    thermal_key: ClassVar[str] = "gamma"
    gamma: Gamma = Field(default=MONATOMIC, description="adiabatic exponent")

    @property
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return self.gamma

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """As of every Fluid."""
        from astroinertia.matter import gases

        return gases.ideal(self.gamma)
