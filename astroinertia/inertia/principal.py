"""Principal moments and axes: sorted, right-handed, followed through crossings; numpy or jax, any consistent units.

Tensors have shape (..., 3, 3). Principal axes are rows: axes[..., k, :] is the unit vector of moment k, in the axes and
about the point of the tensor. Where two moments are equal the axes in their plane are undefined; `tolerance` says how
near counts as equal, as a share of the largest moment.

What can be known of nearly equal and of very small moments is known: moments, their differences and axes are those of
the numbers given to their last digits, whatever the gap and the condition number (see eigen.py). A tensor of a thin rod
that does not lie along x, y or z has lost its smallest moment to the rounding of its own entries, 1e-16 of the largest.
Checked by tests/unit/inertia/test_principal.py against mpmath.
"""

import itertools
from functools import cache
from typing import Any

import numpy as np

from astroinertia.inertia.eigen import refined_eigh
from astroinertia.inertia.tensor import namespace, twice_symmetric
from astroinertia.process.quantities import with_quantities

Array = Any

EQUAL_MOMENTS = 1e-9  # over the larger: what motions and their descriptions take for no difference of two moments
ROUND_OFF_GAP = 1e-9  # what sums over many particles or steps can tell of the gap of two moments
_ROUNDINGS = 16  # roundings within which the moments of a rotated tensor may differ though they were equal
_PERMUTATIONS = tuple(itertools.permutations(range(3)))


@with_quantities()
def principal_moments(inertia: Array, tolerance: float | None = None) -> Array:
    """Moments about the principal axes, ascending, (..., 3); NaN where the tensor (..., 3, 3) is not finite.

    In jax the derivative is that of `principal_frame`, with its tolerance.

    >>> print(principal_moments(np.array([[2.0, 1, 0], [1, 2, 0], [0, 0, 4]])))  # ascending
    [1. 3. 4.]
    """
    return principal_frame(inertia, tolerance)[0]


@with_quantities()
def principal_gap(moments: Array) -> Array:
    """How far each moment is from the nearest other, as a share of the largest, (..., 3): 0 where an axis is undefined.

    A uniform ellipsoid whose semi-axes differ by a small fraction e has gaps of about e.

    >>> print(principal_gap(np.array([1.0, 1.0, 2.0])))  # 0 where an axis is undefined
    [0.  0.  0.5]
    """
    xp = namespace(moments)
    a, b, c = moments[..., 0], moments[..., 1], moments[..., 2]
    near = xp.stack([xp.minimum(abs(a - b), abs(a - c)), xp.minimum(abs(b - a), abs(b - c)),
                     xp.minimum(abs(c - a), abs(c - b))], axis=-1)  # fmt: skip
    largest = xp.max(abs(moments), axis=-1, keepdims=True)
    return near / xp.where(largest > 0, largest, 1.0)


@with_quantities()
def undefined_axes(moments: Array, tolerance: float | None = None) -> Array:
    """Whether each principal axis is undefined, (..., 3), as a moment (..., 3) equals another within the tolerance.

    All three are where moments are not known (NaN).

    The tolerance is 16 roundings of the moments' precision where none is given: 3.6e-15 in double precision.

    >>> print(undefined_axes(np.array([1.0, 1.0, 2.0])))  # of an oblate body, two
    [ True  True False]
    """
    gap = principal_gap(moments)
    return ~(gap > (_ROUNDINGS * float(np.finfo(gap.dtype).eps) if tolerance is None else tolerance))


@with_quantities()
def principal_frame(inertia: Array, tolerance: float | None = None) -> tuple[Array, Array]:
    """Moments, ascending (..., 3), and a right-handed set of principal axes (..., 3, 3), row k for moment k.

    inertia (..., 3, 3), whose antisymmetric part is left out. Of each of the axes of the two largest moments, the
    component that is largest is positive. Moments are NaN where the tensor is not finite.

    In jax derivatives are finite everywhere and right for defined axes and their moments. Where `undefined_axes` says
    so, those of the axes are zero and each of the equal moments has the mean of their derivatives: that of half the
    trace of I in the plane of two, of a third of the trace for a sphere. The sum of the outer products of undefined
    axes does have a derivative: write it as 1 less the outer product of the third. Second derivatives are right for the
    moments, and for axes where all are defined.
    Source: Magnus (1985), Econometric Theory 1, 179, for the derivatives.

    >>> moments, axes = principal_frame(np.diag([3.0, 1.0, 2.0]))
    >>> print(moments, abs(axes[0]))  # the least moment is about y
    [1. 2. 3.] [0. 1. 0.]
    """
    if namespace(inertia) is np:
        return _frame(np, np.asarray(inertia))[:2]
    return _jax_frame(tolerance)(inertia)[:2]


