"""Which tiles of particles the xla engine works on: made on the host, carried into compiled code as arrays.

A tile is a leaf of targets against a block of sources. The neighbour list holds, leaf after leaf, blocks of just those
particles that can come within reach; sums over all pairs use larger leaves, split into near and far pairs of leaves.
The lists hold for as long as every particle stays within the margins of motion and growth (`covers`); compiled code
checks that for itself, and goes through all tiles, culled by their boxes, where it does not hold. So a list that is
out of date costs time and never a pair.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import jax.numpy as jnp
import numpy as np
from numba import njit

from astroinertia.engines import tree
from astroinertia.engines.numba_vectors import ENTRY
from astroinertia.engines.pytree import pytree
from astroinertia.engines.threads import available_threads

LEAF, BLOCK = 8, 32  # targets, and sources that they meet at once
MOST_WIDE_LEAVES = 2048  # whose pairs are listed all
TASKS = 64  # ranges of leaves that threads share out


@pytree
@dataclass(frozen=True)
class Tiles:
    """Leaves of targets (L, S) and the tiles that they take part in; particle number N stands for an empty place.

    slots: (L, S) particles of each leaf; row, column: (N,) where each particle is.
    leaf: (chunks, C) target leaf of each listed tile; sources: (chunks, C, B) particles of each, or (chunks, C, 1) the
    number of a block of `blocks`; used: number of chunks that hold tiles.
    blocks: (M + 1, B) consecutive particles, what all tiles together are made of, and one empty block. patch: how many
    leaves and blocks make the C tiles of a chunk when all tiles are visited.
    """

    slots: Any
    row: Any
    column: Any
    leaf: Any
    sources: Any
    used: Any
    blocks: Any
    by_block: bool = field(metadata={"static": True})
    patch: tuple[int, int] = field(metadata={"static": True})


@dataclass(frozen=True)
class Reach:
    """How far lists reach: `support` smoothing lengths, with margins.

    A particle may move by `motion` of its own reach, and its smoothing length may grow by the fraction `growth`.
    """

    support: float
    motion: float
    growth: float


@pytree
@dataclass(frozen=True)
class Arrangement:
    """Tiles for neighbours, and for near and far pairs of leaves.

    position (N, 3), smoothing_length (N,): what they were made for. longest (N,): smoothing lengths are not solved for
    beyond these, which are infinite but for a caller that looks whether any has come there (`Engine.held`).
    """

    neighbours: Tiles
    near: Tiles
    far: Tiles
    position: Any
    smoothing_length: Any
    longest: Any
    reach: Reach = field(metadata={"static": True})


def arrange(
    position: np.ndarray,
    smoothing_length: np.ndarray,
    margins: Reach,
    wide_leaf: int,
    pairs_in_chunk: int,
) -> tuple[np.ndarray, Arrangement]:
    """Sort particles (N, 3) into leaves and list tiles; smoothing lengths (N,) give the reach.

    Returns the order (N,) and the arrangement of the particles in that order.
    """
    order, leaves = tree.arrange(position, LEAF)
    position = np.ascontiguousarray(position[order], dtype=np.float64)
    smoothing_length = np.ascontiguousarray(smoothing_length[order], dtype=np.float64)
    reach = margins.support * smoothing_length * (1.0 + margins.growth) * (1.0 + 2.0 * margins.motion)
    wide = tree.balanced_leaves(len(position), max(LEAF, wide_leaf, -(-len(position) // MOST_WIDE_LEAVES)))
    near, far = _wide_tiles(wide, position, reach, pairs_in_chunk)
    return order, Arrangement(
        neighbours=_neighbour_tiles(leaves, position, reach, BLOCK, pairs_in_chunk),
        near=near,
        far=far,
        position=jnp.asarray(position),
        smoothing_length=jnp.asarray(smoothing_length),
        longest=jnp.full(len(position), jnp.inf),
        reach=margins,
    )


def covers(xp: Any, arrangement: Arrangement, position: Any, smoothing_length: Any) -> Any:
    """Whether the lists hold every pair within reach at these positions (N, 3) and smoothing lengths (N,): a bool.

    A motion that all particles share does not count.
    """
    listed, margins = xp.asarray(arrangement.smoothing_length), arrangement.reach
    moved = position - xp.asarray(arrangement.position)
    moved = moved - moved.mean(axis=0, keepdims=True)
    allowed = margins.motion * margins.support * listed
    steady = (moved * moved).sum(axis=1) <= allowed * allowed
    return xp.all(steady & (smoothing_length <= (1.0 + margins.growth) * listed))


def holds(arrangement: Arrangement, position: Any, smoothing_length: Any, support: float) -> Any:
    """The same for a kernel of that support, on the device."""
    return covers(jnp, arrangement, position, smoothing_length) & (support <= arrangement.reach.support)


def device(array: Any) -> Any:
    """Numbers of particles, leaves and tiles as compiled sums have them."""
    return jnp.asarray(array, dtype=jnp.int32)


def _slots(leaves: tree.Leaves) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    start, count = leaves.start, int(leaves.start[-1])
    sizes = np.diff(start)
    column = np.arange(count) - np.repeat(start[:-1], sizes)
    row = np.repeat(np.arange(leaves.count), sizes)
    slots = np.full((leaves.count, sizes.max()), count)
    slots[row, column] = np.arange(count)
    return slots, row, column


def _tiles(
    leaves: tree.Leaves, leaf: np.ndarray, sources: np.ndarray, blocks: np.ndarray, patch: tuple[int, int]
) -> Tiles:
    # Empty tiles at the end fill the last chunk; they belong to the last leaf, which keeps leaves in ascending order.
    slots, row, column = _slots(leaves)
    by_block = sources.shape[1] == 1
    empty = len(blocks) if by_block else int(leaves.start[-1])
    chunk = patch[0] * patch[1]
    used = -(-len(leaf) // chunk)
    # Up to a power of two, so that lists of similar length share one compiled program; unused chunks are skipped.
    total = chunk << (used - 1).bit_length() if used else 0
    padded_leaf = np.full(total, leaves.count - 1, np.int32)
    padded_leaf[: len(leaf)] = leaf
    padded_sources = np.full((total, sources.shape[1]), empty, np.int32)
    padded_sources[: len(leaf)] = sources
    whole = np.concatenate([blocks, np.full((1, blocks.shape[1]), int(leaves.start[-1]))])

    return Tiles(
        slots=device(slots),
        row=device(row),
        column=device(column),
        leaf=device(padded_leaf.reshape(-1, chunk)),
        sources=device(padded_sources.reshape(-1, chunk, sources.shape[1])),
        used=device(np.asarray(used)),
        blocks=device(whole),
        by_block=by_block,
        patch=patch,
    )


def _patch(pairs_in_chunk: int, targets: int, sources: int, leaves: int, blocks: int) -> tuple[int, int]:
    tiles = max(1, min(pairs_in_chunk // (targets * sources), leaves * blocks))
    tall = min(int(tiles**0.5), leaves)
    return tall, min(tiles // tall, blocks)


def _neighbour_tiles(
    leaves: tree.Leaves, position: np.ndarray, reach: np.ndarray, block: int, pairs_in_chunk: int
) -> Tiles:
    count = len(position)
    lo, hi = tree.boxes(leaves, position)
    node_reach = tree.largest(leaves, reach)
    ends = np.unique(np.linspace(0, leaves.count, TASKS + 1).astype(np.int64))

    def listed(task: int) -> tuple[np.ndarray, np.ndarray]:
        begin, end = ends[task], ends[task + 1]
        capacity = 2 * (end - begin)
        while True:
            leaf, sources = np.empty(capacity, np.int32), np.empty((capacity, block), np.int32)
            used = _list_blocks(position, reach, lo, hi, node_reach, leaves.start, begin, end, leaf, sources)
            if used <= capacity:
                return leaf[:used], sources[:used]
            capacity = used

    with ThreadPoolExecutor(available_threads()) as pool:
        lists = list(pool.map(listed, range(len(ends) - 1)))
    leaf, sources = (np.concatenate([pair[k] for pair in lists]) for k in range(2))
    everything = np.full(-(-count // block) * block, count)
    everything[:count] = np.arange(count)
    targets = int(np.diff(leaves.start).max())
    blocks = everything.reshape(-1, block)
    patch = _patch(pairs_in_chunk, targets, block, leaves.count, len(blocks))
    return _tiles(leaves, leaf, sources, blocks, patch)


@njit(**ENTRY)
def _out_of_reach(low, high, lower, upper, reach):
    # NaN is never out of reach.
    squared = 0.0
    for a in range(3):
        gap = max(lower[a] - high[a], low[a] - upper[a])
        if gap > 0.0:
            squared += gap * gap
    return squared > reach * reach


@njit(**ENTRY)
def _list_blocks(position, reach, lo, hi, node_reach, start, begin, end, leaf, sources):
    # Of leaves begin ... end-1: fills leaf and sources as far as they go, and returns how many blocks there are.
    leaves, block, empty = len(start) - 1, sources.shape[1], len(position)
    stack = np.empty(128, np.int64)
    used = 0
    for target in range(begin, end):
        low, high, mine = lo[leaves + target], hi[leaves + target], node_reach[leaves + target]
        place = block
        stack[0] = 1
        top = 1
        while top > 0:
            top -= 1
            node = stack[top]
            if _out_of_reach(low, high, lo[node], hi[node], max(mine, node_reach[node])):
                continue
            if node < leaves:
                stack[top] = 2 * node + 1
                stack[top + 1] = 2 * node
                top += 2
                continue
            for j in range(start[node - leaves], start[node - leaves + 1]):
                if _out_of_reach(low, high, position[j], position[j], max(mine, reach[j])):
                    continue
                if place == block:
                    place = 0
                    used += 1
                    if used <= len(leaf):
                        leaf[used - 1] = target
                        sources[used - 1] = empty
                if used <= len(leaf):
                    sources[used - 1, place] = j
                place += 1
    return used


def _wide_tiles(
    leaves: tree.Leaves, position: np.ndarray, reach: np.ndarray, pairs_in_chunk: int
) -> tuple[Tiles, Tiles]:
    lo, hi = (bound[leaves.count :] for bound in tree.boxes(leaves, position))
    leaf_reach = tree.largest(leaves, reach)[leaves.count :]
    near, far = [], []
    for a in range(leaves.count):
        gap = np.maximum(np.maximum(lo - hi[a], lo[a] - hi), 0.0)
        # Written so that NaN counts as near.
        apart = (gap * gap).sum(axis=1) > np.maximum(leaf_reach, leaf_reach[a]) ** 2
        near.append(np.flatnonzero(~apart))
        far.append(np.flatnonzero(apart))
    slots, _, _ = _slots(leaves)
    patch = _patch(pairs_in_chunk, slots.shape[1], slots.shape[1], leaves.count, leaves.count)

    def tiles(lists: list[np.ndarray]) -> Tiles:
        leaf = np.repeat(np.arange(leaves.count), [len(entry) for entry in lists])
        return _tiles(leaves, leaf, np.concatenate(lists)[:, None], slots, patch)

    return tiles(near), tiles(far)
