"""A rigid body through many output times in one compiled program: by the splitting, or adaptively.

Each part of the way, with its steps, follows from the state and the next output time alone, and not from where a call
began: so a run that was stopped after any call goes on bit for bit.
"""

import math
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines import adaptive
from astroinertia.engines.brief import brief
from astroinertia.ledger.moments import Compensated
from astroinertia.models.rigid import body as rigid, splitting, two_way
from astroinertia.models.rigid.body import Rigid
from astroinertia.models.rigid.splitting import Rotor

Array = Any

AT_ONCE = 256
"""Output times of a call: one program serves any number up to it."""
# Steps of the splitting between two looks at how fast the body turns, and the factor by which that may change before
# they take another length: within it they stay alike, as a symplectic method wants them. A free body's pace stays.
_STEPS_BETWEEN_LOOKS, _STEPS_OF_FREE = 4096, 2**17
_CHANGE_OF_PACE = 1.25
ADAPTIVE_BETWEEN_LOOKS = 2**8  # at errors of the attitude, which are put right
# Steps after which a call ends, so that the run looks at the clock and at what signals ask for: about a second.
STEPS_AT_ONCE = 2**14
MOST_STEPS = 10**12
_HIGHEST = max(splitting.COMPOSITIONS)
_SIZES_LOOKED_AT = 65  # between now and the next output, for the smallest
FIRST_STEP = 0.05  # of the adaptive integrator, over one radian of the fastest turn
_MISALIGNED = 0.1  # up to which errors of the adaptive integrator in |m| and the direction of L are put right

# What ends a call before its last output time: the part that met with it is not in the state, but for UNFINISHED.
NOTHING, NOT_FINITE, TOO_FAST, STUCK, UNFINISHED, WITHIN = range(6)  # and from WITHIN on the number of a companion


class Course(NamedTuple):
    """The rotor, the time, the pace that its steps are for, their length, and their number since the start."""

    state: Rotor
    time: Array
    pace: Array
    timestep: Array
    steps: Array


class Met(NamedTuple):
    """States at output times: number leading; momentum (3,) is L in inertial axes, sums (B,) and orbits the rotor's."""

    time: Array
    steps: Array
    timestep: Array
    turning: Array
    momentum: Array
    sums: Array
    orbits: Array | None


class Passage(NamedTuple):
    """Where a call ended: the course, the states at the `number` output times that were met, and what ended it.

    figure: the time that the part reached which met with trouble, or at which a companion is within the body; where it
    was TOO_FAST, the steps that were needed.
    since: steps since the last output time, or since the call began.
    """

    course: Course
    met: Met
    number: Array
    trouble: Array
    figure: Array
    since: Array


def state_met(course: Course) -> Met:
    """What is recorded of the present state."""
    state = course.state
    return Met(course.time, course.steps, course.timestep, state.turning.value, state.angular_momentum.value,
               state.sums.total, None if state.orbits is None else state.orbits.total)  # fmt: skip


