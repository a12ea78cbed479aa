"""Particles within a base step of individual time steps: what some of them need to be evaluated and kicked.

Rows of arrays are changed in place. A pass over pairs has the active particles as its targets and all particles
as its sources; a kick is by pairs of which both are active.
"""

from dataclasses import replace
from functools import lru_cache, reduce
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import added, elementwise, totals
from astroinertia.engines.numba_source import argument_names
from astroinertia.engines.terms import PairTerm
from astroinertia.integrate import leapfrog
from astroinertia.integrate.exchange import Exchange, energies, entropy_after, exchanged
from astroinertia.integrate.heat_update import heat_update
from astroinertia.integrate.hierarchical import Clock, weighted_sets
from astroinertia.integrate.leapfrog import Rates, State, member_key
from astroinertia.ledger.moments import Whole, after_drift, after_heating, after_kick, after_rounding
from astroinertia.models import points, sph
from astroinertia.models.flow import FLUID, Flow, Part, Spans
from astroinertia.models.heat import compression, product
from astroinertia.sph.density import density

Array = Any
Sums = dict[str, dict[str, Array]]
THERMAL = ("pressure", "sound_speed", "internal_energy", "thermal_energy", "entropy_per_heat")
OF_A_STATE = ("identity", "mass", "position", "remainder", "velocity", "entropy", "smoothing_length")
FEW = 2048  # particles that plain sums over all pairs are quicker for
JUST_WOKEN = 1e36  # what a particle closes of which nothing is to be closed (Engine.neighbour_sums)


def drifted(xp, x, remainder, v, now, a, dt):
    """The place dt later, what rounding leaves of it, and the velocity then."""
    place, left = leapfrog.moved(xp, x, remainder, v, dt)
    return place, left, (now[0] + dt * a[0], now[1] + dt * a[1], now[2] + dt * a[2])


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


def heated(xp, entropy, unit, heat):
    """The entropy with that heat; at least half of what it was.

    A step too long for a cold particle that is pushed hard shows in the energy, not in a negative temperature.
    """
    return (xp.maximum(entropy + unit * heat, 0.5 * entropy),)


def corrected_heat(xp, heat, push, before, after, expected):
    """The heat of a push whose work is on (before + after)/2 and was reckoned on `expected`."""
    x = push[0] * (0.5 * (before[0] + after[0]) - expected[0])
    y = push[1] * (0.5 * (before[1] + after[1]) - expected[1])
    z = push[2] * (0.5 * (before[2] + after[2]) - expected[2])
    return (heat - (x + y + z),)


def drift(flow: Flow, clock: Clock) -> None:
    """Free motion of all particles to a later time, and of the body as the ledger has it."""
    dt = clock.elapsed - flow.clock.elapsed
    flow.ledger = after_drift(np, flow.ledger, np.float64(dt))
    flow.regions = {name: region.drifted(np, np.float64(dt)) for name, region in flow.regions.items()}
    flow.centre = flow.centre + dt * flow.centre_velocity
    flow.points = points.drifted(np, flow.points, np.float64(dt), np.float64(flow.begun + clock.elapsed))
    moved(flow, clock, flow.rows["ledger_mass"])


def moved(flow: Flow, clock: Clock, ledger_mass: Array) -> None:
    """The particles at a later time; velocities now by the last accelerations.

    ledger_mass: the masses (N,) with which the ledger takes in the rounding of their places.
    """
    rows, dt, before = flow.rows, clock.elapsed - flow.clock.elapsed, flow.rows["position"]
    rows["position"], rows["remainder"], rows["predicted"] = elementwise(
        np, drifted, before, rows["remainder"], rows["velocity"], rows["predicted"], rows["acceleration"], dt
    )
    ways = before, rows["position"], rows["velocity"], np.float64(dt)
    body = Whole(flow.total_mass, flow.centre, flow.centre_velocity)
    flow.ledger = after_rounding(np, flow.ledger, ledger_mass, *ways, body)
    flow.regions = {
        name: region.rounded(np, ledger_mass * rows[f"memory.{member_key(name)}"], *ways)
        for name, region in flow.regions.items()
    }
    flow.clock = clock


def list_neighbours(flow: Flow, active: Array) -> None:
    """Have the passes to come, with those targets, share what they must know of neighbours."""
    rows = flow.rows
    flow.pairs = flow.problem.engine.listed(
        flow.arrangement.pairs, flow.problem.kernel, rows["position"], rows["smoothing_length"], flow.targets(active)
    )


def matter(flow: Flow, active: Array) -> Any:
    """The equation of state of active particles."""
    material = flow.rows.get("material")
    return sph.matter(flow.problem, None if material is None else material[active])


