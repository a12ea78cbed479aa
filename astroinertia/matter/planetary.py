"""Cold equations of state of planetary matter: pressure, density, bulk modulus and energy, differentiable.

A material is a frozen dataclass and JAX pytree with `reference_density` (at no pressure), `pressure(density)` and
`density(pressure)`; SI, or any consistent units. Elements of arrays are independent of each other. These methods are
for code of JAX and compute in its precision, 32 bits if nothing else is set; the functions of this module, such as
`density(IRON_HCP, 300e9)`, compute in 64 bits wherever they are called from.

Sources: Birch 1947, Phys. Rev. 71, 809; Vinet et al. 1989, J. Phys. Condens. Matter 1, 1941; Murnaghan 1944, PNAS 30,
244; Seager et al. 2007, ApJ 669, 1279. Tillotson's equation is in tillotson.py.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.inertia.double_precision import double_precision
from astroinertia.process.quantities import with_quantities

Array = Any

_GREATEST_COMPRESSION = 20.0  # of a density that is looked for; cold equations of state hold to far less
_NEWTON_STEPS = 60
_NEWTON_TOLERANCE = 1e-15  # relative, of a density
_ENERGY_NODES = 32


class Material(Protocol):
    """What a layer needs to know of its matter."""

    @property
    def reference_density(self) -> Array:
        """Density at no pressure."""
        ...

    def pressure(self, density: Array) -> Array:
        """Pressure at a density, any shape."""
        ...

    def density(self, pressure: Array) -> Array:
        """Density at a pressure, any shape; below no pressure a smooth continuation."""
        ...


@pytree
@with_quantities(reference_density="kg m-3", second_derivative="Pa-1")
@dataclass(frozen=True)
class BirchMurnaghan:
    """P = 3 K f (1 + 2f)^(5/2) (1 + a f + b f^2) with Euler's finite strain f = ((rho/rho_0)^(2/3) - 1)/2.

    K, K' and K'' are the bulk modulus and its derivatives by pressure at no pressure; a = (3/2)(K' - 4). With K' = 4
    and no K'' it is of second order, with no K'' of third (b = 0), else of fourth, b = (3/2)(K K'' + (K' - 4)(K' - 3)
    + 35/9). Source: Birch 1947; Poirier 2000, Introduction to the Physics of the Earth's Interior, sec. 4.3.
    """

    reference_density: Array
    bulk_modulus: Array
    derivative: Array = 4.0
    second_derivative: Array | None = None

    @with_quantities()
    def pressure(self, density: Array) -> Array:
        """Pressure at a density."""
        slope = self.derivative
        a, b = 1.5 * (slope - 4), 0.0
        if self.second_derivative is not None:
            b = 1.5 * (self.bulk_modulus * self.second_derivative + (slope - 4) * (slope - 3) + 35 / 9)
        compression = _compression(density, self.reference_density)
        strain = jnp.expm1(2 / 3 * compression) / 2
        return 3 * self.bulk_modulus * strain * jnp.exp(5 / 3 * compression) * (1 + a * strain + b * strain**2)

    @with_quantities()
    def density(self, pressure: Array) -> Array:
        """Density at a pressure, by Newton's method; NaN beyond the greatest pressure that the equation reaches."""
        return inverted(self, pressure)


@pytree
@with_quantities(reference_density="kg m-3")
@dataclass(frozen=True)
class Vinet:
    """P = 3 K (1 - x)/x^2 exp(1.5 (K' - 1)(1 - x)) with x = (rho_0/rho)^(1/3). Source: Vinet et al. 1989."""

    reference_density: Array
    bulk_modulus: Array
    derivative: Array

    @with_quantities()
    def pressure(self, density: Array) -> Array:
        """Pressure at a density."""
        third = _compression(density, self.reference_density) / 3
        shortened = -jnp.expm1(-third)  # 1 - x
        return 3 * self.bulk_modulus * shortened * jnp.exp(2 * third + 1.5 * (self.derivative - 1) * shortened)

    @with_quantities()
    def density(self, pressure: Array) -> Array:
        """Density at a pressure, by Newton's method."""
        return inverted(self, pressure)


