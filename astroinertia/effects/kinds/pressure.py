"""Pressure of the fluid on itself."""

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, NamedTuple

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, Output, PairTerm, pytree
from astroinertia.effects.gradients import Separation, Symmetric, along, symmetric_inverse
from astroinertia.effects.measure import ZONE, Found, Measure, Options, within_all
from astroinertia.effects.one_zone import difference
from astroinertia.engines.elementwise import elementwise
from astroinertia.sph.fourth_order import weights
from astroinertia.sph.standard_volumes import DENSITY_FACTOR, own_density, weighed
from astroinertia.units import ALL_MODELS, choice

CONTACT = 0.05  # difference of densities over their sum, beyond that of pressures, that is a contact
LEAST = 1e-5  # smallest eigenvalue of a moment matrix that is inverted: all are 1 amid neighbours


class Side(NamedTuple):
    """What a particle of a pair brings with it where densities are of fourth order."""

    dW: Any
    d2W: Any
    slope_weight: Any
    curvature_weight: Any
    sound_speed: Any


class Matter(NamedTuple):
    """What a particle of a pair brings with it where gradients come from a matrix."""

    density: Any
    pressure: Any
    sound_speed: Any


def pressure_pair(xp, v_r, dW_i, dW_j, pressure_weight_i, pressure_weight_j, sound_speed_i, sound_speed_j):
    """The two sides of the pressure gradient, and how fast the pair learns of each other or changes."""
    return pressure_weight_i * dW_i + pressure_weight_j * dW_j, 0.5 * (sound_speed_i + sound_speed_j) + xp.abs(v_r)


def curved_pair(xp, r, v_r, i: Side, j: Side):
    """The same for densities of fourth order."""
    mine = i.slope_weight * i.dW + i.curvature_weight * r * i.d2W
    other = j.slope_weight * j.dW + j.curvature_weight * r * j.d2W
    return mine + other, 0.5 * (i.sound_speed + j.sound_speed) + xp.abs(v_r)


def pressure_pair_of_volumes(
    xp, v_r, dW_i, dW_j, pressure_weight_i, pressure_weight_j, volume_i, volume_j, sound_speed_i, sound_speed_j
):
    """The same where densities are sums of standard volumes (sph.standard_volumes)."""
    push = pressure_weight_i * volume_j * dW_i + pressure_weight_j * volume_i * dW_j
    return push, 0.5 * (sound_speed_i + sound_speed_j) + xp.abs(v_r)


def curved_pair_of_volumes(xp, r, v_r, i: Side, j: Side, volume_i, volume_j):
    """That of fourth order."""
    mine = i.slope_weight * i.dW + i.curvature_weight * r * i.d2W
    other = j.slope_weight * j.dW + j.curvature_weight * r * j.d2W
    return volume_j * mine + volume_i * other, 0.5 * (i.sound_speed + j.sound_speed) + xp.abs(v_r)


def curvature_pair_of_volumes(xp, r, d2W_i, volume_j):
    """C over the standard density."""
    return (volume_j * r * r * d2W_i,)


def curvature_pair(xp, r, d2W_i):
    """C of sph.fourth_order."""
    return (r * r * d2W_i,)


def contact(xp, density_i, density_j, pressure_i, pressure_j):
    """0 where densities differ no more than pressures do, as in waves and shocks; 1 across a contact."""
    thinner = xp.abs(density_i - density_j) / (density_i + density_j)
    weaker = xp.abs(pressure_i - pressure_j) / (xp.abs(pressure_i) + xp.abs(pressure_j) + 1e-30)
    return xp.minimum(xp.maximum((thinner - weaker) / CONTACT, 0.0), 1.0)


