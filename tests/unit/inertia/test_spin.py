"""Angular momentum, mean angular velocity, energy and bearing torque, against sums over points and closed forms."""

import numpy as np
import pytest

from astroinertia.inertia import spin, tensor


def particles(seed, count=30):
    generator = np.random.default_rng(seed)
    mass, position = generator.uniform(0.5, 2, count), generator.normal(size=(count, 3)) * [1.0, 1.4, 2.1]
    return mass, position, generator.normal(size=(count, 3)) + [0.3, 0.0, -2.0]


def test_angular_momentum_is_the_sum_of_cross_products():
    mass, x, v = particles(1)
    origin = np.array([1.0, 2.0, -1.0])
    np.testing.assert_allclose(spin.angular_momentum(mass, x, v, origin), mass @ np.cross(x - origin, v), rtol=1e-13)
    relative, motion = x - mass @ x / mass.sum(), v - mass @ v / mass.sum()
    np.testing.assert_allclose(spin.angular_momentum(mass, x, v), mass @ np.cross(relative, motion), rtol=1e-12)


def test_angular_velocity_of_a_rigid_rotation_and_of_a_body_without_inertia():
    inertia, rate = tensor.inertia_tensor(*particles(4)[:2]), np.array([0.3, -1.2, 2.0])
    np.testing.assert_allclose(spin.angular_velocity(inertia, inertia @ rate), rate, rtol=1e-12)
    rod = tensor.inertia_from_second_moment(np.diag([0.0, 0.0, 1.0]))
    assert np.isnan(spin.angular_velocity(rod, np.array([0.0, 0.0, 1.0]))).all()
    assert np.isnan(spin.angular_velocity(np.zeros((3, 3)), np.zeros(3))).all()


@pytest.mark.slow
def test_a_sphere_has_a_finite_gradient_of_its_mean_spin():
    import jax

    with jax.enable_x64(True):
        momentum = jax.numpy.array([1.0, 2.0, 3.0])
        gradient = jax.grad(lambda inertia: spin.angular_velocity(inertia, momentum) @ momentum)(2.0 * jax.numpy.eye(3))
        # d(L.I^-1.L) = -omega.dI.omega
        np.testing.assert_allclose(gradient, -np.outer(momentum, momentum) / 4, rtol=1e-15)


def test_three_forms_of_the_energy_are_the_energy_of_the_particles():
    mass, x, _ = particles(2)
    rate = np.array([0.2, -0.7, 1.1])
    x = x - mass @ x / mass.sum()
    energy = 0.5 * mass @ (np.cross(rate, x) ** 2).sum(1)
    inertia = tensor.inertia_tensor(mass, x)
    momentum = inertia @ rate
    assert spin.rotational_energy(inertia, rate) == pytest.approx(energy, rel=1e-13)
    assert spin.rotational_energy(inertia, angular_momentum=momentum) == pytest.approx(energy, rel=1e-13)
    assert spin.rotational_energy(None, rate, momentum) == pytest.approx(energy, rel=1e-13)
    with pytest.raises(ValueError, match="follows from two"):
        spin.rotational_energy(inertia)
    with pytest.raises(ValueError, match="follows from two"):
        spin.rotational_energy(inertia, rate, momentum)


def test_the_bearing_torque_is_the_rate_of_the_angular_momentum():
    # Points on a shaft along z turning at a rate w: each needs the force -m w^2 (x, y, 0) at its place.
    mass, x, _ = particles(3)
    force = -(1.7**2) * mass[:, None] * x * [1, 1, 0]
    inertia = tensor.inertia_tensor(mass, x, np.zeros(3))
    torque = spin.bearing_torque(inertia, np.array([0.0, 0.0, 1.7]))
    np.testing.assert_allclose(torque, np.cross(x, force).sum(0), rtol=1e-13, atol=1e-12)
    inertia[0, 1] = inertia[1, 0] = 9.9  # I_xy does not count
    np.testing.assert_array_equal(torque, spin.bearing_torque(inertia, np.array([0.0, 0.0, 1.7])))


def test_the_residual_flow_has_no_momentum_and_no_angular_momentum_and_no_rotation_is_left_of_a_rigid_one():
    mass, x, v = particles(4)
    flow = spin.residual_flow(mass, x, v)
    assert abs(mass @ flow).max() < 1e-12
    assert abs(spin.angular_momentum(mass, x, flow)).max() < 1e-12
    rigid = np.cross([0.3, 0.2, -0.5], x) + [1.0, 2.0, 3.0]
    assert abs(spin.residual_flow(mass, x, rigid)).max() < 1e-14
    half = np.where(np.arange(len(mass)) < 15, 1.0, 0.0)
    mixed = np.where(half[:, None] == 1, rigid, v)
    assert abs(spin.residual_flow(mass, x, mixed, half)[:15]).max() < 1e-14
