"""A run that starts from a state of another one, in a folder of its own, with other effects, numerics or outputs."""

import math
import time as clock
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from astroinertia.build.assemble import (
    BRANCH,
    body_of,
    branched,
    has_snapshots,
    metadata,
    prepare,
    refuse_branch,
    scene_of,
)
from astroinertia.effects.doors import made_of
from astroinertia.engines import hosts
from astroinertia.engines.mesh import shared_out
from astroinertia.errors import ArchiveError, NumericalError, SceneError
from astroinertia.models.protocol import Evolution
from astroinertia.run.callback import callback_of
from astroinertia.run.extend import dated, number_of
from astroinertia.run.loop import Listener, computing, in_si, predicted, refuse_before, run_prepared
from astroinertia.scene.changed import branch_of
from astroinertia.scene.dimensional import dimensional
from astroinertia.scene.own import DOORS
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from astroinertia.scene.source import override_value
from astroinertia.storage.archive import Archive
from astroinertia.storage.outputs import SNAPSHOT
from astroinertia.units import with_unit, written_quantity

_SAME_TIME = 1e-14  # share of a time by which two differ that are meant to be the same


class _Stored(NamedTuple):
    """A state that a run has, at a time in code units: where it is, and its arrays; without them, it is the start."""

    time: float
    place: str
    arrays: dict[str, np.ndarray] | None = None
    snapshot: bool = False


def branch(
    run: Path, folder: Path, at: Any = None, settings: Sequence[str] = (), effects: Sequence[Any] = (),
    listener: Listener | None = None, begun: float | None = None, deadline: float = math.inf, callback: Any = None,
    every: Any = None,
) -> Path:  # fmt: skip
    """Run in a new folder what becomes of a run from a time on with other settings; returns its netCDF file.

    The run in the folder `run` is carried on as it was, from the last state that it has at or before `at`, to that
    time, and its body is the branch's first state. at: a text with a unit, or a number in SI, in code units where the
    scene is; the last state there is without it. settings: "key.path=value" (scene.changed.OF_A_BRANCH). effects: of
    the user's own, new ones and the classes or functions that the run was given. callback, every: as for
    run.callback.callback_of. Where the branch begins is in its description and in its dataset's history. Raises
    SceneError and ArchiveError, with nothing written, and whatever run_scene raises. Tests:
    tests/unit/run/test_branch.py.
    """
    begun = clock.monotonic() if begun is None else begun
    hosts.must_be_alone("a branch")
    archive = Archive.view(run)
    scene = scene_of(archive, [own for own in map(made_of, effects) if _has(archive, own)])
    new = branch_of(scene, settings, effects)
    called = callback_of(callback, every, new)
    refuse_branch(scene, new)
    refuse_before(new, folder)
    until = moment(scene, at)
    described = metadata(new) | predicted(new)
    described.pop("predicted_wall_time", None)  # that is what the whole of its scene would take
    with computing():
        with shared_out(scene.numerics.devices):
            stored = _nearest(archive, scene, until)
            if not max(stored.time, until or 0.0) < code_units(new).to_code(new.time.end, "time"):
                raise SceneError("a branch must end later than it begins: set time.end.")
            body = _carried_to(archive, scene, stored, stored.time if until is None else until)
        particles: Any = body  # no other model begins with a snapshot
        kept = stored.arrays or {}
        again = sorted(name for name in particles.state.memory if name not in kept) if stored.snapshot else []
        described |= _origin(archive, scene, new, stored, body.time, settings, again)
        with shared_out(new.numerics.devices):
            return run_prepared(described, branched(new, body), folder, listener, begun, None, deadline, called)


def _has(archive: Archive, made: Any) -> bool:
    return any(getattr(made, "kind", None) in archive.metadata.get(door.described, {}) for door in DOORS)


def moment(scene: Scene, at: Any, said: str = "the time of a branch") -> float | None:
    """A time of a run in code units; SceneError for what is none, or lies beyond the end of the run."""
    if at is None:
        return None
    try:
        if (quantity := with_unit(at)) is not None:
            at = written_quantity(quantity)
        if isinstance(at, str):
            seconds = dimensional(override_value(at, said), "time", scene.dimensionless)
        else:
            seconds = dimensional(at, "time", code=True)
    except ValueError as error:
        raise SceneError(f"{said} {error}") from None
    if not 0.0 <= seconds <= scene.time.end:
        raise SceneError(f"{said} must lie within the run, which ends at time {scene.shown(scene.time.end, 'time')}.")
    return code_units(scene).to_code(seconds, "time")


def _nearest(archive: Archive, scene: Scene, until: float | None) -> _Stored:
    """The last state that a run has at or before a time, or of all; of equal ones the checkpoint, which has all."""
    latest = math.inf if until is None else until * (1.0 + _SAME_TIME)
    nearest = None if BRANCH in archive.metadata else _Stored(0.0, "its start")
    for file, arrays in archive.checkpoints():
        if 0.0 <= (time := number_of(archive, arrays, ".time", "time")) <= latest:
            nearest = _Stored(time, f"the checkpoint {file}", arrays)
            break
    for part in archive.snapshots_unread() if has_snapshots(scene) else ():
        for number, time in enumerate(part.times):
            if 0.0 <= time <= latest and (nearest is None or time > nearest.time):
                rows = {name: part.rows.row(f"{SNAPSHOT}{name}", number) for name in part.layout}
                nearest = _Stored(float(time), f"the snapshot {number} of {part.rows.path.name}", rows, True)
    if nearest is None:
        raise ArchiveError(f"{archive.folder} has no state at or before that time to branch from.")
    return nearest


def _carried_to(archive: Archive, scene: Scene, stored: _Stored, until: float) -> Evolution:
    """The body of a run in a state that it has, and from there on as its scene says, to a time."""
    if stored.arrays is None:
        body = prepare(scene).evolution
    else:
        body = body_of(archive, scene, stored.arrays, stored.snapshot)
    try:
        while body.time < until * (1.0 - _SAME_TIME):
            body.advance(until)
    except NumericalError as error:
        raise in_si(error, code_units(scene)) from None
    return body


def _origin(
    archive: Archive,
    scene: Scene,
    new: Scene,
    stored: _Stored,
    time: float,
    settings: Sequence[str],
    again: Sequence[str],
) -> dict[str, Any]:
    """What a branch's description has of where it comes from, and its history, which is the run's until then.

    again: what effects have evolved for themselves, and a snapshot lacks.
    """
    units = code_units(scene)
    name, seconds, begins = archive.metadata["name"], units.to_si(time, "time"), units.to_si(stored.time, "time")
    changed = [*settings, *(f"the effect {kind}" for kind in new.own if kind not in scene.own)]
    event = f"branched from the run '{name}' at time {scene.shown(seconds, 'time')}, by {stored.place}"
    if not math.isclose(begins, seconds, rel_tol=1e-12):
        event += f" at time {scene.shown(begins, 'time')}, and on from there"
    if again:
        event += f" ({' and '.join(again)}, which snapshots lack, began again at time {scene.shown(begins, 'time')})"
    return {
        "structure": archive.metadata.get("structure", {}),
        BRANCH: {
            "run": name, "folder": str(archive.folder), "manifest_sha256": archive.digest, "time": seconds,
            "state": stored.place, "state_time": begins, "began_again": list(again), "changed": changed,
        },
        **dated(archive.metadata, f"{event}, with {' and '.join(changed) or 'nothing changed'}"),
    }  # fmt: skip
