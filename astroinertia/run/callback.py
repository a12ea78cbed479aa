"""A function of the user's own that a run calls as it goes, and when."""

import math
from collections.abc import Callable as Function
from numbers import Integral
from typing import Any

import numpy as np

from astroinertia.engines import hosts
from astroinertia.errors import SceneError
from astroinertia.run.state import RunState
from astroinertia.scene.dimensional import checked, dimensional
from astroinertia.scene.plan import cadence, code_units
from astroinertia.scene.schema import Scene
from astroinertia.units import shown, with_unit, written_quantity

STOPPED = "its callback"
"""What stops a run whose callback says so, in RunInterrupted."""


class Callback:
    """The function, and when it is called: after so many `steps`, at times so far apart (code units), or at records."""

    def __init__(self, function: Function[[RunState], Any], steps: int | None, apart: float | None) -> None:
        self.function, self.steps, self.apart = function, steps, apart
        self.passed = -1
        self.failure: BaseException | None = None

    def begin(self, time: float, steps: int) -> None:
        """A run goes on from here, where it has been called before."""
        self.passed = self._count(time, steps)

    def due(self, time: float, steps: int, recorded: bool) -> bool:
        """Whether it is to be called now, at the first moment at or past one of its own."""
        count = self._count(time, steps)
        passed, self.passed = count > self.passed, max(count, self.passed)
        return recorded if self.steps is None and self.apart is None else passed

    def goes_on(self, state: RunState) -> bool:
        """Call it; whether the run is to go on. What it raises is kept, for after the run is saved."""
        try:
            answer = self.function(state)
        except BaseException as error:  # whatever it is, nothing of the run is lost
            self.failure = error
            return False
        return not (isinstance(answer, bool | np.bool_) and not answer)

    def _count(self, time: float, steps: int) -> int:
        if self.steps is not None:
            return steps // self.steps
        return 0 if self.apart is None else int(time / self.apart * (1.0 + 1e-12))


def callback_of(function: Any, every: Any, scene: Scene) -> Callback | None:
    """The callback of a run of that scene, None where there is none; SceneError names what is wrong.

    every: a time (a quantity, or text with a unit; a plain number in code units), a whole number of steps, or None.
    """
    if function is None and every is None:
        return None
    if function is None:
        raise SceneError("every says when the callback is called, but no callback is given.")
    if not callable(function):
        raise SceneError(f"callback must be a function of the state, not something of the type {_type(function)}.")
    hosts.must_be_alone("a run with a callback")
    if every is None:
        return Callback(function, None, None)
    if isinstance(every, Integral) and not isinstance(every, bool):
        if every < 1:
            raise SceneError(f"every must be at least 1 step, not {every}.")
        return Callback(function, int(every), None)
    return Callback(function, None, _time(every, scene))


def _time(every: Any, scene: Scene) -> float:
    try:
        quantity = with_unit(every)
        every = every if quantity is None else written_quantity(quantity)
        every = float(every) if isinstance(every, np.floating) else every
        if not isinstance(every, str | int | float | list):
            raise ValueError(f"must be a time or a number of steps, not something of the type {_type(every)}.")
        seconds = checked(dimensional(every, "time", scene.dimensionless), "positive", every)
        _refuse_between_records(seconds, scene)
    except (ValueError, SceneError) as error:
        raise SceneError(f"every: {error}") from None
    apart = code_units(scene).to_code(seconds, "time")
    if not (apart > 0.0 and math.isfinite(apart)):
        raise SceneError("every must be a time that the run's units can hold.")
    return apart


def _refuse_between_records(seconds: float, scene: Scene) -> None:
    """SceneError for times between the records of a run without particles, which goes from record to record."""
    records = cadence(scene).series_every
    if scene.model != "sph" and records is not None and seconds < records * (1.0 - 1e-9):
        raise SceneError(
            f"a run of the model {scene.model} is seen at its records, {scene.shown(records, 'time')} apart: give no "
            "shorter time, or a shorter output.series_every."
        )


def _type(value: Any) -> str:
    return shown(type(value).__name__)
