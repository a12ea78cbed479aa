"""A base step of a particle fluid in which every particle has an interval of its own (integrate.hierarchical).

At each of its ends some particles are active: those whose interval ends. Their densities, gradients and memories follow
from all particles around, where those are now; then every pair of which both are active is kicked over half the
interval that ends and half the one that begins. Rates of change, which time-step limits, viscosity's switch and
predicted velocities need, are those by all neighbours. At the end of a base step all are active, and the state is one
like any other: nothing but the state is carried from one base step to the next.
"""

from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import added
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.integrate.hierarchical import NEIGHBOURS, base_step, merged, rungs
from astroinertia.integrate.leapfrog import Rates, State
from astroinertia.integrate.timestep import shortest
from astroinertia.models import active as passes, arena, points, sph
from astroinertia.models.active import Sums
from astroinertia.models.flow import Flow, Part, Spans, opened
from astroinertia.models.heat import exchange_with_surroundings, with_heat
from astroinertia.models.sph import Arrangement, Problem
from astroinertia.sph.fluid import Fluid

Array = Any
RINGS = 16  # of neighbours over which limits are made to agree before a base step
WOKEN = 4.0  # a particle is woken where its interval is longer than this times a neighbour's limit
BEYOND = 1  # powers of two that a base step is longer than the longest interval, where nothing acts with base steps
SORTED = 4  # particles may be sorted again where intervals of this rung end
PATIENCE = 2  # an interval becomes longer only where that of this many rungs above ends as well
KEPT = 1.1  # an interval goes on where it is longer than its limit by less than this
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


def step(problem: Problem, arrangement: Arrangement, state: State, until: float) -> tuple[State, Arrangement, Taken]:
    """One base step, not past `until`, of particles that were just sorted."""
    lists = problem.engine.listed(arrangement.pairs, problem.kernel, state.position, state.smoothing_length)
    limits = agreed_limits(problem, lists, state)
    # What is on its way is not to be met in the middle of an interval.
    meets = bool(sph.pair_terms(problem, "neighbour_terms"))
    remaining, beyond = until - float(state.time), 0 if _act_with_base(problem) else BEYOND
    longest = min(remaining, 2.0**beyond * float(np.max(limits)))
    met = float(sph.contact(problem, state.rates.fluid, np.float64(longest))) if meets else np.inf
    base, rung = base_step(limits, min(remaining, met), beyond)
    flow = opened(problem, arrangement, state, base, limits)
    everyone = np.arange(flow.count)
    flow.pairs = lists
    flow.rows["rung"] = np.full(flow.count, -1)
    flow.rows["interval"] = np.zeros(flow.count)
    flow.rows["middle"][:] = flow.time  # the state is one at this time
    counts = np.bincount(rung)
    _kicked(flow, everyone, passes.fluid_of(flow, gradients=state.rates.fluid.gradients), rung, state)
    flow.rows["predicted"] = state.velocity  # all there is, is of one time
    _carry_on(flow, 0)
    rates = _closed(flow)
    state = passes.closed(flow, state, rates)
    tally = flow.tally
    return state, flow.arrangement, Taken(counts, tally.evaluations + flow.count, tally.ends + 1)


def _carry_on(flow: Flow, depth: int) -> None:
    """To the end of the interval of the rung `depth` that is under way, where nothing is evaluated yet."""
    while True:
        inner = arena.depth_of_part(flow, depth)
        if inner is None:
            passes.drift(flow, flow.clock.after(int(flow.rows["rung"].max())))
        else:
            part = arena.part_of(flow, inner)
            _carry_on(part, inner)
            arena.put_back(flow, part, inner)
        if flow.clock.level <= depth:
            return
        if flow.clock.level <= SORTED and passes.stale(flow):
            passes.sorted_again(flow)
        flow.tally.evaluations += _synchronised(flow)
        flow.tally.ends += 1


def agreed_limits(problem: Problem, pairs: Any, state: State) -> Array:
    """The longest interval of each particle, (N,), by its own limits and with neighbours' within a factor of two."""
    limits = own_limits(problem, state.rates)
    fields = {**sph.shared_fields(state.rates.fluid), "position": state.position, "interval": np.zeros(len(limits))}
    for _ in range(RINGS):
        sums = problem.engine.neighbour_sums(
            pairs, problem.kernel, (NEIGHBOURHOOD,), {**fields, "step_rate": 1.0 / limits}
        )
        agreed = _with_neighbours(limits, sums)
        if (agreed >= limits).all():
            break
        limits = agreed
    return limits


def own_limits(problem: Problem, rates: Rates, whole: bool = True) -> Array:
    """The longest interval of each particle by all criteria but its neighbours', (N,).

    Where particles are not the whole body, what limits that has limited the base step already.
    """
    if not whole:
        problem = replace(problem, effects=tuple(effect for effect in problem.effects if not effect.whole_body))
    limits = np.full(len(rates.fluid.mass), np.inf)
    for limit in sph.particle_limits(problem, rates).values():
        limits = np.minimum(limits, limit)
    return limits


