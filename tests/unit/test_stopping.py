"""What stops a run before its end: it is saved, says how to go on, and goes on bit for bit."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import jax
import pytest
import xarray as xr

import astroinertia
from astroinertia import dataset
from astroinertia.build import assemble
from astroinertia.cli import main as cli, stop as cli_stop
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveWarning, RunInterrupted
from astroinertia.models.ellipsoid import evolution as ellipsoid
from astroinertia.models.ellipsoid.evolution import Ellipsoid
from astroinertia.models.rigid import passage
from astroinertia.models.rigid.evolution import RigidBody
from astroinertia.models.scaling import homology
from astroinertia.models.scaling.evolution import Scaling
from astroinertia.process import interrupts
from astroinertia.run import loop
from astroinertia.storage.archive import Archive
from tests.left_behind import Left
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
    return moved_by_steps(monkeypatch, RigidBody, (loop, cli, cli_stop, interrupts))


@pytest.fixture
def heard(monkeypatch):
    """The listener hears of every step, as of steps of 10 s."""
    moved_by_steps(monkeypatch, RigidBody, (loop,))


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    return one.drop_vars("wall_time").equals(other.drop_vars("wall_time"))


@pytest.mark.parametrize(
    ("number", "times", "name"),
    [
        (signal.SIGINT, 2, "Ctrl-C"),
        (signal.SIGTERM, 2, "SIGTERM"),
        pytest.param(signal.SIGUSR1, 2, "SIGUSR1", marks=pytest.mark.full),
    ],
)
def test_a_signal_saves_the_run_also_when_it_comes_twice(tmp_path, whole, number, times, name):
    """`timeout` and schedulers send theirs to the process and to its group: the second must not kill it."""
    before = signal.getsignal(number)

    def send(progress):
        assert progress.step == 0
        assert signal.getsignal(signal.SIGUSR2) == signal.SIG_DFL
        for _ in range(times):
            os.kill(os.getpid(), number)

    with pytest.raises(RunInterrupted, match=rf"stopped by {name} at 0\.0% and is saved"):
        loop.run_scene(scene(), tmp_path / "run", send)
    assert signal.getsignal(number) == before
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "run")), whole)


def test_a_command_that_is_ended_at_any_moment_of_the_last_file_loses_nothing(tmp_path, whole, monkeypatch):
    """At each of the files that are synced once the run has ended, and between the halves of the netCDF file."""
    finish, sync, write = dataset.finish, os.fsync, xr.Dataset.to_netcdf
    left, finishing = Left(tmp_path / "run", tmp_path / "left"), []

    def begun(*arguments):
        finishing.append(True)
        return finish(*arguments)

    def synced(descriptor):
        if finishing:
            left.at(signal.SIGTERM)
        sync(descriptor)

    def written(self, *arguments, **options):
        left.at(signal.SIGUSR1)
        write(self, *arguments, **options)
        left.at(signal.SIGINT)

    with monkeypatch.context() as patch, interrupts.watched(left.end):
        patch.setattr(dataset, "finish", begun)
        patch.setattr(os, "fsync", synced)
        patch.setattr(xr.Dataset, "to_netcdf", written)
        loop.run_scene(scene(), tmp_path / "run")
    assert len(left.ends) >= 6  # netCDF begun and written, its file and folder synced, the manifest and its folder
    for ended, folder in left.ends:
        assert re.match(rf"the run was stopped by {ended.name} at 100\.0% and is saved", str(ended.said))
        assert ended.saved
        file = astroinertia.resume(folder)
        assert [each.name for each in folder.glob("*.nc")] == [file.name]
        assert not list(folder.glob("*.tmp"))
        assert same(astroinertia.open(file), whole)
    assert {ended.name for ended, _ in left.ends} == {"Ctrl-C", "SIGTERM", "SIGUSR1"}


def test_a_command_is_ended_at_once_where_nothing_would_be_lost(tmp_path, whole, heard):
    """Before the first step, which may compile for long, and after one it is saved instead, at the next."""
    left, sent = Left(tmp_path / "run", tmp_path / "left"), []

    def send(progress):
        if progress.step == 0:
            left.at(signal.SIGTERM)
        elif not sent:
            sent.append(progress.step)
            os.kill(os.getpid(), signal.SIGINT)

    with interrupts.watched(left.end), pytest.raises(RunInterrupted, match="stopped by Ctrl-C") as stopped:
        loop.run_scene(scene(), tmp_path / "run", send)
    ((ended, folder),) = left.ends
    assert (str(ended.said), ended.saved) == (
        f"the run was stopped by SIGTERM at 0.0% and is saved in {tmp_path / 'run'}",
        True,
    )
    assert 0.0 < stopped.value.share < 1.0
    for place in (folder, tmp_path / "run"):
        assert same(astroinertia.open(astroinertia.resume(place)), whole)


def test_a_second_signal_ends_a_command_at_once_unless_it_comes_right_after_the_first(
    tmp_path, whole, monkeypatch, heard
):
    left, received, answered = Left(tmp_path / "run", tmp_path / "left"), [], []
    monkeypatch.setattr(interrupts, "AGAIN", 3600.0)

    def send(progress):
        if progress.step and not answered:
            answered.append(True)
            os.kill(os.getpid(), signal.SIGTERM)
            os.kill(os.getpid(), signal.SIGUSR1)
            while not received:
                time.sleep(0.01)
            monkeypatch.setattr(interrupts, "AGAIN", 0.0)
            left.at(signal.SIGTERM)

    noted = interrupts.noted

    def seen(given, *arguments):
        nonlocal received
        received = given
        return noted(given, *arguments)

    monkeypatch.setattr(interrupts, "noted", seen)
    with interrupts.watched(left.end), pytest.raises(RunInterrupted, match="stopped by SIGTERM"):
        loop.run_scene(scene(), tmp_path / "run", send)
    ((ended, folder),) = left.ends
    assert not ended.saved
    assert cli_stop.ended(ended) == (
        143,
        f"ended at once by SIGTERM; what was saved before is kept; go on with: astroinertia resume {tmp_path / 'run'}",
    )
    assert same(astroinertia.open(astroinertia.resume(folder)), whole)


SPIN = ["time.end=100 s", "output.series_every=100 s"]
ELLIPSOID = ["time.end=100.0", "output.series_every=100.0"]
MOON = [
    "numerics.integrator=splitting", "orbits.back_reaction=true", "time.end=100 d", "output.series_every=100 d",
]  # fmt: skip
CRAB = ['equation_of_state.kind="ideal"', "time.end=0.0025 s", "output.series_every=0.0025 s"]
BETWEEN = {
    "splitting": (
        TOP,
        SPIN,
        RigidBody,
        (passage, "STEPS_AT_ONCE", 64),
        (passage, "_STEPS_OF_FREE", 64),
    ),
    "adaptive": (
        TOP,
        [*SPIN, "numerics.integrator=adaptive"],
        RigidBody,
        (passage, "STEPS_AT_ONCE", 64),
        (passage, "ADAPTIVE_BETWEEN_LOOKS", 64),
    ),
    "ellipsoid": (SIMS / "riemann_ellipsoid.toml", ELLIPSOID, Ellipsoid, (ellipsoid, "AT_ONCE", 64)),
    "two bodies": (
        SIMS / "hyperion.toml",
        MOON,
        RigidBody,
        (passage, "STEPS_AT_ONCE", 64),
        (passage, "_STEPS_BETWEEN_LOOKS", 64),
    ),
    "scaling": (SIMS / "crab_pulsar.toml", CRAB, Scaling, (homology, "_AT_ONCE", 16)),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in ("splitting", "scaling") else pytest.mark.full) for name in BETWEEN]
)
def test_models_without_particles_stop_between_outputs_and_go_on_bit_for_bit(tmp_path, monkeypatch, request, name):
    path, settings, kind, *limits = BETWEEN[name]
    asked = astroinertia.load(path, settings)
    at_once = astroinertia.open(astroinertia.run_scene(asked, tmp_path / "at once"))
    for limit in limits:
        monkeypatch.setattr(*limit)
    if kind is RigidBody:  # whose programs have the limits in them
        jax.clear_caches()
        request.addfinalizer(jax.clear_caches)
    name = "through" if hasattr(kind, "through") else "advance"
    going, calls = getattr(kind, name), []

    def counted(body, *arguments):
        records = going(body, *arguments)
        calls.append(body.time)
        if len(calls) == 3 and (tmp_path / "parts").exists():
            os.kill(os.getpid(), signal.SIGTERM)
        return records

    monkeypatch.setattr(kind, name, counted)
    whole = astroinertia.open(astroinertia.run_scene(asked, tmp_path / "whole"))
    assert len(calls) > 6
    calls.clear()
    with pytest.raises(RunInterrupted, match="stopped by SIGTERM") as stopped:
        loop.run_scene(asked, tmp_path / "parts")
    assert len(calls) == 3 and 0.0 < stopped.value.share < 1.0
    assert sum(len(part["step"]) for part in Archive.view(tmp_path / "parts").read_series()) == 1
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "parts")), whole)
    last, there = (found["inertia_tensor"].values[-1] for found in (whole, at_once))
    assert abs(last - there).max() < 1e-7 * abs(there).max()  # about its middle axis a body forgets no error


def test_a_pulsation_that_cannot_be_followed_to_the_end_is_refused_at_once(tmp_path, capsys):
    """The Crab pulsar in a gas of its own pulsates 1e14 times while it slows down."""
    words = [str(SIMS / "crab_pulsar.toml"), "--set", 'equation_of_state.kind="ideal"']
    for command in (["plan", *words], ["run", *words, "--output", str(tmp_path / "run")]):
        assert main(command) == 1
        # It starts in equilibrium to round-off, of which its first turning points are.
        assert re.search(r"pulsates 2\.\de\+14 times in the run", capsys.readouterr().err)
    assert not (tmp_path / "run").exists()


COMPILING = """
import sys, threading, time
from astroinertia.build import assemble
from astroinertia.cli.main import main
from astroinertia.run import loop

