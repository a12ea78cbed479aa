"""The radial mesh and the multipole potential of the self-consistent field solver.

Inside the largest sphere that the body fills (radius `inner`) and between it and the equator (radius 1) stand elements
of Gauss-Legendre nodes. On each sphere q_l(r) is the integral over 0 < mu < 1 of rho P_l(mu), and with G = 1 the
potential of a body that is symmetric about its equator is

    phi(r, mu) = -4 pi sum_l P_l(mu) [ int_0^r q_l (s/r)^(l+1) s ds + int_r^1 q_l (r/s)^l s ds ],   l = 0, 2, 4, ...

q_l is interpolated within each element and its product with the kernel integrated to round-off, so that l is limited by
no quadrature. The elements are equal in t with r = low + (high - low) t^2 (3 - 2t) on both parts: a density that
vanishes as depth^n makes q_l vanish as (1 - r)^(n + 1/2), which is smooth in t for half-integer n, and the centre of a
soft star, which is narrow, has elements enough. Tests: tests/unit/bodies/test_scf.py.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np

from astroinertia.bodies.collocation import lagrange

NODES = 8  # Gauss-Legendre nodes of an element
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(NODES)
_PRODUCT_POINTS = 40  # integrates (s/r)^65 times a polynomial of degree 7 to round-off


@dataclass(frozen=True)
class Mesh:
    """radius (K,) of all nodes and volume_weight (K,): its product with f is the integral of f r^2 dr.

    The first `split` nodes are inside `inner`, parts (P, 2) are the ends of the one or two parts and edges (E + 1,)
    those of the elements. inward and outward (E, L, NODES + 1, NODES) take q_l at an element's nodes to its share of
    the inner and of the outer integral at each node and, last, at the far edge.
    """

    inner: float
    split: int
    parts: np.ndarray
    edges: np.ndarray
    radius: np.ndarray
    volume_weight: np.ndarray
    degrees: np.ndarray
    inward: np.ndarray
    outward: np.ndarray

    def integrals(self, moments: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """int_0^r q_l (s/r)^(l+1) s ds and int_r^1 q_l (r/s)^l s ds, at the nodes (K, L) and at the edges (E + 1, L).

        moments (K, L) are q_l at the nodes.
        """
        elements, count = len(self.edges) - 1, len(self.degrees)
        local = moments.reshape(elements, NODES, count)
        inside = np.einsum("elkj,ejl->ekl", self.inward, local)
        outside = np.einsum("elkj,ejl->ekl", self.outward, local)
        ratio = (self.edges[:-1] / self.edges[1:])[:, None]
        below, above = np.zeros((elements + 1, count)), np.zeros((elements + 1, count))
        for element in range(elements):
            below[element + 1] = below[element] * ratio[element] ** (self.degrees + 1) + inside[element, -1]
            mirror = elements - 1 - element
            above[mirror] = above[mirror + 1] * ratio[mirror] ** self.degrees + outside[mirror, -1]
        r = self.radius.reshape(elements, NODES, 1)
        inner = inside[:, :-1] + below[:-1, None] * (self.edges[:-1, None, None] / r) ** (self.degrees + 1)
        outer = outside[:, :-1] + above[1:, None] * (r / self.edges[1:, None, None]) ** self.degrees
        return inner.reshape(-1, count), outer.reshape(-1, count), below, above

    def potential(self, moments: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """phi_l at the nodes (K, L), at the edges (E + 1, L), and the exterior moments int q_l s^(l+2) ds, (L,).

        moments (K, L) are q_l at the nodes.
        """
        inner, outer, below, above = self.integrals(moments)
        return -4 * math.pi * (inner + outer), -4 * math.pi * (below + above), below[-1]

    def odd(self) -> "Mesh":
        """The same with l = 1, 3, ... in place of 0, 2, ...: for what is symmetric about the equator, with odd m."""
        elements = (len(self.edges) - 1) // len(self.parts)
        return build_mesh(self.inner, elements, int(self.degrees[-1]), hollow=not self.split, odd=True)

    def interpolated(self, values: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return values (K, L) at the nodes interpolated to radius (N,) within the mesh, (N, L)."""
        element = np.clip(np.searchsorted(self.edges, radius, side="right") - 1, 0, len(self.edges) - 2)
        per_part = (len(self.edges) - 1) // len(self.parts)
        low, high = self.parts[element // per_part].T
        share = np.clip((radius - low) / (high - low), 0.0, 1.0)
        # the root of t^2 (3 - 2t) = share, by the cosine formula for the cubic
        t = 0.5 - np.sin(np.arcsin(1 - 2 * share) / 3)
        x = 2 * (t * per_part - element % per_part) - 1
        return np.einsum("nj,njl->nl", lagrange(_NODES, x), values.reshape(-1, NODES, values.shape[1])[element])


def build_mesh(inner: float, elements: int, degree: int, hollow: bool = False, odd: bool = False) -> Mesh:
    """Return the mesh with `elements` inside and as many outside `inner` (0 < inner <= 1), for l = 0, 2, ... degree.

    A hollow mesh, a ring's, has none inside; one with inner = 1, a sphere's, none outside. odd: l = 1, 3, ...
    degree + 1 in place of these. ValueError for other inner.

    >>> mesh = build_mesh(0.8, elements=4, degree=8)
    >>> print(len(mesh.radius), f"{mesh.volume_weight.sum():.9f}", mesh.degrees)  # the integral of r^2 dr to 1 is 1/3
    64 0.333333333 [0 2 4 6 8]
    """
    if not 0 < inner <= 1:
        raise ValueError(f"inner must be above 0 and at most 1, not {inner:g}")
    parts = ([] if hollow else [(0.0, inner)]) + ([(inner, 1.0)] if inner < 1 else [])
    degrees = np.arange(0, degree + 1, 2) + odd
    edges, radius, weight, operators = [0.0 if not hollow else inner], [], [], []
    for low, high in parts:
        for element in range(elements):
            r, slope = _placed(_NODES, low, high, element, elements)
            edges.append(float(_placed(np.array(1.0), low, high, element, elements)[0]))
            radius.append(r)
            weight.append(_WEIGHTS * slope * r**2)
            operators.append(_operators(low, high, element, elements, degrees))
    inward, outward = (np.array(kind) for kind in zip(*operators, strict=True))
    return Mesh(inner, 0 if hollow else NODES * elements, np.array(parts), np.array(edges), np.concatenate(radius),
                np.concatenate(weight), degrees, inward, outward)  # fmt: skip


def _placed(x, low, high, element, elements):
    """Radius and its derivative at the element's own variable x in [-1, 1]."""
    t = (element + (x + 1) / 2) / elements
    return low + (high - low) * t**2 * (3 - 2 * t), (high - low) * 6 * t * (1 - t) / (2 * elements)


def _operators(low, high, element, elements, degrees):
    """Polynomials through an element's nodes times the two kernels, integrated up to and down to its nodes."""
    kernels = []
    for outwards in (False, True):
        ends, x, span, weights, basis = _quadrature(outwards)
        s, slope = _placed(x, low, high, element, elements)
        target = _placed(ends, low, high, element, elements)[0]
        ratio, power = (target / s, degrees) if outwards else (s / target, degrees + 1)
        kernel = ratio ** power[:, None, None] * s * slope * span / 2 * weights
        kernels.append(np.einsum("lkq,kqj->lkj", kernel, basis))
    return tuple(kernels)


@functools.cache
def _quadrature(outwards: bool) -> tuple[np.ndarray, ...]:
    # From the lower edge up to each node and the upper edge, or from the upper edge down to each and the lower, in the
    # element's own variable, the same in all: ends of the intervals, points within them, lengths, weights, and at those
    # points the polynomials that are 1 at one node.
    points, weights = np.polynomial.legendre.leggauss(_PRODUCT_POINTS)
    ends = np.append(_NODES, -1.0 if outwards else 1.0)[:, None]
    start = 1.0 if outwards else -1.0
    x = start + (ends - start) * (points + 1) / 2
    return ends, x, np.abs(ends - start), weights, lagrange(_NODES, x)


def even_legendre(mu: np.ndarray, degree: int) -> np.ndarray:
    """P_l(mu) for l = 0, 2, ... degree, on a new first axis (L, ...).

    >>> print(even_legendre(np.array([0.0, 1.0]), 4))  # P_0, P_2, P_4
    [[ 1.     1.   ]
     [-0.5    1.   ]
     [ 0.375  1.   ]]
    """
    shape = np.shape(mu)
    square = np.square(np.asarray(mu, dtype=float).ravel())
    table = np.empty((degree // 2 + 1, square.size))
    table[0], before = 1.0, 0.0
    for row in range(degree // 2):
        # Bonnet's rule taken twice: P_(l+2) from P_l and P_(l-2).
        l = 2 * row  # noqa: E741 (the field's letter)
        first = (2 * l + 1) * (2 * l + 3) / ((l + 1) * (l + 2))
        middle = (l + 1) ** 2 / ((2 * l + 1) * (2 * l + 3)) + l**2 / ((2 * l + 1) * (2 * l - 1))
        following = table[row + 1]
        np.subtract(square, middle, out=following)
        following *= table[row]
        following -= before
        following *= first
        # The share of P_l in the next: (l + 1) (l + 2)/((2 l + 3) (2 l + 5)) of it.
        before = table[row] * ((l + 1) * (l + 2) / ((2 * l + 3) * (2 * l + 5)))
    return table.reshape(len(table), *shape)
