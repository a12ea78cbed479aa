"""A template: what generated modules hold whose pairs are summed in float64."""

import numpy as np
from numba import njit

from astroinertia.engines.numba_vectors import INNER, reciprocal_root, where

# Copied into generated modules from here on.
real = np.float64
RELATIVE = False  # whether sources lie in coordinates about a centre
PAIR_FLAGS = {"contract", "nsz"}


@njit(forceinline=True, **INNER)
def inverse_distance(r2):
    """1/sqrt(r2), which keeps clear of 0 without a branch: it is finite there, and multiplies separations of 0."""
    return reciprocal_root(where(r2 > 1e-290, r2, 1e-290))
