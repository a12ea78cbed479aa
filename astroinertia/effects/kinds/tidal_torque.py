"""The torque of companions on the tides that they raise in a body."""

from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.characteristic import Neighbour, tidal_parameter
from astroinertia.effects.measure import TURNS, Found, Measure, Options, share_of_momentum, within_all
from astroinertia.matter.rheology import dissipation
from astroinertia.units import REQUIRED, Option, positive


@pytree
@dataclass(frozen=True, eq=False)
class TidalTorque(Effect):
    """tau = 3 k_2 m^2 R^5 dt / r^8 r cross (v - omega cross r), summed over companions: tides lag by a short time dt.

    Each companion of mass m at r, moving at v, attracts only the tide that it raises itself (Mignard 1979, Moon and
    Planets 20, 301; Correia, Levrard & Laskar 2008, A&A 488, L63). With a quality factor Q instead of a time lag, the
    lag is 1/(2 Q) over the rate at which the body turns below the companion (Goldreich & Soter 1966, Icarus 5, 375).
    With a rheology k_2/Q is -Im k_2 at twice that rate, of a homogeneous body or of what yields like one,
    k_2 = k_f/(1 + (k_f/k_e - 1)/j) with the elastic and fluid k and the compliance j of `matter.rheology`, Maxwell's by
    a relaxation time alone, Andrade's with an exponent too. On an eccentric orbit each moment has its own rate.
    """

    love_number: Any
    radius: Any
    time_lag: Any = None
    quality: Any = None
    relaxation_time: Any = None
    fluid_love_number: Any = 1.5
    exponent: Any = None

    kind: ClassVar[str] = "tidal_torque"
    external: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses two measures of the lag, or none, and a fluid that yields less than what is elastic."""
        if sum(options[name] is not None for name in ("time_lag", "quality", "relaxation_time")) != 1:
            raise ValueError("give either time_lag, quality or relaxation_time")
        if options["exponent"] is not None and options["relaxation_time"] is None:
            raise ValueError("an exponent, of Andrade's creep, needs a relaxation_time")
        if options["relaxation_time"] is not None and options["fluid_love_number"] <= options["love_number"]:
            raise ValueError("fluid_love_number must be above love_number, which is the elastic one")
        return cls(**options)

    def quality_at(self, frequency):
        """k_2/(-Im k_2) with the elastic k_2, at a frequency above 0."""
        if self.relaxation_time is None:
            return self.quality
        constants = self.relaxation_time, self.exponent
        return self.love_number / dissipation(self.love_number, self.fluid_love_number, frequency, *constants)

    def torque(self, body):
        """In inertial axes; zero without companions."""
        if body.companions is None:
            return None
        place, speed = body.companions.position(body.time), body.companions.velocity(body.time)
        mass = jnp.asarray(body.companions.mass)[:, None]
        square = jnp.sum(place**2, axis=-1, keepdims=True)
        turning = jnp.cross(place, speed - jnp.cross(body.angular_velocity, place))
        lag = self.time_lag
        if lag is None:
            rate = jnp.sqrt(jnp.sum(turning**2, axis=-1, keepdims=True)) / square
            rate = jnp.where(rate > 0.0, rate, 1.0)
            lag = 0.5 / (self.quality_at(2.0 * rate) * rate)
        return jnp.sum(3.0 * self.love_number * self.radius**5 * mass**2 * lag / square**4 * turning, axis=0)


def tidal_spin_down(body: Characteristic, other: Neighbour, options: Options) -> float:
    """The share of the spin that the torque on the lagging tide takes in the run: 3 k2 G M'^2 R^5 lag/a^6 over C omega.

    k2 times the lag angle is k2/(2 Q), -Im k2/2, or k2 times the time lag times |omega - n|; eccentricity as
    (1 - e)^-6, an upper bound.
    """
    rate = max(abs((body.spin or 0.0) - other.rate), other.rate)
    number, time = options["love_number"], options["relaxation_time"]
    if time is not None:
        lagging = 0.5 * dissipation(number, options["fluid_love_number"], 2.0 * rate, time, options["exponent"])
    elif options["quality"] is not None:
        lagging = 0.5 * number / options["quality"]
    else:
        lagging = number * options["time_lag"] * rate
    strength = 3.0 * body.gravitational_constant * other.mass**2 * options["radius"] ** 5
    return share_of_momentum(body, strength * lagging / (other.distance * (1.0 - other.eccentricity)) ** 6 * body.end)


def _size(body: Characteristic, options: Options) -> Found:
    if not body.neighbours:
        return 0.0, 0.0
    share = sum(tidal_spin_down(body, other, options) for other in body.neighbours)
    tide = 0.0
    if body.radius is not None:
        tide = sum(tidal_parameter(body, other.mass, other.distance) for other in body.neighbours)
    return tide, within_all(share)


ENTRY = Entry(
    "the torque of companions on the tides that they raise, which lag behind",
    {
        "love_number": positive("dimensionless", REQUIRED, "k_2"),
        "radius": positive("length", REQUIRED, "equatorial radius of the body"),
        "time_lag": positive("time", None, "by which tides lag, the same at all frequencies; or give quality"),
        "quality": positive("dimensionless", None, "Q, the same at all frequencies; or give relaxation_time"),
        "relaxation_time": positive("time", None, "viscosity over rigidity of a body that flows as Maxwell's"),
        "exponent": Option(
            "dimensionless", None, "alpha of Andrade's creep on top of it", minimum=0.0, maximum=1.0,
            exclusive=True,
        ),
        "fluid_love_number": positive("dimensionless", 1.5, "k_2 were it fluid; love_number is then the elastic one"),
    },
    "body", "Mignard 1979; Goldreich & Soter 1966; Efroimsky 2012", ("rigid",), colour="green",
    size=Measure(
        "(M'/M) (R/a)^3", "torque on the lagging tide times the run, over L",
        "Goldreich & Soter 1966", _size, (*TURNS, "neighbours"), ("love_number", "radius"),
    ),
    made=TidalTorque, rank=24,
)  # fmt: skip
