"""How long the next step of each particle may be, by each criterion, and the shortest of all."""

from collections.abc import Iterable, Mapping
from functools import reduce
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import added, elementwise
from astroinertia.models.sph.contact import contact_limit
from astroinertia.models.sph.state import Problem, Rates
from astroinertia.sph.fluid import Fluid
from astroinertia.sph.kernels import KERNELS

Array = Any
NONE = 1e-100  # rates below this, in code units, are no limit; dividing by its square does not overflow


def timestep_limits(problem: Problem, rates: Rates) -> dict[str, Array]:
    """The longest step of a whole body by each criterion, for each particle (N,) or for all: those by particles, and
    "contact" where effects act between neighbours.
    """
    limits = particle_limits(problem, rates)
    if problem.terms("neighbour_terms"):
        limits["contact"] = contact(problem, rates.fluid, shortest(problem.engine.xp, limits.values()))
    return limits


def particle_limits(problem: Problem, rates: Rates) -> dict[str, Array]:
    """The longest step by each criterion, for each particle (N,) or for all: the kinds of effects, and by name."""
    xp, fluid = problem.engine.xp, rates.fluid
    limits = {"longest": xp.asarray(problem.max_timestep)}
    for effect in problem.effects:
        if (limit := effect.timestep(xp, fluid)) is not None:
            limits[effect.kind] = problem.courant * limit
    total = total_acceleration(xp, rates, fluid.velocity)
    limits["acceleration"] = acceleration_limit(xp, fluid.smoothing_length, total, problem.acceleration_factor)
    if (heat := reduce(added, rates.heating, None)) is not None:
        limits["energy"] = energy_limit(xp, fluid, heat, total, problem.energy_factor)
    return limits


def contact(problem: Problem, fluid: Fluid, step: Array) -> Array:
    """The longest step before matter that is apart meets, beside the step that all else allows."""
    moving, support = (fluid.position, fluid.velocity, fluid.smoothing_length), KERNELS[problem.kernel].support
    return contact_limit(problem.engine.xp, *moving, support, step)


def total_acceleration(xp: Any, rates: Rates, velocity: Array) -> Array:
    """The sum over effects at the given velocity, (N, 3)."""
    total = rates.total
    for matrix in rates.drag:
        total = total if matrix is None else total + velocity @ matrix.T
    return total


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
