"""Processor time of runs on the machine that the package's figures are of."""

import pytest

from astroinertia.costs import machine, reference
from astroinertia.costs.machine import Machine
from astroinertia.costs.prediction import AGAIN, counted, predict
from astroinertia.process.stopwatch import total
from astroinertia.scene import load
from tests.unit.costs.test_costs import STAR

pytestmark = pytest.mark.usefixtures("own_cache")


def star(*settings):
    return load.loads(STAR, settings)


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_a_run_takes_what_is_predicted_of_it_but_for_compiling_and_writing(timesteps):
    scene = star(f"numerics.timesteps='{timesteps}'", "output.align=false")
    counts = counted(scene)
    taken = reference.of_particles(scene, 1000.0 * counts.evaluations, counts, alone=True)
    prediction = predict(scene, machine.shipped())
    parts = total(cost for name, cost in prediction.parts.items() if name not in ("compiling", "writing"))
    assert taken == pytest.approx(parts.processor, rel=1e-12)


def test_settling_and_the_start_are_counted_once():
    scene = star()
    counts = reference.estimated(scene)
    alone = reference.of_particles(scene, 1e6, counts, alone=True)
    first = reference.of_particles(scene, 1e6, counts)
    again = reference.of_particles(scene, 1e6, counts, placed=True)
    parts = predict(scene, machine.shipped()).parts
    start = machine.shipped().seconds
    assert first - again == pytest.approx(
        sum(parts[name].processor for name in ("placing", "settling") if name in parts)
    )
    assert first - again > 0.5  # seconds of a thousand particles that settle
    assert alone - first == pytest.approx((start["prepare.sph"] + (1.0 - AGAIN) * start["start"]).processor, rel=1e-9)


def test_an_evaluation_of_few_particles_takes_longer():
    few, many = star("body.particles=110"), star("body.particles=1000")
    counts = reference.estimated(few)
    per_particle = [
        reference.of_particles(scene, 2e8, counts, placed=True) / reference.of_particles(many, 2e8, counts, placed=True)
        for scene in (few, many)
    ]
    assert per_particle[0] > 2.0 and per_particle[1] == 1.0


def test_a_calibration_changes_nothing(monkeypatch):
    """Or other settings would be chosen elsewhere."""
    scene = star()
    before = reference.of_particles(scene, 1e6, reference.estimated(scene))
    costs = {name: 3.0 * cost for name, cost in machine.shipped().seconds.items()}
    monkeypatch.setattr(machine, "current", lambda: Machine(costs, machine.shipped().memory, True, {}))
    assert reference.of_particles(scene, 1e6, reference.estimated(scene)) == before


def test_models_without_particles_compile_once_for_all_runs():
    scene = star("model='ellipsoid'")
    one, four = (reference.without_particles(scene, runs) for runs in (1, 4))
    compiling = machine.shipped().seconds["prepare.ellipsoid"].processor
    assert four - one == pytest.approx(3.0 * (one - compiling))
    assert one > compiling > 4.0
