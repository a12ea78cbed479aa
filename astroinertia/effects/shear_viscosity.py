"""Shear viscosity of the fluid itself, as of a molten or turbulent body."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp

from astroinertia.bodies import affine_motion
from astroinertia.effects.effect import Effect
from astroinertia.pytree import pytree


@pytree
@dataclass(frozen=True, eq=False)
class ShearViscosity(Effect):
    """V = -2 M nu sigma with sigma the symmetric part, without trace, of the velocity gradient.

    nu is the kinematic viscosity, the same everywhere. What it dissipates heats a fluid that has a thermal part, and is
    radiated by one that has none. The velocity field stays linear: exact energy loss of that field, but no boundary
    layer (Rosenkilde 1967, ApJ 148, 825; Chandrasekhar 1969, section 37).
    """

    kinematic_viscosity: Any

    kind: ClassVar[str] = "shear_viscosity"

    def affine_force(self, body):
        """V F^-T."""
        return affine_motion.shear_force(body.deformation, body.rate, body.mass * self.kinematic_viscosity)

    def affine_virial(self, body):
        """-2 M nu sigma, sigma with the inverse of F as it stands."""
        gradient = body.rate @ jnp.linalg.inv(body.deformation)
        shear = 0.5 * (gradient + gradient.T) - jnp.trace(gradient) / 3.0 * jnp.eye(3)
        return -2.0 * body.mass * self.kinematic_viscosity * shear

    def affine_heating(self, body):
        """2 M nu sigma : sigma."""
        shear = affine_motion.shear_tensor(body.deformation, body.rate)
        return 2.0 * body.mass * self.kinematic_viscosity * (shear**2).sum()
