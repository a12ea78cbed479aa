"""The choice of settings for an accuracy, with runs whose errors and times are known formulas.

That it holds on real ones is shown by tests/benchmarks/delivered.py, whose table is committed.
"""

import dataclasses
import functools
import math
import re
import time
from types import SimpleNamespace

import numpy as np
import pytest

import astroinertia
from astroinertia.accuracy import choice, choice_particles, choice_smooth, measuring
from astroinertia.accuracy.analysis import reference_of
from astroinertia.accuracy.exact import exact
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.selected_observables import default_names, parsed
from astroinertia.cli.calibrate import with_cost
from astroinertia.cli.main import main
from astroinertia.costs.machine import current
from astroinertia.costs.prediction import predict
from astroinertia.errors import SceneError
from astroinertia.models.rigid.splitting import COMPOSITIONS
from astroinertia.process.words import duration
from astroinertia.scene import load
from astroinertia.scene.plan import plan
from tests.delivered_scenes import ELLIPSOID, carried_out
from tests.tradeoff_scenes import SIMS, TOY_STAR

STAGES = {order: len(stages) for order, stages in COMPOSITIONS.items()} | {"": choice_smooth.STAGES}
RECORDS = 200  # of a run, each of which a step meets
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
    """Runs that err as prescribed: resolution R h^2, time steps S f^2, splitting (c/n)^order, other models M.

    often: evaluations of a particle over N^(1/3)/f.
    """

    def __init__(self, resolution=1.0, steps=1e-3, coarse=3.0, models=None, seconds=1e-4, often=1.0):
        self.resolution, self.steps, self.coarse, self.seconds = resolution, steps, coarse, seconds
        self.often = often
        self.models = models or {}
        self.runs = []

    def error(self, scene):
        """The error, and how many evaluations of a particle or stages of steps it takes."""
        numerics = scene.numerics
        if scene.model == "rigid" and numerics.integrator == "splitting":
            turns = scene.time.end / (2.0 * math.pi)
            steps = math.ceil(turns * numerics.steps_per_rotation)
            return (self.coarse / numerics.steps_per_rotation) ** numerics.order, steps, STAGES[numerics.order]
        if scene.model != "sph":
            return self.models.get(scene.model, numerics.tolerance), 10.0 * numerics.tolerance ** (-1 / 8), STAGES[""]
        count, factor = scene.body.particles, scene.numerics.courant / 0.3
        return self.resolution * count ** (-2 / 3) + self.steps * factor**2, self.often * count ** (4 / 3) / factor, 1

    def work(self, scene):
        _, evaluations, stages = self.error(scene)
        return evaluations * stages

    def __call__(self, scene, observables, folder, rehearsed=True):
        error, evaluations, stages = self.error(scene)
        seconds = self.seconds * evaluations * stages
        self.runs.append(scene)
        values = {each.name: [1.0 + error] for each in observables}
        return Measured(values, {}, seconds, seconds, seconds, 0.0, 0.0, 1, evaluations=evaluations)


@pytest.fixture
def runs(monkeypatch):
    def use(formula):
        monkeypatch.setattr(measuring, "measure", formula)
        monkeypatch.setattr(measuring, "stored", lambda folder, observables: None)
        return formula

    return use


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """Choices by runs that are made, each of them once."""

    @functools.cache
    def chosen(text, settings, accuracy):
        scene = load.loads(text, (*settings, f"accuracy={accuracy}"))
        return choice.choose(scene, tmp_path_factory.mktemp("pilots"))

    return chosen


def particles(accuracy, *more):
    return load.loads(TOY_STAR, (*QUIET, f"accuracy={accuracy}", *more))


