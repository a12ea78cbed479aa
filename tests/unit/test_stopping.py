"""What stops a run before its end: it is sealed, told how to go on, and goes on bit for bit."""

import json
import os
import signal
import time

import pytest
import xarray as xr

import astroinertia
from astroinertia import build, cli, cli_stop, dataset, plots, run
from astroinertia.archive import Archive
from astroinertia.cli import main
from astroinertia.errors import ArchiveWarning, RunInterrupted
from astroinertia.models.rigid_evolution import RigidBody
from astroinertia.plots import style
from tests.stepped_clock import moved_by_steps
from tests.tradeoff_scenes import SIMS

pytestmark = pytest.mark.slow

TOP = SIMS / "tennis_racket.toml"
SETTINGS = ["time.end=1 s", "output.series_every=0.05 s"]


@pytest.fixture(autouse=True)
def _ctrl_c_acts_as_usual():
    """It is ignored in what a shell has started in the background, as tests may be."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def scene():
    return astroinertia.load(TOP, SETTINGS)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return astroinertia.open(astroinertia.run_scene(scene(), tmp_path_factory.mktemp("runs") / "whole"))


@pytest.fixture
def slow(monkeypatch):
    """The clock by which runs are stopped: each of the 20 steps takes 10 s."""
    return moved_by_steps(monkeypatch, RigidBody, (run, cli, cli_stop))


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    return one.drop_vars("wall_time").equals(other.drop_vars("wall_time"))


@pytest.mark.parametrize(
    ("number", "times", "name"),
    [(signal.SIGINT, 1, "Ctrl-C"), (signal.SIGTERM, 2, "SIGTERM"), (signal.SIGUSR1, 2, "SIGUSR1")],
)
def test_a_signal_seals_the_run_also_when_it_comes_twice(tmp_path, whole, number, times, name):
    """`timeout` and schedulers send theirs to the process and to its group: the second must not kill it."""
    before = signal.getsignal(number)

    def send(progress):
        assert progress.step == 0
        assert signal.getsignal(signal.SIGUSR2) == signal.SIG_DFL
        for _ in range(times):
            os.kill(os.getpid(), number)

    with pytest.raises(RunInterrupted, match=rf"stopped by {name} at 0\.0% and is sealed"):
        run.run_scene(scene(), tmp_path / "run", send)
    assert signal.getsignal(number) == before
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "run")), whole)


@pytest.mark.parametrize(
    ("number", "name"), [(signal.SIGTERM, "SIGTERM"), pytest.param(signal.SIGINT, "Ctrl-C", marks=pytest.mark.full)]
)
def test_a_signal_at_any_moment_of_the_last_file_loses_nothing(tmp_path, whole, monkeypatch, number, name):
    """At each of the files that are synced once the run has ended, and between the halves of the netCDF file."""
    finish, sync, write, moments = dataset.finish, os.fsync, xr.Dataset.to_netcdf, range(1, 50)
    for fatal in moments:
        folder, passed = tmp_path / str(fatal), [-(10**9)]

        def moment(fatal=fatal, passed=passed):
            passed[0] += 1
            if passed[0] == fatal:
                os.kill(os.getpid(), number)
                os.kill(os.getpid(), number if number != signal.SIGINT else signal.SIGUSR1)  # `timeout` sends two

        def begun(*arguments, passed=passed):
            passed[0] = 0
            return finish(*arguments)

        def synced(descriptor, moment=moment):
            moment()
            sync(descriptor)

        def written(self, *arguments, moment=moment, **options):
            moment()
            write(self, *arguments, **options)
            moment()

        with monkeypatch.context() as patch:
            patch.setattr(dataset, "finish", begun)
            patch.setattr(os, "fsync", synced)
            patch.setattr(xr.Dataset, "to_netcdf", written)
            try:
                run.run_scene(scene(), folder)
                break
            except RunInterrupted as interrupted:
                stopped = interrupted
        assert str(stopped).startswith(f"the run was stopped by {name} at 100.0%")
        assert not list(folder.glob("*.tmp"))
        file = astroinertia.resume(folder)
        assert [each.name for each in folder.glob("*.nc")] == [file.name]
        assert same(astroinertia.open(file), whole)
    assert fatal >= 6  # netCDF begun and written, its file and folder synced, the manifest and its folder


def test_a_signal_while_pictures_are_drawn_leaves_none_by_half(tmp_path, whole, monkeypatch, capsys):
    file = astroinertia.run_scene(scene(), tmp_path / "run")
    draw = style.Figure.savefig

    def stopped_in_the_middle(figure, aside, **options):
        draw(figure, aside, **options)
        aside.write_bytes(aside.read_bytes()[:100])
        os.kill(os.getpid(), signal.SIGTERM)

    before = set(file.parent.iterdir())
    few = {"spin": plots.FIGURES["spin"]}  # all are drawn in test_plots.py
    monkeypatch.setattr(plots, "FIGURES", few)
    monkeypatch.setattr(style.Figure, "savefig", stopped_in_the_middle)
    assert main(["show", str(file.parent)]) == 130
    assert capsys.readouterr().err.strip().endswith("interrupted.")
    assert set(file.parent.iterdir()) == before
    monkeypatch.undo()
    monkeypatch.setattr(plots, "FIGURES", few)
    assert main(["show", str(file.parent)]) == 0
    assert set(file.parent.iterdir()) > before


def test_a_second_ctrl_c_stops_at_once(tmp_path):
    def send(_):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run.run_scene(scene(), tmp_path / "run", send)


def test_a_run_is_stopped_before_its_deadline_and_not_long_before(tmp_path, whole, slow):
    deadline = slow.now + 95.0
    with pytest.raises(RunInterrupted, match=r"stopped by its limit of wall time at 40\.0%"):
        run.run_scene(scene(), tmp_path / "run", deadline=deadline)
    assert deadline - slow.now == 15.0  # another step, and half of one
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "run")), whole)


def test_the_command_line_says_how_to_go_on(tmp_path, whole, slow, capsys):
    folder = str(tmp_path / "run")
    settings = [part for setting in SETTINGS for part in ("--set", setting)]
    assert main(["run", str(TOP), *settings, "--output", folder, "--max-wall", "70"]) == 130
    told = capsys.readouterr().err
    assert told.endswith(f"go on with: astroinertia resume {folder}\n")
    lives = 1
    while (code := main(["resume", folder, "--max-wall", "1.5 min"])) == 130:
        lives += 1
    assert (code, lives) == (0, 2)
    assert same(astroinertia.open(folder), whole)


@pytest.mark.parametrize("text", ["soon", "-1", "0", "nan", "inf", "1 km", "1 h 30"])
def test_a_limit_that_is_no_time_is_refused(text, capsys):
    assert main(["resume", "runs/x", "--max-wall", text]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_limit_is_in_seconds_or_has_a_unit():
    for text, seconds in {"3600": 3600.0, "1 h": 3600.0, "1.5 min": 90.0, "2 d": 172800.0}.items():
        assert cli_stop._seconds(text) == seconds


@pytest.mark.filterwarnings("default")
def test_a_damaged_file_is_told_in_one_sentence_and_recovered_from(tmp_path, whole, capsys):
    folder = tmp_path / "run"
    with pytest.raises(RunInterrupted):
        run.run_scene(scene(), folder, lambda _: os.kill(os.getpid(), signal.SIGTERM))
    (checkpoint,) = folder.glob("checkpoint-*")
    checkpoint.write_bytes(checkpoint.read_bytes()[:-1])
    assert main(["resume", str(folder)]) == 0
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert f"{checkpoint.name} is damaged" in told
    assert same(astroinertia.open(folder), whole)


def test_a_file_says_what_of_it_is_lost(tmp_path):
    folder = tmp_path / "run"
    settings = [*SETTINGS, "output.checkpoint_seconds=0"]
    file = astroinertia.run_scene(astroinertia.load(TOP, settings), folder)
    first = min(folder.glob("segment-*"))
    first.unlink()
    outputs = len(astroinertia.open(file)["time"])
    with pytest.warns(UserWarning, match=rf"{first.name} is missing.* Its 1 records are lost"):
        astroinertia.resume(folder)
    found = astroinertia.open(file)
    assert len(found["time"]) == outputs - 1
    assert first.name in found.attrs["lost_outputs"]


def test_a_clock_that_is_set_back_changes_nothing(tmp_path, whole, monkeypatch):
    now = [2e9]

    def backwards():
        now[0] -= 3600.0
        return now[0]

    monkeypatch.setattr(time, "time", backwards)
    with pytest.raises(RunInterrupted):
        run.run_scene(scene(), tmp_path / "run", lambda _: os.kill(os.getpid(), signal.SIGTERM))
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "run")), whole)


def test_a_run_that_goes_on_with_other_versions_says_so_and_records_both(tmp_path):
    def stop(progress):
        raise RunInterrupted(tmp_path, progress.time, progress.end)

    with pytest.raises(RunInterrupted):
        astroinertia.run_scene(scene(), tmp_path / "parts", stop)
    now = build.versions()
    before = now | {"numba": "0.1", "jax": "0.2"}
    with Archive.open(tmp_path / "parts") as archive:
        archive.describe({"versions": before})
    with pytest.warns(
        ArchiveWarning, match=rf"other versions.*numba 0\.1 to {now['numba']}, jax 0\.2 to {now['jax']}\)"
    ):
        finished = astroinertia.resume(tmp_path / "parts")
    attrs = astroinertia.open(finished).attrs
    assert json.loads(attrs["versions"]) == before and json.loads(attrs["resumed_versions"]) == [now]
    assert astroinertia.resume(tmp_path / "parts") == finished  # without a word: it has nothing to do
