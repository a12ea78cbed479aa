"""Collapse of a uniform spheroid without pressure, at rest or turning about its axis: it stays uniform and a spheroid.

    d2a/dt2 = -(3/2) G M A_1/(a c) + j^2/a^3,    d2c/dt2 = -(3/2) G M A_3/a^2,    j = Omega a^2

An oblate body ends as a pancake (c = 0), a prolate one without rotation as a spindle (a = 0), a sphere in a point, and
nearly round bodies come close to a point before: the difference of the axes grows like R^(-1/2). It is therefore a
variable of its own, whose force has it as a factor, and the integration runs in the variable d(psi) = dt/a. Index
symbols are written as functions of c/a that are analytic at c = 0, so that the pancake is an ordinary root.

Source: Lin, Mestel & Shu 1965, ApJ 142, 1431; Lynden-Bell 1964, ApJ 139, 1195 (rotation); Chandrasekhar 1969,
Ellipsoidal Figures of Equilibrium, ch. 3 (symbols). Tests: tests/unit/bodies/test_cold_spheroid.py,
tests/hard/test_riemann_hard.py.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.integrate import solve_ivp
from scipy.special import hyp2f1

from astroinertia.errors import NumericalError
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import bisected

_ROUND = 0.5  # |c/a - 1| below which the closed forms of the symbols lose digits and series are used
_RELATIVE = 3e-14  # error allowed in a step
_ABSOLUTE = 1e-17  # the same, of what may pass through zero, over its natural size
_VANISHED = 1e-20  # a over its start: a spindle, whose time and length have settled to 1e-19
_BISECTIONS = 90  # to the last places of the angle when a double can tell no less that is left of the time
_SERIES = [(-1) ** k / math.factorial(2 * k + 3) for k in range(10)]  # of angle - sin(angle), over angle^3
_LONGEST = 1e6  # of psi, times the initial a/sqrt(G M/a): a collapse takes about one


class Collapse(NamedTuple):
    """How a cold spheroid ends: `kind`, the time, both semi-axes and their rates then.

    The equatorial rate of a spindle is -inf: it grows as the root of the logarithm of 1/a, and the polar rate settles;
    all rates of a point are -inf.
    """

    kind: Literal["pancake", "spindle", "point"]
    time: float
    equatorial_radius: float
    polar_radius: float
    equatorial_rate: float
    polar_rate: float


class Motion(NamedTuple):
    """Semi-axes a and c, their rates and Omega at some times, arrays of the shape of the times."""

    equatorial_radius: np.ndarray
    polar_radius: np.ndarray
    equatorial_rate: np.ndarray
    polar_rate: np.ndarray
    angular_velocity: np.ndarray


@with_quantities(polar_radius="m")
@dataclass(frozen=True)
class ColdSpheroid:
    """A uniform spheroid without pressure that is let go at t = 0 with semi-axes a, c, turning about c at Omega.

    Consistent units with the given G; ValueError unless all but Omega are positive and finite.
    """

    equatorial_radius: float
    polar_radius: float
    angular_velocity: float = 0.0
    mass: float = 1.0
    gravitational_constant: float = 1.0

    def __post_init__(self) -> None:
        positive = (self.equatorial_radius, self.polar_radius, self.mass, self.gravitational_constant)
        if not (all(0 < value < math.inf for value in positive) and math.isfinite(self.angular_velocity)):
            raise ValueError(
                f"a cold spheroid has positive, finite radii, mass and G and a finite rotation, not {self}"
            )

    @property
    def density(self) -> float:
        """Rho at the start."""
        return 3 * self.mass / (4 * math.pi * self.equatorial_radius**2 * self.polar_radius)

    @property
    def free_fall_time(self) -> float:
        """Of the sphere of the same density, (pi/2) (R^3/(2 G M))^(1/2)."""
        return sphere_free_fall_time(
            np.cbrt(self.equatorial_radius**2 * self.polar_radius), self.mass, self.gravitational_constant
        )

    def collapse(self) -> Collapse:
        """How and when it ends; NumericalError if the integration fails.

        The time is good to 1e-13, the other axis to 1e-12. Source: Lin et al. 1965.
        Test: tests/unit/bodies/test_cold_spheroid.py.
        """
        a, c = self.equatorial_radius, self.polar_radius
        if a == c and self.angular_velocity == 0:
            return Collapse("point", self.free_fall_time, 0.0, 0.0, -math.inf, -math.inf)
        _, nodes, spindle = self._course
        a, x, rate, change, time = nodes[:, -1]
        if spindle:
            return Collapse("spindle", self._time * float(time - a / rate), 0.0, self._length * float(a + x), -math.inf,
                            self._speed * float(rate + change))  # fmt: skip
        # what the dense output missed the root by, in one step of Newton's method
        time -= (a + x) / (rate + change)
        a -= (a + x) / (rate + change) * rate
        speeds = self._speed * float(rate), self._speed * float(rate + change)
        return Collapse("pancake", self._time * float(time), self._length * float(a), 0.0, *speeds)

    @with_quantities()
    def motion(self, times) -> Motion:
        """Semi-axes and rates at times (...,) from 0 to less than that of the collapse; ValueError outside.

        Source: Lin et al. 1965. Test: tests/unit/bodies/test_cold_spheroid.py.
        """
        moments = np.asarray(times, dtype=float)
        end = self.collapse().time
        if not ((moments >= 0) & (moments < end)).all():
            raise ValueError(f"the motion of this cold spheroid is known from 0 to its collapse at {end:.9g}")
        states = np.array([self._at(time / self._time) for time in moments.ravel()]).reshape(-1, 4)
        a, x, rate, change = (column.reshape(moments.shape) for column in states.T)
        turn = self.angular_velocity * (self.equatorial_radius / (self._length * a)) ** 2
        return Motion(self._length * a, self._length * (a + x), self._speed * rate, self._speed * (rate + change), turn)

    @property
    def _length(self) -> float:
        return self.equatorial_radius

    @property
    def _time(self) -> float:
        return math.sqrt(self._length**3 / (self.gravitational_constant * self.mass))

    @property
    def _speed(self) -> float:
        return self._length / self._time

    @property
    def _spin(self) -> float:
        return self.angular_velocity * self._time

    def _at(self, time: float) -> np.ndarray:
        """a, c - a and their rates at a time, all in the units of the integration."""
        if self.equatorial_radius == self.polar_radius and self.angular_velocity == 0:
            radius = float(sphere_radius(time))
            return np.array([radius, 0.0, -math.sqrt(2 * (1 / radius - 1)), 0.0])
        _, nodes, _ = self._course
        start = nodes[:, max(0, int(np.searchsorted(nodes[4], time, side="right")) - 1)]
        if time == start[4]:
            return start[:4]
        return self._integrate(lambda _, state: self._rates(state), (start[4], time), start[:4]).y[:, -1]

    def _rates(self, state: np.ndarray) -> np.ndarray:
        """d(a, c - a, da/dt, d(c - a)/dt)/dt with G M = 1."""
        a, x, rate, change = state
        centrifugal = self._spin**2 / a**3
        alpha, excess = _symbols(x / a)
        pull = 1.5 / a**2
        return np.array([rate, change, centrifugal - pull * alpha, -pull * excess - centrifugal])

    @cached_property
    def _course(self) -> tuple[np.ndarray, np.ndarray, bool]:
        """psi and (a, c - a, rates, time) at the steps up to the collapse, and whether that is a spindle's."""

        def slopes(_, state):
            return state[0] * np.append(self._rates(state[:4]), 1.0)

        def flat(_, state):
            return state[0] + state[1]

        def thin(_, state):
            return state[0] - _VANISHED

        flat.terminal = thin.terminal = True
        start = np.array([1.0, (self.polar_radius - self.equatorial_radius) / self._length, 0.0, 0.0, 0.0])
        collapse = self._integrate(slopes, (0.0, _LONGEST), start, [flat, thin])
        if collapse.status != 1:
            raise NumericalError("the collapse of a cold spheroid was not followed to its end")
        spindle = len(collapse.t_events[1]) > 0
        psi, nodes = collapse.t, collapse.y
        if not spindle:
            # The dense output is of lower order than the steps: the last one is repeated, to the event.
            last = self._integrate(slopes, (psi[-2], collapse.t_events[0][0]), nodes[:, -2])
            nodes = np.concatenate([nodes[:, :-1], last.y[:, -1:]], axis=1)
        return psi, nodes, spindle

    def _integrate(self, slopes, span: tuple[float, float], start: np.ndarray, events=None):
        # The difference of the axes begins at its own size, which may be tiny, or grows to that of the rotation.
        apart = max(abs(self.polar_radius / self.equatorial_radius - 1), self._spin**2)
        absolute = _ABSOLUTE * np.array([_VANISHED, apart, 1.0, apart, 1.0])[: len(start)]
        solution = solve_ivp(slopes, span, start, method="DOP853", rtol=_RELATIVE, atol=absolute, events=events)
        if solution.status < 0:
            raise NumericalError("the integration of a cold spheroid's collapse failed: " + str(solution.message))
        return solution


