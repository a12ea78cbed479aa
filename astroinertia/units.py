"""Units, at the two ends of the program only: quantity strings to SI, SI to code units with G = 1, and what an option
of an effect, an equation of state, a body or an observable is: its dimension, default and limits.

The only importer of astropy.units.
"""

import difflib
import math
import re
import sys
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

from astroinertia.errors import SceneError

# As astropy.constants has them (tests/unit/test_units.py); written out, so that no command waits for astropy that reads
# no unit, and no result depends on its version.
GRAVITATIONAL_CONSTANT = 6.6743e-11  # m3 kg-1 s-2, CODATA 2022
SPEED_OF_LIGHT = 299792458.0  # m s-1, exact
SOLAR_MASS = 1.988409870698051e30  # kg, IAU 2015 nominal GM over CODATA 2022 G
SOLAR_RADIUS = 695700000.0  # m, IAU 2015 nominal
VACUUM_PERMEABILITY = 1.25663706127e-06  # N A-2, CODATA 2022
PARSEC = 3.085677581491367e16  # m
ELECTRON_MASS = 9.1093837139e-31  # kg, CODATA 2022
ATOMIC_MASS = 1.66053906892e-27  # kg, CODATA 2022
REDUCED_PLANCK_CONSTANT = 1.0545718176461565e-34  # J s, exact
BOLTZMANN_CONSTANT = 1.380649e-23  # J K-1, exact
STEFAN_BOLTZMANN_CONSTANT = 5.6703744191844314e-08  # W m-2 K-4, exact

LONGEST_QUANTITY = 80  # characters; no honest quantity is longer, and the unit parser need not see more
LONGEST_UNIT = 40  # characters, in such a text
LARGEST_EXPONENT = 99  # astropy takes m**1000000, and numbers far beyond


class Dimension(NamedTuple):
    """Exponents of mass, length and time."""

    mass: float
    length: float
    time: float


_DIMENSIONS: dict[str, tuple[Dimension, str]] = {
    "dimensionless": (Dimension(0, 0, 0), ""),
    "angle": (Dimension(0, 0, 0), "30 deg"),
    "mass": (Dimension(1, 0, 0), "1.4 Msun"),
    "length": (Dimension(0, 1, 0), "1500 km"),
    "time": (Dimension(0, 0, 1), "33 ms"),
    "velocity": (Dimension(0, 1, -1), "10 km/s"),
    "acceleration": (Dimension(0, 1, -2), "9.8 m/s2"),
    "angular_velocity": (Dimension(0, 0, -1), "3 rad/s"),
    "angular_acceleration": (Dimension(0, 0, -2), "0.1 rad/s2"),
    "rate": (Dimension(0, 0, -1), "0.1 1/s"),
    "velocity_gradient": (Dimension(0, 0, -1), "0.1 1/s"),
    "inverse_time_squared": (Dimension(0, 0, -2), "0.1 1/s2"),
    "density": (Dimension(1, -3, 0), "2e14 g/cm3"),
    "pressure": (Dimension(1, -1, -2), "1e28 Pa"),
    "momentum": (Dimension(1, 1, -1), "1e30 kg m/s"),
    "force": (Dimension(1, 1, -2), "1e20 N"),
    "energy": (Dimension(1, 2, -2), "1e44 J"),
    "torque": (Dimension(1, 2, -2), "1e30 N m"),
    "power": (Dimension(1, 2, -3), "1e30 W"),
    "specific_energy": (Dimension(0, 2, -2), "1e12 J/kg"),
    "specific_power": (Dimension(0, 2, -3), "1e6 W/kg"),
    "specific_angular_momentum": (Dimension(0, 2, -1), "1e12 m2/s"),
    "angular_momentum": (Dimension(1, 2, -1), "1e41 kg m2/s"),
    "moment_of_inertia": (Dimension(1, 2, 0), "1e38 kg m2"),
    "viscosity": (Dimension(0, 2, -1), "1e6 m2/s"),
    "magnetic_field": (Dimension(0.5, -0.5, -1), "1e12 G"),
}
DIMENSIONS: dict[str, Dimension] = {name: dimension for name, (dimension, _) in _DIMENSIONS.items()}
"""Names of dimensions. `viscosity` is kinematic; `rate` is one over a time without an angle (a decay, a growth);
`magnetic_field` is B / mu_0^(1/2), whose square is twice an energy density."""
EXAMPLES: dict[str, str] = {name: example for name, (_, example) in _DIMENSIONS.items() if example}
"""A quantity of each that has a unit."""

