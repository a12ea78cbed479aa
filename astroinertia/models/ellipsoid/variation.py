"""An affine body and four beside it, which are where a parameter a little to either side of its value takes it.

Tests: tests/unit/models/ellipsoid/test_variation.py, tests/unit/sweeps/test_gradient.py.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import jax

from astroinertia.engines import adaptive, variational
from astroinertia.models.ellipsoid import affine_body
from astroinertia.models.ellipsoid.evolution import ABSOLUTE, AT_ONCE, Ellipsoid
from astroinertia.models.protocol import SAME_TIME

Array = Any


def advance(body: Ellipsoid, four: Sequence[Ellipsoid], step: float, until: float) -> float:
    """All of them to a time, the four by the linearised equations; how far they jump at the start (variational.slopes).

    NumericalError as of Ellipsoid.advance. ValueError where the parameter moves the beginning or end of an effect.
    """
    breaks, jump = body.breaks(until), 0.0
    if any(one.breaks(until) != breaks for one in four):
        raise ValueError("the times at which effects begin or end differ")
    for stop in sorted({until, *breaks}):
        if stop - body.time > SAME_TIME * abs(stop):  # else two times that are meant to be the same
            jump = max(jump, _go(body, four, step, stop))
        for one in (body, *four):
            one.time = stop
    return jump


def _go(body: Ellipsoid, four: Sequence[Ellipsoid], step: float, until: float) -> float:
    """The same where no effect begins or ends on the way."""

    def inputs(one: Ellipsoid) -> tuple[Any, Any]:
        units = {name: getattr(body.problem, name) for name in ("scale", "smallest", "restoring")}
        return replace(one.stretch(until)[1], **units), affine_body.measured(body.problem, one.state)

    problem = inputs(body)[0]
    with jax.enable_x64(True):
        (by_problem, along), jump = variational.slopes([inputs(one) for one in four], step)
        state, way, goes_on = affine_body.measured(problem, body.state), adaptive.Way(), True
        while goes_on:
            advanced = adaptive.advance(
                _rate, (problem, by_problem), (state, along), body.time, until, min(body.timestep, until - body.time),
                body.tolerance, ABSOLUTE * body.tolerance, _ended, min(AT_ONCE, adaptive.MOST_STEPS),
            )  # fmt: skip
            goes_on = way.goes_on(body.time, advanced, until)
            state, along = advanced.state
            body.moved(affine_body.unmeasured(problem, state), advanced)
        if bool(advanced.stopped) or bool(advanced.failed):
            raise body.diagnosis()
        for side, one in zip(variational.SIDES, four, strict=True):
            beside = variational.beside(state, along, side * step)
            one.moved(affine_body.unmeasured(problem, beside), advanced)
    return jump


def _rate(time: Array, both: tuple, problems: tuple) -> tuple:
    def rate(arguments: tuple) -> Any:
        return affine_body.scaled_rate(time, *arguments)

    return variational.pushed(rate, (both[0], problems[0]), (both[1], problems[1]))


def _ended(time: Array, both: tuple, problems: tuple) -> Array:
    return affine_body.ended(time, both[0], problems[0])
