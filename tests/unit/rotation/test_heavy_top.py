"""The heavy symmetric top in closed form: against the equations of motion and the theorems of steady precession."""

import mpmath as mp
import numpy as np
import pytest

from astroinertia.rotation import heavy_top
from astroinertia.rotation.attitude import attitude_of_euler_angles
from tests import exact_top

CASES = {  # A, C, M, tilt, rates about the line of nodes, across it and about the axis
    "loops": (1.0, 0.6, 0.8, 0.7, (0.3, -0.5, 3.0)),
    "waves": (1.0, 0.6, 0.8, 0.7, (0.3, 0.5, -3.0)),
    "cusps": (1.0, 0.4, 1.0, 0.5, (0.0, 0.0, 5.0)),
    "spherical pendulum": (1.0, 0.4, 1.0, 2.5, (0.4, 0.3, 0.0)),
    "swinging": (1.0, 0.4, 1.0, 2.5, (0.4, 0.0, 0.0)),
    "tumbling": (1.0, 0.4, 1.0, 2.5, (-4.4, 0.0, 0.0)),
    "without gravity": (1.0, 0.4, 0.0, 0.5, (0.2, 0.3, 2.0)),
    "from upright": (1.0, 0.4, 1.0, 0.0, (-0.2, 0.0, 2.0)),
    "sleeping": (1.0, 0.4, 1.0, 0.0, (0.0, 0.0, 2.0)),
    "almost sleeping": (1.0, 0.4, 1.0, 1e-9, (0.0, 0.0, 2.0)),
    "at the limit of sleep": (1.0, 0.4, 1.0, 1e-5, (0.0, 1e-6, 5.0)),
    "fast": (1.0, 1.5, 1.0, 1.0, (0.0, 0.3, 300.0)),
}
START = (0.4, -0.9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name, marks=() if name in ("loops", "swinging", "from upright", "sleeping", "fast") else pytest.mark.full
        )
        for name in CASES
    ],
)
def test_the_closed_form_follows_the_equations_of_motion(name):
    case = CASES[name]
    top = heavy_top.heavy_top(*case)
    time = 0.01 if name == "fast" else 0.7
    expected = exact_top.floats(exact_top.heavy_motion(*case[:3], (START[0], case[3], START[1]), case[4], time, 20))
    with np.errstate(all="raise", under="ignore"):
        rates, attitude = heavy_top.body_angular_velocity(top, time, START[1]), heavy_top.attitude(top, time, *START)
        start = heavy_top.attitude(top, 0.0, *START)
    np.testing.assert_allclose(attitude, expected[1], rtol=0, atol=3e-15)
    np.testing.assert_allclose(rates, expected[0], rtol=0, atol=3e-15 * abs(np.array(case[4])).max())
    np.testing.assert_allclose(start, attitude_of_euler_angles(np.array([START[0], case[3], START[1]])), atol=3e-16)
    assert heavy_top.tilt(top, 0.0) == pytest.approx(case[3], rel=1e-15)


@pytest.mark.parametrize("name", ["loops", "cusps", "spherical pendulum", "tumbling"])
def test_what_gravity_keeps_is_kept_for_a_million_nutations(name):
    transverse, axial, torque, *_ = case = CASES[name]
    top = heavy_top.heavy_top(*case)
    times = heavy_top.nutation_period(top) * np.concatenate([[0.0], np.random.default_rng(2).uniform(-1e6, 1e6, 500)])
    rates, attitude = heavy_top.body_angular_velocity(top, times), heavy_top.attitude(top, times)
    momentum = np.array([transverse, transverse, axial]) * rates
    energy = 0.5 * (momentum * rates).sum(-1) + torque * attitude[:, 2, 2]
    upwards = (momentum * attitude[:, :, 2]).sum(-1)
    scale = abs(momentum).max()
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=2e-15 * (scale**2 + torque))
    np.testing.assert_allclose(upwards, upwards[0], rtol=0, atol=2e-15 * scale)
    np.testing.assert_allclose(attitude @ np.swapaxes(attitude, -1, -2), np.tile(np.eye(3), (501, 1, 1)), atol=2e-15)


@pytest.mark.parametrize("branch", [0, 1])
@pytest.mark.parametrize("tilt", [0.4, 1.9])
def test_steady_precession_has_two_branches_and_no_nutation(branch, tilt):
    spin = 4.0
    rate = heavy_top.steady_precession_rates(1.0, 0.7, 0.9, tilt, spin)[branch]
    top = heavy_top.heavy_top(1.0, 0.7, 0.9, tilt, (0.0, np.sin(tilt) * rate, spin))
    low, high = heavy_top.tilt_range(top)
    assert high - low < 1e-15 * 10
    assert heavy_top.precession_rate(top) == pytest.approx(rate, rel=1e-14)


