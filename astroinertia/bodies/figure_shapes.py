"""Level surfaces of a rotating body by multipoles, to any order in the rotation: one sweep and its acceleration.

The surface of mean radius s (that of the sphere of equal volume) is r(s, mu) = s x(s, mu), known at Gauss-Legendre
points of mu = cos(colatitude). Without any series in the small parameter, with U = G M/R u, M = R = G = 1,

    u(r, mu) = sum_k P_2k(mu) [r^-(2k+1) D_2k(s) + r^2k E_2k(s)] + (m/2) r^2 (1 - mu^2),
    D_2k(s) = 4 pi int_0^s rho d<r^(2k+3) P_2k>/(2k + 3),    E_2k(s) = 4 pi int_s^1 rho d<r^(2-2k) P_2k>/(2 - 2k)

(for 2k = 2 the mean of ln r), where < > is the mean over mu, is made constant on every surface. By parts the body
becomes a pile of homogeneous ones, of density -drho each, and the terms at s itself add up to -(2 pi/3) rho(s) r^2, the
potential of a uniform medium, exactly instead of as a sum over harmonics:

    u = -(2 pi/3) rho r^2 + sum_k P_2k [r^-(2k+1) D'_2k + r^2k E'_2k] + (m/2) r^2 (1 - mu^2),
    D'_2k = -4 pi int_0^s <r^(2k+3) P_2k> drho/(2k + 3),    E'_2k = -4 pi int_s^1 <r^(2-2k) P_2k> drho/(2 - 2k).

A homogeneous spheroid of any flattening then needs P_0 and P_2 alone: inside it <r^(2-2k) P_2k> vanishes for 2k > 2.

Source: Zharkov & Trubitsyn 1978, Physics of Planetary Interiors, ch. 3 (eqs 27.1 to 28.12), before their expansion in
m; validity of the multipoles on the surfaces: Hubbard, Schubert, Kong & Zhang 2014, Icarus 242, 138.
Tests: tests/unit/bodies/test_figures.py.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from astroinertia.bodies.anderson import Anderson
from astroinertia.bodies.figure_layers import Layer
from astroinertia.bodies.scf_mesh import even_legendre
from astroinertia.errors import NumericalError

_NEWTON_STEPS = 12
_HISTORY = 20  # earlier sweeps that Anderson's acceleration mixes in
_SHAPE_TOLERANCE = 2e-15
_NO_EQUILIBRIUM = "no figure of equilibrium was found: the body turns too fast, or its shape is beyond the expansion"


@dataclass(frozen=True, eq=False)
class Angles:
    """Gauss-Legendre points of mu in (0, 1), their weights (sum 1) and P_2k at them, (harmonic, point)."""

    mu: np.ndarray
    weights: np.ndarray
    legendre: np.ndarray


def angles(points: int, harmonics: int) -> Angles:
    """Return the points of one hemisphere for harmonics P_0 to P_(2 `harmonics`)."""
    mu, weights = np.polynomial.legendre.leggauss(2 * points)
    mu, weights = mu[points:], weights[points:]
    return Angles(mu, weights / weights.sum(), even_legendre(mu, 2 * harmonics))


@dataclass(frozen=True, eq=False)
class Field:
    """The multipoles at all nodes, in M = R = 1, each on the inner side of a jump of density at its surface.

    outer = D'_2k/s^(2k+3) and inner = E'_2k s^(2k-2), (harmonic, node), inner 0 for k = 0; constant: E'_0; medium:
    -(2 pi/3) rho, the factor of r^2; exterior: D_2k of the whole body, seen from outside.
    """

    outer: np.ndarray
    inner: np.ndarray
    constant: np.ndarray
    medium: np.ndarray
    exterior: np.ndarray


def node_ranges(layers: Sequence[Layer]) -> list[slice]:
    """Where the nodes of each layer are among those of all."""
    ends = np.cumsum([0, *(len(layer.radius) for layer in layers)])
    return [slice(start, end) for start, end in pairwise(ends)]


def multipoles(layers: Sequence[Layer], x: np.ndarray, densities: Sequence[np.ndarray], sphere: Angles) -> Field:
    """Return the multipoles of surfaces x (node, point) with densities at the nodes of each layer, all in M = R = 1."""
    harmonics = len(sphere.legendre) - 1
    factor = 4 * np.pi / (2.0 * np.arange(harmonics + 1) + 3)
    square = x * x
    power, down = square * x, np.ones_like(x)
    weighted = sphere.weights * sphere.legendre
    phi, psi = np.empty((harmonics + 1, len(x))), np.empty((harmonics + 1, len(x)))
    phi[0], psi[0] = power @ weighted[0], square @ weighted[0]
    for k in range(1, harmonics + 1):
        power = power * square
        phi[k] = power @ weighted[k]
        if k == 1:
            psi[1] = np.log(x) @ weighted[1]
        else:
            down = down / square
            psi[k] = down @ weighted[k]
    parts = node_ranges(layers)
    changes = [layer.slope @ density for layer, density in zip(layers, densities, strict=True)]
    beyond = [*(density[0] for density in densities[1:]), 0.0]
    jumps = [next_density - density[-1] for next_density, density in zip(beyond, densities, strict=True)]

    outer, inner = np.empty_like(phi), np.empty_like(psi)
    below = np.zeros(harmonics + 1)
    for layer, part, change, jump in zip(layers, parts, changes, jumps, strict=True):
        outer[:, part] = layer.up * below[:, None] + np.einsum("kim,km->ki", layer.inner, phi[:, part] * change)
        below = outer[:, part][:, -1] + phi[:, part][:, -1] * jump
    above, above_constant = np.zeros(harmonics + 1), 0.0
    for layer, part, change, jump in reversed(list(zip(layers, parts, changes, jumps, strict=True))):
        here = psi[:, part]
        above = above + here[:, -1] * jump
        above_constant += layer.top**2 * here[0, -1] * jump
        within = np.einsum("kim,km->ki", layer.outer, here * change)
        inner[:, part] = layer.down * above[:, None] + within
        inner[0, part] = above_constant + within[0]
        above, above_constant = inner[:, part][:, 0], inner[0, part][0]
    constant = -2 * np.pi * inner[0]
    inner[0] = 0.0
    inner[1] *= -4 * np.pi
    inner[2:] *= 4 * np.pi / (2.0 * np.arange(2, harmonics + 1)[:, None] - 2)
    return Field(
        outer=-factor[:, None] * outer,
        inner=inner,
        constant=constant,
        medium=-2 * np.pi / 3 * np.concatenate(densities),
        exterior=-factor * below,
    )


def potential(field: Field, nodes, x: np.ndarray, legendre: np.ndarray, spin: np.ndarray):
    """Return the scaled potential (u - E'_0)/s^2 on the surfaces x of `nodes`, and its slope by x.

    spin = (m/2) (1 - mu^2) at the points.
    """
    outer, inner = field.outer[:, nodes, None], field.inner[:, nodes, None]
    square = x * x
    inverse = 1 / square
    quadratic = spin + field.medium[nodes, None]
    fall, fall_slope = np.zeros_like(x), np.zeros_like(x)
    rise, rise_slope = np.zeros_like(x), np.zeros_like(x)
    for k in reversed(range(1, len(outer))):
        term = outer[k] * legendre[k]
        fall = (fall + term) * inverse
        fall_slope = (fall_slope + (2 * k + 1) * term) * inverse
        term = inner[k] * legendre[k]
        rise = rise * square + term
        rise_slope = rise_slope * square + 2 * k * term
    value = (fall + outer[0]) / x + (rise + quadratic) * square
    slope = (rise_slope + 2 * quadratic) * x - (fall_slope + outer[0]) * inverse
    return value, slope


def level_surfaces(field: Field, x: np.ndarray, small_m: float, sphere: Angles) -> tuple[np.ndarray, np.ndarray]:
    """Return the surfaces (node, point) of constant potential with mean radius s, and their scaled potential.

    Newton's method from x, at each mu by itself, with the volume <x^3> = 1 as the condition for the level. Raises
    NumericalError where gravity does not point inwards or the steps do not converge.
    """
    spin = 0.5 * small_m * (1 - sphere.mu**2)
    for _ in range(_NEWTON_STEPS):
        value, slope = potential(field, slice(None), x, sphere.legendre, spin)
        if not (slope.max() < 0):
            raise NumericalError(_NO_EQUILIBRIUM)
        square = x * x
        gain = square / slope
        level = ((1 - square * x) / 3 + gain * value) @ sphere.weights / (gain @ sphere.weights)
        step = (level[:, None] - value) / slope
        x = np.clip(x + step, 0.5 * x, 2 * x)
        if np.abs(step).max() < _SHAPE_TOLERANCE**0.5:  # quadratic: the step after it would be below round-off
            return x, level
    raise NumericalError(_NO_EQUILIBRIUM)


def radii_at(field: Field, nodes: slice, level: np.ndarray, mu: float, small_m: float, guess: np.ndarray) -> np.ndarray:
    """Return r/s (node,) at one mu of the surfaces of `nodes`, whose scaled potentials are `level`: Newton's method."""
    legendre = even_legendre(np.array([mu]), 2 * (len(field.outer) - 1))
    spin = np.array([0.5 * small_m * (1 - mu**2)])
    x = guess[:, None]
    for _ in range(_NEWTON_STEPS):
        value, slope = potential(field, nodes, x, legendre, spin)
        if not slope.max() < 0:
            break
        step = (level[:, None] - value) / slope
        x = x + step
        if np.abs(step).max() < _SHAPE_TOLERANCE**0.5:
            return x[:, 0]
    raise NumericalError(_NO_EQUILIBRIUM)


def fixed_point(
    sweep: Callable[[np.ndarray], np.ndarray], start: np.ndarray, tolerance: float, most: int
) -> tuple[np.ndarray, int]:
    """Return z = sweep(z) and the sweeps taken, by Anderson's acceleration; NumericalError after `most` sweeps."""
    z, mixed = start, Anderson(_HISTORY)
    for sweeps in range(1, most + 1):
        image = sweep(z)
        change = np.abs(image - z).max()
        if not np.isfinite(change):
            raise NumericalError(_NO_EQUILIBRIUM)
        if change < tolerance:
            return image, sweeps
        z = mixed.next(z, image)
    raise NumericalError(f"the figure did not converge in {most} sweeps: {_NO_EQUILIBRIUM}")
