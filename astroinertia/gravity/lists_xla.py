"""Interaction lists of fast gravity on the xla engine: made on the host whenever particles are sorted.

A pair of nodes is taken as a whole where its error, in the mean about
    G M_source ((r_target + r_source)/d)^p / d^2,
is below the tolerance times the least acceleration in the target, for either node as the target (after Dehnen 2014,
Comput. Astrophys. Cosmol. 1, 1, section 3): the lists are symmetric, and so momentum is conserved. Of the leaves that
remain, those within reach of the kernels are summed with softening, and those apart as points.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import jax.numpy as jnp
import numpy as np
from numba import njit

from astroinertia.engines.numba_vectors import ENTRY
from astroinertia.engines.pytree import pytree
from astroinertia.engines.threads import available_threads
from astroinertia.engines.xla_lists import device
from astroinertia.gravity import full_leaves

TASKS = 64  # ranges of leaves that threads share out
WIDEST = 0.8  # (r_A + r_B)/d of nodes that may be taken as a whole, whatever their error
COHERENT = 1.0  # calibrated: how much of the tolerance the field of everything else may take over the width of a leaf
TINY = 1e-300
NODES_IN_ROW = 16  # sources of one target that are summed before they are added to it
ANCESTORS_IN_ROW = 8


@pytree
@dataclass(frozen=True)
class Chunks:
    """A list cut into chunks that are worked on at once: target (chunks, C), source (chunks, C) or (chunks, C, K).

    used: the number of chunks that hold anything.
    """

    target: Any
    source: Any
    used: Any


@pytree
@dataclass(frozen=True)
class Lists:
    """Leaves, nodes and their interactions; node number `nodes` is an empty one, and so is particle N.

    The last leaves and nodes may be empty too: their numbers are rounded up, so that bodies cut a little differently
    share one compiled program.
    slots (L, S): particles of each leaf, in the order of the engine; row, column (N,): where each particle is;
    first, last (nodes,): leaves below each node; leaf_node (L,): the leaf's node; scale (nodes + 1,): about the node's
    radius or reach. local: targets and sources of nodes taken as wholes; shifts: leaves and the nodes above them that
    take part, each leaf's own included; near: pairs of leaves. order: of the expansions.
    """

    slots: Any
    row: Any
    column: Any
    first: Any
    last: Any
    leaf_node: Any
    scale: Any
    local: Chunks
    shifts: Chunks
    near: Chunks
    order: int = field(metadata={"static": True})


def interaction_lists(
    mass: np.ndarray,
    position: np.ndarray,
    reach: np.ndarray,
    strength: np.ndarray,
    tolerance: float,
    order: int,
    leaf_size: int,
    pairs_in_chunk: int,
) -> Lists:
    """Lists for particles (N,), (N, 3), summed as points beyond `reach` (N,), with accelerations `strength` (N,)."""
    # The field of everything else varies over about sqrt(M/|a|): its expansion over a leaf of such a width fails,
    # however small the parts in which its sources are taken.
    span = np.sqrt(mass.sum() / np.maximum(strength, TINY))
    tree = full_leaves.tree(position, leaf_size, (COHERENT * tolerance) ** (1.0 / order) * span)
    inner = [np.ascontiguousarray(array[tree.order]) for array in (mass, position, reach, strength)]
    nodes = full_leaves.nodes(tree, *inner)
    local, near = _walked(tree, nodes, tolerance, order)
    count, leaves = len(position), _roomy(tree.leaves)
    total = 2 * leaves - 1
    leaf_node = np.full(leaves, total)
    single = np.flatnonzero(tree.right == 0)
    leaf_node[tree.first[single]] = single
    sizes = np.diff(tree.start)
    leaf = np.repeat(np.arange(tree.leaves), sizes)
    column = np.arange(count) - np.repeat(tree.start[:-1], sizes)
    slots = np.full((leaves, leaf_size), count)
    slots[leaf, column] = tree.order
    row_of, column_of = np.empty(count, np.int64), np.empty(count, np.int64)
    row_of[tree.order], column_of[tree.order] = leaf, column
    taking_part = np.zeros(total, np.bool_)
    taking_part[local[:, 0]] = True
    nodes_in_chunk = max(NODES_IN_ROW, pairs_in_chunk // 8)
    rows = _rows(local[:, 0], local[:, 1], total, NODES_IN_ROW, total)
    above = _above(tree.first, tree.last, tree.right, taking_part, tree.leaves)
    shifts = _rows(above[:, 0], above[:, 1], leaves, ANCESTORS_IN_ROW, total)
    # Never more than about the distance of whatever the node meets, and never 0.
    scale = np.exp2(np.ceil(np.log2(np.maximum(nodes.radius, nodes.reach))))
    empty = total - len(tree.first)
    tiles = max(1, pairs_in_chunk // leaf_size**2)
    return Lists(
        slots=device(slots),
        row=device(row_of),
        column=device(column_of),
        first=device(np.pad(tree.first, (0, empty))),
        last=device(np.pad(tree.last, (0, empty))),
        leaf_node=device(leaf_node),
        scale=jnp.asarray(np.pad(scale, (0, empty + 1), constant_values=1.0)),
        local=_chunks(*rows, nodes_in_chunk // NODES_IN_ROW, total - 1, total),
        shifts=_chunks(*shifts, nodes_in_chunk // ANCESTORS_IN_ROW, leaves - 1, total),
        near=_chunks(near[:, 0], near[:, 1], tiles, leaves - 1, leaves),
        order=order,
    )


def _roomy(count: int) -> int:
    # Up to one of eight sizes between two powers of two.
    step = 1 << max(0, count.bit_length() - 4)
    return -(-count // step) * step


def _chunks(target: np.ndarray, source: np.ndarray, size: int, last_target: int, empty: int) -> Chunks:
    # Up to a power of two, so that lists of similar length share one compiled program; unused chunks are skipped.
    size = min(size, 1 << max(0, len(target) - 1).bit_length())
    used = -(-len(target) // size)
    total = 1 << (used - 1).bit_length() if used else 0
    targets = np.full(total * size, last_target)
    targets[: len(target)] = target
    sources = np.full((total * size, *source.shape[1:]), empty)
    sources[: len(target)] = source
    return Chunks(
        device(targets.reshape(total, size)), device(sources.reshape(total, size, *source.shape[1:])), device(used)
    )


def _walked(tree: full_leaves.Tree, nodes: full_leaves.Nodes, tolerance: float, order: int) -> tuple[Any, Any]:
    # Pairs of nodes and pairs of leaves (target, source), by ascending targets.
    arrays = (tree.first, tree.last, tree.right, nodes.mass, nodes.centre, nodes.radius, nodes.reach, nodes.strength)

    ends = np.unique(np.linspace(0, tree.leaves, TASKS + 1).astype(np.int64))

    def below(task: int) -> tuple[np.ndarray, np.ndarray]:
        return _walk(*arrays, ends[task], ends[task + 1], tolerance, order, WIDEST)

    with ThreadPoolExecutor(available_threads()) as pool:
        walks = list(pool.map(below, range(len(ends) - 1)))
    local, near = (np.concatenate([pair[k] for pair in walks]) for k in range(2))
    return _sorted(local, len(tree.first)), _sorted(near, tree.leaves)


@njit(**ENTRY)
def _grown(array):
    larger = np.empty((2 * len(array), array.shape[1]), array.dtype)
    larger[: len(array)] = array
    return larger


@njit(**ENTRY)
def _far_apart(a, b, mass, centre, radius, reach, strength, tolerance, order, widest):
    # Whether expansions of the two nodes are as accurate as is asked for, for both.
    dx, dy, dz = centre[a, 0] - centre[b, 0], centre[a, 1] - centre[b, 1], centre[a, 2] - centre[b, 2]
    squared = dx * dx + dy * dy + dz * dz
    distance, size = np.sqrt(squared), radius[a] + radius[b]
    if not (size < widest * distance and distance - size > max(reach[a], reach[b])):
        return False
    share = (size / distance) ** order / squared
    return mass[b] * share <= tolerance * strength[a] and mass[a] * share <= tolerance * strength[b]


@njit(**ENTRY)
def _walk(
    first, last, right, mass, centre, radius, reach, strength, begin, end, tolerance, order, widest
):  # fmt: skip
    # All interactions of targets that begin within the leaves begin ... end-1.
    local, near = np.empty((1024, 2), np.int32), np.empty((1024, 2), np.int32)
    locals_found, near_found = 0, 0
    stack = np.empty((1024, 2), np.int32)
    stack[0, 0] = stack[0, 1] = 0
    height = 1
    while height > 0:
        height -= 1
        a, b = stack[height, 0], stack[height, 1]
        if last[a] <= begin or first[a] >= end:
            continue
        if height + 4 > len(stack):
            stack = _grown(stack)
        if a != b and _far_apart(a, b, mass, centre, radius, reach, strength, tolerance, order, widest):
            if first[a] >= begin:
                if locals_found == len(local):
                    local = _grown(local)
                local[locals_found, 0], local[locals_found, 1] = a, b
                locals_found += 1
            continue
        if right[a] == 0 and right[b] == 0:
            if near_found == len(near):
                near = _grown(near)
            near[near_found, 0], near[near_found, 1] = first[a], first[b]
            near_found += 1
            continue
        split_a = right[b] == 0 or (right[a] != 0 and (radius[a] > radius[b] or (radius[a] == radius[b] and a < b)))
        split_b = not split_a or a == b
        for m in range(2 if split_a else 1):
            for n in range(2 if split_b else 1):
                stack[height, 0] = (right[a] if m else a + 1) if split_a else a
                stack[height, 1] = (right[b] if n else b + 1) if split_b else b
                height += 1
    return local[:locals_found], near[:near_found]


@njit(**ENTRY)
def _sorted(pairs, targets):
    # By ascending targets, else in their order.
    place = np.zeros(targets + 1, np.int64)
    for k in range(len(pairs)):
        place[pairs[k, 0] + 1] += 1
    for t in range(targets):
        place[t + 1] += place[t]
    result = np.empty_like(pairs)
    for k in range(len(pairs)):
        t = pairs[k, 0]
        result[place[t]] = pairs[k]
        place[t] += 1
    return result


def _rows(
    target: np.ndarray, source: np.ndarray, targets: int, width: int, empty: int
) -> tuple[np.ndarray, np.ndarray]:
    # Sources of ascending targets in rows of one target each, filled up with `empty`.
    counts = np.bincount(target, minlength=targets)
    rows = -(-counts // width)
    within = np.arange(len(target)) - np.repeat(np.cumsum(counts) - counts, counts)
    row_source = np.full((rows.sum(), width), empty, np.int32)
    row_source[np.repeat(np.cumsum(rows) - rows, counts) + within // width, within % width] = source
    return np.repeat(np.arange(targets, dtype=np.int32), rows), row_source


@njit(**ENTRY)
def _above(first, last, right, taking_part, leaves):
    # (leaf, node) for every node over a leaf, itself included, that takes part.
    total = 0
    for node in range(len(first)):
        if taking_part[node]:
            total += last[node] - first[node]
    pairs = np.empty((total, 2), np.int32)
    k = 0
    for leaf in range(leaves):
        node = 0
        while True:
            if taking_part[node]:
                pairs[k, 0], pairs[k, 1] = leaf, node
                k += 1
            if right[node] == 0:
                break
            node = node + 1 if leaf < first[right[node]] else right[node]
    return pairs
