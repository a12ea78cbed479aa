"""A rigid body and four beside it, which are where a parameter a little to either side of its value takes it.

Tests: tests/unit/sweeps/test_gradient.py.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from astroinertia.engines import adaptive, variational
from astroinertia.errors import NumericalError
from astroinertia.ledger.moments import Compensated
from astroinertia.models.rigid import body as rigid, passage
from astroinertia.models.rigid.evolution import FAR_TOO_MANY, SHORTEST, RigidBody
from astroinertia.models.rigid.splitting import Rotor

Array = Any


def advance(body: RigidBody, four: Sequence[RigidBody], step: float, until: float) -> float:
    """All of them to a time, the four by the linearised equations, adaptively whatever integrator the body has.

    How far they jump at the start (variational.slopes). ValueError where the parameter moves a break of a torque.
    """
    breaks, jump = body.breaks(until), 0.0
    if any(one.breaks(until) != breaks for one in four):
        raise ValueError("the times at which torques begin, end or strike differ")
    for stop in sorted({until, *breaks}):
        start = body.time
        if stop - start > SHORTEST * abs(stop):  # else two times that are meant to be the same
            jump = max(jump, _go(body, four, step, stop))
        for one in (body, *four):
            one.moved(one.state, stop)
            for number, effect in enumerate(one.body.effects):
                if stop in effect.breaks(start, stop):
                    one.strike(number, effect)
    return jump


def _go(body: RigidBody, four: Sequence[RigidBody], step: float, stop: float) -> float:
    """The same where there is no break on the way."""
    momentum_unit, body_unit, energy_unit, orbit_unit = units = body.units

    def inputs(one: RigidBody) -> tuple[Any, Any]:
        turning = np.asarray(one.state.turning.total)
        state = {
            "turning": np.concatenate([turning[:4], turning[4:] / body_unit]),
            "momentum": np.asarray(one.state.angular_momentum.total) / momentum_unit,
            "accumulated": np.asarray(one.state.sums.total) / energy_unit,
        }
        if one.state.orbits is not None:
            state["orbits"] = np.asarray(one.state.orbits.total) / orbit_unit
        return (one.during(stop), *units), state

    def rotor(state: dict[str, Array]) -> Rotor:
        # By numpy: operation by operation, JAX takes longer than to integrate.
        turning, momentum, accumulated = (np.asarray(state[name]) for name in ("turning", "momentum", "accumulated"))
        turning = np.concatenate([turning[:4] / np.linalg.norm(turning[:4]), body_unit * turning[4:]])
        parts = (turning, momentum_unit * momentum, energy_unit * accumulated)
        if orbit_unit is not None:
            parts += (orbit_unit * np.asarray(state["orbits"]),)
        return Rotor(*(Compensated(part, np.zeros_like(part)) for part in parts))

    (arguments, state), course = inputs(body), body.course()
    (by_arguments, along), jump = variational.slopes([inputs(one) for one in four], step)
    time, timestep, steps, way, goes_on = body.time, float(course.timestep), 0, adaptive.Way(), True
    if not timestep:
        pace = float(passage.present_pace(arguments[0], course, stop))
        timestep = passage.FIRST_STEP / max(pace, passage.FIRST_STEP / (stop - time))
    while goes_on:
        advanced = adaptive.advance(
            _rate, (arguments, by_arguments), (state, along), time, stop, min(timestep, stop - time),
            body.settings.tolerance, body.settings.tolerance, None, passage.ADAPTIVE_BETWEEN_LOOKS,
        )  # fmt: skip
        goes_on = way.goes_on(time, advanced, stop)
        (state, along), time, timestep = advanced.state, float(advanced.time), float(advanced.timestep)
        steps += int(advanced.steps)
    if bool(advanced.failed):
        raise NumericalError(FAR_TOO_MANY, time=time)
    body.moved(rotor(state), stop, steps, timestep)
    for side, one in zip(variational.SIDES, four, strict=True):
        one.moved(rotor(variational.beside(state, along, side * step)), stop, steps, timestep)
    return jump


def _rate(time: Array, both: tuple, problems: tuple) -> tuple:
    def rate(arguments: tuple) -> Any:
        return rigid.rate(time, *arguments)

    return variational.pushed(rate, (both[0], problems[0]), (both[1], problems[1]))
