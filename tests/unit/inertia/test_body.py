"""Bodies put together, moved and turned, against sums over point masses."""

import numpy as np
import pytest

from astroinertia.inertia.body import Body


def of_points(mass, position):
    """The body of point masses, by plain sums."""
    centre = mass @ position / mass.sum()
    return Body(mass.sum(), centre, about_by_sum(mass, position, centre))


def about_by_sum(mass, position, point):
    offsets = position - point
    return sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(mass, offsets, strict=True))


def turn(axis, angle):
    """Rotation matrix about an axis (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


@pytest.fixture
def points():
    generator = np.random.default_rng(1)
    return generator.uniform(0.5, 2.0, 9), generator.normal(size=(9, 3)) + [3.0, -2.0, 1.0]


def same(found, expected, rtol=1e-13):
    for name in ("mass", "centre", "inertia"):
        scale = abs(getattr(expected, name)).max()
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=0, atol=rtol * scale)


def test_the_tensor_about_a_point_is_the_sum_about_it(points):
    point = np.array([-1.0, 4.0, 0.5])
    np.testing.assert_allclose(of_points(*points).about(point), about_by_sum(*points, point), rtol=1e-13, atol=1e-11)


def test_the_moment_is_the_sum_of_squared_distances_from_the_line(points):
    mass, position = points
    axis, point = np.array([1.0, 2.0, -2.0]), np.array([0.3, 0.1, -5.0])
    distances = np.linalg.norm(np.cross(position - point, axis / 3.0), axis=1)
    body = of_points(mass, position)
    assert body.moment(axis, point) == pytest.approx(mass @ distances**2, rel=1e-13)
    assert body.moment([0, 0, 2]) == pytest.approx(body.inertia[2, 2], rel=1e-14)


def test_a_sum_is_the_body_of_all_points_and_a_difference_takes_them_out(points):
    mass, position = points
    whole, first, rest = of_points(mass, position), of_points(mass[:4], position[:4]), of_points(mass[4:], position[4:])
    same(first + rest, whole)
    same(whole - rest, first, 1e-12)
    same(rest + (whole - rest), whole)


def test_moving_and_turning_act_on_every_point(points):
    mass, position = points
    matrix, about, by = turn([1, 2, 3], 0.7), np.array([5.0, 0.0, -1.0]), np.array([1.0, 2.0, -7.0])
    body = of_points(mass, position)
    same(body.translated(by), of_points(mass, position + by))
    same(body.rotated(matrix, about), of_points(mass, about + (position - about) @ matrix.T))
    same(body.rotated(matrix), of_points(mass, body.centre + (position - body.centre) @ matrix.T))


def test_a_sum_far_from_the_origin_keeps_its_digits():
    # Steps of whole numbers, which a centre at 2^40 can hold exactly.
    away = np.full(3, 2.0**40)
    left, right = Body(2.0, np.zeros(3), np.eye(3)), Body(6.0, np.array([4.0, 8.0, -4.0]), 2 * np.eye(3))
    near, far = left + right, left.translated(away) + right.translated(away)
    np.testing.assert_array_equal(far.inertia, near.inertia)
    np.testing.assert_array_equal(far.centre - away, near.centre)


def test_a_hole_as_heavy_as_the_body_is_refused(points):
    body = of_points(*points)
    with pytest.raises(ValueError, match="masses add up to 0"):
        body - body.translated([1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="masses add up to 0"):
        Body(0.1 + 0.2, np.zeros(3), np.eye(3)) - Body(0.3, np.ones(3), np.eye(3))


def test_a_matrix_that_stretches_is_refused(points):
    with pytest.raises(ValueError, match="orthogonal"):
        of_points(*points).rotated(np.diag([1.0, 1.0, 1.1]))


def test_a_rotation_in_whole_numbers_is_one(points):
    body = of_points(*points)
    same(body.rotated([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), body.rotated(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])))


def test_batches_and_precision_are_kept(points):
    body = of_points(*points)
    batch = Body(*(np.stack([value, value]) for value in (body.mass, body.centre, body.inertia)))
    shifted = batch.translated([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]) + batch
    assert (shifted.mass.shape, shifted.centre.shape, shifted.inertia.shape) == ((2,), (2, 3), (2, 3, 3))
    same(Body(shifted.mass[1], shifted.centre[1], shifted.inertia[1]), body.translated([1.0, 0.0, 0.0]) + body)
    single = Body(np.float32(1), np.zeros(3, np.float32), np.eye(3, dtype=np.float32))
    double = single + single.translated(np.ones(3, np.float32)).rotated(np.eye(3, dtype=np.float32))
    assert {double.mass.dtype, double.centre.dtype, double.inertia.dtype} == {np.dtype(np.float32)}


def test_jax_differentiates_through_a_body(points):
    import jax

    with jax.enable_x64(True):
        body = jax.tree.map(jax.numpy.asarray, of_points(*points))

        @jax.jit
        def moment(shift, body):
            return (body + body.translated(shift * jax.numpy.array([1.0, 0.0, 0.0]))).moment([0.0, 0.0, 1.0])

        # Two equal masses at distance s have M s^2 / 2 about their centre.
        assert jax.grad(moment)(3.0, body) == pytest.approx(3.0 * float(body.mass), rel=1e-14)


def test_a_light_part_far_away_does_not_round_off_the_place_of_a_heavy_one():
    heavy = Body(1e9, np.array([0.3, 0.2, 0.1]), np.eye(3))
    light = Body(1e-9, np.array([1e6, 0.0, 0.0]), np.eye(3))
    for whole in (heavy + light, light + heavy):
        np.testing.assert_allclose(whole.centre - heavy.centre, [1e-12, 0.0, 0.0], atol=1e-16)


def test_the_sum_of_bodies_is_the_composite_body():
    parts = [Body(float(k + 1), np.eye(3)[k], np.diag([1.0, 2.0, 2.5])) for k in range(3)]
    whole, one_by_one = sum(parts), parts[0] + parts[1] + parts[2]
    np.testing.assert_array_equal(whole.inertia, one_by_one.inertia)
    with pytest.raises(TypeError, match="unsupported operand"):
        1 + parts[0]
