"""The tree of fast gravity on dense tiles: nodes halved near the middle of their boxes, every leaf full.

Tiles cost the same however many of their places are taken, so that leaves hold leaf_size particles each, only the last
one fewer. A node of n leaves is split at the whole number of leaves nearest to the middle of its box's longest side:
nodes are as compact as that allows. Where particles are few and far between, a full leaf would be too wide for the
field of everything else to be expanded in it: those leaves are cut into 2, 4, 8 or 16. Node numbers run down the left
side first: the left child of node a is a + 1.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from astroinertia.engines.numba_vectors import ENTRY, take
from astroinertia.engines.threads import available_threads, share_out
from astroinertia.engines.tree import _select, _split_node

TASKS = 64  # subtrees that threads share out
MOST_CUTS = 4


@dataclass(frozen=True, eq=False)
class Tree:
    """Nodes over leaves of at most leaf_size particles; position[order] is leaf after leaf.

    order (N,); start (L+1,): where each leaf begins; first, last (nodes,): the leaves first to last-1 below a node;
    right (nodes,): the right child, 0 at leaves.
    """

    order: np.ndarray
    start: np.ndarray
    first: np.ndarray
    last: np.ndarray
    right: np.ndarray

    @property
    def leaves(self) -> int:
        """Number of leaves."""
        return int(self.last[0])


def tree(position: np.ndarray, leaf_size: int, widest: np.ndarray, threads: int | None = None) -> Tree:
    """The tree over positions (N, 3), with leaves not much wider than `widest` (N,), whatever the number of threads.

    Tested by tests/unit/gravity/test_multipole_xla.py.
    """
    position = np.ascontiguousarray(position, dtype=np.float64)
    count, threads = len(position), threads or available_threads()
    leaves = -(-count // leaf_size)
    order = np.arange(count, dtype=np.int64)
    first, last = np.zeros(2 * leaves - 1, np.int64), np.zeros(2 * leaves - 1, np.int64)
    right = np.zeros(2 * leaves - 1, np.int64)
    last[0] = leaves
    task = np.sort(_part(position, order, first, last, right, leaf_size, 0, max(1, leaves // TASKS)))
    share_out(_part_tasks, threads, position, order, first, last, right, leaf_size, task)
    pieces = np.zeros(leaves, np.int64)
    share_out(_cut_leaves, threads, position, order, widest, leaf_size, pieces)
    return _with_pieces(order, leaf_size, first, right, pieces)


def _with_pieces(order: np.ndarray, leaf_size: int, first: np.ndarray, right: np.ndarray, pieces: np.ndarray) -> Tree:
    # The same tree with leaf l cut into 2^pieces[l] leaves.
    begin = np.concatenate([[0], np.cumsum(1 << pieces)])
    start = np.empty(begin[-1] + 1, np.int64)
    made = np.zeros((3, 2 * begin[-1] - 1), np.int64)
    _renumber(len(order), leaf_size, first, right, pieces, begin, start, *made)
    return Tree(order, start, *made)


@njit(**ENTRY)
def _renumber(count, leaf_size, first, right, pieces, begin, start, new_first, new_last, new_right):
    for leaf in range(len(pieces)):
        low, parts = leaf * leaf_size, 1 << pieces[leaf]
        size = min(low + leaf_size, count) - low
        for k in range(parts):
            start[begin[leaf] + k] = low + (k * size) // parts
    start[-1] = count
    stack = np.empty((256, 4), np.int64)  # old node or -1, new node, leaves below it
    stack[0] = 0, 0, 0, begin[-1]
    height = 1
    while height > 0:
        height -= 1
        old, node, low, high = stack[height]
        new_first[node], new_last[node] = low, high
        if high - low == 1:
            continue
        one, other, middle = -1, -1, (low + high) // 2
        if old >= 0 and right[old]:
            one, other = old + 1, right[old]
            middle = begin[first[other]]
        after = node + 2 * (middle - low)
        new_right[node] = after
        stack[height] = one, node + 1, low, middle
        stack[height + 1] = other, after, middle, high
        height += 2


@njit(**ENTRY)
def _cut_leaves(counter, position, order, widest, leaf_size, pieces):
    while True:
        leaf = take(counter)
        if leaf >= len(pieces):
            break
        low, high = leaf * leaf_size, min((leaf + 1) * leaf_size, len(order))
        squared, limit = 0.0, np.inf
        for a in range(3):
            least, most = np.inf, -np.inf
            for k in range(low, high):
                least, most = min(least, position[order[k], a]), max(most, position[order[k], a])
            squared += (0.5 * (most - least)) ** 2
        for k in range(low, high):
            limit = min(limit, widest[order[k]])
        # Eight pieces have half the width.
        power, width = 0, np.sqrt(squared)
        while width > limit and 2 << power <= high - low and power < MOST_CUTS:
            width *= 0.5 ** (1.0 / 3.0)
            power += 1
        pieces[leaf] = power
        for level in range(power):
            for part in range(1 << level):
                size, parts = high - low, 2 << level
                begin, end = low + (2 * part * size) // parts, low + ((2 * part + 2) * size) // parts
                middle = low + ((2 * part + 1) * size) // parts
                _split_node(position, order, begin, middle, end)


@njit(**ENTRY)
def _part(position, order, first, last, right, leaf_size, root, enough):
    # Parts a node and what is below it into nodes of at most `enough` leaves, and returns those.
    stack, parts = np.empty(256, np.int64), np.empty(last[root] - first[root], np.int64)
    stack[0] = root
    height, count = 1, 0
    while height > 0:
        height -= 1
        node = stack[height]
        leaves = last[node] - first[node]
        if leaves <= enough:
            parts[count] = node
            count += 1
            continue
        begin, end = first[node] * leaf_size, min(last[node] * leaf_size, len(order))
        axis, longest, middle = 0, -1.0, 0.0
        for a in range(3):
            low, high = np.inf, -np.inf
            for k in range(begin, end):
                x = position[order[k], a]
                low = x if x < low else low
                high = x if x > high else high
            if high - low > longest:
                axis, longest, middle = a, high - low, low + 0.5 * (high - low)
        key = np.empty(end - begin)
        below = 0
        for k in range(begin, end):
            x = position[order[k], axis]
            key[k - begin] = x
            below += x < middle
        # A small side is left only where it leaves the other one more compact, and never an odd leaf deep below.
        cut = min(max((below + leaf_size // 2) // leaf_size, max(1, leaves // 32)), leaves - max(1, leaves // 32))
        _select(key, order[begin:end], cut * leaf_size)
        one, other = node + 1, node + 2 * cut
        right[node] = other
        first[one], last[one] = first[node], first[node] + cut
        first[other], last[other] = first[node] + cut, last[node]
        stack[height], stack[height + 1] = other, one
        height += 2
    return parts[:count]


@njit(**ENTRY)
def _part_tasks(counter, position, order, first, last, right, leaf_size, task):
    while True:
        t = take(counter)
        if t >= len(task):
            break
        _part(position, order, first, last, right, leaf_size, task[t], 1)


@dataclass(frozen=True, eq=False)
class Nodes:
    """What nodes are like, (nodes,) each but centre (nodes, 3).

    mass, centre of mass, radius about it, and the largest reach and least strength of their particles.
    """

    mass: np.ndarray
    centre: np.ndarray
    radius: np.ndarray
    reach: np.ndarray
    strength: np.ndarray


def nodes(tree: Tree, mass: np.ndarray, position: np.ndarray, reach: np.ndarray, strength: np.ndarray) -> Nodes:
    """Nodes of particles (N,), (N, 3), (N,), (N,) in the order of `tree.order`."""
    count = len(tree.first)
    made = Nodes(np.zeros(count), np.zeros((count, 3)), np.zeros(count), np.zeros(count), np.zeros(count))
    share_out(
        _fill_nodes, available_threads(), tree.start, tree.first, tree.last, mass, position, reach, strength,
        made.mass, made.centre, made.radius, made.reach, made.strength,
    )  # fmt: skip
    return made


@njit(**ENTRY)
def _fill_nodes(counter, start, first, last, mass, position, reach, strength, m, centre, radius, far, least):
    while True:
        node = take(counter)
        if node >= len(first):
            break
        begin, end = start[first[node]], start[last[node]]
        total, x, y, z, most, weakest = 0.0, 0.0, 0.0, 0.0, 0.0, np.inf
        for k in range(begin, end):
            total += mass[k]
            x += mass[k] * position[k, 0]
            y += mass[k] * position[k, 1]
            z += mass[k] * position[k, 2]
            most = max(most, reach[k])
            weakest = min(weakest, strength[k])
        x, y, z = x / total, y / total, z / total
        squared = 0.0
        for k in range(begin, end):
            dx, dy, dz = position[k, 0] - x, position[k, 1] - y, position[k, 2] - z
            squared = max(squared, dx * dx + dy * dy + dz * dz)
        m[node], centre[node, 0], centre[node, 1], centre[node, 2] = total, x, y, z
        radius[node], far[node], least[node] = np.sqrt(squared), most, weakest
