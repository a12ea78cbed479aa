"""What softening changes about clamped points, a template: sums over the neighbours of the leaves of gravity's tree.

No second order of particles, no second tree, no lists that are kept: nodes halved in space have boxes that stay compact
where particles cluster. Of all leaves those near a task of the tree are found first, of those the ones near a group of
neighbouring leaves, and of those the ones near each leaf. By itself it takes float64 and Wendland's C2.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import RELATIVE, real
from astroinertia.engines.numba_modules import neighbour_functions
from astroinertia.engines.numba_parts import (
    MANY,
    box_centre,
    columns_for,
    extent,
    load_balls,
    target_box,
    touched,
    whole_lines,
    with_columns,
)
from astroinertia.engines.numba_tables import row_copier, row_spreader
from astroinertia.engines.numba_vectors import ENTRY, LANES, PART, in_reach, padded, take
from astroinertia.engines.templates import executed
from astroinertia.gravity.clamped_points import SOFTENED_LESS_POINT

NEEDS, LINES = neighbour_functions("wendland_c2", (SOFTENED_LESS_POINT,), "float64", "softened_leaf")
SUPPORT, WIDTH, SPREAD, REACHES = 2.0, NEEDS.width, NEEDS.spread, NEEDS.reaches
FUNCTIONS = executed(LINES)
pack_row, set_origin, softened_leaf = FUNCTIONS.pack_row, FUNCTIONS.set_origin, FUNCTIONS.softened_leaf

# Copied into generated modules from here on.
copy_rows = row_copier(WIDTH)
spread_places = row_spreader(4, 0)
spread_reaches = row_spreader(4, REACHES)


@njit(**ENTRY)
def fit_boxes(counter, order, smoothing_length, scale, columns, m, every, start, groups, tasks, h, table, boxes):
    """Of each task's particles, in the tree's order: smoothing lengths and rows of the table that sources are taken
    from; of its leaves: corners, largest h, numbers.

    columns (3, N), m (N,): places and masses in that order; every: 0 to N - 1; start (leaves + 1,), groups, tasks:
    first particles of leaves, first leaves of groups, first groups of tasks; boxes (8, leaves).
    """
    position, box = columns.T, np.empty((2, 3))
    while True:
        task = take(counter)
        if task >= len(tasks) - 1:
            break
        for leaf in range(groups[tasks[task]], groups[tasks[task + 1]]):
            for k in range(start[leaf], start[leaf + 1]):
                h[k] = smoothing_length[order[k]] * scale
                pack_row(k, k, position, h, m, SUPPORT, table)
            boxes[6, leaf] = target_box(position, h, every, start[leaf], start[leaf + 1], box)
            boxes[7, leaf] = leaf
            for a in range(3):
                boxes[a, leaf], boxes[3 + a, leaf] = box[0, a], box[1, a]


@njit(**PART)
def nearer(first, last, one_by_one, columns, h, every, boxes, count, box, centre, balls, listed, out):
    """Of boxes (8, count): those within the larger of two reaches of the box of particles first to last - 1.

    one_by_one: of many, those near one of the particles. Sets that box and its centre; returns how many boxes are left,
    the largest reach of the particles, and the buffer of balls.
    """
    position = columns.T
    reach = SUPPORT * target_box(position, h, every, first, last, box)
    box_centre(box, centre)
    kept = in_reach(
        boxes[0], boxes[1], boxes[2], boxes[3], boxes[4], boxes[5], boxes[6], 0, count, box, SUPPORT, reach, listed, 0
    )
    if one_by_one and kept > MANY:  # the box of particles around a dense body holds the body
        unit = 1.0 / extent(box, reach)
        balls = with_columns(balls, last - first)
        load_balls(position, h, SUPPORT, every, first, last, centre, unit, balls)
        kept = touched(boxes, SUPPORT, box, balls, last - first, centre, unit, listed, kept)
    for k in range(kept):
        for a in range(8):
            out[a, k] = boxes[a, listed[k]]
    return kept, reach, balls


@njit(**PART)
def sources_of(leaf, near, numbers, start, columns, h, box, reach, listed):
    """The particles of a leaf, then those of the others near it that are within the larger of two reaches of its box.

    Neighbours among the leaves are looked through in one run. Returns how many are listed.
    """
    x, y, z, count, k = columns[0], columns[1], columns[2], 0, 0
    for own in range(start[leaf], start[leaf + 1]):
        listed[count] = own
        count += 1
    while k < near:
        begin = np.int64(numbers[k])
        end = begin + 1
        k += 1
        while k < near and begin != leaf and numbers[k] == end and end != leaf:
            end += 1
            k += 1
        if begin != leaf:
            count = in_reach(x, y, z, x, y, z, h, start[begin], start[end], box, SUPPORT, reach, listed, count)
    return count


@njit(**ENTRY)
def soften(counter, columns, h, table, boxes, every, start, groups, tasks, order, force_unit, potential_unit,
           acceleration, potential):  # fmt: skip
    """Add what softening changes to accelerations (N, 3) and potentials (N,), in their own order and units."""
    leaves, like = len(start) - 1, np.empty(0, real)
    listed, balls = np.empty(leaves + LANES, np.int64), whole_lines(4, columns_for(64), np.empty(0, np.float32))
    of_task, of_group = np.empty((8, leaves + LANES)), np.empty((8, leaves + LANES))
    of_leaf, box, centre, zero = np.empty((8, leaves + LANES)), np.empty((2, 3)), np.empty(3), np.zeros(WIDTH)
    most = 0
    for leaf in range(leaves):
        most = max(most, start[leaf + 1] - start[leaf])
    pull, well, room = np.empty((most, 3)), np.empty(most), columns_for(1024)
    sources, rows, search = whole_lines(room, WIDTH, like), whole_lines(SPREAD, room, like), whole_lines(8, room, like)
    near, own, index = np.empty(room, np.int64), np.arange(room), np.empty(room, np.int32 if RELATIVE else np.int64)
    while True:
        task = take(counter)
        if task >= len(tasks) - 1:
            break
        first, last = start[groups[tasks[task]]], start[groups[tasks[task + 1]]]
        near_task, _, balls = nearer(
            first, last, False, columns, h, every, boxes, leaves, box, centre, balls, listed, of_task
        )
        for group in range(tasks[task], tasks[task + 1]):
            first, last = start[groups[group]], start[groups[group + 1]]
            near_group, _, balls = nearer(
                first, last, False, columns, h, every, of_task, near_task, box, centre, balls, listed, of_group
            )
            for leaf in range(groups[group], groups[group + 1]):
                first, last = start[leaf], start[leaf + 1]
                near_leaf, reach, balls = nearer(
                    first, last, True, columns, h, every, of_group, near_group, box, centre, balls, listed, of_leaf
                )
                total = last - first
                for k in range(near_leaf):
                    other = np.int64(of_leaf[7, k])
                    total += start[other + 1] - start[other]
                if total + 3 * LANES > room:
                    room = columns_for(total)
                    sources, rows = whole_lines(room, WIDTH, like), whole_lines(SPREAD, room, like)
                    search, near, own = whole_lines(8, room, like), np.empty(room, np.int64), np.arange(room)
                    index = np.empty(room, index.dtype)
                count = sources_of(leaf, near_leaf, of_leaf[7], start, columns, h, box, reach, near)
                set_origin(centre, table, first, zero)
                copy_rows(table, near, count, zero, sources)
                for k in range(WIDTH):  # a massless copy of the last source stands at the loose end
                    sources[count, k] = sources[count - 1, k]
                sources[count, 3] = 0
                spread_places(sources, own, padded(count), search)
                spread_reaches(sources, own, padded(count), search[4:])
                softened_leaf(leaf, 0, last - first, own, count, sources, rows, search, index, pull, well)
                for k in range(last - first):
                    i = order[first + k]
                    for a in range(3):
                        acceleration[i, a] += pull[k, a] * force_unit
                    potential[i] += well[k] * potential_unit
