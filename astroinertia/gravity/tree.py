"""The tree of the fast gravity: nodes halved in space, so that they stay compact where particles cluster.

Every node is a contiguous range of particles in the tree's own order. Boxes that fit tightly are halved at the middle
of their longest side; where that parts nothing, or nodes are very deep, by number. Children stand side by side, after
their parent. The tree is cut into tasks, subtrees of about the same size, which threads share out; it is a function
of the positions alone, whatever the number of threads.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from astroinertia.engines.numba_vectors import ENTRY, PART, take, where
from astroinertia.engines.threads import available_threads, share_out

LEAF_SIZE = 48  # most particles in a leaf
PIECES = 8  # about so many subtrees are made apart from each other
TASKS = 64  # about so many are shared out over threads
DEEPEST = 60  # below this level nodes are halved by number
MOST_LEVELS = DEEPEST + 64  # and so no tree has more levels than this
# Seen from a sparse leaf, something dense lies all in one direction, and errors of the leaf's expansion add up: a leaf
# that is less than SPARSE times as dense as a node above it can be split, down to single particles, until the square
# of its width is NARROW times that of this node.
SPARSE, NARROW = 0.6, 0.03


@dataclass(frozen=True, eq=False)
class Tree:
    """Nodes of a binary tree over particles; node 0 is the root.

    order (N,): position[order] is node after node; first, last (nodes,): particles of a node in that order; child
    (nodes,): the first of two children, 0 at nodes that are not split; task (T,): nodes that are tasks, which hold all
    particles; begin, end (T,): below task t lie the nodes begin[t] to end[t]-1; top: the nodes above tasks, ascending;
    leaf_size: nodes of no more particles are leaves, which attract each other particle by particle, even where they can
    be split.
    """

    order: np.ndarray
    first: np.ndarray
    last: np.ndarray
    child: np.ndarray
    task: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    top: np.ndarray
    leaf_size: int

    @property
    def count(self) -> int:
        """Number of nodes."""
        return len(self.first)

    @property
    def parent(self) -> np.ndarray:
        """Of each node; the root is its own."""
        return _parents(self.child)


def tree(position: Any, leaf_size: int = LEAF_SIZE, threads: int | None = None) -> Tree:
    """The tree over positions (N, 3) with at most leaf_size particles in a leaf.

    Raises ValueError for no particles or other shapes. Tested in tests/unit/gravity/test_multipole.py.
    """
    position = np.ascontiguousarray(position, dtype=np.float64)
    if position.ndim != 2 or position.shape[1] != 3 or len(position) < 1 or leaf_size < 1:
        raise ValueError(
            f"a tree needs positions of shape (N, 3) and leaves of at least 1, not {position.shape} and {leaf_size}"
        )
    count, threads = len(position), threads or available_threads()
    rows, spare = np.empty((2, count, 4))  # x, y, z and the number of each particle, which move together
    rows[:, :3], rows[:, 3] = position, np.arange(count)
    top = np.empty((4, 2 * min(count, 8 * PIECES) + 2 * MOST_LEVELS), np.int64)  # first, last, child, level
    top[:, 0] = 0, count, 0, 0
    denser = np.zeros((top.shape[1], MOST_LEVELS, 2))
    filled = _split(rows, spare, top, max(leaf_size, count // PIECES), denser, False)
    piece = np.flatnonzero(top[2, :filled] == 0)
    piece = piece[np.argsort(top[0, piece])]
    below = np.empty((4, 2 * count), np.int64)
    sizes = np.zeros(len(piece), np.int64)
    share_out(_split_pieces, threads, rows, spare, top, piece, denser, below, sizes, leaf_size)
    starts = filled + np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    nodes = np.empty((3, starts[-1]), np.int64)
    nodes[:, :filled] = top[:3, :filled]
    for t, node in enumerate(piece):
        start = 2 * top[0, node]
        nodes[:, starts[t] : starts[t + 1]] = below[:3, start : start + sizes[t]]
        children = nodes[2, starts[t] : starts[t + 1]]
        children[children > 0] += starts[t] - 1
        nodes[2, node] = starts[t] if sizes[t] else 0
    first, last, child = nodes[0], nodes[1], nodes[2].astype(np.int32)
    task, begin, end, above = _tasks(first, last, child, leaf_size)
    return Tree(rows[:, 3].astype(np.int64), first, last, child, task, begin, end, above, leaf_size)


def box(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The corners (3,) of the box around positions (N, 3)."""
    low, high = np.empty(3), np.empty(3)
    _extents(position, 0, len(position), low, high)
    return low, high


def _parents(child: np.ndarray) -> np.ndarray:
    parent = np.zeros(len(child), np.int32)
    inner = np.flatnonzero(child)
    parent[child[inner]] = inner
    parent[child[inner] + 1] = inner
    return parent


