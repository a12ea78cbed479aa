"""Runs that are killed at any instant and gone on with end as the one that never was, bit for bit."""

import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import astroinertia
from astroinertia.storage.archive import Archive
from astroinertia.storage.atomic import TEMPORARY
from tests.tradeoff_scenes import SIMS

pytestmark = pytest.mark.usefixtures("steps_differ")  # as lives.py has them

ROOT = SIMS.parent
# A checkpoint at every instant that one can be taken at, so that many kills hit the writing of files.
COMMON = ["output.checkpoint_seconds=0", "output.series_every=0.05", "output.snapshot_every=0.2", "body.particles=150"]
SCENES = {
    "individual": ("evrard", ["numerics.timesteps=individual", "time.end=1.0"]),
    "global": ("cold_spheroid", ["numerics.max_timestep=0.00125"]),  # most of its time is steps, not the last file
    # Without glass and in the precision of tests/physics/test_individual_steps.py: their programs serve here, too.
    "short": (
        "evrard",
        [
            "numerics.timesteps=individual",
            "numerics.precision=float64",
            "body.placement=random",
            "time.end=0.4",
            "body.particles=100",
        ],
    ),
    "xla": ("dyson_ellipsoid", ["numerics.engine=xla", "numerics.courant=0.03", "time.end=1.0"]),
}


class Lives:
    """Processes that carry out a scene, one after the other (lives.py)."""

    def __init__(self, scene, settings):
        command = [sys.executable, str(Path(__file__).with_name("lives.py")), str(SIMS / f"{scene}.toml"), *settings]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        self.server = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1, env=environment
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.stdin.close()
        self.server.stdout.close()
        self.server.wait()

    def live(self, folder, share=None, span=None):
        """Run or resume; kill it after so much of so many seconds from its first step on. Seconds, steps, killed."""
        print(folder, file=self.server.stdin, flush=True)
        process, begin, steps = int(self._answer("process")), None, []
        while True:
            word, number = self.server.stdout.readline().split()
            if word == "ended":
                print("ended", file=self.server.stdin, flush=True)
                assert int(number) in (0, signal.SIGKILL), "a life ended by an error"
                return time.monotonic() - (begin or time.monotonic()), steps, int(number) != 0
            steps.append(int(number))
            if begin is None and steps[-1] > 0:
                begin = time.monotonic()
                if share is not None:
                    time.sleep(share * span)
                    os.kill(process, signal.SIGKILL)  # its number is its own until "ended" is answered

    def _answer(self, what):
        word, number = self.server.stdout.readline().split()
        assert word == what
        return number


def fingerprint(folder: Path) -> tuple[str, str]:
    """Hashes of the final state of a run and of all that its file holds, but for what it took."""
    stored = Archive.view(folder).read_checkpoint()
    assert stored is not None
    (file,) = folder.glob("*.nc")
    tree = astroinertia.open_tree(file)
    contents = {
        f"{group}/{name}": np.asarray(variable.values)
        for group in ("/", "/snapshots")
        for name, variable in tree[group].variables.items()
        if name != "wall_time"
    }
    tree.close()
    return hashed(stored[0]), hashed(contents)


def hashed(arrays) -> str:
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        data = array.astype(str) if array.dtype.hasobject else np.ascontiguousarray(array)
        digest.update(f"{name} {data.dtype.kind} {data.shape}".encode() + data.tobytes())
    return digest.hexdigest()


def killed_and_gone_on_with(scene, kills, folder, seed):
    """Figures of so many kills, each of which is gone on with to the end, beside a run that is left in peace."""
    chance = random.Random(seed)
    name, settings = SCENES[scene]
    found = {"kills": 0, "lives_that_ended_first": 0, "steps_at_the_kills": [], "torn_files": 0, "resumed_before": 0}
    with Lives(name, [*COMMON, *settings]) as lives:
        span, steps, killed = lives.live(folder / "whole")
        assert not killed
        found["steps"] = steps[-1]
        while found["kills"] < kills:
            again = (folder / "run").exists()
            seconds, steps, killed = lives.live(folder / "run", chance.random(), span)
            if not killed:
                if not again:
                    span = min(span, seconds)  # the first life compiled
                found["lives_that_ended_first"] += 1
                assert fingerprint(folder / "run") == fingerprint(folder / "whole")
                shutil.rmtree(folder / "run")
                continue
            shutil.copytree(folder / "run", folder / f"killed-{found['kills']}")
            found["torn_files"] += any(path.suffix == TEMPORARY for path in (folder / "run").iterdir())
            found["steps_at_the_kills"].append(steps[-1])
            found["resumed_before"] += again
            found["kills"] += 1
            if steps[-1] == found["steps"]:  # it was writing its file: kills in between are wanted, too
                shutil.rmtree(folder / "run")
    expected = fingerprint(folder / "whole")
    for number in range(kills):
        each = folder / f"killed-{number}"
        assert astroinertia.open(each).sizes["time"] > 0
        astroinertia.resume(each)
        assert fingerprint(each) == expected, f"kill {number}"
        assert not list(each.glob(f"*{TEMPORARY}"))
    found["state_sha256"], found["file_sha256"] = expected
    return found


def test_two_kills_change_no_bit(tmp_path):
    assert killed_and_gone_on_with("short", 2, tmp_path, seed=1)["kills"] == 2


@pytest.mark.full(inputs=["sims/evrard.toml", "sims/cold_spheroid.toml", "sims/dyson_ellipsoid.toml"])
@pytest.mark.parametrize(("scene", "kills"), [("individual", 18), ("global", 18), ("xla", 14)])
def test_fifty_kills_change_no_bit(tmp_path, result, scene, kills):
    found = killed_and_gone_on_with(scene, kills, tmp_path, seed=kills)
    result(**found)
    assert found["resumed_before"] > 0
    assert len(set(found["steps_at_the_kills"])) > kills // 3
