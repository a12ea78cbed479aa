"""A template: what generated modules hold whose pairs are summed in float32, in coordinates about a centre."""

import numpy as np
from numba import njit

from astroinertia.engines.numba_vectors import PART, where

# Copied into generated modules from here on.
real = np.float32
RELATIVE = True
PAIR_FLAGS = {"contract", "nsz", "arcp", "afn"}


@njit(forceinline=True, fastmath={"contract", "nsz", "arcp", "afn"}, **PART)
def inverse_distance(r2):
    """As in numba_float64."""
    return np.float32(1) / np.sqrt(where(r2 > np.float32(1e-36), r2, np.float32(1e-36)))
