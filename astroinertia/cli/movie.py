"""The command `movie`: a film of a run. Printing is left to main.py."""

from pathlib import Path

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError
from astroinertia.run.meter import Meter

FASTEST = 240  # pictures a second

HELP = """\
Particles are shown as column density, side-on and pole-on, with the principal axes as long as the tensor makes them;
models without particles as the homogeneous ellipsoid that has their tensor. A film that is interrupted leaves no file.

example: astroinertia movie runs/coarse
         astroinertia movie runs/coarse --output coarse.gif --fps 12 --every 2
         astroinertia movie runs/sweep --member 3
"""


def add_arguments(add: Add) -> None:
    """Add the options of `movie`."""
    result.add_argument(add)
    add("--output", type=Path, metavar="FILE",
        help="a .mp4, which needs ffmpeg, or a .gif (default: film.mp4 beside the result, film.gif without "
        "ffmpeg)")  # fmt: skip
    add("--fps", type=float, metavar="N", help="pictures a second (default: the film lasts some 8 s)")
    add("--every", type=int, metavar="N", help="take every Nth snapshot (default: all)")


def carry_out(options: Options, meter: Meter) -> str:
    """Write the film; what the command prints. SceneError and ArchiveError for what cannot be done."""
    if options.fps is not None and not 0.0 < options.fps <= FASTEST:
        raise SceneError(f"--fps must be a number above 0, and at most {FASTEST}.")
    if options.every is not None and options.every < 1:
        raise SceneError("--every must be a whole number of at least 1.")
    from astroinertia.plots import movie

    run, opened = result.of_one_run(options.run, options.member, "movie")
    path = options.output or result.place_beside(run) / ("film.mp4" if movie.ffmpeg() else "film.gif")

    def tell(done: int, count: int) -> None:
        meter.show(done / count, f"{done} of {count} pictures")

    with result.shown(run):
        count = movie.write_movie(opened, opened.inertia.snapshots, path, options.fps, options.every, tell)
    return f"wrote {path}: {count} picture{'s' * (count > 1)}"
