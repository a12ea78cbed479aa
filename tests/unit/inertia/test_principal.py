"""Principal axes and moments, their tracking and figure rotation, against closed forms."""

import jax
import jax.numpy as jnp
import mpmath
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


def test_a_series_of_tensors_in_jax_is_followed_as_in_numpy():
    with jax.enable_x64(True):
        _, _, inertia = crossing(20)
        for found, known in zip(*map(principal.tracked_frame, (jnp.array(inertia), inertia)), strict=True):
            np.testing.assert_allclose(found, known, rtol=1e-13, atol=1e-13)


def test_a_tensor_that_is_not_finite_is_passed_over():
    _, _, inertia = crossing(20)
    inertia[7] = np.nan
    moments, axes = principal.tracked_frame(inertia, tolerance=1e-3)
    assert np.isnan(moments[7]).all()
    assert np.isfinite(axes).all()
    assert np.einsum("tki,tki->tk", axes[1:], axes[:-1]).min() > 0.95


def test_a_sphere_on_the_way_through_a_crossing_of_all_three_moments_does_not_flip():
    share = np.linspace(-1, 1, 101)  # a sphere at the middle output
    slopes = np.array([0.3, -0.1, -0.5])
    matrices = np.stack([rotation((1, 2, 3), 0.2 * s) for s in share])
    inertia = np.stack([turned(2 + slopes * s, matrix) for s, matrix in zip(share, matrices, strict=True)])
    moments, axes = principal.tracked_frame(inertia, tolerance=1e-3)
    np.testing.assert_allclose(moments, 2 + share[:, None] * np.sort(-slopes) * -1, rtol=1e-12)
    assert np.einsum("tki,tki->tk", axes[1:], axes[:-1]).min() > np.cos(0.02)
    assert abs(np.einsum("tki,ti->tk", axes, matrices[..., 2])[[0, -1]]).max(axis=1).tolist() == pytest.approx([1, 1])


def exact_frame(matrix, digits=60):
    """Moments, ascending, and axes as rows of a symmetric mpmath matrix."""
    with mpmath.workdps(digits):
        values, vectors = mpmath.eigsy(matrix)
        order = sorted(range(3), key=lambda k: values[k])
        return [values[k] for k in order], [[vectors[i, k] for i in range(3)] for k in order]


def signed_like(rows, axes):
    """Exact axes with the signs of others."""
    return [
        [-x if mpmath.fdot(row, map(mpmath.mpf, axis)) < 0 else x for x in row]
        for row, axis in zip(rows, axes, strict=True)
    ]


def rotated_tensor(moments, seed):
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    inertia = turned(np.asarray(moments, float), matrix)
    return 0.5 * (inertia + inertia.T)


BODIES = {
    "plain": (1.0, 1.7, 2.4),
    "rod": (1e-12, 1.0, 1.0 + 1e-12),
    "graded": (1e-12, 1e-6, 1.0),
    "disc": (1.0, 1.0 + 1e-9, 2.0),
    "nearly a sphere": (1.0, 1.0 + 1e-13, 1.0 - 1e-12),
    "exactly a spheroid but for rounding": (1.0, 1.0, 2.0),
    "not a body": (-1e-12, 1e-13, 1.0),
}


@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("scale", [1.0, 1e-70, 1e60])
def test_moments_and_axes_are_those_of_the_numbers_given(moments, scale):
    for seed in range(3):
        inertia = scale * rotated_tensor(moments, seed)
        found, axes = principal.principal_frame(inertia)
        exact, rows = exact_frame(mpmath.matrix(inertia.tolist()))
        with mpmath.workdps(60):
            for value, true in zip(found, exact, strict=True):
                assert abs(mpmath.mpf(value) / true - 1) < 3e-16
            for axis, row in zip(axes, signed_like(rows, axes), strict=True):
                assert max(abs(mpmath.mpf(x) - y) for x, y in zip(axis, row, strict=True)) < 1e-14


