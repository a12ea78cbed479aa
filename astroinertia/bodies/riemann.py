"""Riemann ellipsoids of type S: homogeneous, turning about a principal axis, with internal flow about the same axis.

The figure turns at Omega; in its own axes the fluid runs around similar ellipses, u = Lambda (-(a/b) y, (b/a) x, 0), so
that x(t) = R(Omega t) diag(a, b, c) R(Lambda t) X with R the rotation about c. With P = (a^2 b^2 A_12 - c^2 A_3)/(ab),

    Omega^2 + Lambda^2 = 2 B_12,    Omega Lambda = P,    (Omega +- Lambda)^2 = 2 (B_12 +- P)    (units of pi G rho).

The two rates may be exchanged: the adjoint figure has the same axes (Dedekind's theorem). The vorticity in the axes of
the figure is zeta = Lambda (a^2 + b^2)/(ab), and f = zeta/Omega tells sequences apart: f = 0 Jacobi's, infinity
Dedekind's, -2 irrotational ones. Ellipsoids exist between the two self-adjoint sequences, Omega = +-Lambda, of which
one begins at the Maclaurin spheroid that becomes dynamically unstable and the other at the sphere. a >= b, and c may be
anything up to a.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 7 (section 48); Lai, Rasio & Shapiro 1993, ApJS 88,
205 (the two rates). Tests: tests/unit/bodies/test_riemann.py, tests/hard/test_riemann_hard.py.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

from astroinertia.bodies import maclaurin
from astroinertia.bodies.ellipsoid_gravity import index_integral, index_symbols
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_THINNEST = 1e-8  # b/a and c/a of the needles up to which figures are looked for
_FLATTEST = 0.1  # (c/a)/(b/a), which is at least 0.303, from which on figures are looked for
_LOG_ROUNDEST = -30.0  # ln((a - b)/b) from which on figures of given invariants are looked for
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # rate of rotation about z
_ROUNDING = 1e-14  # of (Omega +- Lambda)^2, in pi G rho: below it the figure is self-adjoint


@dataclass(frozen=True)
class RiemannEllipsoid(HomogeneousEllipsoid):
    """An ellipsoid with semi-axes a >= b and c that turns about c, with internal motions; `b_over_a`, `c_over_a`.

    omega2: Omega^2/(pi G rho), Omega >= 0; internal_rate: Lambda/sqrt(pi G rho), negative where the fluid runs against
    the rotation of the figure.
    """

    internal_rate: float = 0.0

    @property
    def internal_angular_velocity(self) -> float:
        """Lambda, the rate at which fluid runs around in the axes of the figure."""
        return self.internal_rate * math.sqrt(math.pi * self.gravitational_constant * self.density)

    @property
    def internal_vorticity(self) -> float:
        """zeta, the vorticity in the axes of the figure."""
        return self.internal_angular_velocity * (self.b_over_a + 1 / self.b_over_a)

    @property
    def vorticity(self) -> float:
        """Of the motion in an inertial frame: 2 Omega + zeta."""
        return 2 * self.angular_velocity + self.internal_vorticity

    @property
    def vorticity_ratio(self) -> float:
        """f = zeta/Omega; infinite for a Dedekind ellipsoid."""
        return self.internal_vorticity / self.angular_velocity if self.omega2 else math.inf

    @property
    def circulation(self) -> float:
        """Along the equator: pi a b (2 Omega + zeta), kept by any motion without viscosity."""
        a, b = self.axes[:2]
        sums = 2 * a * b * self.angular_velocity + (a * a + b * b) * self.internal_angular_velocity
        return float(math.pi * sums)

    @property
    def angular_momentum(self) -> float:
        """L = (M/5) ((a^2 + b^2) Omega + 2 a b Lambda): that of the circulation with the two rates exchanged."""
        a, b = self.axes[:2]
        sums = (a * a + b * b) * self.angular_velocity + 2 * a * b * self.internal_angular_velocity
        return float(self.mass / 5 * sums)

    @property
    def kinetic_energy(self) -> float:
        """T of rotation and internal motion, in an inertial frame."""
        a, b = self.axes[:2]
        one, other = self.angular_velocity, self.internal_angular_velocity
        return float(self.mass / 10 * ((a * one + b * other) ** 2 + (b * one + a * other) ** 2))

    @property
    def total_energy(self) -> float:
        """T + W."""
        return self.kinetic_energy + self.gravitational_energy

    @property
    def central_pressure(self) -> float:
        """p_c = pi G rho^2 c^2 A_3."""
        symbol = float(index_symbols(self.axes)[2])
        return math.pi * self.gravitational_constant * (self.density * self.polar_radius) ** 2 * symbol

    @property
    def adjoint(self) -> Self:
        """The figure with the same axes whose rates Omega and Lambda are exchanged, turned about so that Omega >= 0."""
        internal = math.copysign(math.sqrt(self.omega2), self.internal_rate)
        return replace(self, omega2=self.internal_rate**2, internal_rate=internal)

    @with_quantities()
    def deformation(self, time: float = 0.0) -> np.ndarray:
        """F (3, 3) with x = F X for fluid at X in the sphere of the mean radius: R(Omega t) diag(axes) R(Lambda t)/R.

        Test: tests/unit/bodies/test_riemann.py.
        """
        turned = rotation_about_z(self.angular_velocity * time) @ np.diag(self.axes / self.mean_radius)
        return turned @ rotation_about_z(self.internal_angular_velocity * time)

    @with_quantities()
    def deformation_rate(self, time: float = 0.0) -> np.ndarray:
        """dF/dt (3, 3) at a time. Test: tests/unit/bodies/test_riemann.py."""
        deformation = self.deformation(time)
        turn = self.angular_velocity * TURN @ deformation
        return turn + deformation @ (self.internal_angular_velocity * TURN)


@with_quantities()
def rotation_about_z(angle: float) -> np.ndarray:
    """The matrix (3, 3) of a rotation by an angle (rad) about z.

    >>> print((rotation_about_z(math.pi / 2) @ [1.0, 0.0, 0.0]).round(12))  # x comes to y
    [0. 1. 0.]
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _symbols(b: float, c: float) -> tuple[float, float]:
    """B_12 and P of the axes 1, b, c."""
    squares = (1.0, b * b, c * c)
    polar = float(index_symbols([1.0, b, c])[2])
    product = b * float(index_integral(squares, (0, 1), 0)) - (c / b) * c * polar
    return float(index_integral(squares, (0, 1), 1)), product


