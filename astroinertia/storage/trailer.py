"""What a finished file says of its own bytes, in a line behind its end, where readers of HDF5 do not look.

    astroinertia-sha256 1 <bytes of the head> <its sha256> <bytes of the file> <sha256 of them, or of the head again>

A flipped bit, wherever it is, is noticed before a library that might trust it sees the file. A program that changes the
file leaves the line out, so that it is not held to what it was. Large files are checked in their head alone, which has
the headline series; HDF5 has checksums of its own (fletcher32) for what is read of the rest.
Tests: tests/crash/test_flipped_bits.py.
"""

import functools
import hashlib
import re
from pathlib import Path

from astroinertia.errors import ArchiveError

WHOLE = 256 * 2**20  # bytes of a file that is checked as a whole: a third of a second. With another, the line is a 2
_LINE = re.compile(rb"\nastroinertia-sha256 1 (\d{1,18}) ([0-9a-f]{64}) (\d{1,18}) ([0-9a-f]{64})\n\Z")
_LONGEST = 256
_BLOCK = 1 << 20


def append(path: Path, head: int) -> None:
    """Put the line behind a file that is closed; head: how many of its bytes hold what is always checked."""
    size = path.stat().st_size
    first, whole = _digests(path, head, _checked(head, size))
    with path.open("ab") as file:
        file.write(f"\nastroinertia-sha256 1 {head} {first} {size} {whole}\n".encode())


def check(path: Path) -> None:
    """ArchiveError, naming the file, where it is not what its line says; one without a line is not checked."""
    try:
        status = path.stat()
        sentence = _complaint(path, status.st_size, status.st_mtime_ns, status.st_ino)
    except OSError as error:
        raise ArchiveError(f"{path} cannot be read: {error.strerror or error}.") from error
    if sentence:
        raise ArchiveError(sentence)


def is_whole(path: Path) -> bool:
    """Whether a file is there, and what its line says; one without a line is taken as it is."""
    if not path.is_file():  # a pipe would be waited for
        return False
    try:
        check(path)
    except ArchiveError:
        return False
    return True


def is_there(path: Path) -> bool:
    """Whether a file ends with such a line, as results of runs do."""
    return _line(path, path.stat().st_size) is not None


def _line(path: Path, size: int) -> re.Match[bytes] | None:
    with path.open("rb") as file:
        file.seek(max(0, size - _LONGEST))
        return _LINE.search(file.read(_LONGEST))


@functools.lru_cache(maxsize=64)
def _complaint(path: Path, size: int, changed: int, inode: int) -> str:
    """What is wrong with a file; found once for a file that stays as it is: its size, time and number tell it."""
    del changed, inode
    line = _line(path, size)
    if line is None:
        return ""
    head, length = int(line[1]), int(line[3])
    damaged = f"{path} is damaged: its sha256 is not the one that was recorded when it was written."
    if length != size - len(line[0]) or head > length:
        return damaged
    digests = _digests(path, head, _checked(head, length))
    return "" if digests == (line[2].decode(), line[4].decode()) else damaged


def _checked(head: int, size: int) -> int:
    """How many bytes of a file are read whenever it is opened."""
    return size if size <= WHOLE else head


def _digests(path: Path, head: int, size: int) -> tuple[str, str]:
    """sha256 of the first bytes and of as many as `size`, read once."""
    digest, first, done = hashlib.sha256(), "", 0
    with path.open("rb") as file:
        for end in (head, size):
            while done < end and (block := file.read(min(_BLOCK, end - done))):
                digest.update(block)
                done += len(block)
            first = first or digest.hexdigest()
    return first, digest.hexdigest()
