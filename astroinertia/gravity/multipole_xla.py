"""Fast multipole gravity traced with jax.numpy: interaction lists from the host, everything else in compiled code.

Near pairs are clamped points (gravity.clamped_points); what softening changes about those is a sum over neighbours.
Moments of the leaves are shifted straight to every node above them that takes part, and expansions straight back, so
that no pass waits for another one level up, and shapes do not depend on the depth of the tree. All of it can be
differentiated, forwards and backwards, with the lists held fixed. Checked by tests/unit/gravity/test_multipole_xla.py.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines import xla_pairs, xla_sums, xla_tiles
from astroinertia.engines.pytree import pytree
from astroinertia.gravity import expansions_xla as expansions, lists_xla, multipole
from astroinertia.gravity.clamped_points import CLAMP
from astroinertia.gravity.expansions import harmonic
from astroinertia.gravity.lists_xla import Chunks, Lists

Array = Any
ROUGHLY = 0.01  # error of first accelerations, which only say how large the allowed errors are
# (order, finest error that it takes the least time for). With these the error of one pair of nodes, as estimated, is
# about the rms error of all together: 0.2 to 1.8 times on uniform, Evrard's, Plummer's and disc sets (measured).
ORDERS = ((3, 5e-3), (4, 1e-3), (5, 1e-4), (6, 1e-5), (7, 0.0))


def lists_for(engine: Any, arrangement: Any, mass: Array, acceleration: Array | None, force_error: float) -> Lists:
    """Interaction lists for the particles that the engine has arranged, and for a wanted rms of |da|/|a|.

    mass (N,), acceleration (N, 3) of gravity as far as it is known: a first evaluation looks for it by itself.
    """
    mass, position = np.asarray(mass), np.asarray(arrangement.position)
    smoothing_length = np.asarray(arrangement.smoothing_length)
    if acceleration is None:
        acceleration, _ = multipole.gravity(mass, position, smoothing_length, None, ROUGHLY)
    strength = multipole.strengths(np.asarray(acceleration))
    order = next((p for p, finest in ORDERS if force_error >= finest), ORDERS[-1][0])
    # Clamped distances reach sqrt(1/2) of the longer smoothing length: this leaves room for it to grow.
    return lists_xla.interaction_lists(
        mass, position, smoothing_length, strength, float(force_error), order, engine.near_leaf, engine.chunk
    )


@partial(jax.jit, static_argnames="precision")
def points(precision: str, lists: Lists, mass: Array, position: Array, smoothing_length: Array) -> dict[str, Array]:
    """{"acceleration": (N, 3), "potential": (N,)} of clamped points (N,), (N, 3), (N,).

    Self pairs are included. Lists may be out of date: that costs accuracy as long as smoothing lengths have not grown
    by a third. precision "mixed" works in float32 on coordinates relative to leaves and nodes, and adds up in float64.
    """
    bodies = _bodies(precision, lists, mass, position, smoothing_length)
    sums = _near(bodies)
    if lists.local.target.shape[0]:
        sums = sums + _far(bodies)
    sums = sums[lists.row, lists.column]
    return {"acceleration": sums[:, :3], "potential": sums[:, 3]}


@partial(jax.jit, static_argnames="precision")
def virial(precision: str, lists: Lists, mass: Array, position: Array, smoothing_length: Array) -> Array:
    """The virial tensor (3, 3) of the same, by a route of its own: pairs, and expansions about their own nodes."""
    bodies = _bodies(precision, lists, mass, position, smoothing_length)
    tensor = _near_virial(bodies)[jnp.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])]
    return tensor + _far_virial(bodies) if lists.local.target.shape[0] else tensor


@pytree
@dataclass(frozen=True)
class _Bodies:
    """Leaves and nodes where the particles are now; the last of each is an empty one, far away.

    centre (nodes + 1, 3), leaf_centre (L + 1, 3); of leaves, in the type of pairs: coordinates about the centre
    (L, S, 3), masses and shares of the clamp (L, S).
    """

    lists: Lists
    centre: Array
    leaf_centre: Array
    relative: Array
    mass: Array
    clamp: Array

    @property
    def order(self) -> int:
        """Of the expansions."""
        return self.lists.order

    @property
    def scale(self) -> Array:
        """Of lengths about each node."""
        return self.lists.scale

    @property
    def dtype(self) -> Any:
        """The type of pairs."""
        return self.mass.dtype

    @staticmethod
    def with_empty(array: Array) -> Array:
        """Leaves' values and zeros for the empty leaf."""
        return jnp.concatenate([array, jnp.zeros_like(array[:1])])

    def components(self, difference: Array) -> list[Array]:
        """(..., 3) as three arrays in the type of pairs."""
        return [difference[..., a].astype(self.dtype) for a in range(3)]


