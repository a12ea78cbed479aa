"""Cassini's laws from the integrated rotation of the Moon: locked, leaning by a constant angle, all in one plane."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies import j2000
from astroinertia.bodies.planets import body
from astroinertia.effects.kinds.gravity_gradient import GravityGradient
from astroinertia.models.rigid import body as rigid, splitting
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.rotation import cassini, precession
from astroinertia.rotation.attitude import attitude_of_quaternion, quaternion
from astroinertia.rotation.ephemeris import ephemeris

DAY = 86400.0
NODE, LONGITUDE = np.radians([125.04455501, 218.31664563])  # mean, of the Moon at J2000: Simon et al. 1994


@pytest.mark.full
def test_the_moon_stays_in_its_cassini_state():
    """Measured over 18.6 years: 1.555 degrees on average, 1.549 by the formula, 1.543 observed."""
    known, moon = j2000.states("Earth"), body("Moon")
    ours, sun = known["Moon"], known["Sun"]
    j2, c22 = moon.value("j2"), moon.value("c22")
    largest = moon.moment_ratio("polar", moon.adopted("j2").radius).value
    moments = np.array([largest - j2 - 2 * c22, largest - j2 + 2 * c22, largest])
    lean = np.radians(1.543)
    axis = np.array([-np.sin(lean) * np.sin(NODE), np.sin(lean) * np.cos(NODE), np.cos(lean)])
    towards = -np.array([np.cos(LONGITUDE), np.sin(LONGITUDE), 0.0])  # the Earth
    long_axis = towards - (towards @ axis) * axis
    long_axis /= np.linalg.norm(long_axis)
    with jax.enable_x64(True):
        others = [
            Companion(
                "Earth", j2000.EARTH_PARAMETER, position=tuple(-ours.position), velocity=tuple(-ours.velocity)
            ),
            Companion(
                "Sun", sun.gravitational_parameter, position=tuple(sun.position - ours.position),
                velocity=tuple(sun.velocity - ours.velocity),
            ),
        ]  # fmt: skip
        orbits = ephemeris(simulation(ours.gravitational_parameter, others), 6800 * DAY, 1e-9)
        turning = jax.tree.map(jnp.asarray, rigid.body(1.0, moments, effects=(GravityGradient(),), companions=orbits))
        state = splitting.rotor(
            quaternion(np.array([long_axis, np.cross(axis, long_axis), axis])),
            np.array([0.0, 0.0, largest * moon.angular_velocity]), jnp.zeros(1),
        )  # fmt: skip
        times = np.arange(0.0, 6795.0, 5.0) * DAY
        momenta, faces = [np.asarray(state.angular_momentum.value)], []
        for before, after in pairwise(times):
            state = splitting.advance(state, turning.rates, before, after, 20, 2, turning, rigid.kick)
            momenta.append(np.asarray(state.angular_momentum.value))
            faces.append(np.asarray(attitude_of_quaternion(state.quaternion))[0])
        place, speed = (np.asarray(each)[:, 0] for each in (orbits.position(times), orbits.velocity(times)))
    axes = np.array(momenta) / np.linalg.norm(momenta, axis=1, keepdims=True)
    normals = np.cross(place, speed)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    leaning = np.degrees(np.arccos(axes[:, 2]))
    share = j2000.EARTH_PARAMETER / (j2000.EARTH_PARAMETER + ours.gravitational_parameter)
    formula = cassini.resonant_obliquity(
        largest, j2, c22, 2 * np.pi / (27.321661 * DAY), precession.MOON_NODE_RATE, precession.MOON_INCLINATION,
        precession.MOON_ECCENTRICITY, 1.0, share,
    )  # fmt: skip
    assert leaning.mean() == pytest.approx(np.degrees(formula - precession.MOON_INCLINATION), abs=0.015)
    assert leaning.max() - leaning.min() < 0.05
    # The nodes of equator and orbit are opposite, while they go round once; and the Moon shows its one face.
    nodes = np.unwrap(np.arctan2(axes[:, 1], axes[:, 0])) - np.unwrap(np.arctan2(normals[:, 1], normals[:, 0]))
    apart = np.degrees(np.remainder(nodes, 2 * np.pi))
    assert apart.mean() == pytest.approx(180.0, abs=0.5) and np.abs(apart - 180.0).max() < 4.0
    shown = np.einsum("ti,ti->t", faces, place[1:] / np.linalg.norm(place[1:], axis=1, keepdims=True))
    assert np.degrees(np.arccos(shown.min())) < 12.0  # the optical librations, 8 and 7 degrees
