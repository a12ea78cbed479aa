"""What softening changes about clamped points, a template: sums over the neighbours of the leaves of gravity's tree.

No second order of particles, no second tree, no lists that are kept: nodes halved in space have boxes that stay compact
where particles cluster. Of all leaves those near a task of the tree are found first, of those the ones near a group of
neighbouring leaves, and of those the ones near each leaf. By itself it takes float64 and Wendland's C2.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import RELATIVE, real
from astroinertia.engines.numba_modules import within_functions
from astroinertia.engines.numba_parts import (
    MANY,
    box_centre,
    columns_for,
    extent,
    fill_row,
    load_balls,
    target_box,
    touched,
    whole_lines,
    with_columns,
)
from astroinertia.engines.numba_tables import vector_copy, vector_fill
from astroinertia.engines.numba_vectors import (
    ENTRY,
    LANES,
    PART,
    SLACK,
    in_reach,
    larger_of,
    padded,
    take,
    widest_vectors,
)
from astroinertia.engines.templates import executed
from astroinertia.gravity.clamped_points import SOFTENED_LESS_POINT
from astroinertia.gravity.compaction import compacted

FUNCTIONS = executed(within_functions("wendland_c2", (SOFTENED_LESS_POINT,), "softened_leaf"))
SUPPORT, softened_leaf = 2.0, FUNCTIONS.softened_leaf

# Copied into generated modules from here on.


@njit(**ENTRY)
def fit_boxes(counter, order, smoothing_length, scale, columns, every, start, groups, tasks, h, boxes):
    """Of each task's particles: smoothing lengths in the tree's order; of its leaves: corners, largest h, numbers.

    columns (3, N): places in that order; every: 0 to N - 1; start (leaves + 1,), groups, tasks: first particles of
    leaves, first leaves of groups, first groups of tasks; boxes (8, leaves).
    """
    position, box = columns.T, np.empty((2, 3))
    while True:
        task = take(counter)
        if task >= len(tasks) - 1:
            break
        for leaf in range(groups[tasks[task]], groups[tasks[task + 1]]):
            for k in range(start[leaf], start[leaf + 1]):
                h[k] = smoothing_length[order[k]] * scale
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
def copied_run(first, last, columns, h, m, centre, rows, count):
    """Particles first to last - 1 about a centre; whole vectors: what is too much is overwritten by what comes next."""
    x, y, z = columns[0], columns[1], columns[2]
    for k in range(0, last - first, LANES):
        vector_copy(x, first + k, centre[0], rows[0], count + k)
        vector_copy(y, first + k, centre[1], rows[1], count + k)
        vector_copy(z, first + k, centre[2], rows[2], count + k)
        vector_copy(m, first + k, real(0), rows[3], count + k)
        vector_copy(h, first + k, 0.0, rows[4], count + k)
    return count + last - first


@njit(**PART)
def copied_leaves(leaf, near, numbers, start, columns, h, m, centre, rows):
    """The particles of a leaf, then those of the others that are near it, neighbours among them in one run."""
    total = copied_run(start[leaf], start[leaf + 1], columns, h, m, centre, rows, 0)
    k = 0
    while k < near:
        begin = np.int64(numbers[k])
        end = begin + 1
        k += 1
        while k < near and begin != leaf and numbers[k] == end and end != leaf:
            end += 1
            k += 1
        if begin != leaf:
            total = copied_run(start[begin], start[end], columns, h, m, centre, rows, total)
    return total


@njit(fastmath={"contract"}, **PART)
def beyond_reach(rows, count, half_x, half_y, half_z, reach, key):
    """Squared distances from a box about the centre, less the squares of the larger of two reaches."""
    widest_vectors()
    x, y, z, h = rows[0], rows[1], rows[2], rows[4]
    zero, support, slack = real(0), real(SUPPORT), real(SLACK)
    for k in range(padded(count)):
        dx = larger_of(zero, abs(x[k]) - half_x)
        dy = larger_of(zero, abs(y[k]) - half_y)
        dz = larger_of(zero, abs(z[k]) - half_z)
        most = larger_of(reach, support * h[k])
        key[k] = dx * dx + (dy * dy + dz * dz) - most * most * slack


@njit(**PART)
def compacted_sources(rows, key, total, sources):
    """Sources within reach as `softened_leaf` has them: x, y, z, mass, squared reaches, 1/h, h; how many they are.

    A massless copy of the last one stands at the loose end.
    """
    widest_vectors()
    count = compacted(rows[0], key, total, sources[0], 0)
    compacted(rows[1], key, total, sources[1], 0)
    compacted(rows[2], key, total, sources[2], 0)
    compacted(rows[3], key, total, sources[3], 0)
    compacted(rows[4], key, total, sources[6], 0)
    fill_row(sources[0], count)
    fill_row(sources[1], count)
    fill_row(sources[2], count)
    fill_row(sources[6], count)
    vector_fill(sources[3], count, real(0))
    reach2, inverse_h, h = sources[4], sources[5], sources[6]
    for k in range(padded(count + 1)):
        reach = real(SUPPORT) * h[k]
        reach2[k], inverse_h[k] = reach * reach, real(1) / h[k]
    return count


@njit(**ENTRY)
def soften(counter, columns, h, m, boxes, every, start, groups, tasks, order, force_unit, potential_unit, acceleration,
           potential):  # fmt: skip
    """Add what softening changes to accelerations (N, 3) and potentials (N,), in their own order and units."""
    leaves, like = len(start) - 1, np.empty(0, real)
    listed, balls = np.empty(leaves + LANES, np.int64), whole_lines(4, columns_for(64), np.empty(0, np.float32))
    of_task, of_group = np.empty((8, leaves + LANES)), np.empty((8, leaves + LANES))
    of_leaf, box, centre = np.empty((8, leaves + LANES)), np.empty((2, 3)), np.empty(3)
    most = 0
    for leaf in range(leaves):
        most = max(most, start[leaf + 1] - start[leaf])
    slots, pull, well, room = np.arange(most), np.empty((most, 3)), np.empty(most), columns_for(1024)
    rows, sources = whole_lines(5, room, like), whole_lines(7, room, like)
    key, index = np.empty(room, real), np.empty(room, np.int32 if RELATIVE else np.int64)
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
                near, reach, balls = nearer(
                    first, last, True, columns, h, every, of_group, near_group, box, centre, balls, listed, of_leaf
                )
                total = last - first
                for k in range(near):
                    other = np.int64(of_leaf[7, k])
                    total += start[other + 1] - start[other]
                if total + 3 * LANES > room:
                    room = columns_for(total)
                    rows, sources = whole_lines(5, room, like), whole_lines(7, room, like)
                    key, index = np.empty(room, real), np.empty(room, index.dtype)
                total = copied_leaves(leaf, near, of_leaf[7], start, columns, h, m, centre, rows)
                beyond_reach(
                    rows, total, real(box[1, 0] - centre[0]), real(box[1, 1] - centre[1]), real(box[1, 2] - centre[2]),
                    real(reach), key
                )  # fmt: skip
                count = compacted_sources(rows, key, total, sources)
                for k in range(last - first):
                    pull[k, 0] = pull[k, 1] = pull[k, 2] = well[k] = 0.0
                softened_leaf(leaf, 0, last - first, slots, count, sources, sources, key, index, pull, well)
                for k in range(last - first):
                    i = order[first + k]
                    for a in range(3):
                        acceleration[i, a] += pull[k, a] * force_unit
                    potential[i] += well[k] * potential_unit
