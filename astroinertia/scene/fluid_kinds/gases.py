"""Gases of one exponent in a scene: ideal, isothermal and polytropic."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.dimensional import Speed
from astroinertia.scene.fluids import FROM_BODY, MONATOMIC, Fluid, Gamma, pressure_constant
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


class PolytropicFluid(Fluid):
    """P = K rho^gamma, one K everywhere and for ever."""

    kind: Literal["polytropic"]
    rank: ClassVar[int] = 3
    gamma_key: ClassVar[str] = "gamma"
    barotropic: ClassVar[bool] = True
    gamma: Gamma = Field(description="exponent")
    constant: Annotated[float | str, pressure_constant("gamma")] = Field(
        default=FROM_BODY, description='K, or "from body": the K that holds the body in equilibrium'
    )

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """As of every Fluid."""
        from astroinertia.matter import gases

        assert constant is not None
        return gases.polytropic(self.gamma, constant)
