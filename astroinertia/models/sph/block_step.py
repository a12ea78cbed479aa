"""A base step of a particle fluid in which every particle has an interval of its own (models.sph.intervals).

At each of its ends some particles are active: those whose interval ends. Their densities, gradients and memories follow
from all particles around, where those are now; then every pair of which both are active is kicked over half the
interval that ends and half the one that begins. Rates of change, which time-step limits, viscosity's switch and
predicted velocities need, are those by all neighbours. At the end of a base step all are active, and the state is one
like any other: nothing but the state goes from one base step to the next. Where one interval is for all, the step is
the global one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.engines.elementwise import added
from astroinertia.engines.pytree import mapped, with_fields
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.errors import SceneError
from astroinertia.ledger.moments import Whole
from astroinertia.models.protocol import GivenUp, never
from astroinertia.models.sph import (
    active as parts,
    evaluate,
    intervals,
    limits as timesteps,
    points,
    step as global_steps,
    subcycle,
)
from astroinertia.models.sph.active import BlockStep, HalfIntervals, opened
from astroinertia.models.sph.evaluate import Sums, add_sums
from astroinertia.models.sph.intervals import NEIGHBOURS, merged, rungs
from astroinertia.models.sph.limits import shortest, total_acceleration, towards
from astroinertia.models.sph.state import Arrangement, Problem, Rates, State
from astroinertia.sph import rung_costs
from astroinertia.sph.fluid import Fluid

Array = Any
RINGS = 16  # of neighbours over which limits are made to agree before a base step
ACTIVATED = 4.0  # a particle is activated where its interval is longer than this times a neighbour's limit
SORTED = 4  # particles may be sorted again where intervals of this rung end
PATIENCE = 2  # an interval becomes longer only where that of this many rungs above ends as well
KEPT = 1.1  # an interval goes on where it is longer than its limit by less than this
SAME = 1e-9  # of the largest acceleration, by which it differs where only the order of sums does
SETTLED = 0.9  # an interval becomes longer where the longer one is below this part of its limit


def neighbourhood_pair(xp, step_rate_j, interval_j):
    """1/limit and interval of a neighbour."""
    return step_rate_j, interval_j


NEIGHBOURHOOD = PairTerm("timesteps", neighbourhood_pair, (Output("rate", "max"), Output("interval", "max")))


@dataclass(frozen=True)
class Taken:
    """What a base step was: how many particles each rung had when it began, evaluations, and ends of intervals."""

    counts: Array
    evaluations: int
    ends: int

    @property
    def ideal_speed_up(self) -> float:
        """N 2^k / sum 2^(k_i) of the rungs k_i as they change, with k the finest at each moment.

        That is what global steps, as short as the shortest, would have evaluated, over what was evaluated.
        """
        return float(self.counts.sum()) * self.ends / self.evaluations

    def __str__(self) -> str:
        """The histogram of rungs and the ideal speed-up, in a few words."""
        return f"rungs {' '.join(map(str, self.counts))}, ideal speed-up {self.ideal_speed_up:.1f}"


def step(
    problem: Problem, arrangement: Arrangement, state: State, until: float, longest: float = math.inf,
    to_give_up: Callable[[], bool] = never, rung: Array | None = None,
) -> tuple[State, Arrangement, Taken]:  # fmt: skip
    """One base step, not past `until` and no longer than `longest`; the global one where several rungs do not pay.

    to_give_up: asked wherever intervals begin; if so, GivenUp is raised, and the state given is what it was.
    rung: (N,) those with which it lasts until then; None where limits decide.
    """
    limits, remaining = own_limits(problem, state.rates), until - float(state.time)
    beyond = 0 if _act_with_base(problem) else rung_costs.BEYOND
    # Nor do several rungs pay with limits that are agreed on, which are closer together.
    if rung is not None or intervals.rungs_that_pay(limits, beyond, min(remaining, longest), agreed=False):
        lists = evaluate.listed(problem, arrangement.pairs, state.position, state.smoothing_length)
        moving = state.position, state.rates.fluid.velocity, state.smoothing_length
        apart = _contacts(problem, *moving, min(remaining, longest, float(np.max(limits))))
        limits = agreed_limits(problem, lists, state, np.minimum(limits, apart))
        if rung is None:
            base, rung = intervals.base_step(limits, remaining, beyond, longest)
        else:
            base = towards(remaining, longest)
        if rung.any():  # type: ignore[union-attr]
            block = opened(problem, arrangement, state, base, limits)
            block.to_give_up = to_give_up
            block.pairs, block.more["contact"], block.looked = lists, apart, block.time
            del lists  # the block has others soon
            return _split(block, state, rung)
    dt = towards(remaining, min(float(state.rates.timestep), longest))
    taken = Taken(np.array([len(limits)]), len(limits), 1)
    return global_steps.step(problem, arrangement, state, np.float64(dt)), arrangement, taken


def _split(block: BlockStep, state: State, rung: Array) -> tuple[State, Arrangement, Taken]:
    """A base step with these rungs (N,), from the state that it begins with."""
    everyone = np.arange(block.count)
    fluid = with_fields(parts.fluid_of(block), gradients=state.rates.fluid.gradients)
    _kick(block, everyone, fluid, rung, opening=state)
    del fluid  # whose gradients nothing asks for any more
    block.more["predicted"] = state.velocity  # all there is, is of one time
    _carry_on(block, 0)
    rates = _close(block)
    tally = block.tally
    taken = Taken(np.bincount(rung), tally.evaluations + block.count, tally.ends + 1)
    return parts.closed(block, rates), block.arrangement, taken


def _carry_on(block: BlockStep, depth: int) -> None:
    """To the end of the interval of the rung `depth` that is under way, where nothing is evaluated yet."""
    finest = int(block.more["rung"].max())
    while True:
        if block.to_give_up():
            raise GivenUp
        inner = subcycle.depth_of_part(block, depth)
        if inner is None:
            parts.drift(block, block.clock.after(int(block.more["rung"].max())))
        else:
            part = subcycle.part_of(block, inner)
            _carry_on(part, inner)
            subcycle.put_back(block, part, inner)
        if block.clock.level <= depth or _ends_early(block, depth, finest):
            return
        if block.clock.level <= SORTED and parts.stale(block):
            parts.sorted_again(block)
        block.tally.evaluations += _synchronise(block)
        block.tally.ends += 1


def _ends_early(block: BlockStep, depth: int, finest: int) -> bool:
    """Whether the base step is over where all intervals end: limits have become shorter than those that it suits.

    Few particles of a finer rung than the finest one at first would ask for as many ends of intervals again. The last
    interval that ends is then the base step.
    """
    level, rung = block.clock.level, block.more["rung"]
    if depth > 0 or _act_with_base(block.problem) or rung.max() <= finest or rung.min() < level:
        return False
    now, block.clock, block.more["rung"] = block.time, block.clock.last(), rung - level
    block.begun = now - block.clock.base
    return True


def _synchronise(block: BlockStep) -> int:
    """Evaluate and kick those that are active now; their number."""
    level, more = block.clock.level, block.more
    active = np.flatnonzero(more["rung"] >= level)
    _look_ahead(block, active)
    parts.list_neighbours(block, active)
    sums = _before_forces(block, active)
    activated = _to_activate(block, active, sums, level)
    if len(activated):
        further = _before_forces(block, activated)
        both = np.concatenate([active, activated])
        order = np.argsort(both)
        active = both[order]
        sums = {
            effect: {name: np.concatenate([a, further[effect][name]])[order] for name, a in outputs.items()}
            for effect, outputs in sums.items()
        }
    since = _since(block, active)
    fluid = parts.remembered(block, active, sums, since)
    old, limits = more["rung"][active], more["limit"][active]
    wanted, relaxed = rungs(KEPT * limits, block.clock.base), rungs(SETTLED * limits, block.clock.base)
    # Few ends of intervals are for longer ones to begin: nested sets that lose members are summed over again.
    longer = np.where(level <= old - PATIENCE, np.minimum(old, relaxed), old)
    rung = merged(np.maximum(level, np.where(wanted > old, wanted, longer)), level)
    _kick_and_rate(block, active, fluid, rung, since)
    return len(active)


def _close(block: BlockStep) -> Rates:
    """Evaluate all particles at the end of a base step and close their intervals; the rates of the state."""
    everyone = np.arange(block.count)
    parts.list_neighbours(block, everyone)
    sums = _before_forces(block, everyone)
    since = _since(block, everyone)
    fluid = parts.remembered(block, everyone, sums, since)
    rates = _kick_and_rate(block, everyone, fluid, np.full(block.count, -1), since)
    del sums["timesteps"]
    return with_fields(rates, timestep=shortest(block.xp, timesteps.timestep_limits(block.problem, rates).values()))


def _before_forces(block: BlockStep, active: Array) -> Sums:
    """Densities of active particles, the sums of the pass before the forces, and how long intervals may be."""
    before = block.take("smoothing_length", active).copy()
    parts.find_densities(block, active)
    sums = parts.gradients(block, active, NEIGHBOURHOOD)
    # The last evaluation's limit, shorter where matter has been compressed since.
    own = block.take("own_limit", active) * np.minimum(1.0, block.take("smoothing_length", active) / before)
    own = np.minimum(own, block.take("contact", active))
    limit = _with_neighbours(own, sums)
    block.put("limit", active, limit)
    block.put("step_rate", active, 1.0 / limit)
    return sums


def _look_ahead(block: BlockStep, active: Array) -> None:
    """What is on its way is not to be met in the middle of an interval that begins now.

    Where one may last longer than until then, as it was when it was looked for last, it is looked for again.
    """
    longest = np.minimum(block.take("own_limit", active), block.clock.base / 2.0**block.clock.level)
    if (longest > block.take("contact", active) - (block.time - block.looked)).any():
        moving = block.state.position, block.more["predicted"], block.state.smoothing_length
        block.more["contact"], block.looked = _contacts(block.problem, *moving, block.clock.base), block.time


def _to_activate(block: BlockStep, active: Array, sums: Sums, level: int) -> Array:
    """Particles at the middle of their interval with a neighbour whose limit is far shorter than that.

    Half a kick over the whole interval was a whole one over its first half, to first order: nothing has to be
    corrected.
    """
    more, longer = block.more, block.clock.base / 2.0 ** (level - 1)
    near = (sums["timesteps"]["interval"] > 0.75 * longer) & (ACTIVATED * more["limit"][active] < longer)
    if level == 0 or not near.any():
        return np.zeros(0, np.int64)
    resting = np.flatnonzero(more["rung"] == level - 1)
    if not len(resting):
        return resting
    names = ("mass", "position", "smoothing_length", "step_rate", "interval")
    engine, kernel = block.problem.engine, block.problem.kernel
    fields = {name: block.array(name) for name in names}
    around = engine.neighbour_sums(block.pairs, kernel, (NEIGHBOURHOOD,), fields, targets=block.chosen(resting))
    return resting[ACTIVATED / np.maximum(around["timesteps"]["rate"], 1e-300) < longer]


def _since(block: BlockStep, active: Array) -> Array:
    """Time since active particles were evaluated, (n,): their intervals, or half of those of activated ones."""
    activated = block.take("rung", active) < block.clock.level
    return np.where(activated, 0.5, 1.0) * block.take("interval", active)


def _kick_and_rate(block: BlockStep, active: Array, fluid: Fluid, rung: Array, since: Array) -> Rates:
    """Kick active particles; their rates now, `since` (n,) after the last ones."""
    fluid, own = _kick(block, active, fluid, rung)
    rates = evaluate.rates_of(block.problem, fluid, own, block.take("entropy_per_heat", active))
    parts.correct(block, active, since, total_acceleration(block.xp, rates, fluid.velocity))
    block.put("entropy_rate", active, rates.entropy_rate)
    if rates.exchange is not None:
        block.put("decay", active, rates.exchange.decay)
    block.put("own_limit", active, own_limits(block.problem, rates, block.clock.level == 0))
    return rates


def _kick(
    block: BlockStep, active: Array, fluid: Fluid, rung: Array, opening: State | None = None
) -> tuple[Fluid, list[Array | None]]:
    """Kick active particles, over half of what ends and half of what begins with their new rungs.

    opening: the state that a base step begins with. Returned are the particles with their sums, and each effect's
    acceleration that is not of pairs.
    """
    problem, clock = block.problem, block.clock
    old = block.take("rung", active).copy()
    old[old < clock.level] = -1  # activated
    spans = HalfIntervals(clock.base, clock.level, old, rung)
    near, pushed = parts.neighbour_forces(block, fluid, active, spans)
    if opening is not None:
        _recall_distant(block, near, opening)
    distant, pulled, beginning = parts.distant_forces(block, active, spans)
    sums: Sums = {}
    for further in (near, distant if opening is None else _distant_sums(block)):
        add_sums(sums, further)
    fluid = with_fields(fluid, sums=sums)
    after = evaluate.with_memories_of_sums(problem, fluid)
    parts.keep_memories(block, active, fluid, after)
    own = [_own_acceleration(block, effect, fluid, active) for effect in problem.effects]
    pushes, by_pairs = [], []
    for effect, acceleration in zip(problem.effects, own, strict=True):
        impulses = pushed.get(effect.kind, {})
        push = added(impulses.get("acceleration"), pulled.get(effect.kind))
        if acceleration is not None and _acts_now(block, effect):
            span = 0.5 * clock.base if effect.whole_body else spans.both
            push = added(push, np.reshape(span, (-1, 1)) * acceleration)
        pushes.append(push)
        by_pairs.append(impulses.get("heating") if problem.equation_of_state.thermal else None)
    beside = points.pushed(np, problem.effects, block.state.points, fluid, spans.both)
    block.state = with_fields(block.state, points=beside)
    exchange = evaluate.exchange_with_surroundings(problem, fluid, block.take("entropy_per_heat", active))
    parts.kick(block, active, pushes, [effect.drag(fluid) for effect in problem.effects], by_pairs, exchange, spans)
    if spans.opens:
        parts.remember_outer(block, active, beginning)
        interval = np.ldexp(clock.base, -rung)
        block.put("rung", active, rung)
        block.put("interval", active, interval)
        block.put("middle", active, block.time + 0.5 * interval)
    return fluid, own


def _own_acceleration(block: BlockStep, effect: Effect, fluid: Fluid, active: Array) -> Array | None:
    """An effect's acceleration that is not of pairs.

    Most act on a particle by itself; what depends on the whole body, on all of it at once, with the base step, so that
    it exerts no net force.
    """
    name = f"body.{effect.kind}"
    if not _acts_now(block, effect):
        return block.more[name][active] if name in block.more else None
    acceleration = effect.acceleration(block.xp, fluid)
    if acceleration is not None and effect.whole_body:
        block.more[name] = acceleration
    return acceleration


def _acts_now(block: BlockStep, effect: Effect) -> bool:
    return block.clock.level == 0 or not effect.whole_body


def _act_with_base(problem: Problem) -> bool:
    return any(effect.whole_body for effect in problem.effects)


def _recall_distant(block: BlockStep, near: Sums, state: State) -> None:
    # What is not by neighbours is in the state's sums together with what is.
    for effect in block.problem.effects:
        outputs = state.rates.fluid.sums.get(effect.kind, {})
        if "acceleration" in outputs and (effect.all_pair_terms or "own_sums" in vars(type(effect))):
            by_neighbours = near.get(effect.kind, {}).get("acceleration", 0.0)
            block.more[f"distant.{effect.kind}"] = outputs["acceleration"] - by_neighbours


def _distant_sums(block: BlockStep) -> Sums:
    return {kind: {"acceleration": array} for kind, array in block.distant.items()}


def refuse_unsaid_whole(problem: Problem, state: State) -> None:
    """SceneError where an acceleration of the user's own depends on particles that need not be due, unsaid.

    What it gives to every other particle, asked for these alone, is then not what it gives them among all.
    """
    fluid = state.rates.fluid
    count, body = len(fluid.mass), Whole(fluid.mass.sum(), fluid.centre, fluid.centre_velocity)
    some = mapped(lambda array: array[::2] if np.ndim(array) and len(array) == count else array, fluid)
    some = with_fields(some, body=body, points=fluid.points)
    for effect in problem.effects:
        if effect.whole_body or type(effect).__module__.startswith("astroinertia."):
            continue
        given: Any = [effect.acceleration(problem.engine.xp, seen) for seen in (fluid, fluid, some)]
        among, again, alone = given
        if among is None or not np.array_equal(among, again):  # one that is random says nothing
            continue
        if not np.allclose(among[::2], alone, rtol=0.0, atol=SAME * float(abs(among).max())):
            raise SceneError(
                f"the acceleration that the effect '{effect.kind}' gives to a particle depends on others, which "
                "individual time steps do not show to it: a class of which whole_body = True acts on all at once; "
                'else take [numerics] timesteps = "global".'
            )


def agreed_limits(problem: Problem, pairs: Any, state: State, limits: Array) -> Array:
    """The longest intervals (N,) of particles by their own limits (N,), and within a factor of two of neighbours'."""
    shared = evaluate.shared_fields(state.rates.fluid)
    fields = {**shared, "position": state.position, "interval": np.zeros(len(limits))}
    for _ in range(RINGS):
        fields["step_rate"] = 1.0 / limits
        agreed = _with_neighbours(
            limits, problem.engine.neighbour_sums(pairs, problem.kernel, (NEIGHBOURHOOD,), fields)
        )
        if (agreed >= limits).all():
            break
        limits = agreed
    return limits


def own_limits(problem: Problem, rates: Rates, whole: bool = True) -> Array:
    """The longest interval of each particle by all criteria but its neighbours', (N,).

    Where particles are not the whole body, what limits that has limited the base step already.
    """
    if not whole and _act_with_base(problem):
        problem = replace(problem, effects=tuple(effect for effect in problem.effects if not effect.whole_body))
    limits = np.full(len(rates.fluid.mass), np.inf)
    for limit in timesteps.particle_limits(problem, rates).values():
        limits = np.minimum(limits, limit)
    return limits


def _contacts(problem: Problem, position: Array, velocity: Array, smoothing_length: Array, interval: float) -> Array:
    """The longest interval of each particle, (N,), for the sake of what it is not to meet in the middle of it."""
    if not problem.terms("neighbour_terms"):
        return np.full(len(position), np.inf)
    return timesteps.contacts(problem, position, velocity, smoothing_length, interval)


def _with_neighbours(limits: Array, sums: Sums) -> Array:
    rate = sums["timesteps"]["rate"]
    return np.minimum(limits, np.where(rate > 0.0, NEIGHBOURS / np.maximum(rate, 1e-300), np.inf))
