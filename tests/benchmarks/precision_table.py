"""What a solver's accuracy costs: its error and time at each setting of its knob, as a table and a picture."""

import argparse
import os
import platform
import re
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


def picture(text: str, file: Path) -> None:
    """Draw error against time: a panel for each problem, a line for each way to solve it ("problem: way" in titles)."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot, ticker

    curves: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for title, rows in re.findall(r"\*\*(.+?)\*\*\n+((?:\|.*\n)+)", text):
        problem, _, way = title.partition(": ")
        cells = [[cell.strip() for cell in row.split("|")] for row in rows.splitlines()[2:]]
        curves.setdefault(problem, {})[way] = [(float(row[3]), float(row[2])) for row in cells]
    columns = min(3, len(curves))
    shape = (-(-len(curves) // columns), columns)
    size = (4.6 * columns, 3.6 * shape[0])
    figure, panels = pyplot.subplots(*shape, figsize=size, squeeze=False, layout="constrained")
    for panel, (problem, ways) in zip(panels.flat, curves.items(), strict=False):
        for way, points in ways.items():
            panel.loglog(*zip(*points, strict=True), marker="o", markersize=4, label=way or None)
        panel.set_title(problem, fontsize=8, wrap=True)
        panel.set(xlabel="time (ms)", ylabel="error")
        panel.xaxis.set_major_formatter("{x:g}")
        panel.xaxis.set_minor_formatter(ticker.LogFormatter(minor_thresholds=(1, 0.5)))
        panel.grid(alpha=0.3)
        if any(ways):
            panel.legend(fontsize=7)
    for panel in panels.flat[len(curves) :]:
        panel.set_visible(False)
    figure.savefig(file, dpi=90)
    pyplot.close(figure)


def publish(topic: str, tables: Iterable[str]) -> None:
    """Print the tables; with `--keep` write them to results/work_precision_<topic>.md, and draw them beside it."""
    parser = argparse.ArgumentParser(description=f"Error against time: {topic}.")
    parser.add_argument("--keep", action="store_true", help="write tables and a picture to tests/benchmarks/results")
    options = parser.parse_args()
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    text = f"# Error against time: {topic}\n\n{machine}; the shortest of repeated runs.\n\n" + "\n".join(tables)
    print(text)
    if options.keep:
        file = RESULTS / f"work_precision_{topic}.md"
        file.write_text(text)
        picture(text, file.with_suffix(".png"))
