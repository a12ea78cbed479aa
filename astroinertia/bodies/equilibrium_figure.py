"""What rotating bodies in equilibrium share: ellipsoids, polytropes, figures of layers and self-consistent stars.

Tests: tests/unit/bodies/test_figures.py, tests/unit/bodies/test_ellipsoids.py, tests/unit/bodies/test_scf.py.
"""

import numpy as np

from astroinertia.inertia.gravity_field import GravityField, zonal_field


class EquilibriumFigure:
    """Ratios and energies of a body that turns about its shortest axis, from its mass, radii, moments and rate.

    A subclass has the attributes below as fields or properties, in the units of its mass, mean radius and G; where it
    knows one of these properties better, as one that does not turn rigidly knows its energy, it has its own.
    """

    mass: float
    mean_radius: float
    gravitational_constant: float
    equatorial_radius: float
    polar_radius: float
    angular_velocity: float
    polar_moment: float
    mean_moment: float
    gravitational_energy: float
    zonal_harmonics: np.ndarray

    def gravity_field(self) -> GravityField:
        """The field outside, about z, to the degree of zonal_harmonics, with the equatorial radius."""
        return zonal_field(self.mass, self.equatorial_radius, self.zonal_harmonics)

    @property
    def flattening(self) -> float:
        """f = 1 - c/a of the surface."""
        return 1 - self.polar_radius / self.equatorial_radius

    @property
    def moment_ratio(self) -> float:
        """I/(M R_mean^2) with the mean moment I, a third of the trace."""
        return self.mean_moment / (self.mass * self.mean_radius**2)

    @property
    def polar_moment_ratio_equatorial(self) -> float:
        """C/(M a^2)."""
        return self.polar_moment / (self.mass * self.equatorial_radius**2)

    @property
    def kinetic_energy(self) -> float:
        """T = C Omega^2/2, in a frame at rest with the centre."""
        return 0.5 * self.polar_moment * self.angular_velocity**2

    @property
    def angular_momentum(self) -> float:
        """L = C Omega, about the own centre."""
        return self.polar_moment * self.angular_velocity

    @property
    def rotational_to_gravitational(self) -> float:
        """T/|W|."""
        return self.kinetic_energy / -self.gravitational_energy
