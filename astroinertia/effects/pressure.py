"""Pressure of the fluid on itself."""

from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, NamedTuple

import jax.numpy as jnp

from astroinertia.bodies import affine, affine_motion
from astroinertia.effects.effect import Effect
from astroinertia.engines.elementwise import elementwise
from astroinertia.engines.pytree import pytree
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.sph.fourth_order import weights


class Side(NamedTuple):
    """What a particle of a pair brings with it where densities are of fourth order."""

    dW: Any
    d2W: Any
    slope_weight: Any
    curvature_weight: Any
    sound_speed: Any


def pressure_pair(xp, v_r, dW_i, dW_j, pressure_weight_i, pressure_weight_j, sound_speed_i, sound_speed_j):
    """The two sides of the pressure gradient, and how fast the pair learns of each other or changes."""
    return pressure_weight_i * dW_i + pressure_weight_j * dW_j, 0.5 * (sound_speed_i + sound_speed_j) + xp.abs(v_r)


def curved_pair(xp, r, v_r, i: Side, j: Side):
    """The same for densities of fourth order."""
    mine = i.slope_weight * i.dW + i.curvature_weight * r * i.d2W
    other = j.slope_weight * j.dW + j.curvature_weight * r * j.d2W
    return mine + other, 0.5 * (i.sound_speed + j.sound_speed) + xp.abs(v_r)


def curvature_pair(xp, r, d2W_i):
    """C of sph.fourth_order."""
    return (r * r * d2W_i,)


def weight(xp, pressure, grad_h, density):
    """P/(Omega rho^2)."""
    return (pressure / (grad_h * density**2),)


def crossing_time(xp, h, signal, sound_speed):
    """h/v_signal; the particle's own sound is a signal too, where it has no neighbour."""
    return (1.0 / xp.maximum(xp.maximum(signal, sound_speed) / h, 1e-30),)


PRESSURE = PairTerm("pressure", pressure_pair, (Output("acceleration", "central"), Output("signal", "max")))
CURVED = PairTerm("pressure", curved_pair, PRESSURE.outputs)
CURVATURE = PairTerm("pressure", curvature_pair, (Output("curvature", "sum"),))


@pytree
@dataclass(frozen=True, eq=False)
class Pressure(Effect):
    """a_i = -sum_j m_j [P_i/(Omega_i rho_i^2) dW_i + P_j/(Omega_j rho_j^2) dW_j] rhat.

    Springel & Hernquist (2002, MNRAS 333, 649), eq. 18. It follows from the Lagrangian with u(rho, A): its potential is
    the internal energy, which the model keeps. order: of the error of the density in the smoothing length; "fourth"
    leaves out what smoothing adds to the density, and its force follows from that (sph.fourth_order).
    """

    order: Literal["second", "fourth"] = field(default="second", metadata={"static": True})

    kind: ClassVar[str] = "pressure"
    central: ClassVar[bool] = True

    @property
    def needs_contrast(self):
        """Where densities are of fourth order."""
        return self.order == "fourth"

    @property
    def gradient_terms(self):
        """The curvature of the kernel's sum, where densities are of fourth order."""
        return (CURVATURE,) if self.order == "fourth" else ()

    @property
    def neighbour_terms(self):
        """The pressure gradient, and the signal of the time step."""
        return (CURVED,) if self.order == "fourth" else (PRESSURE,)

    def fields(self, xp, fluid):
        """P/(Omega rho^2), or the two weights of sph.fourth_order, and the speed of sound."""
        if self.order == "fourth":
            slope, curvature = elementwise(
                xp, weights, fluid.pressure, fluid.density, fluid.contrast, fluid.grad_h,
                fluid.gradients[self.kind]["curvature"],
            )  # fmt: skip
            return {"slope_weight": slope, "curvature_weight": curvature, "sound_speed": fluid.sound_speed}
        return {
            "pressure_weight": elementwise(xp, weight, fluid.pressure, fluid.grad_h, fluid.density)[0],
            "sound_speed": fluid.sound_speed,
        }

    def timestep(self, xp, fluid):
        """Sound crosses the smoothing length, and neighbours do not move far apart or together: h/v_signal."""
        signal = fluid.sums[self.kind]["signal"]
        return elementwise(xp, crossing_time, fluid.smoothing_length, signal, fluid.sound_speed)[0]

    def affine_force(self, body):
        """-(dU/dJ) dJ/dF: isotropic. The slope is the fluid's own, or what keeps the volume."""
        return affine_motion.pressure_force(body.deformation, body.pressure_slope)

    def affine_virial(self, body):
        """The integral of the pressure over the volume, -(dU/dJ) J, in every direction."""
        return -body.pressure_slope * affine.volume_ratio(body.deformation) * jnp.eye(3)

    def affine_heating(self, body):
        """Its work on the volume comes out of the internal energy: (dU/dJ) dJ/dt."""
        return body.pressure_slope * (affine.cofactor(body.deformation) * body.rate).sum()
