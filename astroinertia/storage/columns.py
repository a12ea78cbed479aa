"""Columns of numbers in a file that may come from anywhere: CSV, npz and HDF5, read within limits.

A CSV file names its columns in the first line that is not a comment (#), or in the comment right before numbers, as
NumPy's savetxt writes it; all of them with units or none: "x (km)" or "x [km]"; a table of astropy (ECSV) has the units
in its comments, and position and velocity may be lists of three numbers there. gzip may have packed such text. An npz
file holds one array a column, never pickled objects; h5 and hdf5 files are those of table_hdf5.py.
Tests: tests/unit/sph/test_initial_particles.py.
"""

import csv
import gzip
import itertools
import re
import zlib
from array import array
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.storage.bounded import SMALL, SPREAD, npz_members, plain_text
from astroinertia.storage.table_hdf5 import (
    SUFFIXES as HDF5_SUFFIXES,
    VECTORS,
    hdf5_columns,
    split_units,
    split_vectors,
    units_in_head,
)
from astroinertia.units import quantity, shown

MAX_BYTES = 2**30
_MAX_LINE = 1024
_MOST_PASSED = 100_000
HEAD_WITH_UNIT = re.compile(r"\s*(\w{1,40})\s*(?:\[([^\[\]]{1,40})\]|\(([^()]{1,40})\))\s*")
_ECSV = "# %ECSV"
_TEXTS, _GZIP = (".csv", ".ecsv"), b"\x1f\x8b"  # endings, and how a file begins that gzip has packed
Read = tuple[dict[str, np.ndarray], bool]
"""Columns by name, in SI where their file states their units, and whether it does."""


@dataclass(frozen=True)
class Columns:
    """What a file should hold: how messages call it, its columns, other names for them, and the most rows.

    Names are in small letters here; a file may have them in capitals, too.
    dimensions: of the columns, where a file may state their units; one that is not used may be without.
    """

    what: str
    required: tuple[str, ...]
    optional: tuple[str, ...]
    most: int
    aliases: Mapping[str, str] = field(default_factory=dict)
    dimensions: Mapping[str, str] = field(default_factory=dict)

    @property
    def spellings(self) -> tuple[str, ...]:
        """All names of columns: in small letters, with a capital, and in capitals."""
        names = (*self.required, *self.optional, *self.aliases)
        return tuple({spelt: None for name in names for spelt in (name, name.capitalize(), name.upper())})

    def named(self, name: str) -> str:
        """A column's own name; what is none stays as it is."""
        small = name.lower()
        return self.aliases.get(small, small if small in self.required + self.optional else name)

    def check(self, path: Path, names: list[str]) -> None:
        """SceneError unless the names are all that is required, and nothing unknown or twice."""
        allowed = self.required + self.optional
        missing = [name for name in self.required if name not in names]
        unknown = [name for name in names if name not in allowed]
        repeated = sorted({name for name in names if names.count(name) > 1})
        if missing or unknown or repeated:
            kind, odd = ("unknown columns", unknown) if unknown else ("columns more than once, namely", repeated)
            odd = [name or "without a name" for name in (names if missing else odd)]
            wrong = f"has {kind} {shown(', '.join(odd[:4]), 80)}"
            if missing:
                wrong = f"lacks {', '.join(missing)}" + (f", and has {shown(', '.join(odd), 80)}" if odd else "")
            has = f"its columns are {', '.join(self.required)} and maybe {', '.join(self.optional)}"
            if len(names) == 1 and missing and re.search(r"[\s;]", names[0]):
                has = f"{has}, with commas between them"
            raise SceneError(f"{self.what} {path} {wrong}; {has}")


def check_file(path: Path, what: str, suffixes: tuple[str, ...]) -> None:
    """SceneError unless there is a file, of a known kind, that is not too large."""
    check_there(path, what)
    check_size(path, what)
    if suffix_of(path) not in suffixes:
        *first, last = suffixes
        raise SceneError(f"{what} {path} must be a {', '.join(first)} or {last} file")


def suffix_of(path: Path) -> str:
    """The ending of a file's name in small letters, of text that gzip has packed the one before .gz."""
    packed = path.suffix.lower() == ".gz"
    inner = Path(path.stem).suffix.lower() if packed else ""
    return inner if inner in _TEXTS else path.suffix.lower()


