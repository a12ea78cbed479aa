"""Which settings are worth their cost: the Pareto front of error against cost, and its knee.

Pure functions of arrays (n,), smaller being better in both; NaN counts as not measured.
"""

import numpy as np


def pareto(cost: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Whether no other setting is cheaper and at least as exact, or as cheap and more exact, (n,) of truth values.

    >>> print(pareto([1.0, 2.0, 3.0], [0.1, 0.2, 0.01]))  # the second costs more and errs more
    [ True False  True]
    """
    cost, error = np.asarray(cost, float), np.asarray(error, float)
    good = np.isfinite(cost) & np.isfinite(error)
    best, on_front = np.inf, np.zeros(len(cost), dtype=bool)
    for number in np.lexsort((error, cost)):
        if good[number] and error[number] < best:
            best, on_front[number] = error[number], True
    return on_front


def knee(cost: np.ndarray, error: np.ndarray) -> int | None:
    """Number of the setting of the front that is farthest below the line between its ends, in logarithms scaled to 1.

    None where the front has less than three settings, or none below that line. Source: Satopaa et al. 2011, Proc. 31st
    ICDCS Workshops, 166 (the knee of a curve).

    >>> print(knee([1.0, 2.0, 100.0], [1.0, 1e-3, 1e-4]))
    1
    """
    cost, error = np.asarray(cost, float), np.asarray(error, float)
    front = np.flatnonzero(pareto(cost, error) & (error > 0) & (cost > 0))
    if len(front) < 3:
        return None
    front = front[np.argsort(cost[front])]
    x, y = np.log(cost[front]), np.log(error[front])
    x, y = (x - x[0]) / (x[-1] - x[0]), (y - y[-1]) / (y[0] - y[-1])
    below = 1.0 - x - y
    best = int(np.argmax(below))
    return int(front[best]) if below[best] > 0 else None
