"""What a solver's accuracy costs: its error and time at each setting of its knob, as a table."""

import argparse
import os
import platform
import time
from collections.abc import Callable, Iterable
from pathlib import Path

RESULTS = Path(__file__).parent / "results"


def seconds(action: Callable[[], object], least: float = 0.2) -> float:
    """The shortest of repeated runs that last `least` seconds together, two at least."""
    best, spent, runs = float("inf"), 0.0, 0
    while spent < least or runs < 2:
        begin = time.perf_counter()
        action()
        last = time.perf_counter() - begin
        best, spent, runs = min(best, last), spent + last, runs + 1
    return best


def table(
    title: str,
    knob: str,
    settings: Iterable,
    action: Callable[[object], object],
    error: Callable[[object], float],
    default: object,
) -> str:
    """A table of `settings`: `action(setting)` gives a result, `error(result)` its relative error.

    The row of the solver's default is marked.
    """
    rows = [f"**{title}**\n", f"| {knob} | error | time (ms) | |", "|---|---|---|---|"]
    for setting in settings:
        result = action(setting)
        took = seconds(lambda setting=setting: action(setting))
        mark = "default" if setting == default else ""
        rows.append(f"| {setting} | {error(result):.1e} | {1e3 * took:.3g} | {mark} |")
    return "\n".join(rows) + "\n"


def publish(topic: str, tables: Iterable[str]) -> None:
    """Print the tables; with `--keep` write them to results/work_precision_<topic>.md, too."""
    parser = argparse.ArgumentParser(description=f"Error against time: {topic}.")
    parser.add_argument("--keep", action="store_true", help="write the tables to tests/benchmarks/results")
    options = parser.parse_args()
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    text = f"# Error against time: {topic}\n\n{machine}; the shortest of repeated runs.\n\n" + "\n".join(tables)
    print(text)
    if options.keep:
        (RESULTS / f"work_precision_{topic}.md").write_text(text)
