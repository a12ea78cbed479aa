"""Evolving a prepared scene in memory: what the physics tests and the full cases measure with."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from astroinertia.build.assemble import prepare
from astroinertia.models.sph.evolution import Particles
from astroinertia.models.sph.record import series_record
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import State
from astroinertia.models.sph.step import step
from astroinertia.scene import load


def prepared(text: str, *settings: str) -> Particles:
    """The problem and the first state of a scene given as TOML text, with `--set`-style overrides."""
    return prepare(load.loads(text, settings)).evolution


def reached(body: Particles, end: float) -> list[dict[str, Any]]:
    """Records at the start and at the end, with the steps and all else that a run takes on its way."""
    first = body.record(None)
    while body.time < end * (1 - 1e-14):
        body.advance(end)
    return [first, body.record(first["potential_energy"])]


def advanced(body: Any, end: float) -> None:
    """Go to the end in as many parts as the body takes."""
    while body.time < end:
        body.advance(end)


def evolve(
    start: Particles,
    times: Sequence[float],
    watch: Callable[[State], None] | None = None,
    sort_every: int = 16,
) -> list[dict[str, Any]]:
    """Records at exactly `times` (ascending, code units); `watch` sees the state after each step."""
    problem, state, arrangement = start.problem, start.state, start.arrangement
    opening = series_record(problem, arrangement, state, None)["potential_energy"]
    records = []
    for target in times:
        while float(state.time) < target * (1 - 1e-14):
            if int(state.step) % sort_every == 0:
                state, arrangement = rearranged(problem, state)
            dt = min(float(state.rates.timestep), target - float(state.time))
            state = step(problem, arrangement, state, np.float64(dt))
            if watch is not None:
                watch(state)
        records.append(series_record(problem, arrangement, state, opening))
    return records
