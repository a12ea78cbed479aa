"""From particles to pairs: the ways in which values of particles spread over a tile, with derivatives that are cheap.

The derivative of an array (C, S, B) of pairs with respect to targets (C, S) and sources (C, B) is a sum over the tile.
Written as small matrix products, such sums are taken from one stored array; plain reductions are each fused with the
whole computation of the pairs, which is then repeated for every one of them (twice as slow, measured).
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

Array = Any
PRECISION = jax.lax.Precision.HIGHEST


@jax.custom_jvp
def product_of_differences(a: Array, b: Array, x: Array, y: Array) -> Array:
    """(a_i - b_j) . (x_i - y_j) for vectors of targets a, x (C, S, 3) and sources b, y (C, B, 3): (C, S, B)."""
    return sum((a[:, :, None, k] - b[:, None, :, k]) * (x[:, :, None, k] - y[:, None, :, k]) for k in range(3))


@product_of_differences.defjvp
def _product_of_differences_jvp(primals, tangents):
    a, b, x, y = primals
    change = _expanded(tangents[0], tangents[1], x, y) + _expanded(tangents[2], tangents[3], a, b)
    return product_of_differences(*primals), change


def _expanded(a: Array, b: Array, x: Array, y: Array) -> Array:
    # The same product, multiplied out and linear in a and b: (a.x - a.y) + (b.y - b.x), each one matrix product.
    mine = jnp.concatenate([(a * x).sum(axis=2, keepdims=True), -a], axis=2)
    theirs = jnp.concatenate([(b * y).sum(axis=2, keepdims=True), -b], axis=2)
    with_y, with_x = (jnp.concatenate([jnp.ones_like(z[:, :, :1]), z], axis=2) for z in (y, x))
    first = jnp.einsum("cik,cjk->cij", mine, with_y, precision=PRECISION)
    return first + jnp.einsum("cik,cjk->cij", with_x, theirs, precision=PRECISION)


@partial(jax.custom_jvp, nondiff_argnums=(1, 2))
def spread(values: Array, over_sources: bool, across: int) -> Array:
    """Values of targets (C, S) for all of `across` sources, or of sources (C, B) for all targets: (C, S, B)."""
    if over_sources:
        return jnp.broadcast_to(values[:, :, None], (*values.shape, across))
    return jnp.broadcast_to(values[:, None, :], (values.shape[0], across, values.shape[1]))


@spread.defjvp
def _spread_jvp(over_sources, across, primals, tangents):
    one = jnp.ones(across, primals[0].dtype)
    change = jnp.einsum("ci,j->cij" if over_sources else "cj,i->cij", tangents[0], one, precision=PRECISION)
    return spread(primals[0], over_sources, across), change
