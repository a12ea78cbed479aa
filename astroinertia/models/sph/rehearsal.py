"""A step of every kind that a run may come to, so that whatever it needs is compiled before.

Which kinds of steps a run takes depends on where it goes: individual ones are split only where that pays, plain sums
are for nested sets of few particles, and matter that flies at other matter is looked for only when it is fast. Test:
tests/unit/run/test_warm.py.
"""

from typing import Any

import numpy as np

from astroinertia.models.sph import limits
from astroinertia.models.sph.state import Arrangement, Problem, State
from astroinertia.models.sph.step import step

Array = Any
NESTED = 4  # times fewer particles in each nested set than in the one around it
FEWEST = 4  # particles in a set
DEEPER = 2  # rungs of the last one below the last but one: so much within it lets it be taken out of the body


def rehearse(state: State, arrangement: Arrangement, problem: Problem, base_step: Any) -> None:
    """A global step, with individual ones (base_step is block_step.step) a split one too, and limits by contact."""
    dt = state.rates.timestep
    if problem.engine.name != "xla" and problem.terms("neighbour_terms"):  # there, all steps are one program
        with np.errstate(invalid="ignore"):
            limits.contact(problem, state.rates.fluid, np.float64(np.inf))
    if base_step is None:
        return
    step(problem, arrangement, state, dt)
    base_step(problem, arrangement, state, float(state.time + dt), rung=nested(len(state.mass)))


def nested(count: int) -> Array:
    """Rungs of so many sorted particles, (N,), in sets of all sizes within each other, next to each other each."""
    rung, depth, inner = np.zeros(count, np.int64), 0, count // NESTED
    while inner >= FEWEST:
        depth += 1
        rung[:inner] = depth
        inner //= NESTED
    return np.where((rung == depth) & (rung > 0), depth + DEEPER, rung)
