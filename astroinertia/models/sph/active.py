"""The particles of a body within a base step of individual time steps, and what those that are active now need of it.

A pass over pairs has the active particles as its targets and all particles as its sources; a kick is by pairs of which
both are active.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import added, elementwise
from astroinertia.engines.pytree import with_fields
from astroinertia.engines.terms import PairTerm, argument_names
from astroinertia.ledger.moments import Whole, after_heating
from astroinertia.models.protocol import never
from astroinertia.models.sph import evaluate, kick_drift, points, sorting
from astroinertia.models.sph.evaluate import Sums
from astroinertia.models.sph.heat import Exchange, Heat, compression, entropy_gain, exchanged
from astroinertia.models.sph.intervals import Clock, weighted_sets
from astroinertia.models.sph.limits import total_acceleration
from astroinertia.models.sph.state import Arrangement, Problem, Rates, State, rows
from astroinertia.sph.fluid import Fluid

Array = Any
THERMAL = ("pressure", "sound_speed", "internal_energy", "thermal_energy", "entropy_per_heat")
OF_A_FLUID = (
    "density", "grad_h", "zeta", "pressure", "sound_speed", "internal_energy", "thermal_energy", "acceleration",
    "contrast", "standard_density",
)  # fmt: skip
SOLVED = ("zeta", "contrast")  # of these, where there are any
PER_PARTICLE = (
    "identity", "mass", "position", "remainder", "velocity", "entropy", "smoothing_length", "material",
)  # fmt: skip
FEW = 2048  # particles that plain sums over all pairs are quicker for
NOTHING_ENDS = 1e36  # what a particle closes of which nothing is to be closed (Engine.neighbour_sums)


@dataclass(frozen=True)
class HalfIntervals:
    """Half of the interval that ends, and of the one that begins, of each active particle (n,), and their rungs.

    A particle that was activated within its interval has nothing to close: its old rung is -1. Nothing is opened at the
    end of a base step: all new rungs are -1.
    """

    base: float
    level: int
    old: Array
    new: Array

    @property
    def opens(self) -> bool:
        """Whether intervals begin."""
        return self.new.min(initial=0) >= 0

    @staticmethod
    def _half(base: float, rung: Array) -> Array:
        return np.where(rung < 0, 0.0, np.ldexp(0.5 * base, -rung))

    @cached_property
    def closing(self) -> Array:
        """Half of the interval that ends, (n,); 0 where there is none."""
        return self._half(self.base, self.old)

    @cached_property
    def opening(self) -> Array:
        """Half of the interval that begins, (n,); 0 where there is none."""
        return self._half(self.base, self.new)

    @cached_property
    def both(self) -> Array:
        """The time that a kick is over, (n,)."""
        return self.closing + self.opening


@dataclass
class Tally:
    """Evaluations of particles and ends of intervals so far."""

    evaluations: int = 0
    ends: int = 0


@dataclass
class BlockStep:
    """Particles within a base step.

    state: they and their ledgers now, with the velocities as kicked so far; its rates are those of the beginning.
    more: further arrays (N, ...): those of a Fluid that a State lacks, under their names; `predicted`, the velocity
    now; `counted`, the mass of particles whose drift this part enters into the ledger, else 0; `entropy_per_heat`;
    `entropy_rate`; `decay` where heat is exchanged with the surroundings; `middle`, the time at the middle of a
    particle's interval; `limit`, what its interval must not exceed, its own and for its neighbours' sake; `own_limit`;
    `contact`, how long after the time `looked` it meets nothing; `rung` and `interval`; and with prefixes field (of the
    force terms), distant (accelerations that are not by neighbours), outer (those of them by what is outside a nested
    set) and body (accelerations that come with the base step alone).
    body: the mass, place and velocity of the whole body; pairs: the engine's arrangement with lists of neighbours;
    tally: what was done so far; whole: whether these are all particles of the body; looked: when what is on its way was
    looked for; to_give_up: whether the base step is to be given up.
    """

    problem: Problem
    arrangement: Arrangement
    clock: Clock
    begun: float
    state: State
    more: dict[str, Array]
    body: Whole
    tally: Tally
    whole: bool = True
    pairs: Any = None
    looked: float = 0.0
    to_give_up: Callable[[], bool] = never

    @property
    def time(self) -> float:
        """Now."""
        return self.begun + self.clock.elapsed

    @cached_property
    def direct(self) -> Problem:
        """The physics with plain sums over all pairs, for few particles."""
        return replace(self.problem, effects=tuple(effect.direct for effect in self.problem.effects))

    @cached_property
    def xp(self) -> Any:
        """What work on each particle by itself is done with."""
        return self.problem.engine.xp

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.state.mass)

    def chosen(self, active: Array | None) -> Array | None:
        """The active particles; None where these are all."""
        return None if active is None or len(active) == len(self.state.mass) else active

    def array(self, name: str) -> Array:
        """The array of that name."""
        return self.more[name] if name in self.more else getattr(self.state, name)

    def take(self, name: str, active: Array) -> Array:
        """The rows of active particles (a copy, unless all are active)."""
        array = self.array(name)
        return array if len(active) == len(array) else array.take(active, axis=0)

    def put(self, name: str, active: Array, values: Array) -> None:
        """Change those rows."""
        array = self.array(name)
        if len(active) < len(array):
            array[active] = values
        elif name in self.more:
            self.more[name] = np.array(values)
        else:
            self.state = with_fields(self.state, **{name: np.array(values)})

    def room(self, name: str, *row: int) -> Array:
        """The further array of that name, of rows (N, *row), in which there are zeros at first."""
        if name not in self.more:
            self.more[name] = np.zeros((self.count, *row))
        return self.more[name]

    @property
    def distant(self) -> dict[str, Array]:
        """The accelerations that are not by neighbours, {effect: (N, 3)}."""
        names = [(effect.kind, f"distant.{effect.kind}") for effect in self.problem.effects]
        return {kind: self.more[name] for kind, name in names if name in self.more}


def opened(problem: Problem, arrangement: Arrangement, state: State, base: float, limits: Array) -> BlockStep:
    """The particles of a state at the beginning of a base step, not kicked yet."""
    fluid, mass, rates = state.rates.fluid, state.mass, state.rates
    owned = ("velocity", "entropy", "smoothing_length")
    state = with_fields(
        state,
        memory={name: array.copy() for name, array in state.memory.items()},
        **{name: getattr(state, name).copy() for name in owned},
    )
    more = {name: np.array(array) for name in OF_A_FLUID if (array := getattr(fluid, name)) is not None}
    more |= {
        "predicted": np.array(fluid.velocity),
        "counted": mass,
        "acceleration": total_acceleration(np, rates, state.velocity),
        "entropy_rate": rates.entropy_rate.copy(),
        "entropy_per_heat": problem.matter(state.material).state(np, fluid.density, fluid.entropy)[-1],
        "limit": limits.copy(),
        "step_rate": 1.0 / limits,
        "own_limit": limits.copy(),
        "middle": np.full(len(mass), float(state.time)),  # the state is one at this time
        "rung": np.full(len(mass), -1),
        "interval": np.zeros(len(mass)),
    }
    if rates.exchange is not None:
        more["decay"] = np.array(rates.exchange.decay)
    total = mass.sum()
    body = Whole(total, (mass @ state.position) / total, (mass @ state.velocity) / total)
    problem = replace(problem, engine=problem.engine.within(len(mass)))
    return BlockStep(problem, arrangement, Clock(base), float(state.time), state, more, body, Tally())


def closed(block: BlockStep, rates: Rates) -> State:
    """The state at the end of a base step."""
    state, fluid = block.state, with_fields(rates.fluid, points=block.state.points, body=None)
    return with_fields(
        state,
        time=np.float64(block.begun + block.clock.base),
        step=state.step + 1,
        rates=with_fields(rates, fluid=fluid),
        points=points.with_histories(block.xp, block.problem.effects, with_fields(fluid, velocity=state.velocity)),
    )


def drift(block: BlockStep, clock: Clock) -> None:
    """Free motion of all particles to a later time, and of the body as the ledger has it."""
    dt = np.float64(clock.elapsed - block.clock.elapsed)
    mass, centre, velocity = block.body
    block.body = Whole(mass, centre + dt * velocity, velocity)
    state = with_fields(block.state, time=np.float64(block.time))
    block.state = kick_drift.drift(block.xp, state, dt, block.more["counted"], block.body)
    _predict(block, clock)


def carry_on(block: BlockStep, clock: Clock, counted: Array) -> None:
    """Particles at a later time, to which the body has drifted already; counted: as in kick_drift.carried_on."""
    dt = np.float64(clock.elapsed - block.clock.elapsed)
    block.state = kick_drift.carried_on(block.xp, block.state, dt, counted, block.body)
    _predict(block, clock)


def _predict(block: BlockStep, clock: Clock) -> None:
    # Velocities by the last accelerations.
    dt = clock.elapsed - block.clock.elapsed
    velocity, acceleration = block.more["predicted"], block.more["acceleration"]
    block.more["predicted"] = elementwise(block.xp, kick_drift.changed, velocity, acceleration, dt)[0]
    block.clock = clock


def list_neighbours(block: BlockStep, active: Array) -> None:
    """Have the passes to come, with those targets, share what they must know of neighbours."""
    _list(block, block.arrangement.pairs, active)


def _list(block: BlockStep, pairs: Any, active: Array) -> None:
    position, length = block.state.position, block.state.smoothing_length
    block.pairs = evaluate.listed(block.problem, pairs, position, length, block.chosen(active))


def matter(block: BlockStep, active: Array) -> Any:
    """The equation of state of active particles."""
    material = block.state.material
    return block.problem.matter(None if material is None else material[active])


def find_densities(block: BlockStep, active: Array) -> None:
    """Smoothing lengths, densities and what follows from them; the ledger takes in what pressure did since."""
    problem, eos = block.problem, matter(block, active)
    solved = evaluate.densities(problem, block.pairs, block.state, block.chosen(active))
    entropy = block.take("entropy", active)
    if "pressure" in problem.effect_names:
        parts = block.take("mass", active), entropy, block.take("density", active), solved.density
        ledger = after_heating(block.state.ledger, compression(problem, eos, *parts))
        block.state = with_fields(block.state, ledger=ledger)
    rate, since = block.take("entropy_rate", active), block.time - block.take("middle", active)
    if "decay" in block.more:
        now = elementwise(block.xp, exchanged, entropy, rate * since, block.take("decay", active), since)[0]
    else:
        now = elementwise(block.xp, advanced, entropy, rate, since)[0]
    values = dict(zip(THERMAL, eos.state(block.xp, solved.density, now), strict=True))
    values |= {"smoothing_length": solved.smoothing_length, "density": solved.density, "grad_h": solved.grad_h}
    values |= {name: array for name in SOLVED if (array := getattr(solved, name)) is not None}
    for name, array in values.items():
        block.put(name, active, array)
    _list(block, block.pairs, active)  # as in evaluate.evaluated


def fluid_of(block: BlockStep, active: Array | None = None) -> Fluid:
    """What the effects see of active particles, or of all as they are known."""
    chosen, state, more = block.chosen(active), block.state, block.more
    arrays = {name: getattr(state, name) for name in ("mass", "position", "entropy", "smoothing_length")}
    arrays |= {"velocity": more["predicted"], **{name: more[name] for name in OF_A_FLUID if name in more}}
    memory = dict(state.memory)
    if chosen is not None:
        arrays, memory = ({name: array.take(chosen, axis=0) for name, array in of.items()} for of in (arrays, memory))
    # What has no array has none from the beginning of the base step on.
    return with_fields(
        state.rates.fluid, time=np.float64(block.time), memory=memory, gradients={}, sums={}, points=state.points,
        body=block.body, **arrays,
    )  # fmt: skip


def gradients(block: BlockStep, active: Array, further: PairTerm) -> Sums:
    """Sums of the pass before the forces, with a further term."""
    fields = {name: block.more[name] for name in ("step_rate", "interval")}
    return evaluate.gradients(block.problem, block.pairs, fluid_of(block), block.chosen(active), (further,), **fields)


def remembered(block: BlockStep, active: Array, sums: Sums, since: Array) -> Fluid:
    """The active particles with their gradients, and memories brought up to now, `since` (n,) after they last were."""
    before = with_fields(fluid_of(block, active), gradients=sums)
    fluid = evaluate.with_memories(block.problem, before, since)
    keep_memories(block, active, before, fluid)
    return fluid


def keep_memories(block: BlockStep, active: Array, before: Fluid, fluid: Fluid) -> None:
    """The body's memories as those of the active particles have become, from a fluid before to one after."""
    held, everyone = block.state.memory, block.chosen(active) is None
    for name, values in fluid.memory.items():
        if values is before.memory[name]:
            continue
        if everyone:
            held[name] = np.array(values)  # a base step has a dictionary of its own, as it has arrays
        else:
            held[name][active] = values


