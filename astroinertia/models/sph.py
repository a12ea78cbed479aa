"""The particle fluid: what a step of smoothed-particle hydrodynamics evaluates, and how a run advances.

The equations are those that follow from a Lagrangian with variable smoothing lengths (Springel & Hernquist 2002, MNRAS
333, 649; Price & Monaghan 2007, MNRAS 374, 1347): the thermal variable is the entropy function A in
P = P_cold(rho) + A rho^gamma, constant but for dissipation.
"""

from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

import jax
import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.engines.elementwise import added, elementwise
from astroinertia.engines.pytree import pytree
from astroinertia.errors import NumericalError
from astroinertia.integrate import leapfrog, timestep
from astroinertia.integrate.contact import contact_limit
from astroinertia.integrate.leapfrog import Rates, State
from astroinertia.ledger.moments import after_heating, open_ledger
from astroinertia.models.heat import compression, total_heating, with_heat
from astroinertia.models.points import attracted, opened, with_others, without_others
from astroinertia.sph.density import density, refuse_unsolved, refuse_without_length
from astroinertia.sph.fluid import Fluid
from astroinertia.sph.kernels import KERNELS

_BEYOND = 1e-3  # of an energy, by which particles of single precision may miss it

Array = Any


@pytree
@dataclass(frozen=True)
class Problem:
    """The physics and the numerics of a particle run, in code units.

    eta sets h = eta (m/rho)^(1/3); smoothing_tolerance is the relative error allowed in h. The step is the least of
    courant times the effects' own limits, acceleration_factor sqrt(h/|a|), energy_factor u/|du/dt| and max_timestep.
    """

    effects: tuple[Effect, ...]
    equation_of_state: Any
    eta: float
    courant: float
    acceleration_factor: float
    energy_factor: float
    max_timestep: float
    engine: Any = field(metadata={"static": True})
    kernel: str = field(metadata={"static": True})
    smoothing_tolerance: float = field(metadata={"static": True})

    @property
    def effect_names(self) -> tuple[str, ...]:
        """The kinds of the effects, in the order of the ledger's rows."""
        return tuple(effect.kind for effect in self.effects)

    @property
    def fixed_length(self) -> Any | None:
        """The smoothing length that an effect asks all particles to keep; None where lengths follow the density."""
        return next((length for effect in self.effects if (length := effect.fixed_length) is not None), None)


@pytree
@dataclass(frozen=True)
class Arrangement:
    """How particles are sorted: the engine's arrangement, and {kind: what an effect needs for sums of its own}."""

    pairs: Any
    own: dict[str, Any]


def initial_state(
    problem: Problem,
    mass: Array,
    position: Array,
    velocity: Array,
    entropy: Array | None = None,
    internal_energy: Array | None = None,
    points: dict[str, Any] | None = None,
    material: Array | None = None,
) -> tuple[State, Any]:
    """The state at time 0 with its rates, and the arrangement of its particles (N,), (N, 3), (N, 3), (N,).

    Entropies are given, or follow from specific internal energies and the densities found. points: those beside it.
    material: (N,), where the equation of state has several.
    NumericalError where some particle cannot have a smoothing length, or the energy that it is given.
    """
    xp = problem.engine.xp
    mass, position, velocity = xp.asarray(mass), xp.asarray(position), xp.asarray(velocity)
    count = mass.shape[0]
    spread = float(((position - position.mean(axis=0)) ** 2).sum(axis=1).mean()) ** 0.5
    if problem.fixed_length is None:
        refuse_without_length(problem.kernel, problem.eta, np.asarray(mass), spread)
    guess = xp.full(count, problem.eta * 2.0 * spread / count ** (1 / 3))
    nothing = (None,) * len(problem.effects)
    state = State(
        time=xp.zeros(()),
        step=xp.zeros((), dtype=int),
        identity=xp.arange(count),
        mass=mass,
        position=position,
        remainder=xp.zeros_like(position),
        velocity=velocity,
        entropy=xp.asarray(internal_energy if entropy is None else entropy),
        smoothing_length=guess,
        memory={},
        ledger=open_ledger(xp, mass, position, velocity, len(problem.effects)),
        rates=Rates(nothing, nothing, nothing, xp.zeros(count), xp.zeros(()), None),  # type: ignore[arg-type]
        points=opened(xp, problem.effects, points),
        material=None if material is None else xp.asarray(material, dtype=int),
    )
    for _ in range(2):  # the first lengths are a guess; particles are sorted again by the solved ones
        state, arrangement = rearranged(problem, state)
        solved = _density(problem, arrangement, state)
        state = replace(state, smoothing_length=solved.smoothing_length)
    acts = pair_terms(problem, "neighbour_terms") or pair_terms(problem, "all_pair_terms")
    if acts and problem.fixed_length is None:  # else no density is solved for
        refuse_unsolved(problem.kernel, problem.eta, np.asarray(state.mass), solved, np.asarray(state.identity))
    if entropy is None:
        fluid = matter(problem, state.material)
        found = fluid.entropy(xp, solved.density, state.entropy)
        _refuse_beyond(xp, fluid, solved.density, state.entropy, found)
        state = replace(state, entropy=found)
    return evaluated(problem, arrangement, state, xp.zeros(())), arrangement