def _symbols(y: float) -> tuple[float, float]:
    """A_1 a/c and A_3 - A_1 a/c for c/a = 1 + y, analytic at c = 0; the second to round-off of itself at y = 0."""
    q = 1 + y
    if abs(y) < _ROUND:
        # 2F1 after a quadratic transformation of the integrals over v = 1/(1 + u): DLMF 15.8.18
        alpha = 2 / 3 * float(hyp2f1(1, 3, 2.5, -y / 2))
        pair = 2 / 5 * float(hyp2f1(2, 4, 3.5, -y / 2))  # A_13
        return alpha, y * (alpha - (1 + q) * pair)
    between = -y * (2 + y)  # 1 - q^2
    root = math.sqrt(abs(between))
    angle = (math.acos(q) if y < 0 else math.acosh(q)) / root
    alpha = (angle - q) / between
    return alpha, 2 * (1 - q * angle) / between - alpha


@with_quantities()
def sphere_free_fall_time(radius: float, mass: float = 1.0, gravitational_constant: float = 1.0) -> float:
    """Return (pi/2) (R^3/(2 G M))^(1/2), in which a cold sphere at rest collapses to a point.

    Source: Lin, Mestel & Shu 1965. Test: tests/unit/bodies/test_cold_spheroid.py.

    >>> print(f"{sphere_free_fall_time(1.0):.4f}")  # pi/(2 sqrt(2))
    1.1107
    """
    require_positive(radius=radius, mass=mass, gravitational_constant=gravitational_constant)
    return math.pi / 2 * math.sqrt(radius**3 / (2 * gravitational_constant * mass))


