"""Functions of JAX that compute in 64 bits wherever they are called from, and set nothing for anyone else."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from astroinertia.engines.brief import brief
from astroinertia.process.known import is_known


def double_precision(*static: str) -> Callable[[Callable], Callable]:
    """Decorate a function of pytrees: compiled, in 64 bits, with the arguments named in `static` as constants.

    Called within jax.enable_x64(True), the function is an ordinary one of JAX: arrays of JAX come back, and vmap and
    grad apply. Called outside, it gives numpy arrays, lest the next operation silently round them to 32 bits; a batch
    or a gradient taken outside would have been rounded already and is a ValueError. Static arguments that a caller
    leaves out take their defaults. Series of xarray, of which JAX knows nothing, are arrays to it. Checked by
    tests/unit/bodies/test_layered.py.

    >>> print(f"{double_precision()(jax.numpy.sqrt)(2.0):.15f}")
    1.414213562373095
    """

    def decorate(function: Callable) -> Callable:
        compiled = brief(function, static_argnames=static)

        @functools.wraps(function)
        def called(*args: Any, **kwargs: Any) -> Any:
            args, kwargs = jax.tree.map(_without_labels, (args, kwargs))
            if jax.config.jax_enable_x64:  # type: ignore[attr-defined]
                return compiled(*args, **kwargs)
            if not all(is_known(leaf) for leaf in jax.tree.leaves((args, kwargs))):
                raise ValueError("take gradients and batches of layered bodies within jax.enable_x64(True)")
            with jax.enable_x64(True):
                return jax.tree.map(np.array, compiled(*args, **kwargs))

        return called

    return decorate


def _without_labels(leaf: Any) -> Any:
    return leaf.values if hasattr(type(leaf), "dims") else leaf
