"""What a tradeoff runs and finds, with runs in place of which a formula stands: errors whose sources are known."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from astroinertia.accuracy import measuring, table
from astroinertia.accuracy.analysis import Table, analysed
from astroinertia.accuracy.exact import Exact
from astroinertia.accuracy.knobs import Setting, knobs
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.selected_observables import parsed
from astroinertia.accuracy.tradeoff import carry_out
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError, NumericalError, RunInterrupted, SceneError
from astroinertia.plots.tradeoff import tradeoff_figure
from astroinertia.scene import load
from tests.sims import SIMS

SCENE = """
name = "formula"
units = "code"
[body]
kind = "dyson"
gamma = 1.6666666666666667
particles = 2000
mass = 1.0
radius = 1.0
relax = false
entropy = 0.46
[body.rotation]
rate = 0.5
[equation_of_state]
kind = "ideal"
[effects.pressure]
[effects.viscosity]
[time]
end = 1.0
"""
KNOBS = ("timestep_factor", "smoothing_tolerance", "precision")


class Formula:
    """I_zz = I (1 + 3 N^(-2/3) + t f^2 + e), of which the exact scene has I: the sources of error are known."""

    def __init__(self, exact, timestep=1e-4):
        self.exact, self.timestep, self.runs, self.stop_after, self.fails = exact, timestep, [], None, ""

    def __call__(self, scene, observables, folder, rehearsed):
        if self.stop_after is not None and len(self.runs) >= self.stop_after:
            raise RunInterrupted(folder, 0.0, 1.0)
        self.runs.append(folder.name)
        if self.fails and folder.name.startswith(self.fails):
            raise NumericalError("the state is no longer finite", "pressure", 0.5, 7)
        count, factor = scene.particles, scene.numerics.courant / 0.3
        rounding = 1e-6 if scene.numerics.precision == "mixed" else 0.0
        error = 3.0 * count ** (-2 / 3) + self.timestep * factor**2 + rounding
        seconds = 1e-5 * count ** (4 / 3) / factor
        values = {each.name: (self.exact.values[each.variable][2:3, 2] * (1 + error)).tolist() for each in observables}
        names = {each.name: [each.name] for each in observables}
        return Measured(values, names, 2.0 * seconds, seconds, seconds, 0.0, 1e8, 10)  # one of two threads waits


@pytest.fixture(scope="module")
def answer():
    from astroinertia.accuracy.exact import exact

    return exact(load.loads(SCENE.replace("[effects.viscosity]", "")))


@pytest.fixture
def formula(monkeypatch, answer):
    found = Formula(answer)
    monkeypatch.setattr(measuring, "_measured", found)
    return found


@pytest.fixture(scope="module")
def whole(tmp_path_factory, answer):
    """The study of the scene as it stands, which tests only read."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measuring, "_measured", Formula(answer))
        return study(tmp_path_factory.mktemp("study"))


def study(folder, minutes=60.0, only=KNOBS, text=SCENE):
    return carry_out(load.loads(text), folder, minutes, ["inertia_tensor z z"], only)


def sources(found):
    (judged,) = analysed(found).judged
    return judged, {source.knob.name: source for source in judged.sources}


def test_sources_of_error_are_separated_with_their_orders(whole):
    judged, found = sources(whole)
    assert "DOP853" in judged.reference.source
    particles, timestep = found["particles"], found["timestep_factor"]
    assert particles.law.order == pytest.approx(2.0, abs=0.1)
    assert particles.error == pytest.approx(3.0 * 2000 ** (-2 / 3) + 1e-4, rel=1e-3)
    # A source a hundred and seventy times smaller, seen only in differences.
    assert timestep.law.order == pytest.approx(2.0, abs=1e-3)
    assert timestep.error == pytest.approx(1e-4, rel=1e-3)
    assert found["precision"].error == pytest.approx(1e-6, rel=0.05)
    assert found["smoothing_tolerance"].error < 1e-12
    assert judged.limiting.knob.name == "particles"
    assert particles.cost_order == pytest.approx(4.0, abs=1e-6)


