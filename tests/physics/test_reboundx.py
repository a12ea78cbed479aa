"""The gravity gradient, its reaction on orbits and the torque of lagging tides against REBOUNDx.

Sources: Tamayo et al. 2020, MNRAS 491, 2885 (REBOUNDx); Lu et al. 2023, ApJ 948, 41 (its effect tides_spin).
"""

import math
import warnings
from types import SimpleNamespace

import jax
import numpy as np
import pytest
import rebound

from astroinertia.effects.kinds.gravity_gradient import GravityGradient, quadrupole_attraction
from astroinertia.effects.kinds.tidal_torque import TidalTorque
from astroinertia.inertia.gravity_field import ellipsoid_field
from astroinertia.interop.reboundx import gravitational_harmonics
from astroinertia.models.rigid.evolution import Settings
from astroinertia.orbits.particles import accelerations
from astroinertia.orbits.simulation import Companion, simulation
from tests.coupled import coupled, places
from tests.evolve import advanced

reboundx = pytest.importorskip(
    "reboundx", reason="reboundx is not installed: pip install reboundx", exc_type=ImportError
)

RADIUS, J2 = 0.05, 0.01
LOVE_NUMBER, PUFFED = 0.3, 0.2
SPIN = np.array([0.3, 0.4, 2.0])


def pair(mass=0.1, inclination=0.4, pericentre=0.3):
    moon = Companion(
        "moon", mass, semi_major_axis=1.0, eccentricity=0.2, inclination=inclination, pericentre=pericentre,
        mean_anomaly=0.5,
    )  # fmt: skip
    return simulation(1.0, [moon])


def effect(bodies, name):
    extras = reboundx.Extras(bodies)
    with warnings.catch_warnings():
        # It tells of a change in its own version 4.5 whenever it is loaded.
        warnings.filterwarnings("ignore", message="tides_spin was updated", category=RuntimeWarning)
        force = extras.load_force(name)
    extras.add_force(force)
    return extras, force


def flattened(bodies, axis=(0.0, 0.0, 1.0)):
    extras, _ = effect(bodies, "gravitational_harmonics")
    body = bodies.particles[0]
    body.params["J2"], body.params["R_eq"], body.params["Omega"] = J2, RADIUS, rebound.Vec3d(*axis)
    return extras


def tidal(bodies, time_lag=None):
    bodies.particles[0].r = PUFFED
    extras, force = effect(bodies, "tides_spin")
    body = bodies.particles[0]
    body.params["k2"], body.params["I"], body.params["Omega"] = LOVE_NUMBER, 0.012, rebound.Vec3d(*SPIN)
    if time_lag is not None:
        body.params["tau"] = time_lag
    extras.initialize_spin_ode(force)
    return extras


def relative(bodies):
    body, moon = bodies.particles[0], bodies.particles[1]
    return np.subtract(moon.xyz, body.xyz), np.subtract(moon.vxyz, body.vxyz)


def seen(bodies, inertia):
    place, speed = relative(bodies)
    companions = SimpleNamespace(
        mass=np.array([bodies.particles[1].m]), position=lambda time: place[None], velocity=lambda time: speed[None]
    )
    return SimpleNamespace(time=0.0, companions=companions, inertia=inertia, angular_velocity=SPIN)


def test_the_quadrupole_is_that_of_gravitational_harmonics():
    for axis in ((0.0, 0.0, 1.0), (0.1, 0.2, 1.0)):
        bodies = pair()
        plain = accelerations(bodies)
        extras = flattened(bodies, axis)
        theirs = accelerations(bodies) - plain
        along = np.array(axis) / np.linalg.norm(axis)
        inertia = J2 * RADIUS**2 * np.outer(along, along)  # C - A = J2 M R^2; A does not count
        with jax.enable_x64(True):
            ours = np.asarray(quadrupole_attraction(seen(bodies, inertia)))[0]
        assert theirs[1] == pytest.approx(ours, rel=1e-9, abs=1e-15)
        assert theirs[0] == pytest.approx(-0.1 * ours, rel=1e-9, abs=1e-15)
        del extras


