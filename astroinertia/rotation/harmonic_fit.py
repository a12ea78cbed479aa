"""A long record taken apart into a rate, a slow change of it and periodic terms of known frequencies."""

from typing import Any, NamedTuple

import numpy as np

from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities

Array = Any

_WORST_CONDITION = 1e8  # of the normalised columns; beyond, terms cannot be separated in so short a record


class HarmonicFit(NamedTuple):
    """value(t) = offset + rate t + acceleration t^2/2 + sum of sine_j sin(f_j t + p_j) + cosine_j cos(f_j t + p_j).

    sine and cosine: (J,), in the units of the values; residual: root mean square of what is left.
    """

    offset: float
    rate: float
    acceleration: float
    sine: np.ndarray
    cosine: np.ndarray
    residual: float

    @with_quantities()
    def steady(self, times: Array) -> np.ndarray:
        """The values at times (...,) without the periodic terms."""
        t = np.asarray(times, dtype=float)
        return self.offset + t * (self.rate + 0.5 * self.acceleration * t)


@with_quantities(frequencies="rad/s")
def harmonic_fit(times: Array, values: Array, frequencies: Array = (), phases: Array | None = None) -> HarmonicFit:
    """Least squares of values (N,) at times (N,) by terms of frequencies f (J,), in radians a time, and phases p
    (J,), 0 unless given.

    The rate is that at time 0: put 0 in the middle. ValueError for fewer values than numbers to find, and for numbers
    that are not finite; NumericalError where the record is too short to tell terms apart.

    >>> t = np.linspace(-10.0, 10.0, 201)
    >>> fit = harmonic_fit(t, 0.5 * t + 2.0 * np.sin(3.0 * t), np.array([3.0]))
    >>> print(f"{fit.rate:.6f} {fit.sine[0]:.6f}")
    0.500000 2.000000
    """
    t, y, f = (np.asarray(series, dtype=float) for series in (times, values, frequencies))
    p = np.zeros_like(f) if phases is None else np.asarray(phases, dtype=float)
    if t.shape != y.shape or t.ndim != 1 or f.shape != p.shape or len(t) < 3 + 2 * len(f):
        raise ValueError("a fit needs a value for each time, a phase for each frequency, and more values than terms")
    if not all(np.isfinite(series).all() for series in (t, y, f, p)):
        raise ValueError("the times, values, frequencies and phases of a fit must be finite")
    unit = np.abs(t).max() or 1.0
    turning = np.multiply.outer(t, f) + p
    columns = np.concatenate(
        [np.stack([np.ones_like(t), t / unit, (t / unit) ** 2], 1), np.sin(turning), np.cos(turning)], 1
    )
    fitted, _, _, spread = np.linalg.lstsq(columns, y, rcond=None)
    if spread[-1] * _WORST_CONDITION < spread[0]:
        raise NumericalError("the record is too short to tell its terms apart")
    left = y - columns @ fitted
    terms = len(f)
    return HarmonicFit(
        float(fitted[0]), float(fitted[1] / unit), float(2 * fitted[2] / unit**2), fitted[3 : 3 + terms],
        fitted[3 + terms :], float(np.sqrt(np.mean(left**2))),
    )  # fmt: skip
