"""What a step of smoothed-particle hydrodynamics evaluates: densities, gradients, memories, sums over pairs and rates.

The equations are those that follow from a Lagrangian with variable smoothing lengths (Springel & Hernquist 2002, MNRAS
333, 649; Price & Monaghan 2007, MNRAS 374, 1347): the thermal variable is the entropy function A in
P = P_cold(rho) + A rho^gamma, constant but for dissipation. Global steps evaluate all particles; individual ones take
the same parts for some of them, `targets` (n,), with all particles as the sources of the sums.
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any

from astroinertia.effects.effect import Effect
from astroinertia.engines.elementwise import added, elementwise
from astroinertia.engines.pytree import with_fields
from astroinertia.engines.terms import COMMON, PairTerm
from astroinertia.errors import SceneError
from astroinertia.ledger.moments import after_heating
from astroinertia.models.sph import points
from astroinertia.models.sph.compiled import compiled
from astroinertia.models.sph.heat import Exchange, compression, entropy_gain, exchange_of
from astroinertia.models.sph.kick_drift import change_by_rates, predicted
from astroinertia.models.sph.limits import shortest, timestep_limits, total_acceleration
from astroinertia.models.sph.state import Arrangement, Problem, Rates, State, rows
from astroinertia.sph.density import Density, density, own_share
from astroinertia.sph.fluid import Fluid
from astroinertia.sph.fourth_order import sharpened
from astroinertia.sph.standard_volumes import DENSITY_FACTOR

Array = Any
Sums = dict[str, dict[str, Array]]


@compiled
def evaluated(problem: Problem, arrangement: Arrangement, state: State, dt: Array) -> State:
    """The state with densities, smoothing lengths, memories and rates for its positions; dt is the step under way."""
    xp, before = problem.engine.xp, state.rates.fluid
    eos, first = problem.matter(state.material), before is None
    pairs = listed(problem, arrangement.pairs, state.position, state.smoothing_length)
    solved = densities(problem, pairs, state)
    # A few lengths may have grown by more than the lists have room for: the passes to come then share longer ones.
    pairs = listed(problem, pairs, state.position, solved.smoothing_length)
    velocity, entropy = (state.velocity, state.entropy) if first else predicted(xp, state, dt / 2)
    *thermal, entropy_per_heat = eos.state(xp, solved.density, entropy)
    pressure, sound_speed, internal_energy, thermal_energy = thermal
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
        contrast=solved.contrast,
        standard_density=problem.standard_density(state.material),
        pressure=pressure,
        sound_speed=sound_speed,
        internal_energy=internal_energy,
        thermal_energy=thermal_energy,
        acceleration=xp.zeros_like(velocity) if first else total_acceleration(xp, state.rates, velocity),
        memory=state.memory,
        kernel=problem.kernel,
        points=state.points,
    )
    if first:
        fluid = with_first_memories(problem, fluid)
    fluid = with_fields(fluid, gradients=gradients(problem, pairs, fluid))
    fluid = with_memories(problem, fluid, dt)
    fields = pair_fields(problem, fluid)
    sums = near_sums(problem, pairs, fields)
    del pairs  # expansions take as much memory as lists of neighbours, and what neighbours alone ask for
    fields = fields if problem.terms("all_pair_terms") else {}
    add_sums(sums, distant_sums(problem, arrangement, fluid, {} if first else before.sums, False, fields))
    fluid = with_fields(fluid, sums=sums)
    fluid = with_memories_of_sums(problem, fluid)
    own = [effect.acceleration(xp, fluid) for effect in problem.effects]
    rates = rates_of(problem, fluid, own, entropy_per_heat)
    ledger = state.ledger
    if not first and "pressure" in problem.effect_names:
        gained = compression(problem, eos, state.mass, state.entropy, before.density, solved.density)
        ledger = after_heating(ledger, gained)
    beside = state.points
    if beside:  # what is known of the whole body is that of the velocities that the closing kick makes
        ending = change_by_rates(xp, with_fields(state, rates=rates), dt / 2).after
        beside = points.with_histories(xp, problem.effects, with_fields(fluid, velocity=ending))
    return with_fields(
        state,
        smoothing_length=solved.smoothing_length,
        memory=fluid.memory,
        ledger=ledger,
        rates=with_fields(rates, timestep=shortest(xp, timestep_limits(problem, rates).values())),
        points=beside,
    )


def turned(problem: Problem, arrangement: Arrangement, state: State, time: Array) -> State:
    """The state at a time that it has come to, with the rates of what acts from then on."""
    xp = problem.engine.xp
    return evaluated(problem, arrangement, with_fields(state, time=xp.asarray(time, dtype=float)), xp.zeros(()))


def listed(problem: Problem, pairs: Any, position: Array, length: Array, targets: Array | None = None) -> Any:
    """The engine's arrangement with what the passes of one evaluation share, where an engine has them share it.

    length: smoothing lengths (N,) as far as they are known.
    """
    engine = problem.engine
    return engine.listed(pairs, problem.kernel, position, length, targets) if hasattr(engine, "listed") else pairs


@compiled
def densities(problem: Problem, pairs: Any, state: State, targets: Array | None = None) -> Density:
    """Smoothing lengths, densities and their gradient factors; densities of fourth order where an effect needs them."""
    softening = any(effect.needs_zeta for effect in problem.effects)
    standard = problem.standard_density(state.material)
    factor = state.memory.get(DENSITY_FACTOR)
    counted = state.mass if standard is None else state.mass / standard
    solved = density(
        problem.engine, pairs, problem.kernel, state.position, counted, state.smoothing_length,
        problem.eta, problem.smoothing_tolerance, softening, targets, problem.fixed_length,
    )  # fmt: skip
    if standard is not None:
        own = standard if factor is None else factor * standard
        solved = with_fields(solved, density=rows(own, targets) * solved.density)
    if not any(effect.needs_contrast for effect in problem.effects):
        return solved
    xp = problem.engine.xp
    share = own_share(xp, problem.kernel, problem.eta)
    sharper, contrast = elementwise(xp, sharpened, solved.density, solved.grad_h, share)
    return with_fields(solved, density=sharper, contrast=contrast)


def with_first_memories(problem: Problem, fluid: Fluid) -> Fluid:
    """The fluid with what effects evolve for themselves, before the first evaluation: as it has it, or as it begins."""
    before, fluid = fluid.memory, with_fields(fluid, memory={})
    for effect in problem.effects:
        begun = effect.initial_memory(problem.engine.xp, fluid)
        if shared := sorted(fluid.memory.keys() & begun.keys()):
            raise SceneError(f"the effect '{effect.kind}' and another have a memory '{shared[0]}': rename one.")
        fluid = with_fields(fluid, memory=fluid.memory | {name: before.get(name, begun[name]) for name in begun})
    return fluid


def gradients(
    problem: Problem, pairs: Any, fluid: Fluid, targets: Array | None = None, further: tuple[PairTerm, ...] = (),
    **fields: Array,
) -> Sums:  # fmt: skip
    """Sums of the pass before the forces, with further terms and what these ask for by name."""
    terms = problem.terms("gradient_terms") + further
    if not terms:
        return {}
    fields |= shared_fields(fluid)
    _add_fields(fields, [(effect, effect.gradient_fields(problem.engine.xp, fluid)) for effect in problem.effects])
    chosen = {} if targets is None else {"targets": targets}
    sums = problem.engine.neighbour_sums(pairs, problem.kernel, terms, fields, **chosen)
    return with_inertial_flow(problem, fluid, sums)


def with_inertial_flow(problem: Problem, fluid: Fluid, sums: Sums) -> Sums:
    """The sums, in a frame that turns also with that of velocities in inertial axes: v + Omega x x is linear in x."""
    rotation = reduce(added, [effect.frame_rotation(fluid) for effect in problem.effects], None)
    if rotation is None or COMMON not in sums:
        return sums
    flow = sums[COMMON]
    turned = problem.engine.xp.einsum("ck,nkd->ncd", rotation, flow["position"])
    return sums | {COMMON: flow | {"inertial_velocity": flow["velocity"] + turned}}


def with_memories(problem: Problem, fluid: Fluid, since: Array) -> Fluid:
    """The fluid with what effects evolve for themselves, `since` () or (n,) after they last did."""
    for effect in problem.effects:
        if found := effect.remember(problem.engine.xp, fluid, since):
            fluid = with_fields(fluid, memory={**fluid.memory, **found})
    return fluid


def with_memories_of_sums(problem: Problem, fluid: Fluid) -> Fluid:
    """The fluid with what effects keep of the sums over pairs for the next evaluation."""
    for effect in problem.effects:
        if found := effect.remember_sums(problem.engine.xp, fluid):
            fluid = with_fields(fluid, memory={**fluid.memory, **found})
    return fluid


def near_sums(problem: Problem, pairs: Any, fields: dict[str, Array], virial: bool = False) -> Sums:
    """Sums over neighbours of every effect, {effect: {output: array}}; with `virial` also their part of V_e, (3, 3)."""
    return problem.engine.neighbour_sums(pairs, problem.kernel, problem.terms("neighbour_terms"), fields, virial=virial)


def distant_sums(
    problem: Problem, arrangement: Arrangement, fluid: Fluid, before: Sums, virial: bool, fields: dict[str, Array]
) -> Sums:
    """Sums that are not over neighbours: over all pairs, and what effects sum for themselves, as `near_sums` has them.

    before: those of the evaluation before, {} on the first; fields: what the terms of all pairs ask for by name.
    """
    engine = problem.engine
    sums: Sums = {}
    if terms := problem.terms("all_pair_terms"):
        add_sums(sums, engine.all_pair_sums(arrangement.pairs, problem.kernel, terms, fields, virial=virial))
    for effect in problem.effects:
        own, previous = arrangement.own.get(effect.kind), before.get(effect.kind, {})
        add_sums(sums, {effect.kind: effect.own_sums(engine, arrangement.pairs, own, fluid, previous, virial)})
    return sums


def add_sums(sums: Sums, more: Sums) -> None:
    """Add the outputs of further sums to those that there are, in place."""
    for effect, outputs in more.items():
        mine = sums.setdefault(effect, {})
        for name, array in outputs.items():
            mine[name] = added(mine[name], array) if name in mine else array


def pair_fields(problem: Problem, fluid: Fluid) -> dict[str, Array]:
    """What the force terms ask for by name."""
    fields = shared_fields(fluid)
    _add_fields(fields, [(effect, effect.fields(problem.engine.xp, fluid)) for effect in problem.effects])
    return fields


def _add_fields(fields: dict[str, Array], given: Sequence[tuple[Effect, Mapping[str, Array]]]) -> None:
    """Add what each effect gives to pairs, {name: array}, in place.

    SceneError where a name means two arrays, one of them of an effect of a user's own.
    """
    owners: dict[str, Effect | None] = dict.fromkeys(fields)
    for effect, arrays in given:
        for name, array in arrays.items():
            other = owners.setdefault(name, effect)
            if fields.setdefault(name, array) is not array and (other is None or _own(effect) or _own(other)):
                who = "every fluid" if other is None else f"'{other.kind}'"
                raise SceneError(
                    f"the effect '{effect.kind}' has a field '{name}' of pairs, and {who} another: rename one."
                )


def _own(effect: Effect) -> bool:
    return not type(effect).__module__.startswith("astroinertia.")


def shared_fields(fluid: Fluid) -> dict[str, Array]:
    """What every pass over pairs is given."""
    return {name: getattr(fluid, name) for name in ("mass", "position", "velocity", "smoothing_length")}


def rates_of(problem: Problem, fluid: Fluid, own: list[Array | None], entropy_per_heat: Array) -> Rates:
    """The rates that follow from the sums over pairs, from each effect's own accelerations, (n, 3) or None, and from
    heat; without the time step.
    """
    xp, effects = problem.engine.xp, problem.effects
    accelerations = tuple(
        added(fluid.sums.get(effect.kind, {}).get("acceleration"), acceleration)
        for effect, acceleration in zip(effects, own, strict=True)
    )
    total = reduce(added, accelerations, None)
    # A barotropic fluid has no thermal content: what is dissipated leaves it, and only the work shows.
    thermal = problem.equation_of_state.thermal
    heating = tuple(fluid.sums.get(effect.kind, {}).get("heating") if thermal else None for effect in effects)
    exchange = exchange_with_surroundings(problem, fluid, entropy_per_heat)
    gain = entropy_gain(entropy_per_heat, heating, None if exchange is None else exchange.gain)
    return Rates(
        acceleration=accelerations,
        drag=tuple(effect.drag(fluid) for effect in effects),
        heating=heating,
        entropy_rate=xp.zeros_like(fluid.entropy) if gain is None else gain,
        timestep=xp.zeros(()),
        fluid=fluid,
        total=xp.zeros_like(fluid.velocity) if total is None else total,
        exchange=exchange,
    )


def exchange_with_surroundings(problem: Problem, fluid: Fluid, entropy_per_heat: Array) -> Exchange | None:
    """The heat that effects give and take by themselves; None where none does, or nothing can be warm."""
    if not problem.equation_of_state.thermal:
        return None
    return exchange_of([effect.exchange(problem.engine.xp, fluid) for effect in problem.effects], entropy_per_heat)


def effect_accelerations(xp: Any, rates: Rates) -> tuple[Array, ...]:
    """The acceleration of each effect, drag at the fluid's velocity included, (N, 3)."""
    velocity = rates.fluid.velocity
    return tuple(
        (xp.zeros_like(velocity) if a is None else a) + (0.0 if matrix is None else velocity @ matrix.T)
        for a, matrix in zip(rates.acceleration, rates.drag, strict=True)
    )