def integral_pair(
    xp, r, v_r, ij: Separation, dW_i, dW_j, pressure_weight_i, i: Matter, j: Matter, push_i: Symmetric,
    push_j: Symmetric,
):  # fmt: skip
    """Push, heat and signal of a pair where gradients come from a matrix."""
    across = contact(xp, i.density, j.density, i.pressure, j.pressure)
    here, there = 1.0 / i.density, 1.0 / j.density
    inverse = 1.0 / xp.maximum(r, 1e-15)
    squared = inverse * inverse
    mine = (here + across * (there - here)) * squared * along(xp, ij, push_i)
    other = (there + across * (here - there)) * squared * along(xp, ij, push_j)
    # What the work has more than the change of the density at constant entropy accounts for.
    heat = v_r * dW_i * (mine - pressure_weight_i)
    return mine * dW_i + other * dW_j, heat, 0.5 * (i.sound_speed + j.sound_speed) + xp.abs(v_r)


def moment_pair(xp, dW_i, density_i, density_j, pressure_i, pressure_j):
    """Weight of the moment matrix."""
    across = contact(xp, density_i, density_j, pressure_i, pressure_j)
    here, there = 1.0 / density_i, 1.0 / density_j
    return (-dW_i * (here + across * (there - here)),)


def pushes(xp, moment, pressure, density):
    """(P/rho) C^-1: xx, yy, zz, xy, xz, yz. Neighbours in one plane leave it finite."""
    x, y, z = moment
    regular = (x[0] + LEAST, x[1], x[2]), (y[0], y[1] + LEAST, y[2]), (z[0], z[1], z[2] + LEAST)
    xx, yy, zz, xy, xz, yz = symmetric_inverse(xp, regular)
    size = pressure / density
    return size * xx, size * yy, size * zz, size * xy, size * xz, size * yz


def weight(xp, pressure, grad_h, density):
    """P/(Omega rho^2)."""
    return (pressure / (grad_h * density**2),)


def crossing_time(xp, h, signal, sound_speed):
    """h/v_signal; the particle's own sound is a signal too, where it has no neighbour."""
    return (1.0 / xp.maximum(xp.maximum(signal, sound_speed) / h, 1e-30),)


PRESSURE = PairTerm("pressure", pressure_pair, (Output("acceleration", "central"), Output("signal", "max")))
CURVED = PairTerm("pressure", curved_pair, PRESSURE.outputs)
INTEGRAL = PairTerm("pressure", integral_pair, (PRESSURE.outputs[0], Output("heating", "sum"), PRESSURE.outputs[1]))
MOMENT = PairTerm("pressure", moment_pair, (Output("moment", "outer", of="position"),))
CURVATURE = PairTerm("pressure", curvature_pair, (Output("curvature", "sum"),))
OF_VOLUMES = PairTerm("pressure", pressure_pair_of_volumes, PRESSURE.outputs)
CURVED_OF_VOLUMES = PairTerm("pressure", curved_pair_of_volumes, PRESSURE.outputs)
CURVATURE_OF_VOLUMES = PairTerm("pressure", curvature_pair_of_volumes, CURVATURE.outputs)
WEIGHTS = ("pressure_weight", "slope_weight", "curvature_weight")
PUSH = tuple(f"push_{axes}" for axes in Symmetric._fields)