@pytest.mark.slow
@pytest.mark.parametrize(
    "accuracy", [pytest.param(3e-2, marks=pytest.mark.full), 3e-3, pytest.param(1e-3, marks=pytest.mark.full)]
)
def test_particles_have_the_accuracy_and_not_much_more(runs, tmp_path, accuracy):
    formula = runs(Formula())
    found = choice.choose(particles(accuracy, "model='sph'"), tmp_path)
    error, evaluations, _ = formula.error(found.scene)
    assert error <= accuracy
    # The cheapest pair of a fine scan, with the whole accuracy as its error.
    scan = [
        n ** (4 / 3) / f
        for f in (0.5, 1.0, 1.5, 2.0)
        for n in np.geomspace(250, 1e6, 2000)
        if formula.resolution * n ** (-2 / 3) + formula.steps * f**2 <= accuracy
    ]
    assert evaluations <= 2.5 * min(scan)
    assert found.scene.settings == "given" and not found.scene.wants_choice
    assert max(scene.body.particles for scene in formula.runs) <= max(found.scene.body.particles, 1000)


@pytest.mark.full
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


@pytest.mark.slow
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


@pytest.mark.full
def test_more_is_stated_than_was_asked_for_and_the_choice_says_why(runs, tmp_path):
    runs(Formula())
    found = choice.choose(particles(1e-2, "model='sph'"), tmp_path)
    assert found.settings.error <= 1e-2 < found.settings.bar
    sentence = found.scene.choice["stated"]
    assert sentence.startswith(f"{found.settings.bar:.1e} is stated, more than the 0.01 asked for: ")
    less = re.search(r"accuracy = (\S+) has 0.01 stated$", sentence)
    again = choice.choose(particles(less[1], "model='sph'"), tmp_path / "less")
    assert 0.8e-2 < again.settings.bar <= 1.02e-2
    assert again.scene.body.particles > found.scene.body.particles


@pytest.mark.full
def test_nothing_more_is_said_where_no_more_is_stated(real):
    found = real(TOP, (), 1e-4)
    assert found.settings.bar <= 1e-4
    assert "stated" not in found.scene.choice


@pytest.mark.slow
def test_short_time_steps_are_made_shorter_where_they_are_what_errs(runs, tmp_path):
    formula = runs(Formula(steps=0.02))
    found = choice.choose(particles(1e-2, "model='sph'"), tmp_path)
    assert found.scene.numerics.courant < 0.15
    assert formula.error(found.scene)[0] <= 1e-2


@pytest.mark.full
def test_coarser_gravity_is_tried_where_multipoles_are_and_the_run_affords_it(runs, tmp_path):
    runs(Formula(resolution=4.0))
    found = choice.choose(load.load_file(SIMS / "cold_spheroid.toml", ("model='sph'", "accuracy=0.02")), tmp_path)
    assert found.settings.chosen["force_error"] == 2e-3  # no coarser than its share of the accuracy
    assert found.settings.errors["gravity"] == 0.0  # the formula's runs do not see it


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "settings", "why"),
    [
        (ELLIPSOID, ("judged_by=['torque pressure']",), "'torque pressure' is 0, to which no error is relative"),
        (TOP, ("judged_by=['density_max']",), "'density_max' is not known"),
        (TOY_STAR, ("judged_by=['torque pressure']", "model='sph'", *QUIET), "'torque pressure' is 0"),
    ],
    ids=["zero", "unknown", "zero_of_particles"],
)
def test_an_observable_that_no_error_is_relative_to_is_refused(monkeypatch, tmp_path, text, settings, why):
    """Once 250 particles were chosen with an error of nan, or a traceback ended the search of an ellipsoid."""

    def measure(scene, observables, folder, rehearsed=True):
        if scene.model == "rigid":
            return measuring.failed("'density_max' is not known: no model here has it.", observables)
        return Measured({each.name: [0.0] for each in observables}, {}, *[0.1] * 5, steps=1, evaluations=100)

    monkeypatch.setattr(measuring, "measure", measure)
    with pytest.raises(choice.UnreachableAccuracy, match=why):
        choice.choose(load.loads(text, (*settings, "accuracy=0.01")), tmp_path)