_YEAR, _DAY, _HOUR, _AU = 31557600.0, 86400.0, 3600.0, 149597870700.0
# Units that readers think in, and the size from which on they do: (from, size of the unit, name).
_READABLE = {
    "s": [(0.0, 1e-9, "ns"), (1e-6, 1e-6, "µs"), (1e-3, 1e-3, "ms"), (1.0, 1.0, "s"), (600.0, 60.0, "min"),
          (3 * _HOUR, _HOUR, "h"), (2 * _DAY, _DAY, "d"), (_YEAR, _YEAR, "yr"), (1e3 * _YEAR, 1e3 * _YEAR, "kyr"),
          (1e6 * _YEAR, 1e6 * _YEAR, "Myr")],
    "m": [(0.0, 1e-3, "mm"), (1e-2, 1e-2, "cm"), (1.0, 1.0, "m"), (1e3, 1e3, "km"), (1e7, 1e6, "10^3 km"),
          (1e10, 1e9, "10^6 km"), (0.5 * _AU, _AU, "au"), (1e3 * _AU, 1e3 * _AU, "10^3 au"),
          (0.1 * PARSEC, PARSEC, "pc")],
    "Hz": [(1.0, 1.0, "Hz"), (1e3, 1e3, "kHz"), (1e6, 1e6, "MHz")],
}  # fmt: skip

# Size in SI, dimension and power of the radian of units that most scenes are written in, as astropy has them
# to the last bit (tests/unit/test_units.py): importing it takes longer than reading a scene.
_OF_SCENES = {
    "kg": (1.0, Dimension(1, 0, 0), 0.0), "g": (1e-3, Dimension(1, 0, 0), 0.0),
    "Msun": (SOLAR_MASS, Dimension(1, 0, 0), 0.0),
    "m": (1.0, Dimension(0, 1, 0), 0.0), "cm": (0.01, Dimension(0, 1, 0), 0.0), "km": (1e3, Dimension(0, 1, 0), 0.0),
    "Rsun": (SOLAR_RADIUS, Dimension(0, 1, 0), 0.0), "pc": (PARSEC, Dimension(0, 1, 0), 0.0),
    "au": (_AU, Dimension(0, 1, 0), 0.0),
    "s": (1.0, Dimension(0, 0, 1), 0.0), "ms": (1e-3, Dimension(0, 0, 1), 0.0),
    "min": (60.0, Dimension(0, 0, 1), 0.0), "h": (_HOUR, Dimension(0, 0, 1), 0.0), "d": (_DAY, Dimension(0, 0, 1), 0.0),
    "yr": (_YEAR, Dimension(0, 0, 1), 0.0),
    "m/s": (1.0, Dimension(0, 1, -1), 0.0), "km/s": (1e3, Dimension(0, 1, -1), 0.0),
    "m/s2": (1.0, Dimension(0, 1, -2), 0.0), "rad/s": (1.0, Dimension(0, 0, -1), 1.0),
    "kg/m3": (1.0, Dimension(1, -3, 0), 0.0), "kg m-3": (1.0, Dimension(1, -3, 0), 0.0),
    "g/cm3": (999.9999999999999, Dimension(1, -3, 0), 0.0), "kg m2": (1.0, Dimension(1, 2, 0), 0.0),
}  # fmt: skip

_ASTROPY_NAMES = {"rpm": "cycle / min"}  # of what astropy has by another name
_ANGULAR = {"angle", "angular_velocity", "angular_acceleration"}
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:\s+|(?=[A-Za-zµÅ/(%]))(\S.*?)\s*", re.ASCII)
_WORDS_FOR_NO_NUMBER = re.compile(r"\s*[+-]?(nan|inf|infinity)\b", re.IGNORECASE)


