"""How the fluid of a scene moves at first: a collapse of its own, a gradient and a rotation, in code units."""

import math

import numpy as np
import pytest

from astroinertia.build.flow import initial_velocity
from astroinertia.build.placing import particles
from astroinertia.build.sph import problem_of
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units

G, MASS, RADIUS = 6.6743e-11, 2.6e30, 1.5e6
CORE = """
name = "core"
[units]
mass = "1e30 kg"
length = "1000 km"
[body]
kind = "homologous_core"
collapse_rate = 1.0
particles = 100
mass = "2.6e30 kg"
radius = "1500 km"
relax = false
velocity_gradient = [["0 1/s", "-3 1/s", "0 1/s"], ["3 1/s", "0 1/s", "0 1/s"], ["0 1/s", "0 1/s", "0.5 1/s"]]
rotation = { rate = "2 rad/s", axis = [1, 0, 0] }
[equation_of_state]
kind = "ideal"
gamma = 1.3333333333333333
[effects.gravity]
[effects.pressure]
[time]
end = "1 ms"
"""


def test_a_collapse_a_gradient_and_a_rotation_of_the_scene_add_up() -> None:
    """At the critical rate the surface falls freely, and all in proportion: at (2 G M/R^3)^(1/2) r on a parabola."""
    scene = loads(CORE)
    units = code_units(scene)
    _, initial = problem_of(scene, units)
    at = np.random.default_rng(2).normal(0.0, 5e5, (7, 3))  # m
    found = initial_velocity(scene, units, initial, np.ones(7), units.to_code(at, "length"))
    infall = -math.sqrt(2.0 * G * MASS / RADIUS**3)
    gradient = np.array([[infall, -3.0, 0.0], [3.0, infall, -2.0], [0.0, 2.0, infall + 0.5]])
    np.testing.assert_allclose(units.to_si(found, "velocity"), at @ gradient.T, rtol=1e-8)


def test_an_ellipsoid_turns_with_its_share_of_the_energy_that_binds_it() -> None:
    """That of a spheroid of one density, -(3/5) G M^2 arcsin(e)/(a e), not of the sphere it was."""
    shape = CORE[CORE.index("kind") : CORE.index("[equation")]
    flat = """kind = "uniform"
particles = 400
mass = "2.6e30 kg"
radius = "1500 km"
axes = [1.25, 1.25, 0.64]
relax = false
specific_internal_energy = "1e12 J/kg"
rotation = { t_over_w = 0.1 }
"""
    scene = loads(CORE.replace(shape, flat))
    units = code_units(scene)
    problem, initial = problem_of(scene, units)
    body = particles(scene, units, initial, problem)
    e, a = math.sqrt(1.0 - (0.64 / 1.25) ** 2), 1.25 * RADIUS
    binding = units.to_code(0.6 * G * MASS**2 * math.asin(e) / (a * e), "energy")
    assert 0.5 * body.mass @ (body.velocity**2).sum(axis=1) == pytest.approx(0.1 * binding, rel=1e-9)
