"""Multipole and local expansions, as gravity.expansions has them, traced with jax.numpy over batches of nodes.

The polynomials h_a(x) are x^a/a! with every z^2 replaced by -(x^2 + y^2), which D does not see: for harmonic a alone,

    1/|R + t - s| = sum_a sum_b h_a(-s) h_b(t) D_(a+b)(R),    h_c(s + t) D_c = sum_(a+b) h_a(s) h_b(t) D_(a+b),

so that moments, shifts, interactions and fields are sums over harmonic a and b, with D_(a+b) of at most two z. Here
|a| + |b| <= p: cut off alike for sources and targets, the forces of two nodes on each other are opposite to rounding
(Dehnen 2002, J. Comput. Phys. 179, 27), and the gradient of the potential energy. An expansion is a dictionary
{a: array}, so that everything here is arithmetic between arrays of one shape. Moments M_a/c^|a| and coefficients
L_a c^|a| are in units of a node's scale c, which keeps float32 from overflow.
"""

import math
from collections.abc import Iterable
from functools import reduce
from operator import add
from typing import Any

import jax
import jax.numpy as jnp

from astroinertia.gravity.expansions import Index, harmonic, indices

Array = Any
Expansion = dict[Index, Array]
UNITS: tuple[Index, Index, Index] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def harmonics(order: int, x: list[Array]) -> Expansion:
    """h_a(x) up to an order, of three arrays of one shape."""
    powers: Expansion = {(0, 0, 0): jnp.ones_like(x[0])}
    for a in indices(order)[1:]:
        axis = max(k for k in range(3) if a[k])
        powers[a] = powers[_less(a, axis)] * (x[axis] / a[axis])
    return _folded(powers)


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
            once = _less(a, axis)
            found = x[axis] * value(once, m + 1)
            if once[axis]:
                found = found + once[axis] * value(_less(once, axis), m + 1)
            table[a, m] = found
        return table[a, m]

    return with_two_z({a: value(a, 0) for a in harmonic(order)[1:]})


def with_two_z(values: Expansion) -> Expansion:
    """Derivatives of a potential, and those of two z besides, which Laplace's equation has from the others."""
    result = dict(values)
    for a in [(0, 0, 0), *values]:
        along_x, along_y, along_z = (_plus(_plus(a, unit), unit) for unit in UNITS)
        if a[2] == 0 and along_x in values:
            result[along_z] = -(values[along_x] + values[along_y])
    return result


def scaled(values: Expansion, factor: Array) -> Expansion:
    """Components times factor^|a|."""
    powers = [jnp.ones_like(factor)]
    for _ in range(max(map(sum, values))):
        powers.append(powers[-1] * factor)
    return {a: value * powers[sum(a)] for a, value in values.items()}


def local(order: int, direction: list[Array], moments: Expansion) -> Expansion:
    """L_b = sum_a M_a D_(a+b) of sources whose centres are at unit distance, against `direction`."""
    d, given = _apart(derivatives(order, direction)) | {(0, 0, 0): 1.0}, _apart(moments)
    return {
        b: _total(d[_plus(a, b)] * m for a, m in given.items() if sum(a) + sum(b) <= order) for b in harmonic(order)
    }


def moments_shifted(order: int, moments: Expansion, by: list[Array]) -> Expansion:
    """Moments up to an order, about a centre that is at `by` from the one that they are given about."""
    h = _apart(harmonics(order, by))
    terms: dict[Index, list[Array]] = {}
    for a, m in moments.items():
        for b, value in h.items():
            if sum(a) + sum(b) <= order:
                terms.setdefault(_plus(a, b), []).append(m * value)
    return _folded({c: _total(each) for c, each in terms.items()})


def local_shifted(order: int, values: Expansion, by: list[Array]) -> Expansion:
    """Local coefficients about a centre that is at `by` from the one that they are given about."""
    h, given = _apart(harmonics(order, by)), with_two_z(values)
    return {
        b: _total(given[_plus(b, c)] * value for c, value in h.items() if sum(b) + sum(c) <= order)
        for b in harmonic(order)
    }


def field(values: Expansion, weights: Expansion) -> Array:
    """sum_b L_b w_b."""
    return _total(values[b] * weight for b, weight in weights.items())


def gradient(order: int, values: Expansion, axis: int, weights: Expansion) -> Array:
    """Its derivative along an axis: sum_b L_(b+e) w_b of all b below an order."""
    return _total(values[_plus(b, UNITS[axis])] * weight for b, weight in weights.items() if sum(b) < order)


def _folded(values: Expansion) -> Expansion:
    # Of harmonic a alone, the same sum over a of M_a D_a.
    values = dict(values)
    for a in sorted(values, key=lambda a: -a[2]):
        if a[2] >= 2:
            part, below = values.pop(a), _less(_less(a, 2), 2)
            for unit in UNITS[:2]:
                into = _plus(_plus(below, unit), unit)
                values[into] = values[into] - part
    return values


def _apart(values: Expansion) -> Expansion:
    # Kept by itself, so that XLA does not work it out again for each sum that it is in.
    return jax.lax.optimization_barrier(values)


def _total(terms: Iterable[Array]) -> Array:
    return reduce(add, terms)


def _plus(a: Index, b: Index) -> Index:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _less(a: Index, axis: int) -> Index:
    return a[0] - (axis == 0), a[1] - (axis == 1), a[2] - (axis == 2)
