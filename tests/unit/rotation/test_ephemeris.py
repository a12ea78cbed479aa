"""Orbits as polynomials: they meet Kepler's ellipses and REBOUND's own positions, inside compiled code too."""

import jax
import numpy as np
import pytest

from astroinertia.errors import NumericalError
from astroinertia.orbits import dense
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.orbits.states import states
from astroinertia.rotation.ephemeris import ephemeris, ephemeris_of

ELEMENTS = {"inclination": 0.3, "node": 1.0, "pericentre": 2.0}


def kepler(eccentricity, times, mean_anomaly=0.0):
    """Position and velocity in the plane of the orbit, GM = a = 1, by bisection of Kepler's equation."""
    mean = np.asarray(times) + mean_anomaly
    low, high = mean - 1.0, mean + 1.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        late = middle - eccentricity * np.sin(middle) > mean
        low, high = np.where(late, low, middle), np.where(late, middle, high)
    cosine, sine, axis = np.cos(low), np.sin(low), np.sqrt(1.0 - eccentricity**2)
    rate = 1.0 / (1.0 - eccentricity * cosine)
    return (
        np.stack([cosine - eccentricity, axis * sine], axis=-1),
        np.stack([-sine * rate, axis * cosine * rate], axis=-1),
    )


def turned(plane):
    """From the plane of the orbit to space: pericentre about z, inclination about x, node about z."""

    def about(axis, angle):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[one, one] = matrix[other, other] = np.cos(angle)
        matrix[other, one], matrix[one, other] = np.sin(angle), -np.sin(angle)
        return matrix

    matrix = about(2, ELEMENTS["node"]) @ about(0, ELEMENTS["inclination"]) @ about(2, ELEMENTS["pericentre"])
    return plane @ matrix[:, :2].T


@pytest.mark.parametrize("eccentricity", [0.0, 0.3, 0.9])
def test_an_ellipse_is_met_at_any_time(eccentricity):
    orbit = Companion(
        "moon", 0.25, semi_major_axis=1.0, eccentricity=eccentricity, mean_anomaly=0.5, **ELEMENTS
    )  # fmt: skip
    found = ephemeris(simulation(0.75, [orbit]), 20.0)
    times = np.linspace(0.0, 20.0, 997)
    with jax.enable_x64(True):
        position, velocity = (np.asarray(part(times))[:, 0] for part in (found.position, found.velocity))
    place, speed = map(turned, kepler(eccentricity, times, 0.5))
    # Near the pericentre the time itself, in double precision, moves the place by 1e-14 of the distance.
    assert np.abs(position - place).max() < 5e-13
    assert (np.abs(velocity - speed).max(axis=1) / np.linalg.norm(speed, axis=1)).max() < 3e-11
    assert float(found.error) < 1e-13
    assert found.names == ("moon",)
    assert found.mass == pytest.approx([0.25])


@pytest.mark.slow
def test_compiled_code_reads_all_bodies_as_rebound_has_them():
    bodies = simulation(
        1.0,
        [
            Companion("moon", 0.0123, semi_major_axis=1.0, eccentricity=0.055, **ELEMENTS),
            Companion("sun", 332946.0, semi_major_axis=389.0, eccentricity=0.0167, mean_anomaly=1.0),
        ],
    )
    # Steps as those of the table: other ones move the moon by up to 3e-12 of its distance, in REBOUND itself. By 4e-13
    # to 4e-12 it is off for elements that differ in their last bits.
    bodies.integrator.epsilon = dense.EPSILON
    found = ephemeris(bodies, 40.0)
    assert bodies.t == 0.0
    times = np.sort(np.random.default_rng(1).uniform(0.0, 40.0, 50))
    place, speed = states(bodies, times)
    with jax.enable_x64(True):
        read = jax.jit(jax.vmap(lambda table, t: (table.position(t), table.velocity(t)), (None, 0)))
        position, velocity = map(np.asarray, read(found, times))
    distance, pace = (np.linalg.norm(part, axis=-1, keepdims=True) for part in (place, speed))
    assert np.abs((position - place) / distance).max() < 5e-12
    assert np.abs((velocity - speed) / pace).max() < 5e-12


@pytest.mark.slow
def test_positions_and_velocities_are_continuous_between_segments():
    found = ephemeris(simulation(1.0, [Companion("moon", 0.01, period=1.0, eccentricity=0.5)]), 3.0)
    edges = (found.middle + found.half_length)[:-1]
    assert len(edges) > 10
    with jax.enable_x64(True):
        for part in (found.position, found.velocity):
            before, after = np.asarray(part(edges * (1.0 - 4e-16))), np.asarray(part(edges * (1.0 + 4e-16)))
            assert np.abs(after - before).max() < 1e-13 * np.abs(before).max()