@partial(brief, static_argnames=("integrator", "order"))
def passage(
    body: Rigid, units: tuple, course: Course, times: Array, count: Array, most: Array, tolerance: float,
    steps_per_rotation: float, integrator: str, order: int,
) -> Passage:  # fmt: skip
    """Go through the first `count` of the output times (AT_ONCE,), ascending, none of which is now.

    It ends where the steps since the start are `most`, of which one at least is to come, or when a call has taken long
    enough. units: those of errors, of L, m (3,), energy and orbits, for the adaptive integrator. Torques are without
    breaks.
    """
    empty = jax.tree.map(lambda one: jnp.zeros((AT_ONCE, *jnp.shape(one)), jnp.asarray(one).dtype), state_met(course))
    begun, allowed = course.steps, jnp.minimum(STEPS_AT_ONCE, most - course.steps)

    def under_way(carry: Passage) -> Array:
        goes = (carry.trouble == NOTHING) | (carry.trouble == UNFINISHED)
        return (carry.number < count) & goes & (carry.course.steps - begun < allowed)

    def part(carry: Passage) -> Passage:
        until, before = times[carry.number], carry.course
        if integrator == "splitting":
            after, trouble, figure = _split(body, before, until, steps_per_rotation, order, most - before.steps)
        else:
            after, trouble, figure = _adapted(body, units, before, until, tolerance, most - before.steps)
        broken = (trouble == NOTHING) & ~jnp.isfinite(after.state.turning.value).all()
        trouble = jnp.where(broken, NOT_FINITE, trouble)
        goes = (trouble == NOTHING) | (trouble == UNFINISHED)
        course = jax.tree.map(lambda new, old: jnp.where(goes, new, old), after, before)
        arrived = goes & (course.time >= until)
        met = jax.tree.map(
            lambda rows, row: rows.at[carry.number].set(jnp.where(arrived, row, rows[carry.number])),
            carry.met, state_met(course),
        )  # fmt: skip
        since = jnp.where(arrived, 0, carry.since + course.steps - before.steps)
        return Passage(course, met, carry.number + arrived, trouble, figure, since)

    zero = jnp.zeros((), int)
    return jax.lax.while_loop(under_way, part, Passage(course, empty, zero, zero, jnp.zeros(()), zero))


@jax.jit
def planned(body: Rigid, course: Course, until: Array, steps_per_rotation: float) -> tuple[Array, Array]:
    """The pace that steps of the splitting to a time are for, and how many it takes, not rounded."""
    pace = present_pace(body, course, until)
    alike = (pace / _CHANGE_OF_PACE <= course.pace) & (course.pace <= pace * _CHANGE_OF_PACE)
    kept = jnp.where(alike, course.pace, pace)
    return kept, (until - course.time) * kept * steps_per_rotation / (2.0 * math.pi)


def whole(steps: Array) -> Array:
    """A number of steps, rounded up: as an integer."""
    return jnp.maximum(1, jnp.ceil(steps * (1.0 - 1e-9))).astype(int)


def present_pace(body: Rigid, course: Course, until: Array) -> Array:
    """The largest angular frequency from now until a time, as the body is now but for its size."""
    state, pair = course.state, 0.0
    if state.orbits is not None:
        mass, orbits = body.companions.mass, state.orbits.value
        pair = two_way.fastest_pair(mass, orbits)
        body = rigid.accompanied(body, two_way.at_pericentres(body.mass, mass, orbits))
    pace = jnp.maximum(rigid.pace(body, course.time, state.turning.value), pair)
    if body.change is None:
        return pace
    shares = np.linspace(0.0, 1.0, _SIZES_LOOKED_AT)
    sizes = body.change.factor(course.time + (until - course.time) * shares)
    return pace * sizes[0] / jnp.min(sizes)


def _split(
    body: Rigid, course: Course, until: Array, steps_per_rotation: float, order: int, most: Array
) -> tuple[Course, Array, Array]:  # fmt: skip
    """Steps up to the next look, or to the time, or so many."""
    free = not body.effects and body.deformability is None and course.state.orbits is None
    pace, wanted = planned(body, course, until, steps_per_rotation)
    possible = wanted < MOST_STEPS  # not so of NaN
    steps = whole(jnp.where(possible, wanted, 1.0))
    at_once = _STEPS_OF_FREE if free and body.change is None else _STEPS_BETWEEN_LOOKS
    more = jnp.minimum(steps, jnp.minimum(at_once, most))
    stop = jnp.where(more == steps, until, course.time + (until - course.time) * (more / steps))
    flow, within, state, known = None, None, course.state, None
    if course.state.orbits is not None:
        if body.companions.substeps is not None:
            orbits, step = course.state.orbits.value, (stop - course.time) / more
            substeps = whole(two_way.substeps(body.mass, body.companions.mass, orbits, step))
            body = replace(body, companions=replace(body.companions, substeps=substeps))
        # A stage of order 8 needs points to order 2: what it is composed of raises the order of all.
        flow, within = two_way.flow if order == _HIGHEST else two_way.fine_flow, two_way.within
        state = replace(state, entered=jnp.full(body.companions.mass.shape, jnp.inf))
    elif body.companions is not None:
        known = rigid.known_orbits
    state = splitting.advance(
        state, body.rates, course.time, stop, more, order, body,
        None if free else rigid.kick, None if body.change is None else rigid.size, flow, within, known,
    )  # fmt: skip
    after = Course(replace(state, entered=None), stop, pace, (stop - course.time) / more, course.steps + more)
    trouble, figure = jnp.where(possible, NOTHING, TOO_FAST), jnp.where(possible, stop, wanted)
    if within is None:
        return after, trouble, figure
    met = possible & jnp.isfinite(jnp.min(state.entered))
    return (
        after, jnp.where(met, WITHIN + jnp.argmin(state.entered), trouble),
        jnp.where(met, jnp.min(state.entered), figure),
    )  # fmt: skip


