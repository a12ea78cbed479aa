"""Uniform gravity on a body that turns about a fixed point: tops, gyroscopes, pendulums."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp

from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import pytree


@pytree
@dataclass(frozen=True, eq=False)
class Pivot(Effect):
    """tau = l cross M g about the fixed point, with the arm l from there to the centre of mass, fixed in the body.

    The body's moments are those about its centre of mass; the model takes them to the pivot.
    """

    gravity: Any
    arm: Any

    kind: ClassVar[str] = "pivot"
    external: ClassVar[bool] = True
    conservative: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses a centre of mass at the fixed point."""
        if not any(options["arm"]):
            raise ValueError("the arm must not have zero length")
        return cls(**options)

    def place(self, body):
        """The centre of mass from the fixed point, (3,), in inertial axes."""
        return body.attitude.T @ jnp.asarray(self.arm)

    def torque(self, body):
        """About the fixed point."""
        return body.mass * jnp.cross(self.place(body), jnp.asarray(self.gravity))

    def potential(self, body):
        """-M g . l, zero where the centre of mass is level with the fixed point."""
        return -body.mass * (self.place(body) @ jnp.asarray(self.gravity))

    def frequency(self, body):
        """Of small oscillations about the axis of the least moment."""
        strength = body.mass * jnp.linalg.norm(jnp.asarray(self.gravity)) * jnp.linalg.norm(jnp.asarray(self.arm))
        across = jnp.sort(jnp.linalg.eigvalsh(body.inertia))
        return jnp.sqrt(strength / across[1])