@compiled
def virial_tensors(problem: Problem, arrangement: Arrangement, fluid: Fluid) -> dict[str, Array]:
    """V_e of every effect by its own route, (3, 3): in the pair loop, or from the effect's closed form.

    NaN in a periodic box, whose matter has no place of its own.
    """
    xp = problem.engine.xp
    if not problem.engine.bounded:
        return {effect.kind: xp.full((3, 3), xp.nan) for effect in problem.effects}
    fields = pair_fields(problem, fluid)
    sums = near_sums(problem, arrangement.pairs, fields, virial=True)
    add_sums(sums, distant_sums(problem, arrangement, fluid, fluid.sums, True, fields))
    tensors = {}
    for effect in problem.effects:
        own = effect.virial(xp, fluid)
        own = _summed_virial(effect, xp, fluid) if own is None else own
        paired = sums.get(effect.kind, {}).get("virial")
        parts = [part for part in (own, paired) if part is not None]
        tensors[effect.kind] = sum(parts[1:], start=parts[0]) if parts else xp.zeros((3, 3))
    return tensors


def _summed_virial(effect: Effect, xp: Any, fluid: Fluid) -> Array | None:
    """sum m (x - centre) (x) a, (3, 3), of what an effect without a route of its own does to single particles."""
    matrix = effect.drag(fluid)
    own = added(effect.acceleration(xp, fluid), None if matrix is None else fluid.velocity @ matrix.T)
    return None if own is None else (fluid.mass[:, None] * (fluid.position - fluid.centre)).T @ own


@compiled
def internal_energy(problem: Problem, state: State) -> Array:
    """sum m u at the present entropies, a scalar; zero where no pressure acts."""
    xp = problem.engine.xp
    if "pressure" not in problem.effect_names:
        return xp.zeros(())
    eos = problem.matter(state.material)
    return state.mass @ eos.internal_energy(xp, state.rates.fluid.density, state.entropy)


@compiled
def potential_energies(problem: Problem, state: State) -> dict[str, Array]:
    """The potential energy of each effect that has one."""
    xp, fluid = problem.engine.xp, with_fields(state.rates.fluid, points=state.points)
    energies = {effect.kind: effect.potential_energy(xp, fluid) for effect in problem.effects}
    return {kind: energy for kind, energy in energies.items() if energy is not None}
