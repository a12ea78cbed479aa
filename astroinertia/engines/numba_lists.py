"""The pass that lists the particles that can reach each leaf, a template: once an evaluation, for all passes.

What is listed reaches one of the leaf's targets, or one of them reaches it. The box of a leaf with the longest reach of
its targets all around would not do: where they lie around a dense body, it holds the body. Lists are made for lengths
somewhat above the smoothing lengths, so that they still hold when those have changed a little. A leaf and its
neighbours in the tree (GROUP of them) share a walk.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_parts import (
    GROUP,
    ROUNDING,
    box_centre,
    columns_for,
    extent,
    gather,
    load_balls,
    load_row,
    target_box,
    whole_lines,
    with_columns,
    with_room,
)
from astroinertia.engines.numba_tables import vector_take
from astroinertia.engines.numba_vectors import (
    ENTRY,
    LANES,
    PART,
    SLACK,
    claim,
    compressed_indices,
    larger_of,
    take,
    where,
    widest_vectors,
)

# Copied into generated modules from here on.


@njit(**PART)
def scale(rows, count, unit, support):
    """Places to the unit, and lengths to squares of reaches."""
    widest_vectors()
    x, y, z, h = rows[0], rows[1], rows[2], rows[3]
    factor, unit = x.dtype.type(unit * support), x.dtype.type(unit)
    for k in range(count):
        x[k], y[k], z[k], h[k] = unit * x[k], unit * y[k], unit * z[k], (factor * h[k]) * (factor * h[k])


@njit(fastmath={"contract"}, **PART)
def least_excess(x, y, z, reach2, count, balls, first, last, key):
    """The least squared distance of sources from balls first to last - 1, less the larger of two squared reaches."""
    widest_vectors()
    slack, rounding, zero = x.dtype.type(SLACK), x.dtype.type(ROUNDING), x.dtype.type(0)
    for k in range(count):
        key[k] = np.inf
    for t in range(first, last):
        x_t, y_t, z_t, reach2_t = balls[0, t], balls[1, t], balls[2, t], balls[3, t]
        for k in range(count):
            dx, dy, dz = x_t - x[k], y_t - y[k], z_t - z[k]
            square = dx * dx + (dy * dy + (dz * dz - rounding))
            excess = square - larger_of(reach2_t, reach2[k]) * slack
            # Zero is added so that a whole vector is stored: compilers would else store it where it falls alone, which
            # on processors without AVX-512 takes longer than all the rest together.
            key[k] = where(key[k] < excess, key[k], excess) + zero


@njit(**ENTRY)
def neighbour_lists(
    counter, x, y, z, h, position, support, nodes, start, targets, begin, groups, offset, count, pool, used
):
    """For each leaf of the groups: where its list begins in `pool` and how long it is."""
    leaves = len(start) - 1
    group = min(leaves, GROUP)
    like = np.empty(0, np.float32)
    parents, listed = np.empty(leaves + LANES, np.int64), np.empty(leaves + LANES, np.int64)
    gathered, index = np.empty(2048, np.int64), np.empty(1024, np.int32)
    rows, key = whole_lines(4, columns_for(1024), like), np.empty(1024, np.float32)
    box, centre, balls = np.empty((2, 3)), np.empty(3), whole_lines(4, columns_for(128), like)
    while True:
        number = take(counter)
        if number >= len(groups):
            break
        first_leaf = group * groups[number]
        origin, last = begin[first_leaf], begin[first_leaf + group]
        reach = support * target_box(position, h, targets, origin, last, box)
        box_centre(box, centre)
        unit = 1.0 / extent(box, reach)  # a NaN makes all of its sources NaN, which are listed
        balls = with_columns(balls, last - origin)
        load_balls(position, h, support, targets, origin, last, centre, unit, balls)
        total, gathered = gather(
            x, y, z, h, support, nodes, start, box, reach, balls, last - origin, centre, unit, parents, listed, gathered
        )
        key, index, rows = with_room(key, total), with_room(index, total), with_columns(rows, total)
        load_row(x, gathered, total, centre[0], rows[0])
        load_row(y, gathered, total, centre[1], rows[1])
        load_row(z, gathered, total, centre[2], rows[2])
        vector_take(h, 0, gathered, total, 0.0, rows[3])
        scale(rows, total, unit, support)
        for leaf in range(first_leaf, first_leaf + group):
            first, last = begin[leaf], begin[leaf + 1]
            if first == last:
                continue
            least_excess(rows[0], rows[1], rows[2], rows[3], total, balls, first - origin, last - origin, key)
            number = compressed_indices(0, key, total, index, 0)
            place = claim(used, number)
            offset[leaf], count[leaf] = place, number
            if place + number <= len(pool):  # else the caller comes back with more room
                for k in range(number):
                    pool[place + k] = gathered[index[k]]
