"""The internal energy of a body whose similar shells all change in volume by the same factor: U(J)."""

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp

from astroinertia.engines.pytree import pytree

Array = Any


@pytree
@dataclass(frozen=True)
class Matter:
    """A fluid of which every shell keeps its mass, its entropy but for heating, and its density over J.

    shell_mass and shell_density (K,) are of the sphere J = 1; cold is an equation of state at zero entropy function,
    thermal_exponent the gamma of the thermal part. Either may be absent. `heat` is the thermal energy that the body
    would have at J = 1: constant, but for heating.
    """

    shell_mass: Array
    shell_density: Array
    cold: Any = None
    thermal_exponent: Any = None

    def energy(self, volume: Array, heat: Array) -> Array:
        """U at J = volume: sum m u(rho/J) and heat J^(1 - gamma)."""
        total = jnp.zeros(())
        if self.cold is not None:
            density = self.shell_density / volume
            total = total + self.shell_mass @ self.cold.internal_energy(jnp, density, jnp.zeros_like(density))
        if self.thermal_exponent is not None:
            total = total + heat * volume ** (1.0 - self.thermal_exponent)
        return total

    def slope(self, volume: Array, heat: Array) -> Array:
        """dU/dJ, which is -sum m P(rho/J)/rho and what the heat has."""
        total = jnp.zeros(())
        if self.cold is not None:
            density = self.shell_density / volume
            pressure = self.cold.pressure(jnp, density, jnp.zeros_like(density))
            total = total - (self.shell_mass / self.shell_density) @ pressure
        if self.thermal_exponent is not None:
            total = total + (1.0 - self.thermal_exponent) * heat * volume**-self.thermal_exponent
        return total

    def heat_rate(self, volume: Array, heating: Array) -> Array:
        """The rate of `heat` where energy is given at the rate `heating`; zero where no thermal part can take it."""
        if self.thermal_exponent is None:
            return jnp.zeros_like(heating)
        return heating * volume ** (self.thermal_exponent - 1.0)
