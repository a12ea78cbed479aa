"""How long the next step of each particle may be: limits by acceleration and energy rate, and the shortest of all."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import elementwise
from astroinertia.sph.fluid import Fluid

Array = Any
NONE = 1e-100  # rates below this, in code units, are no limit; dividing by its square does not overflow


def size(xp, a):
    """|a|."""
    return xp.sqrt(a[0] ** 2 + a[1] ** 2 + a[2] ** 2)


def crossing(xp, h, acceleration, factor):
    """factor sqrt(h/|a|)."""
    return (factor * xp.sqrt(h / xp.maximum(size(xp, acceleration), NONE)),)


def doubling(xp, h, acceleration, internal_energy, heating, factor):
    """factor times the energy at hand over its rate."""
    content = internal_energy + xp.where(heating > 0.0, h * size(xp, acceleration), 0.0)
    rate = xp.abs(heating)
    limit = xp.where(rate > NONE, factor * content / xp.maximum(rate, NONE), xp.inf)
    # Cold solids have no energy to lose, or less than none by the error of their table: kicks keep their entropy.
    return (xp.where(content > 0.0, limit, xp.inf),)


def acceleration_limit(xp: Any, smoothing_length: Array, acceleration: Array, factor: Array | float = 1.0) -> Array:
    """factor sqrt(h/|a|) of each particle, (N,), from (N,) and (N, 3): Monaghan (1989, J. Comput. Phys. 82, 1)."""
    return elementwise(xp, crossing, smoothing_length, acceleration, factor)[0]


def energy_limit(xp: Any, fluid: Fluid, heating: Array, acceleration: Array, factor: Array | float = 1.0) -> Array:
    """(u + h|a|)/|du/dt| of particles that gain heat, u/|du/dt| of those that lose it, (N,), from (N,) and (N, 3).

    h|a| is the specific energy at hand within a smoothing length: cold gas entering a shock may heat by it in a step.
    """
    return elementwise(xp, doubling, fluid.smoothing_length, acceleration, fluid.internal_energy, heating, factor)[0]


def shortest(xp: Any, limits: Iterable[Array]) -> Array:
    """The smallest of all limits, scalars or one a particle (N,)."""
    smallest = [xp.min(limit) for limit in limits]
    return xp.min(xp.stack(smallest))


def limiting(limits: Mapping[str, Array]) -> tuple[str, int | None]:
    """The criterion that sets the step, and the particle that it is set at; None where it is one for all particles."""
    name = min(limits, key=lambda criterion: float(np.min(np.asarray(limits[criterion]))))
    limit = np.asarray(limits[name])
    return name, int(np.argmin(limit)) if limit.ndim else None
