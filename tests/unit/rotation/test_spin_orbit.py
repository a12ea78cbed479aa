"""Spin-orbit resonances: widths, capture and sections, against closed forms, published numbers and the motion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.rotation import spin_orbit

MERCURY = 0.2056317


def test_published_numbers():
    # Wisdom, Peale & Mignard 1984: Hyperion at e = 0.1 has omega_0 = 0.89, and resonances touch at 0.31.
    assert spin_orbit.overlap_asphericity(0.1) == pytest.approx(0.31, abs=0.01)
    assert spin_orbit.overlap_asphericity(1e-6) == pytest.approx(1 / (2 + np.sqrt(14e-6)), rel=1e-5)
    # Goldreich & Peale 1966: a tide linear in frequency holds Mercury at 1.26 n; 3:2 catches it with some 7 %.
    assert spin_orbit.tidal_equilibrium_rate(MERCURY) == pytest.approx(1.256, abs=1e-3)
    assert spin_orbit.capture_probability(1.5, MERCURY, np.sqrt(3e-4)) == pytest.approx(0.07, abs=0.005)
    assert spin_orbit.capture_probability(1.5, 0.0, 0.1) == 0.0
    assert spin_orbit.capture_probability(1.0, 0.0, 0.1, equilibrium_rate=1.0) == 1.0
    with pytest.raises(ValueError, match="slows no spin"):
        spin_orbit.capture_probability(1.0, MERCURY, 0.1)


def test_asphericity_does_not_mind_the_order():
    assert spin_orbit.asphericity([1.0, 0.6, 0.8]) == pytest.approx(np.sqrt(0.6), rel=1e-15)
    with pytest.raises(ValueError, match="above 0"):
        spin_orbit.asphericity([0.0, 1.0, 1.0])
    with pytest.raises(ValueError, match=r"1 \+ 2 < 4"):
        spin_orbit.asphericity([[1.0, 1.5, 2.0], [4.0, 1.0, 2.0]])


@pytest.mark.slow
@pytest.mark.parametrize(("e", "size", "error"), [(0.3, 0.6, 1e-8), (0.9, 0.2, 1e-4)])
def test_the_section_is_the_motion(e, size, error):
    def rate(anomaly, state):
        eccentric = anomaly + e * np.sin(anomaly)
        for _ in range(30):
            eccentric -= (eccentric - e * np.sin(eccentric) - anomaly) / (1 - e * np.cos(eccentric))
        distance = 1 - e * np.cos(eccentric)
        true = 2 * np.arctan(np.sqrt((1 + e) / (1 - e)) * np.tan(eccentric / 2))
        return state[1], -0.5 * size**2 / distance**3 * np.sin(2 * (state[0] - true))

    exact = solve_ivp(rate, (0, 6 * np.pi), [0.4, 1.2], rtol=1e-12, atol=1e-13).y[:, -1]
    errors = []
    for steps in (48, 96):
        found = spin_orbit.surface_of_section(e, size, 0.4, 1.2, 3, steps)
        errors.append(abs(found.rate[-1] - exact[1]))
    assert np.remainder(found.angle[-1] - exact[0] + 0.5, np.pi) == pytest.approx(0.5, abs=1e-4)
    assert errors[1] < error and np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.7)


def test_the_width_of_a_resonance_is_that_of_the_section():
    e, size = 0.05, 0.05
    for p in (1.0, 1.5):
        width = spin_orbit.resonance_half_width(p, e, size)
        found = spin_orbit.surface_of_section(e, size, np.zeros(2), p + width * np.array([0.9, 1.1]), 600, 24)
        inside, outside = np.abs(found.angle).max(0)
        assert inside < 1.3 and outside > 1.5  # swings, and turns over


@pytest.mark.slow
def test_small_swings_have_their_rate():
    e, size = 0.02, 0.05
    width = spin_orbit.resonance_half_width(1.0, e, size)
    orbits = 4000
    found = spin_orbit.surface_of_section(e, size, 0.01, 1.0, orbits, 24)
    power = np.abs(np.fft.rfft((found.angle[1:] - found.angle.mean()) * np.hanning(orbits)))
    peak = 2 + np.argmax(power[2:])
    assert peak / orbits == pytest.approx(width, rel=0.02)  # turns an orbit, as a share of n


def test_an_aspherical_moon_is_chaotic_and_a_round_one_is_not():
    for size, chaotic in ((0.1, False), (0.89, True)):
        pair = spin_orbit.surface_of_section(0.1, size, [0.0, 1e-9], [1.35, 1.35], 60)
        distance = np.abs(pair.rate[:, 1] - pair.rate[:, 0])
        assert (distance[-1] > 1e-3) == chaotic
        assert chaotic or distance[-1] < 1e-6


@pytest.mark.full
def test_capture_happens_as_often_as_the_formula_says():
    e, size, starts = 0.2, 0.1, 300
    expected = spin_orbit.capture_probability(1.5, e, size)
    rates = 1.62 + 0.004 * np.random.default_rng(1).uniform(size=starts)
    angles = np.linspace(0, np.pi, starts, endpoint=False)
    equilibrium = spin_orbit.tidal_equilibrium_rate(e)
    found = spin_orbit.surface_of_section(e, size, angles, rates, 700, 24, 3e-4, equilibrium)
    last = found.rate[-20:].mean(0)
    held = np.abs(last - 1.5) < 0.03
    assert np.all(held | (last < 1.47))  # each is either held or past
    assert held.mean() == pytest.approx(expected, abs=3 * np.sqrt(expected * (1 - expected) / starts))


def test_what_makes_no_section_is_refused():
    orbit = (0.1, 0.1, 0.0, 1.0)
    for arguments in ((1.0, 0.1, 0.0, 1.0, 3), (*orbit, 0), (*orbit, 3, 0), (*orbit, 2.5), (*orbit, 3, 48.5)):
        with pytest.raises(ValueError, match="section needs"):
            spin_orbit.surface_of_section(*arguments)
    whole = (spin_orbit.surface_of_section(*orbit, *counts) for counts in ((3, 24), (3.0, 24.0)))
    np.testing.assert_array_equal(*(found.rate for found in whole))


def test_a_negative_asphericity_is_refused():
    for function in (spin_orbit.resonance_half_width, spin_orbit.capture_probability):
        with pytest.raises(ValueError, match=r"asphericity must not be negative, not -0\.1"):
            function(1.5, MERCURY, -0.1)


def test_the_chance_of_a_body_that_is_not_known_is_not_known():
    assert np.isnan(spin_orbit.capture_probability(1.5, 0.2056, np.nan))  # it was 1
