"""The penalty energy of a target tensor: its gradient, what it is blind to and what it conserves."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from astroinertia.inertia import target
from astroinertia.inertia.tensor import axial_vector

CASES = {
    "given axes": {},
    "own stiffness": {"orientation_stiffness": 0.7},
    "free orientation": {"orientation_stiffness": 0.0},
    "free size": {"free_size": True},
    "free size and orientation": {"free_size": True, "orientation_stiffness": 0.0},
    "in a plane": {"normal": np.array([0.3, -0.5, 1.0])},
    "in a plane, free size": {"normal": np.array([0.3, -0.5, 1.0]), "free_size": True, "orientation_stiffness": 0.7},
}
STIFFNESS = 2.3


def rotation(seed):
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return matrix * np.linalg.det(matrix)


def cloud(seed=1, count=40):
    random = np.random.default_rng(seed)
    return random.uniform(0.5, 1.5, count), random.normal(size=(count, 3)) * (1.0, 0.6, 1.7) @ rotation(3) + 5.0


def second_moment(mass, position):
    relative = position - mass @ position / mass.sum()
    return (mass[:, None] * relative).T @ relative


TARGET = target.target_tensor(np.array([10.0, 30.0, 90.0]), rotation(4))


def energy(mass, position, **options):
    return target.target_energy(second_moment(mass, position), TARGET, STIFFNESS, **options)


@pytest.mark.slow
@pytest.mark.parametrize("options", CASES.values(), ids=CASES)
def test_the_gradient_is_that_of_the_energy(options):
    mass, position = cloud()
    with jax.enable_x64(True):
        exact = jax.grad(lambda x: energy(jnp.asarray(mass), x, **options))(jnp.asarray(position))
    found = target.target_energy_gradient(mass, position, TARGET, STIFFNESS, **options)
    np.testing.assert_allclose(found, exact, rtol=1e-11, atol=1e-11 * abs(found).max())
    assert abs(found).max() > 0.1


@pytest.mark.parametrize("options", CASES.values(), ids=CASES)
def test_it_does_not_see_translation_and_exerts_no_net_force(options):
    mass, position = cloud()
    shifted = position + (100.0, -30.0, 7.0)
    assert energy(mass, shifted, **options) == pytest.approx(energy(mass, position, **options), rel=1e-12)
    force = target.target_energy_gradient(mass, position, TARGET, STIFFNESS, **options)
    assert np.linalg.norm(force.sum(0)) < 1e-13 * np.linalg.norm(force, axis=1).sum()


@pytest.mark.full
@given(st.floats(-6, 6), st.floats(-6, 6), st.sampled_from(list(CASES)))
def test_it_scales_as_mass_times_length_squared(mass, length, case):
    """Over twelve decades of each; the acceleration's matrix stays as it is."""
    second, scale = second_moment(*cloud()), 10.0 ** (mass + 2.0 * length)
    for function, factor in ((target.target_energy, scale), (target.target_matrix, 1.0)):
        small = function(second, TARGET, STIFFNESS, **CASES[case])
        large = function(scale * second, scale * TARGET, STIFFNESS, **CASES[case])
        np.testing.assert_allclose(large, factor * small, rtol=1e-11, atol=1e-12 * factor)


def torque(position, force):
    return np.cross(position, force).sum(0)


def test_the_torque_is_that_of_the_orientation_alone():
    mass, position = cloud()
    second = second_moment(mass, position)
    for options in CASES.values():
        force = -target.target_energy_gradient(mass, position, TARGET, STIFFNESS, **options)
        size = np.linalg.norm(np.cross(position, force), axis=1).sum()
        stiffness = options.get("orientation_stiffness", STIFFNESS)
        plane = np.eye(3)
        if "normal" in options:
            normal = options["normal"] / np.linalg.norm(options["normal"])
            plane = plane - np.outer(normal, normal)
        flat, wanted = second, plane @ TARGET @ plane
        trace = np.trace(plane @ second) if options.get("free_size") else np.trace(wanted)
        scaled = wanted if not options.get("free_size") else wanted * trace / np.trace(wanted)
        if "normal" in options:
            # Within the plane; the pull of the plane's forces on what sticks out of it turns the body too.
            expected = 2.0 * stiffness / trace * axial_vector(plane @ flat @ plane @ scaled)
            assert torque(position, force) @ normal == pytest.approx(expected @ normal, abs=1e-11 * size)
            continue
        expected = 2.0 * stiffness / trace * axial_vector(flat @ scaled)
        np.testing.assert_allclose(torque(position, force), expected, atol=1e-12 * size)
        if stiffness == 0.0:
            assert np.linalg.norm(torque(position, force)) < 1e-12 * size
        else:
            assert np.linalg.norm(expected) > 1e-3 * size