def pressure_constant_dimension(gamma: float) -> Dimension:
    """Dimension of K in P = K rho^gamma.

    >>> print(si_unit(pressure_constant_dimension(2.0)))  # K of P = K rho^2
    kg-1 m5 s-2
    """
    return Dimension(1.0 - gamma, 3.0 * gamma - 1.0, -2.0)


def dimension_of(name: str | Dimension) -> Dimension:
    """The dimension itself, from its name or as given; SceneError for a name that is not in the table.

    >>> print(dimension_of("velocity"))
    Dimension(mass=0, length=1, time=-1)
    """
    if isinstance(name, Dimension):
        return name
    if name not in DIMENSIONS:
        raise SceneError(f"there is no dimension named '{name}': there are {', '.join(DIMENSIONS)}.")
    return DIMENSIONS[name]


def si_unit(dimension: str | Dimension) -> str:
    """The SI unit as astropy, xarray and people read it, such as "kg m2 s-2"; "1" without dimension.

    >>> print(si_unit("angular_momentum"))
    kg m2 s-1
    """
    exponents = dimension_of(dimension)
    parts = [
        symbol if power == 1 else f"{symbol}{power:g}" if power % 1 == 0 else f"{symbol}({_as_fraction(power)})"
        for symbol, power in zip(("kg", "m", "s"), exponents, strict=True)
        if power != 0
    ]
    return " ".join(parts) if parts else "1"


def _as_fraction(power: float) -> str:
    """A power as people write it: -2/3."""
    near = Fraction(power).limit_denominator(20)
    return str(near) if abs(float(near) - power) < 1e-9 else f"{power:.12g}"


def quantity(text: str, dimension: str | Dimension) -> float:
    """The SI value of a quantity string such as "1500 km".

    Angles count as radians where the dimension is angular; Hz is refused there, for it does not say whether it counts
    turns or radians. Raises SceneError for anything that is not one finite number and one unit of that dimension.

    >>> print(f"{quantity('1.4 Msun', 'mass'):.4e}")
    2.7838e+30
    """
    hint = _hint(dimension)
    if len(text) > LONGEST_QUANTITY:
        raise SceneError(f"a quantity of {len(text)} characters is longer than the {LONGEST_QUANTITY} allowed.")
    if _WORDS_FOR_NO_NUMBER.match(text):
        raise SceneError(f"'{shown(text)}' is not a finite number.")
    parts = _QUANTITY.fullmatch(text)
    if parts is None:
        raise SceneError(f"'{shown(text)}' is not a number and a unit{hint}.")
    number, unit = parts.groups()
    scale, exponents, radians = _unit(unit)
    expected = dimension_of(dimension)
    angular = dimension in _ANGULAR
    if not _same(exponents, expected) or (radians != 0 and not angular):
        raise SceneError(f"'{shown(text)}' is not {_phrase(dimension)}{hint}.")
    if angular and dimension != "angle" and re.search(r"Hz|Bq|Ci", unit):
        raise SceneError(f"'{shown(text)}' leaves open whether it counts radians or turns; write rad/s or cycle/s.")
    if dimension == "angle" and radians != 1:
        raise SceneError(f"'{shown(text)}' is not {_phrase(dimension)}{hint}.")
    value = float(number) * scale
    if not math.isfinite(value):
        raise SceneError(f"'{shown(text)}' is not a finite number.")
    if value == 0.0 and re.search(r"[1-9]", re.split("[eE]", number)[0]):
        raise SceneError(f"'{shown(text)}' is too small to differ from zero.")
    return value


