"""Identities of inertia tensors that hold for every body, over twelve decades of mass and of length."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as some

from astroinertia.inertia import evolution, principal, spin, tensor
from astroinertia.inertia.body import Body

EXACT = 1e-13  # of the size of I, or of |I| + M d^2 where a tensor is shifted by d
DECADES = some.floats(-6, 6)


@some.composite
def clouds(draw):
    """Masses (N,) and positions (N, 3) of a body somewhere, its own size and distance each over twelve decades."""
    generator = np.random.default_rng(draw(some.integers(0, 2**32 - 1)))
    count = draw(some.integers(2, 40))
    size = 10.0 ** draw(DECADES)
    mass = 10.0 ** draw(DECADES) * generator.uniform(0.01, 1, count)
    shape = size * 10.0 ** generator.uniform(-3, 0, 3)  # rods and discs too
    position = generator.normal(size=(count, 3)) * shape
    if draw(some.booleans()):
        position = position + 10.0 ** draw(DECADES) * generator.normal(size=3)
    return mass, position


@some.composite
def rotations(draw):
    quaternion = np.random.default_rng(draw(some.integers(0, 2**32 - 1))).normal(size=4)
    w, *vector = quaternion / np.linalg.norm(quaternion)
    x, y, z = vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


shifts = some.builds(
    lambda seed, size: 10.0**size * np.random.default_rng(seed).normal(size=3), some.integers(0, 2**32 - 1), DECADES
)


def size_of(inertia):
    return np.linalg.norm(inertia)


def reach(mass, position, origin=0.0):
    """|I| + M d^2 about the centre with the distance d of the centre from a point."""
    return size_of(tensor.inertia_tensor(mass, position)) + mass.sum() * np.sum(
        (tensor.centre_of_mass(mass, position) - origin) ** 2
    )


def body_of(mass, position):
    return Body(mass.sum(), tensor.centre_of_mass(mass, position), tensor.inertia_tensor(mass, position))


def assert_near(found, expected, scale):
    assert abs(np.asarray(found) - expected).max() <= EXACT * scale


@given(clouds(), rotations())
def test_a_turned_body_has_the_turned_tensor(cloud, matrix):
    mass, position = cloud
    origin = np.zeros(3)
    inertia = tensor.inertia_tensor(mass, position, origin)
    turned = tensor.inertia_tensor(mass, position @ matrix.T, origin)
    assert_near(turned, tensor.rotated(inertia, matrix), size_of(inertia))
    assert_near(tensor.rotated(tensor.rotated(inertia, matrix), matrix.T), inertia, size_of(inertia))
    assert_near(tensor.invariants(turned)[0], tensor.invariants(inertia)[0], size_of(inertia))
    assert_near(tensor.invariants(turned)[1], tensor.invariants(inertia)[1], size_of(inertia) ** 2)
    assert_near(tensor.invariants(turned)[2], tensor.invariants(inertia)[2], size_of(inertia) ** 3)


@given(clouds(), shifts)
def test_the_parallel_axis_theorem_there_and_back(cloud, shift):
    mass, position = cloud
    total, centre = mass.sum(), tensor.centre_of_mass(mass, position)
    inertia = tensor.inertia_tensor(mass, position)
    point = centre + shift
    offset = centre - point  # as the numbers have it, after the rounding of the point
    about = tensor.about_point(inertia, total, offset)
    shift = np.linalg.norm(offset)
    scale = size_of(inertia) + total * shift**2
    # A centre at a distance D from the origin is itself rounded, and the moments of mass about it are not quite 0.
    rounding = total * shift * np.linalg.norm(centre)
    assert_near(tensor.inertia_tensor(mass, position, point), about, scale + rounding)
    assert_near(tensor.about_centre(about, total, offset), inertia, scale)
    assert_near(Body(total, centre, inertia).about(point), about, scale)


@given(clouds(), shifts)
def test_the_tensor_about_the_centre_of_mass_does_not_know_where_the_body_is(cloud, shift):
    mass, position = cloud
    moved = position + shift
    assert_near(
        tensor.inertia_tensor(mass, moved),
        tensor.inertia_tensor(mass, position),
        reach(mass, position) + reach(mass, moved),
    )


@given(clouds(), clouds(), clouds())
def test_bodies_add_up_in_any_order_and_come_apart_again(one, two, three):
    parts = one, two, three
    a, b, c = (body_of(*part) for part in parts)
    mass = np.concatenate([part[0] for part in parts])
    position = np.concatenate([part[1] for part in parts])
    whole = body_of(mass, position)
    scale = reach(mass, position)
    for body in (a + b + c, c + (b + a)):
        assert_near(body.mass, whole.mass, whole.mass)
        assert_near(body.centre, whole.centre, abs(position).max())
        assert_near(body.inertia, whole.inertia, scale)
        assert_near(body.about(np.zeros(3)), tensor.inertia_tensor(mass, position, np.zeros(3)), scale)
    rest = whole - a
    if rest.mass > 0.01 * whole.mass:
        # About a point that both share: the centre of what is left is known to a rounding of the whole only.
        assert_near(rest.about(whole.centre), (b + c).about(whole.centre), 100 * scale)


@given(clouds())
def test_the_trace_is_twice_the_sum_of_squared_distances(cloud):
    mass, position = cloud
    expected = 2 * (mass * (position**2).sum(1)).sum()
    assert_near(np.trace(tensor.inertia_tensor(mass, position, np.zeros(3))), expected, expected)


@given(clouds())
def test_principal_moments_keep_the_triangle_inequalities(cloud):
    inertia = tensor.inertia_tensor(*cloud)
    low, middle, high = principal.principal_moments(inertia)
    assert low >= -EXACT * high
    assert low <= middle <= high
    assert low + middle >= high * (1 - EXACT)
    tensor.require_plausible(inertia)


@given(clouds())
def test_the_second_moment_and_the_tensor_invert_each_other(cloud):
    second = tensor.second_moment(*cloud)
    inertia = tensor.inertia_from_second_moment(second)
    assert_near(tensor.second_moment_from_inertia(inertia), second, size_of(inertia))
    assert_near(inertia, tensor.inertia_tensor(*cloud), size_of(inertia))


@pytest.mark.slow
@given(clouds(), some.randoms(use_true_random=False), some.permutations(range(3)))
def test_the_order_of_particles_and_the_names_of_the_axes_do_not_matter(cloud, random, names):
    mass, position = cloud
    order = list(range(len(mass)))
    random.shuffle(order)
    inertia = tensor.inertia_tensor(mass, position)
    assert_near(tensor.inertia_tensor(mass[order], position[order]), inertia, reach(mass, position))
    renamed = tensor.inertia_tensor(mass, position[:, names])
    assert_near(renamed, inertia[np.ix_(names, names)], size_of(inertia))
    assert_near(principal.principal_moments(renamed), principal.principal_moments(inertia), size_of(inertia))


@given(clouds(), rotations())
def test_principal_axes_give_the_tensor_back(cloud, matrix):
    inertia = tensor.inertia_tensor(cloud[0], cloud[1] @ matrix.T)
    moments, axes = principal.principal_frame(inertia)
    assert_near(np.einsum("k,ki,kj->ij", moments, axes, axes), inertia, size_of(inertia))
    assert_near(axes @ axes.T, np.eye(3), 1.0)
    assert np.linalg.det(axes) == pytest.approx(1.0, rel=EXACT)


@given(clouds(), shifts)
def test_a_rigid_rotation_is_its_own_mean_spin_and_keeps_the_principal_moments(cloud, rate):
    mass, position = cloud
    position = position - tensor.centre_of_mass(mass, position)
    velocity = np.cross(rate, position)
    inertia = tensor.inertia_tensor(mass, position)
    momentum = spin.angular_momentum(mass, position, velocity)
    scale = size_of(inertia) * np.linalg.norm(rate)
    assert_near(momentum, inertia @ rate, scale)
    # dI/dt = [omega x, I]
    turning = -(np.cross(np.eye(3), rate).T @ inertia)
    assert_near(evolution.inertia_rate(mass, position, velocity), turning + turning.T, scale)


@settings(max_examples=30)
@given(clouds(), some.floats(0.1, 10))
def test_tensors_scale_with_mass_and_with_the_square_of_length(cloud, factor):
    mass, position = cloud
    inertia = tensor.inertia_tensor(mass, position)
    assert_near(tensor.inertia_tensor(factor * mass, position), factor * inertia, factor * size_of(inertia))
    scaled = tensor.inertia_tensor(mass, 4.0 * position)
    np.testing.assert_array_equal(scaled, 16.0 * inertia)  # by a power of two not even a rounding changes
