"""What a ladder of runs says of its own errors: pure functions of arrays.

values (n, K) are an observable at steps (n,), whatever its error goes as a power of.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from astroinertia.accuracy import convergence

_ROUND_OFF = 1e-15
_SCATTER = 0.3  # standard deviation of an order that a few runs tell


class Estimate(NamedTuple):
    """The relative error at the finest step of a ladder, and the order by which it falls."""

    error: float
    order: float

    def at(self, ratio: float) -> float:
        """The error where the step is `ratio` times the finest one."""
        return self.error * ratio**self.order

    def ratio_for(self, error: float) -> float:
        """By what factor of the finest step an error is reached."""
        return math.inf if self.error <= 0.0 else (error / self.error) ** (1.0 / self.order)


UNKNOWN = Estimate(math.nan, math.nan)


def estimate(
    steps: Sequence[float], values: np.ndarray, order: float, orders: tuple[float, float], trust: float = math.inf
) -> Estimate:
    """The error of the value at the finest step, relative to its size.

    order: what theory says, taken where the ladder tells none; trust: its standard deviation from case to case, by
    which it is weighed against the ladder's own; orders: the least and the largest that are believed. Two values tell
    no order: theory's less its deviation counts, or half of it. Each coarser value gives an estimate by Richardson's
    rule; the largest one counts, for two may agree by chance while three or four do not. UNKNOWN with fewer than two
    values. Source: Richardson 1911 (see convergence).

    >>> steps = np.array([0.4, 0.2, 0.1])
    >>> judged = estimate(steps, 1 + steps[:, None] ** 2, order=2.0, orders=(1.0, 4.0))
    >>> print(f"{judged.error:.4f} {judged.order:.2f}")  # 0.01/1.01
    0.0099 2.00
    """
    r, v = np.asarray(steps, float), np.atleast_2d(np.asarray(values, float))
    finest = int(np.argmin(r))
    size = float(np.linalg.norm(v[finest]))
    if len(r) < 2 or not size > 0.0 or not np.isfinite(v).all():
        return UNKNOWN
    law = convergence.self_convergence(r, v, size, _ROUND_OFF)
    least, most = orders
    p = order if len(r) > 2 else max(order - trust, 0.5 * order)
    if law.credible:
        own = max(law.uncertainty, _SCATTER) if math.isfinite(law.uncertainty) else _SCATTER
        share = 1.0 / (1.0 + (own / trust) ** 2)
        p = share * law.order + (1.0 - share) * order
    p = min(max(p, least), most)
    coarser = np.arange(len(r)) != finest
    apart = np.linalg.norm(v[coarser] - v[finest], axis=1) / size
    errors = apart / ((r[coarser] / r[finest]) ** p - 1.0)
    return Estimate(float(errors.max()), p)


def worst(estimates: Sequence[Estimate]) -> Estimate:
    """The least certain of several observables: the largest error, the lowest order.

    >>> print(worst([Estimate(1e-3, 2.0), Estimate(1e-5, 1.0)]))
    Estimate(error=0.001, order=1.0)
    """
    if any(math.isnan(estimate.error) for estimate in estimates):
        return UNKNOWN
    return Estimate(max(estimate.error for estimate in estimates), min(estimate.order for estimate in estimates))
