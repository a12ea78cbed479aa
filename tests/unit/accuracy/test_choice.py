"""The choice of settings for an accuracy, with runs whose errors and times are known formulas.

That it holds on real ones is shown by tests/benchmarks/delivered.py, whose table is committed.
"""

import math
import re

import numpy as np
import pytest

import astroinertia
from astroinertia.accuracy import choice, measuring
from astroinertia.accuracy.measuring import Measured
from astroinertia.errors import SceneError
from astroinertia.scene import load
from tests.tradeoff_scenes import SIMS, TOY_STAR

QUIET = ("body.particles=600", "time.end=3.0")
TOP = """
name = "top"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 1.3, 1.7]
[body.rotation]
rate = 1.0
axis = [0.3, 1.0, 0.2]
[effects]
[numerics]
integrator = "splitting"
[time]
end = 10.0
"""


class Formula:
    """Runs that err as prescribed: resolution R h^2, time steps S f^2, splitting (c/n)^order, other models M."""

    def __init__(self, resolution=1.0, steps=1e-3, coarse=3.0, models=None, seconds=1e-4):
        self.resolution, self.steps, self.coarse, self.seconds = resolution, steps, coarse, seconds
        self.models = models or {}
        self.runs = []

    def error(self, scene):
        if scene.model == "rigid":
            numerics = scene.numerics
            if numerics.integrator == "adaptive":
                return numerics.tolerance, 0.05
            error = (self.coarse / numerics.steps_per_rotation) ** numerics.order
            return error, 1e-5 * numerics.steps_per_rotation * numerics.order**1.5
        if scene.model != "sph":
            return self.models[scene.model], 1e-3
        count, factor = scene.body.particles, scene.numerics.courant / 0.3
        return self.resolution * count ** (-2 / 3) + self.steps * factor**2, self.seconds * count ** (4 / 3) / factor

    def __call__(self, scene, observables, folder, listener=None):
        error, seconds = self.error(scene)
        self.runs.append(scene)
        values = {each.name: [1.0 + error] for each in observables}
        return Measured(values, {}, seconds, seconds, seconds, 0.0, 0.0, 1)


@pytest.fixture
def runs(monkeypatch):
    def use(formula):
        monkeypatch.setattr(measuring, "measure", formula)
        monkeypatch.setattr(measuring, "stored", lambda folder, observables: None)
        return formula

    return use


def particles(accuracy, *more):
    return load.loads(TOY_STAR, (*QUIET, f"accuracy={accuracy}", *more))


@pytest.mark.parametrize("accuracy", [3e-2, 3e-3, 1e-3])
def test_particles_have_the_accuracy_and_not_much_more(runs, tmp_path, accuracy):
    formula = runs(Formula())
    found = choice.choose(particles(accuracy, "model='sph'"), tmp_path)
    error, seconds = formula.error(found.scene)
    assert error <= accuracy
    # The cheapest pair of a fine scan, with the whole accuracy as its error.
    scan = [
        formula.seconds * n ** (4 / 3) / f
        for f in (0.5, 1.0, 1.5, 2.0)
        for n in np.geomspace(250, 1e6, 2000)
        if formula.resolution * n ** (-2 / 3) + formula.steps * f**2 <= accuracy
    ]
    assert seconds <= 2.5 * min(scan)
    assert found.scene.settings == "given" and not found.scene.wants_choice
    assert max(scene.body.particles for scene in formula.runs) <= max(found.scene.body.particles, 1000)


def test_the_number_of_particles_need_not_be_written(runs, tmp_path):
    runs(Formula())
    text = re.sub(r"^particles = .*\n", "", TOY_STAR, flags=re.MULTILINE)
    chosen = choice.choose(load.loads(text, ("time.end=3.0", "accuracy=3e-3", "model='sph'")), tmp_path / "without")
    assert chosen.scene.body == choice.choose(particles(3e-3, "model='sph'"), tmp_path / "with").scene.body
    with pytest.raises(SceneError, match="particles is missing"):
        load.loads(text, ("accuracy=3e-3", "settings='given'"))


def test_a_table_has_its_own_number_which_a_plan_says(tmp_path):
    (tmp_path / "gas.csv").write_text("mass,x,y,z\n")
    gas = re.sub(
        r"(?s)\[body\].*?\n(?=\[)", '[body]\nkind = "table"\nfile = "gas.csv"\nentropy = 1.0\n', TOY_STAR, count=1
    )
    assert load.loads(gas, ("accuracy=3e-3", "settings='given'"), str(tmp_path)).particles is None
    with pytest.raises(SceneError, match="a table has its own: write settings"):
        load.loads(gas, ("accuracy=3e-3",), str(tmp_path))


