"""Cold matter with a thermal part, in a scene."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.dimensional import Density
from astroinertia.scene.fluids import FROM_BODY, Fluid, Gamma, pressure_constant
from astroinertia.units import CodeUnits


class HybridFluid(Fluid):
    """Cold part that stiffens at nuclear density, and a thermal part for what shocks heat.

    Janka, Zwerger & Moenchmeyer 1993, A&A 268, 360; Dimmelmeier, Font & Mueller 2002, A&A 388, 917.
    """

    kind: Literal["hybrid"]
    rank: ClassVar[int] = 5
    gamma_key: ClassVar[str] = "gamma_1"
    thermal_key: ClassVar[str] = "gamma_thermal"
    gamma_1: Gamma = Field(
        default=1.31, description="exponent of the cold part below nuclear density; below 4/3 it stops no fall"
    )
    gamma_2: Gamma = Field(default=2.5, description="exponent of the cold part above nuclear density")
    gamma_thermal: Gamma = Field(default=1.5, description="exponent of the thermal part")
    nuclear_density: Density = Field(description="density at which the cold part stiffens")
    constant: Annotated[float | str, pressure_constant("gamma_1")] = Field(
        default=FROM_BODY,
        description='K below nuclear density, or "from body": the K that gives the body its own central pressure',
    )

    @property
    def pieces(self) -> tuple[tuple[float, float], ...]:
        """As of every Fluid."""
        return ((self.nuclear_density, self.gamma_2),)

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """As of every Fluid."""
        from astroinertia.matter import cold_matter

        assert constant is not None
        nuclear = units.to_code(self.nuclear_density, "density")
        return cold_matter.hybrid(nuclear, self.gamma_1, self.gamma_2, self.gamma_thermal, constant)
