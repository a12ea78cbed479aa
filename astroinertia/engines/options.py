"""What an option of an effect, an equation of state, a body or an observable is: its dimension, default and limits."""

import math
from dataclasses import dataclass
from typing import Any

from astroinertia.units import Dimension


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


def positive(dimension: str | Dimension, default: Any, text: str) -> Option:
    """An option that must be above zero."""
    return Option(dimension, default, text, minimum=0.0, exclusive=True)


def not_negative(dimension: str | Dimension, default: Any, text: str) -> Option:
    """An option that must not be below zero."""
    return Option(dimension, default, text, minimum=0.0)
