"""A state as named arrays and back: what a checkpoint holds, and what is required of one that may come from anywhere.

Tests: tests/unit/models/test_checkpoint.py, tests/hard/test_altered_folders.py.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from astroinertia.engines.pytree import named_leaves, with_leaves
from astroinertia.models.sph.state import State

LARGEST = 1e100  # no number of a state is larger: its square and its cube are still numbers
SIZE = (0.0, LARGEST)  # of what is not negative
LATE = 1e-9  # a run may end so much later than it should, over its length
COUNT = (0, 2**53)
POSITIVE = (5e-324, LARGEST)
_OF_SCENE = ".orbits."  # in a path: what the scene says, which may go on to a later end than when it was saved


def flattened(state: State) -> dict[str, np.ndarray]:
    """Every array of a state under its path, but for known orbits of companions."""
    return {path: np.asarray(leaf) for path, leaf in named_leaves(state).items() if _OF_SCENE not in path}


def unflattened(like: State, arrays: Mapping[str, np.ndarray], xp: Any) -> State:
    """The state of which `arrays` are the leaves; `like` has the same structure, and known orbits."""
    leaves = named_leaves(like).items()
    return with_leaves(like, {path: xp.asarray(leaf if _OF_SCENE in path else arrays[path]) for path, leaf in leaves})


def length(arrays: Mapping[str, np.ndarray], name: str) -> int:
    """The length of a list of numbers; ValueError where it is missing or something else."""
    array = arrays.get(name)
    if array is None or array.ndim != 1 or array.dtype != np.float64:
        raise ValueError(f"it has no list of numbers {name!r}")
    return len(array)


def check(
    arrays: Mapping[str, np.ndarray], like: Mapping[str, tuple[np.dtype, tuple[int, ...]]],
    limits: Mapping[str, tuple[float, float]],
) -> None:  # fmt: skip
    """ValueError, in a sentence, where the arrays of a checkpoint are not those of a state.

    like: the dtype and the shape of each array. limits: the least and the largest value of arrays by the last part of
    their names; all numbers are finite and within LARGEST of zero. Other arrays there may be, and are not read.
    """
    if missing := [name for name in like if name not in arrays]:
        raise ValueError(f"it lacks the array {missing[0]!r:.80}")
    for name, (dtype, shape) in like.items():
        array = arrays[name]
        if array.dtype != dtype or array.shape != shape:
            raise ValueError(f"{name!r} is {array.dtype} of shape {array.shape}, and must be {dtype} of shape {shape}")
        if array.dtype.kind == "f" and not (np.abs(array) <= LARGEST).all():
            raise ValueError(f"{name!r} has values that are not finite, or larger than {LARGEST:g}")
        least, largest = limits.get(name, (-np.inf, np.inf))
        if array.size and not least <= array.min() <= array.max() <= largest:
            raise ValueError(f"{name!r} has values beyond {least:g} to {largest:g}")


def described(arrays: Mapping[str, np.ndarray]) -> dict[str, tuple[np.dtype, tuple[int, ...]]]:
    """The dtype and the shape of each array."""
    return {name: (array.dtype, array.shape) for name, array in arrays.items()}
