"""The torque of companions on the tides that they raise in a body."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp

from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import pytree


@pytree
@dataclass(frozen=True, eq=False)
class TidalTorque(Effect):
    """tau = 3 k_2 m^2 R^5 dt / r^8 r cross (v - omega cross r), summed over companions: tides lag by a short time dt.

    Each companion of mass m at r, moving at v, attracts only the tide that it raises itself (Mignard 1979, Moon and
    Planets 20, 301; Correia, Levrard & Laskar 2008, A&A 488, L63). With a quality factor Q instead of a time lag, the
    lag is 1/(2 Q) over the rate at which the body turns below the companion (Goldreich & Soter 1966, Icarus 5, 375).
    """

    love_number: Any
    radius: Any
    time_lag: Any = None
    quality: Any = None

    kind: ClassVar[str] = "tidal_torque"
    external: ClassVar[bool] = True
    follows_spin: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses two measures of the lag, or none."""
        if (options["time_lag"] is None) == (options["quality"] is None):
            raise ValueError("give either time_lag or quality")
        return cls(**options)

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
            lag = 0.5 / (self.quality * jnp.where(rate > 0.0, rate, 1.0))
        return jnp.sum(3.0 * self.love_number * self.radius**5 * mass**2 * lag / square**4 * turning, axis=0)
