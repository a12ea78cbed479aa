"""Companions that come within a body on their orbits are found, as far as that is sure, and no others."""

import math
from typing import Any

import numpy as np
import pytest
import rebound

from astroinertia.orbits import states
from astroinertia.orbits.approach import pericentres_within
from astroinertia.orbits.simulation import Companion, simulation

RADIUS = 1.0


def least_distance(bodies: rebound.Simulation, end: float) -> float:
    """Of particle 1 from particle 0, by many places on the way."""
    least = math.inf
    for time in np.linspace(0.0, end, 401):
        bodies.integrate(time)
        least = min(least, float(np.linalg.norm(states.present(bodies)[0][0])))
    return least


def of_pericentre(bodies: rebound.Simulation) -> float:
    body: Any = bodies.particles[0]
    companion: Any = bodies.particles[1]
    orbit = companion.orbit(primary=body)
    return orbit.h**2 / (1.0 + orbit.e)


def test_one_that_moves_outwards_comes_in_when_kepler_has_it() -> None:
    a, e, f = 3.0, 0.9, 2.5
    mean = [2.0 * math.atan(math.sqrt((1.0 - e) / (1.0 + e)) * math.tan(0.5 * f)), math.acos((1.0 - RADIUS / a) / e)]
    out, back = (x - e * math.sin(x) for x in mean)
    comes = math.sqrt(a**3) * (2.0 * math.pi - out - back)
    bodies = rebound.Simulation()
    bodies.add(m=0.7)
    bodies.add(m=0.3, a=a, e=e, f=f)
    at = states.masses(bodies), *states.present(bodies), RADIUS
    assert np.isnan(pericentres_within(*at, comes * (1.0 - 1e-9))[0])
    assert pericentres_within(*at, comes * (1.0 + 1e-9))[0] == pytest.approx(a * (1.0 - e), rel=1e-12)


def test_one_that_falls_from_rest_comes_in_when_the_cycloid_has_it() -> None:
    """t = (d^3/(2 M))^(1/2) ((x (1 - x))^(1/2) + arccos x^(1/2)), x = r/d: an orbit as narrow as a line."""
    masses, place, x = np.array([1.1, 0.2]), np.array([[0.0, 4.0, 0.0]]), RADIUS / 4.0
    comes = math.sqrt(4.0**3 / 2.6) * (math.sqrt(x * (1.0 - x)) + math.acos(math.sqrt(x)))
    at = masses, place, 0.0 * place, RADIUS
    assert np.isnan(pericentres_within(*at, comes * (1.0 - 1e-6))[0])
    assert pericentres_within(*at, comes * (1.0 + 1e-6))[0] == 0.0


@pytest.mark.parametrize(
    "orbit",
    [
        {"a": 3.0, "e": 0.9, "f": 2.5, "inc": 0.4},
        {"a": 3.0, "e": 0.9, "f": -2.5},
        {"a": 3.0, "e": 0.6, "f": 2.0},  # stays outside
        {"a": 2.0, "e": 0.0},
        {"a": -2.0, "e": 1.3, "f": -1.8},
        {"a": -2.0, "e": 1.3, "f": 1.8},  # goes away
        {"a": -0.1, "e": 8.0, "f": -1.5},
        {"x": 5.0, "vy": 0.2, "vx": -0.6},
        {"x": 2.5},  # falls from rest
    ],
)
def test_those_that_come_within_before_the_end_are_found_and_no_others(orbit: dict[str, float]) -> None:
    for end in (1.0, 2.0, 3.0, 5.0, 15.0, 40.0):
        bodies = rebound.Simulation()
        bodies.add(m=0.7)
        bodies.add(m=0.3, **orbit)
        found = pericentres_within(states.masses(bodies), *states.present(bodies), RADIUS, end)[0]
        nearest = of_pericentre(bodies)
        if orbit != {"x": 2.5}:  # through the centre
            comes = least_distance(bodies, end) < RADIUS
        else:
            comes = end > 2.5**1.5 / 2**0.5 * (math.acos(0.4**0.5) + (0.4 * 0.6) ** 0.5)
        assert np.isfinite(found) == comes, end
        if comes:
            assert found == pytest.approx(nearest, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("planet", "comes"), [(1e3, False), (1e-6, True)])
