"""A rigid body and companions that act on each other: what is kept, and that steps of any order come to one motion."""

import jax
import numpy as np
import pytest
import rebound

import astroinertia
from astroinertia.models.rigid import body as rigid, passage, two_way
from astroinertia.models.rigid.evolution import Settings
from astroinertia.orbits import states
from astroinertia.orbits.particles import accelerations
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.scene import load
from astroinertia.units import GRAVITATIONAL_CONSTANT
from tests.coupled import coupled, kept, places

MOMENTS = np.array([0.9, 1.0, 1.2]) * 4e-4
QUATERNION = np.array([0.9, 0.1, 0.3, 0.2]) / np.sqrt(0.95)
MOMENTUM = np.array([0.2, 0.5, 3.2]) * 4e-4
PLANET = Companion("planet", 0.01, "barycentre", semi_major_axis=3.5, eccentricity=0.1, inclination=0.5)
DUST = Companion("dust", 0.0, semi_major_axis=3.0)


def system(*more, eccentricity=0.2):
    moon = Companion(
        "moon", 0.3, semi_major_axis=1.0, eccentricity=eccentricity, inclination=0.3, node=1.0, pericentre=2.0,
        mean_anomaly=0.1,
    )  # fmt: skip
    return simulation(1.0, [moon, *more])


def motion(order=8, steps_per_rotation=20.0, more=(), integrator="splitting", momentum=MOMENTUM):
    settings = Settings(integrator, 1e-12, steps_per_rotation, order)
    return coupled(system(*more), MOMENTS, QUATERNION, momentum, settings)


def reached(body):
    spin = np.asarray(body.state.momentum_in_body) / 4e-4
    return np.concatenate([np.asarray(body.state.quaternion), spin, places(body)[0]])


@pytest.mark.slow
@pytest.mark.parametrize("case", ["planet", "dust", "at rest"])
def test_angular_momentum_is_kept_to_round_off_and_energy_without_drift(case):
    with jax.enable_x64(True):
        more = {"planet": (PLANET,), "dust": (DUST,)}.get(case, ())
        body = motion(8, 40.0, more, momentum=np.zeros(3) if case == "at rest" else MOMENTUM)
        (momentum, energy), spin = kept(body), body.state.angular_momentum.value
        errors = []
        for time in np.linspace(0.0, 12.0, 7)[1:]:
            body.advance(time)
            errors.append(kept(body)[1] - energy)
        lost = np.abs(kept(body)[0] - momentum).max()
        assert lost < 2e-15 * np.linalg.norm(momentum)
        # What the two exchange is far more than what is lost: the reaction is there.
        exchanged = np.abs(np.asarray(body.state.angular_momentum.value - spin)).max()
        assert exchanged > 1e9 * lost
        record = body.record(None)
        of_spin = record["kinetic_energy"] + record["potential_energy"]
        assert abs(of_spin - np.sum(MOMENTUM**2 / MOMENTS) / 2) > 100 * np.abs(errors).max()
        # Measured: 4e-14 and 5e-15, and 2e-12 of the body at rest, for which steps are longer.
        assert np.abs(errors).max() < 1e-11 * abs(energy)


def test_what_all_keep_together_is_what_rebound_says_of_points():
    bodies = system(PLANET, DUST)
    mass, (place, speed) = states.masses(bodies), states.present(bodies)
    momentum, energy = two_way.totals(mass[0], mass[1:], np.stack([place, speed])[None])
    np.testing.assert_allclose(momentum[0], bodies.angular_momentum(), rtol=0, atol=1e-15)
    assert energy[0] == pytest.approx(bodies.energy(), rel=1e-14)


@pytest.mark.slow
def test_accelerations_are_those_of_rebound_where_the_body_is_a_sphere():
    """Of one, two and three companions, one of them without mass: those of points, relative to the body."""
    with jax.enable_x64(True):
        for more in ((), (PLANET,), (PLANET, DUST)):
            bodies = system(*more)
            ball = coupled(bodies, np.full(3, 4e-4), QUATERNION, MOMENTUM, Settings())
            body = rigid.accompanied(ball.body, ball.state.orbits.value)
            seen = rigid.view(body, 0.0, QUATERNION, MOMENTUM)
            there = accelerations(bodies)
            found = two_way.pulls(body.mass, body.companions.mass, body.companions.orbits[0])
            np.testing.assert_allclose(found, there[1:] - there[0], rtol=1e-13, atol=1e-15)
            assert np.abs(two_way.pushes(seen)).max() < 1e-17  # of some 1e-4


@pytest.mark.slow
def test_a_stage_takes_its_step_of_points_without_a_loop_and_looks_at_the_body_once(monkeypatch):
    """By default; where steps are long, a stage takes several of points, in a loop."""
    with jax.enable_x64(True):
        fine, coarse = motion(8, 40.0), motion(8, 5.0)
        for body, loop in ((fine, False), (coarse, True)):
            program = jax.jit(two_way.flow).lower(body.body, body.state.orbits, 0.01).compile().as_text()
            assert (" while(" in program) == loop
        looks, view = [], rigid.view
        monkeypatch.setattr(rigid, "view", lambda *seen: looks.append(seen) or view(*seen))
        jax.eval_shape(rigid.kick, fine.body, 0.0, fine.state, 0.01, None)
        assert len(looks) == 1


