"""Principal moments and axes: sorted, right-handed, followed through crossings; numpy or jax, any consistent units.

Tensors have shape (..., 3, 3). Principal axes are rows: axes[..., k, :] is the unit vector of moment k. Where two
moments are equal the axes in their plane are undefined; `tolerance` says how near counts as equal, as a share of the
largest moment.
"""

import itertools
from functools import cache
from typing import Any

import numpy as np

from astroinertia.inertia.tensor import namespace, twice_symmetric

Array = Any

ROUND_OFF_GAP = 1e-9  # moments nearer than this share of the largest are equal to what double precision can tell
_PERMUTATIONS = tuple(itertools.permutations(range(3)))


def principal_moments(inertia: Array) -> Array:
    """Moments about the principal axes, ascending, (..., 3)."""
    return _eigh(namespace(inertia), inertia)[0]


def principal_gap(moments: Array) -> Array:
    """How far each moment is from the nearest other, as a share of the largest, (..., 3): 0 where an axis is undefined.

    A uniform ellipsoid whose semi-axes differ by a small fraction e has gaps of about e.
    """
    xp = namespace(moments)
    a, b, c = moments[..., 0], moments[..., 1], moments[..., 2]
    near = xp.stack([xp.minimum(abs(a - b), abs(a - c)), xp.minimum(abs(b - a), abs(b - c)),
                     xp.minimum(abs(c - a), abs(c - b))], axis=-1)  # fmt: skip
    largest = xp.max(abs(moments), axis=-1, keepdims=True)
    return near / xp.where(largest > 0, largest, 1.0)


def principal_frame(inertia: Array, tolerance: float = ROUND_OFF_GAP) -> tuple[Array, Array]:
    """Moments, ascending (..., 3), and a right-handed set of principal axes (..., 3, 3), row k for moment k.

    In jax the derivative leaves out the turning of axes within a plane of equal moments, where it has none: finite for
    a sphere, where that of `eigh` is NaN.
    """
    if namespace(inertia) is np:
        moments, vectors = _eigh(np, inertia)
        return moments, np.swapaxes(_right_handed(np, vectors), -1, -2)
    return _jax_frame(tolerance)(inertia)


def figure_rotation(moments: Array, axes: Array, inertia_rate: Array, tolerance: float = ROUND_OFF_GAP) -> Array:
    """Rate at which the principal axes turn about each of themselves, (..., 3); NaN where it is undefined.

    From dI/dt alone, at one instant: the axes turn about e_m by (e_k . dI/dt e_l) / (I_k - I_l) with (k, l, m) cyclic,
    which is undefined where I_k and I_l are equal. Axes must be right-handed.
    """
    xp = namespace(moments)
    in_axes = xp.einsum("...ki,...ij,...lj->...kl", axes, inertia_rate, axes)
    largest = xp.max(abs(moments), axis=-1)
    rates = []
    for k, m in ((1, 2), (2, 0), (0, 1)):
        difference = moments[..., k] - moments[..., m]
        defined = abs(difference) > tolerance * largest
        rates.append(xp.where(defined, in_axes[..., k, m] / xp.where(defined, difference, 1.0), xp.nan))
    return xp.stack(rates, axis=-1)


def tracked_frame(inertia: np.ndarray, tolerance: float = ROUND_OFF_GAP) -> tuple[np.ndarray, np.ndarray]:
    """Moments (T, 3) and right-handed axes (T, 3, 3) of a series of tensors, continuous in order and in sign.

    The axes are numbered by ascending moment where all three are first defined, and followed from there in both
    directions by their overlap, through crossings: a moment that overtakes another keeps its number. Where moments are
    equal within the tolerance, the axes are those in their plane that turned least.
    """
    moments, vectors = _eigh(np, inertia)
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


def _eigh(xp: Any, inertia: Array) -> tuple[Array, Array]:
    # Where a tensor is not finite so are its moments; numpy's own solver raises there, for the whole series.
    finite = xp.isfinite(inertia).all((-2, -1))
    moments, vectors = xp.linalg.eigh(xp.where(finite[..., None, None], 0.5 * twice_symmetric(inertia), 0.0))
    return xp.where(finite[..., None], moments, xp.nan), vectors


def _right_handed(xp: Any, vectors: Array) -> Array:
    sign = xp.where(xp.linalg.det(vectors) < 0, -1.0, 1.0)[..., None, None]
    return xp.concatenate([vectors[..., :1] * sign, vectors[..., 1:]], axis=-1)


@cache
def _jax_frame(tolerance: float) -> Any:
    import jax  # only here: numpy users need not wait for it
    import jax.numpy as jnp

    @jax.custom_jvp
    def frame(inertia: Array) -> tuple[Array, Array]:
        moments, vectors = jnp.linalg.eigh(inertia)
        return moments, jnp.swapaxes(_right_handed(jnp, vectors), -1, -2)

    @frame.defjvp
    def _(primals: tuple, tangents: tuple) -> tuple:
        moments, axes = frame(primals[0])
        change = 0.5 * (tangents[0] + jnp.swapaxes(tangents[0], -1, -2))
        change = jnp.einsum("...ki,...ij,...lj->...kl", axes, change, axes)
        difference = moments[..., :, None] - moments[..., None, :]
        largest = jnp.max(jnp.abs(moments), axis=-1)[..., None, None]
        apart = jnp.abs(difference) > tolerance * largest
        turning = jnp.where(apart, change / jnp.where(apart, difference, 1.0), 0.0)
        # d e_k = sum_l (e_l . dI e_k) / (I_k - I_l) e_l
        return (moments, axes), (
            jnp.diagonal(change, axis1=-2, axis2=-1),
            jnp.einsum("...kl,...li->...ki", turning, axes),
        )

    return frame