@with_quantities()
def figure_rotation(moments: Array, axes: Array, inertia_rate: Array, tolerance: float = ROUND_OFF_GAP) -> Array:
    """Rate at which the principal axes turn about each of themselves, (..., 3); NaN where it is undefined.

    From dI/dt alone, at one instant: the axes turn about e_m by (e_k . dI/dt e_l) / (I_k - I_l) with (k, l, m) cyclic,
    which is undefined where I_k and I_l are equal. Axes must be right-handed.

    >>> rate = np.array([[0.0, 0.5, 0], [0.5, 0, 0], [0, 0, 0]])  # dI_xy/dt of axes that turn about z
    >>> print(figure_rotation(np.array([1.0, 2.0, 3.0]), np.eye(3), rate)[2])  # I_xy' over I_2 - I_1, with its sign
    -0.5
    """
    xp = namespace(moments, axes, inertia_rate)
    moments, axes, inertia_rate = (xp.asarray(array) for array in (moments, axes, inertia_rate))
    in_axes = xp.einsum("...ki,...ij,...lj->...kl", axes, inertia_rate, axes)
    largest = xp.max(abs(moments), axis=-1)
    rates = []
    for k, m in ((1, 2), (2, 0), (0, 1)):
        difference = moments[..., k] - moments[..., m]
        defined = abs(difference) > tolerance * largest
        rates.append(xp.where(defined, in_axes[..., k, m] / xp.where(defined, difference, 1.0), xp.nan))
    return xp.stack(rates, axis=-1)


@with_quantities()
def tracked_frame(inertia: np.ndarray, tolerance: float = ROUND_OFF_GAP) -> tuple[np.ndarray, np.ndarray]:
    """Moments (T, 3) and right-handed axes (T, 3, 3) of a series of tensors, continuous in order and in sign.

    The axes are numbered by ascending moment where all three are first defined, and followed from there in both
    directions by their overlap, through crossings: a moment that overtakes another keeps its number. Where moments are
    equal within the tolerance, the axes are those in their plane that turned least.

    >>> inertia = np.array([np.diag([1.0, 2.0, 4.0]), np.diag([3.0, 2.0, 4.0])])  # moments that cross
    >>> print(tracked_frame(inertia)[0])  # each keeps its place
    [[1. 2. 4.]
     [3. 2. 4.]]
    """
    if np.ndim(inertia) != 3:
        raise ValueError(f"a series of tensors has the shape (T, 3, 3), not {np.shape(inertia)}")
    inertia = np.asarray(inertia)
    moments, axes = principal_frame(inertia)
    vectors = np.swapaxes(axes, -1, -2)
    gaps = principal_gap(moments)
    start = next((int(np.argmax(ok)) for ok in (gaps.min(-1) > tolerance, gaps.max(-1) > tolerance) if ok.any()), 0)
    axes = np.empty_like(vectors)
    first = _settled(moments[start], vectors[start], np.eye(3), tolerance)
    # Numbered by ascending moment; the last axis points along +z or as near as it can.
    first = first[np.argsort(np.einsum("ki,ij,kj->k", first, inertia[start], first), kind="stable")]
    first *= np.where(first[range(3), np.argmax(abs(first), axis=1)] < 0, -1.0, 1.0)[:, None]
    first[0] *= np.linalg.det(first)
    axes[start] = first
    for index in range(start + 1, len(inertia)):
        axes[index] = _settled(moments[index], vectors[index], axes[index - 1], tolerance)
    for index in range(start - 1, -1, -1):
        axes[index] = _settled(moments[index], vectors[index], axes[index + 1], tolerance)
    # The eigenvalues, in the order of the moments about the chosen axes.
    about = np.einsum("tki,tij,tkj->tk", axes, inertia, axes)
    ranks = np.argsort(np.argsort(about, axis=1, kind="stable"), axis=1, kind="stable")
    return np.take_along_axis(moments, ranks, axis=1), axes


