"""Sums over neighbours, a template: what each leaf's loop over pairs is given, put in rows of its own.

arrays, results: what the terms ask for and what they add up to, lists of arguments in generated modules. By itself it
takes TOTAL, for which each is a single one, and float64.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_float64 import RELATIVE, real
from astroinertia.engines.numba_modules import neighbour_functions
from astroinertia.engines.numba_parts import (
    box_centre,
    close_to,
    columns_for,
    places,
    target_box,
    whole_lines,
    with_room,
)
from astroinertia.engines.numba_tables import row_copier, row_spreader
from astroinertia.engines.numba_vectors import ENTRY, LANES, padded, take
from astroinertia.engines.templates import executed
from astroinertia.engines.terms import Output, PairTerm


def total_pair(xp, weight_j):
    """A neighbour's weight."""
    return (weight_j,)


TOTAL = PairTerm("total", total_pair, (Output("weight", "sum"),), far=total_pair)
NEEDS, FUNCTIONS = neighbour_functions("wendland_c2", (TOTAL,), "float64", "neighbour_leaf")
WIDTH, SPREAD, REACHES = NEEDS.width, NEEDS.spread, NEEDS.reaches
TOTALS = executed(FUNCTIONS)
pack_row, set_origin, neighbour_leaf = TOTALS.pack_row, TOTALS.set_origin, TOTALS.neighbour_leaf

# Copied into generated modules from here on.
copy_rows = row_copier(WIDTH)
spread_places = row_spreader(4, 0)
spread_reaches = row_spreader(4, REACHES)


@njit(**ENTRY)
def neighbour_pass(
    counter, position, h, mass, support, arrays, table, chosen, begin, active, offset, number, pool, results
):
    """Sums over the neighbours of all targets, leaf by leaf.

    table: what `pack` made of all particles, or none: then each leaf packs what is near enough to its targets.
    """
    room = columns_for(512)
    like = np.empty(0, real)
    sources, rows = whole_lines(room, WIDTH, like), whole_lines(SPREAD, room, like)
    search = whole_lines(8, room, like)
    index, own = np.empty(room, np.int32 if RELATIVE else np.int64), np.arange(room)
    box, centre, zero = np.empty((2, 3)), np.empty(3), np.zeros(WIDTH)
    slots = np.empty(0, np.int64)
    sparse = len(table) == 0
    if sparse:
        near, packed = np.empty(room, pool.dtype), np.empty((room, WIDTH))
    else:
        near, packed = pool[:0], table
    while True:
        turn = take(counter)
        if turn >= len(active):
            break
        leaf = active[turn]
        first, last, count = begin[leaf], begin[leaf + 1], number[leaf]
        neighbours = pool[offset[leaf] : offset[leaf] + count]
        if count + 3 * LANES > room:
            room = columns_for(count)
            sources, rows = whole_lines(room, WIDTH, like), whole_lines(SPREAD, room, like)
            search, index, own = whole_lines(8, room, like), np.empty(room, index.dtype), np.arange(room)
            if sparse:
                near, packed = np.empty(room, pool.dtype), np.empty((room, WIDTH))
        slots = with_room(slots, last - first)
        largest = target_box(position, h, chosen, first, last, box)
        box_centre(box, centre)
        if sparse:
            for k in range(count):
                near[k] = neighbours[k]
            count = close_to(box, support, largest, position, h, near, count)
            for k in range(count):
                pack_row(np.int64(near[k]), k, position, h, mass, support, arrays, packed)
            neighbours = near[:count]
            places(chosen, first, last, neighbours, count, slots)
            set_origin(centre, packed, slots[0], zero)
            copy_rows(packed, own, count, zero, sources)
        else:
            places(chosen, first, last, neighbours, count, slots)
            set_origin(centre, packed, chosen[first], zero)
            copy_rows(packed, neighbours, count, zero, sources)
        for k in range(WIDTH):  # a massless copy of the last source stands at the loose end
            sources[count, k] = sources[count - 1, k]
        sources[count, 3] = 0
        spread_places(sources, own, padded(count), search)
        spread_reaches(sources, own, padded(count), search[4:])
        neighbour_leaf(leaf, first, last, slots, count, sources, rows, search, index, results)
