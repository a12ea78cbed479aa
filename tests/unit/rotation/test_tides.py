"""Torque and heat of tides against closed forms in eccentricity and obliquity, and against an observed moon."""

import numpy as np
import pytest

from astroinertia.rotation.spin_orbit import tidal_equilibrium_rate
from astroinertia.rotation.tides import despin_time, inclination_functions, tides

ORBIT = {"mass": 3.0, "radius": 0.5, "semi_major_axis": 2.0, "mean_motion": 0.7, "gravitational_constant": 1.3}
SCALE = 1.3 * 3.0**2 * 0.5**5 / 2.0**6


def lagging(frequency):
    """A short time lag: -Im k2 goes with the frequency."""
    return 0.3 - 0.02j * frequency


@pytest.mark.parametrize(("eccentricity", "obliquity", "spin"), [(0.0, 0.0, 2.0), (0.1, 2.5, 0.3), (0.6, 0.8, 1.9)])
def test_a_time_lag_has_the_closed_forms_of_hut(eccentricity, obliquity, spin):
    # Hut 1981, A&A 99, 126; with an obliquity: Levrard et al. 2007, A&A 462, L5; Leconte et al. 2010, A&A 516, A64
    s, x, n = eccentricity**2, np.cos(obliquity), ORBIT["mean_motion"]
    energy = (1 + 31 / 2 * s + 255 / 8 * s**2 + 185 / 16 * s**3 + 25 / 64 * s**4) / (1 - s) ** 7.5
    orbital = (1 + 15 / 2 * s + 45 / 8 * s**2 + 5 / 16 * s**3) / (1 - s) ** 6
    spinning = (1 + 3 * s + 3 / 8 * s**2) / (1 - s) ** 4.5
    size, r = 3 * 0.02 * SCALE * n, spin / n
    found = tides(lagging, **ORBIT, spin_rate=spin, eccentricity=eccentricity, obliquity=obliquity)
    assert found.torque == pytest.approx(size * (x * orbital - 0.5 * (1 + x**2) * spinning * r), rel=1e-11)
    heat = n * size * (energy - 2 * x * orbital * r + 0.5 * (1 + x**2) * spinning * r**2)
    assert found.heating == pytest.approx(heat, rel=1e-11)


def test_a_moon_in_step_is_heated_by_eccentricity_and_obliquity():
    # Segatz et al. 1988; Wisdom 2004: (21/2 e^2 + 3/2 sin^2 eps) n (-Im k2) G m^2 R^5/a^6, whatever its rheology
    for eccentricity, obliquity in ((1e-4, 0.0), (0.0, 1e-4), (1e-4, 1e-4)):
        found = tides(
            lambda w: 0.01 - 0.003j / w, **ORBIT, spin_rate=0.7, eccentricity=eccentricity, obliquity=obliquity
        )
        exact = (10.5 * eccentricity**2 + 1.5 * obliquity**2) * 0.003 * SCALE
        assert found.heating == pytest.approx(exact, rel=1e-6)
    assert tides(lagging, **ORBIT, spin_rate=0.7) == pytest.approx((0.0, 0.0), abs=1e-25)
    rounded = 0.7 * (1 + 2**-50)  # in step but for round-off, whose sign must not count
    assert tides(lambda w: -0.01j + 0 * w, **ORBIT, spin_rate=rounded) == pytest.approx((0.0, 0.0), abs=1e-25)


def test_a_companion_that_goes_round_backwards_is_one_of_an_orbit_turned_over():
    """In matter that flows, of which only tides that move may be asked."""
    given = {**ORBIT, "spin_rate": 0.3, "eccentricity": 0.2}
    turned = tides(lambda w: 0.01 - 0.003j / w, **given, obliquity=np.pi)
    backwards = tides(lambda w: 0.01 - 0.003j / w, **{**given, "mean_motion": -ORBIT["mean_motion"]})
    assert backwards == pytest.approx(turned, rel=1e-13)


def test_a_time_lag_has_no_torque_where_the_spin_is_in_equilibrium():
    rate = 0.7 * tidal_equilibrium_rate(0.3)
    found = [tides(lagging, **ORBIT, spin_rate=rate * part, eccentricity=0.3).torque for part in (0.99, 1.0, 1.01)]
    assert found[0] > 0 > found[2] and abs(found[1]) < 1e-12 * found[0]


def test_io_as_observed():
    # Lainey et al. 2009, Nature 459, 957: k2/Q = 0.015(3), and 9.33(187)e13 W with it
    found = tides(lambda w: -0.015j + 0 * w, 1.89813e27, 1.8216e6, 4.218e8, 4.1106e-5, 4.1106e-5, 0.0041)
    assert found.heating == pytest.approx(9.33e13, rel=0.03)


