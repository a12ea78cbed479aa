"""Matrices, quaternions, rotation vectors and Euler angles, against scipy's rotations and each other."""

from itertools import product

import numpy as np
import pytest
from astropy import units as u
from scipy.spatial.transform import Rotation

from astroinertia.rotation import attitude

SEQUENCES = ["".join(axes) for axes in product("xyz", repeat=3) if axes[0] != axes[1] != axes[2]]


def rotations(count=40):
    return Rotation.random(count, rng=np.random.default_rng(5)).as_matrix()


def test_the_cross_matrix_takes_a_cross_product():
    v, x = np.random.default_rng(1).normal(size=(2, 7, 3))
    np.testing.assert_allclose(
        (attitude.cross_matrix(v) @ x[..., None])[..., 0], np.cross(v, x), rtol=1e-15, atol=1e-15
    )


@pytest.mark.parametrize("angle", [0.0, 1e-160, 1e-9, 1e-4, 1.0, np.pi - 1e-9, np.pi, 3.5, 40.0])
def test_rotations_about_a_vector_are_those_of_scipy_at_any_angle(angle):
    vector = angle * np.array([0.36, -0.48, 0.8])
    matrix = attitude.rotation(vector)
    np.testing.assert_allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), rtol=0, atol=4e-16)
    if angle < np.pi:
        # Next to pi the vector is as well known as the matrix, no better.
        np.testing.assert_allclose(attitude.rotation_vector(matrix), vector, rtol=1e-15, atol=5e-16)


def test_small_rotation_vectors_come_back_with_all_digits():
    vector = np.array([1e-9, -3e-12, 2e-15])
    np.testing.assert_allclose(attitude.rotation_vector(attitude.rotation(vector)), vector, rtol=1e-14)


def test_half_turns_come_back_about_either_direction():
    for axis in (np.array([1.0, 0, 0]), np.array([0, 0.6, -0.8]), np.array([-0.36, 0.48, 0.8])):
        found = attitude.rotation_vector(attitude.rotation(np.pi * axis))
        np.testing.assert_allclose(abs(found @ axis), np.pi, rtol=1e-15)


def test_quaternions_are_those_of_the_rotation_that_turned_the_body():
    matrices = np.concatenate([rotations(), np.stack([np.diag(d) for d in ([1.0, 1, 1], [1, -1, -1], [-1, -1, 1])])])
    expected = Rotation.from_matrix(matrices).as_quat(canonical=True, scalar_first=True)
    found = attitude.quaternion(np.swapaxes(matrices, -1, -2))
    np.testing.assert_allclose(found, expected, rtol=0, atol=6e-16)
    for length in (1e-300, 1e-200, 1.0, 1e200):  # whose squares numbers hold, or do not
        scale = length * np.linspace(0.1, 9, len(found))[:, None]
        np.testing.assert_allclose(
            attitude.attitude_of_quaternion(scale * found), np.swapaxes(matrices, -1, -2), rtol=0, atol=1e-15
        )


