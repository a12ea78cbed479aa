"""Spheres of layers whose density is a polynomial in x = r/R: every integral over them is exact.

Constant and linear layers are special cases, and a table is one linear layer between each two of its rows. All of it is
JAX: jit, vmap and grad apply to any function of a `LayeredBody` within jax.enable_x64(True). Masses, radii and G are in
any consistent units. The radius that normalises a moment ratio is the mean radius R, that of the sphere.

Sources: Dziewonski & Anderson 1981, PEPI 25, 297 (layers as polynomials); the integrals are elementary.
Tests: tests/unit/bodies/test_layered.py, tests/hard/test_layered_hard.py.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.inertia.double_precision import double_precision
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities

Array = Any


@pytree
@dataclass(frozen=True)
class LayeredBody:
    """Layers from the centre to the surface; a JAX pytree, made by the functions below, which check their arguments.

    outer_radii: (layers,), ascending, the last is the mean radius R; coefficients: (layers, terms), the density of a
    layer is the sum of c_k (r/R)^k. A layer of no thickness is allowed and changes nothing.
    """

    outer_radii: Array
    coefficients: Array
    gravitational_constant: Array = 1.0

    @property
    def mean_radius(self) -> Array:
        """R, the radius of the sphere."""
        return self.outer_radii[-1]

    @property
    @double_precision()
    def mass(self) -> Array:
        """M, exact."""
        return _FOUR_PI * self.mean_radius**3 * jnp.sum(shell_integrals(self, 2))

    @property
    @double_precision()
    def layer_masses(self) -> Array:
        """The mass (layers,) of each layer, exact."""
        return _FOUR_PI * self.mean_radius**3 * shell_integrals(self, 2)

    @property
    @double_precision()
    def mean_moment(self) -> Array:
        """I about any axis, (8 pi/3) of the integral of rho r^4; of a rotating body (2 A + C)/3 to first order."""
        return 2 / 3 * _FOUR_PI * self.mean_radius**5 * jnp.sum(shell_integrals(self, 4))

    @property
    @double_precision()
    def moment_ratio(self) -> Array:
        """I/(M R^2) with the mean radius R."""
        return 2 / 3 * jnp.sum(shell_integrals(self, 4)) / jnp.sum(shell_integrals(self, 2))

    @property
    @double_precision()
    def gravitational_energy(self) -> Array:
        """W = -(integral of G m dm/r), negative and exact."""
        x_in, x_out, offset = layer_bounds(self)
        powers = jnp.arange(self.coefficients.shape[1], dtype=float)
        total = powers[:, None] + powers
        pairs = self.coefficients[:, :, None] * self.coefficients[:, None, :] / (powers + 3)
        within = jnp.sum(pairs * _power_integral(x_in, x_out, total + 4), axis=(1, 2))
        below = offset * jnp.sum(self.coefficients * _power_integral(x_in, x_out, powers + 1), axis=1)
        return -(_FOUR_PI**2) * self.gravitational_constant * self.mean_radius**5 * jnp.sum(within + below)

    @property
    @double_precision()
    def stably_stratified(self) -> Array:
        """Whether the density never rises outwards: seen at 33 depths of each layer, and across each boundary."""
        x_in, x_out, _ = layer_bounds(self)
        x = x_in[:, None] + (x_out - x_in)[:, None] * jnp.linspace(0.0, 1.0, 33)
        density = jnp.sum(self.coefficients[:, None, :] * _powers(x, self.coefficients.shape[1]), axis=-1)
        return jnp.all(jnp.diff(density.ravel()) <= _RISE * jnp.max(density))

    @with_quantities(r="m")
    @double_precision()
    def density(self, r: Array) -> Array:
        """Density at radii r of any shape, at a boundary that of the layer below; zero outside."""
        x = jnp.asarray(r, dtype=float) / self.mean_radius
        layer = _layer_of(self, x)
        rho = jnp.sum(self.coefficients[layer] * _powers(x, self.coefficients.shape[1]), axis=-1)
        return jnp.where(x > 1, 0.0, rho)

    @with_quantities(r="m")
    @double_precision()
    def enclosed_mass(self, r: Array) -> Array:
        """Mass inside radii r of any shape, constant outside."""
        x = jnp.minimum(jnp.asarray(r, dtype=float) / self.mean_radius, 1.0)
        layer = _layer_of(self, x)
        offset = layer_bounds(self)[2][layer]
        return _FOUR_PI * self.mean_radius**3 * (offset + _own_mean(self, layer, x) * x**3)

    @with_quantities(r="m")
    @double_precision()
    def gravity(self, r: Array) -> Array:
        """G m/r^2 at radii r of any shape, zero at the centre."""
        x = jnp.asarray(r, dtype=float) / self.mean_radius
        inside = jnp.minimum(x, 1.0)
        layer = _layer_of(self, inside)
        offset = layer_bounds(self)[2][layer]
        safe = jnp.where(inside > 0, inside, 1.0)
        at_depth = offset / safe**2 + _own_mean(self, layer, inside) * inside
        return _FOUR_PI * self.gravitational_constant * self.mean_radius * at_depth / jnp.maximum(x, 1.0) ** 2

    @with_quantities(r="m")
    @double_precision()
    def pressure(self, r: Array) -> Array:
        """Hydrostatic pressure at radii r of any shape, the exact integral of rho g from r to the surface; 0 there."""
        x_in, x_out, _ = layer_bounds(self)
        x = jnp.clip(jnp.asarray(r, dtype=float) / self.mean_radius, 0.0, 1.0)
        layer = _layer_of(self, x)
        every = jnp.arange(len(x_out))
        whole = _weight(self, every, x_out) - _weight(self, every, x_in)
        above = jnp.cumsum(whole[::-1])[::-1] - whole
        depth = above[layer] + _weight(self, layer, x_out[layer]) - _weight(self, layer, x)
        return _FOUR_PI * self.gravitational_constant * self.mean_radius**2 * depth


_FOUR_PI = 4 * math.pi
_RISE = 1e-9  # of density from round-off in steep polynomials, as a share of the greatest
_SURFACE = 1e-12  # round-off of a density that vanishes at the surface, as a share of the greatest


def _powers(x: Array, terms: int) -> Array:
    return jnp.stack([x**k for k in range(terms)], axis=-1)


def _power_integral(x_in: Array, x_out: Array, powers: Array) -> Array:
    """The integral of x^p from x_in to x_out for each layer (first axis) and each p of `powers`, all above -1."""
    shape = (-1,) + (1,) * powers.ndim
    return (x_out.reshape(shape) ** (powers + 1) - x_in.reshape(shape) ** (powers + 1)) / (powers + 1)


@double_precision("power")
def shell_integrals(body: LayeredBody, power: int) -> Array:
    """The integral of rho x^power dx over each layer (layers,), x = r/R, exact; power 2 gives masses, 4 moments.

    Checked by tests/unit/bodies/test_layered.py.

    >>> import jax
    >>> with jax.enable_x64(True):
    ...     print(shell_integrals(constant_layers([1.0], [1.0]), 2).round(6))  # 1/3
    [0.333333]
    """
    x_in, x_out = _bounds(body)
    powers = jnp.arange(body.coefficients.shape[1], dtype=float) + power
    return jnp.sum(body.coefficients * _power_integral(x_in, x_out, powers), axis=1)


def _bounds(body: LayeredBody) -> tuple[Array, Array]:
    x_out = body.outer_radii / body.outer_radii[-1]
    return jnp.concatenate([jnp.zeros(1, x_out.dtype), x_out[:-1]]), x_out


def layer_bounds(body: LayeredBody) -> tuple[Array, Array, Array]:
    """Inner and outer x = r/R of the layers, and the offset of the mass in each, all (layers,).

    In a layer m = 4 pi R^3 (offset + sum of c_k x^(k+3)/(k+3)); the offset is what the layers below hold beyond what
    the layer itself, continued to the centre, would.

    >>> import jax
    >>> with jax.enable_x64(True):
    ...     print(layer_bounds(constant_layers([0.5, 1.0], [1.0, 1.0]))[1])  # outer
    [0.5 1. ]
    """
    x_in, x_out = _bounds(body)
    below = jnp.cumsum(shell_integrals(body, 2))[:-1]
    layer = jnp.arange(1, len(x_out))
    own = _own_mean(body, layer, x_in[1:]) * x_in[1:] ** 3
    return x_in, x_out, jnp.concatenate([jnp.zeros(1, x_out.dtype), below - own])


def _own_mean(body: LayeredBody, layer: Array, x: Array) -> Array:
    """Sum of c_k x^k/(k + 3): a third of the mean density inside x if the layer reached to the centre."""
    terms = body.coefficients.shape[1]
    return jnp.sum(body.coefficients[layer] * _powers(x, terms) / (jnp.arange(terms) + 3.0), axis=-1)


def _layer_of(body: LayeredBody, x: Array) -> Array:
    _, x_out = _bounds(body)
    return jnp.minimum(jnp.searchsorted(x_out, x, side="left"), len(x_out) - 1)


def _weight(body: LayeredBody, layer: Array, x: Array) -> Array:
    """The indefinite integral of rho m/x^2 over x in a layer, in units of 4 pi R^3."""
    terms = body.coefficients.shape[1]
    rho = body.coefficients[layer]
    offset = layer_bounds(body)[2][layer]
    safe = jnp.where(x > 0, x, 1.0)  # the offset of the layer at the centre is zero
    by_offset = -rho[..., 0] / safe
    if terms > 1:
        by_offset = by_offset + rho[..., 1] * jnp.log(safe)
    for j in range(2, terms):
        by_offset = by_offset + rho[..., j] * x ** (j - 1) / (j - 1)
    own = jnp.zeros_like(x)
    for j in range(terms):
        for k in range(terms):
            own = own + rho[..., j] * rho[..., k] * x ** (j + k + 2) / ((k + 3) * (j + k + 2))
    return offset * by_offset + own


def _checked(radii: Array, coefficients: Array, gravitational_constant: Array) -> LayeredBody:
    if is_known(radii) and is_known(coefficients):
        radii, coefficients = np.asarray(radii, dtype=float), np.asarray(coefficients, dtype=float)
        if radii.ndim != 1 or len(radii) != len(coefficients):
            raise ValueError(f"{len(coefficients)} densities need as many radii in one list, not {radii.shape}")
        if not (np.isfinite(radii).all() and radii[-1] > 0 and radii[0] >= 0 and (np.diff(radii) >= 0).all()):
            raise ValueError("the outer radii of the layers must ascend from the centre to a positive surface radius")
        x = radii / radii[-1]
        depth = np.concatenate([[0.0], x[:-1]])[:, None] + np.diff(x, prepend=0.0)[:, None] * np.linspace(0, 1, 33)
        rho = np.stack([np.polyval(c[::-1], points) for c, points in zip(coefficients, depth, strict=True)])
        rho[-1, -1] += _SURFACE * rho.max()  # at the surface itself it may vanish
        if not (np.isfinite(rho).all() and (rho > 0).all()):
            raise ValueError("the density must be positive in every layer: an empty one has no level surfaces")
    return LayeredBody(radii, coefficients, gravitational_constant)


def _stacked(concrete: bool, columns: Sequence[Array]) -> Array:
    return (np if concrete else jnp).stack(columns, axis=-1)


@with_quantities()
def constant_layers(outer_radii: Array, densities: Array, gravitational_constant: Array = 1.0) -> LayeredBody:
    """The body of layers of constant density: outer radii (layers,) from the centre outwards, densities (layers,).

    gravitational_constant: without it 1 for plain numbers, and that of SI where radii and densities have units.
    ValueError where radii do not ascend or a density is not positive. Checked by tests/unit/bodies/test_layered.py.

    >>> print(f"{float(constant_layers([0.5, 1.0], [2.0, 1.0]).moment_ratio):.6f}")  # (2/5)(1 + 1/32)/(1 + 1/8)
    0.366667
    """
    return _checked(outer_radii, _stacked(is_known(densities), [densities]), gravitational_constant)


@with_quantities()
def linear_layers(
    outer_radii: Array, inner_densities: Array, outer_densities: Array, gravitational_constant: Array = 1.0
) -> LayeredBody:
    """The body of layers in which the density goes linearly in r from an inner to an outer value, (layers,) each.

    A layer of no thickness is a jump. ValueError as for `constant_layers`. Checked by
    tests/unit/bodies/test_layered.py.

    >>> print(f"{float(linear_layers([1.0], [1.0], [1.0]).moment_ratio):.6f}")  # uniform
    0.400000
    """
    concrete = all(is_known(array) for array in (outer_radii, inner_densities, outer_densities))
    xp = np if concrete else jnp
    radii, inner, outer = (xp.asarray(array, dtype=float) for array in (outer_radii, inner_densities, outer_densities))
    if not inner.shape == outer.shape == radii.shape:
        raise ValueError(f"{inner.size} and {outer.size} densities need as many radii in one list, not {radii.shape}")
    with np.errstate(invalid="ignore"):  # a surface at infinity, or at or below 0, is refused by what follows
        x = radii / xp.where(radii[-1] > 0, radii[-1], 1.0)
        x_in = xp.concatenate([xp.zeros(1), x[:-1]])
        width = x - x_in
    slope = xp.where(width > 0, (outer - inner) / xp.where(width > 0, width, 1.0), 0.0)
    return _checked(radii, _stacked(concrete, [inner - slope * x_in, slope]), gravitational_constant)


@with_quantities()
def polynomial_layers(
    outer_radii: Array, coefficients: Sequence[Array], gravitational_constant: Array = 1.0
) -> LayeredBody:
    """The body of layers of density c_0 + c_1 x + c_2 x^2 + ..., x = r/R: a list of coefficients for each layer.

    The lists may differ in length. ValueError as for `constant_layers`. Checked by tests/unit/bodies/test_layered.py.

    >>> print(f"{float(polynomial_layers([1.0], [[1.0]]).moment_ratio):.6f}")  # uniform
    0.400000
    """
    concrete = all(is_known(row) for row in coefficients)
    xp = np if concrete else jnp
    longest = max(len(row) for row in coefficients)
    rows = [xp.pad(xp.asarray(row, dtype=float), (0, longest - len(row))) for row in coefficients]
    return _checked(outer_radii, xp.stack(rows), gravitational_constant)


@with_quantities()
def tabulated_layers(radii: Array, densities: Array, gravitational_constant: Array = 1.0) -> LayeredBody:
    """The body of a table, linear between its rows: radii (rows,) ascending up to the surface, densities (rows,).

    Two rows of one radius are a jump; where the first radius is not zero, the first density fills the centre.
    ValueError as for `constant_layers`. Checked by tests/unit/bodies/test_layered.py.

    >>> print(f"{float(tabulated_layers([0.0, 1.0], [1.0, 1.0]).moment_ratio):.6f}")  # uniform
    0.400000
    """
    xp = np if is_known(radii) and is_known(densities) else jnp
    radii, densities = xp.asarray(radii, dtype=float), xp.asarray(densities, dtype=float)
    return linear_layers(radii, xp.concatenate([densities[:1], densities[:-1]]), densities, gravitational_constant)
