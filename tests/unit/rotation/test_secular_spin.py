"""Spin axes on precessing orbits: exact motions, order of convergence, Cassini states, capture while alpha grows."""

import numpy as np
import pytest

from astroinertia.rotation import secular_spin
from astroinertia.rotation.cassini import cassini_states
from astroinertia.rotation.secular_spin import orbit_normal, spin_history

LEAN = 0.3  # inclination of an orbit that precesses with one rate
AMPLITUDE = np.sin(LEAN / 2)


def test_the_orbits_normal_has_its_inclination_and_node():
    normal = orbit_normal([0.0, 1.0], AMPLITUDE, -0.5, 0.4)
    np.testing.assert_allclose(normal[:, 2], np.cos(LEAN), rtol=1e-15)
    node = np.cross([0, 0, 1.0], normal)  # towards the ascending node
    np.testing.assert_allclose(np.arctan2(node[:, 1], node[:, 0]), [0.4, -0.1], rtol=1e-14)
    np.testing.assert_allclose(
        orbit_normal(0.0, [0.1, 0.2], [1.0, 2.0], [0.0, 1.0])[2], 1 - 2 * 0.05 - 0.08 * np.cos(1)
    )


def test_about_a_fixed_orbit_the_axis_precesses_at_its_rate():
    tilt, alpha = 0.7, 0.2
    times = np.linspace(0.0, 500.0, 7)
    found = spin_history(times, [0.0, np.sin(tilt), np.cos(tilt)], alpha, 0.0, 0.0, 0.0)
    angle = np.pi / 2 - alpha * np.cos(tilt) * times  # a regression
    expected = np.stack([np.sin(tilt) * np.cos(angle), np.sin(tilt) * np.sin(angle), np.full(7, np.cos(tilt))], 1)
    np.testing.assert_allclose(found.axis, expected, atol=1e-12)
    np.testing.assert_allclose(found.obliquity, tilt, rtol=1e-13)


def energy(found, alpha, rate):
    return 0.5 * alpha * (found.axis * found.normal).sum(1) ** 2 + rate * found.axis[:, 2]


def test_steps_are_of_order_four_and_keep_colombos_integral():
    times, alpha, rate = np.linspace(0.0, 3000.0, 30), 1.0, -0.8
    coarse, fine, exact = (
        spin_history(times, [0.0, 0.5, 0.7], alpha, AMPLITUDE, rate, 0.0, steps_per_radian=steps)
        for steps in (5, 10, 80)
    )
    errors = [np.abs(found.axis - exact.axis).max() for found in (coarse, fine)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)
    drift = energy(fine, alpha, rate) - energy(fine, alpha, rate)[0]
    assert np.abs(drift).max() < 1e-6 and np.abs(drift[15:]).max() < 1.5 * np.abs(drift[:15]).max()
    np.testing.assert_allclose(np.linalg.norm(exact.axis, axis=1), 1.0, rtol=1e-15)


def test_cassini_states_stay():
    for state in cassini_states(1.0, -0.3, LEAN):
        # The pole of the orbit's precession is z; the normal leans to -y at time 0, and s beyond the pole to +y.
        place = state.obliquity - LEAN
        found = spin_history([0.0, 40.0], [0.0, np.sin(place), np.cos(place)], 1.0, AMPLITUDE, -0.3, 0.0, 0.0, 400)
        assert found.obliquity[1] == pytest.approx(abs(state.obliquity), abs=1e-7)
        if state.stable:
            times = np.linspace(0, 3000, 400)
            near = spin_history(times, [1e-4, np.sin(place), np.cos(place)], 1.0, AMPLITUDE, -0.3, 0.0)
            assert np.abs(near.obliquity - abs(state.obliquity)).max() < 3e-3


def test_an_axis_follows_state_two_while_the_constant_grows():
    """As Saturn's is thought to have: slow growth through the resonance raises the obliquity by the state's own."""
    lean, rate, growth = 0.01, -1.0, 2e-5
    start = cassini_states(0.3, rate, lean)[0]
    assert start.number == 2
    place, times = start.obliquity - lean, np.linspace(0.0, np.log(5.0) / growth, 50)
    found = spin_history(times, [0, np.sin(place), np.cos(place)], 0.3, np.sin(lean / 2), rate, 0.0, growth, 10)
    end = next(state for state in cassini_states(1.5, rate, lean) if state.number == 2)
    assert np.degrees(end.obliquity) > 45
    assert found.obliquity[-1] == pytest.approx(end.obliquity, abs=0.02)


def test_times_need_not_be_even_and_one_is_enough():
    times = np.array([0.0, 0.1, 5.0, 300.0])
    arguments = ([0.1, 0.2, 0.9], 1.0, [AMPLITUDE, 0.02], [-0.7, 0.3], [0.0, 1.0])
    found = spin_history(times, *arguments)
    direct = spin_history(times[[0, 3]], *arguments)
    np.testing.assert_allclose(found.axis[3], direct.axis[1], atol=1e-6)
    assert spin_history([3.0], *arguments).axis.shape == (1, 3)


def test_what_makes_no_history_is_refused(monkeypatch):
    monkeypatch.setattr(secular_spin, "_MOST_STEPS", 100)
    axis = [0.0, 0.0, 1.0]
    for arguments, message in (
        (([0.0, 0.0], axis, 1.0, 0.1, 1.0, 0.0), "increase"),
        (([0.0, np.nan], axis, 1.0, 0.1, 1.0, 0.0), "increase"),
        (([0.0, 1.0], [0.0, 0.0, 0.0], 1.0, 0.1, 1.0, 0.0), "length"),
        (([0.0, 1.0], axis, 1.0, [0.6, 0.5], [1.0, 2.0], [0.0, 0.0]), "less than 1"),
        (([0.0, 1.0], axis, 1.0, [0.1, 0.2], [1.0], [0.0]), "a rate and a phase"),
        (([0.0, 1e3], axis, 1.0, 0.1, 1.0, 0.0), "too many"),
        (([0.0, 1.0], axis, np.nan, 0.1, 1.0, 0.0), "finite"),
        (([0.0, 1.0], axis, 1.0, 0.1, 1.0, 0.0, 0.0, 0), "at least one step a radian, not 0"),
        (([0.0, 1.0], axis, 1.0, 0.1, 1.0, 0.0, 0.0, np.nan), "at least one step a radian, not nan"),
    ):
        with pytest.raises(ValueError, match=message):
            spin_history(*arguments)
