"""Pair sums over tiles: how compiled code goes through the tiles of an arrangement and adds up what pair terms return.

A chunk of C tiles is C leaves of S targets against C blocks of B sources: pair arrays have shape (C, S, B). Chunks run
in ascending order of the leaves, in two nested scans, and each is computed again in reverse mode rather than stored.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from astroinertia.engines import devices, xla_pairs, xla_sums
from astroinertia.engines.terms import KERNEL_NAMES, SEPARATION, Output, PairTerm, arguments
from astroinertia.engines.xla_lists import Tiles
from astroinertia.engines.xla_places import Places
from astroinertia.sph.kernels import Kernel

Array = Any
# So few chunks are gone through one by one; more of them in groups of about as many, which are skipped and stored as a
# whole, and groups of groups.
FEW = 64
# Sums over pairs as differences of sums lose this factor in digits, and more is not given away.
UNEVEN = 100.0
PRECISION = jax.lax.Precision.HIGHEST
AXES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


class Pairs:
    """The scalars of all pairs of a chunk, each worked out when it is first asked for.

    Targets and sources are {field: (C, S) or (C, B)}, vectors with a last axis of 3, in the type that pairs are
    computed in; in float32 they are relative to a particle of the leaf.
    """

    def __init__(self, kernel: Kernel, targets: Mapping[str, Array], sources: Mapping[str, Array]) -> None:
        self.kernel, self.targets, self.sources = kernel, targets, sources
        self.quantities: dict[str, Array] = {}
        squared = self._product("position", "position")
        apart = squared != 0.0  # also where it is not a number, which must not go unseen
        # A square root has no derivative at 0: the inner `where` keeps it away from there.
        root = jnp.sqrt(jnp.where(apart, squared, 1.0))
        self.inverse_r = jnp.where(apart, 1.0 / root, 0.0)
        self.quantities["r"] = jnp.where(apart, root, 0.0)

    @property
    def separation(self) -> list[Array]:
        """x_i - x_j, three components of shape (C, S, B)."""
        mine, other = self.targets["position"], self.sources["position"]
        return [mine[:, :, None, k] - other[:, None, :, k] for k in range(3)]

    def _product(self, one: str, other: str) -> Array:
        sides = (self.targets, self.sources)
        return xla_pairs.product_of_differences(*(side[name] for name in (one, other) for side in sides))

    def __getitem__(self, name: str) -> Array:
        if name not in self.quantities:
            self.quantities[name] = self._made(name)
        return self.quantities[name]

    def _made(self, name: str) -> Array:
        if name == "v_r":
            return self._product("velocity", "position") * self.inverse_r
        if name in SEPARATION:
            k = SEPARATION.index(name)
            mine, other = (side["position"][:, :, k] for side in (self.targets, self.sources))
            return self._spread(mine, "i") - self._spread(other, "j")
        stem, side = name[:-2], name[-1]
        if stem == "h":
            return self._field("smoothing_length", side)
        if stem in KERNEL_NAMES:
            function, power = KERNEL_NAMES[stem]
            value = getattr(self.kernel, function)(jnp, self["r"] * self.inverse_length(side))
            return value * self.inverse_length(side, power)
        return self._field(stem, side)

    def inverse_length(self, side: str, power: int = 1) -> Array:
        """1/h^power of targets ("i") or sources ("j")."""
        name = f"inverse_h{power}_{side}"
        if name not in self.quantities:
            h = (self.targets if side == "i" else self.sources)["smoothing_length"]
            self.quantities[name] = self._spread((1.0 / h) ** power, side)
        return self.quantities[name]

    def _field(self, name: str, side: str) -> Array:
        return self._spread((self.targets if side == "i" else self.sources)[name], side)

    def _spread(self, values: Array, side: str) -> Array:
        across = (self.sources if side == "i" else self.targets)["position"].shape[1]
        return xla_pairs.spread(values, side == "i", across)


def columns(output: Output) -> int:
    """How many sums one output is made of."""
    return {"central": 3, "sum": 1, "outer": 9, "max": 0}[output.how]


def sum_over_tiles(
    tiles: Tiles,
    covered: Array,
    boxes: tuple[Array, Array, Array, Array] | None,
    places: Places,
    chunk_sums: Callable[[Places, Array, Array], Any],
    zero: Any,
    otherwise_all: bool = True,
) -> Any:
    """Add up `chunk_sums(places, target particles (C, S), source particles (C, B))` by target leaf.

    It returns a dictionary, gathered into one like `zero`: (C, S, ...) arrays into (L, S, ...), by addition under the
    key "sum" and by maximum under "max"; arrays under "total" are simply added. Where the lists do not
    cover all pairs, all tiles are visited (or with otherwise_all=False none); the `boxes` of `boxes_of` say which of
    them can be left out.
    """
    listed, size = tiles.leaf.shape
    leaves, blocks = tiles.slots.shape[0], tiles.blocks.shape[0] - 1
    # All tiles are visited in patches of neighbouring leaves and blocks, which are out of reach together.
    tall, wide = tiles.patch
    across = -(-blocks // wide)
    everything = -(-leaves // tall) * across if otherwise_all else 0
    total = max(listed, everything)
    used = jnp.where(covered, tiles.used, everything)

    def one(arrays: Any, carry: Any, chunk: Array) -> Any:
        tiles, covered, boxes, used, places = arrays
        row = jnp.minimum(chunk, listed - 1)
        member = jnp.arange(size)
        leaf = chunk // across * tall + member // wide
        block = jnp.where(leaf < leaves, jnp.minimum(chunk % across * wide + member % wide, blocks), blocks)
        leaf = jnp.minimum(leaf, leaves - 1)
        within = jnp.array(True)
        if boxes is not None:
            within = (_in_reach(boxes, leaf, block) & (block < blocks)).any()
        target = jnp.where(covered, tiles.leaf[row], leaf)
        if tiles.by_block:
            source = tiles.blocks[jnp.where(covered, tiles.sources[row, :, 0], block)]
        else:
            source = jnp.where(covered, tiles.sources[row], tiles.blocks[block])

        def add(carry: Any) -> Any:
            # Sums are finished first: else a GPU works them out again for each column that they are added to.
            part = jax.lax.optimization_barrier(chunk_sums(places, tiles.slots[target], source))
            return _gathered(carry, target, part)

        return jax.lax.cond((chunk < used) & (covered | within), jax.checkpoint(add), lambda carry: carry, carry)

    return in_groups(one, (tiles, covered, boxes, used, places), zero, total, used)


def in_groups(one: Callable[[Any, Any, Array], Any], arrays: Any, zero: Any, total: int, used: Array) -> Any:
    """`one(arrays, sums, chunk)` for chunks 0 ... total-1 in nested scans, whose groups are skipped from `used` on.

    arrays: a tree of all that `one` works with. The chunks are shared out over devices. In reverse mode each
    group is computed again rather than stored.
    """

    def chunks_from(inputs: Any, first: Array | int, stride: int) -> Any:
        arrays, zero, used = inputs
        count = -(-total // stride)
        depth = max(1, math.ceil(math.log(max(count, 1), FEW)))
        group = math.ceil(round(count ** (1.0 / depth), 9))

        def scanned(carry: Any, start: Array | int, level: int) -> Any:
            # A group of the level, group^level chunks, as one scan over its parts.
            width = group ** (level - 1)
            parts = -(-count // width) if level == depth else group
            return jax.lax.scan(jax.checkpoint(partial(part, level - 1)), carry, start + width * jnp.arange(parts))[0]

        def part(level: int, carry: Any, start: Array) -> tuple[Any, None]:
            chunk = first + stride * start
            if level == 0:
                return one(arrays, carry, chunk), None
            inner = jax.checkpoint(partial(scanned, start=start, level=level))
            return jax.lax.cond(chunk < used, inner, lambda carry: carry, carry), None

        return scanned(zero, 0, depth)

    return devices.sums_of_chunks(chunks_from, (arrays, zero, used))


def _gathered(carry: dict[str, Array], target: Array, part: dict[str, Array]) -> dict[str, Array]:
    result = {}
    for key, array in carry.items():
        if key == "sum":
            result[key] = array.at[target].add(part[key], indices_are_sorted=True, mode="promise_in_bounds")
        elif key == "max":
            result[key] = array.at[target].max(part[key], indices_are_sorted=True, mode="promise_in_bounds")
        else:
            result[key] = array + part[key]
    return result


def _in_reach(boxes: tuple[Array, Array, Array, Array], leaf: Array, block: Array) -> Array:
    centre, width, other, spread = boxes[0][leaf], boxes[1][leaf], boxes[2][block], boxes[3][block]
    gap = jnp.maximum(jnp.abs(centre - other) - width[:, :3] - spread[:, :3], 0.0)
    # NaN counts as within reach.
    return ~((gap * gap).sum(axis=1) > jnp.maximum(width[:, 3], spread[:, 3]) ** 2)


def boxes_of(places: Places, support: float, tiles: Tiles, covered: Array) -> tuple[Array, Array, Array, Array]:
    """Centres (L, 3) and half-widths with the reach beside them (L, 4) of leaves, then the same of blocks.

    Worked out only where the lists do not cover all pairs; zeros otherwise.
    """
    position, h = jax.lax.stop_gradient((places.points[:, :3], places.scalars["smoothing_length"]))
    h = h.astype(position.dtype)

    def boxes() -> tuple[Array, ...]:
        parts = []
        for members in (tiles.slots, tiles.blocks):
            # An empty place takes the position of the first of its group, so that it does not stretch the box.
            members = jnp.where(members < places.empty, members, members[:, :1])
            points = position[members]
            low, high = points.min(axis=1), points.max(axis=1)
            middle = 0.5 * (low + high)
            reach = (support * h)[members].max(axis=1)
            parts += [middle, jnp.concatenate([(high - middle) * (1.0 + 1e-6), reach[:, None]], axis=1)]
        return tuple(parts)

    shapes = [(len(members), width) for members in (tiles.slots, tiles.blocks) for width in (3, 4)]
    return jax.lax.cond(covered, lambda: tuple(jnp.zeros(shape, h.dtype) for shape in shapes), boxes)


def term_sums(
    pairs: Pairs,
    terms: tuple[PairTerm, ...],
    far: bool,
    mass: tuple[Array, Array],
    within: Array | None,
    other: Array,
    virial: bool,
) -> dict[str, Array]:
    """What one chunk adds, {"sum": (C, S, K), "max": (C, S, M), "total": (E, 6)}, in the order of the terms' outputs.

    mass: of targets (C, S) and sources (C, B), float64, zero at empty places; within: pairs to count, or None for all;
    other: pairs of different particles, empty places left out, (C, S, B).
    """
    sums, largest, totals, uneven = [], [], [], None
    for term in terms:
        function = term.far if far and term.far else term.pair
        if far:
            # Leaves are apart, but not from the particle that empty places are copies of.
            pairs.quantities["r"] = jnp.where(other, pairs["r"], 1.0)
        with jax.named_scope("pairs"):
            scalars = arguments(function, pairs)
        with jax.named_scope(f"effect:{term.effect}"):
            values = [jnp.broadcast_to(value, other.shape) for value in function(jnp, *scalars)]
            for output, value in zip(term.outputs, values, strict=True):
                if output.how == "max":
                    counted = other if within is None else other & within
                    # Largest over sources; the square tile may hold empty places, which `other` leaves out.
                    largest.append(jnp.where(counted, value, 0.0).max(axis=2))
                    continue
                value = value if within is None else jnp.where(within, value, 0.0)
                if output.how == "sum":
                    sums.append(weighted(value, mass[1])[:, :, None])
                    continue
                slope = value * pairs.inverse_r
                if output.how == "central":
                    uneven = _uneven(pairs, other) if uneven is None else uneven
                    sums.append(-_drawn(slope, pairs, mass[1], uneven))
                    if virial:
                        totals.append(virial_of(slope, pairs.separation, mass))
                else:
                    sums.append(_outer(slope, pairs, mass[1], str(output.of)))
    result = {}
    if sums:
        result["sum"] = jnp.concatenate(sums, axis=2)
    if largest:
        result["max"] = jnp.stack(largest, axis=2).astype(mass[0].dtype)
    if totals:
        result["total"] = jnp.stack(totals)
    return result


def empty_sums(terms: tuple[PairTerm, ...], tiles: Tiles, virial: bool, dtype: Any) -> dict[str, Array]:
    """Zeros of the shape that `term_sums` are gathered into."""
    shape = tiles.slots.shape
    outputs = [output for term in terms for output in term.outputs]
    counts = {"sum": sum(columns(output) for output in outputs), "max": sum(o.how == "max" for o in outputs)}
    zero = {key: jnp.zeros((*shape, count), dtype) for key, count in counts.items() if count}
    central = sum(output.how == "central" for output in outputs)
    if virial and central:
        zero["total"] = jnp.zeros((central, 6), dtype)
    return zero


def weighted(value: Array, mass: Array) -> Array:
    """sum_j m_j q of a chunk (C, S, B) with the masses of its sources (C, B), in their type."""
    return (value.astype(mass.dtype) * mass[:, None, :]).sum(axis=2)


def _product(matrix: Array, right: Array) -> Array:
    return jnp.einsum("cij,cjk->cik", matrix.astype(right.dtype), right, precision=PRECISION)


def _about_first(pairs: Pairs, name: str, mass: Array) -> tuple[Array, Array]:
    # Vectors of targets and sources relative to the first target, in the type of the masses.
    mine, other = (side[name].astype(mass.dtype) for side in (pairs.targets, pairs.sources))
    return mine - mine[:, :1], other - mine[:, :1]


def moments(slope: Array, mine: Array, other: Array, mass: Array) -> Array:
    """sum_j m_j s (x_i - x_j) of a chunk (C, S, B) as one small matrix product a tile, in the type of the masses.

    Positions of targets (C, S, 3) and sources (C, B, 3) are relative to something nearby.
    """
    weights = mass[:, :, None] * jnp.concatenate([other, jnp.ones_like(other[:, :, :1])], axis=2)
    product = _product(slope, weights)
    return mine * product[:, :, 3:] - product[:, :, :3]


def _uneven(pairs: Pairs, other: Array) -> Array:
    """Whether a tile of the chunk holds a pair so close that differences of sums would lose it: a bool."""
    mine, theirs = (side["position"] - pairs.targets["position"][:, :1] for side in (pairs.targets, pairs.sources))
    widest = jnp.maximum(jnp.abs(mine).max(axis=(1, 2)), jnp.abs(theirs).max(axis=(1, 2)))
    nearest = jnp.where(other & (pairs["r"] > 0.0), pairs["r"], jnp.inf).min(axis=(1, 2))
    return jax.lax.stop_gradient(widest > UNEVEN * nearest).any()


def _drawn(slope: Array, pairs: Pairs, mass: Array, uneven: Array) -> Array:
    # The same sum twice: as matrix products, or pair by pair (slower) where those would not do.
    def by_pairs() -> Array:
        weight = slope.astype(mass.dtype) * mass[:, None, :]
        return jnp.stack([(weight * d.astype(mass.dtype)).sum(axis=2) for d in pairs.separation], axis=2)

    return jax.lax.cond(uneven, by_pairs, lambda: moments(slope, *_about_first(pairs, "position", mass), mass))


def _outer(slope: Array, pairs: Pairs, mass: Array, name: str) -> Array:
    # sum_j m_j s (F_i - F_j) (x) (x_i - x_j), rows of F, expanded into products of sums.
    x, y = _about_first(pairs, "position", mass)
    f, g = _about_first(pairs, name, mass)
    one = jnp.ones_like(y[:, :, :1])
    both = (g[:, :, :, None] * y[:, :, None, :]).reshape(*y.shape[:2], 9)
    product = _product(slope, mass[:, :, None] * jnp.concatenate([one, y, g, both], axis=2))
    total, first, second, third = jnp.split(product, (1, 4, 7), axis=2)
    cross = f[:, :, :, None] * (x * total - first)[:, :, None, :] - second[:, :, :, None] * x[:, :, None, :]
    return cross.reshape(*x.shape[:2], 9) + third


def virial_of(slope: Array, separation: list[Array], mass: tuple[Array, Array]) -> Array:
    """-1/2 sum_i sum_j m_i m_j s (x_i - x_j) (x) (x_i - x_j), six components, pair by pair: a route of its own."""
    weight = -0.5 * slope.astype(mass[0].dtype) * mass[0][:, :, None] * mass[1][:, None, :]
    d = [component.astype(mass[0].dtype) for component in separation]
    of_targets = xla_sums.sums([weight * d[a] * d[b] for a, b in AXES], 2)
    # Of targets first: one sum over all pairs of a chunk takes a third longer on a CPU (measured).
    return jnp.stack([each.sum() for each in jax.lax.optimization_barrier(of_targets)])