def any_quantity(text: str) -> tuple[float, str] | None:
    """The SI value of a quantity string and its SI unit, whatever its dimension; None where it is no quantity.

    >>> print(any_quantity("10 km/s"))
    (10000.0, 'm s-1')
    """
    parts = _QUANTITY.fullmatch(text) if len(text) <= LONGEST_QUANTITY else None
    if parts is None:
        return None
    try:
        scale, exponents, radians = _unit(parts[2])
    except SceneError:
        return None
    unit = " ".join(part for part in ("rad" if radians == 1 else "", si_unit(exponents)) if part)
    value = float(parts[1]) * scale
    return (value, unit.removesuffix(" 1")) if math.isfinite(value) and radians in (0, 1) else None


def shown(text: str, longest: int = 40) -> str:
    """Text as it may be repeated in a message: one line, printable, cut where it is long.

    >>> print(shown("a" * 50, longest=10))
    aaaaaaa...
    """
    clean = "".join(character if character.isprintable() else "?" for character in text)
    return clean if len(clean) <= longest else clean[: longest - 3] + "..."


def failure(error: Exception) -> str:
    """What a user's own code ended with, for a message.

    >>> print(failure(TypeError("not a number")))
    TypeError: not a number
    """
    return f"{type(error).__name__}: {shown(str(error), 200)}"


def readable(unit: str, largest: float) -> tuple[float, str] | None:
    """Size and name of the unit in which people read numbers up to `largest` of an SI unit; None if none is known.

    >>> print(readable("s", 0.1))
    (0.001, 'ms')
    """
    for begin_at, factor, name in reversed(_READABLE.get(unit, [])):
        if largest >= 0.999 * begin_at and largest >= 1e-3 * factor:
            return factor, name
    return None


def known_size(name: str, unit: str) -> float | None:
    """Size of a unit that people read, in the SI unit that it is for; None for others, which astropy may know.

    >>> print(known_size("ms", "s"), known_size("fortnight", "s"))
    0.001 None
    """
    return next((factor for _, factor, known in _READABLE.get(unit, []) if known == name), None)


def display_unit(unit: str, values: Any) -> str:
    """The same as a unit that astropy and others know, for what such values are shown in: "ms" for some of 0.1 s.

    >>> print(display_unit("s", np.array([0.0, 0.1])))
    ms
    """
    largest = float(abs(values).max(initial=0.0))
    shown_in = readable(unit, largest) if 0.0 < largest < math.inf else None
    return unit if shown_in is None or " " in shown_in[1] else shown_in[1]


def astropy_quantity(values: Any, unit: str) -> Any:
    """Values with the unit of a dataset's attribute, "kg m2 s-1", as an astropy Quantity.

    >>> print(astropy_quantity(3600.0, "s").to("h"))
    1.0 h
    """
    from astropy import units as astropy_units  # only here and below: most commands read no unit

    return astropy_units.Quantity(values, "" if unit == "1" else _ASTROPY_NAMES.get(unit, unit))


def parsed(text: str) -> Any:
    """A quantity string of any unit as an astropy Quantity; SceneError where it is none.

    >>> print(parsed("1e12 G").to("T"))
    100000000.0 T
    """
    parts = _QUANTITY.fullmatch(text) if len(text) <= LONGEST_QUANTITY else None
    if parts is not None:
        with suppress(ValueError, TypeError):
            return astropy_quantity(float(parts[1]), parts[2])
    raise SceneError(f"'{shown(text)}' is not a number and a unit that is known here.")


def with_unit(value: Any) -> Any:
    """What has a unit, as an astropy Quantity: one, an array of unyt or a series of a dataset; None for all else.

    SceneError for what has a unit that is none of astropy's, so that none is ever left out.

    >>> from astropy import units as astropy_units
    >>> print(with_unit(astropy_units.Quantity(3.0, "km")), with_unit(3.0))
    3.0 km None
    """
    astropy_units = sys.modules.get("astropy.units")  # whoever has a quantity of astropy has imported it
    if astropy_units is not None and isinstance(value, astropy_units.Quantity):
        return getattr(value, "physical", value)  # of a logarithm, such as dex(kg), the quantity itself
    if astropy_units is not None and isinstance(value, astropy_units.UnitBase):
        return 1.0 * value
    if callable(getattr(value, "to_astropy", None)):
        return value.to_astropy()
    attrs = getattr(value, "attrs", None)
    if isinstance(attrs, Mapping):
        try:
            return astropy_quantity(value.values, str(attrs["units"])) if "units" in attrs else None
        except ValueError:
            raise SceneError(f"its unit '{shown(str(attrs['units']))}' is not known here.") from None
    if hasattr(value, "units") and (hasattr(value, "magnitude") or hasattr(value, "__array__")):
        raise SceneError(f"its unit is one of {shown(type(value).__module__)}; give an astropy Quantity.")
    return None