def test_in_a_plane_orientation_counts_as_the_square_of_the_sine():
    """2 |q| |q*| (1 - cos 2 theta)/2 of the traceless parts, as nematics have it."""
    angle = 0.4
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    wanted = np.diag([3.0, 1.0, 0.0])
    for stiffness in (0.0, 2.3):  # of size and elongation, which are as wanted
        found = target.target_energy(turn @ wanted @ turn.T, wanted, stiffness, 1.0, normal=np.array([0.0, 0.0, 1.0]))
        assert found == pytest.approx((3.0 - 1.0) ** 2 * np.sin(angle) ** 2 / 4.0, abs=1e-14)


def test_flat_bodies_are_the_bodies_of_a_plane():
    mass, position = cloud()
    flat = target.target_energy_gradient(mass, position[:, :2], TARGET, STIFFNESS)
    embedded = np.column_stack([position[:, :2], np.zeros(len(mass))])
    whole = target.target_energy_gradient(mass, embedded, TARGET, STIFFNESS, normal=np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose(flat, whole[:, :2], rtol=1e-13)
    assert (whole[:, 2] == 0.0).all()


def test_the_smooth_energy_is_convex_and_has_no_force_at_the_target_alone():
    one, other = second_moment(*cloud(1)), second_moment(*cloud(2))
    middle = target.target_energy(0.5 * (one + other), TARGET, 1.0)
    assert middle < 0.5 * (target.target_energy(one, TARGET, 1.0) + target.target_energy(other, TARGET, 1.0))
    np.testing.assert_allclose(target.target_matrix(TARGET, TARGET, 1.0), 0.0, atol=1e-15)
    np.testing.assert_allclose(target.target_matrix(7.0 * TARGET, TARGET, 1.0, free_size=True), 0.0, atol=1e-15)


def test_with_a_free_size_the_pull_inward_is_twice_the_energy():
    """E is homogeneous of degree 2 in the positions, so that tr V = -2 E (Euler)."""
    second = second_moment(*cloud())
    for options in ({}, {"orientation_stiffness": 0.7}):
        virial = second @ target.target_matrix(second, TARGET, STIFFNESS, free_size=True, **options)
        value = target.target_energy(second, TARGET, STIFFNESS, free_size=True, **options)
        assert np.trace(virial) == pytest.approx(-2.0 * value, rel=1e-12)


def test_batches_spheres_and_points():
    seconds = np.stack([second_moment(*cloud(seed)) for seed in range(4)])
    for options in CASES.values():
        whole = target.target_matrix(seconds, TARGET, STIFFNESS, **options)
        for second, matrix in zip(seconds, whole, strict=True):
            np.testing.assert_allclose(matrix, target.target_matrix(second, TARGET, STIFFNESS, **options), rtol=1e-12)
        wanted = np.stack([TARGET, 2.0 * TARGET, np.diag([1.0, 2.0, 3.0]), np.eye(3)])
        for energy in (target.target_matrix, target.target_energy):
            one_by_one = [energy(*pair, STIFFNESS, **options) for pair in zip(seconds, wanted, strict=True)]
            np.testing.assert_allclose(energy(seconds, wanted, STIFFNESS, **options), one_by_one, rtol=1e-12)
        for degenerate in (np.eye(3), np.zeros((3, 3))):
            assert np.isfinite(target.target_matrix(degenerate, TARGET, STIFFNESS, **options)).all()
            assert np.isfinite(target.target_energy(degenerate, TARGET, STIFFNESS, **options))


@pytest.mark.full
@pytest.mark.parametrize("options", CASES.values(), ids=CASES)
def test_derivatives_are_finite_for_round_bodies_and_single_precision_is_kept(options):
    for second in (np.eye(3), np.diag([1.0, 1.0, 3.0])):
        with jax.enable_x64(True):
            slope = jax.jacrev(lambda q: target.target_matrix(q, jnp.asarray(TARGET), STIFFNESS, **options))
            assert np.isfinite(slope(jnp.asarray(second))).all()
    normal = {name: value.astype(np.float32) for name, value in options.items() if name == "normal"}
    single = target.target_tensor(np.array([1.0, 2.0, 4.0], dtype=np.float32))
    for function in (target.target_energy, target.target_matrix):
        assert function(single, single, STIFFNESS, **{**options, **normal}).dtype == np.float32
