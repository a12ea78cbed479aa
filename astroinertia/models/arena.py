"""A part of a body by itself for a while: particles of short intervals, and what is around them.

Between two ends of a rung's interval nothing happens but to the particles of that rung and finer ones. They are
taken out of the body with all particles that may come within their reach meanwhile, which only drift, and put back at
its end: what is done in between costs what it is done to, however large the body is.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.models.active import moved
from astroinertia.models.flow import Flow
from astroinertia.models.sph import Arrangement

Array = Any
WORTH = 3  # ends of intervals that must lie within, for taking a part out to pay
PART = 0.125  # of the particles: what is taken out is less, those around not counted
GROWTH = 1.25  # by how much smoothing lengths may grow meanwhile
ALONE = 3000  # particles that two threads are not worth waking for


def depth_of_part(flow: Flow, depth: int) -> int | None:
    """The rung below `depth` whose particles, and finer ones, are worth taking out until its interval ends."""
    rung = flow.rows["rung"]
    counts = np.bincount(rung)
    within = counts[::-1].cumsum()[::-1]  # particles of this rung or a finer one
    for inner in range(max(flow.clock.level, depth + 1), len(counts)):
        if 2 ** (len(counts) - 1 - inner) > WORTH and within[inner] <= PART * flow.count:
            return inner
    return None


def part_of(flow: Flow, depth: int) -> Flow:
    """The particles of rung `depth` and finer with those around them; rows `home` tell where they come from."""
    rows, engine = flow.rows, flow.problem.engine
    inner = rows["rung"] >= depth
    chosen = np.flatnonzero(inner | _around(flow, inner, flow.clock.base / 2.0**depth))
    threads = 1 if len(chosen) < ALONE else engine.threads
    problem = replace(flow.problem, engine=engine.with_threads(threads))
    taken = {name: array[chosen] for name, array in rows.items()} | {"home": chosen}
    taken["ledger_mass"] = np.where(inner[chosen], taken["ledger_mass"], 0.0)
    pairs = problem.engine.subset(flow.arrangement.pairs, chosen, taken["smoothing_length"])
    return replace(flow, problem=problem, arrangement=Arrangement(pairs, {}), rows=taken, whole=False, pairs=None)


def put_back(flow: Flow, part: Flow, depth: int) -> None:
    """What became of the particles that were taken out; all others drift to the same time."""
    inner = np.flatnonzero(part.rows["rung"] >= depth)
    home = part.rows.pop("home")[inner]
    ledger_mass = flow.rows["ledger_mass"]
    others = ledger_mass.copy()
    others[home] = 0.0
    flow.ledger, flow.regions, flow.points = part.ledger, part.regions, part.points
    flow.centre, flow.centre_velocity = part.centre, part.centre_velocity
    moved(flow, part.clock, others)
    for name, array in part.rows.items():
        if name not in flow.rows:
            flow.rows[name] = np.zeros((flow.count, *array.shape[1:]))
        flow.rows[name][home] = array[inner]


def _around(flow: Flow, inner: Array, dt: float) -> Array:
    """Which particles may come within reach of those inside within dt, (N,) bool."""
    engine, kernel, rows = flow.problem.engine, flow.problem.kernel, flow.rows
    members = np.flatnonzero(inner)
    middle = rows["velocity"][members].mean(axis=0)
    apart = np.sqrt(np.square(rows["velocity"] - middle).sum(axis=1))
    reach = GROWTH * rows["smoothing_length"] + dt * (apart + apart[members].max())
    return engine.near(flow.arrangement.pairs, kernel, rows["position"], reach, members)
