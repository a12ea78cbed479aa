"""Multipole and Taylor expansions of 1/r in Cartesian components, traced with jax.numpy over batches of nodes.

With multi-indices n, k, moments M_k = sum m s^k/k! about a source's centre and a target's centre at R from it,

    sum m/|R + t - s| = sum_n t^n/n! sum_k (-1)^|k| D_(n+k)(R) M_k,    D_n = d^n (1/R),    |n| + |k| <= p.

Cut off at the same combined order for sources and targets, the forces of two nodes on each other are opposite, to
rounding (Dehnen 2002, J. Comput. Phys. 179, 27). A batch is a list of one array a component, so that everything
here is arithmetic between arrays of one shape. Components are in units of the node's scale c: M_k/c^|k|, L_n c^|n|,
which keeps float32 from overflow.
"""

from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

Array = Any
Index = tuple[int, int, int]


@lru_cache
def multi_indices(order: int) -> tuple[Index, ...]:
    """All (a, b, c) with a + b + c <= order, by ascending sum."""
    return tuple((a, b, n - a - b) for n in range(order + 1) for a in range(n, -1, -1) for b in range(n - a, -1, -1))


@lru_cache
def places(order: int) -> dict[Index, int]:
    """Where each multi-index is in `multi_indices`."""
    return {index: place for place, index in enumerate(multi_indices(order))}


def _sum(one: Index, other: Index) -> Index:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]


def monomials(order: int, x: list[Array]) -> list[Array]:
    """x^n/n! of three arrays of one shape, a list over multi-indices."""
    powers: dict[Index, Array] = {(0, 0, 0): jnp.ones_like(x[0])}
    for index in multi_indices(order)[1:]:
        axis = max(range(3), key=lambda a: index[a])
        lower = tuple(index[a] - (a == axis) for a in range(3))
        powers[index] = powers[lower] * (x[axis] / index[axis])  # type: ignore[index]
    return list(powers.values())


def derivatives(order: int, x: list[Array]) -> list[Array]:
    """D_n(x), all derivatives of 1/r up to an order, a list over multi-indices; infinite at the origin.

    d^(n + e) = x_e T' + n_e T'' with T^(j) the same derivatives of (1/r d/dr)^j (1/r).
    """
    inverse = jax.lax.rsqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    squared = inverse * inverse
    radial = [inverse]
    for j in range(order):
        radial.append(radial[-1] * squared * -(2.0 * j + 1.0))
    table: dict[Index, list[Array]] = {(0, 0, 0): radial}
    for index in multi_indices(order)[1:]:
        axis = min((a for a in range(3) if index[a]), key=lambda a: index[a])
        lower = tuple(index[a] - (a == axis) for a in range(3))
        twice = tuple(index[a] - 2 * (a == axis) for a in range(3))
        rows = []
        for j in range(order - sum(index) + 1):
            value = x[axis] * table[lower][j + 1]  # type: ignore[index]
            rows.append(value + lower[axis] * table[twice][j + 1] if lower[axis] else value)  # type: ignore[index]
        table[index] = rows
    return [rows[0] for rows in table.values()]


def scaled(order: int, values: list[Array], factor: Array) -> list[Array]:
    """Components times factor^|n|."""
    powers = [jnp.ones_like(factor)]
    for _ in range(order):
        powers.append(powers[-1] * factor)
    return [value * powers[sum(n)] for n, value in zip(multi_indices(order), values, strict=True)]


def local(order: int, separation: list[Array], moments: list[Array]) -> list[Array]:
    """L_n = -sum_k (-1)^|k| D_(n+k) M_k of sources without a dipole, at `separation` = target - source."""
    d = derivatives(order, separation)
    where, indices = places(order), multi_indices(order)
    # About its centre of mass a source has no dipole.
    sources = [(k, moments[where[k]] if sum(k) % 2 else -moments[where[k]]) for k in indices if sum(k) != 1]
    return [sum(d[where[_sum(n, k)]] * m for k, m in sources if sum(n) + sum(k) <= order) for n in indices]


def moments_shifted(order: int, moments: list[Array], by: list[Array]) -> list[Array]:
    """Moments about a new centre from those about one that is at `by` from it; without dipoles to begin with."""
    e, where = monomials(order, by), places(order)
    indices = [k for k in multi_indices(order) if sum(k) != 1]
    return [
        sum(moments[where[j]] * e[where[difference]] for j in indices if (difference := _lower(k, j)))
        for k in multi_indices(order)
    ]


def local_shifted(order: int, values: list[Array], by: list[Array]) -> list[Array]:
    """A Taylor expansion about a centre from that about another one; the new one is at `by` from it."""
    e, where, indices = monomials(order, by), places(order), multi_indices(order)
    return [
        sum(values[where[m]] * e[where[difference]] for m in indices if (difference := _lower(m, n))) for n in indices
    ]


def _lower(one: Index, other: Index) -> Index | None:
    # one - other, where it is one.
    difference = one[0] - other[0], one[1] - other[1], one[2] - other[2]
    return difference if min(difference) >= 0 else None


def gradient_places(order: int) -> np.ndarray:
    """(3, K) places of n + e_a for the K multi-indices |n| < order: the gradient's components in an expansion."""
    units = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    where = places(order)
    return np.array([[where[_sum(n, unit)] for n in multi_indices(order - 1)] for unit in units])