def _adapted(
    body: Rigid, units: tuple, course: Course, until: Array, tolerance: float, most: Array
) -> tuple[Course, Array, Array]:  # fmt: skip
    """As many steps as there are between two looks, or to the time, or so many."""
    momentum_unit, body_unit, energy_unit, orbit_unit = units
    turning, sums = course.state.turning.value, course.state.sums.value
    scaled = {
        "turning": jnp.concatenate([turning[:4], turning[4:] / body_unit]),
        "momentum": course.state.angular_momentum.value / momentum_unit,
        "accumulated": sums / energy_unit,
    }
    orbits = course.state.orbits
    if orbits is not None:
        scaled["orbits"] = orbits.total / orbit_unit
    left = until - course.time
    first = jax.lax.cond(
        course.timestep > 0.0,
        lambda: course.timestep,
        lambda: FIRST_STEP / jnp.maximum(present_pace(body, course, until), FIRST_STEP / left),
    )
    advanced = adaptive.advance(
        rigid.rate, (body, *units), scaled, course.time, until, jnp.minimum(left, first), tolerance, tolerance,
        None if orbits is None else rigid.entered,
        jnp.minimum(ADAPTIVE_BETWEEN_LOOKS, most),
    )  # fmt: skip
    turning, momentum, sums = (advanced.state[name] for name in ("turning", "momentum", "accumulated"))
    if orbits is not None:
        orbits = filled(orbit_unit * advanced.state["orbits"])
    turning = jnp.concatenate([turning[:4] / jnp.linalg.norm(turning[:4]), body_unit * turning[4:]])
    state = Rotor(*map(filled, (turning, momentum_unit * momentum, energy_unit * sums)))
    length = jnp.linalg.norm(state.momentum_in_body)
    right = jnp.linalg.norm(state.angular_momentum.value) / jnp.where(length > 0.0, length, 1.0)
    right = jnp.where(jnp.abs(right - 1.0) < _MISALIGNED, right, 1.0)
    state = Rotor(filled(state.turning.value.at[4:].multiply(right)), state.angular_momentum, state.sums)
    for _ in range(3):  # from a tenth to round-off: the error left is the square of what it was
        state = splitting.put_right(state, _MISALIGNED)
        state = Rotor(filled(state.turning.total), state.angular_momentum, state.sums, orbits)
    time = jnp.where(advanced.unfinished, advanced.time, until)
    nearest = 0 if orbits is None else jnp.argmin(jnp.sum(orbits.value[0] ** 2, axis=-1))
    after = Course(state, time, course.pace, advanced.timestep, course.steps + advanced.steps)
    trouble = jnp.where(advanced.unfinished, UNFINISHED, jnp.where(advanced.failed, STUCK, NOTHING))
    trouble = jnp.where(advanced.stopped, WITHIN + nearest, trouble)
    return after, trouble, advanced.time


def filled(value: Array) -> Compensated:
    """A sum without rounding errors."""
    return Compensated(value, jnp.zeros_like(value))
