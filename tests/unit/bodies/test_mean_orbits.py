"""Mean orbits of planets and moons: held to where the planets were at J2000, and to the masses of their moons."""

import numpy as np
import pytest

from astroinertia.bodies.j2000 import states
from astroinertia.bodies.mean_orbits import mass_of, mean_companions
from astroinertia.bodies.planets import body
from astroinertia.units import quantity


@pytest.mark.parametrize("name", ["Venus", "Earth", "Mars", "Jupiter", "Saturn", "Uranus", "Neptune"])
def test_planets_were_within_their_mean_orbits_at_j2000(name):
    sun = mean_companions(name)[0]
    axis, eccentricity = quantity(sun["semi_major_axis"], "length"), float(sun["eccentricity"])
    place = states("Sun")[name].position
    assert 0.99 * axis * (1 - eccentricity) < np.linalg.norm(place) < 1.01 * axis * (1 + eccentricity)
    speed = np.linalg.norm(states("Sun")[name].velocity)
    parameter = body("Sun").gravitational_parameter
    assert 1.0 / (2.0 / np.linalg.norm(place) - speed**2 / parameter) == pytest.approx(axis, rel=0.01)


@pytest.mark.parametrize(
    ("planet", "moon", "days"),
    [("Earth", "Moon", 27.3217), ("Mars", "Phobos", 0.31891), ("Mars", "Deimos", 1.26244), ("Jupiter", "Io", 1.769138),
     ("Jupiter", "Callisto", 16.689018),
     ("Uranus", "Titania", 8.705872), ("Uranus", "Ariel", 2.520379), ("Neptune", "Triton", 5.876854),
     ("Saturn", "Titan", 15.945), ("Saturn", "Iapetus", 79.3215)],
)  # fmt: skip
def test_moons_go_round_in_their_sidereal_periods(planet, moon, days):
    orbits = {companion["name"]: companion for companion in mean_companions(planet)}
    axis = quantity(orbits[moon]["semi_major_axis"], "length")
    parameter = body(planet).gravitational_parameter * (1 + orbits[moon]["mass"] / body(planet).mass)
    assert 2 * np.pi * np.sqrt(axis**3 / parameter) / 86400 == pytest.approx(days, rel=5e-3)


def test_masses_are_of_either_table():
    assert mass_of("Titan") == body("Titan").mass
    assert mass_of("Rhea") == pytest.approx(2.3065e21, rel=1e-3)
    assert mass_of("Phobos") == pytest.approx(1.06e16, rel=0.01)
    assert mass_of("Triton") == pytest.approx(2.14e22, rel=0.01)
    with pytest.raises(KeyError, match="no table has the mass of Vulcan"):
        mass_of("Vulcan")


def test_a_body_without_an_orbit_has_no_companions():
    assert mean_companions("Sun") == []
    assert mean_companions("Ceres") == []