def test_steady_precession_in_its_limits():
    slow, fast = heavy_top.steady_precession_rates(1.0, 0.7, 0.9, 0.4, 1e9)
    assert slow == pytest.approx(0.9 / (0.7 * 1e9), rel=1e-15)  # M/(C w_3)
    assert fast == pytest.approx(0.7 * 1e9 / np.cos(0.4), rel=1e-15)  # that of the free top
    assert heavy_top.steady_precession_rates(1.0, 0.7, 0.9, 0.4, -1e9) == (-slow, -fast)
    limit = heavy_top.least_sleeping_spin(1.0, 0.7, 0.9)
    assert np.isnan(heavy_top.steady_precession_rates(1.0, 0.7, 0.9, 0.0, limit * (1 - 1e-9))).all()
    both = heavy_top.steady_precession_rates(1.0, 0.7, 0.9, 0.0, limit * (1 + 1e-15))
    assert both[0] == pytest.approx(both[1], rel=1e-6)
    hanging = heavy_top.steady_precession_rates(1.0, 0.7, 0.9, 2.5, 0.0)
    assert hanging == pytest.approx(np.sqrt(-0.9 / np.cos(2.5)) * np.array([1, -1]), rel=1e-15)


@pytest.mark.parametrize(("share", "falls"), [(1.001, False), (0.999, True)])
def test_a_top_sleeps_from_the_limiting_spin_on(share, falls):
    spin = share * heavy_top.least_sleeping_spin(1.0, 0.7, 0.9)
    top = heavy_top.heavy_top(1.0, 0.7, 0.9, 1e-7, (0.0, 0.0, spin))
    assert (heavy_top.tilt_range(top)[1] > 1e-2) == falls


def test_a_fast_top_nutates_at_its_own_rate():
    # Goldstein et al.: amplitude and rate of nutation of a fast top let go
    spin, tilt = 1e4, 0.8
    top = heavy_top.heavy_top(1.0, 0.7, 0.9, tilt, (0.0, 0.0, spin))
    a = 0.7 * spin
    low, high = heavy_top.tilt_range(top)
    assert low == pytest.approx(tilt, rel=1e-15)
    assert high - low == pytest.approx(2 * 0.9 / a**2 * np.sin(tilt), rel=1e-4)
    assert heavy_top.nutation_period(top) == pytest.approx(2 * np.pi / a, rel=1e-6)
    assert heavy_top.precession_rate(top) == pytest.approx(0.9 / a, rel=1e-6)


@pytest.mark.full
def test_a_top_that_rises_to_the_vertical_takes_for_ever():
    with mp.workdps(140):
        a, beta, tilt = mp.mpf("0.5"), mp.mpf(2), mp.mpf(2)
        across = a * mp.tan(tilt / 2)
        nodal = -mp.sqrt(beta * (1 - mp.cos(tilt)) - across**2)
        texts = [mp.nstr(each, 130) for each in (nodal, across)]
    top = heavy_top.heavy_top(1, "0.5", 1, 2, (*texts, 1))
    assert heavy_top.nutation_period(top) == np.inf
    assert heavy_top.precession_rate(top) == 0.25
    expected = exact_top.floats(exact_top.heavy_motion(1, 0.5, 1, (0, 2, 0), (*texts, 1), 1.5, 20))
    np.testing.assert_allclose(heavy_top.attitude(top, 1.5), expected[1], rtol=0, atol=2e-15)
    np.testing.assert_allclose(heavy_top.body_angular_velocity(top, 1.5), expected[0], rtol=0, atol=2e-15)
    falling = heavy_top.tilt(top, [40.0, 41.0])
    assert falling[1] / falling[0] == pytest.approx(np.exp(-float(top.argument_rate)), rel=1e-13)


def test_bad_arguments_are_refused():
    for wrong in ((0.0, 1.0, 1.0, 1.0), (1.0, -1.0, 1.0, 1.0), (1.0, 1.0, -1.0, 1.0), (1.0, 1.0, 1.0, 3.2)):
        with pytest.raises(ValueError, match="two positive moments"):
            heavy_top.heavy_top(*wrong, (0.0, 0.0, 1.0))
    with pytest.raises(ValueError, match="two positive moments"):
        heavy_top.heavy_top(1.0, 1.0, 1.0, 1.0, (0.0, 1.0))
    with pytest.raises(ValueError, match="rate across it must be 0"):
        heavy_top.heavy_top(1.0, 1.0, 1.0, 0.0, (0.0, 1.0, 0.0))


@pytest.mark.parametrize("numbers", [(1.0, 2.0, -1.0), (0.0, 2.0, 1.0), (1.0, 0.0, 1.0)])
def test_what_does_not_stand_upright_has_no_least_spin(numbers):
    with pytest.raises(ValueError, match="two moments above 0 and a torque that is not negative"):
        heavy_top.least_sleeping_spin(*numbers)
