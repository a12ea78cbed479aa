"""Orbit and spin that act on each other, against a rigid body inside REBOUND's interface to differential equations."""

import jax
import numpy as np
import pytest

from astroinertia.effects.kinds.gravity_gradient import GravityGradient
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import RigidBody, Settings
from astroinertia.orbits.rigid_ode import TOLERANCE, RigidBodyOde
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.rotation.ephemeris import ephemeris
from tests.coupled import coupled, kept, places
from tests.evolve import advanced

# A triaxial body whose spin axis is 0.14 rad from its largest axis, three orbital rates fast: regular motion. Where the
# torque makes it chaotic, no two integrations agree after 1000 orbits.
MOMENTS = np.array([0.95, 1.0, 1.1]) * 4e-4
MOMENTUM = np.array([0.2, 0.5, 3.5]) * 4e-4
QUATERNION = np.array([0.9, 0.1, 0.3, 0.2]) / np.sqrt(0.95)
MASS, ECCENTRICITY = 0.3, 0.1
ORBIT = 2.0 * np.pi / np.sqrt(1.0 + MASS)
PLANET = Companion("planet", 0.05, "barycentre", semi_major_axis=4.0, eccentricity=0.1, inclination=0.5)


def pair(*more):
    moon = Companion(
        "moon", MASS, semi_major_axis=1.0, eccentricity=ECCENTRICITY, inclination=0.3, node=1.0, pericentre=2.0,
        mean_anomaly=0.1,
    )  # fmt: skip
    return simulation(1.0, [moon, *more])


def inside_rebound(bodies, back_reaction=True, tolerance=TOLERANCE):
    state = np.empty((bodies.N, 6))
    bodies.serialize_particle_data(xyzvxvyvz=state)
    mass = np.array([particle.m for particle in bodies.particles])
    return RigidBodyOde(
        mass, state[:, :3], state[:, 3:], MOMENTS, QUATERNION, MOMENTUM / MOMENTS, back_reaction=back_reaction,
        tolerance=tolerance,
    )  # fmt: skip


def spin_differences(one, other):
    """Largest differences of quaternions (of which q and -q are the same) and of body rates over their size."""
    q, p = np.asarray(one.state.quaternion), other.quaternion
    rates = np.asarray(one.state.momentum_in_body) / MOMENTS
    size = np.linalg.norm(rates)
    return min(np.abs(q - sign * p).max() for sign in (1, -1)), np.abs(rates - other.angular_velocity).max() / size


def differences(motion, inside):
    place = inside.position[1:] - inside.position[0]
    orbit = np.linalg.norm(places(motion) - place, axis=1) / np.linalg.norm(place, axis=1)
    return orbit.max(), *spin_differences(motion, inside)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["splitting", "adaptive"])
def test_orbit_and_spin_are_those_of_a_body_inside_rebound(integrator):
    time = 4.0 * ORBIT
    with jax.enable_x64(True):
        motion = coupled(pair(PLANET), MOMENTS, QUATERNION, MOMENTUM, Settings(integrator, 1e-14, 40.0, 8))
        momentum, energy = kept(motion)
        motion.advance(time)
        inside = inside_rebound(pair(PLANET))
        inside.integrate(time)
        # Measured: 6e-13, 2e-14 and 2e-14, adaptively 1e-13, 5e-14 and 3e-14.
        assert max(differences(motion, inside)) < 1e-11
        lost, gained = (now - before for now, before in zip(kept(motion), (momentum, energy), strict=True))
        assert np.abs(lost).max() < {"splitting": 1e-15, "adaptive": 3e-14}[integrator] * np.linalg.norm(momentum)
        assert abs(gained) < 1e-12 * abs(energy)
        # Without the reaction the orbit is another one by far.
        one_sided = inside_rebound(pair(PLANET), back_reaction=False)
        one_sided.integrate(time)
        assert differences(motion, one_sided)[0] > 1e-5


@pytest.mark.full
@pytest.mark.parametrize(
    ("orbits", "more", "settings", "bound"),
    # Measured: 3e-12, 1.3e-10 and 3.8e-9.
    [
        (100.0, (PLANET,), Settings("splitting", 1e-12, 20.0, 8), 2e-11),
        (1000.0, (), Settings("splitting", 1e-12, 20.0, 8), 1e-9),
        (1000.0, (), Settings("adaptive", 1e-14, 20.0, 8), 1e-8),
    ],
)
def test_the_spin_on_a_tabulated_orbit_is_that_of_a_body_inside_rebound(orbits, more, settings, bound):
    time = orbits * ORBIT
    with jax.enable_x64(True):
        companions = ephemeris(pair(*more), time * (1.0 + 1e-12))
        torqued = rigid.body(1.0, MOMENTS, effects=(GravityGradient(),), companions=companions)
        model = RigidBody(torqued, QUATERNION, MOMENTUM, settings)
        advanced(model, time)
        inside = inside_rebound(pair(*more), back_reaction=False)
        inside.integrate(time)
        assert max(spin_differences(model, inside)) < bound


@pytest.mark.full
def test_orbit_and_spin_agree_over_a_thousand_orbits(result):
    time = 1000.0 * ORBIT
    with jax.enable_x64(True):
        motion = coupled(pair(), MOMENTS, QUATERNION, MOMENTUM, Settings())
        momentum, energy = kept(motion)
        advanced(motion, time)
        lost = np.abs(kept(motion)[0] - momentum).max() / np.linalg.norm(momentum)
        drift = abs(kept(motion)[1] / energy - 1.0)
        found = []
        for tolerance in (TOLERANCE, 1e-13, 3e-15):
            inside = inside_rebound(pair(), tolerance=tolerance)
            inside.integrate(time)
            found.append(differences(motion, inside))
    orbit, attitude, spin = np.array(found).T.tolist()
    result(orbit=orbit, attitude=attitude, spin=spin, angular_momentum=lost, energy=drift, steps=motion.steps)
    # At looser tolerances REBOUND's steps err by 4e-10 to 3e-9 of the orbit, for axes that differ in their last bit; at
    # the tightest by 5e-10 to 7e-10.
    assert max(orbit[-1], *attitude, *spin) < 1e-9
    assert max(orbit) < 1e-8
    assert lost < 3e-15
    assert drift < 1e-13