def _refuse_beyond(xp: Any, fluid: Any, density: Array, energy: Array, entropy: Array) -> None:
    """NumericalError where matter that is hotter than the coldest has no such energy: where tables are left too far."""
    if not fluid.thermal:
        return
    coldest, has = (np.asarray(fluid.energy(xp, density, A)) for A in (xp.zeros_like(entropy), entropy))
    wanted = np.asarray(energy)
    beyond = (wanted > coldest) & ~(np.abs(has - wanted) <= _BEYOND * np.maximum(np.abs(coldest), np.abs(wanted)))
    if beyond.any():
        where = int(np.flatnonzero(beyond)[0])
        raise NumericalError(
            f"{beyond.sum()} particles cannot have the specific energy that they are given: at the density "
            f"{float(density[where]):.3g} and the specific energy {wanted[where]:.3g} (code units) their equation of "
            "state or its table has come to its end"
        )


def matter(problem: Problem, material: Array | None) -> Any:
    """The equation of state of particles, which may be of several materials, (N,) or None."""
    eos = problem.equation_of_state
    return eos if material is None else eos.of(material)


def rearranged(problem: Problem, state: State) -> tuple[State, Any]:
    """The state with its particles sorted again into leaves, and the arrangement, made for the coming evaluation."""
    order, pairs = problem.engine.arrange(coming_position(problem, state), state.smoothing_length)
    count = state.mass.shape[0]

    def sort(array: Array) -> Array:
        return array[order] if getattr(array, "ndim", 0) and array.shape[0] == count else array

    particles, others = without_others(state)
    state = with_others(jax.tree.map(sort, particles), others)
    return state, arranged(problem, pairs, state)


def arranged(problem: Problem, pairs: Any, state: State) -> Arrangement:
    """The arrangement of particles that the engine has sorted already."""
    made = {effect.kind: effect.arranged(problem.engine, pairs, state) for effect in problem.effects}
    return Arrangement(pairs, {kind: own for kind, own in made.items() if own is not None})


def stale(problem: Problem, arrangement: Arrangement, state: State) -> bool:
    """Whether sorting particles again pays."""
    return problem.engine.stale(arrangement.pairs, coming_position(problem, state), state.smoothing_length)


def coming_position(problem: Problem, state: State) -> Array:
    """Where particles will be when a step of the allowed length evaluates the forces, (N, 3)."""
    xp, dt = problem.engine.xp, state.rates.timestep
    if state.rates.fluid is None:
        return state.position
    velocity, _ = leapfrog.predicted(xp, state, dt / 2)
    return elementwise(xp, leapfrog.moved, state.position, state.remainder, velocity, dt)[0]


