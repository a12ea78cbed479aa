"""What block time steps of several intervals cost, and how many of them pay: plain numbers, as plans need them too.

Tests: tests/unit/models/sph/test_intervals.py, tests/unit/costs/test_costs.py.
"""

from typing import Any

import numpy as np

Array = Any
FAR = 0.3  # what a sum over a nested set costs, beside all that one evaluation has to do
CHANGED = 1.5  # how often nested sets are summed over for an interval, as some of their members change rungs
BASE = 0.5  # what a base step costs beside its evaluation: sorting, agreeing on limits, and opening by itself
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
    particles = counts.sum()
    total = (1.0 + FAR + BASE) * particles
    for k in range(1, finest + 1):
        size = float(counts[: finest - k + 1].sum())  # of the nested set k
        total += (0.5 + CHANGED * FAR) * 2.0**k * size  # half of the ends of its intervals are of longer ones, too
    return total / 2.0**finest
