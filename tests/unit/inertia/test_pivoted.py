"""Pendulums against the equation of motion, Kater's gravity from periods, and a blow against free rigid motion."""

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.inertia import pivoted, shapes

BODY = shapes.box(2.0, 0.3, 0.2, 1.1) + shapes.solid_sphere(1.0, 0.2).translated((0.1, 0.05, -0.6))
PIVOT, AXIS = np.array([0.05, 0.0, 0.4]), np.array([0.3, 1.0, 0.0])
GRAVITY = 3.7


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [0.01, 1.2, 3.0])
def test_the_period_is_that_of_the_equation_of_motion(amplitude):
    length = pivoted.pendulum_length(BODY, PIVOT, AXIS)
    period = pivoted.pendulum_period(BODY, PIVOT, AXIS, amplitude, GRAVITY)

    def rate(_, state):
        return [state[1], -GRAVITY / length * np.sin(state[0])]

    quarter = solve_ivp(
        rate, (0, 10 * period), [amplitude, 0.0], rtol=1e-12, atol=1e-14, events=lambda _, state: state[0]
    ).t_events[0][0]
    assert period == pytest.approx(4 * quarter, rel=1e-9)


def test_the_length_counts_the_distance_from_the_axle_alone():
    along = PIVOT + 0.7 * AXIS
    assert pivoted.pendulum_length(BODY, along, 3 * AXIS) == pytest.approx(
        pivoted.pendulum_length(BODY, PIVOT, AXIS), rel=1e-13
    )


def test_the_body_swings_alike_about_its_centre_of_oscillation():
    unit = AXIS / np.linalg.norm(AXIS)
    arm = BODY.centre - PIVOT
    down = arm - (arm @ unit) * unit
    other = PIVOT + pivoted.pendulum_length(BODY, PIVOT, AXIS) * down / np.linalg.norm(down)
    periods = [pivoted.pendulum_period(BODY, place, AXIS, 0.8) for place in (PIVOT, other)]
    assert periods[0] == pytest.approx(periods[1], rel=1e-13)


def test_gravity_comes_out_of_two_periods_whatever_the_pendulum():
    edges = (np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, -0.9]))
    bar = shapes.rod(1.0, 2.0) + shapes.point(0.4, (0.0, 0.0, -0.3))
    periods = [pivoted.pendulum_period(bar, edge, gravity=GRAVITY) for edge in edges]
    arms = [abs(bar.centre[2] - edge[2]) for edge in edges]
    assert pivoted.kater_gravity(*periods, *arms) == pytest.approx(GRAVITY, rel=1e-12)
    assert np.isnan(pivoted.kater_gravity(2.0, 2.1, 0.5, 0.5))


@pytest.mark.parametrize("reach", [0.0, 0.4, 1.5])
def test_the_axle_gives_what_the_free_body_would_not(reach):
    """Struck by 1 at `reach` below the axle, and by R at the axle, a free body leaves the axle at rest."""
    axis = np.array([0.0, 1.0, 0.0])
    pivot = BODY.centre + np.array([0.0, 0.0, 0.8])  # the centre of mass is straight below
    reaction = float(pivoted.pivot_impulse(BODY, pivot, reach, axis))
    drift = (1 + reaction) / BODY.mass
    # About the centre of mass, with the blow along x: the torque along y of a force F at height z is z F.
    spin = (0.8 * reaction + (0.8 - reach)) / BODY.moment(axis)
    assert drift + 0.8 * spin == pytest.approx(0.0, abs=1e-14)


@pytest.mark.full
def test_periods_have_gradients():
    slope = jax.grad(lambda height: pivoted.pendulum_period(BODY, np.array([0.05, 0.0, 1.0]) * height, AXIS))(0.4)
    beside = [pivoted.pendulum_period(BODY, np.array([0.05, 0.0, 1.0]) * height, AXIS) for height in (0.399, 0.401)]
    assert float(slope) == pytest.approx((beside[1] - beside[0]) / 0.002, rel=1e-3)


@pytest.mark.parametrize("amplitude", [np.pi, -3.2, np.nan])
def test_amplitudes_beyond_the_top_are_refused_by_name(amplitude):
    with pytest.raises(ValueError, match="amplitude must be below pi"):
        pivoted.pendulum_period(BODY, PIVOT, AXIS, amplitude)


def test_nothing_swings_about_its_centre_of_mass():
    assert pivoted.pendulum_length(shapes.rod(1.0, 2.0), np.zeros(3)) == np.inf
