"""A part of a body by itself for a while: particles of short intervals, and what is around them.

Between two ends of a rung's interval nothing happens but to the particles of that rung and finer ones. They are
taken out of the body with all particles that may come within their reach meanwhile, which only drift, and put back at
its end: what is done in between costs what it is done to, however large the body is.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.models.sph.active import BlockStep, carry_on, choose
from astroinertia.models.sph.state import Arrangement
from astroinertia.sph.rung_costs import PART

Array = Any
CHANGING = ("position", "remainder", "velocity", "entropy", "smoothing_length")  # of a state, besides its memory
WORTH = 3  # ends of intervals that must lie within, for taking a part out to pay
GROWTH = 1.25  # by how much smoothing lengths may grow meanwhile


def depth_of_part(block: BlockStep, depth: int) -> int | None:
    """The rung below `depth` whose particles, and finer ones, are worth taking out until its interval ends."""
    counts = np.bincount(block.more["rung"])
    within = counts[::-1].cumsum()[::-1]  # particles of this rung or a finer one
    for inner in range(max(block.clock.level, depth + 1), len(counts)):
        if 2 ** (len(counts) - 1 - inner) > WORTH and within[inner] <= PART * block.count:
            return inner
    return None


def part_of(block: BlockStep, depth: int) -> BlockStep:
    """The particles of rung `depth` and finer with those around them; their array `home` says where they come from."""
    inner = block.more["rung"] >= depth
    chosen = np.flatnonzero(inner | _around(block, inner, block.clock.base / 2.0**depth))
    pairs = block.problem.engine.subset(block.arrangement.pairs, chosen, block.state.smoothing_length[chosen])
    part = replace(block, arrangement=Arrangement(pairs, {}), whole=False, pairs=None)
    choose(part, chosen)
    part.more |= {"home": chosen, "counted": np.where(inner[chosen], part.more["counted"], 0.0)}
    return part


def put_back(block: BlockStep, part: BlockStep, depth: int) -> None:
    """What became of the particles that were taken out; all others drift to the same time."""
    inner = np.flatnonzero(part.more["rung"] >= depth)
    home = part.more.pop("home")[inner]
    del part.more["contact"]  # with what else is in the part alone
    others = block.more["counted"].copy()
    others[home] = 0.0
    went, block.body = part.state, part.body
    block.state = replace(block.state, ledger=went.ledger, regions=went.regions, points=went.points)
    carry_on(block, part.clock, others)
    for name in CHANGING:
        getattr(block.state, name)[home] = getattr(went, name)[inner]
    for name, array in went.memory.items():
        block.state.memory[name][home] = array[inner]
    for name, array in part.more.items():
        if name not in block.more:
            block.more[name] = np.zeros((block.count, *array.shape[1:]))
        block.more[name][home] = array[inner]


def _around(block: BlockStep, inner: Array, dt: float) -> Array:
    """Which particles may come within reach of those inside within dt, (N,) bool."""
    engine, kernel, state = block.problem.engine, block.problem.kernel, block.state
    members = np.flatnonzero(inner)
    middle = state.velocity[members].mean(axis=0)
    apart = np.sqrt(np.square(state.velocity - middle).sum(axis=1))
    reach = GROWTH * state.smoothing_length + dt * (apart + apart[members].max())
    return engine.near(block.arrangement.pairs, kernel, state.position, reach, members)
