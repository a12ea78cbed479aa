"""Polhodes and herpolhodes, the separatrix and flips, against the motion itself."""

import numpy as np
import pytest
from scipy.optimize import brentq

from astroinertia.rotation import free_top, polhodes
from tests.unit.rotation.test_free_top import CASES

RACKET = free_top.free_top([1.0, 2.0, 3.0], [1e-3, 1.0, 1e-3])
ON = free_top.free_top([1.0, 1.5, 3.0], [3.0, 0.6, 1.0])


@pytest.mark.parametrize("name", [*CASES, "separatrix"])
def test_the_polhode_is_where_the_angular_velocity_runs(name):
    top = ON if name == "separatrix" else free_top.free_top(*CASES[name])
    curve = polhodes.polhode(top, 20001)
    np.testing.assert_allclose((top.moments * curve**2).sum(-1), 2 * top.energy, rtol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(top.moments * curve, axis=-1), float(top.angular_momentum), rtol=1e-14)
    for time in (0.0, 0.7, -2.0):
        nearest = np.linalg.norm(curve - free_top.angular_velocity(top, time), axis=-1).min()
        assert nearest < 1e-3 * abs(curve).max()
    if name != "separatrix":
        np.testing.assert_allclose(curve[0], curve[-1], atol=1e-15)


def test_the_polhode_of_a_steady_rotation_is_a_point():
    top = free_top.free_top([1.0, 2.0, 3.0], [0.0, 0.7, 0.0])
    for points in (5, 5.0):
        np.testing.assert_array_equal(polhodes.polhode(top, points), np.tile([0.0, 0.7, 0.0], (5, 1)))
    with pytest.raises(ValueError, match="whole number"):
        polhodes.polhode(top, 5.5)
    assert polhodes.herpolhode_radii(top) == (0.0, 0.0)
    assert np.isnan(free_top.period(top))
    assert np.isnan(polhodes.dwell(top, 0.3))
    assert len(polhodes.flip_times(top, 10.0)) == 0


@pytest.mark.parametrize("name", CASES)
def test_the_herpolhode_lies_on_a_plane_between_two_circles(name):
    moments, spin = CASES[name]
    top = free_top.free_top(moments, spin)
    times = np.linspace(0, free_top.period(top), 4001)
    momentum = np.array(moments) * spin
    upwards = momentum / np.linalg.norm(momentum)
    curve = polhodes.herpolhode(top, times)
    np.testing.assert_allclose(curve @ upwards, 2 * top.energy / np.linalg.norm(momentum), rtol=1e-14)
    across = np.linalg.norm(curve - (curve @ upwards)[:, None] * upwards, axis=-1)
    assert polhodes.herpolhode_radii(top) == pytest.approx((across.min(), across.max()), rel=1e-5)
    # Poinsot: the body's ellipsoid rolls on the plane, so the end of omega moves alike in space and in the body.
    body = np.gradient(free_top.angular_velocity(top, times), times, axis=0)
    space = np.gradient(curve, times, axis=0)
    np.testing.assert_allclose(np.linalg.norm(space, axis=-1)[1:-1], np.linalg.norm(body, axis=-1)[1:-1], rtol=1e-4)


def test_the_herpolhode_on_the_separatrix_spirals_into_the_middle():
    least, _ = polhodes.herpolhode_radii(ON)
    assert least == pytest.approx(0.0, abs=1e-15)


def test_stability_is_that_of_small_wobbles():
    moments, rate = [2.0, 3.0, 1.0], 0.7
    found = polhodes.stability(moments, rate)
    for k in (1, 2):  # those of the greatest and of the least moment
        spin = np.full(3, 1e-6)
        spin[k] = rate
        top = free_top.free_top(moments, spin)
        assert found.wobble_rate[k] == pytest.approx(abs(free_top.wobble_rate(top)), rel=1e-11)
        assert found.growth_rate[k] == 0.0
    grown = free_top.angular_velocity(free_top.free_top(moments, [rate, 1e-9, 0.0]), [20.0, 21.0])[:, 1]
    assert found.growth_rate[0] == pytest.approx(np.log(grown[1] / grown[0]), rel=1e-6)
    assert polhodes.stability([2.0, 2.0, 3.0], 1.0).wobble_rate[2] == 0.5
    np.testing.assert_array_equal(polhodes.stability([2.0, 2.0, 3.0], 1.0).growth_rate, 0.0)
    with pytest.raises(ValueError, match="three positive moments"):
        polhodes.stability([0.0, 1.0, 1.0], 1.0)