def _bodies(precision: str, lists: Lists, mass: Array, position: Array, smoothing_length: Array) -> _Bodies:
    dtype = jnp.float32 if precision == "mixed" else jnp.float64
    taken = lists.slots < mass.shape[0]
    # An empty place is a copy of its leaf's first particle, without mass; in an empty leaf, of any.
    slots = jnp.where(taken, lists.slots, jnp.minimum(lists.slots[:, :1], mass.shape[0] - 1))
    masses, points = jnp.where(taken, mass[slots], 0.0), position[slots]
    leaf_mass = masses.sum(axis=1)
    leaf_sum = (masses[:, :, None] * points).sum(axis=1)
    # Dipoles are left out: centres must be those of mass to rounding, or momentum is not conserved to rounding.
    node = _sum_over_chunks(
        jnp.concatenate([leaf_mass[:, None], leaf_sum], axis=1),
        lists.shifts,
        lambda sums, carry, leaf, node: carry.at[node].add(sums[leaf][:, None], mode="promise_in_bounds"),
        jnp.zeros((len(lists.scale), 4)),
    )
    centre = node[:-1, 1:] / jnp.where(node[:-1, :1] > 0.0, node[:-1, :1], 1.0)
    full = leaf_mass[:, None] > 0.0
    leaf_centre = jnp.where(full, leaf_sum / jnp.where(full, leaf_mass[:, None], 1.0), points[:, 0])
    away = jax.lax.stop_gradient(position.max(axis=0) + 2.0 * jnp.ptp(position, axis=0) + 1.0)
    return _Bodies(
        lists=lists,
        centre=jnp.concatenate([centre, away[None]]),
        leaf_centre=jnp.concatenate([leaf_centre, away[None]]),
        relative=(points - leaf_centre[:, None]).astype(dtype),
        mass=masses.astype(dtype),
        clamp=(CLAMP * smoothing_length[slots] ** 2).astype(dtype),
    )


def _sum_over_chunks(arrays: Any, chunks: Chunks, add: Callable[[Any, Any, Array, Array], Any], zero: Any) -> Any:
    # add(arrays, sums, target, source) for every chunk that is used; arrays: all that it works with.
    total = chunks.target.shape[0]
    if not total:
        return zero

    def one(both: Any, carry: Any, chunk: Array) -> Any:
        arrays, chunks = both

        def added(carry: Any) -> Any:
            return add(arrays, carry, chunks.target[chunk], chunks.source[chunk])

        return jax.lax.cond(chunk < chunks.used, jax.checkpoint(added), lambda carry: carry, carry)

    return xla_tiles.in_groups(one, (arrays, chunks), zero, total, chunks.used)


def _near(bodies: _Bodies) -> Array:
    # Sums (L, S, 4) over pairs of leaves.
    def add(arrays: Any, sums: Array, target: Array, source: Array) -> Array:
        x, y, weight, inverse = _pairs(arrays, target, source)
        attraction = -xla_tiles.moments(inverse * inverse * inverse, x, y, weight)
        part = jnp.concatenate([attraction, -xla_tiles.weighted(inverse, weight)[:, :, None]], axis=2)
        return sums.at[target].add(part.astype(sums.dtype), indices_are_sorted=True, mode="promise_in_bounds")

    return _sum_over_chunks(_both_sides(bodies), bodies.lists.near, add, jnp.zeros((*bodies.mass.shape, 4)))


