"""A balanced binary tree over particles: how both engines sort particles into compact leaves.

The tree is an implicit heap with nodes 1 ... 2L-1 (row 0 of node arrays is unused): the root is 1, the children of
node k are 2k and 2k+1, and leaf l is node L + l, with L = 2^depth leaves. Particles are stored leaf after leaf, so that
every node is a contiguous range of particles. Leaf sizes differ by at most one. Only the order and `Leaves` are fixed
by the particles; boxes are refitted to wherever the particles are now.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numba import njit

from astroinertia.engines.few import FEW
from astroinertia.engines.numba_vectors import ENTRY, LANES, PART, take
from astroinertia.engines.threads import available_threads, share_out

SHARE = 64  # leaves that a thread takes at a time
AT_ONCE = 6  # levels at the top of a tree whose nodes are so few that all of them are filled in one go
ALONE = 1024  # leaves below which one thread is sooner done than others are started
# What numba keeps compiled for this file does not notice changes of numba_vectors: change something here, too.


@dataclass(frozen=True)
class Leaves:
    """The leaves of a balanced tree: leaf l holds particles start[l] to start[l+1]-1 of the arranged order.

    start: (L+1,) int64; depth: L = 2^depth.
    """

    start: np.ndarray
    depth: int

    @property
    def count(self) -> int:
        """Number of leaves."""
        return len(self.start) - 1


def balanced_leaves(particles: int, leaf_size: int) -> Leaves:
    """Leaves of at most leaf_size (and at least about half as many) particles: the fewest levels that allow it."""
    if particles < 1 or leaf_size < 1:
        raise ValueError(f"a tree needs particles and a leaf size of at least 1, not {particles} and {leaf_size}")
    depth = 0
    while -(-particles >> depth) > leaf_size:  # ceiling of particles / 2^depth
        depth += 1
    return Leaves((np.arange(2**depth + 1, dtype=np.int64) * particles) >> depth, depth)


def arrange(position: np.ndarray, leaf_size: int, threads: int | None = None) -> tuple[np.ndarray, Leaves]:
    """Sort particles into leaves by median splits along the longest side of each node's box.

    position (N, 3). Returns order (N,) int64, such that position[order] is leaf after leaf, and the leaves. The order
    is a function of the positions alone, whatever the number of threads. NaN positions are carried along.
    """
    position = np.ascontiguousarray(position, dtype=np.float64)
    if position.ndim != 2 or position.shape[1] != 3:
        raise ValueError(f"positions must have shape (N, 3), not {position.shape}")
    leaves = balanced_leaves(len(position), leaf_size)
    order = np.arange(len(position), dtype=np.int64)
    if len(position) <= FEW:
        _split_few(position, order, leaves)
        return order, leaves
    threads = threads or available_threads()
    top = min(leaves.depth, (4 * threads - 1).bit_length() if threads > 1 else 0)
    _split_levels(position, order, 0, 0, top)
    share_out(_split_subtrees, threads, position, order, top, leaves.depth)
    return order, leaves


def _split_few(position: np.ndarray, order: np.ndarray, leaves: Leaves) -> None:
    """What `_split_levels` does, without a program to compile; each half is sorted besides."""
    for level in range(leaves.depth):
        edges = leaves.start[:: 1 << (leaves.depth - level)]
        for first, last in pairwise(edges):
            held = order[first:last]
            place = position[held]
            with np.errstate(invalid="ignore"):
                axis = np.argmax(np.ptp(place, axis=0))
            held[:] = held[np.argsort(place[:, axis], kind="stable")]


@dataclass(frozen=True)
class Nodes:
    """What is refitted at every pass, in rows with room for one more vector at their ends.

    columns (4, N + LANES): x, y, z and one more value of each particle; rows (7, 2L + LANES): the low and high corners
    of the box of each node, and the largest of that value in it.
    """

    columns: np.ndarray
    rows: np.ndarray


def fit(
    leaves: Leaves, position: np.ndarray, values: np.ndarray, threads: int | None = None, among: int = 0
) -> Nodes:  # fmt: skip
    """Boxes of all nodes and their largest value, from position (N, 3) and values (N,) in arranged order.

    A particle that has NaN makes NaN of the boxes, or largest values, of all nodes above it. among: particles of the
    body that these are part of: few of many are fitted by the program that the many have.
    """
    position = np.ascontiguousarray(position, dtype=np.float64)
    values = np.ascontiguousarray(values, dtype=np.float64)
    columns = np.empty((4, len(position) + LANES))
    rows = np.zeros((7, 2 * leaves.count + LANES))
    columns[:, len(position) :] = 0.0
    if max(len(position), among) <= FEW:
        _fit_few(leaves, position, values, columns, rows)
    elif leaves.count < ALONE:
        share_out(_fit_tree, 1, leaves.start, position, values, columns, rows)
        return Nodes(columns, rows)
    else:
        share_out(_fit_leaves, threads or available_threads(), leaves.start, position, values, columns, rows)
    for level in range(leaves.depth - 1, AT_ONCE - 1, -1):
        below = rows[:, 2 << level : 4 << level]
        one, other, here = below[:, ::2], below[:, 1::2], rows[:, 1 << level : 2 << level]
        np.minimum(one[:3], other[:3], out=here[:3])
        np.maximum(one[3:], other[3:], out=here[3:])
    if top := min(leaves.depth, AT_ONCE):
        here, below, ranges = rows[:, 1 : 1 << top], rows[:, 1 << top :], _ranges_below(top)
        here[:3] = np.minimum.reduceat(below[:3], ranges, axis=1)[:, ::2]
        here[3:] = np.maximum.reduceat(below[3:], ranges, axis=1)[:, ::2]
    return Nodes(columns, rows)


@lru_cache(maxsize=AT_ONCE)
def _ranges_below(depth: int) -> np.ndarray:
    """The nodes of the level `depth`, first and last + 1, below each of the nodes 1 ... 2^depth-1 in turn."""
    node = np.arange(1, 1 << depth)
    level = np.repeat(np.arange(depth), 1 << np.arange(depth))
    first, width = (node << (depth - level)) - (1 << depth), 1 << (depth - level)
    return np.stack([first, first + width], axis=1).ravel()


def _fit_few(
    leaves: Leaves, position: np.ndarray, values: np.ndarray, columns: np.ndarray, rows: np.ndarray
) -> None:  # fmt: skip
    """What `_fit_leaves` does, without a program to compile; it takes no longer for few particles."""
    count, begin = leaves.count, leaves.start[:-1]
    columns[:3, : len(position)], columns[3, : len(position)] = position.T, values
    held = columns[:, : len(position)]
    np.minimum.reduceat(held[:3], begin, axis=1, out=rows[:3, count : 2 * count])
    np.maximum.reduceat(held, begin, axis=1, out=rows[3:, count : 2 * count])


def boxes(leaves: Leaves, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounding boxes of all nodes, position (N, 3) in arranged order: (lo, hi), each (2L, 3); NaN spreads upward."""
    rows = fit(leaves, position, np.zeros(len(position))).rows[:, : 2 * leaves.count]
    return np.ascontiguousarray(rows[:3].T), np.ascontiguousarray(rows[3:6].T)


