"""Shells that fall together: at rest in balance, cold in the free-fall time, cores to the bounces of finer methods."""

import math
import tomllib

import numpy as np
import pytest

from astroinertia.costs import course, shells
from astroinertia.costs.shells import Shells, followed, in_balance
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.storage.data_tables import data_path
from tests.sims import SIMS

RADIUS = (np.arange(1, 41) / 40) ** (1 / 3)  # of shells of one mass each, of a uniform sphere
AT_REST = Shells(1 / 40, RADIUS, in_balance(1 / 40, RADIUS), 5 / 3, None, 5 / 3, np.zeros(40))


def test_shells_in_balance_stay():
    moments = followed(AT_REST, 3.0)
    assert moments[-1].time == 3.0
    np.testing.assert_allclose(moments[-1].density, moments[0].density, rtol=1e-9)


def test_a_cold_sphere_falls_in_the_free_fall_time():
    cold = Shells(1 / 40, RADIUS, 1e-6 * AT_REST.pressure, 5 / 3, None, 5 / 3, np.zeros(40))
    density = 3 / (4 * math.pi)
    moments = followed(cold, 0.99 * math.sqrt(3 * math.pi / (32 * density)))
    assert moments[-1].density[:30].min() > 50 * density
    half = next(moment for moment in moments if moment.density[20] > 8 * density)  # at half the radius
    expected = (1 / 2 + math.pi / 4) * math.sqrt(1 / 2)  # of a'' = -1/a^2 from rest
    assert half.time == pytest.approx(expected, rel=0.03)


def test_angular_momentum_holds_up_what_turns():
    turning = Shells(1 / 40, RADIUS, 1e-6 * AT_REST.pressure, 5 / 3, None, 5 / 3, RADIUS**4)
    np.testing.assert_allclose(followed(turning, 1.0)[-1].density, 3 / (4 * math.pi), rtol=1e-3)


@pytest.mark.parametrize("name", ["pulsar_collapse", "core_collapse"])
def test_cores_bounce_when_grids_say(name):
    """Grids of our own, in two dimensions (data/references.toml): the time to 6 %, the density to a fifth."""
    scene = load.load_file(SIMS / f"{name}.toml")
    units = code_units(scene)
    moments = followed(course._shells(scene, course.sphere_of(scene)), float(units.to_code(scene.time.end, "time")))
    greatest = np.array([moment.density.max() for moment in moments])
    values = tomllib.loads(data_path("references.toml").read_text())[name]["values"]
    converged = {value["name"]: value["value"] for value in values}
    first = int(greatest.argmax())
    assert moments[first].time * units.time == pytest.approx(converged["time of bounce"], rel=0.06)
    assert greatest[first] * units.unit("density") == pytest.approx(converged["density at bounce"], rel=0.2)


def test_the_demo_takes_as_many_steps_as_are_predicted():
    """1286 steps of 3000 particles, as its run took (guide/performance.md)."""
    steps = course.steps(load.load_file(SIMS / "pulsar_collapse.toml"))
    assert steps is not None
    assert 1286 / 1.5 < steps[-1] < 1286 * 1.5
    assert steps[-1] > 1.3 * course.steps(load.load_file(SIMS / "pulsar_collapse.toml", ["body.particles=1000"]))[-1]


def test_what_takes_too_many_steps_has_no_end(monkeypatch):
    monkeypatch.setattr(shells, "MOST_STEPS", 30)
    assert course.steps(load.load_file(SIMS / "pulsar_collapse.toml")) is None


def test_base_steps_of_individual_steps_are_those_of_free_fall():
    def base(*settings):
        return course.base_steps(load.load_file(SIMS / "core_collapse.toml", settings))

    whole = base()
    assert base("numerics.free_fall_factor=0.2") == pytest.approx(0.5 * whole, rel=1e-2)
    assert base("body.particles=8000") == pytest.approx(whole, rel=1e-2)
    assert whole > 100