def stated(value: Any) -> Any:
    """The same of what may also be text, "3 km"; None for what states no unit.

    >>> print(stated("3 km"), stated(3.0))
    3.0 km None
    """
    return parsed(value) if isinstance(value, str) else with_unit(value)


def in_si(value: Any, dimension: str | Dimension | None) -> Any:
    """The numbers of a Quantity in SI, of any shape; SceneError where it has another dimension (None: any unit).

    >>> from astropy import units as astropy_units
    >>> print(in_si(astropy_units.Quantity([1.0, 2.0], "km"), "length"))
    [1000. 2000.]
    """
    text = f"{value:.6g}" if value.isscalar else f"an array in {value.unit}"
    plain = dimension is None or dimension_of(dimension) == Dimension(0, 0, 0)
    if plain and not value.unit.decompose().bases:  # a share, a percentage
        return value.to_value("")
    if dimension is None:
        raise SceneError(f"must be a plain number, not {shown(text)}.")
    written, factor = value.unit.to_string(), 1.0
    if not _can_be_read(written):  # as a pound: a unit that astropy has and does not read
        decomposed = value.unit.decompose()
        factor = decomposed.scale
        written = " ".join(f"{base}{power}" for base, power in zip(decomposed.bases, decomposed.powers, strict=True))
    try:
        scale = factor * quantity(f"1 {written}", dimension)
    except SceneError:
        raise SceneError(f"must be {_phrase(dimension)}, not {shown(text)}{_hint(dimension)}.") from None
    return _wide(value).value * scale


def _wide(value: Any) -> Any:
    """The quantity in float64 at least: a mass of the Sun in float32 has no square in SI."""
    return value.astype(float) if value.dtype.kind == "f" and value.dtype.itemsize < 8 else value


def _can_be_read(unit: str) -> bool:
    from astropy import units as astropy_units

    try:
        astropy_units.Unit(unit)
    except ValueError:
        return False
    return True


def in_unit(value: Any, unit: str | None) -> Any:
    """The numbers of a Quantity in a unit; SceneError where they have none in it (None: where a plain number is meant).

    >>> from astropy import units as astropy_units
    >>> print(f"{in_unit(astropy_units.Quantity(1.9884e30, 'kg'), 'Msun'):.3f}")
    1.000
    """
    from astropy import units as astropy_units

    try:
        return _wide(value).to_value("" if unit is None else unit)
    except astropy_units.UnitConversionError:
        wanted = "a plain number" if unit is None else f"in {unit}, or in units of that kind"
        raise SceneError(f"must be {wanted}, not {shown(f'{value}')}.") from None


def unit_of(variable: Any) -> str:
    """The unit that a variable of a dataset says it has, "1" where it says none.

    >>> import xarray as xr
    >>> print(unit_of(xr.DataArray(2.0, attrs={"units": "kg"})), unit_of(xr.DataArray(2.0)))
    kg 1
    """
    return str(variable.attrs.get("units", "1"))


def written_quantity(value: Any) -> Any:
    """An astropy Quantity as a scene has it: "1.4 solMass", or lists of such; plain numbers without dimension.

    >>> from astropy import units as astropy_units
    >>> print(written_quantity(astropy_units.Quantity([3.0, 4.0], "km")))
    ['3.0 km', '4.0 km']
    """
    from astropy import units as astropy_units

    if not value.unit.decompose().bases:
        return value.to_value("").tolist()
    text = value.unit.to_string()
    try:
        readable_unit = len(text) <= LONGEST_UNIT and astropy_units.Unit(text) == value.unit
    except ValueError:  # it has a name that was made up for it
        readable_unit = False
    if not readable_unit:
        value = value.decompose()
        text = value.unit.to_string()

    def written(numbers: Any) -> Any:
        return [written(item) for item in numbers] if isinstance(numbers, list) else f"{numbers!r} {text}"

    return written(value.value.tolist())


