"""How large a quantity gets."""

from typing import Any

import numpy as np


def largest_size(values: Any, unknown: float = 0.0) -> float:
    """The largest size of a number in values of any shape; `unknown` where none is known, that is, where all are NaN.

    >>> largest_size([[1.0, -3.0], [np.nan, 2.0]])
    3.0
    """
    return float(np.fmax.reduce(np.abs(np.asarray(values, dtype=float)), axis=None, initial=unknown))