def _with_neighbours(limits: Array, sums: Sums) -> Array:
    rate = sums["timesteps"]["rate"]
    return np.minimum(limits, np.where(rate > 0.0, NEIGHBOURS / np.maximum(rate, 1e-300), np.inf))


def _synchronised(flow: Flow) -> int:
    """Evaluate and kick those that are active now; their number."""
    level, rows = flow.clock.level, flow.rows
    active = np.flatnonzero(rows["rung"] >= level)
    passes.list_neighbours(flow, active)
    sums = _before_forces(flow, active)
    activated = _to_activate(flow, active, sums, level)
    if len(activated):
        further = _before_forces(flow, activated)
        both = np.concatenate([active, activated])
        order = np.argsort(both)
        active = both[order]
        sums = {
            effect: {name: np.concatenate([a, further[effect][name]])[order] for name, a in outputs.items()}
            for effect, outputs in sums.items()
        }
    since = _since(flow, active)
    part = _remembered(flow, active, sums, since)
    old, limits = rows["rung"][active], rows["limit"][active]
    wanted, relaxed = rungs(KEPT * limits, flow.clock.base), rungs(SETTLED * limits, flow.clock.base)
    # Few ends of intervals are for longer ones to begin: nested sets that lose members are summed over again.
    longer = np.where(level <= old - PATIENCE, np.minimum(old, relaxed), old)
    rung = merged(np.maximum(level, np.where(wanted > old, wanted, longer)), level)
    _forced(flow, active, part, rung, since)
    return len(active)


def _before_forces(flow: Flow, active: Array) -> Sums:
    rows, before = flow.rows, flow.take("smoothing_length", active).copy()
    passes.find_densities(flow, active)
    rows["step_rate"] = 1.0 / rows["limit"]
    sums = passes.gradients(flow, active, (NEIGHBOURHOOD,))
    # The last evaluation's limit, shorter where matter has been compressed since.
    own = flow.take("own_limit", active) * np.minimum(1.0, flow.take("smoothing_length", active) / before)
    flow.put("limit", active, _with_neighbours(own, sums))
    return sums


def _to_activate(flow: Flow, active: Array, sums: Sums, level: int) -> Array:
    """Particles at the middle of their interval with a neighbour whose limit is far shorter than that.

    Half a kick over the whole interval was a whole one over its first half, to first order: nothing has to be
    corrected.
    """
    rows, longer = flow.rows, flow.clock.base / 2.0 ** (level - 1)
    near = (sums["timesteps"]["interval"] > 0.75 * longer) & (WOKEN * rows["limit"][active] < longer)
    if level == 0 or not near.any():
        return np.zeros(0, np.int64)
    resting = np.flatnonzero(rows["rung"] == level - 1)
    if not len(resting):
        return resting
    rows["step_rate"] = 1.0 / rows["limit"]
    fields = {name: rows[name] for name in ("mass", "position", "smoothing_length", "step_rate", "interval")}
    found = flow.problem.engine.neighbour_sums(
        flow.pairs, flow.problem.kernel, (NEIGHBOURHOOD,), fields, targets=flow.targets(resting)
    )
    return resting[WOKEN / np.maximum(found["timesteps"]["rate"], 1e-300) < longer]


def _since(flow: Flow, active: Array) -> Array:
    """Time since active particles were evaluated, (n,): their intervals, or half of them where they have been woken."""
    activated = flow.take("rung", active) < flow.clock.level
    return np.where(activated, 0.5, 1.0) * flow.take("interval", active)


def _remembered(flow: Flow, active: Array, sums: Sums, since: Array) -> Part:
    """The active particles with their gradients, and their memories brought up to now."""
    part = passes.fluid_of(flow, active, gradients=sums)
    for effect in flow.problem.effects:
        if changed := effect.remember(np, part, since):
            part = replace(part, memory={**part.memory, **changed})
            for name, values in changed.items():
                flow.put(f"memory.{name}", active, values)
    return part


def _kicked(
    flow: Flow, active: Array, part: Any, rung: Array, opening: State | None = None
) -> tuple[Part, list[Array | None], list[Array | None]]:
    """Kick active particles, over half of what ends and half of what begins with their new rungs.

    opening: the state that a base step begins with. Returned are the particles with their sums, and each effect's
    acceleration that is not of pairs, and drag.
    """
    problem, level = flow.problem, flow.clock.level
    old = flow.take("rung", active).copy()
    old[old < level] = -1  # woken
    spans = Spans(flow.clock.base, level, old, rung)
    plain, pushed = passes.neighbour_forces(flow, part, active, spans)
    if opening is not None:
        _found_before(flow, plain, opening)
    distant, pulled, far = passes.distant_forces(flow, active, spans)
    sums: Sums = {}
    for further in (plain, distant if opening is None else _distant_rows(flow)):
        sph.add_sums(sums, further)
    part = replace(part, sums=sums)
    own, kicked = _own_accelerations(flow, part, active)
    half = spans.closing + spans.opening
    pushes, heat = [], []
    for effect, acceleration in zip(problem.effects, own, strict=True):
        impulses = pushed.get(effect.kind, {})
        push = added(impulses.get("acceleration"), pulled.get(effect.kind))
        if acceleration is not None and kicked(effect):
            span = 0.5 * flow.clock.base if effect.whole_body else half
            push = added(push, np.reshape(span, (-1, 1)) * acceleration)
        pushes.append(np.zeros((len(active), 3)) if push is None else push)
        heat.append(impulses.get("heating") if problem.equation_of_state.thermal else None)
    flow.points = points.pushed(problem.effects, part, half)
    drags = [effect.drag(part) for effect in problem.effects]
    exchange = exchange_with_surroundings(problem, part, flow.take("entropy_per_heat", active))
    passes.kick(flow, active, pushes, drags, heat, exchange, spans)
    if spans.opens:
        passes.remember_outer(flow, active, far)
        interval = flow.clock.base / 2.0**rung
        flow.put("rung", active, rung)
        flow.put("interval", active, interval)
        flow.put("middle", active, flow.time + 0.5 * interval)
    return part, own, drags


