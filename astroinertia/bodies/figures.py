"""Figures of rotating bodies by the theory of figures without expansion: harmonics to any degree, shape, moments.

Ways in: `figure_of_density` and `figure_of_layered_body` (the density of each surface of mean radius s is given),
`figure_of_polytrope` and `figure_of_barotropes` (hydrostatic equilibrium is found together with the shape). The order
of the theory is the number of `harmonics` kept, P_2 to P_(2 harmonics); the method and its sources are in
figure_shapes.py. Rotation is rigid.

The field of what lies inside a surface is continued to points of it nearer to the centre than parts of that matter; at
large flattenings of compressible bodies this sum over harmonics ceases to converge, and NumericalError is raised. With
the default accuracy this is reached at q = 0.28, 0.38, 0.47 and 0.68 for polytropes of index 0.5, 1, 1.5 and 3,
flattened by 0.22, 0.23, 0.23 and 0.26 (rotating_star.py goes on to mass shedding); homogeneous spheroids are found up
to their largest rate of rotation.
Tests: tests/unit/bodies/test_figures.py, tests/hard/test_figures_hard.py.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from astroinertia.bodies.figure_layers import FEWEST_NODES, Layer, cut_tall_layers, layer, node_count, surface_power
from astroinertia.bodies.figure_shapes import angles, multipoles
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
from astroinertia.bodies.rotating_figure import RotatingFigure, figure_of_solution
from astroinertia.errors import NumericalError
from astroinertia.matter.barotropes import BarotropicLaw, PolytropicLaw
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities

if TYPE_CHECKING:  # it brings JAX along, which figures do not need
    from astroinertia.bodies.layered import LayeredBody

STAGES = (4, 7, 10, 14, 18, 24, 28, 32, 40)  # numbers of harmonics, each the start of the next
DEFAULT_HARMONICS = 10  # J2 to J20, or more if the truncation asks for it
TRUNCATION = 1e-11  # a share of the harmonics left out below which no more are added
ACCURACY = 1e-6  # the largest share of the harmonics left out, and virial error, that is not refused
NODES = 32  # of a layer that reaches the centre
FEWEST_HARMONICS = 3
_SPIN_UP = (0.4, 0.6, 0.75, 0.85, 0.93, 1.0)  # shares of the centrifugal force
_CONDENSED_INDEX = 2.5
_STIFF_INDEX, _STIFF_EDGE = 0.2, 0.9  # the density of a stiff polytrope falls near its surface only
_CONDENSED_EDGES = 3.0 ** np.arange(1, 8)  # xi at which a polytrope with a large envelope is cut into layers


def _layers(edges, powers, nodes: int, harmonics: int) -> list[Layer]:
    return [
        layer(float(bottom), float(top), power, node_count(bottom, top, nodes, power), harmonics)
        for (bottom, top), power in zip(pairwise(edges), powers, strict=True)
    ]


def _converged(edges, powers, nodes, harmonics, accuracy, rotation: Rotation, material: Callable) -> Solution:
    """Solve with the number of harmonics asked for, or with more and more until enough or as many as converge."""
    best: Solution | None = None
    last: Solution | None = None
    stages = STAGES if harmonics is None else [*(count for count in STAGES if count < harmonics), harmonics]
    for count in stages:
        layers = _layers(edges, powers, nodes, count)
        try:
            solution = solve(layers, material(layers), rotation, count, last)
        except NumericalError:
            if last is None:
                solution = _spun_up(layers, material(layers), rotation, count)
            elif harmonics is None:
                break
            else:
                raise
        if best is None or harmonics is not None or solution.truncation < max(best.truncation, TRUNCATION):
            best = solution
        elif last is not best:  # twice no better: once may be by chance
            break
        last = solution
        if harmonics is None and count >= DEFAULT_HARMONICS and best.truncation < TRUNCATION:
            break
    assert best is not None
    if best.truncation > accuracy:
        raise NumericalError(
            f"the body is too flat for the theory of figures: {len(best.field.outer) - 1} harmonics leave out"
            f" {best.truncation:.1e} of the potential at its surface, more than the accuracy of {accuracy:.1e}"
        )
    return best if harmonics is not None else _with_harmonics(best, edges, powers, nodes)


def _spun_up(layers, material: Material, rotation: Rotation, harmonics: int) -> Solution:
    """Solve step by step from slow rotation."""
    solution: Solution | None = None
    for share in _SPIN_UP:
        solution = solve(layers, material, rotation.slowed(share), harmonics, solution)
    assert solution is not None
    return solution


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
    rates = [value for value in (small_m, rotation_parameter, angular_velocity) if value is not None]
    if len(rates) != 1:
        raise ValueError("give one of small_m, rotation_parameter and angular_velocity")
    if not (math.isfinite(rates[0]) and rates[0] >= 0):
        raise ValueError("the rotation must be a finite number, zero or above")
    if angular_velocity is not None:
        return Rotation(small_m=(angular_velocity / rate_unit) ** 2, radius_power=radius_power)
    return Rotation(small_m=small_m, rotation_parameter=rotation_parameter)


def _check_settings(nodes: int, harmonics: int | None, accuracy: float) -> None:
    if nodes < FEWEST_NODES or (harmonics is not None and harmonics < FEWEST_HARMONICS):
        raise ValueError(f"a figure needs {FEWEST_NODES} nodes and {FEWEST_HARMONICS} harmonics at least")
    require_positive(accuracy=accuracy)


def _radius_of_sphere(edges, powers, laws, mass: float, gravitational_constant: float, nodes: int) -> float:
    """The radius without rotation, from any first guess."""
    surface_density = float(laws[-1].density(0.0))
    guess = (3 * mass / (4 * math.pi * surface_density)) ** (1 / 3) if surface_density > 0 else 1.0
    material = Hydrostatic(laws, mass / guess**3, gravitational_constant * mass / guess, True)
    return (
        guess * _converged(edges, powers, nodes, FEWEST_HARMONICS, 1.0, Rotation(small_m=0.0), lambda _: material).scale
    )


@with_quantities()
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
    density that falls inwards is taken as it is, stable or not. harmonics: P_2 to P_(2 harmonics), as many as needed
    if None; nodes: of a layer that reaches the centre; accuracy: the worst truncation and virial error that are not
    refused. Raises ValueError for bad arguments, NumericalError where no figure is found or it is not that accurate.
    Source: figure_shapes.py; checked by tests/unit/bodies/test_figures.py against Maclaurin, Clairaut and PREM.

    >>> print(f"{figure_of_density([1.0], [1.0], small_m=0.01).flattening:.5f}")  # about (5/4) m of a uniform body
    0.01253
    """
    edges = _layer_edges(outer_radii)
    if len(densities) != len(edges) - 1:
        raise ValueError("each layer needs one density")
    require_positive(gravitational_constant=gravitational_constant)
    _check_settings(nodes, harmonics, accuracy)
    mean_radius = float(edges[-1])
    edges, owner = cut_tall_layers(edges / mean_radius)
    densities = [densities[number] for number in owner]

    def at_nodes(layers):
        values = []
        for shell, density in zip(layers, densities, strict=True):
            value = density(shell.radius * mean_radius) if callable(density) else density
            values.append(np.broadcast_to(np.asarray(value, dtype=float), shell.radius.shape))
        if not all(np.all(np.isfinite(value)) and np.all(value >= 0) for value in values):
            raise ValueError("densities must be finite and not negative")
        return values, volume_integral(layers, values)

    def material(layers) -> Material:
        values, mass = at_nodes(layers)
        return GivenDensity([value / mass for value in values])

    powers = [1.0] * len(densities)
    mass = at_nodes(_layers(edges, powers, nodes, FEWEST_HARMONICS))[1] * mean_radius**3
    if not mass > 0:
        raise ValueError("the body has no mass")
    rate_unit = math.sqrt(gravitational_constant * mass / mean_radius**3)
    rotation = _rotation(small_m, rotation_parameter, angular_velocity, rate_unit)
    solution = _converged(edges, powers, nodes, harmonics, accuracy, rotation, material)
    return figure_of_solution(solution, mass, mean_radius, gravitational_constant, accuracy)


