"""A state as named arrays and back: what a checkpoint holds."""

from typing import Any

import jax
import numpy as np

from astroinertia.integrate.leapfrog import State


def flattened(state: State) -> dict[str, np.ndarray]:
    """Every array of a state under its path."""
    leaves, _ = jax.tree_util.tree_flatten_with_path(state)
    return {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in leaves}


def unflattened(like: State, arrays: dict[str, np.ndarray], xp: Any) -> State:
    """The state of which `arrays` are the leaves; `like` has the same structure."""
    paths, structure = jax.tree_util.tree_flatten_with_path(like)
    return jax.tree_util.tree_unflatten(
        structure, [xp.asarray(arrays[jax.tree_util.keystr(path)]) for path, _ in paths]
    )
