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

from astroinertia.engines.numba_vectors import ENTRY, take
from astroinertia.engines.threads import available_threads, share_out

LEAF_SIZE = 48  # most particles in a leaf
TASKS = 64  # about so many subtrees are shared out over threads
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
    particles; begin (T+1,): below task t lie the nodes begin[t] to begin[t+1]-1, and before begin[0] the tasks and what
    is above them; leaf_size: nodes of no more particles are leaves, which attract each other particle by particle, even
    where they can be split.
    """

    order: np.ndarray
    first: np.ndarray
    last: np.ndarray
    child: np.ndarray
    task: np.ndarray
    begin: np.ndarray
    leaf_size: int

    @property
    def count(self) -> int:
        """Number of nodes."""
        return len(self.first)


def tree(position: Any, leaf_size: int = LEAF_SIZE, threads: int | None = None) -> Tree:
    """The tree over positions (N, 3) with at most leaf_size particles in a leaf; coherent orders are sorted sooner.

    Raises ValueError for no particles or other shapes. Tested in tests/unit/gravity/test_multipole.py.
    """
    position = np.ascontiguousarray(position, dtype=np.float64)
    if position.ndim != 2 or position.shape[1] != 3 or len(position) < 1 or leaf_size < 1:
        raise ValueError(
            f"a tree needs positions of shape (N, 3) and leaves of at least 1, not {position.shape} and {leaf_size}"
        )
    count, threads = len(position), threads or available_threads()
    columns = np.ascontiguousarray(position.T)
    order = np.arange(count, dtype=np.int64)
    smallest = max(leaf_size, count // TASKS)
    top = np.empty((4, 2 * min(count, 8 * TASKS) + 2 * MOST_LEVELS), np.int64)  # first, last, child, level
    top[:, 0] = 0, count, 0, 0
    above = np.zeros((top.shape[1], MOST_LEVELS, 2))
    filled = _split(columns, order, top, smallest, above, False)
    task = np.flatnonzero(top[2, :filled] == 0)
    task = task[np.argsort(top[0, task])]
    below = np.empty((4, 2 * count), np.int64)
    sizes = np.zeros(len(task), np.int64)
    share_out(_split_tasks, threads, columns, order, top, task, above, below, sizes, leaf_size)
    begin = filled + np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    nodes = np.empty((3, begin[-1]), np.int64)
    nodes[:, :filled] = top[:3, :filled]
    for t, node in enumerate(task):
        start = 2 * top[0, node]
        part = below[:3, start : start + sizes[t]]
        nodes[:, begin[t] : begin[t + 1]] = part
        children = nodes[2, begin[t] : begin[t + 1]]
        children[children > 0] += begin[t] - 1
        nodes[2, node] = begin[t] if sizes[t] else 0
    return Tree(order, nodes[0], nodes[1], nodes[2].astype(np.int32), task, begin, leaf_size)


@njit(**ENTRY)
def _extent(column, first, last):
    low, high = np.inf, -np.inf
    for k in range(first, last):
        x = column[k]
        low = x if x < low else low
        high = x if x > high else high
    return low, high


@njit(**ENTRY)
def _partition(x, y, z, order, key, first, last, middle):
    # What is below the middle comes first; NaN counts as above.
    i, j = first, last - 1
    while True:
        while i <= j and key[i] <= middle:
            i += 1
        while i <= j and not key[j] <= middle:
            j -= 1
        if i > j:
            return i
        x[i], x[j] = x[j], x[i]
        y[i], y[j] = y[j], y[i]
        z[i], z[j] = z[j], z[i]
        order[i], order[j] = order[j], order[i]


@njit(**ENTRY)
def _exposed(path, level, density, width2):
    # Whether a node above is much denser, and not much wider.
    exposed = False
    for k in range(level):
        exposed |= density < SPARSE * path[k, 0] and width2 > NARROW * path[k, 1]
    return exposed


@njit(**ENTRY)
def _split(columns, order, nodes, leaf_size, above, further):
    # Splits node 0 and all below it; children of the node in column k are numbered by their columns.
    # above[k]: density and squared width of the nodes above node k, by their levels; of all nodes, or of node 0 alone
    # where exposed leaves are split further.
    x, y, z = columns[0], columns[1], columns[2]
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
        for a in range(3):
            low, high = _extent(columns[a], first, last)
            width2 += (high - low) ** 2
            if high - low > longest:
                axis, longest, middle = a, high - low, low + 0.5 * (high - low)
        density = (last - first) / max(width2, 1e-300) ** 1.5
        if last - first <= leaf_size and not _exposed(path, level, density, width2):
            continue
        path[level, 0], path[level, 1] = density, width2
        cut = first
        if longest > 0.0 and level < DEEPEST:
            cut = _partition(x, y, z, order, columns[axis], first, last, middle)
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
def _split_tasks(counter, columns, order, top, task, above, below, sizes, leaf_size):
    while True:
        t = take(counter)
        if t >= len(task):
            break
        node = task[t]
        begin, end = 2 * top[0, node], 2 * top[1, node]
        part = below[:, begin:end]
        part[0, 0], part[1, 0], part[3, 0] = top[0, node], top[1, node], top[3, node]
        filled = _split(columns, order, part, leaf_size, above[node : node + 1], True)
        sizes[t] = filled - 1
        for a in range(4):
            for k in range(1, filled):
                part[a, k - 1] = part[a, k]
