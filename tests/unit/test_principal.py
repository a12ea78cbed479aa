"""Principal axes and moments, their tracking and figure rotation, against closed forms."""

import numpy as np
import pytest

from astroinertia.inertia import principal, tensor


def rotation(axis, angle):
    """Rotation matrix about an axis (Rodrigues)."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def turned(moments, matrix):
    return matrix @ np.diag(moments) @ matrix.T


def random_tensor(seed):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(20, 3)) * [1.0, 1.4, 2.1]
    return tensor.inertia_from_second_moment(points.T @ points)


def test_principal_frame_diagonalises_and_is_right_handed():
    inertia = np.stack([random_tensor(seed) for seed in range(5)])
    moments, axes = principal.principal_frame(inertia)
    np.testing.assert_allclose(
        np.einsum("tki,tij,tlj->tkl", axes, inertia, axes), moments[..., None] * np.eye(3), atol=1e-11
    )
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, rtol=1e-12)
    assert (np.diff(moments, axis=-1) > 0).all()


def test_equal_moments_are_flagged():
    assert principal.principal_gap(np.array([2.0, 2.0, 2.0])).tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(principal.principal_gap(np.array([1.0, 1.0, 4.0])), [0.0, 0.0, 0.75])
    np.testing.assert_allclose(principal.principal_gap(np.array([1.0, 2.0, 4.0])), [0.25, 0.25, 0.5])
    assert principal.principal_gap(np.zeros(3)).tolist() == [0.0, 0.0, 0.0]


def test_gap_of_a_uniform_ellipsoid_is_about_the_difference_of_its_semi_axes():
    squares = np.array([1.0, 1.01, 1.3]) ** 2
    gap = principal.principal_gap(squares.sum() - squares)
    assert gap[0] == pytest.approx(0.01, rel=0.35)


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (1, 2, -0.5)])
def test_figure_rotation_is_the_rate_at_which_the_body_turns(axis):
    rate = 1.7
    spin = rate * np.asarray(axis, float) / np.linalg.norm(axis)
    matrix = rotation(axis, 0.4) @ rotation((1, 1, 0), 0.9)
    inertia = turned([1.0, 2.0, 2.6], matrix)
    cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
    # dI/dt of a turning body, plus changing moments, which must not show
    change = cross @ inertia - inertia @ cross + turned([0.3, -0.2, 0.1], matrix)
    moments, axes = principal.principal_frame(inertia)
    rates = principal.figure_rotation(moments, axes, change)
    np.testing.assert_allclose(rates @ axes, spin, rtol=1e-11, atol=1e-12)


def test_figure_rotation_is_undefined_about_the_axis_of_a_spheroid_only():
    inertia = np.diag([1.0, 1.0, 1.5])
    moments, axes = principal.principal_frame(inertia)
    rates = principal.figure_rotation(moments, axes, np.zeros((3, 3)))
    assert np.isnan(rates).tolist() == [False, False, True]


def crossing(steps):
    """Moments of which two cross while the body turns about z by 0.6 rad."""
    share = np.linspace(-1, 1, steps)
    moments = np.stack([2 + 0.5 * share, 2 - 0.5 * share, np.full(steps, 4.0)], axis=1)
    matrices = [rotation((0, 0, 1), 0.3 * (s + 1)) @ rotation((1, 0, 0), 0.2) for s in share]
    return moments, matrices, np.stack([turned(m, r) for m, r in zip(moments, matrices, strict=True)])


@pytest.mark.parametrize("steps", [200, 201])  # with 201 the moments are exactly equal at the middle output
def test_axes_and_moments_are_continuous_through_a_crossing(steps):
    moments, matrices, inertia = crossing(steps)
    found, axes = principal.tracked_frame(inertia, tolerance=1e-3)
    np.testing.assert_allclose(found, moments, rtol=1e-12)
    turns = np.einsum("tki,tki->tk", axes[1:], axes[:-1])
    assert turns.min() > np.cos(0.02), "an axis jumps or changes sign"
    for k in range(3):
        along = abs(np.einsum("ti,ti->t", axes[:, k], np.stack(matrices)[:, :, k]))
        away = abs(moments[:, 0] - moments[:, 1]) > 5e-3
        np.testing.assert_allclose(along[away], 1.0, rtol=1e-10)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, rtol=1e-12)


def test_plain_sorting_would_jump_at_that_crossing():
    _, _, inertia = crossing(200)
    _, axes = principal.principal_frame(inertia)
    assert abs(np.einsum("tki,tki->tk", axes[1:], axes[:-1])).min() < 0.1


def test_a_body_that_starts_as_a_sphere_is_numbered_by_what_it_becomes():
    growth = np.linspace(0.0, 0.4, 50)
    matrix = rotation((0, 1, 0), 0.3)
    inertia = np.stack([turned([1.0 + 2 * g, 1.0, 1.0 + g], matrix) for g in growth])
    moments, axes = principal.tracked_frame(inertia, tolerance=1e-3)
    np.testing.assert_allclose(moments[-1], [1.0, 1.4, 1.8])
    assert np.einsum("tki,tki->tk", axes[1:], axes[:-1]).min() > 0.999999


def test_axes_of_spheres_and_spheroids_stay_put():
    sphere = np.repeat(np.eye(3)[None], 4, axis=0)
    moments, axes = principal.tracked_frame(sphere)
    assert (axes == np.eye(3)).all()
    assert (moments == 1).all()
    noisy = np.stack([np.diag([1.0, 1.0, 1.6]) + 1e-12 * random_tensor(seed) for seed in range(20)])
    _, axes = principal.tracked_frame(noisy)
    np.testing.assert_allclose(axes, np.repeat(np.eye(3)[None], 20, axis=0), atol=1e-6)


def test_a_tensor_that_is_not_finite_is_passed_over():
    _, _, inertia = crossing(20)
    inertia[7] = np.nan
    moments, axes = principal.tracked_frame(inertia, tolerance=1e-3)
    assert np.isnan(moments[7]).all()
    assert np.isfinite(axes).all()
    assert np.einsum("tki,tki->tk", axes[1:], axes[:-1]).min() > 0.95


def test_jax_gives_the_same_numbers_and_finite_gradients_at_a_sphere():
    jax = pytest.importorskip("jax")
    from jax.test_util import check_grads

    with jax.enable_x64(True):
        inertia = random_tensor(5)
        for function in (principal.principal_moments, tensor.inertia_from_second_moment, tensor.axial_vector):
            np.testing.assert_allclose(function(jax.numpy.asarray(inertia)), function(inertia), rtol=1e-12, atol=1e-12)

        def about_last_axis(inertia):
            moments, axes = principal.principal_frame(inertia)
            return (axes[2] @ jax.numpy.array([0.2, 0.5, 1.0])) ** 2 + moments[0] * moments[2]

        check_grads(about_last_axis, (jax.numpy.asarray(inertia),), order=1, modes=["fwd", "rev"], rtol=1e-5)
        gradient = jax.jit(jax.grad(about_last_axis))(jax.numpy.eye(3))
        assert np.isfinite(gradient).all()