def test_an_error_that_changes_its_sign_tells_no_order():
    """Riemann's ellipsoid as it ships: its error was said to be 1.4e-27, of order 2.36 by two tolerances."""
    scene = load.load_file(SIMS / "riemann_ellipsoid.toml")
    (tolerance, *_), one = knobs(scene), np.ones((3, 3))
    errors = {1e-4: 2.3e-6, 1e-5: 1.0e-8, 1e-6: -1.5e-8, 1e-7: -3.0e-9, 1e-8: -3.4e-10, 1e-9: -3.5e-11, 1e-13: 1e-15}
    found = Table(
        scene, (tolerance,), (parsed("inertia_tensor z z"),), Setting("tolerance", 1e-13, ()),
        Exact({"inertia_tensor": one}, "made up", 1.4e-14), Path(),
    )  # fmt: skip
    for value, error in errors.items():
        result = {"inertia_tensor z z": [1.0 + error]}
        found.measured[Setting("tolerance", value, ())] = Measured(result, {}, *[value ** (-1 / 8)] * 5, steps=1)
    _, found = sources(found)
    assert not found["tolerance"].law.order > 1.5  # 1 in theory
    assert found["tolerance"].error >= 1e-15


@pytest.mark.full
def test_another_source_limits_where_it_is_the_larger(formula, tmp_path):
    formula.timestep = 0.2
    judged, found = sources(study(tmp_path))
    assert judged.limiting.knob.name == "timestep_factor"
    assert found["timestep_factor"].error == pytest.approx(0.2, rel=1e-2)
    assert found["particles"].law.order == pytest.approx(2.0, abs=0.05)  # from differences, for errors do not show it


def test_balanced_settings_are_cheaper_than_the_ladder_at_the_same_error(whole):
    found = whole
    judged, _ = sources(found)
    together = [setting for setting in found.measured if setting.knob == "balanced"]
    assert together and any(setting in judged.front for setting in together)
    alone = {setting.chosen["particles"]: found.measured[setting] for setting in found.measured
             if setting.knob == "particles"}  # fmt: skip
    for setting in together:
        same = alone[setting.chosen["particles"]]
        assert found.measured[setting].cpu_time < 0.6 * same.cpu_time


def test_words_name_whose_error_it_is_and_the_cost_of_a_digit(whole):
    text = "\n".join(table.conclusions(whole))
    assert "limited by the particles" in text
    assert "(theory 2)" in text
    assert "the next digit costs" in text
    factor = float(text.split("the next digit costs ")[1].split(" times")[0])
    assert factor == pytest.approx(100.0, rel=0.25)
    (first,) = re.findall(r"particles 2000, in (\d+) ms", text)
    (then,) = re.findall(r"the next digit costs \S+ times: particles \S+, (\d+) s", text)
    assert float(then) == pytest.approx(factor * float(first) / 1000.0, rel=0.05)  # of processor time, both


def test_a_file_where_the_folder_should_be_is_bad_input(formula, tmp_path):
    (tmp_path / "taken").touch()
    with pytest.raises(ArchiveError, match=r"the folder .*taken cannot be made: it is a file"):
        study(tmp_path / "taken")


def test_what_was_run_is_not_run_again(formula, tmp_path):
    first = study(tmp_path)
    count = len(formula.runs)
    again = study(tmp_path)
    assert len(formula.runs) == count
    assert {s: m.values for s, m in again.measured.items()} == {s: m.values for s, m in first.measured.items()}
    study(tmp_path, text=SCENE.replace("end = 1.0", "end = 0.9"))
    assert len(formula.runs) == 2 * count  # another scene in the same folder is another matter


