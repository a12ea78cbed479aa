"""Librations against the motion itself, linearised or integrated, and against what was measured."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.rotation import libration


@pytest.mark.parametrize(("p", "e", "size"), [(1.5, 0.20563, 0.0256), (1.0, 0.0047, 0.2), (1.0, 0.01, 1.3)])
def test_the_forced_swing_is_that_of_the_pendulum(p, e, size):
    """From where the formula has it, the swing repeats itself orbit after orbit, but for terms of higher order."""
    amplitude = libration.forced_libration(p, e, size)

    def rate(anomaly, state):
        eccentric = anomaly
        for _ in range(8):
            eccentric -= (eccentric - e * np.sin(eccentric) - anomaly) / (1 - e * np.cos(eccentric))
        r = 1 - e * np.cos(eccentric)
        f = np.arctan2(np.sqrt(1 - e * e) * np.sin(eccentric), np.cos(eccentric) - e)
        return [state[1], -0.5 * size**2 / r**3 * np.sin(2 * (state[0] + p * anomaly - f))]

    at = 2 * np.pi * np.arange(0, 400) / 100
    found = solve_ivp(rate, (0, at[-1]), [0, amplitude], t_eval=at, rtol=1e-9, atol=1e-13).y[0]
    slow = np.linalg.lstsq(np.column_stack([np.sin(at), np.cos(at), np.ones_like(at), at, at**3]), found)[0]
    assert slow[0] == pytest.approx(amplitude, rel=0.03)


def test_what_was_measured():
    # Mercury 38.5 +- 1.6 arcsec with (B - A)/C_m of 2.18e-4 (Margot et al. 2012, JGR 117, E00L09).
    mercury = libration.forced_libration(1.5, 0.20563, np.sqrt(3 * 2.18e-4))
    assert np.degrees(mercury) * 3600 == pytest.approx(38.5, abs=0.3)
    # Phobos 1.09 +- 0.01 deg with (B - A)/C of 0.1291 (Oberst et al. 2014, Planet. Space Sci. 102, 45), e = 0.0151.
    assert np.degrees(libration.forced_libration(1.0, 0.0151, np.sqrt(3 * 0.129))) == pytest.approx(-1.09, abs=0.03)
    with pytest.raises(ValueError, match="does not hold"):
        libration.forced_libration(1.5, 0.0, 0.1)


@pytest.mark.parametrize("moments", [(2.0, 3.0, 1.5), (3.0, 2.0, 1.5), (1.0, 1.2, 2.0), (1.7, 1.2, 1.5)])
def test_free_swings_are_those_of_the_linearised_motion(moments):
    """Euler's equations with the torque 3 n^2 c x I c of the vertical c, in a frame that goes round with n = 1."""
    inertia = np.diag(moments)

    def turning(state):
        x, v = state[:3], state[3:]
        cross = np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
        frame = (np.eye(3) + cross + 0.5 * cross @ cross).T  # from the orbit's axes to the body's
        omega = v + frame @ [0, -1.0, 0]  # of the body among the stars, to first order in small angles
        torque = 3 * np.cross(frame[:, 2], inertia @ frame[:, 2])
        spin = np.linalg.solve(inertia, torque - np.cross(omega, inertia @ omega))
        return np.r_[v, spin - np.cross(frame @ [0, -1.0, 0], v)]

    step = 1e-6 * np.eye(6)
    matrix = np.array([(turning(each) - turning(-each)) / 2e-6 for each in step]).T
    expected = np.linalg.eigvals(matrix)
    found = libration.free_librations(moments, 1.0)
    for frequency in (found.pitch, *found.roll_yaw):
        assert min(abs(expected - 1j * frequency)) < 1e-6
        assert frequency.imag <= 0


@pytest.mark.parametrize(("roll", "yaw"), [(1e-3, 3e-3), (1e-7, 2e-7), (1e-12, 3e-12)])
def test_nearly_round_bodies_swing_slowly_in_roll_and_yaw(roll, yaw):
    """To first order in the differences the slow one of the two is 2 (k_1 k_3)^(1/2) n, and the other n."""
    pitch, rolling, yawing = 1.0, 1.0 - roll, 1.0 - yaw
    slow, fast = libration.free_librations([rolling, pitch, yawing], 1.0).roll_yaw
    expected = 2 * np.sqrt((pitch - yawing) * (pitch - rolling))
    assert slow.real == pytest.approx(expected, rel=3 * yaw + 1e-12, abs=0.0)
    assert fast.real == pytest.approx(1.0, rel=3 * yaw)
    assert libration.free_librations([3.0, 3.0, 4.0], 1.0).roll_yaw.tolist() == [0.0, 0.0]
