"""What the commands that look at a result share: opening it, and where they write."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from astroinertia.cli.parser import Add
from astroinertia.errors import ArchiveError, AstroinertiaError, SceneError

if TYPE_CHECKING:
    import xarray as xr


def add_argument(add: Add, name: str = "run") -> None:
    """Add the result that a command looks at."""
    add(name, metavar=name.upper(), type=Path, help="netCDF file of a run, or the run's folder")


def opened(path: Path) -> "xr.Dataset":
    """The headline series of a result; ArchiveError for what is none."""
    from astroinertia import dataset

    if path.exists() and not (path.is_file() or path.is_dir()):
        raise ArchiveError(f"{path} is neither a file nor a run folder.")  # a pipe would be waited for
    return dataset.open(path)


@contextmanager
def shown(*paths: Path) -> Iterator[None]:
    """Make an ArchiveError of whatever fails while results are read on, drawn or written in another form.

    A file that is none of ours may lack what ours have; its data are read only where they are wanted.
    """
    try:
        yield
    except (AstroinertiaError, OSError, MemoryError):
        raise
    except Exception as error:  # which one, depends on what is missing where
        from astroinertia.storage.bounded import plain_text

        names = ", ".join(map(str, paths))
        raise ArchiveError(f"{names} cannot be shown: {type(error).__name__}, {plain_text(error)}.") from error


def must_be_writable(path: Path | None, suffix: str) -> None:
    """SceneError where a file that is asked for does not end so, or is in no folder that is there."""
    if path is not None and (path.suffix != suffix or not path.parent.is_dir()):
        raise SceneError(f"{path} cannot be written: it must be a {suffix} file in a folder that is there")


def beside(path: Path) -> Path:
    """The folder that what is made of a result is written to."""
    return path if path.is_dir() else path.parent
