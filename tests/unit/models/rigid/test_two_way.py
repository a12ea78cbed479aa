"""A rigid body and companions that act on each other: what is kept, and that steps of any order come to one motion."""

import jax
import numpy as np
import pytest
import rebound

import astroinertia
from astroinertia.effects.kinds.gravity_gradient import GravityGradient
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import Settings
from astroinertia.models.rigid.two_way import CoupledRigidBody
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.scene import load
from astroinertia.units import GRAVITATIONAL_CONSTANT

MOMENTS = np.array([0.9, 1.0, 1.2]) * 4e-4
QUATERNION = np.array([0.9, 0.1, 0.3, 0.2]) / np.sqrt(0.95)
MOMENTUM = np.array([0.2, 0.5, 3.2]) * 4e-4


def coupled(order=8, steps_per_rotation=20.0, more=()):
    moon = Companion(
        "moon", 0.3, semi_major_axis=1.0, eccentricity=0.2, inclination=0.3, node=1.0, pericentre=2.0, mean_anomaly=0.1
    )
    body = rigid.body(1.0, MOMENTS, effects=(GravityGradient(),))
    settings = Settings("splitting", 1e-12, steps_per_rotation, order)
    return CoupledRigidBody(body, QUATERNION, MOMENTUM, settings, simulation(1.0, [moon, *more]))


def reached(body):
    return np.concatenate(
        [
            np.asarray(body.state.quaternion),
            np.asarray(body.state.momentum_in_body) / 4e-4,
            body.body.companions.place[0],
        ]
    )


@pytest.mark.slow
def test_angular_momentum_is_kept_to_round_off_and_energy_without_drift():
    planet = Companion("planet", 0.01, "barycentre", semi_major_axis=3.5, eccentricity=0.1, inclination=0.5)
    with jax.enable_x64(True):
        body = coupled(order=4, more=(planet,))
        momentum, energy, spin = body.total_angular_momentum(), body.total_energy(), body.state.angular_momentum.value
        orbit = body.bodies.energy()
        errors = []
        for time in np.linspace(0.0, 12.0, 7)[1:]:
            body.advance(time)
            errors.append(body.total_energy() - energy)
        lost = np.abs(body.total_angular_momentum() - momentum).max()
        assert lost < 1e-15 * np.linalg.norm(momentum)
        # What the two exchange is far more than what is lost: the reaction is there.
        exchanged = np.abs(np.asarray(body.state.angular_momentum.value - spin)).max()
        assert exchanged > 1e10 * lost
        assert abs(body.bodies.energy() - orbit) > 1e3 * np.abs(errors).max()
        assert np.abs(errors).max() < 1e-7 * abs(energy)


@pytest.mark.full
def test_orders_are_what_they_are_called():
    with jax.enable_x64(True):

        def motion(order, steps):
            body = coupled(order, steps)
            body.advance(2.0)
            return reached(body), body.steps

        exact, _ = motion(8, 60.0)
        for order, few in ((2, 20.0), (4, 15.0), (6, 12.0)):
            (coarse, some), (fine, more) = motion(order, few), motion(order, 2.0 * few)
            found = np.log(np.abs(coarse - exact).max() / np.abs(fine - exact).max()) / np.log(more / some)
            assert found == pytest.approx(order, abs=0.5)


@pytest.mark.slow
def test_a_resumed_body_goes_on_bit_for_bit():
    with jax.enable_x64(True):
        body = coupled(order=4)
        body.advance(1.0)
        stored = body.arrays()
        other = coupled(order=4)
        other.resume(stored)
        for one in (body, other):
            one.advance(2.0)
        assert np.array_equal(reached(body), reached(other))
        assert np.array_equal(body.arrays()["carry"], other.arrays()["carry"])


@pytest.mark.slow
def test_a_sphere_leaves_the_orbit_alone():
    with jax.enable_x64(True):
        body = coupled()
        sphere = rigid.body(1.0, np.full(3, 4e-4), effects=(GravityGradient(),))
        ball = CoupledRigidBody(sphere, QUATERNION, MOMENTUM, Settings(order=2), body.bodies)
        alone = body.bodies.copy()
        ball.advance(1.5)
        alone.integrate(1.5)
        assert np.abs(np.subtract(ball.bodies.particles[1].xyz, alone.particles[1].xyz)).max() < 1e-14


