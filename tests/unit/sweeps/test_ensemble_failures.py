"""Members of a sweep that cannot be, that fail, and that are run again."""

import time

import numpy as np
import pytest
import xarray as xr

import astroinertia
from astroinertia.accuracy import running
from astroinertia.cli.main import main
from astroinertia.errors import NumericalError, RunInterrupted
from astroinertia.scene.sweep import member
from astroinertia.sweeps import combined, ensemble, folder, members
from tests.small_sweep import SCENE, made

STARS = SCENE.replace('kind = "power_law"\nexponent', 'kind = "rotating_star"\nindex').replace(
    '[body.rotation]\nperiod = "30 s"\n', "t_over_w = 0.05\n"
)


def test_members_that_cannot_be_are_named_by_plan_and_before_a_run(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "600")
    file, folder = tmp_path / "stars.toml", tmp_path / "run"
    file.write_text(STARS.replace("{sweep}", '"body.t_over_w" = [0.2, 0.05]'))
    assert main(["plan", str(file)]) == 2
    rows = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.strip()}
    assert "body.t_over_w = 0.2 " in rows[member(0)] and "mass shedding" in rows[member(0)]
    assert member(1) in rows["members"] and member(1) not in rows  # the plan is of the first that can be
    assert main(["run", str(file), "--output", str(folder), "--workers", "1"]) == 1
    printed = capsys.readouterr().out
    assert printed.index("will have no result") < printed.index("0 of 2 members")
    assert "mass shedding" in str(astroinertia.open(folder)["failure"][0].values)
    assert np.isfinite(astroinertia.open(folder)["mass"][1]).all()
    assert main(["show", str(folder)]) == 0
    table, why = capsys.readouterr().out.split("has no result, for")
    assert f"{member(1)}  0.05" in table and "mass shedding" in why and member(1) not in why
    assert main(["show", str(folder), "--member", "0"]) == 2
    said = capsys.readouterr().err
    assert "holds no run (it has no manifest.json): this member of a sweep failed. [body] t_over_w of 0.2" in said


def test_members_that_fail_at_once_do_not_shorten_what_is_to_go(tmp_path, monkeypatch):
    def carried_out(task):
        if task.number < 2:
            return members.Outcome(task.number, 0.0, folder.Failure("it sheds mass", lasting=True))
        time.sleep(0.05)
        return members.Outcome(task.number, 0.05)

    monkeypatch.setattr(ensemble, "carry_out", carried_out)
    monkeypatch.setattr(ensemble, "_combine", lambda *_: None)
    standings = []
    ensemble.run_sweep(made(), tmp_path / "run", listener=standings.append)
    assert np.isnan([each.to_go for each in standings[:3]]).all()
    assert standings[3].to_go == pytest.approx(standings[3].seconds) and standings[4].to_go == 0.0


@pytest.mark.parametrize("command", ["plan", "run"])
def test_a_sweep_of_which_no_member_can_be_is_refused_before_anything(command, tmp_path, capsys, monkeypatch):
    file = tmp_path / "stars.toml"
    file.write_text(STARS.replace("{sweep}", '"body.t_over_w" = [0.2, 0.3]'))
    monkeypatch.chdir(tmp_path)
    assert main([command, str(file)]) == 2
    caught = capsys.readouterr()
    assert (
        "no member of the sweep can be run: [body] t_over_w of 0.2: no polytrope" in caught.err
        and "(member-0000: body" in caught.err
    )
    assert list(tmp_path.iterdir()) == [file]


def test_members_whose_effects_contradict_each_other_are_named_by_plan(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "600")
    file = tmp_path / "sweep.toml"
    braked = '[effects.dipole_braking]\nfield = "1e12 G"\nradius = "1500 km"\n[time]'
    file.write_text(SCENE.replace("{sweep}", '"effects.dipole_braking.index" = [3.0, 2.0]').replace("[time]", braked))
    assert main(["plan", str(file)]) == 2
    rows = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.strip()}
    assert "the braking index of a field is 3" in rows[member(1)] and member(0) not in rows


def test_a_failure_stays_with_its_member_and_is_reported(tmp_path, monkeypatch):
    carried_out, ran = running.run_scene, []

    def sometimes(scene, place, listener, deadline):
        ran.append(place.name)
        if place.name == member(1):
            raise NumericalError("the state is no longer finite", "gravity", 0.1, None, "s")
        if place.name == member(2) and ran.count(place.name) == 1:
            raise OSError(28, "No space left on device")
        return carried_out(scene, place, listener)

    monkeypatch.setattr(running, "run_scene", sometimes)
    asked = made(
        '"body.exponent" = [0.5, 1.0, 1.5, 2.6]'
    )  # the last has no finite energy, which is found when it is built
    found = ensemble.run_sweep(asked, tmp_path / "run")
    assert {number: each.lasting for number, each in found.failures.items()} == {1: True, 2: False, 3: True}
    result = astroinertia.open(tmp_path / "run")
    assert "no longer finite" in str(result["failure"][1].values)
    assert "No space left" in str(result["failure"][2].values)
    assert "infinite gravitational energy" in str(result["failure"][3].values)
    assert np.isfinite(result["mass"][0]).all() and np.isnan(result["mass"][1:]).all()
    assert result.attrs["failed_members"] == 3

    again = ensemble.resume(tmp_path / "run")  # what will fail again is not tried again
    assert set(again.failures) == {1, 3} and ran == [member(0), member(1), member(2), member(3), member(2)]
    result = astroinertia.open(tmp_path / "run")
    assert str(result["failure"][2].values) == "" and np.isfinite(result["mass"][2]).all()


def test_what_was_found_stays_while_a_member_that_failed_is_run_again(tmp_path, monkeypatch):
    """Until there is more: also where running it again is stopped, and where putting all together is."""
    carried_out, write, trouble = running.run_scene, combined.write, [OSError(28, "No space left on device")]

    def troubled(scene, place, listener, deadline):
        if place.name == member(1) and trouble:
            raise trouble.pop()
        return carried_out(scene, place, listener)

    def stopped(*_):
        raise RunInterrupted(tmp_path, 0.0, 1.0)

    monkeypatch.setattr(running, "run_scene", troubled)
    ensemble.run_sweep(made(), tmp_path / "run")
    before = astroinertia.open(tmp_path / "run").load()
    assert before.attrs["failed_members"] == 1
    trouble.append(RunInterrupted(tmp_path, 0.0, 1.0))
    with pytest.raises(RunInterrupted):
        ensemble.resume(tmp_path / "run")
    xr.testing.assert_identical(astroinertia.open(tmp_path / "run"), before)
    monkeypatch.setattr(combined, "write", stopped)
    with pytest.raises(RunInterrupted):
        ensemble.resume(tmp_path / "run")
    assert folder.finished(tmp_path / "run", 1)
    xr.testing.assert_identical(astroinertia.open(tmp_path / "run"), before)
    monkeypatch.setattr(combined, "write", write)
    assert not ensemble.resume(tmp_path / "run").failures
    after = astroinertia.open(tmp_path / "run")
    assert after.attrs["failed_members"] == 0 and np.isfinite(after["mass"]).all()
