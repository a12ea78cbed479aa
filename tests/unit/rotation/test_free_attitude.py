"""Attitude and precession of a free body: against the equations of motion, mpmath and Montgomery's theorem."""

import mpmath as mp
import numpy as np
import pytest

from astroinertia.rotation import free_attitude, free_top
from astroinertia.rotation.attitude import angle_between, cross_matrix, rotation
from tests import exact_top
from tests.unit.rotation.test_free_top import CASES

START = rotation(np.array([0.3, -1.1, 0.8]))
SPECIAL = {
    "sphere": ([2.0, 2.0, 2.0], [1.0, 2.0, 3.0]),
    "oblate": ([2.0, 2.0, 3.0], [0.3, 0.4, -0.5]),
    "prolate": ([1.0, 2.0, 2.0], [0.3, 0.4, -0.5]),
    "rod": ([1.0, 0.0, 1.0], [0.3, 0.4, -0.5]),
    "steady": ([1.0, 2.0, 3.0], [0.0, -0.7, 0.0]),
    "at rest": ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
    "almost steady": ([1.0, 2.0, 3.0], [1e-9, 0.0, 1.0]),
    "next to the separatrix": ([1.0, 2.0, 3.0], [1e-8, 1.0, 1e-8]),
    "separatrix": ([1.0, 1.5, 3.0], [3.0, 0.6, 1.0]),
    "separatrix, backwards": ([1.5, 1.0, 3.0], [0.6, -3.0, -1.0]),
}


@pytest.mark.full
@pytest.mark.parametrize("name", CASES)
def test_any_order_of_moments_at_any_time(name):
    moments, spin = CASES[name]
    top = free_top.free_top(moments, spin)
    np.testing.assert_allclose(free_attitude.attitude(top, 0.0, START), START, rtol=0, atol=1e-15)
    for time in (-7.0, 0.3, 40.0, 123456.7):
        expected = exact_top.floats(exact_top.motion(moments, spin, time))[1] @ START
        np.testing.assert_allclose(free_attitude.attitude(top, time, START), expected, rtol=0, atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPECIAL)
def test_special_bodies_and_motions_follow_the_equations_of_motion(name):
    moments, spin = SPECIAL[name]
    scaled = [max(moment, 1e-30) for moment in moments]  # a rod: the series divides by its moment, by which 0 is meant
    found = free_attitude.attitude(free_top.free_top(moments, spin), 0.8)
    expected = exact_top.floats(exact_top.taylor_motion(scaled, spin, 0.8, 20))[1]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["about the least", "about the greatest", "descending"])
def test_the_space_frame_angular_momentum_never_moves(name):
    moments, spin = CASES[name]
    top = free_top.free_top(moments, spin)
    times = np.linspace(0, 1e6, 4001) * free_top.period(top)
    body = np.array(moments) * free_top.angular_velocity(top, times)
    attitude = free_attitude.attitude(top, times, START)
    space = (np.swapaxes(attitude, -1, -2) @ body[..., None])[..., 0]
    size = float(top.angular_momentum)
    np.testing.assert_allclose(space / size, np.tile(START.T @ body[0], (4001, 1)) / size, rtol=0, atol=1.5e-15)
    np.testing.assert_allclose(attitude @ np.swapaxes(attitude, -1, -2), np.tile(np.eye(3), (4001, 1, 1)), atol=1.5e-15)


@pytest.mark.parametrize("name", ["about the least", "about the greatest", "middle last"])
def test_a_period_turns_the_body_about_its_angular_momentum_by_montgomerys_phase(name):
    moments, spin = CASES[name]
    top = free_top.free_top(moments, spin)
    period = free_top.period(top)
    turned = free_attitude.attitude(top, period)
    angle = free_attitude.precession_per_period(top)
    momentum = np.array(moments) * spin
    about = momentum / np.linalg.norm(momentum)
    assert angle_between(turned, rotation(angle * about).T) < 1e-14
    # 2 T period/L less the solid angle that L encloses in the body, by quadrature of d(azimuth)(1 - cos)
    times = period * np.arange(400) / 400
    direction = np.array(moments) * free_top.angular_velocity(top, times) @ top.frame.T / float(top.angular_momentum)
    rate = np.array([float(each) for each in top.ordered])
    omega = direction * float(top.angular_momentum) / rate
    flow = np.cross(direction, omega)
    across = direction[:, 0] ** 2 + direction[:, 1] ** 2
    azimuth = (direction[:, 0] * flow[:, 1] - direction[:, 1] * flow[:, 0]) / across
    pole = np.sign(direction[0, 2])
    solid = period * (azimuth * (1 - pole * direction[:, 2])).mean() * pole
    expected = 2 * top.energy * period / float(top.angular_momentum) - solid
    assert np.remainder(angle - expected + np.pi, 2 * np.pi) - np.pi == pytest.approx(0.0, abs=1e-12)