@pytest.mark.full
@pytest.mark.parametrize("case", ["at rest", "dust", "whfast"])
def test_a_body_at_rest_dust_and_whfast_keep_the_angular_momentum_too(case):
    dust = (Companion("dust", 0.0, semi_major_axis=3.0),) if case == "dust" else ()
    with jax.enable_x64(True):
        body = coupled(order=4, more=dust)
        if case == "whfast":
            body.bodies.integrator, body.bodies.dt = "whfast", 0.05
        if case == "at rest":
            body = CoupledRigidBody(body.body, QUATERNION, np.zeros(3), Settings(order=4), body.bodies)
        momentum, energy = body.total_angular_momentum(), body.total_energy()
        body.advance(0.5)
        assert np.abs(body.total_angular_momentum() - momentum).max() < 1e-14 * np.linalg.norm(momentum)
        assert body.total_energy() == pytest.approx(energy, rel=1e-8)


TWO = """
name = "two"
model = "rigid"
[body]
kind = "rigid"
mass = "1e15 kg"
moments = ["0.9e20 kg m2", "1.0e20 kg m2", "1.2e20 kg m2"]
rotation = { period = "5 h", obliquity = "20 deg" }
[[companions]]
name = "moon"
mass = "2e14 kg"
semi_major_axis = "4 km"
eccentricity = 0.2
inclination = "10 deg"
[orbits]
back_reaction = true
[effects.gravity_gradient]
[numerics]
integrator = "splitting"
[time]
end = "12 h"
[output]
series_every = "1 h"
"""


@pytest.mark.slow
def test_the_dataset_has_the_orbits_and_what_all_keep_together(tmp_path):
    """The moon moves as the sum says: its orbit's angular momentum, but for the body's part of it, and the spin's."""
    ds = astroinertia.open(astroinertia.run_scene(load.loads(TWO), tmp_path / "two"))
    assert ds["companion_position"].dims == ("time", "companion", "i") and ds["companion"].values.tolist() == ["moon"]
    place, speed = ds["companion_position"].values[:, 0], ds["companion_velocity"].values[:, 0]
    reduced = 1e15 * 2e14 / 1.2e15
    turning = reduced * np.cross(place, speed)
    near = 1e-12 * np.linalg.norm(turning[0])
    np.testing.assert_allclose(ds["companion_angular_momentum"][:, 0], turning, rtol=0, atol=near)
    energy = 0.5 * reduced * (speed**2).sum(axis=1) - GRAVITATIONAL_CONSTANT * 2e29 / np.linalg.norm(place, axis=1)
    np.testing.assert_allclose(ds["companion_energy"][:, 0], energy, rtol=1e-11)
    whole = ds["system_angular_momentum"].values
    np.testing.assert_allclose(whole, turning + ds["angular_momentum"].values, rtol=0, atol=near)
    assert np.abs(whole - whole[0]).max() < 1e-14 * np.linalg.norm(whole[0])
    assert np.ptp(ds["system_energy"].values) < 1e-6 * abs(ds["system_energy"].values[0])
    # What the two exchange is there to be seen.
    assert np.linalg.norm(turning[-1] - turning[0]) > 1e-4 * np.linalg.norm(turning[0])
    np.testing.assert_allclose(np.linalg.norm(place[0]), 4e3 * (1 - 0.2), rtol=1e-9)  # at the pericentre


@pytest.mark.full
def test_orbits_that_the_body_does_not_act_on_are_recorded_too(tmp_path):
    """As two points they are those of Kepler: with REBOUND's own orbit from where they begin."""
    ds = astroinertia.open(astroinertia.run_scene(load.loads(TWO.replace("true", "false")), tmp_path / "one"))
    two = rebound.Simulation()
    two.G = GRAVITATIONAL_CONSTANT
    two.add(m=1e15)
    two.add(m=2e14, a=4e3, e=0.2, inc=np.radians(10))
    for row, seconds in enumerate(ds["time"].values.tolist()):
        two.integrate(seconds)
        body, moon = (np.array(one.xyz + one.vxyz) for one in two.particles)
        place, speed = np.split(moon - body, 2)
        np.testing.assert_allclose(ds["companion_position"][row, 0], place, rtol=0, atol=1e-7)
        np.testing.assert_allclose(ds["companion_velocity"][row, 0], speed, rtol=0, atol=1e-10)
    turning = ds["companion_angular_momentum"].values[:, 0]
    reduced = 1e15 * 2e14 / 1.2e15
    expected = reduced * np.sqrt(GRAVITATIONAL_CONSTANT * 1.2e15 * 4e3 * (1.0 - 0.2**2))
    np.testing.assert_allclose(np.linalg.norm(turning, axis=1), expected, rtol=1e-9)
    np.testing.assert_allclose(ds["companion_energy"][:, 0], -GRAVITATIONAL_CONSTANT * 2e29 / 8e3, rtol=1e-9)
    assert "system_energy" not in ds  # which they do not keep