def test_the_reported_errors_are_the_actual_ones(runs, tmp_path):
    formula = runs(Formula())
    found = choice.choose(particles(3e-3, "model='sph'"), tmp_path)
    factor = found.scene.numerics.courant / 0.3
    assert found.settings.errors["time steps"] == pytest.approx(formula.steps * factor**2, rel=0.02)
    assert found.settings.errors["resolution"] == pytest.approx(found.scene.body.particles ** (-2 / 3), rel=0.05)
    assert found.settings.bar > formula.error(found.scene)[0]
    text = " ".join(found.scene.choice.values())
    assert re.search(r"0\.003 of inertia_tensor z z, angular_velocity at the end; expected", text)
    assert f"{found.scene.body.particles} particles" in text


def test_short_time_steps_are_made_shorter_where_they_are_what_errs(runs, tmp_path):
    formula = runs(Formula(steps=0.02))
    found = choice.choose(particles(1e-2, "model='sph'"), tmp_path)
    assert found.scene.numerics.courant < 0.15
    assert formula.error(found.scene)[0] <= 1e-2


def test_out_of_reach_is_refused_with_the_cost(runs, tmp_path):
    runs(Formula(resolution=5.0, seconds=1e-3))
    with pytest.raises(
        choice.UnreachableAccuracy, match=r"it takes .* particles and .*; in 6 s some .* particles have"
    ):
        choice.choose(particles(1e-4, "model='sph'"), tmp_path, minutes=0.1)


@pytest.mark.full
def test_an_exact_rung_is_taken_without_a_single_particle(tmp_path):
    found = choice.choose(particles(1e-3), tmp_path)
    assert found.scene.model == "ellipsoid"
    assert choice.measured(found, tmp_path).values["inertia_tensor z z"][0] == pytest.approx(
        choice.measured(choice.choose(particles(1e-8), tmp_path), tmp_path).values["inertia_tensor z z"][0], rel=1e-3
    )


@pytest.mark.parametrize(("apart", "model"), [(1e-3, "ellipsoid"), (0.2, "sph")])
def test_an_approximate_rung_is_taken_where_it_agrees_with_particles(runs, tmp_path, monkeypatch, apart, model):
    runs(Formula(models={"ellipsoid": apart}))
    monkeypatch.setattr(choice, "_is_exact", lambda scene: False)
    found = choice.choose(particles(1e-2), tmp_path)
    assert found.scene.model == model


def test_the_cheapest_of_all_integrations_is_taken(runs, tmp_path):
    formula = runs(Formula())
    for accuracy in (1e-2, 1e-5, 1e-9):
        found = choice.choose(load.loads(TOP, (f"accuracy={accuracy}",)), tmp_path)
        error, seconds = formula.error(found.scene)
        assert error <= accuracy
        scan = [
            1e-5 * n * order**1.5
            for order in (2, 4, 6, 8)
            for n in np.geomspace(4, 1e5, 4000)
            if (formula.coarse / n) ** order <= accuracy
        ]
        assert seconds <= 1.8 * min(scan)


@pytest.mark.full
def test_a_real_top_has_the_accuracy(tmp_path):
    scene = load.loads(TOP, ("accuracy=1e-6", "judged_by=['angular_velocity']"))
    found = choice.choose(scene, tmp_path)
    fine = choice.choose(load.loads(TOP, ("accuracy=1e-10", "judged_by=['angular_velocity']")), tmp_path)
    values = [np.array(choice.measured(each, tmp_path).values["angular_velocity"]) for each in (found, fine)]
    error = np.linalg.norm(values[0] - values[1])
    assert (
        found.settings.chosen != fine.settings.chosen
    )  # the finer one is another run, or the error would tell nothing
    assert 0.0 < error < 1e-6 * np.linalg.norm(values[1])
    assert math.isfinite(found.settings.seconds)


def test_what_cannot_be_chosen_is_said(tmp_path):
    with pytest.raises(SceneError, match="accuracy is not asked for"):
        choice.choose(load.loads(TOP), tmp_path)
    with pytest.raises(SceneError, match="nothing to choose"):
        choice.choose(load.load_file(SIMS / "core_to_pulsar_scaling.toml", ("accuracy=1e-3",)), tmp_path)


def test_a_run_takes_the_choice_into_its_file(tmp_path):
    scene = load.loads(TOP, ("accuracy=1e-4",))
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "top"))
    assert "0.0001 of angular_velocity" in found.attrs["choice"]
    assert 'settings = "given"' in found.attrs["scene"]
    assert (tmp_path / "top-pilots").is_dir()
