"""Tillotson's equation of state, with its parameters for rocks, iron and ice.

Sources: Tillotson 1962, General Atomic report GA-3216; Melosh 1989, Impact Cratering, app. II; Benz & Asphaug 1999,
Icarus 142, 5. Tests: tests/unit/matter/test_planetary.py.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.inertia.tensor import namespace
from astroinertia.process.quantities import with_quantities

Array = Any

_NODES = 20  # of the collocation of the cold curve
_PICARD = 24  # iterations: each gains a factor (order times the logarithm of the compression) over its number


@pytree
@with_quantities(
    reference_density="kg m-3", linear="Pa", quadratic="Pa", energy_scale="J kg-1", incipient_vaporisation="J kg-1",
    complete_vaporisation="J kg-1",
)  # fmt: skip
@dataclass(frozen=True)
class Tillotson:
    """Pressure from density and energy; as a cold material, on the isentrope from the reference density at no energy.

    With eta = rho/rho_0 and mu = eta - 1, compressed or cold: P = (a + b/(E/(E_0 eta^2) + 1)) rho E + A mu + B mu^2;
    expanded and above the energy of complete vaporisation: P = a rho E + (b rho E/(E/(E_0 eta^2) + 1) + A mu
    exp(-beta (1/eta - 1))) exp(-alpha (1/eta - 1)^2); between, linear in E. SI. Source: Melosh 1989, eqs. AII.3 to 5.

    >>> print(f"{GRANITE.pressure_at(2680.0, 1e6) / 1e9:.2f} GPa")  # heated at its reference density
    4.62 GPa
    """

    reference_density: Array
    a: Array
    b: Array
    linear: Array  # A
    quadratic: Array  # B
    energy_scale: Array  # E_0
    incipient_vaporisation: Array
    complete_vaporisation: Array
    alpha: Array
    beta: Array

    @property
    def bulk_modulus(self) -> Array:
        """K = A at the reference state."""
        return self.linear

    @property
    def derivative(self) -> Array:
        """K' = 1 + 2 B/A + a + b of the cold curve at the reference state."""
        return 1 + 2 * self.quadratic / self.linear + self.a + self.b

    @with_quantities(energy="J kg-1")
    def pressure_at(self, density: Array, energy: Array) -> Array:
        """Pressure at a density and an energy a mass, any regime, any shape."""
        condensed, vapour, share = self._phases(density, energy)
        return share * vapour + (1 - share) * condensed

    @with_quantities(energy="J kg-1")
    def fluid_pressure_at(self, density: Array, energy: Array) -> Array:
        """The same of matter that cannot be pulled: where a phase would be in tension it exerts no pressure.

        Cutting each phase rather than their sum leaves the pressure of vapour beside condensed matter that has come
        apart, and isentropes that do not run together there.
        """
        condensed, vapour, share = self._phases(density, energy)
        xp = namespace(condensed, vapour)
        return share * xp.maximum(vapour, 0.0) + (1 - share) * xp.maximum(condensed, 0.0)

    def _phases(self, density: Array, energy: Array) -> tuple[Array, Array, Array]:
        """Pressure of condensed matter and of vapour, and the share of vapour."""
        xp = namespace(density, energy, *vars(self).values())
        eta = density / self.reference_density
        mu = (density - self.reference_density) / self.reference_density
        thermal = self.b * density * energy / (energy / (self.energy_scale * eta**2) + 1)
        condensed = self.a * density * energy + thermal + self.linear * mu + self.quadratic * mu**2
        stretch = xp.maximum(-mu / eta, 0.0)
        cold_part = self.linear * mu * xp.exp(-self.beta * stretch)
        vapour = self.a * density * energy + (thermal + cold_part) * xp.exp(-self.alpha * stretch**2)
        share = (energy - self.incipient_vaporisation) / (self.complete_vaporisation - self.incipient_vaporisation)
        return condensed, vapour, xp.where(eta < 1, xp.clip(share, 0.0, 1.0), 0.0)

    @with_quantities()
    def energy(self, density: Array) -> Array:
        """The energy of the cold curve, dE/d rho = P(rho, E)/rho^2 with E = 0 at the reference density.

        Picard's iteration of its collocation in ln rho, which converges like a factorial.
        """
        import jax  # which pressure_at does without
        import jax.numpy as jnp

        width = jnp.log(jnp.asarray(density, dtype=float) / self.reference_density)[..., None]
        nodes, to_nodes, to_end = (jnp.asarray(array, dtype=width.dtype) for array in _integrals())
        rho = self.reference_density * jnp.exp(width * nodes)

        def slope(energy: Array) -> Array:
            return width * self.pressure_at(rho, energy) / rho

        def better(energy: Array, _: None) -> tuple[Array, None]:
            return slope(energy) @ to_nodes, None

        energy, _ = jax.lax.scan(better, jnp.zeros_like(rho), length=_PICARD)
        return slope(energy) @ to_end

    @with_quantities()
    def pressure(self, density: Array) -> Array:
        """Pressure of the cold curve."""
        return self.pressure_at(density, self.energy(density))

    @with_quantities()
    def density(self, pressure: Array) -> Array:
        """Density at a pressure on the cold curve, by Newton's method."""
        from astroinertia.matter.planetary import inverted  # with JAX

        return inverted(self, pressure)


@lru_cache(maxsize=1)
def _integrals() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss's nodes on (0, 1), the matrix of integrals from 0 to each, and the weights of the whole."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    legendre = np.polynomial.legendre.Legendre
    to_values = np.linalg.inv(np.polynomial.legendre.legvander(nodes, _NODES - 1))
    rising = np.stack([legendre.basis(k).integ(lbnd=-1)(nodes) for k in range(_NODES)])
    return (nodes + 1) / 2, (rising.T @ to_values / 2).T, weights / 2


GRANITE = Tillotson(2680.0, 0.5, 1.3, 18.0e9, 18.0e9, 16.0e6, 3.5e6, 18.0e6, 5.0, 5.0)
"""Melosh 1989, table AII.3."""
BASALT = Tillotson(2700.0, 0.5, 1.5, 26.7e9, 26.7e9, 487.0e6, 4.72e6, 18.2e6, 5.0, 5.0)
"""Benz & Asphaug 1999, table II."""
IRON = Tillotson(7800.0, 0.5, 1.5, 128.0e9, 105.0e9, 9.5e6, 2.4e6, 8.67e6, 5.0, 5.0)
"""Melosh 1989, table AII.3."""
ICE = Tillotson(917.0, 0.3, 0.1, 9.47e9, 9.47e9, 10.0e6, 0.773e6, 3.04e6, 10.0, 5.0)
"""Benz & Asphaug 1999, table II."""
