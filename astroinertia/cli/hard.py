"""The command `verify --hard`: hard cases of particles, and what each was held to. Printing is left to main.py."""

import json
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.table import Table
from rich.text import Text

from astroinertia.cli.parser import Add, Options
from astroinertia.cli.screen import titled
from astroinertia.errors import SceneError

if TYPE_CHECKING:
    from astroinertia.verify.hard.case import Verdict

EVERY_MODE = ("global", "individual", "xla")
DEFAULT_MODES = ("global", "individual")


class Family(NamedTuple):
    """Cases of one kind: the verdicts of each, one a mode."""

    title: str
    rows: "list[list[Verdict]]"

    @property
    def holds(self) -> bool:
        """Whether every verdict is good."""
        return all(verdict.holds for verdicts in self.rows for verdict in verdicts)


def add_arguments(add: Add) -> None:
    """Add the options of `verify --hard`."""
    add("--hard", action="store_true",
        help="evolve hard cases of particles instead: coincident, in a plane, at zero temperature, at Mach 1000, "
        "in units of 1e30; --only takes words of their names")  # fmt: skip
    add("--mode", action="append", default=[], choices=EVERY_MODE,
        help="of --hard: global or individual time steps with the engine numba_cpu, or the engine xla, which takes "
        "minutes to compile; may be repeated (default: global and individual)")  # fmt: skip


def parts(options: Options, begin: Callable[[str], None]) -> Iterator[Family]:
    """The families, one by one as they are tried; --only takes words of the names of cases.

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
        names = ", ".join(case.name for cases in FAMILIES.values() for case in cases if not case.long)
        raise SceneError(f"--only '{options.only[0]:.40}' is in the name of no hard case; they are: {names}")
    for title, cases in chosen.items():
        if cases:
            family = Family(title, [])
            for case in cases:
                begin(case.name)
                family.rows.append([tried(case, mode) for mode in modes])
            yield family


def _asked_for(name: str, words: list[str]) -> bool:
    return not words or any(word.lower() in name.lower() for word in words)


def table(family: Family, _: int) -> Table:
    """A family as it is shown, on a console of any width."""
    rows = family.rows
    shown = titled(family.title)
    shown.add_column("case, and what stable means", min_width=30)
    for verdict in rows[0]:
        shown.add_column(verdict.mode, min_width=24)
    for verdicts in rows:
        case = verdicts[0].case
        shown.add_row(
            Text(f"{case.name}\n").append(case.stable, style="dim"), *(_verdict_text(one) for one in verdicts)
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


def total(families: list[Family], _: float) -> str:
    """The last line: how many of how many are stable."""
    cases = [verdicts for family in families for verdicts in family.rows]
    holds = [verdict.holds for verdicts in cases for verdict in verdicts]
    return f"{sum(holds)} of {len(holds)} are stable ({len(cases)} cases)"


def as_json(families: list[Family]) -> str:
    """Every figure of every case."""
    rows: list[dict[str, Any]] = [
        {
            "case": verdict.case.name, "stable_means": verdict.case.stable, "mode": verdict.mode,
            "stable": verdict.holds, "steps": verdict.steps, "figures": dict(verdict.figures),
            "bars": dict(verdict.bars), "error": verdict.error,
        }
        for family in families
        for verdicts in family.rows
        for verdict in verdicts
    ]  # fmt: skip
    return json.dumps({"stable": all(row["stable"] for row in rows), "cases": rows}, indent=1)
