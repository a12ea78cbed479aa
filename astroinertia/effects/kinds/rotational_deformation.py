"""The bulge of an elastic body, which follows its rotation at once."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp

from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import pytree


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
