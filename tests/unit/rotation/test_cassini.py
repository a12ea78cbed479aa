"""Cassini states against closed forms, published bodies and the merging of states 1 and 4."""

import numpy as np
import pytest

from astroinertia.bodies.planets import body
from astroinertia.rotation import cassini, precession

DAY = 86400.0


def test_strengths_of_resonances():
    # Cayley's series; and both ways of e -> 0.
    for e in (0.01, 0.05):
        assert cassini.hansen_coefficient(e, 1) == pytest.approx(1 - 5 * e**2 / 2 + 13 * e**4 / 16, abs=e**6)
        assert cassini.hansen_coefficient(e, 1.5) == pytest.approx(7 * e / 2 - 123 * e**3 / 16, abs=12 * e**5)
        assert cassini.hansen_coefficient(e, 0.5) == pytest.approx(-e / 2 + e**3 / 16, abs=e**5)
        assert cassini.hansen_coefficient(e, 2) == pytest.approx(17 * e**2 / 2 - 115 * e**4 / 6, abs=40 * e**6)
    assert cassini.hansen_coefficient(0.0, 1) == 1.0 and abs(cassini.hansen_coefficient(0.0, 1.5)) < 1e-15
    # All of them together are the torque at the pericentre, (1 - e)^-3.
    e = 0.4
    total = sum(cassini.hansen_coefficient(e, k / 2) for k in range(-40, 90))
    assert total == pytest.approx((1 - e) ** -3, rel=1e-10)
    for wrong in ((0.1, 0.7), (1.0, 1), (-0.1, 1)):
        with pytest.raises(ValueError, match="resonance"):
            cassini.hansen_coefficient(*wrong)


@pytest.mark.parametrize("inclination", [0.01, 0.09, 0.7, 1.5])
def test_states_stand_still_and_merge_at_the_critical_rate(inclination):
    critical = cassini.critical_node_rate(1.0, inclination)
    for rate, count in ((-0.999 * critical, 4), (-1.001 * critical, 2), (-0.01, 4), (-30.0, 2), (0.5 * critical, 4)):
        states = cassini.cassini_states(1.0, rate, inclination)
        assert [state.number for state in states] == ([1, 2, 3, 4] if count == 4 else [2, 3])
        pole = np.array([0.0, np.sin(inclination), np.cos(inclination)])
        for state in states:
            axis = np.array([0.0, np.sin(state.obliquity), np.cos(state.obliquity)])
            normal = np.array([0.0, 0.0, 1.0])
            drift = (axis @ normal) * np.cross(axis, normal) - rate * np.cross(pole, axis)
            np.testing.assert_allclose(drift, 0.0, atol=1e-13 * max(1.0, abs(rate)))
            assert state.stable == (state.number != 4) == np.isfinite(state.frequency)


@pytest.mark.parametrize("inclination", [0.001, 0.02066, 0.09, 0.7, 1.5])
@pytest.mark.parametrize("short", [1e-4, 1e-6, 1e-7])
def test_states_next_to_their_merging_are_counted_once(inclination, short):
    # States 1 and 4 are then sqrt(short) or so apart, within a part of the circle or two.
    critical = cassini.critical_node_rate(1.0, inclination)
    states = cassini.cassini_states(1.0, -(1 - short) * critical, inclination)
    assert [state.number for state in states] == [1, 2, 3, 4]
    # By hand: at the merging tan(obliquity) = -tan(inclination)^(1/3) (Henrard & Murigande 1987).
    merging = -np.arctan(np.tan(inclination) ** (1 / 3))
    apart = states[0].obliquity - states[3].obliquity
    assert 0 < apart < 10 * short**0.5 and abs(states[0].obliquity - merging) < 6 * short**0.5
    assert len(cassini.cassini_states(1.0, -(1 + short) * critical, inclination)) == 2


def test_a_small_obliquity_keeps_its_digits():
    node, inclination = 1e-5, 1e-5
    state = cassini.cassini_states(1.0, -node, inclination)[0]
    expected = -node * np.sin(inclination) / (1 - node * np.cos(inclination))
    assert state.obliquity == pytest.approx(expected, rel=1e-12)


