"""The text of the pass that lists, for every leaf, the particles that can reach it: once an evaluation, for all passes.

Lists are made for lengths somewhat above the smoothing lengths, so that they still hold when those have changed a
little. A leaf and its neighbours in the tree (GROUP of them) share a walk.
"""

import functools
from collections.abc import Callable

from astroinertia.engines.numba_cache import load_module
from astroinertia.engines.numba_passes import header

LISTS = """
@njit(**PART)
def squares(row, count, factor):
    widest_vectors()
    for k in range(count):
        row[k] = (factor * row[k]) * (factor * row[k])


@njit(cache=True, nogil=True, error_model="numpy")
def neighbour_lists(
    counter, x, y, z, h, position, support, nodes, start, targets, begin, groups, offset, count, pool, used
):
    leaves = len(start) - 1
    group = min(leaves, GROUP)
    parents, listed = np.empty(leaves + LANES, np.int64), np.empty(leaves + LANES, np.int64)
    found, index = np.empty(2048, np.int64), np.empty(1024, np.int64)
    rows, key = np.empty((4, columns_for(512))), np.empty(1024)
    box = np.empty((2, 3))
    while True:
        number = take(counter)
        if number >= len(groups):
            break
        first_leaf = group * groups[number]
        first, last = begin[first_leaf], begin[first_leaf + group]
        reach = support * target_box(position, h, targets, first, last, box)
        total, found = gather(x, y, z, h, support, nodes, start, box, reach, parents, listed, found)
        key, index, rows = with_room(key, total), with_room(index, total), with_columns(rows, total)
        load_row(x, found, total, 0.0, rows[0])
        load_row(y, found, total, 0.0, rows[1])
        load_row(z, found, total, 0.0, rows[2])
        vector_take(h, 0, found, total, 0.0, rows[3])
        squares(rows[3], total, support)
        for leaf in range(first_leaf, first_leaf + group):
            first, last = begin[leaf], begin[leaf + 1]
            if first == last:
                continue
            reach = support * target_box(position, h, targets, first, last, box)
            row_excess(rows[0], rows[1], rows[2], rows[3], total, box, reach * reach, key)
            number = compressed_indices(0, key, total, index, 0)
            place = claim(used, number)
            offset[leaf], count[leaf] = place, number
            if place + number <= len(pool):  # else the caller comes back with more room
                for k in range(number):
                    pool[place + k] = found[index[k]]
"""


@functools.cache
def lists_pass() -> Callable:
    """The entry function of the generated module."""
    module = load_module("neighbour_lists", "\n".join([*header("float64"), LISTS]))
    return module.neighbour_lists