def test_axes_are_orthonormal_to_a_rounding():
    matrices = np.linalg.qr(np.random.default_rng(0).normal(size=(2000, 3, 3)))[0]
    _, axes = principal.principal_frame((matrices * [1.0, 1.7, 2.4]) @ np.swapaxes(matrices, 1, 2))
    exact = axes.astype(np.longdouble)
    products = np.einsum("nki,nli->nkl", exact, exact)
    assert abs(products - np.eye(3)).max() < 8e-16  # those of eigh itself are off by 2e-15


def test_plain_eigh_would_lose_the_thickness_of_a_rod():
    inertia = rotated_tensor(BODIES["rod"], 0)
    exact = float(exact_frame(mpmath.matrix(inertia.tolist()))[0][0])
    assert abs(np.linalg.eigvalsh(inertia)[0] / exact - 1) > 1e-6


def test_a_thin_rod_along_an_axis_keeps_its_thickness_beyond_double_precision():
    np.testing.assert_array_equal(principal.principal_moments(np.diag([1.0, 1e-200, 1.0])), [1e-200, 1.0, 1.0])


@pytest.fixture(scope="module")
def derivatives():
    """Derivatives of the moments and of the axes of a tensor (3, 3), compiled once."""
    import jax

    compiled = jax.jit(jax.jacrev(principal.principal_frame))

    def of(inertia):
        with jax.enable_x64(True):
            return tuple(map(np.asarray, compiled(jax.numpy.asarray(inertia))))

    return of


@pytest.mark.full
@pytest.mark.parametrize("gap", [1.0, 1e-6, 1e-12])
def test_derivatives_of_moments_and_axes_match_exact_arithmetic(gap, derivatives):
    inertia = rotated_tensor((1.0, 1.0 + gap, 1.0 + 2.1 * gap if gap == 1 else 2.4), 5)
    axes = principal.principal_frame(inertia)[1]
    rates, turning = derivatives(inertia)
    with mpmath.workdps(80):
        centre, step = mpmath.matrix(inertia.tolist()), mpmath.mpf(10) ** -30 * gap
        size = [0.0, 0.0, 0.0]
        error = [0.0, 0.0, 0.0]
        error_of_rates = 0.0
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            direction = mpmath.matrix(3)
            direction[i, j] = direction[j, i] = 1
            frames = [exact_frame(centre + sign * step * direction, 80) for sign in (1, -1)]
            rows = [signed_like(frame[1], axes) for frame in frames]
            twice = [array[..., i, j] + (array[..., j, i] if i != j else 0) for array in (rates, turning)]
            for k in range(3):
                true = (frames[0][0][k] - frames[1][0][k]) / (2 * step)
                error_of_rates = max(error_of_rates, abs(float(true - mpmath.mpf(float(twice[0][k])))))
                for m in range(3):
                    true = (rows[0][k][m] - rows[1][k][m]) / (2 * step)
                    size[k] = max(size[k], abs(float(true)))
                    error[k] = max(error[k], abs(float(true - mpmath.mpf(float(twice[1][k, m])))))
    assert error_of_rates < 1e-14
    assert size[0] > 0.1 / gap  # the axes do turn
    # The goal is max(1e-10, 1e-15 / gap); differences of refined moments keep all digits at every gap.
    assert max(e / s for e, s in zip(error, size, strict=True)) < 1e-13


