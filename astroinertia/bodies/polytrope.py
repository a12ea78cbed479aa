"""Polytropes: the Lane-Emden equation for 0 <= n < 5, and the sphere of given mass and radius that it describes.

    theta'' + 2 theta'/xi + theta^n = 0,    rho = rho_c theta^n,    P = K rho^(1 + 1/n),    r = R xi/xi_1

Source: Chandrasekhar 1939, An Introduction to the Study of Stellar Structure, ch. IV.
"""

import math
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.polynomial import polyval

from astroinertia.errors import NumericalError
from astroinertia.process.positive import refuse_negative, require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import bisected

HANDOVER = 1.0  # xi up to which the series at the centre is taken (theta is 0.83 to 0.86 there)
_TERMS = 36  # of it, exact to round-off there: it converges up to 3^(1/2) for n -> 5, farther for others
_SUM_ROUNDS = 1e-9  # of the whole mass
_BISECTIONS = 60
_RELATIVE, _ABSOLUTE = 2.3e-14, 1e-20


@dataclass(frozen=True, eq=False)
class LaneEmden:
    """The solution of index n from the centre to the first zero xi_1.

    surface_mass = -xi_1^2 theta'(xi_1); moment_ratio = I/(M R^2); central_to_mean = rho_c over the mean density.
    """

    index: float
    xi_1: float
    surface_mass: float
    moment_ratio: float
    central_to_mean: float
    xi: np.ndarray  # nodes, ascending from 0 to xi_1
    theta: np.ndarray
    mass: np.ndarray  # -xi^2 theta'

    def theta_at(self, xi) -> np.ndarray:
        """Return theta at any xi (to 1e-11, from n = 3 on to 6e-11), zero beyond xi_1."""
        xi = np.asarray(xi, dtype=float)
        inside = np.clip(hermite(self.xi, self.theta, self._slope, xi), 0.0, 1.0)
        return np.where(xi < self.xi_1, inside, np.where(np.isnan(xi), xi, 0.0))

    def mass_at(self, xi) -> np.ndarray:
        """Return the mass -xi^2 theta' at any xi (to 2e-10), constant beyond xi_1."""
        xi = np.asarray(xi, dtype=float)
        slope = self.xi**2 * np.maximum(self.theta, 0) ** self.index
        mass = np.clip(hermite(self.xi, self.mass, slope, xi), 0.0, self.surface_mass)
        return np.where(xi < self.xi_1, mass, np.where(np.isnan(xi), xi, self.surface_mass))

    @property
    def _slope(self) -> np.ndarray:
        return np.where(self.xi > 0, -self.mass / np.where(self.xi > 0, self.xi, 1.0) ** 2, 0.0)


def central_series(n: float, xi, terms: int = 5):
    """Return theta, -xi^2 theta' and the integral of theta^n xi^4 near the centre, to xi^(2 terms).

    theta = sum a_k xi^2k, with theta^n = sum b_k xi^2k from J.C.P. Miller's recurrence and
    a_(k+1) = -b_k / ((2k + 2)(2k + 3)). Source: Chandrasekhar 1939, ch. IV.
    """
    a, b = np.ones(terms + 1), np.ones(terms + 1)
    for k in range(1, terms + 1):
        a[k] = -b[k - 1] / (2 * k * (2 * k + 1))
        i = np.arange(1, k + 1)
        b[k] = ((n * i - (k - i)) * a[i]) @ b[k - i] / k
    xi = np.asarray(xi, dtype=float)
    square, k = xi**2, np.arange(terms + 1)
    mass = xi**3 * polyval(square, -2 * k[1:] * a[1:])
    return polyval(square, a), mass, xi**5 * polyval(square, (b / (2 * k + 5))[:-1])


@with_quantities()
def lane_emden(index: float) -> LaneEmden:
    """Return the Lane-Emden solution of `index`, accurate to about 1e-14; ValueError outside 0 <= n < 5.

    Towards n = 5, where the radius is infinite, the relative error of xi_1 is about 1e-14/(5 - n), some twenty times
    what the rounding of n itself makes; of the moment ratio it is twice that, and of central_to_mean three times.

    From a series about the centre the integration goes on in t with theta = t^4: the surface is the end point t = 0, no
    root needs to be found, and theta^n is smooth enough there for fractional n as well.

    >>> print(f"{lane_emden(1.0).moment_ratio:.9f} {2 / 3 * (1 - 6 / np.pi**2):.9f}")  # numerical and exact
    0.261381932 0.261381932
    """
    return _lane_emden(float(index))


