"""Block time steps by hierarchical splitting: intervals of base/2^k, who is kicked when, and by how much.

A particle of rung k has the interval base/2^k. A pair is kicked over the longer of its two intervals, both members at
once, at fixed positions that belong to one time: so every kick conserves momentum, and between kicks all particles
drift freely. The scheme is the HOLD of Pelupessy, Janes & Portegies Zwart (2012, New Astronomy 17, 711), carried over
to gas as in Springel, Pakmor, Zier & Reinecke (2021, MNRAS 506, 2871, section 4.3); neighbours' intervals differ by a
factor of two at most (Saitoh & Makino 2009, ApJ 697, L99). Tests: tests/unit/models/sph/test_intervals.py.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from astroinertia.errors import NumericalError
from astroinertia.models.sph.limits import FEW
from astroinertia.sph import rung_costs

Array = Any
DEEPEST = 40  # rungs below the base step: far more than SMALLEST_STEP of a run allows
NEIGHBOURS = 2.0  # how many times longer than its neighbour's the interval of a particle may be
MARGIN = 0.95  # of its limit is the most that an interval begins with: few rungs then change as limits shrink a little
POWERS = 2  # of the shortest limit, as the base step, are looked at where it may not be as long as it would be
FEWER = 0.4  # of a nested set: so few particles more do not make another one


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

    @cached_property
    def level(self) -> int:
        """The coarsest rung whose interval begins or ends now."""
        return 0 if self.ended or not self.ticks else DEEPEST - ((self.ticks & -self.ticks).bit_length() - 1)

    def middle(self, rung: int) -> float:
        """When, since the base step began, the middle is of the rung's interval that begins now or is under way."""
        width = 1 << (DEEPEST - rung)
        return self.base * ((self.ticks // width + 0.5) * width / (1 << DEEPEST))

    def after(self, rung: int) -> "Clock":
        """When the interval of the finest rung ends that began now."""
        return Clock(self.base, self.ticks + (1 << (DEEPEST - rung)))

    def last(self) -> "Clock":
        """With the longest interval that ends now as the base step, which is over: its rung is 0 from now on."""
        return Clock(self.base / 2.0**self.level, 1 << DEEPEST)


def base_step(limits: Array, remaining: float, beyond: int = 0, longest: float = np.inf) -> tuple[float, Array]:
    """The base step that costs least, a power of two times the shortest limit (N,) where it can be, and rungs (N,).

    All rungs are 0 where global steps cost less. Limits are taken less a margin where there are several rungs. A base
    step then is by `beyond` powers of two longer than the longest interval: what it takes to begin with one is paid
    less often. remaining: until a time that is to be met; longest: no base step is longer, but nothing has to be met
    then.
    """
    finest = rungs_that_pay(limits, beyond, min(remaining, longest))
    alike = min(remaining, longest, float(np.min(limits))), np.zeros(len(limits), np.int64)
    if not finest:
        return alike
    within = MARGIN * limits
    powers = float(np.min(within)) * 2.0 ** np.arange(finest + beyond + 1)
    wanted = min(float(powers[-1]), longest)
    lengths = [*in_equal_parts(remaining, wanted), *([wanted] if wanted < remaining else [])]
    lengths += list(powers[powers < min(wanted, remaining)][-POWERS:])

    def split(base: float) -> tuple[Array, float]:
        rung = merged(rungs(within, base), 0)
        return rung, rung_costs.of_base_step(np.bincount(rung))

    def cost(base: float) -> float:
        # Of a time: what remains after the last whole base step is one by itself.
        if remaining > FEW * wanted:
            return split(base)[1] / base
        whole = np.floor(remaining / base * (1.0 + 1e-12))
        rest = remaining - whole * base
        return (whole * split(base)[1] + (split(rest)[1] if rest > 1e-9 * base else 0.0)) / remaining

    costs = [cost(base) for base in lengths]
    if min(1.0, rung_costs.PAYS) * min(costs) > rung_costs.of_global_step(len(limits)) / np.min(limits):
        return alike
    base = lengths[int(np.argmin(costs))]
    return base, split(base)[0]


def rungs_that_pay(limits: Array, beyond: int, longest: float, agreed: bool = True) -> int:
    """How many rungs below the longest interval cost least with limits (N,); 0 where several hardly cost less.

    beyond: powers of two that a base step is longer than that interval; longest: no base step is longer;
    agreed: whether neighbours' limits agree.
    """
    most = int(np.clip(np.log2(longest / (MARGIN * np.min(limits))) + 1e-9, 0.0, DEEPEST))
    above = np.floor(np.log2(limits / np.min(limits)) + 1e-9).astype(np.int64)
    return rung_costs.that_pay(np.bincount(np.minimum(above, DEEPEST)), beyond, most, agreed)


def in_equal_parts(remaining: float, base: float) -> list[float]:
    """Equal parts of what little time remains, from the fewest that are no longer than the base step to three times so
    many: intervals come in powers of two of a part, and one may suit them that is shorter. None where much remains.
    """
    fewest = int(np.ceil(min(remaining / base, 2.0 * FEW) * (1.0 - 1e-12)))
    return [remaining / parts for parts in range(fewest, 3 * fewest + 1)] if fewest <= FEW else []


def rungs(limits: Array, base: float) -> Array:
    """The coarsest rung whose interval is within each limit, (N,) int64."""
    wanted = np.fmax(np.ceil(np.log2(base / limits) - 1e-9), 0.0)  # the run loop sees what is not a number
    if (wanted >= DEEPEST).any():
        raise NumericalError(f"a time step fell below 2^-{DEEPEST} of the longest")
    return wanted.astype(np.int64)


def merged(rung: Array, level: int) -> Array:
    """The rungs (n,), from `level` on, with those of few particles made finer.

    Where a nested set has hardly more particles than the next one, it is cheaper to evaluate these more often than to
    sum over both.
    """
    counts = np.bincount(rung, minlength=level + 1)
    finer = np.arange(len(counts))
    for k in range(level, len(counts) - 1):
        if 0 < counts[k] < FEWER * counts[k + 1 :].sum():
            finer[finer == k] = k + 1
            counts[k + 1] += counts[k]
    return finer[rung]


def sets(rung: Array, level: int) -> list[Array]:
    """The nested sets of particles that a kick at `level` splits pairs by: indices of those of rung >= level, + 1, ...

    rung (n,). The sum over pairs in set k less that over pairs in set k + 1 is that over pairs of interval base/2^k.
    """
    deepest = int(rung.max(initial=-1))
    return [np.flatnonzero(rung >= k) for k in range(level, deepest + 1)]


def weighted_sets(base: float, rung: Array, level: int) -> list[tuple[Array, list[int], float]]:
    """The distinct ones of the nested sets, their rungs, and what sums over them are multiplied by for half a kick.

    sum_k dt_k/2 (S_k - S_k+1) = dt_l/2 S_l - sum_(k > l) dt_k/2 S_k, as dt_(k-1) = 2 dt_k. Of sets within each other
    those of the same size are the same.
    """
    weighted: list[tuple[Array, list[int], float]] = []
    for k, members in enumerate(sets(rung, level), start=level):
        weight = (0.5 if k == level else -0.5) * base / 2.0**k
        if weighted and len(weighted[-1][0]) == len(members):
            same, rungs_of, total = weighted.pop()
            weighted.append((same, [*rungs_of, k], total + weight))
        else:
            weighted.append((members, [k], weight))
    return weighted