def neighbour_forces(block: BlockStep, fluid: Fluid, active: Array, spans: HalfIntervals) -> tuple[Sums, Sums]:
    """Sums of the force pass by all neighbours, and impulses by active ones, each pair over its own interval."""
    problem, more = block.problem, block.more
    terms = problem.terms("neighbour_terms")
    if not terms:
        return {}, {}
    fields = {name: block.array(name) for name in ("mass", "position", "smoothing_length")}
    fields["velocity"] = more["predicted"]
    for name, values in evaluate.pair_fields(problem, fluid).items():
        if name not in fields:
            fields[name] = block.room(f"field.{name}")
            fields[name][active] = values
    closing, opening = np.zeros(block.count), np.full(block.count, -1.0)
    closing[active] = np.where(spans.old < 0, NOTHING_ENDS, spans.closing)
    opening[active] = spans.opening
    sums = problem.engine.neighbour_sums(
        block.pairs, problem.kernel, terms, fields, targets=block.chosen(active), interval=(closing, opening)
    )
    plain: Sums = {}
    impulses: Sums = {}
    for effect, outputs in sums.items():
        for name, values in outputs.items():
            stem = name.removesuffix("_impulse")
            (plain if stem == name else impulses).setdefault(effect, {})[stem] = values
    return plain, impulses