def _polar_axis(b: float, share: float) -> float:
    """c/a at which P/B_12, which falls as c grows, is `share` = 2 Omega Lambda/(Omega^2 + Lambda^2)."""

    def excess(log_c: float) -> float:
        sums, product = _symbols(b, math.exp(log_c))
        return product / sums - share

    if excess(0.0) >= 0:  # the sphere, in round-off
        return 1.0
    return math.exp(root_between(excess, math.log(_FLATTEST * b), 0.0))


def _figure(b: float, x: float, scale: dict[str, float]) -> RiemannEllipsoid:
    """The ellipsoid of given b/a and Lambda/Omega."""
    if not (_THINNEST <= b <= 1):
        raise ValueError(f"b/a of a Riemann ellipsoid lies in {_THINNEST:g} <= b/a <= 1, not {b}")
    share = 2 / (x + 1 / x) if x and math.isfinite(x) else 0.0
    c = _polar_axis(b, share)
    whole = 2 * _symbols(b, c)[0]
    cosine = 1 / math.hypot(1, x)
    internal = math.sqrt(whole) * (math.copysign(1.0, x) if math.isinf(x) else x * cosine)
    return RiemannEllipsoid(b, c, whole * cosine**2, internal_rate=internal).rescaled(**scale)


@with_quantities()
def from_vorticity_ratio(b_over_a: float, vorticity_ratio: float, **scale: float) -> RiemannEllipsoid:
    """Return the ellipsoid of given b/a, 1e-8 to 1, and f = zeta/Omega, any number or infinity (Dedekind's).

    With b = a it is the Maclaurin spheroid at which the sequence of this f begins. `scale`: mass, mean_radius,
    gravitational_constant. ValueError outside. Source: Chandrasekhar 1969, section 48.
    Test: tests/unit/bodies/test_riemann.py.

    >>> print(f"{from_vorticity_ratio(0.5, 0.0).angular_velocity:.6f}")  # without currents: Jacobi
    0.481838
    """
    b, f = float(b_over_a), float(vorticity_ratio)
    if math.isnan(f):
        raise ValueError("the vorticity ratio f of a Riemann ellipsoid is a number or infinity, not nan")
    return _figure(b, f * b / (1 + b * b), scale)


