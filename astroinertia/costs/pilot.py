"""Runs a scene with few particles, in memory, to count the steps of many (costs.piloted)."""

import time as clock
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from astroinertia.build.assemble import outputs_of, prepare
from astroinertia.costs import experience
from astroinertia.costs.piloted import PARTICLES, Pilot, kept, key, with_particles
from astroinertia.errors import AstroinertiaError
from astroinertia.models.sph.limits import timestep_limits
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from astroinertia.storage import cache

LONGEST = 20.0  # processor seconds of a pilot's steps; a longer flow is carried on as it was last
FIRST = 2  # steps in which loops are compiled, which is not counted


def run(scene: Scene, listener: Callable[[float], None] | None = None, longest: float = LONGEST) -> Pilot | None:
    """Run a scene with few particles, in memory, and keep what it reported; None where it cannot be.

    listener: hears the share that is done. A pilot that was run before is not run again.
    """
    earlier = kept(scene)
    if earlier is not None or scene.particles is None:
        return earlier
    try:
        with jax.enable_x64(True):
            pilot = _followed(scene, listener, longest)
    except AstroinertiaError:  # so few particles cannot be placed, or do not last
        return None
    if pilot is not None:
        experience.note(with_particles(scene, PARTICLES))
        arrays = {name: np.asarray(value) for name, value in vars(pilot).items()}
        cache.save("pilot", key(scene), arrays)
    return pilot


def _followed(scene: Scene, listener: Any, longest: float) -> Pilot | None:
    few = with_particles(scene, PARTICLES)
    body: Any = prepare(few).evolution
    end = outputs_of(few, code_units(few)).end
    tallies: list[Any] = []
    if body.base_step is not None:
        plain = body.base_step

        def counted(*arguments: Any) -> Any:
            result = plain(*arguments)
            tallies.append(result[2])
            return result

        body.base_step = counted
    rows, evaluated, begun = [], [], clock.process_time()
    criteria: tuple[str, ...] = ()
    while body.time < end * (1.0 - 1e-14) and (len(rows) < FIRST or clock.process_time() - begun < longest):
        limits = timestep_limits(body.problem, body.state.rates)
        criteria, before = tuple(limits), body.time
        begun = clock.process_time() if len(rows) < FIRST else begun
        body.advance(end)
        rows.append([body.time - before, *(float(np.min(limit)) for limit in limits.values())])
        count = len(body.state.mass)
        evaluated.append((tallies[-1].evaluations / count, tallies[-1].ends) if tallies else (1.0, 1.0))
        if listener is not None:
            listener(body.time / end)
    body.record(None)  # so that all that a run compiles is compiled
    measured, taken = np.array(rows), np.array(evaluated)
    if not len(measured) or not np.isfinite(measured[:, 0]).all():
        return None
    return Pilot(len(body.state.mass), measured[:, 0], criteria, measured[:, 1:], taken[:, 0], taken[:, 1],
                 min(1.0, body.time / end), clock.process_time() - begun)  # fmt: skip