def distant_forces(
    block: BlockStep, active: Array, spans: HalfIntervals
) -> tuple[Sums, dict[str, Array], list[tuple[Array, list[int], Sums]]]:
    """Sums that are not over neighbours, and impulses of those, {effect: (n, 3)}: by nested sets of particles.

    Besides, the nested sets that begin, their rungs, and the sums over them.

    Where all are active the sums have all their outputs; else only accelerations, by inactive ones as before.
    """
    everyone = fluid_of(block)
    whole_sums: Sums = {}
    impulses: dict[str, Array] = {}
    done: list[tuple[Array, Sums]] = []

    def summed(members: Array, weight: float, before: Sums | None = None) -> Sums:
        # What began when the last interval did often goes on.
        same = (sums for chosen, sums in done if chosen is members or np.array_equal(chosen, members))
        sums = next(same, before)
        if sums is None:
            sums = _sums_of(block, everyone, active[members])
            done.append((members, sums))
        for effect, outputs in sums.items():
            impulse = weight * outputs["acceleration"]
            if len(members) == len(active):
                impulses[effect] = added(impulses.get(effect), impulse)
            else:
                impulses.setdefault(effect, np.zeros((len(active), 3)))[members] += impulse
        return sums

    ending = weighted_sets(spans.base, spans.old, spans.level)
    for members, rungs, weight in ending:
        sums = summed(members, weight)
        if rungs[0] == spans.level:
            whole_sums = _by_all(block, active, members, sums, spans.level)
    # Where a base step begins, the sums over all were made at the end of the last one.
    before: Sums | None = None if done else {kind: {"acceleration": a} for kind, a in block.distant.items()}
    beginning = []
    again = ending if np.array_equal(spans.old, spans.new) else weighted_sets(spans.base, spans.new, spans.level)
    for members, rungs, weight in again:
        beginning.append((members, rungs, summed(members, weight, before if rungs[0] == 0 else None)))
    return whole_sums, impulses, beginning


