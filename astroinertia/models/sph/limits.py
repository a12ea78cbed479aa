"""How long the next step of each particle may be, by each criterion, and the shortest of all.

Signal velocities tell of neighbours alone. Two bodies that approach each other far above the speed of sound are not
neighbours yet, and a step that suits each by itself would carry one through the other: "contact" limits that. Particles
in the order of their leaves are taken in groups there, each a sphere that moves with some velocity and spreads with
another.
"""

import math
from collections.abc import Iterable, Mapping
from functools import lru_cache, reduce
from typing import Any

import numpy as np

from astroinertia.effects.gradients import dot
from astroinertia.engines.elementwise import added, by_numpy, elementwise
from astroinertia.models.sph.compiled import compiled
from astroinertia.models.sph.state import Problem, Rates
from astroinertia.sph.fluid import Fluid
from astroinertia.sph.kernels import KERNELS

Array = Any
DEPTH = 0.5  # smoothing lengths that matter may go into other matter in one step
GROUPS = 256  # spheres: their pairs cost less than a thousandth of a step of many particles
FEW = 4  # steps to a time that is to be met, or fewer, are made equally long
NONE = 1e-100  # rates below this, in code units, are no limit; dividing by its square does not overflow


@compiled
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
    moving = fluid.smoothing_length, total, problem.acceleration_factor
    heat = reduce(added, rates.heating, None)
    if heat is None:
        (limits["acceleration"],) = elementwise(xp, crossing, *moving)
    else:
        heating = fluid.internal_energy, heat, problem.energy_factor
        limits["acceleration"], limits["energy"] = elementwise(xp, crossing_and_doubling, *moving, *heating)
    return limits


def contact(problem: Problem, fluid: Fluid, step: Array) -> Array:
    """The longest step before matter that is apart meets, beside the step that all else allows."""
    moving, support = (fluid.position, fluid.velocity, fluid.smoothing_length), KERNELS[problem.kernel].support
    return contact_limit(problem.engine.xp, *moving, support, step)


def contacts(problem: Problem, position: Array, velocity: Array, smoothing_length: Array, step: float) -> Array:
    """The same of each particle, (N,): the longest step before the group that it is in meets another one (numpy)."""
    moving, support = (position, velocity, smoothing_length), KERNELS[problem.kernel].support
    if goes_nowhere(velocity, smoothing_length, step):
        return np.full(len(position), np.inf)
    pairs, rows = meetings(np, *moving, support)
    of_groups = np.full((len(rows), len(rows)), np.inf)
    one, other = pairs_of(len(rows))
    of_groups[one, other] = of_groups[other, one] = pairs
    return np.repeat(of_groups.min(axis=1), rows.shape[1])[: len(position)]


def total_acceleration(xp: Any, rates: Rates, velocity: Array) -> Array:
    """The sum over effects at the given velocity, (N, 3)."""
    total = rates.total
    for matrix in rates.drag:
        total = total if matrix is None else total + velocity @ matrix.T
    return total


def shortest(xp: Any, limits: Iterable[Array]) -> Array:
    """The smallest of all limits, scalars or one a particle (N,)."""
    smallest = [xp.min(limit) for limit in limits]
    return xp.min(xp.stack(smallest))


def limiting(limits: Mapping[str, Array]) -> tuple[str, int | None]:
    """The criterion that sets the step, and the particle that it is set at; None where it is one for all particles."""
    name = min(limits, key=lambda criterion: float(np.min(np.asarray(limits[criterion]))))
    limit = np.asarray(limits[name])
    return name, int(np.argmin(limit)) if limit.ndim else None


def towards(remaining: float, longest: float) -> float:
    """The next step to a time that is to be met: as long as is allowed, or an equal part of what little remains.

    So many steps are needed in any case; made equally long, none is a small remainder.
    """
    parts = steps_left(remaining, longest)
    return remaining / parts if parts else longest


def steps_left(remaining: float, longest: float) -> int:
    """How many steps, made equally long, meet that time; 0 where it is further off than FEW steps."""
    return max(1, math.ceil(remaining / longest * (1.0 - 1e-12))) if remaining < FEW * longest else 0


def root(xp: Any, square: Array) -> Array:
    """The square root, whose gradient is zero at zero."""
    return xp.where(square > 0.0, xp.sqrt(xp.where(square > 0.0, square, 1.0)), 0.0)


def contact_limit(
    xp: Any, position: Array, velocity: Array, smoothing_length: Array, support: float, step: Array
) -> Array:
    """The longest step, a scalar, in which no two groups go deeper into each other than DEPTH smoothing lengths h.

    A pair of groups whose kernels, of `support` smoothing lengths, leave a gap and that close in at the rate w may step
    by (gap + DEPTH h)/w. position, velocity (N, 3), smoothing_length (N,), sorted; step is what all else allows: where
    that takes nothing so deep, numpy looks no further. Test: tests/unit/models/sph/test_limits.py.
    """
    if by_numpy(xp) and goes_nowhere(velocity, smoothing_length, step):
        return np.float64(np.inf)
    return xp.min(meetings(xp, position, velocity, smoothing_length, support)[0])