def _near_virial(bodies: _Bodies) -> Array:
    # The virial tensor's six components of the same pairs.
    def add(arrays: Any, tensor: Array, target: Array, source: Array) -> Array:
        x, y, weight, inverse = _pairs(arrays, target, source)
        separation = [x[:, :, None, a] - y[:, None, :, a] for a in range(3)]
        masses = arrays[0].mass[target].astype(tensor.dtype), weight.astype(tensor.dtype)
        return tensor + xla_tiles.virial_of(inverse * inverse * inverse, separation, masses)

    return _sum_over_chunks(_both_sides(bodies), bodies.lists.near, add, jnp.zeros(6))


def _both_sides(bodies: _Bodies) -> tuple[_Bodies, tuple[Array, Array, Array]]:
    # Targets, and the leaves as sources, with the empty one.
    relative, mass, clamp = (bodies.with_empty(array) for array in (bodies.relative, bodies.mass, bodies.clamp))
    return bodies, (relative, mass, clamp)


def _pairs(arrays: Any, target: Array, source: Array) -> tuple[Array, Array, Array, Array]:
    # Of leaves (C,) each: coordinates (C, S, 3) of targets and sources, sources' masses, inverse clamped distances.
    bodies, (sources, source_mass, source_clamp) = arrays
    offset = (bodies.leaf_centre[source] - bodies.leaf_centre[target]).astype(bodies.dtype)
    x, y = bodies.relative[target], sources[source] + offset[:, None]
    squared = xla_pairs.product_of_differences(x, y, x, y)
    clamp = bodies.clamp[target][:, :, None] + source_clamp[source][:, None, :]
    return x, y, source_mass[source], jax.lax.rsqrt(jnp.maximum(squared, clamp))


def _far(bodies: _Bodies) -> Array:
    # Sums (L, S, 4) by expansions.
    order, size, h = bodies.order, *_about_leaves(bodies)
    moments = _upward(bodies, _leaf_moments(order, bodies.mass[None], h))
    values = _downward(bodies, _interactions(bodies, moments[:, 0]))
    fields = jnp.stack([*(slope / size for slope in expansions.gradient(order, values)), -values])
    return jnp.einsum("ckl,kls->lsc", fields, h, precision=xla_tiles.PRECISION).astype(bodies.centre.dtype)


def _far_virial(bodies: _Bodies) -> Array:
    # sum m x (x) a of each node's own list (3, 3), from its expansion and its moments of m x alone.
    order, (_, h) = bodies.order, _about_leaves(bodies)
    weights = jnp.concatenate([bodies.mass[None], bodies.mass * _levers(bodies)])
    moments = _upward(bodies, _leaf_moments(order, weights, h))
    values = (_interactions(bodies, moments[:, 0]) / bodies.scale[:, None]).T
    fields = jnp.stack(expansions.gradient(order, values))
    return jnp.einsum("akn,nbk->ba", fields, moments[:, 1:] * _signs(order), precision=xla_tiles.PRECISION)


def _about_leaves(bodies: _Bodies) -> tuple[Array, Array]:
    # The leaves' scales (L,), and harmonics (K, L, S) of their particles in units of those.
    size = bodies.scale[bodies.lists.leaf_node].astype(bodies.dtype)
    return size, expansions.harmonics(bodies.order, [bodies.relative[:, :, a] / size[:, None] for a in range(3)])


def _leaf_moments(order: int, weights: Array, h: Array) -> Array:
    # Moments (L, W, K) of weights (W, L, S), of the centre less the particle.
    return jnp.einsum("wls,kls->lwk", weights, h, precision=xla_tiles.PRECISION) * _signs(order).astype(h.dtype)


def _signs(order: int) -> np.ndarray:
    # Of harmonics on the other side of the origin.
    return np.array([(-1.0) ** sum(a) for a in harmonic(order)])


def _levers(bodies: _Bodies) -> Array:
    # Coordinates (3, L, S) about a point amid all of them.
    centre = bodies.leaf_centre[:-1]
    offset = (centre - jax.lax.stop_gradient(centre.mean(axis=0))).astype(bodies.dtype)
    return jnp.moveaxis(bodies.relative + offset[:, None], 2, 0)


def _apart(array: Array) -> Array:
    # (..., K) as (K, ...), each component in one piece of memory: twice as fast as reading across the rows (measured).
    return jax.lax.optimization_barrier(jnp.moveaxis(array, -1, 0))