@with_quantities()
def figure_of_layered_body(body: "LayeredBody", **settings: Any) -> RotatingFigure:
    """Return the figure of a body of layers of polynomial density (layered.py), which is that of its level surfaces.

    Units, G and mean radius are the body's; settings: the rotation and the other arguments of `figure_of_density`, as
    are errors and source. Checked by tests/unit/bodies/test_figures.py.
    """
    radii = np.asarray(body.outer_radii, dtype=float)
    thick = np.diff(radii, prepend=0.0) > 0
    layers = [partial(_polynomial, np.asarray(layer, dtype=float), radii[-1]) for layer in body.coefficients]
    return figure_of_density(
        radii[thick].tolist(),
        [density for density, kept in zip(layers, thick, strict=True) if kept],
        gravitational_constant=float(body.gravitational_constant),
        **settings,
    )


def _polynomial(coefficients: np.ndarray, scale: float, r: np.ndarray) -> np.ndarray:
    return np.polynomial.polynomial.polyval(r / scale, coefficients)


@with_quantities()
def figure_of_barotropes(
    outer_fractions: Sequence[float],
    laws: Sequence[BarotropicLaw],
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
    One of small_m, rotation_parameter and angular_velocity; harmonics, nodes and accuracy as for `figure_of_density`.
    Raises ValueError for bad arguments, NumericalError where no figure is found or it is not that accurate. Source:
    figure_shapes.py; checked by tests/unit/bodies/test_figures.py.
    """
    edges = _layer_edges(outer_fractions)
    if abs(edges[-1] - 1) > 1e-14 or len(laws) != len(edges) - 1:
        raise ValueError("the outer fractions must end with 1, and each layer needs one law")
    reference = 1.0 if mean_radius is None else mean_radius
    require_positive(mass=mass, mean_radius=reference, gravitational_constant=gravitational_constant)
    _check_settings(nodes, harmonics, accuracy)
    edges, owner = cut_tall_layers(edges)
    laws = [laws[number] for number in owner]
    index = laws[-1].surface_index
    powers = [*[1.0] * (len(laws) - 1), surface_power(index) if index > 0 else 1.0]
    if mean_radius is None:
        reference = _radius_of_sphere(edges, powers, laws, mass, gravitational_constant, nodes)
    unit_enthalpy = gravitational_constant * mass / reference
    material = Hydrostatic(laws, mass / reference**3, unit_enthalpy, mean_radius is None)
    rate_unit = math.sqrt(unit_enthalpy) / reference
    rotation = _rotation(small_m, rotation_parameter, angular_velocity, rate_unit, 3 if mean_radius is None else 0)
    solution = _converged(edges, powers, nodes, harmonics, accuracy, rotation, lambda layers: material)
    return figure_of_solution(solution, mass, reference * solution.scale, gravitational_constant, accuracy)


@with_quantities()
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
    angular_velocity; harmonics, nodes and accuracy as for `figure_of_density`. Raises ValueError for bad arguments (for
    n = 0 take `figure_of_density` with one density), NumericalError where no figure is found or it is not that
    accurate. Source: figure_shapes.py; checked by tests/unit/bodies/test_figures.py against spectral ones of n = 1.

    >>> print(f"{figure_of_polytrope(1.0, small_m=0.08).flattening:.4f}")  # nearly Jupiter, 0.065
    0.0612
    """
    if not 0 < index < 5:
        raise ValueError(f"a polytrope of finite radius and density needs an index 0 < n < 5, not {index}")
    surface = lane_emden(index).xi_1 if index > _CONDENSED_INDEX else 0.0
    edges = [xi / surface for xi in _CONDENSED_EDGES if xi < 0.5 * surface]
    if index < _STIFF_INDEX:
        edges = [_STIFF_EDGE]
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
