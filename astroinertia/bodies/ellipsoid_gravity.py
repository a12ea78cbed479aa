"""Gravity of homogeneous ellipsoids: index symbols, potential, energy and its tensor, without cancellation.

    A_i = abc integral du/(Delta (a_i^2 + u)),    Delta^2 = product over i of (a_i^2 + u),    u from 0 to infinity
    A_ij = abc integral du/(Delta (a_i^2 + u)(a_j^2 + u)),    B_ij = abc integral u du/(Delta (a_i^2 + u)(a_j^2 + u))

A_i and the potential are Carlson's integrals. The pair symbols, which A_i - A_j = -(a_i^2 - a_j^2) A_ij would lose for
nearly equal axes, are sums over ln u, where the trapezoidal rule converges geometrically for any axes.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 3; Carlson 1995, Numer. Algorithms 10, 13;
Trefethen & Weideman 2014, SIAM Rev. 56, 385 (the trapezoidal rule). Tests: tests/unit/bodies/test_ellipsoids.py.
"""

import math

import numpy as np
from scipy.special import elliprd, elliprf

from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import require_components

_LOG_STEP = 0.375  # of ln u: the error of the sum is about 100 exp(-2 pi pi/step) = 1e-21
_LOG_TAIL = 38.0  # ln u below the smallest squared axis at which exp(ln u) is beneath round-off


@with_quantities(axes="m")
def index_symbols(axes) -> np.ndarray:
    """Return A_1, A_2, A_3 of the semi-axes (..., 3): dimensionless, of sum 2, to 1e-15.

    Source: Chandrasekhar 1969, ch. 3; Carlson 1995.

    >>> print(index_symbols(np.array([1.0, 1.0, 1.0])).round(6))  # of a sphere
    [0.666667 0.666667 0.666667]
    """
    scaled = _checked(axes) / np.max(axes, axis=-1, keepdims=True)
    return _shifted_symbols(scaled, scaled**2)


@with_quantities(squares="m2")
def index_integral(squares, indices: tuple[int, ...], power: int):
    """Return abc times the integral of u^power du/(Delta product over `indices` of (a_i^2 + u)).

    indices (0, 1) with power 0 give A_12, with power 1 B_12. squares: a^2, b^2, c^2, and after them any other shifts
    that `indices` may name; complex values near the positive axis give derivatives. Relative error 3e-16 for any axes.
    Source: Chandrasekhar 1969, section 21.

    >>> print(f"{index_integral(np.ones(3), (0,), 0):.6f}")  # A_1 of a sphere
    0.666667
    """
    sizes = [abs(square) for square in squares]
    first = math.floor((math.log(min(sizes)) - _LOG_TAIL) / _LOG_STEP)
    last = math.ceil((math.log(max(sizes)) + _LOG_TAIL) / _LOG_STEP)
    u = np.exp(_LOG_STEP * np.arange(first, last + 1))
    terms = u * np.ones_like(u, dtype=np.result_type(*[np.asarray(square) for square in squares], float))
    for square in squares[:3]:
        terms = terms * np.sqrt(square / (square + u))
    for index in indices:
        terms = terms / (squares[index] + u)
    return _LOG_STEP * (terms * u**power).sum()


@with_quantities(axes="m")
def potential(axes, points, density: float = 1.0, gravitational_constant: float = 1.0) -> np.ndarray:
    """Return the potential (negative) of the homogeneous ellipsoid at points (..., 3), inside and outside.

    Source: Chandrasekhar 1969, ch. 3 (Ferrers).

    >>> print(f"{potential(np.ones(3), np.array([2.0, 0.0, 0.0])) / (4 / 3 * np.pi):.6f}")  # -M/r outside a sphere
    -0.500000
    """
    axes, points = _checked(axes), np.asarray(points, dtype=float)
    require_components(points=points)
    squares = axes**2 + _confocal(axes, points)[..., None]
    whole = 2 * np.prod(axes) * elliprf(*np.moveaxis(squares, -1, 0))
    symbols = _shifted_symbols(axes, squares)
    return -math.pi * gravitational_constant * density * (whole - (symbols * points**2).sum(-1))