@pytree
@dataclass(frozen=True, eq=False)
class Pressure(Effect):
    """a_i = -sum_j m_j [P_i/(Omega_i rho_i^2) dW_i + P_j/(Omega_j rho_j^2) dW_j] rhat.

    Springel & Hernquist (2002, MNRAS 333, 649), eq. 18. It follows from the Lagrangian with u(rho, A): its potential is
    the internal energy, which the model keeps. order: of the error of the density in the smoothing length; "fourth"
    leaves out what smoothing adds to the density, and its force follows from that (sph.fourth_order). volumes: whether
    densities are sums of standard volumes, which problems know (sph.standard_volumes).

    gradients "integral": in place of dW_i/Omega_i there is

        rho_i V_ij dW_i rhat.C_i^-1.rhat,   C_i = -sum_j m_j V_ij (dW_i/r) x (x) x,   x = x_i - x_j,   V_ij = 1/rho_i,

    the integral approach to derivatives (Garcia-Senz, Cabezon & Escartin 2012, A&A 538, A9; Cabezon, Garcia-Senz &
    Figueira 2017, A&A 606, A78) with -dW/r as its kernel in place of W, which costs a star at rest five times the
    entropy; of its force the part along the separation is kept, so that linear and angular momentum stay exact. As
    -sum_j m_j V_ij (dW_i/r) x.C_i^-1.x = tr 1 = 3, the divergence of v = H x is 3 H however particles lie, that of
    other linear flows so on average over directions. Across a contact, where densities differ by more than pressures,
    V_ij is 1/rho_j, so that P_i/(rho_i rho_j) stands for P_i/rho_i^2, which leaves little surface tension
    (Garcia-Senz, Cabezon & Escartin 2022, A&A 659, A175, whose measure is that of densities alone). No Lagrangian has
    this force: what its work has more than the change of the density at constant entropy is heat of either sign,

        du_i/dt = (P_i/rho_i) sum_j m_j v_r dW_i [V_ij rhat.C_i^-1.rhat - 1/(Omega_i rho_i)],

    with which energy is exact. Tests: tests/unit/effects/kinds/test_pressure.py.
    """

    order: Literal["second", "fourth"] = field(default="second", metadata={"static": True})
    gradients: Literal["kernel", "integral"] = field(default="kernel", metadata={"static": True})
    volumes: bool = field(default=False, metadata={"static": True, "of_problem": True})

    kind: ClassVar[str] = "pressure"

    @classmethod
    def from_options(cls, options):
        """Refuses gradients that have no density of fourth order."""
        if options["gradients"] == "integral" and options["order"] == "fourth":
            raise ValueError('gradients = "integral" is for order = "second"; leave one of the two away.')
        return cls(**options)

    @property
    def needs_heat(self):
        """Where gradients come from a matrix, as their work is not that of a potential."""
        return self.gradients == "integral"

    @property
    def settling(self):
        """The kernel's gradients: noise that a matrix leaves would keep a body from coming to rest."""
        return replace(self, gradients="kernel")

    @property
    def of_volumes(self):
        """The same for densities that are sums of standard volumes."""
        if self.gradients == "integral":
            raise ValueError('gradients = "integral" has no sharp boundaries; leave it or boundary_pressure away.')
        return replace(self, volumes=True)

    @property
    def needs_contrast(self):
        """Where densities are of fourth order."""
        return self.order == "fourth"

    @property
    def gradient_terms(self):
        """The curvature of the kernel's sum, where densities are of fourth order; or the moment matrix."""
        if self.gradients == "integral":
            return (MOMENT,)
        if self.order == "second":
            return ()
        return (CURVATURE_OF_VOLUMES,) if self.volumes else (CURVATURE,)

    @property
    def neighbour_terms(self):
        """The pressure gradient, and the signal of the time step."""
        if self.gradients == "integral":
            return (INTEGRAL,)
        if self.order == "fourth":
            return (CURVED_OF_VOLUMES,) if self.volumes else (CURVED,)
        return (OF_VOLUMES,) if self.volumes else (PRESSURE,)

    def initial_memory(self, xp, fluid):
        """The factor of each particle's density where that is a sum of volumes: 1, if nothing else is known."""
        return {DENSITY_FACTOR: xp.ones_like(fluid.density)} if self.volumes else {}

    def recalled(self, xp, arrays):
        """The factors that a snapshot has."""
        return {name: arrays[name] for name in (DENSITY_FACTOR,) if self.volumes and name in arrays}

    def gradient_fields(self, xp, fluid):
        """What volumes are made of, for the moment matrix."""
        if self.order == "fourth" and self.volumes:
            return {"volume": 1.0 / fluid.standard_density}
        return {"density": fluid.density, "pressure": fluid.pressure} if self.gradients == "integral" else {}

    def fields(self, xp, fluid):
        """P/(Omega rho^2), or the two weights of sph.fourth_order, or what the matrix makes; and the speed of sound."""
        own = self.weights(xp, fluid) | {"sound_speed": fluid.sound_speed}
        if self.gradients == "integral":
            moment = fluid.gradients[self.kind]["moment"]
            push = elementwise(xp, pushes, moment, fluid.pressure, fluid.density)
            own |= {"density": fluid.density, "pressure": fluid.pressure, **dict(zip(PUSH, push, strict=True))}
        return weighed(own, fluid, *WEIGHTS) if self.volumes else own

    def weights(self, xp, fluid):
        """Of the slopes of the kernel, and of its curvature where densities are of fourth order."""
        if self.order == "second":
            return {"pressure_weight": elementwise(xp, weight, fluid.pressure, fluid.grad_h, fluid.density)[0]}
        curvature = fluid.gradients[self.kind]["curvature"]
        if self.volumes:
            curvature = own_density(fluid) * curvature
        both = elementwise(xp, weights, fluid.pressure, fluid.density, fluid.contrast, fluid.grad_h, curvature)
        return dict(zip(("slope_weight", "curvature_weight"), both, strict=True))

    def timestep(self, xp, fluid):
        """Sound crosses the smoothing length, and neighbours do not move far apart or together: h/v_signal."""
        signal = fluid.sums[self.kind]["signal"]
        return elementwise(xp, crossing_time, fluid.smoothing_length, signal, fluid.sound_speed)[0]

    def affine_force(self, body):
        """-(dU/dJ) dJ/dF: isotropic. The slope is the fluid's own, or what keeps the volume."""
        from astroinertia.bodies import affine_motion

        return affine_motion.pressure_force(body.deformation, body.pressure_slope)

    def affine_virial(self, body):
        """The integral of the pressure over the volume, -(dU/dJ) J, in every direction."""
        from astroinertia.bodies import affine

        return -body.pressure_slope * affine.volume_ratio(body.deformation) * jnp.eye(3)

    def affine_heating(self, body):
        """Its work on the volume comes out of the internal energy: (dU/dJ) dJ/dt."""
        from astroinertia.bodies import affine

        return body.pressure_slope * (affine.cofactor(body.deformation) * body.rate).sum()


