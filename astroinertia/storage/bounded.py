"""How much a file from anywhere may become in memory, and npz files within that: nothing large is made on its word.

Tests: tests/hard/test_malformed_files.py, tests/hard/test_crafted_results.py.
"""

import functools
import io
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

SMALL = 64 * 2**20  # bytes that any file may become
SPREAD = 200  # bytes that a byte of a larger file may become; zlib makes up to a thousand of one
MOST_MEMBERS = 1000  # of an npz file
_LONGEST_HEADER = 60_000  # bytes of the text that says what an array is
# How many bytes tell how long that text is, and what reads it.
_FORMATS: Mapping[tuple[int, int], tuple[int, Callable]] = {
    (1, 0): (2, np.lib.format.read_array_header_1_0),
    (2, 0): (4, np.lib.format.read_array_header_2_0),
}


def check_proportion(name: str, size: float, path: Path) -> None:
    """ValueError where the `size` bytes that a file becomes in memory are out of proportion to it."""
    if size > max(SMALL, SPREAD * path.stat().st_size):
        raise ValueError(
            f"{name} unpacks to {size / 2**20:.0f} MiB, more than {SPREAD} times its size and {SMALL >> 20} MiB"
        )


def plain_text(error: BaseException | str) -> str:
    """What an error of a library says, on one line and not at length."""
    words = " ".join(str(error).split()) or type(error).__name__
    return words if len(words) <= 200 else f"{words[:200]}..."


def npz_members(path: Path) -> dict[str, Callable[[], np.ndarray]]:
    """What reads each array of an npz file, by name, once all of them are known to be of plain numbers or text.

    ValueError in a sentence, or whatever zipfile raises, for what is none: each array's header is read first, and its
    shape and dtype must account for just the bytes that are there, so that no header makes more of them.
    """
    with zipfile.ZipFile(path) as bundle:
        entries = bundle.infolist()
        if len(entries) > MOST_MEMBERS:
            raise ValueError(f"it has more than {MOST_MEMBERS} members")
        check_proportion("it", sum(entry.file_size for entry in entries), path)
        readers = {}
        for entry in entries:
            name = entry.filename.removesuffix(".npy")
            if name in readers or entry.flag_bits & 1:
                raise ValueError(f"its member {name!r:.80} is there twice, or encrypted")
            with bundle.open(entry) as member:
                described(member, entry.file_size)
            readers[name] = lambda entry=entry: _read(path, entry)
    return readers


def _read(path: Path, entry: zipfile.ZipInfo) -> np.ndarray:
    with zipfile.ZipFile(path) as bundle, bundle.open(entry) as member:
        return array_of(member, entry.file_size)


def array_of(member: Any, size: int) -> np.ndarray:
    """The array of an npy stream of `size` bytes; ValueError where it is none."""
    shape, fortran, dtype = described(member, size)
    array = np.empty(shape[::-1] if fortran else shape, dtype)
    content, done = array.reshape(-1).view(np.uint8), 0
    while block := member.read(min(content.size - done, 2**20)):
        content[done : done + len(block)] = np.frombuffer(block, np.uint8)
        done += len(block)
    if done != content.size or member.read(1):  # at its end the archive compares checksums, too
        raise ValueError("an array does not end where it should")
    return array.T if fortran else array


def described(member: Any, size: int) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, whether in Fortran's order, and dtype of an npy stream of `size` bytes, which is read up to its data."""
    version = np.lib.format.read_magic(member)
    if version not in _FORMATS:
        raise ValueError(f"an array is of the unknown format {version}")
    width = _FORMATS[version][0]
    prefix = member.read(width)
    length = int.from_bytes(prefix, "little")
    if length > _LONGEST_HEADER:
        raise ValueError("the description of an array is longer than any of a run")
    shape, fortran, dtype = _parsed(version, prefix + member.read(length))
    if dtype.hasobject:
        raise ValueError("an array holds Python objects, which are not read")
    if dtype.itemsize == 0 and 0 not in shape:
        raise ValueError("an array is of nothing")
    wanted = dtype.itemsize
    for length in shape:  # in whole numbers, which do not overflow
        wanted *= length
    if any(length < 0 for length in shape) or wanted != size - member.tell():
        raise ValueError(f"an array of shape {shape!s:.80} and type {dtype!s:.40} has other than its bytes")
    return shape, bool(fortran), dtype


@functools.lru_cache(maxsize=1000)
def _parsed(version: tuple[int, int], header: bytes) -> tuple[tuple[int, ...], bool, np.dtype]:
    # To parse it takes longer than to read a table of records, and the segments of a run have the same few headers.
    return _FORMATS[version][1](io.BytesIO(header), max_header_size=_LONGEST_HEADER)