def compiles(*_):
    time.sleep(600.0)

assemble.prepare = loop.prepare = compiles
sys.exit(main(["run", *sys.argv[1:]]))
"""


def test_the_limit_of_wall_time_holds_while_a_run_is_prepared(tmp_path):
    words = [str(TOP), "--output", str(tmp_path / "run"), "--max-wall", "3"]
    done = subprocess.run([sys.executable, "-c", COMPILING, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 130
    assert "stopped by its limit of wall time before its first step" in done.stderr
    assert not (tmp_path / "run").exists()


DRAWING = """
import os, signal, sys, time
from PIL import Image
from astroinertia.plots import pictures
from astroinertia.cli.main import main

def stopped_in_the_middle(image, aside, *options, **more):
    aside.write_bytes(b"half a picture")
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(600.0)

pictures.FIGURES = {"spin": pictures.FIGURES["spin"]}
Image.Image.save = stopped_in_the_middle
sys.exit(main(["show", sys.argv[1]]))
"""


@pytest.mark.full
def test_a_signal_while_pictures_are_drawn_leaves_none_by_half(tmp_path):
    file = astroinertia.run_scene(scene(), tmp_path / "run")
    before = set(file.parent.iterdir())
    done = subprocess.run([sys.executable, "-c", DRAWING, file.parent], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (143, "astroinertia: interrupted.\n")
    assert set(file.parent.iterdir()) == before


def test_a_later_second_ctrl_c_acts_as_usual_where_no_command_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(interrupts, "AGAIN", 0.0)

    def send(_):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        loop.run_scene(scene(), tmp_path / "run", send)


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_while_the_result_is_written_acts_when_it_is_and_a_second_one_at_once(times, tmp_path, monkeypatch):
    """An exception between an `acquire` and its `try` leaves a lock of xarray's shut, at which its files then wait."""
    begun, write = [], xr.Dataset.to_netcdf

    def interrupted(*arguments, **options):
        for _ in range(times):
            os.kill(os.getpid(), signal.SIGINT)
        begun.append(write(*arguments, **options))

    monkeypatch.setattr(xr.Dataset, "to_netcdf", interrupted)
    with pytest.raises(KeyboardInterrupt):
        loop.run_scene(scene(), tmp_path / "run")
    assert len(begun) == len(list((tmp_path / "run").glob("*.nc"))) == 2 - times
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_run_is_stopped_before_its_deadline_and_not_long_before(tmp_path, whole, slow):
    deadline = slow.now + 95.0
    with pytest.raises(RunInterrupted, match=r"stopped by its limit of wall time at 40\.0%"):
        loop.run_scene(scene(), tmp_path / "run", deadline=deadline)
    assert deadline - slow.now == 15.0  # another step, and half of one
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "run")), whole)