def find_densities(flow: Flow, active: Array) -> None:
    """Smoothing lengths, densities and what follows from them; the ledger takes in what pressure did since."""
    problem, eos = flow.problem, matter(flow, active)
    softening = any(effect.needs_zeta for effect in problem.effects)
    found = density(
        problem.engine, flow.pairs, problem.kernel, flow.rows["position"], flow.rows["mass"],
        flow.rows["smoothing_length"], problem.eta, problem.smoothing_tolerance, softening, flow.targets(active),
        problem.fixed_length,
    )  # fmt: skip
    entropy = flow.take("entropy", active)
    if "pressure" in problem.effect_names:
        parts = flow.take("mass", active), entropy, flow.take("density", active), found.density
        flow.ledger = after_heating(flow.ledger, compression(problem, eos, *parts))
    rate, since = flow.take("entropy_rate", active), flow.time - flow.take("middle", active)
    if "decay" in flow.rows:
        now = elementwise(np, exchanged, entropy, rate * since, flow.take("decay", active), since)[0]
    else:
        now = elementwise(np, advanced, entropy, rate, since)[0]
    values = dict(zip(THERMAL, eos.state(np, found.density, now), strict=True))
    values |= {"smoothing_length": found.smoothing_length, "density": found.density, "grad_h": found.grad_h}
    values |= {} if found.zeta is None else {"zeta": found.zeta}
    for name, array in values.items():
        flow.put(name, active, array)


def fluid_of(flow: Flow, active: Array | None = None, **more: Any) -> Part:
    """What the effects see of active particles, or of all as they are known."""
    everyone = active is None or len(active) == flow.count
    names = [name for name in FLUID if name in flow.rows]
    arrays: dict[str, Any] = {name: flow.rows[name] if everyone else flow.rows[name][active] for name in names}
    arrays["velocity"] = flow.rows["predicted"] if everyone else flow.rows["predicted"][active]
    arrays.setdefault("zeta", None)
    memory = {name: array if everyone else array[active] for name, array in flow.under("memory").items()}
    return Part(
        time=np.float64(flow.time), memory=memory, kernel=flow.problem.kernel, points=flow.points,
        body_centre=flow.centre, body_velocity=flow.centre_velocity, **arrays, **more,
    )  # fmt: skip


def gradients(flow: Flow, active: Array, further: tuple[PairTerm, ...]) -> Sums:
    """Sums of the pass before the forces, with further terms, which may ask for rows by their names."""
    problem = flow.problem
    everyone = fluid_of(flow)
    fields = {**flow.rows, "velocity": flow.rows["predicted"]}
    for effect in problem.effects:
        fields.update(effect.gradient_fields(np, everyone))
    terms = sph.pair_terms(problem, "gradient_terms") + further
    return problem.engine.neighbour_sums(flow.pairs, problem.kernel, terms, fields, targets=flow.targets(active))


def correct(flow: Flow, active: Array, since: Array, acceleration: Array) -> None:
    """The velocities now by the trapezoidal rule over `since` (n,), with the accelerations (n, 3) found at last."""
    velocity, before = flow.take("predicted", active), flow.take("acceleration", active)
    flow.put("predicted", active, elementwise(np, trapezoid, velocity, before, acceleration, since)[0])
    flow.put("acceleration", active, acceleration)


def remember_outer(flow: Flow, active: Array, far: list[tuple[Array, list[int], Sums]]) -> None:
    """What is outside each nested set that begins exerts on those in it: far has them, their rungs and their sums."""
    for kind, total in flow.under("distant").items():
        for members, rungs, sums in far:
            chosen = active[members]
            by_others = total[chosen] - sums[kind]["acceleration"] if rungs[-1] > 0 else None
            for k in rungs:
                if k > 0:
                    flow.rows.setdefault(f"outer.{k}.{kind}", np.zeros((flow.count, 3)))[chosen] = by_others


def neighbour_forces(flow: Flow, part: Part, active: Array, spans: Spans) -> tuple[Sums, Sums]:
    """Sums of the force pass by all neighbours, and impulses by active ones, each pair over its own interval."""
    problem = flow.problem
    terms = sph.pair_terms(problem, "neighbour_terms")
    if not terms:
        return {}, {}
    mine = sph.pair_fields(problem, part)
    for name in mine.keys() - sph.shared_fields(part).keys():
        flow.rows.setdefault(f"field.{name}", np.zeros(flow.count))[active] = mine[name]
    fields = {name: flow.rows[name] for name in ("mass", "position", "smoothing_length")}
    fields |= {"velocity": flow.rows["predicted"], **flow.under("field")}
    closing, opening = np.zeros(flow.count), np.full(flow.count, -1.0)
    closing[active] = np.where(spans.old < 0, JUST_WOKEN, spans.closing)
    opening[active] = spans.opening
    sums = problem.engine.neighbour_sums(
        flow.pairs, problem.kernel, terms, fields, targets=flow.targets(active), interval=(closing, opening)
    )
    plain: Sums = {}
    impulses: Sums = {}
    for effect, outputs in sums.items():
        for name, values in outputs.items():
            stem = name.removesuffix("_impulse")
            (plain if stem == name else impulses).setdefault(effect, {})[stem] = values
    return plain, impulses


