"""Many records in one call: the same bits as one by one, wherever a call begins, and few calls a run."""

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import astroinertia
from astroinertia.engines.pytree import pytree
from astroinertia.errors import NumericalError
from astroinertia.models.rigid.evolution import RigidBody, Settings
from astroinertia.models.rigid.passage import AT_ONCE
from tests.rigid import ADAPTIVE, BEST, SPLITTING, effect, under_way
from tests.sims import SIMS

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("float64")]  # slow: each combination of effects is compiled

TOP, SPIN = [1.0, 2.0, 3.0], [0.5, 0.2, 1.0]
TIMES = 0.3 * np.arange(1, 31)


def settling(settings):
    blows = effect("impulses", angular_momentum=[0.3, 0.0, 0.0], time=6.05, every=20.0)
    return under_way(TOP, SPIN, blows, effect("internal_dissipation", time_scale=30.0), settings=settings)


def same(left, right):
    assert len(left) == len(right)
    for one, other in zip(left, right, strict=True):
        assert list(one) == list(other)
        assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


@pytest.mark.parametrize(
    "settings", [BEST["splitting"], pytest.param(BEST["adaptive"], marks=pytest.mark.full)], ids=BEST
)
def test_records_are_those_of_one_call_each_wherever_calls_begin(settings):
    single, several, resumed = (settling(settings) for _ in range(3))
    expected = []
    for time in TIMES[:20]:
        single.advance(time)
        expected.append(single.record(0.0))
    rows = several.through(TIMES[:20], 0.0, np.inf)
    same(rows, expected)
    parts = resumed.through(TIMES[:7], 0.0, np.inf)
    again = settling(settings)
    again.resume(resumed.arrays())
    same(parts + again.through(TIMES[7:20], 0.0, np.inf), expected)


def test_errors_of_the_adaptive_integrator_do_not_wait_for_a_record():
    # Between looks the axis in the body errs by itself: over 4000 steps by 15 times what looks leave.
    def turned(tolerance, records):
        body = under_way(
            TOP,
            SPIN,
            effect("internal_dissipation", time_scale=3000.0),
            settings=Settings("adaptive", tolerance=tolerance),
        )
        for time in np.linspace(0.0, 2000.0, records + 1)[1:]:
            body.advance(time)
        return body.state.turning.total

    exact = turned(1e-13, 100)
    once, often = (np.abs(turned(1e-9, records) - exact).max() for records in (1, 100))
    assert 1e-7 < often < once < 6 * often


@pytree
@dataclass(frozen=True, eq=False)
class Circling:
    """A companion on a circle, which counts how often it is looked up."""

    mass: np.ndarray
    asked: list = field(metadata={"static": True})

    def position(self, time):
        jax.debug.callback(lambda _: self.asked.append("position"), time)
        return 20.0 * jnp.stack([jnp.cos(time), jnp.sin(time), 0.0 * time], -1)[..., None, :]

    def velocity(self, time):
        jax.debug.callback(lambda _: self.asked.append("velocity"), time)
        return 20.0 * jnp.stack([-jnp.sin(time), jnp.cos(time), 0.0 * time], -1)[..., None, :]


def test_companions_are_looked_up_once_a_step_of_the_splitting():
    """By two torques, one of which follows the spin, so that each of a step's kicks has seven stages."""
    moon = Circling(np.array([0.1]), [])
    tide = effect("tidal_torque", love_number=0.3, radius=1.0, time_lag=0.01)
    body = under_way(TOP, SPIN, effect("gravity_gradient"), tide, companions=moon)
    moon.asked.clear()
    body.advance(5.0)
    jax.effects_barrier()
    assert body.steps > 40
    assert len(moon.asked) < 2 * (body.steps + 10)


def test_an_impulse_is_left_to_advance():
    run = settling(SPLITTING)
    rows = run.through(TIMES, 0.0, np.inf)
    assert [row["time"] for row in rows] == pytest.approx(TIMES[:20], abs=0.0)
    assert run.through(TIMES[20:], 0.0, np.inf) == []
    run.advance(TIMES[20])
    assert run.record(0.0)["work"][0] != 0.0
    assert len(run.through(TIMES[21:], 0.0, np.inf)) == 9


def test_no_more_steps_are_taken_than_may_be():
    run = settling(SPLITTING)
    steps = [row["step"] for row in run.through(TIMES, 0.0, 50)]
    assert steps[-1] < 50 == run.steps


@pytest.mark.full
def test_what_was_met_before_the_motion_cannot_go_on_is_kept():
    brake = effect("dipole_braking", period=1.0, period_derivative=0.5, index=-4.0, speed_of_light=1.0)
    run = under_way([1.0, 1.0, 1.2], [0.0, 0.0, 2.0 * np.pi], brake, settings=ADAPTIVE)
    times = 0.05 * np.arange(1, 200)
    rows = run.through(times, 0.0, np.inf)
    with pytest.raises(NumericalError) as error:
        run.through(times[len(rows) :], 0.0, np.inf)
    assert 0 < len(rows) < len(times)
    assert all(np.isfinite(row["kinetic_energy"]) for row in rows)
    assert rows[-1]["time"] < error.value.time <= times[len(rows)]


@pytest.mark.full(inputs=["sims/asteroid_settles.toml"])
def test_a_run_of_five_hundred_records_takes_a_few_calls(tmp_path, monkeypatch):
    """The steps of a year of hourly records (tests/benchmarks/rigid_records.py), fewer of them."""
    calls = []

    def counted(name):
        method = getattr(RigidBody, name)

        def call(body, *arguments):
            calls.append(name)
            return method(body, *arguments)

        monkeypatch.setattr(RigidBody, name, call)

    for name in ("through", "advance", "_ledgers"):
        counted(name)
    scene = astroinertia.load(SIMS / "asteroid_settles.toml", ["time.end=500 h", "output.series_every=1 h"])
    ds = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    assert ds.time.values == pytest.approx(3600.0 * np.arange(501), rel=1e-14)
    assert calls.count("advance") == 0
    assert calls.count("through") == -(-500 // AT_ONCE)
    assert calls.count("_ledgers") <= calls.count("through") + 2  # at the start
    assert abs(ds.integration_energy_error.values).max() < 1e-12 * ds.kinetic_energy.values[0]
