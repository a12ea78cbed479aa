"""Companions of a body as a REBOUND simulation, and back."""

import math

import mpmath
import numpy as np
import pytest
import rebound

from astroinertia.orbits.simulation import BARYCENTRE, BODY, Companion, companions, in_code_units, simulation
from astroinertia.orbits.states import present, states
from astroinertia.units import GRAVITATIONAL_CONSTANT, CodeUnits

EARTH, MOON, SUN = 5.9722e24, 7.346e22, 1.98841e30
DAY = 86400.0


def close(one, other, tolerance=1e-11):
    return all(
        getattr(one, name) == pytest.approx(getattr(other, name), rel=tolerance, abs=tolerance)
        for name in ("mass", "eccentricity", "inclination", "node", "pericentre", "mean_anomaly")
    )


def earth_moon_sun(sun_around="body"):
    return [
        Companion(
            "moon", MOON, period=27.321661 * DAY, eccentricity=0.0549, inclination=0.0898, node=2.1, pericentre=5.5,
            mean_anomaly=2.3,
        ),
        Companion(
            "sun", SUN, sun_around, semi_major_axis=1.495978707e11, eccentricity=0.0167, inclination=0.01,
            node=0.4, pericentre=1.8, mean_anomaly=0.1,
        ),
    ]  # fmt: skip


@pytest.mark.parametrize("sun_around", ["body", "moon", BARYCENTRE])
def test_elements_go_in_and_come_back(sun_around):
    given = earth_moon_sun(sun_around)
    bodies = simulation(EARTH, given, GRAVITATIONAL_CONSTANT)
    moon, sun = companions(bodies, {"sun": sun_around})
    assert close(moon, given[0])
    assert close(sun, given[1], 1e-9)
    period = 2 * math.pi * math.sqrt(moon.semi_major_axis**3 / (GRAVITATIONAL_CONSTANT * (EARTH + MOON)))
    assert period == pytest.approx(given[0].period, rel=1e-12)
    assert sun.semi_major_axis == pytest.approx(given[1].semi_major_axis, rel=1e-11)


@pytest.mark.parametrize("eccentricity", [0.0, 1e-12, 1e-6, 0.3, 0.99])
@pytest.mark.parametrize("inclination", [0.0, 1e-12, 1e-8, 1e-5, 0.5 * math.pi, math.pi - 1e-8, math.pi])
def test_elements_of_circles_and_of_orbits_that_hardly_tilt_are_those_of_where_the_companion_is(
    eccentricity, inclination
):
    # By arccosines, a companion on a circle may come back on its other side, and a tilt of 1e-8 is lost.
    for mean_anomaly in (0.0, 1e-6, 1.0, 3.14159, 5.0):
        given = Companion(
            "moon", 0.01, semi_major_axis=60.0, eccentricity=eccentricity, inclination=inclination, node=2.0,
            pericentre=0.7, mean_anomaly=mean_anomaly,
        )  # fmt: skip
        one = simulation(1.0, [given])
        other = simulation(1.0, companions(one))
        for found, wanted in zip(present(other), present(one), strict=True):
            assert np.linalg.norm(found - wanted) < 1e-13 * np.linalg.norm(wanted)


@pytest.mark.parametrize("gap", [0.5, 1e-2, 1e-4, 1e-8])
@pytest.mark.parametrize("mean_anomaly", [0.0, 1e-12, 1e-3, 2.0])
def test_places_on_long_ellipses_are_those_of_keplers_equation(gap, mean_anomaly):
    """By mpmath; REBOUND's own are 1e-10 off at e = 0.9999."""
    given = Companion("comet", 0.25, period=3.0, eccentricity=1.0 - gap, mean_anomaly=mean_anomaly, inclination=0.4)
    place, speed = (values[0] for values in present(simulation(2.0, [given])))
    with mpmath.workdps(50):
        e, low, high = mpmath.mpf(given.eccentricity), mpmath.mpf(0), mpmath.pi
        axis = mpmath.cbrt(2.25 * (3 / (2 * mpmath.pi)) ** 2)
        for _ in range(180):
            middle = (low + high) / 2
            low, high = (low, middle) if middle - e * mpmath.sin(middle) > mean_anomaly else (middle, high)
        along, across = mpmath.cos(low) - e, mpmath.sqrt(1 - e * e) * mpmath.sin(low)
        pace = mpmath.sqrt(2.25 / axis) / (1 - e * mpmath.cos(low))
        velocity = pace * -mpmath.sin(low), pace * mpmath.sqrt(1 - e * e) * mpmath.cos(low)
        wanted = [[float(x), float(y * mpmath.cos(0.4)), float(y * mpmath.sin(0.4))]
                  for x, y in ((axis * along, axis * across), velocity)]  # fmt: skip
    for found, exact in zip((place, speed), wanted, strict=True):
        assert np.linalg.norm(found - exact) < 1e-14 * np.linalg.norm(exact)


