"""The fluid that a scene may ask for: equations of state, validated and frozen, in SI (or code units)."""

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from astroinertia.scene.dimensional import (
    Density,
    Real,
    SpecificEnergy,
    Speed,
    checked,
    dimensional,
    options_in_code_units,
)
from astroinertia.units import DIMENSIONLESS, CodeUnits, pressure_constant_dimension, shown

MONATOMIC = 5.0 / 3.0  # adiabatic exponent
FROM_BODY = "from body"


class Part(BaseModel):
    """Base of every part of a scene: frozen, unknown keys refused, no silent conversions."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


def as_tuple(value: Any) -> Any:
    """Lists of lists as tuples of tuples: what TOML has and frozen models keep."""
    return tuple(as_tuple(item) for item in value) if isinstance(value, list) else value


Gamma = Annotated[Real, Field(gt=1.0, le=10.0)]


def _pressure_constant(value: Any, gamma: float | None, info: ValidationInfo) -> float | str:
    if value == FROM_BODY:
        return FROM_BODY
    if isinstance(value, str) and not any(character.isdigit() for character in value):
        raise ValueError(f"must be \"from body\" or a quantity, not '{shown(value)}'.")
    if gamma is None:
        raise ValueError("cannot be read without a valid exponent.")
    code = bool((info.context or {}).get("code"))
    return checked(dimensional(value, pressure_constant_dimension(gamma), code), "positive")


class Fluid(Part):
    """An equation of state, with the exponents that all else asks for."""

    @property
    def first_gamma(self) -> float:
        """Adiabatic exponent of the pressure that holds a body up at first; 5/3 where it is not of one exponent."""
        return MONATOMIC

    @property
    def thermal_gamma(self) -> float | None:
        """Exponent of the thermal part A rho^gamma, which dissipation heats; None without one."""
        return None


class IdealGas(Fluid):
    """P = A rho^gamma with an entropy A of each particle that only dissipation raises."""

    kind: Literal["ideal"]
    gamma: Gamma = Field(default=MONATOMIC, description="adiabatic exponent")

    @property
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return self.gamma

    @property
    def thermal_gamma(self) -> float:
        """As of every Fluid."""
        return self.gamma


class IsothermalGas(Fluid):
    """P = sound_speed^2 rho."""

    kind: Literal["isothermal"]
    sound_speed: Speed = Field(description="isothermal sound speed")

    @property
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return 1.0


class PolytropicFluid(Fluid):
    """P = K rho^gamma, one K everywhere and for ever."""

    kind: Literal["polytropic"]
    gamma: Gamma = Field(description="exponent")
    constant: float | str = Field(
        default=FROM_BODY, description='K, or "from body": the K that holds the body in equilibrium'
    )

    @field_validator("constant", mode="before")
    @classmethod
    def _constant(cls, value: Any, info: ValidationInfo) -> float | str:
        return _pressure_constant(value, info.data.get("gamma"), info)

    @property
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return self.gamma


class PiecewisePolytropicFluid(Fluid):
    """P = K_k rho^gamma_k between dividing densities; P and u are continuous."""

    kind: Literal["piecewise_polytropic"]
    densities: Annotated[tuple[Density, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=20)] = Field(
        description="dividing densities, rising"
    )
    gammas: Annotated[tuple[Gamma, ...], BeforeValidator(as_tuple), Field(min_length=2, max_length=21)] = Field(
        description="exponents of the pieces, one more than there are densities"
    )
    constant: float | str = Field(default=FROM_BODY, description='K of the first piece, or "from body"')

    @field_validator("constant", mode="before")
    @classmethod
    def _constant(cls, value: Any, info: ValidationInfo) -> float | str:
        gammas = info.data.get("gammas")
        return _pressure_constant(value, gammas[0] if gammas else None, info)

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
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return self.gammas[0]


class HybridFluid(Fluid):
    """Cold part that stiffens at nuclear density, and a thermal part for what shocks heat.

    Janka, Zwerger & Moenchmeyer 1993, A&A 268, 360; Dimmelmeier, Font & Mueller 2002, A&A 388, 917.
    """

    kind: Literal["hybrid"]
    gamma_1: Gamma = Field(
        default=1.31, description="exponent of the cold part below nuclear density; below 4/3 it stops no fall"
    )
    gamma_2: Gamma = Field(default=2.5, description="exponent of the cold part above nuclear density")
    gamma_thermal: Gamma = Field(default=1.5, description="exponent of the thermal part")
    nuclear_density: Density = Field(description="density at which the cold part stiffens")
    constant: float | str = Field(
        default=FROM_BODY,
        description='K below nuclear density, or "from body": the K that gives the body its own central pressure',
    )

    @field_validator("constant", mode="before")
    @classmethod
    def _constant(cls, value: Any, info: ValidationInfo) -> float | str:
        return _pressure_constant(value, info.data.get("gamma_1"), info)

    @property
    def first_gamma(self) -> float:
        """As of every Fluid."""
        return self.gamma_1

    @property
    def thermal_gamma(self) -> float:
        """As of every Fluid."""
        return self.gamma_thermal


class Material(Part):
    """Matter whose pressure is a function of density and energy: Tillotson's equation for one substance, or a table."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_\-]{0,63}$")] = Field(
        description="what the layers of a body call it"
    )
    tillotson: Literal["iron", "granite", "basalt", "ice"] | None = Field(
        default=None, description="substance of Tillotson's equation; or give a file"
    )
    file: Annotated[str, Field(min_length=1, max_length=512)] | None = Field(
        default=None,
        description="table (.csv .npz .h5), relative to the scene: columns density internal_energy pressure, in SI",
    )
    reference_density: Density | None = Field(
        default=None, description="with a file: the density at which isentropes are distinguished by their energy"
    )
    hottest: SpecificEnergy | None = Field(
        default=None, description="energy of the hottest isentrope at the reference density; 1e9 J/kg, or the file's"
    )
    tension: bool = Field(default=False, description="let matter be pulled, down to half its reference density")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.tillotson is None) == (self.file is None):
            raise ValueError("needs exactly one of tillotson and file.")
        if (self.file is None) != (self.reference_density is None):
            raise ValueError("needs a reference_density with a file, and none with tillotson.")
        return self


