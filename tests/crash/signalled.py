"""Commands that get signals at any moment, each in processes of its own, and what is asked of them then.

Moments are processor seconds of a command's own process, which do not depend on what else the machine does.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from unittest import mock

import xarray as xr

import astroinertia
from astroinertia.cli.stop import INTERRUPTED
from astroinertia.run import loop
from tests.tradeoff_scenes import SIMS

HANGS = 120.0  # s
# What JAX says of a cache that another machine has filled, and what long commands say of themselves.
ASIDE = re.compile(r"[EW]\d{4} .*\.cc:\d+\] |\d+ s: ")
OF_THE_CLOCK = ["wall_time", "measured_wall_time", "measured_memory"]
TOP = [str(SIMS / "tennis_racket.toml"), "--set", "time.end=2 s", "--set", "output.series_every=0.02 s"]
PARTICLES = [
    str(SIMS / "evrard.toml"),
    *("--set", "numerics.timesteps=individual", "--set", "numerics.precision=float64", "--set", "body.particles=100"),
    *("--set", "body.placement=random", "--set", "time.end=0.4", "--set", "output.series_every=0.05"),
    *("--set", "output.snapshot_every=0.2"),
]
SWEEP = """
name = "shrinking"
model = "scaling"
units = "code"
[sweep]
"body.rotation.rate" = [0.5, 1.0, 1.5, 2.0]
[body]
kind = "power_law"
exponent = 1.0
mass = 1.0
radius = 1.0
[body.change]
times = [100.0]
factors = [0.5]
[effects.gravity]
[time]
end = 100.0
[output]
series_every = 0.1
"""
TABLE = "mass,x,y,z\n" + "".join(f"{1 + k},{k % 3},{k % 5},{k % 7}\n" for k in range(2000))
# Words in which {done} is the folder of a finished run, {begun} a copy of one that was stopped, {out} an empty folder.
COMMANDS = {
    "new": ["new", "{out}/star.toml"],
    "plan": ["plan", str(SIMS / "pulsar_collapse.toml")],
    "run": ["run", *PARTICLES, "--output", "{out}/run"],
    "run rigid": ["run", *TOP, "--error-bars", "--output", "{out}/run"],
    "resume": ["resume", "{begun}"],
    "show": ["show", "{done}", "--output", "{out}/pictures"],
    "movie": ["movie", "{done}", "--output", "{out}/film.gif"],
    "report": ["report", "{done}", "--output", "{out}/report.html"],
    "view": ["view", "{done}", "--output", "{out}/view.html"],
    "tradeoff": ["tradeoff", *TOP, "--minutes", "0.2", "--output", "{out}/tradeoff"],
    "compare": ["compare", "{done}", "{done}", "--plot", "{out}/compare.png"],
    "moments": ["moments", "{out}/../particles.csv"],
    "export": ["export", "{done}", "--to", "csv", "--snapshot", "all", "--output", "{out}"],
    "ratios": ["ratios"],
    "verify": ["verify", "--only", "particles"],
    "verify beside": ["verify", "--only", "exact_motions", "--only", "particles"],
    "calibrate": ["calibrate"],
    "sweep": ["run", "{out}/../sweep.toml", "--workers", "2", "--output", "{out}/run"],
}


@dataclass(frozen=True)
class Place:
    """A folder with what commands work on."""

    folder: Path

    @property
    def done(self) -> Path:
        return self.folder / "done"

    @property
    def begun(self) -> Path:
        return self.folder / "begun"


def prepared(folder: Path) -> Place:
    """A finished run of particles, one that was stopped in the middle, a sweep and a table."""
    settings = [word for word in PARTICLES[1:] if word != "--set"]
    scene = astroinertia.load(PARTICLES[0], settings)
    astroinertia.run_scene(scene, folder / "done")

    def stop(progress):
        if progress.step > 5:
            raise astroinertia.errors.RunInterrupted(folder, 0.0, 1.0)

    # It says after each step how far it is, for it may end before the usual pause.
    with suppress(astroinertia.errors.RunInterrupted), mock.patch.object(loop, "PAUSES", (0.0, 0.0)):
        astroinertia.run_scene(scene, folder / "begun", stop)
    assert not list((folder / "begun").glob("*.nc"))
    (folder / "sweep.toml").write_text(SWEEP)
    (folder / "particles.csv").write_text(TABLE)
    return Place(folder)


@dataclass
class Counted:
    """How many signals were sent to what, and what became of it."""

    sent: Counter = field(default_factory=Counter)
    ended: Counter = field(default_factory=Counter)
    slowest: float = 0.0  # s from the first signal to the end

    @property
    def number(self) -> int:
        return self.sent.total()


def signalled(place: Place, name: str, numbers, after: float, counted: Counted, cold: bool = False) -> None:
    """Run a command and send it signals once it has taken so many processor seconds; all that is asked is asserted.

    numbers: one for the process; two equal ones go to the process and to its group, as `timeout` sends them; two
    others, the second a second and a half later. cold: whether nothing is compiled before.
    """
    out = place.folder / f"out-{counted.number}"
    out.mkdir()
    begun = out / "begun"
    if name == "resume":
        shutil.copytree(place.begun, begun)
    words = [word.format(out=out, done=place.done, begun=begun) for word in COMMANDS[name]]
    env = dict(os.environ)
    if cold or name == "calibrate":
        empty = str(out.with_name(f"{out.name}-cache"))
        env |= {"ASTROINERTIA_CACHE": empty, "NUMBA_CACHE_DIR": empty, "JAX_COMPILATION_CACHE_DIR": f"{empty}/jax"}
    command = [sys.executable, "-m", "astroinertia", *words]
    with (out / "complaints").open("w+") as complained, subprocess.Popen(
        command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=complained, env=env,
    ) as process:  # fmt: skip
        try:
            while process.poll() is None and processor_seconds(process.pid) < after:
                time.sleep(0.005)
            began = time.monotonic()
            under_way = process.poll() is None
            sent(process, numbers)
            process.wait(HANGS)
            seconds = time.monotonic() - began
            gone(process.pid)
        finally:
            for each in left(process.pid):
                with suppress(ProcessLookupError):
                    os.kill(each, signal.SIGKILL)
    lines = (out / "complaints").read_text().splitlines(keepends=True)
    complaints = "".join(line for line in lines if not ASIDE.match(line))
    said = f"{name}, {[each.name for each in numbers]} after {after:.2f} s, code {process.returncode}: {complaints}"
    counted.sent[name] += 1
    counted.ended[_judged(process.returncode, numbers, complaints, under_way, said)] += 1
    counted.slowest = max(counted.slowest, seconds if under_way else 0.0)
    assert "Traceback" not in complaints, said
    assert not [path for path in out.rglob("*.tmp") if path.parent not in (begun, out / "run")], said
    _goes_on(place, name, out, said)
    shutil.rmtree(out)


def sent(process, numbers) -> None:
    first, *more = numbers
    with suppress(ProcessLookupError):
        process.send_signal(first)
        for other in more:
            if other == first:
                os.killpg(process.pid, other)
            else:
                time.sleep(1.5)
                process.send_signal(other)


def processor_seconds(process: int) -> float:
    """What a process has taken, and those of its children that have ended."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def gone(session: int) -> None:
    """Wait until no process of a session is left."""
    end = time.monotonic() + HANGS
    while left(session):
        assert time.monotonic() < end, "processes that the command started are left"
        time.sleep(0.02)


