"""What belongs to a run: its description and its sealed files, in two copies that know their own hash.

The copy is written first, so that at any instant one of the two is whole and tells a consistent state of the run;
where a disk damages one, the other is used. Tests: tests/unit/test_archive.py, tests/crash/test_faults.py.
"""

import hashlib
import json
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from astroinertia.errors import ArchiveError, ArchiveWarning
from astroinertia.sealed import read_json, write_json

MANIFEST = "manifest.json"
COPY = "manifest-copy.json"
FORMAT = "astroinertia-run"
SEALED = re.compile(r"(segment|snapshots|checkpoint)-[0-9]+\.npz")
_TYPE = re.compile(r"[<>|=][biufcSU][0-9]{1,4}")
_FINAL = re.compile(r"[^/\\\s]*\.nc")  # in this folder
VERSION = 3
"""1: one checkpoint, one manifest without a hash. 2: the last two checkpoints, the manifest twice and hashed, snapshots
with the records of a segment. 3: snapshots in files of their own, described here; records as one table."""


def empty(metadata: dict[str, Any]) -> dict[str, Any]:
    """The manifest of a run that has written nothing; of its checkpoints, oldest first, None stands for the start."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "metadata": metadata,
        "serial": 0,
        "segments": [],
        "checkpoints": [None],
        "final": None,
    }


def write(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Replace both copies, each as a whole; ArchiveError if the system refuses."""
    content = {**manifest, "sha256": _digest(manifest)}
    for name in (COPY, MANIFEST):
        write_json(folder / name, content)


def read(folder: Path) -> dict[str, Any]:
    """The manifest of a run folder, also of an older format; ArchiveWarning, naming it, where only the copy is whole.

    Raises ArchiveError if there is none, neither is whole, or it is of a newer format.
    """
    errors = []
    for name in (MANIFEST, COPY):
        try:
            manifest = read_file(folder / name)
        except ArchiveError as error:
            errors.append(error)
            continue
        if errors:
            warnings.warn(f"{folder / MANIFEST} is damaged or missing; its copy is used.", ArchiveWarning, stacklevel=3)
        return manifest
    raise errors[0]


def read_file(path: Path) -> dict[str, Any]:
    """One of the two copies, in today's format; ArchiveError where it is missing, damaged or not of this package."""
    try:
        manifest = read_json(path)
    except (FileNotFoundError, NotADirectoryError):
        raise ArchiveError(f"{path.parent} holds no run (it has no {MANIFEST}).") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise ArchiveError(f"{path} does not describe a run of this package.")
    version, recorded = manifest.get("version"), manifest.pop("sha256", None)
    if isinstance(version, int) and version > VERSION:
        raise ArchiveError(
            f"{path.parent} was written in format {version} of a newer version; this one reads up to {VERSION}."
        )
    if recorded != _digest(manifest) and not (version == 1 and recorded is None):
        raise ArchiveError(f"{path} is damaged: its sha256 is not the one that was recorded when it was written.")
    manifest = _current(manifest)
    if wrong := _complaint(manifest):
        raise ArchiveError(f"{path} was not written by this package: {wrong}.")
    return manifest


def _current(manifest: dict[str, Any]) -> dict[str, Any]:
    """The same in today's format."""
    if manifest.get("version") == 1:
        manifest = {**manifest, "checkpoints": [manifest.get("checkpoint")]}
        manifest.pop("checkpoint", None)
    return {**manifest, "version": VERSION} if manifest.get("version") in range(1, VERSION) else manifest


def _complaint(manifest: Mapping[str, Any]) -> str:
    """What this package never writes; its own hash whoever wrote it may have found, too. Empty where all is well."""
    metadata, segments, checkpoints = (manifest.get(name) for name in ("metadata", "segments", "checkpoints"))
    if manifest.get("version") != VERSION or not _is_count(manifest.get("serial")):
        return "it has no version, or no serial number"
    if not isinstance(metadata, dict) or not isinstance(metadata.get("name"), str):
        return "it has no description of a run"
    if any(not isinstance(metadata.get(name, ""), str | None) for name in ("scene", "origin")):
        return "its scene is not a text"
    if not isinstance(segments, list) or not isinstance(checkpoints, list) or not 1 <= len(checkpoints) <= 2:
        return "it has no lists of segments and checkpoints"
    counted = ("records", "snapshots")
    if not all(_is_sealed(each, ("segment", "snapshots"), counted) and _has_layout(each) for each in segments):
        return "it lists something that is no segment"
    if not all(each is None or _is_sealed(each, ("checkpoint",), ("segments",)) for each in checkpoints):
        return "it lists something that is no checkpoint"
    numbers = [0 if each is None else each["segments"] for each in checkpoints]
    if sorted(numbers) != numbers or numbers[-1] > len(segments):
        return "a checkpoint follows segments that are not there"
    final = manifest.get("final")
    if final is not None and not (_is_entry(final, ("segments",)) and _FINAL.fullmatch(final["file"])):
        return "its final file is none"
    return ""


def _is_sealed(entry: Any, kinds: tuple[str, ...], counted: tuple[str, ...]) -> bool:
    found = SEALED.fullmatch(entry["file"]) if _is_entry(entry, counted) else None
    return found is not None and found[1] in kinds


def _is_entry(entry: Any, counted: tuple[str, ...]) -> bool:
    return (
        isinstance(entry, dict)
        and isinstance(entry.get("file"), str)
        and isinstance(entry.get("sha256"), str)
        and all(_is_count(entry.get(name)) for name in counted)
    )


def _has_layout(segment: Mapping[str, Any]) -> bool:
    layout = segment.get("layout", {})
    return (
        isinstance(layout, dict)
        and ("layout" in segment or not segment["snapshots"])
        and all(isinstance(shape, list) and all(map(_is_count, shape)) for shape in layout.values())
        and ("times" not in segment or _is_described(segment, layout))
    )


def _is_described(segment: Mapping[str, Any], layout: Mapping[str, Any]) -> bool:
    """Whether the times and types of snapshots are those of so many, and of what is laid out."""
    times, types = segment["times"], segment.get("types")
    return (
        isinstance(times, list)
        and len(times) == segment["snapshots"]
        and all(isinstance(time, int | float) and not isinstance(time, bool) for time in times)
        and isinstance(types, dict)
        and types.keys() == layout.keys()
        and "time" in layout
        and all(isinstance(kind, str) and _TYPE.fullmatch(kind) for kind in types.values())
    )


def _is_count(number: Any) -> bool:
    return isinstance(number, int) and not isinstance(number, bool) and 0 <= number < 2**53


def _digest(manifest: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(manifest).encode()).hexdigest()
