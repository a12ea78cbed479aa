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

from astroinertia.engines import xla_pairs, xla_tiles
from astroinertia.engines.pytree import pytree
from astroinertia.gravity import expansions_xla as expansions, lists_xla, multipole
from astroinertia.gravity.clamped_points import CLAMP
from astroinertia.gravity.lists_xla import Chunks, Lists

Array = Any
ROUGHLY = 0.01  # error of first accelerations, which only say how large the allowed errors are
# (order, finest error that it takes the least time for). With these the error of one pair of nodes, as estimated, is
# about the rms error of all together: 0.4 to 1.5 times on uniform, Evrard's, Plummer's and disc sets (measured).
ORDERS = ((3, 5e-3), (4, 1e-4), (5, 1e-5), (6, 0.0))


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


@partial(jax.jit, static_argnames=("precision", "virial"))
def points(
    precision: str,
    virial: bool,
    lists: Lists,
    mass: Array,
    position: Array,
    smoothing_length: Array,
) -> dict[str, Array]:
    """{"acceleration": (N, 3), "potential": (N,)[, "virial": (3, 3)]} of clamped points (N,), (N, 3), (N,).

    Self pairs are included. Lists may be out of date: that costs accuracy as long as smoothing lengths have not grown
    by a third. precision "mixed" works in float32 on coordinates relative to leaves and nodes, and adds up in float64.
    """
    bodies = _bodies(precision, lists, mass, position, smoothing_length)
    near, near_virial = _near(bodies, virial)
    far, far_virial = _far(bodies, virial)
    whole = (near + far)[lists.row, lists.column]
    sums = {"acceleration": whole[:, :3], "potential": whole[:, 3]}
    if virial:
        sums["virial"] = near_virial[jnp.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])] + far_virial
    return sums


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


def _near(bodies: _Bodies, virial: bool) -> tuple[Array, Array]:
    # Sums (L, S, 4) over pairs of leaves, and the virial tensor's six components.
    targets = bodies.relative, bodies.mass, bodies.clamp
    arrays = bodies, tuple(bodies.with_empty(array) for array in targets)

    def add(arrays: Any, carry: tuple[Array, Array], target: Array, source: Array) -> tuple[Array, Array]:
        bodies, (sources, source_mass, source_clamp) = arrays
        relative, mass, clamp = bodies.relative, bodies.mass, bodies.clamp
        sums, tensor = carry
        offset = (bodies.leaf_centre[source] - bodies.leaf_centre[target]).astype(bodies.dtype)
        x, y, weight = relative[target], sources[source] + offset[:, None], source_mass[source]
        squared = xla_pairs.product_of_differences(x, y, x, y)
        inverse = jax.lax.rsqrt(jnp.maximum(squared, clamp[target][:, :, None] + source_clamp[source][:, None, :]))
        slope = inverse * inverse * inverse
        attraction = -xla_tiles.moments(slope, x, y, weight)
        part = jnp.concatenate([attraction, -xla_tiles.weighted(inverse, weight)[:, :, None]], axis=2)
        sums = sums.at[target].add(part.astype(sums.dtype), indices_are_sorted=True, mode="promise_in_bounds")
        if virial:
            separation = [x[:, :, None, a] - y[:, None, :, a] for a in range(3)]
            masses = mass[target].astype(tensor.dtype), weight.astype(tensor.dtype)
            tensor = tensor + xla_tiles.virial_of(slope, separation, masses)
        return sums, tensor

    return _sum_over_chunks(arrays, bodies.lists.near, add, (jnp.zeros((*bodies.mass.shape, 4)), jnp.zeros(6)))


def _far(bodies: _Bodies, virial: bool) -> tuple[Array, Array]:
    # Sums (L, S, 4) by expansions, and the virial tensor (3, 3).
    lists, order = bodies.lists, bodies.order
    if not lists.local.target.shape[0]:
        return jnp.zeros((*bodies.mass.shape, 4)), jnp.zeros((3, 3))
    indices = expansions.multi_indices(order)
    scale = bodies.scale
    x = [bodies.relative[:, :, a] / scale[lists.leaf_node][:, None].astype(bodies.dtype) for a in range(3)]
    powers = expansions.monomials(order, x)
    leaf_moments = jnp.stack([(bodies.mass * power).sum(axis=1) for power in powers], axis=1)
    moments = _upward(bodies, leaf_moments)
    local = _interactions(bodies, moments)
    leaf_local = _downward(bodies, local)
    gradient = expansions.gradient_places(order)
    lower = len(gradient[0])
    size = scale[lists.leaf_node].astype(bodies.dtype)
    parts = [
        -sum(leaf_local[:, gradient[a, k], None] * powers[k] for k in range(lower)) / size[:, None] for a in range(3)
    ]
    parts.append(sum(leaf_local[:, k, None] * powers[k] for k in range(len(indices))))
    sums = jnp.stack(parts, axis=2).astype(bodies.centre.dtype)
    return sums, _node_virial(bodies, moments, local) if virial else jnp.zeros((3, 3))