def test_the_scene_of_a_setting_is_made_once(formula, monkeypatch, tmp_path):
    made, inner = [], measuring.scene_of
    monkeypatch.setattr(measuring, "scene_of", lambda *given: made.append(given[1]) or inner(*given))
    found = study(tmp_path)
    assert len(made) == len(set(made)) == len(found.measured)


@pytest.mark.full
def test_an_interruption_keeps_what_is_done_and_goes_on(formula, tmp_path):
    formula.stop_after = 4
    stopped = study(tmp_path)
    assert stopped.interrupted and len(stopped.measured) == 4
    assert table.write(stopped).exists()
    formula.stop_after = None
    whole = study(tmp_path)
    assert not whole.interrupted
    assert len(formula.runs) == len(set(formula.runs)) == len(whole.measured)


def test_a_budget_leaves_out_what_does_not_fit_and_says_so(formula, monkeypatch, tmp_path):
    from astroinertia.accuracy import tradeoff

    now = [0.0]
    monkeypatch.setattr(tradeoff.clock, "monotonic", lambda: now[0])
    inner = measuring.measure

    def measure(*arguments):
        found = inner(*arguments)
        now[0] += found.wall_time
        return found

    monkeypatch.setattr(measuring, "measure", measure)
    whole = 1e-5 * 2000 ** (4 / 3)
    found = study(tmp_path, minutes=4.0 * whole / 60.0)
    assert now[0] < 4.0 * whole
    assert found.left
    assert found.base.value < 2000.0  # single knobs are turned where the budget allows it
    assert f"{len(found.left)} settings did not fit into the budget" in table.conclusions(found)[-1]


def test_a_table_without_any_run_is_written(formula, tmp_path):
    formula.stop_after = 0
    stopped = study(tmp_path)
    assert stopped.interrupted and not stopped.measured
    assert table.read(table.write(stopped)).sizes["setting"] == 0
    assert table.conclusions(stopped)


def test_an_exact_answer_that_takes_long_is_part_of_the_budget(formula, answer, monkeypatch, tmp_path):
    from astroinertia.accuracy import tradeoff

    now = [0.0]
    monkeypatch.setattr(tradeoff.clock, "monotonic", lambda: now[0])
    monkeypatch.setattr(tradeoff, "exact", lambda scene: now.__setitem__(0, 59.5) or answer)
    found = study(tmp_path, minutes=1.0)
    assert found.left and not found.measured  # a run of which nothing is known yet counts as one second
    assert study(tmp_path, minutes=1.0).measured  # it is kept, and taken as it is


def test_a_failed_run_is_a_result_with_its_sentence(formula, tmp_path):
    formula.fails = "timestep_factor_2-"
    found = study(tmp_path)
    (failed,) = (setting for setting in found.measured if found.measured[setting].failure)
    assert failed.label == "timestep factor 2"
    assert any("no longer finite" in line and "particle 7" in line for line in table.conclusions(found))
    data = table.read(table.write(found))
    assert np.isnan(data["error"].sel(setting="timestep factor 2")).all()


def test_the_file_explains_itself_and_is_drawn(whole):
    data = table.read(table.write(whole))
    assert data.sizes["setting"] == len(whole.measured)
    assert data["order"].sel(knob="timestep_factor").item() == pytest.approx(2.0, abs=1e-3)
    for name, variable in data.data_vars.items():
        assert variable.attrs["long_name"], name
        assert variable.dtype.kind in "OU" or "units" in variable.attrs or name in ("result", "reference_result"), name
    assert data["pareto"].sum() > 2
    assert load.loads(data.attrs["scene"]).particles == 2000
    assert "machine" in data.attrs and json.loads(data.attrs["left_out"]) == {}
    front = data["pareto"].values[:, 0].astype(bool)
    (panel,) = tradeoff_figure(data).axes
    drawn = [line.get_xydata() for line in panel.get_lines() if len(line.get_xydata()) == front.sum()]
    assert any(np.allclose(np.sort(xy[:, 0]), np.sort(data["cpu_time"].values[front])) for xy in drawn)


