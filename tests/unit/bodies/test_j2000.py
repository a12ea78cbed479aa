"""Where bodies were at J2000, against another library's ephemeris and against Kepler's orbits."""

import erfa
import numpy as np
import pytest

from astroinertia.bodies import j2000
from astroinertia.bodies.planets import solar_system

AU, DAY = 149597870700.0, 86400.0


def test_sun_and_moon_are_where_sofa_has_them():
    turn = j2000.ecliptic_axes()
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
    known = j2000.states("Earth")
    moon = erfa.moon98(2451545.0, 0.0)
    np.testing.assert_allclose(known["Moon"].position, turn @ (AU * np.array(moon["p"])), atol=2e4)  # 10 arc seconds
    np.testing.assert_allclose(known["Moon"].velocity, turn @ (AU / DAY * np.array(moon["v"])), atol=0.05)
    earth = erfa.epv00(2451545.0, 0.0)[0]
    np.testing.assert_allclose(known["Sun"].position, -turn @ (AU * np.array(earth["p"])), atol=2e4)
    np.testing.assert_allclose(known["Sun"].velocity, -turn @ (AU / DAY * np.array(earth["v"])), atol=0.02)


@pytest.mark.parametrize(
    ("name", "axis"),
    [("Mercury", 0.387098), ("Venus", 0.723330), ("Earth", 1.000001), ("Mars", 1.523679), ("Jupiter", 5.2026),
     ("Saturn", 9.5549), ("Uranus", 19.2184), ("Neptune", 30.1104)],
)  # fmt: skip
def test_planets_have_their_orbits_about_the_sun(name, axis):
    """Semi-major axes of Simon et al. 1994; those of the outer planets swing by the Sun's motion about the centre."""
    known = j2000.states("Sun")
    sun = j2000.states(name)["Sun"]
    one = known[name]
    if name != "Earth":  # about the Sun it goes with the Moon, as one
        np.testing.assert_allclose(one.position, -sun.position, rtol=1e-14)
    total = sun.gravitational_parameter + one.gravitational_parameter
    energy = 0.5 * one.velocity @ one.velocity - total / np.linalg.norm(one.position)
    assert -0.5 * total / energy / AU == pytest.approx(axis, rel=3e-4 if axis < 3 else 0.02)
    assert solar_system()[name].gravitational_parameter == pytest.approx(
        one.gravitational_parameter, rel=0.013
    )  # moons


def test_axes_are_the_callers_and_unknown_bodies_refused():
    plain = j2000.states("Mars", np.eye(3))
    np.testing.assert_allclose(
        j2000.ecliptic_axes() @ plain["Sun"].position, j2000.states("Mars")["Sun"].position, rtol=1e-15
    )
    assert set(plain) == {"Sun", "Earth", "Mercury", "Venus", "Jupiter", "Saturn", "Uranus", "Neptune"}
    for name in ("Moon", "Pluto"):
        with pytest.raises(KeyError, match="orbits about"):
            j2000.states(name)