@pytest.mark.slow
def test_steps_are_for_the_pericentre_wherever_companions_are():
    with jax.enable_x64(True):
        bodies = system(eccentricity=0.7)
        mass, orbits = states.masses(bodies), np.stack(states.present(bodies))
        place, speed = two_way.at_pericentres(mass[0], mass[1:], orbits)
        assert np.linalg.norm(place) == pytest.approx(0.3, rel=1e-12)
        assert np.linalg.norm(speed) * 0.3 == pytest.approx(np.linalg.norm(np.cross(*orbits)), rel=1)
        turning = np.linalg.norm(np.cross(place[0], speed[0])) / 0.3**2
        at_pericentre = np.sqrt(1.3 * 0.3 * 1.7) / 0.3**2
        assert turning == pytest.approx(at_pericentre, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("spin", "substeps"), [(10.0, 1), (0.1, 5)])
def test_points_take_the_steps_that_their_own_turns_ask_for(spin, substeps):
    """Four steps a rotation: of a body that turns fast they are enough for points, else five times too long."""
    with jax.enable_x64(True):
        bodies = system()
        ball = coupled(bodies, np.full(3, 4e-4), QUATERNION, spin * MOMENTUM, Settings(steps_per_rotation=4.0, order=2))
        mass, orbits = ball.body.companions.mass, ball.body.companions.orbits
        pace = float(passage.present_pace(ball.body, ball.course(), 3.0))
        step = 2.0 * np.pi / (4.0 * pace)
        assert int(passage.whole(two_way.substeps(ball.body.mass, mass, orbits, step))) == substeps
        ball.advance(3.0)
        bodies.integrate(3.0)
        assert np.abs(places(ball) - states.present(bodies)[0]).max() < 1e-9


@pytest.mark.slow
def test_a_moon_of_a_companion_is_followed_however_slowly_the_body_turns():
    """The body turns once in a hundred of its orbits: steps for the body, or for the planet, would not resolve them."""
    with jax.enable_x64(True):
        planet = Companion("planet", 0.01, semi_major_axis=1.0)
        moon = Companion("its moon", 1e-6, "planet", semi_major_axis=0.03, eccentricity=0.3)
        bodies = simulation(1.0, [planet, moon])
        slow = coupled(bodies, np.full(3, 4e-4), QUATERNION, 1e-3 * MOMENTUM, Settings())
        slow.advance(3.0)
        bodies.integrate(3.0)
        apart, expected = (place[1] - place[0] for place in (places(slow), states.present(bodies)[0]))
        assert np.linalg.norm(apart - expected) < 1e-9 * np.linalg.norm(expected)
        mass, orbits = states.masses(bodies)[1:], np.stack(states.present(bodies))
        pericentre = 0.03 * 0.7
        rate = np.sqrt(mass.sum() * 0.03 * (1 - 0.3**2)) / pericentre**2
        assert two_way.fastest_pair(mass, orbits) == pytest.approx(rate, rel=0.1)


@pytest.mark.full
@pytest.mark.parametrize(("order", "few"), [(2, 20.0), (4, 15.0), (6, 12.0), (8, 20.0)])
def test_orders_are_what_they_are_called(order, few):
    with jax.enable_x64(True):

        def after(order, steps):
            body = motion(order, steps)
            body.advance(2.0)
            return reached(body), body.steps

        exact, _ = after(8, 60.0)
        (coarse, some), (fine, more) = after(order, few), after(order, 2.0 * few)
        found = np.log(np.abs(coarse - exact).max() / np.abs(fine - exact).max()) / np.log(more / some)
        assert found == pytest.approx(order, abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["splitting", "adaptive"])
def test_a_resumed_body_goes_on_bit_for_bit(integrator):
    with jax.enable_x64(True):
        body, other = (motion(order=4, integrator=integrator) for _ in range(2))
        body.advance(1.0)
        stored = body.arrays()
        other.resume(stored)
        for one in (body, other):
            one.advance(2.0)
        assert np.array_equal(reached(body), reached(other))
        assert all(np.array_equal(array, other.arrays()[name]) for name, array in body.arrays().items())
        with pytest.raises(ValueError, match="of shape"):
            motion(more=(PLANET,)).resume(stored)


@pytest.mark.slow
def test_a_sphere_leaves_the_orbit_alone():
    with jax.enable_x64(True):
        bodies = system()
        ball = coupled(bodies, np.full(3, 4e-4), QUATERNION, MOMENTUM, Settings(steps_per_rotation=80.0))
        ball.advance(1.5)
        bodies.integrate(1.5)
        assert np.abs(places(ball) - states.present(bodies)[0]).max() < 1e-14


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
[time]
end = "12 h"
[output]
series_every = "1 h"
"""


@pytest.mark.slow
@pytest.mark.parametrize(("integrator", "lost"), [("splitting", 1e-14), ("adaptive", 1e-12)])
def test_the_dataset_has_the_orbits_and_what_all_keep_together(tmp_path, integrator, lost):
    """The moon moves as the sum says: its orbit's angular momentum, but for the body's part of it, and the spin's."""
    scene = load.loads(TWO, [f"numerics.integrator={integrator}"])
    ds = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "two"))
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
    assert np.abs(whole - whole[0]).max() < lost * np.linalg.norm(whole[0])
    assert np.ptp(ds["system_energy"].values) < 1e-11 * abs(ds["system_energy"].values[0])
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