def test_who_comes_near_is_known_with_the_time():
    """On an ellipse from its far end: at the radius r, where cos E = (1 - r/a)/e."""
    far = Companion("far", 0.0, semi_major_axis=5.0)
    near = Companion("near", 0.0, semi_major_axis=1.0, eccentricity=0.5, mean_anomaly=np.pi)
    orbits = ephemeris(simulation(1.0, [far, near]), np.pi)
    assert orbits.within(0.499) is None
    time, number = orbits.within(0.8)
    anomaly = np.arccos((1.0 - 0.8) / 0.5)
    assert number == 1 and np.linalg.norm(orbits.position(np.array(time))[1]) < 0.8
    assert 0.0 <= time - (np.pi - (anomaly - 0.5 * np.sin(anomaly))) < 2e-4


def test_outside_its_time_an_ephemeris_knows_nothing():
    found = ephemeris(simulation(1.0, [Companion("moon", 0.01, period=1.0)]), 3.0)
    with jax.enable_x64(True):
        known = np.isfinite(np.asarray(found.position(np.array([-1e-9, 0.0, 1.5, 3.0, 3.0 + 1e-9])))).all(axis=(1, 2))
    assert known.tolist() == [False, True, True, True, False]


@pytest.mark.parametrize("integrator", ["ias15", "whfast"])
def test_a_table_to_a_later_end_has_the_same_places(integrator):
    """To the bit, at the edges of its segments, too: a run that is to go further has the orbits that it had."""
    pair = [
        Companion("moon", 0.01, period=1.0, eccentricity=0.3),
        Companion("sun", 300.0, period=13.0, eccentricity=0.1),
    ]
    bodies = simulation(1.0, pair, integrator=integrator)
    short, long = ephemeris(bodies, 3.3), ephemeris(bodies, 20.0)
    edges = (short.middle + short.half_length)[:-1]
    times = np.concatenate([[0.0], edges, np.random.default_rng(1).uniform(0.0, 3.3, 2000), [3.3]])
    assert len(edges) > 10
    np.testing.assert_array_equal(short.position(times), long.position(times))
    np.testing.assert_array_equal(short.velocity(times), long.velocity(times))


@pytest.mark.slow
def test_whfast_steps_evenly_and_keeps_the_orbit():
    planets = [
        Companion("inner", 1e-4, semi_major_axis=1.0, eccentricity=0.05),
        Companion("outer", 1e-4, semi_major_axis=2.2, eccentricity=0.05, mean_anomaly=2.0),
    ]
    end = 300.0
    by_whfast = ephemeris(simulation(1.0, planets, integrator="whfast"), end)
    by_ias15 = ephemeris(simulation(1.0, planets), end)
    assert np.ptp(by_whfast.half_length) == 0.0
    assert float(by_whfast.error) < 1e-8
    times = np.linspace(0.0, end, 500)
    with jax.enable_x64(True):
        apart = np.asarray(by_whfast.position(times)) - np.asarray(by_ias15.position(times))
    assert np.abs(apart).max() < 1e-6


@pytest.mark.full
def test_whfast_does_not_follow_heavy_bodies_that_meet():
    """Pieces of one length would be thousands for each of its steps: a table of 131072 pieces took 82 s."""
    iron = Companion("iron", 3.468, period=1.041, node=0.1697)
    rock = Companion("rock", 4.853, period=2.603, eccentricity=0.6168, inclination=-0.0322)
    with pytest.raises(NumericalError, match=r"WHFast does not follow these orbits: .* take ias15"):
        ephemeris(simulation(7.827, [iron, rock], integrator="whfast"), 6.129)
    narrow = simulation(1.0, [Companion("comet", 1e-3, semi_major_axis=1.0, eccentricity=0.99)], integrator="whfast")
    assert float(ephemeris(narrow, 7.0).error) < 1e-8


