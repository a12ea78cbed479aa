"""Times that can be compared although other work shares the machine, and tables that say where they were taken."""

import os
import platform
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from astroinertia.engines.threads import available_threads

RESULTS = Path(__file__).parent / "results"


def best_times(
    actions: Mapping[Any, Callable[[], Any]],
    rounds: int,
    clock: Callable[[], float] = time.perf_counter,
    compiled: bool = False,
) -> dict[Any, float]:
    """The shortest time of each action in so many rounds of all of them, after one that compiles what is not compiled.

    Other work only ever adds to a time, and falls on all alike where they take turns.
    """
    best = dict.fromkeys(actions, float("inf"))
    for action in () if compiled else actions.values():
        action()
    for _ in range(rounds):
        for name, action in actions.items():
            begin = clock()
            action()
            best[name] = min(best[name], clock() - begin)
    return best


def processor_clock() -> float:
    """Processor time of all threads, in seconds a core."""
    return time.process_time() / available_threads()


def clock_of(processor_time: bool) -> tuple[Callable[[], float], str]:
    """The clock that a program was asked for, and what it counts in words."""
    if processor_time:
        return processor_clock, "processor time shared by the threads"
    return time.perf_counter, "wall time"


def machine() -> str:
    """The machine in words, and what else it was doing."""
    load = f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "load unknown"
    return (
        f"{available_threads()} threads on {os.cpu_count()} cores, {processor()}, Python {platform.python_version()}, "
        f"{load}"
    )


def processor() -> str:
    """What kind of processor it is, and the widest vectors that it has, as far as the system tells."""
    try:
        fields = dict(
            (part.strip() for part in line.split(":", 1))
            for line in Path("/proc/cpuinfo").read_text().splitlines()
            if ":" in line
        )
    except OSError:
        return platform.machine()
    flags = fields.get("flags", "").split()
    widest = next((name for name in ("avx512f", "avx2", "avx") if name in flags), "")
    return ", ".join(part for part in (platform.machine(), fields.get("model name", ""), widest) if part)


def rows_of(head: list[str], rows: list[list[Any]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def publish(name: str, text: str, keep: bool) -> None:
    """Print a result; with `keep` write it to results/<name>.md."""
    print(text)
    if keep:
        RESULTS.mkdir(exist_ok=True)
        (RESULTS / f"{name}.md").write_text(text, encoding="utf-8")
