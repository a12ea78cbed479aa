"""Isothermal gases in a scene."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.dimensional import Speed
from astroinertia.scene.fluids import Fluid
from astroinertia.units import CodeUnits


class IsothermalGas(Fluid):
    """P = sound_speed^2 rho."""

    kind: Literal["isothermal"]
    rank: ClassVar[int] = 2
    barotropic: ClassVar[bool] = True
    sound_speed: Speed = Field(description="isothermal sound speed")

    @property
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return 1.0

    @property
    def pressure_key(self) -> str | None:
        """As of every Fluid."""
        return "sound_speed"

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """As of every Fluid."""
        from astroinertia.matter import gases

        return gases.isothermal(units.to_code(self.sound_speed, "velocity"))