def test_a_body_far_from_a_resonance_of_many_harmonics():
    # a constant Q of a body that turns fast: all harmonics push one way, and the torque is that of the mean of (a/r)^6
    found = tides(lambda w: -0.01j + 0 * w, **ORBIT, spin_rate=50.0, eccentricity=0.7)
    s = 0.49
    assert found.torque == pytest.approx(-1.5 * 0.01 * SCALE * (1 + 3 * s + 3 / 8 * s**2) / (1 - s) ** 4.5, rel=1e-12)
    for beyond in (-0.1, 1.0):
        with pytest.raises(ValueError, match="below 1"):
            tides(lagging, **ORBIT, spin_rate=1.0, eccentricity=beyond)


def test_inclination_functions_keep_the_size_of_the_potential():
    for angle in (0.0, 0.4, 2.0):
        squares = np.array([1, 2 / 6, 2 / 24]) @ inclination_functions(angle) ** 2
        assert squares == pytest.approx([0.75, 0.25, 0.75], abs=1e-15) or squares.sum() == pytest.approx(1.0)


def test_inclination_functions_turn_the_potential_to_the_plane_of_the_orbit():
    """P_2m(sin latitude) exp(i m longitude from the node) is the sum of F_2mp exp(i (2 - 2p) u), over i for m = 1.

    u is the argument of latitude. Kaula 1966, (3.61), at any place of an inclined orbit.
    """
    for angle in (0.4, 2.0):
        u = np.linspace(0.0, 6.0, 7)
        flat, up = np.cos(u) + 1j * np.sin(u) * np.cos(angle), np.sin(u) * np.sin(angle)
        legendre = np.array([1.5 * up**2 - 0.5, 3 * up * flat, 3 * flat**2])  # of cos latitude e^(i longitude)
        turned = inclination_functions(angle) @ np.exp(1j * np.multiply.outer([2.0, 0.0, -2.0], u))
        np.testing.assert_allclose(np.array([[1.0], [-1j], [1.0]]) * turned, legendre, atol=1e-15)


@pytest.mark.parametrize("name", ["mass", "radius", "semi_major_axis"])
def test_what_raises_no_tide_is_refused(name):
    io = {"mass": 1.898e27, "radius": 1.8216e6, "semi_major_axis": 4.218e8}
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        tides(lambda rates: 0.02 - 0.0002j + 0 * rates, **{**io, name: -1.0}, mean_motion=4.11e-5, spin_rate=4.11e-5)


@pytest.mark.parametrize(("start", "end"), [(5.0, 0.7), (5.0, 2.0), (0.1, 0.7), (-3.0, 0.2)])
def test_a_constant_quality_turns_a_spin_by_what_its_torque_does(start, end):
    took = despin_time(**ORBIT, spin_rate=start, moment_of_inertia=4.0, love_number=0.3, quality=20.0,
                       spin_rate_after=end)  # fmt: skip
    between = start + np.array([0.0, 0.5, 0.99]) * (end - start)
    torque = [tides(lambda w: 0.3 - 0.3j / 20 + 0 * w, **ORBIT, spin_rate=rate).torque for rate in between]
    np.testing.assert_allclose(took * np.array(torque), 4.0 * (end - start), rtol=1e-14)
    gladman = abs(start) * 2.0**6 * 4.0 * 20.0 / (3 * 1.3 * 3.0**2 * 0.3 * 0.5**5)
    assert took == pytest.approx(2 * gladman * abs(end - start) / abs(start), rel=1e-14)


def test_a_spin_is_locked_at_the_mean_motion():
    given = {"mass": "1 Msun", "radius": "2440 km", "mean_motion": "1e-6 rad/s", "moment_of_inertia": 6.8e35}
    given |= {"semi_major_axis": np.array([1.0, 2.0]) * 5.79e10, "love_number": 0.5, "quality": 100.0}
    near, far = despin_time(**given, spin_rate="600 deg/h")
    assert far == pytest.approx(64 * near, rel=1e-14)
    assert near == pytest.approx(despin_time(**given, spin_rate="600 deg/h", spin_rate_after=1e-6)[0], rel=1e-14)
    assert list(despin_time(**given, spin_rate=1e-6, spin_rate_after=1e-6)) == [0.0, 0.0]


def test_tides_do_not_turn_a_spin_away_from_the_orbit_nor_past_it():
    body = {**ORBIT, "moment_of_inertia": 4.0, "love_number": 0.3, "quality": 20.0}
    for start, end in ((5.0, 6.0), (0.5, 0.3), (5.0, 0.5), (0.1, 0.8)):
        with pytest.raises(ValueError, match="nearer to the mean motion"):
            despin_time(**body, spin_rate=start, spin_rate_after=end)
    with pytest.raises(ValueError, match="quality must be positive"):
        despin_time(**{**body, "quality": 0.0}, spin_rate=5.0)
