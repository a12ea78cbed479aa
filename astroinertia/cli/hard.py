"""The command `verify --hard`: hard cases of particles, and what each was held to. Printing is left to main.py."""

import argparse
import json
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table
from rich.text import Text

from astroinertia.errors import SceneError

if TYPE_CHECKING:
    from astroinertia.verify.hard.case import Verdict

Rows = list["list[Verdict]"]  # of a family: the verdicts of each case, one a mode
EVERY_MODE = ("global", "individual", "xla")
DEFAULT_MODES = ("global", "individual")


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the options of `verify --hard`."""
    command.add_argument(
        "--hard", action="store_true",
        help="evolve hard cases of particles instead: coincident, flat, cold, at Mach 1000, in huge and tiny units",
    )  # fmt: skip
    command.add_argument(
        "--mode", action="append", default=[], choices=EVERY_MODE,
        help="of --hard: global or individual time steps with the engine numba_cpu, or the engine xla, which takes "
        "minutes to compile; may be repeated (default: global and individual)",
    )  # fmt: skip


def families(options: argparse.Namespace, begin: Callable[[str], None]) -> Iterator[tuple[str, Rows]]:
    """Each family's title and its verdicts as they are found; --only takes words of the names of cases.

    begin: hears the name of each case before it is tried.
    """
    from astroinertia.verify.hard import FAMILIES
    from astroinertia.verify.hard.case import tried

    modes = tuple(dict.fromkeys(options.mode)) or DEFAULT_MODES
    chosen = {
        title: [case for case in cases if not case.long and _asked_for(case.name, options.only)]
        for title, cases in FAMILIES.items()
    }
    if not any(chosen.values()):
        raise SceneError(f"--only '{options.only[0]:.40}' is in the name of no hard case")
    for title, cases in chosen.items():
        if cases:
            rows: Rows = []
            for case in cases:
                begin(case.name)
                rows.append([tried(case, mode) for mode in modes])
            yield title, rows


def _asked_for(name: str, words: list[str]) -> bool:
    return not words or any(word.lower() in name.lower() for word in words)


def table(title: str, rows: Rows) -> Table:
    """A family as it is shown."""
    shown = Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", title_style="bold", padding=(0, 1))
    shown.add_column("case, and what stable means", min_width=30)
    for verdict in rows[0]:
        shown.add_column(verdict.mode, min_width=24)
    for verdicts in rows:
        case = verdicts[0].case
        shown.add_row(
            Text(f"{case.name}\n").append(case.stable, style="dim"), *(_verdict_text(each) for each in verdicts)
        )
    return shown


def _verdict_text(verdict: "Verdict") -> Text:
    said = ("ended, as it must" if verdict.case.ends else "stable") if verdict.holds else "NOT STABLE"
    good = Text(said, style="green" if verdict.holds else "bold red")
    if verdict.error:
        return good.append(f"\n{verdict.error}", style="dim")
    worst = verdict.worst
    figure = (
        f"\n{verdict.steps} steps, {worst.replace('_', ' ')} {verdict.figures[worst]:.1e} of {verdict.bars[worst]:g}"
    )
    return good.append(figure, style="dim")


def total(found: Rows) -> str:
    """The last line: how many of how many are stable."""
    holds = [each.holds for verdicts in found for each in verdicts]
    return f"{sum(holds)} of {len(holds)} are stable ({len(found)} cases)"


def as_json(found: Rows) -> str:
    """Every figure of every case."""
    rows: list[dict[str, Any]] = [
        {
            "case": each.case.name, "stable_means": each.case.stable, "mode": each.mode, "stable": each.holds,
            "steps": each.steps, "figures": dict(each.figures), "bars": dict(each.bars), "error": each.error,
        }
        for verdicts in found
        for each in verdicts
    ]  # fmt: skip
    return json.dumps({"stable": all(row["stable"] for row in rows), "cases": rows}, indent=1)