@lru_cache(maxsize=512)
def _unit(text: str) -> tuple[float, Dimension, float]:
    """SI scale, dimension and power of the radian of a unit."""
    if text in _OF_SCENES:
        return _OF_SCENES[text]
    from astropy import units as astropy_units

    powers = [int(digits) for digits in re.findall(r"(?:\*\*|\^|[A-Za-z)])\s*\(?\s*[+-]?(\d+)", text)]
    if any(power > LARGEST_EXPONENT for power in powers):
        raise SceneError(f"the unit '{shown(text)}' has an exponent beyond {LARGEST_EXPONENT}.")
    try:
        with warnings.catch_warnings(), astropy_units.imperial.enable():
            warnings.simplefilter("error")  # astropy warns where it guesses at a unit
            unit: Any = astropy_units.Unit(_ASTROPY_NAMES.get(text, text)).decompose()
            bases = {base.name: float(power) for base, power in zip(unit.bases, unit.powers, strict=True)}
            scale = float(unit.scale)
    except Exception as error:  # ValueError, TypeError, AttributeError and OverflowError have all been seen
        near = difflib.get_close_matches(text[:64], _OF_SCENES, n=1, cutoff=0.7)
        hint = f"; did you mean {near[0]}?" if near else "."
        hint = "; write what it divides by in brackets, as in kg/(m s)." if "multiple slashes" in str(error) else hint
        raise SceneError(f"'{shown(text)}' is not a unit that is known here{hint}") from None
    if not math.isfinite(scale) or scale <= 0.0:
        raise SceneError(f"the unit '{shown(text)}' has no finite size.")
    radians = bases.pop("rad", 0.0)
    dimension = Dimension(bases.pop("kg", 0.0), bases.pop("m", 0.0), bases.pop("s", 0.0))
    ampere = bases.pop("A", 0.0)
    if ampere:  # mu_0^(1/2) A is the root of a newton: mechanics has no other use for currents and fields
        scale *= VACUUM_PERMEABILITY ** (ampere / 2)
        dimension = Dimension(*(a + ampere * b for a, b in zip(dimension, (0.5, 0.5, -1.0), strict=True)))
    if bases:
        raise SceneError(f"'{shown(text)}' is not a unit of mechanics (it contains {', '.join(sorted(bases))}).")
    return scale, dimension, radians


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    # exponents such as 5/3 - 1 reach here by different roads, hence a tolerance
    return all(abs(a - b) < 1e-9 for a, b in zip(one, other, strict=True))


def _phrase(dimension: str | Dimension) -> str:
    if isinstance(dimension, Dimension):
        return f"a quantity in {si_unit(dimension)}"
    if dimension == "dimensionless":
        return "a plain number"
    words = dimension.replace("_", " ")
    return f"an {words}" if words[0] in "aeiou" else f"a {words}"


def _hint(dimension: str | Dimension) -> str:
    example = None if isinstance(dimension, Dimension) else EXAMPLES.get(dimension)
    return f'; write for example "{example}"' if example else ""


def plain_number_hint(dimension: str | Dimension) -> str:
    """What to write instead of a plain number, as the end of a sentence.

    >>> print(plain_number_hint("length"))
    write it as a string with its unit, for example "1500 km"
    """
    if isinstance(dimension, Dimension):
        return f"write it as a string with its unit (in SI: {si_unit(dimension)})"
    return f'write it as a string with its unit, for example "{EXAMPLES.get(dimension, "1 m")}"'


