"""A run folder: atomic segments of output and the last two checkpoints, consistent after a crash at any instant.

    manifest.json            what belongs to the run, with the sha256 of every file; replaced as a whole
    manifest-copy.json       the same once more, for a disk that damages the first
    segment-000001.npz ...   headline records, in code units
    snapshots-000001.npz ... the snapshots saved with them, apart: to open a run is to read the records alone
    checkpoint-000002.npz    the state from which the run goes on, after so many segments; and the one before it
    <name>.nc                the final dataset, written once (astroinertia.dataset)
    lock                     held by the one process that writes

A file exists for the run only once the manifest lists it, and the manifest is replaced atomically: that is the whole
of the crash safety. What a disk damages later is known by its hash, and what follows from the checkpoint before is
computed again. One file held open for appending is not an option: HDF5 loses it on kill -9.
"""

import fcntl
import json
import os
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from astroinertia.errors import ArchiveError, ArchiveWarning, AstroinertiaError
from astroinertia.storage import manifest as manifests
from astroinertia.storage.atomic import (
    archive_errors,
    check,
    meant_for,
    missing,
    read_arrays,
    read_json,
    regular,
    sync_folder,
    write_arrays,
    write_whole,
)
from astroinertia.storage.manifest import COPY, MANIFEST, SAVED
from astroinertia.storage.outputs import SERIES, SNAPSHOT, Snapshots, stacked, table, unread

LOCK = "lock"
SHARED = "shared"  # of a checkpoint's scalars: {name of an array: the name that it is saved under}
SWEEP = "sweep.json"  # in place of the manifest, in the folder of a sweep: sweeps.folder


