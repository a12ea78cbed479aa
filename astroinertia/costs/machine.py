"""How fast a machine is: what `calibrate` measured on it, kept in the user's cache, or the figures shipped here.

A calibration is a file that anybody may have touched: it is validated when it is read, and one that is broken, or is of
another machine or other versions, counts as none. Tests: tests/unit/costs/test_costs.py.
"""

import json
import math
import os
import platform
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from astroinertia.errors import ArchiveError
from astroinertia.storage.atomic import write_json
from astroinertia.storage.cache import cache_directory

FORMAT = 1  # raise it when a cost changes its meaning
FILE = "machine.json"
LARGEST_FILE = 1 << 16  # bytes
MOST_SECONDS, MOST_BYTES = 1e4, 1e13  # no honest cost is as large
_VERSIONS = ("numpy", "numba", "jax", "diffrax")  # those that carry out what is timed


@dataclass(frozen=True)
class Seconds:
    """A time by the clock on the wall, and the processor time of all threads together."""

    wall: float = 0.0
    processor: float = 0.0

    def __add__(self, other: "Seconds") -> "Seconds":
        return Seconds(self.wall + other.wall, self.processor + other.processor)

    def __mul__(self, factor: float) -> "Seconds":
        return Seconds(self.wall * factor, self.processor * factor)

    __rmul__ = __mul__


def total(times: Iterable[Seconds]) -> Seconds:
    """The sum of times."""
    return sum(times, start=Seconds())


def less(whole: Seconds, part: Seconds) -> Seconds:
    """What is left of a time without a part of it; nothing where noise made the part longer."""
    return Seconds(max(0.0, whole.wall - part.wall), max(0.0, whole.processor - part.processor))


@dataclass(frozen=True)
class Machine:
    """What things take on a machine.

    seconds: {name: Seconds}, as SHIPPED_SECONDS has them; memory: bytes, as SHIPPED_MEMORY; calibrated: whether they
    were measured here; description: the machine and the versions that they are of.
    """

    seconds: dict[str, Seconds]
    memory: dict[str, float]
    calibrated: bool
    description: dict[str, Any]


# As `calibrate` found on a 2-core x86-64 machine that other jobs shared: processor times, and wall times that are those
# over two where both cores share the work. Costs of passes are seconds a particle with REFERENCE_NEIGHBOURS, direct.*
# of a pair; those of fixed.* are what a pass takes however few particles there are. compile.sph is of
# a first run with 500 particles on such a machine that did nothing else (tests/benchmarks/results/cold_start.md).
REFERENCE_NEIGHBOURS = 74.0
SHIPPED_MACHINE = "a 2-core x86-64 machine"
PRECISIONS = ("mixed", "float64")
SHIPPED_SECONDS: dict[str, tuple[float, float]] = {
    "start": (4.0, 4.0),
    "prepare.ellipsoid": (10.0, 10.0),
    "step.ellipsoid": (0.00057, 0.00057),
    "record.ellipsoid": (0.0085, 0.0085),
    "record.scaling": (0.00046, 0.00046),
    "prepare.splitting": (3.2, 3.2),
    "step.splitting": (9.5e-06, 9.5e-06),
    "record.splitting": (0.009, 0.009),
    "step.adaptive": (5e-05, 5e-05),
    "record.adaptive": (0.022, 0.022),
    "prepare.adaptive": (4.5, 4.5),
    "companions": (6.5, 6.5),
    "prepare.sph": (1.3, 1.3),
    "record": (0.0024, 0.0024),
    "record.particle": (1e-05, 1e-05),
    "rest": (3.1e-07, 3.1e-07),
    "individual.end": (0.0069, 0.0069),
    "individual.particle": (5.6e-06, 1.1e-05),
    "place.particle": (0.00064, 0.00064),
    "write": (0.0083, 0.0083),
    "write.byte": (3.4e-08, 3.4e-08),
    "compile.sph": (30.0, 30.0),
    "fixed.density": (0.00016, 0.00016),
    "fixed.gradients": (0.00035, 0.00035),
    "fixed.forces": (0.00035, 0.00035),
    "fixed.multipole": (1.4e-05, 1.4e-05),
    "fixed.direct": (0.0005, 0.0005),
    "fixed.rest": (0.0041, 0.0041),
    "mixed.density": (1.7e-06, 3.5e-06),
    "mixed.gradients": (1.2e-06, 2.5e-06),
    "mixed.forces": (1.8e-06, 3.7e-06),
    "mixed.multipole": (1.2e-06, 2.4e-06),
    "mixed.direct": (4.9e-10, 9.9e-10),
    "float64.density": (2.1e-06, 4.1e-06),
    "float64.gradients": (1.5e-06, 3.1e-06),
    "float64.forces": (2.5e-06, 4.9e-06),
    "float64.multipole": (3.4e-06, 6.9e-06),
    "float64.direct": (1.4e-09, 2.9e-09),
}
# Bytes of a run that does next to nothing, from the same, and bytes a particle more: the most that a step of Evrard's
# cloud holds, rounded up (tests/benchmarks/results/memory.md).
SHIPPED_MEMORY = {
    "scaling": 360000000.0,
    "ellipsoid": 730000000.0,
    "splitting": 520000000.0,
    "adaptive": 690000000.0,
    "sph": 500000000.0,
    "particle.mixed": 2100.0,
    "particle.float64": 2000.0,
}


