"""What the size of an effect is made of: a number, and what leaving the effect out would change."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from astroinertia.effects.characteristic import Characteristic

Options = Mapping[str, Any]
ZONE = ("mass", "radius", "zone")  # what the estimates of one zone need
Found = tuple[float, float]
"""The dimensionless number, and the relative change of the observables."""


@dataclass(frozen=True)
class Measure:
    """How the size of an effect is found.

    name: of the number. formula: of the change, in words. needs: characteristic numbers, options: options that it is
    not known without.
    """

    name: str
    formula: str
    source: str
    function: Callable[[Characteristic, Options], Found]
    needs: tuple[str, ...] = ()
    options: tuple[str, ...] = ()


def within_all(change: float) -> float:
    """A change, at most all there is."""
    return min(1.0, abs(change))


def dot(a: Any, b: Any) -> float:
    """a . b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def size(vector: Any) -> float:
    """|a|."""
    return dot(vector, vector) ** 0.5
