"""Files that are either whole or absent: written aside, synced to disk, renamed, and known by their hash."""

import ast
import hashlib
import io
import json
import math
import os
import struct
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import ArchiveError

TEMPORARY = ".tmp"
_CHUNK = 1 << 20
_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)  # a fixed date, so that the same arrays give the same bytes
_ZIP_NAME_LENGTHS = 26  # where the header of a file in a zip tells the lengths of its name and what follows that
_SCALARS = "scalars.json"


def write_whole(path: Path, fill: Callable[[Path], None]) -> str:
    """Let `fill` write a file under a temporary name, sync it, give it its name, sync the folder; returns its sha256.

    After a crash at any instant `path` is what it was before or what it is now, never half of it. Raises ArchiveError
    when the system refuses (no space, no permission); `path` stays as it was then.
    """
    aside = path.with_name(path.name + TEMPORARY)
    try:
        fill(aside)
        with aside.open("rb") as written:
            os.fsync(written.fileno())
        digest = sha256(aside)
        aside.replace(path)
        sync_folder(path.parent)
    except OSError as error:
        _discard(aside)
        raise ArchiveError(
            f"{path} cannot be written: {error.strerror or error}; what was written before is kept."
        ) from error
    except BaseException:
        _discard(aside)
        raise
    return digest


def sync_folder(folder: Path) -> None:
    """Make renames and removals in a folder durable."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sha256(path: Path) -> str:
    """Hash of a file's contents, as hexadecimal text."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(_CHUNK):
            digest.update(block)
    return digest.hexdigest()


def write_json(path: Path, content: Any) -> str:
    """Write JSON whole; floats survive bit for bit (the shortest text that reads back the same)."""
    text = json.dumps(content, indent=1, allow_nan=True) + "\n"

    def fill(aside: Path) -> None:
        aside.write_text(text)

    return write_whole(path, fill)


def write_arrays(path: Path, arrays: Mapping[str, Any], scalars: Mapping[str, Any] | None = None) -> str:
    """Write arrays (npz, no pickle, uncompressed) and plain scalars as one whole file; returns its sha256.

    Any dtype but objects; every bit survives. Scalars are text, truth values, whole numbers, floats, None, and lists
    and dicts of these. Raises ArchiveError for anything else.
    """
    for name, array in arrays.items():
        must_be_plain(name, np.asarray(array))
    try:
        listing = json.dumps({name: _plain(value) for name, value in (scalars or {}).items()})
    except TypeError as error:
        raise ArchiveError(f"a scalar cannot be archived: {error}.") from error

    def fill(aside: Path) -> None:
        with zipfile.ZipFile(aside, "w", zipfile.ZIP_STORED, allowZip64=True) as bundle:
            for name, array in arrays.items():
                with bundle.open(zipfile.ZipInfo(f"{name}.npy", _ZIP_EPOCH), "w", force_zip64=True) as member:
                    _write_array(member, np.asarray(array))
            bundle.writestr(zipfile.ZipInfo(_SCALARS, _ZIP_EPOCH), listing)

    return write_whole(path, fill)


def read_arrays(path: Path, digest: str, prefix: str = "") -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Arrays and scalars of a file that has this sha256; only arrays whose name begins with `prefix` are loaded.

    Raises ArchiveError, naming the file, if it is missing or its contents are not what was written.
    """
    check(path, digest)
    arrays, scalars = {}, {}
    with zipfile.ZipFile(path) as bundle:
        for member in bundle.namelist():
            if member == _SCALARS:
                scalars = json.loads(bundle.read(member))
            elif member.startswith(prefix):
                content = io.BytesIO(bundle.read(member))
                dtype, shape = _described(content)
                plain = np.frombuffer(content.read(), np.uint8)
                arrays[member.removesuffix(".npy")] = np.ndarray(shape, dtype, plain).copy()
    return arrays, scalars


def must_be_plain(name: str, array: np.ndarray) -> None:
    """Raise ArchiveError for an array of Python objects."""
    if array.dtype.hasobject:
        raise ArchiveError(f"'{name}' holds Python objects, which are not archived; give numbers or text.")


def missing(path: Path) -> ArchiveError:
    """The error of a file that the manifest lists and that is not there."""
    return ArchiveError(f"{path} is missing, but the manifest beside it lists it.")


class Rows:
    """The arrays of a file of write_arrays, read row by row; before the first its hash is checked, once."""

    def __init__(self, path: Path, digest: str) -> None:
        self.path, self.digest = path, digest

    @cached_property
    def places(self) -> dict[str, tuple[int, np.dtype, tuple[int, ...]]]:
        """Where each array begins, in bytes, its dtype and its shape; ArchiveError where the file is not whole."""
        check(self.path, self.digest)
        found = {}
        with zipfile.ZipFile(self.path) as bundle, self.path.open("rb") as file:
            for member in bundle.infolist():
                if member.filename == _SCALARS:
                    continue
                file.seek(member.header_offset + _ZIP_NAME_LENGTHS)
                file.seek(sum(struct.unpack("<HH", file.read(4))), os.SEEK_CUR)
                dtype, shape = _described(file)
                found[member.filename.removesuffix(".npy")] = (file.tell(), dtype, shape)
        return found

    def row(self, name: str, number: int) -> np.ndarray:
        """Element `number` of an array along its first axis."""
        begin, dtype, shape = self.places[name]
        size = math.prod(shape[1:])
        return np.fromfile(self.path, dtype, size, offset=begin + number * size * dtype.itemsize).reshape(shape[1:])


def check(path: Path, digest: str) -> None:
    """Raise ArchiveError, naming the file, unless it is there and has this sha256."""
    try:
        found = sha256(path)
    except FileNotFoundError:
        raise missing(path) from None
    except OSError as error:
        raise ArchiveError(f"{path} cannot be read: {error.strerror or error}.") from error
    if found != digest:
        raise ArchiveError(
            f"{path} is damaged: its sha256 is {found[:12]}..., but {digest[:12]}... was recorded when it was written."
        )


def _described(file: Any) -> tuple[np.dtype, tuple[int, ...]]:
    """Dtype and shape of an array in NumPy's format that begins here; its numbers come next, in C order."""
    version, _ = np.lib.format.read_magic(file)
    (length,) = struct.unpack("<H", file.read(2)) if version == 1 else struct.unpack("<I", file.read(4))
    return _parsed(file.read(length).decode("utf8" if version == 3 else "latin1"))


@lru_cache(maxsize=1000)
def _parsed(header: str) -> tuple[np.dtype, tuple[int, ...]]:
    # To parse it takes longer than to read a table of records, and the segments of a run have the same few headers.
    told = ast.literal_eval(header)
    return np.lib.format.descr_to_dtype(told["descr"]), told["shape"]


def _write_array(member: Any, array: np.ndarray) -> None:
    np.lib.format.write_array(member, np.asanyarray(array, order="C"), allow_pickle=False)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic) or (hasattr(value, "item") and getattr(value, "ndim", None) == 0):
        return value.item()
    return value


def _discard(path: Path) -> None:
    # The first error is the one to tell; leftovers are swept when the folder is opened next.
    with suppress(OSError):
        path.unlink(missing_ok=True)