def shipped() -> Machine:
    """The machine that the package's own figures are of."""
    seconds = {name: Seconds(*pair) for name, pair in SHIPPED_SECONDS.items()}
    return Machine(seconds, dict(SHIPPED_MEMORY), False, {"processor": SHIPPED_MACHINE})


def current() -> Machine:
    """This machine as it was calibrated, or else the one that the package's own figures are of."""
    try:
        with (cache_directory() / FILE).open("rb") as file:
            content = json.loads(file.read(LARGEST_FILE))
    except (OSError, ValueError, RecursionError):
        return shipped()
    return read(content, described()) or shipped()


def read(content: Any, description: dict[str, Any]) -> Machine | None:
    """A calibration of the machine described; None where `content` is something else, or of another machine."""
    if not isinstance(content, dict) or content.get("format") != FORMAT or content.get("machine") != description:
        return None
    seconds, memory = content.get("seconds"), content.get("memory")
    if not (isinstance(seconds, dict) and isinstance(memory, dict)):
        return None
    if seconds.keys() != SHIPPED_SECONDS.keys() or memory.keys() != SHIPPED_MEMORY.keys():
        return None
    pairs = [pair for pair in seconds.values() if isinstance(pair, list) and len(pair) == 2]
    numbers = [(value, MOST_SECONDS) for pair in pairs for value in pair]
    numbers += [(value, MOST_BYTES) for value in memory.values()]
    if len(pairs) < len(seconds) or not all(_sound(value, most) for value, most in numbers):
        return None
    costs = {name: Seconds(*map(float, pair)) for name, pair in seconds.items()}
    return Machine(costs, {name: float(value) for name, value in memory.items()}, True, description)


def _sound(value: Any, most: float) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(value) and 0.0 <= value <= most


def keep(machine: Machine) -> Path | None:
    """Keep a calibration in the user's cache; its file, or None where that cannot be written."""
    path = cache_directory() / FILE
    content = {
        "format": FORMAT,
        "machine": machine.description,
        "seconds": {name: [cost.wall, cost.processor] for name, cost in machine.seconds.items()},
        "memory": machine.memory,
    }
    with suppress(OSError, ArchiveError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, content)
        return path
    return None


@lru_cache(maxsize=1)
def described() -> dict[str, Any]:
    """This machine and the versions of what is timed, as plain data."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "threads": os.environ.get("NUMBA_NUM_THREADS", ""),
        "system": platform.system(),
        "python": platform.python_version(),
        **{name: version(name) for name in _VERSIONS},
    }


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return f"{platform.machine()}, {line.partition(':')[2].strip()}"
    return f"{platform.machine()} {platform.processor()}".strip()


def peak_memory() -> float:
    """The most bytes that this process has held, by what the system tells; NaN where it tells nothing."""
    # What the kernel tells of a process outlives its start by another one; this line is of the process alone.
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return 1024.0 * int(line.split()[1])
    with suppress(ImportError, OSError):
        import resource

        largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return float(largest) * (1.0 if platform.system() == "Darwin" else 1024.0)
    return math.nan