@contextmanager
def text_file(path: Path, name: str, most: int = MAX_BYTES) -> Iterator[TextIO]:
    """A text, open for reading, which gzip may have packed from `most` bytes or less; SceneError where it is none."""
    try:
        with path.open("rb") as file:
            packed = file.read(len(_GZIP)) == _GZIP
        if packed:
            _check_unpacked(path, name, most)
        opened = gzip.open if packed else open
        with opened(path, "rt", encoding="utf-8-sig", newline="") as text:
            yield text
    except UnicodeDecodeError as error:
        raise SceneError(f"{name} is not text") from error
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise SceneError(f"{name} cannot be unpacked ({plain_text(error)})") from error


def _check_unpacked(path: Path, name: str, most: int) -> None:
    """SceneError where gzip makes more of a file than it may become."""
    left = most = min(most, max(SMALL, SPREAD * path.stat().st_size))
    with gzip.open(path) as unpacked:
        while block := unpacked.read(2**20):
            left -= len(block)
            if left < 0:
                raise SceneError(f"{name} unpacks to more than the {most >> 20} MiB allowed")


def check_there(path: Path, what: str) -> None:
    """SceneError unless there is a file; a pipe would be waited for, and a device has no end."""
    if not path.is_file():
        there = "is a directory" if path.is_dir() else "is not a file" if path.exists() else "is not there"
        raise SceneError(f"{what} {shown(str(path), 200)} {there}")


def check_size(path: Path, what: str) -> None:
    """SceneError for a file that is too large."""
    if path.stat().st_size > MAX_BYTES:
        raise SceneError(f"{what} {path} is larger than {MAX_BYTES >> 20} MiB")


def check_numbers(path: Path, what: str, columns: Mapping[str, np.ndarray], row_name: str) -> None:
    """SceneError unless all columns are of one length and finite; `row_name` is what a row is of."""
    count = next(iter(columns.values())).size
    for name, column in columns.items():
        if column.shape != (count,):
            raise SceneError(f"{what} {path}: column {name} is not one number a {row_name}")
        if not np.isfinite(column).all():
            raise SceneError(f"{what} {path}: {name} of row {int(np.argmin(np.isfinite(column))) + 1} is not finite")


def csv_columns(path: Path, wanted: Columns) -> Read:
    """The columns of a CSV file, which may state units in its head."""
    numbers, rows = array("d"), 0  # eight bytes each, where a list of floats takes forty
    heads, units, delimiter, vectors = _head(path, wanted)
    names = [part for head in heads for part in vectors.get(head, (head,))]
    wanted.check(path, names)
    scales = unit_scales(path, wanted, names, units)
    with text_file(path, f"{wanted.what} {path}") as file:
        try:
            lines = csv.reader(_limited(f"{wanted.what} {path}", file), delimiter=delimiter)
            next(lines, None)
            for row in itertools.islice(lines, wanted.most + 1):
                if len(row) != len(heads):
                    raise SceneError(f"{wanted.what} {path}: row {rows + 1} has {len(row)} values, not {len(heads)}")
                numbers.extend(_flat(heads, row, vectors) if vectors else map(plain_number, row))
                rows += 1
        except UnicodeDecodeError:
            raise
        except (ValueError, csv.Error) as error:
            raise SceneError(f"{wanted.what} {path}: row {rows + 1} is not numbers ({plain_text(error)})") from error
    columns = np.array(numbers, dtype=float).reshape(-1, len(names)).T
    return scaled(dict(zip(names, columns, strict=True)), scales)


def _flat(heads: list[str], row: list[str], vectors: Mapping[str, tuple[str, ...]]) -> Iterator[float]:
    """The numbers of a row, those of a vector one by one; ValueError where one is no number or has not three."""
    for head, text in zip(heads, row, strict=True):
        parts = text[1:-1].split(",") if head in vectors and text[:1] + text[-1:] == "[]" else [text]
        if len(parts) != len(vectors.get(head, (head,))):
            raise ValueError(f"{head} is not three numbers: {text!r:.80}")
        yield from map(plain_number, parts)


def _head(path: Path, wanted: Columns) -> tuple[list[str], dict[str, str], str, Mapping[str, tuple[str, ...]]]:
    """Names of the columns of a CSV file, their units where it states them, what is between them, and vectors."""
    comments: list[str] = []
    with text_file(path, f"{wanted.what} {path}") as file:
        line = next(_limited(f"{wanted.what} {path}", file, comments), "")
    of_astropy = bool(comments) and comments[0].startswith(_ECSV)
    commas = any(re.fullmatch(r"# delimiter: ([\"']),\1\s*", line) for line in comments)
    delimiter = " " if of_astropy and not commas else ","
    heads = next(csv.reader([line], delimiter=delimiter), [])
    parts = [HEAD_WITH_UNIT.fullmatch(head) if wanted.dimensions else None for head in heads]
    names = [wanted.named(head.strip() if part is None else part[1]) for head, part in zip(heads, parts, strict=True)]
    units = {name: part[2] or part[3] for name, part in zip(names, parts, strict=True) if part is not None}
    if of_astropy and wanted.dimensions:
        units |= {wanted.named(name): unit for name, unit in units_in_head(comments).items()}
    vectors = {name: VECTORS[name] for name in names if name in VECTORS} if of_astropy and wanted.dimensions else {}
    return names, split_units(units), delimiter, vectors


