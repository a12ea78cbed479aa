"""Figures of rotating bodies by the theory of figures without expansion: harmonics to any degree, shape, moments.

Three ways in: `figure_of_density` (the density of each surface of mean radius s is given), `figure_of_polytrope` and
`figure_of_barotropes` (hydrostatic equilibrium is found together with the shape). The order of the theory is the number
of `harmonics` kept, P_2 to P_(2 harmonics); the method and its sources are in figure_shapes.py. Rotation is rigid.

The field of what lies inside a surface is continued to points of it nearer to the centre than parts of that matter; at
large flattenings of compressible bodies this sum over harmonics ceases to converge, and NumericalError is raised.
Tests: tests/unit/test_figures.py, tests/hard/test_figures_hard.py.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from astroinertia.bodies.barotropes import Barotrope, PolytropicLaw
from astroinertia.bodies.figure_layers import Layer, cut_tall_layers, layer, node_count, surface_power
from astroinertia.bodies.figure_shapes import angles, multipoles, node_ranges
from astroinertia.bodies.figure_solver import (
    GivenDensity,
    Hydrostatic,
    Material,
    Rotation,
    Solution,
    on_points,
    solve,
    volume_integral,
)
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.errors import NumericalError

STAGES = (4, 7, 10, 14, 18, 24, 28, 32, 40)  # numbers of harmonics, each the start of the next
DEFAULT_HARMONICS = 10  # J2 to J20, or more if the truncation asks for it
TRUNCATION = 1e-11  # a share of the harmonics left out below which no more are added
ACCURACY = 1e-6  # the largest share of the harmonics left out, and virial error, that is not refused
NODES = 32  # of a layer that reaches the centre
FEWEST_HARMONICS = 3
_CONDENSED_EDGES = 3.0 ** np.arange(1, 8)  # xi at which a polytrope with a large envelope is cut into layers


@dataclass(frozen=True, eq=False)
class RotatingFigure:
    """A rotating body in equilibrium, in the units of its mass, mean radius and gravitational constant.

    mean_radius: of the sphere of equal volume. zonal_harmonics: J2, J4, ... with the equatorial radius and the mass.
    radius, density, enclosed_mass, pressure (node): of the level surfaces, by mean radius, ascending; a jump of density
    has two nodes.
    mu (point) and shape (node, point): r/radius on each surface. harmonics: P_2 to P_(2 harmonics) shape the surfaces.
    truncation: estimate of what those left out have of the potential at the surface, in G M/R_mean. virial_error:
    (2T + W + 3 int P dV)/|W|, an independent measure of the error.
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
    radius: np.ndarray
    density: np.ndarray
    enclosed_mass: np.ndarray
    pressure: np.ndarray
    mu: np.ndarray
    shape: np.ndarray
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
    def flattening(self) -> float:
        """f = 1 - c/a of the surface."""
        return 1 - self.polar_radius / self.equatorial_radius

    @property
    def moment_ratio(self) -> float:
        """I/(M R_mean^2) with the mean moment I."""
        return self.mean_moment / (self.mass * self.mean_radius**2)

    @property
    def polar_moment_ratio_equatorial(self) -> float:
        """C/(M a^2)."""
        return self.polar_moment / (self.mass * self.equatorial_radius**2)

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
        """k2 = 3 J2/q, the fluid Love number at this rate of rotation; NaN without rotation."""
        return 3 * float(self.zonal_harmonics[0]) / self.rotation_parameter if self.small_m else math.nan

    @property
    def kinetic_energy(self) -> float:
        """T = C Omega^2/2."""
        return 0.5 * self.polar_moment * self.angular_velocity**2

    @property
    def angular_momentum(self) -> float:
        """L = C Omega."""
        return self.polar_moment * self.angular_velocity

    @property
    def rotational_to_gravitational(self) -> float:
        """T/|W|."""
        return self.kinetic_energy / -self.gravitational_energy


def _pressures(solution: Solution, u: list[np.ndarray]) -> list[np.ndarray]:
    """Pressure at the nodes, dP = rho du from the surface, in G M^2/R^4."""
    top, pressures = 0.0, []
    for each, rho, potential_of_level in reversed(list(zip(solution.layers, solution.densities, u, strict=True))):
        pressures.append(top - each.outer[1] @ (rho * (each.slope @ potential_of_level)))
        top = pressures[-1][0]
    return pressures[::-1]