def test_the_legend_has_what_is_drawn(whole):
    data = table.read(table.write(whole))
    everything = {text.get_text() for text in tradeoff_figure(data).legends[0].get_texts()}
    assert {"base", "Pareto front", "particles", "precision"} <= everything
    cheapest = data["cpu_time"] == data["cpu_time"].min()
    alone = tradeoff_figure(data.assign(pareto=data["pareto"] & cheapest)).legends[0]  # of which no line is drawn
    assert {text.get_text() for text in alone.get_texts()} == everything - {"Pareto front"}
    of_precision = data["error"].where(data["knob_turned"] == "precision")
    (legend,) = tradeoff_figure(data.assign(error=of_precision, pareto=0 * data["pareto"])).legends
    assert [text.get_text() for text in legend.get_texts()] == ["precision"]
    assert not tradeoff_figure(data.assign(error=np.nan * data["error"])).legends


@pytest.mark.full
def test_without_an_exact_answer_the_finest_runs_are_extrapolated(formula, tmp_path):
    text = SCENE.replace("entropy = 0.46", "specific_internal_energy = 0.4")  # not isentropic: no exact solution
    judged, found = sources(study(tmp_path, text=text))
    assert "Richardson" in judged.reference.source
    wanted = formula.exact.values["inertia_tensor"][2, 2] * (1 + 1e-4)  # what no number of particles takes away
    assert judged.reference.values[0] == pytest.approx(wanted, rel=1e-5)
    assert found["particles"].law.order == pytest.approx(2.0, abs=0.1)


def test_what_there_is_not_gets_a_sentence(formula, tmp_path):
    with pytest.raises(SceneError, match="no knob 'nonsense'"):
        study(tmp_path, only=["nonsense"])
    laws = "model='scaling'"
    with pytest.raises(SceneError, match="no accuracy knobs"):
        carry_out(load.loads(SCENE.replace("[effects.viscosity]", ""), [laws]), tmp_path, only=())


def command(folder, *more):
    (folder / "scene.toml").write_text(SCENE)
    knobs = [part for name in KNOBS for part in ("--knob", name)]
    options = ["--observable", "inertia_tensor z z", "--output", str(folder / "out")]
    return main(["tradeoff", str(folder / "scene.toml"), *knobs, *options, *more])


@pytest.mark.full
def test_the_command_prints_what_is_worth_its_cost_and_draws_it(formula, tmp_path, capsys):
    assert command(tmp_path) == 0
    printed = capsys.readouterr().out
    assert "worth its cost" in printed and "<- base" in printed
    assert "the next digit costs" in printed
    assert (tmp_path / "out" / "tradeoff.png").stat().st_size > 10000
    assert (tmp_path / "out" / "tradeoff.nc").exists()


@pytest.mark.slow
def test_the_command_goes_on_after_an_interruption(formula, tmp_path, capsys):
    formula.stop_after = 3
    assert command(tmp_path) == 130
    assert "go on with the same command" in capsys.readouterr().err
    assert table.read(tmp_path / "out").attrs["interrupted"] == 1
    formula.stop_after = None
    assert command(tmp_path) == 0
    assert table.read(tmp_path / "out").attrs["interrupted"] == 0


def test_the_command_says_that_no_setting_fits_into_the_budget(formula, tmp_path, capsys):
    assert command(tmp_path, "--minutes", "0.01") == 0
    assert "settings did not fit into the budget; the next, " in capsys.readouterr().out


@pytest.mark.parametrize("more", [("--minutes", "0"), ("--knob", "nonsense"), ("--observable", "nonsense")])
def test_the_command_says_in_a_sentence_what_is_wrong(formula, tmp_path, capsys, more):
    assert command(tmp_path, *more) == 2
    assert capsys.readouterr().err.count("\n") == 1
