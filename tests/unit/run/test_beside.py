"""A run and a second process compile for each other: all that the run needs, the same bits, and nothing is left."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from astroinertia.costs.compiling import by_two_processes
from astroinertia.costs.machine import shipped
from astroinertia.costs.prediction import predict
from astroinertia.engines import elementwise, numba_cpu
from astroinertia.engines.threads import carry_out
from astroinertia.run.loop import run_scene
from astroinertia.run.programs import programs
from astroinertia.scene.load import load_file
from tests.sims import SIMS

MANY = ["body.particles=1100", "body.placement=random", "time.max_steps=2"]
TWO = {"NUMBA_NUM_THREADS": "2"}
RUN = """
import sys
from pathlib import Path
from numba.core import event
from astroinertia.run.loop import run_scene
from astroinertia.scene.load import load_file

folder, file, *settings = sys.argv[1:]
with event.install_recorder("numba:compile") as recorder:
    run_scene(load_file(file, settings), Path(folder))
print(*(happened.data["dispatcher"].py_func.__module__ for _, happened in recorder.buffer if happened.is_start))
"""
two_cores = pytest.mark.skipif(
    not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2, reason="there is one core"
)


def noted_run(scene: Any, folder: Path, monkeypatch: pytest.MonkeyPatch) -> set[tuple]:
    """Run it; the programs that carried out its sums and loops, by module, name and types."""
    carried: set[tuple] = set()

    def noted(function: Any, threads: int, *arguments: Any) -> bool:
        types = tuple(map(function.typeof_pyval, (np.zeros(1, np.int64), *arguments)))
        carried.add((function.py_func.__module__, function.py_func.__name__, types))
        return carry_out(function, threads, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(numba_cpu, "carry_out", noted)
        patched.setattr(elementwise, "carry_out", noted)
        run_scene(scene, folder)
    return carried


def run_alone(scene: Any, folder: Path, monkeypatch: pytest.MonkeyPatch) -> set[tuple]:
    """As `noted_run`, in this process by itself; they are what is known ahead."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    run = noted_run(scene, folder, monkeypatch)
    known = {(f.py_func.__module__, f.py_func.__name__, types) for f, types in programs(scene)}
    assert known == run and len(run) > 20
    return run


@pytest.mark.full(inputs=["sims/evrard.toml"])
def test_all_programs_of_a_run_are_known_before_it(tmp_path, monkeypatch) -> None:
    run_alone(load_file(SIMS / "evrard.toml", MANY), tmp_path, monkeypatch)


@pytest.mark.full
@two_cores
def test_a_first_run_by_two_processes_has_the_bits_of_one_that_finds_everything_compiled(tmp_path, monkeypatch) -> None:
    scene = load_file(SIMS / "evrard.toml", MANY)
    run = run_alone(scene, tmp_path / "alone", monkeypatch)
    kept = TWO | {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "ASTROINERTIA_CACHE": str(tmp_path / "kernels")}
    command = [sys.executable, "-c", RUN, str(tmp_path / "two"), str(SIMS / "evrard.toml"), *MANY]
    compiled = subprocess.run(command, env=os.environ | kept, capture_output=True, text=True, check=True)
    here = {module for module, _, _ in run} & set(compiled.stdout.split())
    assert 0 < len(here) < len({module for module, _, _ in run})  # the rest was compiled beside it
    assert not compiled.stderr
    assert not [path for path in tmp_path.rglob("*") if ".tmp" in path.name]
    alone, two = (xr.open_dataset(next((tmp_path / name).glob("*.nc"))) for name in ("alone", "two"))
    for name in set(alone.data_vars) - {"wall_time"}:
        np.testing.assert_array_equal(alone[name].values, two[name].values, name)

    # Where everything is found, no process is started.
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    monkeypatch.setattr(subprocess, "Popen", None)
    assert by_two_processes(scene)
    run_scene(scene, tmp_path / "again")


def beside(pid: int) -> list[int]:
    """Processes that compile beside a run: those of its children that still are."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((place / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
        if parent == pid and b"astroinertia.run.ahead" in words_of(place):
            found.append(int(place.name))
    return found


def words_of(place: Path) -> list[bytes]:
    """Of the command that a process carries out; none where it has ended."""
    try:
        return [word for word in (place / "cmdline").read_bytes().split(b"\0") if word]
    except OSError:
        return []


def waited_for(condition: Any, seconds: float) -> Any:
    end = time.monotonic() + seconds
    while not (answer := condition()) and time.monotonic() < end:
        time.sleep(0.05)
    return answer


@pytest.mark.slow
@two_cores
@pytest.mark.parametrize(("number", "code"), [
    (signal.SIGKILL, -9), pytest.param(signal.SIGINT, 130, marks=pytest.mark.full),
    pytest.param(signal.SIGTERM, 143, marks=pytest.mark.full),
])  # fmt: skip
def test_the_second_process_ends_with_the_run(number: int, code: int, tmp_path) -> None:
    kept = TWO | {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "ASTROINERTIA_CACHE": str(tmp_path / "kernels")}
    command = [sys.executable, "-m", "astroinertia", "run", str(SIMS / "evrard.toml")]
    command += [word for setting in MANY for word in ("--set", setting)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=tmp_path, env=os.environ | kept, **quiet) as run:  # type: ignore[call-overload]
        try:
            (other,) = waited_for(lambda: beside(run.pid), 60.0)
            assert os.getpgid(other) != os.getpgid(run.pid)  # what a terminal sends is for the run alone
            time.sleep(1.0)
            run.send_signal(number)
            assert run.wait(30.0) == code
            assert waited_for(lambda: not words_of(Path(f"/proc/{other}")), 10.0)
        finally:
            run.kill()


def test_two_processes_are_for_many_programs_of_few_particles_on_two_cores(monkeypatch) -> None:
    def shared(*settings: str, scene: str = "evrard", threads: str = "2") -> bool:
        monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
        return by_two_processes(load_file(SIMS / f"{scene}.toml", list(settings)))

    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    assert shared("body.particles=1001") and shared("body.particles=30000")
    assert not shared("body.particles=1000") and not shared("body.particles=30001")
    assert shared("body.particles=1000", "numerics.precision=mixed")  # which has no programs for few
    assert not shared("numerics.engine=xla", "body.particles=2000")
    assert not shared(scene="tennis_racket") and not shared("body.particles=2000", threads="1")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)
    assert not shared("body.particles=2000")


def test_two_processes_are_predicted_to_take_less_time_and_more_of_the_processor(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(tmp_path / "cache"))  # nothing is compiled yet
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    scene, compiling = load_file(SIMS / "evrard.toml", ["body.particles=2000"]), {}
    for threads in ("1", "2"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
        compiling[threads] = predict(scene, shipped()).compiling  # type: ignore[union-attr]
    one, two = compiling["1"], compiling["2"]
    assert two.wall == pytest.approx(0.6 * one.wall) and two.processor > one.processor
