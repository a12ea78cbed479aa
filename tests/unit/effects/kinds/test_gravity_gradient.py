"""The torque on a quadrupole: against point masses that make one up, and against its own potential."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.kinds.gravity_gradient import GravityGradient, quadrupole_attraction
from astroinertia.inertia.tensor import inertia_tensor

MASSES, PLACES = np.array([3.0, 0.5]), np.array([[40.0, -30.0, 20.0], [-10.0, 25.0, 5.0]])


def seen(inertia, places=PLACES):
    companions = SimpleNamespace(mass=MASSES, position=lambda time: jnp.asarray(places))
    moments = jnp.linalg.eigvalsh(inertia)
    return SimpleNamespace(time=0.0, companions=companions, inertia=jnp.asarray(inertia), principal_moments=moments)


@pytest.fixture
def points():
    random = np.random.default_rng(3)
    mass, place = random.uniform(0.5, 1.0, 30), random.normal(size=(30, 3)) * [1.0, 0.6, 0.3]
    return mass, place - mass @ place / mass.sum()


def attraction(mass, place, scale):
    """V = sum m x (x) a and the energy of point masses in the whole field of the companions, less what is uniform."""
    virial, energy = np.zeros((3, 3)), 0.0
    for source, at in zip(MASSES, PLACES, strict=True):
        apart = at - scale * place
        distance = np.linalg.norm(apart, axis=1)
        virial += np.einsum("n,ni,nj->ij", mass, scale * place, source * apart / distance[:, None] ** 3)
        energy += -source * (mass / distance).sum() + source * mass.sum() / np.linalg.norm(at)
    return virial, energy


def test_small_bodies_of_points_feel_it(points):
    mass, place = points
    errors = []

    @jax.jit
    def parts(inertia):
        body, effect = seen(inertia), GravityGradient()
        return effect.torque(body), effect.rigid_virial(body), effect.potential(body)

    for scale in (0.02, 0.01):
        with jax.enable_x64(True):
            torque, virial, energy = (np.asarray(part) for part in parts(inertia_tensor(mass, scale * place)))
        whole, whole_energy = attraction(mass, place, scale)
        assert torque == pytest.approx([virial[1, 2] - virial[2, 1], virial[2, 0] - virial[0, 2],
                                        virial[0, 1] - virial[1, 0]], rel=1e-12)  # fmt: skip
        assert energy == pytest.approx(whole_energy, rel=0.02)
        errors.append(np.abs(virial - whole).max() / np.abs(whole).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)  # what is left out is one order higher


def test_the_torque_is_the_slope_of_the_potential(points):
    with jax.enable_x64(True):
        inertia, effect = jnp.asarray(inertia_tensor(*points)), GravityGradient()

        def turned(angles):
            x, y, z = angles
            generator = jnp.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            turn = jnp.eye(3) + generator  # to first order
            return effect.potential(seen_by(turn @ inertia @ turn.T))

        def seen_by(tensor):
            companions = SimpleNamespace(mass=MASSES, position=lambda time: jnp.asarray(PLACES))
            return SimpleNamespace(time=0.0, companions=companions, inertia=tensor)

        slope = jax.jit(jax.grad(turned))(jnp.zeros(3))
        torque = jax.jit(lambda tensor: effect.torque(seen_by(tensor)))(inertia)
        assert np.asarray(torque) == pytest.approx(-np.asarray(slope), rel=1e-12)


def test_companions_are_attracted_by_the_slope_of_the_potential(points):
    with jax.enable_x64(True):
        inertia = jnp.asarray(inertia_tensor(*points))

        def at(places):
            companions = SimpleNamespace(mass=MASSES, position=lambda time: places)
            return SimpleNamespace(time=0.0, companions=companions, inertia=inertia)

        @jax.jit
        def slope_attraction_and_torque(places):
            slope = jax.grad(lambda moved: GravityGradient().potential(at(moved)))(places)
            return slope, quadrupole_attraction(at(places)), GravityGradient().torque(at(places))

        slope, found, torque = (np.asarray(each) for each in slope_attraction_and_torque(jnp.asarray(PLACES)))
    found = MASSES[:, None] * found
    assert found == pytest.approx(-slope, rel=1e-12)
    assert np.cross(PLACES, found).sum(axis=0) == pytest.approx(-torque, rel=1e-12)


def test_a_sphere_and_a_body_alone_feel_nothing():
    with jax.enable_x64(True):
        assert np.abs(np.asarray(GravityGradient().torque(seen(0.4 * np.eye(3))))).max() < 1e-18
        alone = SimpleNamespace(companions=None)
        assert GravityGradient().torque(alone) is None


@pytest.mark.slow
def test_a_small_swing_has_the_frequency_it_tells():
    # One companion along x, the longest axis near it, turning about the axis of the middle moment.
    moments, distance, mass = np.array([1.0, 2.0, 2.5]), 10.0, 7.0
    companions = SimpleNamespace(mass=np.array([mass]), position=lambda time: jnp.array([[distance, 0.0, 0.0]]))

    def torque(angle):
        cosine, sine = jnp.cos(angle), jnp.sin(angle)
        turn = jnp.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
        tensor = turn @ jnp.diag(jnp.asarray(moments)) @ turn.T
        return GravityGradient().torque(SimpleNamespace(time=0.0, companions=companions, inertia=tensor))[1]

    with jax.enable_x64(True):
        stiffness = -float(jax.jit(jax.grad(torque))(0.0))
        frequency = GravityGradient().frequency(
            SimpleNamespace(time=0.0, companions=companions, principal_moments=jnp.asarray(moments))
        )
    assert float(frequency) == pytest.approx(np.sqrt(stiffness / moments[1]), rel=1e-12)