def _settled(moments: np.ndarray, vectors: np.ndarray, before: np.ndarray, tolerance: float) -> np.ndarray:
    """Eigenvectors (columns) as rows, each numbered, signed and turned to be nearest to the axes `before` (rows)."""
    if not np.isfinite(moments).all():
        return before
    equal = np.diff(moments) <= tolerance * abs(moments).max()
    if equal.all():
        return before
    overlap = before @ vectors
    best = max(_PERMUTATIONS, key=lambda order: sum(overlap[k, order[k]] ** 2 for k in range(3)))
    axes = vectors[:, best].T.copy()
    if equal.any():
        # Two axes span a plane of equal moments: take the pair in it nearest to the former pair.
        lone = best.index(2 if equal[0] else 0)
        plane = np.delete(vectors, 2 if equal[0] else 0, axis=1)
        pair = [k for k in range(3) if k != lone]
        left, _, right = np.linalg.svd(before[pair] @ plane)
        axes[pair] = left @ right @ plane.T
    agreement = np.einsum("ki,ki->k", axes, before)
    axes *= np.where(agreement < 0, -1.0, 1.0)[:, None]
    if np.linalg.det(axes) * np.linalg.det(before) < 0:
        axes[np.argmin(abs(agreement))] *= -1.0
    return axes


def _frame(xp: Any, inertia: Array) -> tuple[Array, Array, Array]:
    """Moments, axes, and the differences of moments k and l, (..., 3, 3)."""
    # Where a tensor is not finite so are its moments; numpy's own solver raises there, for the whole series.
    finite = xp.isfinite(inertia).all((-2, -1))[..., None]
    matrix = xp.where(finite[..., None], 0.5 * twice_symmetric(inertia), 0.0)
    moments, differences, vectors = refined_eigh(xp, matrix)
    second, third = (_signed(xp, vectors[..., k]) for k in (1, 2))
    axes = xp.stack([xp.cross(second, third), second, third], axis=-2)
    return xp.where(finite, moments, xp.nan), axes, differences


def _signed(xp: Any, vector: Array) -> Array:
    largest = xp.take_along_axis(vector, xp.argmax(abs(vector), axis=-1, keepdims=True), axis=-1)
    return xp.where(largest < 0, -vector, vector)


@cache
def _jax_frame(tolerance: float | None) -> Any:
    import jax  # only here: numpy users need not wait for it
    import jax.numpy as jnp

    @jax.custom_jvp
    @jax.jit
    def frame(inertia: Array) -> tuple[Array, Array, Array]:
        return _frame(jnp, inertia)

    @frame.defjvp
    def _(primals: tuple, tangents: tuple) -> tuple:
        moments, axes, differences = frame(primals[0])
        undefined = undefined_axes(moments, tolerance)
        turn = 0.5 * (tangents[0] + jnp.swapaxes(tangents[0], -1, -2))
        # Sums of products and no matrix product, for which an accelerator may use fewer digits.
        turn = (axes[..., :, :, None] * turn[..., None, :, :]).sum(-2)
        change = (turn[..., :, None, :] * axes[..., None, :, :]).sum(-1)
        rates = jnp.diagonal(change, axis1=-2, axis2=-1)
        # As what the others leave of the trace, whose own derivative needs no axis that is undefined.
        rest = jnp.trace(tangents[0], axis1=-2, axis2=-1) - jnp.where(undefined, 0.0, rates).sum(-1)
        equal = jnp.maximum(undefined.sum(-1), 1).astype(moments.dtype)
        rates = jnp.where(undefined, (rest / equal)[..., None], rates)
        # d e_k = sum_l (e_l . dI e_k) / (I_k - I_l) e_l
        turns = ~undefined[..., :, None] & (differences != 0)
        turning = jnp.where(turns, change / jnp.where(turns, differences, 1.0), 0.0)
        return (moments, axes, differences), (
            rates,
            (turning[..., :, :, None] * axes[..., None, :, :]).sum(-2),
            rates[..., :, None] - rates[..., None, :],
        )

    return frame
