"""Equations of motion of a deformed sphere: figures of equilibrium, the constraint, viscosity and waves."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies import affine, affine_motion, ellipsoid_gravity, jacobi

MOMENT, ENERGY = 0.2, -0.6  # of the homogeneous sphere of unit mass and radius
TILTED = np.array([[1.1, 0.2, -0.3], [0.1, 0.8, 0.25], [-0.2, 0.15, 0.9]])
FLOW = np.array([[0.1, -0.4, 0.2], [0.5, 0.2, -0.1], [0.05, 0.3, -0.3]])
SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def still_volume(deformation, rate):
    """The flow whose volume stays: less what changes det F."""
    cofactors = np.array(affine.cofactor(deformation))
    return rate - (cofactors * rate).sum() / (cofactors**2).sum() * cofactors


def jacobi_ellipsoid():
    figure = jacobi.from_axis_ratio(0.6)
    return (
        figure.axes,
        figure.angular_velocity,
        np.diag(figure.axes),
        figure.angular_velocity * SPIN @ np.diag(figure.axes),
    )


def test_jacobi_ellipsoid_turns_rigidly():
    _, spin, deformation, rate = jacobi_ellipsoid()
    acceleration = affine_motion.incompressible_acceleration(deformation, rate, ENERGY, MOMENT)
    np.testing.assert_allclose(acceleration, spin**2 * SPIN @ SPIN @ deformation, atol=1e-14)


@pytest.mark.full
def test_derivatives_of_the_moments_of_a_jacobi_ellipsoid():
    axes, spin, deformation, rate = jacobi_ellipsoid()

    def acceleration(at, moving):
        return affine_motion.incompressible_acceleration(at, moving, ENERGY, MOMENT)

    with jax.enable_x64(True):
        derivatives = jax.jit(lambda a, b: affine_motion.second_moment_derivatives(a, b, MOMENT, acceleration))(
            jnp.asarray(deformation), jnp.asarray(rate)
        )
    half = 0.5 * MOMENT * (axes[0] ** 2 - axes[1] ** 2)
    for order, derivative in enumerate(derivatives, start=1):
        phase = order * np.pi / 2
        wanted = np.zeros((3, 3))
        wanted[:2, :2] = [[np.cos(phase), np.sin(phase)], [np.sin(phase), -np.cos(phase)]]
        np.testing.assert_allclose(derivative, (2 * spin) ** order * half * wanted, atol=1e-14)


@pytest.mark.slow
def test_derivatives_keep_double_precision_and_take_lists_of_whole_numbers():
    """Q = F F^T/3 of F = cos(t): its fourth derivative is 8/3."""

    def swinging(matrix, rate):
        return -matrix

    rate = np.zeros((3, 3))
    for whole in (np.eye(3), np.eye(3, dtype=int), np.eye(3, dtype=int).tolist()):
        fourth = affine_motion.second_moment_derivatives(whole, rate, 1 / 3, swinging)[3]
        np.testing.assert_allclose(fourth, np.eye(3) * 8 / 3, rtol=1e-15, atol=0.0)

    def wrong(matrix, rate):
        raise TypeError("no such motion")

    with pytest.raises(TypeError, match="no such motion"):
        affine_motion.second_moment_derivatives(np.eye(3), rate, 1.0, wrong)


@pytest.mark.slow
def test_constraint_keeps_the_volume_and_the_restoring_rate_brings_it_back():
    with jax.enable_x64(True):
        deformation, rate = jnp.asarray(TILTED), jnp.asarray(still_volume(TILTED, FLOW))
        acceleration = affine_motion.incompressible_acceleration(deformation, rate, ENERGY, MOMENT)

        def volume(time):
            return affine.volume_ratio(deformation + time * rate + 0.5 * time**2 * acceleration)

        slope, curvature = jax.grad(volume)(0.0), jax.grad(jax.grad(volume))(0.0)
        force = affine.gravity_force(deformation, ENERGY)
        pressed = affine_motion.constraint_slope(deformation, jnp.asarray(FLOW), force, MOMENT, 3.0, 0.5)
        pushed = (force + affine_motion.pressure_force(deformation, pressed)) / MOMENT

        def wandering(time):
            return affine.volume_ratio(deformation + time * jnp.asarray(FLOW) + 0.5 * time**2 * pushed)

        start, drift, growth = wandering(0.0), jax.grad(wandering)(0.0), jax.grad(jax.grad(wandering))(0.0)
    assert abs(float(slope)) < 1e-15 and abs(float(curvature)) < 1e-14
    np.testing.assert_allclose(float(growth), -6.0 * float(drift) - 9.0 * (float(start) - 0.5), rtol=1e-13)


def test_neither_gravity_nor_pressure_changes_circulation_or_angular_momentum():
    with jax.enable_x64(True):
        deformation, rate = jnp.asarray(TILTED), jnp.asarray(still_volume(TILTED, FLOW))
        acceleration = affine_motion.incompressible_acceleration(deformation, rate, ENERGY, MOMENT)
        change = affine_motion.circulation(deformation, acceleration, MOMENT)  # d/dt of it: F'^T F' has none
        torque = affine_motion.circulation(deformation.T, acceleration.T, MOMENT)
        kept = affine_motion.circulation(deformation, rate, MOMENT)
    assert np.abs(change).max() < 1e-15 and np.abs(torque).max() < 1e-15 and np.abs(kept).max() > 0.01


def test_viscosity_takes_energy_but_no_angular_momentum():
    with jax.enable_x64(True):
        deformation, rate = jnp.asarray(TILTED), jnp.asarray(FLOW)
        force = np.array(affine_motion.shear_force(deformation, rate, 0.3))
        gradient = np.array(affine_motion.velocity_gradient(deformation, rate))
        turning = affine_motion.shear_force(deformation, jnp.asarray(SPIN) @ deformation, 0.3)
    np.testing.assert_allclose(gradient, FLOW @ np.linalg.inv(TILTED), atol=1e-15)
    shear = 0.5 * (gradient + gradient.T) - np.trace(gradient) / 3 * np.eye(3)
    np.testing.assert_allclose((force * FLOW).sum(), -2 * 0.3 * (shear**2).sum(), rtol=1e-13)
    tensor = TILTED @ force.T
    np.testing.assert_allclose(tensor, tensor.T, atol=1e-15)
    assert np.abs(turning).max() < 1e-15


def test_waves_are_made_by_the_traceless_part():
    tensor = np.diag([3.0, 1.0, -1.0])
    np.testing.assert_allclose(
        affine_motion.radiation_reaction_tensor(tensor, 0.5), np.diag([-0.4, 0.0, 0.4]), atol=1e-15
    )


def test_gravity_agrees_with_the_ellipsoids_own():
    axes = np.array([1.3, 1.0, 0.7])
    wanted = ellipsoid_gravity.potential_energy_tensor(axes)
    np.testing.assert_allclose(np.diag(affine.gravity_force(np.diag(axes), ENERGY)) * axes, wanted, rtol=1e-14)