@pytest.mark.slow
def test_out_of_reach_is_refused_with_the_cost(runs, tmp_path):
    runs(Formula(resolution=5.0, seconds=1e-3))
    with pytest.raises(
        choice.UnreachableAccuracy,
        match=r"it takes .* particles and .*; in 6 s some .* particles have \S+: ask for no less, or allow more --m",
    ):
        choice.choose(particles(1e-4, "model='sph'"), tmp_path, minutes=0.1)


@pytest.mark.slow
def test_a_refusal_names_the_observable_that_errs_most(runs, tmp_path):
    """A star at rest beside a companion hardly turns: 1e6 particles were asked for, and no word of its spin."""

    class Spin(Formula):
        def __call__(self, *arguments, **named):
            measured = super().__call__(*arguments, **named)
            error = measured.values["angular_velocity"][0] - 1.0
            return dataclasses.replace(measured, values={**measured.values, "angular_velocity": [1.0 + 9.0 * error]})

    runs(Spin(resolution=5.0, seconds=1e-3))
    with pytest.raises(choice.UnreachableAccuracy, match=r"it takes .* for angular_velocity, which errs most; in 6 s"):
        choice.choose(particles(1e-4, "model='sph'"), tmp_path, minutes=0.1)


@pytest.mark.slow
def test_more_particles_than_are_ever_chosen_are_refused_whatever_time_there_is(runs, tmp_path):
    formula = runs(Formula(steps=0.0, seconds=1e-9))
    wanted = (0.7 * 1e-6) ** (-3 / 2)  # 1.7e9, of which the formula's run takes 34 min
    with pytest.raises(choice.UnreachableAccuracy) as refused:
        choice.choose(particles(1e-6, "model='sph'"), tmp_path)
    said = re.search(
        r"it takes (\S+) particles and .*; no more than 1e\+07 are chosen, which have (\S+): ask for no less\.$",
        str(refused.value),
    )
    assert float(said[1]) == pytest.approx(wanted, rel=0.1)
    assert float(said[2]) == pytest.approx(1e7 ** (-2 / 3) / 0.7, rel=0.1)  # of which resolution is 0.7
    assert max(scene.body.particles for scene in formula.runs) < 1e7
    slow = runs(Formula(steps=0.0, seconds=1e-6))
    with pytest.raises(choice.UnreachableAccuracy, match=r"no more than 1e\+07 are chosen"):
        choice.choose(particles(1e-6, "model='sph'"), tmp_path / "slow", minutes=1e6)
    most = max(scene.body.particles for scene in slow.runs)
    assert slow.work(slow.runs[-1]) * slow.seconds <= 30.0 and most < 6.9e5  # which take half a minute


@pytest.mark.full
def test_a_refusal_comes_within_a_minute_of_pilots_whatever_time_the_run_has(runs, tmp_path):
    """What is far out of an hour's reach, and out of a week's: a longer run is no reason for longer pilots."""
    for seconds, minutes in ((1e-4, 60.0), (1e-2, 1e4)):
        formula = runs(Formula(resolution=5.0, seconds=seconds))
        with pytest.raises(choice.UnreachableAccuracy, match="it takes"):
            choice.choose(particles(1e-4, "model='sph'"), tmp_path / f"{seconds}", minutes=minutes)
        assert len(formula.runs) >= 3 and sum(map(formula.work, formula.runs)) * seconds < 60.0


@pytest.mark.full
def test_an_exact_rung_is_taken_without_a_single_particle(tmp_path):
    found = choice.choose(particles(1e-3), tmp_path)
    assert found.scene.model == "ellipsoid"
    assert carried_out(found, tmp_path).values["inertia_tensor z z"][0] == pytest.approx(
        carried_out(choice.choose(particles(1e-8), tmp_path), tmp_path).values["inertia_tensor z z"][0], rel=1e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "model"), [(1e-4, "ellipsoid"), pytest.param(0.2, "sph", marks=pytest.mark.full)])