def largest(leaves: Leaves, values: np.ndarray) -> np.ndarray:
    """Largest of a per-particle value (N,), in arranged order, in every node: (2L,); NaN spreads upward."""
    return fit(leaves, np.zeros((len(values), 3)), values).rows[6, : 2 * leaves.count].copy()


@njit(**PART)
def _select(key, item, middle):
    # Hoare's selection: afterwards key[:middle] <= key[middle:]. NaN compares false, which stops both scans.
    left, right = 0, len(key) - 1
    while left < right:
        a, b, c = key[left], key[(left + right) // 2], key[right]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = left, right
        while i <= j:
            while i < right and key[i] < pivot:
                i += 1
            while j > left and pivot < key[j]:
                j -= 1
            if i <= j:
                key[i], key[j] = key[j], key[i]
                item[i], item[j] = item[j], item[i]
                i += 1
                j -= 1
        if middle <= j:
            right = j
        elif middle >= i:
            left = i
        else:
            return


@njit(**PART)
def _split_node(position, order, first, middle, last):
    axis, longest = 0, -1.0
    for a in range(3):
        low = high = position[order[first], a]
        for k in range(first + 1, last):
            x = position[order[k], a]
            low = min(low, x)
            high = max(high, x)
        if high - low > longest:
            axis, longest = a, high - low
    key = np.empty(last - first)
    for k in range(first, last):
        key[k - first] = position[order[k], axis]
    _select(key, order[first:last], middle - first)


@njit(**ENTRY)
def _split_levels(position, order, root, top, depth):
    # All splits below one node of level `top`, down to the leaves' level `depth`.
    particles = len(order)
    for level in range(top, depth):
        below = level - top
        for node in range(root << below, (root + 1) << below):
            first = (node * particles) >> level
            middle = ((2 * node + 1) * particles) >> (level + 1)
            last = ((node + 1) * particles) >> level
            _split_node(position, order, first, middle, last)


@njit(**ENTRY)
def _split_subtrees(counter, position, order, top, depth):
    while True:
        root = take(counter)
        if root >= 1 << top:
            break
        _split_levels(position, order, root, top, depth)


@njit(**PART)
def _fit_leaf(position, values, columns, first, last, node, rows):
    for a in range(4):
        column = columns[a]
        low, high, unknown = np.inf, -np.inf, 0.0
        for j in range(first, last):
            x = position[j, a] if a < 3 else values[j]
            column[j] = x
            low = x if x < low else low
            high = x if x > high else high
            unknown += x if np.isnan(x) else 0.0
        if a < 3:
            rows[a, node] = low + unknown
        rows[3 + a, node] = high + unknown


@njit(**ENTRY)
def _fit_tree(counter, start, position, values, columns, rows):
    count = len(start) - 1
    for leaf in range(count):
        _fit_leaf(position, values, columns, start[leaf], start[leaf + 1], count + leaf, rows)
    for node in range(count - 1, 0, -1):
        for a in range(7):
            one, other = rows[a, 2 * node], rows[a, 2 * node + 1]
            first = (one < other) if a < 3 else (one > other)
            rows[a, node] = one if first or np.isnan(one) else other


@njit(**ENTRY)
def _fit_leaves(counter, start, position, values, columns, rows):
    count = len(start) - 1
    while True:
        begin = SHARE * take(counter)
        if begin >= count:
            break
        for leaf in range(begin, min(begin + SHARE, count)):
            _fit_leaf(position, values, columns, start[leaf], start[leaf + 1], count + leaf, rows)
