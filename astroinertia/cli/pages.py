"""The commands `report` and `view`: pages of a run. Printing is left to main.py."""

import argparse
from pathlib import Path

from astroinertia.cli import result


def add_arguments(command: argparse.ArgumentParser, name: str) -> None:
    """Add the options of a command that writes a page of that name."""
    result.add_argument(command)
    command.add_argument(
        "--output", type=Path, metavar="FILE.html", help=f"where to write it (default: {name}.html beside the result)"
    )


def report(options: argparse.Namespace) -> str:
    """What `report` prints; the page is written first."""
    from astroinertia.pages.report import write_report

    opened, path = result.opened(options.run), _path(options, "report")
    with result.shown(options.run):
        count = write_report(opened, opened.inertia.snapshots, path)
    return f"wrote {path}: one file with {count} pictures, for any browser"


def view(options: argparse.Namespace) -> str:
    """What `view` prints; the page is written first."""
    from astroinertia.pages.view import write_view

    opened, path = result.opened(options.run), _path(options, "view")
    with result.shown(options.run):
        count = write_view(opened, opened.inertia.snapshots, path)
    return f"wrote {path}: {count} times to turn about; open it in a browser"


def _path(options: argparse.Namespace, name: str) -> Path:
    return options.output or result.beside(options.run) / f"{name}.html"
