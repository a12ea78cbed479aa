"""Runs record at the times that their scenes name, and say so while they go where they leave their plan."""

import io
import itertools
import math
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import astroinertia
from astroinertia.errors import RunInterrupted
from astroinertia.models.sph.evolution import Particles
from astroinertia.run import loop
from astroinertia.run.meter import Meter
from astroinertia.scene.load import load_file, loads
from tests.few_with_steps import MANY_RUNGS
from tests.sims import SIMS

pytestmark = pytest.mark.usefixtures("steps_differ")

EVERY, SNAPSHOTS, END = 0.07, 0.11, 0.5  # none of them a multiple of a step, the end of neither cadence
PARTICLES = ["body.particles=100", "body.placement=random", "numerics.precision=float64"]
ONE_OF_EACH = {
    "global steps": ("evrard", PARTICLES),
    "individual steps": ("evrard", [*PARTICLES, "numerics.timesteps=individual"]),
    "ellipsoid": ("riemann_ellipsoid", []),
    "rigid": ("tennis_racket", []),
    "scaling": ("core_to_pulsar_scaling", []),
}


def cadence(scene: str) -> list[str]:
    unit = "" if scene in ("evrard", "riemann_ellipsoid") else " s"
    values = {"output.series_every": EVERY, "output.snapshot_every": SNAPSHOTS, "time.end": END}
    return [f'{key}="{value}{unit}"' if unit else f"{key}={value}" for key, value in values.items()]


def times_of(every: float, end: float) -> np.ndarray:
    return np.append(np.arange(0.0, end * (1.0 - 1e-9), every), end)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name, marks=pytest.mark.full(inputs=["sims/riemann_ellipsoid.toml"]) if name == "ellipsoid" else ()
        )
        for name in ONE_OF_EACH
    ],
)
def test_records_and_snapshots_are_of_the_times_asked_for(name: str, tmp_path: Path) -> None:
    scene, settings = ONE_OF_EACH[name]
    tree = astroinertia.open_tree(
        astroinertia.run_scene(load_file(SIMS / f"{scene}.toml", [*settings, *cadence(scene)]), tmp_path / "run")
    )
    np.testing.assert_allclose(tree["time"], times_of(EVERY, END), rtol=1e-12, atol=0.0)
    if "steps" in name:
        np.testing.assert_allclose(tree["snapshots"]["snapshot_time"], times_of(SNAPSHOTS, END), rtol=1e-12, atol=0.0)


