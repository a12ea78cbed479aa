"""Several torques at once and decaying fields, against closed forms."""

import math

import numpy as np
import pytest

from astroinertia.errors import NumericalError
from astroinertia.rotation import braking, pulsars

P, DOT = 0.0333924123, 4.20972e-13
OMEGA, SLOWING = 2 * math.pi / P, -2 * math.pi * DOT / P**2
TIMES = np.array([0.0, 1e8, 1e10, 3e11])


@pytest.mark.parametrize("n", [0.0, 1.0, 2.51, 3.0, 5.0])
def test_one_torque_is_the_power_law(n):
    star = braking.Braking(OMEGA, SLOWING, (n,), (1.0,))
    times = TIMES if n >= 1 else 1e-2 * TIMES
    rates = star.history(times)
    np.testing.assert_allclose(2 * math.pi / rates, pulsars.period_history(times, P, DOT, n), rtol=1e-12)
    np.testing.assert_allclose(star.time_to(rates), times, rtol=1e-11, atol=1e-3)
    np.testing.assert_allclose(star.index(rates), n, atol=1e-12)


def test_a_short_time_has_all_its_digits():
    """(1 - x)^-2 - 1 = 2 x + 3 x^2 + ..., of a rate that is x less than at the start."""
    x = 2.0**-30
    star = braking.Braking(64.0, -1e-9, (3.0,), (1.0,))
    assert star.time_to(64.0 * (1 - x)) == pytest.approx(64.0 / 1e-9 * (x + 1.5 * x**2), rel=1e-14)


def test_a_mixture_drifts_to_its_lowest_index():
    star = braking.Braking(OMEGA, SLOWING, (1.0, 3.0, 5.0), (0.2, 0.7, 0.1))
    assert star.index(OMEGA) == pytest.approx(0.2 + 3 * 0.7 + 5 * 0.1)
    rates = star.history(TIMES)
    index = star.index(rates)
    assert np.all(np.diff(index) < 0) and index[-1] < 1.4
    np.testing.assert_allclose(star.time_to(rates), TIMES, rtol=1e-11, atol=1e-3)
    # n is what Omega Omega''/Omega'^2 gives.
    slope = (star.rate(OMEGA * 1.0001) - star.rate(OMEGA * 0.9999)) / (2e-4 * OMEGA)
    assert OMEGA * slope / star.rate(OMEGA) == pytest.approx(float(star.index(OMEGA)), rel=1e-7)
    assert star.time_to(1.2 * OMEGA) < 0


def test_wind_and_dipole_make_the_crab():
    wind, dipole = braking.shares_of_index(2.51)
    assert (wind, dipole) == pytest.approx((0.245, 0.755))
    assert float(braking.Braking(OMEGA, SLOWING, (1.0, 3.0), (wind, dipole)).index(OMEGA)) == pytest.approx(2.51)
    # Closed form of the two: u = Omega^2, u' = -2 (a u + b u^2).
    star = braking.Braking(OMEGA, SLOWING, (1.0, 3.0), (wind, dipole))
    a, b = wind * -SLOWING / OMEGA, dipole * -SLOWING / OMEGA**3
    grown = np.exp(2 * a * TIMES)
    exact = np.sqrt(1 / ((1 / OMEGA**2 + b / a) * grown - b / a))
    np.testing.assert_allclose(star.history(TIMES), exact, rtol=1e-12)
    with pytest.raises(ValueError, match="between 1 and 3"):
        braking.shares_of_index(3.15)


def test_a_decaying_field_ends_the_spin_down():
    decay = 1e11
    period = braking.decaying_field_period(np.array([0.0, 1e9, 1e13]), P, DOT, decay)
    assert period[0] == P and period[2] == pytest.approx(math.sqrt(P**2 + decay * P * DOT))
    assert braking.decaying_field_period(math.inf, P, DOT, decay) == period[2]
    step = 1e6
    later = braking.decaying_field_period(1e9 + np.array([-step, 0.0, step]), P, DOT, decay)
    slowing = (later[2] - later[0]) / (2 * step)
    assert later[1] * slowing == pytest.approx(P * DOT * math.exp(-2 * 1e9 / decay), rel=1e-6)
    assert braking.decaying_field_index(P, DOT, decay) == pytest.approx(3 + 2 * P / (DOT * decay))
    slowly = braking.decaying_field_period(1e9, P, DOT, 1e25)
    assert slowly == pytest.approx(float(pulsars.period_history(1e9, P, DOT)), rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((OMEGA, 1.0, (3.0,), (1.0,)), "negative derivative"),
        ((OMEGA, SLOWING, (3.0,), (0.5, 0.5)), "as many shares"),
        ((OMEGA, SLOWING, (1.0, 3.0), (-0.5, 1.5)), "none negative"),
    ],
)
def test_what_does_not_brake_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        braking.Braking(*arguments)


def test_times_must_rise():
    with pytest.raises(ValueError, match="rising"):
        braking.Braking(OMEGA, SLOWING, (3.0,), (1.0,)).history([1.0, 0.5])


def test_a_field_that_never_decays_is_a_dipole_and_no_star_comes_to_rest():
    exact = np.sqrt(0.1**2 + 2 * 0.1 * 1e-15 * np.array([0.0, 1e13]))
    np.testing.assert_allclose(
        braking.decaying_field_period(np.array([0.0, 1e13]), 0.1, 1e-15, np.inf), exact, rtol=1e-14
    )
    for rate in (0.0, -5.0, np.inf):
        with pytest.raises(ValueError, match="must be positive and finite"):
            braking.Braking(200.0, -1e-9, (3.0,), (1.0,)).time_to(rate)


def test_a_torque_that_stops_a_star_says_when():
    stopping = braking.Braking(1.0, -1.0, (0.5,), (1.0,))  # Omega' = -Omega^(1/2): at rest at t = 2
    assert stopping.time_to(1e-12) == pytest.approx(2.0, rel=2e-6)
    with pytest.raises(NumericalError, match="it comes to rest before"):
        stopping.history([0.0, 1.0, 3.0])