@pytest.mark.parametrize("name", [None, "star"])
def test_companions_of_a_simulation_of_ones_own_go_around_its_first_particle(name):
    bodies = rebound.Simulation()
    bodies.add(m=1.0) if name is None else bodies.add(m=1.0, name=name)
    bodies.add(m=1e-3, a=2.0, e=0.1, inc=0.2, Omega=0.3, omega=0.4, M=0.5)
    bodies.add(m=1e-4, a=0.02, e=0.2, primary=bodies.particles[1], name="moon")
    planet, moon = companions(bodies, {"moon": "particle 1"})
    assert (planet.name, planet.around, moon.around) == ("particle 1", BODY, "particle 1")
    assert close(planet, Companion("planet", 1e-3, BODY, None, None, 2.0, None, 0.1, 0.2, 0.3, 0.4, 0.5))
    assert (planet.semi_major_axis, moon.semi_major_axis) == pytest.approx((2.0, 0.02), rel=1e-11)


def test_the_centre_of_mass_is_at_rest_at_the_origin():
    bodies = simulation(EARTH, earth_moon_sun(), GRAVITATIONAL_CONSTANT)
    centre = bodies.com()
    assert np.abs(centre.xyz).max() < 1e-15 * 1.5e11
    assert np.abs(centre.vxyz).max() < 1e-15 * 3e4
    assert [particle.name for particle in bodies.particles] == ["body", "moon", "sun"]


def test_positions_and_velocities_are_relative_to_what_a_companion_goes_around():
    star = Companion("star", 3.0, position=(10.0, 0.0, 0.0), velocity=(0.0, 0.5, 0.0))
    planet = Companion("planet", 0.1, "star", position=(0.0, 1.0, 2.0), velocity=(0.1, 0.0, 0.0))
    particles = simulation(1.0, [star, planet]).particles
    assert np.subtract(particles[2].xyz, particles[1].xyz) == pytest.approx([0.0, 1.0, 2.0])
    assert np.subtract(particles[2].vxyz, particles[0].vxyz) == pytest.approx([0.1, 0.5, 0.0])


def test_units_change_nothing_but_the_numbers():
    units = CodeUnits(mass=EARTH, length=6.371e6)
    given = earth_moon_sun()
    in_si = simulation(EARTH, given, GRAVITATIONAL_CONSTANT)
    in_code = simulation(1.0, in_code_units(given, units))
    for one, other in zip(in_si.particles, in_code.particles, strict=True):
        assert units.to_si(np.array(other.xyz), "length") == pytest.approx(one.xyz, rel=1e-12, abs=1e-3)
        assert units.to_si(np.array(other.vxyz), "velocity") == pytest.approx(one.vxyz, rel=1e-12, abs=1e-10)


def test_whfast_takes_a_fortieth_of_the_shortest_period():
    bodies = simulation(EARTH, earth_moon_sun(), GRAVITATIONAL_CONSTANT, integrator="whfast")
    assert bodies.dt == pytest.approx(27.321661 * DAY / 40)
    assert simulation(EARTH, earth_moon_sun(), GRAVITATIONAL_CONSTANT, "whfast", 100.0).dt == 100.0


def test_what_contradicts_is_refused_in_a_sentence():
    with pytest.raises(ValueError, match="one of semi_major_axis and period"):
        Companion("moon", 1.0)
    with pytest.raises(ValueError, match="and not both"):
        Companion("moon", 1.0, period=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="eccentricity 1"):
        Companion("moon", 1.0, period=1.0, eccentricity=1.0)
    with pytest.raises(ValueError, match="not listed before"):
        simulation(1.0, [Companion("moon", 1.0, "sun", period=1.0)])
    with pytest.raises(ValueError, match="two bodies"):
        simulation(1.0, [Companion("moon", 1.0, period=1.0), Companion("moon", 1.0, period=2.0)])
    passing = simulation(1.0, [Companion("comet", 0.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 2.0, 0.0))])
    with pytest.raises(ValueError, match="no bound orbit"):
        companions(passing)
    with pytest.raises(ValueError, match="which has no mass"):
        simulation(0.0, [Companion("mote", 1.0, period=1.0)])
    weightless = simulation(0.0, [Companion("mote", 0.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))])
    with pytest.raises(ValueError, match="neither has a mass"):
        companions(weightless)


def test_states_at_a_list_of_times_are_those_at_an_array():
    orbit = [Companion("moon", 0.1, semi_major_axis=1.0, eccentricity=0.2)]
    by_list, by_array = (states(simulation(1.0, orbit), times) for times in ([0.0, 3], np.array([0.0, 3.0])))
    assert np.array_equal(by_list, by_array)