@pytest.mark.parametrize(("mass", "inclination"), [pytest.param(0.1, 0.0, marks=pytest.mark.full), (1e-9, 0.6)])
def test_an_orbit_about_a_flattened_body_precesses_as_with_gravitational_harmonics(mass, inclination):
    # In the equator there is no torque; a light companion has none that would move the axis. So J2 alone is left.
    orbits, theirs = 10.0 * 2 * math.pi, pair(mass, inclination)
    extras = flattened(theirs)
    theirs.integrate(orbits)
    least = 0.3 * RADIUS**2
    with jax.enable_x64(True):
        moments = np.array([least, least, least + J2 * RADIUS**2])
        spin = np.array([0.0, 0.0, moments[2]])
        ours = coupled(pair(mass, inclination), moments, np.eye(4)[0], spin, Settings(steps_per_rotation=80.0))
        advanced(ours, orbits)
    place, _ = relative(theirs)
    unperturbed = pair(mass, inclination)
    unperturbed.integrate(orbits)
    moved = np.linalg.norm(place - relative(unperturbed)[0])
    assert moved > 1e-3
    # Measured: 2e-12 and 7e-12, where J2 moves the companion by 7e-3 and 3e-3.
    assert np.linalg.norm(places(ours)[0] - place) < 1e-10
    del extras


def test_a_field_is_exported_as_gravitational_harmonics_takes_it():
    """The pull on the companion is the slope of the field's potential to degree 4."""
    field = ellipsoid_field(1.0, (0.5, 0.5, 0.3), degree=5, radius=0.5)
    bodies = pair()
    plain = accelerations(bodies)
    extras, _ = effect(bodies, "gravitational_harmonics")
    for name, value in gravitational_harmonics(field).items():
        bodies.particles[0].params[name] = value
    theirs = (accelerations(bodies) - plain)[1]
    place, _ = relative(bodies)
    step = 1e-3
    nodes, weights = np.array([-2, -1, 1, 2]), np.array([1, -8, 8, -1]) / (12 * step)
    slope = [field.potential(place + step * np.outer(nodes, axis)) @ weights for axis in np.eye(3)]
    central = place / np.linalg.norm(place) ** 3
    assert theirs == pytest.approx(-np.array(slope) + central, rel=1e-8, abs=1e-10)
    del extras


def test_the_bulge_of_a_spin_is_that_of_tides_spin():
    bodies = pair()
    plain = accelerations(bodies)
    extras = tidal(bodies)
    theirs = (accelerations(bodies) - plain)[1]
    place, _ = relative(bodies)
    distance = np.linalg.norm(place)
    # The equilibrium bulge of the companion's own tide pulls along the line; that of the spin has C - A = k R^5 w^2/3G.
    own = -3.0 * LOVE_NUMBER * PUFFED**5 * 0.1 / distance**8 * place
    with jax.enable_x64(True):
        body = seen(bodies, LOVE_NUMBER * PUFFED**5 / 3.0 * np.outer(SPIN, SPIN))
        ours = np.asarray(quadrupole_attraction(body))[0]
        torque = np.asarray(GravityGradient().torque(body))
    assert theirs == pytest.approx(ours + own, rel=1e-9, abs=1e-14)
    assert -0.1 * np.cross(place, theirs) == pytest.approx(torque, rel=1e-9, abs=1e-15)
    del extras


def test_the_torque_of_lagging_tides_is_that_of_tides_spin():
    # Its tau is half the time by which tides lag: its sigma is 4 G tau/(3 k R^5), where the torque of a lag dt, 3 k R^5
    # m^2 G dt (w - n)/a^6 on a circular orbit (Mignard 1979; Hut 1981 with k/2), wants 2 G dt/(3 k R^5).
    time_lag = 2e-3
    conservative, lagging = pair(), pair()
    extras = [tidal(conservative), tidal(lagging, 0.5 * time_lag)]
    theirs = 0.1 * (accelerations(lagging) - accelerations(conservative))[1]
    place, _ = relative(lagging)
    with jax.enable_x64(True):
        ours = TidalTorque(LOVE_NUMBER, PUFFED, time_lag=time_lag).torque(seen(lagging, np.eye(3)))
    assert np.asarray(ours) == pytest.approx(-np.cross(place, theirs), rel=1e-8)
    del extras
