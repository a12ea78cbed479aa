"""Ordinary differential equations to a tolerance: an explicit pair of order 8(7) with steps that follow the error."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from astroinertia.engines.brief import brief

Tree = Any

MOST_STEPS = 4_000_000  # from one record to the next, and then it says that it failed
JUDGED = 2**10  # steps, from which on their length shows whether they will be far too many
FAR_TOO_MANY = 10 * MOST_STEPS
SHORTEST = 1e-14  # of a step, as a share of the time: round-off
WHOLE = 0.99  # of what is left, beyond which a first step takes all of it


class Advanced(NamedTuple):
    """Where an integration ended: the state and the time there.

    timestep is the mean length of a step, with which the next call may begin, steps their number, rejected ones
    included; `stopped` says that the condition ended it, `failed` that it took too many steps or one of no length,
    `unfinished` the first of these: the next call goes on from there.
    """

    state: Tree
    time: jax.Array
    timestep: jax.Array
    steps: jax.Array
    stopped: jax.Array
    failed: jax.Array
    unfinished: jax.Array


class Way:
    """The way from one record to the next, which `advance` may go in parts: whether it is to go on."""

    def __init__(self) -> None:
        self._begun, self._steps = math.nan, 0

    def goes_on(self, begun: float, advanced: Advanced, until: float) -> bool:
        """Whether there is more of the way after a part that began then; not where it takes too many steps."""
        if self._steps == 0:
            self._begun = begun
        self._steps += int(advanced.steps)
        share = (float(advanced.time) - self._begun) / (until - self._begun)
        most = MOST_STEPS if self._steps < JUDGED else min(MOST_STEPS, FAR_TOO_MANY * share)
        if bool(advanced.unfinished) and self._steps < most:
            return True
        self._steps = 0
        return False


@partial(brief, static_argnames=("rate", "condition"))
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
    most: int = MOST_STEPS,
) -> Advanced:
    """The state, a pytree of float64 arrays, at `until`, of d state/dt = rate(time, state, arguments).

    arguments is a pytree of the problem's numbers, timestep the first step that is tried, relative and absolute the
    error allowed in a step, in the root mean square over the state. Where condition(time, state, arguments) is true
    after a step, the integration ends there, or after `most` steps, MOST_STEPS at most. rate and condition are
    functions of a module: each new one is compiled.
    Runs under jax.enable_x64. Compiled as what runs briefly, which for ellipsoids takes 0.7 to 1.4 s less: as much as
    eighty thousand steps take longer. Source: Prince & Dormand 1981, J. Comp. Appl. Math. 7, 67, as diffrax has it.
    Checked by tests/unit/engines/test_adaptive.py.
    """
    import diffrax  # which bodies that are followed by a splitting do without

    from astroinertia.engines.first_step import FirstStepGiven

    shortest = SHORTEST * jnp.maximum(jnp.abs(time), jnp.abs(until))
    # A first step that all but reaches the end would leave one of no length.
    left = until - time
    first = jnp.where(jnp.abs(timestep) > WHOLE * jnp.abs(left), left, timestep)
    solved = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        diffrax.Dopri8(),
        t0=time,
        t1=until,
        dt0=None,
        y0=state,
        args=arguments,
        stepsize_controller=FirstStepGiven(
            rtol=relative, atol=absolute, dtmin=shortest, force_dtmin=False, first=first, most=most
        ),
        max_steps=MOST_STEPS,
        saveat=diffrax.SaveAt(t1=True),
        adjoint=diffrax.ForwardMode(),
        event=None if condition is None else diffrax.Event(lambda t, y, args, **_: condition(t, y, args)),
        throw=False,
    )
    assert solved.ts is not None  # asked for by saveat
    reached = solved.ts[-1]
    stopped = solved.result == diffrax.RESULTS.event_occurred
    enough = solved.result == diffrax.RESULTS.max_steps_reached
    unfinished = enough & (reached != until)
    return Advanced(
        state=jax.tree.map(lambda saved: saved[-1], solved.ys),
        time=reached,
        timestep=(reached - time) / jnp.maximum(solved.stats["num_accepted_steps"], 1),
        steps=solved.stats["num_steps"],
        stopped=stopped,
        failed=unfinished | ~(stopped | enough | (solved.result == diffrax.RESULTS.successful)),
        unfinished=unfinished,
    )