def _by_all(block: BlockStep, active: Array, members: Array, sums: Sums, level: int) -> Sums:
    # By all particles: those active now, and the others as they were when last active together with these.
    for effect, outputs in sums.items():
        name, chosen = f"distant.{effect}", active[members]
        outer = block.more.get(f"outer.{level}.{effect}")
        by_inactive = 0.0 if level == 0 or outer is None else outer[chosen]
        block.room(name, 3)[chosen] = outputs["acceleration"] + by_inactive
    if level == 0:
        return sums
    return {effect: {"acceleration": block.more[f"distant.{effect}"][active]} for effect in sums}


def _sums_of(block: BlockStep, everyone: Fluid, chosen: Array) -> Sums:
    # The particles in a set act on each other alone.
    problem = block.problem
    whole = block.whole and len(chosen) == block.count
    if len(chosen) <= FEW and not whole:
        problem = block.direct
    fluid: Any = Chosen(everyone, block.chosen(chosen))  # as much of a state as effects look at
    arrangement = block.arrangement
    if not whole:
        pairs = problem.engine.subset(arrangement.pairs, chosen, fluid.smoothing_length)
        arrangement = sorting.arranged(problem, pairs, fluid)
    before: Sums = {name: {"acceleration": array[chosen]} for name, array in block.distant.items()}
    terms = problem.terms("all_pair_terms")
    fields = evaluate.shared_fields(fluid) if terms else {}
    for name in _asked_for(terms):
        if f"field.{name}" in block.more:
            fields[name] = block.take(f"field.{name}", chosen)
    sums = evaluate.distant_sums(problem, arrangement, fluid, before, False, fields)
    return {effect: outputs for effect, outputs in sums.items() if outputs}


