"""Homologous collapse of a stellar core with gamma = 4/3 (Goldreich & Weber 1980, ApJ 238, 991), exact at every rate.

A gas of one entropy, P = K rho^(4/3), falls as r = a(t) X with a'' = -k/a^2: pressure and gravity both go as a^-2, so
what is left of gravity may stay in proportion to the distance. With r = a alpha x, rho = rho_c f^3/a^3, alpha^2 =
K/(pi G rho_c^(2/3)) and Phi = 4 pi G rho_c alpha^2 psi/a, Euler's equation is a'' a^2 x = -4 pi G rho_c (f' + psi'),
and Poisson's psi'' + 2 psi'/x = f^3. Its divergence is

    (1/x^2) (x^2 f')' + f^3 = lambda,    f(0) = 1,  f'(0) = 0,    k = (4 pi/3) G rho_c lambda.

Without lambda it is Lane and Emden's of index 3. At the largest lambda, 0.00654376, f and f' vanish together: the
surface falls freely. Beyond, f has no zero. Time follows from a'^2/2 - k/a = E: E = -k from rest, where a falls as a
cycloid, and E = 0 for the self-similar collapse, a = (1 - t/t_0)^(2/3).
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal, get_args

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.integrate import solve_ivp

from astroinertia.bodies.cold_spheroid import fallen
from astroinertia.bodies.polytrope import enclosing, hermite
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

GAMMA = 4.0 / 3.0
_HANDOVER = 1.0  # x up to which the series at the centre is taken; t = sqrt(f) is the independent variable beyond
_LONGEST = 0.1  # step of x to the critical surface
_TERMS = 30  # of it, exact to round-off there: it converges up to 2.6
_SURFACE = 0.01  # t below which f^3, at most 1e-12, no longer bends f: it is A + B/x + lambda x^2/6 from there on
_RELATIVE, _ABSOLUTE = 2.3e-14, 1e-20
_NEWTON_STEPS = 60  # of which the critical rate, whose surface is a double root, needs most
_BRACKET, _FARTHEST = (0.006, 0.007), 20.0  # of the critical rate; an x beyond every surface

Start = Literal["rest", "parabolic"]


@dataclass(frozen=True, eq=False)
class HomologousProfile:
    """The solution of one lambda from the centre to the surface x_1; lengths in units of alpha, density in rho_c.

    surface_mass: the integral of f^3 x^2; second_moment: that of f^3 x^4; weight: that of m f^3 x; work: that of
    f^4 x^2. Nodes ascend in x from 0 to x_1: f (K,), mass (K,) inside x.
    """

    rate: float
    x_1: float
    surface_mass: float
    second_moment: float
    weight: float
    work: float
    x: np.ndarray
    f: np.ndarray
    mass: np.ndarray

    def f_at(self, x) -> np.ndarray:
        """f at any x (to 1e-10), zero beyond x_1."""
        x = np.asarray(x, dtype=float)
        return np.where(x < self.x_1, np.clip(hermite(self.x, self.f, self._slope, x), 0.0, 1.0), 0.0)

    def mass_at(self, x) -> np.ndarray:
        """The mass inside any x (to 1e-10), constant beyond x_1."""
        x = np.asarray(x, dtype=float)
        inside = hermite(self.x, self.mass, self.x**2 * self.f**3, x)
        return np.where(x < self.x_1, np.clip(inside, 0.0, self.surface_mass), self.surface_mass)

    @cached_property
    def _slope(self) -> np.ndarray:
        x = np.where(self.x > 0, self.x, 1.0)
        return np.where(self.x > 0, self.rate * self.x / 3 - self.mass / x**2, 0.0)


def _centre(rate: float, x):
    """f, mass and the integrals of f^3 x^4, m f^3 x and f^4 x^2 up to the handover.

    f = sum a_k x^2k with a_(k+1) = (lambda delta_k0 - b_k)/((2k + 2)(2k + 3)), b the series of f^3, m = sum
    b_k x^(2k+3)/(2k+3).
    """
    x = np.asarray(x, dtype=float)
    a = [1.0]
    for k in range(_TERMS - 1):
        cube = np.convolve(np.convolve(a, a), a)[k]
        a.append(((rate if k == 0 else 0.0) - cube) / ((2 * k + 2) * (2 * k + 3)))
    k = np.arange(_TERMS)
    b = np.convolve(np.convolve(a, a), a)[:_TERMS]
    weight, fourth = np.convolve(b / (2 * k + 3), b)[:_TERMS], np.convolve(b, a)[:_TERMS]

    def series(terms, power: int):
        return x**power * polyval(x**2, terms / (2 * k + power))

    return polyval(x**2, a), series(b, 3), series(b, 5), series(weight, 5), series(fourth, 3)


@lru_cache(maxsize=1)
def critical_rate() -> float:
    """The largest lambda: that at which f touches zero, to 1e-12.

    Goldreich & Weber (1980) have 0.00654.

    >>> print(f"{critical_rate():.10f}")
    0.0065437581
    """

    def least(rate: float) -> float:
        def slope(x, y):
            return [rate * x / 3 - y[1] / x**2, y[0] ** 3 * x**2]

        def bottom(x, y):
            return rate * x**3 / 3 - y[1]  # x^2 f'

        bottom.terminal, bottom.direction = True, 1.0
        start = [float(value) for value in _centre(rate, _HANDOVER)[:2]]
        fallen = solve_ivp(slope, (_HANDOVER, _FARTHEST), start, "DOP853", events=bottom, rtol=_RELATIVE,
                           atol=_ABSOLUTE, max_step=_LONGEST)  # fmt: skip
        return fallen.y_events[0][0][0]

    return root_between(least, *_BRACKET, 1e-16, 1e-14)


@lru_cache(maxsize=64)
def homologous_profile(share: float) -> HomologousProfile:
    """The profile of lambda = share of the critical one, accurate to 1e-12 (x_1 of share 1: to 1e-8).

    From a series about the centre the integration goes on in t = sqrt(f), in which dx/dt is bounded at the surface also
    where f' vanishes there; the last stretch is in closed form. ValueError outside 0 <= share <= 1.

    >>> from astroinertia.bodies.polytrope import lane_emden
    >>> print(f"{homologous_profile(0.0).x_1:.6f} {lane_emden(3.0).xi_1:.6f} {homologous_profile(1.0).x_1:.4f}")
    6.896849 6.896849 9.8894
    """
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"a homologous collapse has a rate between 0 and 1 times the critical one, not {share}")
    rate = share * critical_rate()
    inner = np.linspace(0.0, _HANDOVER, 265)
    first = np.array(_centre(rate, inner))
    t = np.linspace(math.sqrt(first[0, -1]), _SURFACE, 1537)

    def inwards(t, y):
        x, mass = y[0], y[1]
        dx = 2 * t / (rate * x / 3 - mass / x**2)
        cube = t**6
        return [dx, cube * x**2 * dx, cube * x**4 * dx, mass * cube * x * dx, cube * t**2 * x**2 * dx]

    solution = solve_ivp(inwards, (t[0], t[-1]), [_HANDOVER, *first[1:, -1]], method="DOP853", t_eval=t,
                         rtol=_RELATIVE, atol=_ABSOLUTE)  # fmt: skip
    if not solution.success:
        raise ArithmeticError(f"the integration of a homologous core failed: {solution.message}")
    x, mass = solution.y[0], solution.y[1]
    edge, far, f_far, mass_far, sums = _last_stretch(rate, x[-1], t[-1] ** 2, solution.y[1:, -1])
    return HomologousProfile(
        rate, edge, *sums,
        x=np.concatenate([inner[:-1], x, far]),
        f=np.concatenate([first[0, :-1], t**2, f_far]),
        mass=np.concatenate([first[1, :-1], mass, mass_far]),
    )  # fmt: skip


def _last_stretch(rate: float, x_0: float, f_0: float, sums: np.ndarray):
    """The surface from (x_0, f_0) on: x_1, nodes beyond x_0 (K,) with f and mass there, and the sums up to x_1.

    f = A + B/x + rate x^2/6, with B from the mass inside x_0.
    """
    b = sums[0]
    a = f_0 - b / x_0 - rate * x_0**2 / 6
    lowest = (3 * b / rate) ** (1 / 3) if rate > 0 else math.inf
    x_1 = x_0
    for _ in range(_NEWTON_STEPS):  # from the left, where f is convex: it comes to the nearer root, and not past it
        slope = rate * x_1 / 3 - b / x_1**2
        value = a + b / x_1 + rate * x_1**2 / 6
        if slope >= 0 or value <= 0:
            break
        x_1 = min(x_1 - value / slope, lowest)
    far = np.linspace(x_0, x_1, 65)[1:]
    f = np.maximum(a + b / far + rate * far**2 / 6, 0.0)
    f[-1] = 0.0
    points, weights = np.polynomial.legendre.leggauss(12)
    x = x_0 + (x_1 - x_0) * (points + 1) / 2
    weights = weights * (x_1 - x_0) / 2
    cube = np.maximum(a + b / x + rate * x**2 / 6, 0.0) ** 3
    more = np.array([cube * x**2, cube * x**4, b * cube * x, cube ** (4 / 3) * x**2]) @ weights
    grown = np.cumsum(np.concatenate([[f_0**3 * x_0**2], f**3 * far**2]))
    mass = sums[0] + more[0] * (grown[1:] / grown[-1])
    return float(x_1), far, f, mass, [float(value) for value in sums + more]


@with_quantities()
@dataclass(frozen=True)
class HomologousCore:
    """A collapsing core of a given mass and radius at t = 0, in units with the given G.

    share: lambda over the critical one, 0 (at rest) to 1. start: "rest", or "parabolic" for the self-similar collapse,
    which has fallen from infinity.
    """

    share: float
    mass: float = 1.0
    radius: float = 1.0
    start: Start = "parabolic"
    gravitational_constant: float = 1.0

    def __post_init__(self) -> None:
        if self.start not in get_args(Start):
            raise ValueError(f"start must be {' or '.join(get_args(Start))}, not {self.start!r:.40}")
        require_positive(mass=self.mass, radius=self.radius, gravitational_constant=self.gravitational_constant)

    @property
    def profile(self) -> HomologousProfile:
        """The dimensionless solution."""
        return homologous_profile(float(self.share))

    @property
    def scale(self) -> float:
        """alpha at t = 0, the length of x = 1."""
        return self.radius / self.profile.x_1

    @property
    def central_density(self) -> float:
        """rho_c at t = 0."""
        return self.mass / (4 * math.pi * self.scale**3 * self.profile.surface_mass)

    @property
    def constant(self) -> float:
        """K of P = K rho^(4/3): pi G rho_c^(2/3) alpha^2."""
        return math.pi * self.gravitational_constant * self.central_density ** (2 / 3) * self.scale**2

    @property
    def central_pressure(self) -> float:
        """P at the centre at t = 0."""
        return self.constant * self.central_density**GAMMA

    @property
    def deceleration(self) -> float:
        """k of a'' = -k/a^2, (4 pi/3) G rho_c lambda: every part is drawn in by k r at t = 0."""
        return 4 * math.pi / 3 * self.gravitational_constant * self.central_density * self.profile.rate

    @property
    def starting_rate(self) -> float:
        """a' at t = 0: nothing from rest, -(2k)^(1/2) on the parabola."""
        return 0.0 if self.start == "rest" else -math.sqrt(2 * self.deceleration)

    @property
    def collapse_time(self) -> float:
        """The time at which a = 0; infinite without collapse.

        From rest pi/(2 (2k)^(1/2)), as of free fall; on the parabola 2/(3 (2k)^(1/2)).
        """
        if self.deceleration == 0.0:
            return math.inf
        return (math.pi / 2 if self.start == "rest" else 2 / 3) / math.sqrt(2 * self.deceleration)

    @property
    def moment_of_inertia(self) -> float:
        """I about any axis through the centre at t = 0, (2/3) of the integral of rho r^2."""
        profile = self.profile
        return 2 / 3 * self.mass * self.scale**2 * profile.second_moment / profile.surface_mass

    @property
    def gravitational_energy(self) -> float:
        """W at t = 0; it goes as 1/a."""
        profile = self.profile
        return -self.gravitational_constant * self.mass**2 / self.scale * profile.weight / profile.surface_mass**2

    @property
    def internal_energy(self) -> float:
        """U = 3 integral P dV at t = 0; it goes as 1/a. By the virial theorem U + W = -k integral rho r^2 dV."""
        scale = self.scale
        return 12 * math.pi * self.central_pressure * scale**3 * self.profile.work

    @with_quantities()
    def scale_factor(self, time) -> np.ndarray:
        """a at times of the shape of `time`; ValueError after the collapse, or before t = 0."""
        time = np.asarray(time, dtype=float)
        end = self.collapse_time
        if not ((time >= 0) & (time < end)).all():
            raise ValueError(f"a homologous collapse is known from t = 0 to {end:g}, when it has no size any more")
        if self.deceleration == 0.0:
            return np.ones_like(time)
        return (1 - time / end) ** (2 / 3) if self.start == "parabolic" else fallen(time / end)

    def time_of(self, scale_factor) -> np.ndarray:
        """When a has come down to values in (0, 1]; ValueError for others, or without collapse."""
        a = np.asarray(scale_factor, dtype=float)
        if self.deceleration == 0.0 or (a <= 0).any() or (a > 1).any():
            raise ValueError("a homologous collapse passes sizes between 0 and 1 times the first, and needs a rate")
        if self.start == "parabolic":
            return self.collapse_time * (1 - a**1.5)
        u = np.arccos(np.sqrt(a))
        return (u + np.sqrt(a * (1 - a))) / math.sqrt(2 * self.deceleration)

    @with_quantities()
    def expansion_rate(self, time) -> np.ndarray:
        """a'/a at times, negative: the velocity over the distance."""
        a = self.scale_factor(time)
        energy = 0.5 * self.starting_rate**2 - self.deceleration
        return -np.sqrt(np.maximum(2 * (energy + self.deceleration / a), 0.0)) / a

    @with_quantities()
    def moment_at(self, time) -> np.ndarray:
        """I at times: a^2 times the first."""
        return self.moment_of_inertia * self.scale_factor(time) ** 2

    @with_quantities(r="m")
    def density(self, r, time=0.0) -> np.ndarray:
        """Density at radius r and time, zero outside."""
        a = self.scale_factor(time)
        return self.central_density * self.profile.f_at(np.asarray(r, dtype=float) / (a * self.scale)) ** 3 / a**3

    @with_quantities(r="m")
    def pressure(self, r, time=0.0) -> np.ndarray:
        """Pressure at radius r and time, zero outside."""
        return self.constant * self.density(r, time) ** GAMMA

    @with_quantities(r="m")
    def enclosed_mass(self, r, time=0.0) -> np.ndarray:
        """Mass inside radius r at a time."""
        profile, a = self.profile, self.scale_factor(time)
        return self.mass * profile.mass_at(np.asarray(r, dtype=float) / (a * self.scale)) / profile.surface_mass

    @with_quantities()
    def radius_enclosing(self, mass) -> np.ndarray:
        """Radius at t = 0 inside which a given mass lies: bisection on the cumulative mass, to round-off."""
        profile = self.profile
        fraction = np.clip(np.asarray(mass, dtype=float) / self.mass, 0.0, 1.0)
        x = enclosing(profile.x, profile.mass, profile.mass_at, fraction * profile.surface_mass)
        inside = np.where(fraction <= 0.0, 0.0, x * self.scale)
        return np.where(fraction >= 1.0, self.radius, inside)
