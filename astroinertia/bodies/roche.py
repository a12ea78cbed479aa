"""Roche ellipsoids: homogeneous, synchronous with a companion that acts as a point mass, tide to second degree.

With mu = G M'/d^3, p = M/M' (the mass of the body over that of its companion), Omega^2 = (1 + p) mu, and a = 1,

    ((3 + p) + c^2) mu = 2 (1 - c^2) B_13,    (p b^2 + c^2) mu = 2 (b^2 - c^2) B_23        (mu in units of pi G rho)

Eliminating mu and using b^2 B_23 and B_13 in terms of A_12 and A_3 leaves a sum without cancellation for any p,

    (3 + c^2)(b^2 - c^2) B_23 - c^2 (1 - c^2) B_13 + p (1 - b^2)(b^2 A_12 - c^2 A_3) = 0,

in which p -> infinity shows Maclaurin's (b = 1) and Jacobi's sequence. p = -1 is Jeans's spheroid in a tide without
rotation (b = c), p = 0 a satellite of negligible mass. In between p = Omega^2/mu - 1 is no ratio of masses: that of a
body that turns less fast than on its orbit beside a companion that is held in place, so that mu alone is known. The
figures are labelled by c/a, which falls from 1 along each sequence; the Roche limit is where mu is largest.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 8. Tests: tests/unit/bodies/test_roche.py,
tests/hard/test_ellipsoids_hard.py.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from astroinertia.bodies import jacobi, maclaurin
from astroinertia.bodies.ellipsoid_gravity import index_integral
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_COMPLEX_STEP = 1e-40  # exact derivatives: nothing is subtracted
_THINNEST = 1e-6  # c/a of the needles up to which figures are looked for
_WIDEST_ODDS = 90.0  # ln((b^2 - c^2)/(a^2 - b^2)) in which a figure is looked for
_FARTHEST = 500.0  # -ln(a/c - 1) up to which a figure is looked for at a given distance
_LIMIT_BRACKET = (0.4, 0.583)  # c/a at the limit: 0.4693 for p = -1 to 0.5827, the bifurcation, for p = infinity


@dataclass(frozen=True)
class RocheEllipsoid(HomogeneousEllipsoid):
    """A Roche ellipsoid: a points at the companion; `mass_ratio` is p = M/M', `tide` is (G M'/d^3)/(pi G rho)."""

    mass_ratio: float = 0.0
    tide: float = 0.0

    @property
    def scaled_distance(self) -> float:
        """(d/R_mean) (M/M')^(1/3) = (4/(3 tide))^(1/3), finite for a body of negligible mass; inf without a tide."""
        return math.inf if self.tide == 0 else (4 / (3 * self.tide)) ** (1 / 3)

    @property
    def distance(self) -> float:
        """Distance d of the companion; inf for p = 0, nan for p < 0, where only the ratio M'/d^3 has a meaning."""
        if self.mass_ratio <= 0:
            return math.inf if self.mass_ratio == 0 else math.nan
        return self.scaled_distance * self.mean_radius / math.cbrt(self.mass_ratio)


def _terms(y, z, p: float, above, below):
    """The equation of the sequence over 1 + |p|, and (1 + |p|) mu, for b^2 = y = z + above = 1 - below and c^2 = z."""
    squares = (1.0, y, z)
    b_13, b_23 = index_integral(squares, (0, 2), 1), index_integral(squares, (1, 2), 1)
    jacobian = below * (y * index_integral(squares, (0, 1), 0) - z * index_integral(squares, (2,), 0))
    share = p / (1 + abs(p))
    equation = ((3 + z) * above * b_23 - z * (above + below) * b_13) / (1 + abs(p)) + share * jacobian
    return equation, 2 * (above + below) * b_13 / ((3 + z) / (1 + abs(p)) + share)


def _middle_square(z: float, deficit: float, p: float) -> tuple[float, float, float]:
    """b^2, b^2 - c^2 and 1 - b^2 of the figure with c^2 = z = 1 - deficit, each to round-off next to any spheroid."""
    if p == -1:
        return z, 0.0, deficit

    def split(odds: float) -> tuple[float, float, float]:
        above, below = deficit / (1 + math.exp(-odds)), deficit / (1 + math.exp(odds))
        return z + above, above, below

    def equation(odds: float) -> float:
        y, above, below = split(odds)
        return float(_terms(y, z, p, above, below)[0])

    return split(root_between(equation, -_WIDEST_ODDS, _WIDEST_ODDS))


def _checked_ratio(mass_ratio: float) -> float:
    if not mass_ratio >= -1:
        raise ValueError(
            "the mass ratio M/M' of a Roche ellipsoid is at least 0, or from -1 (no rotation) to 0 for one that turns "
            f"less fast than on its orbit, not {mass_ratio}"
        )
    return float(mass_ratio)


@with_quantities()
def from_axis_ratio(mass_ratio: float, c_over_a: float, **scale: float) -> RocheEllipsoid:
    """Return the ellipsoid of given p = M/M' >= 0 (or -1 <= p < 0: less rotation than synchronous) and c/a, 1e-6 to 1.

    p = infinity gives Maclaurin spheroids and then Jacobi ellipsoids; `scale`: mass, mean_radius,
    gravitational_constant. ValueError outside. Source: Chandrasekhar 1969, ch. 8. Test:
    tests/unit/bodies/test_roche.py.

    >>> print(from_axis_ratio(0.0, 0.6).axes.round(4))  # the longest towards the companion
    [1.3786 0.8769 0.8272]
    """
    p, c = _checked_ratio(mass_ratio), float(c_over_a)
    if not (_THINNEST <= c <= 1):
        raise ValueError(f"c/a of a Roche ellipsoid lies in {_THINNEST:g} <= c/a <= 1, not {c_over_a}")
    if c == 1:
        return RocheEllipsoid(1.0, 1.0, 0.0, mass_ratio=p).rescaled(**scale)
    if p == math.inf:
        body = _without_companion(c)
        return RocheEllipsoid(body.b_over_a, c, body.omega2, mass_ratio=p).rescaled(**scale)
    return _figure(p, c, 1 - c).rescaled(**scale)


def _figure(p: float, c: float, flattening: float) -> RocheEllipsoid:
    z = c * c
    y, above, below = _middle_square(z, flattening * (1 + c), p)
    tide = float(_terms(y, z, p, above, below)[1]) / (1 + abs(p))
    return RocheEllipsoid(math.sqrt(y), c, (1 + p) * tide, mass_ratio=p, tide=tide)


def _without_companion(c: float) -> HomogeneousEllipsoid:
    """The Maclaurin spheroid, or beyond the bifurcation the Jacobi ellipsoid, of given c/a."""
    if c >= maclaurin.bifurcation().c_over_a:
        return maclaurin.from_axis_ratio(c)
    log_b = root_between(lambda log_b: math.log(jacobi.from_axis_ratio(math.exp(log_b)).c_over_a / c), math.log(c), 0.0)
    return jacobi.from_axis_ratio(math.exp(log_b))


@with_quantities()
def limit(mass_ratio: float, **scale: float) -> RocheEllipsoid:
    """Return the ellipsoid of the Roche limit of p = M/M' >= 0 (or -1 <= p < 0): the closest to its companion.

    p = 0: scaled_distance 2.455176; p = -1: 2.1985, Jeans's spheroid (no rotation); p = infinity: the bifurcation to
    the Jacobi ellipsoids. ValueError for p < -1. Source: Chandrasekhar 1969, ch. 8. Test:
    tests/unit/bodies/test_roche.py.

    >>> print(f"{limit(0.0).scaled_distance:.4f}")  # of a satellite of no mass: 2.4552 R_mean (companion/M)^(1/3)
    2.4552
    """
    return _limit(_checked_ratio(mass_ratio)).rescaled(**scale)


@lru_cache(maxsize=256)
def _limit(p: float) -> RocheEllipsoid:
    if p == math.inf:
        return from_axis_ratio(p, maclaurin.bifurcation().c_over_a)

    def slope(c: float) -> float:
        """Sign of d mu/d(c^2) along the curve on which the equation holds."""
        z = c * c
        y, above, below = _middle_square(z, 1 - z, p)
        by_y, by_z = (
            [term.imag / _COMPLEX_STEP for term in _terms(y + dy, z + dz, p, above + dy - dz, below - dy)]
            for dy, dz in ((1j * _COMPLEX_STEP, 0), (0, 1j * _COMPLEX_STEP))
        )
        return by_z[1] * by_y[0] - by_y[1] * by_z[0]

    return from_axis_ratio(p, root_between(slope, *_LIMIT_BRACKET))


@with_quantities()
def at_distance(
    mass_ratio: float, scaled_distance: float, branch: Literal["stable", "unstable"] = "stable", **scale: float
) -> RocheEllipsoid:
    """Return the ellipsoid of p = M/M' at the scaled distance (d/R_mean) (M/M')^(1/3).

    The stable one is less deformed than the one at the limit, the unstable one more. ValueError inside the Roche limit.
    Source: Chandrasekhar 1969, ch. 8. Test: tests/unit/bodies/test_roche.py.

    >>> print(at_distance(0.0, 4.0).axes.round(4))
    [1.0503 0.9848 0.9668]
    """
    closest = limit(mass_ratio)
    if branch not in ("stable", "unstable"):
        raise ValueError(f"the branches of Roche ellipsoids are stable and unstable, not {branch!r}")
    if mass_ratio == math.inf or not (closest.scaled_distance <= scaled_distance < math.inf):
        raise ValueError(
            f"scaled distances of Roche ellipsoids of finite mass ratio are finite and at least "
            f"{closest.scaled_distance:.9g}, the Roche limit, not {scaled_distance}"
        )
    target = 4 / (3 * scaled_distance**3)

    def at(log_odds: float) -> RocheEllipsoid:
        return _figure(float(mass_ratio), 1 / (1 + math.exp(log_odds)), 1 / (1 + math.exp(-log_odds)))

    def excess(log_odds: float) -> float:
        return math.log(at(log_odds).tide / target)

    middle = math.log(1 / closest.c_over_a - 1)
    far = -_FARTHEST if branch == "stable" else math.log(1 / _THINNEST - 1)
    if excess(middle) <= 0:
        return closest.rescaled(**scale)
    if excess(far) > 0:
        raise ValueError(f"a Roche ellipsoid at scaled distance {scaled_distance} is too close to a sphere or a needle")
    return at(root_between(excess, *sorted((far, middle)))).rescaled(**scale)