def test_an_approximate_rung_is_taken_where_it_agrees_with_particles(runs, tmp_path, monkeypatch, apart, model):
    runs(Formula(models={"ellipsoid": apart}, steps=1e-5, often=100.0))
    monkeypatch.setattr(choice, "_is_exact", lambda scene: False)
    found = choice.choose(particles(3e-3), tmp_path)
    assert found.scene.model == model


@pytest.mark.slow
def test_an_approximate_rung_is_not_tried_where_it_takes_longer_to_compile_than_particles_to_run(
    runs, tmp_path, monkeypatch
):
    formula = runs(Formula(models={"ellipsoid": 1e-3}))
    monkeypatch.setattr(choice, "_is_exact", lambda scene: False)
    found = choice.choose(particles(1e-2, "output.series_every=3.0"), tmp_path)  # records take time, too
    assert {scene.model for scene in [found.scene, *formula.runs]} == {"sph"}


@pytest.mark.slow
def test_the_cheapest_of_all_integrations_is_taken(runs, tmp_path):
    formula = runs(Formula())
    for accuracy in (1e-2, 1e-5, 1e-9):
        found = choice.choose(load.loads(TOP, (f"accuracy={accuracy}",)), tmp_path)
        error, steps, stages = formula.error(found.scene)
        assert error <= accuracy
        scan = [
            STAGES[order] * max(n * 10.0 / (2.0 * math.pi), RECORDS)
            for order in (2, 4, 6, 8)
            for n in np.geomspace(4, 1e5, 4000)
            if (formula.coarse / n) ** order <= accuracy
        ]
        assert stages * max(steps, RECORDS) <= 1.8 * min(scan)


@pytest.mark.slow
@pytest.mark.parametrize(
    "accuracy",
    [
        0.1,
        pytest.param(3e-2, marks=pytest.mark.full),
        pytest.param(1e-2, marks=pytest.mark.full),
        pytest.param(3e-3, marks=pytest.mark.full),
        1e-4,
    ],
)
@pytest.mark.parametrize(("name", "finer"), [("sph", 1.0), ("ellipsoid", 1e-4), ("rigid", 1e-4)])
def test_pilots_cost_at_most_the_run_that_they_choose(runs, tmp_path, name, finer, accuracy):
    """Of runs without records to meet, which would make them cost more."""
    text, settings = {
        "sph": (TOY_STAR, (*QUIET, "model='sph'", "output.align=false")),
        "ellipsoid": (ELLIPSOID, ("output.series_every=20.0",)),
        "rigid": (TOP, ("output.series_every=10.0",)),
    }[name]
    formula, accuracy = runs(Formula(seconds=1e-9)), finer * accuracy
    found = choice.choose(load.loads(text, (*settings, f"accuracy={accuracy}")), tmp_path)
    assert found.pilots.work == pytest.approx(sum(map(formula.work, formula.runs)))
    assert found.pilots.work <= formula.work(found.scene)
    assert found.pilots.processor <= choice_particles.SURE * found.settings.processor
    assert formula.error(found.scene)[0] <= accuracy


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "settings", "accuracy"),
    [
        pytest.param(TOY_STAR, (*QUIET, "model='sph'", "time.end=1.5"), 0.05, marks=pytest.mark.full),
        pytest.param(ELLIPSOID, (), 1e-5, marks=pytest.mark.full),
        (TOP, (), 1e-4),
    ],
    ids=["sph", "ellipsoid", "rigid"],
)
def test_real_pilots_cost_at_most_their_run_and_what_was_predicted(tmp_path, real, text, settings, accuracy):
    found = real(text, settings, accuracy)
    names = tuple(parsed(name) for name in default_names(found.scene))
    run = measuring.measure(found.scene, names, tmp_path / "run")
    numerics = found.scene.numerics
    stages = STAGES[numerics.order if numerics.integrator == "splitting" else ""]
    assert 0.0 < found.pilots.work <= run.evaluations * (1 if found.scene.model == "sph" else stages)
    assert found.pilots.work / 1.5 < found.pilots.predicted < found.pilots.work * 1.5


