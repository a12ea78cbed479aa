"""Rigid bodies where numbers are hard: needles, discs, moments of 1e12 to 1, the separatrix, rest, blows."""

import jax
import numpy as np
import pytest

from astroinertia.engines import adaptive
from astroinertia.errors import NumericalError
from astroinertia.observables.quantities import RECORDED
from astroinertia.rotation import free_attitude, free_top
from astroinertia.rotation.attitude import quaternion, rotation
from tests.rigid import BEST, attitude, both, effect, momentum, spin, under_way

pytestmark = pytest.mark.usefixtures("float64")

# Where each has a program of its own to compile: the adaptive one in the full tests.
each = pytest.mark.parametrize(
    "settings", [BEST["splitting"], pytest.param(BEST["adaptive"], marks=pytest.mark.full)], ids=BEST
)
TILTED = (0.8, 0.1, -0.5, 0.3)
TINY = 1e-12
# Blows that never come, with which a body under a constant torque shares the program of one that is struck.
NO_BLOWS = {"angular_momentum": [0.0, 0.0, 4.0], "time": 1e6, "frame": "body"}

BODIES = {
    "needle that spins": ([TINY, 1.0, 1.0], [30.0, 0.4, 1.0]),
    "flat needle that spins": ([TINY, 1.0 - 0.7 * TINY, 1.0], [30.0, 0.4, 1.0]),
    "needle that tumbles": ([TINY, 1.0 - 0.7 * TINY, 1.0], [1e-3, 0.4, 1.0]),
    "rod": ([0.0, 1.0, 1.0], [0.0, 0.4, 1.0]),
    "disc": ([1.0, 1.0, 2.0], [0.3, 0.1, 1.0]),
    "disc that is not quite round": ([1.0, 1.0 + TINY, 2.0 + TINY], [0.3, 0.1, 1.0]),
    "ball": ([1.0, 1.0, 1.0], [0.3, 0.1, 1.0]),
    "ball that is not quite round": ([1.0, 1.0 + TINY, 1.0 + 2.0 * TINY], [0.3, 0.1, 1.0]),
    "huge": ([1e40, 2e40, 2.5e40], [3e-9, 2e-9, 4e-9]),
    "tiny": ([1e-40, 2e-40, 2.5e-40], [3e9, 2e9, 4e9]),
}


def pushed(moments, turning, torque, settings, **struck):
    """A body under a constant torque, which is struck where it is said when."""
    blows = effect("impulses", **{**NO_BLOWS, **struck})
    return under_way(moments, turning, effect("constant_torque", vector=torque), blows, settings=settings)


@each
@pytest.mark.parametrize("name", BODIES)
def test_extreme_moments_turn_as_the_closed_form_says(name, settings):
    moments, rates = (np.array(each) for each in BODIES[name])
    top = free_top.free_top(moments, rates)
    end = np.array([10.0 * 2.0 * np.pi / np.linalg.norm(rates)])
    run = under_way(moments, rates, settings=settings)
    run.advance(float(end[0]))
    size = np.linalg.norm(rates)
    # Of m, which is what is known: the rate of a needle about itself is m_1 over next to nothing.
    exact = moments * free_top.angular_velocity(top, end)[0]
    assert np.abs(np.asarray(run.state.momentum_in_body) - exact).max() < 1e-10 * np.linalg.norm(moments * rates)
    assert np.abs(spin(run) - free_top.angular_velocity(top, end)[0]).max() < 1e-9 * size
    assert attitude(run) == pytest.approx(free_attitude.attitude(top, end)[0], abs=1e-9)
    assert momentum(run) == pytest.approx(moments * rates, rel=1e-13, abs=1e-14 * np.linalg.norm(moments * rates))
    record = run.record(None)
    absent = {name for name, quantity in RECORDED.items() if "rigid" in quantity.absent}
    assert all(np.isfinite(value).all() for name, value in record.items() if name not in absent)


@both
def test_a_tilted_needle_keeps_its_own_spin(settings):
    moments, rates = np.array([TINY, 1.0, 1.0]), np.array([30.0, 0.4, 1.0])
    run = under_way(moments, rates, settings=settings, quaternion=TILTED)
    run.advance(20.0)
    assert spin(run)[0] == pytest.approx(30.0, rel=1e-12)


@each
def test_a_spin_is_reversed_through_rest(settings):
    # Against a torque along the spin: L passes zero to round-off, and the body turns the other way.
    run = pushed([1.0, 2.0, 2.5], [0.0, 0.0, 1.0], [0.0, 0.0, -0.5], settings)
    for time, rate in ((5.0, 0.0), (10.0, -1.0)):
        run.advance(time)
        assert spin(run) == pytest.approx([0.0, 0.0, rate], abs=1e-12)
    assert attitude(run)[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-11)  # half of it one way, half the other


@pytest.mark.full
@both
def test_a_wobbling_body_is_braked_through_rest_in_general(settings):
    # L goes from +x to -x while the body tumbles: nothing singular on the way, and both halves account for energy.
    run = pushed([1.0, 1.5, 2.0], [0.9, 0.1, 0.0], [-0.3, -0.05, 0.0], settings)
    start = momentum(run)
    run.advance(6.0)
    assert momentum(run) == pytest.approx(start + 6.0 * np.array([-0.3, -0.05, 0.0]), abs=1e-12)
    assert abs(run.record(0.0)["integration_energy_error"]) < 1e-10