def _upward(bodies: _Bodies, leaf_moments: Array) -> Array:
    # Moments (nodes + 1, W, K) of all nodes that take part, from those of leaves (L, W, K), for W weights.
    lists, order, nodes = bodies.lists, bodies.order, bodies.lists.first.shape[0]

    def add(both: Any, carry: Array, leaf: Array, node: Array) -> Array:
        bodies, leaf_moments = both
        by, ratio, size = _shift(bodies, leaf, node)
        moments = expansions.scaled(order, _apart(leaf_moments[leaf][:, None]), ratio[:, :, None])
        moved = expansions.moments_shifted(order, moments, [(-d / size)[:, :, None] for d in by])
        part = jnp.moveaxis(moved, 0, -1).astype(carry.dtype)
        return carry.at[node].add(part, mode="promise_in_bounds")

    zero = jnp.zeros((nodes + 1, *leaf_moments.shape[1:]))
    return _sum_over_chunks((bodies, leaf_moments), lists.shifts, add, zero).at[nodes].set(0.0)


def _shift(bodies: _Bodies, leaf: Array, node: Array) -> tuple[list[Array], Array, Array]:
    # From nodes (C, K) to leaves (C,): the way, the ratio of their scales and the nodes' scale; no way to empty ones.
    lists = bodies.lists
    listed = (node < lists.first.shape[0])[:, :, None]
    way = jnp.where(listed, bodies.leaf_centre[leaf][:, None] - bodies.centre[node], 0.0)
    size = bodies.scale[node]
    ratio = bodies.scale[lists.leaf_node[leaf]][:, None] / size
    return bodies.components(way), ratio.astype(bodies.dtype), size.astype(bodies.dtype)


def _interactions(bodies: _Bodies, moments: Array) -> Array:
    # Expansions (nodes + 1, K) about every node, of the nodes in its list.
    order = bodies.order
    # About its centre of mass a source has no dipole.
    keys = harmonic(order)
    sources = tuple(a for a in keys if sum(a) != 1)
    moments = moments[:, np.array([sum(a) != 1 for a in keys])].astype(bodies.dtype)

    def add(both: Any, carry: Array, target: Array, source: Array) -> Array:
        bodies, moments = both
        separation = bodies.centre[target][:, None] - bodies.centre[source]
        distance = jnp.sqrt((separation * separation).sum(axis=2))
        # In units of the distance all numbers are about 1 or less, which float32 holds.
        ratio = (bodies.scale[source] / distance).astype(bodies.dtype)
        powers = expansions.powers(order, ratio)
        given = {a: m * powers[sum(a)] for a, m in zip(sources, _apart(moments[source]), strict=True)}
        made = expansions.local(order, bodies.components(separation / distance[:, :, None]), given)
        powers = expansions.powers(order, (bodies.scale[target][:, None] / distance).astype(bodies.dtype))
        inverse = (1.0 / distance).astype(bodies.dtype)
        part = jnp.stack(xla_sums.sums([made[b] * powers[sum(b)] * inverse for b in keys], 1), axis=1)
        return carry.at[target].add(part.astype(carry.dtype), indices_are_sorted=True, mode="promise_in_bounds")

    zero = jnp.zeros((moments.shape[0], len(keys)))
    return _sum_over_chunks((bodies, moments), bodies.lists.local, add, zero)


def _downward(bodies: _Bodies, local: Array) -> Array:
    # Expansions (K, L) about the leaves, of all nodes above them.
    order, local = bodies.order, local.astype(bodies.dtype)

    def add(both: Any, carry: Array, leaf: Array, node: Array) -> Array:
        bodies, local = both
        by, ratio, size = _shift(bodies, leaf, node)
        moved = expansions.local_shifted(order, _apart(local[node]), [d / size for d in by])
        part = expansions.scaled(order, moved, ratio).sum(axis=2).T
        return carry.at[leaf].add(part.astype(carry.dtype), indices_are_sorted=True, mode="promise_in_bounds")

    zero = jnp.zeros((bodies.mass.shape[0], local.shape[1]))
    return _sum_over_chunks((bodies, local), bodies.lists.shifts, add, zero).astype(bodies.dtype).T
