"""What the catalogue of effects is made of: entries, options and their dimensions, as plain data."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from astroinertia.effects.measure import Measure
from astroinertia.units import Dimension

Cost = Literal["particles", "neighbours", "all pairs", "body"]
Pace = Callable[[Mapping[str, Any]], tuple[float, float | None]]


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

    A dimension without a name in DIMENSIONS is given by its exponents, units.Dimension(mass, length, time).

    A default of None means that what the option describes is absent. `shape` is () for a number, (3,) for a vector and
    (3, 3) for a matrix; `minimum` and `maximum` bound a number, and are themselves allowed unless `exclusive`. `models`
    are those that it means something to: the others leave it out.
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


@dataclass(frozen=True)
class Entry:
    """One effect: its module and class, one line on what it is, its options, the loop it needs and its source.

    models: those that have it. A numerical device of particles is not physics: other models need it not and skip it.
    size: how its size in a scene is estimated; None where it states none. colour: that of figures, of plots.style; a
    spare one without it. pace: from its options, the time that steps must resolve and until when (None: to the end),
    where these follow from options alone. auto: where `effects = "auto"` considers it that is not among a scene's
    candidates: "always", where there are "companions", or where bodies or kinds of matter are "touching". needs: the
    effects that it cannot be without. gradients: whether it asks for a pass over gradients, from its options.
    limit_power: of the number of particles, that its time-step limit falls with. made: the class itself, of an effect
    that is not of this package; package: name and version of the one that it comes from, empty where it was given from
    Python.
    """

    module: str
    class_name: str
    text: str
    options: Mapping[str, Option]
    cost: Cost
    source: str
    models: tuple[str, ...] = ("sph",)
    numerical: bool = False
    size: Measure | None = None
    colour: str = ""
    pace: Pace | None = None
    auto: Literal["", "always", "companions", "touching"] = ""
    needs: tuple[str, ...] = ()
    gradients: Callable[[Mapping[str, Any]], bool] | None = None
    limit_power: float = 0.0
    made: type | None = None
    package: str = ""

    @property
    def origin(self) -> str:
        """Where it comes from, in words; empty for an effect of this package."""
        if self.made is None:
            return ""
        return self.package or f"the class {self.made.__qualname__} of {self.module}, given from Python"


# Exponents of (mass, length, time) of every dimension that an option may have.
DIMENSIONS: Mapping[str, tuple[float, float, float]] = {
    "dimensionless": (0, 0, 0),
    "mass": (1, 0, 0),
    "moment_of_inertia": (1, 2, 0),
    "length": (0, 1, 0),
    "time": (0, 0, 1),
    "velocity": (0, 1, -1),
    "acceleration": (0, 1, -2),
    "angular_velocity": (0, 0, -1),
    "angular_acceleration": (0, 0, -2),
    "inverse_time_squared": (0, 0, -2),
    "angle": (0, 0, 0),
    "torque": (1, 2, -2),
    "force": (1, 1, -2),
    "pressure": (1, -1, -2),
    "angular_momentum": (1, 2, -1),
    "energy": (1, 2, -2),
    "power": (1, 2, -3),
    "rate": (0, 0, -1),
    "viscosity": (0, 2, -1),
    "magnetic_field": (0.5, -0.5, -1),
    "density": (1, -3, 0),
    "specific_energy": (0, 2, -2),
    "specific_power": (0, 2, -3),
}


def exponents(dimension: str | Dimension) -> Dimension:
    """Exponents of mass, length and time of an option's dimension."""
    return Dimension(*DIMENSIONS[dimension]) if isinstance(dimension, str) else dimension


def positive(dimension: str | Dimension, default: Any, text: str) -> Option:
    """An option that must be above zero."""
    return Option(dimension, default, text, minimum=0.0, exclusive=True)


def not_negative(dimension: str | Dimension, default: Any, text: str) -> Option:
    """An option that must not be below zero."""
    return Option(dimension, default, text, minimum=0.0)


AXIS = (0.0, 0.0, 1.0)
FORCE_ERROR = 2e-4  # of gravity, wanted rms of |da|/|a|: less than the fluid's own discretisation leaves
DIFFUSION_PART = 0.125  # of h^2/nu, that the limit of viscous steps is (Morris, Fox & Zhu 1997, JCP 136, 214, eq. 20)
FREE_FALL_PART = 0.3  # of the free-fall time, that gravity's own time-step limit is
