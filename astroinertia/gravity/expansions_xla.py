"""Multipole and local expansions, as gravity.expansions has them, traced with jax.numpy over batches of nodes.

The polynomials h_a(x) are x^a/a! with every z^2 replaced by -(x^2 + y^2), which D does not see: for harmonic a alone,

    1/|R + t - s| = sum_a sum_b h_a(-s) h_b(t) D_(a+b)(R),    h_c(s + t) D_c = sum_(a+b) h_a(s) h_b(t) D_(a+b),

so that moments, shifts, interactions and fields are sums over harmonic a and b, with D_(a+b) of at most two z. Here
|a| + |b| <= p: cut off alike for sources and targets, the forces of two nodes on each other are opposite to rounding
(Dehnen 2002, J. Comput. Phys. 179, 27), and the gradient of the potential energy. An expansion is an array (K, ...) in
the order of `harmonic`, or for interactions, whose sums are written out, a dictionary {a: array}. Moments M_a/c^|a| and
coefficients L_a c^|a| are in units of a node's scale c, which keeps float32 from overflow.
"""

import math
from functools import cache, reduce
from operator import add, mul
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.gravity.expansions import UNITS, Index, harmonic, less, plus

Array = Any
Expansion = dict[Index, Array]


def harmonics(order: int, x: list[Array]) -> Array:
    """h_a(x) (K, ...) up to an order, of three arrays of one shape: moments of a unit mass that is at -x."""
    mass = jnp.zeros((len(harmonic(order)), *x[0].shape), x[0].dtype).at[0].set(1.0)
    return moments_shifted(order, mass, x)


def derivatives(order: int, x: list[Array]) -> Expansion:
    """D_a, derivatives of 1/r from order 1 to `order`, of at most two z, at unit vectors.

    From McMurchie & Davidson (1978, J. Comput. Phys. 26, 218), eq. 4.6.
    """
    table: dict[tuple[Index, int], Any] = {}

    def value(a: Index, m: int) -> Any:
        if a == (0, 0, 0):
            return float((-1) ** m * math.prod(range(1, 2 * m, 2)))
        if (a, m) not in table:
            # An axis with a single derivative takes one term.
            axis = next((k for k in (2, 1, 0) if a[k] == 1), min((k for k in range(3) if a[k]), key=lambda k: a[k]))
            once = less(a, axis)
            found = x[axis] * value(once, m + 1)
            if once[axis]:
                found = found + once[axis] * value(less(once, axis), m + 1)
            table[a, m] = found
        return table[a, m]

    return _with_two_z({a: value(a, 0) for a in harmonic(order)[1:]})


def _with_two_z(values: Expansion) -> Expansion:
    """Derivatives of a potential, and those of two z besides, which Laplace's equation has from the others."""
    result = dict(values)
    for a in [(0, 0, 0), *values]:
        along_x, along_y, along_z = (plus(plus(a, unit), unit) for unit in UNITS)
        if a[2] == 0 and along_x in values:
            result[along_z] = -(values[along_x] + values[along_y])
    return result


def powers(order: int, x: Array) -> list[Array]:
    """x^n from 0 to an order."""
    found = [jnp.ones_like(x)]
    for _ in range(order):
        found.append(found[-1] * x)
    return found


def scaled(order: int, values: Array, factor: Array) -> Array:
    """Components (K, ...), in the order of `harmonic`, times factor^|a|."""
    return values * jnp.stack(powers(order, factor))[np.array([sum(a) for a in harmonic(order)])]


def local(order: int, direction: list[Array], moments: Expansion) -> Expansion:
    """L_b = sum_a M_a D_(a+b) of sources whose centres are at unit distance, against `direction`."""
    d, given = _apart(derivatives(order, direction)) | {(0, 0, 0): 1.0}, _apart(moments)
    return {
        b: reduce(add, (d[plus(a, b)] * m for a, m in given.items() if sum(a) + sum(b) <= order))
        for b in harmonic(order)
    }


def moments_shifted(order: int, moments: Array, by: list[Array]) -> Array:
    """Moments (K, ...) in the order of `harmonic`, about a centre that is at `by` from the one that they are about."""
    return _moved(order, moments, by, transposed=True)


def local_shifted(order: int, values: Array, by: list[Array]) -> Array:
    """Local coefficients (K, ...) about a centre that is at `by` from the one that they are about."""
    return _moved(order, values, by, transposed=False)


def gradient(order: int, values: Array, transposed: bool = False) -> list[Array]:
    """Derivatives along the three axes of local coefficients (K, ...), themselves coefficients (K, ...).

    transposed: what the transposed matrices make of moments.
    """
    shape = (len(values),) + (1,) * (values.ndim - 1)

    def part(index: np.ndarray, factor: np.ndarray) -> Array:
        taken = values.at[index].get(mode="promise_in_bounds")
        return jnp.asarray(factor.reshape(shape), values.dtype) * taken

    return [reduce(add, [part(*term) for term in terms]) for terms in _gradient(order, transposed)]


def _moved(order: int, values: Array, by: list[Array], transposed: bool) -> Array:
    # exp(by . grad) = 1 + by . grad (1 + by . grad (1 + ...)/2)/1: a loop compiles in a tenth of the time of its sums.
    def further(inner: Array, n: Array) -> tuple[Array, None]:
        along = reduce(add, map(mul, by, gradient(order, inner, transposed)))
        return values + along / n.astype(values.dtype), None

    return jax.lax.scan(further, values, jnp.arange(order, 0, -1))[0]


@cache
def _gradient(order: int, transposed: bool) -> list[list[tuple[np.ndarray, np.ndarray]]]:
    # For each axis (index (K,), factor (K,)): its derivative is the sum of factor * coefficients[index].
    place = {a: n for n, a in enumerate(harmonic(order))}
    axes = []
    for unit in UNITS:
        matrix = np.zeros((len(place), len(place)))
        for a, row in place.items():
            # Coefficients above the order are 0, and those of two z as Laplace's equation has them.
            for b, value in _folded({plus(a, unit): 1.0}).items():
                if b in place:
                    matrix[row, place[b]] = value
        axes.append(_picked(matrix.T if transposed else matrix))
    return axes


def _picked(matrix: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    # A matrix of few entries as (column, value) of one entry of every row, until none is left.
    left, every = matrix.copy(), np.arange(len(matrix))
    picked = []
    while left.any():
        column = np.abs(left).argmax(axis=1)
        picked.append((column, left[every, column]))
        left[every, column] = 0.0
    return picked


def _folded(values: Expansion) -> Expansion:
    # Of harmonic a alone, the same sum over a of M_a D_a.
    values = dict(values)
    for a in sorted(values, key=lambda a: -a[2]):
        if a[2] >= 2:
            part, below = values.pop(a), less(less(a, 2), 2)
            for unit in UNITS[:2]:
                into = plus(plus(below, unit), unit)
                values[into] = values.get(into, 0.0) - part
    return values


def _apart(values: Expansion) -> Expansion:
    # Kept by itself, so that XLA does not work it out again for each sum that it is in.
    return jax.lax.optimization_barrier(values)
