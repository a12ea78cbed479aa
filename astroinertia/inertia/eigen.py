"""Eigenvalues and eigenvectors of symmetric 3 x 3 matrices to the last digits of the numbers given; numpy or jax.

`eigh` is good to a rounding of the largest eigenvalue: a condition number of 1e12 costs the smallest one twelve digits,
and nearly equal ones have axes that are wrong by a rounding over their gap. Here its vectors V only make the matrix
nearly diagonal: V^T A V is formed with about twice the digits, and Jacobi rotations of the small rest finish the work.
Every eigenvalue, and every difference of two, is then that of the given numbers to about 1e-30 of the largest, and
rounded once at the end. (That a rotated tensor's own entries were rounded to 1e-16 of the largest moment is nothing
that an eigenvalue solver can undo.)

Sources: Ogita & Aishima (2018), Japan J. Indust. Appl. Math. 35, 1007, for refinement by products in higher precision;
Ogita, Rump & Oishi (2005), SIAM J. Sci. Comput. 26, 1955, for sums with their errors; Golub & Van Loan (2013), Matrix
Computations, section 8.5, for Jacobi rotations. Checked by tests/unit/inertia/test_principal.py against mpmath.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

Array = Any

_ROTATIONS = 12  # four sweeps: one does for eigenvalues that are apart, nearly equal ones take some
_OPPOSITE = ((1, 2), (2, 0), (0, 1))  # where the element between the other two vectors stands


def refined_eigh(xp: Any, matrix: Array) -> tuple[Array, Array, Array]:
    """Eigenvalues, ascending (..., 3), their differences (..., 3, 3), and eigenvectors as columns (..., 3, 3).

    matrix (..., 3, 3), symmetric and finite. differences[..., k, l] is eigenvalue k minus eigenvalue l, with the digits
    that the subtraction of the rounded eigenvalues would lose.
    """
    _, exponent = xp.frexp(abs(matrix).max((-2, -1)))
    exponent = exponent + 2  # entries of at most 1/4: no sum of products below exceeds 1
    scaled = xp.ldexp(matrix, -exponent[..., None, None])
    vectors = xp.linalg.eigh(scaled)[1]
    transposed = xp.swapaxes(vectors, -1, -2)
    identity = xp.broadcast_to(xp.eye(3, dtype=matrix.dtype), matrix.shape)

    high, low = _product(xp, scaled, vectors, xp.zeros_like(matrix))
    nearly, rest = _product(xp, transposed, high, xp.zeros_like(matrix))
    rest = rest + _plain_product(transposed, low)
    excess = sum(_product(xp, transposed, vectors, -identity))  # V^T V - 1, of the size of a rounding
    # The basis V (1 - excess/2) is orthonormal; the same correction on both sides of V^T A V.
    rest = rest - 0.5 * (_plain_product(excess, nearly) + _plain_product(nearly, excess))
    vectors = vectors - 0.5 * _plain_product(vectors, excess)

    high = xp.stack([nearly[..., k, k] for k in range(3)], axis=-1)
    low = xp.stack([rest[..., k, k] for k in range(3)], axis=-1)
    off = xp.stack([0.5 * sum(x[..., k, m] + x[..., m, k] for x in (nearly, rest)) for k, m in _OPPOSITE], axis=-1)
    high, low, off, vectors = _repeated(xp, _ROTATIONS, partial(_rotate, xp), (high, low, off, vectors))
    for k in (0, 1, 0):
        high, low, vectors = _sort(xp, k, high, low, vectors)
    differences = (high[..., :, None] - high[..., None, :]) + (low[..., :, None] - low[..., None, :])
    return xp.ldexp(high + low, exponent[..., None]), xp.ldexp(differences, exponent[..., None, None]), vectors


def _product(xp: Any, left: Array, right: Array, start: Array) -> tuple[Array, Array]:
    """start + left @ right, as a sum and what rounding took from it; entries of at most 1."""
    total, error = start, xp.zeros_like(start)
    # All products that count are exact, so that it does not matter if a compiler fuses them with the sums.
    a, b = _pieces(xp, left), _pieces(xp, right)
    for i, j in ((0, 0), (0, 1), (1, 0)):
        for k in range(3):
            term = a[i][..., :, k, None] * b[j][..., None, k, :]
            total, lost = two_sum(total, term)
            error = error + lost
    for i, j in ((1, 1), (0, 2), (2, 0), (1, 2), (2, 1)):
        error = error + _plain_product(a[i], b[j])
    return two_sum(total, error)


def _plain_product(left: Array, right: Array) -> Array:
    return sum(left[..., :, k, None] * right[..., None, k, :] for k in range(3))


def two_sum(one: Array, other: Array) -> tuple[Array, Array]:
    """Sum and its rounding (Knuth)."""
    total = one + other
    part = total - one
    return total, (one - (total - part)) + (other - part)


def _pieces(xp: Any, array: Array) -> tuple[Array, Array, Array]:
    """Three parts that add up to the array: half of a mantissa, the other half, and what small numbers keep."""
    half = 2.0 ** ((xp.finfo(array.dtype).nmant + 1) // 2)
    first = xp.round(array * half) / half
    second = xp.round((array - first) * half**2) / half**2
    return first, second, (array - first) - second


def _repeated(xp: Any, times: int, step: Callable[[tuple], tuple], state: tuple) -> tuple:
    if xp is np:
        for _ in range(times):
            state = step(state)
        return state
    from jax import lax  # only here: numpy users need not wait for it

    return lax.fori_loop(0, times, lambda _, vectors: step(vectors), state)  # compiled once, and not for every rotation


def _rotate(xp: Any, state: tuple) -> tuple:
    """One Jacobi rotation of the first two vectors, which makes the element between them 0, and a roll to the next."""
    high, low, off, vectors = state
    element = off[..., 2]
    apart = _gap(high, low, 0)
    size = abs(apart) + xp.hypot(apart, 2 * element)
    tangent = xp.where(apart < 0, -2 * element, 2 * element) / xp.where(size > 0, size, 1.0)
    cosine = 1 / xp.sqrt(1 + tangent**2)
    sine = tangent * cosine
    moved = tangent * element
    low = xp.stack([low[..., 0] - moved, low[..., 1] + moved, low[..., 2]], axis=-1)
    first, second = off[..., 0], off[..., 1]
    off = xp.stack([sine * second + cosine * first, cosine * second - sine * first, xp.zeros_like(element)], axis=-1)
    sine, cosine = sine[..., None], cosine[..., None]
    first, second = vectors[..., 0], vectors[..., 1]
    columns = [cosine * first - sine * second, sine * first + cosine * second, vectors[..., 2]]
    return tuple(xp.roll(values, -1, axis=-1) for values in (high, low, off, xp.stack(columns, axis=-1)))


def _sort(xp: Any, k: int, high: Array, low: Array, vectors: Array) -> tuple[Array, Array, Array]:
    """Exchange eigenvalues k and k + 1, and their vectors, where they are not in ascending order."""
    order = [1, 0, 2] if k == 0 else [0, 2, 1]
    swap = (_gap(high, low, k) < 0)[..., None]
    high, low = (xp.where(swap, values[..., order], values) for values in (high, low))
    return high, low, xp.where(swap[..., None], vectors[..., order], vectors)


def _gap(high: Array, low: Array, k: int) -> Array:
    return (high[..., k + 1] - high[..., k]) + (low[..., k + 1] - low[..., k])
