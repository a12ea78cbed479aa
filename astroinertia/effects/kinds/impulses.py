"""Angular momentum added at once: a blow, a landing, a thruster that fires briefly."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import jax.numpy as jnp

from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import pytree


@pytree
@dataclass(frozen=True, eq=False)
class Impulses(Effect):
    """L jumps by `angular_momentum` at `time`, and again `every` so long, `number` times at most."""

    angular_momentum: Any
    time: Any
    every: Any = None
    number: Any = 1e9
    frame: str = field(default="inertial", metadata={"static": True})

    kind: ClassVar[str] = "impulses"
    external: ClassVar[bool] = True

    def breaks(self, start, end):
        """When they come."""
        if self.every is None:
            return (self.time,) if start < self.time <= end else ()
        first = max(0, math.floor((start - self.time) / self.every))
        last = min(int(self.number) - 1, math.ceil((end - self.time) / self.every))
        times = (self.time + number * self.every for number in range(first, last + 1))
        return tuple(time for time in times if start < time <= end)

    def impulse(self, body):
        """What one of them adds, (3,)."""
        vector = jnp.asarray(self.angular_momentum)
        return vector if self.frame == "inertial" else body.attitude.T @ vector
