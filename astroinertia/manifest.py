"""What belongs to a run: its description and its sealed files, in two copies that know their own hash.

The copy is written first, so that at any instant one of the two is whole and tells a consistent state of the run;
where a disk damages one, the other is used. Tests: tests/unit/test_archive.py, tests/crash/test_faults.py.
"""

import hashlib
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from astroinertia.errors import ArchiveError, ArchiveWarning
from astroinertia.sealed import write_json

MANIFEST = "manifest.json"
COPY = "manifest-copy.json"
FORMAT = "astroinertia-run"
VERSION = 2
"""1: one checkpoint, one manifest without a hash. 2: the last two checkpoints, the manifest twice and hashed."""


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
            manifest = _whole(folder / name)
        except ArchiveError as error:
            errors.append(error)
            continue
        if errors:
            warnings.warn(f"{folder / MANIFEST} is damaged or missing; its copy is used.", ArchiveWarning, stacklevel=3)
        return _current(manifest)
    raise errors[0]


def _whole(path: Path) -> dict[str, Any]:
    try:
        manifest = json.loads(path.read_bytes())
    except (FileNotFoundError, NotADirectoryError):
        raise ArchiveError(f"{path.parent} holds no run (it has no {MANIFEST}).") from None
    except OSError as error:
        raise ArchiveError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:
        raise ArchiveError(f"{path} is damaged: it is not JSON ({error}).") from error
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise ArchiveError(f"{path} does not describe a run of this package.")
    version, recorded = manifest.get("version"), manifest.pop("sha256", None)
    if isinstance(version, int) and version > VERSION:
        raise ArchiveError(
            f"{path.parent} was written in format {version} of a newer version; this one reads up to {VERSION}."
        )
    if recorded != _digest(manifest) and not (version == 1 and recorded is None):
        raise ArchiveError(f"{path} is damaged: its sha256 is not the one that was recorded when it was written.")
    return manifest


def _current(manifest: dict[str, Any]) -> dict[str, Any]:
    """The same in today's format."""
    if manifest["version"] == 1:
        manifest = {**manifest, "version": VERSION, "checkpoints": [manifest["checkpoint"]]}
        del manifest["checkpoint"]
    return manifest


def _digest(manifest: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(manifest).encode()).hexdigest()
