"""Measures this machine: what passes, steps, records, files and a start take on it (python: costs.probes).

Every probe runs in an interpreter of its own, so that starting one is measured too and memory is that of a run.
Tests: tests/unit/costs/test_costs.py.
"""

import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import netCDF4

from astroinertia.costs.machine import Machine, described, keep, read, shipped
from astroinertia.costs.probe_scenes import SCALING
from astroinertia.errors import NumericalError
from astroinertia.process.children import completed
from astroinertia.process.stopwatch import Seconds, less
from astroinertia.storage.atomic import temporary_folder

PROBES = {
    "ellipsoid": "ellipsoids: compiling, steps and records",
    "rigid": "rigid bodies: compiling, steps and records",
    "sph": "particles: passes over pairs, gravity, individual steps, records, files",
}
START = "the start of a run, and its end"
NOTHING_KEPT = {"JAX_ENABLE_COMPILATION_CACHE": "false"}  # what a first run compiles is timed
COMPILED = 20.0  # processor seconds: a start that takes as long has compiled what particles need


def calibrate(listener: Callable[[str, float], None] | None = None) -> Machine:
    """Measure this machine, keep what was found in the user's cache, and return it.

    listener: hears what is measured next, and the share that is done. NumericalError where a probe fails.
    """
    report = listener or (lambda *_: None)
    shares = iter((0.0, 0.1, 0.3, 0.5))
    report(START, next(shares))
    start, memory = _start()
    seconds = {"start": start}
    peaks = {"scaling": memory}
    for kind, text in PROBES.items():
        report(text, next(shares))
        probe = probed(kind)
        prepared = Seconds(*probe["prepared"])
        if kind == "sph" and prepared.processor > COMPILED:
            seconds["compile.sph"] = less(prepared, start)
            report(f"{text}, now that they are compiled", 0.7)
            probe = probed(kind)
            prepared = Seconds(*probe["prepared"])
        first = "splitting" if kind == "rigid" else kind
        seconds[f"prepare.{first}"] = less(prepared, start)
        peaks[first] = float(probe["memory"])
        if kind == "rigid":
            peaks["adaptive"] = float(probe["last"])
        seconds |= {name: Seconds(*pair) for name, pair in probe["seconds"].items()}
    seconds.setdefault("compile.sph", _compiling(seconds))
    particle = {name: size for name, size in shipped().memory.items() if name.startswith("particle.")}
    machine = checked(seconds, peaks | particle)
    keep(machine)
    report("done", 1.0)
    return machine


def checked(seconds: dict[str, Seconds], memory: dict[str, float]) -> Machine:
    """The machine with these costs; NumericalError where one is missing or no number."""
    expected = shipped()
    wrong = (seconds.keys() ^ expected.seconds.keys()) | (memory.keys() ^ expected.memory.keys())
    machine = read(Machine(seconds, memory, True, described()).content, described())
    if machine is None:
        raise NumericalError(f"the machine could not be measured: a cost is missing or out of bounds {sorted(wrong)}")
    return machine


def _compiling(seconds: dict[str, Seconds]) -> Seconds:
    """Of what was compiled before, so that it could not be timed: as shipped, for a machine as fast as this one."""
    shipped_seconds = shipped().seconds
    faster = seconds["prepare.ellipsoid"].processor / shipped_seconds["prepare.ellipsoid"].processor
    return shipped_seconds["compile.sph"] * faster


def probed(kind: str) -> dict[str, Any]:
    """What one probe tells."""
    command = ["-m", "astroinertia.costs.probes", kind, repr(time.time())]
    output, _ = _run(command)
    try:
        return json.loads(output.splitlines()[-1])
    except (ValueError, IndexError):
        raise NumericalError(f"the machine could not be measured: the probe {kind} said nothing") from None


def _start() -> tuple[Seconds, float]:
    """A run that does next to nothing: its time, and the most bytes that it held."""
    with temporary_folder() as folder:
        scene = folder / "start.toml"
        scene.write_text(SCALING)
        _, taken = _run(["-m", "astroinertia", "run", str(scene), "--output", f"{folder}/run"])
        with netCDF4.Dataset(folder / "run" / "start.nc") as file:
            return taken, float(file.measured_memory)


def _run(arguments: Sequence[str]) -> tuple[str, Seconds]:
    """What a Python program printed, and what it took; NumericalError where it failed."""
    begin = time.perf_counter()
    before = os.times()
    done = completed([sys.executable, *arguments], env=os.environ | NOTHING_KEPT)
    after = os.times()
    taken = after.children_user + after.children_system - before.children_user - before.children_system
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["without a word"])[-1]
        raise NumericalError(f"the machine could not be measured: a probe failed ({last[:200]})")
    return done.stdout, Seconds(time.perf_counter() - begin, taken)