@pytest.mark.slow
def test_equal_moments_have_the_mean_derivative_and_their_axes_none(derivatives):
    rates, turning = derivatives(3.0 * np.eye(3))
    assert principal.undefined_axes(principal.principal_moments(3.0 * np.eye(3))).all()
    np.testing.assert_allclose(rates, np.broadcast_to(np.eye(3) / 3, (3, 3, 3)), rtol=1e-15)
    assert (turning == 0).all()

    spheroid = rotated_tensor((1.0, 1.0, 2.0), 3)
    moments, axes = principal.principal_frame(spheroid)
    assert principal.undefined_axes(moments).tolist() == [True, True, False]
    assert principal.undefined_axes(np.array([1, 1, 2])).tolist() == [True, True, False]  # in whole numbers, too
    assert principal.undefined_axes(np.array([1.0, 2.0, np.nan])).all()  # what is not known has no axes
    rates, turning = derivatives(spheroid)
    lone = np.outer(axes[2], axes[2])
    np.testing.assert_allclose(rates, [(np.eye(3) - lone) / 2] * 2 + [lone], atol=1e-15)
    assert (turning[:2] == 0).all()
    # The axis of symmetry turns by P dI e / (I_3 - I_1).
    change = np.array([[0.3, -0.2, 0.5], [-0.2, 0.7, 0.1], [0.5, 0.1, -0.4]])
    expected = (np.eye(3) - lone) @ change @ axes[2] / (2.0 - 1.0)
    np.testing.assert_allclose(np.einsum("kij,ij->k", turning[2], change), expected, atol=1e-14)


@pytest.mark.parametrize(
    "diagonal", [(0, 0, 0), (1, 1, 1), (0, 1, 1), (1, 1, 2), (1e-300, 1, 1), (1, 1 + 2e-15, 1 + 4e-15), (np.nan, 1, 1)]
)
def test_derivatives_are_finite_everywhere(diagonal, derivatives):
    for found in derivatives(np.diag(np.array(diagonal, float))):
        assert np.isfinite(found).all()


@pytest.mark.full
def test_second_derivatives_of_moments_and_axes():
    import jax

    change = np.array([[0.3, -0.2, 0.5], [-0.2, 0.7, 0.1], [0.5, 0.1, -0.4]])
    bodies = np.array([[1.0, 1.7, 2.4], [1.0, 1.0, 2.4]])
    with jax.enable_x64(True):

        def along(step, inertia):
            return principal.principal_moments(inertia + step * jax.numpy.asarray(change))

        second = jax.jit(jax.vmap(jax.jacfwd(jax.jacfwd(along)), in_axes=(None, 0)))
        for moments, found in zip(bodies, second(0.0, bodies[:, :, None] * np.eye(3)), strict=True):
            lone = 2 * (change[2, 0] ** 2 / (2.4 - moments[0]) + change[2, 1] ** 2 / (2.4 - moments[1]))
            assert found[2] == pytest.approx(lone, rel=1e-13)
            assert found.sum() == pytest.approx(0.0, abs=1e-13)  # the trace is linear

        def turned(step):
            return principal.principal_frame(np.diag(bodies[0]) + step * jax.numpy.asarray(change))[1]

        turning = jax.jit(jax.jacfwd(turned))
        differences = (turning(1e-5) - turning(-1e-5)) / 2e-5
        np.testing.assert_allclose(jax.jit(jax.jacfwd(jax.jacfwd(turned)))(0.0), differences, atol=1e-8)


@pytest.mark.slow
def test_numpy_and_jax_agree_in_sign_and_number_and_keep_single_precision():
    import jax

    inertia = np.stack([rotated_tensor(moments, 1) for moments in BODIES.values()])
    with jax.enable_x64(True):
        for mine, theirs in zip(
            principal.principal_frame(inertia), principal.principal_frame(jax.numpy.asarray(inertia)), strict=True
        ):
            np.testing.assert_allclose(mine, theirs, rtol=1e-15, atol=2e-14)
        both = (
            principal.principal_frame(inertia[:1].astype(np.float32)),
            principal.principal_frame(jax.numpy.asarray(inertia[:1], "float32")),
        )
    assert {array.dtype for pair in both for array in pair} == {np.dtype(np.float32)}
    np.testing.assert_allclose(both[0][0][0], BODIES["plain"], rtol=2e-7)
    np.testing.assert_array_equal(both[0][0], both[1][0])
