"""What is beside the particles of a fluid: point masses, and what effects keep of the whole body from step to step.

Kicks are by the fluid; between them point masses act on each other, kick, drift and kick.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.models.sph.state import State
from astroinertia.sph.fluid import Fluid

Array = Any


def opened(xp: Any, effects: Sequence[Effect], points: dict[str, Any] | None) -> dict[str, Any]:
    """The points given, and the histories that effects begin with where none is."""
    begun = {effect.kind: effect.initial_history(xp) for effect in effects}
    return {**{kind: history for kind, history in begun.items() if history is not None}, **(points or {})}


def with_histories(xp: Any, effects: Sequence[Effect], fluid: Fluid) -> dict[str, Any]:
    """The points beside the fluid, with what effects know of the whole body as it is now."""
    points = dict(fluid.points)
    for effect in effects:
        if (history := effect.history(xp, fluid)) is not None:
            points[effect.kind] = history
    return points


def pushed(xp: Any, effects: Sequence[Effect], points: dict[str, Any], fluid: Fluid, spans: Array) -> dict[str, Any]:
    """Points after the fluid's particles, each over its own span (n,), or all over the same, acted on them."""
    points = dict(points)
    for effect in effects:
        if (gain := effect.reaction(xp, fluid, fluid.mass * spans)) is not None:
            group = points[effect.kind]
            points[effect.kind] = replace(group, velocity=group.velocity + gain)
    return points


def drifted(xp: Any, points: dict[str, Any], dt: Array, time: Array) -> dict[str, Any]:
    """Points dt later, at `time`: between two kicks by the fluid they act on each other, kick, drift and kick."""
    points = _by_each_other(xp, points, 0.5 * dt)
    points = {kind: group.drifted(dt, time) for kind, group in points.items()}
    return _by_each_other(xp, points, 0.5 * dt)


def _by_each_other(xp: Any, points: dict[str, Any], dt: Array) -> dict[str, Any]:
    among = moving(points)
    return {
        kind: replace(group, velocity=group.velocity + dt * group.by_each_other(xp, among)) if _moves(group) else group
        for kind, group in points.items()
    }


def moving(points: dict[str, Any]) -> list[Any]:
    """Those that the fluid acts on."""
    return [group for group in points.values() if _moves(group)]


def _moves(points: Any) -> bool:
    return hasattr(points, "by_each_other")


def without_others(state: State) -> tuple[State, tuple[Any, ...]]:
    """The arrays of the particles alone, and what else there is: the ledger, the ledgers of regions and the points."""
    fluid = state.rates.fluid
    rates = state.rates if fluid is None else replace(state.rates, fluid=replace(fluid, points={}))
    others = state.ledger, state.regions, state.points, fluid
    return replace(state, ledger=None, regions={}, points={}, rates=rates), others


def with_others(state: State, others: tuple[Any, ...]) -> State:
    """The state put together again."""
    ledger, regions, points, fluid = others
    rates = state.rates
    if fluid is not None:
        rates = replace(rates, fluid=replace(rates.fluid, points=fluid.points))
    return replace(state, ledger=ledger, regions=regions, points=points, rates=rates)


def system_record(state: State) -> dict[str, Array]:
    """Momentum and angular momentum, about the centre of mass of all, of fluid and moving points together."""
    among = moving(state.points)
    if not among:
        return {}
    parts = [state, *among]
    mass, position, velocity = (
        np.concatenate([np.asarray(getattr(part, name)) for part in parts]) for name in ("mass", "position", "velocity")
    )
    centre, drift = (mass @ position) / mass.sum(), (mass @ velocity) / mass.sum()
    spin = sum(np.asarray(group.spin).sum(axis=0) for group in among if hasattr(group, "spin"))
    orbital = (mass[:, None] * np.cross(position - centre, velocity - drift)).sum(axis=0)
    return {"system_momentum": mass @ velocity, "system_angular_momentum": orbital + spin}
