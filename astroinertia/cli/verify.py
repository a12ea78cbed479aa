"""The command `verify`: its arguments, and what it says. Printing is left to main.py."""

import json
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from astroinertia.cli.parser import Add, Options
from astroinertia.cli.screen import titled
from astroinertia.errors import SceneError

if TYPE_CHECKING:
    from astroinertia.verify.comparison import Section

WIDTH = 150  # columns of the table where the output is no terminal
NARROW = 120  # columns below which the source goes under the quantity
HELP = """\
Every number in the column "here" is computed when the command runs, by the functions that runs and studies use. The
references are in a cited table (data/verify.csv), or are computed by REBOUND or astropy, where the source says so. The
difference is relative (rel) or absolute (abs); an error or a drift has no reference and stays below its tolerance.
Where a tolerance comes from, --json says: the digits printed, what a theory leaves out, or round-off.

The exit code is 1 if one verdict is not good.

example: astroinertia verify
         astroinertia verify --only ellipsoids --only neutron_stars
         astroinertia verify --json > verify.json
         astroinertia verify --hard --only coincident
"""


def add_arguments(add: Add) -> None:
    """Add the options of `verify`."""
    add("--only", action="append", default=[], metavar="SECTION",
        help="one section of the table, such as polytropes (a wrong name lists them), or a word of hard cases' names; "
        "may be repeated")  # fmt: skip
    add("--json", action="store_true", help="print everything as JSON, with the reasons of tolerances")


def parts(options: Options, begin: Callable[[str], None]) -> "Iterator[Section]":
    """The sections that are asked for, one by one as they are computed; SceneError for one there is not.

    begin: hears the title of each before it is computed.
    """
    from astroinertia.verify.comparison import SECTIONS, compare_sections

    if options.mode:
        raise SceneError("--mode is of --hard; give both, or neither")
    unknown = [name for name in options.only if name not in SECTIONS]
    if unknown:
        raise SceneError(f"--only has no section '{unknown[0]:.40}'; it has {', '.join(SECTIONS)}")
    return compare_sections(tuple(dict.fromkeys(options.only) or SECTIONS), begin)


def table(section: "Section", width: int = WIDTH) -> Table:
    """One section as it is shown; on narrow terminals the source stands below the quantity."""
    wide = width >= NARROW
    shown = titled(f"{section.title}  ({section.seconds:.1f} s)", padding=(0, 1 if wide else 0), pad_edge=False)
    shown.add_column("quantity", min_width=16)
    for name in ("here", "reference", *(["source"] if wide else []), "difference", "tolerance", "verdict"):
        words = name in ("source", "verdict")
        shown.add_column(name, justify="left" if words else "right", no_wrap=name != "source")
    for comparison in section.comparisons:
        reference, below = comparison.reference, comparison.reference.measure == "below"
        quantity = Text(reference.quantity + ("" if reference.unit == "1" else f" ({reference.unit})"))
        source = Text(reference.source, style="dim")
        problem = [Text(comparison.problem, style="red")] if comparison.problem else []
        measure, digits = "" if below else f" {reference.measure[:3]}", 3 if below else 10 if wide else 7
        shown.add_row(
            Text("\n").join([quantity, *([] if wide else [source]), *problem]),
            f"{comparison.here:.{digits}g}",
            "-" if below else f"{comparison.there:.{digits}g}",
            *([source] if wide else []),
            "-" if below else f"{comparison.difference:+.1e}{measure}",
            f"{reference.tolerance:g}{measure}",
            Text(comparison.verdict, style="green" if comparison.verdict == "agrees" else "bold red"),
        )
    return shown


def total(sections: "list[Section]", seconds: float) -> str:
    """The last line: how many of how many agree, and in how long."""
    verdicts = [comparison.verdict for section in sections for comparison in section.comparisons]
    good = sum(verdict == "agrees" for verdict in verdicts)
    return f"{good} of {len(verdicts)} agree, in {seconds:.0f} s"


def as_json(sections: "list[Section]") -> str:
    """Everything that is known of every comparison."""
    rows: list[dict[str, Any]] = [comparison.plain() for section in sections for comparison in section.comparisons]
    content = {
        "agree": all(section.holds for section in sections),
        "seconds": round(sum(section.seconds for section in sections), 2),
        "sections": {section.name: round(section.seconds, 2) for section in sections},
        "comparisons": rows,
    }
    return json.dumps(content, indent=1)