@lru_cache(maxsize=64)
def _lane_emden(n: float) -> LaneEmden:
    if not 0 <= n < 5:
        raise ValueError(f"a polytrope of finite radius needs an index 0 <= n < 5, not {n}")

    inner = np.linspace(0.0, HANDOVER, 265)
    theta, mass, _ = central_series(n, inner, _TERMS)
    t, xi, outer_mass, moment = _envelope(n, np.linspace(1.0, 0.0, 1025))
    xi_1, surface = float(xi[-1]), float(outer_mass[-1])
    return LaneEmden(
        index=n,
        xi_1=xi_1,
        surface_mass=surface,
        moment_ratio=float(2 * moment[-1] / (3 * surface * xi_1**2)),
        central_to_mean=xi_1**3 / (3 * surface),
        xi=np.concatenate([inner[:-1], xi]),
        theta=np.concatenate([theta[:-1], t**4]),
        mass=np.concatenate([mass[:-1], outer_mass]),
    )


def _envelope(n: float, share: np.ndarray) -> tuple[np.ndarray, ...]:
    """t, xi, -xi^2 theta' and the integral of theta^n xi^4 from the handover to the surface, ascending in radius.

    share: values of t over that at the handover, from 1 to 0.
    """
    from scipy.integrate import solve_ivp  # only here: plans of other bodies do without it

    def slope(t, y):
        xi, mass = y[0], y[1]
        dxi = -4 * t**3 * xi**2 / mass
        theta_n = t ** (4 * n)
        return [dxi, xi**2 * theta_n * dxi, xi**4 * theta_n * dxi]

    theta, mass, moment = (float(value) for value in central_series(n, HANDOVER, _TERMS))
    t = theta**0.25 * share
    solution = solve_ivp(slope, (t[0], 0.0), [HANDOVER, mass, moment], method="DOP853", t_eval=t, rtol=_RELATIVE,
                         atol=_ABSOLUTE, max_step=t[0] / 128)  # fmt: skip
    if not solution.success:
        raise ArithmeticError(f"Lane-Emden integration failed: {solution.message}")
    return (t, *solution.y)


