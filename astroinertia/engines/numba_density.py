"""The density pass, a template: smoothing lengths, densities and their gradient factors, leaf by leaf.

How they are solved for: numba_lengths. Few particles: numba_few_density.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import RELATIVE, real
from astroinertia.engines.numba_lengths import solve
from astroinertia.engines.numba_parts import (
    box_centre,
    columns_for,
    gather,
    load_component,
    load_row,
    places,
    target_box,
    whole_lines,
    with_columns,
    with_room,
)
from astroinertia.engines.numba_vectors import ENTRY, LANES, PART, take

# Copied into generated modules from here on.
MOVED = 1.2  # how much further to look among positions that may have moved since they were listed


@njit(**PART)
def load_sources(indices, count, centre, buffer, position, mass):
    """Rows: x, y, z, mass."""
    for a in range(3):
        load_component(position, a, indices, count, centre[a] if RELATIVE else 0.0, buffer[a])
    load_row(mass, indices, count, 0.0, buffer[3])


@njit(**PART)
def solve_again(waiting, left, x, y, z, length, position, mass, targets, nodes, start, options, results):
    """Targets waiting[:left] of a leaf, which have outgrown their lists, gather others, each time of larger reach."""
    leaves = len(start) - 1
    parents, listed = np.empty(leaves + LANES, np.int64), np.empty(leaves + LANES, np.int64)
    neighbours, items, slots = np.empty(1024, np.int64), np.empty(left, np.int64), np.empty(left, np.int64)
    like = np.empty(0, real)
    buffer, lists = whole_lines(4, columns_for(512), like), whole_lines(2, columns_for(512), like)
    box, centre = np.empty((2, 3)), np.empty(3)
    while left > 0:
        limit = 0.0
        for k in range(left):
            items[k] = targets[waiting[k]]
            limit = max(limit, 1.3 * results[0, waiting[k]])
        target_box(position, length, items, 0, left, box)
        box_centre(box, centre)
        reach = MOVED * options[0] * limit
        count, neighbours = gather(
            x, y, z, length, 0.0, nodes, start, box, reach, nodes, 0, centre, 0.0, parents, listed, neighbours
        )
        buffer, lists = with_columns(buffer, count), with_columns(lists, count)
        load_sources(neighbours, count, centre, buffer, position, mass)
        places(items, 0, left, neighbours, count, slots)
        for k in range(left):
            results[1, waiting[k]] = limit
        left = solve(waiting, left, slots, count, buffer, lists, options, results)


@njit(**ENTRY)
def density_pass(
    counter, x, y, z, length, position, h, mass, nodes, start, targets, begin, active, offset, number, pool, options,
    results,
):  # fmt: skip
    """Solve for all targets, leaf by leaf.

    length: what the lists were made for, options[1] times as long as the guesses h.
    """
    like = np.empty(0, real)
    buffer, lists = whole_lines(4, columns_for(512), like), whole_lines(2, columns_for(512), like)
    box, centre = np.empty((2, 3)), np.empty(3)
    slots, waiting = np.empty(0, np.int64), np.empty(0, np.int64)
    while True:
        turn = take(counter)
        if turn >= len(active):
            break
        leaf = active[turn]
        first, last, count = begin[leaf], begin[leaf + 1], number[leaf]
        neighbours = pool[offset[leaf] : offset[leaf] + count]
        buffer, lists = with_columns(buffer, count), with_columns(lists, count)
        slots, waiting = with_room(slots, last - first), with_room(waiting, last - first)
        target_box(position, length, targets, first, last, box)
        box_centre(box, centre)
        load_sources(neighbours, count, centre, buffer, position, mass)
        places(targets, first, last, neighbours, count, slots)
        for t in range(first, last):
            waiting[t - first], results[0, t], results[1, t] = t, h[targets[t]], length[targets[t]]
        left = solve(waiting, last - first, slots, count, buffer, lists, options, results)
        if left > 0:
            solve_again(waiting, left, x, y, z, length, position, mass, targets, nodes, start, options, results)
