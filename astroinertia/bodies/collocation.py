"""Polynomials through nodes, and Gauss-Legendre collocation of integrals whose kernel is a power.

Tests: through tests/unit/bodies/test_clairaut.py, test_figures.py and test_scf.py, and tests/physics/
test_hydrostatic.py.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np


def lagrange(nodes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values (..., N) at points (...,) of the polynomials that are 1 at one of the nodes (N,) and 0 at the others.

    Both in [-1, 1], the nodes crowded at the ends as Gauss's or Chebyshev's are.

    >>> print(lagrange(np.array([-1.0, 0.0, 1.0]), np.array([0.5])).round(3))
    [[-0.125  0.75   0.375]]
    """
    legendre, order = np.polynomial.legendre.legvander, len(nodes) - 1
    return legendre(at, order) @ np.linalg.inv(legendre(nodes, order))


class Collocation(NamedTuple):
    """A step from 0 to 1 with `count` nodes, and inner integrals that are exact for polynomials times a power.

    nodes, weights (count,): Gauss's. inner_nodes, inner_weights (inner,): of integrals from 0 to each node, or to 1.
    to_node (count, inner, count): the j-th Lagrange polynomial of the nodes at nodes[i] inner_nodes[q]; to_end (inner,
    count): at inner_nodes[q].
    """

    nodes: np.ndarray
    weights: np.ndarray
    inner_nodes: np.ndarray
    inner_weights: np.ndarray
    to_node: np.ndarray
    to_end: np.ndarray


@lru_cache(maxsize=64)
def collocation(count: int, power: int) -> Collocation:
    """The collocation with `count` nodes whose inner integrals are exact for a kernel of degree `power`.

    Source: Hairer, Norsett & Wanner 1993, Solving ODEs I, sec. II.7.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    inner, inner_weights = np.polynomial.legendre.leggauss((count + power) // 2 + 1)
    c, tau = (nodes + 1) / 2, (inner + 1) / 2
    return Collocation(
        c,
        weights / 2,
        tau,
        inner_weights / 2,
        lagrange(nodes, 2 * c[:, None] * tau - 1),
        lagrange(nodes, inner),
    )