def _tasks(
    first: np.ndarray, last: np.ndarray, child: np.ndarray, leaf_size: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    # The largest nodes that are small enough, what lies below each, which stands together, and what lies above.
    small = last - first <= max(leaf_size, last[0] // TASKS)
    above = ~small[_parents(child)]
    above[0] = True
    task = np.flatnonzero(small & above)
    task = task[np.argsort(first[task])]
    leaves = np.sort(first[child == 0])
    below = np.searchsorted(leaves, last[task]) - np.searchsorted(leaves, first[task])
    return task, child[task], child[task] + 2 * below - 2, np.flatnonzero(~small)


@njit(fastmath={"nsz"}, **ENTRY)
def _extents(rows, first, last, low, high):
    # Side by side, as vectors have them; NaN is left out.
    low_x = low_y = low_z = np.inf
    high_x = high_y = high_z = -np.inf
    for k in range(first, last):
        x, y, z = rows[k, 0], rows[k, 1], rows[k, 2]
        low_x, high_x = where(x < low_x, x, low_x), where(x > high_x, x, high_x)
        low_y, high_y = where(y < low_y, y, low_y), where(y > high_y, y, high_y)
        low_z, high_z = where(z < low_z, z, low_z), where(z > high_z, z, high_z)
    low[0], low[1], low[2] = low_x, low_y, low_z
    high[0], high[1], high[2] = high_x, high_y, high_z


@njit(**PART)
def _partition(rows, spare, axis, first, last, middle):
    # What is below the middle comes first, in its order, without a branch; NaN counts as above.
    place, above = first, first
    for k in range(first, last):
        x, y, z, number = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
        below = np.int64(rows[k, axis] <= middle)
        rows[place, 0], rows[place, 1], rows[place, 2], rows[place, 3] = x, y, z, number
        spare[above, 0], spare[above, 1], spare[above, 2], spare[above, 3] = x, y, z, number
        place += below
        above += 1 - below
    for k in range(above - first):
        for a in range(4):
            rows[place + k, a] = spare[first + k, a]
    return place


@njit(**ENTRY)
def _exposed(path, level, density, width2):
    # Whether a node above is much denser, and not much wider.
    exposed = False
    for k in range(level):
        exposed |= density < SPARSE * path[k, 0] and width2 > NARROW * path[k, 1]
    return exposed


@njit(**ENTRY)
def _split(rows, spare, nodes, leaf_size, above, further):
    # Splits node 0 and all below it; children of the node in column k are numbered by their columns.
    # above[k]: density and squared width of the nodes above node k, by their levels; of all nodes, or of node 0 alone
    # where exposed leaves are split further.
    low, high = np.empty(3), np.empty(3)
    stack = np.empty(2 * MOST_LEVELS, np.int64)
    stack[0] = 0
    height = filled = 1
    room = nodes.shape[1]
    path = np.empty((above.shape[1], above.shape[2]))
    for k in range(len(path)):
        path[k, 0], path[k, 1] = above[0, k, 0], above[0, k, 1]
    while height > 0:
        height -= 1
        node = stack[height]
        first, last, level = nodes[0, node], nodes[1, node], nodes[3, node]
        nodes[2, node] = 0
        if not further:
            for k in range(level):  # by number: numba takes seconds to compile the same of slices and rows
                above[node, k, 0], above[node, k, 1] = path[k, 0], path[k, 1]
        if last - first <= (1 if further else leaf_size) or filled + 2 > room:
            continue
        axis, longest, middle, width2 = 0, -1.0, 0.0, 0.0
        _extents(rows, first, last, low, high)
        for a in range(3):
            width = high[a] - low[a]
            width2 += width**2
            if width > longest:
                axis, longest, middle = a, width, low[a] + 0.5 * width
        density = (last - first) / max(width2, 1e-300) ** 1.5
        if last - first <= leaf_size and not _exposed(path, level, density, width2):
            continue
        path[level, 0], path[level, 1] = density, width2
        cut = first
        if longest > 0.0 and level < DEEPEST:
            cut = _partition(rows, spare, axis, first, last, middle)
        if cut <= first or cut >= last:
            cut = (first + last) // 2
        nodes[0, filled], nodes[1, filled], nodes[3, filled] = first, cut, level + 1
        nodes[0, filled + 1], nodes[1, filled + 1], nodes[3, filled + 1] = cut, last, level + 1
        nodes[2, node] = filled
        stack[height], stack[height + 1] = filled + 1, filled
        height += 2
        filled += 2
    return filled


@njit(**ENTRY)
def _split_pieces(counter, rows, spare, top, piece, above, below, sizes, leaf_size):
    while True:
        t = take(counter)
        if t >= len(piece):
            break
        node = piece[t]
        begin, end = 2 * top[0, node], 2 * top[1, node]
        part = below[:, begin:end]
        part[0, 0], part[1, 0], part[3, 0] = top[0, node], top[1, node], top[3, node]
        filled = _split(rows, spare, part, leaf_size, above[node : node + 1], True)
        sizes[t] = filled - 1
        for a in range(4):
            for k in range(1, filled):
                part[a, k - 1] = part[a, k]
