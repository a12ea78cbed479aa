"""Particles within a base step of individual time steps: what some of them need to be evaluated and kicked.

Rows of arrays are changed in place. A pass over pairs has the particles that are awake as its targets and all particles
as its sources; a kick is by pairs of which both are awake.
"""

from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import added, elementwise, totals
from astroinertia.engines.numba_source import argument_names
from astroinertia.engines.terms import PairTerm
from astroinertia.inertia.ledger import Whole, after_drift, after_heating, after_kick
from astroinertia.integrate.hierarchical import Clock, sets, weights
from astroinertia.integrate.leapfrog import Rates, State
from astroinertia.models import sph
from astroinertia.models.flow import FLUID, Flow, Part, Spans
from astroinertia.sph.density import density

Array = Any
Sums = dict[str, dict[str, Array]]
THERMAL = ("pressure", "sound_speed", "internal_energy", "thermal_energy", "entropy_per_heat")
FEW = 2048  # particles that plain sums over all pairs are quicker for
JUST_WOKEN = 1e36  # what a particle closes of which nothing is to be closed (Engine.neighbour_sums)


def drifted(xp, x, v, a, moment, dt, elapsed):
    """The place dt later, and the velocity then."""
    place = (x[0] + dt * v[0], x[1] + dt * v[1], x[2] + dt * v[2])
    gained = (elapsed * a[0] - moment[0], elapsed * a[1] - moment[1], elapsed * a[2] - moment[2])
    return place, (v[0] + gained[0], v[1] + gained[1], v[2] + gained[2])


def advanced(xp, value, rate, dt):
    """value + dt rate."""
    return (value + dt * rate,)


def mended(xp, heat, push, before, after, expected):
    """The heat of a push whose work is on (before + after)/2 and was reckoned on `expected`."""
    x = push[0] * (0.5 * (before[0] + after[0]) - expected[0])
    y = push[1] * (0.5 * (before[1] + after[1]) - expected[1])
    z = push[2] * (0.5 * (before[2] + after[2]) - expected[2])
    return (heat - (x + y + z),)


def drift(flow: Flow, clock: Clock) -> None:
    """Free motion of all particles to a later time; velocities now by the last accelerations."""
    rows, dt = flow.rows, clock.elapsed - flow.clock.elapsed
    rows["position"], rows["predicted"] = elementwise(
        np, drifted, rows["position"], rows["velocity"], rows["acceleration"], rows["moment"], dt, clock.elapsed
    )
    flow.ledger = after_drift(np, flow.ledger, np.float64(dt))
    flow.centre = flow.centre + dt * flow.centre_velocity
    flow.clock = clock


def list_neighbours(flow: Flow, awake: Array) -> None:
    """Have the passes to come, with those targets, share what they must know of neighbours."""
    rows = flow.rows
    flow.pairs = flow.problem.engine.listed(
        flow.arrangement.pairs, flow.problem.kernel, rows["position"], rows["smoothing_length"], flow.targets(awake)
    )


def find_densities(flow: Flow, awake: Array) -> None:
    """Smoothing lengths, densities and what follows from them; the ledger is told what pressure did since."""
    problem, eos = flow.problem, flow.problem.equation_of_state
    softening = any(effect.needs_zeta for effect in problem.effects)
    found = density(
        problem.engine, flow.pairs, problem.kernel, flow.rows["position"], flow.rows["mass"],
        flow.rows["smoothing_length"], problem.eta, problem.smoothing_tolerance, softening, flow.targets(awake),
    )  # fmt: skip
    entropy = flow.take("entropy", awake)
    if "pressure" in problem.effect_names:
        new, old = (eos.energy(np, rho, entropy) for rho in (found.density, flow.take("density", awake)))
        gain = totals(np, sph.change, flow.take("mass", awake), new, old)[0][0]
        flow.ledger = after_heating(
            flow.ledger, np.array([gain if name == "pressure" else 0.0 for name in problem.effect_names])
        )
    rate, middle = flow.take("entropy_rate", awake), flow.take("middle", awake)
    now = elementwise(np, advanced, entropy, rate, flow.time - middle)[0]
    values = dict(zip(THERMAL, eos.state(np, found.density, now), strict=True))
    values |= {"smoothing_length": found.smoothing_length, "density": found.density, "grad_h": found.grad_h}
    values |= {} if found.zeta is None else {"zeta": found.zeta}
    for name, array in values.items():
        flow.put(name, awake, array)