@pytree
@with_quantities(reference_density="kg m-3")
@dataclass(frozen=True)
class Murnaghan:
    """P = (K/K')((rho/rho_0)^K' - 1): a bulk modulus linear in pressure. Source: Murnaghan 1944."""

    reference_density: Array
    bulk_modulus: Array
    derivative: Array

    @with_quantities()
    def pressure(self, density: Array) -> Array:
        """Pressure at a density."""
        compression = _compression(density, self.reference_density)
        return self.bulk_modulus / self.derivative * jnp.expm1(self.derivative * compression)

    @with_quantities()
    def density(self, pressure: Array) -> Array:
        """Density at a pressure, in closed form."""
        base = jnp.maximum(1 + self.derivative * pressure / self.bulk_modulus, 1e-3)  # tension beyond it has no density
        return self.reference_density * base ** (1 / self.derivative)


@pytree
@with_quantities(reference_density="kg m-3", coefficient=None, exponent=None)
@dataclass(frozen=True)
class ModifiedPolytrope:
    """rho = rho_0 + c P^n: incompressible if c = 0, a polytrope if rho_0 = 0. Source: Seager et al. 2007, eq. 11."""

    reference_density: Array
    coefficient: Array
    exponent: Array = 1.0

    @with_quantities()
    def pressure(self, density: Array) -> Array:
        """Pressure at a density of at least rho_0; infinite or NaN where it is incompressible."""
        return ((density - self.reference_density) / self.coefficient) ** (1 / self.exponent)

    @with_quantities()
    def density(self, pressure: Array) -> Array:
        """Density at a pressure, in closed form; rho_0 below no pressure."""
        positive = pressure > 0
        power = jnp.where(positive, jnp.where(positive, pressure, 1.0) ** self.exponent, 0.0)
        return self.reference_density + self.coefficient * power


def _compression(density: Array, reference: Array) -> Array:
    """ln(rho/rho_0), right to rounding where densities are almost the same."""
    return jnp.log1p((density - reference) / reference)


def _slope(function: Callable[[Array], Array], at: Array) -> tuple[Array, Array]:
    """A function of independent elements, and its derivative."""
    at = jnp.asarray(at, dtype=float)
    return jax.jvp(function, (at,), (jnp.ones_like(at),))


def inverted(material: Any, pressure: Array) -> Array:
    """The density at which `material.pressure` is `pressure`, differentiable to any order (implicit function theorem).

    Newton's method kept inside a bracket, from Murnaghan's density for the same K and K'; NaN where the pressure is
    beyond what the material reaches at 20 times its reference density or before its bulk modulus vanishes. Below no
    pressure the density is rho_0 exp(P/K).

    >>> with jax.enable_x64(True):
    ...     print(f"{inverted(IRON_HCP, IRON_HCP.pressure(12000.0)):.6f}")
    12000.000000
    """
    pressure = jnp.asarray(pressure, dtype=float)
    return _compressed(material, jnp.maximum(pressure, 0.0)) * jnp.exp(
        jnp.minimum(pressure, 0.0) / material.bulk_modulus
    )


@jax.custom_jvp
def _compressed(material: Any, wanted: Array) -> Array:
    """The density at pressures that are not negative."""
    reference, modulus = material.reference_density, material.bulk_modulus
    compressed = 1 + material.derivative * wanted / modulus
    guess = jnp.clip(
        reference * compressed ** (1 / material.derivative), reference, 0.9 * _GREATEST_COMPRESSION * reference
    )

    near = max(1e-10, 100 * float(jnp.finfo(guess.dtype).eps))

    def unfinished(state: tuple) -> Array:
        return (state[0] < _NEWTON_STEPS) & ~jnp.all(state[4])

    def improve(state: tuple) -> tuple:
        count, rho, low, high, *_ = state
        reached, slope = _slope(material.pressure, rho)
        high, low = jnp.where(reached > wanted, rho, high), jnp.where(reached > wanted, low, rho)
        step = rho - (reached - wanted) / slope
        inside = (step >= low) & (step <= high)  # not so for a NaN
        new = jnp.where(inside, step, 0.5 * (low + high))
        solved = (jnp.abs(reached - wanted) <= near * (wanted + modulus)) & (slope > 0)
        return count + 1, new, low, high, jnp.abs(new - rho) <= _NEWTON_TOLERANCE * rho, solved

    limit, no = jnp.full_like(guess, _GREATEST_COMPRESSION * reference), jnp.zeros(guess.shape, dtype=bool)
    _, rho, *_, solved = jax.lax.while_loop(
        unfinished, improve, (0, guess, jnp.full_like(guess, reference), limit, no, no)
    )
    return jnp.where(solved, rho, jnp.nan)


