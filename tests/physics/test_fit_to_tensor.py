"""The free parameters of a scene are fitted to a wanted inertia tensor by gradients through its steps."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.inertia import realise
from astroinertia.inertia.tensor import inertia_tensor
from astroinertia.models.sph.step import advance
from tests.evolve import prepared

SCENE = """
name = "free"
units = "code"
[body]
kind = "uniform"
particles = 40
mass = 1.0
radius = 1.0
placement = "random"
relax = false
specific_internal_energy = 0.5
[equation_of_state]
kind = "ideal"
[effects.pressure]
[numerics]
max_timestep = 0.02
smoothing_tolerance = 1e-13
[time]
end = 1.0
"""
STEPS = 5
WANTED = np.array([[0.38, 0.02, -0.01], [0.02, 0.42, 0.03], [-0.01, 0.03, 0.35]])


def after_some_steps(start, gradient):
    """The tensor of a body that starts with this velocity gradient, symmetric, given by its six elements."""
    xx, yy, zz, xy, xz, yz = gradient
    matrix = start.problem.engine.xp.asarray([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    state = replace(start.state, velocity=start.state.position @ matrix)
    state = advance(start.problem, start.arrangement, state, STEPS)
    return inertia_tensor(state.mass, state.position)


@pytest.mark.full
def test_the_first_velocities_that_lead_to_a_tensor_are_found() -> None:
    """With the xla engine and its derivatives; what is found is judged with the other engine."""
    with jax.enable_x64(True):
        start = prepared(SCENE, "numerics.engine=xla")
        found = realise.fit_to_tensor(lambda gradient: after_some_steps(start, gradient), jnp.zeros(6), WANTED)
    assert found.misfit < 1e-12
    assert found.evaluations < 15
    other = prepared(SCENE)
    assert np.linalg.norm(after_some_steps(other, found.parameters) - WANTED) < 1e-9 * np.linalg.norm(WANTED)
    untouched = after_some_steps(other, np.zeros(6))
    assert np.linalg.norm(untouched - WANTED) > 0.05 * np.linalg.norm(WANTED)
