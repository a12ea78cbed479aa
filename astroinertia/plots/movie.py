"""Films of a run: MP4 where ffmpeg is to be had, else GIF. A film is written whole or not at all."""

import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
import xarray as xr
from PIL import Image

from astroinertia.errors import ArchiveError
from astroinertia.plots import film
from astroinertia.process import interrupts
from astroinertia.storage import overwriting
from astroinertia.storage.atomic import write_whole

SUFFIXES = (".mp4", ".gif")
LASTS = 8.0  # seconds, of a film whose rate is not said
SLOWEST, FASTEST = 4.0, 25.0  # pictures a second, unless said otherwise
_DPI = {".mp4": 130, ".gif": 75}  # a GIF of the size of an MP4 would be tens of megabytes
_COLOURS = 256
SHORTEST = 20  # milliseconds that a picture of a GIF is shown: viewers slow down what is shorter


def write_movie(
    dataset: xr.Dataset,
    snapshots: xr.Dataset | None,
    path: Path,
    fps: float | None = None,
    every: int | None = None,
    listener: Callable[[int, int], None] | None = None,
) -> int:
    """Write the film of a run's snapshots, or of its outputs where it has no particles; how many pictures it has.

    path: ends in .mp4 or .gif. fps: pictures a second; without it the film lasts some 8 s. every: take every so many
    snapshots. listener: called with the pictures that are done and their number. ArchiveError for what cannot be filmed
    or written; nothing is left behind then, nor after Ctrl-C. Tests: tests/unit/plots/test_film.py.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(write_movie(ds, ds.inertia.snapshots, Path(folder, "star.gif")))  # pictures, one a snapshot
    3
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ArchiveError(f"{path} cannot be written: a film ends in .mp4 or .gif.")
    overwriting.check(path, overwriting.MP4 if suffix == ".mp4" else overwriting.GIF)
    program = ffmpeg() if suffix == ".mp4" else None
    if suffix == ".mp4" and program is None:
        raise ArchiveError(
            f"{path} cannot be written: there is no ffmpeg; install it, or `pip install imageio-ffmpeg`, or end the "
            "name in .gif."
        )
    numbers = film.chosen(dataset, snapshots, every)
    rate = fps or float(np.clip(len(numbers) / LASTS, SLOWEST, FASTEST))
    pictures = _counted(film.frames(dataset, snapshots, numbers, _DPI[suffix]), len(numbers), listener)

    def fill(aside: Path) -> None:
        if program is None:
            _write_gif(pictures, rate, aside)
        else:
            _write_mp4(pictures, rate, aside, program)

    write_whole(path, fill)
    return len(numbers)


def ffmpeg() -> str | None:
    """The ffmpeg of this machine, or the one that imageio-ffmpeg brings along.

    >>> print(ffmpeg() is None or Path(str(ffmpeg())).is_file())
    True
    """
    program = shutil.which("ffmpeg")
    if program is None and find_spec("imageio_ffmpeg") is not None:
        import imageio_ffmpeg  # type: ignore[import-not-found]

        try:
            return imageio_ffmpeg.get_ffmpeg_exe()
        except RuntimeError:  # it has none for this machine
            return None
    return program


def _counted(
    pictures: Iterable[np.ndarray], count: int, listener: Callable[[int, int], None] | None
) -> Iterator[np.ndarray]:
    for done, picture in enumerate(pictures, 1):
        yield picture
        if listener is not None:
            listener(done, count)


def _write_gif(pictures: Iterator[np.ndarray], rate: float, path: Path) -> None:
    # Each picture has a palette of its own: one for all would show bands in what is dark.
    reduced = map(_reduced, pictures)
    first = next(reduced)
    duration = max(round(1000.0 / rate), SHORTEST)
    with path.open("wb") as stream:  # a stream of our own is closed whatever happens
        first.save(stream, format="GIF", save_all=True, append_images=reduced, duration=duration, loop=0)


def _reduced(picture: np.ndarray) -> Image.Image:
    """The picture in few colours, its gradients dithered: without that they would show bands.

    Of the ways to choose colours, the median cut leaves out those of small areas, such as a bright core.
    """
    image = Image.fromarray(picture)
    palette = image.quantize(_COLOURS, method=Image.Quantize.MAXCOVERAGE)
    return image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)


def _write_mp4(pictures: Iterator[np.ndarray], rate: float, path: Path, program: str) -> None:
    first = next(pictures)
    height, width = (size - size % 2 for size in first.shape[:2])  # the coding halves the colours both ways
    # Whatever the path begins with, it is neither an option nor an address; and what is read is the pipe alone.
    command = [
        program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
        "-framerate", f"{rate:.6g}", "-protocol_whitelist", "pipe", "-i", "pipe:0", "-an", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", "-f", "mp4", f"file:{path.absolute()}",
    ]  # fmt: skip
    with TemporaryFile() as said:
        # In a session of its own: Ctrl-C is for this process, which then ends ffmpeg.
        coder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=said, start_new_session=True)
        stream: Any = coder.stdin
        try:
            with (
                interrupts.leaving(coder.kill),
                suppress(BrokenPipeError),
            ):  # where it has given up, what it said tells why
                for picture in chain([first], pictures):
                    stream.write(np.ascontiguousarray(picture[:height, :width]).tobytes())
        except BaseException:
            coder.kill()
            raise
        finally:
            with suppress(BrokenPipeError):
                stream.close()
            coder.wait()
        if coder.returncode != 0:
            said.seek(0)
            reason = (said.read().decode(errors="replace").strip().splitlines() or ["gives no reason"])[-1]
            raise ArchiveError(f"{path} cannot be written; ffmpeg says: {reason}.")