class Archive:
    """A run folder. `create` and `open` take it for writing (one process at a time), `view` only reads it."""

    def __init__(self, folder: Path, manifest: dict[str, Any], lock: Any) -> None:
        self.folder = folder
        self._manifest = manifest
        self._lock = lock
        self._lost: dict[str, str] = {}

    @classmethod
    def create(cls, folder: Path | str, metadata: Mapping[str, Any]) -> Self:
        """Start a run in a folder that holds none yet (made if it is not there).

        metadata: plain data (JSON) that describes the run; `name` is required and names the final file. Raises
        ArchiveError if the folder holds another run or its result, is in use, or cannot be written.
        """
        folder = Path(folder)
        final_name(metadata)
        try:
            described: dict[str, Any] = json.loads(json.dumps(dict(metadata)))
        except TypeError as error:
            raise ArchiveError(f"the metadata of a run must be plain data: {error}.") from error
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ArchiveError(f"the run folder {folder} cannot be made: {error.strerror or error}.") from error
        lock = locked(folder)
        try:
            refuse_if_taken(folder, metadata)
            archive = cls(folder, {}, lock)
            archive._commit(manifests.empty(described))
        except BaseException:
            lock.close()
            raise
        return archive

    @classmethod
    def open(cls, folder: Path | str) -> Self:
        """Go on with the run in a folder, at its last checkpoint: what was written after it is dropped.

        Where that checkpoint, or an output since the one before it, is missing or damaged, at the one before. Outputs
        older than that are `lost`. Either way an ArchiveWarning names the file and says what becomes of it.
        Raises ArchiveError if there is no run, another process is writing it, or no checkpoint is left.
        """
        folder = Path(folder)
        manifests.read(folder)  # before the lock, so that a folder that holds no run stays as it is
        lock = locked(folder)
        try:
            archive = cls(folder, manifests.read(folder), lock)
            archive._return_to_checkpoint()
        except BaseException:
            lock.close()
            raise
        return archive

    @classmethod
    def view(cls, folder: Path | str) -> Self:
        """Read a run folder, also while another process writes it; takes no lock and changes nothing."""
        folder = Path(folder)
        return cls(folder, manifests.read(folder), None)

    @property
    def metadata(self) -> dict[str, Any]:
        """What `create` was given."""
        return self._manifest["metadata"]

    def describe(self, further: Mapping[str, Any]) -> None:
        """Add plain data (JSON) to what `create` was given."""
        self.must_be_writable()
        self._commit({**self._manifest, "metadata": {**self.metadata, **further}})

    def change(self, further: Mapping[str, Any], back: bool = False) -> None:
        """Add plain data to the description and, where `back`, return to the checkpoint before the last, at once.

        Outputs after that checkpoint are dropped; where there is none, the last stays. The final file stays until the
        next one is whole.
        """
        self.must_be_writable()
        checkpoints, segments = self._manifest["checkpoints"], self._manifest["segments"]
        checkpoints = checkpoints[:-1] if back and len(checkpoints) > 1 else checkpoints
        self._commit({
            **self._manifest, "metadata": {**self.metadata, **further}, "checkpoints": checkpoints,
            "segments": segments[: _segments(checkpoints[-1])], "final": None,
        })  # fmt: skip
        self._sweep()

    @property
    def digest(self) -> str:
        """The sha256 of the manifest, which has that of every file."""
        return manifests.digest(self._manifest)

    @property
    def segments(self) -> int:
        """Number of saved files of output."""
        return len(self._manifest["segments"])

    @property
    def lost(self) -> tuple[str, ...]:
        """Sentences, each on outputs that cannot be read any more and were too old to be computed again by `open`."""
        return tuple(self._lost.values())

    @property
    def finished(self) -> Path | None:
        """The final file, if it is there and holds all there is."""
        final = self._manifest["final"]
        if final is None or final["segments"] != self.segments:
            return None
        path = self.folder / final["file"]
        if not path.exists():
            return None
        regular(path)
        return path

    def write_segment(self, records: Sequence[Mapping[str, Any]], snapshots: Sequence[Mapping[str, Any]] = ()) -> None:
        """Save headline records and snapshots, each a mapping of names to arrays or numbers; nothing if both are empty.

        Every record of a segment has the same names and shapes (so have the snapshots, among themselves); a snapshot
        has its `time`.
        """
        self.must_be_writable()
        if not records and not snapshots:
            return
        series, particles = stacked(records, "record"), stacked(snapshots, "snapshot")
        number, entries = self._numbered(), []
        if records:
            entry = self._write("segment", number, {SERIES: table(series)})
            entries.append(entry | {"records": len(records), "snapshots": 0})
        if snapshots:
            arrays = {f"{SNAPSHOT}{name}": array for name, array in particles.items()}
            entry = self._write("snapshots", number, arrays) | {"records": 0, "snapshots": len(snapshots)}
            # So much of it that a folder is opened without the file.
            entry["layout"] = {name: list(array.shape[1:]) for name, array in particles.items()}
            entry["types"] = {name: array.dtype.str for name, array in particles.items()}
            entry["times"] = [float(time) for time in particles["time"]]
            entries.append(entry)
        self._commit({**self._manifest, "segments": [*self._manifest["segments"], *entries]})

    def write_checkpoint(self, arrays: Mapping[str, Any], scalars: Mapping[str, Any]) -> None:
        """Save the state after all segments written so far; the checkpoint before it stays, older ones go.

        Every bit of the arrays survives. One that has several names is saved once.
        """
        self.must_be_writable()
        *older, before = self._manifest["checkpoints"]
        once, shared = _without_repeats(arrays)
        entry = self._write("checkpoint", self._numbered(), once, {**scalars, SHARED: shared})
        entry |= {"segments": self.segments}
        self._commit({**self._manifest, "checkpoints": [before, entry]})
        for checkpoint in filter(None, older):
            (self.folder / checkpoint["file"]).unlink(missing_ok=True)

    def read_checkpoint(self) -> tuple[dict[str, np.ndarray], dict[str, Any]] | None:
        """Arrays and scalars of the last checkpoint, None before the first; ArchiveError if it is damaged."""
        entry = self._manifest["checkpoints"][-1]
        return None if entry is None else self._checkpoint(entry)

    def checkpoints(self) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
        """File and arrays of each checkpoint that is whole, the last one first."""
        damaged = self.damaged()
        for entry in filter(None, reversed(self._manifest["checkpoints"])):
            if entry["file"] not in damaged:
                yield entry["file"], self._checkpoint(entry)[0]

    def read_series(self, damaged: str = "raise") -> Iterator[dict[str, np.ndarray]]:
        """Headline records of each segment in turn, the output number leading; checked against the hashes.

        A segment that is missing or damaged raises ArchiveError, or with damaged="skip" is left out with a warning.
        """
        for arrays in self._read("records", SERIES, damaged):
            # One table; in files of older versions an array for each quantity.
            records = arrays.pop(SERIES, None)
            if records is None:
                yield {name.removeprefix(f"{SERIES}/"): array for name, array in arrays.items()}
            else:
                yield {name: records[name] for name in records.dtype.names or ()}

    def read_snapshots(self) -> Iterator[dict[str, np.ndarray]]:
        """Snapshots of each segment in turn, the snapshot's number leading; ArchiveError where one is damaged."""
        for arrays in self._read("snapshots", SNAPSHOT, "raise"):
            yield {name.removeprefix(SNAPSHOT): array for name, array in arrays.items()}

    def snapshot_layout(self) -> tuple[int, dict[str, tuple[int, ...]]]:
        """Number of snapshots and the shape of each quantity in the first of them, without reading any."""
        listed = [entry for entry in self._kept() if entry["snapshots"]]
        layout = listed[0]["layout"] if listed else {}
        return sum(entry["snapshots"] for entry in listed), {name: tuple(shape) for name, shape in layout.items()}

    def snapshots_unread(self, damaged: str = "raise") -> list[Snapshots]:
        """What files hold of snapshots, none of which is read; each file is checked against its hash when it is.

        One that is missing raises ArchiveError; with damaged="skip" all are checked now, and left out with a warning.
        """
        snapshots = []
        for entry in self._kept():
            if not entry["snapshots"]:
                continue
            path = self.folder / entry["file"]
            try:
                if damaged == "skip":
                    check(path, entry["sha256"])
                elif not path.exists():
                    raise missing(path)
                snapshots.append(unread(path, entry))
            except ArchiveError as error:
                if damaged != "skip":
                    raise
                _left_out(error, entry, "snapshots")
        return snapshots

    def damaged(self) -> dict[str, str]:
        """A sentence on each segment and checkpoint that is missing or damaged, by the name of its file."""
        sentences = {}
        for entry in [*self._manifest["segments"], *filter(None, self._manifest["checkpoints"])]:
            try:
                check(self.folder / entry["file"], entry["sha256"])
            except ArchiveError as error:
                sentences[entry["file"]] = str(error)
        return sentences

    def finish(self, fill: Callable[[Path], None]) -> Path:
        """Let `fill` write the final file, save it as <name>.nc and return its path. Segments and checkpoint stay."""
        path = self.folder / final_name(self.metadata)
        self.must_be_writable()
        digest = write_whole(path, fill)
        self._commit({**self._manifest, "final": {"file": path.name, "sha256": digest, "segments": self.segments}})
        return path

    def close(self) -> None:
        """Let go of the folder."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _read(self, kind: str, prefix: str, damaged: str) -> Iterator[dict[str, np.ndarray]]:
        for entry in self._kept():
            if not entry[kind]:
                continue
            try:
                arrays, _ = read_arrays(self.folder / entry["file"], entry["sha256"], prefix)
            except ArchiveError as error:
                if damaged != "skip":
                    raise
                _left_out(error, entry, kind)
                continue
            yield arrays

    def _numbered(self) -> int:
        # The serial number never goes back, so that no reader of an older manifest finds other contents under a name.
        self._manifest["serial"] += 1
        return self._manifest["serial"]

    def _write(
        self, kind: str, number: int, arrays: Mapping[str, Any], scalars: Mapping[str, Any] | None = None
    ) -> dict[str, Any]:
        name = f"{kind}-{number:06d}.npz"
        return {"file": name, "sha256": write_arrays(self.folder / name, arrays, scalars)}

    def _checkpoint(self, entry: dict[str, Any]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        path = self.folder / entry["file"]
        arrays, scalars = read_arrays(path, entry["sha256"])
        with archive_errors(path, "names an array that it does not hold"):
            shared = scalars.pop(SHARED, {})  # files of older versions have none
            arrays |= {name: arrays[other] for name, other in shared.items()}
        return arrays, scalars

    def _commit(self, manifest: dict[str, Any]) -> None:
        self.must_be_writable()
        manifests.write(self.folder, manifest)
        self._manifest = manifest  # only now: where the disk refuses, this object still agrees with it

    def must_be_writable(self) -> None:
        """Raise ArchiveError where the folder was opened for reading only, or has been closed."""
        if self._lock is None:
            raise ArchiveError(f"the run folder {self.folder} is open for reading only, or closed.")

    def _kept(self) -> list[dict[str, Any]]:
        return [entry for entry in self._manifest["segments"] if entry["file"] not in self._lost]

    def _return_to_checkpoint(self) -> None:
        segments, damaged = self._manifest["segments"], self.damaged()
        checkpoints = [entry for entry in self._manifest["checkpoints"] if not entry or entry["file"] not in damaged]
        if not checkpoints:
            raise ArchiveError(" ".join(damaged[entry["file"]] for entry in self._manifest["checkpoints"]))
        if len(checkpoints) == 2:
            between = segments[_segments(checkpoints[0]) : _segments(checkpoints[1])]
            if any(entry["file"] in damaged for entry in between):
                checkpoints.pop()
        kept = segments[: _segments(checkpoints[-1])]
        for entry in kept:
            if entry["file"] in damaged:
                held = " and ".join(f"{entry[kind]} of the {kind}" for kind in ("records", "snapshots") if entry[kind])
                self._lost[entry["file"]] = f"{damaged[entry['file']]} This loses {held}."
        for file, sentence in damaged.items():
            whole = "The run goes on from a checkpoint that is whole, and nothing of this is lost."
            warnings.warn(self._lost.get(file, f"{sentence} {whole}"), ArchiveWarning, stacklevel=3)
        # First forgotten, then removed: a crash in between leaves strays, not gaps.
        if checkpoints != self._manifest["checkpoints"] or len(kept) < len(segments):
            final = self._manifest["final"] if len(kept) == len(segments) else None
            self._commit({**self._manifest, "segments": kept, "checkpoints": checkpoints, "final": final})
        self._sweep()

    def _sweep(self) -> None:
        entries = [*self._manifest["segments"], *filter(None, self._manifest["checkpoints"])]
        listed = {entry["file"] for entry in entries}
        whole = (MANIFEST, COPY, final_name(self.metadata))
        strays = [
            path
            for path in self.folder.iterdir()
            if (SAVED.fullmatch(path.name) and path.name not in listed)
            or ((meant := meant_for(path.name)) and (SAVED.fullmatch(meant) or meant in whole))
        ]
        for path in strays:
            path.unlink(missing_ok=True)
        if strays:
            sync_folder(self.folder)


def _without_repeats(arrays: Mapping[str, Any]) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Arrays without those that lie in the same memory as an earlier one, and {their name: its name}."""
    held = {name: np.asarray(array) for name, array in arrays.items()}
    first: dict[Any, str] = {}
    names = {
        name: first.setdefault((array.ctypes.data, array.shape, array.strides, array.dtype.str), name)
        for name, array in held.items()
    }
    once = {name: array for name, array in held.items() if names[name] == name}
    return once, {name: other for name, other in names.items() if other != name}


