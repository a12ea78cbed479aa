"""Time derivatives of inertia tensors against jax's own, a force's shares against sums, strain against textbooks."""

import json
from pathlib import Path

import numpy as np
import pytest

from astroinertia.inertia import evolution, tensor
from astroinertia.units import GRAVITATIONAL_CONSTANT, SPEED_OF_LIGHT

REFERENCE = Path(__file__).parents[2] / "reference"


def particles(seed, count=25):
    """Masses, positions, velocities and accelerations of a body that drifts and falls, away from the origin."""
    generator = np.random.default_rng(seed)
    vectors = generator.normal(size=(3, count, 3)) * [1.0, 1.4, 2.1] + generator.normal(size=(3, 1, 3)) * 5
    return generator.uniform(0.5, 2, count), *vectors


@pytest.mark.full
@pytest.mark.parametrize("origin", [None, np.array([0.4, -2.0, 1.0])], ids=["centre of mass", "fixed point"])
def test_rate_and_acceleration_are_the_derivatives_of_the_tensor(origin):
    import jax

    mass, x, v, a = particles(1)
    weights = np.random.default_rng(2).uniform(0, 1, len(mass))
    with jax.enable_x64(True):
        mass, x, v, a, weights = map(jax.numpy.asarray, (mass, x, v, a, weights))

        def inertia(x):
            return tensor.inertia_tensor(mass, x, origin, weights)

        def rate(x, v):
            return evolution.inertia_rate(mass, x, v, origin, weights)

        value, first = jax.jvp(inertia, (x,), (v,))
        scale = abs(value).max()
        np.testing.assert_allclose(rate(x, v), first, rtol=0, atol=1e-13 * scale)
        _, second = jax.jvp(rate, (x, v), (v, a))
        found = evolution.inertia_acceleration(mass, x, v, a, origin, weights)
        np.testing.assert_allclose(found, second, rtol=0, atol=1e-13 * scale)
        twice = jax.jvp(lambda t: jax.jvp(lambda t: inertia(x + t * v + t**2 / 2 * a), (t,), (1.0,))[1], (0.0,), (1.0,))
        np.testing.assert_allclose(found, twice[1], rtol=0, atol=1e-13 * scale)