def distant_forces(
    flow: Flow, active: Array, spans: Spans
) -> tuple[Sums, dict[str, Array], list[tuple[Array, list[int], Sums]]]:
    """Sums that are not over neighbours, and impulses of those, {effect: (n, 3)}: by nested sets of particles.

    Besides, the nested sets that begin, their rungs, and the sums over them.

    Where all are active the sums have all their outputs; else only accelerations, by inactive ones as before.
    """
    totals: Sums = {}
    impulses: dict[str, Array] = {}
    done: list[tuple[Array, Sums]] = []

    def summed(members: Array, weight: float, known: Sums | None = None) -> Sums:
        # What began when the last interval did often goes on.
        sums = next((sums for chosen, sums in done if np.array_equal(chosen, members)), known)
        if sums is None:
            sums = _sums_of(flow, active, members)
            done.append((members, sums))
        for effect, outputs in sums.items():
            impulses.setdefault(effect, np.zeros((len(active), 3)))[members] += weight * outputs["acceleration"]
        return sums

    for members, rungs, weight in weighted_sets(spans.base, spans.old, spans.level):
        found = summed(members, weight)
        if rungs[0] == spans.level:
            totals = _totals(flow, active, members, found, spans.level)
    # Where a base step begins, the sums over all were made at the end of the last one.
    before: Sums | None = None if done else {kind: {"acceleration": a} for kind, a in flow.under("distant").items()}
    newly = []
    for members, rungs, weight in weighted_sets(spans.base, spans.new, spans.level):
        newly.append((members, rungs, summed(members, weight, before if rungs[0] == 0 else None)))
    return totals, impulses, newly


def _totals(flow: Flow, active: Array, members: Array, found: Sums, level: int) -> Sums:
    # By all particles: those active now, and the others as they were when last active together with these.
    for effect, outputs in found.items():
        name, chosen = f"distant.{effect}", active[members]
        outer = flow.rows.get(f"outer.{level}.{effect}")
        if name not in flow.rows:
            flow.rows[name] = np.zeros((flow.count, 3))
        by_inactive = 0.0 if level == 0 or outer is None else outer[chosen]
        flow.rows[name][chosen] = outputs["acceleration"] + by_inactive
    if level == 0:
        return found
    return {effect: {"acceleration": flow.rows[f"distant.{effect}"][active]} for effect in found}


def _sums_of(flow: Flow, active: Array, members: Array) -> Sums:
    # The particles in a set act on each other alone.
    problem, chosen = flow.problem, active[members]
    whole = flow.whole and len(chosen) == flow.count
    if len(chosen) <= FEW and not whole:
        problem = flow.direct
    part: Any = fluid_of(flow, chosen)  # as much of a state as effects look at
    arrangement = flow.arrangement
    if not whole:
        pairs = problem.engine.subset(arrangement.pairs, chosen, part.smoothing_length)
        arrangement = sph.arranged(problem, pairs, part)
    before: Sums = {name: {"acceleration": array[chosen]} for name, array in flow.under("distant").items()}
    fields = sph.shared_fields(part)
    for name in _asked_for(sph.pair_terms(problem, "all_pair_terms")):
        if f"field.{name}" in flow.rows:
            fields[name] = flow.take(f"field.{name}", chosen)
    sums = sph.distant_sums(problem, arrangement, part, before, False, fields)
    return {effect: outputs for effect, outputs in sums.items() if outputs}


@lru_cache(maxsize=32)
def _asked_for(terms: tuple[PairTerm, ...]) -> list[str]:
    # What the arguments of pair functions may be fields of.
    functions = [function for term in terms for function in (term.pair, term.far) if function is not None]
    return sorted({name.rpartition("_")[0] for function in functions for name in argument_names(function)})


