"""How long the next step of each particle may be: limits by acceleration and energy rate, and the shortest of all."""

from collections.abc import Iterable
from typing import Any

from astroinertia.sph.fluid import Fluid

Array = Any
NONE = 1e-100  # rates below this, in code units, are no limit; dividing by its square does not overflow


def acceleration_limit(xp: Any, smoothing_length: Array, acceleration: Array) -> Array:
    """sqrt(h/|a|) of each particle, (N,), from (N,) and (N, 3): Monaghan (1989, J. Comput. Phys. 82, 1)."""
    size = xp.sqrt((acceleration**2).sum(axis=1))
    return xp.sqrt(smoothing_length / xp.maximum(size, NONE))


def energy_limit(xp: Any, fluid: Fluid, heating: Array, acceleration: Array) -> Array:
    """(u + h|a|)/|du/dt| of particles that gain heat, u/|du/dt| of those that lose it, (N,), from (N,) and (N, 3).

    h|a| is the specific energy at hand within a smoothing length: cold gas entering a shock may heat by it in a step.
    """
    at_hand = fluid.smoothing_length * xp.sqrt((acceleration**2).sum(axis=1))
    content = fluid.internal_energy + xp.where(heating > 0.0, at_hand, 0.0)
    rate = xp.abs(heating)
    return xp.where(rate > NONE, content / xp.maximum(rate, NONE), xp.inf)


def shortest(xp: Any, limits: Iterable[Array]) -> Array:
    """The smallest of all limits, scalars or one a particle (N,)."""
    smallest = [xp.min(limit) for limit in limits]
    return xp.min(xp.stack(smallest))
