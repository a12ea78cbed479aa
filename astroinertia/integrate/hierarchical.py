"""Block time steps by hierarchical splitting: intervals of base/2^k, who is kicked when, and by how much.

A particle of rung k has the interval base/2^k. A pair is kicked over the longer of its two intervals, both members at
once, at fixed positions that belong to one time: so every kick conserves momentum, and between kicks all particles
drift freely. The scheme is the HOLD of Pelupessy, Janes & Portegies Zwart (2012, New Astronomy 17, 711), carried over
to gas as in Springel, Pakmor, Zier & Reinecke (2021, MNRAS 506, 2871, section 4.3); neighbours' intervals differ by a
factor of two at most (Saitoh & Makino 2009, ApJ 697, L99). Tests: tests/unit/test_hierarchical.py.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

Array = Any
DEEPEST = 40  # rungs below the base step: far more than SMALLEST_STEP of a run allows
NEIGHBOURS = 2.0  # how many times longer than its neighbour's the interval of a particle may be
FEW = 4  # base steps to a given time that are made equally long


@dataclass(frozen=True)
class Clock:
    """Where within a base step the integration is, exactly: `ticks` of base/2^DEEPEST."""

    base: float
    ticks: int = 0

    @property
    def elapsed(self) -> float:
        """Time since the base step began."""
        return self.base * (self.ticks / (1 << DEEPEST))

    @property
    def ended(self) -> bool:
        """Whether the base step is over."""
        return self.ticks == 1 << DEEPEST

    @property
    def level(self) -> int:
        """The coarsest rung whose interval ends now."""
        return 0 if self.ended else DEEPEST - ((self.ticks & -self.ticks).bit_length() - 1)

    def middle(self, rung: int) -> float:
        """When, since the base step began, the middle is of the rung's interval that begins now or is under way."""
        width = 1 << (DEEPEST - rung)
        return self.base * ((self.ticks // width + 0.5) * width / (1 << DEEPEST))

    def after(self, rung: int) -> "Clock":
        """When the interval of the finest rung ends that began now."""
        return Clock(self.base, self.ticks + (1 << (DEEPEST - rung)))


def base_step(limits: Array, remaining: float) -> float:
    """The longest interval: the shortest limit (N,) times a power of two, within the longest limit.

    The last few base steps before a given time, which is `remaining` ahead, are equally long.
    """
    shortest, longest = float(np.min(limits)), float(np.max(limits))
    parts = np.ceil(remaining / longest * (1.0 - 1e-12))
    if parts <= FEW:
        return remaining / parts
    return shortest * 2.0 ** np.floor(np.log2(longest / shortest))


def rungs(limits: Array, base: float) -> Array:
    """The coarsest rung whose interval is within each limit, (N,) int64."""
    with np.errstate(divide="ignore"):
        wanted = np.ceil(np.log2(base / limits) - 1e-9)
    return np.clip(np.nan_to_num(wanted, nan=DEEPEST), 0, DEEPEST).astype(np.int64)


def sets(rung: Array, level: int) -> list[Array]:
    """The nested sets of particles that a kick at `level` splits pairs by: indices of those of rung >= level, + 1, ...

    rung (n,). The sum over pairs in set k less that over pairs in set k + 1 is that over pairs of interval base/2^k.
    """
    deepest = int(rung.max(initial=-1))
    return [np.flatnonzero(rung >= k) for k in range(level, deepest + 1)]


def weights(base: float, level: int, count: int) -> list[float]:
    """What the sums over the nested sets of `level` are multiplied by for half a kick, finest last.

    sum_k dt_k/2 (S_k - S_k+1) = dt_l/2 S_l - sum_(k > l) dt_k/2 S_k, as dt_(k-1) = 2 dt_k.
    """
    halves = [0.5 * base / 2.0**k for k in range(level, level + count)]
    return halves[:1] + [-half for half in halves[1:]]


def histogram(rung: Array) -> Array:
    """How many particles each rung has, from 0 on."""
    return np.bincount(rung)


def ideal_speed_up(evaluations: float, particles: int, shortest_steps: float) -> float:
    """N 2^k / sum 2^(k_i): what global steps would evaluate over what was evaluated."""
    return particles * shortest_steps / max(evaluations, 1.0)