@with_quantities()
def from_rate_ratio(b_over_a: float, rate_ratio: float, **scale: float) -> RiemannEllipsoid:
    """Return the ellipsoid of given b/a, 1e-8 to 1, and Lambda/Omega, any number or infinity; 1 and -1: self-adjoint.

    ValueError outside. Source: Chandrasekhar 1969, section 48. Test: tests/unit/bodies/test_riemann.py.

    >>> print(f"{from_rate_ratio(0.5, 0.0).angular_velocity:.6f}")  # without currents: Jacobi
    0.481838
    """
    if math.isnan(rate_ratio):
        raise ValueError("the ratio Lambda/Omega of a Riemann ellipsoid is a number or infinity, not nan")
    return _figure(float(b_over_a), float(rate_ratio), scale)


@with_quantities()
def from_axis_ratios(
    b_over_a: float, c_over_a: float, branch: Literal["direct", "adjoint"] = "direct", **scale: float
) -> RiemannEllipsoid:
    """Return the ellipsoid of given b/a and c/a: `direct` (Omega >= |Lambda|, as Jacobi's) or `adjoint` (Dedekind's).

    ValueError where there is none, that is outside of the self-adjoint sequences.
    Source: Chandrasekhar 1969, section 48. Test: tests/unit/bodies/test_riemann.py.

    >>> one = dedekind(0.5)
    >>> print(f'{from_axis_ratios(0.5, one.axes[2] / one.axes[0], branch="adjoint").angular_velocity:.4f}')
    0.0000
    """
    b, c = float(b_over_a), float(c_over_a)
    if branch not in ("direct", "adjoint"):
        raise ValueError(f"the branches of Riemann ellipsoids are direct and adjoint, not {branch!r}")
    if not (_THINNEST <= b <= 1 and _THINNEST * _FLATTEST <= c <= 1):
        raise ValueError(f"axis ratios of Riemann ellipsoids lie between {_THINNEST:g} and 1, not {b} and {c}")
    sums, product = _symbols(b, c)
    if abs(product) > sums + _ROUNDING:
        least, most = (_polar_axis(b, share) for share in (1.0, -1.0))
        raise ValueError(
            f"a Riemann ellipsoid with b/a = {b:.9g} has c/a from {least:.9g} to {most:.9g}, not {c_over_a}"
        )
    plus, minus = (math.sqrt(max(0.0, 2 * (sums + sign * product))) for sign in (1, -1))
    rate = (plus + minus) / 2
    body = RiemannEllipsoid(b, c, rate**2, internal_rate=product / rate)
    return (body if branch == "direct" else body.adjoint).rescaled(**scale)