@pytest.mark.slow
def test_large_snapshots_do_not_wait_in_memory_and_are_made_again_where_a_run_breaks_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Saved at once, they are beyond the checkpoint that the run goes on from."""
    scene = load_file(SIMS / "evrard.toml", [*PARTICLES, *cadence("evrard")])
    expected = astroinertia.open_tree(astroinertia.run_scene(scene, tmp_path / "whole"))
    monkeypatch.setattr(loop, "HELD", 0)
    keep, waiting = loop._Run._keep_what_there_is, []

    def broken_off(run: loop._Run) -> None:
        waiting.append(len(run.snapshots))
        keep(run)
        if len(waiting) == 4:
            raise MemoryError

    with monkeypatch.context() as patch:
        patch.setattr(loop._Run, "_keep_what_there_is", broken_off)
        with pytest.raises(MemoryError):
            loop.run_scene(scene, tmp_path / "run")
    assert waiting == [1, 0, 1, 1]  # the second with the first checkpoint
    assert len(list((tmp_path / "run").glob("snapshots-*"))) == 3
    resumed = astroinertia.open_tree(loop.resume(tmp_path / "run"))
    assert (
        resumed.drop_nodes("snapshots")
        .to_dataset()
        .drop_vars("wall_time")
        .equals(expected.drop_nodes("snapshots").to_dataset().drop_vars("wall_time"))
    )
    assert resumed["snapshots"].to_dataset().equals(expected["snapshots"].to_dataset())


@pytest.mark.full
def test_without_align_steps_are_as_long_as_they_may_be(tmp_path: Path) -> None:
    """The first step past each time is recorded, none is shortened but the last."""
    chosen = [*PARTICLES, *cadence("evrard"), "output.align=false"]
    free = astroinertia.open(astroinertia.run_scene(load_file(SIMS / "evrard.toml", chosen), tmp_path / "free"))
    none = ["output.series_every=0.5", "output.snapshot_every=0.5"]
    alone = load_file(SIMS / "evrard.toml", [*PARTICLES, f"time.end={END}", *none])
    assert free["step"].values[-1] == astroinertia.open(astroinertia.run_scene(alone, tmp_path / "alone"))["step"][-1]
    late = free["time"].values[1:-1] / EVERY
    assert (late >= np.arange(1, len(late) + 1)).all() and (late % 1.0 > 1e-6).any()


@pytest.mark.slow
@pytest.mark.parametrize(("planned", "says"), [(1.0, True), (1e9, False)])
def test_a_run_that_leaves_its_plan_by_a_factor_of_ten_says_so(
    planned: float, says: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(loop, "predicted", lambda _: {"predicted_steps": planned, "predicted_evolution_time": 1e6})
    seen: list[loop.Progress] = []
    loop.run_scene(load_file(SIMS / "tennis_racket.toml"), tmp_path / "run", seen.append)
    assert any(math.isfinite(each.planned_steps) for each in seen) == says
    for each in seen:
        assert math.isfinite(each.planned_steps) == (each.step > 10.0 * planned)
        # What was predicted of a plan that was wrong is no longer counted on.
        assert not (says and each.step > 10.0 and each.to_go > 1e4)


def test_the_line_of_such_a_run_names_the_plan() -> None:
    text = io.StringIO()
    with Meter(Console(file=text)) as meter:
        meter.tell(loop.Progress(0.5, 1.0, 230, 20.0, 0.0, 0.0, 1.0, planned_steps=22.9))
        meter.tell(loop.Progress(0.6, 1.0, 240, 40.0, 0.0, 0.0, 1.0))
    warned, usual = text.getvalue().splitlines()
    assert "step 230" in warned
    assert "WARNING: the plan was about 22.9 steps" in warned
    assert "WARNING" not in usual


@pytest.mark.full(inputs=["sims/evrard.toml"])
def test_particles_are_run_resumed_and_shown_without_jax(tmp_path: Path) -> None:
    """To import it takes longer than what they would need of it."""
    settings = [word for setting in [*PARTICLES, "time.max_steps=2"] for word in ("--set", setting)]
    folder = str(tmp_path / "run")
    commands = [
        ["run", str(SIMS / "evrard.toml"), *settings, "--output", folder],
        ["resume", folder, "--set", "time.max_steps=4"],
        ["show", folder],
    ]
    program = f"import sys; from astroinertia.cli.main import main; commands = {commands!r}\n"
    program += "for each in commands: print(f'\\n{each[0]} ended with', main(each), 'jax' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    ends = [line for line in done.stdout.splitlines() if "ended with" in line]
    assert ends == [f"{command} ended with 0 False" for command, *_ in commands], done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("callback", [None, lambda state: None])
@pytest.mark.parametrize(
    ("scene", "settings"),
    [
        ("tennis_racket", ["numerics.integrator='splitting'", "time.end='1000 s'", "output.series_every='1000 s'"]),
        ("tennis_racket", ["numerics.integrator='adaptive'", "time.end='1000 s'", "output.series_every='1000 s'"]),
        ("riemann_ellipsoid", ["output.series_every=100.0"]),
        ("core_to_pulsar_scaling", []),
    ],
)
def test_a_run_ends_with_its_last_step_wherever_its_next_output_is(scene, settings, callback, tmp_path):
    scene = load_file(SIMS / f"{scene}.toml", [*settings, "time.max_steps=10"])
    ds = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run", callback=callback, progress=False))
    assert ds.step.values[-1] == 10
    assert 0.0 < ds.time.values[-1] < scene.time.end
    assert np.isfinite(ds.kinetic_energy.values).all()


def test_a_run_of_a_number_of_steps_says_that_it_is_over_before_its_end(tmp_path: Path) -> None:
    """And no longer does so where it has gone on to its end."""
    scene = load_file(SIMS / "core_to_pulsar_scaling.toml", ["time.max_steps=2"])
    half = astroinertia.open(loop.run_scene(scene, tmp_path / "run"))
    assert half.attrs["ended_early"] == "time.max_steps is reached, after 2 steps"
    whole = astroinertia.open(loop.resume(tmp_path / "run", settings=["time.max_steps=1000000"]))
    assert float(half["time"][-1]) < float(whole["time"][-1]) == pytest.approx(scene.time.end, rel=1e-14)
    assert "ended_early" not in whole.attrs


def test_runs_of_several_threads_come_one_after_another(tmp_path):
    scene = load_file(SIMS / "core_to_pulsar_scaling.toml", ["output.series_every=1 s"])
    order = []

    def run(name):
        astroinertia.run_scene(scene, tmp_path / name, callback=lambda state: order.append(name), progress=False)

    threads = [threading.Thread(target=run, args=(name,)) for name in ("one", "two", "three")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(order) == 3 * order.count("one") > 3
    assert sum(before != after for before, after in itertools.pairwise(order)) == 2


@pytest.mark.slow
@pytest.mark.parametrize("by", ["Ctrl-C", "its limit of wall time"])
def test_a_run_is_stopped_within_a_base_step_and_goes_on_bit_for_bit(
    by: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 12 rungs and more, so that it would not end for hours where there are many particles: it is taken again."""
    monkeypatch.setattr(loop, "PAUSES", (0.0, 0.0))
    monkeypatch.setattr(loop, "TELLING", math.inf)
    notes: list[str] = []
    figures = Particles.figures
    monkeypatch.setattr(Particles, "figures", lambda body: notes.append(body.note) or figures(body))
    whole: list[int] = []
    expected = loop.run_scene(loads(MANY_RUNGS), tmp_path / "whole", lambda progress: whole.append(progress.step))
    before, within = whole.index(1), 30
    assert whole.count(1) > 2 * within, whole
    assert max(len(note.split()) for note in notes) > 12

    heard: list[int] = []

    def listen(progress: loop.Progress) -> None:
        heard.append(progress.step)
        if by == "Ctrl-C" and len(heard) == before + within:
            os.kill(os.getpid(), signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(loop._Run, "_late", lambda _: by != "Ctrl-C" and len(heard) >= before + within)
        with pytest.raises(RunInterrupted, match=f"stopped by {by}"):
            loop.run_scene(loads(MANY_RUNGS), tmp_path / "run", listen)
    assert heard == whole[: before + within]
    resumed = astroinertia.open(loop.resume(tmp_path / "run"))
    assert resumed.drop_vars("wall_time").equals(astroinertia.open(expected).drop_vars("wall_time"))
