"""What an effect is: the parts of the equations of motion that a scene can call for, one at a time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import jax
import numpy as np

from astroinertia.effects.entries import Option
from astroinertia.effects.measure import Measure
from astroinertia.engines.terms import PairTerm

PARTS = (
    "gradient_fields",
    "fields",
    "initial_memory",
    "remember",
    "own_sums",
    "acceleration",
    "drag",
    "reaction",
    "history",
    "exchange",
    "potential_energy",
    "virial",
    "timestep",
    "affine_force",
    "affine_push",
    "affine_virial",
    "affine_potential",
    "affine_heating",
    "torque",
    "slip",
    "potential",
    "rigid_virial",
    "impulse",
    "frequency",
)


def scoped(kind: str, part: Callable) -> Callable:
    """A part of an effect whose operations carry its name in compiled programs, so that its absence can be shown."""

    @functools.wraps(part)
    def named(*arguments: Any) -> Any:
        with jax.named_scope(f"effect:{kind}"):
            return part(*arguments)

    return named


def is_pytree(made: type) -> bool:
    """Whether JAX knows the parts of a class, by @pytree."""
    return not jax.tree_util.all_leaves([object.__new__(made)])


@dataclass(frozen=True, eq=False)
class Effect:
    """One force or energy exchange, with an acceleration of its own, so that its virial tensor can be taken (G = 1).

    A subclass is a frozen dataclass registered as a pytree; numbers are leaves, choices are static, and an option that
    is None is absent from what is compiled. It overrides what it has and leaves the rest. One evaluation runs

        gradient_fields -> gradient pass (fluid.gradients) -> remember (fluid.memory) -> fields
        -> neighbour and all-pairs passes, own_sums (fluid.sums)
        -> acceleration, drag, exchange, potential_energy, virial, timestep

    `fluid` has time, mass (N,), position (N, 3), velocity (N, 3), entropy (N,), smoothing_length (N,), density (N,),
    grad_h (N,), zeta (N,) where softening is adaptive, pressure (N,), sound_speed (N,), internal_energy (N,) (of unit
    mass), thermal_energy (N,) (its part above the cold curve), acceleration (N, 3) (total of the previous evaluation,
    zero on the first), gradients and sums {kind: {output: array}}, memory {name: array}, points {kind: point masses
    beside the fluid}, kernel (a name), centre (3,) and centre_velocity (3,) of mass. Pair outputs: "acceleration"
    (central), "heating" (sum, du/dt), "potential" (sum), "signal" (max, a speed that must not cross a smoothing length
    within the time step).

    With individual time steps the fluid may hold some of the body's particles alone (centre and centre_velocity stay
    those of the whole), and `remember` is given an interval for each, (N,). An acceleration then acts on a particle
    over its own interval; that of an effect of the whole body, on all of them over the longest.

    The affine parts are for a body whose matter moves as x = centre + F xi: `body` there has time, mass,
    second_moment (q of the sphere F = 1 along an axis), sphere_energy (its W), deformation F and rate dF/dt (3, 3),
    centre and velocity (3,), pressure_slope (dU/dJ), and conservative (d2F/dt2 by gravity and pressure alone, a
    function of F and dF/dt).

    The rigid parts are for a body that keeps its shape or changes it as prescribed: `body` there is models.rigid.View.

    An effect that is not of this package (effects.own) says of itself what the catalogue says of the others: `options`,
    `source`, `models`, `numerical` and `size`; the first paragraph of its docstring says in plans what it is.
    """

    kind: ClassVar[str]
    options: ClassVar[Mapping[str, Option]] = {}
    """Each field: its dimension, default, limits and meaning."""
    source: ClassVar[str] = "no source is stated"
    """Where its equations come from."""
    models: ClassVar[tuple[str, ...]] = ("sph",)
    """Those that it has parts for."""
    numerical: ClassVar[bool] = False
    """A device of particles and no physics: other models do without."""
    size: ClassVar[Measure | None] = None
    """How large it is in a scene, and what leaving it out would change; None where it does not say."""
    external: ClassVar[bool] = False
    """Exchanges momentum or energy with the outside of the fluid."""
    central: ClassVar[bool] = False
    """Acts between particles along their separation: no net force, symmetric virial tensor."""
    whole_body: ClassVar[bool] = False
    """Its acceleration depends on the body as a whole: with individual time steps it acts with the longest of them."""
    follows_spin: ClassVar[bool] = False
    """Its torque depends on the angular velocity or on L, or it has a slip."""
    conservative: ClassVar[bool] = False
    """Its `potential` does not depend on time: what it does to a rigid body is found again there."""

    def __init_subclass__(cls) -> None:
        for name in PARTS:
            if name in vars(cls):
                setattr(cls, name, scoped(cls.kind, vars(cls)[name]))

    @classmethod
    def from_options(cls, options: dict[str, Any]) -> Self:
        """The effect from its options in code units; raises ValueError, in one sentence, where they contradict."""
        return cls(**options)

    @property
    def needs_zeta(self) -> bool:
        """Whether it needs fluid.zeta, the response of the softened potential to the smoothing length."""
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

    def acceleration(self, xp: Any, fluid: Any) -> Any | None:
        """Per-particle acceleration (N, 3) that does not depend on the particle's own velocity."""
        return None

    def drag(self, fluid: Any) -> Any | None:
        """Matrix M (3, 3) of an acceleration M v, taken at the mean velocity of a kick."""
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
        """The same with the whole body as it is now, once a step; with individual steps, once in the longest."""
        return None

    def recorded(self, state: Any) -> dict[str, Any]:
        """Arrays that a record of the series has of the effect beside its rows (observables.quantities.OF_EFFECTS)."""
        return {}

    def exchange(self, xp: Any, fluid: Any) -> tuple[Any, Any] | None:
        """Gain g and decay k, each (N,), of du/dt = g - k u: heat exchanged with the surroundings, u thermal energy."""
        return None

    def arranged(self, engine: Any, arrangement: Any, state: Any) -> Any | None:
        """What own_sums needs to know of particles that were just sorted (integrate.leapfrog.State), if anything."""
        return None

    def own_sums(
        self, engine: Any, arrangement: Any, own: Any, fluid: Any, before: dict[str, Any], virial: bool
    ) -> dict[str, Any]:
        """Sums that the effect takes by a method of its own, {output: array}; with `virial` also its V, (3, 3).

        arrangement: the engine's; own: what `arranged` made; before: the effect's sums of the evaluation before, {} on
        the first.
        """
        return {}

    def potential_energy(self, xp: Any, fluid: Any) -> Any | None:
        """Scalar whose gradient is the effect's force, where there is one."""
        return None

    def virial(self, xp: Any, fluid: Any) -> Any | None:
        """V (3, 3) = sum m (x - centre) (x) a of a per-particle effect, drag included, by a route of its own."""
        return None

    def timestep(self, xp: Any, fluid: Any) -> Any | None:
        """The effect's own time for each particle (N,), or for all, which is multiplied by the Courant factor."""
        return None

    @property
    def potential_moves(self) -> bool:
        """Whether the potential changes by itself with time, so that it exchanges energy with what is outside."""
        return False

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

    def torque(self, body: Any) -> Any | None:
        """Torque (3,) on a rigid body about its centre of mass, or its pivot, in inertial axes."""
        return None

    def slip(self, body: Any) -> Any | None:
        """Angular velocity (3,) by which a rigid body's axes turn beyond I^-1 L: internal forces, which leave L alone.

        Its power, slip . (omega cross L), must not be positive: it is the heat that the body gains.
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

    def breaks(self, start: float, end: float) -> tuple[float, ...]:
        """Times after the start, up to the end, at which a rigid body's torque begins or ends, or an impulse comes."""
        return ()

    def during(self, start: float, end: float) -> Self:
        """The effect as it is between two breaks: the same, with other numbers."""
        return self

    def impulse(self, body: Any) -> Any | None:
        """What is added to the angular momentum of a rigid body at once, (3,), at one of the breaks."""
        return None


