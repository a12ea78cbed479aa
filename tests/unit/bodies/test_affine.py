"""Gravity of a deformed sphere against Carlson's integrals in 40 digits, and its derivatives against each other."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from astroinertia.bodies import affine, ellipsoid_gravity

SPHERE_ENERGY = -0.6
ROUND_OFF = 3e-15
AXES = [
    (1, 1, 1),
    (1.2, 1, 0.8),
    (1, 1, 0.5),
    (1, 0.5, 0.5),
    (1, 1 + 1e-9, 1 - 1e-9),
    (1, 1, 1e-6),
    (1, 1e-6, 1e-6),
    (1, 1e-3, 1e-6),
    (1, 1e-12, 1e-12),
    (1, 1, 1e-12),
    (1e9, 1e9, 0.7e9),
]
TILTED = np.array([[1.1, 0.2, -0.3], [0.1, 0.8, 0.25], [-0.2, 0.15, 0.9]])


def exact(axes):
    with mpmath.workdps(40):
        a = [mpmath.mpf(float(axis)) for axis in axes]
        squares = [axis**2 for axis in a]
        symbols = [
            mpmath.mpf(2) / 3 * a[0] * a[1] * a[2] * mpmath.elliprd(squares[i - 1], squares[i - 2], squares[i])
            for i in range(3)
        ]
        return [float(symbol) for symbol in symbols], float(mpmath.elliprf(*squares))


@pytest.mark.full
def test_energy_and_tensor():
    axes = np.array(AXES, dtype=float)
    with jax.enable_x64(True):
        matrices = jax.vmap(jnp.diag)(jnp.asarray(axes))
        energies = np.array(jax.vmap(affine.gravitational_energy, (0, None))(matrices, SPHERE_ENERGY))
        tensors = np.array(jax.vmap(affine.gravity_tensor, (0, None))(matrices, SPHERE_ENERGY))
    for each, energy, tensor in zip(axes, energies, tensors, strict=True):
        wanted, first = exact(each)
        np.testing.assert_allclose(energy, SPHERE_ENERGY * first, rtol=ROUND_OFF)
        diagonal = SPHERE_ENERGY * each / (2 * np.roll(each, 1) * np.roll(each, 2)) * wanted
        np.testing.assert_allclose(tensor, np.diag(diagonal), rtol=ROUND_OFF)


def test_tensor_turns_with_the_body():
    left, axes, right = np.linalg.svd(TILTED)
    wanted = left @ np.diag(ellipsoid_gravity.potential_energy_tensor(axes)) @ left.T
    np.testing.assert_allclose(affine.gravity_tensor(TILTED, SPHERE_ENERGY), wanted, atol=1e-15)
    turned = affine.gravity_tensor(TILTED @ right.T, SPHERE_ENERGY)
    np.testing.assert_allclose(turned, wanted, atol=1e-15)


@pytest.mark.slow
def test_force_is_the_gradient_of_the_energy():
    deformations = np.array([TILTED, np.eye(3), np.diag([1.0, 1.0, 0.6]), np.diag([1.0, 1.0, 1e-6])])
    with jax.enable_x64(True):
        batch = jnp.asarray(deformations)
        gradients = np.array(jax.vmap(jax.grad(affine.gravitational_energy), (0, None))(batch, SPHERE_ENERGY))
        forces = np.array(jax.vmap(affine.gravity_force, (0, None))(batch, SPHERE_ENERGY))
    for deformation, gradient, force in zip(deformations, gradients, forces, strict=True):
        np.testing.assert_allclose(force, -gradient, rtol=1e-13, atol=1e-15)
        tensor = affine.gravity_tensor(deformation, SPHERE_ENERGY)
        np.testing.assert_allclose(deformation @ force.T, tensor, rtol=1e-13, atol=1e-15)


@pytest.mark.full
def test_second_derivatives_of_a_sphere():
    with jax.enable_x64(True):
        second = jax.jacfwd(affine.gravity_force)(jnp.eye(3), -1.0)
    second = np.einsum("iijj->ij", second)
    with mpmath.workdps(30):
        along = mpmath.diff(lambda e: mpmath.elliprf((1 + e) ** 2, 1, 1), 0, 2)
        across = mpmath.diff(lambda e, f: mpmath.elliprf((1 + e) ** 2, (1 + f) ** 2, 1), (0, 0), (1, 1))
    wanted = np.where(np.eye(3, dtype=bool), float(along), float(across))
    np.testing.assert_allclose(second, wanted, rtol=1e-13)


@pytest.mark.full
def test_pair_symbol_of_a_spheroid_is_the_derivative():
    # dA_1/da_2 at a_1 = a_2 has the pair symbols, which differences of A would lose; V_11 = -(3/10) a_1 A_1/(a_2 a_3).
    axes = np.array([1.0, 1.0, 0.6])
    pair = ellipsoid_gravity.index_integral(axes**2, (0, 1), 0)

    def symbol(axes):
        tensor = affine.gravity_tensor(jnp.diag(axes), SPHERE_ENERGY)
        return tensor[0, 0] / (0.5 * SPHERE_ENERGY) * axes[1] * axes[2] / axes[0]

    with jax.enable_x64(True):
        value, slope = float(symbol(jnp.asarray(axes))), float(jax.jacfwd(symbol)(jnp.asarray(axes))[1])
    np.testing.assert_allclose(value, ellipsoid_gravity.index_symbols(axes)[0], rtol=1e-14)
    np.testing.assert_allclose(slope, value / axes[1] - axes[1] * pair, rtol=1e-13)


@pytest.mark.slow
def test_parts_keep_double_precision_and_take_lists():
    cofactors = np.linalg.det(TILTED) * np.linalg.inv(TILTED).T
    for given in (TILTED, TILTED.tolist()):
        np.testing.assert_allclose(affine.cofactor(given), cofactors, rtol=1e-14)
        assert float(affine.volume_ratio(given)) == pytest.approx(np.linalg.det(TILTED), rel=1e-14)
    x, y, z = 1.0, 0.5, 0.25
    wanted = float(mpmath.elliprf(x, y, z))
    assert float(affine.first_integral(x + y + z, x * y + y * z + z * x, x * y * z)) == pytest.approx(wanted, rel=1e-14)
    energy = affine.gravitational_energy(TILTED, SPHERE_ENERGY)
    assert affine.gravitational_energy(TILTED.tolist(), SPHERE_ENERGY) == energy