def _figure(solution: Solution, mass: float, mean_radius: float, gravitational_constant: float, accuracy: float):
    layers, densities, field = solution.layers, solution.densities, solution.field
    parts = node_ranges(layers)
    radius = np.concatenate([each.radius for each in layers])
    potentials = [solution.potential[part] for part in parts]
    fifth = solution.shape**5 @ solution.sphere.weights
    second_moment = 0.0
    for each, part, rho in zip(layers, parts, densities, strict=True):
        f = fifth[part]
        inside = each.top**5 * (each.inner[1, -1] @ (f * (each.slope @ rho)))
        second_moment += 4 * math.pi / 5 * (each.top**5 * f[-1] * rho[-1] - each.bottom**5 * f[0] * rho[0] - inside)
    harmonics = field.exterior[1:]
    mean, difference = 2 / 3 * second_moment, -float(harmonics[0])
    polar = mean + 2 / 3 * difference
    kinetic = 0.5 * polar * solution.small_m
    # With u = V + (m/2)(x^2 + y^2) constant on surfaces that enclose (4 pi/3) s^3: W = -(1/2) int rho V dV.
    gravitational = -0.5 * (
        volume_integral(layers, [rho * u for rho, u in zip(densities, potentials, strict=True)]) - kinetic
    )
    three_pressure = (
        -4
        * math.pi
        * sum(
            each.top**3 * (each.inner[0, -1] @ (rho * (each.slope @ u)))
            for each, rho, u in zip(layers, densities, potentials, strict=True)
        )
    )
    virial_error = (2 * kinetic + gravitational + three_pressure) / -gravitational
    if not abs(virial_error) < accuracy:
        raise NumericalError(
            f"the figure misses the virial theorem by {virial_error:.1e}, more than the accuracy of {accuracy:.1e}:"
            " more nodes are needed, or a density without jumps and kinks within a layer"
        )
    unit_pressure = gravitational_constant * mass**2 / mean_radius**4
    unit_moment = mass * mean_radius**2
    return RotatingFigure(
        mass=mass,
        mean_radius=mean_radius,
        gravitational_constant=gravitational_constant,
        small_m=solution.small_m,
        equatorial_radius=solution.equator * mean_radius,
        polar_radius=solution.pole * mean_radius,
        zonal_harmonics=-harmonics / solution.equator ** (2.0 * np.arange(1, len(harmonics) + 1)),
        mean_moment=mean * unit_moment,
        polar_moment=polar * unit_moment,
        equatorial_moment=(polar - difference) * unit_moment,
        gravitational_energy=gravitational * gravitational_constant * mass**2 / mean_radius,
        radius=radius * mean_radius,
        density=np.concatenate(densities) * mass / mean_radius**3,
        enclosed_mass=radius**3 * (field.outer[0] - 2 * field.medium) * mass,
        pressure=np.concatenate(_pressures(solution, potentials)) * unit_pressure,
        mu=solution.sphere.mu,
        shape=solution.shape,
        harmonics=len(field.outer) - 1,
        truncation=solution.truncation,
        virial_error=virial_error,
        sweeps=solution.sweeps,
    )


def _layers(edges, powers, nodes: int, harmonics: int) -> list[Layer]:
    return [
        layer(float(bottom), float(top), power, node_count(bottom, top, nodes), harmonics)
        for (bottom, top), power in zip(pairwise(edges), powers, strict=True)
    ]


def _converged(edges, powers, nodes, harmonics, accuracy, rotation: Rotation, material: Callable) -> Solution:
    """Solve with the number of harmonics asked for, or with more and more until enough or as many as converge."""
    if nodes < 4 or (harmonics is not None and harmonics < FEWEST_HARMONICS):
        raise ValueError(f"a figure needs 4 nodes or more and {FEWEST_HARMONICS} harmonics or more")
    best: Solution | None = None
    stages = STAGES if harmonics is None else [*(count for count in STAGES if count < harmonics), harmonics]
    for count in stages:
        layers = _layers(edges, powers, nodes, count)
        try:
            solution = solve(layers, material(layers), rotation, count, best)
        except NumericalError:
            if best is None or harmonics is not None:
                raise
            break
        if best is not None and harmonics is None and solution.truncation > max(best.truncation, TRUNCATION):
            break
        best = solution
        if harmonics is None and count >= DEFAULT_HARMONICS and best.truncation < TRUNCATION:
            break
    assert best is not None
    if best.truncation > accuracy:
        raise NumericalError(
            f"the body is too flat for the theory of figures: {len(best.field.outer) - 1} harmonics leave out"
            f" {best.truncation:.1e} of the potential at its surface, more than the accuracy of {accuracy:.1e}"
        )
    return best if harmonics is not None else _with_harmonics(best, edges, powers, nodes)