def test_five_particles_of_the_reference():
    case = json.loads((REFERENCE / "inertia_rate.json").read_text())
    mass, x, v = (np.array(case["inputs"][name]) for name in ("m", "X", "V"))
    origin = np.zeros(3)
    np.testing.assert_allclose(tensor.inertia_tensor(mass, x, origin), case["value"]["Theta"], rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(
        evolution.inertia_rate(mass, x, v, origin), case["value"]["dTheta_dt"], rtol=1e-14, atol=1e-14
    )


def test_torque_and_shape_share_of_a_force():
    mass, x, v, a = particles(3)
    other = a[::-1] * 0.7
    virials = [evolution.virial_tensor(mass, x, force) for force in (a, other)]
    relative = x - mass @ x / mass.sum()
    np.testing.assert_allclose(evolution.torque(virials[0]), mass @ np.cross(relative, a), rtol=1e-12)
    # The shares of two forces and of motion alone add up to the whole.
    whole = evolution.inertia_acceleration(mass, x, v, a + other)
    motion = evolution.inertia_acceleration(mass, x, v, np.zeros_like(a))
    shares = motion + sum(evolution.shape_share(virial) for virial in virials)
    np.testing.assert_allclose(shares, whole, atol=1e-12 * abs(whole).max())


def test_an_even_pull_has_no_torque_and_no_share_about_the_centre_of_mass_but_has_about_a_point():
    mass, x, _, _ = particles(4)
    pull = np.broadcast_to([0.0, 0.0, -9.81], x.shape)
    virial = evolution.virial_tensor(mass, x, pull)
    assert abs(virial).max() < 1e-12
    about = evolution.torque(evolution.virial_tensor(mass, x, pull, np.zeros(3)))
    np.testing.assert_allclose(about, np.cross(mass @ x, pull[0]), rtol=1e-12)


def binary(time, solar_masses=1.4, separation=1e8):
    """d2Q/dt2 of two equal masses on a circle about z, in J, its size and its phase."""
    mass = solar_masses * 1.98841e30
    rate = np.sqrt(2 * GRAVITATIONAL_CONSTANT * mass / separation**3)
    phase = 2 * rate * time
    size = mass * separation**2 * rate**2  # of d2Q/dt2: Q_xx = m a^2 / 4 (1 + cos 2 w t) with both masses
    acceleration = np.zeros((len(time), 3, 3))
    acceleration[:, 0, 0], acceleration[:, 1, 1] = -size * np.cos(phase), size * np.cos(phase)
    acceleration[:, 0, 1] = acceleration[:, 1, 0] = -size * np.sin(phase)
    return acceleration, mass, rate, phase


@pytest.mark.parametrize(("polar", "azimuth"), [(0.0, 0.0), (0.8, 0.0), (np.pi / 2, 0.4), (2.5, -1.3)])
def test_strain_of_a_binary_is_that_of_the_textbook(polar, azimuth):
    # Maggiore (2008), Gravitational Waves I, eq. 4.3 to 4.5, with the chirp mass; its phase runs with azimuth.
    time, distance = np.linspace(0, 30.0, 17), 3.0857e22
    acceleration, mass, rate, phase = binary(time)
    reduced, total = mass / 2, 2 * mass
    chirp = GRAVITATIONAL_CONSTANT * reduced**0.6 * total**0.4 / SPEED_OF_LIGHT**2
    size = 4 / distance * chirp ** (5 / 3) * (rate / SPEED_OF_LIGHT) ** (2 / 3)
    plus, cross = evolution.gravitational_wave_strain(acceleration, polar, azimuth, distance)
    seen = phase - 2 * azimuth
    np.testing.assert_allclose(plus, -size * (1 + np.cos(polar) ** 2) / 2 * np.cos(seen), atol=1e-12 * size)
    np.testing.assert_allclose(cross, -size * np.cos(polar) * np.sin(seen), atol=1e-12 * size)


def test_strain_falls_with_distance_and_takes_many_directions_at_once():
    acceleration = binary(np.array([3.0]))[0][0]
    polar, azimuth = np.linspace(0, np.pi, 5)[:, None], np.linspace(0, 6, 7)
    plus, cross = evolution.gravitational_wave_strain(acceleration, polar, azimuth, 2.0)
    assert plus.shape == cross.shape == (5, 7)
    one = evolution.gravitational_wave_strain(acceleration, polar[3, 0], azimuth[2], 1.0)
    np.testing.assert_allclose((2 * plus[3, 2], 2 * cross[3, 2]), one, rtol=1e-14)


def test_strain_in_single_precision_does_not_vanish():
    acceleration = 1e37 * np.diag([1.0, -1.0, 0.0])
    expected = evolution.gravitational_wave_strain(acceleration, 0.7, 0.2, 3e20)
    single = evolution.gravitational_wave_strain(acceleration.astype(np.float32), *np.float32([0.7, 0.2, 3e20]))
    assert single[0].dtype == np.float32
    np.testing.assert_allclose(single, expected, rtol=1e-5)


def test_strain_is_the_transverse_traceless_part():
    generator = np.random.default_rng(6)
    acceleration = generator.normal(size=(3, 3))
    acceleration = acceleration + acceleration.T
    polar, azimuth = 0.7, 2.1
    line = np.array([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)])
    across = np.eye(3) - np.outer(line, line)
    projected = across @ acceleration @ across - 0.5 * across * np.trace(across @ acceleration)
    plus, cross = evolution.gravitational_wave_strain(acceleration, polar, azimuth, gravitational_constant=1.0)
    np.testing.assert_allclose(
        2 * (plus**2 + cross**2), (2 / SPEED_OF_LIGHT**4) ** 2 * (projected**2).sum(), rtol=1e-13
    )
    # A sphere that swells sends nothing out.
    swelling = evolution.gravitational_wave_strain(np.eye(3), polar, azimuth, gravitational_constant=1.0)
    assert abs(np.array(swelling)).max() * SPEED_OF_LIGHT**4 < 1e-15
