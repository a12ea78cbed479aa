"""Inertia tensors and what follows from them, against closed forms and plain sums."""

import numpy as np

from astroinertia.inertia import tensor


def random_tensor(seed):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(20, 3)) * [1.0, 1.4, 2.1]
    return tensor.inertia_from_second_moment(points.T @ points)


def test_second_moment_and_inertia_invert_each_other_for_points():
    points = np.random.default_rng(1).normal(size=(50, 3))
    mass = np.random.default_rng(2).uniform(1, 2, 50)
    second = (mass[:, None] * points).T @ points
    direct = sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(mass, points, strict=True))
    inertia = tensor.inertia_from_second_moment(second)
    np.testing.assert_allclose(inertia, direct, rtol=1e-13, atol=1e-12)
    np.testing.assert_allclose(tensor.second_moment_from_inertia(inertia), second, rtol=1e-13, atol=1e-12)


def test_axial_vector_is_the_angular_momentum():
    generator = np.random.default_rng(3)
    x, v, mass = generator.normal(size=(9, 3)), generator.normal(size=(9, 3)), generator.uniform(1, 2, 9)
    mixed = (mass[:, None] * x).T @ v
    np.testing.assert_allclose(tensor.axial_vector(mixed), mass @ np.cross(x, v), rtol=1e-13)


def test_semi_axes_of_a_homogeneous_ellipsoid():
    mass, axes = 3.0, np.array([1.0, 2.0, 3.0])
    squares = axes**2
    moments = mass / 5 * (squares.sum() - squares)
    np.testing.assert_allclose(tensor.equivalent_semi_axes(mass, moments), axes, rtol=1e-14)


def test_angular_velocity_of_a_rigid_rotation_and_of_a_body_without_inertia():
    inertia, spin = random_tensor(4), np.array([0.3, -1.2, 2.0])
    np.testing.assert_allclose(tensor.angular_velocity(inertia, inertia @ spin), spin, rtol=1e-12)
    rod = tensor.inertia_from_second_moment(np.diag([0.0, 0.0, 1.0]))
    assert np.isnan(tensor.angular_velocity(rod, np.array([0.0, 0.0, 1.0]))).all()
    assert np.isnan(tensor.angular_velocity(np.zeros((3, 3)), np.zeros(3))).all()
