"""What block time steps of several intervals cost, and how many of them pay: plain numbers, as plans need them too.

Tests: tests/unit/models/sph/test_intervals.py, tests/unit/costs/test_costs.py.
"""

from typing import Any

import numpy as np

Array = Any
FAR = 0.3  # what a sum over a nested set costs, beside all that one evaluation has to do
CHANGED = 1.5  # how often nested sets are summed over for an interval, as some of their members change rungs
BASE = 0.5  # what a base step costs beside its evaluation: sorting, agreeing on limits, and opening by itself
END = 0.05  # what an end of an interval costs, however few are active: all particles drift
PAYS = 1.45  # how many times cheaper several rungs must be than one: they take more time than evaluations, and err more


def that_pay(counts: Array) -> int:
    """How many rungs below the longest interval cost least; 0 where several hardly cost less than one.

    counts: of particles by the power of two that their limit is above the shortest. The pressures of a pair of two
    intervals act over the longer one, and those that they balance do not: so short steps for half of a star save a
    third of the evaluations, and shift its balance by 0.2 % of its radius.
    """
    costs = [cost(counts, finest) for finest in range(len(counts))]
    best = int(np.argmin(costs))
    return best if costs[0] >= PAYS * costs[best] else 0


def cost(counts: Array, finest: int) -> float:
    """The cost of a unit of time with so many rungs below the base step, in evaluations of a particle.

    counts: of particles by the power of two that their limit is above the shortest. An evaluation is of sums over
    neighbours, one for each interval, and of sums over nested sets, each computed again where particles have changed
    sides.
    """
    by_rung = np.append(counts[:finest], counts[finest:].sum())[::-1]
    return of_base_step(by_rung) / 2.0**finest


def of_base_step(counts: Array) -> float:
    """The cost of a base step with so many particles in each rung, (K,), in evaluations of a particle."""
    within = np.cumsum(counts[::-1])[::-1].astype(float)  # those of this rung or a finer one
    total = (1.0 + FAR + BASE) * within[0]
    for k in range(1, len(counts)):
        apart = 1.0 if within[k] < within[k - 1] else 0.5  # half of its sums are those over the set around it
        total += (0.5 + apart * CHANGED * FAR) * 2.0**k * within[k]  # half of its ends are of longer ones, too
    return total + END * within[0] * 2.0 ** (len(counts) - 1)