@dataclass(frozen=True)
class Chosen:
    """Some particles of a fluid, of which an array is made when it is asked for: sums ask for few."""

    fluid: Fluid
    chosen: Array | None

    @property
    def memory(self) -> dict[str, Array]:
        """What effects evolve for themselves of these particles."""
        return {name: rows(array, self.chosen) for name, array in self.fluid.memory.items()}

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.fluid, name)
        return rows(value, self.chosen) if isinstance(value, np.ndarray) and value.ndim else value


@lru_cache(maxsize=32)
def _asked_for(terms: tuple[PairTerm, ...]) -> list[str]:
    # What the arguments of pair functions may be fields of.
    functions = [function for term in terms for function in (term.pair, term.far) if function is not None]
    return sorted({name.rpartition("_")[0] for function in functions for name in argument_names(function)})


def kick(
    block: BlockStep, active: Array, pushes: list[Array | None], drags: list[Array | None],
    by_pairs: list[Array | None], exchange: Exchange | None, spans: HalfIntervals,
) -> None:  # fmt: skip
    """Change velocities by each effect's push (n, 3) and drag matrix, and entropies by its heat per mass (n,).

    Entropies change as well by the exchange of heat with the surroundings.

    A push that heats has its heat for the velocities that particles were expected to have; what it works on those that
    they turn out to have beyond that is made up for, so that it turns energy into heat and loses none.
    """
    change = kick_drift.velocity_change(block.xp, pushes, drags, block.take("velocity", active), spans.both)
    expected = block.take("predicted", active)
    by_pairs = [
        q if q is None or push is None
        else elementwise(block.xp, corrected_heat, q, push, change.before, change.after, expected)[0]
        for q, push in zip(by_pairs, change.increments, strict=True)
    ]  # fmt: skip
    more = None if exchange is None else spans.both * exchange.gain
    gain = entropy_gain(block.take("entropy_per_heat", active), by_pairs, more)
    heat = Heat(by_pairs, exchange, gain, spans.both, 1.0)
    curved = block.problem.equation_of_state.curved
    chosen = block.chosen(active)
    everyone = block.whole and chosen is None
    momentum = block.state.ledger.impulse.total.sum(axis=0)
    block.state = kick_drift.kick(
        block.xp, block.state, change, heat, block.take("density", active), matter(block, active) if curved else None,
        chosen, None if everyone else block.body,
    )  # fmt: skip
    gained = block.state.ledger.impulse.total.sum(axis=0) - momentum
    block.body = block.body._replace(velocity=block.body.velocity + gained / block.body.mass)


