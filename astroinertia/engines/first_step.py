"""The first step of an adaptive integration, given. Tests: tests/unit/engines/test_adaptive.py."""

from dataclasses import replace
from typing import Any

import diffrax


class FirstStepGiven(diffrax.PIDController):
    """A controller that knows the first step itself.

    diffrax checks a first step that it is given by a call from compiled code into Python, and JAX keeps no program with
    such a call on disk: each process would compile it, for seconds.
    """

    first: Any = None

    def wrap(self, direction: Any) -> "FirstStepGiven":
        """The same for time that runs forward."""
        return replace(self, first=self.first * direction)

    def init(self, terms: Any, t0: Any, t1: Any, y0: Any, dt0: Any, *rest: Any) -> Any:
        """The end of the first step, and the controller's state."""
        return super().init(terms, t0, t1, y0, self.first, *rest)
