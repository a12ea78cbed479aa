"""Evrard's cloud with SWIFT and with Phantom: the same particles in their own files, and what the runs took.

Neither is part of this package nor needed by it. SWIFT (Schaller et al. 2024, MNRAS 530, 2378) is built as
standard_swift.py says, with `--with-gcc-arch=native`; Phantom (Price et al. 2018, PASA 35, e031) in its folder build by

    FFLAGS=-march=native make phantom SYSTEM=gfortran SETUP=evrard IND_TIMESTEPS=yes

or `no`, for steps that all particles take. Of Phantom's options all but times and outputs are its own defaults: cubic
spline with 58 neighbours, switch of Cullen & Dehnen, conduction of heat, tree with an opening of 0.5.
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from standard_swift import REACH, UNITS, write_start

from astroinertia.build.assemble import prepare
from astroinertia.scene import load
from astroinertia.test_problems.matter import Matter

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own dumps are beside it
from tests.phantom_dump import dump

SIMS = Path(__file__).parent.parent.parent / "sims"
HEAT = 0.05  # specific internal energy at the beginning
SIDE = 20.0  # of SWIFT's box, in whose middle the cloud is
NEIGHBOURS = 60.0
UPDATES = 7  # the column of its file of steps that counts particles with new forces
GRAVITY = 6.672041e-8  # Phantom's constant in cgs: a dump's units are to have G = 1
# Time integration and gravity as in SWIFT's own example of this problem; softened over a tenth of its spacing.
PARAMETERS = (
    UNITS
    + """\
TimeIntegration:
  time_begin: 0.
  time_end: {end}
  dt_min: 1e-9
  dt_max: {longest}
Snapshots:
  basename: flow
  time_first: 0.
  delta_time: {end}
Statistics:
  delta_time: {every}
SPH:
  resolution_eta: {eta}
  CFL_condition: 0.1
Gravity:
  eta: 0.025
  MAC: adaptive
  theta_cr: 0.7
  epsilon_fmm: 0.001
  max_physical_baryon_softening: {softening}
InitialConditions:
  file_name: start.hdf5
  periodic: 0
PhysicalConstants:
  G: 1.
"""
)


@dataclass(frozen=True)
class Length:
    """How long a run is: to a time with outputs every so often, or so many steps, none longer than `longest`."""

    end: float
    every: float
    longest: float = 1e-2
    steps: int | None = None


@dataclass(frozen=True)
class Ran:
    """Processor and wall time of a run in seconds, and its series of time, kinetic and internal energy, (n, 3)."""

    processor: float
    wall: float
    series: np.ndarray


def start(particles: int) -> Matter:
    """The particles with which `sims/evrard.toml` begins."""
    state = prepare(load.load_file(SIMS / "evrard.toml", [f"body.particles={particles}"])).evolution.state
    return Matter(state.mass, state.position, state.velocity, np.full(len(state.mass), HEAT))


def run_swift(program: Path, matter: Matter, length: Length, threads: int = 1) -> Ran:
    """A run of SWIFT; one of so many steps takes all particles in each."""
    eta = (NEIGHBOURS * 3.0 / (4.0 * np.pi)) ** (1 / 3) / REACH
    spacing = (4.0 * np.pi / 3.0 / len(matter.mass)) ** (1 / 3)
    given = {"end": length.end, "every": length.every, "longest": length.longest, "eta": eta}
    flags = [] if length.steps is None else [f"--steps={length.steps}"]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_start(folder / "start.hdf5", matter.position + SIDE / 2, matter, 1, np.full(3, SIDE), eta * spacing)
        (folder / "flow.yml").write_text(PARAMETERS.format(**given, softening=0.1 * spacing))
        options = ["--hydro", "--self-gravity", "--limiter", f"--threads={threads}", *flags, "flow.yml"]
        processor, wall = _timed([str(program.absolute()), *options], folder, threads)
        heads = next(line for line in _lines(folder / "statistics.txt") if "Kin. Energy" in line)
        names = re.split(r"\s{2,}", heads.lstrip("# ").strip())
        series = _columns(folder / "statistics.txt", names, "Time", "Kin. Energy", "Int. Energy")
        if length.steps is not None:
            updates = np.loadtxt(folder / "timesteps.txt", ndmin=2)[:, UPDATES]
            if (updates != len(matter.mass)).any():
                raise RuntimeError(
                    f"SWIFT advanced {updates.min():.0f} particles in a step: its longest must be shorter."
                )
    return Ran(processor, wall, series)


def run_phantom(program: Path, matter: Matter, length: Length, threads: int = 1) -> Ran:
    """A run of Phantom: its own input file with other times and outputs."""
    count = len(matter.mass)
    whole = {"nparttot": count, "ntypes": 1, "npartoftype": count}
    units = {"udist": 1.0, "umass": 1.0, "utime": GRAVITY**-0.5, "umagfd": 1.0}
    header = {
        0: whole | {"nblocks": 1, "nptmass": 0}, 4: whole, 7: units,
        5: {"time": 0.0, "gamma": 5 / 3, "RK2": 0.0, "massoftype": matter.mass[0]},
    }  # fmt: skip
    columns = dict(zip(("x", "y", "z", "vx", "vy", "vz"), np.hstack((matter.position, matter.velocity)).T, strict=True))
    spacing = np.full(count, (4.0 * np.pi / 3.0 / count) ** (1 / 3), np.float32)
    wanted = {"tmax": length.end, "dtmax": length.every, "nout": 10**6, "dumpfile": "flow_00000"}
    wanted["alpha"] = 0.0  # the least of the switch: as phantomsetup has it, which knows by then that there is one
    wanted |= {} if length.steps is None else {"nmax": length.steps}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        dumped = dump(header, {5: columns | {"u": matter.internal_energy}, 6: {"h": spacing}}, {})
        (folder / "flow_00000").write_bytes(dumped)
        command = [str(program.absolute()), "flow.in"]
        subprocess.run(command, cwd=folder, capture_output=True, check=False)  # writes an input file, and ends
        text = (folder / "flow.in").read_text()
        for name, value in wanted.items():
            text, found = re.subn(rf"^(\s*{name} =\s*)\S+", rf"\g<1>{value}", text, flags=re.MULTILINE)
            if found != 1:
                raise RuntimeError(f"Phantom's input file has {found} lines of {name}.")
        (folder / "flow.in").write_text(text)
        processor, wall = _timed(command, folder, threads)
        names = [name.strip() for name in re.findall(r"\[\d+ +(.+?)\]", _lines(folder / "flow01.ev")[0])]
        series = _columns(folder / "flow01.ev", names, "time", "ekin", "etherm")
    return Ran(processor, wall, series)


def _timed(command: list[str], folder: Path, threads: int) -> tuple[float, float]:
    """Processor and wall time of a command."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    settings = os.environ | {"OMP_NUM_THREADS": str(threads)}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=settings)
    wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise RuntimeError(f"{Path(command[0]).name} says: {done.stdout[-500:]} {done.stderr[-500:]}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def _lines(path: Path) -> list[str]:
    return path.read_text().splitlines()


def _columns(path: Path, names: list[str], *wanted: str) -> np.ndarray:
    return np.loadtxt(path, ndmin=2)[:, [names.index(name) for name in wanted]]
