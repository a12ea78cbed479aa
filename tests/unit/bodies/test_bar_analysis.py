"""Bars of moving ellipsoids: the figures whose rates are known, turned any way, and growth that was put in."""

import math

import numpy as np
import pytest

from astroinertia.bodies import jacobi, maclaurin, riemann
from astroinertia.bodies.bar_analysis import bar, bar_history, growth_rate
from astroinertia.inertia.tensor import mixed_moment

SCALE = {"mass": 2.0, "mean_radius": 3.0, "gravitational_constant": 0.5}


def _history(body, times, turn=None, **more):
    moved = [body.deformation(time) for time in times], [body.deformation_rate(time) for time in times]
    if turn is not None:
        moved = [[turn @ each @ turn.T for each in part] for part in moved]
    return bar_history(*moved, body.mass, body.mean_radius, body.gravitational_constant, **more)


@pytest.mark.parametrize("f", [-7.0, -2.0, -0.4, 0.0, 1.0, math.inf])
def test_a_riemann_ellipsoid_is_recognized_at_any_phase(f):
    body = riemann.from_vorticity_ratio(0.6, f, **SCALE)
    times = np.array([0.0, 1.7, 30.0])
    seen = _history(body, times)
    unit = math.sqrt(math.pi * body.gravitational_constant * body.density)
    np.testing.assert_allclose(seen.bar_strength, (1 - 0.36) / (1 + 0.36), rtol=1e-13)
    np.testing.assert_allclose(seen.pattern_speed, body.angular_velocity, atol=1e-13 * unit)
    np.testing.assert_allclose(seen.internal_rate, body.internal_angular_velocity, atol=1e-13 * unit)
    turned = (seen.bar_phase - body.angular_velocity * times + 1e-9) % math.pi
    np.testing.assert_allclose(turned, 1e-9, atol=1e-12)
    np.testing.assert_allclose(np.sort(seen.axes[0]), np.sort(body.axes), rtol=1e-14)
    np.testing.assert_allclose(seen.angular_momentum[:, 2], body.angular_momentum, rtol=1e-12)
    flow = body.mass / (5 * math.pi) * body.circulation
    np.testing.assert_allclose(seen.circulation[:, 2], flow, atol=1e-13 * abs(body.angular_momentum))
    np.testing.assert_allclose(seen.rotational_to_gravitational, body.rotational_to_gravitational, rtol=1e-13)
    if math.isfinite(f):
        np.testing.assert_allclose(seen.vorticity_ratio, f, atol=1e-11)


def test_any_axis_will_do():
    """The same body about another axis, and the history of one time without leading dimensions."""
    body = riemann.from_vorticity_ratio(0.6, -1.0, **SCALE)
    axis = np.array([1.0, -2.0, 0.5])
    pole = axis / np.linalg.norm(axis)
    first = np.cross(pole, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(pole, [0.0, 0.0, 1.0]))
    turn = np.stack([first, np.cross(pole, first), pole], axis=1)
    seen = _history(body, [0.3, 2.0], turn, axis=axis)
    np.testing.assert_allclose(seen.pattern_speed, body.angular_velocity, rtol=1e-12)
    np.testing.assert_allclose(seen.internal_rate, body.internal_angular_velocity, rtol=1e-12)
    np.testing.assert_allclose(seen.angular_momentum @ pole, body.angular_momentum, rtol=1e-12)
    single = bar_history(body.deformation(), body.deformation_rate())
    assert single.axes.shape == (3,) and single.bar_strength.shape == single.past_pear.shape == ()


def test_moments_of_any_body_tell_its_bar():
    """Of particles on a sphere that move as x = F X, and of the tensors that a dataset keeps."""
    body = riemann.from_vorticity_ratio(0.5, -1.5, **SCALE)
    matrix, rate = body.deformation(1.2), body.deformation_rate(1.2)
    corners = body.mean_radius * math.sqrt(3 / 5) * np.concatenate([np.eye(3), -np.eye(3)])  # Q = M R^2/5
    mass = np.full(6, body.mass / 6)
    position, velocity = corners @ matrix.T, corners @ rate.T
    strength, phase, pattern = bar(*(mixed_moment(mass, position, other) for other in (position, velocity)))
    whole = _history(body, [1.2])
    assert strength == pytest.approx(whole.bar_strength[0], rel=1e-13)
    assert phase == pytest.approx(whole.bar_phase[0], abs=1e-13)
    assert pattern == pytest.approx(body.angular_velocity, rel=1e-12)


def test_round_bodies_have_no_bar():
    body = maclaurin.from_eccentricity(0.5)
    shape = np.diag(body.axes)
    seen = bar_history(shape, np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]) @ shape)
    assert seen.bar_strength == 0 and np.isnan(seen.pattern_speed) and np.isnan(seen.internal_rate)
    nearly = np.diag([1.0, 1.0 + 4e-16, 0.8])  # as particles sum it up
    strength, _, pattern = bar(nearly, np.array([[0.0, 0.2, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    assert 0 < strength < 1e-15 and np.isnan(pattern)


def test_fission_begins_with_the_pear():
    pear = jacobi.pear_bifurcation().b_over_a
    for ratio, past in ((pear * 1.001, False), (pear * 0.999, True)):
        body = riemann.from_vorticity_ratio(ratio, 0.0)
        assert bool(_history(body, [0.0]).past_pear[0]) is past


def test_growth_is_measured_between_two_strengths():
    times = np.linspace(0, 20, 400)
    strength = np.minimum(1e-6 * np.cosh(0.9 * times), 0.3)  # decays, grows, saturates
    assert growth_rate(times, strength, 1e-4, 0.1) == pytest.approx(0.9, rel=1e-3)
    with pytest.raises(ValueError, match="needs 3"):
        growth_rate(times, strength, 0.2, 0.21)
    for low, high in ((np.nan, 0.1), (1e-4, np.nan), (0.1, 1e-4), (-1e-4, 0.1)):
        with pytest.raises(ValueError, match="grows from a low strength above 0 to a higher one"):
            growth_rate(times, strength, low, high)
    with pytest.raises(ValueError, match="do not go with times"):
        growth_rate(times[1:], strength, 1e-4, 0.1)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match=r"\(\.\.\., 3, 3\)"):
        bar_history(np.eye(2), np.eye(2))
    for wrong in ((np.nan * np.eye(3), np.eye(3)), (np.eye(3), np.full((3, 3), np.inf))):
        with pytest.raises(ValueError, match="F and dF/dt must be finite"):
            bar_history(*wrong)
    with pytest.raises(ValueError, match="three finite numbers"):
        bar_history(np.eye(3), np.eye(3), axis=[0.0, 0.0, 0.0])
