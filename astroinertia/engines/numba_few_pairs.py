"""Sums over all pairs of few particles, a template: as numba_all_pairs, but none are taken for far before.

results: as there. The rows of sources are made by numpy (engines/few_sources.py).
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_all_pairs import near_leaf
from astroinertia.engines.numba_vectors import ENTRY, take

# Copied into generated modules from here on.


@njit(**ENTRY)
def all_pairs_pass(counter, sources, start, results):
    """Sums over all pairs, leaf by leaf; sources: rows of what is asked of each particle, with loose ends."""
    count, leaves = start[-1], len(start) - 1
    key, index, slots = np.empty(sources.shape[1]), np.empty(sources.shape[1], np.int64), np.arange(count)
    while True:
        leaf = take(counter)
        if leaf >= leaves:
            break
        first, last = start[leaf], start[leaf + 1]
        near_leaf(leaf, first, last, slots[first:last], count, sources, sources, key, index, results)