def file_of_sweep(folder: Path) -> Path:
    """The result that the folder of a sweep names; ArchiveError where there is none yet."""
    try:
        file = folder / final_name({"name": read_json(folder / SWEEP)["name"]})
    except (OSError, LookupError, TypeError) as error:
        raise ArchiveError(f"{folder / SWEEP} cannot be read, or does not name its sweep: {error}.") from error
    if not file.exists():
        raise ArchiveError(f"{folder} holds a sweep that is not finished; resume it.")
    regular(file)
    return file


def way_to_rewrite(path: Path) -> str:
    """How the final file of a run or sweep is written again from what is beside it, in a sentence; empty for others."""
    folder = path.parent
    try:
        own = (
            file_of_sweep(folder).name if (folder / SWEEP).exists() else final_name(manifests.read(folder)["metadata"])
        )
    except ArchiveError:
        return ""
    again = f" All that was in it is beside it: astroinertia resume {shlex.quote(str(folder))} writes it again."
    return again if path.name == own else ""


def final_name(metadata: Mapping[str, Any]) -> str:
    """File name of the final dataset; ArchiveError if the metadata has no usable `name`."""
    name = metadata.get("name")
    if not isinstance(name, str) or not name.strip():
        raise ArchiveError("the metadata of a run needs a 'name', which names its final file.")
    return re.sub(r"[^\w.+-]+", "_", name.strip()).lstrip(".")[:100] + ".nc"


