"""Jacobi ellipsoids: homogeneous, rigidly rotating, with three axes, from the bifurcation (b = a) to needles (b -> 0).

    a^2 b^2 A_12 = c^2 A_3,    Omega^2/(pi G rho) = 2 B_12

Both symbols are sums of positive terms, so that b = a is reached exactly: there the sequence joins the Maclaurin one.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, section 39, eqs 4 and 5.
Tests: tests/unit/bodies/test_ellipsoids.py, tests/hard/test_ellipsoids_hard.py.
"""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from astroinertia.bodies.ellipsoid_gravity import index_integral, index_symbols
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_LOG_THINNEST = math.log(1e-12)  # ln(b/a) of the needle up to which figures are looked for


@with_quantities()
def from_axis_ratio(b_over_a: float, **scale: float) -> HomogeneousEllipsoid:
    """Return the ellipsoid of given b/a, 0 < b/a <= 1; `scale`: mass, mean_radius, gravitational_constant.

    ValueError outside, and below 1e-12. Source: Chandrasekhar 1969, ch. 6. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_axis_ratio(0.5).polar_moment:.6f}")  # in M R_mean^2
    0.752075
    """
    if np.ndim(b_over_a):
        raise ValueError("a Jacobi ellipsoid has one b/a, not an array of them")
    if not (math.exp(_LOG_THINNEST) * (1 - 1e-9) <= b_over_a <= 1):
        raise ValueError(f"a Jacobi ellipsoid has 0 < b/a <= 1 (from 1e-12 on here), not {b_over_a}")
    return _unit(float(b_over_a)).rescaled(**scale)


@lru_cache(maxsize=4096)
def _unit(b: float) -> HomogeneousEllipsoid:
    def difference(log_c: float) -> float:
        c = math.exp(log_c)
        ratio = index_integral((1.0, b * b, c * c), (0, 1), 0) * (b / c) ** 2 / index_symbols([1.0, b, c])[2]
        return math.log(float(ratio))

    # c falls short of b by a share of about b^2 ln(1/b), which round-off hides in the thinnest needles
    round_needle = difference(math.log(b)) >= 0 and b < 1e-6
    c = b if round_needle else math.exp(root_between(difference, math.log(b) - 1.0, math.log(b)))
    return HomogeneousEllipsoid(b, c, float(2 * index_integral((1.0, b * b, c * c), (0, 1), 1)))


@lru_cache(maxsize=1)
def pear_bifurcation() -> HomogeneousEllipsoid:
    """Return the ellipsoid where the pear-shaped figures branch off, b/a = 0.432232: none is stable beyond.

    There the third harmonic x (x^2/(a^2 + s) + y^2/(b^2 + s) + z^2/(c^2 + s) - 1), 3/(a^2 + s) + 1/(b^2 + s) +
    1/(c^2 + s) = 0, is neutral: a^2 s^2 abc integral du/(Delta (a^2 + u)(u - s)^2) = c^2 A_3, just as xy is at the
    bifurcation from the Maclaurin sequence.
    Source: Poincare 1885, Acta Math. 7, 259; Chandrasekhar 1969, section 40, with the numbers.
    Test: tests/hard/test_ellipsoids_hard.py.

    >>> print(f"{pear_bifurcation().axes[1] / pear_bifurcation().axes[0]:.6f}")
    0.432232
    """

    def difference(b: float) -> float:
        y, z = b * b, _unit(b).c_over_a ** 2
        # the root between -1 and -b^2 of 3 (y + s)(z + s) + (1 + s)(y + z + 2 s) = 0
        linear, constant = 4 * (y + z) + 2, 3 * y * z + y + z
        shift = (linear + math.sqrt(linear**2 - 20 * constant)) / 10
        third = shift**2 * index_integral((1.0, y, z, shift), (0, 3, 3), 0)
        return float(third - z * index_integral((1.0, y, z), (2,), 0))

    return _unit(root_between(difference, 0.3, 0.6))


@with_quantities()
def from_angular_velocity(angular_velocity: float, **scale: float) -> HomogeneousEllipsoid:
    """Return the ellipsoid of given Omega (in the units of `scale`), 0 < Omega^2 <= 0.374230 pi G rho.

    ValueError outside.     Source: Chandrasekhar 1969, ch. 6. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(from_angular_velocity(0.5).axes.round(4))  # in R_mean
    [1.5914 0.9277 0.6774]
    """
    body = _unit(1.0).rescaled(**scale)
    target = angular_velocity / math.sqrt(math.pi * body.gravitational_constant * body.density)
    return _with("Omega/sqrt(pi G rho)", lambda body: math.sqrt(body.omega2), target, scale)


@with_quantities()
def from_angular_momentum(angular_momentum: float, **scale: float) -> HomogeneousEllipsoid:
    """Return the ellipsoid of given L >= 0.303751 sqrt(G M^3 R_mean) (in the units of `scale`); ValueError below.

    Source: Chandrasekhar 1969, ch. 6. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_angular_momentum(0.35).angular_momentum:.6f}")
    0.350000
    """
    body = _unit(1.0).rescaled(**scale)
    target = angular_momentum / math.sqrt(body.gravitational_constant * body.mass**3 * body.mean_radius)
    return _with("L/sqrt(G M^3 R)", lambda body: body.angular_momentum, target, scale)


@with_quantities()
def from_energy_ratio(rotational_to_gravitational: float, **scale: float) -> HomogeneousEllipsoid:
    """Return the ellipsoid of given T/|W|, from 0.137528 to below 1/2; ValueError outside.

    Source: Chandrasekhar 1969, ch. 6. Test: tests/unit/bodies/test_ellipsoids.py.

    >>> print(f"{from_energy_ratio(0.16).rotational_to_gravitational:.6f}")
    0.160000
    """
    return _with("T/|W|", lambda body: body.rotational_to_gravitational, rotational_to_gravitational, scale)


def _with(name: str, quantity: Callable[[HomogeneousEllipsoid], float], target: float, scale) -> HomogeneousEllipsoid:
    """The ellipsoid with quantity = target, which changes in one sense along the sequence."""

    def excess(log_b: float) -> float:
        return quantity(_unit(math.exp(log_b))) - target

    start, end = excess(0.0), excess(_LOG_THINNEST)
    if abs(start) <= 4e-16 * target:
        return _unit(1.0).rescaled(**scale)
    if not start * end < 0:
        first, last = sorted((quantity(_unit(1.0)), quantity(_unit(math.exp(_LOG_THINNEST)))))
        raise ValueError(f"Jacobi ellipsoids have {name} from {first:.9g} to {last:.9g}, not {target}")
    return _unit(math.exp(root_between(excess, _LOG_THINNEST, 0.0))).rescaled(**scale)
