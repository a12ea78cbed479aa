"""Derivatives by a parameter, carried along an evolution: the variational equations of any rate or step.

A parameter reaches an evolution through its first state and the numbers of its equations. Their derivatives are
differences of states a little to either side of it; with D(h) the central difference, (4 D(h/2) - D(h))/3 is of fourth
order in h (Richardson 1911, Philosophical Transactions A 210, 307). From there on they follow the linearised equations,
exactly, by forward-mode differentiation. Tests: tests/unit/engines/test_variational.py.
"""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

Tree = Any

_SMALL = 1e-6  # a leaf whose numbers are all below is round-off to those that are of order 1
SIDES = (-1.0, -0.5, 0.5, 1.0)  # of a step h, at which four states or runs are compared


def derivative(four: Sequence[Any], step: float) -> tuple[Any, Any]:
    """The fourth-order derivative of values at SIDES of a step, and its distance from that of second order."""
    far, near = (four[3] - four[0]) / (2 * step), (four[2] - four[1]) / step
    best = (4 * near - far) / 3
    return best, abs(best - near)


def slopes(trees: Sequence[Tree], step: float) -> tuple[Tree, float]:
    """The derivative of a pytree from four of it at SIDES of a step, and by how far its numbers jump.

    None stands for leaves that are no real numbers. The second is the largest error of the derivative, over the size of
    the leaf and of its derivative: of the order of step^2, and 1/step where numbers jump. ValueError for pytrees that
    differ in more than real numbers.
    """
    leaves, structure = zip(*map(jax.tree.flatten, trees), strict=True)
    if len(set(structure)) > 1:
        raise ValueError("the states are not of one structure")
    answers, jump = [], 0.0
    for four in zip(*leaves, strict=True):
        arrays = [np.asarray(leaf) for leaf in four]
        if len({array.shape for array in arrays}) > 1:
            raise ValueError("the states are not of one structure")
        same = np.all([array == arrays[0] for array in arrays], axis=0)
        if arrays[0].dtype.kind != "f":
            if not same.all():
                raise ValueError("the states differ in whole numbers")
            answers.append(None)
            continue
        with np.errstate(invalid="ignore"):  # infinities that stay
            best, error = (np.where(same, 0.0, part) for part in derivative(arrays, step))
        if best.size:
            size = np.linalg.norm(np.where(np.isfinite(arrays[0]), arrays[0], 0.0))
            jump = max(jump, float(np.linalg.norm(error) / max(np.linalg.norm(best), size, _SMALL)))
        answers.append(best)
    return jax.tree.unflatten(structure[0], answers), jump


def beside(tree: Tree, slope: Tree, distance: float) -> Tree:
    """The pytree so far from itself along a derivative, as `slopes` gives it; as numpy arrays where it moves."""
    leaves, structure = jax.tree.flatten(tree)
    parts = structure.flatten_up_to(slope)
    moved = [leaf if part is None else np.asarray(leaf) + distance * np.asarray(part)
             for leaf, part in zip(leaves, parts, strict=True)]  # fmt: skip
    return jax.tree.unflatten(structure, moved)


def pushed(function: Callable[[Tree], Tree], tree: Tree, slope: Tree) -> tuple[Tree, Tree]:
    """function(tree) and its derivative where that of the tree is `slope`: jax.jvp of the leaves that have one.

    In the derivative, too, None stands for leaves that are no real numbers.
    """
    leaves, structure = jax.tree.flatten(tree)
    parts = structure.flatten_up_to(slope)
    places = [place for place, part in enumerate(parts) if part is not None]

    def of_moving(values: list[Any]) -> Tree:
        filled = dict(enumerate(leaves)) | dict(zip(places, values, strict=True))
        return function(jax.tree.unflatten(structure, list(filled.values())))

    at = [jnp.asarray(leaves[place], dtype=float) for place in places]
    along = [jnp.asarray(parts[place], dtype=float) for place in places]
    value, change = jax.jvp(of_moving, (at,), (along,))
    return value, jax.tree.map(lambda part: None if part.dtype == jax.dtypes.float0 else part, change)
