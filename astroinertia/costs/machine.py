"""How fast a machine is: what `calibrate` measured on it, kept in the user's cache, or the figures shipped here.

A calibration is a file that anybody may have touched: it is validated when it is read, and one that is broken, or is of
another machine or other versions, counts as none. Tests: tests/unit/costs/test_costs.py.
"""

import json
import math
import os
import platform
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from astroinertia.errors import ArchiveError
from astroinertia.process.cache_directory import cache_directory
from astroinertia.process.stopwatch import Seconds
from astroinertia.storage.atomic import write_json

FORMAT = 3  # raise it when a cost changes its meaning
FILE = "machine.json"
LARGEST_FILE = 1 << 16  # bytes
MOST_SECONDS, MOST_BYTES = 1e4, 1e13  # no cost is as large
_VERSIONS = ("numpy", "numba", "jax", "diffrax")  # those that carry out what is timed


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

    @property
    def content(self) -> dict[str, Any]:
        """What is kept of it, as plain data that `read` takes."""
        seconds = {name: [cost.wall, cost.processor] for name, cost in self.seconds.items()}
        return {"format": FORMAT, "machine": self.description, "seconds": seconds, "memory": self.memory}


# As `calibrate` found on two machines of two x86-64 cores with AVX-512, an AMD EPYC and an Intel Xeon that takes 1.4
# times as long: between them, by their geometric mean (tests/benchmarks/results/predicted_steps.md has runs against
# them). Costs of passes are seconds a particle with REFERENCE_NEIGHBOURS, direct.* of a pair; those of
# fixed.* are what a pass takes however few particles there are, and those of few.* a particle's of the programs that
# few have (engines.few), as one thread takes for 100 and 1000 of them; compile.sph is all that a first run of particles
# compiles, orbit a turn of a companion on a circle (costs.prediction).
REFERENCE_NEIGHBOURS = 74.0
SHIPPED_MACHINE = "a 2-core x86-64 machine"
PRECISIONS = ("mixed", "float64")
SHIPPED_SECONDS: dict[str, tuple[float, float]] = {
    "start": (2.6, 2.7),
    "prepare.ellipsoid": (4.0, 5.3),
    "step.ellipsoid": (0.00011, 0.00021),
    "record.ellipsoid": (0.0013, 0.0017),
    "record.scaling": (0.00021, 0.00022),
    "prepare.splitting": (2.4, 3.1),
    "step.splitting": (6.1e-06, 6.1e-06),
    "record.splitting": (3.1e-05, 3.9e-05),
    "step.adaptive": (1.4e-05, 1.4e-05),
    "record.adaptive": (5.4e-05, 5.8e-05),
    "prepare.adaptive": (2.1, 2.8),
    "companions": (3.4, 5.1),
    "orbit": (0.00053, 0.00053),
    "prepare.sph": (0.79, 0.69),
    "record": (0.0019, 0.0014),
    "record.particle": (5.6e-06, 9e-06),
    "rest": (3.1e-07, 3.6e-07),
    "individual.base": (0.0026, 0.0025),
    "individual.base.particle": (1.1e-07, 1.1e-07),
    "individual.end": (0.0029, 0.0029),
    "individual.particle": (3.8e-06, 3.8e-06),
    "place.particle": (0.00046, 0.00046),
    "write": (0.0051, 0.0036),
    "write.byte": (2.4e-08, 2.2e-08),
    "compile.sph": (38.0, 38.0),
    "fixed.density": (0.00012, 0.00012),
    "fixed.gradients": (0.00008, 0.00008),
    "fixed.forces": (0.0001, 0.0001),
    "fixed.multipole": (0.00046, 0.00046),
    "fixed.direct": (0.0004, 0.0004),
    "fixed.rest": (0.0021, 0.0021),
    "few.density": (8.1e-07, 8.1e-07),
    "few.gradients": (1.09e-06, 1.09e-06),
    "few.forces": (2.2e-06, 2.2e-06),
    "few.multipole": (1.37e-06, 1.37e-06),
    "few.direct": (1.96e-09, 1.96e-09),
    "few.rest": (1.02e-06, 1.02e-06),
    "mixed.density": (3.2e-07, 5.9e-07),
    "mixed.gradients": (2.5e-07, 4.8e-07),
    "mixed.forces": (3.6e-07, 7.5e-07),
    "mixed.multipole": (8.3e-07, 1.5e-06),
    "mixed.direct": (2.3e-10, 4.6e-10),
    "float64.density": (4.2e-07, 7.2e-07),
    "float64.gradients": (4.2e-07, 7.6e-07),
    "float64.forces": (7.6e-07, 1.5e-06),
    "float64.multipole": (1.7e-06, 3.2e-06),
    "float64.direct": (6.1e-10, 1.2e-09),
}
# Bytes of a run that does next to nothing, from the same, and bytes a particle more: the most that a step of Evrard's
# cloud holds, rounded up (tests/benchmarks/results/memory.md).
SHIPPED_MEMORY = {
    "scaling": 360000000.0,
    "ellipsoid": 730000000.0,
    "splitting": 520000000.0,
    "adaptive": 690000000.0,
    "sph": 500000000.0,
    "particle.mixed": 1700.0,
    "particle.float64": 1700.0,
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
    with suppress(OSError, ArchiveError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, machine.content)
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
