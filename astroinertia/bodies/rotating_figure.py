"""A rotating body in equilibrium and what follows from it: moments, harmonics, energies, shape.

Tests: tests/unit/bodies/test_figures.py.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from astroinertia.bodies.equilibrium_figure import EquilibriumFigure
from astroinertia.bodies.figure_shapes import node_ranges
from astroinertia.bodies.figure_solver import Solution, volume_integral
from astroinertia.errors import NumericalError

_SLOWEST = 1e-12  # m, whose J2 is known to a hundredth


@dataclass(frozen=True, eq=False)
class RotatingFigure(EquilibriumFigure):
    """A rotating body in equilibrium, in the units of its mass, mean radius and gravitational constant.

    mean_radius: of the sphere of equal volume. zonal_harmonics: J2, J4, ... with the equatorial radius and the mass,
    to 1e-14: J2/m of a rotation as slow as m = 1e-10 is off by 1e-4.
    radius, density, enclosed_mass, pressure, level_flattening 1 - c/a (node): of the level surfaces, by mean radius,
    ascending; a jump of density has two nodes.
    mu (point) and shape (node, point): r/radius on each surface. harmonics: P_2 to P_(2 harmonics) shape the surfaces.
    truncation: estimate of what those left out have of the potential at the surface, in G M/R_mean (n = 1: the error of
    the flattening is 0.1 to 0.5 of it, that of J2 less). virial_error:
    (2T + W + 3 int P dV)/|W|, an independent measure of the error. sweeps: of the last stage.
    """

    mass: float
    mean_radius: float
    gravitational_constant: float
    small_m: float
    equatorial_radius: float
    polar_radius: float
    zonal_harmonics: np.ndarray
    mean_moment: float
    polar_moment: float
    equatorial_moment: float
    gravitational_energy: float
    radius: np.ndarray = field(repr=False)
    density: np.ndarray = field(repr=False)
    enclosed_mass: np.ndarray = field(repr=False)
    pressure: np.ndarray = field(repr=False)
    level_flattening: np.ndarray = field(repr=False)
    mu: np.ndarray = field(repr=False)
    shape: np.ndarray = field(repr=False)
    harmonics: int
    truncation: float
    virial_error: float
    sweeps: int

    @property
    def angular_velocity(self) -> float:
        """Omega = sqrt(m G M/R_mean^3)."""
        return math.sqrt(self.small_m * self.gravitational_constant * self.mass / self.mean_radius**3)

    @property
    def rotation_parameter(self) -> float:
        """q = Omega^2 a^3/(G M)."""
        return self.small_m * (self.equatorial_radius / self.mean_radius) ** 3

    @property
    def equatorial_moment_ratio_equatorial(self) -> float:
        """A/(M a^2)."""
        return self.equatorial_moment / (self.mass * self.equatorial_radius**2)

    @property
    def dynamical_ellipticity(self) -> float:
        """H = (C - A)/C."""
        return (self.polar_moment - self.equatorial_moment) / self.polar_moment

    @property
    def secular_love_number(self) -> float:
        """k2 = 3 J2/q, the fluid Love number at this rate of rotation; NaN where it is so slow that J2 is round-off."""
        return 3 * float(self.zonal_harmonics[0]) / self.rotation_parameter if self.small_m > _SLOWEST else math.nan


def _pressures(solution: Solution, u: list[np.ndarray]) -> list[np.ndarray]:
    """Pressure at the nodes, dP = rho du from the surface, in G M^2/R^4."""
    top, pressures = 0.0, []
    for layer, rho, potential_of_level in reversed(list(zip(solution.layers, solution.densities, u, strict=True))):
        pressures.append(top - layer.outer[1] @ (rho * (layer.slope @ potential_of_level)))
        top = pressures[-1][0]
    return pressures[::-1]


def _second_moment(solution: Solution) -> float:
    """The integral of rho r^2 dV, by parts."""
    fifth = solution.shape**5 @ solution.sphere.weights
    total = 0.0
    for layer, part, rho in zip(solution.layers, node_ranges(solution.layers), solution.densities, strict=True):
        f = fifth[part]
        inside = layer.top**5 * (layer.inner[1, -1] @ (f * (layer.slope @ rho)))
        total += 4 * math.pi / 5 * (layer.top**5 * f[-1] * rho[-1] - layer.bottom**5 * f[0] * rho[0] - inside)
    return float(total)


def _energies(solution: Solution, potentials: list[np.ndarray], kinetic: float) -> tuple[float, float]:
    """W and the integral of 3 P dV."""
    layers, densities = solution.layers, solution.densities
    # With u = V + (m/2)(x^2 + y^2) constant on surfaces that enclose (4 pi/3) s^3: W = -(1/2) int rho V dV.
    total = volume_integral(layers, [rho * u for rho, u in zip(densities, potentials, strict=True)])
    falls = [
        layer.top**3 * float(layer.inner[0, -1] @ (rho * (layer.slope @ u)))
        for layer, rho, u in zip(layers, densities, potentials, strict=True)
    ]
    return -0.5 * (total - kinetic), -4 * math.pi * sum(falls)


def figure_of_solution(
    solution: Solution, mass: float, mean_radius: float, gravitational_constant: float, accuracy: float
) -> RotatingFigure:
    """Return the quantities of a solution, in the units of mass, mean radius and G.

    NumericalError if it misses the virial theorem by more than `accuracy`, which tells of too few nodes.
    """
    layers, field = solution.layers, solution.field
    radius = np.concatenate([layer.radius for layer in layers])
    potentials = [solution.potential[part] for part in node_ranges(layers)]
    harmonics = field.exterior[1:]
    mean, difference = 2 / 3 * _second_moment(solution), -float(harmonics[0])
    polar = mean + 2 / 3 * difference
    kinetic = 0.5 * polar * solution.small_m
    gravitational, three_pressure = _energies(solution, potentials, kinetic)
    virial_error = (2 * kinetic + gravitational + three_pressure) / -gravitational
    if not abs(virial_error) < accuracy:
        raise NumericalError(
            f"the figure misses the virial theorem by {virial_error:.1e}, more than the accuracy of {accuracy:.1e}:"
            " more nodes are needed, or a density without jumps and kinks within a layer"
        )
    unit_pressure = gravitational_constant * mass**2 / mean_radius**4
    equator = float(solution.equator[-1])
    unit_moment = mass * mean_radius**2
    return RotatingFigure(
        mass=mass,
        mean_radius=mean_radius,
        gravitational_constant=gravitational_constant,
        small_m=solution.small_m,
        equatorial_radius=equator * mean_radius,
        polar_radius=float(solution.pole[-1]) * mean_radius,
        zonal_harmonics=-harmonics / equator ** (2.0 * np.arange(1, len(harmonics) + 1)),
        mean_moment=mean * unit_moment,
        polar_moment=polar * unit_moment,
        equatorial_moment=(polar - difference) * unit_moment,
        gravitational_energy=gravitational * gravitational_constant * mass**2 / mean_radius,
        radius=radius * mean_radius,
        density=np.concatenate(solution.densities) * mass / mean_radius**3,
        enclosed_mass=radius**3 * (field.outer[0] - 2 * field.medium) * mass,
        pressure=np.concatenate(_pressures(solution, potentials)) * unit_pressure,
        level_flattening=1 - solution.pole / solution.equator,
        mu=solution.sphere.mu,
        shape=solution.shape,
        harmonics=len(field.outer) - 1,
        truncation=solution.truncation,
        virial_error=virial_error,
        sweeps=solution.sweeps,
    )
