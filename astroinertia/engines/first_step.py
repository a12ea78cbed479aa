"""The first step of an adaptive integration, given, and the most steps. Tests: tests/unit/engines/test_adaptive.py."""

from dataclasses import replace
from typing import Any

import diffrax
import jax.numpy as jnp


class FirstStepGiven(diffrax.PIDController):
    """A controller that knows the first step itself, and how many there are to be at most, rejected ones included.

    diffrax checks a first step that it is given by a call from compiled code into Python, and JAX keeps no program with
    such a call on disk: each process would compile it, for seconds. Its own largest number of steps is compiled in.
    """

    first: Any = None
    most: Any = None

    def wrap(self, direction: Any) -> "FirstStepGiven":
        """The same for time that runs forward."""
        return replace(self, first=self.first * direction)

    def init(self, terms: Any, t0: Any, t1: Any, y0: Any, dt0: Any, *rest: Any) -> Any:
        """The end of the first step, and the controller's state."""
        end, state = super().init(terms, t0, t1, y0, self.first, *rest)
        return end, (state, jnp.zeros((), int))

    def adapt_step_size(self, t0: Any, t1: Any, y0: Any, y1: Any, args: Any, error: Any, order: Any, state: Any) -> Any:
        """Whether the step is kept, the next one, the controller's state, and whether there is to be none."""
        state, steps = state
        *step, state, result = super().adapt_step_size(t0, t1, y0, y1, args, error, order, state)
        enough = diffrax.RESULTS.where(steps + 1 < self.most, result, diffrax.RESULTS.max_steps_reached)
        return *step, (state, steps + 1), diffrax.RESULTS.where(result == diffrax.RESULTS.successful, enough, result)
