"""The density pass of few particles, a template: as numba_density, but all of them are looked at for every target.

Nothing is gathered and no length outgrows that, which leaves a third of the text to compile.
"""

import numpy as np
from numba import njit

from astroinertia.engines.numba_lengths import solve
from astroinertia.engines.numba_vectors import ENTRY, take

# Copied into generated modules from here on.


@njit(**ENTRY)
def density_pass(counter, sources, chosen, begin, active, h, options, results):
    """Solve for the targets of the leaves that have any.

    sources (4, M): x, y, z and mass, with loose ends; h: first guesses of all.
    """
    lists = np.empty((2, sources.shape[1]))
    waiting = np.empty(sources.shape[1], np.int64)
    while True:
        turn = take(counter)
        if turn >= len(active):
            break
        first, last = begin[active[turn]], begin[active[turn] + 1]
        for t in range(first, last):
            waiting[t - first], results[0, t], results[1, t] = t, h[chosen[t]], np.inf
        solve(waiting, last - first, chosen[first:last], len(h), sources, lists, options, results)