def test_the_product_of_quaternions_is_one_rotation_after_another():
    first, second = rotations(2)
    product = attitude.quaternion_product(attitude.quaternion(second.T), attitude.quaternion(first.T))
    np.testing.assert_allclose(attitude.attitude_of_quaternion(product), (second @ first).T, rtol=0, atol=1e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_are_those_of_scipy_and_give_the_attitude_back(sequence):
    matrices = rotations()
    angles = attitude.euler_angles(np.swapaxes(matrices, -1, -2), sequence)
    np.testing.assert_allclose(angles, Rotation.from_matrix(matrices).as_euler(sequence.upper()), rtol=0, atol=2e-14)
    again = attitude.attitude_of_euler_angles(angles, sequence)
    np.testing.assert_allclose(again, np.swapaxes(matrices, -1, -2), rtol=0, atol=1e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("away", [0.0, 1e-300, 1e-17, 1e-9, 1e-5])
def test_euler_angles_give_the_attitude_back_where_they_are_ill_defined(sequence, away):
    ends = (0.0, np.pi) if sequence[0] == sequence[2] else (-np.pi / 2, np.pi / 2)
    for end in ends:
        matrix = attitude.attitude_of_euler_angles(np.array([0.7, end + away, -1.9]), sequence)
        angles = attitude.euler_angles(matrix, sequence)
        np.testing.assert_allclose(attitude.attitude_of_euler_angles(angles, sequence), matrix, rtol=0, atol=1e-15)


def test_precession_nutation_and_spin_are_the_angles_of_mechanics():
    # Goldstein et al. eq. 4.46: the rows of A are the body's axes
    phi, theta, psi = 0.4, 1.1, -0.8
    found = attitude.attitude_of_euler_angles(np.array([phi, theta, psi]))
    np.testing.assert_allclose(found[2], [np.sin(theta) * np.sin(phi), -np.sin(theta) * np.cos(phi), np.cos(theta)])
    np.testing.assert_allclose(found[:, 2], [np.sin(theta) * np.sin(psi), np.sin(theta) * np.cos(psi), np.cos(theta)])


def test_other_sequences_are_refused():
    for sequence in ("xx", "zxx", "abc", "zxzx"):
        with pytest.raises(ValueError, match="a sequence of Euler angles"):
            attitude.euler_angles(np.eye(3), sequence)


@pytest.mark.parametrize("function", [attitude.quaternion, attitude.rotation_vector, attitude.euler_angles])
def test_a_matrix_that_is_no_rotation_is_refused_and_an_unknown_one_stays_unknown(function):
    import jax

    wrong = (np.diag([1, 1, -1]), 2.0 * np.eye(3), np.diag([1.0, 1.0, np.inf]), np.eye(2))
    for matrix, words in zip(wrong, ("must not mirror", *["must be orthogonal"] * 3), strict=True):
        for among in (matrix, np.stack([np.eye(len(matrix)), matrix])):
            with pytest.raises(ValueError, match=words):
                function(among)
    some = np.stack([rotations(1)[0], np.full((3, 3), np.nan)])
    np.testing.assert_allclose(function(some[0].round(8)), function(some[0]), rtol=0, atol=1e-7)  # as people write it
    found = function(some)
    np.testing.assert_array_equal(found[0], function(some[0]))
    assert np.isnan(found[1]).all()
    with jax.enable_x64(True):
        known = jax.numpy.asarray(some[0])
        with pytest.raises(ValueError, match="must be orthogonal"):
            function(2.0 * known)
        np.testing.assert_allclose(jax.jit(lambda: function(known))(), found[0], rtol=1e-14)


def test_the_nearest_rotation_is_nearer_than_its_neighbours_and_never_a_reflection():
    generator = np.random.default_rng(3)
    for matrix in (generator.normal(size=(3, 3)), -rotations(1)[0], np.diag([2.0, 1.0, 0.5])):
        found = attitude.nearest_rotation(matrix)
        np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(found) == pytest.approx(1.0)
        near = attitude.rotation(1e-3 * generator.normal(size=(20, 3))) @ found
        assert (((near - matrix) ** 2).sum((1, 2)) >= ((found - matrix) ** 2).sum()).all()


def test_the_nearest_rotation_is_nan_where_a_matrix_is_and_of_no_other_shape():
    found = attitude.nearest_rotation(np.stack([2.0 * np.eye(3), np.full((3, 3), np.nan), np.diag([np.inf, 1.0, 1.0])]))
    np.testing.assert_array_equal(found[0], np.eye(3))
    assert np.isnan(found[1:]).all()
    for shape in ((3,), (2, 2), (3, 4)):
        with pytest.raises(ValueError, match=r"takes matrices of shape \(..., 3, 3\), not"):
            attitude.nearest_rotation(np.ones(shape))


ROUND = {"identity": np.eye(3), "larger": 2.5 * np.eye(3), "turned": rotations(2)[1], "two equal": np.diag([2.0, 2, 1])}


@pytest.mark.slow
@pytest.mark.parametrize(
    "matrix", [*ROUND.values(), np.random.default_rng(3).normal(size=(3, 3)), -rotations(1)[0] @ np.diag([3.0, 2, 1])],
    ids=[*ROUND, "any", "mirrored"],
)  # fmt: skip
def test_the_nearest_rotation_has_its_derivatives_also_at_rotations(matrix):
    import jax

    along, step = np.random.default_rng(4).normal(size=(2, 3, 3)), 1e-4

    def difference(function, by):
        """Of order 4."""
        near, far = (function(matrix + k * by) - function(matrix - k * by) for k in (step, 2 * step))
        return np.asarray(8 * near - far) / (12 * step)

    with jax.enable_x64(True):

        def slope(at):
            return jax.jvp(attitude.nearest_rotation, (at,), (jax.numpy.asarray(along[0]),))[1]

        point = jax.numpy.asarray(matrix)
        exact = slope(point)
        np.testing.assert_allclose(exact, difference(attitude.nearest_rotation, along[0]), rtol=0, atol=1e-10)
        second = jax.jvp(slope, (point,), (jax.numpy.asarray(along[1]),))[1]
        np.testing.assert_allclose(second, difference(slope, along[1]), rtol=0, atol=1e-9)
        backwards = jax.jit(jax.grad(lambda at: (along[1] * attitude.nearest_rotation(at)).sum()))(point)
        assert (backwards * along[0]).sum() == pytest.approx(float((along[1] * exact).sum()), rel=1e-12)
        many = jax.vmap(slope)(jax.numpy.stack([point, 2.0 * point]))
        np.testing.assert_allclose(many, [exact, 0.5 * exact], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-4, 1.0, 3.1, np.pi])
def test_the_angle_between_attitudes_keeps_its_digits(angle):
    one = rotations(1)[0]
    other = attitude.rotation(angle * np.array([0.0, 0.6, 0.8])) @ one
    assert attitude.angle_between(one, other) == pytest.approx(angle, rel=0, abs=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.0, 1e-3, 1.0])
