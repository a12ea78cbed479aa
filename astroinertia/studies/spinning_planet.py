"""A spinning planet of layers: its exact figure, and how far a body of particles is from it.

The figure is in hydrostatic equilibrium on the isentropes of a scene's layers and turns rigidly
(bodies/figures.py); the particles are those of the scene, settled and evolved with the same materials.
Test: tests/physics/test_spinning_planets.py.
"""

import math
from typing import Any, NamedTuple

import jax
import numpy as np

from astroinertia.bodies.figures import figure_of_barotropes
from astroinertia.bodies.rotating_figure import RotatingFigure
from astroinertia.build.materials import materials
from astroinertia.build.planets import planet
from astroinertia.matter.barotropes import CondensedLaw
from astroinertia.matter.interior import isentrope
from astroinertia.process.roots import root_between
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene

_DENSEST = 3.0  # times the density without pressure: how far the laws are tabulated
_NEAR = 0.1  # of the fraction of the radius at which a boundary lies at rest: where it is looked for
_CLOSE = 1e-9  # of the radius


class Shape(NamedTuple):
    """Mean moment over that of the figure, polar moment likewise, and flattening 1 - (Q_zz/Q_xx)^(1/2) of both.

    moment and polar_moment: relative differences; flattening and exact_flattening: of the second moments, which a
    body of particles has without a surface; angular_velocity: L_z/C over the figure's, less 1.
    """

    moment: float
    polar_moment: float
    flattening: float
    exact_flattening: float
    angular_velocity: float


def figure_of_scene(scene: Scene, angular_velocity: float) -> RotatingFigure:
    """The figure of the scene's body of two layers, or one, at a rate of rotation, in its code units.

    ValueError where it has more layers; SceneError and NumericalError as for the planet and the figure.
    """
    fluid: Any = scene.equation_of_state
    with jax.enable_x64(True):
        units = code_units(scene)
        still, matter = planet(scene, units), materials(fluid, scene.origin, units)
        laws = [_law(matter, number, label) for number, label in zip(still.numbers, still.labels, strict=True)]
        boundary = float(still.solution.layer_radii[0] / still.radius)
    if len(laws) > 2:
        raise ValueError(f"the figure of a planet of {len(laws)} layers is not looked for, only of 1 or 2")

    def figure(fraction: float) -> RotatingFigure:
        tops = [fraction, 1.0][2 - len(laws) :]
        return figure_of_barotropes(tops, laws, mass=still.mass, angular_velocity=angular_velocity)

    def excess(fraction: float) -> float:
        # The level surface at the boundary has two nodes, with the same mass inside.
        solution = figure(fraction)
        node = np.argmin(np.abs(solution.radius / solution.mean_radius - fraction))
        return solution.enclosed_mass[node] / solution.mass - float(still.edges[0])

    if len(laws) == 1:
        return figure(1.0)
    return figure(root_between(excess, (1 - _NEAR) * boundary, (1 + _NEAR) * boundary, _CLOSE))


def _law(matter: Any, number: int, label: float) -> CondensedLaw:
    law = isentrope(matter, int(number), float(label))
    lightest = float(law.reference_density)
    return CondensedLaw(law.pressure, lightest, _DENSEST * lightest)


def shape(figure: RotatingFigure, mass: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> Shape:
    """Particles (N,), (N, 3) that turn about z beside the figure of the same units."""
    x = position - mass @ position / mass.sum()
    along, *across = np.diagonal((mass[:, None] * x).T @ x)[[2, 0, 1]]
    polar, momentum = sum(across), mass @ np.cross(x, velocity)
    exact = figure.equatorial_moment - figure.polar_moment / 2
    return Shape(
        moment=2 / 3 * (along + polar) / figure.mean_moment - 1,
        polar_moment=polar / figure.polar_moment - 1,
        flattening=1 - math.sqrt(2 * along / polar),
        exact_flattening=1 - math.sqrt(2 * exact / figure.polar_moment),
        angular_velocity=momentum[2] / polar / figure.angular_velocity - 1,
    )
