"""Whether values can be looked at, and so refused: JAX traces functions with arrays that have none yet.

Tests: tests/unit/inertia/test_tensor.py, tests/unit/inertia/test_body.py.
"""

import sys
from typing import Any


def is_known(array: Any) -> bool:
    """Whether an array or list has values that can be looked at now: not so inside jax.jit, jax.grad or jax.vmap."""
    # A tracer can only have come from a jax that is already imported, and numpy users need not wait for one.
    if "jax" not in sys.modules:
        return True
    if isinstance(array, list | tuple):
        return all(map(is_known, array))
    return not isinstance(array, sys.modules["jax"].core.Tracer)