def test_small_circles_about_a_state_have_its_frequency():
    inclination, rate, step = 0.3, -0.2, 1e-6
    pole, normal = np.array([0.0, np.sin(inclination), np.cos(inclination)]), np.array([0.0, 0.0, 1.0])

    def drift(axis):
        return (axis @ normal) * np.cross(axis, normal) - rate * np.cross(pole, axis)

    for state in cassini.cassini_states(1.0, rate, inclination):
        axis = np.array([0.0, np.sin(state.obliquity), np.cos(state.obliquity)])
        jacobian = np.array([(drift(axis + step * e) - drift(axis - step * e)) / (2 * step) for e in np.eye(3)]).T
        roots = np.linalg.eigvals(jacobian)
        if state.stable:
            assert np.abs(roots.imag).max() == pytest.approx(state.frequency, rel=1e-7)
        else:
            assert roots.real.max() > 0.1


def test_the_moon():
    """State 2, 1.54 degrees beyond the ecliptic's pole; the formula is the average over a Kepler orbit."""
    moon, earth = body("Moon"), body("Earth")
    ratio = moon.moment_ratio("polar", moon.adopted("j2").radius).value
    motion, node = 2 * np.pi / (27.321661 * DAY), precession.MOON_NODE_RATE
    share = earth.gravitational_parameter / (earth.gravitational_parameter + moon.gravitational_parameter)
    orbit = (motion, node, precession.MOON_INCLINATION, precession.MOON_ECCENTRICITY, 1.0, share)
    figure = (moon.value("j2"), moon.value("c22"))
    tilt = cassini.resonant_obliquity(ratio, *figure, *orbit)
    assert np.degrees(tilt - precession.MOON_INCLINATION) == pytest.approx(1.543, abs=0.01)
    assert cassini.moment_ratio_from_obliquity(tilt, *figure, *orbit) == pytest.approx(ratio, rel=1e-12)
    # As measured: C/(M R^2) of a body that is nearly uniform.
    measured = cassini.moment_ratio_from_obliquity(np.radians(1.543) + precession.MOON_INCLINATION, *figure, *orbit)
    assert measured == pytest.approx(ratio, rel=0.01)


def test_mercury():
    """State 1, at 2.04 +- 0.08 arc minutes: C/(M R^2) = 0.346 +- 0.014 (Margot et al. 2012)."""
    motion, node = 2 * np.pi / (87.9693496 * DAY), -2 * np.pi / (325513 * 365.25 * DAY)
    orbit = (motion, node, np.radians(8.6), 0.2056317, 1.5)
    figure = (5.031e-5, 0.809e-5)
    ratio = cassini.moment_ratio_from_obliquity(-np.radians(2.04 / 60), *figure, *orbit)
    assert ratio == pytest.approx(0.346, abs=0.014)
    assert 60 * np.degrees(cassini.resonant_obliquity(ratio, *figure, *orbit)) == pytest.approx(-2.04, rel=1e-10)
    with pytest.raises(ValueError, match="below 0 on the other side of the normal"):
        cassini.moment_ratio_from_obliquity(np.radians(2.04 / 60), *figure, *orbit)


@pytest.mark.parametrize("name", ["j2", "c22", "primary_share", "node_rate", "inclination"])
def test_a_figure_or_an_orbit_of_no_number_is_named(name):
    moon = {"j2": 2e-4, "c22": 2e-5, "mean_motion": 2.7e-6, "node_rate": -1.1e-8, "inclination": 0.09}
    with pytest.raises(ValueError, match=f"{name}.* must be finite, not"):
        cassini.resonant_obliquity(0.393, **moon | {name: np.nan})


@pytest.mark.parametrize("orbit", [(0.0, -1.0, 0.1), (1.0, 0.0, 0.1), (1.0, -1.0, 0.0), (1.0, -1.0, 2.0)])
def test_what_has_no_states_is_refused(orbit):
    with pytest.raises(ValueError, match="Cassini states need"):
        cassini.cassini_states(*orbit)


def test_hansen_coefficients_of_high_resonances():
    """At e = 0 only p = 1 has strength. Others by mpmath's quadrature; 16 points take a fast turn for a slow one."""
    assert [abs(cassini.hansen_coefficient(0.0, p)) < 1e-14 for p in (17, -15, 33, 9, 16.5)] == [True] * 5
    assert abs(cassini.hansen_coefficient(0.01, 17)) < 1e-14
    assert cassini.hansen_coefficient(0.9, 30) == pytest.approx(9.37676494098853, rel=1e-12)
