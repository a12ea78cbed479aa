"""Which files may be written over: none that is being read, and only such as are of the kind that is written."""

import stat
from pathlib import Path

from astroinertia.errors import ArchiveError
from astroinertia.storage import trailer

_LONGEST = 16  # bytes that tell what a file is
_BEGINNINGS = {
    "a PNG picture": (b"\x89PNG\r\n\x1a\n",),
    "an HTML page": (b"<!doctype html",),
    "a netCDF file": (b"\x89HDF\r\n\x1a\n", b"CDF"),
    "a GIF": (b"GIF8",),
    "an MP4": (b"ftyp",),  # after four bytes of length
    "a CSV table": (b"",),
}
PNG, HTML, NETCDF, GIF, MP4, CSV = _BEGINNINGS


def check(path: Path, kind: str, read: Path | None = None) -> None:
    """ArchiveError where a file is there that is `read`, that is not of that kind, or that is the result of a run.

    Also where there is no folder for it, before anything is worked out that would be lost.
    """
    if not path.parent.is_dir():
        raise ArchiveError(f"{path} cannot be written: there is no folder {path.parent}.")
    try:
        status = path.stat()
    except FileNotFoundError:
        return
    except OSError as error:
        raise ArchiveError(f"{path} cannot be written: {error.strerror or error}.") from error
    if read is not None and read.exists() and path.samefile(read):
        raise ArchiveError(f"{path} is what is read, and is not written over; choose another file.")
    if not stat.S_ISREG(status.st_mode):
        raise ArchiveError(f"{path} is there and is not a file; choose another name.")
    with path.open("rb") as file:
        start = file.read(_LONGEST).lower()
    begins = start[4:] if kind == MP4 else start
    if status.st_size and not any(begins.startswith(beginning.lower()) for beginning in _BEGINNINGS[kind]):
        raise ArchiveError(f"{path} is there and is not {kind}, so it is not written over; choose another file.")
    if kind == NETCDF and trailer.is_there(path):
        raise ArchiveError(f"{path} is the result of a run, and is not written over; choose another file.")
