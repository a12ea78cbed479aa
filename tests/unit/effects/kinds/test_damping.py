"""Damping of a body's motion: decay times, rigid rotation in the end, and rates that change."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.effects import catalogue
from astroinertia.inertia.tensor import axial_vector
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of


def test_damping_takes_the_motion_within_the_body_and_leaves_that_of_its_centre() -> None:
    position, random = ball(60), np.random.default_rng(2)
    velocity = random.normal(loc=(3.0, 0.0, 0.0), size=position.shape)
    damping = catalogue.build("damping", {"time_scale": 0.5, "until": 1.0})
    problem, state, arrangement = state_of(damping, position=position, velocity=velocity)
    mean = state.velocity.mean(axis=0)
    inner = np.abs(state.velocity - mean).max()
    for _ in range(100):
        state = step(problem, arrangement, state, np.float64(0.01))
    assert np.allclose(state.velocity.mean(axis=0), mean, rtol=1e-13)
    assert math.isclose(np.abs(state.velocity - mean).max() / inner, math.exp(-2.0), rel_tol=1e-2)
    velocity = state.velocity
    for _ in range(10):
        state = step(problem, arrangement, state, np.float64(0.01))
    assert np.allclose(state.velocity, velocity, rtol=0.02)
    for _ in range(10):
        earlier, state = state.velocity, step(problem, arrangement, state, np.float64(0.01))
    assert np.array_equal(state.velocity, earlier)


def test_damping_towards_rotation_ends_in_rigid_rotation() -> None:
    position = ball(60)
    damping = catalogue.build("damping", {"time_scale": 0.01, "rate": 0.05, "axis": (0.0, 3.0, 0.0)})
    problem, state, arrangement = state_of(damping, position=position, velocity=np.zeros_like(position))
    for _ in range(40):
        state = step(problem, arrangement, state, np.float64(0.01))
    relative = state.position - state.position.mean(axis=0)
    assert np.allclose(state.velocity, np.cross([0.0, 0.05, 0.0], relative), atol=1e-4)
    assert np.abs(state.velocity).max() > 0.04


@pytest.mark.slow
def test_damping_towards_a_rate_that_changes_turns_each_particle_as_its_equation_says() -> None:
    """Second order in the step towards x'' = (Omega(t) x x - x')/tau, and the torque in the ledger is what L gains."""
    position, rate, change, tau, end = ball(60), 0.3, 0.8, 0.4, 1.0
    position -= position.mean(axis=0)
    options = {"time_scale": tau, "rate": rate, "rate_change": change}
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])

    def rates(time: float, packed: np.ndarray) -> np.ndarray:
        x, v = packed.reshape(2, -1, 3)
        return np.concatenate([v, ((rate + change * time) * x @ turn.T - v) / tau]).ravel()

    start = np.concatenate([position, 0.0 * position]).ravel()
    exact = solve_ivp(rates, (0.0, end), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1].reshape(2, -1, 3)

    def final(steps: int) -> Any:
        problem, state, arrangement = state_of(
            catalogue.build("damping", options), position=position, velocity=np.zeros_like(position)
        )
        for _ in range(steps):
            state = step(problem, arrangement, state, np.float64(end / steps))
        return state

    states = [final(steps) for steps in (20, 40, 80)]
    errors = [float(np.abs(state.velocity - exact[1][state.identity]).max()) for state in states]
    assert all(3.8 < a / b < 4.2 for a, b in itertools.pairwise(errors)), errors
    gained = np.cross(states[-1].position, states[-1].velocity).mean(axis=0)
    assert gained[2] > 0.1
    assert np.allclose(axial_vector(states[-1].ledger.mixed_impulse.total[0]), gained, rtol=1e-12, atol=1e-15)
