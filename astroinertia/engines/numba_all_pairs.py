"""Sums over all pairs, a template: sources near a leaf one by one, those far away in blocks.

arrays, results: what the terms ask for and what they add up to, as in numba_neighbours.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import RELATIVE, real
from astroinertia.engines.numba_modules import all_pairs_functions
from astroinertia.engines.numba_neighbours import TOTAL
from astroinertia.engines.numba_parts import divide, node_box, place_of, with_columns, with_room
from astroinertia.engines.numba_vectors import ENTRY, LANES, take
from astroinertia.engines.templates import executed

NEEDS, FAR_NEEDS, FUNCTIONS = all_pairs_functions("wendland_c2", (TOTAL,), "float64", "near_leaf", "far_leaf")
ROWS, FAR_ROWS, DISTANT = len(NEEDS.rows), len(FAR_NEEDS.rows), True
TOTALS = executed(FUNCTIONS)
load_sources, load_far_sources = TOTALS.load_sources, TOTALS.load_far_sources
near_leaf, far_leaf = TOTALS.near_leaf, TOTALS.far_leaf

# Copied into generated modules from here on.


@njit(**ENTRY)
def all_pairs_pass(counter, x, y, z, h, mass, support, factor, nodes, first_of, last_of, leaves, arrays, results):
    """Sums over all pairs, leaf by leaf."""
    block = 1024
    parents, listed = np.empty(leaves + LANES, np.int64), np.empty(leaves + LANES, np.int64)
    near, far = np.empty(2048, np.int64), np.empty(2048, np.int64)
    ranges = np.empty((leaves + 1, 2), np.int64)
    run, slots = np.empty(block, np.int64), np.empty(0, np.int64)
    sources = np.empty((ROWS, 2048), real)
    far_sources = np.empty((FAR_ROWS, block + 2 * LANES), real)
    targets = np.empty((FAR_ROWS, block + 2 * LANES), real)
    key, index = np.empty(2048, real), np.empty(2048, np.int32 if RELATIVE else np.int64)
    box, centre = np.empty((2, 3)), np.empty(3)
    while True:
        leaf = take(counter)
        if leaf >= leaves:
            break
        node = leaves + leaf
        first, last = first_of[node], last_of[node]
        node_box(nodes, node, box, centre)
        near_count, far_count, range_count, near, far = divide(
            x, y, z, h, factor, nodes, first_of, last_of, leaves, box, factor * nodes[6, node], parents, listed,
            near, far, ranges
        )  # fmt: skip
        key, index = with_room(key, near_count), with_room(index, near_count)
        sources = with_columns(sources, near_count)
        slots = with_room(slots, last - first)
        for n in range(last - first):
            slots[n] = place_of(first, near, near_count) + n
        load_sources(near, near_count, centre, first, sources, x, y, z, mass, h, support, arrays)
        near_leaf(leaf, first, last, slots, near_count, sources, sources, key, index, results)
        if DISTANT:
            for n in range(last - first):
                run[n] = first + n
            load_far_sources(run, last - first, centre, first, targets, x, y, z, mass, h, support, arrays)
            for k in range(range_count):
                for begin in range(ranges[k, 0], ranges[k, 1], block):
                    count = min(block, ranges[k, 1] - begin)
                    for n in range(count):
                        run[n] = begin + n
                    load_far_sources(run, count, centre, first, far_sources, x, y, z, mass, h, support, arrays)
                    far_leaf(leaf, first, last, slots, count, targets, far_sources, key, index, results)
            for begin in range(0, far_count, block):
                count = min(block, far_count - begin)
                for n in range(count):
                    run[n] = far[begin + n]
                load_far_sources(run, count, centre, first, far_sources, x, y, z, mass, h, support, arrays)
                far_leaf(leaf, first, last, slots, count, targets, far_sources, key, index, results)