def _with_harmonics(solution: Solution, edges, powers, nodes: int) -> Solution:
    """The same surfaces with their exterior harmonics up to the default number, where fewer were enough for them."""
    if len(solution.field.exterior) > DEFAULT_HARMONICS:
        return solution
    sphere = angles(2 * DEFAULT_HARMONICS + 8, DEFAULT_HARMONICS)
    layers = _layers(edges, powers, nodes, DEFAULT_HARMONICS)
    field = multipoles(layers, on_points(solution, sphere), solution.densities, sphere)
    return replace(solution, field=replace(solution.field, exterior=field.exterior))


def _layer_edges(edges) -> np.ndarray:
    edges = np.asarray(edges, dtype=float)
    if edges.ndim != 1 or len(edges) < 1 or not np.all(np.isfinite(edges)) or not np.all(np.diff([0.0, *edges]) > 0):
        raise ValueError("the outer radii of the layers must be above zero and ascend")
    return np.concatenate([[0.0], edges])


def _rotation(small_m, rotation_parameter, angular_velocity, rate_unit: float, radius_power: int = 0) -> Rotation:
    given = [value for value in (small_m, rotation_parameter, angular_velocity) if value is not None]
    if len(given) != 1:
        raise ValueError("give one of small_m, rotation_parameter and angular_velocity")
    if not (math.isfinite(given[0]) and given[0] >= 0):
        raise ValueError("the rotation must be a finite number, zero or above")
    if angular_velocity is not None:
        return Rotation(small_m=(angular_velocity / rate_unit) ** 2, radius_power=radius_power)
    return Rotation(small_m=small_m, rotation_parameter=rotation_parameter)


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be a finite number above zero, not {value!r}")


def _radius_of_sphere(edges, powers, laws, mass: float, gravitational_constant: float, nodes: int) -> float:
    """The radius without rotation, from any first guess."""
    surface_density = float(laws[-1].density(0.0))
    guess = (3 * mass / (4 * math.pi * surface_density)) ** (1 / 3) if surface_density > 0 else 1.0
    material = Hydrostatic(laws, mass / guess**3, gravitational_constant * mass / guess, True)
    return (
        guess * _converged(edges, powers, nodes, FEWEST_HARMONICS, 1.0, Rotation(small_m=0.0), lambda _: material).scale
    )


def figure_of_density(
    outer_radii: Sequence[float],
    densities: Sequence[float | Callable],
    *,
    small_m: float | None = None,
    rotation_parameter: float | None = None,
    angular_velocity: float | None = None,
    gravitational_constant: float = 1.0,
    harmonics: int | None = None,
    nodes: int = NODES,
    accuracy: float = ACCURACY,
) -> RotatingFigure:
    """Return the figure of layers whose density is given by mean radius.

    outer_radii: mean radii at the tops of the layers, from the centre out; the last is the body's. densities: for each
    layer a number, or a smooth function of the mean radius. One of small_m, rotation_parameter and angular_velocity. A
    density that falls inwards is taken as it is, stable or not. Raises ValueError for bad arguments, NumericalError
    where no figure is found or its accuracy is worse than asked.
    """
    edges = _layer_edges(outer_radii)
    if len(densities) != len(edges) - 1:
        raise ValueError("each layer needs one density")
    _positive(gravitational_constant=gravitational_constant)
    mean_radius = float(edges[-1])
    edges, owner = cut_tall_layers(edges / mean_radius)
    densities = [densities[number] for number in owner]

    def at_nodes(layers):
        values = []
        for each, density in zip(layers, densities, strict=True):
            value = density(each.radius * mean_radius) if callable(density) else density
            values.append(np.broadcast_to(np.asarray(value, dtype=float), each.radius.shape))
        if not all(np.all(np.isfinite(value)) and np.all(value >= 0) for value in values):
            raise ValueError("densities must be finite and not negative")
        return values, volume_integral(layers, values)

    def material(layers) -> Material:
        values, mass = at_nodes(layers)
        if not mass > 0:
            raise ValueError("the body has no mass")
        return GivenDensity([value / mass for value in values])

    powers = [1.0] * len(densities)
    mass = at_nodes(_layers(edges, powers, nodes, FEWEST_HARMONICS))[1] * mean_radius**3
    rate_unit = math.sqrt(gravitational_constant * mass / mean_radius**3)
    rotation = _rotation(small_m, rotation_parameter, angular_velocity, rate_unit)
    solution = _converged(edges, powers, nodes, harmonics, accuracy, rotation, material)
    return _figure(solution, mass, mean_radius, gravitational_constant, accuracy)


