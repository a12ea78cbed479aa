"""Files that are either whole or absent: written aside, synced to disk, renamed, and known by their hash.

Folders may come from anywhere: what is read is bounded, and no link out of a folder is followed, to read or to write.
Tests: tests/unit/storage/test_atomic.py, tests/unit/storage/test_archive.py, tests/hard/test_crafted_results.py.
"""

import hashlib
import json
import math
import os
import re
import secrets
import shutil
import stat
import struct
import zipfile
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from astroinertia.errors import ArchiveError, AstroinertiaError
from astroinertia.process import interrupts
from astroinertia.storage.bounded import array_of, described, plain_text

TEMPORARY = ".tmp"
_ASIDE = re.compile(rf"(.+?)(\.[0-9a-f]{{16}})?{re.escape(TEMPORARY)}")  # older versions had no number in the name
_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)  # a fixed date, so that the same arrays give the same bytes
_ZIP_NAME_LENGTHS = 26  # where the header of a file in a zip tells the lengths of its name and what follows that
_SCALARS = "scalars.json"
_NO_ARRAYS = "does not hold the arrays of a run"
_LARGEST_JSON = 32 * 2**20  # bytes
_MOST_VALUES = 2_000_000  # in a JSON file: an empty list takes 2 bytes there, and 60 in memory


def write_whole(path: Path, fill: Callable[[Path], object]) -> str:
    """Let `fill` write a file under a temporary name, sync it, give it its name, sync the folder; returns its sha256.

    The temporary name is this call's own: of several that write the same path at once, the last to be whole stays.
    After a crash at any instant `path` is what it was before or what it is now, never half of it. Raises ArchiveError
    when the system refuses (no space, no permission); `path` stays as it was then.
    """
    aside = path.with_name(f"{path.name}.{secrets.token_hex(8)}{TEMPORARY}")  # nobody can have put a link there
    try:
        with interrupts.leaving(lambda: _discard(aside)):
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


def meant_for(name: str) -> str | None:
    """The file that one of this name was written aside for; None for a name that is no temporary one.

    >>> print(meant_for("manifest.json.0123456789abcdef.tmp"), meant_for("manifest.json"))
    manifest.json None
    """
    aside = _ASIDE.fullmatch(name)
    return aside and aside[1]


def remove_leftovers(folder: Path, names: Collection[str]) -> None:
    """Remove what killed processes wrote aside for files of these names; only for who alone writes them."""
    for path in folder.iterdir():
        if meant_for(path.name) in names:
            path.unlink(missing_ok=True)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder of the system's temporary ones, gone afterwards, and where a signal ends the command."""
    with TemporaryDirectory() as place, interrupts.leaving(lambda: shutil.rmtree(place, ignore_errors=True)):
        yield Path(place)


def sync_folder(folder: Path) -> None:
    """Make renames and removals in a folder durable."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sha256(path: Path) -> str:
    """Hash of a file's contents, as hexadecimal text."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_json(path: Path, content: Any) -> str:
    """Write JSON whole; floats survive bit for bit (the shortest text that reads back the same)."""
    text = json.dumps(content, indent=1, allow_nan=True) + "\n"
    return write_whole(path, lambda aside: aside.write_text(text))


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
                    np.lib.format.write_array(member, np.asarray(array, order="C"), allow_pickle=False)
            bundle.writestr(zipfile.ZipInfo(_SCALARS, _ZIP_EPOCH), listing)

    return write_whole(path, fill)


@contextmanager
def hdf5_refusals() -> Iterator[None]:
    """What the system refused HDF5, and netCDF or h5py call a RuntimeError, becomes an OSError."""
    try:
        yield
    except RuntimeError as error:
        raise OSError(f"{error} (is the disk full?)") from error


def write_netcdf(path: Path, data: Any) -> str:
    """Write a dataset of xarray as netCDF, whole; returns its sha256."""

    @hdf5_refusals()
    def fill(aside: Path) -> None:
        data.to_netcdf(aside, engine="netcdf4", format="NETCDF4")

    return write_whole(path, fill)


