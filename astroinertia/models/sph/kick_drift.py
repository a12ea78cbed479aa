"""Kick and drift: what a step does to particles, with what the ledgers enter of it.

A force linear in the velocity enters through its matrix M_e by the implicit midpoint rule, so that a Coriolis force
does no work. Global and individual steps are made of these two alike; the latter kick some of the particles at a time,
which are then given by their indices, `active` (n,).
"""

from collections.abc import Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from astroinertia.engines.elementwise import added, elementwise
from astroinertia.engines.pytree import with_fields
from astroinertia.ledger.moments import Ledgers, Whole
from astroinertia.models.sph import points
from astroinertia.models.sph.heat import Heat, after_heat, entropy_after
from astroinertia.models.sph.state import State, rows

Array = Any


class VelocityChange(NamedTuple):
    """Velocities before and after a kick, (n, 3); `length` times the increment of each effect adds up to the change."""

    before: Array
    after: Array
    increments: Sequence[Array | None]
    length: Array | float


def two_sum(xp, x, remainder, v, dt):
    """x + remainder + dt v of one component, rounded, and what rounding leaves of it (Knuth's two-sum)."""
    way = dt * v + remainder
    place = x + way
    part = place - x
    return place, (x - (place - part)) + (way - part)


def moved(xp, x, remainder, v, dt):
    """The place dt later, and what rounding leaves of it."""
    x_0, left_0 = two_sum(xp, x[0], remainder[0], v[0], dt)
    x_1, left_1 = two_sum(xp, x[1], remainder[1], v[1], dt)
    x_2, left_2 = two_sum(xp, x[2], remainder[2], v[2], dt)
    return (x_0, x_1, x_2), (left_0, left_1, left_2)


def changed(xp, v, a, length):
    """v + length a."""
    return ((v[0] + length * a[0], v[1] + length * a[1], v[2] + length * a[2]),)


def drift(xp: Any, state: State, dt: Array, counted: Array | None = None, whole: Whole | None = None) -> State:
    """Free motion over dt of particles, of the points beside them, and of the body as the ledgers have it.

    counted, whole: as in `carried_on`, where a part of the body drifts by itself.
    """
    ledgers = Ledgers(state.ledger, state.regions).drifted(xp, dt)
    time = state.time + dt
    beside = points.drifted(xp, state.points, dt, time)
    state = with_fields(state, time=time, points=beside, ledger=ledgers.body, regions=ledgers.regions)
    return carried_on(xp, state, dt, counted, whole)


def carried_on(xp: Any, state: State, dt: Array, counted: Array | None, whole: Whole | None) -> State:
    """Particles dt later, with what rounding did to their places entered into ledgers that have drifted already.

    counted: the masses (N,) that are entered, without it all of them; whole: the body afterwards, where these particles
    are not all of it.
    """
    before, mass = state.position, state.mass if counted is None else counted
    position, remainder = elementwise(xp, moved, before, state.remainder, state.velocity, dt)
    ledgers = Ledgers(state.ledger, state.regions)
    ledgers = ledgers.rounded(xp, mass, state.members(), before, position, state.velocity, dt, whole)
    return with_fields(state, position=position, remainder=remainder, ledger=ledgers.body, regions=ledgers.regions)


def kick(
    xp: Any, state: State, change: VelocityChange, heat: Heat, density: Array, matter: Any = None,
    active: Array | None = None, whole: Whole | None = None,
) -> State:  # fmt: skip
    """Velocities changed and entropies heated at fixed positions, and what each effect did in the ledgers.

    density (n,) and matter, the equation of state of the particles that are kicked, where their energy is not linear in
    the entropy function. whole: the body before the kick, where these are not all of its particles.
    """
    mass, position, entropy = (rows(array, active) for array in (state.mass, state.position, state.entropy))
    ledgers = Ledgers(state.ledger, state.regions).kicked(xp, mass, state.members(active), position, *change, whole)
    entropy, energies = after_heat(xp, heat, mass, entropy, density, matter)
    ledgers = ledgers.heated(xp.asarray(energies))
    return with_fields(
        state,
        velocity=_written(state.velocity, active, change.after),
        entropy=_written(state.entropy, active, entropy),
        ledger=ledgers.body,
        regions=ledgers.regions,
    )


def predicted(xp: Any, state: State, dt: Array) -> tuple[Array, Array]:
    """Velocities (N, 3) and entropies (N,) dt later, from the last rates.

    A kick makes them so, but for the entropies of matter whose energy is not linear in them, which here are right to
    first order; velocity-dependent effects are evaluated with those in the middle of a step.
    """
    change = change_by_rates(xp, state, dt)
    return change.after, entropy_after(xp, state.rates.exchange, state.entropy, dt * state.rates.entropy_rate, dt)


def change_by_rates(xp: Any, state: State, dt: Array) -> VelocityChange:
    """What the rates of a state make of its velocities over dt."""
    rates = state.rates
    return velocity_change(xp, rates.acceleration, rates.drag, state.velocity, dt, dt, rates.total)


def velocity_change(
    xp: Any, pushes: Sequence[Array | None], drags: Sequence[Array | None], before: Array, span: Array,
    length: Array | float = 1.0, total: Array | None = None,
) -> VelocityChange:  # fmt: skip
    """What `length` times the push of each effect, (n, 3), and its drag M_e (3, 3) over span do to velocities (n, 3).

    dv_e = length push_e + span M_e (v + v')/2 with v' = v + sum_e dv_e solved for exactly; span () or, with numpy,
    (n,). total: the sum of the pushes, where it is known.
    """
    matrices = [matrix for matrix in drags if matrix is not None]
    if not matrices:
        total = reduce(added, pushes, None) if total is None else total
        after = before if total is None else elementwise(xp, changed, before, total, length)[0]
        return VelocityChange(before, after, pushes, length)
    free = [xp.zeros_like(before) if push is None else length * push for push in pushes]
    matrix: Any = sum(matrices[1:], start=matrices[0])
    spans = xp.reshape(xp.asarray(span), (-1, 1))
    halfway = before + sum(free) + 0.5 * spans * (before @ matrix.T)
    after = _solved(xp, matrix, halfway, span)
    middle = 0.5 * spans * (before + after)
    increments = [push if drag is None else push + middle @ drag.T for push, drag in zip(free, drags, strict=True)]
    return VelocityChange(before, before + sum(increments), increments, 1.0)


def _solved(xp: Any, matrix: Array, halfway: Array, span: Array) -> Array:
    """v' with (1 - span M/2) v' = halfway."""
    if np.ndim(span) == 0:
        return halfway @ xp.linalg.inv(xp.eye(3) - 0.5 * span * matrix).T
    after = np.empty_like(halfway)
    for length in np.unique(span):
        chosen = span == length
        after[chosen] = _solved(xp, matrix, halfway[chosen], length)
    return after


def _written(array: Array, active: Array | None, values: Array) -> Array:
    # A base step of individual steps owns its arrays: where few particles are kicked, they are changed in place.
    if active is None:
        return values
    array[active] = values
    return array