def unit_scales(path: Path, wanted: Columns, names: Iterable[str], units: Mapping[str, str]) -> dict[str, float]:
    """What columns are to be multiplied by to be in SI; nothing where there are no units, or where none is looked for.

    SceneError where some columns have a unit and others have none, and for what is no unit of a column.
    """
    units = {name: unit for name, unit in units.items() if name in wanted.dimensions and unit.strip() != "1"}
    if not units:
        return {}
    if without := [name for name in names if name in wanted.dimensions and name not in units]:
        with_unit = next(iter(units))
        raise SceneError(f"{wanted.what} {path}: its column {without[0]} has no unit, but {with_unit} has one")
    return {name: _scale(path, wanted, name, unit) for name, unit in units.items()}


def scaled(columns: dict[str, np.ndarray], scales: Mapping[str, float]) -> Read:
    """Columns in SI, and whether they had units."""
    in_si = {name: columns[name] * scale for name, scale in scales.items()}
    return columns | in_si, bool(scales)


def _scale(path: Path, wanted: Columns, name: str, unit: str) -> float:
    try:
        return quantity(f"1 {unit.strip()}", wanted.dimensions[name])
    except SceneError as error:
        raise SceneError(f"{wanted.what} {path}: the unit of {name}: {error}") from None


def plain_number(text: str) -> float:
    """The number that a text is; ValueError, too, for one with underscores, which Python takes for spaces."""
    if "_" in text:
        raise ValueError(f"could not convert string to float: {text!r:.80}")
    return float(text)


def is_number(text: str) -> bool:
    """Whether a text is a number (plain_number)."""
    try:
        plain_number(text)
    except ValueError:
        return False
    return True


def _limited(name: str, file: TextIO, comments: list[str] | None = None) -> Iterator[str]:
    """The lines of a text but empty ones and comments, which are kept in a list, none read beyond what it may have.

    A comment right before numbers, which are the first line, is one of them: the head of a table of NumPy's savetxt.
    """
    passed, head, begun = 0, "", False
    for number in itertools.count(1):
        line = file.readline(_MAX_LINE + 1)
        if len(line) > _MAX_LINE:
            raise SceneError(f"{name}: line {number} is longer than {_MAX_LINE} characters")
        if not line:
            return
        if line.strip() and not line.startswith("#"):
            if head and not begun and is_number(line.split(",")[0]):
                yield head
            begun = True
            yield line
        elif (passed := passed + 1) > _MOST_PASSED:
            raise SceneError(f"{name} has more than {_MOST_PASSED} empty lines and comments")
        else:
            head = line.removeprefix("#").strip()
            if comments is not None:
                comments.append(line)


def npz_columns(path: Path, wanted: Columns) -> Read:
    """The columns of an npz file, which states no units; position and velocity may be of three numbers a row."""
    try:
        members = npz_members(path)
        names = {wanted.named(name): name for name in members}
        wanted.check(path, [part for name in map(wanted.named, members) for part in VECTORS.get(name, (name,))])
        arrays = {name: members[file]() for name, file in names.items()}
        if wrong := [name for name, column in arrays.items() if column.dtype.kind not in "fiu"]:
            raise ValueError(f"its column {wrong[0]} is not of numbers")
        columns = {name: np.asarray(column, dtype=float) for name, column in arrays.items()}
        return split_vectors(f"{wanted.what} {path}", columns), False
    except SceneError:
        raise
    except Exception as error:  # zipfile and what it unpacks with fail in their own ways
        raise SceneError(f"{wanted.what} {path} is not an npz file of plain numbers ({plain_text(error)})") from error


def hdf5(path: Path, wanted: Columns) -> Read:
    """The columns of an HDF5 file, which may have units as attributes."""
    columns, units = hdf5_columns(path, wanted.spellings, wanted.most, wanted.what)
    own = [wanted.named(name) for name in columns]
    wanted.check(path, own)
    scales = unit_scales(path, wanted, own, {wanted.named(name): unit for name, unit in units.items()})
    return scaled(dict(zip(own, columns.values(), strict=True)), scales)


READERS = {".csv": csv_columns, ".npz": npz_columns} | dict.fromkeys(HDF5_SUFFIXES, hdf5)