def fluid_of(flow: Flow, awake: Array | None = None, **more: Any) -> Part:
    """What the effects see of particles that are awake, or of all as they are known."""
    everyone = awake is None or len(awake) == flow.count
    names = [name for name in FLUID if name in flow.rows]
    arrays: dict[str, Any] = {name: flow.rows[name] if everyone else flow.rows[name][awake] for name in names}
    arrays["velocity"] = flow.rows["predicted"] if everyone else flow.rows["predicted"][awake]
    arrays.setdefault("zeta", None)
    memory = {name: array if everyone else array[awake] for name, array in flow.under("memory").items()}
    return Part(
        time=np.float64(flow.time), memory=memory, kernel=flow.problem.kernel, body_centre=flow.centre,
        body_velocity=flow.centre_velocity, **arrays, **more,
    )  # fmt: skip


def gradients(flow: Flow, awake: Array, further: tuple[PairTerm, ...]) -> Sums:
    """Sums of the pass before the forces, with further terms, which may ask for rows by their names."""
    problem = flow.problem
    everyone = fluid_of(flow)
    fields = {**flow.rows, "velocity": flow.rows["predicted"]}
    for effect in problem.effects:
        fields.update(effect.gradient_fields(np, everyone))
    terms = sph.pair_terms(problem, "gradient_terms") + further
    return problem.engine.neighbour_sums(flow.pairs, problem.kernel, terms, fields, targets=flow.targets(awake))


def centre_kick(flow: Flow, awake: Array) -> None:
    """Take from the velocities of those awake what only longer intervals will have brought by their ends.

    A kick changes velocities about those that are left, and turns as much energy into heat as they say.
    """
    rows, level, now = flow.rows, flow.clock.level, flow.clock.elapsed
    if level == 0:
        return
    ahead = np.zeros((len(awake), 3))
    for name, outer in flow.under(f"outer.{level}").items():
        ahead += now * outer[awake] - rows[f"lever.{level}.{name}"][awake]
    last = rows["rung"][awake] == level
    ahead[last] += (now - flow.clock.middle(level - 1)) * rows["beyond"][awake[last]]
    rows["predicted"][awake] -= ahead


def remember_levels(flow: Flow, awake: Array, spans: Spans, near: Array, pushed: Array, far: list[Sums]) -> None:
    """Divide the accelerations of those awake by the intervals that their partners have.

    near (n, 3) is by all neighbours, pushed (n, 3) their impulses; far holds the sums over the nested sets that begin.
    With the middle t_k of the interval of rung k and the accelerations a_k of pairs of that interval, a particle moves
    at v + sum_k (t - t_k) a_k: `acceleration` has sum_k a_k and `moment` sum_k t_k a_k, `outer.l` and `lever.l` the
    same sums over k < l. Neighbours are of the particle's own interval or of one twice as long: by those is `beyond`.
    """
    rows, level, clock = flow.rows, spans.level, flow.clock
    span = (spans.closing + spans.opening)[:, None]
    reference = np.where(spans.old < 0, spans.new, spans.old)
    awake_too = (reference > level)[:, None]
    beyond = np.where(awake_too, pushed / span - near, near - pushed / span)
    beyond[spans.new == 0] = 0.0
    rows["beyond"][awake] = beyond
    outer = np.zeros((len(awake), 3))
    lever = np.zeros((len(awake), 3))
    for kind, total in flow.under("distant").items():
        total = total[awake]
        for k, sums in enumerate(far, start=level):
            members = np.flatnonzero(spans.new >= k)
            names = f"outer.{k}.{kind}", f"lever.{k}.{kind}"
            for name in names:
                if name not in rows:
                    rows[name] = np.zeros((flow.count, 3))
            chosen = awake[members]
            mine = total[members] - sums[kind]["acceleration"] if k > 0 else np.zeros((len(members), 3))
            if k > level:
                lever_now = rows[f"lever.{k - 1}.{kind}"][chosen] + clock.middle(k - 1) * (
                    mine - rows[f"outer.{k - 1}.{kind}"][chosen]
                )
                rows[names[1]][chosen] = lever_now
            elif level > 0:
                woken = rows["rung"][chosen] < level
                if woken.any():
                    those = chosen[woken]
                    rows[names[1]][those] = rows[f"lever.{k - 1}.{kind}"][those] + clock.middle(k - 1) * (
                        mine[woken] - rows[f"outer.{k - 1}.{kind}"][those]
                    )
            else:
                rows[names[1]][chosen] = 0.0
            rows[names[0]][chosen] = mine
            last = spans.new[members] == k
            outer[members[last]] += mine[last]
            lever[members[last]] += rows[names[1]][chosen[last]]
    own = np.array([clock.middle(int(k)) for k in range(int(spans.new.max()) + 1)])
    slower = np.array([0.0, *own[:-1]])
    outer, lever = outer + beyond, lever + slower[spans.new][:, None] * beyond
    rows["moment"][awake] = lever + own[spans.new][:, None] * (rows["acceleration"][awake] - outer)


