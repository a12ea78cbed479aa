"""What the commands that look at a result share: opening it, and where they write."""

import os
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
    add("--member", type=int, metavar="N", help="of a sweep: the number of the member to look at, from 0")


def opened(path: Path) -> "xr.Dataset":
    """The headline series of a result; ArchiveError for what is none."""
    from astroinertia import dataset

    if path.exists() and not (path.is_file() or path.is_dir()):
        raise ArchiveError(f"{path} is neither a file nor a run folder.")  # a pipe would be waited for
    return dataset.open(path)


def of_one_run(path: Path, number: int | None, command: str) -> "tuple[Path, xr.Dataset]":
    """The result that a command looks at that is for one run, and its series; of a sweep, those of a member.

    SceneError where no member of a sweep is chosen, or one of something else.
    """
    folder = folder_of_sweep(path)
    if folder is not None:
        path = member_of(folder, number, command)
    elif number is not None:
        raise SceneError(f"--member is for the result of a sweep, and {path} is that of one run.")
    data = opened(path)
    must_be_of_one_run(path, data, command)
    return path, data


def must_be_of_one_run(path: Path, data: "xr.Dataset", command: str) -> None:
    """SceneError for a file of several runs: of a sweep, or put together in xarray."""
    from astroinertia.dataset.by_member import swept

    if "sweep" in data.attrs:
        raise SceneError(
            f"{path} is of a sweep, and `{command}` takes one run: give the folder of a member, such as member-0000 "
            "beside the sweep's own file."
        )
    if "inertia_tensor" in data and (dims := swept(data)):
        raise SceneError(
            f"{path} holds several runs along {', '.join(dims)}, and `{command}` takes one: write each to a file of "
            f"its own, such as ds.isel({dims[0]}=0).to_netcdf(...)."
        )


def folder_of_sweep(path: Path) -> Path | None:
    """The folder of the sweep whose folder or file is given; None where that is something else."""
    from astroinertia.storage.archive import SWEEP, file_of_sweep

    if (path / SWEEP).exists():
        return path
    if (path.parent / SWEEP).exists() and path.is_file() and path.samefile(file_of_sweep(path.parent)):
        return path.parent
    return None


def member_of(folder: Path, number: int | None, command: str) -> Path:
    """The folder of a member that is chosen by its number; SceneError where there is none of it."""
    from astroinertia.scene.sweep import member
    from astroinertia.sweeps import folder as folders

    count = len(folders.read(folder).members)
    if number is None:
        raise SceneError(
            f"{folder} holds a sweep of {count} members, of which `{command}` takes one: add --member N (0 to "
            f"{count - 1}), or give a member's folder, such as {folder / member(0)}."
        )
    if not 0 <= number < count:
        raise SceneError(f"--member must be the number of a member of {folder}, from 0 to {count - 1}, not {number}.")
    return folders.place(folder, number)


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
    """SceneError where a file that is asked for does not end so, is in no folder that is there, or cannot be netCDF."""
    if path is not None and suffix == ".nc":
        from astroinertia.storage.archive import refuse_for_netcdf

        refuse_for_netcdf(path, SceneError)
    if path is not None and (path.suffix != suffix or not path.parent.is_dir()):
        raise SceneError(f"{path} cannot be written: it must be a {suffix} file in a folder that is there")


def write_netcdf(data: "xr.Dataset", path: Path | None) -> None:
    """Write a dataset where a file is asked for, at most over another netCDF file; ArchiveError where it cannot be."""
    if path is not None:
        from astroinertia.storage import atomic, overwriting

        overwriting.check(path, overwriting.NETCDF)
        atomic.write_netcdf(path, data)


def beside(path: Path) -> Path:
    """The folder that a result is in."""
    return path if path.is_dir() else path.parent


def place_beside(path: Path) -> Path:
    """The folder that what is made of a result is written to; ArchiveError, before it is made, where that cannot be."""
    folder = beside(path)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ArchiveError(f"nothing may be written to {folder}: give --output, elsewhere.")
    return folder
