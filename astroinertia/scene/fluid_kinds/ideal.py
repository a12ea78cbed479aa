"""Ideal gases in a scene."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.fluids import MONATOMIC, Fluid, Gamma
from astroinertia.units import CodeUnits


class IdealGas(Fluid):
    """P = A rho^gamma with an entropy A of each particle that only dissipation raises."""

    kind: Literal["ideal"]
    rank: ClassVar[int] = 1
    gamma_key: ClassVar[str] = "gamma"
    thermal_key: ClassVar[str] = "gamma"
    gamma: Gamma = Field(default=MONATOMIC, description="adiabatic exponent")

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """As of every Fluid."""
        from astroinertia.matter import gases

        return gases.ideal(self.gamma)