@both
@pytest.mark.parametrize("offset", [1e-8, 1e-12, 0.0])
def test_next_to_the_separatrix_nothing_is_lost_but_the_phase(offset, settings):
    moments, rates = np.array([1.0, 2.0, 3.0]), np.array([offset, 1.0, offset])
    run = under_way(moments, rates, settings=settings)
    energies, seen = [], []
    for k in range(1, 21):
        run.advance(20.0 * k)
        energies.append((moments * spin(run) ** 2).sum() / (moments * rates**2).sum() - 1.0)
        seen.append(spin(run)[1])
    assert np.abs(energies).max() < 1e-13
    assert momentum(run) == pytest.approx(moments * rates, abs=1e-15)
    if offset == 0.0:
        assert seen == pytest.approx([1.0] * 20, abs=1e-15)
    elif offset == 1e-8:
        assert min(seen) < 0.0  # it flips: half a period is 67.4


@pytest.mark.full
@each
def test_a_spin_is_carried_across_the_separatrix_by_blows(settings):
    run = pushed([1.0, 2.0, 3.0], [1.0, 0.3, 0.1], [0.0, 0.0, 0.0], settings, time=7.0)
    about = []
    for k in range(1, 9):
        run.advance(5.0 * k)
        m = np.asarray(run.state.momentum_in_body)
        about.append(3 if (m**2 / [1.0, 2.0, 3.0]).sum() * 2.0 < (m**2).sum() else 1)
        assert abs(run.record(0.0)["integration_energy_error"]) < 1e-11
    assert about[0] == 1 and about[-1] == 3


def assert_stays_as_it_is(settings, *effects):
    run = under_way([1.0, 2.0, 2.5], np.zeros(3), *effects, settings=settings, quaternion=TILTED)
    before = attitude(run)
    run.advance(100.0)
    assert attitude(run) == pytest.approx(before, abs=1e-15) and not momentum(run).any()
    assert run.record(0.0)["kinetic_energy"] == 0.0


@both
def test_a_body_at_rest_stays_as_it_is(settings):
    assert_stays_as_it_is(settings)


@pytest.mark.full
@each
def test_a_body_at_rest_with_effects_of_its_spin_stays_as_it_is(settings):
    brake = effect("dipole_braking", period=1.0, period_derivative=0.1, speed_of_light=1.0)
    assert_stays_as_it_is(settings, effect("internal_dissipation", time_scale=1.0, rate=1.0), brake)


@both
def test_a_torque_sets_a_body_at_rest_in_motion(settings):
    run = pushed([1.0, 2.0, 2.5], np.zeros(3), [0.0, 0.01, 0.0], settings)
    run.advance(10.0)
    assert attitude(run) == pytest.approx(rotation(np.array([0.0, 0.25, 0.0])).T, abs=1e-11)


@pytest.mark.full
@each
def test_a_pendulum_swings_through_the_vertical_from_next_to_it(settings):
    # Upside down but for 1e-6: it takes long, and has all of its energy when it comes down.
    start = quaternion(rotation(np.array([np.pi - 1e-6, 0.0, 0.0])).T)
    hung = effect("pivot", gravity=[0.0, 0.0, -1.0], arm=[0.0, 0.0, -1.0])
    run = under_way([1.0, 1.5, 2.0], np.zeros(3), hung, settings=settings, quaternion=start,
                    arm=np.array([0.0, 0.0, -1.0]))  # fmt: skip
    run.advance(np.log(4.0 / 0.5e-6))  # the quarter period: K(m) = ln(4 / k') at the rate 1
    assert run.record(0.0)["centre_of_mass"] == pytest.approx([0.0, 0.0, -1.0], abs=1e-4)
    assert spin(run)[0] ** 2 == pytest.approx(4.0, rel=1e-7)


def test_a_spin_beyond_all_steps_is_refused():
    run = under_way([1.0, 2.0, 2.5], [1e9, 0.0, 0.0], effect("constant_torque", vector=[0.0, 0.0, 1.0]))
    with pytest.raises(NumericalError, match="the body turns so fast that"):
        run.advance(1e9)


def test_a_runaway_torque_is_said_to_fail():
    # A braking index below 1 stops the body in a finite time, where its torque is not smooth.
    brake = effect("dipole_braking", period=1.0, period_derivative=0.5, index=-4.0, speed_of_light=1.0)
    run = under_way([1.0, 1.0, 1.2], [0.0, 0.0, 2.0 * np.pi], brake, settings=BEST["adaptive"])
    with pytest.raises(NumericalError):
        run.advance(100.0)


@pytest.mark.full
def test_a_body_that_turns_too_often_for_the_adaptive_integrator_gets_advice_what_to_take(monkeypatch):
    monkeypatch.setattr(adaptive, "MOST_STEPS", 200)
    jax.clear_caches()
    run = under_way([1.0, 2.0, 3.0], [0.1, 1.0, 0.1], settings=BEST["adaptive"])
    try:
        with pytest.raises(NumericalError, match=r"do not reach the next record: .*splitting, or the model scaling"):
            run.advance(1e4)
    finally:
        jax.clear_caches()