def _forced(flow: Flow, active: Array, part: Any, rung: Array, since: Array) -> Rates:
    """Kick active particles as `_kicked` does; their rates now, `since` (n,) after the last ones."""
    part, own, drags = _kicked(flow, active, part, rung)
    rates = _rates(flow.problem, part, own, drags, flow.take("entropy_per_heat", active))
    passes.correct(flow, active, since, sph.total_acceleration(np, rates, part.velocity))
    flow.put("entropy_rate", active, rates.entropy_rate)
    if rates.exchange is not None:
        flow.put("decay", active, rates.exchange.decay)
    flow.put("own_limit", active, own_limits(flow.problem, rates, flow.clock.level == 0))
    return rates


def _found_before(flow: Flow, plain: Sums, state: State) -> None:
    # What is not by neighbours is in the state's sums together with what is.
    for effect, outputs in state.rates.fluid.sums.items():
        if "acceleration" in outputs and _has_distant(flow.problem, effect):
            near = plain.get(effect, {}).get("acceleration", 0.0)
            flow.rows[f"distant.{effect}"] = outputs["acceleration"] - near


def _has_distant(problem: Problem, kind: str) -> bool:
    (effect,) = (effect for effect in problem.effects if effect.kind == kind)
    return bool(effect.all_pair_terms) or "own_sums" in vars(type(effect))


def _distant_rows(flow: Flow) -> Sums:
    return {kind: {"acceleration": array} for kind, array in flow.under("distant").items()}


def _act_with_base(problem: Problem) -> bool:
    return any(effect.whole_body for effect in problem.effects)


def _own_accelerations(flow: Flow, part: Any, active: Array) -> tuple[list[Array | None], Any]:
    """Each effect's acceleration that is not of pairs, and whether it kicks now.

    Most act on a particle by itself; what depends on the whole body, on all of it at once, with the base step, so that
    it exerts no net force.
    """
    found = []
    everyone = flow.clock.level == 0

    def kicked(effect: Any) -> bool:
        return everyone or not effect.whole_body

    for effect in flow.problem.effects:
        if kicked(effect):
            acceleration = effect.acceleration(np, part)
            if acceleration is not None and effect.whole_body:
                flow.rows[f"body.{effect.kind}"] = acceleration
        else:
            stored = flow.rows.get(f"body.{effect.kind}")
            acceleration = None if stored is None else stored[active]
        found.append(acceleration)
    return found, kicked


def _rates(problem: Problem, part: Fluid, own: list[Array | None], drags: list[Array | None], per_heat: Array) -> Rates:
    accelerations = tuple(
        added(part.sums.get(effect.kind, {}).get("acceleration"), acceleration)
        for effect, acceleration in zip(problem.effects, own, strict=True)
    )
    total = reduce(added, accelerations, None)
    thermal = problem.equation_of_state.thermal
    rates = Rates(
        acceleration=accelerations,
        drag=tuple(drags),
        heating=tuple(part.sums.get(e.kind, {}).get("heating") if thermal else None for e in problem.effects),
        entropy_rate=np.zeros_like(part.entropy),
        timestep=np.zeros(()),
        fluid=part,
        total=np.zeros_like(part.velocity) if total is None else total,
    )
    return with_heat(problem, rates, per_heat)


def _closed(flow: Flow) -> Rates:
    """Evaluate all particles at the end of a base step and close their intervals; the rates of the state."""
    everyone = np.arange(flow.count)
    passes.list_neighbours(flow, everyone)
    sums = _before_forces(flow, everyone)
    since = _since(flow, everyone)
    part = _remembered(flow, everyone, sums, since)
    rates = _forced(flow, everyone, part, np.full(flow.count, -1), since)
    rates = replace(rates, timestep=shortest(np, sph.timestep_limits(flow.problem, rates).values()))
    del sums["timesteps"]
    whole = {name: getattr(rates.fluid, name) for name in Fluid.__dataclass_fields__}
    return replace(rates, fluid=Fluid(**whole))
