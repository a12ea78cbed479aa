"""Roots of functions of one variable between two ends, to round-off: of one function, or of many at once."""

from collections.abc import Callable

import numpy as np

_TOLERANCE = np.float64(1e-15)  # scipy allows no less than four times round-off


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of `function` between `low` and `high` to 1e-15, absolute and relative (Brent's method).

    ValueError unless the function has different signs there. Source: Brent 1973, Algorithms for Minimization without
    Derivatives, ch. 4. Test: tests/unit/bodies/test_ellipsoids.py (every figure found from a quantity).
    """
    from scipy.optimize import brentq  # only here: who opens a file need not wait for it

    return float(brentq(function, low, high, xtol=_TOLERANCE, rtol=_TOLERANCE))  # pyright: ignore[reportArgumentType]


def bisected(below: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray, steps: int) -> np.ndarray:
    """Return where `below`, true at `low` and false at `high`, changes, by halving the interval of each so often."""
    for _ in range(steps):
        middle = 0.5 * (low + high)
        beneath = below(middle)
        low, high = np.where(beneath, middle, low), np.where(beneath, high, middle)
    return 0.5 * (low + high)
