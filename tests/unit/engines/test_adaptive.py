"""The library's integrator as this package calls it: accuracy, stopping, failing, going on."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.engines import adaptive

pytestmark = pytest.mark.usefixtures("float64")


def oscillator(time, state, stiffness):
    place, speed = state
    return speed, -stiffness * place


def blow_up(time, state, _):
    return state**2


def below_a_tenth(time, state, _):
    return state[0] < 0.1


def start():
    return jnp.array(1.0), jnp.array(0.0)


@pytest.mark.slow
def test_a_hundred_periods_to_the_tolerance():
    end = 200.0 * np.pi
    found = adaptive.advance(oscillator, 1.0, start(), 0.0, end, 0.1)
    assert abs(float(found.state[0]) - 1.0) < 1e-10 and abs(float(found.state[1])) < 1e-10
    assert float(found.time) == end and not found.failed and not found.stopped
    coarse = adaptive.advance(oscillator, 1.0, start(), 0.0, end, 0.1, 1e-6, 1e-6)
    assert coarse.steps < 0.5 * found.steps


@pytest.mark.full
def test_two_calls_go_on_as_one_problem():
    half = adaptive.advance(oscillator, 4.0, start(), 0.0, 3.0, 0.1)
    whole = adaptive.advance(oscillator, 4.0, half.state, half.time, 7.0, half.timestep)
    assert float(whole.state[0]) == pytest.approx(np.cos(14.0), abs=1e-11)
    assert 3.0 / float(half.timestep) == pytest.approx(float(half.steps), rel=0.5)


def test_a_first_step_that_misses_the_end_by_a_rounding_takes_it():
    found = adaptive.advance(oscillator, 0.0, (jnp.array(1.0), jnp.array(2.0)), 0.03, 0.04, 0.01 - 2e-18)
    assert not found.failed and float(found.time) == 0.04 and int(found.steps) == 1
    assert float(found.state[0]) == pytest.approx(1.02, rel=1e-15)


@pytest.mark.full
def test_a_condition_ends_it_with_the_step():
    found = adaptive.advance(oscillator, 1.0, start(), 0.0, 10.0, 0.1, condition=below_a_tenth)
    assert bool(found.stopped) and not found.failed
    assert np.arccos(0.1) < float(found.time) < np.arccos(0.1) + 1.0
    assert float(found.state[0]) == pytest.approx(np.cos(float(found.time)), abs=1e-12)


@pytest.mark.slow
def test_so_many_steps_end_it_and_the_next_call_goes_on():
    whole = adaptive.advance(oscillator, 1.0, start(), 0.0, 10.0, 0.1)
    needed = int(whole.steps)
    part = adaptive.advance(oscillator, 1.0, start(), 0.0, 10.0, 0.1, most=needed - 1)
    assert int(part.steps) == needed - 1 and part.unfinished and part.failed and 0.0 < float(part.time) < 10.0
    just = adaptive.advance(oscillator, 1.0, start(), 0.0, 10.0, 0.1, most=needed)
    assert int(just.steps) == needed and not (just.unfinished or just.failed) and float(just.time) == 10.0
    rest = adaptive.advance(oscillator, 1.0, part.state, part.time, 10.0, 10.0 - part.time)
    assert float(rest.state[0]) == pytest.approx(np.cos(10.0), abs=1e-12)


@pytest.mark.slow
def test_a_singularity_is_said_to_fail():
    found = adaptive.advance(blow_up, None, jnp.array(1.0), 0.0, 2.0, 0.1)  # 1 / (1 - t)
    assert bool(found.failed) and float(found.time) < 1.0 + 1e-9


def test_no_compiled_program_calls_python_so_that_jax_can_keep_it():
    """JAX leaves programs with such calls out of its cache on disk: each process compiled for five seconds."""
    made = jax.make_jaxpr(adaptive.advance, static_argnums=(0, 8))
    for condition in (None, below_a_tenth):
        program = str(made(oscillator, 1.0, start(), 0.0, 1.0, 0.1, 1e-6, 1e-6, condition))
        assert "while" in program and "callback" not in program


def test_time_may_run_backward():
    found = adaptive.advance(oscillator, 1.0, start(), 0.0, -1.0, -0.1)
    assert abs(float(found.state[0]) - np.cos(1.0)) < 1e-12 and abs(float(found.state[1]) - np.sin(1.0)) < 1e-12