def _segments(checkpoint: Mapping[str, Any] | None) -> int:
    """How many segments were saved before a checkpoint; None is the start."""
    return 0 if checkpoint is None else checkpoint["segments"]


def locked(folder: Path) -> Any:
    """The folder's lock, held until it is closed or the process ends; ArchiveError where another process holds it."""
    path = folder / LOCK
    try:
        # Neither through a link, which may lead anywhere, nor for a pipe, which would be waited for.
        careful = os.O_NOFOLLOW | os.O_NONBLOCK
        lock = open(path, "ab", opener=lambda name, flags: os.open(name, flags | careful, 0o666))  # noqa: SIM115
    except OSError as error:
        raise ArchiveError(f"the run folder {folder} cannot be written: {error.strerror or error}.") from error
    try:
        # The kernel lets go of it when the process ends, however it ends.
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.close()
        raise ArchiveError(f"another process is writing the run folder {folder}; wait for it or stop it.") from None
    except OSError as error:
        lock.close()
        raise ArchiveError(f"the run folder {folder} cannot be locked: {error.strerror or error}.") from error
    return lock


def refuse_for_netcdf(path: Path, kind: type[AstroinertiaError] = ArchiveError) -> None:
    """Raise an error where a path, from the root on, has what netCDF takes for a slash, or cannot open."""
    whole = str(path.absolute())
    if "\\" in whole:
        raise kind(f"{whole} has a backslash, which netCDF takes for a slash; choose another path.")
    encoding = sys.getfilesystemencoding()
    try:
        whole.encode(encoding)
    except UnicodeEncodeError:
        raise kind(
            f"{whole} has bytes that are no {encoding}, which netCDF cannot open; choose another path."
        ) from None