def moments(fluid: Any) -> tuple[Any, Any]:
    """Second moment Q = sum m x (x) x and mixed moment P = sum m x (x) v about the centre of mass, each (3, 3)."""
    position = fluid.position - fluid.centre
    weighted = (fluid.mass[:, None] * position).T
    return weighted @ position, weighted @ (fluid.velocity - fluid.centre_velocity)


def antisymmetric_vector(xp: Any, tensor: Any) -> Any:
    """eps_ijk T_jk, (3,): the angular momentum in P, the torque in V_e."""
    return xp.stack([tensor[1, 2] - tensor[2, 1], tensor[2, 0] - tensor[0, 2], tensor[0, 1] - tensor[1, 0]])


# Generators of the rotations: (GENERATORS[k])[i, j] = -epsilon_kij, so that a rotation about axis k turns i towards j.
GENERATORS = np.array(
    [
        [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    ]
)


def angular_velocity_matrix(rate: Any, axis: Any) -> Any:
    """The matrix [w] with [w] x = w cross x for w = rate * axis/|axis|, shape (3, 3)."""
    x, y, z = axis[0], axis[1], axis[2]
    generator = x * GENERATORS[0] + y * GENERATORS[1] + z * GENERATORS[2]
    return generator * (rate / (x * x + y * y + z * z) ** 0.5)