def figure_of_barotropes(
    outer_fractions: Sequence[float],
    laws: Sequence[Barotrope],
    *,
    mass: float = 1.0,
    mean_radius: float | None = None,
    small_m: float | None = None,
    rotation_parameter: float | None = None,
    angular_velocity: float | None = None,
    gravitational_constant: float = 1.0,
    harmonics: int | None = None,
    nodes: int = NODES,
    accuracy: float = ACCURACY,
) -> RotatingFigure:
    """Return the figure of layers of barotropes in hydrostatic equilibrium, of given mass.

    outer_fractions: tops of the layers in units of the body's mean radius, from the centre out, ending with 1; laws:
    of each layer (barotropes.py), with the pressure going on across their boundaries. With `mean_radius`, all pressures
    of the laws are scaled by one factor that is fitted; without it, the laws hold as they are and the radius is fitted.
    One of small_m, rotation_parameter and angular_velocity. Raises ValueError for bad arguments, NumericalError where
    no figure is found or its accuracy is worse than asked.
    """
    edges = _layer_edges(outer_fractions)
    if abs(edges[-1] - 1) > 1e-14 or len(laws) != len(edges) - 1:
        raise ValueError("the outer fractions must end with 1, and each layer needs one law")
    reference = 1.0 if mean_radius is None else mean_radius
    _positive(mass=mass, mean_radius=reference, gravitational_constant=gravitational_constant)
    edges, owner = cut_tall_layers(edges)
    laws = [laws[number] for number in owner]
    index = laws[-1].surface_index
    powers = [*[1.0] * (len(laws) - 1), surface_power(index) if index > 0 else 1.0]
    if mean_radius is None:
        reference = _radius_of_sphere(edges, powers, laws, mass, gravitational_constant, nodes)
    unit_enthalpy = gravitational_constant * mass / reference
    material = Hydrostatic(laws, mass / reference**3, unit_enthalpy, mean_radius is None)
    rate_unit = math.sqrt(unit_enthalpy) / reference
    rotation = _rotation(small_m, rotation_parameter, angular_velocity, rate_unit, 0 if mean_radius else 3)
    solution = _converged(edges, powers, nodes, harmonics, accuracy, rotation, lambda layers: material)
    return _figure(solution, mass, reference * solution.scale, gravitational_constant, accuracy)


def figure_of_polytrope(
    index: float,
    *,
    mass: float = 1.0,
    mean_radius: float = 1.0,
    small_m: float | None = None,
    rotation_parameter: float | None = None,
    angular_velocity: float | None = None,
    gravitational_constant: float = 1.0,
    harmonics: int | None = None,
    nodes: int = NODES,
    accuracy: float = ACCURACY,
) -> RotatingFigure:
    """Return the figure of a polytrope of index n > 0, rigidly rotating, of given mass and mean radius.

    P = K rho^(1 + 1/n) with the K that mass and radius ask for. One of small_m, rotation_parameter and
    angular_velocity. Raises ValueError for bad arguments (for n = 0 take `figure_of_density` with one density),
    NumericalError where no figure is found or its accuracy is worse than asked.
    """
    if not 0 < index < 5:
        raise ValueError(f"a polytrope of finite radius and density needs an index 0 < n < 5, not {index!r}")
    surface = lane_emden(index).xi_1
    edges = [xi / surface for xi in _CONDENSED_EDGES if xi < 0.5 * surface]
    return figure_of_barotropes(
        [*edges, 1.0],
        [PolytropicLaw(index)] * (len(edges) + 1),
        mass=mass,
        mean_radius=mean_radius,
        small_m=small_m,
        rotation_parameter=rotation_parameter,
        angular_velocity=angular_velocity,
        gravitational_constant=gravitational_constant,
        harmonics=harmonics,
        nodes=nodes,
        accuracy=accuracy,
    )
