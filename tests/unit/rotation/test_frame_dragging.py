"""Lense-Thirring precession against the acceleration itself, averaged over an orbit, and against what was measured."""

import astropy.units as u
import numpy as np
import pytest

from astroinertia.bodies.planets import body
from astroinertia.rotation import frame_dragging as dragging
from astroinertia.rotation.precession import ARCSECOND_PER_YEAR, JULIAN_YEAR, geodesic_precession
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SPEED_OF_LIGHT

G, C = GRAVITATIONAL_CONSTANT, SPEED_OF_LIGHT
MAS = ARCSECOND_PER_YEAR / 1e3
EARTH = body("Earth")
SPIN = (
    EARTH.moment_ratio("polar", EARTH.equatorial_radius).value
    * EARTH.mass
    * EARTH.equatorial_radius**2
    * EARTH.angular_velocity
)


def test_node_and_pericentre_turn_as_the_force_says():
    """dL/dt = r x f and that of Laplace's vector, f = (2 G/(c^2 r^3)) (3 (r.J) r x v/r^2 + v x J), over an orbit."""
    mu, a, e, lean, momentum = 4e14, 1.2e7, 0.3, 0.7, np.array([0.0, 0.0, 6e33])
    anomaly = 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    n, root = np.sqrt(mu / a**3), np.sqrt(1 - e**2)
    first, normal = np.array([0.8, 0.6 * np.cos(lean), 0.6 * np.sin(lean)]), np.array([0, -np.sin(lean), np.cos(lean)])
    second = np.cross(normal, first)
    size = a * (1 - e * np.cos(anomaly))
    r = (a * (np.cos(anomaly) - e))[:, None] * first + (a * root * np.sin(anomaly))[:, None] * second
    v = n * a**2 * (-(np.sin(anomaly) / size)[:, None] * first + (root * np.cos(anomaly) / size)[:, None] * second)
    turned = 3 * (r @ momentum / size**2)[:, None] * np.cross(r, v) + np.cross(v, momentum)
    force = 2 * G / (C**2 * size[:, None] ** 3) * turned
    orbital = np.cross(r, v)
    torque = (np.cross(r, force) * (size / a)[:, None]).mean(0)
    laplace = ((np.cross(force, orbital) + np.cross(v, np.cross(r, force))) * (size / a)[:, None]).mean(0) / mu
    node, pericentre = dragging.dragged_node(6e33, a, e), dragging.dragged_pericentre(6e33, a, e, lean)
    turning = node * np.array([0, 0, 1.0])
    np.testing.assert_allclose(torque, np.cross(turning, orbital[0]), rtol=1e-12, atol=1e-12 * abs(torque).max())
    turning = turning + pericentre * normal
    np.testing.assert_allclose(laplace, np.cross(turning, e * first), rtol=1e-10, atol=1e-10 * abs(laplace).max())


def test_a_gyroscope_turns_as_schiff_says():
    """(G/(c^2 r^3)) (3 (J.r) r/r^2 - J), averaged over an eccentric orbit; on two orbits at once."""
    e, normals = 0.4, np.array([[0.0, 0.6, 0.8], [1.0, 2.0, -2.0]])
    momentum, anomaly = np.array([1e33, -2e33, 5e33]), 2 * np.pi * np.arange(512) / 512
    found = dragging.dragged_gyroscope(momentum, normals, 1e7, e)
    for normal, turning in zip(normals / np.linalg.norm(normals, axis=1, keepdims=True), found, strict=True):
        first = np.linalg.svd(normal[None])[2][1]
        second, size = np.cross(normal, first), 1e7 * (1 - e * np.cos(anomaly))
        x, y = 1e7 * (np.cos(anomaly) - e), 1e7 * np.sqrt(1 - e**2) * np.sin(anomaly)
        along = (x[:, None] * first + y[:, None] * second) / size[:, None]
        rate = G / (C**2 * size[:, None] ** 3) * (3 * (along @ momentum)[:, None] * along - momentum)
        np.testing.assert_allclose(turning, (rate * (size / 1e7)[:, None]).mean(0), rtol=1e-10)
    with pytest.raises(ValueError, match="must not be the vector 0"):
        dragging.dragged_gyroscope(momentum, np.zeros(3), 1e7)
    with pytest.raises(ValueError, match="an orbit is an ellipse"):
        dragging.dragged_node(1.0, 1e7, 1.0)


def test_satellites_and_planets():
    # Everitt et al. 2011, PRL 106, 221101: 39.2 and 6606.1 mas a year predicted, the latter with the Earth's J2.
    turning = dragging.dragged_gyroscope(SPIN * np.array([0, 0, 1.0]), [0.0, 1.0, 0.0], 7027.4 * u.km, 0.0014)
    assert turning[2] * np.cos(np.radians(16.84)) / MAS == pytest.approx(39.2, abs=0.3)
    assert geodesic_precession(EARTH.gravitational_parameter, 7027.4e3, 0.0014) / MAS == pytest.approx(6606.1, rel=5e-4)
    # Ciufolini & Pavlis 2004, Nature 431, 958: 30.7 and 31.4 (31.5) mas a year; the pericentre of LAGEOS 2: -57.
    assert dragging.dragged_node(SPIN, 12270e3, 0.0044) / MAS == pytest.approx(30.7, abs=0.05)
    assert dragging.dragged_node(SPIN, 12163e3, 0.0135) / MAS == pytest.approx(31.5, abs=0.1)
    assert dragging.dragged_pericentre(SPIN, 12163e3, 0.0135, np.radians(52.64)) / MAS == pytest.approx(-57.3, abs=0.3)
    mercury = dragging.relativistic_pericentre(body("Sun").gravitational_parameter, 5.790905e10, 0.20563)
    assert 100 * mercury / ARCSECOND_PER_YEAR == pytest.approx(42.98, abs=0.01)
    # 16.8995 deg a year: Kramer et al. 2006, Science 314, 97.
    mass, n = 2.5870 * G * SOLAR_MASS, 2 * np.pi / (0.10225156248 * 86400)
    advance = dragging.relativistic_pericentre(mass, (mass / n**2) ** (1 / 3), 0.0877775)
    assert np.degrees(advance) * JULIAN_YEAR == pytest.approx(16.8995, rel=1e-3)
