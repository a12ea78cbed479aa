"""A star of particles that brakes as a rigid one does: its L(t), and its torque against the formula."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from astroinertia.build.effects import effects_of
from astroinertia.effects import catalogue
from astroinertia.errors import SceneError
from astroinertia.inertia.tensor import axial_vector
from astroinertia.models.sph.step import step
from astroinertia.rotation.braking import Braking
from astroinertia.scene import load
from astroinertia.scene.plan import code_units, plan
from astroinertia.sph.placement import isotropised
from astroinertia.units import SPEED_OF_LIGHT
from tests.ball import ball, state_of

AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
RATE = 1e-6  # so slow that the star keeps its shape over the run
GROWTH = 0.5  # dP/dt over P at that rate


def braked(options: dict[str, Any], steps: int, end: float = 2.0) -> tuple[Any, Any, list[np.ndarray]]:
    """The state at first and at the end, and L at each step, of a ball of one moment that turns differentially."""
    position = isotropised(ball(60), 0.2)
    rates = RATE * (1.0 + 0.5 * np.sin(7.0 * position[:, 0]))
    velocity = np.cross(AXIS, position) * rates[:, None] + [1e-5, 0.0, 0.0]
    problem, first, arrangement = state_of(
        catalogue.build("dipole_braking", options), position=position, velocity=velocity
    )
    state, spins = first, [spin_of(first)]
    for _ in range(steps):
        state = step(problem, arrangement, state, np.float64(end / steps))
        spins.append(spin_of(state))
    return first, state, spins


def spin_of(state: Any) -> np.ndarray:
    x, v = state.position - state.position.mean(axis=0), state.velocity - state.velocity.mean(axis=0)
    return state.mass @ np.cross(x, v)


def inertia_of(state: Any) -> np.ndarray:
    x = state.position - state.position.mean(axis=0)
    return np.eye(3) * (state.mass @ (x**2).sum(axis=1)) - (state.mass[:, None] * x).T @ x


@pytest.mark.parametrize(
    "index",
    [
        pytest.param(1.0, marks=pytest.mark.full),
        pytest.param(2.5, marks=pytest.mark.full),
        3.0,
        pytest.param(5.0, marks=pytest.mark.full),
    ],
)
def test_angular_momentum_falls_as_that_of_a_rigid_body(index: float) -> None:
    """omega^(1-n) grows linearly, to second order in the step; omega keeps its direction in a body of one moment."""
    options = {
        "speed_of_light": 1.0,
        "period": 2.0 * math.pi / RATE,
        "period_derivative": GROWTH * 2.0 * math.pi / RATE,
        "index": index,
    }
    errors = []
    for steps in (10, 20, 40):
        first, last, spins = braked(options, steps)
        before, after = (np.linalg.solve(inertia_of(first), spin) for spin in (spins[0], spins[-1]))
        speed = np.linalg.norm(before)
        exact = Braking(speed, -GROWTH * speed * (speed / RATE) ** (index - 1.0), (index,), (1.0,)).history(
            np.array([0.0, 2.0])
        )[-1]
        # omega falls along itself: every part of it by the same factor.
        errors.append(abs(np.linalg.norm(after) / exact - 1.0))
        assert np.allclose(after / np.linalg.norm(after), before / speed, atol=1e-5)
        given = axial_vector(last.ledger.mixed_impulse.total[0])
        assert np.allclose(given, spins[-1] - spins[0], rtol=0.0, atol=1e-13 * np.abs(spins[0]).max())
    assert all(3.7 < a / b < 4.4 for a, b in itertools.pairwise(errors)), errors
    assert exact < 0.75 * speed


def test_the_torque_of_a_field_is_that_of_a_dipole_and_exerts_no_force() -> None:
    """tau = -(8 pi/3) b^2 R^6/c^3 omega^3, and the rotation law is left as it is."""
    options = {"field": 3e4, "radius": 1.2, "speed_of_light": 0.1}
    first, last, spins = braked(options, 1, 1e-3)
    fluid = first.rates.fluid
    effect = catalogue.build("dipole_braking", options)
    spin = np.linalg.solve(inertia_of(first), spins[0])
    expected = -8.0 * math.pi / 3.0 * 9e8 * 1.2**6 / 1e-3 * (spin @ spin) * spin
    assert np.allclose(axial_vector(effect.virial(np, fluid)), expected, rtol=1e-12, atol=0.0)
    acceleration = effect.acceleration(np, fluid)
    assert np.abs(fluid.mass @ acceleration).max() < 1e-15 * np.abs(acceleration).max()
    # What is taken is a rigid rotation.
    gradient = np.linalg.lstsq(fluid.position - fluid.centre, acceleration, rcond=None)[0]
    assert np.allclose(gradient, -gradient.T, atol=1e-12 * np.abs(gradient).max())
    assert float(last.ledger.work.total[0]) < 0.0


def test_a_body_at_rest_is_not_braked() -> None:
    position = ball(60)
    options = {"speed_of_light": 1.0, "period": 1.0, "period_derivative": 1.0}
    _, state, _ = state_of(catalogue.build("dipole_braking", options), position=position, velocity=0.0 * position)
    assert not state.rates.acceleration[0].any()


def pulsar(options: str, units: str = "") -> Any:
    quantities = ("1.0", "1.0", "6.0", "5.0") if units else ('"1.4 Msun"', '"12 km"', '"33 ms"', '"100 yr"')
    mass, radius, period, end = quantities
    return load.loads(
        f'name = "pulsar"\nmodel = "scaling"\n{units}\n[body]\nkind = "polytrope"\nindex = 1.0\nmass = {mass}\n'
        f"radius = {radius}\nrotation = {{ period = {period} }}\n"
        f"[effects.dipole_braking]\n{options}\n[time]\nend = {end}\n"
    )


def test_a_period_that_grows_needs_no_speed_of_light_and_a_field_does() -> None:
    growing, field, code = "period = 6.0\nperiod_derivative = 0.1", "field = 0.01\nradius = 1.0", 'units = "code"'
    (effect,) = effects_of(scene := pulsar(growing, code), code_units(scene))
    assert effect.speed_of_light is None and "dipole_braking" in plan(scene).text()
    with pytest.raises(SceneError, match=r"dipole_braking\] speed_of_light is missing, which the field"):
        effects_of(scene := pulsar(field, code), code_units(scene))
    (effect,) = effects_of(scene := pulsar(field + "\nspeed_of_light = 9.0", code), code_units(scene))
    assert effect.speed_of_light == 9.0
    (effect,) = effects_of(scene := pulsar('field = "1e12 G"\nradius = "12 km"'), code_units(scene))
    assert code_units(scene).to_si(effect.speed_of_light, "velocity") == pytest.approx(SPEED_OF_LIGHT, rel=1e-15)
