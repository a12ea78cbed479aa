"""Rigid motion by both integrators against the closed forms of the free body and of the heavy top."""

import json
from pathlib import Path

import numpy as np
import pytest

from astroinertia.inertia.prescribed import change
from astroinertia.models.rigid.evolution import Settings
from astroinertia.rotation import free_attitude, free_top, heavy_top
from astroinertia.rotation.attitude import quaternion
from tests.rigid import BEST, attitude, both, effect, momentum, spin, under_way

pytestmark = pytest.mark.usefixtures("float64")

TOPS = [
    entry for entry in json.loads((Path(__file__).parent.parent / "reference" / "free_top.json").read_text())
    if entry["name"] == "asymmetric_top"
]  # fmt: skip
PERIODS = 100.0


def numbers(entry):
    return tuple(np.array([float(each) for each in entry["inputs"][name]]) for name in ("I", "omega0"))


def far_from_the_separatrix(entry):
    moments, rates = numbers(entry)
    return min(abs(rates)) >= 0.1 or abs(moments[1] - moments[0]) < 1e-3


def after(moments, rates, settings, periods=PERIODS):
    """A run after so many of its periods, and the exact angular velocity and attitude then."""
    top = free_top.free_top(moments, rates)
    end = np.array([periods * free_top.period(top)])
    run = under_way(moments, rates, settings=settings)
    run.advance(float(end[0]))
    return run, free_top.angular_velocity(top, end)[0], free_attitude.attitude(top, end)[0]


def kept(run, moments, rates):
    """The largest relative error of energy and of L, recomputed from attitude, moments and rates."""
    found = spin(run)
    energy = (moments * found**2).sum() / (moments * rates**2).sum() - 1.0
    lost = attitude(run).T @ (moments * found) - moments * rates
    return max(abs(energy), np.abs(lost).max() / np.linalg.norm(moments * rates))


# One top that comes near the separatrix, and those that do not; the adaptive integrator on every other. All: test-full.
NEAR = (1, 2, 3, 6)
SOME = [
    pytest.param(
        entry, settings, id=f"{entry['inputs']['I']}{entry['inputs']['omega0']}-{name}",
        marks=pytest.mark.full if number in NEAR or (name == "adaptive" and number % 2) else (),
    )
    for number, entry in enumerate(TOPS)
    for name, settings in BEST.items()
]  # fmt: skip


@pytest.mark.parametrize(("entry", "settings"), SOME)
def test_a_hundred_periods(entry, settings):
    moments, rates = numbers(entry)
    run, exact, turned = after(moments, rates, settings)
    size = np.abs(rates).max()
    error = max(np.abs(spin(run) - exact).max() / size, np.abs(attitude(run) - turned).max())
    assert kept(run, moments, rates) < 1e-12
    if far_from_the_separatrix(entry):
        assert error < 1e-10
        return
    # Nearer to it round-off grows: no step is more wrong than steps differ among themselves.
    steps = [40.0, 50.0, 70.0, 90.0] if settings.integrator == "splitting" else [3e-14, 1e-13, 2e-13, 4e-13]
    name = "steps_per_rotation" if settings.integrator == "splitting" else "tolerance"
    others = [after(moments, rates, Settings(settings.integrator, order=8, **{name: step}))[0] for step in steps]
    spread = max(np.abs(spin(one) - spin(other)).max() for one in (run, *others) for other in others) / size
    assert np.abs(spin(run) - exact).max() / size < 10.0 * max(spread, 1e-12)


@pytest.mark.full
@both
@pytest.mark.parametrize(
    ("tilt", "rates"),
    [(0.6, [0.0, 0.0, 6.0]), (1.2, [0.3, 0.7, 4.0]), (2.0, [0.0, -0.5, 0.0]), (0.3, [0.1, 0.0, -8.0])],
)
def test_the_heavy_top_nods_and_precesses_as_its_closed_form_says(tilt, rates, settings):
    # Body axes: the line of nodes, across it, and the top's own. Moments about the point: 2, 2 and 0.5.
    top = heavy_top.heavy_top(2.0, 0.5, 3.0 * 0.4, tilt, rates)
    times = np.array([2.0, 30.0])
    exact = heavy_top.attitude(top, times)
    axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # ascending moments: the top's own axis first
    start = heavy_top.attitude(top, np.array([0.0]))[0]
    pull = effect("pivot", gravity=[0.0, 0.0, -0.4], arm=[0.0, 0.0, 1.0])
    run = under_way([0.5, 2.0, 2.0], axes @ np.array(rates), pull, settings=settings, mass=3.0,
                    quaternion=quaternion(axes @ start), axes=axes.T, arm=axes @ [0.0, 0.0, 1.0])  # fmt: skip
    opening = run.record(None)["total_energy"]
    for time, expected in zip(times, exact, strict=True):
        run.advance(float(time))
        record = run.record(0.0)
        assert record["attitude"] == pytest.approx(expected, abs=1e-9)
        assert record["total_energy"] == pytest.approx(opening, abs=1e-11 * abs(opening) + 1e-11)
        assert abs(record["integration_energy_error"]) < 1e-11 * record["kinetic_energy"] + 1e-11


@pytest.mark.full
def test_both_integrators_agree_where_all_acts_at_once():
    acts = (
        effect("constant_torque", vector=[0.05, 0.0, 0.02], begin=1.0, until=4.0),
        effect("impulses", angular_momentum=[0.0, 0.3, 0.0], time=2.5, frame="body"),
        effect("dipole_braking", period=3.0, period_derivative=0.02, index=2.7, speed_of_light=1.0),
        effect("internal_dissipation", time_scale=8.0, rate=1.0),
    )
    runs = [
        under_way([1.0, 1.8, 2.4], [0.6, 0.4, 0.9], *acts, settings=settings, change=change([2.0, 6.0], [1.4, 0.5]))
        for settings in BEST.values()
    ]
    for time in (1.7, 3.0, 9.0):
        for run in runs:
            run.advance(time)
        assert momentum(runs[0]) == pytest.approx(momentum(runs[1]), abs=1e-11)
        assert attitude(runs[0]) == pytest.approx(attitude(runs[1]), abs=3e-11)
        records = [run.record(0.0) for run in runs]
        assert records[0]["work"] == pytest.approx(records[1]["work"], abs=3e-11)
        assert max(abs(record["integration_energy_error"]) for record in records) < 3e-11


@pytest.mark.full
@pytest.mark.parametrize("order", [4, 6])
def test_the_order_of_the_splitting_holds_with_all_kinds_of_torques(order):
    acts = (
        effect("constant_torque", vector=[0.05, 0.0, 0.2], frame="body"),
        effect("dipole_braking", period=3.0, period_derivative=0.02, speed_of_light=1.0),
        effect("internal_dissipation", time_scale=8.0),
    )
    found = []
    for steps in (8.0, 16.0, 128.0):
        settings = Settings("splitting", order=order, steps_per_rotation=steps)
        run = under_way([1.0, 1.8, 2.4], [0.6, 0.4, 0.9], *acts, settings=settings, change=change([8.0], [0.6]))
        run.advance(8.0)
        found.append(np.concatenate([spin(run), attitude(run).ravel(), run.record(0.0)["work"]]))
    errors = [np.abs(one - found[-1]).max() for one in found[:-1]]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.8)