@pytest.mark.full
@pytest.mark.parametrize("accuracy", [0.1, 3e-2])
def test_pilots_of_a_long_run_take_at_most_its_processor_time(runs, tmp_path, accuracy):
    """Few particles take several times the processor time of many for each evaluation, of which pilots have fewer."""
    runs(Formula(often=1e4))
    found = choice.choose(particles(accuracy, "model='sph'", "output.align=false"), tmp_path)
    run, pilots = found.settings.processor, found.pilots.processor
    assert 10.0 < pilots <= choice_particles.SURE * run
    assert found.settings.processor / found.settings.work < 0.6 * pilots / found.pilots.work
    assert found.scene.body.particles > 250  # of which the run would have the accuracy, and cost less
    assert f"{duration(run)} with its start and {duration(pilots)}" in found.scene.choice["price"]


@pytest.mark.slow
def test_what_first_pilots_take_is_reported_before_and_by_a_plan(runs, tmp_path):
    reported = []
    formula = runs(Formula())
    scene = particles(1e-2, "model='sph'")
    choice.choose(scene, tmp_path, listener=reported.append)
    before = [predict(one, current()) for one in choice_particles.first(scene)]
    seconds = sum(one.again.wall for one in before) + max(one.compiling.wall for one in before)
    assert reported[0] == choice.price_before(scene)
    assert reported[0].startswith(
        f"3 pilots before the run, of about {duration(seconds)} in all; more of them as long as"
    )
    assert {one.particles for one in choice_particles.first(scene)} <= {one.particles for one in formula.runs}
    lines = with_cost(plan(scene), scene, SimpleNamespace(pilot=False, processes=1), print).sections["cost"]
    assert [line.value for line in lines if line.name == "pilots"] == [reported[0]]


@pytest.mark.full
def test_pilots_that_have_lost_their_way_are_not_believed(tmp_path):
    """Over 1600 rotations coarse ones end anywhere, and tell no error."""
    scene = load.loads(TOP, ("accuracy=1e-6", "time.end=10000.0"))
    found = choice.choose(scene, tmp_path)
    answer = exact(scene)
    assert answer is not None
    for name, values in carried_out(found, tmp_path).values.items():
        truth = reference_of(answer, parsed(name)).values
        assert np.linalg.norm(np.array(values) - truth) < 1e-6 * np.linalg.norm(truth)


@pytest.mark.full
def test_a_real_top_has_the_accuracy(tmp_path):
    scene = load.loads(TOP, ("accuracy=1e-6", "judged_by=['angular_velocity']"))
    found = choice.choose(scene, tmp_path)
    fine = choice.choose(load.loads(TOP, ("accuracy=1e-10", "judged_by=['angular_velocity']")), tmp_path)
    values = [np.array(carried_out(each, tmp_path).values["angular_velocity"]) for each in (found, fine)]
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


@pytest.mark.slow
def test_a_run_takes_the_choice_into_its_file(tmp_path):
    scene = load.loads(TOP, ("accuracy=1e-4",))
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "top"))
    assert "0.0001 of angular_velocity" in found.attrs["choice"]
    assert 'settings = "given"' in found.attrs["scene"]
    assert (tmp_path / "top-pilots").is_dir()


@pytest.mark.slow
def test_what_pilots_take_is_no_part_of_the_time_of_the_run(tmp_path, monkeypatch):
    waited = 1e4

    def chosen(scene, *arguments):
        clock = time.monotonic
        monkeypatch.setattr(time, "monotonic", lambda: clock() + waited)
        return load.loads(TOP)

    monkeypatch.setattr("astroinertia.cli.main.choice.chosen", chosen)
    (tmp_path / "top.toml").write_text(TOP)
    assert main(["run", str(tmp_path / "top.toml"), "--output", str(tmp_path / "top")]) == 0
    assert 0.0 < astroinertia.open(tmp_path / "top").attrs["measured_wall_time"] < waited
