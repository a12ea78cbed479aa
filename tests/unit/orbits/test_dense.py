"""Orbits between the steps of REBOUND, against REBOUND stopped at each time."""

import numpy as np
import pytest
import rebound

from astroinertia.orbits.dense import EPSILON, DenseOrbits


def bodies(eccentricity, true_anomaly=0.0):
    """Three point masses, at a time that is not 0."""
    made = rebound.Simulation()
    made.G, made.t = 2.0, 5.0
    made.add(m=1.0, x=3.0, vy=0.2)
    made.add(m=0.3, a=1.0, e=eccentricity, f=true_anomaly, primary=made.particles[0])
    made.add(m=0.01, a=6.0, e=0.2, inc=0.4)
    return made


def stopped_at(simulation, time):
    """Positions and velocities relative to particle 0 of a copy that is stopped at a time."""
    stopped = simulation.copy()
    stopped.integrator.epsilon = EPSILON
    stopped.t = 0.0
    stopped.integrate(time)
    states = np.empty((stopped.N, 6))
    stopped.serialize_particle_data(xyzvxvyvz=states)
    return np.split(states[1:] - states[0], 2, axis=1)


@pytest.mark.parametrize("eccentricity", [0.0, 0.3, 0.9, 0.99])
def test_places_and_velocities_are_those_of_rebound_at_any_time(eccentricity):
    """To twice what was found of any, through the pericentre, where steps are shortest; asked for in two goes."""
    begun = bodies(eccentricity, true_anomaly=-2.5)
    orbits = DenseOrbits(begun)
    for times in (np.linspace(0.0, 0.4, 41), np.linspace(0.4, 1.6, 41)):
        for time, place, speed in zip(times, *orbits.at(times), strict=True):
            known, moving = stopped_at(begun, time)
            distance, fastest = (np.linalg.norm(part, axis=1) for part in (known, moving))
            assert (np.linalg.norm(place - known, axis=1) / distance).max() < 2e-14
            assert (np.linalg.norm(speed - moving, axis=1) / fastest).max() < 4e-12
    assert begun.t == 5.0  # the simulation itself stays


def test_time_begins_again_where_what_is_before_is_left():
    """The same places, to the rounding of a step's length, whatever was left behind."""
    begun = bodies(0.6)
    whole, left = DenseOrbits(begun), DenseOrbits(begun)
    at_once, _ = whole.at(np.linspace(0.0, 3.0, 31))
    for number in range(30):
        place, _ = left.at(np.array([0.0, 0.1]))
        np.testing.assert_allclose(place, at_once[number : number + 2], rtol=0, atol=1e-12)
        left.leave(0.1)
    assert len(left._begin) < len(whole._begin)


def test_the_beginning_may_be_all_that_is_asked_for():
    begun = bodies(0.3)
    orbits = DenseOrbits(begun)
    place, speed = orbits.at(np.zeros(1))
    known, moving = stopped_at(begun, 0.0)
    np.testing.assert_allclose(place[0], known, rtol=0, atol=1e-15)
    np.testing.assert_allclose(speed[0], moving, rtol=0, atol=1e-14)
    orbits.leave(0.0)
    np.testing.assert_allclose(orbits.at(np.array([0.5]))[0][0], stopped_at(begun, 0.5)[0], rtol=0, atol=1e-13)


@pytest.mark.parametrize("integrator", ["mercurius", "leapfrog", "bs"])
def test_a_simulation_of_any_integrator_is_followed(integrator):
    begun, times = bodies(0.3), np.linspace(0.0, 1.0, 11)
    known, _ = DenseOrbits(begun).at(times)
    begun.integrator = integrator
    place, _ = DenseOrbits(begun).at(times)
    np.testing.assert_allclose(place, known, rtol=0, atol=1e-13)
    assert str(begun.integrator) == integrator
