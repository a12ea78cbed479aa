"""How long the next step may be: Courant, acceleration and energy-rate limits of a global time step."""

from typing import Any

from astroinertia.sph.fluid import Fluid

Array = Any
NONE = 1e-100  # rates below this, in code units, are no limit; dividing by its square does not overflow


def acceleration_limit(xp: Any, smoothing_length: Array, acceleration: Array) -> Array:
    """min sqrt(h/|a|) over particles, (N,), (N, 3): Monaghan (1989, J. Comput. Phys. 82, 1)."""
    size = xp.sqrt((acceleration**2).sum(axis=1))
    return xp.sqrt(xp.min(smoothing_length / xp.maximum(size, NONE)))


def energy_limit(xp: Any, fluid: Fluid, heating: Array, acceleration: Array) -> Array:
    """min (u + h|a|)/|du/dt| over particles that gain heat, u/|du/dt| over those that lose it, (N,), (N, 3).

    h|a| is the specific energy at hand within a smoothing length: cold gas entering a shock may heat by it in a step.
    """
    at_hand = fluid.smoothing_length * xp.sqrt((acceleration**2).sum(axis=1))
    content = fluid.internal_energy + xp.where(heating > 0.0, at_hand, 0.0)
    rate = xp.abs(heating)
    return xp.min(xp.where(rate > NONE, content / xp.maximum(rate, NONE), xp.inf))


def shortest(xp: Any, limits: list[Array]) -> Array:
    """The smallest of scalar limits."""
    shortest_limit = limits[0]
    for limit in limits[1:]:
        shortest_limit = xp.minimum(shortest_limit, limit)
    return shortest_limit
