"""How fast a tumbling moon's motions come apart: against two motions themselves, regular ones, and published times."""

import numpy as np
import pytest

from astroinertia.rotation.attitude import attitude_of_euler_angles, rotation
from astroinertia.rotation.tumbling import divergence

HYPERION = np.array([133.0**2 + 102.7**2, 180.1**2 + 102.7**2, 180.1**2 + 133.0**2])  # Thomas 2010, semi-axes in km


@pytest.mark.full
def test_growth_is_that_of_two_motions():
    attitude, spin, small = attitude_of_euler_angles(np.array([0.3, 0.5, 0.2])), np.array([0.1, 0.2, 1.1]), 1e-7
    one = divergence(HYPERION, 0.123, attitude, spin, orbits=6)
    others = [divergence(HYPERION, 0.123, attitude @ rotation(small * turn), spin, orbits=6) for turn in np.eye(3)]
    apart = max(np.linalg.norm(each.angular_velocity - one.angular_velocity) for each in others) / small
    assert np.log(apart) == pytest.approx(one.growth[-1], abs=2.0) and one.growth[-1] > 3


@pytest.mark.slow
def test_a_round_moon_and_one_on_a_circle_do_not_come_apart():
    attitude, spin = np.eye(3), np.array([0.0, 0.0, 1.0])
    free = divergence([1.0, 1.0, 1.0], 0.1, attitude, [0.3, 0.2, 1.0], orbits=60)
    assert free.growth[-1] < 8 and free.lyapunov_time > 100  # as the time, not as its exponential
    np.testing.assert_allclose(free.angular_velocity, [0.3, 0.2, 1.0], atol=1e-9)
    # Synchronous on a circle, long axis towards the primary: the spin stays.
    held = divergence([0.9, 0.95, 1.0], 0.0, attitude, spin, orbits=60)
    np.testing.assert_allclose(held.angular_velocity, spin, atol=1e-9)
    assert held.growth[-1] < 8


@pytest.mark.slow
def test_hyperion():
    """Wisdom, Peale & Mignard 1984: attitude instability within a few orbits (21.3 d); units come out as they go in."""
    days, motion = 2 * np.pi / 21.2766, 1.0
    attitude = attitude_of_euler_angles(np.array([0.0, 1e-3, 0.6]))
    found = divergence(HYPERION, 0.123, attitude, [0.0, 0.0, days], days, orbits=100)
    assert 15 < found.lyapunov_time < 60
    unit = divergence(HYPERION, 0.123, attitude, [0.0, 0.0, motion], motion, orbits=10)
    np.testing.assert_allclose(unit.growth[:3], found.growth[:3], atol=1e-6)


def test_what_is_no_tumbling_moon_is_refused():
    for moments, e, orbits, message in (
        ([1.0, 1.0, 3.0], 0.1, 5, "three moments"), ([1.0, 1.0, 1.0], 1.0, 5, "tumbling"),
        ([1.0, 1.0, 1.0], 0.1, 1, "tumbling"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=message):
            divergence(moments, e, np.eye(3), [0.0, 0.0, 1.0], orbits=orbits)