def kick(
    flow: Flow, active: Array, pushes: list[Array], drags: list[Array | None], heat: list[Array | None],
    exchange: Exchange | None, spans: Spans,
) -> None:  # fmt: skip
    """Change velocities by each effect's push (n, 3) and drag matrix, and entropies by its heat per mass (n,).

    Entropies change as well by the exchange of heat with the surroundings.

    A push that heats has its heat for the velocities that particles were expected to have; what it works on those that
    they turn out to have beyond that is made up for, so that it turns energy into heat and loses none.
    """
    mass, position = flow.take("mass", active), flow.take("position", active)
    before = flow.take("velocity", active)
    increments = with_drag(pushes, drags, before, spans.closing + spans.opening)
    after = added(before, reduce(added, increments, None))
    body = Whole(flow.total_mass, flow.centre, flow.centre_velocity)
    momentum = flow.ledger.impulse.total.sum(axis=0)
    everyone = flow.whole and len(active) == flow.count
    flow.ledger = after_kick(np, flow.ledger, mass, position, before, after, increments, body=body, complete=everyone)
    flow.regions = {
        name: region.kicked(
            np,
            mass * flow.take(f"memory.{member_key(name)}", active),
            position,
            before,
            after,
            increments,
            complete=everyone,
        )
        for name, region in flow.regions.items()
    }
    gained = flow.ledger.impulse.total.sum(axis=0) - momentum
    flow.centre_velocity = flow.centre_velocity + gained / flow.total_mass
    flow.put("velocity", active, after)
    expected = flow.take("predicted", active)
    heat = [
        q if q is None or push is None else elementwise(np, corrected_heat, q, push, before, after, expected)[0]
        for q, push in zip(heat, pushes, strict=True)
    ]
    take_up(flow, active, heat, exchange, spans.closing + spans.opening)


def take_up(flow: Flow, active: Array, heat: list[Array | None], exchange: Exchange | None, span: Array) -> None:
    """Change entropies by each effect's heat per mass (n,) and the exchange with the surroundings over span (n,)."""
    mass, entropy = flow.take("mass", active), flow.take("entropy", active)
    if flow.problem.equation_of_state.curved:
        density, least = flow.take("density", active), 0.5 * entropy if exchange is None else -np.inf
        new, gains = heat_update(np, matter(flow, active), mass, density, entropy, heat, exchange, span, least)
        flow.put("entropy", active, new)
        flow.ledger = after_heating(flow.ledger, np.array(gains))
        return
    gains = np.array([0.0 if q is None else totals(np, product, mass, q)[0][0] for q in heat])
    total, unit = reduce(added, heat, None), flow.take("entropy_per_heat", active)
    if exchange is not None:
        gained = unit * added(total, span * exchange.gain)
        gains += energies(np, exchange, mass, entropy, gained, span)
        flow.put("entropy", active, entropy_after(np, exchange, entropy, gained, span))
    elif total is not None:
        flow.put("entropy", active, elementwise(np, heated, entropy, unit, total)[0])
    flow.ledger = after_heating(flow.ledger, gains)


def with_drag(pushes: list[Array], drags: list[Array | None], before: Array, span: Array) -> list[Array]:
    """dv_e = push_e + span M_e (v + v')/2, (n, 3), with v' = v + sum_e dv_e solved for exactly; span (n,)."""
    matrices = [matrix for matrix in drags if matrix is not None]
    if not matrices:
        return pushes
    total: Array = sum(matrices[1:], start=matrices[0])
    known = before + sum(pushes[1:], start=pushes[0]) + 0.5 * span[:, None] * (before @ total.T)
    after = np.empty_like(before)
    for length in np.unique(span):
        chosen = span == length
        after[chosen] = known[chosen] @ np.linalg.inv(np.eye(3) - 0.5 * length * total).T
    middle = 0.5 * span[:, None] * (before + after)
    return [push if m is None else push + middle @ m.T for push, m in zip(pushes, drags, strict=True)]


def stale(flow: Flow) -> bool:
    """Whether sorting particles again pays."""
    rows = flow.rows
    return flow.whole and flow.problem.engine.stale(flow.arrangement.pairs, rows["position"], rows["smoothing_length"])


def sorted_again(flow: Flow) -> None:
    """Sort particles into leaves by where they are."""
    order, pairs = flow.problem.engine.arrange(flow.rows["position"], flow.rows["smoothing_length"])
    flow.rows = {name: array[order] for name, array in flow.rows.items()}
    body: Any = fluid_of(flow)
    flow.arrangement = sph.arranged(flow.problem, pairs, body)


def closed(flow: Flow, state: State, rates: Rates) -> State:
    """The state at the end of a base step."""
    rows = flow.rows
    return replace(
        state,
        time=np.float64(flow.begun + flow.clock.base),
        step=state.step + 1,
        **{name: rows[name] for name in OF_A_STATE},
        material=rows.get("material"),
        memory=flow.under("memory"),
        ledger=flow.ledger,
        regions=flow.regions,
        rates=replace(rates, fluid=replace(rates.fluid, points=flow.points)),
        points=points.attracted(np, flow.problem.effects, replace(rates.fluid, points=flow.points)),
    )
