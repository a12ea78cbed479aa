"""A size that is prescribed in time: the factor of an inertia tensor, as a smooth positive curve."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.inertia.tensor import namespace
from astroinertia.process.quantities import with_quantities

Array = Any


@pytree
@dataclass(frozen=True, eq=False)
class Change:
    """Factor of an inertia tensor over that at time 0: 1 until then, constant after the last of `times` (n,).

    Between them the logarithm is a cubic in time, with the slopes of Fritsch & Butland (1984, SIAM Journal on
    Scientific and Statistical Computing 5, 300), none at the two ends: the curve and its rate are continuous, and it
    never overshoots. A JAX pytree; times begin with 0. Checked by tests/unit/inertia/test_prescribed.py.
    """

    times: Array
    logarithms: Array
    slopes: Array

    @with_quantities()
    def factor(self, time: Array) -> Array:
        """The factor (...,) at times (...,)."""
        xp = namespace(time, self.times)
        times, values, slopes = (xp.asarray(array) for array in (self.times, self.logarithms, self.slopes))
        time = xp.clip(xp.asarray(time), times[0], times[-1])
        piece = xp.clip(xp.searchsorted(times, time, side="right") - 1, 0, len(self.times) - 2)
        length = times[piece + 1] - times[piece]
        share = (time - times[piece]) / length
        rest = 1.0 - share
        # Hermite's form: it keeps the digits of the values at both ends.
        value = rest * rest * ((1.0 + 2.0 * share) * values[piece] + share * length * slopes[piece])
        value = value + share * share * ((1.0 + 2.0 * rest) * values[piece + 1] - rest * length * slopes[piece + 1])
        return xp.exp(value)

    @with_quantities()
    def derivatives(self, time: float) -> tuple[float, float, float]:
        """The factor at one time with its first and second derivative; the second jumps at the given times."""
        times, values, slopes = (np.asarray(array) for array in (self.times, self.logarithms, self.slopes))
        if not times[0] < time < times[-1]:
            return float(np.exp(values[0 if time <= times[0] else -1])), 0.0, 0.0
        piece = int(np.searchsorted(times, time, side="right")) - 1
        length = times[piece + 1] - times[piece]
        share, fall = (time - times[piece]) / length, values[piece] - values[piece + 1]
        left, right = length * slopes[piece], length * slopes[piece + 1]
        first = 6.0 * share * (share - 1.0) * fall + (3.0 * share - 1.0) * (share - 1.0) * left
        first = (first + share * (3.0 * share - 2.0) * right) / length
        second = 6.0 * (2.0 * share - 1.0) * fall + (6.0 * share - 4.0) * left + (6.0 * share - 2.0) * right
        factor = float(self.factor(time))
        return factor, float(factor * first), float(factor * (second / length**2 + first**2))


@with_quantities()
def change(times: Array, factors: Array) -> Change:
    """The curve through factors (n,) at times (n,), rising, after factor 1 at time 0; any unit of time.

    ValueError where times do not rise from 0, or where a factor is not positive.
    """
    times, factors = np.atleast_1d(np.asarray(times, dtype=float)), np.atleast_1d(np.asarray(factors, dtype=float))
    if times.ndim != 1 or times.shape != factors.shape:
        raise ValueError("a change of size needs as many factors as times")
    if times[0] != 0.0:
        times, factors = np.concatenate([[0.0], times]), np.concatenate([[1.0], factors])
    if len(times) < 2 or factors[0] != 1.0 or not (np.diff(times) > 0).all():
        raise ValueError("a change of size needs times that rise, from a factor of 1 at time 0")
    if not (np.isfinite(times).all() and np.isfinite(factors).all() and (factors > 0).all()):
        raise ValueError("a change of size needs finite times and positive factors")
    values, length = np.log(factors), np.diff(times)
    secant = np.diff(values) / length
    slopes = np.zeros_like(values)
    left, right = secant[:-1], secant[1:]
    together = left * right > 0.0
    share = (length[:-1] + 2.0 * length[1:]) / (3.0 * (length[:-1] + length[1:]))
    mean = share * right + (1.0 - share) * left
    slopes[1:-1] = np.where(together, left * right / np.where(together, mean, 1.0), 0.0)
    return Change(times, values, slopes)
