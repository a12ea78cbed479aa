"""How particles are sorted into leaves for the sums over pairs."""

from typing import Any

import numpy as np

from astroinertia.engines.elementwise import elementwise
from astroinertia.engines.pytree import mapped
from astroinertia.models.sph.kick_drift import moved, predicted
from astroinertia.models.sph.points import with_others, without_others
from astroinertia.models.sph.state import Arrangement, Problem, State

Array = Any
# Particles are sorted again, and checkpoints may be taken, every so many steps and after each that was of several
# intervals: a resumed run then sorts where the uninterrupted one did, and both compute the same bits.
STEPS_BETWEEN_SORTS = 16


def rearranged(
    problem: Problem, state: State, dt: Array | None = None, length: Array | None = None
) -> tuple[State, Any]:
    """The state with its particles sorted again into leaves, and the arrangement, made for the coming evaluation.

    dt: the length of the coming step; as long as is allowed unless given. length: other smoothing lengths than those
    that particles have, (N,), to list neighbours with.
    """
    length = state.smoothing_length if length is None else length
    order, pairs = problem.engine.arrange(coming_position(problem, state, dt), length)
    state = in_order(state, order)
    return state, arranged(problem, pairs, state)


def in_order(state: State, order: Array) -> State:
    """The state, or its derivative, with its particles in another order (N,)."""
    count = state.mass.shape[0]

    def sort(array: Array) -> Array:
        return array.take(order, axis=0) if getattr(array, "ndim", 0) and array.shape[0] == count else array

    particles, others = without_others(state)
    return with_others(mapped(sort, particles), others)


def places_of(identity: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Where each of those identities (N,) stands among the same ones in another order (N,)."""
    order = np.argsort(among)
    return order[np.searchsorted(among, identity, sorter=order)]


def arranged(problem: Problem, pairs: Any, state: State) -> Arrangement:
    """The arrangement of particles that the engine has sorted already."""
    made = {effect.kind: effect.arranged(problem.engine, pairs, state) for effect in problem.effects}
    return Arrangement(pairs, {kind: own for kind, own in made.items() if own is not None})


def stale(problem: Problem, arrangement: Arrangement, state: State, dt: Array | None = None) -> bool:
    """Whether sorting particles again pays, before a step of the length dt."""
    return problem.engine.stale(arrangement.pairs, coming_position(problem, state, dt), state.smoothing_length)


def coming_position(problem: Problem, state: State, dt: Array | None) -> Array:
    """Where particles will be when a step evaluates the forces, (N, 3); dt: None for the step allowed."""
    if state.rates.fluid is None:
        return state.position
    xp, step = problem.engine.xp, state.rates.timestep if dt is None else dt
    velocity, _ = predicted(xp, state, step / 2)
    return elementwise(xp, moved, state.position, state.remainder, velocity, step)[0]