def neighbour_forces(flow: Flow, part: Part, awake: Array, spans: Spans) -> tuple[Sums, Sums]:
    """Sums of the force pass by all neighbours, and impulses by those awake, each pair over its own interval."""
    problem = flow.problem
    terms = sph.pair_terms(problem, "neighbour_terms")
    if not terms:
        return {}, {}
    mine = sph.pair_fields(problem, part)
    for name in mine.keys() - sph.shared_fields(part).keys():
        values = np.broadcast_to(np.asarray(mine[name], dtype=np.float64), len(awake))
        if f"field.{name}" not in flow.rows:
            flow.rows[f"field.{name}"] = np.zeros(flow.count)
        flow.put(f"field.{name}", awake, values)
    fields = {name: flow.rows[name] for name in ("mass", "position", "smoothing_length")}
    fields |= {"velocity": flow.rows["predicted"], **flow.under("field")}
    closing, opening = np.zeros(flow.count), np.full(flow.count, -1.0)
    closing[awake] = np.where(spans.old < 0, JUST_WOKEN, spans.closing)
    opening[awake] = spans.opening
    sums = problem.engine.neighbour_sums(
        flow.pairs, problem.kernel, terms, fields, targets=flow.targets(awake), interval=(closing, opening)
    )
    plain: Sums = {}
    impulses: Sums = {}
    for effect, outputs in sums.items():
        for name, values in outputs.items():
            stem = name.removesuffix("_impulse")
            (plain if stem == name else impulses).setdefault(effect, {})[stem] = values
    return plain, impulses


def distant_forces(flow: Flow, awake: Array, spans: Spans) -> tuple[Sums, dict[str, Array], list[Sums]]:
    """Sums that are not over neighbours, and impulses of those, {effect: (n, 3)}: by nested sets of particles.

    Where all are awake the sums have all their outputs; else only accelerations, by what sleeps taken from before.
    """
    old, new = sets(spans.old, spans.level), sets(spans.new, spans.level)
    closing = weights(spans.base, spans.level, len(old))
    opening = weights(spans.base, spans.level, len(new))
    totals: Sums = {}
    impulses: dict[str, Array] = {}
    newly: list[Sums] = []
    for k in range(max(len(old), len(new))):
        mine, next_ones = old[k] if k < len(old) else None, new[k] if k < len(new) else None
        same = mine is not None and next_ones is not None and np.array_equal(mine, next_ones)
        found = _sums_of(flow, awake, mine) if mine is not None else {}
        if same or next_ones is None:
            after = found if same else {}
        elif k == 0 and not old:  # a base step begins: these were summed at the end of the last one
            after = {kind: {"acceleration": array} for kind, array in flow.under("distant").items()}
        else:
            after = _sums_of(flow, awake, next_ones)
        for members, sums, weight in ((mine, found, closing[k : k + 1]), (next_ones, after, opening[k : k + 1])):
            for effect, outputs in sums.items():
                whole = impulses.setdefault(effect, np.zeros((len(awake), 3)))
                whole[members] += weight[0] * outputs["acceleration"]
        if k == 0:
            totals = _totals(flow, awake, mine, found, spans.level)
        newly.append(after)
    return totals, impulses, newly[: len(new)]