def refuse_if_taken(folder: Path, metadata: Mapping[str, Any]) -> None:
    """Raise ArchiveError if the folder holds a run already, or the result of one; one that is not there is free.

    Also for a path that netCDF would take for another, and for a folder that cannot be made or written.
    """
    refuse_for_netcdf(folder)
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not (there.is_dir() and os.access(there, os.W_OK | os.X_OK)):
        why = "may not be written to" if there.is_dir() else "is a file"
        raise ArchiveError(f"the run folder {folder} cannot be made: {there} {why}.")
    if there != folder:
        return
    if (folder / SWEEP).exists():
        raise ArchiveError(f"{folder} already holds a sweep; choose another folder.")
    if (folder / MANIFEST).exists():
        other = manifests.read(folder)["metadata"].get("name", "?")
        raise ArchiveError(
            f"{folder} already holds the run '{other}'; resume it, choose another folder, or remove this one."
        )
    if any(SAVED.fullmatch(path.name) for path in folder.iterdir()):
        raise ArchiveError(f"{folder} holds segments of a run whose {MANIFEST} is gone; choose another folder.")
    result = folder / final_name(metadata)
    if result.exists():
        raise ArchiveError(f"{folder} already holds a result, {result.name}; choose another folder.")


def _left_out(error: ArchiveError, entry: Mapping[str, Any], kind: str) -> None:
    warnings.warn(f"{error} Its {entry[kind]} {kind} are left out.", ArchiveWarning, stacklevel=4)
