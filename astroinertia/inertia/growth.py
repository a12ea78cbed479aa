"""How fast a mode grows and turns: straight lines through the logarithm of an amplitude and through a phase.

Tests: tests/unit/dataset/test_waves.py.
"""

from typing import NamedTuple

import numpy as np

from astroinertia.process.quantities import with_quantities


class Line(NamedTuple):
    """A straight line by least squares: slope and its standard error, value at time 0, and rms of what is left.

    >>> print(Line(slope=0.7, error=0.01, intercept=0.0, residual=0.02).slope)
    0.7
    """

    slope: float
    error: float
    intercept: float
    residual: float


@with_quantities()
def line(time, values) -> Line:
    """Return the line through values (T,) at times (T,), those that are finite; ValueError for fewer than three.

    >>> print(f"{line(np.arange(5.0), 3.0 * np.arange(5.0) + 1.0).slope:.6f}")
    3.000000
    """
    t, y = np.asarray(time, float), np.asarray(values, float)
    fine = np.isfinite(t) & np.isfinite(y)
    t, y = t[fine], y[fine]
    if len(t) < 3 or np.ptp(t) == 0.0:
        raise ValueError(f"a line needs at least three known values at different times, not {len(t)}")
    middle = t.mean()
    spread = ((t - middle) ** 2).sum()
    slope = ((t - middle) * (y - y.mean())).sum() / spread
    left = y - y.mean() - slope * (t - middle)
    error = np.sqrt((left**2).sum() / max(len(t) - 2, 1) / spread)
    return Line(float(slope), float(error), float(y.mean() - slope * middle), float(np.sqrt((left**2).mean())))


@with_quantities()
def growth(time, amplitude) -> Line:
    """Return the line through ln A: its slope is the growth rate of A ~ exp(slope t). Zero amplitudes are left out.

    >>> print(f"{growth(np.arange(5.0), 2.0 * np.exp(0.7 * np.arange(5.0))).slope:.6f}")  # A ~ exp(0.7 t)
    0.700000
    """
    size = np.asarray(amplitude, float)
    if (known := np.count_nonzero(size > 0.0)) < 3:
        raise ValueError(f"growth as exp(rate t) needs at least three values above 0, not {known}")
    return line(time, np.log(size, out=np.full(size.shape, np.nan), where=size > 0.0))


@with_quantities()
def turning(time, phase, fold: int) -> Line:
    """Return the line through the angle of a pattern of `fold`-fold symmetry: its slope is the pattern speed.

    phase (T,): that of the mode, fold times the angle, known to 2 pi, or NaN; ValueError where two neighbours may be
    more than half a turn apart, for then the times are too sparse to count turns.

    >>> print(f"{turning(np.arange(5.0), (0.3 * np.arange(5.0)) % np.pi, 2).slope:.6f}")  # a bar
    0.150000
    """
    t, angle = np.asarray(time, float), np.asarray(phase, float)
    known = np.isfinite(angle)
    total = np.unwrap(angle[known])
    if (np.abs(np.diff(total)) > 0.9 * np.pi).any():
        raise ValueError("the phase advances by nearly half a turn from one time to the next: record more often")
    return line(t[known], total / fold)
