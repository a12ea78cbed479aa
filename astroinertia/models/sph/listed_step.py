"""A step whose lists of neighbours hold to its end, for an engine that makes them ahead of it.

Smoothing lengths may grow by more than the lists have room for, a single one among a million, and then every sum over
neighbours goes through all tiles. So a step in which that happens is taken again with longer lists. Tested by
tests/unit/models/sph/test_sorting.py.
"""

from dataclasses import replace
from typing import Any

from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem, State
from astroinertia.models.sph.step import step

Array = Any
LONGER = 1.25  # what a length that has outgrown its list is taken to be, in terms of what the list held
ATTEMPTS = 8  # after which the sums through all tiles are taken


def listed_step(problem: Problem, arrangement: Any, state: State, dt: Array) -> tuple[State, Any]:
    """The state after one step of length dt, and the arrangement of its particles, sorted again if need be."""
    engine = problem.engine
    for _ in range(ATTEMPTS):
        after = step(problem, replace(arrangement, pairs=engine.held(arrangement.pairs)), state, dt)
        outgrown = engine.outgrown(arrangement.pairs, after.smoothing_length)
        if not outgrown.any():
            return after, arrangement
        length = after.smoothing_length * engine.xp.where(outgrown, LONGER, 1.0)
        state, arrangement = rearranged(problem, state, dt, length)
    return step(problem, arrangement, state, dt), arrangement
