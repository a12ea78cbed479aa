"""A body whose matter moves as x = centre + F xi: its state, the forces on it and its rates of change.

xi runs over the reference sphere, of second moment q along an axis; q d2F/dt2 is the sum of the forces
G = sum m a (x) xi of all effects, M d2(centre)/dt2 that of their pushes. The ledger is integrated beside it, from the
virial tensors that effects state by routes of their own: dQ/dt = P + P^T, dP/dt = K + sum V. Sources: Chandrasekhar
1969, Ellipsoidal Figures of Equilibrium, ch. 4 and section 11; Carter & Luminet 1985, MNRAS 212, 23.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from astroinertia.bodies.affine import cofactor, volume_ratio
from astroinertia.bodies.affine_motion import constraint_slope
from astroinertia.engines.brief import brief
from astroinertia.engines.pytree import pytree

Array = Any
PRESSURE = "pressure"
CONSERVATIVE = ("gravity", PRESSURE)  # what an isolated body moves by, to lowest order


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


class State(NamedTuple):
    """What is integrated: F and dF/dt (3, 3), the centre of mass and its velocity (3,), heat (), and the ledger.

    second_moment and mixed_moment (3, 3) are Q and P by their own equations; mixed_impulse (E, 3, 3), impulse (E, 3),
    work (E,) and heating (E,) what each effect has added to P, momentum, kinetic and internal energy.
    """

    deformation: Array
    rate: Array
    centre: Array
    velocity: Array
    heat: Array
    second_moment: Array
    mixed_moment: Array
    mixed_impulse: Array
    impulse: Array
    work: Array
    heating: Array


UNSCALED = State(np.ones((3, 3)), np.ones((3, 3)), *[1.0] * (len(State._fields) - 2))


@pytree
@dataclass(frozen=True)
class Problem:
    """The physics of an affine body, in code units.

    second_moment and sphere_energy are q and W of the sphere F = 1 (radius: its radius). matter is None where there is
    no pressure, or where the fluid is incompressible: then `volume` is the J that is kept, and `restoring` the rate at
    which errors of it decay. scale holds a unit for each number of the state, so that all are of order 1 in the
    integrator; the smallest semi-axis, over `radius`, must not fall below `smallest`.
    """

    effects: tuple[Any, ...]
    mass: Array
    radius: Array
    second_moment: Array
    sphere_energy: Array
    matter: Matter | None = None
    volume: Array | None = None
    restoring: Array = 0.0
    scale: State = UNSCALED
    smallest: Array = 0.0

    @property
    def effect_names(self) -> tuple[str, ...]:
        """The kinds of the effects, in the order of the ledger's rows."""
        return tuple(effect.kind for effect in self.effects)

    @property
    def incompressible(self) -> bool:
        """Whether pressure is what keeps the volume."""
        return self.volume is not None


class AffineBody(NamedTuple):
    """The body as effects see it (effects.effect.Effect says what is what)."""

    time: Array
    mass: Array
    second_moment: Array
    sphere_energy: Array
    deformation: Array
    rate: Array
    centre: Array
    velocity: Array
    pressure_slope: Array | None
    conservative: Any


class Observed(NamedTuple):
    """Forces (E, 3, 3), pushes (E, 3), virial tensors (E, 3, 3); kinetic, internal and, by effect, potential energies.

    reaches has, of each perturber, the square of the longest semi-axis over that of its distance.
    """

    forces: Array
    pushes: Array
    virials: Array
    kinetic: Array
    internal: Array
    potentials: dict[str, Array]
    reaches: dict[str, Array]


def body_at(problem: Problem, time: Array, state: State) -> tuple[AffineBody, list[Array]]:
    """The body of a state (in code units) with the pressure that acts on it, and the force G (3, 3) of each effect."""
    body = AffineBody(
        time=time,
        mass=problem.mass,
        second_moment=problem.second_moment,
        sphere_energy=problem.sphere_energy,
        deformation=state.deformation,
        rate=state.rate,
        centre=state.centre,
        velocity=state.velocity,
        pressure_slope=None,
        conservative=partial(_conservative_acceleration, problem, state.heat),
    )
    return _pressed(problem, problem.effects, body, state.heat)


def force_on(effect: Any, body: AffineBody) -> Array:
    """G (3, 3) of one effect; zero where it has none."""
    force = effect.affine_force(body)
    return jnp.zeros((3, 3)) if force is None else force


def push_on(effect: Any, body: AffineBody) -> Array:
    """Net force (3,) of one effect; zero where it has none."""
    push = effect.affine_push(body)
    return jnp.zeros(3) if push is None else push


@brief
def observed(problem: Problem, time: Array, state: State) -> Observed:
    """What a record needs of the effects at a state, in one compiled program."""
    body, forces = body_at(problem, time, state)
    moving = 0.5 * problem.second_moment * jnp.sum(state.rate**2) + 0.5 * problem.mass * jnp.sum(state.velocity**2)
    potentials = {effect.kind: effect.affine_potential(body) for effect in problem.effects}
    return Observed(
        forces=_stacked(forces, (3, 3)),
        pushes=_stacked([push_on(effect, body) for effect in problem.effects], (3,)),
        virials=_stacked(_virials(problem, body, forces), (3, 3)),
        kinetic=moving,
        internal=internal_energy(problem, state),
        potentials={kind: energy for kind, energy in potentials.items() if energy is not None},
        reaches=reaches(problem, body),
    )


def internal_energy(problem: Problem, state: State) -> Array:
    """U, zero where there is none."""
    return (
        jnp.zeros(()) if problem.matter is None else problem.matter.energy(volume_ratio(state.deformation), state.heat)
    )