@with_quantities()
def from_invariants(angular_momentum: float, circulation: float, **scale: float) -> RiemannEllipsoid:
    """Return the ellipsoid of given L and circulation pi a b (2 Omega + zeta), both kept by frictionless motion.

    Of all ellipsoids that they allow it has the least energy: a Maclaurin spheroid where L = M circulation/(5 pi) is
    less than at the dynamical limit. Both have another sign where Omega >= 0 asks for it: then the body is seen from
    below. On the sequence of a given ratio of the two, which begins at the sphere, there is one for each L. Units of
    `scale`. ValueError unless both are finite and in range.
    Source: Lai, Rasio & Shapiro 1993, section 5 (the energy as a function of both). Test:
    tests/unit/bodies/test_riemann.py.

    >>> one = from_rate_ratio(0.5, 0.2)
    >>> print(f"{from_invariants(one.angular_momentum, one.circulation).b_over_a:.6f}")
    0.500000
    """
    unit = maclaurin.from_eccentricity(0.0, **scale)
    size = math.sqrt(unit.gravitational_constant * unit.mass**3 * unit.mean_radius)
    turn, flow = angular_momentum / size, circulation * unit.mass / (5 * math.pi) / size
    if not (math.isfinite(turn) and math.isfinite(flow)):
        raise ValueError(f"momentum and circulation are finite, not {angular_momentum} and {circulation}")
    if turn < 0:
        turn, flow = -turn, -flow
    if abs(flow) > turn:
        return from_invariants(flow, 5 * math.pi * turn).adjoint.rescaled(**scale)
    if turn == 0:
        return RiemannEllipsoid(1.0, 1.0, 0.0).rescaled(**scale)
    apart = 1 - flow / turn
    if apart == 0 and turn < maclaurin.dynamical_limit().angular_momentum:
        spheroid = maclaurin.from_angular_momentum(turn)
        rate = math.sqrt(spheroid.omega2) / 2  # one rotation in two halves, as where the self-adjoint figures begin
        return RiemannEllipsoid(1.0, spheroid.c_over_a, rate**2, internal_rate=rate).rescaled(**scale)

    def figure(log_gap: float) -> RiemannEllipsoid:
        gap = math.exp(log_gap)  # (a - b)/b
        b = 1 / (1 + gap)
        # Lambda/Omega from L and its like, (1 - b)^2 and 1 - C/L apart, which may both be small
        x = ((gap * b) ** 2 - apart * (1 + b * b)) / ((gap * b) ** 2 + 2 * b * apart)
        return _figure(b, x, {})

    def excess(log_gap: float) -> float:
        return figure(log_gap).angular_momentum - turn

    ends = _LOG_ROUNDEST, -math.log(_THINNEST) - 1e-6
    if excess(ends[0]) * excess(ends[1]) > 0:
        raise ValueError(f"a Riemann ellipsoid with L = {angular_momentum} is too close to a sphere or a needle")
    return figure(root_between(excess, *ends)).rescaled(**scale)


@with_quantities()
def dedekind(b_over_a: float, **scale: float) -> RiemannEllipsoid:
    """Return the Dedekind ellipsoid of given b/a: at rest in space, held up by its internal flow; adjoint of Jacobi's.

    ValueError unless 1e-8 <= b/a <= 1. Source: Chandrasekhar 1969, ch. 6. Test: tests/unit/bodies/test_riemann.py.

    >>> print(f"{dedekind(0.5).angular_velocity:.6f}")  # at rest in space
    0.000000
    """
    return from_rate_ratio(b_over_a, math.inf, **scale)


@with_quantities()
def irrotational(b_over_a: float, **scale: float) -> RiemannEllipsoid:
    """Return the ellipsoid without vorticity in space, f = -2, of given b/a; with a = b the sphere, at rest.

    ValueError unless 1e-8 <= b/a <= 1. Source: Chandrasekhar 1969, section 48. Test: tests/unit/bodies/test_riemann.py.

    >>> print(irrotational(0.55).axes.round(4))
    [1.3856 0.7621 0.947 ]
    """
    return from_vorticity_ratio(b_over_a, -2.0, **scale)
