"""How fast a machine is: what `calibrate` measured on it, kept in the user's cache, or the figures shipped here.

A calibration is a file that anybody may have touched: it is validated when it is read, and one that is broken, or is of
another machine or other versions, counts as none. Tests: tests/unit/test_costs.py.
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

from astroinertia.cache import cache_directory
from astroinertia.errors import ArchiveError
from astroinertia.sealed import write_json

FORMAT = 1  # raise it when a price changes its meaning
FILE = "machine.json"
LARGEST_FILE = 1 << 16  # bytes
MOST_SECONDS, MOST_BYTES = 1e4, 1e13  # no honest price is as large
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

    seconds: {price: Seconds}, as SHIPPED_SECONDS has them; memory: bytes, as SHIPPED_MEMORY; calibrated: whether they
    were measured here; description: the machine and the versions that they are of.
    """

    seconds: dict[str, Seconds]
    memory: dict[str, float]
    calibrated: bool
    description: dict[str, Any]


# Two cores with AVX-512 (see tests/benchmarks/results/predictions.md). Prices of passes are seconds a particle with
# REFERENCE_NEIGHBOURS, direct.* a pair; those of fixed.* are what a pass takes however few particles there are.
REFERENCE_NEIGHBOURS = 74.0
PASSES = ("density", "gradients", "forces", "direct", "multipole")
PRECISIONS = ("mixed", "float64")
SHIPPED_SECONDS: dict[str, tuple[float, float]] = {
    "start": (2.5, 3.0),
    "prepare.sph": (2.0, 2.0),
    "prepare.ellipsoid": (4.0, 5.0),
    "prepare.splitting": (3.0, 4.0),
    "prepare.adaptive": (3.0, 4.0),
    "companions": (4.0, 5.0),
    "compile.sph": (60.0, 60.0),
    "fixed.density": (3e-4, 4e-4),
    "fixed.gradients": (3e-4, 4e-4),
    "fixed.forces": (3e-4, 4e-4),
    "fixed.direct": (2e-4, 2e-4),
    "fixed.multipole": (4e-4, 5e-4),
    "fixed.rest": (3e-3, 3e-3),
    **{f"mixed.{name}": price for name, price in {
        "density": (3.0e-7, 6.0e-7), "gradients": (1.5e-7, 3.0e-7), "forces": (2.5e-7, 5.0e-7),
        "direct": (2.0e-10, 4.0e-10), "multipole": (7.0e-7, 1.4e-6),
    }.items()},
    **{f"float64.{name}": price for name, price in {
        "density": (5.0e-7, 1.0e-6), "gradients": (2.5e-7, 5.0e-7), "forces": (4.5e-7, 9.0e-7),
        "direct": (5.5e-10, 1.1e-9), "multipole": (1.4e-6, 2.8e-6),
    }.items()},
    "rest": (3e-7, 4e-7),
    "individual.end": (8e-3, 9e-3),
    "individual.particle": (1e-6, 2e-6),
    "record": (5e-3, 5e-3),
    "record.particle": (1e-6, 1e-6),
    "write": (2e-2, 1e-2),
    "write.byte": (2e-8, 2e-8),
    "place.particle": (1e-3, 1e-3),
    "record.ellipsoid": (1.5e-2, 1.5e-2),
    "step.ellipsoid": (3e-4, 3e-4),
    "record.splitting": (8e-3, 8e-3),
    "step.splitting": (1e-5, 1e-5),
    "record.adaptive": (1.5e-2, 1.5e-2),
    "step.adaptive": (1e-4, 1e-4),
    "record.scaling": (1e-3, 1e-3),
}  # fmt: skip
# Bytes of a run that does next to nothing, and bytes a particle more: the most that a step of Evrard's cloud holds,
# rounded up (tests/benchmarks/results/memory.md).
SHIPPED_MEMORY = {
    "scaling": 3.6e8, "splitting": 5.0e8, "adaptive": 6.3e8, "ellipsoid": 7.1e8, "sph": 5.0e8, "particle.mixed": 2100.0,
    "particle.float64": 2000.0,
}  # fmt: skip


def shipped() -> Machine:
    """The machine that the package's own figures are of."""
    seconds = {name: Seconds(*pair) for name, pair in SHIPPED_SECONDS.items()}
    return Machine(seconds, dict(SHIPPED_MEMORY), False, {"processor": "two cores with AVX-512"})


def known() -> Machine:
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
    found = {name: Seconds(*map(float, pair)) for name, pair in seconds.items()}
    return Machine(found, {name: float(value) for name, value in memory.items()}, True, description)


def _sound(value: Any, most: float) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(value) and 0.0 <= value <= most


def keep(machine: Machine) -> Path | None:
    """Keep a calibration in the user's cache; its file, or None where that cannot be written."""
    path = cache_directory() / FILE
    content = {
        "format": FORMAT,
        "machine": machine.description,
        "seconds": {name: [each.wall, each.processor] for name, each in machine.seconds.items()},
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