@pytest.mark.parametrize("share", [1.0001, 0.0, -1.0])
def test_velocities_that_are_not_those_of_the_places_are_refused_at_once(share):
    """The second companion's from a time on; shorter segments, of which there would be millions, do not help."""

    def circle(times, rate=1.0, distance=1.0):
        return distance * np.stack([np.cos(rate * times), np.sin(rate * times), 0.0 * times], axis=-1)

    asked = 0

    def states(times):
        nonlocal asked
        asked += 1
        right = 0.6 * circle(times + 2.5 * np.pi, 0.2)
        there = np.where((times > 50.0)[:, None], share, 1.0) * right
        return (
            np.stack([circle(times), circle(times, 0.2, 3.0)], axis=1),
            np.stack([circle(times + 0.5 * np.pi), there], axis=1),
        )

    with pytest.raises(ValueError, match=r"velocity of sun at [56]\d.* is \(.*, and its position changes by \("):
        ephemeris_of(states, 0.0, 100.0, {"moon": 0.01, "sun": 1.0})
    assert asked < 100


def test_a_narrow_ellipse_has_the_velocities_of_its_places():
    def states(times):
        return tuple(np.pad(part, ((0, 0), (0, 1)))[:, None] for part in kepler(0.99, times))

    assert float(ephemeris_of(states, 1.0, 9.0, {"comet": 0.0}, 1e-12).error) < 1e-12


@pytest.mark.parametrize("eccentricity", [0.995, 0.999, 0.9999])
@pytest.mark.parametrize("start", [np.pi, 0.0, -8.0, 3.0 + 200.0 * np.pi])
def test_a_comet_that_is_slow_where_its_orbit_begins_has_the_velocities_of_its_places(eccentricity, start):
    """The first segment is as long as suits its speed there, and its pericentre lies anywhere within it."""

    def states(times):
        return tuple(np.pad(part, ((0, 0), (0, 1)))[:, None] for part in kepler(eccentricity, times))

    digit = 2.0 * np.spacing(abs(start)) * (1.0 - eccentricity) ** -1.5  # of the time, over that of the pericentre
    if digit > 1e-8:
        with pytest.raises(NumericalError, match=r"last digit of a time of 63\d.*, comet moves by .*; count time from"):
            ephemeris_of(states, start, start + 2.0 * np.pi, {"comet": 0.0})
        return
    orbit = ephemeris_of(states, start, start + 2.0 * np.pi, {"comet": 0.0})
    times = start + 2.0 * np.pi * np.linspace(0.0, 1.0, 2001)
    there = states(times)[0][:, 0]
    apart = np.linalg.norm(np.asarray(orbit.position(times))[:, 0] - there, axis=1) / np.linalg.norm(there, axis=1)
    assert apart.max() < 1e-8 + digit


def test_what_cannot_be_tabulated_is_refused():
    bodies = simulation(1.0, [Companion("moon", 0.01, period=1.0, eccentricity=0.5)])
    with pytest.raises(ValueError, match="not after its start"):
        ephemeris(bodies, 0.0)
    with pytest.raises(ValueError, match="needs a companion"):
        ephemeris(simulation(1.0, []), 1.0)
    with pytest.raises(NumericalError, match=r"cannot be tabulated to 1\.0e-18 of the distance"):
        ephemeris(bodies, 1.0, tolerance=1e-18)


def test_orbits_of_a_function_that_are_no_numbers_are_refused():
    def fall(times, of=1.0):
        """From rest, so that no time scale follows from its speed at first."""
        x, v = 2.0 + np.cos(times), -np.sin(times)
        return tuple(np.stack([of * part, 0.0 * times, 0.0 * times], axis=-1)[:, None] for part in (x, v))

    moon = {"moon": 0.01}
    assert ephemeris_of(fall, 0.0, 20.0, moon).position(np.array([3.0]))[0, 0, 0] == pytest.approx(2.0 + np.cos(3.0))
    for of in (np.nan, 0.0):
        with pytest.raises(ValueError, match="all states must be finite, and no companion where the body is"):
            ephemeris_of(lambda times, of=of: fall(times, of), 0.0, 20.0, moon)
    for end in (np.inf, np.nan, -1.0):
        with pytest.raises(ValueError, match="which is no time after its start at 0"):
            ephemeris_of(fall, 0.0, end, moon)
    with pytest.raises(ValueError, match=r"states of 2 companions at one time are \(1, 2, 3\), not \(1, 1, 3\)"):
        ephemeris_of(fall, 0.0, 20.0, {**moon, "other": 0.1})


def test_bodies_whose_distance_is_rounded_away_are_reported():
    """About the common centre of mass, which a light body moves if it is far enough away."""
    near, far = Companion("near", 23.0, semi_major_axis=0.08), Companion("far", 1e-3, semi_major_axis=1e34)
    with pytest.raises(NumericalError, match="rounded away beside the distance of another"):
        ephemeris(simulation(0.5, [near, far]), 1e3)