def left(session: int) -> list[int]:
    """The processes of a session that have not ended."""
    found = []
    for place in Path("/proc").glob("[0-9]*/stat"):
        with suppress(FileNotFoundError, ProcessLookupError):
            state, *numbers = place.read_text().rpartition(")")[2].split()
            if int(numbers[2]) == session and state != "Z":
                found.append(int(place.parent.name))
    return found


def _judged(code, numbers, complaints, under_way, said) -> str:
    """How the process ended, which must be one of the ways that are documented."""
    if code == INTERRUPTED and "is saved in" in complaints:
        return "saved"
    if code == INTERRUPTED and "what is done is kept" in complaints:
        return "kept"
    if code == 0:
        return "had its result" if under_way else "had ended before"
    assert under_way, said
    if -code in numbers:  # before the command line has begun, or once it has said its last word
        assert not complaints or "is saved in" in complaints or "what is done is kept" in complaints, said
        return "at once"
    assert code in [128 + number for number in numbers], said
    assert complaints.startswith("astroinertia: ") and complaints.count("\n") == 1, said
    return "at once"


def _goes_on(place: Place, name: str, out: Path, said: str) -> None:
    """What is left in the folder of a run is gone on with, to what it would have been."""
    if name in ("run", "resume"):
        folder = out / ("run" if name == "run" else "begun")
        if (folder / "manifest.json").exists():
            found, whole = (astroinertia.open(each) for each in (astroinertia.resume(folder), place.done))
            assert found.drop_vars("wall_time").equals(whole.drop_vars("wall_time")), said
    elif name in ("run rigid", "sweep") and any((out / "run").glob("*.json")):
        assert astroinertia.resume(out / "run").exists(), said
        if name == "sweep":
            assert xr.open_dataset(out / "run" / "shrinking.nc").sizes["body_rotation_rate"] == 4, said