def test_the_square_of_an_angle_has_a_slope_also_of_attitudes_that_are_the_same(angle):
    import jax

    with jax.enable_x64(True):
        turn = jax.grad(
            lambda size: attitude.angle_between(attitude.rotation(size * np.array([0.0, 0.6, 0.8])), np.eye(3)) ** 2
        )
        assert float(turn(angle)) == pytest.approx(2.0 * angle, rel=1e-12, abs=1e-15)


@pytest.mark.slow
def test_the_rate_of_an_attitude_is_its_derivative_in_jax():
    import jax

    spin = np.array([0.2, -1.0, 0.4])

    @jax.jit
    def compiled(start):
        def turned(time):
            return attitude.rotation(-time * spin) @ start  # seen from the body, the world turns the other way

        value, rate = jax.jvp(turned, (0.0,), (1.0,))
        by_quaternion = attitude.attitude_of_quaternion(attitude.quaternion(value))
        by_angles = attitude.attitude_of_euler_angles(attitude.euler_angles(value))
        known = attitude.attitude_rate(value, spin), attitude.body_angular_velocity(value, rate)
        return value, rate, by_quaternion, by_angles, *known

    with jax.enable_x64(True):
        for start in (rotations(1)[0], np.eye(3)):
            value, rate, by_quaternion, by_angles, expected_rate, expected_spin = compiled(start)
            np.testing.assert_allclose(rate, expected_rate, rtol=0, atol=1e-15)
            np.testing.assert_allclose(expected_spin, spin, rtol=0, atol=1e-15)
            np.testing.assert_allclose(by_quaternion, value, rtol=0, atol=1e-15)
            np.testing.assert_allclose(by_angles, value, rtol=0, atol=1e-15)


def test_rates_may_have_units():
    rate = attitude.attitude_rate(np.eye(3), [10.0, 20.0, 30.0] * u.deg / u.min)
    expected = np.radians([10.0, 20.0, 30.0]) / 60
    np.testing.assert_allclose(attitude.body_angular_velocity(np.eye(3), rate * 3600 / u.h), expected, rtol=1e-15)


@pytest.mark.parametrize("sequence", ["zxz", "zyz", "xyz", "zyx"])
def test_no_turn_has_no_angles(sequence):
    np.testing.assert_array_equal(attitude.euler_angles(np.eye(3), sequence), 0.0)
    about_one = attitude.attitude_of_euler_angles(np.array([0.5, 0.0, 0.0]), sequence)
    first, second, third = attitude.euler_angles(about_one, sequence)
    assert (first + third, second) == pytest.approx((0.5, 0.0), abs=1e-15) and first in (0.0, pytest.approx(0.5))


def test_the_angle_to_an_attitude_that_is_not_known_is_not_known():
    assert np.isnan(attitude.angle_between(np.eye(3), np.full((3, 3), np.nan)))  # it was 0