def correct(block: BlockStep, active: Array, since: Array, acceleration: Array) -> None:
    """The velocities now by the trapezoidal rule over `since` (n,), with the accelerations (n, 3) found at last."""
    velocity, before = block.take("predicted", active), block.take("acceleration", active)
    block.put("predicted", active, elementwise(block.xp, trapezoid, velocity, before, acceleration, since)[0])
    block.put("acceleration", active, acceleration)


def remember_outer(block: BlockStep, active: Array, beginning: list[tuple[Array, list[int], Sums]]) -> None:
    """What is outside each nested set that begins exerts on those in it; beginning: as of distant_forces."""
    for kind, total in block.distant.items():
        for members, rungs, sums in beginning:
            chosen = active[members]
            by_others = total[chosen] - sums[kind]["acceleration"] if rungs[-1] > 0 else None
            for k in rungs:
                if k > 0:
                    block.room(f"outer.{k}.{kind}", 3)[chosen] = by_others


def stale(block: BlockStep) -> bool:
    """Whether sorting particles again pays."""
    state, engine = block.state, block.problem.engine
    return block.whole and engine.stale(block.arrangement.pairs, state.position, state.smoothing_length)


def sorted_again(block: BlockStep) -> None:
    """Sort particles into leaves by where they are."""
    order, pairs = block.problem.engine.arrange(block.state.position, block.state.smoothing_length)
    choose(block, order)
    block.arrangement = sorting.arranged(block.problem, pairs, block.state)


def choose(block: BlockStep, chosen: Array) -> None:
    """Keep the chosen particles alone, or all in another order."""
    state = block.state
    arrays = {name: array[chosen] for name in PER_PARTICLE if (array := getattr(state, name)) is not None}
    memory = {name: array[chosen] for name, array in state.memory.items()}
    block.state = with_fields(state, memory=memory, **arrays)
    block.more = {name: array[chosen] for name, array in block.more.items()}


def trapezoid(xp, v, before, a, dt):
    """The velocity of which half the accelerations over dt were others."""
    half = 0.5 * dt
    return (
        (
            v[0] + half * (a[0] - before[0]),
            v[1] + half * (a[1] - before[1]),
            v[2] + half * (a[2] - before[2]),
        ),
    )


def advanced(xp, value, rate, dt):
    """value + dt rate."""
    return (value + dt * rate,)


def corrected_heat(xp, heat, push, before, after, expected):
    """The heat of a push whose work is on (before + after)/2 and was reckoned on `expected`."""
    x = push[0] * (0.5 * (before[0] + after[0]) - expected[0])
    y = push[1] * (0.5 * (before[1] + after[1]) - expected[1])
    z = push[2] * (0.5 * (before[2] + after[2]) - expected[2])
    return (heat - (x + y + z),)