def step(problem: Problem, arrangement: Any, state: State, dt: Array) -> State:
    """One kick-drift-kick step of length dt."""
    xp, exact = problem.engine.xp, problem.equation_of_state.curved and problem.engine.xp is np
    curved = matter(problem, state.material) if exact else None  # xla compiles that for minutes: first order there
    return leapfrog.step(xp, state, dt, lambda moved, length: evaluated(problem, arrangement, moved, length), curved)


def advance(problem: Problem, arrangement: Any, state: State, steps: int) -> State:
    """`steps` steps, each as long as the state allows; reverse-differentiable with the xla engine."""
    if problem.engine.name != "xla":
        for _ in range(steps):
            state = step(problem, arrangement, state, state.rates.timestep)
        return state

    def one(carried: State, _: None) -> tuple[State, None]:
        return step(problem, arrangement, carried, carried.rates.timestep), None

    return jax.lax.scan(jax.checkpoint(one), state, None, length=steps)[0]


def evaluated(problem: Problem, arrangement: Any, state: State, dt: Array) -> State:
    """The state with densities, smoothing lengths, memories and rates for its positions; dt is the step under way."""
    xp, eos, effects = problem.engine.xp, matter(problem, state.material), problem.effects
    arrangement = replace(arrangement, pairs=_listed(problem, arrangement.pairs, state))
    solved = _density(problem, arrangement, state)
    first = state.rates.fluid is None
    velocity, entropy = (state.velocity, state.entropy) if first else leapfrog.predicted(xp, state, dt / 2)
    acceleration = xp.zeros_like(velocity) if first else total_acceleration(xp, state.rates, velocity)
    pressure, sound_speed, internal_energy, thermal_energy, entropy_per_heat = eos.state(xp, solved.density, entropy)
    fluid = Fluid(
        time=state.time,
        mass=state.mass,
        position=state.position,
        velocity=velocity,
        entropy=entropy,
        smoothing_length=solved.smoothing_length,
        density=solved.density,
        grad_h=solved.grad_h,
        zeta=solved.zeta,
        pressure=pressure,
        sound_speed=sound_speed,
        internal_energy=internal_energy,
        thermal_energy=thermal_energy,
        acceleration=acceleration,
        memory=state.memory,
        kernel=problem.kernel,
        points=state.points,
    )
    if first:
        for effect in effects:
            fluid = replace(fluid, memory={**fluid.memory, **effect.initial_memory(xp, fluid)})
    fluid = _with_gradients(problem, arrangement, fluid)
    for effect in effects:
        fluid = replace(fluid, memory={**fluid.memory, **effect.remember(xp, fluid, dt)})
    before = {} if first else state.rates.fluid.sums
    fluid = replace(fluid, sums=pair_sums(problem, arrangement, fluid, before))
    rates = _rates(problem, fluid, entropy_per_heat)
    ledger = state.ledger
    if "pressure" in problem.effect_names and not first:
        before = state.rates.fluid.density
        ledger = after_heating(ledger, compression(problem, eos, state.mass, state.entropy, before, solved.density))
    points = attracted(xp, effects, fluid)
    return replace(
        state, smoothing_length=solved.smoothing_length, memory=fluid.memory, ledger=ledger, rates=rates, points=points
    )


def pair_sums(
    problem: Problem, arrangement: Arrangement, fluid: Fluid, before: dict[str, dict[str, Array]], virial: bool = False
) -> dict[str, dict[str, Array]]:
    """Sums over pairs of every effect, {effect: {output: array}}; with `virial` also each one's V_e, (3, 3).

    before: those of the evaluation before, {} on the first.
    """
    engine, fields = problem.engine, pair_fields(problem, fluid)
    sums: dict[str, dict[str, Array]] = {}
    if terms := pair_terms(problem, "neighbour_terms"):
        add_sums(sums, engine.neighbour_sums(arrangement.pairs, problem.kernel, terms, fields, virial=virial))
    add_sums(sums, distant_sums(problem, arrangement, fluid, before, virial, fields))
    return sums