def test_rates_of_precession():
    oblate = free_top.free_top(*SPECIAL["oblate"])
    assert free_attitude.precession_rate(oblate) == pytest.approx(float(oblate.angular_momentum) / 2.0, rel=1e-15)
    on = free_top.free_top(*SPECIAL["separatrix"])
    assert free_attitude.precession_rate(on) == pytest.approx(float(on.angular_momentum) / 1.5, rel=1e-15)
    assert np.isnan(free_attitude.precession_rate(free_top.free_top(*SPECIAL["steady"])))
    assert np.isnan(free_attitude.precession_per_period(on))
    for moments, spin in (CASES["about the least"], CASES["about the greatest"], CASES["middle first"]):
        top = free_top.free_top(moments, spin)
        a, b, _ = (mp.mpf(float(each)) for each in top.ordered)
        p, q = (mp.mpf(float(each)) for each in top.amplitudes[:2])
        m, whole = mp.mpf(str(top.modulus.square)), mp.mpf(str(top.modulus.quarter))

        def rate(u, m=m, a=a, b=b, p=p, q=q):
            cosine, sine = (p * mp.ellipfun("cn", u, m=m)) ** 2, (q * mp.ellipfun("sn", u, m=m)) ** 2
            return (a * cosine + b * sine) / (a * a * cosine + b * b * sine)

        mean = mp.quad(rate, [0, whole]) / whole * mp.mpf(str(top.angular_momentum))
        assert free_attitude.precession_rate(top) == pytest.approx(float(mean), rel=2e-15)


@pytest.mark.parametrize("moments", [[1.3, 2.1, 2.9], [2.0, 2.0, 2.0], [0.0, 2.0, 2.0], [1.0, 2.0, 2.0]])
def test_a_tensor_in_any_axes_turns_with_its_body(moments):
    inertia = START @ np.diag(moments) @ START.T
    spin = np.array([0.4, -0.3, 0.9])
    times = np.array([[0.0, 1e-4], [7.0, 1e5]])
    found = free_attitude.free_motion(inertia, spin, times)
    assert found.inertia.shape == (2, 2, 3, 3)
    np.testing.assert_allclose(found.angular_velocity[0, 0], spin, atol=1e-15)
    np.testing.assert_allclose(found.inertia[0, 0], inertia, atol=3e-15)
    momentum = (found.inertia @ found.angular_velocity[..., None])[..., 0]
    np.testing.assert_allclose(momentum, np.tile(inertia @ spin, (2, 2, 1)), rtol=0, atol=1e-14)
    # dI/dt = omega x I - I x omega of a tensor that turns with angular velocity omega
    turn = cross_matrix(spin)
    rate = (found.inertia[0, 1] - found.inertia[0, 0]) / 1e-4
    np.testing.assert_allclose(rate, turn @ inertia - inertia @ turn, atol=5e-4)


@pytest.mark.parametrize("start", [2.0 * np.eye(3), np.diag([2.0, 1.0, 1.0]), np.diag([1.0, 1.0, -1.0])])
def test_a_start_that_is_no_rotation_is_refused(start):
    for motion in ([0.1, 0.0, 1.0], [0.0, 0.0, 1.0]):
        with pytest.raises(ValueError, match="a rotation matrix must"):
            free_attitude.attitude(free_attitude.free_top([1, 2, 4], motion), 1.0, start)


def test_a_tensor_that_no_body_has_is_refused():
    with pytest.raises(ValueError, match="no body has these moments"):
        free_attitude.free_motion(np.diag([1.0, 1.0, 3.0]), [0.0, 0.0, 1.0], 0.0)
