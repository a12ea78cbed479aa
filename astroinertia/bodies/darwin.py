"""Darwin ellipsoids: two congruent homogeneous ellipsoids in synchronous orbit, each deformed by the other.

Each body feels its own gravity, rotation and the other's tide to second degree, and the orbit feels the quadrupoles of
both, Omega^2 = 2 mu (1 + 2 delta). That is what an interaction energy of a point and two quadrupoles gives,

    E_i = -(G M^2/d)(1 + q/d^2),    q = (2 a^2 - b^2 - c^2)/5,    2 delta = 3 q/d^2,    mu = G M/d^3,
    (Omega^2 + 2 mu) a^2 + mu c^2 = 2 (a^2 - c^2) B_13,    (Omega^2 - mu) b^2 + mu c^2 = 2 (b^2 - c^2) B_23,

so that dE = Omega dJ holds exactly along the sequence, and energy and angular momentum are least at one and the same
separation: the secular limit. Figures are labelled by d/(2a), one where they touch.

Source: Lai, Rasio & Shapiro 1993, ApJS 88, 205 (the energy, for n = 0); Chandrasekhar 1969, ch. 8 (the problem).
Tests: tests/unit/bodies/test_roche.py, tests/hard/test_ellipsoids_hard.py.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from astroinertia.bodies.ellipsoid_gravity import index_integral
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

_COMPLEX_STEP = 1e-40
_WIDEST = 1e4  # d/(2a) beyond which the two are spheres to single precision
_NARROWEST = 0.8  # d/(2a) down to which overlapping figures, which are formal, are looked for
_SEPARATIONS = 1.15  # ratio between the separations at which Newton's method goes from far to near


@dataclass(frozen=True)
class DarwinEllipsoid(HomogeneousEllipsoid):
    """One of two congruent ellipsoids; a points at the other one, `gap` is d/(2a)."""

    gap: float = math.inf

    @property
    def distance(self) -> float:
        """d, between the centres."""
        return 2 * self.gap * self.equatorial_radius

    @property
    def scaled_distance(self) -> float:
        """d/R_mean."""
        return self.distance / self.mean_radius

    @property
    def orbital_energy(self) -> float:
        """Energy of both bodies and their orbit: gravity of each and of one on the other, and rotation of all."""
        quadrupole = (2 * self.axes[0] ** 2 - self.axes[1] ** 2 - self.axes[2] ** 2) / 5
        mutual = self.gravitational_constant * self.mass**2 / self.distance * (1 + quadrupole / self.distance**2)
        return 2 * self.gravitational_energy - mutual + 0.5 * self.orbital_angular_momentum * self.angular_velocity

    @property
    def orbital_angular_momentum(self) -> float:
        """Angular momentum of the orbit and both spins."""
        return (2 * self.polar_moment + 0.5 * self.mass * self.distance**2) * self.angular_velocity


def _rates(y, z, gap):
    """mu and Omega^2 over pi G rho for b^2 = y, c^2 = z and d = 2 gap (a = 1)."""
    d2 = 4 * gap**2
    mu = 4 / 3 * np.sqrt(y) * np.sqrt(z) / (d2 * 2 * gap)
    return mu, 2 * mu * (1 + 3 / 5 * (2 - y - z) / d2)


def _equations(y, z, gap):
    mu, omega2 = _rates(y, z, gap)
    squares = (1.0, y, z)
    return np.array(
        [
            omega2 + 2 * mu + mu * z - 2 * (1 - z) * index_integral(squares, (0, 2), 1),
            (omega2 - mu) * y + mu * z - 2 * (y - z) * index_integral(squares, (1, 2), 1),
        ]
    )


def _derivatives(y, z, gap, function) -> np.ndarray:
    """By y, z and gap, as columns: complex steps, exact to round-off."""
    point = np.array([y, z, gap], dtype=complex)
    steps = 1j * _COMPLEX_STEP * np.eye(3)
    return np.array([np.imag(function(*(point + step))) / _COMPLEX_STEP for step in steps]).T


def _newton(gap: float, y: float, z: float) -> tuple[float, float] | None:
    last = math.inf
    for _ in range(40):
        slopes = _derivatives(y, z, gap, _equations)[:, :2]
        step = -np.linalg.solve(slopes, np.real(_equations(y, z, gap)))
        size = float(np.max(np.abs(step)))
        if size < 1e-15 or (size < 1e-12 and size > 0.5 * last):
            return y, z
        last, y, z = size, y + float(step[0]), z + float(step[1])
        if not (0 < z < y < 1):
            return None
    return None


@lru_cache(maxsize=1024)
def _axes_squared(gap: float) -> tuple[float, float]:
    """b^2 and c^2 (a = 1): followed from far away, where linear theory holds, to the separation asked for."""
    far = max(gap, 3.0)
    mu = 4 / 3 / (2 * far) ** 3
    solution = (1 - 45 / 8 * mu, 1 - 75 / 8 * mu)
    steps = max(1, math.ceil(math.log(far / gap) / math.log(_SEPARATIONS)) + 1)
    for separation in np.geomspace(far, gap, steps):
        member = _newton(float(separation), *solution)
        if member is None:
            raise NumericalError(f"the Darwin ellipsoid at d/(2a) = {separation:.6g} did not converge")
        solution = member
    return solution


@with_quantities()
def from_gap(gap: float, **scale: float) -> DarwinEllipsoid:
    """Return the figure of given d/(2a), 0.8 to 1e4: one where the two touch, and less where they would overlap.

    `scale`: mass (of each), mean_radius, gravitational_constant. ValueError outside.
    Source: Lai et al. 1993. Test: tests/unit/bodies/test_roche.py.

    >>> print(f"{from_gap(1.0).gap:.1f}")  # they touch
    1.0
    """
    if not (_NARROWEST <= gap <= _WIDEST):
        raise ValueError(f"d/(2a) of Darwin ellipsoids lies in {_NARROWEST} <= d/(2a) <= {_WIDEST:g}, not {gap}")
    y, z = _axes_squared(float(gap))
    omega2 = float(np.real(_rates(y, z, gap)[1]))
    return DarwinEllipsoid(math.sqrt(y), math.sqrt(z), omega2, gap=float(gap)).rescaled(**scale)


@with_quantities()
def contact(**scale: float) -> DarwinEllipsoid:
    """Return the figure whose two bodies touch, d = 2a. Source: Lai et al. 1993. Test: tests/unit/bodies/test_roche.py.

    >>> print(f"{contact().distance:.4f}")  # in R_mean
    2.7691
    """
    return from_gap(1.0, **scale)


def _rate_of_change(quantity, gap: float) -> float:
    """d(quantity)/d(gap) along the sequence."""
    y, z = _axes_squared(gap)
    slopes = _derivatives(y, z, gap, _equations)
    along = np.append(-np.linalg.solve(slopes[:, :2], slopes[:, 2]), 1.0)
    return float(_derivatives(y, z, gap, lambda *point: np.array([quantity(*point)]))[0] @ along)


def _log_distance(y, z, gap):
    return np.log(gap) - (np.log(y) + np.log(z)) / 6


def _log_angular_momentum(y, z, gap):
    """ln(J/sqrt(G M^3 R_mean)) but for a constant: (2 C + M d^2/2) Omega."""
    root = (y * z) ** (1 / 6)
    return np.log(((2 + 2 * y) / 5 + 2 * gap**2) / root**2) + 0.5 * np.log(_rates(y, z, gap)[1])


@with_quantities()
def closest(**scale: float) -> DarwinEllipsoid:
    """Return the figure of least separation d/R_mean. Source: Lai et al. 1993. Test: tests/unit/bodies/test_roche.py.

    >>> print(f"{closest().distance:.4f}")  # in R_mean; a little less than at contact
    2.7544
    """
    return _turning_point("separation").rescaled(**scale)


@with_quantities()
def secular_limit(**scale: float) -> DarwinEllipsoid:
    """Return the figure of least energy and angular momentum: closer ones are secularly unstable.

    Source: Lai et al. 1993. Test: tests/unit/bodies/test_roche.py.

    >>> print(f"{secular_limit().distance:.4f}")  # in R_mean: before they are closest
    3.2422
    """
    return _turning_point("angular momentum").rescaled(**scale)


@lru_cache(maxsize=2)
def _turning_point(name: str) -> DarwinEllipsoid:
    quantity = _log_distance if name == "separation" else _log_angular_momentum
    return from_gap(root_between(lambda gap: _rate_of_change(quantity, gap), _NARROWEST, 5.0))
