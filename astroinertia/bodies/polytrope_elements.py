"""Spectral elements along a polytrope: quadrature nodes, its structure there, and bases of orthonormal polynomials.

The first element runs in the radius up to xi = 1, the others in t with theta = t^4 or t^2 to the surface t = 0:
powers of theta, which are not smooth in the radius, are smooth enough in t. Lengths are in units of R, masses of M and
G = 1: dm/dx = density x^2, gravity = m/x^2, pressure = density enthalpy/(n + 1).
Source: Karniadakis & Sherwin 2005, Spectral/hp Element Methods, ch. 2. Tests: tests/unit/bodies/test_oscillations.py.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space, solve_triangular
from scipy.special import eval_jacobi, roots_jacobi, roots_legendre

from astroinertia.bodies.polytrope import HANDOVER, lane_emden, nodes_of

_STEEP = 1.5  # index from which theta = t^2 is smooth enough; below it t^4 is taken, which large n would make too flat
_CONDENSED = 2.5  # index from which the envelope needs more than two elements, each half as far out as the one before
BUOYANT = 0.01  # index from which the energy of buoyancy is calculated by itself: it diverges at the surface as n -> 0
_EXTRA_NODES = 24  # of the quadrature beyond the number of polynomials: the structure is no polynomial


@dataclass(frozen=True)
class Basis:
    """Functions at the quadrature nodes: values and derivatives by x (node, function), and values at the surface."""

    values: np.ndarray
    slopes: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True)
class Elements:
    """The structure of a polytrope at the nodes of all elements; `weights` integrates over x = r/R."""

    index: float
    polynomials: int
    power: int  # k of the variable t, theta = t^k
    x: np.ndarray
    weights: np.ndarray
    density: np.ndarray
    gravity: np.ndarray
    enthalpy: np.ndarray
    _s: np.ndarray  # the coordinate of every element at its nodes, -1 to 1, one row an element
    _slope: np.ndarray  # dx/ds, one row an element

    @property
    def pressure(self) -> np.ndarray:
        """Pressure at the nodes."""
        return self.density * self.enthalpy / (self.index + 1)

    @property
    def mass_weights(self) -> np.ndarray:
        """Weights of the integral over x with density x^4: the mass of a displacement x y."""
        return self.weights * self.density * self.x**4

    @property
    def mass_power(self) -> float:
        """The power of t with which mass_weights fall at the surface."""
        return self.power * (self.index + 1) - 1

    def basis(
        self,
        count: int,
        surface_power: float,
        weights: np.ndarray,
        slope_weights: np.ndarray | None = None,
    ) -> Basis:
        """So many polynomials an element, orthonormal with `weights`, which fall as t^surface_power at the surface.

        With slope_weights, for the slopes in the same inner product, the functions are continuous, and their slope by
        t vanishes at the surface as t^(power - 1), as it does for whatever is smooth in the radius.
        """
        elements, nodes = self._s.shape
        smooth = slope_weights is not None
        values = np.zeros((elements * nodes, elements * count))
        slopes = np.zeros_like(values)
        left, right = np.zeros((2, elements, elements * count))
        for element in range(elements):
            last = element == elements - 1
            rows, columns = (slice(element * size, (element + 1) * size) for size in (nodes, count))
            powers = (surface_power if last else 0.0, 4.0 if element == 0 else 0.0)
            v, d, ends = _polynomials(count, powers, self._s[element], self.power if smooth and last else 0)
            d /= self._slope[element][:, None]
            product = np.sqrt(weights[rows])[:, None] * v
            if slope_weights is not None:
                product = np.concatenate([product, np.sqrt(slope_weights[rows])[:, None] * d])
            triangle = np.linalg.qr(product, mode="r")
            v, d, ends = (solve_triangular(triangle, part.T, trans=1).T for part in (v, d, ends))
            values[rows, columns], slopes[rows, columns] = v, d
            left[element, columns], right[element, columns] = ends
        surface = right[-1]
        if smooth:
            joined = null_space(right[:-1] - left[1:])
            values, slopes, surface = values @ joined, slopes @ joined, surface @ joined
        return Basis(values, slopes, surface)


def _polynomials(count: int, powers: tuple[float, float], s: np.ndarray, flat: int):
    """Values and slopes at s and values at both ends of Jacobi polynomials; flat: 1 and (1 - s)^flat times them."""
    a, b = powers
    at = np.concatenate([s, [-1.0, 1.0]])
    degrees = np.arange(count - 1 if flat else count)
    v = eval_jacobi(degrees, a, b, at[:, None])
    d = 0.5 * (degrees + a + b + 1) * np.where(degrees > 0, eval_jacobi(degrees - 1, a + 1, b + 1, s[:, None]), 0.0)
    scale = np.sqrt((2 * degrees + a + b + 1) / 2.0 ** (a + b + 1))
    v, d = v * scale, d * scale
    if flat:
        depth, depths = (1 - s)[:, None], (1 - at)[:, None]
        d = np.concatenate([np.zeros((len(s), 1)), depth**flat * d - flat * depth ** (flat - 1) * v[:-2]], axis=1)
        v = np.concatenate([np.ones((len(at), 1)), depths**flat * v], axis=1)
    return v[:-2], d, v[-2:]


def polytrope_elements(index: float, polynomials: int) -> Elements:
    """Return the elements of the polytrope of `index`, 0 <= n < 5, with so many polynomials each.

    Checked by tests/unit/bodies/test_oscillations.py: the masses of the nodes add up to 1.
    """
    n = float(index)
    power = 4 if n < _STEEP else 2
    envelope = 2 if n < _CONDENSED else 4
    solution = lane_emden(n)
    nodes = polynomials + _EXTRA_NODES
    s, quadrature = (np.tile(part, (envelope + 1, 1)) for part in roots_legendre(nodes))
    if BUOYANT <= n < 1:  # buoyancy and compression of an outer layer go as this power of t, which is singular
        surface = power * n - 1
        s[-1], quadrature[-1] = roots_jacobi(nodes, surface, 0.0)
        quadrature[-1] /= (1 - s[-1]) ** surface
    edges = np.append(0.5 ** np.arange(envelope), 0.0)
    width = -0.5 * np.diff(edges)[:, None]
    core = 0.5 * HANDOVER * (1 + s[0])
    share = edges[:-1, None] - width * (1 + s[1:])
    xi, theta, mass = nodes_of(n, core, share.ravel() ** (power / 4))
    start = float(solution.theta_at(HANDOVER)) ** (1 / power)
    outside = slice(nodes, None)
    inverse_gradient = (xi[outside] ** 2 / mass[outside]).reshape(share.shape)
    slope = inverse_gradient * power * (start * share) ** (power - 1) * start * width
    radius, total = solution.xi_1, solution.surface_mass
    slope = np.concatenate([np.full((1, nodes), 0.5 * HANDOVER), slope]) / radius
    return Elements(
        index=n,
        polynomials=polynomials,
        power=power,
        x=xi / radius,
        weights=(slope * quadrature).ravel(),
        density=theta**n * radius**3 / total,
        gravity=mass / total * (radius / xi) ** 2,
        enthalpy=theta * radius / total,
        _s=s,
        _slope=slope,
    )