def _upward(bodies: _Bodies, leaf_moments: Array) -> Array:
    # Moments (nodes + 1, K) of all nodes that take part, from those of leaves.
    lists, order, nodes = bodies.lists, bodies.order, bodies.lists.first.shape[0]

    def add(both: Any, carry: Array, leaf: Array, node: Array) -> Array:
        bodies, leaf_moments = both
        by, ratio, size = _shift(bodies, leaf, node)
        moments = leaf_moments[leaf]
        moments = [jnp.broadcast_to(moments[:, None, k], node.shape) for k in range(moments.shape[1])]
        moments = expansions.scaled(order, moments, ratio)
        moved = expansions.moments_shifted(order, moments, [d / size for d in by])
        return carry.at[node].add(jnp.stack(moved, axis=2).astype(carry.dtype), mode="promise_in_bounds")

    zero = jnp.zeros((nodes + 1, leaf_moments.shape[1]))
    return _sum_over_chunks((bodies, leaf_moments), lists.shifts, add, zero).at[nodes].set(0.0)


def _components(gathered: Array) -> list[Array]:
    # (C, K, n) as n arrays (C, K), each in one piece of memory: twice as fast as reading across the rows (measured).
    return list(jax.lax.optimization_barrier(jnp.moveaxis(gathered, 2, 0)))


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
    moments = moments.astype(bodies.dtype)

    def add(both: Any, carry: Array, target: Array, source: Array) -> Array:
        bodies, moments = both
        separation = bodies.centre[target][:, None] - bodies.centre[source]
        distance = jnp.sqrt((separation * separation).sum(axis=2))
        # In units of the distance all numbers are about 1 or less, which float32 holds.
        components = _components(moments[source])
        components = expansions.scaled(order, components, (bodies.scale[source] / distance).astype(bodies.dtype))
        made = expansions.local(order, bodies.components(separation / distance[:, :, None]), components)
        made = expansions.scaled(order, made, (bodies.scale[target][:, None] / distance).astype(bodies.dtype))
        inverse = (1.0 / distance).astype(bodies.dtype)
        part = (jnp.stack(made, axis=2) * inverse[:, :, None]).sum(axis=1)
        return carry.at[target].add(part.astype(carry.dtype), indices_are_sorted=True, mode="promise_in_bounds")

    zero = jnp.zeros((moments.shape[0], moments.shape[1]))
    return _sum_over_chunks((bodies, moments), bodies.lists.local, add, zero)


def _downward(bodies: _Bodies, local: Array) -> Array:
    # Expansions (L, K) about the leaves, of all nodes above them.
    order = bodies.order
    local = local.astype(bodies.dtype)

    def add(both: Any, carry: Array, leaf: Array, node: Array) -> Array:
        bodies, local = both
        by, ratio, size = _shift(bodies, leaf, node)
        components = _components(local[node])
        moved = expansions.scaled(order, expansions.local_shifted(order, components, [d / size for d in by]), ratio)
        part = jnp.stack(moved, axis=2).sum(axis=1)
        return carry.at[leaf].add(part.astype(carry.dtype), indices_are_sorted=True, mode="promise_in_bounds")

    zero = jnp.zeros((bodies.mass.shape[0], local.shape[1]))
    return _sum_over_chunks((bodies, local), bodies.lists.shifts, add, zero).astype(bodies.dtype)


def _node_virial(bodies: _Bodies, moments: Array, local: Array) -> Array:
    # sum m x (x) a of each node's own list from its moments and its expansion alone: a route of its own.
    order, scale = bodies.order, bodies.scale
    where, lower = expansions.places(order), expansions.multi_indices(order - 1)
    dipole = np.array([0.0 if sum(n) == 1 else 1.0 for n in expansions.multi_indices(order)])
    moments = moments * dipole
    gradient = expansions.gradient_places(order)
    force = [-sum(local[:, gradient[b, k]] * moments[:, k] for k in range(len(lower))) / scale for b in range(3)]
    tensor = []
    for a in range(3):
        raised = [tuple(n[c] + (c == a) for c in range(3)) for n in lower]
        lever = [(n[a] + 1) * moments[:, where[up]] for n, up in zip(lower, raised, strict=True)]  # type: ignore[index]
        inner = [-sum(local[:, gradient[b, k]] * lever[k] for k in range(len(lower))) for b in range(3)]
        tensor.append(jnp.stack([(bodies.centre[:, a] * force[b] + inner[b]).sum() for b in range(3)]))
    return jnp.stack(tensor)
