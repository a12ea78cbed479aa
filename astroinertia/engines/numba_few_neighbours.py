"""Sums over neighbours of few particles, a template: as numba_neighbours, but all are looked at for every target.

arrays, results: as there. What the loop over pairs is given is put in rows by numpy (engines/few_sources.py).
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_neighbours import SPREAD, neighbour_leaf
from astroinertia.engines.numba_parts import whole_lines
from astroinertia.engines.numba_vectors import ENTRY, take

# Copied into generated modules from here on.


@njit(**ENTRY)
def neighbour_pass(counter, table, search, chosen, begin, active, results):
    """Sums for the targets of the leaves that have any.

    table (N + 1, WIDTH): what is asked of each particle, and a massless copy of the last. search (8, M): places
    and, among four columns of the table, squared reaches.
    """
    count = len(table) - 1
    rows, index = whole_lines(SPREAD, search.shape[1], table), np.empty(search.shape[1], np.int64)
    while True:
        turn = take(counter)
        if turn >= len(active):
            break
        leaf = active[turn]
        first, last = begin[leaf], begin[leaf + 1]
        neighbour_leaf(leaf, first, last, chosen[first:last], count, table, rows, search, index, results)