def test_the_command_line_says_how_to_go_on(tmp_path, whole, slow, capsys):
    folder = str(tmp_path / "run")
    settings = [part for setting in SETTINGS for part in ("--set", setting)]
    assert main(["run", str(TOP), *settings, "--output", folder, "--max-wall", "70"]) == 130
    printed = capsys.readouterr().err
    assert printed.endswith(f"go on with: astroinertia resume {folder}\n")
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
def test_a_damaged_file_is_reported_in_one_sentence_and_recovered_from(tmp_path, whole, capsys):
    folder = tmp_path / "run"
    with pytest.raises(RunInterrupted):
        loop.run_scene(scene(), folder, lambda _: os.kill(os.getpid(), signal.SIGTERM))
    (checkpoint,) = folder.glob("checkpoint-*")
    checkpoint.write_bytes(checkpoint.read_bytes()[:-1])
    assert main(["resume", str(folder)]) == 0
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    assert f"{checkpoint.name} is damaged" in printed
    assert same(astroinertia.open(folder), whole)


def test_a_file_says_what_of_it_is_lost(tmp_path):
    folder = tmp_path / "run"
    settings = [*SETTINGS, "output.checkpoint_seconds=0"]
    file = astroinertia.run_scene(astroinertia.load(TOP, settings), folder)
    first = min(folder.glob("segment-*"))
    first.unlink()
    outputs = len(astroinertia.open(file)["time"])
    with pytest.warns(UserWarning, match=rf"{first.name} is missing.* This loses 1 of the records"):
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
        loop.run_scene(scene(), tmp_path / "run", lambda _: os.kill(os.getpid(), signal.SIGTERM))
    assert same(astroinertia.open(astroinertia.resume(tmp_path / "run")), whole)


def test_a_run_that_goes_on_with_other_versions_says_so_and_records_both(tmp_path):
    def stop(progress):
        raise RunInterrupted(tmp_path, progress.time, progress.end)

    with pytest.raises(RunInterrupted):
        astroinertia.run_scene(scene(), tmp_path / "parts", stop)
    now = assemble.versions(scene())
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
