"""One step of a particle fluid, and many.

Half kick, drift, evaluation, half kick: second order, symplectic for a fixed step, one force evaluation a step
(Hernquist & Katz 1989, ApJS 70, 419; Springel 2005, MNRAS 364, 1105). Velocity-dependent effects see the velocity that
is predicted for the end of the step, which makes them time-centred.
"""

from dataclasses import replace
from typing import Any

from astroinertia.models.sph import points
from astroinertia.models.sph.compiled import compiled
from astroinertia.models.sph.evaluate import evaluated
from astroinertia.models.sph.heat import Heat
from astroinertia.models.sph.kick_drift import change_by_rates, drift, kick
from astroinertia.models.sph.state import Arrangement, Problem, State

Array = Any


def step(problem: Problem, arrangement: Arrangement, state: State, dt: Array) -> State:
    """One kick-drift-kick step of length dt."""
    state = half_kick(problem, state, dt / 2)
    state = drifted(problem, state, dt)
    state = evaluated(problem, arrangement, state, dt)
    state = half_kick(problem, state, dt / 2)
    return replace(state, step=state.step + 1)


@compiled
def half_kick(problem: Problem, state: State, dt: Array) -> State:
    """All particles, and the points beside them, kicked over dt by the present rates."""
    xp, rates = problem.engine.xp, state.rates
    change = change_by_rates(xp, state, dt)
    heat = Heat(rates.heating, rates.exchange, rates.entropy_rate, dt, dt)
    matter = problem.matter(state.material) if problem.equation_of_state.curved else None
    state = kick(xp, state, change, heat, rates.fluid.density, matter)
    return replace(state, points=points.pushed(xp, problem.effects, state.points, rates.fluid, dt))


@compiled
def drifted(problem: Problem, state: State, dt: Array) -> State:
    """All particles after free motion over dt."""
    return drift(problem.engine.xp, state, dt)


def advance(problem: Problem, arrangement: Arrangement, state: State, steps: int) -> State:
    """`steps` steps, each as long as the state allows; reverse-differentiable with the xla engine."""
    if problem.engine.name != "xla":
        for _ in range(steps):
            state = step(problem, arrangement, state, state.rates.timestep)
        return state

    import jax  # only here: numba's engine does without it

    def one(state: State, _: None) -> tuple[State, None]:
        return step(problem, arrangement, state, state.rates.timestep), None

    return jax.lax.scan(jax.checkpoint(one), state, None, length=steps)[0]
