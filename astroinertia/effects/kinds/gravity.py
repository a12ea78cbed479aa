"""The fluid's own gravity, softened by its kernel."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

from astroinertia.effects import Characteristic, Effect, Entry, Output, PairTerm, pytree
from astroinertia.effects.entries import FORCE_ERROR
from astroinertia.effects.measure import ZONE, Found, Measure, Options, within_all
from astroinertia.effects.one_zone import difference
from astroinertia.engines.elementwise import elementwise
from astroinertia.gravity.clamped_points import POINTS, SOFTENED_LESS_POINT
from astroinertia.gravity.direct import DIRECT_GRAVITY
from astroinertia.sph.fourth_order import smoothed
from astroinertia.sph.kernels import KERNELS
from astroinertia.sph.standard_volumes import weighed
from astroinertia.units import ALL_MODELS, Option, choice

FREE_FALL_PART = 0.3  # of the free-fall time, that its time-step limit is


def softening_pair(xp, dW_i, dW_j, zeta_over_omega_i, zeta_over_omega_j):
    """The force of a softening that adapts, in the same form as pressure."""
    return (0.5 * (zeta_over_omega_i * dW_i + zeta_over_omega_j * dW_j),)


def softening_pair_of_volumes(xp, dW_i, dW_j, zeta_over_omega_i, zeta_over_omega_j, volume_i, volume_j):
    """The same where densities are sums of standard volumes (sph.standard_volumes)."""
    return (0.5 * (zeta_over_omega_i * volume_j * dW_i + zeta_over_omega_j * volume_i * dW_j),)


def response_pair(xp, r, phi_i, dphi_i):
    """-h dphi/dh."""
    return (phi_i + r * dphi_i,)


SOFTENING = PairTerm("gravity", softening_pair, (Output("acceleration", "central"),))

SOFTENING_OF_VOLUMES = PairTerm("gravity", softening_pair_of_volumes, SOFTENING.outputs)
RESPONSE = PairTerm("gravity", response_pair, (Output("response", "sum"),))


@pytree
@dataclass(frozen=True, eq=False)
class Gravity(Effect):
    """Sum over all pairs with kernel softening, and the term that keeps energy when the softening adapts.

    a_i = -sum_j m_j (phi'(r, h_i) + phi'(r, h_j))/2 rhat
          - 1/2 sum_j m_j [zeta_i/Omega_i dW_i + zeta_j/Omega_j dW_j] rhat,
    the exact gradient of 1/2 sum_i sum_j m_i m_j (phi(r, h_i) + phi(r, h_j))/2, self pairs included
    (Price & Monaghan 2007, eqs. 13 to 24). method: auto is settled by whoever knows the number of particles
    (build/effects.py), and else is direct; points: as multipole, its points summed pair by pair; force_error: wanted
    rms of |da|/|a| by multipoles. softening: the smoothing length of all particles, which then stays as it is and needs
    no neighbours; the second sum is nil. None: lengths follow the density.

    volumes: whether densities are sums of standard volumes, which problems know (sph.standard_volumes); zeta is then
    sum_j m_j (phi + r phi')/(3 rho), of the pass before the forces.

    order "fourth" adds -pi sum_i m_i s h_i^2 rho_i to the potential energy, s h^2 the kernel's second moment along an
    axis, and what follows from it to zeta, -2/3 pi s h^2. That is what softening takes from the binding energy in
    leading order: a potential softened by W is Phi + (s h^2/2) lap Phi, lap Phi = 4 pi rho (Dehnen 2001, MNRAS 324,
    273, section 2.2).
    """

    method: Literal["auto", "direct", "multipole", "points"] = field(default="auto", metadata={"static": True})
    force_error: float = FORCE_ERROR
    softening: Any = None
    order: Literal["second", "fourth"] = field(default="second", metadata={"static": True})
    volumes: bool = field(default=False, metadata={"static": True, "of_problem": True})

    kind: ClassVar[str] = "gravity"
    limited_by_density: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses a fourth order with softening that does not adapt."""
        if options["order"] == "fourth" and options["softening"] is not None:
            raise ValueError('order = "fourth" is for softening that follows the density; leave softening away.')
        return cls(**options)

    @property
    def needs_zeta(self):
        """Where the softening adapts and the density pass, which weighs particles by mass, can sum it up."""
        return self.softening is None and not self.volumes

    @property
    def of_volumes(self):
        """The same softening by lengths that follow from standard volumes."""
        return replace(self, volumes=True)

    @property
    def gradient_terms(self):
        """How potentials change with the length, where that follows from standard volumes and not from mass."""
        return (RESPONSE,) if self.softening is None and self.volumes else ()

    @property
    def fixed_length(self):
        """The softening that was asked for."""
        return self.softening

    @property
    def direct(self):
        """The same by direct sums."""
        return replace(self, method="points") if self.method == "multipole" else self

    @property
    def neighbour_terms(self):
        """The term of a softening that adapts, and what softening changes where points are summed."""
        adapting = (SOFTENING_OF_VOLUMES if self.volumes else SOFTENING,) if self.softening is None else ()
        return (*adapting, SOFTENED_LESS_POINT) if self.method in ("multipole", "points") else adapting

    @property
    def all_pair_terms(self):
        """The attraction of all pairs, by direct sums."""
        return {"multipole": (), "points": (POINTS,)}.get(self.method, (DIRECT_GRAVITY,))

    def fields(self, xp, fluid):
        """zeta/Omega, where the softening adapts."""
        if self.softening is not None:
            return {}
        unbiased = fluid.zeta
        if self.volumes:
            unbiased = fluid.gradients[self.kind]["response"] / (3.0 * self.kernel_density(xp, fluid))
        if self.order == "fourth":
            unbiased = unbiased - 2.0 / 3.0 * math.pi * KERNELS[fluid.kernel].variance * fluid.smoothing_length**2
        own = {"zeta_over_omega": unbiased / fluid.grad_h}
        return weighed(own, fluid, "zeta_over_omega") if self.volumes else own

    def kernel_density(self, xp, fluid):
        """The density that the smoothing length follows."""
        if fluid.contrast is None:
            return fluid.density
        return elementwise(xp, smoothed, fluid.density, fluid.contrast)[0]

    def arranged(self, engine, arrangement, state):
        """The tree that expansions are made on, and in the xla engine all interactions."""
        if self.method != "multipole":
            return None
        if engine.name != "xla":
            from astroinertia.gravity import multipole  # not at the top: direct sums do without

            return multipole.tree(state.position, threads=engine.workers)
        from astroinertia.gravity import multipole_xla

        last = state.rates.fluid
        acceleration = None if last is None else last.sums["gravity"]["acceleration"]
        return multipole_xla.lists_for(engine, arrangement, state.mass, acceleration, self.force_error)

    def own_sums(self, engine, arrangement, own, fluid, before, virial):
        """The attraction of all pairs by expansions, opened by the accelerations of the evaluation before."""
        if own is None:
            return {}
        if engine.name == "xla":
            from astroinertia.gravity import multipole_xla

            given = engine.precision, own, fluid.mass, fluid.position, fluid.smoothing_length
            return {"virial": multipole_xla.virial(*given)} if virial else multipole_xla.points(*given)
        from astroinertia.gravity import multipole

        acceleration = before.get("acceleration")
        strength = None if acceleration is None else multipole.strengths(acceleration)
        points = fluid.mass, fluid.position, fluid.smoothing_length
        if virial:
            tensor = multipole.virial(
                *points, self.force_error, strength, engine.workers, own, engine.precision, engine.together
            )
            return {"virial": tensor}
        acceleration, potential = multipole.gravity(
            *points, None, self.force_error, strength, engine.workers, own, engine.precision, engine.together
        )
        return {"acceleration": acceleration, "potential": potential}

    def potential_energy(self, xp, fluid):
        """1/2 sum m Phi, with the particle's own softened potential in it."""
        potential = fluid.sums["gravity"]["potential"]
        if self.order == "fourth":
            density = self.kernel_density(xp, fluid)
            second_moment = KERNELS[fluid.kernel].variance * fluid.smoothing_length**2
            potential = potential - 2.0 * math.pi * second_moment * density
        return 0.5 * xp.sum(fluid.mass * potential)

    def timestep(self, xp, fluid):
        """A part of the free-fall time sqrt(3 pi/(32 rho)), for cold gas, which has no sound."""
        return FREE_FALL_PART * xp.sqrt(3.0 * math.pi / (32.0 * fluid.density))

    def affine_force(self, body):
        """-dW/dF with W = W_sphere R_F: exact where the density falls off on similar ellipsoids."""
        from astroinertia.bodies import affine

        return affine.gravity_force(body.deformation, body.sphere_energy)

    def affine_virial(self, body):
        """Chandrasekhar's potential-energy tensor, of trace W."""
        from astroinertia.bodies import affine

        return affine.gravity_tensor(body.deformation, body.sphere_energy)

    def affine_potential(self, body):
        """W (Roberts 1962, ApJ 136, 1108)."""
        from astroinertia.bodies import affine

        return affine.gravitational_energy(body.deformation, body.sphere_energy)


def _size(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None
    weight_over_heat = zone.weight / (zone.pressure + zone.turning) if zone.pressure + zone.turning > 0.0 else math.inf
    if body.held:
        return weight_over_heat, within_all(zone.weight * body.end**2)
    return weight_over_heat, difference(zone, body.end, weight=0.0)


ENTRY = Entry(
    "self-gravity of the body (particles are softened by their own kernel)",
    {
        "method": choice(
            "how particles attract each other: direct sums over all pairs, exact and N^2; multipole expansions of "
            "far groups, to an error that is asked for; auto is what takes less time",
            "auto", "direct", "multipole", models=("sph",),
        ),
        "force_error": Option(
            "dimensionless", FORCE_ERROR, "of multipole: wanted rms of the relative error of the accelerations",
            minimum=1e-8, maximum=0.03, models=("sph",),
        ),
        "softening": Option(
            "length", None,
            "smoothing length of every particle, kept as it is, where no effect acts between neighbours; without "
            "it, lengths follow the density",
            minimum=0.0, exclusive=True, models=("sph",),
        ),
        "order": choice(
            "order in the smoothing length of the error of the binding energy: fourth takes out what softening "
            "leaves out of it",
            "second", "fourth", models=("sph",),
        ),
    },
    "all pairs", "Price & Monaghan 2007; Dehnen 2014", ALL_MODELS, colour="blue", auto="always", made=Gravity, rank=1,
    size=Measure(
        "|W| over 3 Pi + 2 T", "I of one zone by the virial theorem, with |W| and without",
        "Chandrasekhar 1969, section 14", _size, ZONE,
    ),
)  # fmt: skip