def nodes_of(index: float, core: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return xi, theta and -xi^2 theta' at chosen nodes, to about 1e-13: what a quadrature needs.

    core: ascending xi in (0, HANDOVER); share: descending values in (0, 1) of t = theta^(1/4) over its value at
    xi = HANDOVER, from where it is the smooth variable up to the surface t = 0. The result ascends in radius.
    Checked by tests/unit/bodies/test_oscillations.py, through the masses that it gives.
    """
    theta, mass, _ = central_series(float(index), core, _TERMS)
    t, xi, outer_mass, _ = (part[1:-1] for part in _envelope(float(index), np.concatenate([[1.0], share, [0.0]])))
    return np.concatenate([core, xi]), np.concatenate([theta, t**4]), np.concatenate([mass, outer_mass])


def hermite(nodes: np.ndarray, values: np.ndarray, slopes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Cubic interpolation with given slopes between ascending nodes; all arrays in units of the caller.

    Checked by the closed forms of tests/unit/bodies/test_polytrope.py.
    """
    cell = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    width = nodes[cell + 1] - nodes[cell]
    s = (at - nodes[cell]) / width
    left, right = values[cell], values[cell + 1]
    d_left, d_right = slopes[cell] * width, slopes[cell + 1] * width
    return (1 - s) ** 2 * ((1 + 2 * s) * left + s * d_left) + s**2 * ((3 - 2 * s) * right + (s - 1) * d_right)


def enclosing(nodes: np.ndarray, masses: np.ndarray, mass_at, wanted: np.ndarray) -> np.ndarray:
    """The radius inside which `wanted` lies, from the masses inside the nodes and a function: bisection to round-off.

    Checked by tests/unit/bodies/test_polytrope.py and test_homologous_core.py.
    """
    cell = np.clip(np.searchsorted(masses, wanted), 1, len(nodes) - 1)
    return bisected(lambda r: mass_at(r) < wanted, nodes[cell - 1], nodes[cell], _BISECTIONS)


@with_quantities()
@dataclass(frozen=True)
class Polytrope:
    """The polytrope of index n with a given mass and radius, in units with the given G."""

    index: float
    mass: float = 1.0
    radius: float = 1.0
    gravitational_constant: float = 1.0

    def __post_init__(self) -> None:
        if not 0 <= float(self.index) < 5:
            raise ValueError(f"a polytrope of finite radius needs an index 0 <= n < 5, not {self.index}")
        require_positive(mass=self.mass, radius=self.radius, gravitational_constant=self.gravitational_constant)

    @property
    def solution(self) -> LaneEmden:
        """The dimensionless solution of this index."""
        return lane_emden(float(self.index))

    @property
    def gamma(self) -> float:
        """1 + 1/n, infinite for n = 0."""
        return math.inf if self.index == 0 else 1 + 1 / self.index

    @property
    def central_density(self) -> float:
        """rho_c, from its ratio to the mean density."""
        return self.solution.central_to_mean * 3 * self.mass / (4 * math.pi * self.radius**3)

    @property
    def central_pressure(self) -> float:
        """4 pi G rho_c^2 (R/xi_1)^2/(n + 1)."""
        scale = self.radius / self.solution.xi_1
        return 4 * math.pi * self.gravitational_constant * self.central_density**2 * scale**2 / (self.index + 1)

    @property
    def constant(self) -> float:
        """K of P = K rho^(1 + 1/n); ValueError for n = 0, where P does not follow from rho.

        NumericalError where the index is so small that no number is as large, or as small.
        """
        if self.index == 0:
            raise ValueError("a polytrope of index 0 is incompressible: it has no polytropic constant")
        with suppress(OverflowError, ZeroDivisionError):
            constant = self.central_pressure / self.central_density**self.gamma
            if 0.0 < constant < math.inf:
                return constant
        raise NumericalError(
            f"a polytrope of index {self.index:g} has a pressure in proportion to density^{self.gamma:.3g}, beyond "
            "what numbers hold: take a larger index, or 0 for an incompressible body"
        )

    @property
    def gravitational_energy(self) -> float:
        """W = -3 G M^2/((5 - n) R)."""
        return -3 * self.gravitational_constant * self.mass**2 / ((5 - self.index) * self.radius)

    @property
    def moment_of_inertia(self) -> float:
        """I about any axis through the centre, (2/3) of the integral of rho r^2."""
        return self.solution.moment_ratio * self.mass * self.radius**2

    @with_quantities(r="m")
    def density(self, r) -> np.ndarray:
        """Density at radius r, zero outside; ValueError for a negative one."""
        refuse_negative(r=r)
        r = np.asarray(r, dtype=float)
        theta = self.solution.theta_at(r * self.solution.xi_1 / self.radius)
        return np.where(r >= self.radius, 0.0, self.central_density * theta**self.index)

    @with_quantities(r="m")
    def pressure(self, r) -> np.ndarray:
        """Pressure at radius r, zero outside; ValueError for a negative one."""
        refuse_negative(r=r)
        theta = self.solution.theta_at(np.asarray(r, dtype=float) * self.solution.xi_1 / self.radius)
        return self.central_pressure * theta ** (self.index + 1)

    @with_quantities(r="m")
    def enclosed_mass(self, r) -> np.ndarray:
        """Mass inside radius r; ValueError for a negative one."""
        refuse_negative(r=r)
        xi = np.asarray(r, dtype=float) * self.solution.xi_1 / self.radius
        return self.mass * self.solution.mass_at(xi) / self.solution.surface_mass

    @with_quantities()
    def radius_enclosing(self, mass) -> np.ndarray:
        """Radius inside which a given mass lies: bisection on the cumulative mass, to round-off.

        ValueError for a mass that is negative or more than the whole, but for rounding.
        """
        fraction = np.asarray(mass, dtype=float) / self.mass
        if (fraction < -_SUM_ROUNDS).any() or (fraction > 1.0 + _SUM_ROUNDS).any():
            raise ValueError(f"a radius encloses between 0 and the whole mass of {self.mass:g}")
        fraction, solution = np.clip(fraction, 0.0, 1.0), self.solution
        share = (
            enclosing(solution.xi, solution.mass, solution.mass_at, fraction * solution.surface_mass) / solution.xi_1
        )
        inside = np.where(fraction <= 0.0, 0.0, share * self.radius)
        return np.where(fraction >= 1.0, self.radius, np.where(np.isnan(fraction), fraction, inside))

    @with_quantities()
    def entropy_function(self, mass, gamma: float) -> np.ndarray:
        """A(m) = P/rho^gamma on the shell that encloses `mass`: what holds the same body up with another gamma.

        With gamma above 1 + 1/n the entropy rises outwards, the body is stably stratified, and A diverges at the
        surface: shells at the surface itself are not asked for.
        """
        r = self.radius_enclosing(mass)
        return self.pressure(r) / self.density(r) ** gamma


@with_quantities()
def polytrope_radius(index: float, mass: float, constant: float, gravitational_constant: float = 1.0) -> float:
    """Return the radius of the polytrope of given mass and K; ValueError for n = 0, 1e-9-near 3 and n outside (0, 5).

    K = G N_n M^((n-1)/n) R^((3-n)/n) with N_n that of the unit sphere; for n = 1 the radius does not depend on the
    mass, and for n = 3 only one mass is in equilibrium.

    >>> print(f"{polytrope_radius(1.5, 2.0, 1.0) / polytrope_radius(1.5, 1.0, 1.0):.6f}")  # R ~ M^(-1/3)
    0.793701
    """
    require_positive(mass=mass, constant=constant, gravitational_constant=gravitational_constant)
    if abs(index - 3) < 1e-9:
        raise ValueError("a polytrope of index 3 has any radius: its mass, not its radius, follows from K")
    unit = Polytrope(index).constant * gravitational_constant
    # The power of each by itself: for a small index that of the mass is beyond what numbers hold before the root.
    return (constant / unit) ** (index / (3 - index)) * mass ** ((1 - index) / (3 - index))