@_compressed.defjvp
def _compressed_jvp(at: tuple, along: tuple) -> tuple[Array, Array]:
    (material, wanted), (of_material, of_wanted) = at, along
    rho = _compressed(material, wanted)
    of_pressure = jax.jvp(lambda own: own.pressure(rho), (material,), (of_material,))[1]
    return rho, (of_wanted - of_pressure) / _slope(material.pressure, rho)[1]


@with_quantities()
@double_precision()
def pressure(material: Material, density: Array) -> Array:
    """The cold pressure of a material at densities of any shape.

    >>> print(f"{pressure(IRON_HCP, 13000.0) / 1e9:.0f} GPa")  # cold iron as dense as the Earth's centre
    253 GPa
    """
    return material.pressure(jnp.asarray(density, dtype=float))


@with_quantities()
@double_precision()
def density(material: Material, pressure: Array) -> Array:
    """The density of a material at pressures of any shape; NaN beyond the reach of its equation.

    >>> print(f"{density(PEROVSKITE, 136e9):.0f} kg/m3")  # at the foot of the Earth's mantle, cold
    5547 kg/m3
    """
    return material.density(jnp.asarray(pressure, dtype=float))


@with_quantities()
@double_precision()
def bulk_modulus(material: Material, density: Array) -> Array:
    """K = rho dP/d rho at densities of any shape, by exact differentiation.

    >>> print(f"{bulk_modulus(IRON_HCP, 8300.0) / 1e9:.1f} GPa")  # at no pressure: that of the table
    156.2 GPa
    """
    rho = jnp.asarray(density, dtype=float)
    return rho * _slope(material.pressure, rho)[1]


@with_quantities()
@double_precision()
def cold_energy(material: Material, density: Array) -> Array:
    """Energy a mass of compression from the reference density, the integral of P/rho^2 d rho, any shape.

    Gauss-Legendre quadrature, exact to round-off up to some fivefold compression. Source: dE = -P dV.

    >>> small = cold_energy(IRON_HCP, 8300.0 * 1.001)
    >>> print(f"{small / (156.2e9 * 0.001**2 / (2 * 8300.0)):.3f}")  # Hooke: K (drho/rho)^2/(2 rho)
    1.000
    """
    nodes, weights = np.polynomial.legendre.leggauss(_ENERGY_NODES)
    share = (nodes + 1) / 2
    change = jnp.asarray(density, dtype=float)[..., None] - material.reference_density
    rise = change * share**2
    rho = material.reference_density + rise
    # Near the reference density pressures go as the rise, which the sum with it has rounded.
    rounded = rho - material.reference_density
    pressures = material.pressure(rho) * jnp.where(rounded == 0.0, 1.0, rise / jnp.where(rounded == 0.0, 1.0, rounded))
    return jnp.sum(pressures / rho**2 * change * share * weights, axis=-1)


IRON_HCP = Vinet(8300.0, 156.2e9, 6.08)
"""hcp iron: Anderson et al. 2001, GRL 28, 399, as in Seager et al. 2007, table 1."""
IRON_LIQUID = BirchMurnaghan(7019.0, 109.7e9, 4.66, -0.043e-9)
"""Liquid iron on the isentrope from 1811 K at 1 bar: Anderson & Ahrens 1994, JGR 99, 4273."""
IRON_SULPHIDE = BirchMurnaghan(4770.0, 35.0e9, 4.9)
"""FeS: Ahrens 2000, as in Seager et al. 2007, table 1."""
PEROVSKITE = BirchMurnaghan(4100.0, 247.0e9, 3.97, -0.016e-9)
"""MgSiO3 perovskite (bridgmanite): Karki et al. 2000, PRB 62, 14750, as in Seager et al. 2007, table 1."""
FORSTERITE = BirchMurnaghan(3227.0, 128.0e9, 4.2)
"""Mg2SiO4 olivine at 300 K: Stixrude & Lithgow-Bertelloni 2011, GJI 184, 1180, table A1 (43.60 cm3/mol)."""
ICE_VII = BirchMurnaghan(1460.0, 23.7e9, 4.15)
"""H2O ice VII at 300 K: Hemley et al. 1987, Nature 330, 737, as in Seager et al. 2007, table 1."""
