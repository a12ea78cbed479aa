"""An affine body that coasts, but for a push that lasts a moment."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import jax.numpy as jnp
import numpy as np

from astroinertia.effects import Effect, pytree
from astroinertia.models.ellipsoid.affine_body import Problem
from astroinertia.models.ellipsoid.evolution import Ellipsoid, started


@pytree
@dataclass(frozen=True, eq=False)
class Burn(Effect):
    """A uniform acceleration along x, from one time to another, which `during` alone says."""

    strength: Any
    begin: Any
    until: Any

    kind: ClassVar[str] = "burn"
    external: ClassVar[bool] = True

    def affine_push(self, body: Any) -> Any:
        """M g."""
        return body.mass * self.strength * jnp.eye(3)[0]

    def breaks(self, start: float, end: float) -> tuple[float, ...]:
        """When it begins and ends."""
        return tuple(float(time) for time in (self.begin, self.until) if start < time <= end)

    def during(self, start: float, end: float) -> Self:
        """With or without it, the ends included."""
        lasts = self.begin <= 0.5 * (start + end) < self.until
        return replace(self, strength=self.strength if lasts else 0.0)


def coasting(strength: float) -> Ellipsoid:
    """A body that nothing else acts on."""
    problem = Problem((Burn(strength, 5.0, 5.001),), 1.0, 1.0, 0.2, -0.6)
    return started(problem, np.eye(3), 1e-3 * np.eye(3), 0.0, tolerance=1e-10, density=1.0, approximation="of a test")
