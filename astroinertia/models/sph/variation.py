"""Particles and four bodies of them beside, which are where a parameter a little to either side of its value takes it.

What is differentiated is the run as it is: the lengths of its steps answer to the parameter as everything else does,
smoothing lengths by the equation that they solve. How many steps meet a time, and the lists of neighbours, which no sum
depends on, are given. Tests: tests/unit/sweeps/test_gradient.py, tests/physics/test_gradients.py.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.effects.effect import acting
from astroinertia.engines import variational
from astroinertia.models.sph.evaluate import turned
from astroinertia.models.sph.evolution import Particles
from astroinertia.models.sph.limits import steps_left
from astroinertia.models.sph.sorting import in_order
from astroinertia.models.sph.state import Arrangement, Problem, State
from astroinertia.models.sph.step import step as one_step

Array = Any
MET = 1e-14  # of a time, which is met where no more is left to it


def advance(body: Particles, four: Sequence[Particles], step: float, until: float) -> float:
    """All of them to a time, the four by the linearised steps; how far they jump at the start (variational.slopes).

    NumericalError as of Particles.advance. ValueError where the parameter moves the beginning or end of an effect.
    """
    breaks = body.breaks(until)
    if any(one.breaks(until) != breaks for one in four):
        raise ValueError("the times at which effects begin or end differ")
    with jax.enable_x64(True):
        known = body.state.identity
        along, jump = variational.slopes([in_order(one.state, _order(one.state.identity, known)) for one in four], step)
        by_problem, known_until = None, -np.inf
        while body.time < until * (1.0 - MET):
            longest = body.longest
            stop, problem = body.stretch(until)
            if stop != known_until:
                by_problem, moved = variational.slopes([acting(one.problem, body.time, stop) for one in four], step)
                known_until, jump = stop, max(jump, moved)
            body.begin(stop, longest)
            longest = min(float(body.state.rates.timestep), longest)
            along = in_order(along, _order(known, body.state.identity))
            known, parts = body.state.identity, steps_left(stop - body.time, longest)
            body.state, along = _stepped(
                (problem, by_problem), body.arrangement, (body.state, along), stop, parts, body.free_fall_factor
            )
            if stop in breaks and body.has_met(stop):
                by_problem, _ = variational.slopes([acting(one.problem, stop) for one in four], step)
                both = (acting(body.problem, stop), by_problem), body.arrangement, (body.state, along)
                body.state, along = _turned(*both, stop)
            body.check()
        for side, one in zip(variational.SIDES, four, strict=True):
            one.state, one.arrangement = variational.beside(body.state, along, side * step), body.arrangement
    return jump


@jax.jit
def _stepped(
    problems: tuple[Problem, Any], arrangement: Arrangement, states: tuple[State, Any], until: Array, parts: Array,
    free_fall_factor: Array | None,
) -> tuple[State, Any]:  # fmt: skip
    """A step of a state and of its derivative, both as they come in: one program serves all steps."""

    def stepped(both: tuple[Problem, State]) -> State:
        problem, state = both
        longest = state.rates.timestep
        if free_fall_factor is not None:
            longest = jnp.minimum(longest, free_fall_factor / jnp.sqrt(state.rates.fluid.density.max()))
        dt = jnp.where(parts > 0, (until - state.time) / jnp.maximum(parts, 1), longest)
        return one_step(problem, arrangement, state, dt)

    both = variational.pushed(stepped, (problems[0], states[0]), (problems[1], states[1]))
    return jax.tree.map(lambda array: array.astype(array.dtype), both)


@jax.jit
def _turned(
    problems: tuple[Problem, Any], arrangement: Arrangement, states: tuple[State, Any], time: Array
) -> tuple[State, Any]:
    """A state and its derivative with what acts from that time on."""
    return variational.pushed(
        lambda both: turned(both[0], arrangement, both[1], time), (problems[0], states[0]), (problems[1], states[1])
    )


def _order(now: Array, wanted: Array) -> np.ndarray:
    """Where among particles of identities `now` those of `wanted` are, (N,)."""
    return np.argsort(np.asarray(now))[np.asarray(wanted)]
