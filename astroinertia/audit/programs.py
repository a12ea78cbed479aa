"""The program of one step of each model, traced: every operation that is compiled, with the scope that it stands in."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp

from astroinertia.build.sph import engine_of
from astroinertia.scene.schema import Scene


def traced(scene: Scene, evolution: Any) -> Any:
    """The jaxpr of a step (sph) or of the rates of change (ellipsoid, rigid); None where closed forms answer (scaling).

    Particles are traced with the engine xla, whatever engine the scene asks for: the physics is written once.
    """
    if scene.model == "scaling":
        return None
    trace = {"sph": _particles, "ellipsoid": _ellipsoid, "rigid": _rigid}[scene.model]
    with jax.enable_x64(True):
        return trace(evolution).jaxpr.jaxpr


def _particles(evolution: Any) -> Any:
    from astroinertia.models.sph.sorting import arranged
    from astroinertia.models.sph.step import step

    problem, state = evolution.problem, jax.tree.map(jnp.asarray, evolution.state)
    engine = engine_of("xla", "float64", problem.kernel)
    problem = replace(problem, engine=engine)
    pairs = engine.arrange(state.position, state.smoothing_length)[1]
    arrangement = arranged(problem, pairs, state)
    return jax.jit(step).trace(problem, arrangement, state, jnp.asarray(1e-3))


def _ellipsoid(evolution: Any) -> Any:
    from astroinertia.models.ellipsoid import affine_body

    problem = evolution.problem
    scaled = affine_body.measured(problem, evolution.state)
    return jax.jit(affine_body.scaled_rate).trace(jnp.asarray(evolution.time), scaled, problem)


def _rigid(evolution: Any) -> Any:
    from astroinertia.models.rigid import body as rigid

    return jax.jit(rigid.motion).trace(evolution.body, jnp.asarray(evolution.time), evolution.state.turning.value)
