"""A run that starts from a state of another one: where it begins, what it keeps, its ledger, and what is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import astroinertia
from astroinertia.build import sph
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.plots.in_words import heading
from astroinertia.scene.load import load_file, loads
from astroinertia.scene.plan import code_units
from astroinertia.storage.archive import Archive
from tests.plugin_example import stopped_at
from tests.unit.run.test_extend import DROP, ROOT, STAR, WHEEL, opened

pytestmark = pytest.mark.usefixtures("steps_differ")

ADDED = ["effects.damping.time_scale=0.5", "time.end=0.8"]


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture(scope="module")
def star(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the star to time 0.4, with snapshots at 0, 0.2 and 0.4."""
    folder = tmp_path_factory.mktemp("runs") / "star"
    astroinertia.run_scene(loads(STAR), folder)
    return folder


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the wheel to 2 s."""
    folder = tmp_path_factory.mktemp("runs") / "wheel"
    astroinertia.run_scene(loads(WHEEL, ['numerics.integrator="splitting"']), folder)
    return folder


# What it is


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting", [pytest.param('engine="numba_cpu"', marks=pytest.mark.full), 'timesteps="individual"']
)
def test_a_branch_with_nothing_changed_goes_on_as_the_run_does(star, tmp_path, setting) -> None:
    whole = opened(astroinertia.run_scene(loads(STAR, ["time.end=0.8", f"numerics.{setting}"]), tmp_path / "whole"))
    settings = ["time.end=0.8", f"numerics.{setting}"]
    before = contents(star)
    branch = opened(astroinertia.branch(star, tmp_path / "branch", settings=settings))
    assert contents(star) == before
    assert branch.time.values == pytest.approx([0.4, 0.5, 0.6, 0.7, 0.8], abs=1e-12)
    for name in ("inertia_tensor", "angular_momentum", "kinetic_energy", "internal_energy", "total_energy"):
        scale = float(abs(whole[name]).max())
        assert branch[name].values[-1] == pytest.approx(whole[name].values[-1], abs=1e-5 * scale), name
    assert float(abs(branch.ledger_closure).max()) < 1e-14
    assert np.abs(branch.work.values[0]).max() == 0.0 and np.abs(branch.work.values[-1]).max() > 0.0
    first = branch.isel(time=0)
    assert first.inertia_tensor_evolved.values == pytest.approx(first.inertia_tensor.values, rel=1e-14, abs=1e-15)


@pytest.mark.slow
def test_what_is_changed_and_where_it_began_is_in_its_history(star, tmp_path) -> None:
    ds = opened(astroinertia.branch(star, tmp_path / "branch", 0.3, ADDED))
    assert list(ds.effect.values) == ["gravity", "pressure", "viscosity", "damping"]
    assert ds.time.values == pytest.approx([0.3, 0.4, 0.5, 0.6, 0.7, 0.8], abs=1e-12)
    line = ds.attrs["history"].splitlines()[-1]
    assert "branched from the run 'star' at time 0.3, by the snapshot 0 of snapshots-" in line
    # The switch of the viscosity follows shocks by what it was before, which a snapshot does not have.
    assert (
        "and on from there (viscosity_alpha and viscosity_trend, which snapshots lack, began again at time 0.2)" in line
    )
    assert line.endswith(", with effects.damping.time_scale=0.5 and time.end=0.8")
    origin = json.loads(ds.attrs["branched_from"])
    assert (origin["run"], origin["folder"], origin["time"]) == ("star", str(star), pytest.approx(0.3))
    assert origin["manifest_sha256"] == Archive.view(star).digest and origin["changed"] == ADDED
    assert float(ds.work.sel(effect="damping")[-1]) < 0.0
    assert float(abs(ds.ledger_closure).max()) < 1e-14
    assert float(abs(ds.virial_mismatch.sel(effect="damping")).max()) < 1e-13


@pytest.mark.parametrize(
    ("at", "place"),
    [(0.25, "the snapshot 0 of"), pytest.param(0.1, "its start", marks=pytest.mark.full), (0.4, "the checkpoint ")],
)
def test_it_begins_with_the_last_state_before_its_time(star, tmp_path, at, place) -> None:
    ds = opened(astroinertia.branch(star, tmp_path / "branch", at, ["time.end=0.41"]))
    assert float(ds.time[0]) == pytest.approx(at, abs=1e-14)
    origin = json.loads(ds.attrs["branched_from"])
    assert origin["state"].startswith(place) and origin["state_time"] <= at
    assert bool(origin["began_again"]) == place.startswith("the snapshot")
    run = astroinertia.open(star)
    if at in (0.1, 0.4):  # records of the run
        there = run.sel(time=at, method="nearest")
        assert ds.inertia_tensor.values[0] == pytest.approx(there.inertia_tensor.values, rel=1e-12, abs=1e-14)
        assert float(ds.density_max[0]) == pytest.approx(float(there.density_max), rel=1e-9)


@pytest.mark.full
def test_a_function_acts_from_the_time_of_the_branch_on(tmp_path) -> None:
    k, speed = 0.3, 1.5

    def cubic(state: Any) -> Any:
        return -k * np.sum(state.velocities**2, axis=1)[:, None] * state.velocities

    free = STAR.replace("[effects.gravity]\n[effects.pressure]\n[effects.viscosity]\n", "[effects]\n")
    free = free.replace("[body.rotation]\nrate = 0.3\n", "")
    free = free.replace("relax = false\n", f"relax = false\nvelocity = [{speed}, 0.0, 0.0]\n")
    astroinertia.run_scene(loads(free), tmp_path / "run")
    ds = opened(astroinertia.branch(tmp_path / "run", tmp_path / "branch", 0.2, effects=[cubic]))
    assert list(ds.effect.values) == ["cubic"]
    passed = ds.time.values - 0.2
    assert ds.momentum.sel(i="x").values == pytest.approx(speed / np.sqrt(1 + 2 * k * speed**2 * passed), rel=1e-4)
    assert ds.attrs["history"].endswith("with the effect cubic")
    # A branch of the branch, with the function that it was given, and one without.
    again = opened(astroinertia.branch(tmp_path / "branch", tmp_path / "again", 0.3, ["time.end=0.5"], effects=[cubic]))
    assert again.attrs["history"].count("branched from") == 2 and list(again.effect.values) == ["cubic"]
    with pytest.raises(ArchiveError, match="with the effect 'cubic'"):
        astroinertia.branch(tmp_path / "branch", tmp_path / "without", 0.3, ["effects={}", "time.end=0.5"])


@pytest.mark.slow
def test_a_branch_that_is_stopped_goes_on_bit_for_bit(star, tmp_path, monkeypatch) -> None:
    whole = opened(astroinertia.branch(star, tmp_path / "whole", 0.3, ADDED))
    with monkeypatch.context() as patch:
        stopped_at(patch, 16)
        with pytest.raises(RunInterrupted):
            astroinertia.branch(star, tmp_path / "parts", 0.4, [*ADDED, "output.checkpoint_seconds=0.0"])
    parts = opened(astroinertia.resume(tmp_path / "parts"))
    assert parts.time[-1] == whole.time[-1]
    again = opened(astroinertia.branch(star, tmp_path / "again", 0.4, [*ADDED, "output.checkpoint_seconds=0.0"]))
    assert parts.equals(again)


@pytest.mark.full
def test_an_ellipsoid_branches_and_goes_on_bit_for_bit(tmp_path) -> None:
    astroinertia.run_scene(loads(DROP), tmp_path / "run")
    whole = opened(astroinertia.run_scene(loads(DROP, ["time.end=3.0"]), tmp_path / "whole"))
    branch = opened(astroinertia.branch(tmp_path / "run", tmp_path / "branch", 1.2, ["time.end=3.0"]))
    assert branch.inertia_tensor.values[-1] == pytest.approx(whole.inertia_tensor.values[-1], rel=1e-9, abs=1e-9)
    assert float(abs(branch.ledger_closure).max()) < 1e-10
    assert float(abs(branch.integration_energy_error).max()) < 1e-10
    longer = opened(astroinertia.resume(tmp_path / "branch", settings={"time.end": 4.0}))
    direct = opened(astroinertia.branch(tmp_path / "run", tmp_path / "direct", 1.2, ["time.end=4.0"]))
    assert longer.equals(direct)
    with pytest.raises(SceneError, match=r"pressure.*listed by a run and its branch, or by neither"):
        astroinertia.branch(tmp_path / "run", tmp_path / "no", 1.2, ["effects={gravity={}}"])


# An effect that is added has a program of its own to compile, and one that is changed has not: one of each.
@pytest.mark.full
@pytest.mark.parametrize(
    ("integrator", "changed"),
    [
        ("adaptive", "effects.internal_dissipation.time_scale=60 s"),
        ("splitting", "effects.constant_torque.vector=['0 N m', '0 N m', '-0.5 N m']"),
    ],
    ids=["adaptive", "splitting"],
)
def test_a_rigid_body_branches_and_goes_on_bit_for_bit(wheel, tmp_path, integrator, changed) -> None:
    chosen = [f"numerics.integrator={integrator}", changed]
    whole = opened(astroinertia.run_scene(loads(WHEEL, ['time.end="3 s"', chosen[0]]), tmp_path / "whole"))
    branch = opened(astroinertia.branch(wheel, tmp_path / "branch", "1.3 s", ["time.end=3 s", chosen[0]]))
    assert branch.time.values[:2] == pytest.approx([1.3, 1.5], rel=1e-14)
    for name in ("angular_momentum", "inertia_tensor"):
        assert branch[name].values[-1] == pytest.approx(whole[name].values[-1], rel=1e-8, abs=1e-8), name
    gained = whole.work.sel(effect="constant_torque")
    done = float(gained[-1] - gained.interp(time=1.3, method="cubic"))
    assert float(branch.work.sel(effect="constant_torque")[-1]) == pytest.approx(done, rel=0.05)
    assert float(abs(branch.integration_energy_error).max()) < 1e-8
    settings = [*chosen, "time.end=3 s"]
    astroinertia.branch(wheel, tmp_path / "parts", "1.3 s", settings)
    parts = opened(astroinertia.resume(tmp_path / "parts", settings=["time.end=4 s"]))
    direct = opened(astroinertia.branch(wheel, tmp_path / "direct", "1.3 s", [*settings, "time.end=4 s"]))
    assert parts.equals(direct) and float(direct.work.sel(effect=changed.split(".")[1])[-1]) < 0.0
    assert np.abs(direct.work.values[0]).max() == 0.0


# What is refused


@pytest.mark.parametrize(
    ("at", "settings", "sentence"),
    [
        (0.3, ["body.mass=2.0"], "body.mass stays as it is in a branch.* effects, numerics, time"),
        (0.3, ["time.end=0.2"], "a branch must end later than it begins: set time.end"),
        (None, [], "a branch must end later than it begins: set time.end"),
        (0.5, ["time.end=0.8"], "must lie within the run, which ends at time 0.4"),
        (-0.1, [], "must lie within the run"),
        ("3 s", [], "the time of a branch must be a plain number"),
        (0.3, ["output.error_bars=true"], "a branch has no error bars"),
        (0.3, ["effects.sinks={density=10.0, radius=0.1}"], r"sinks\] has bodies beside the particles"),
        (0.3, ["effects.dampign.time_scale=1.0"], "dampign is not a known effect; did you mean 'damping'"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(star, tmp_path, at, settings, sentence) -> None:
    with pytest.raises(SceneError, match=sentence):
        astroinertia.branch(star, tmp_path / "branch", at, settings)
    assert not (tmp_path / "branch").exists()


def test_runs_without_states_folders_that_are_taken_and_none_are_refused(star, wheel, tmp_path) -> None:
    with pytest.raises(ArchiveError, match="already holds the run 'star'"):
        astroinertia.branch(star, star, 0.3)
    with pytest.raises(ArchiveError, match="holds no run"):
        astroinertia.branch(tmp_path, tmp_path / "branch", 0.3)
    pivot = "effects.pivot={arm=['0 m', '0 m', '1 m'], gravity=['0 m/s2', '0 m/s2', '1 m/s2']}"
    with pytest.raises(SceneError, match=r"effects.pivot\] belongs to the shape of the body"):
        astroinertia.branch(wheel, tmp_path / "branch", "1 s", [pivot])
    with pytest.raises(SceneError, match="the time of a branch must have a unit"):
        astroinertia.branch(wheel, tmp_path / "branch", "0.5")
    scaling = load_file(ROOT / "sims" / "core_to_pulsar_scaling.toml")
    astroinertia.run_scene(scaling, tmp_path / "scaling")
    with pytest.raises(SceneError, match="the model scaling has no states to branch from"):
        astroinertia.branch(tmp_path / "scaling", tmp_path / "branch")


def test_a_snapshot_from_a_stranger_is_no_state_unless_it_is_one(star) -> None:
    scene = loads(STAR)
    tree = astroinertia.open_tree(star)["snapshots"].isel(snapshot_time=1)
    arrays = {name: np.array(tree[name]) for name in ("mass", "position", "velocity", "entropy")}
    arrays["time"] = np.array(0.2)
    sph.of_snapshot(scene, code_units(scene), arrays)
    for name, bad in (
        ("mass", -arrays["mass"]),
        ("position", arrays["position"][:50]),
        ("velocity", np.full((100, 3), np.nan)),
        ("entropy", arrays["entropy"].astype(np.float32)),
        ("time", np.array(-1.0)),
    ):
        with pytest.raises(ValueError, match=name):
            sph.of_snapshot(scene, code_units(scene), {**arrays, name: bad})


# The command


@pytest.mark.slow
def test_the_commands_extend_and_branch(wheel, tmp_path, capsys) -> None:
    assert main(["branch", str(wheel), "--at", "1.5 s", "--set", "time.end=3 s", "--output", str(tmp_path / "b")]) == 0
    said = capsys.readouterr().out
    assert "branched from the run 'wheel' at time 1.5 s, by the checkpoint" in said
    assert "at time 0 s, and on from there, with time.end=3 s" in said
    assert f"wrote {tmp_path / 'b' / 'wheel.nc'}" in said
    assert main(["resume", str(tmp_path / "b"), "--set", "time.end=4 s"]) == 0
    ds = astroinertia.open(tmp_path / "b")
    assert ds.time.values[[0, -1]] == pytest.approx([1.5, 4.0], rel=1e-14)
    assert "predicted_wall_time" not in ds.attrs  # of the whole scene, which a branch is not
    first, second = heading(ds).splitlines()[-2:]
    assert "branched from the run 'wheel' at time 1.5 s" in first and second.endswith("from time 3 s with time.end=4 s")
    assert (
        main(["branch", str(wheel), "--at", "1.5 s", "--set", "body.mass=1 kg", "--output", str(tmp_path / "c")]) == 2
    )
    assert "body.mass stays as it is in a branch" in capsys.readouterr().err
