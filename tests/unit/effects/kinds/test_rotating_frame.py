"""Coriolis and centrifugal forces against motions in the inertial frame."""

import itertools
import math

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of
from tests.unit.points import at


def test_the_coriolis_force_does_no_work_in_a_step() -> None:
    """In a frame whose centrifugal force is taken away, |v| of every particle stays to round-off."""
    position, random = ball(60), np.random.default_rng(0)
    frame = catalogue.build("rotating_frame", {"rate": 0.7, "axis": (1.0, -2.0, 0.5)})
    rotation = frame.frame_rotation(at(position))
    remove = catalogue.build("external_field", {"quadratic": tuple(map(tuple, -rotation @ rotation))})
    problem, state, arrangement = state_of(
        frame, remove, position=position, velocity=random.normal(size=position.shape)
    )
    before = np.linalg.norm(state.velocity, axis=1)
    for _ in range(50):
        state = step(problem, arrangement, state, np.float64(0.1))
    assert np.abs(np.linalg.norm(state.velocity, axis=1) / before - 1).max() < 1e-14
    work = np.asarray(state.ledger.work.total)
    assert abs(work.sum()) < 1e-15
    assert np.abs(state.velocity).max() > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("rate_change", [None, -0.15])
def test_a_free_particle_in_a_rotating_frame_runs_straight_in_the_inertial_one(rate_change: float | None) -> None:
    """Second order in the step towards x0 + t u seen from the turning frame, with and without spin-up."""
    axis, rate = np.array([2.0, 1.0, -2.0]) / 3.0, 0.6
    frame = catalogue.build("rotating_frame", {"rate": rate, "rate_change": rate_change, "axis": tuple(axis)})
    start, speed = ball(60), np.random.default_rng(1).normal(size=(len(ball(60)), 3))
    velocity = speed - np.cross(rate * axis, start)

    def error(steps: int) -> float:
        problem, state, arrangement = state_of(frame, position=start, velocity=velocity)
        for _ in range(steps):
            state = step(problem, arrangement, state, np.float64(2.0 / steps))
        angle = rate * 2.0 + 0.5 * (rate_change or 0.0) * 4.0
        straight = start + 2.0 * speed
        turned = (
            straight * math.cos(angle)
            - np.cross(axis, straight) * math.sin(angle)
            + np.outer(straight @ axis, axis) * (1 - math.cos(angle))
        )
        return float(np.abs(state.position - turned).max())

    errors = [error(steps) for steps in (16, 32, 64)]
    assert errors[-1] < 1e-3
    assert all(3.8 < a / b < 4.2 for a, b in itertools.pairwise(errors)), errors


def test_a_body_at_rest_in_the_inertial_frame_turns_backwards_on_a_circle() -> None:
    """Centrifugal and Coriolis together give the centripetal acceleration of the turning -Omega that is seen."""
    frame = catalogue.build("rotating_frame", {"rate": 1.3})
    position = ball(60)
    fluid = at(position, -np.cross([0.0, 0.0, 1.3], position))
    total = frame.acceleration(np, fluid) + fluid.velocity @ frame.drag(fluid).T
    assert np.allclose(total, -(1.3**2) * position * (1.0, 1.0, 0.0), atol=1e-15)


@pytest.mark.parametrize("kind", ["viscosity", "conduction"])
@pytest.mark.parametrize("limiter", ["balsara", "reconstruction", "guarded_reconstruction"])
def test_limiters_see_the_vorticity_that_the_frame_hides(kind: str, limiter: str) -> None:
    """What is dissipated is the same to round-off in inertial axes and in axes that turn, where the flow turns less."""
    position, random = ball(60), np.random.default_rng(2)
    turn = np.cross((0.2, -0.3, 0.9), position)
    velocity = turn - 0.2 * position + 0.05 * random.normal(size=position.shape)
    options = {"viscosity": {"switch": "none", "limiter": limiter}, "conduction": {"limiter": "shear"}}
    frame = catalogue.build("rotating_frame", {"rate": math.sqrt(0.94), "axis": (0.2, -0.3, 0.9)})
    entropy = random.uniform(0.4, 0.6, len(position))
    heating = []
    for further, seen in (((), velocity), ((frame,), velocity - turn)):
        listed = (*further, *(catalogue.build(*item) for item in options.items()))
        _, state, _ = state_of(*listed, position=position, velocity=seen, entropy=entropy)
        heating.append(state.rates.fluid.sums[kind]["heating"])
    assert np.abs(heating[0] - heating[1]).max() < 1e-12 * np.abs(heating[0]).max()