def goes_nowhere(velocity: Array, smoothing_length: Array, step: Array) -> bool:
    """Whether no particle gets so deep into others within a step, wherever they are: a matter of speed alone."""
    return bool(step * 2.0 * fastest(velocity) <= DEPTH * smoothing_length.min())


def meetings(
    xp: Any, position: Array, velocity: Array, smoothing_length: Array, support: float
) -> tuple[Array, Array]:  # fmt: skip
    """(gap + DEPTH h)/w of each pair of groups, as `pairs_of` has them, and the particles of each, (K, members)."""
    relative = velocity - velocity.mean(axis=0)
    count = len(smoothing_length)
    members = -(-count // min(count, GROUPS))
    rows = np.minimum(np.arange(-(-count // members) * members), count - 1).reshape(-1, members)

    def spheres(vector: Array) -> tuple[Array, Array]:
        inside = [xp.take(vector[:, k], rows) for k in range(3)]  # by components, as numpy is slow along axes of three
        middle = [0.5 * (component.min(axis=1) + component.max(axis=1)) for component in inside]
        x, y, z = (component - centre[:, None] for component, centre in zip(inside, middle, strict=True))
        return xp.stack(middle, axis=1), root(xp, (x * x + y * y + z * z).max(axis=1))

    groups = *spheres(position - position.mean(axis=0)), *spheres(relative), smoothing_length[rows].max(axis=1)
    pairs = (xp.take(of_group, of, axis=0) for of in pairs_of(len(rows)) for of_group in groups)
    return elementwise(xp, meeting, *pairs, support, DEPTH)[0], rows


def fastest(velocity: np.ndarray) -> float:
    """The largest speed relative to the mean velocity (N, 3); by components, as numpy is slow along axes of three."""
    x, y, z = (component - component.mean() for component in velocity.T)
    return math.sqrt((x * x + y * y + z * z).max())


@lru_cache(maxsize=4)
def pairs_of(count: int) -> tuple[Array, Array]:
    """Every pair of so many, each with itself as well."""
    return np.triu_indices(count)


def meeting(
    xp, centre_i, radius_i, drift_i, spread_i, h_i, centre_j, radius_j, drift_j, spread_j, h_j, support, depth
):  # fmt: skip
    """(gap + depth h)/w of two groups, infinite where they part."""
    apart = centre_i[0] - centre_j[0], centre_i[1] - centre_j[1], centre_i[2] - centre_j[2]
    moving = drift_i[0] - drift_j[0], drift_i[1] - drift_j[1], drift_i[2] - drift_j[2]
    distance, speed = root(xp, dot(xp, apart, apart)), root(xp, dot(xp, moving, moving))
    towards = xp.where(distance > 0.0, -dot(xp, apart, moving) / xp.where(distance > 0.0, distance, 1.0), speed)
    closing = towards + spread_i + spread_j
    reach = xp.maximum(h_i, h_j)
    gap = xp.maximum(distance - radius_i - radius_j - support * reach, 0.0)
    return (xp.where(closing > 0.0, (gap + depth * reach) / xp.where(closing > 0.0, closing, 1.0), xp.inf),)


def size(xp, a):
    """|a|."""
    return xp.sqrt(a[0] ** 2 + a[1] ** 2 + a[2] ** 2)


def crossing(xp, h, acceleration, factor):
    """factor sqrt(h/|a|): Monaghan (1989, J. Comput. Phys. 82, 1)."""
    return (factor * xp.sqrt(h / xp.maximum(size(xp, acceleration), NONE)),)


def doubling(xp, h, acceleration, internal_energy, heating, factor):
    """factor (u + h|a|)/|du/dt| of a particle that gains heat, factor u/|du/dt| of one that loses it.

    h|a| is the specific energy at hand within a smoothing length: cold gas entering a shock may heat by it in a step.
    """
    content = internal_energy + xp.where(heating > 0.0, h * size(xp, acceleration), 0.0)
    rate = xp.abs(heating)
    limit = xp.where(rate > NONE, factor * content / xp.maximum(rate, NONE), xp.inf)
    # Cold solids have no energy to lose, or less than none by the error of their table: kicks keep their entropy.
    return (xp.where(content > 0.0, limit, xp.inf),)


def crossing_and_doubling(xp, h, acceleration, factor, internal_energy, heating, energy_factor):
    """Both of these."""
    return (
        *crossing(xp, h, acceleration, factor),
        *doubling(xp, h, acceleration, internal_energy, heating, energy_factor),
    )
