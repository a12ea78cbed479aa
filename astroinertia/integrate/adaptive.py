"""Ordinary differential equations to a tolerance: an explicit pair of order 8(7) with steps that follow the error."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp

Tree = Any

MOST_STEPS = 4_000_000  # from one record to the next
STEPS_AT_ONCE = 10_000  # between two looks at whoever waits: at most some seconds of work
SHORTEST = 1e-14  # of a step, as a share of the time: round-off
WHOLE = 0.99  # of what is left, beyond which a first step takes all of it


class Advanced(NamedTuple):
    """Where an integration ended: the state and the time there.

    timestep is the mean length of a step, with which the next call may begin, steps their number, rejected ones
    included; `stopped` says that the condition ended it, `unfinished` that it took all the steps that it was allowed,
    `failed` that it took one of no length.
    """

    state: Tree
    time: jax.Array
    timestep: jax.Array
    steps: jax.Array
    stopped: jax.Array
    unfinished: jax.Array
    failed: jax.Array


@partial(jax.jit, static_argnames=("rate", "condition", "most_steps"))
def advance(
    rate: Callable[[Any, Tree, Any], Tree],
    arguments: Any,
    state: Tree,
    time: float,
    until: float,
    timestep: float,
    relative: float = 1e-13,
    absolute: float = 1e-14,
    condition: Callable[[Any, Tree, Any], Any] | None = None,
    most_steps: int = MOST_STEPS,
) -> Advanced:
    """The state, a pytree of float64 arrays, at `until`, of d state/dt = rate(time, state, arguments).

    arguments is a pytree of the problem's numbers, timestep the first step that is tried, relative and absolute the
    error allowed in a step, in the root mean square over the state. Where condition(time, state, arguments) is true
    after a step, the integration ends there. rate and condition are functions of a module: each new one is compiled.
    Runs under jax.enable_x64. Source: Prince & Dormand 1981, J. Comp. Appl. Math. 7, 67, as diffrax has it.
    Checked by tests/unit/test_adaptive.py.
    """
    shortest = SHORTEST * jnp.maximum(jnp.abs(time), jnp.abs(until))
    # A first step that all but reaches the end would leave one of no length.
    left = until - time
    first = jnp.where(jnp.abs(timestep) > WHOLE * jnp.abs(left), left, timestep)
    solved = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        diffrax.Dopri8(),
        t0=time,
        t1=until,
        dt0=first,
        y0=state,
        args=arguments,
        stepsize_controller=diffrax.PIDController(rtol=relative, atol=absolute, dtmin=shortest, force_dtmin=False),
        max_steps=most_steps,
        saveat=diffrax.SaveAt(t1=True),
        adjoint=diffrax.ForwardMode(),
        event=None if condition is None else diffrax.Event(lambda t, y, args, **_: condition(t, y, args)),
        throw=False,
    )
    assert solved.ts is not None  # asked for by saveat
    reached = solved.ts[-1]
    stopped = solved.result == diffrax.RESULTS.event_occurred
    unfinished = solved.result == diffrax.RESULTS.max_steps_reached
    return Advanced(
        state=jax.tree.map(lambda saved: saved[-1], solved.ys),
        time=reached,
        timestep=(reached - time) / jnp.maximum(solved.stats["num_accepted_steps"], 1),
        steps=solved.stats["num_steps"],
        stopped=stopped,
        unfinished=unfinished,
        failed=~(stopped | unfinished | (solved.result == diffrax.RESULTS.successful)),
    )
