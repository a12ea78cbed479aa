"""The commands `report` and `view`: pages of a run. Printing is left to main.py."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options


def add_arguments(add: Add, name: str) -> None:
    """Add the options of a command that writes a page of that name."""
    result.add_argument(add)
    add("--output", type=Path, metavar="FILE.html", help=f"where to write it (default: {name}.html beside the result)")


def report(options: Options) -> str:
    """What `report` prints; the page is written first."""
    from astroinertia.pages.report import write_report

    path, count = _written(options, "report", write_report)
    return f"wrote {path}: one file with {count} pictures, for any browser"


def view(options: Options) -> str:
    """What `view` prints; the page is written first."""
    from astroinertia.pages.view import write_view

    path, count = _written(options, "view", write_view)
    return f"wrote {path}: {count} times to turn about; open it in a browser"


def _written(options: Options, name: str, write: Callable[..., Any]) -> tuple[Path, int]:
    result.must_be_writable(options.output, ".html")
    run, opened = result.of_one_run(options.run, options.member, name)
    path = options.output or result.place_beside(run) / f"{name}.html"
    with result.shown(run):
        return path, write(opened, opened.inertia.snapshots, path)
