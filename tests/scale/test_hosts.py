"""A whole run by two processes is that of one; they stop together, and the first alone writes."""

import signal
import socket
import time

import numpy as np
import pytest

import astroinertia
from astroinertia.cli.main import main
from astroinertia.storage.archive import Archive
from tests.scale.commands import ROOT, ended, started

TOP = ("tennis_racket", "time.end=1 s", "output.series_every=0.05 s")
STAR = (
    "rotating_star", "body.particles=200", "body.relax=false", "numerics.engine='xla'", "output.checkpoint_seconds=0",
)  # fmt: skip
FEW = (*STAR, "time.max_steps=12")  # more of them amplify rounding: 60 to 1.5e-13
MORE = (*STAR, "time.max_steps=60", "numerics.devices=2")
ALONE = {"JAX_PLATFORMS": "cpu", "XLA_FLAGS": ""}


def both(folders, scene, *second):
    """The two processes of one run, with more options for the second."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{free.getsockname()[1]}"
    joined = ["--coordinator", place, "--processes", "2", "--process"]
    return [
        started(folders[0], scene, *joined, "0", **ALONE),
        started(folders[1], scene, *joined, "1", *second, **ALONE),
    ]


def all_ended(processes, code=0):
    """What each printed, and complained of, after it ended with this exit code."""
    return [ended(process, code) for process in processes]


def is_silent(said):
    """Whether nothing was said but by the library that JAX sends messages with."""
    return all(line.startswith("[Gloo]") for line in said.splitlines())


def last_state(folder):
    stored = Archive.view(folder).read_checkpoint()
    assert stored is not None
    return stored[0]


def difference(one, other, exactly=True):
    """The largest difference of any array of two states, over its largest value; the impulse's, which is nil, over
    sum m |v|. What is carried of rounding is as large as rounding, and is compared only where all is to be the same.
    """
    assert set(one) == set(other)
    worst = 0.0
    for name, array in one.items():
        if array.dtype.kind == "f" and array.size and not name.endswith((".remainder", ".carry")):
            scale = np.abs(array[np.isfinite(array)]).max(initial=1e-300)
            if name == ".ledger.impulse.value":
                scale = np.sum(one[".mass"] * np.linalg.norm(one[".velocity"], axis=1))
            worst = max(worst, float(np.nanmax(np.abs(array - other[name]), initial=0.0) / scale))
        elif exactly and array.dtype.kind in "iub":
            np.testing.assert_array_equal(array, other[name], err_msg=name)
    return worst


def same(one, other):
    """Whether two states are the same to the bit."""
    return set(one) == set(other) and all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


@pytest.mark.full
def test_two_processes_stop_together_and_the_first_alone_writes(tmp_path):
    together, elsewhere = tmp_path / "together", tmp_path / "elsewhere"
    # The limit of the second is over at once.
    (_, (silent, _)) = all_ended(both((together, elsewhere), TOP, "--max-wall", "1e-6"), 130)
    assert is_silent(silent)
    assert [int(part["step"][-1]) for part in Archive.view(together).read_series()] == [0]
    (said, _), (silent, _) = all_ended(both((together, together), None))
    assert "wrote" in said
    assert is_silent(silent)
    assert not elsewhere.exists()
    alone = astroinertia.run_scene(astroinertia.load(ROOT / "sims" / f"{TOP[0]}.toml", TOP[1:]), tmp_path / "alone")
    one, two = (astroinertia.open(path).drop_vars("wall_time") for path in (alone, together))
    assert one.equals(two)


@pytest.mark.full
def test_what_the_first_cannot_do_ends_all(tmp_path):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "tennis_racket.nc").write_text("a result")
    (_, first), (_, second) = all_ended(both((tmp_path / "taken", tmp_path / "taken"), TOP), 2)
    assert "already holds a result" in first
    assert "the first process of the run cannot write its folder" in second


@pytest.mark.full(inputs=["sims/rotating_star.toml"])
def test_a_run_by_two_processes_is_that_by_one(tmp_path, result):
    alone, together, whole, stopped = (tmp_path / name for name in ("alone", "together", "whole", "stopped"))
    ended(started(alone, FEW, **ALONE))
    (said, _), (silent, _) = all_ended(both((together, together), (*FEW, "numerics.devices=2")))
    assert "wrote" in said
    assert is_silent(silent)
    files = sorted(path.name for path in together.iterdir())
    assert files == sorted(path.name for path in alone.iterdir())
    apart = difference(last_state(alone), last_state(together))
    result(difference_of_the_last_state=apart, files=len(files))

    all_ended(both((whole, whole), MORE))
    processes = both((stopped, stopped), MORE)
    while processes[0].poll() is None and len(list(stopped.glob("checkpoint-*"))) < 2:
        time.sleep(0.02)
    processes[1].send_signal(signal.SIGTERM)  # the second alone: both stop after the same step
    outputs = all_ended(processes, 130)
    assert all("SIGTERM" in complaints for _, complaints in outputs)
    left = difference(last_state(whole), last_state(stopped), exactly=False)
    assert left > 1e-6  # it was under way
    all_ended(both((stopped, stopped), None))
    resumed = same(last_state(whole), last_state(stopped))
    result(difference_where_it_stopped=left, the_same_after_resuming=resumed)
    assert apart <= 1e-13
    assert resumed


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--coordinator", "here:1"], "needs --processes N and --process K"),
        (["--coordinator", "here:1", "--processes", "2", "--process", "2"], "a number from 0 to N - 1"),
        (["--processes", "2", "--process", "0"], "are for a --coordinator"),
    ],
)
def test_half_of_the_options_is_refused(tmp_path, options, sentence, capsys):
    assert main(["run", str(tmp_path / "scene.toml"), *options]) == 2
    assert sentence in capsys.readouterr().err