def test_a_wheel_along_an_axis_holds_it():
    """The linearised equations of a gyrostat: I dw/dt = -w x (I w + h)."""
    inertia, rotor, rate = np.diag([1.0, 2.0, 3.0]), 1.3, 0.9
    found = polhodes.stability([1.0, 2.0, 3.0], rate, rotor)
    for k, axis in enumerate(np.eye(3)):
        whole = inertia @ axis * rate + rotor * axis
        by_rate = [-np.cross(each, whole) - np.cross(rate * axis, inertia @ each) for each in np.eye(3)]
        roots = np.linalg.eigvals(np.linalg.solve(inertia, np.transpose(by_rate)))
        assert abs(roots.imag).max() == pytest.approx(found.wobble_rate[k], abs=1e-7)
        assert roots.real.max() == pytest.approx(found.growth_rate[k], abs=1e-7)
    assert found.growth_rate[1] == 0.0 < polhodes.stability([1.0, 2.0, 3.0], rate, 0.5).growth_rate[1]


@pytest.mark.parametrize("moments", [(1.0, 2.0, 3.0), (1.5, 4.0, 5.25)])
def test_the_separatrices_are_great_circles_of_the_angular_momentum(moments):
    moments = np.array(moments)
    least, middle, most = moments
    normals = np.array([[np.sqrt(1 / least - 1 / middle), 0, x * np.sqrt(1 / middle - 1 / most)] for x in (1, -1)])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    for spin in ([0.3, 0.2, 0.9], [1.0, -0.2, 0.3]):
        top = free_top.free_top(moments, spin)
        times = np.linspace(0, free_top.period(top), 7)
        direction = moments * free_top.angular_velocity(top, times) / float(top.angular_momentum)
        expected = abs(np.arcsin(direction @ normals.T)).min(-1)
        np.testing.assert_allclose(polhodes.separatrix_angle(top, times), expected, rtol=1e-13)
    # All digits next to it: the angle is proportional to the offset.
    angles = [
        float(polhodes.separatrix_angle(free_top.free_top(["1", "1.5", "3"], [f"{3 + offset!r}", "0.6", "1"])))
        for offset in (2.0**-20, 2.0**-40)
    ]
    assert angles[0] / angles[1] == pytest.approx(2.0**20, rel=1e-5)
    assert polhodes.separatrix_angle(ON) == 0.0
    assert np.isnan(polhodes.separatrix_angle(free_top.free_top([1.0, 1.0, 2.0], [0.1, 0.2, 0.3])))


def test_a_tennis_racket_turns_over_dwells_and_turns_back():
    interval = free_top.period(RACKET) / 2
    assert interval == pytest.approx(55.061681107466372 / 2, rel=1e-15)
    flips = polhodes.flip_times(RACKET, 130.0)
    assert len(flips) == 4 + (flips[0] + 4 * interval < 130.0)
    np.testing.assert_allclose(np.diff(flips), interval, rtol=1e-14)
    np.testing.assert_allclose(free_top.angular_velocity(RACKET, flips)[:, 1], 0.0, atol=1e-13)
    component = free_top.angular_velocity(RACKET, flips[:-1] + interval / 2)[:, 1]
    np.testing.assert_array_equal(np.sign(component[1:]), -np.sign(component[:-1]))


@pytest.mark.parametrize("angle", [0.01, 0.3, 1.2])
def test_the_dwell_is_the_time_next_to_the_intermediate_axis(angle):
    def away(time):
        return abs(2.0 * free_top.angular_velocity(RACKET, time)[1]) / float(RACKET.angular_momentum) - np.cos(angle)

    flip = polhodes.flip_times(RACKET, 100.0)[0]
    interval = free_top.period(RACKET) / 2
    begin = brentq(away, flip, flip + interval / 2, xtol=1e-13)
    end = brentq(away, flip + interval / 2, flip + interval, xtol=1e-13)
    assert polhodes.dwell(RACKET, angle) == pytest.approx(end - begin, abs=1e-9)


def test_dwells_at_their_limits():
    assert polhodes.dwell(ON, 0.1) == free_top.period(ON) == np.inf
    assert polhodes.dwell(free_top.free_top([1.0, 2.0, 3.0], [1e-3, 1e-3, 1.0]), 0.5) == 0.0
    assert (
        len(polhodes.flip_times(ON, 100.0)) + len(polhodes.flip_times(free_top.free_top(ON.moments, [3, -0.6, 1]), 100))
        == 1
    )
    # One flip lasts as long however near the separatrix it is; the dwell takes all the rest.
    tops = [free_top.free_top([1.0, 2.0, 3.0], [size, 1.0, size]) for size in (1e-10, 1e-100)]
    flips = [free_top.period(top) / 2 - polhodes.dwell(top, 0.2) for top in tops]
    assert flips[0] == pytest.approx(flips[1], rel=1e-12)
    with pytest.raises(ValueError, match="between 0 and pi/2"):
        polhodes.dwell(RACKET, 0.0)


def test_flips_are_counted_to_any_number_that_ends():
    top = free_top.free_top([1, 2, 3], [0.01, 3, 0.01])
    expected = polhodes.flip_times(top, 20.0)
    assert len(expected) == 3
    np.testing.assert_array_equal(polhodes.flip_times(top, np.float32(20)), expected)
    for end in (np.inf, np.nan):
        with pytest.raises(ValueError, match="must be finite"):
            polhodes.flip_times(top, end)