def distant_sums(
    problem: Problem,
    arrangement: Arrangement,
    fluid: Fluid,
    before: dict[str, dict[str, Array]],
    virial: bool = False,
    fields: dict[str, Array] | None = None,
) -> dict[str, dict[str, Array]]:
    """The part of `pair_sums` that is not over neighbours: over all pairs, and what effects sum for themselves."""
    engine = problem.engine
    sums: dict[str, dict[str, Array]] = {}
    if terms := pair_terms(problem, "all_pair_terms"):
        fields = pair_fields(problem, fluid) if fields is None else fields
        add_sums(sums, engine.all_pair_sums(arrangement.pairs, problem.kernel, terms, fields, virial=virial))
    for effect in problem.effects:
        own, previous = arrangement.own.get(effect.kind), before.get(effect.kind, {})
        add_sums(sums, {effect.kind: effect.own_sums(engine, arrangement.pairs, own, fluid, previous, virial)})
    return sums


def add_sums(sums: dict[str, dict[str, Array]], more: dict[str, dict[str, Array]]) -> None:
    """Add the outputs of further sums to those that there are, in place."""
    for effect, outputs in more.items():
        mine = sums.setdefault(effect, {})
        for name, array in outputs.items():
            mine[name] = added(mine[name], array) if name in mine else array


def virial_tensors(problem: Problem, arrangement: Any, fluid: Fluid) -> dict[str, Array]:
    """V_e of every effect by its own route, (3, 3): in the pair loop, or from the effect's closed form.

    NaN in a periodic box, whose matter has no place of its own.
    """
    xp = problem.engine.xp
    if not problem.engine.bounded:
        return {effect.kind: xp.full((3, 3), xp.nan) for effect in problem.effects}
    sums = pair_sums(problem, arrangement, fluid, fluid.sums, virial=True)
    tensors = {}
    for effect in problem.effects:
        own = effect.virial(xp, fluid)
        paired = sums.get(effect.kind, {}).get("virial")
        parts = [part for part in (own, paired) if part is not None]
        tensors[effect.kind] = sum(parts[1:], start=parts[0]) if parts else xp.zeros((3, 3))
    return tensors


def effect_accelerations(xp: Any, rates: Rates) -> tuple[Array, ...]:
    """The acceleration of each effect, drag at the fluid's velocity included, (N, 3)."""
    velocity = rates.fluid.velocity
    return tuple(
        (xp.zeros_like(velocity) if a is None else a) + (0.0 if matrix is None else velocity @ matrix.T)
        for a, matrix in zip(rates.acceleration, rates.drag, strict=True)
    )


def total_acceleration(xp: Any, rates: Rates, velocity: Array) -> Array:
    """The sum over effects at the given velocity, (N, 3)."""
    total = rates.total
    for matrix in rates.drag:
        total = total if matrix is None else total + velocity @ matrix.T
    return total


def internal_energy(problem: Problem, state: State) -> Array:
    """sum m u at the present entropies, a scalar; zero where no pressure acts."""
    xp = problem.engine.xp
    if "pressure" not in problem.effect_names:
        return xp.zeros(())
    eos = matter(problem, state.material)
    return state.mass @ eos.internal_energy(xp, state.rates.fluid.density, state.entropy)


def potential_energies(problem: Problem, state: State) -> dict[str, Array]:
    """The potential energy of each effect that has one."""
    xp, fluid = problem.engine.xp, replace(state.rates.fluid, points=state.points)
    energies = {effect.kind: effect.potential_energy(xp, fluid) for effect in problem.effects}
    return {kind: energy for kind, energy in energies.items() if energy is not None}


def _listed(problem: Problem, pairs: Any, state: State) -> Any:
    # What the passes of one evaluation share, where an engine has them share it.
    listed = getattr(problem.engine, "listed", None)
    return pairs if listed is None else listed(pairs, problem.kernel, state.position, state.smoothing_length)


def _density(problem: Problem, arrangement: Any, state: State) -> Any:
    softening = any(effect.needs_zeta for effect in problem.effects)
    return density(
        problem.engine, arrangement.pairs, problem.kernel, state.position, state.mass, state.smoothing_length,
        problem.eta, problem.smoothing_tolerance, softening, length=problem.fixed_length,
    )  # fmt: skip


