"""A homogeneous ellipsoid in relative equilibrium: what the Maclaurin, Jacobi, Roche and Darwin figures share.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium. Tests: tests/unit/bodies/test_ellipsoids.py.
"""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from astroinertia.bodies import ellipsoid_gravity
from astroinertia.bodies.equilibrium_figure import EquilibriumFigure
from astroinertia.inertia.gravity_field import GravityField, ellipsoid_field
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities


@with_quantities()
@dataclass(frozen=True)
class HomogeneousEllipsoid(EquilibriumFigure):
    """An ellipsoid with semi-axes a >= b >= c that turns rigidly about c, of given mass and mean radius (abc)^(1/3).

    b_over_a, c_over_a: axis ratios; omega2: Omega^2/(pi G rho). Everything else follows in units with the given G.

    >>> sphere = HomogeneousEllipsoid(1.0, 1.0, 0.0)
    >>> print(f"{sphere.moment_ratio:.3f} {sphere.gravitational_energy:.3f}")  # 2/5 M R^2, -3/5 G M^2/R
    0.400 -0.600
    """

    b_over_a: float
    c_over_a: float
    omega2: float
    mass: float = 1.0
    mean_radius: float = 1.0
    gravitational_constant: float = 1.0

    @with_quantities()
    def rescaled(self, mass: float = 1.0, mean_radius: float = 1.0, gravitational_constant: float = 1.0) -> Self:
        """The same figure with another mass, mean radius and G; ValueError unless they are positive and finite."""
        scale = {"mass": mass, "mean_radius": mean_radius, "gravitational_constant": gravitational_constant}
        require_positive(**scale)
        # One value of a dataset is a plain number here: xarray would not let it multiply an array.
        return replace(self, **{name: value if np.ndim(value) else float(value) for name, value in scale.items()})

    @property
    def axes(self) -> np.ndarray:
        """Semi-axes a, b, c."""
        ratios = np.array([1.0, self.b_over_a, self.c_over_a])
        return ratios * (self.mean_radius / np.cbrt(self.b_over_a) / np.cbrt(self.c_over_a))

    @property
    def equatorial_radius(self) -> float:
        """a, the longest semi-axis."""
        return float(self.axes[0])

    @property
    def polar_radius(self) -> float:
        """c, the semi-axis of rotation."""
        return float(self.axes[2])

    @property
    def flattening(self) -> float:
        """1 - c/a."""
        return 1 - self.c_over_a

    @property
    def eccentricity(self) -> float:
        """Of the meridian section through the longest axis, sqrt(1 - c^2/a^2)."""
        return math.sqrt((1 - self.c_over_a) * (1 + self.c_over_a))

    @property
    def density(self) -> float:
        """Rho."""
        return 3 * self.mass / (4 * math.pi * self.mean_radius**3)

    @property
    def angular_velocity(self) -> float:
        """Omega."""
        return math.sqrt(self.omega2 * math.pi * self.gravitational_constant * self.density)

    @property
    def rotation_parameter(self) -> float:
        """q = Omega^2 a^3/(G M) = (3/4) (Omega^2/(pi G rho))/((b/a)(c/a))."""
        return 0.75 * self.omega2 / (self.b_over_a * self.c_over_a)

    @property
    def small_m(self) -> float:
        """m = Omega^2 R_mean^3/(G M) = (3/4) Omega^2/(pi G rho)."""
        return 0.75 * self.omega2

    @property
    def principal_moments(self) -> np.ndarray:
        """Moments of inertia about the axes a, b, c: M (b^2 + c^2)/5 and so on."""
        squares = self.axes**2
        return self.mass / 5 * np.array([squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]])

    @property
    def polar_moment(self) -> float:
        """C, about the axis of rotation."""
        return float(self.principal_moments[2])

    @property
    def equatorial_moment(self) -> float:
        """A, about the longest axis."""
        return float(self.principal_moments[0])

    @property
    def mean_moment(self) -> float:
        """I, a third of the trace."""
        return float(self.principal_moments.sum() / 3)

    @property
    def polar_moment_ratio_equatorial(self) -> float:
        """C/(M a^2)."""
        return (1 + self.b_over_a**2) / 5

    @property
    def second_zonal_harmonic(self) -> float:
        """J_2 = (C - (A + B)/2)/(M a^2)."""
        return (self.eccentricity**2 + (self.b_over_a - self.c_over_a) * (self.b_over_a + self.c_over_a)) / 10

    @property
    def sectorial_harmonic(self) -> float:
        """C_22 = (B - A)/(4 M a^2)."""
        return (1 - self.b_over_a) * (1 + self.b_over_a) / 20

    @property
    def gravitational_energy(self) -> float:
        """W, of the body itself."""
        return ellipsoid_gravity.gravitational_energy(self.axes, self.mass, self.gravitational_constant)

    def gravity_field(self, degree: int = 20) -> GravityField:
        """The field outside, a along x and c along z, with the equatorial radius a."""
        return ellipsoid_field(self.mass, self.axes, degree, self.equatorial_radius)

    @property
    def zonal_harmonics(self) -> np.ndarray:
        """J_2, J_4, ... J_20 with the equatorial radius a, of a spheroid: 3 (-1)^(n+1) e^2n/((2n + 1)(2n + 3)).

        ValueError for three different axes. Source: Hubbard 2012, ApJL 756, L15.
        """
        if self.b_over_a != 1:
            raise ValueError("zonal harmonics in closed form belong to a spheroid: this ellipsoid has three axes")
        n = np.arange(1, 11)
        return 3 * (-1.0) ** (n + 1) * self.eccentricity ** (2 * n) / ((2 * n + 1) * (2 * n + 3))
