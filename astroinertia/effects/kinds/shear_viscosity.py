"""Viscosity of the fluid itself, as of a molten or turbulent body."""

from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.bodies.bar_limits import SECULAR
from astroinertia.effects import Characteristic, Effect, Entry, Output, PairTerm, pytree
from astroinertia.effects.measure import Found, Measure, Options, within_all
from astroinertia.units import REQUIRED, not_negative

# 2 (d + 2) in d = 3 dimensions: what makes the sum over radial velocities the Laplacian.
DIRECTIONS = 10.0
DIFFUSION_PART = 0.125  # of h^2/nu, that its time-step limit is (Morris, Fox & Zhu 1997, JCP 136, 214, eq. 20)


def shear_viscosity_pair(xp, r, v_r, dW_i, dW_j, density_i, density_j, kinematic_viscosity_i, kinematic_viscosity_j):
    """Pull between particles that part, push between those that close, and the heat of it."""
    mean = 0.5 * (kinematic_viscosity_i + kinematic_viscosity_j)
    drag = -DIRECTIONS * mean * v_r * (dW_i + dW_j) / ((density_i + density_j) * xp.maximum(r, 1e-15))
    return drag, 0.5 * drag * v_r


SHEAR_VISCOSITY = PairTerm(
    "shear_viscosity", shear_viscosity_pair, (Output("acceleration", "central"), Output("heating", "sum"))
)


@pytree
@dataclass(frozen=True, eq=False)
class ShearViscosity(Effect):
    """rho dv/dt = div (2 eta sigma) + grad (zeta div v), eta = rho nu, with the same nu everywhere.

    Particles: a_i = sum_j m_j 10 nu v_r/([rho] r) [dW] rhat, with [.] the mean over the pair (the part of Espanol &
    Revenga 2003, PRE 67, 026705, eq. 45, along the separation; Monaghan 2005, Rep. Prog. Phys. 68, 1703, section 4.4;
    1/[rho] with the harmonic mean of eta, Cleary & Monaghan 1999, JCP 148, 227). Forces along the separation keep L to
    rounding and leave rigid rotation alone; they bring with them a bulk viscosity zeta = 5 eta/3. What motion loses is
    heat, to rounding, for the velocities that the pair is evaluated with.

    An affine body: V = -2 M nu sigma with sigma the symmetric part, without trace, of the velocity gradient, and no
    bulk viscosity. The velocity field stays linear: exact energy loss of that field, but no boundary layer (Rosenkilde
    1967, ApJ 148, 825; Chandrasekhar 1969, section 37).

    What is dissipated heats a fluid that has a thermal part, and is radiated by one that has none.
    """

    kinematic_viscosity: Any

    kind: ClassVar[str] = "shear_viscosity"
    limited_by_density: ClassVar[bool] = True

    @property
    def neighbour_terms(self):
        """Drag along the separation, and its heat."""
        return (SHEAR_VISCOSITY,)

    def fields(self, xp, fluid):
        """Densities and nu."""
        return {
            "density": fluid.density,
            "kinematic_viscosity": xp.zeros_like(fluid.density) + self.kinematic_viscosity,
        }

    def timestep(self, xp, fluid):
        """Momentum diffuses over the smoothing length: h^2/(8 nu)."""
        return DIFFUSION_PART * fluid.smoothing_length**2 / xp.maximum(self.kinematic_viscosity, 1e-300)

    def affine_force(self, body):
        """V F^-T."""
        from astroinertia.bodies import affine_motion

        return affine_motion.shear_force(body.deformation, body.rate, body.mass * self.kinematic_viscosity)

    def affine_virial(self, body):
        """-2 M nu sigma, sigma with the inverse of F as it stands."""
        gradient = body.rate @ jnp.linalg.inv(body.deformation)
        shear = 0.5 * (gradient + gradient.T) - jnp.trace(gradient) / 3.0 * jnp.eye(3)
        return -2.0 * body.mass * self.kinematic_viscosity * shear

    def affine_heating(self, body):
        """2 M nu sigma : sigma."""
        from astroinertia.bodies import affine_motion

        shear = affine_motion.shear_tensor(body.deformation, body.rate)
        return 2.0 * body.mass * self.kinematic_viscosity * (shear**2).sum()


def _size(body: Characteristic, options: Options) -> Found:
    assert body.radius is not None
    decay = 5.0 * options["kinematic_viscosity"] * body.end / body.radius**2
    zone = body.zone
    steady = body.shear == 0.0 and body.expansion == 0.0 and zone is not None and body.bodies == 1
    if steady and zone is not None and (body.rotational_to_gravitational or 0.0) < SECULAR:
        return decay, within_all(decay * zone.imbalance)  # rigid rotation has no friction: what moves is what swings
    return decay, within_all(decay)


ENTRY = Entry(
    "viscosity of the fluid itself, which particles have along their separations: L is kept",
    {"kinematic_viscosity": not_negative("viscosity", REQUIRED, "nu, the same everywhere")},
    "neighbours", "Espanol & Revenga 2003; Cleary & Monaghan 1999; Chandrasekhar 1969, section 37",
    ("sph", "ellipsoid"), colour="green", limit_power=2.0 / 3.0, made=ShearViscosity, rank=5,
    size=Measure(
        "5 nu t/R^2", "that, where the flow has shear; times the imbalance of forces in rigid rotation",
        "Lamb 1932, section 355; Chandrasekhar 1969, section 37", _size, ("radius",), ("kinematic_viscosity",),
    ),
)  # fmt: skip