def pair_terms(problem: Problem, name: str) -> tuple:
    """The terms of all effects under one of their properties: gradient_terms, neighbour_terms or all_pair_terms."""
    return tuple(term for effect in problem.effects for term in getattr(effect, name))


def pair_fields(problem: Problem, fluid: Fluid) -> dict[str, Array]:
    """What the force terms ask for by name."""
    fields = shared_fields(fluid)
    for effect in problem.effects:
        fields.update(effect.fields(problem.engine.xp, fluid))
    return fields


def shared_fields(fluid: Fluid) -> dict[str, Array]:
    """What every pass over pairs is given."""
    return {name: getattr(fluid, name) for name in ("mass", "position", "velocity", "smoothing_length")}


def _with_gradients(problem: Problem, arrangement: Any, fluid: Fluid) -> Fluid:
    terms = pair_terms(problem, "gradient_terms")
    if not terms:
        return fluid
    fields = shared_fields(fluid)
    for effect in problem.effects:
        fields.update(effect.gradient_fields(problem.engine.xp, fluid))
    return replace(fluid, gradients=problem.engine.neighbour_sums(arrangement.pairs, problem.kernel, terms, fields))


def _rates(problem: Problem, fluid: Fluid, entropy_per_heat: Array) -> Rates:
    xp, eos, effects = problem.engine.xp, problem.equation_of_state, problem.effects
    accelerations = tuple(
        added(fluid.sums.get(effect.kind, {}).get("acceleration"), effect.acceleration(xp, fluid)) for effect in effects
    )
    # A barotropic fluid has no thermal content: what is dissipated leaves it, and only the work shows.
    heating = tuple(fluid.sums.get(e.kind, {}).get("heating") if eos.thermal else None for e in effects)
    total = reduce(added, accelerations, None)
    rates = Rates(
        acceleration=accelerations,
        drag=tuple(effect.drag(fluid) for effect in effects),
        heating=heating,
        entropy_rate=xp.zeros_like(fluid.entropy),
        timestep=xp.zeros(()),
        fluid=fluid,
        total=xp.zeros_like(fluid.velocity) if total is None else total,
    )
    rates = with_heat(problem, rates, entropy_per_heat)
    return replace(rates, timestep=timestep.shortest(xp, timestep_limits(problem, rates).values()))


def timestep_limits(problem: Problem, rates: Rates) -> dict[str, Array]:
    """The longest step of a whole body by each criterion, for each particle (N,) or for all: those by particles, and
    "contact" where effects act between neighbours.
    """
    limits = particle_limits(problem, rates)
    if pair_terms(problem, "neighbour_terms"):
        limits["contact"] = contact(problem, rates.fluid, timestep.shortest(problem.engine.xp, limits.values()))
    return limits


def contact(problem: Problem, fluid: Fluid, step: Array) -> Array:
    """The longest step before matter that is apart meets, beside the step that all else allows."""
    moving, support = (fluid.position, fluid.velocity, fluid.smoothing_length), KERNELS[problem.kernel].support
    return contact_limit(problem.engine.xp, *moving, support, step)


def particle_limits(problem: Problem, rates: Rates) -> dict[str, Array]:
    """The longest step by each criterion, for each particle (N,) or for all: the kinds of effects, and by name."""
    xp, fluid = problem.engine.xp, rates.fluid
    limits = {"longest": xp.asarray(problem.max_timestep)}
    for effect in problem.effects:
        if (limit := effect.timestep(xp, fluid)) is not None:
            limits[effect.kind] = problem.courant * limit
    total = total_acceleration(xp, rates, fluid.velocity)
    limits["acceleration"] = timestep.acceleration_limit(xp, fluid.smoothing_length, total, problem.acceleration_factor)
    if (heat := total_heating(rates)) is not None:
        limits["energy"] = timestep.energy_limit(xp, fluid, heat, total, problem.energy_factor)
    return limits