@with_quantities(axes="m")
def acceleration(axes, points, density: float = 1.0, gravitational_constant: float = 1.0) -> np.ndarray:
    """Return the gravity (..., 3) of the homogeneous ellipsoid at points (..., 3), inside and outside.

    Source: Chandrasekhar 1969, ch. 3.

    >>> print((acceleration(np.ones(3), np.array([2.0, 0.0, 0.0])) / (4 / 3 * np.pi))[0].round(6))  # -M/r^2
    -0.25
    """
    axes, points = _checked(axes), np.asarray(points, dtype=float)
    require_components(points=points)
    squares = axes**2 + _confocal(axes, points)[..., None]
    return -2 * math.pi * gravitational_constant * density * _shifted_symbols(axes, squares) * points


@with_quantities(axes="m")
def gravitational_energy(axes, mass: float = 1.0, gravitational_constant: float = 1.0) -> float:
    """Return W = -(3/5) G M^2 R_F(a^2, b^2, c^2) of the homogeneous ellipsoid.

    Source: Chandrasekhar 1969, section 22.

    >>> print(f"{gravitational_energy(np.ones(3)):.6f}")  # -3/5 of a sphere
    -0.600000
    """
    axes = _checked(axes)
    scale = axes.max()  # Carlson's integrals are homogeneous
    return -0.6 * gravitational_constant * mass**2 * float(elliprf(*(axes / scale) ** 2)) / scale


@with_quantities(axes="m")
def potential_energy_tensor(axes, mass: float = 1.0, gravitational_constant: float = 1.0) -> np.ndarray:
    """Return the diagonal of Chandrasekhar's potential-energy tensor (3,), of sum W.

    Source: Chandrasekhar 1969, section 22.

    >>> print(potential_energy_tensor(np.ones(3)).round(6))
    [-0.2 -0.2 -0.2]
    """
    axes = _checked(axes)
    scale = axes.max()
    shape = axes / scale
    factor = -0.3 * gravitational_constant * mass**2 / (np.prod(shape) * scale)
    return factor * index_symbols(shape) * shape**2


def _checked(axes) -> np.ndarray:
    axes = np.asarray(axes, dtype=float)
    if axes.shape[-1:] != (3,) or not (np.isfinite(axes).all() and (axes > 0).all()):
        raise ValueError(f"an ellipsoid needs three positive, finite semi-axes, not {axes.tolist()!r}")
    return axes


def _shifted_symbols(axes, squares) -> np.ndarray:
    """A_i at a confocal surface, whose squared axes are `squares`."""
    columns, volume = np.moveaxis(squares, -1, 0), np.prod(axes, axis=-1)
    return np.stack([2 / 3 * volume * elliprd(*np.delete(columns, i, 0), columns[i]) for i in range(3)], axis=-1)


def _confocal(axes, points) -> np.ndarray:
    """The largest root lambda of sum x_i^2/(a_i^2 + lambda) = 1 for points outside; zero inside.

    Newton's method from below: the sum is convex and falls, so it never overshoots.
    """
    outside = (points**2 / axes**2).sum(-1) > 1
    # a lower bound that is exact for a sphere: the largest of x_i^2 - a_i^2 and r^2 - a_max^2
    r2 = (points**2).sum(-1)
    root = np.maximum(np.max(points**2 - axes**2, axis=-1), r2 - np.max(axes) ** 2)
    root = np.where(outside, np.maximum(root, 0.0), 0.0)
    for _ in range(100):
        terms = points**2 / (axes**2 + root[..., None])
        total = terms.sum(-1)
        step = np.where(outside, (total - 1) / np.maximum((terms / (axes**2 + root[..., None])).sum(-1), 1e-300), 0.0)
        root = root + step
        if np.all(np.abs(step) <= 4e-16 * (root + np.min(axes) ** 2)):
            break
    return root
