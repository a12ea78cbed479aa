"""What every equation of state of a scene has, whatever its kind, and one of a kind from outside the package.

What the rest of the package asks of a kind is an attribute or a method of its class (scene.fluid_kinds).
"""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo

from astroinertia.scene.dimensional import Real, checked, dimensional, options_in_code_units
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


def pressure_constant(exponent: str) -> BeforeValidator:
    """Reads the K of P = K rho^gamma, in SI (or code units), or "from body"; exponent: the key above that has gamma."""

    def read(value: Any, info: ValidationInfo) -> float | str:
        if value == FROM_BODY:
            return FROM_BODY
        if isinstance(value, str) and not any(character.isdigit() for character in value):
            raise ValueError(f"must be \"from body\" or a quantity, not '{shown(value)}'.")
        if exponent not in info.data:
            raise ValueError("cannot be read without a valid exponent.")
        gamma = info.data[exponent]
        dimension = pressure_constant_dimension(gamma[0] if isinstance(gamma, tuple) else gamma)  # of the first piece
        code = bool((info.context or {}).get("code"))
        return checked(dimensional(value, dimension, code), "positive", value)

    return BeforeValidator(read)


class Fluid(Part):
    """An equation of state, with the exponents that all else asks for."""

    rank: ClassVar[int] = 100
    """Its place in lists of all kinds."""
    gamma_key: ClassVar[str] = ""
    """The key that says its first_gamma, or the first of several."""
    thermal_key: ClassVar[str] = ""
    """The key that says its thermal_gamma."""
    barotropic: ClassVar[bool] = False
    """Whether its pressure follows from the density alone, so that a body has no heat of its own."""
    made_by: ClassVar[str] = ""
    """The function, of a module of astroinertia.build, that makes it where `matter` cannot."""

    @property
    def first_gamma(self) -> float:
        """Adiabatic exponent of the pressure that holds a body up at first; 5/3 where it is not of one exponent."""
        gamma = getattr(self, self.gamma_key) if self.gamma_key else MONATOMIC
        return gamma[0] if isinstance(gamma, tuple) else gamma

    @property
    def thermal_gamma(self) -> float | None:
        """Exponent of the thermal part A rho^gamma, which dissipation heats; None without one."""
        return getattr(self, self.thermal_key) if self.thermal_key else None

    @property
    def pressure_key(self) -> str | None:
        """The key that alone says how high the pressure is; None where it is that of the body's equilibrium."""
        return "constant" if self.stated_constant not in (None, FROM_BODY) else None

    @property
    def stated_constant(self) -> float | str | None:
        """K of P = K rho^gamma, in SI or code units, or "from body"; None of a kind without such a key."""
        return getattr(self, "constant", None)

    @property
    def pieces(self) -> tuple[tuple[float, float], ...]:
        """Densities, rising, and the exponents that the cold pressure has above each."""
        return ()

    def matter(self, units: CodeUnits, constant: float | None) -> Any:
        """The equation of state that particles follow (matter.equation.Matter), in code units.

        constant: K of P = K rho^first_gamma in those, of a kind with a key `constant`; ValueError for impossible ones.
        """
        raise NotImplementedError(f"no particles follow {type(self).__name__}")


class OwnFluid(Fluid):
    """An equation of state that is not of this package, which scene.load makes of a kind that it knows from outside.

    name: its kind in the scene. options: in SI, or in code units where the scene is. entry: what its class says.
    """

    kind: Literal["own"]
    name: str
    options: dict[str, Any]
    entry: Any = Field(exclude=True, repr=False)

    def matter(self, units: CodeUnits = DIMENSIONLESS, constant: float | None = None) -> Any:
        """The equation of state (matter.equation.Matter) in those units; as the scene has its numbers, without any.

        ValueError, in one sentence, where its options contradict each other.
        """
        return self.entry.build(options_in_code_units(self.options, self.entry.options, units))
