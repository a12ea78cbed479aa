"""Vectors that have all of their components: a number in place of one would be taken for each of them."""

from typing import Any

import numpy as np


def require_components(count: int = 3, **named: Any) -> None:
    """ValueError names the first argument whose last dimension is not of so many components.

    >>> require_components(axis=[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    """
    for name, value in named.items():
        if (shape := np.shape(value))[-1:] != (count,):
            raise ValueError(f"{name} {shape} must have the shape (..., {count})")


def of_any_length(vector: Any) -> Any:
    """The same direction (..., 3) with a largest component of 1, whose square neither overflows nor vanishes; 0 of 0.

    >>> print(of_any_length(np.array([3e200, 0.0, -4e200])))
    [ 0.75  0.   -1.  ]
    """
    size = abs(vector).max(-1, keepdims=True)
    return vector / (size + (size == 0.0))
