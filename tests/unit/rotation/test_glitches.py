"""Glitches: angular momentum stays, the crust relaxes, and Vela needs a reservoir of a percent."""

import numpy as np
import pytest

from astroinertia.rotation import glitches

SHARE, TAU = 0.02, 10.0


def test_two_components_share_their_angular_momentum():
    times = np.linspace(0.0, 100.0, 50)
    crust, superfluid = glitches.coupled_history(times, 70.001, 70.0, SHARE, TAU)
    total = (1 - SHARE) * crust + SHARE * superfluid
    np.testing.assert_allclose(total, total[0], rtol=1e-15)
    np.testing.assert_allclose(crust - superfluid, 1e-3 * np.exp(-times / TAU), rtol=1e-9, atol=1e-12)
    # A jump of the crust alone heals by Q = I_s/I.
    jump = crust - 70.0
    assert jump[-1] / jump[0] == pytest.approx(1 - SHARE, rel=1e-4)
    np.testing.assert_allclose(jump, glitches.recovery(times, 1e-3, SHARE, TAU), rtol=1e-9, atol=1e-14)


def test_braking_holds_a_steady_lag():
    steady = -1e-6 * TAU / (1 - SHARE)
    times = np.array([0.0, 3.0, 5.0])
    crust, superfluid = glitches.coupled_history(times, 70.0 + steady, 70.0, SHARE, TAU, external_rate=-1e-6)
    np.testing.assert_allclose(crust - superfluid, steady, rtol=1e-9)
    np.testing.assert_allclose(np.diff(crust) / np.diff(times), -1e-6, rtol=1e-6)
    # Its equations, by differences: I_s Omega_s' = I_c I_s/(I tau) (Omega_c - Omega_s).
    away = glitches.coupled_history(np.array([1.0, 1.0001]), 70.1, 70.0, SHARE, TAU)
    pull = (1 - SHARE) / TAU * (away.crust[0] - away.superfluid[0])
    assert np.diff(away.superfluid)[0] / 1e-4 == pytest.approx(pull, rel=1e-4)


def test_a_glitch_moves_angular_momentum_and_a_starquake_the_moment():
    lag, rate = 0.05, 70.0
    size = glitches.glitch_size(SHARE, lag, rate)
    # The crust gains size * rate, the superfluid loses lag relative to it.
    crust, superfluid = rate + size * rate, rate + size * rate - lag
    assert (1 - SHARE) * crust + SHARE * superfluid == pytest.approx(rate, rel=1e-15)
    change = glitches.starquake_moment_change(1e-3)
    assert (1 + change) * (1 + 1e-3) == pytest.approx(1.0, rel=1e-15)


def test_velas_reservoir():
    # Vela glitches by 2e-6 every 1000 days or so and has a characteristic age of 11.3 kyr: Link, Epstein & Lattimer
    # 1999 find G = 0.014.
    activity = glitches.glitch_activity([2.0e-6] * 9, 8.1 * 1000 * 86400.0)
    share = glitches.least_superfluid_share(activity, 11300 * 365.25 * 86400)
    assert share == pytest.approx(0.014, rel=0.35)


def test_what_is_no_superfluid_is_refused():
    for share, tau in ((0.0, 1.0), (1.0, 1.0), (0.5, 0.0)):
        with pytest.raises(ValueError, match="superfluid"):
            glitches.coupled_history(0.0, 1.0, 1.0, share, tau)
    for share in (1.5, -0.1, np.array([0.5, 2.0])):
        with pytest.raises(ValueError, match="share of the whole moment from 0 to 1"):
            glitches.glitch_size(share, 1.0, 70.0)


def test_recoveries_have_units_and_go_side_by_side():
    days = np.array([0.0, 30.0, 1e5])
    found = glitches.recovery(days * 86400.0, "3600 deg/h", 0.2, "30 d", "1e-12 rad/s2")
    lasting = 1e-12 * 86400.0 * days
    np.testing.assert_allclose(found - lasting, np.radians(1.0) * np.array([1.0, 0.8 + 0.2 / np.e, 0.8]), rtol=1e-12)
    both = glitches.recovery(days, np.array([[1.0], [2.0]]), 0.2, 30.0)
    np.testing.assert_allclose(both, [glitches.recovery(days, jump, 0.2, 30.0) for jump in (1.0, 2.0)], rtol=1e-15)
    for relaxation_time in (0.0, -30.0):
        with pytest.raises(ValueError, match="relaxation time of a glitch must be above 0"):
            glitches.recovery(days, 1.0, 0.2, relaxation_time)
    slowed = glitches.coupled_history([0.0, 1e9], 70.0, 70.0, 0.1, "1 d", "-1e-10 rad/s2")
    assert slowed.crust[1] == pytest.approx(70.0 - 0.1, abs=1e-4)