def pressure_size(body: Characteristic, options: Options) -> Found:
    """U/|W|, and what a body without pressure would do otherwise."""
    zone = body.zone
    assert zone is not None
    share = body.thermal_to_gravitational
    number = zone.pressure / zone.weight if share is None and zone.weight > 0.0 else share or 0.0
    if body.held:
        return number, 1.0
    if zone.pressure == 0.0:
        return number, 0.0
    return number, max(difference(zone, body.end, pressure=0.0), within_all(body.fallen))


ENTRY = Entry(
    "pressure gradient of the fluid",
    {
        "order": choice(
            "order in the smoothing length of the error of densities: fourth takes out what smoothing adds to them",
            "second", "fourth", models=("sph",),
        ),
        "gradients": choice(
            "the kernel's own slope, which keeps the entropy of smooth flow exact; or integral, of a matrix that "
            "straightens out how neighbours lie: less noise in subsonic flow, no surface tension at contacts",
            "kernel", "integral", models=("sph",),
        ),
    },
    "neighbours", "Springel & Hernquist 2002", ALL_MODELS, colour="vermillion", auto="always", made=Pressure, rank=2,
    limit_power=1.0 / 3.0,
    size=Measure(
        "U/|W|", "I of one zone with 3 Pi and without; mass whose free fall ends",
        "Chandrasekhar 1969, section 14", pressure_size, ZONE,
    ),
    gradients=lambda options: options["order"] == "fourth" or options["gradients"] == "integral",
)  # fmt: skip
