"""What block time steps of several intervals cost, and how many of them pay: plain numbers, as plans need them too.

Tests: tests/unit/models/sph/test_intervals.py, tests/unit/costs/test_costs.py.
"""

from typing import Any

import numpy as np

Array = Any
FAR = 0.3  # what a sum over a nested set costs, beside all that one evaluation has to do
CHANGED = 1.5  # how often nested sets are summed over for an interval, as some of their members change rungs
BASE = 0.5  # what a base step costs beside its evaluation: sorting, agreeing on limits, and opening by itself
END = 0.03  # what a drift costs, of every particle that takes part in it however few are active at its end
PART = 0.125  # of the particles: those of the shortest intervals, if no more, drift by themselves between other ends
# What takes as long however few particles there are, in evaluations of one, of about 5 us: a global step, the beginning
# and the end of a base step, and an end of an interval within it (tests/benchmarks/results/individual_steps.md).
STEP, BEGUN, ENDED = 400.0, 1000.0, 450.0
BEYOND = 1  # powers of two that a base step is longer than the longest interval, where nothing acts with base steps
PAYS = 1.1  # how many times cheaper several rungs must be than global steps: limits change, and pairs err more
# How many times more they must be by limits of which neighbours' do not agree yet: of Evrard's 3000 particles, 1 of 38
# base steps was split that promised less. To make them agree takes a fifth of a global step.
AGREED = 1.2
# Global steps that a base step may cost. A run is saved and stopped between base steps; to begin with one takes a
# hundredth of so many.
LONGEST = 256.0


def that_pay(counts: Array, beyond: int, most: int, agreed: bool = True) -> int:
    """How many rungs below the longest interval cost least; 0 where several hardly cost less than global steps.

    counts: of particles by the power of two that their limit is above the shortest; beyond: powers of two that a base
    step is longer than the longest interval; most: of them from the shortest limit to the longest base step;
    agreed: whether neighbours' limits agree. The pressures of a pair of two intervals act over the longer one, and
    those that they balance do not: so short steps for half of a star save a third of the evaluations, and shift its
    balance by 0.2 % of its radius.
    """
    costs = [cost(counts, finest, min(beyond, most - finest)) for finest in range(1, min(len(counts), most + 1))]
    best = int(np.argmin(costs)) if costs else 0
    least = PAYS if agreed else PAYS * AGREED
    return best + 1 if costs and least * costs[best] <= of_global_step(counts.sum()) else 0


def of_global_step(particles: float) -> float:
    """The cost of a global step, in evaluations of a particle."""
    return STEP + particles


def cost(counts: Array, finest: int, beyond: int) -> float:
    """The cost of the shortest interval with so many rungs below the longest one, in evaluations of a particle.

    counts, beyond: as of that_pay. An evaluation is of sums over neighbours, one for each interval, and of sums over
    nested sets, each computed again where particles have changed sides. Infinite where a base step would take too long.
    """
    by_rung = np.append(counts[:finest], counts[finest:].sum())[::-1]
    whole = of_base_step(np.append(np.zeros(beyond), by_rung))
    return np.inf if whole > LONGEST * of_global_step(counts.sum()) else whole / 2.0 ** (finest + beyond)


def of_base_step(counts: Array) -> float:
    """The cost of a base step with so many particles in each rung, (K,), in evaluations of a particle."""
    within = np.cumsum(counts[::-1])[::-1].astype(float)  # those of this rung or a finer one
    total = BEGUN + (1.0 + FAR + BASE) * within[0]
    for k in range(1, len(counts)):
        apart = 1.0 if within[k] < within[k - 1] else 0.5  # half of its sums are those over the set around it
        total += (0.5 + apart * CHANGED * FAR) * 2.0**k * within[k]  # half of its ends are of longer ones, too
    few = min(np.count_nonzero(within > PART * within[0]), len(counts) - 1)
    outer, ends = 2.0**few, 2.0 ** (len(counts) - 1)
    return total + ENDED * ends + END * (outer * within[0] + (ends - outer) * within[few])
