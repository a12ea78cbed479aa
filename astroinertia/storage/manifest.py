"""What belongs to a run: its description and its saved files, in two copies that know their own hash.

The copy is written first, so that at any instant one of the two is whole and tells a consistent state of the run;
where a disk damages one, the other is used. Tests: tests/unit/storage/test_archive.py, tests/crash/test_faults.py.
"""

import hashlib
import json
import math
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from astroinertia.errors import ArchiveError, ArchiveWarning
from astroinertia.storage.atomic import read_json, write_json
from astroinertia.storage.bounded import plain_text

MANIFEST = "manifest.json"
COPY = "manifest-copy.json"
FAILURE = "failure.json"  # of a member of a sweep that failed: sweeps.folder
FORMAT = "astroinertia-run"
SAVED = re.compile(r"(segment|snapshots|checkpoint)-[0-9]+\.npz")
VERSION = 3
"""1: one checkpoint, one manifest without a hash. 2: the last two checkpoints, the manifest twice and hashed, snapshots
with the records of a segment. 3: snapshots in files of their own, described here; records as one table."""


Count = Annotated[int, Field(ge=0, lt=2**53)]
_Size = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
_Exponent = Annotated[float, Field(ge=-100.0, le=100.0)]
_Text = str | None
_Value = None | bool | Annotated[int, Field(ge=-(2**63), lt=2**63)] | float | str | list | dict
_Key = Annotated[str, Field(pattern=r"^[A-Za-z]\w{0,99}$")]


class _Plain(BaseModel):
    model_config = ConfigDict(strict=True)


class _Units(_Plain):
    mass: _Size
    length: _Size
    G: _Size


class _Quantity(_Plain):
    """A quantity that is not of the schema."""

    dims: Annotated[list[Literal["time", "effect", "i", "j", "principal", "mode"]], Field(min_length=1)]
    dimension: Annotated[list[_Exponent], Field(min_length=3, max_length=3)] | None
    unit: str
    long_name: str
    comment: str


class _Metadata(_Plain):
    """What is used of a run's description, and so must be what it is taken for; of the rest only that it is plain."""

    model_config = ConfigDict(strict=True, extra="allow")
    __pydantic_extra__: dict[_Key, _Value]

    name: str
    scene: _Text = None
    origin: _Text = None
    frame: _Text = None
    reference_radius_convention: _Text = None
    dimensionless: bool = False
    code_units: _Units | None = None
    effects: list[str] = []
    companions: list[str] = []
    regions: dict[str, str] = {}
    absent: dict[str, str] = {}
    skipped_effects: dict[str, str] = {}
    own_effects: dict[str, str] = {}
    own_matter: dict[str, str] = {}
    own_observables: dict[str, str] = {}
    observables: dict[_Key, _Quantity] = {}
    own_bodies: dict[str, str] = {}
    reference_radius: float | None = None
    structure: dict[str, float] = {}
    box: list[float | None] = []
    neighbours: float | None = None
    body_particles: list[Count] = []
    principal_gap_tolerance: float | None = None
    predicted_evolution_time: float = math.nan
    predicted_steps: float = math.inf
    predicted_course: list[float] = [0.0, 1.0]
    history: list[str] = []


class _Segment(_Plain):
    """Records or snapshots; of snapshots the shapes and, in newer files, the types and times."""

    file: Annotated[str, Field(pattern=r"^(segment|snapshots)-[0-9]+\.npz$")]
    sha256: str
    records: Count
    snapshots: Count
    layout: dict[str, list[Count]] | None = None
    types: dict[str, Annotated[str, Field(pattern=r"^[<>|=][biufcSU][0-9]{1,4}$")]] | None = None
    times: list[float] | None = None

    @model_validator(mode="after")
    def _of_snapshots(self) -> Self:
        if self.snapshots and self.layout is None:
            raise ValueError("snapshots have no layout")
        if self.times is not None:
            layout = self.layout or {}
            if len(self.times) != self.snapshots or "time" not in layout or (self.types or {}).keys() != layout.keys():
                raise ValueError("the times and types of snapshots are not those of what is laid out")
        return self


class _Checkpoint(_Plain):
    file: Annotated[str, Field(pattern=r"^checkpoint-[0-9]+\.npz$")]
    sha256: str
    segments: Count


class _Final(_Plain):
    file: Annotated[str, Field(pattern=r"^[^/\\\s]*\.nc$")]  # in this folder
    sha256: str
    segments: Count


class _Manifest(_Plain):
    """The schema of a manifest: its own hash whoever wrote it may have found, too."""

    version: Literal[3]
    serial: Count
    metadata: _Metadata
    segments: list[_Segment]
    checkpoints: Annotated[list[_Checkpoint | None], Field(min_length=1, max_length=2)]
    final: _Final | None = None

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        numbers = [0 if checkpoint is None else checkpoint.segments for checkpoint in self.checkpoints]
        if sorted(numbers) != numbers or numbers[-1] > len(self.segments):
            raise ValueError("a checkpoint follows segments that are not there")
        return self


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
    content = {**manifest, "sha256": digest(manifest)}
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


def _failure(folder: Path) -> str:
    """Why a member of a sweep that is to be in a folder was never begun, where that was noted; else nothing."""
    try:
        noted = read_json(folder / FAILURE)
    except (FileNotFoundError, NotADirectoryError, ArchiveError):
        return ""
    sentence = noted.get("sentence") if isinstance(noted, dict) else None
    return f": this member of a sweep failed. {plain_text(sentence)}" if isinstance(sentence, str) else ""


def read_file(path: Path) -> dict[str, Any]:
    """One of the two copies, in today's format; ArchiveError where it is missing, damaged or not of this package."""
    try:
        manifest = read_json(path)
    except (FileNotFoundError, NotADirectoryError):
        why = _failure(path.parent)
        if any((path.parent / name).exists() for name in ("zarr.json", ".zgroup")):
            why = ": it is a Zarr store, which xarray.open_datatree opens"
        raise ArchiveError(f"{path.parent} holds no run (it has no {MANIFEST}){why or '.'}") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise ArchiveError(f"{path} does not describe a run of this package.")
    version, recorded = manifest.get("version"), manifest.pop("sha256", None)
    if isinstance(version, int) and version > VERSION:
        raise ArchiveError(
            f"{path.parent} was written in format {version} of a newer version; this one reads up to {VERSION}."
        )
    if recorded != digest(manifest) and not (version == 1 and recorded is None):
        raise ArchiveError(f"{path} is damaged: its sha256 is not the one that was recorded when it was written.")
    manifest = _current(manifest)
    if wrong := complaint(_Manifest, manifest):
        raise ArchiveError(f"{path} was not written by this package: {wrong}.")
    return manifest


def _current(manifest: dict[str, Any]) -> dict[str, Any]:
    """The same in today's format."""
    if manifest.get("version") == 1:
        manifest = {**manifest, "checkpoints": [manifest.get("checkpoint")]}
        manifest.pop("checkpoint", None)
    return {**manifest, "version": VERSION} if manifest.get("version") in range(1, VERSION) else manifest


def complaint(schema: type[BaseModel], content: Any) -> str:
    """What in the content is not as its schema has it, and where, on one line; empty where all is."""
    try:
        schema.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        place, words = " ".join(map(str, first["loc"])), first["msg"].removeprefix("Value error, ")
        return plain_text(f"{place}: {words}" if place else words)
    return ""


def digest(manifest: Mapping[str, Any]) -> str:
    """The sha256 that both copies of a manifest have with them."""
    return hashlib.sha256(json.dumps(manifest).encode()).hexdigest()