def _totals(flow: Flow, awake: Array, members: Array | None, found: Sums, level: int) -> Sums:
    # By all particles: those awake now, and the others as they were when last awake together with these.
    if members is None:  # a base step opens: what there is, is of now
        return {}
    for effect, outputs in found.items():
        name, chosen = f"distant.{effect}", awake[members]
        outer = flow.rows.get(f"outer.{level}.{effect}")
        if name not in flow.rows:
            flow.rows[name] = np.zeros((flow.count, 3))
        by_sleepers = 0.0 if level == 0 or outer is None else outer[chosen]
        flow.rows[name][chosen] = outputs["acceleration"] + by_sleepers
    if len(members) == flow.count:
        return found
    return {effect: {"acceleration": flow.rows[f"distant.{effect}"][awake]} for effect in found}


def _sums_of(flow: Flow, awake: Array, members: Array) -> Sums:
    # The particles in a set act on each other alone.
    problem, chosen = flow.problem, awake[members]
    if len(chosen) <= min(FEW, flow.count - 1):
        problem = replace(problem, effects=tuple(effect.direct for effect in problem.effects))
    part: Any = fluid_of(flow, chosen)  # as much of a state as effects look at
    arrangement = flow.arrangement
    if len(chosen) < flow.count:
        pairs = problem.engine.subset(arrangement.pairs, chosen, part.smoothing_length)
        arrangement = sph.arranged(problem, pairs, part)
    before: Sums = {name: {"acceleration": array[chosen]} for name, array in flow.under("distant").items()}
    fields = sph.shared_fields(part)
    for term in sph.pair_terms(problem, "all_pair_terms"):
        for function in filter(None, (term.pair, term.far)):
            for stem in {name.rpartition("_")[0] for name in argument_names(function)}:
                if f"field.{stem}" in flow.rows:
                    fields[stem] = flow.take(f"field.{stem}", chosen)
    sums = sph.distant_sums(problem, arrangement, part, before, False, fields)
    return {effect: outputs for effect, outputs in sums.items() if outputs}


def kick(
    flow: Flow, awake: Array, pushes: list[Array], drags: list[Array | None], heat: list[Array | None], spans: Spans
) -> None:
    """Change velocities by each effect's push (n, 3) and drag matrix, and entropies by its heat per mass (n,).

    A push that heats has its heat for the velocities that particles were expected to have; what it works on those that
    they turn out to have beyond that is made up for, so that it turns energy into heat and loses none.
    """
    mass = flow.take("mass", awake)
    before = flow.take("velocity", awake)
    increments = with_drag(pushes, drags, before, spans.closing + spans.opening)
    after = added(before, reduce(added, increments))
    body = Whole(flow.total_mass, flow.centre, flow.centre_velocity)
    momentum = flow.ledger.impulse.total.sum(axis=0)
    flow.ledger = after_kick(np, flow.ledger, mass, flow.take("position", awake), before, after, increments, body=body)
    gained = flow.ledger.impulse.total.sum(axis=0) - momentum
    flow.centre_velocity = flow.centre_velocity + gained / flow.total_mass
    flow.put("velocity", awake, after)
    expected, total, gains = flow.take("predicted", awake), None, np.zeros(len(heat))
    for k, (q, push) in enumerate(zip(heat, pushes, strict=True)):
        if q is not None and push is not None:
            q = elementwise(np, mended, q, push, before, after, expected)[0]
        if q is not None:
            gains[k] = totals(np, sph.product, mass, q)[0][0]
        total = added(total, q)
    flow.ledger = after_heating(flow.ledger, gains)
    if total is not None:
        entropy, unit = flow.take("entropy", awake), flow.take("entropy_per_heat", awake)
        flow.put("entropy", awake, elementwise(np, advanced, entropy, unit, total)[0])


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


def sorted_anew(flow: Flow) -> None:
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
        **{name: rows[name] for name in ("identity", "mass", "position", "velocity", "entropy", "smoothing_length")},
        memory=flow.under("memory"),
        ledger=flow.ledger,
        rates=rates,
    )
