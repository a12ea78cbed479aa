"""Roots of functions of one variable between two ends, of one function, or of many at once."""

from collections.abc import Callable
from typing import Any

import numpy as np

_TOLERANCE = 1e-15  # scipy allows no less than four times round-off
_MOST_STEPS = 1000


def root_between(
    function: Callable[[float], float], low: float, high: float, absolute: float = _TOLERANCE,
    relative: float = _TOLERANCE,
) -> float:  # fmt: skip
    """Return the root of `function` between `low` and `high` to the sum of these errors (Brent's method).

    ValueError unless the function has different signs there. Source: Brent 1973, Algorithms for Minimization without
    Derivatives, ch. 4. Test: tests/unit/process/test_roots.py.
    """
    from scipy.optimize import brentq  # only here: who opens a file need not wait for it

    root: Any = brentq(function, low, high, xtol=absolute, rtol=np.float64(relative), maxiter=_MOST_STEPS)
    return float(root)


def bisected(below: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray, steps: int) -> np.ndarray:
    """Return where `below`, true at `low` and false at `high`, changes, by halving the interval of each so often."""
    for _ in range(steps):
        middle = 0.5 * (low + high)
        beneath = below(middle)
        low, high = np.where(beneath, middle, low), np.where(beneath, high, middle)
    return 0.5 * (low + high)
