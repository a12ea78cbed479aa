"""The command `movie`: a film of a run. Printing is left to main.py."""

import argparse
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from astroinertia.cli import result
from astroinertia.errors import SceneError

FASTEST = 240  # pictures a second

HELP = """\
Particles are shown as column density, side-on and pole-on, with the principal axes as long as the tensor makes them;
models without particles as the homogeneous ellipsoid that has their tensor. A film that is interrupted leaves no file.

example: astroinertia movie runs/coarse
         astroinertia movie runs/coarse --output coarse.gif --fps 12 --every 2
"""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the options of `movie`."""
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = HELP
    result.add_argument(command)
    command.add_argument(
        "--output", type=Path, metavar="FILE",
        help="a .mp4, which needs ffmpeg, or a .gif (default: film.mp4 beside the result, film.gif without ffmpeg)",
    )  # fmt: skip
    command.add_argument("--fps", type=float, metavar="N", help="pictures a second (default: the film lasts some 8 s)")
    command.add_argument("--every", type=int, metavar="N", help="take every Nth snapshot (default: all)")


def carry_out(options: argparse.Namespace, listener: Callable[[int, int], None]) -> str:
    """Write the film; what the command prints. SceneError and ArchiveError for what cannot be done."""
    from astroinertia.plots import movie

    if options.fps is not None and not 0.0 < options.fps <= FASTEST:
        raise SceneError(f"--fps must be a number above 0, and at most {FASTEST}.")
    if options.every is not None and options.every < 1:
        raise SceneError("--every must be a whole number of at least 1.")
    opened = result.opened(options.run)
    path = options.output or result.beside(options.run) / ("film.mp4" if movie.ffmpeg() else "film.gif")
    with result.shown(options.run):
        count = movie.write_movie(opened, opened.inertia.snapshots, path, options.fps, options.every, listener)
    return f"wrote {path}: {count} pictures"


class Bar:
    """How many pictures are done, on a terminal; nothing elsewhere."""

    def __init__(self, console: Console) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        self.bar = Progress(
            TextColumn("pictures"), BarColumn(24), MofNCompleteColumn(), TimeRemainingColumn(), console=console,
            transient=True, disable=not console.is_terminal,
        )  # fmt: skip
        self.task = self.bar.add_task("", total=None)

    def __enter__(self) -> "Bar":
        self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.bar.stop()

    def tell(self, done: int, count: int) -> None:
        """Show it."""
        self.bar.update(self.task, completed=done, total=count)