@dataclass(frozen=True)
class CodeUnits:
    """Code units with G = 1, fixed by a unit of mass (kg) and one of length (m).

    `gravitational_constant` is G in the units that mass and length are given in: SI unless the scene is dimensionless,
    where it is 1 and all units are 1. The unit of time is sqrt(length^3 / (G mass)).
    """

    mass: float
    length: float
    gravitational_constant: float = GRAVITATIONAL_CONSTANT

    def __post_init__(self) -> None:
        for name in ("mass", "length", "gravitational_constant"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise SceneError(f"the code unit of {name.replace('_', ' ')} is {value:g}, but must be positive.")
        if not (math.isfinite(self.time) and self.time > 0.0):
            raise SceneError(f"code units of {self.mass:g} kg and {self.length:g} m leave no finite unit of time.")

    @property
    def time(self) -> float:
        """The unit of time in seconds."""
        # the roots are taken first: length^3 overflows where the result does not
        return self.length * math.sqrt(self.length / self.mass) / math.sqrt(self.gravitational_constant)

    def unit(self, dimension: str | Dimension) -> float:
        """The code unit of a dimension, in SI; infinite or 0 where no number is as large or small."""
        exponents = dimension_of(dimension)
        powers = (
            (self.mass, exponents.mass), (self.length, exponents.length), (self.time, exponents.time),
        )  # fmt: skip
        with suppress(OverflowError):
            product = math.prod(base**exponent for base, exponent in powers)
            if 0.0 < product < math.inf:
                return product
        # Powers of large exponents may overflow where their product does not.
        with suppress(OverflowError):
            return math.exp(sum(exponent * math.log(base) for base, exponent in powers))
        return math.inf

    def to_code(self, value, dimension: str | Dimension):
        """SI number or array to code units."""
        return value / self.unit(dimension)

    def to_si(self, value, dimension: str | Dimension):
        """Number or array in code units to SI."""
        return value * self.unit(dimension)


DIMENSIONLESS = CodeUnits(mass=1.0, length=1.0, gravitational_constant=1.0)
"""The units of a scene with `units = "code"`: every conversion is the identity, G = 1."""


class Default:
    """A default that is no number: an option that must be given, or the speed of light."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


ALL_MODELS = ("sph", "ellipsoid", "rigid", "scaling")
REQUIRED = Default("required")
LIGHT = Default("the speed of light")
"""Must be given in a scene in code units, where the speed of light has no value."""


@dataclass(frozen=True)
class Option:
    """One option: its dimension ("choice" for one of `choices`), default in code units and meaning.

    A dimension without a name in units.DIMENSIONS is given by its exponents, units.Dimension(mass, length, time).

    A default of None means that what the option describes is absent. `shape` is () for a number, (3,) for a vector and
    (3, 3) for a matrix; `minimum` and `maximum` bound a number, and are themselves allowed unless `exclusive`. `models`
    are those that it means something to: the others leave it out. `nonzero` is of a vector, whose length must not be.
    """

    dimension: str | Dimension
    default: Any
    text: str
    shape: tuple[int, ...] = ()
    choices: tuple[str, ...] = ()
    minimum: float = -math.inf
    maximum: float = math.inf
    exclusive: bool = False
    models: tuple[str, ...] = ALL_MODELS
    nonzero: bool = False


def positive(dimension: str | Dimension, default: Any, text: str) -> Option:
    """An option that must be above zero.

    >>> positive("length", None, "radius of the torus").minimum, positive("length", None, "radius").exclusive
    (0.0, True)
    """
    return Option(dimension, default, text, minimum=0.0, exclusive=True)


def not_negative(dimension: str | Dimension, default: Any, text: str) -> Option:
    """An option that must not be below zero.

    >>> not_negative("time", 0.0, "when it begins").exclusive
    False
    """
    return Option(dimension, default, text, minimum=0.0)


def choice(text: str, *words: str, default: str = "", models: tuple[str, ...] = ALL_MODELS) -> Option:
    """An option that is one of some words, the first of them unless another default is given.

    >>> choice("axes that it is given in", "inertial", "body").default
    'inertial'
    """
    return Option("choice", default or words[0], text, choices=words, models=models)
