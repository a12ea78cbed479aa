"""Layers of a figure of equilibrium: nodes of the mean radius, and the integrals over it that the multipoles need.

A body is cut at its jumps of density into layers; in each, functions of the mean radius s are polynomials through
Chebyshev points of a coordinate x in [-1, 1]. With powers of s scaled by the radius where they are wanted, no harmonic
under- or overflows at the centre:

    inner_k(s) = int_0^s (s'/s)^(2k+3) f drho,    outer_k(s) = int_s^1 (s/s')^(2k-2) f drho.

Tests: tests/unit/bodies/test_figures.py.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from astroinertia.bodies.collocation import lagrange

FEWEST_NODES = 6  # of a thin layer
_PANEL_RATIO = 2.5  # of the radii at the ends of one panel of the outer integral: (s/s')^(2k-2) falls steeply
_MOST_PANELS = 12
_TALLEST = 3.0
_STEEP_INDEX = 0.8


@dataclass(frozen=True, eq=False)
class Layer:
    """One layer between the mean radii `bottom` and `top`.

    radius: the nodes, ascending; below_top: top - radius without cancellation. inner (harmonic, node, node) takes
    f drho/dx at the nodes to the integral from `bottom` to each node; outer to that from each node to `top` (of s'^2 f,
    not scaled, for harmonic 0, of f itself for harmonic 2). slope: d/dx at the nodes.
    """

    bottom: float
    top: float
    radius: np.ndarray
    below_top: np.ndarray
    slope: np.ndarray
    inner: np.ndarray
    outer: np.ndarray
    up: np.ndarray  # (bottom/s)^(2k+3)
    down: np.ndarray  # (s/top)^(2k-2), 1 for harmonic 0


def node_count(bottom: float, top: float, nodes: int, surface_power: float) -> int:
    """Return the number of nodes of a layer when one that reaches the centre has `nodes`: thin layers need fewer.

    Not so at a surface where the density falls with a broken power of the depth, however thin the layer.
    """
    if surface_power != 1:
        return nodes
    return min(nodes, FEWEST_NODES + math.ceil((nodes - FEWEST_NODES) * (1 - (bottom / top) ** 2)))


def cut_tall_layers(edges: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Return edges with every layer outside the innermost cut to a top below `_TALLEST` bottoms, and whose part it is.

    The field around a small core falls as a power of the radius, which no short polynomial follows over decades.
    """
    finer, owner = [edges[0], edges[1]], [0]
    for number, (bottom, top) in enumerate(pairwise(edges[1:]), start=1):
        parts = math.ceil(math.log(top / bottom) / math.log(_TALLEST) - 1e-9)
        finer.extend(bottom * (top / bottom) ** (np.arange(1, parts + 1) / parts))
        owner.extend([number] * parts)
        finer[-1] = top
    return np.array(finer), owner


def _differentiation(x: np.ndarray) -> np.ndarray:
    """The matrix d/dx at Chebyshev points."""
    order = len(x) - 1
    slopes = chebyshev.chebvander(x, order - 1) @ chebyshev.chebder(np.eye(order + 1))
    return slopes @ np.linalg.inv(chebyshev.chebvander(x, order))


@lru_cache(maxsize=256)
def layer(bottom: float, top: float, surface_power: float, count: int, harmonics: int) -> Layer:
    """Return the layer with `count` nodes, ascending in s, for harmonics of degree 0 to 2 `harmonics`."""
    x = -np.cos(np.pi * np.arange(count) / (count - 1))
    depth = np.sin(np.pi * np.arange(count)[::-1] / (2 * (count - 1))) ** 2  # (1 - x)/2 without cancellation
    thickness = top - bottom

    def radius_of_depth(depth):
        return top - thickness * depth**surface_power

    radius = radius_of_depth(depth)
    radius[0] = bottom
    points, point_weights = np.polynomial.legendre.leggauss(count // 2 + harmonics + 8)
    points, point_weights = (points + 1) / 2, point_weights / 2
    degree = 2 * np.arange(harmonics + 1)

    # The fraction (s'/s)^(2k+3), from `bottom` to each node: one panel.
    width = x - x[0]
    inside = x[0] + width[:, None] * points
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(radius[:, None] > 0, radius_of_depth((1 - inside) / 2) / radius[:, None], 0.0)
    powers = np.clip(ratio, 0, 1) ** (degree[:, None, None] + 3) * (point_weights * width[:, None])
    inner = np.einsum("kig,igm->kim", powers, lagrange(x, inside))

    # (s/s')^(2k-2), from each node to `top`: panels in geometric progression of s'.
    lowest = radius[1] if bottom == 0 else bottom
    panels = int(np.clip(math.ceil(math.log(top / lowest) / math.log(_PANEL_RATIO)), 1, _MOST_PANELS))
    start = np.where(radius > 0, radius, radius[1] / 2)[:, None]
    edges = start * (top / start) ** (np.arange(panels + 1) / panels)
    edges[:, -1] = top
    if bottom == 0:
        edges[0, 0] = 0.0
    edge_x = 1 - 2 * np.clip((top - edges) / thickness, 0, 1) ** (1 / surface_power)
    edge_x[:, 0] = x
    spans = np.diff(edge_x, axis=1)
    inside = (edge_x[:, :-1, None] + spans[:, :, None] * points).reshape(count, -1)
    share = (spans[:, :, None] * point_weights).reshape(count, -1)
    there = radius_of_depth((1 - inside) / 2)
    powers = np.clip(radius[:, None] / there, 0, 1) ** np.maximum(degree[:, None, None] - 2, 0)
    powers[0] = there**2
    outer = np.einsum("kig,igm->kim", powers * share, lagrange(x, inside))

    with np.errstate(divide="ignore", invalid="ignore"):
        up = np.where(radius > 0, bottom / radius, 0.0) ** (degree[:, None] + 3)
    return Layer(
        bottom=bottom,
        top=top,
        radius=radius,
        below_top=thickness * depth**surface_power,
        slope=_differentiation(x),
        inner=inner,
        outer=outer,
        up=up,
        down=(radius / top) ** np.maximum(degree[:, None] - 2, 0),
    )


def surface_power(index: float) -> float:
    """Return a power p for which d = u^p and the density d^index of depth d are smooth enough in u (index > 0).

    Both are powers of u with whole exponents where that takes p <= 4; else one of them is (the density's, if it
    rises more steeply than d), and the other has an exponent of 5 or more.
    """
    for power in range(1, 5):
        if abs(power * index - round(power * index)) < 1e-9:
            return float(power)
    return float(max(2, math.ceil(6 / index))) if index > _STEEP_INDEX else math.ceil(5 * index) / index
