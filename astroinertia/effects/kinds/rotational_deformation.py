"""The bulge of an elastic body, which follows its rotation at once."""

from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import TURNS, Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.units import REQUIRED, not_negative, positive


@pytree
@dataclass(frozen=True, eq=False)
class RotationalDeformation(Effect):
    """The inertia tensor grows by D (omega (x) omega - omega^2/3) with D = k_2 R^5/3: L = (I + 2/3 D omega^2) omega.

    A bulge that follows the pole does not make it wobble, and so the wobble slows down (Munk & MacDonald 1960, The
    Rotation of the Earth, chapter 6). The strain holds the energy D omega^4/6. `rate` is the spin about the largest
    moment at which the body has its moments.
    """

    love_number: Any
    radius: Any
    rate: Any = 0.0

    kind: ClassVar[str] = "rotational_deformation"
    follows_spin: ClassVar[bool] = True
    conservative: ClassVar[bool] = True

    @property
    def deformability(self) -> Any:
        """D, with G = 1."""
        return self.love_number * self.radius**5 / 3.0

    def potential(self, body):
        """The energy of the strain."""
        return self.deformability * jnp.sum(body.angular_velocity**2) ** 2 / 6.0


def _size(body: Characteristic, options: Options) -> Found:
    assert body.moments is not None and body.spin is not None
    per_square = options["love_number"] * options["radius"] ** 5 / (3.0 * body.gravitational_constant)
    bulge = per_square * body.spin**2 / body.moments[2]
    grown = 2.0 / 3.0 * per_square * abs(body.spin**2 - options["rate"] ** 2) / body.moments[2]
    return bulge, within_all(grown + body.wobble * min(1.0, bulge * body.spin * body.end))


ENTRY = Entry(
    "the bulge of an elastic body, which follows its rotation at once and so slows its wobble",
    {
        "love_number": positive("dimensionless", REQUIRED, "k_2"),
        "radius": positive("length", REQUIRED, "equatorial radius of the body"),
        "rate": not_negative(
            "angular_velocity", 0.0, "rotation about the largest moment at which the body has its moments",
        ),
    },
    "body", "Munk & MacDonald 1960, chapter 6; Love 1909", ("rigid",), colour="vermillion",
    size=Measure(
        "bulge k2 R^5 omega^2/(3 G C)", "what the bulge adds to C, and the wobble where its phase has changed",
        "Munk & MacDonald 1960, 6", _size, TURNS, ("love_number", "radius"),
    ),
    made=RotationalDeformation, rank=25,
)  # fmt: skip
