"""What an effect may do to a fluid of particles, to an affine body (x = centre + F xi), and to a rigid one."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from astroinertia.engines.terms import PairTerm


class ParticleParts:
    """The parts of an effect on particles.

    One evaluation runs

        gradient_fields -> gradient pass (fluid.gradients) -> remember (fluid.memory) -> fields
        -> neighbour and all-pairs passes, own_sums (fluid.sums) -> remember_sums (fluid.memory)
        -> acceleration, drag, exchange, potential_energy, virial, timestep

    `fluid` is a sph.fluid.Fluid: time, mass (N,), position (N, 3), velocity (N, 3), entropy (N,), smoothing_length
    (N,), density (N,), grad_h (N,), zeta (N,) where softening is adaptive, contrast (N,) where the density is of fourth
    order, pressure (N,), sound_speed (N,),
    internal_energy (N,) (of unit mass), thermal_energy (N,) (its part above the cold curve), acceleration (N, 3) (total
    of the previous evaluation, zero on the first), gradients and sums {kind: {output: array}}, memory {name: array},
    points {kind: point masses beside the fluid}, kernel (a name), centre (3,) and centre_velocity (3,) of mass. Pair
    outputs with a meaning: "acceleration" (central), "heating" (sum, du/dt), "signal" (max, a speed that must not cross
    a smoothing length within the time step). Others are for the effect itself: gravity's potential_energy sums its
    "potential" from fluid.sums. Fields and memories have names that no other effect has, or the same array by one name.
    memory may have further_pressure and further_energy (N,): what pressure and specific energy have by an effect beyond
    the equation of state's.

    With individual time steps the fluid may hold some of the body's particles alone (centre and centre_velocity stay
    those of the whole), and `remember` is given an interval for each, (N,). An acceleration then acts on a particle
    over its own interval; that of an effect of the whole body, on all of them over the longest. So a class whose
    acceleration of a particle depends on others, but for the body's centre, says `whole_body: ClassVar[bool] = True`.
    """

    whole_body: ClassVar[bool] = False
    """Its acceleration depends on the body as a whole: with individual time steps it acts with the longest of them."""
    limited_by_density: ClassVar[bool] = False
    """Its time step follows from options, density and smoothing length alone, so that it is known before a run."""
    follows_place: ClassVar[bool] = False
    """Its acceleration follows from options and places alone, its time step from these and the speeds there."""

    @property
    def needs_zeta(self) -> bool:
        """Whether it needs fluid.zeta, the response of the softened potential to the smoothing length."""
        return False

    @property
    def needs_contrast(self) -> bool:
        """Whether it needs a density of fourth order in the smoothing length (sph.fourth_order)."""
        return False

    @property
    def needs_heat(self) -> bool:
        """Whether its energy is only kept by matter that can be warm."""
        return False

    @property
    def fixed_length(self) -> Any | None:
        """The smoothing length that it asks all particles to keep; None where lengths follow the density."""
        return None

    @property
    def direct(self) -> Self:
        """The effect with plain sums over all pairs in place of sums of its own: for few particles."""
        return self

    @property
    def settling(self) -> Self:
        """The effect with forces that have a potential, with which a body settles."""
        return self

    @property
    def of_volumes(self) -> Self:
        """The effect where densities are sums of standard volumes (sph.standard_volumes)."""
        return self

    @property
    def gradient_terms(self) -> tuple[PairTerm, ...]:
        """Pair terms of the pass before the forces, over neighbours."""
        return ()

    @property
    def neighbour_terms(self) -> tuple[PairTerm, ...]:
        """Pair terms of the force pass over neighbours."""
        return ()

    @property
    def all_pair_terms(self) -> tuple[PairTerm, ...]:
        """Pair terms over all pairs."""
        return ()

    def gradient_fields(self, xp: Any, fluid: Any) -> dict[str, Any]:
        """Per-particle fields that gradient_terms name, beyond mass, position, velocity and smoothing_length."""
        return {}

    def fields(self, xp: Any, fluid: Any) -> dict[str, Any]:
        """Per-particle fields that neighbour_terms and all_pair_terms name."""
        return {}

    def initial_memory(self, xp: Any, fluid: Any) -> dict[str, Any]:
        """State of the effect's own, one array (N,) a name, before the first evaluation."""
        return {}

    def remember(self, xp: Any, fluid: Any, interval: Any) -> dict[str, Any]:
        """That state, `interval` after it was last brought up to date (0 on the first evaluation)."""
        return {}

    def remember_sums(self, xp: Any, fluid: Any) -> dict[str, Any]:
        """What of that state follows from the sums over pairs, for the next evaluation."""
        return {}

    def recalled(self, xp: Any, arrays: Any) -> dict[str, Any]:
        """What of that state the arrays (N,) of a snapshot have, by name; what they lack begins again."""
        return {}

    def acceleration(self, xp: Any, fluid: Any) -> Any | None:
        """Per-particle acceleration (N, 3) that does not depend on the particle's own velocity."""
        return None

    def drag(self, fluid: Any) -> Any | None:
        """Matrix M (3, 3) of an acceleration M v, taken at the mean velocity of a kick."""
        return None

    def frame_rotation(self, fluid: Any) -> Any | None:
        """The matrix [Omega] (3, 3) of the frame that velocities are relative to, of an effect that `turns_frame`."""
        return None

    def reaction(self, xp: Any, fluid: Any, weight: Any) -> Any | None:
        """sum over particles of weight (N,) times what unit mass does to the effect's moving point masses, (n, 3).

        With masses as the weights it is their acceleration, with masses times a span of time what is added to their
        velocities: minus what the effect does to the fluid.
        """
        return None

    def initial_history(self, xp: Any) -> Any | None:
        """What the effect keeps of the whole body from step to step, beside the particles, in fluid.points."""
        return None

    def history(self, xp: Any, fluid: Any) -> Any | None:
        """The same with the whole body as it is now, once a step; with individual steps, once in the longest.

        Its velocities are those that the step ends with, and no predicted ones.
        """
        return None

    def recorded(self, state: Any) -> dict[str, Any]:
        """Arrays that a record of the series has of the effect beside its rows (observables.quantities.OF_EFFECTS)."""
        return {}

    def exchange(self, xp: Any, fluid: Any) -> tuple[Any, Any] | None:
        """Gain g and decay k, each (N,), of du/dt = g - k u: heat exchanged with the surroundings, u thermal energy."""
        return None

    def arranged(self, engine: Any, arrangement: Any, state: Any) -> Any | None:
        """What own_sums needs to know of particles that were just sorted (models.sph.state.State), if anything."""
        return None

    def own_sums(
        self, engine: Any, arrangement: Any, own: Any, fluid: Any, before: dict[str, Any], virial: bool
    ) -> dict[str, Any]:
        """Sums that the effect takes by a method of its own, {output: array}; with `virial` its V (3, 3) counts alone.

        arrangement: the engine's; own: what `arranged` made; before: the effect's sums of the evaluation before, {} on
        the first.
        """
        return {}

    def potential_energy(self, xp: Any, fluid: Any) -> Any | None:
        """Scalar whose gradient is the effect's force, where there is one."""
        return None

    def virial(self, xp: Any, fluid: Any) -> Any | None:
        """V (3, 3) = sum m (x - centre) (x) a of a per-particle effect, drag included, by a route of its own.

        Without it that sum itself is recorded, and nothing checks it.
        """
        return None

    def timestep(self, xp: Any, fluid: Any) -> Any | None:
        """The effect's own time for each particle (N,), or for all, which is multiplied by the Courant factor."""
        return None