@partial(brief, inline=True)
def measured(problem: Problem, state: State) -> State:
    """The state, or its rate, in the problem's own units."""
    return State(*(value / unit for value, unit in zip(state, problem.scale, strict=True)))


@partial(brief, inline=True)
def unmeasured(problem: Problem, scaled: State) -> State:
    """The state in code units."""
    return State(*(value * unit for value, unit in zip(scaled, problem.scale, strict=True)))


def scaled_rate(time: Array, scaled: State, problem: Problem) -> State:
    """The rate of change of the state in its own units: what an integrator needs."""
    return measured(problem, rate_of_change(time, unmeasured(problem, scaled), problem))


def rate_of_change(time: Array, state: State, problem: Problem) -> State:
    """d state/dt, in code units."""
    (body, forces), moment = body_at(problem, time, state), problem.second_moment
    pushes = [push_on(effect, body) for effect in problem.effects]
    virials = _virials(problem, body, forces)
    heating = [_heating(problem, effect, body) for effect in problem.effects]
    kinetic = moment * state.rate @ state.rate.T
    heat_input = sum(
        (h for effect, h in zip(problem.effects, heating, strict=True) if effect.kind != PRESSURE), jnp.zeros(())
    )
    heat_rate = jnp.zeros(())
    if problem.matter is not None:
        heat_rate = problem.matter.heat_rate(volume_ratio(state.deformation), heat_input)
    return State(
        deformation=state.rate,
        rate=sum(forces, jnp.zeros((3, 3))) / moment,
        centre=state.velocity,
        velocity=sum(pushes, jnp.zeros(3)) / problem.mass,
        heat=heat_rate,
        second_moment=state.mixed_moment + state.mixed_moment.T,
        mixed_moment=kinetic + sum(virials, jnp.zeros((3, 3))),
        mixed_impulse=_stacked(virials, (3, 3)),
        impulse=_stacked(pushes, (3,)),
        work=_stacked([(f * state.rate).sum() + p @ state.velocity for f, p in zip(forces, pushes, strict=True)], ()),
        heating=_stacked(heating, ()),
    )


def ended(time: Array, scaled: State, problem: Problem) -> Array:
    """Whether the body has collapsed along an axis, reaches out to a perturber, or is no longer finite."""
    state = unmeasured(problem, scaled)
    over = thickness(state.deformation) < problem.smallest
    over = over | ~jnp.isfinite(jnp.sum(state.deformation) + jnp.sum(state.rate))
    for reach in reaches(problem, body_at(problem, time, state)[0]).values():
        over = over | (reach >= 1.0)
    return over


@partial(brief, inline=True)
def thickness(deformation: Array) -> Array:
    """det F/|cof F|: between the smallest stretch and 1/3^(1/2) of it, negative where matter is turned inside out."""
    return volume_ratio(deformation) / jnp.sqrt(jnp.sum(cofactor(deformation) ** 2))


def reaches(problem: Problem, body: AffineBody) -> dict[str, Array]:
    """Of each perturber, the square of the longest semi-axis over that of its distance."""
    return {effect.kind: effect.affine_reach(body) for effect in problem.effects if hasattr(effect, "affine_reach")}


def _pressed(
    problem: Problem, effects: tuple[Any, ...], body: AffineBody, heat: Array
) -> tuple[AffineBody, list[Array]]:
    # Pressure comes last: an incompressible fluid's is what all other forces make it.
    forces = {effect.kind: force_on(effect, body) for effect in effects if effect.kind != PRESSURE}
    if problem.incompressible:
        others = sum(forces.values(), jnp.zeros((3, 3)))
        slope = constraint_slope(
            body.deformation, body.rate, others, problem.second_moment, problem.restoring, problem.volume
        )
        body = body._replace(pressure_slope=slope)
    elif problem.matter is not None:
        body = body._replace(pressure_slope=problem.matter.slope(volume_ratio(body.deformation), heat))
    return body, [forces[effect.kind] if effect.kind in forces else force_on(effect, body) for effect in effects]


def _conservative_acceleration(problem: Problem, heat: Array, deformation: Array, rate: Array) -> Array:
    # d2F/dt2 as without what dissipates or comes from outside.
    nothing = jnp.zeros(3)
    body = AffineBody(
        jnp.zeros(()), problem.mass, problem.second_moment, problem.sphere_energy, deformation, rate,
        nothing, nothing, None, None,
    )  # fmt: skip
    inner = tuple(effect for effect in problem.effects if effect.kind in CONSERVATIVE)
    return sum(_pressed(problem, inner, body, heat)[1], jnp.zeros((3, 3))) / problem.second_moment


def _virials(problem: Problem, body: AffineBody, forces: list[Array]) -> list[Array]:
    own = [effect.affine_virial(body) for effect in problem.effects]
    return [body.deformation @ g.T if v is None else v for v, g in zip(own, forces, strict=True)]


def _heating(problem: Problem, effect: Any, body: AffineBody) -> Array:
    # A fluid without a thermal part radiates what is dissipated; an incompressible one has no internal energy.
    if problem.matter is None or (effect.kind != PRESSURE and problem.matter.thermal_exponent is None):
        return jnp.zeros(())
    rate = effect.affine_heating(body)
    return jnp.zeros(()) if rate is None else rate


def _stacked(rows: list[Array], shape: tuple[int, ...]) -> Array:
    return jnp.stack(rows) if rows else jnp.zeros((0, *shape))