def read_arrays(path: Path, digest: str, prefix: str = "") -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Arrays and scalars of a file that has this sha256; only arrays whose name begins with `prefix` are loaded.

    Raises ArchiveError, naming the file, if it is missing or its contents are not what was written.
    """
    check(path, digest)
    arrays, scalars = {}, {}
    with archive_errors(path, _NO_ARRAYS), zipfile.ZipFile(path) as bundle:
        for entry in _stored(bundle):
            with bundle.open(entry) as member:
                if entry.filename == _SCALARS:
                    scalars = _parsed(member.read(_LARGEST_JSON + 1))
                elif entry.filename.startswith(prefix):
                    arrays[entry.filename.removesuffix(".npy")] = array_of(member, entry.file_size)
        if not isinstance(scalars, dict):
            raise ValueError("its scalars are no table of names and values")
    return arrays, scalars


def read_json(path: Path) -> Any:
    """The content of a JSON file that may come from anywhere; FileNotFoundError or NotADirectoryError without one.

    ArchiveError, naming the file, for what is no JSON, for a link out of its folder, and for more than a run needs.
    """
    try:
        regular(path)
        with path.open("rb") as file:
            return _parsed(file.read(_LARGEST_JSON + 1))
    except (FileNotFoundError, NotADirectoryError):
        raise
    except OSError as error:
        raise ArchiveError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:
        raise ArchiveError(f"{path} is damaged: it is not JSON ({plain_text(error)}).") from error


def _parsed(content: bytes) -> Any:
    if len(content) > _LARGEST_JSON or sum(map(content.count, (b",", b"[", b"{"))) > _MOST_VALUES:
        raise ValueError(f"it has more than {_LARGEST_JSON >> 20} MiB or {_MOST_VALUES} values")
    value = json.loads(content)
    if b"\\ud" in content.lower():  # half of a character, which no file can be named or written with
        json.dumps(value, ensure_ascii=False).encode()
    return value


def made_folder(folder: Path) -> Path:
    """A folder of the user's choice, made where it is not there; ArchiveError where it cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = "it is a file" if folder.is_file() else error.strerror or error
        raise ArchiveError(f"the folder {folder} cannot be made: {why}.") from error
    return folder


def own_folder(folder: Path, *names: str) -> Path:
    """The folder that lies below another along the names; ArchiveError where one of them is a link, or no folder.

    A link may lead anywhere. The folder that is begun with is its user's choice, and may be reached through links.
    """
    for name in names:
        folder = folder / name
        if folder.is_symlink():
            raise ArchiveError(f"{folder} is a link, and is not followed.")
        if folder.exists() and not folder.is_dir():
            raise ArchiveError(f"{folder} is not a folder.")
    return folder


def regular(path: Path) -> None:
    """ArchiveError where a path is no file, or a link that leads out of the folder that it is in; OSError without one.

    Whoever made a folder says with its links what else on this machine is read, or written. A pipe would be waited for.
    """
    if path.is_symlink() and path.resolve().parent != path.parent.resolve():
        raise ArchiveError(f"{path} is a link that leads out of its folder, and is not followed.")
    if not stat.S_ISREG(path.stat().st_mode):
        raise ArchiveError(f"{path} is not a file.")


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
        places = {}
        with archive_errors(self.path, _NO_ARRAYS), zipfile.ZipFile(self.path) as bundle, self.path.open("rb") as file:
            for entry in _stored(bundle):
                if entry.filename == _SCALARS:
                    continue
                with bundle.open(entry) as member:
                    shape, fortran, dtype = described(member, entry.file_size)
                    before = member.tell()
                if fortran:
                    raise ValueError(f"its array {entry.filename!r:.80} is not in the order that runs have")
                file.seek(entry.header_offset + _ZIP_NAME_LENGTHS)
                names = sum(struct.unpack("<HH", file.read(4)))
                places[entry.filename.removesuffix(".npy")] = (file.tell() + names + before, dtype, shape)
        return places

    def row(self, name: str, number: int) -> np.ndarray:
        """Element `number` of an array along its first axis; ArchiveError as `places`, or where there is none."""
        with archive_errors(self.path, _NO_ARRAYS):
            begin, dtype, shape = self.places[name]
            size = math.prod(shape[1:])
            if not 0 <= number < shape[0]:
                raise ValueError(f"{name!r:.80} has no element {number}")
            taken = np.fromfile(self.path, dtype, size, offset=begin + number * size * dtype.itemsize)
            return taken.reshape(shape[1:])


@contextmanager
def archive_errors(path: Path, what: str = "cannot be read as netCDF") -> Iterator[None]:
    """Make an ArchiveError of whatever libraries raise of a file that is damaged or is no such file."""
    try:
        yield
    except AstroinertiaError:
        raise
    except Exception as error:  # zipfile, netCDF, HDF5 and xarray pass on what each finds as errors of many kinds
        raise ArchiveError(f"{path} {what}: {plain_text(error).rstrip('.')}.") from error


def _stored(bundle: zipfile.ZipFile) -> Iterator[zipfile.ZipInfo]:
    for entry in bundle.infolist():
        if entry.compress_type != zipfile.ZIP_STORED:  # nothing here may become larger than it is
            raise ValueError(f"its member {entry.filename!r:.80} is compressed")
        yield entry


def check(path: Path, digest: str) -> None:
    """Raise ArchiveError, naming the file, unless it is there and has this sha256."""
    try:
        regular(path)
        actual = sha256(path)
    except FileNotFoundError:
        raise missing(path) from None
    except OSError as error:
        raise ArchiveError(f"{path} cannot be read: {error.strerror or error}.") from error
    if actual != digest:
        raise ArchiveError(
            f"{path} is damaged: its sha256 is {actual[:12]}..., but {digest[:12]}... was recorded when it was written."
        )


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic) or (hasattr(value, "item") and getattr(value, "ndim", None) == 0):
        return value.item()
    return value


def _discard(path: Path) -> None:
    # The first error is the one to tell; leftovers are swept when the folder is opened next.
    with suppress(OSError):
        path.unlink(missing_ok=True)