@with_quantities()
def sphere_radius(time, radius: float = 1.0, mass: float = 1.0, gravitational_constant: float = 1.0) -> np.ndarray:
    """Return the radius (...,) of a cold sphere let go at rest, at times (...,) from 0 to its free fall.

    ValueError outside. Source: Lin, Mestel & Shu 1965. Test: tests/unit/bodies/test_cold_spheroid.py.

    >>> print(sphere_radius(np.array([0.0, 1.0])).round(3))
    [1.    0.351]
    """
    share = np.asarray(time, dtype=float) / sphere_free_fall_time(radius, mass, gravitational_constant)
    if not ((share >= 0) & (share <= 1)).all():
        raise ValueError("a cold sphere is followed from t = 0 to its free-fall time")

    return radius * fallen(share)


def fallen(share) -> np.ndarray:
    """Return r/R (...,) of what falls freely from rest, at shares (...,) of its free fall: a cycloid, to round-off.

    sin^2 v with v - sin(v) cos(v) = (pi/2)(1 - share). ValueError for shares outside 0 to 1. Source: Lin, Mestel & Shu
    1965.

    >>> print(fallen(np.array([0.0, 0.5, 1.0])).round(4))
    [1.     0.8368 0.    ]
    """
    share = np.asarray(share, dtype=float)
    if not ((share >= 0) & (share <= 1)).all():
        raise ValueError("a free fall is followed from a share of 0 to 1")
    left = math.pi / 2 * (1 - share)
    ends = np.zeros_like(left), np.full_like(left, math.pi / 2)
    return np.sin(bisected(lambda v: _excess(2 * v) < 2 * left, *ends, _BISECTIONS)) ** 2


def _excess(angle: np.ndarray) -> np.ndarray:
    """angle - sin(angle), by its series where the first terms cancel."""
    series = angle**3 * polyval(angle**2, _SERIES)
    return np.where(angle > 1, angle - np.sin(angle), series)
