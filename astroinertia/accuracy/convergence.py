"""Orders of convergence from a few errors, and what they extrapolate to: pure functions of arrays.

Steps r (n,) are whatever an error goes as a power of: a time step, a tolerance, N^(-1/3).
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

_FLATTEST = 0.3  # order below which nothing converges
_STEEPEST = 12.0  # of the orders that are tried
_LEAST_CHANGE = 1.4  # of the steps, from the finest to the coarsest, from which an order is known: 3 in particles


class PowerLaw(NamedTuple):
    """error = factor r^order; uncertainty is the standard error of the order, NaN where two points fix it.

    points is the number of those that were fitted.
    """

    order: float
    uncertainty: float
    factor: float
    points: int

    @property
    def credible(self) -> bool:
        """Whether there is an order, and it is no child of scatter: positive, and known to half of itself."""
        return self.points > 0 and self.order > _FLATTEST and not self.uncertainty > 0.5 * self.order

    def at(self, step: float) -> float:
        """The error at a step."""
        return self.factor * step**self.order


NONE = PowerLaw(np.nan, np.nan, np.nan, 0)
"""Where no order can be determined."""


def power_law(steps: np.ndarray, errors: np.ndarray, floor: float = 0.0) -> PowerLaw:
    """A power law through errors (n,) at steps (n,), by least squares of logarithms; errors up to `floor` are left out.

    >>> steps = np.array([0.4, 0.2, 0.1])
    >>> print(f"{power_law(steps, 3 * steps**2).order:.6f} {power_law(steps, 3 * steps**2).factor:.6f}")
    2.000000 3.000000
    """
    r, e = np.asarray(steps, float), np.asarray(errors, float)
    good = np.isfinite(r) & np.isfinite(e) & (r > 0) & (e > max(floor, 0.0))
    r, e = r[good], e[good]
    if len(r) < 2 or r.max() < _LEAST_CHANGE * r.min():
        return NONE
    x, y = np.log(r), np.log(e)
    order, start = np.polyfit(x, y, 1)
    spread = _standard_error(x, y - (order * x + start), x - x.mean())
    return PowerLaw(float(order), spread, float(np.exp(start)), len(r))


def converging(steps: np.ndarray, errors: np.ndarray, order: float) -> np.ndarray:
    """Which errors (n,), from the coarsest on, still fall at half of `order` or more: until something else takes over.

    >>> print(converging([4.0, 2.0, 1.0, 0.5], [1.6e-3, 4e-4, 1e-4, 9e-5], order=2.0))  # a floor at the end
    [ True  True  True False]
    """
    r, e = np.asarray(steps, float), np.asarray(errors, float)
    ranked = [number for number in np.argsort(-r) if np.isfinite(e[number]) and e[number] > 0 and r[number] > 0]
    kept = np.zeros(len(r), dtype=bool)
    for place, number in enumerate(ranked):
        if place:
            before = ranked[place - 1]
            if e[number] > e[before] * (r[number] / r[before]) ** (0.5 * order):
                break
        kept[number] = True
    return kept


def self_convergence(steps: np.ndarray, values: np.ndarray, size: float, floor: float = 0.0) -> PowerLaw:
    """The power law of the error in a knob that nothing but its own refinement shows.

    values (n, K) are the observable at steps (n,); their differences from the one at the finest step are
    factor |r^order - r_finest^order| size where the error is factor r^order size, so that whatever else errs drops out.
    Differences at most `floor` (over size) are left out.

    >>> steps = np.array([0.4, 0.2, 0.1])
    >>> print(f"{self_convergence(steps, 1 + steps[:, None] ** 4, size=1.0).order:.3f}")  # the limit is not given
    4.000
    """
    r, v = np.asarray(steps, float), np.asarray(values, float)
    good = np.isfinite(r) & (r > 0) & np.isfinite(v).all(axis=1)
    if good.sum() < 3 or not size > 0:
        return NONE
    r, v = r[good], v[good]
    finest = int(np.argmin(r))
    differences = np.linalg.norm(v - v[finest], axis=1) / size
    keep = (np.arange(len(r)) != finest) & (differences > floor)
    r_finest, r, d = r[finest], r[keep], differences[keep]
    if len(r) < 2 or r.max() < _LEAST_CHANGE * r.min():
        return NONE
    y = np.log(d)

    def shape(order: float) -> np.ndarray:
        return np.log(r**order - r_finest**order)

    def misfit(order: float) -> float:
        left = y - shape(order)
        return float(np.sum((left - left.mean()) ** 2))

    minimum: Any = minimize_scalar(misfit, bounds=(0.05, _STEEPEST), method="bounded", options={"xatol": 1e-6})
    order = float(minimum.x)
    left = y - shape(order)
    slope = (shape(order * 1.001) - shape(order * 0.999)) / (0.002 * order)
    spread = _standard_error(slope, left - left.mean(), slope - slope.mean())
    return PowerLaw(order, spread, float(np.exp(left.mean())), len(r))


def extrapolated(steps: np.ndarray, values: np.ndarray, order: float) -> np.ndarray | None:
    """Richardson's extrapolation (K,) to step 0 of values (n, K) at steps (n,), by the two finest; None if not trusted.

    It is trusted where the three finest change by ratios that are those of `order` within a factor of two.
    Source: Richardson 1911, Phil. Trans. R. Soc. A 210, 307.

    >>> steps = np.array([0.4, 0.2, 0.1])
    >>> print(f"{extrapolated(steps, 1 + steps[:, None] ** 2, order=2.0)[0]:.9f}")
    1.000000000
    """
    r, v = np.asarray(steps, float), np.asarray(values, float)
    good = np.isfinite(r) & (r > 0) & np.isfinite(v).all(axis=1)
    ranked = np.flatnonzero(good)[np.argsort(r[good])]
    if len(ranked) < 3:
        return None
    (a, b, c), (fine, middle, coarse) = r[ranked[:3]], v[ranked[:3]]
    wanted = (c**order - b**order) / (b**order - a**order)
    size = float(np.linalg.norm(middle - fine))
    ratio = float((coarse - middle) @ (middle - fine)) / size**2 if size > 0 else np.inf
    if not 0.5 < ratio / wanted < 2.0:
        return None
    return fine + (fine - middle) * a**order / (b**order - a**order)


def _standard_error(x: np.ndarray, residual: np.ndarray, spread: np.ndarray) -> float:
    free = len(x) - 2
    return float(np.sqrt(np.sum(residual**2) / free / np.sum(spread**2))) if free > 0 else float("nan")
