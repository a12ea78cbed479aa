"""What files of a run folder hold: records as one table, snapshots as arrays.

Tests: tests/unit/storage/test_archive.py.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from astroinertia.errors import ArchiveError
from astroinertia.storage.atomic import Rows, must_be_plain

SERIES, SNAPSHOT = "series", "snapshot/"  # names of arrays in files


@dataclass(frozen=True)
class Snapshots:
    """The snapshots in one file: their times, the dtype and shape of each quantity in one of them, and how to read it.

    rows: of the quantities under SNAPSHOT + name, one for each time.
    """

    times: np.ndarray
    layout: dict[str, tuple[np.dtype, tuple[int, ...]]]
    rows: Rows


class Unwritten:
    """In the place of an archive, for the processes of a run that leave its writing to another: it keeps nothing."""

    def __init__(self, folder: Path, metadata: Mapping[str, Any]) -> None:
        self.folder, self.metadata = folder, metadata

    def write_segment(self, records: Sequence[Mapping[str, Any]], snapshots: Sequence[Mapping[str, Any]] = ()) -> None:
        """Forget them."""

    def write_checkpoint(self, arrays: Mapping[str, Any], scalars: Mapping[str, Any]) -> None:
        """Forget it."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass


def unread(path: Path, entry: Mapping[str, Any]) -> Snapshots:
    """The snapshots of a file, from its entry in the manifest."""
    rows = Rows(path, entry["sha256"])
    if "times" in entry:
        layout = {name: (np.dtype(entry["types"][name]), tuple(shape)) for name, shape in entry["layout"].items()}
        return Snapshots(np.array(entry["times"]), layout, rows)
    # A file of an older version, with records in it, tells of itself only when it is read.
    layout = {
        name.removeprefix(SNAPSHOT): (dtype, shape[1:])
        for name, (_, dtype, shape) in rows.places.items()
        if name.startswith(SNAPSHOT)
    }
    return Snapshots(np.array([rows.row(f"{SNAPSHOT}time", k) for k in range(entry["snapshots"])]), layout, rows)


def table(columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Columns of the same length as one array of records: one is read in a tenth of the time of seventy."""
    for name, array in columns.items():
        must_be_plain(name, array)
    count = len(next(iter(columns.values())))
    made = np.empty(count, [(name, array.dtype, array.shape[1:]) for name, array in columns.items()])
    for name, array in columns.items():
        made[name] = array
    return made


def stacked(records: Sequence[Mapping[str, Any]], what: str) -> dict[str, np.ndarray]:
    """Records as columns; ArchiveError where they differ in names or shapes."""
    if not records:
        return {}
    names = set(records[0])
    for record in records[1:]:
        if set(record) != names:
            raise ArchiveError(f"the {what}s of a segment differ in what they hold: {sorted(names ^ set(record))}.")
    columns = {}
    for name in records[0]:
        values = [np.asarray(record[name]) for record in records]
        shapes = {value.shape for value in values}
        if len(shapes) > 1:
            raise ArchiveError(f"'{name}' changes its shape from one {what} to the next: {sorted(shapes)}.")
        columns[name] = np.stack(values)
    return columns
