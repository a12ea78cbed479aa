"""Polytropic fluids in a scene."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.fluids import FROM_BODY, Fluid, Gamma, pressure_constant
from astroinertia.units import CodeUnits


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
