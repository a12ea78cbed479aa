"""What is beside the particles of a fluid: point masses, and what effects keep of the whole body from step to step.

Kicks are by the fluid. Between them point masses act on each other, by a scheme of fourth order with short steps: what
two of them gain as they fall together is far more than what they have, before they part again or become one.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.engines.elementwise import by_numpy
from astroinertia.models.sph.limits import towards
from astroinertia.models.sph.state import State
from astroinertia.sph.fluid import Fluid

Array = Any
# Shares of a step over which points drift and are kicked in turn, of fourth order (Omelyan, Mryglod & Folk 2002,
# Comput. Phys. Commun. 146, 188, section 4.2).
OUTER, INNER, KICK = 0.1786178958448091, -0.06626458266981849, -0.2123418310626054
DRIFTS = (OUTER, INNER, 1.0 - 2.0 * (OUTER + INNER), INNER, OUTER)
KICKS = (0.5 - KICK, KICK, KICK, 0.5 - KICK, 0.0)
SUBSTEP = 0.1  # of the time scale of their orbit or pass: as two fall together their energy errs by 1e-5 of its parts
MOST = 1e5  # substeps of a drift: points that fall into each other without softening take no more


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
    """Points dt later, at `time`: between two kicks by the fluid they act on each other, in steps of their own.

    Programs that are traced have as many of these whatever the points do: one.
    """
    if sum(len(group.mass) for group in moving(points)) < 2:
        return {kind: group.drifted(dt, time) for kind, group in points.items()}
    if not by_numpy(xp):
        return _substep(xp, points, dt, time)
    left = float(dt)
    while left > 0.0:
        among = moving(points)
        allowed = SUBSTEP * min(float(group.meeting_time(xp, among, 0.0)) for group in among)
        span = towards(left, max(allowed, float(dt) / MOST))
        left = 0.0 if span == left else left - span
        points = _substep(xp, points, span, time - left)
    return points


def _substep(xp: Any, points: dict[str, Any], dt: Array, time: Array) -> dict[str, Any]:
    gone = 0.0
    for drift, kick in zip(DRIFTS, KICKS, strict=True):
        gone += drift
        points = {kind: group.drifted(drift * dt, time - (1.0 - gone) * dt) for kind, group in points.items()}
        if kick:
            points = _by_each_other(xp, points, kick * dt)
    return points


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
