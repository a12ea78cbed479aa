"""The command `show`: its arguments, and its pictures, by two processes where they pay. Printing is left to main.py."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError
from astroinertia.process.cores import cores

if TYPE_CHECKING:
    import subprocess

    import xarray as xr

OF_PARTICLES = ("density", "projection", "exact")  # as `plots.pictures` has them, which imports what draws them


def add_arguments(add: Add) -> None:
    """Add the options of `show`."""
    result.add_argument(add, "file")
    add("--output", type=Path, metavar="DIR", help="folder for the pictures (default: beside the file)")
    add("--only", action="append", default=[], metavar="NAME",
        help="this picture without the summary, such as spin or density; may be repeated")  # fmt: skip


@contextmanager
def particles_drawn_beside(options: Options) -> "Iterator[subprocess.Popen[str] | None]":
    """A process that draws the particles meanwhile; None where there are none, or no second core.

    Their pictures take as long as all others, and with numba much that is imported for them alone.
    """
    alone = options.only or options.member is not None or cores() < 2
    if alone or not any(result.beside(options.file).glob("snapshots-*.npz")):
        yield None
        return
    from astroinertia.process.children import started

    names = [word for name in OF_PARTICLES for word in ("--only", name)]
    place = [] if options.output is None else ["--output", str(options.output)]
    with started([sys.executable, "-m", "astroinertia", "show", *names, *place, "--", str(options.file)]) as child:
        yield child


def written(options: Options, file: Path, opened: "xr.Dataset", beside: "subprocess.Popen[str] | None") -> list[Path]:
    """The pictures of a result, all written; SceneError for one that there is not.

    Those that a process beside this one should have drawn and did not, are drawn here, or fail as they do.
    """
    from astroinertia import plots
    from astroinertia.plots.pictures import FIGURES

    unknown = [name for name in options.only if name not in (*FIGURES, *OF_PARTICLES)]
    if unknown:
        raise SceneError(
            f"--only knows no picture {unknown[0]!r}: it is one of {', '.join((*FIGURES, *OF_PARTICLES))}."
        )
    folder = options.output or result.place_beside(file)
    if beside is None:
        return plots.write_all(opened, folder, only=options.only or (*FIGURES, *OF_PARTICLES))
    own = plots.write_all(opened, folder, only=FIGURES)
    said, _ = beside.communicate()
    if beside.returncode:
        return own + plots.write_all(opened, folder, only=OF_PARTICLES)
    drawn = {Path(line.strip()).stem for line in said.splitlines()}
    return own + [folder / f"{name}.png" for name in OF_PARTICLES if name in drawn]