class Materials(Fluid):
    """Materials, each with its own P(rho, u), as tables of isentropes that conserve energy exactly."""

    kind: Literal["materials"]
    materials: Annotated[tuple[Material, ...], BeforeValidator(as_tuple), Field(min_length=1, max_length=16)] = Field(
        description="what the layers of a body are of; a body without layers is of the first"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [material.name for material in self.materials]
        if len(set(names)) < len(names):
            raise ValueError("needs materials of different names.")
        return self


class IncompressibleFluid(Fluid):
    """Every part of the body keeps its density; the pressure is what that takes (model ellipsoid)."""

    kind: Literal["incompressible"]


class OwnFluid(Fluid):
    """An equation of state that is not of this package, which scene.load makes of a kind that it knows from outside.

    name: its kind in the scene. options: in SI, or in code units where the scene is. entry: what its class says.
    """

    kind: Literal["own"]
    name: str
    options: dict[str, Any]
    entry: Any = Field(exclude=True, repr=False)

    def matter(self, units: CodeUnits = DIMENSIONLESS) -> Any:
        """The equation of state (matter.equation.Matter) in those units; as the scene has its numbers, without any.

        ValueError, in one sentence, where its options contradict each other.
        """
        return self.entry.made.from_options(options_in_code_units(self.options, self.entry.options, units))


AnyEquationOfState = Annotated[
    IdealGas
    | IsothermalGas
    | PolytropicFluid
    | PiecewisePolytropicFluid
    | HybridFluid
    | Materials
    | IncompressibleFluid
    | OwnFluid,
    Field(discriminator="kind"),
]