class AffineParts:
    """The parts of an effect on an affine body.

    `body` has time, mass, second_moment (q of the sphere F = 1 along an axis), sphere_energy (its W), deformation F and
    rate dF/dt (3, 3), centre and velocity (3,), pressure_slope (dU/dJ), and conservative (d2F/dt2 by gravity and
    pressure alone, a function of F and dF/dt).
    """

    def affine_force(self, body: Any) -> Any | None:
        """G = sum m a (x) xi, (3, 3), of an affine body: its share of q d2F/dt2."""
        return None

    def affine_push(self, body: Any) -> Any | None:
        """Net force (3,) on an affine body."""
        return None

    def affine_virial(self, body: Any) -> Any | None:
        """V = sum m (x - centre) (x) a, (3, 3), of an affine body, by a route of its own; F G^T where there is none."""
        return None

    def affine_potential(self, body: Any) -> Any | None:
        """Scalar that the force on an affine body derives from, where there is one."""
        return None

    def affine_heating(self, body: Any) -> Any | None:
        """Energy per time that an affine body is heated by."""
        return None


class RigidParts:
    """The parts of an effect on a rigid body.

    `body` has time, mass, attitude (3, 3) (the body's axes as the scene gives them, one a row), moments (3,) (about
    those axes), principal_moments (3,) (ascending, at rest), inertia (3, 3), angular_momentum (3,) and angular_velocity
    (3,), all in inertial axes, about the centre of mass or the pivot; and companions, whose `position` at a time is
    (n, 3).

    A torque is taken for one that depends on the angular velocity or on L. Where it does not, a class says
    `follows_spin: ClassVar[bool] = False`: the integrator "splitting" then takes far less time for it. It says
    `conservative: ClassVar[bool] = True` where its `potential` does not depend on time, so that
    integration_energy_error compares its work with it.
    """

    follows_spin: ClassVar[bool] = False
    """Its torque depends on the angular velocity or on L, or it has a relative rotation: so with a part for either,
    unless its class says that it does not."""
    conservative: ClassVar[bool] = False
    """Its `potential` does not depend on time: what it does to a rigid body is found again there."""

    def torque(self, body: Any) -> Any | None:
        """Torque (3,) on a rigid body about its centre of mass, or its pivot, in inertial axes."""
        return None

    def relative_rotation(self, body: Any) -> Any | None:
        """Angular velocity (3,) by which a rigid body's axes turn beyond I^-1 L: internal forces, which leave L alone.

        Its power, s . (omega cross L), must not be positive: it is the heat that the body gains.
        """
        return None

    def potential(self, body: Any) -> Any | None:
        """Scalar that the torque on a rigid body derives from, where there is one."""
        return None

    def rigid_virial(self, body: Any) -> Any | None:
        """V (3, 3) of a rigid body about its centre of mass; without it, the torque's antisymmetric part alone."""
        return None

    def frequency(self, body: Any) -> Any | None:
        """The largest angular frequency that the torque brings to a rigid body, which steps must resolve."""
        return None

    def impulse(self, body: Any) -> Any | None:
        """What is added to the angular momentum of a rigid body at once, (3,), at one of the breaks."""
        return None
