"""The splitting of rigid rotation: orders, invariants, round-off, and what torques and a change of size do to it."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.models.rigid import splitting
from astroinertia.models.rigid.splitting import Kick, advance, in_body, in_space, rotor, turning_rates
from astroinertia.rotation import free_top

pytestmark = pytest.mark.usefixtures("float64")

MOMENTS, SPIN = np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.2, 1.0])


def start(moments=MOMENTS, spin=SPIN, sums=()):
    return rotor([1.0, 0.0, 0.0, 0.0], moments * spin, sums)


def run(end, steps, order, moments=MOMENTS, spin=SPIN):
    return advance(start(moments, spin), turning_rates(moments), 0.0, end, steps, order)


def energy(state, moments=MOMENTS):
    return 0.5 * float(np.sum(np.asarray(state.momentum_in_body) ** 2 / moments))


@pytest.mark.slow
@pytest.mark.parametrize(
    "order", [pytest.param(2, marks=pytest.mark.full), 4, pytest.param(6, marks=pytest.mark.full), 8]
)
def test_each_composition_has_its_order(order):
    exact = free_top.angular_velocity(free_top.free_top(MOMENTS, SPIN), np.array([10.0]))[0]
    steps = {2: 100, 4: 50, 6: 30, 8: 30}[order]
    errors = [
        np.abs(np.asarray(run(10.0, n, order).momentum_in_body) / MOMENTS - exact).max() for n in (steps, 2 * steps)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)
    assert errors[1] < {2: 1e-2, 4: 1e-4, 6: 1e-6, 8: 1e-8}[order]


def test_round_off_is_put_right_and_energy_does_not_drift():
    state, rates = start(), turning_rates(MOMENTS)
    opening, errors = energy(state), []
    for k in range(8):
        state = advance(state, rates, 100.0 * k, 100.0 * (k + 1), 600, 8)
        errors.append(energy(state) / opening - 1.0)
        assert float(jnp.sum(state.quaternion**2)) == pytest.approx(1.0, abs=1e-15)
        again = in_space(state.quaternion, state.momentum_in_body)
        assert np.asarray(again) == pytest.approx(MOMENTS * SPIN, abs=3e-15)
    assert np.abs(errors).max() < 1e-13


@pytest.mark.slow
@pytest.mark.parametrize("moments", [[1.0, 1.0, 1.7], [0.3, 1.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
def test_a_symmetric_top_is_exact_in_one_step(moments):
    moments = np.array(moments)
    spin = SPIN * (moments > 0)
    state = run(1000.0, 1, 2, moments, spin)
    exact = free_top.angular_velocity(free_top.free_top(moments, spin), np.array([1000.0]))[0]
    assert np.asarray(state.momentum_in_body) == pytest.approx(moments * exact, abs=1e-12)


def test_a_needle_keeps_the_digits_of_its_own_spin():
    moments, spin = np.array([1e-12, 1.0, 1.0 + 4e-13]), np.array([5.0, 0.3, 1.0])
    state = run(20.0, 2000, 6, moments, spin)
    exact = free_top.angular_velocity(free_top.free_top(moments, spin), np.array([20.0]))[0]
    assert np.asarray(state.momentum_in_body) / moments == pytest.approx(exact, rel=1e-11)


@pytest.mark.full
def test_the_order_holds_with_torques_and_sums():
    # A torque of fixed direction in space, and energy gained from it.
    rates, torque = turning_rates(MOMENTS), np.array([0.3, -0.1, 0.2])
    runs = [advance(start(sums=[0.0]), rates, 0.0, 8.0, n, 6, torque, pushed) for n in (40, 80, 640)]
    errors = [np.abs(np.asarray(r.momentum_in_body - runs[-1].momentum_in_body)).max() for r in runs[:-1]]
    assert 45 < errors[0] / errors[1] < 100
    assert np.asarray(runs[0].angular_momentum.value) == pytest.approx(MOMENTS * SPIN + 8.0 * torque, abs=1e-14)
    gained = energy(runs[-1]) - energy(start())
    assert float(runs[-1].sums.value[0]) == pytest.approx(gained, abs=1e-12)


def pushed(torque, time, state, interval, known):
    impulse = interval * torque
    gain = in_body(state.quaternion, impulse)
    rate = (state.momentum_in_body + 0.5 * gain) / MOMENTS
    turning = jnp.concatenate([jnp.zeros(4), gain])
    return Kick(impulse, turning, jnp.sum(rate * gain)[None])


@pytest.mark.slow
@pytest.mark.parametrize("end", [2.0, -2.0])
@pytest.mark.parametrize("order", [2, 8])
def test_a_kick_is_given_what_is_known_of_its_time(order, end):
    """Asked for eighteen kicks at once, and none beyond the end; forwards and back."""
    steps, asked = 13, []

    def known(_, times):
        jax.debug.callback(asked.append, times)
        return times**2

    opening = start(sums=[0.0, 0.0])
    state = advance(opening, turning_rates(MOMENTS), 0.0, end, steps, order, kick=noted, known=known)
    missed, length = np.asarray(state.sums.value)
    jax.effects_barrier()
    assert missed < 1e-12 and length == pytest.approx(end)
    assert len(asked) == math.ceil((1 + steps * len(splitting.COMPOSITIONS[order])) / 18)
    assert np.abs(asked).max() == abs(end) and (np.multiply(asked, np.sign(end)) >= 0.0).all()


def noted(_, time, state, interval, known):
    return Kick(jnp.zeros(3), jnp.zeros(7), jnp.stack([jnp.abs(known - time**2), interval]))


@pytest.mark.slow
def test_with_a_prescribed_size_time_runs_at_another_rate():
    # I = I_0 exp(t): the motion at t is that of constant size at 1 - exp(-t).
    opening = energy(start())
    state = advance(start(sums=[opening, 0.0]), turning_rates(MOMENTS), 0.0, 2.0, 40, 8, jnp.array(1.0), size=growing)
    exact = free_top.angular_velocity(free_top.free_top(MOMENTS, SPIN), np.array([1.0 - np.exp(-2.0)]))[0]
    assert np.asarray(state.momentum_in_body) == pytest.approx(MOMENTS * exact, abs=1e-13)
    assert float(state.sums.value[1]) == pytest.approx(opening * (np.exp(-2.0) - 1.0), abs=1e-14)


def growing(rate, time):
    return jnp.exp(rate * time)


def test_a_body_at_rest_stays_at_rest():
    state = run(10.0, 10, 6, spin=np.zeros(3))
    assert np.asarray(state.turning.value).tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_the_stages_of_a_step_stay_within_it():
    # Tables of orbits end with the run.
    for stages in splitting.COMPOSITIONS.values():
        reached = np.cumsum(stages)
        assert reached.min() > 0.0 and reached.max() < 1.0 + 1e-15 and reached[-1] == pytest.approx(1.0, abs=1e-15)