def test_what_others_pull_elsewhere_is_not_found(planet: float, comes: bool) -> None:
    """Two moons of a planet that are at rest to each other do not fall on each other; without it they do."""
    masses, place = np.array([1.0, planet, 1e-3]), np.array([[-100.0, 0.0, 0.0], [0.0, 20.0, 0.0]])
    velocity = np.array([[0.0, -(((1.0 + planet) / 100.0) ** 0.5), 0.0], [0.0, 0.0, 0.0]])
    found = pericentres_within(masses, place, velocity, RADIUS, 1e4)
    assert np.isnan(found[0]) and np.isfinite(found[1]) == comes


@pytest.mark.parametrize(("share", "comes"), [(0.99, True), (1.01, False)])
def test_a_pull_that_can_just_lift_an_orbit_off_the_body_is_that_of_the_bound(share: float, comes: bool) -> None:
    """6 m S^2/D^3 for the time of the fall adds what is lacking of R (2 E + 2 M/R)^(1/2), with which it grazes.

    The companion comes in from S on an orbit of pericentre q and apocentre Q; the other begins at its own apocentre.
    """
    q, apocentre, start, away = 0.05, 25.0, 20.0, 100.0
    a, e = 0.5 * (apocentre + q), (apocentre - q) / (apocentre + q)
    momentum, energy = math.sqrt(a * (1.0 - e * e)), -0.5 / a
    here, there = (math.acos((1.0 - r / a) / e) for r in (start, RADIUS))
    time = a**1.5 * (here - e * math.sin(here) - there + e * math.sin(there))
    lacks = RADIUS * math.sqrt(2.0 * (energy + 1.0 / RADIUS)) - momentum
    other = share * lacks / (6.0 * start**2 / away**3 * time)
    across = momentum / start
    place = np.array([[3.0 * away, 0.0, 0.0], [0.0, start, 0.0]])
    fall = -math.sqrt(2.0 * (energy + 1.0 / start) - across**2)
    velocity = np.array([[0.0, math.sqrt((1.0 + other) / (6.0 * away)), 0.0], [across, fall, 0.0]])
    found = pericentres_within(np.array([1.0, other, 0.0]), place, velocity, RADIUS, 2.0 * time)
    assert np.isnan(found[0]) and np.isfinite(found[1]) == comes


def test_what_goes_round_a_companion_does_not_come_within_the_body() -> None:
    """A probe of the Moon against its motion is at rest to the Earth's sides, and on no orbit of the Earth's."""
    moon = Companion("moon", 0.0123, semi_major_axis=60.3)
    probe = Companion("probe", 0.0, around="moon", semi_major_axis=0.7, inclination=math.pi)
    bodies = simulation(1.0, [moon, probe])
    found = pericentres_within(states.masses(bodies), *states.present(bodies), RADIUS, 2000.0)
    assert np.isnan(found).all()
    bodies.integrate(2000.0)
    place = states.present(bodies)[0]
    assert np.linalg.norm(place[1] - place[0]) == pytest.approx(0.7, rel=1e-3)
    # From rest and beside a Moon without a mass it falls.
    masses, places, speeds = states.masses(bodies) * [1.0, 0.0, 1.0], *states.present(bodies)
    still = np.array([speeds[0], np.zeros(3)])
    assert np.isfinite(pericentres_within(masses, places, still, RADIUS, 2000.0)[1])


def test_an_orbit_that_grazes_the_body_is_not_found() -> None:
    for angle in np.linspace(0.0, 6.0, 25):
        outward, along = (
            np.array([[np.cos(angle), np.sin(angle), 0.0]]),
            np.array([[-np.sin(angle), np.cos(angle), 0.0]]),
        )
        for speed in (1.0, 1.2, 2.0):
            assert np.isnan(pericentres_within(np.array([1.0, 0.0]), outward, speed * along, RADIUS, 100.0)[0])
