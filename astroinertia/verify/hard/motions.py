"""Hard cases of how matter moves: cold, at rest, at a thousand times the speed of sound, into vacuum, near break-up."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from astroinertia.models.sph.evolution import Particles
from astroinertia.verify.hard.case import KEPT, Case
from astroinertia.verify.hard.clouds import COUNT, ball, cloud, every_other, first, turning, two

SOUND = (10.0 / 9.0) ** 0.5  # of an ideal gas of exponent 5/3 with u = 1


# 0.42 with 32 particles a body, whose smoothing lengths are nearly half its radius, and 0.12 with 1000.
def _through(body: Particles, before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, float]:
    """How much of the momentum that the first of two bodies had along x it still has: 1 where they did not meet."""
    state = body.state
    own = np.asarray(state.identity) < COUNT // 2
    mass, velocity = np.asarray(state.mass)[own], np.asarray(state.velocity)[own, 0]
    opening = np.sqrt(2.0 * before["kinetic_energy"] / before["mass"])
    return {"through": float(mass @ velocity / mass.sum() / opening)}


def _expanded(body: Particles, before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, float]:
    """How far short of all its energy a blast into vacuum is in motion."""
    return {"not_in_motion": 1.0 - float(after["kinetic_energy"] / before["internal_energy"])}


def _apart(body: Particles, before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, float]:
    """Decades short of 1e6 radii that the outermost particle is."""
    reached = np.linalg.norm(np.asarray(body.state.position), axis=1).max()
    return {"short_of_1e6": float(max(0.0, 6.0 - np.log10(reached)))}


MOTIONS: tuple[Case, ...] = (
    Case("zero temperature at rest", lambda: cloud(ball(), 0.0, 0.0)),
    Case("zero temperature, expanding", lambda: cloud(ball(), 2.0 * ball(), 0.0)),
    Case("zero temperature, turning", lambda: cloud(ball(), turning(ball(), 0.7), 0.0)),
    Case("half of it at zero temperature", lambda: cloud(ball(), 0.0, np.where(every_other(), 1.0, 0.0))),
    Case("zero velocity", lambda: cloud(ball(), 0.0, 0.3)),
    Case("zero temperature and no gravity", lambda: cloud(1e8 * ball(), 0.0, 0.0), stable="nothing moves"),
    Case("temperatures of 1 to 1e12", lambda: cloud(ball(), 0.0, np.where(every_other(), 1e6, 1e-6)), steps=300),
    Case("all heat in one particle", lambda: cloud(ball(), 0.0, np.where(first(), 1e6, 1e-6)), steps=400),
    Case("the smallest temperatures", lambda: cloud(ball(), 0.0, 1e-300)),
    Case(
        "head on at Mach 1000", lambda: two(4.0, 1e3 * SOUND, 0.0, 1.0), stable=KEPT + "; they stop each other",
        until=6.0 / SOUND / 1e3, steps=400, bars={"through": 0.5}, finding=_through,
    ),
    Case("past each other at Mach 1000", lambda: two(4.0, 1e3 * SOUND, 1.5, 1.0), until=8.0 / SOUND / 1e3, steps=400),
    Case(
        "head on a thousand radii away", lambda: two(1e3, 1e3, 0.0, 1.0), stable=KEPT + "; they stop each other",
        until=1.002, steps=500, bars={"through": 0.5}, finding=_through,
    ),
    Case(
        "a blast into vacuum", lambda: cloud(ball(), 0.0, 1e12), stable=KEPT + "; all its energy comes to be motion",
        until=1e-3, steps=400, bars={"not_in_motion": 0.01}, finding=_expanded,
    ),
    Case(
        "everything falls to a point",
        lambda: cloud(ball(), -30.0 * ball() / np.linalg.norm(ball(), axis=1, keepdims=True), 0.0), until=0.1,
        steps=300,
    ),
    Case("a pancake collapses", lambda: cloud(ball() * [1.0, 1.0, 0.1], 0.0, 0.0), until=0.5, steps=400),
    Case("a spindle collapses", lambda: cloud(ball() * [0.1, 0.1, 1.0], 0.0, 0.0), until=0.3, steps=600),
    Case("a bounce", lambda: cloud(ball(), 0.0, 1e-3), until=1.5, steps=600),
    Case(
        "time steps of 1 to 1e5",
        lambda: cloud(np.concatenate([ball(32, 1, 2e-4), ball(32, 2)]), 0.0, np.repeat([1e3, 1e-3], 32)), steps=500,
    ),
    Case(
        "out to 1e6 radii", lambda: cloud(ball(), 10.0 * ball(), 10.0), stable=KEPT + "; particles get there",
        until=2e5, steps=600, bars={"short_of_1e6": 0.0}, finding=_apart,
    ),
    Case(
        "one particle at 1e6 times the speed of sound",
        lambda: cloud(ball(), np.where(first()[:, None], [1e6, 0.0, 0.0], 0.0)), until=1e-4, steps=400,
    ),
    Case("99.9 % of break-up", lambda: cloud(ball(), turning(ball(), 0.999))),
    Case("beyond break-up", lambda: cloud(ball(), turning(ball(), 3.0))),
    Case(
        "halves that turn against each other",
        lambda: cloud(ball(), turning(ball(), np.where(ball()[:, 2] > 0.0, 3.0, -3.0))), steps=200,
    ),
    Case("about a tilted axis", lambda: cloud(ball() * [1.0, 0.8, 0.6], turning(ball(), 0.7, (1.0, 1.0, 1.0)))),
    Case("shear of 1e3", lambda: cloud(ball(), 1e3 * ball()[:, [1]] * [1.0, 0.0, 0.0]), until=1e-2, steps=300),
    Case("without a sound, random motion", lambda: cloud(ball(), 10.0 * ball(COUNT, 7), 0.0), until=0.3, steps=400),
)  # fmt: skip
