"""Field types of a scene: quantity strings on the way in, SI floats once validated.

Each type is a float to its reader. What may be written for it depends on the scene: a string with a unit, or, where the
scene says `units = "code"`, a plain number. The validation context carries that choice as "code".
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, get_args

import numpy as np
from pydantic import BeforeValidator, GetCoreSchemaHandler, ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from astroinertia.errors import SceneError
from astroinertia.units import CodeUnits, Dimension, Option, plain_number_hint, quantity, shown

LARGEST_NUMBER = 1e100  # squares of products of such numbers must not overflow; scales.py is stricter on quantities
LARGEST_CONSTANT = 1e200  # of quantities in odd units, as K of P = K rho^gamma
_PLAIN = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*", re.ASCII)
_FRACTION = re.compile(r"\s*([+-]?\d{1,15})\s*/\s*(\d{1,15})\s*", re.ASCII)


def fraction(value: Any) -> Any:
    """A text such as "5/3" as the number that it is; everything else as it is."""
    parts = _FRACTION.fullmatch(value) if isinstance(value, str) else None
    return int(parts[1]) / int(parts[2]) if parts and int(parts[2]) else value


def whole(value: Any) -> Any:
    """A number without a fractional part, such as 1e5, as an int; everything else as it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def number(value: Any, largest: float = LARGEST_NUMBER) -> float:
    """A finite plain number, or a fraction such as "5/3"; ValueError says what else it is."""
    value = fraction(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"must be a number, not {described(value)}.")
    if not -largest <= value <= largest:  # false for nan too; an int may be too large for a float
        raise ValueError(f"must be a finite number, and no larger than {largest:g}.")
    return float(value)


def dimensional(value: Any, dimension: str | Dimension, code: bool) -> float:
    """The value of a dimensional quantity: SI from a string, or a plain number in code units."""
    largest = LARGEST_CONSTANT if isinstance(dimension, Dimension) else LARGEST_NUMBER
    if dimension == "dimensionless":
        value = fraction(value)
        if isinstance(value, str) and _PLAIN.fullmatch(value):
            raise ValueError(f"must be a number without quotes, not {described(value)}.")
    if isinstance(value, str):
        if code:
            raise ValueError(
                f"must be a plain number, not '{shown(value)}', for the scene is in code units (units = \"code\")."
            )
        try:
            result = quantity(value, dimension)
        except SceneError as error:
            raise ValueError(str(error)) from None
        return number(result, largest)
    if isinstance(value, list | tuple | dict) and not code and dimension != "dimensionless":
        raise ValueError(f"must be a single quantity, not {described(value)}: {plain_number_hint(dimension)}.")
    result = number(value, largest)
    if not code and dimension != "dimensionless":
        raise ValueError(f"must have a unit: {plain_number_hint(dimension)}.")
    return result


def in_code_units(value: Any, dimension: str | Dimension, units: CodeUnits) -> Any:
    """The value of an option in code units: a number, or a list of numbers; what has no dimension as it is."""
    if value is None or isinstance(value, str) or dimension in ("choice", "boolean"):
        return value
    scale = units.unit(dimension)
    if isinstance(value, int | float):
        return value / scale
    return (np.asarray(value, dtype=float) / scale).tolist()


def options_in_code_units(options: Mapping[str, Any], table: Mapping[str, Option], units: CodeUnits) -> dict[str, Any]:
    """All options of one thing in code units."""
    return {name: in_code_units(value, table[name].dimension, units) for name, value in options.items()}


def checked(value: float, sign: str, given: Any) -> float:
    """The value, given as it is written, if it has the sign that is asked for: "positive", "not negative" or "any"."""
    written = f"'{shown(given)}'" if isinstance(given, str) else f"{value:g}"
    if sign == "positive" and not value > 0.0:
        raise ValueError(f"must be positive, not {written}.")
    if sign == "not negative" and not value >= 0.0:
        raise ValueError(f"must not be negative, as {written} is.")
    return value


def described(value: Any) -> str:
    """What a TOML value is, for a message."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text '{shown(value)}'"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ") if abs(value) < 10**15 else "a very large number"
    if isinstance(value, float):
        return f"{value:g}" if math.isfinite(value) else "a number that is not finite"
    return "a date or time"


@dataclass(frozen=True)
class Quantity:
    """Marks a field type with its dimension and sign, by which values are read, explained and judged."""

    dimension: str
    sign: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """A float that is read by the dimension, in code units where the validation context says so."""
        return core_schema.with_info_before_validator_function(self._read, handler(source))

    def _read(self, value: Any, info: ValidationInfo) -> float:
        if self.dimension == "dimensionless":
            return checked(number(value), self.sign, value)
        return checked(dimensional(value, self.dimension, bool((info.context or {}).get("code"))), self.sign, value)


def quantity_of(field: FieldInfo) -> Quantity | None:
    """What a field of a scene is marked with, in itself or in the items of its tuples."""
    marks = [item for item in (*field.metadata, *_metadata(field.annotation)) if isinstance(item, Quantity)]
    return marks[0] if marks else None


def _metadata(annotation: Any) -> list[Any]:
    own = list(getattr(annotation, "__metadata__", ()))
    return own + [item for argument in get_args(annotation) for item in _metadata(argument)]


_POSITIVE, _NOT_NEGATIVE, _ANY = "positive", "not negative", "any"

Mass = Annotated[float, Quantity("mass", _POSITIVE)]
Length = Annotated[float, Quantity("length", _POSITIVE)]
Duration = Annotated[float, Quantity("time", _POSITIVE)]
Speed = Annotated[float, Quantity("velocity", _POSITIVE)]
Density = Annotated[float, Quantity("density", _POSITIVE)]
AngularVelocity = Annotated[float, Quantity("angular_velocity", _ANY)]
AngularMomentum = Annotated[float, Quantity("angular_momentum", _ANY)]
SpecificEnergy = Annotated[float, Quantity("specific_energy", _NOT_NEGATIVE)]
Pressure = Annotated[float, Quantity("pressure", _NOT_NEGATIVE)]
VelocityGradient = Annotated[float, Quantity("velocity_gradient", _ANY)]
Angle = Annotated[float, Quantity("angle", _ANY)]
Place = Annotated[float, Quantity("length", _ANY)]
SpeedComponent = Annotated[float, Quantity("velocity", _ANY)]
Moment = Annotated[float, Quantity("moment_of_inertia", _NOT_NEGATIVE)]
Number = Annotated[float, Quantity("dimensionless", _ANY)]
NumberNotNegative = Annotated[float, Quantity("dimensionless", _NOT_NEGATIVE)]
PositiveNumber = Annotated[float, Quantity("dimensionless", _POSITIVE)]
Real = Annotated[float, BeforeValidator(fraction)]
Whole = Annotated[int, BeforeValidator(whole)]
