"""Matter of several polytropic pieces in a scene, cold or with a thermal part."""

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from astroinertia.scene.dimensional import Density
from astroinertia.scene.fluids import FROM_BODY, Fluid, Gamma, as_tuple, pressure_constant
from astroinertia.units import CodeUnits


class PiecewisePolytropicFluid(Fluid):
    """P = K_k rho^gamma_k between dividing densities; P and u are continuous."""

    kind: Literal["piecewise_polytropic"]
    rank: ClassVar[int] = 4
    gamma_key: ClassVar[str] = "gammas"
    barotropic: ClassVar[bool] = True
    densities: Annotated[tuple[Density, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=20)] = Field(
        description="dividing densities, rising"
    )
    gammas: Annotated[tuple[Gamma, ...], BeforeValidator(as_tuple), Field(min_length=2, max_length=21)] = Field(
        description="exponents of the pieces, one more than there are densities"
    )
    constant: Annotated[float | str, pressure_constant("gammas")] = Field(
        default=FROM_BODY, description='K of the first piece, or "from body"'
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.gammas) != len(self.densities) + 1:
            raise ValueError(
                f"needs one more of gammas than of densities, but has {len(self.gammas)} and {len(self.densities)}."
            )
        if any(b <= a for a, b in zip(self.densities, self.densities[1:], strict=False)):
            raise ValueError("needs densities that rise.")
        return self

    @property
    def pieces(self) -> tuple[tuple[float, float], ...]:
        """As of every Fluid."""
        return tuple(zip(self.densities, self.gammas[1:], strict=True))

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """As of every Fluid."""
        from astroinertia.matter import cold_matter

        assert constant is not None
        densities = [units.to_code(density, "density") for density in self.densities]
        return cold_matter.piecewise_polytropic(densities, self.gammas, constant)


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
