"""What the size of an effect is made of: a number, and what leaving the effect out would change.

Tests: tests/unit/effects/test_sizes.py.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from astroinertia.effects.characteristic import Characteristic

Options = Mapping[str, Any]
ZONE = ("mass", "radius", "zone")  # what the estimates of one zone need
TURNS = ("moments", "spin")  # what those of torques need
BULGE = 5.0  # of a liquid sphere in a tide, over its tidal parameter: twice 5/2, for a tide that comes suddenly
ROCHE = 0.05  # tidal parameter beyond which a liquid is torn: 1/2.455^3 = 0.068
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


def angular_momentum(body: Characteristic) -> float:
    """C omega, of a body that turns about its largest moment."""
    assert body.moments is not None and body.spin is not None
    return body.moments[2] * body.spin


def share_of_momentum(body: Characteristic, impulse: float) -> float:
    """What is added to the angular momentum, over that: by what angle the axis turns (rad), or the rate changes."""
    momentum = angular_momentum(body)
    return impulse / momentum if momentum > 0.0 else math.inf if impulse > 0.0 else 0.0


def lit(body: Characteristic, options: Options) -> Characteristic:
    """The body with the speed of light of the options."""
    light = options.get("speed_of_light") or body.speed_of_light
    if light is None:
        raise KeyError("speed_of_light")
    return replace(body, speed_of_light=light)


def tidal_change(body: Characteristic, parameter: float) -> float:
    """What a tide does: a bulge of five tidal parameters q to what is bound, q (t/t_dyn)^2 before that; all if torn."""
    assert body.run_length is not None
    if parameter > ROCHE and body.run_length > 1.0:
        return 1.0
    zone = body.zone
    bound = zone is not None and zone.weight >= zone.pressure + zone.turning - 1e-3 * zone.weight
    grown = parameter * body.run_length**2
    change = min(grown, BULGE * parameter) if bound else grown
    if not body.spin or body.moments is None:
        return within_all(change)
    largest = body.moments[2]
    turn = 1.5 * parameter / body.dynamical_time**2 / body.spin  # type: ignore[operator]
    return within_all(change + turn * (largest - body.moments[0]) / largest * min(body.end, 1.0 / body.spin))
