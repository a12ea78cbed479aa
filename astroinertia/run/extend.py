"""A run that goes on with a later end, or with other outputs: what its folder has of it from then on."""

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from astroinertia.build.assemble import BRANCH, metadata
from astroinertia.errors import ArchiveError, SceneError
from astroinertia.scene.plan import cadence, code_units
from astroinertia.scene.schema import Scene
from astroinertia.storage.archive import Archive

_NEW = ("scene", "plan")  # of a run's description, what follows from what may be changed


def go_on_with(
    archive: Archive, scene: Scene, settings: Sequence[str], predicted: Mapping[str, Any], before: Scene
) -> None:
    """Have a run of an open archive be one of another scene, which differs from its own by those settings.

    before: its own.

    A run that had ended goes on from the checkpoint before its last one, for its last steps were those to its end, and
    its particles were not sorted there: what follows is that of a run that was to go so far from the start. With
    outputs at other times it goes on from its end, and keeps those that it has. SceneError where the run has come as
    far already, or its body has nothing left to evolve. Tests: tests/unit/run/test_extend.py.
    """
    time, steps, measured = _reached(archive)
    units, end = code_units(scene), scene.time.end
    if not time < units.to_code(end, "time") * (1.0 - 1e-14):
        raise SceneError(
            f"the run has reached time {scene.shown(units.to_si(time, 'time'), 'time')}: its end must be later."
        )
    if scene.time.max_steps is not None and steps >= scene.time.max_steps:
        raise SceneError(f"the run has taken {steps} steps: time.max_steps must be more.")
    reached = f"time {scene.shown(units.to_si(time, 'time'), 'time')}"
    if (why := measured.get("ended_early")) and steps < (before.time.max_steps or math.inf):
        raise SceneError(f"the run is over at {reached} and can go no further: {why}.")
    described = metadata(scene)
    if BRANCH in archive.metadata:  # that of its whole scene is none of a branch
        predicted = {name: figure for name, figure in predicted.items() if name != "predicted_wall_time"}
    archive.change(
        {name: described[name] for name in _NEW}
        | dict(predicted)
        | {"overrides": [*_list(archive, "overrides"), *settings]}
        | dated(
            archive.metadata,
            f"went on from {reached} with {' and '.join(settings)}",
        ),
        back=bool(measured) and cadence(scene) == cadence(before),
    )


def dated(described: Mapping[str, Any], event: str) -> dict[str, Any]:
    """The history of a run with another event in it, of now."""
    before = described.get("history")
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return {"history": [*(before if isinstance(before, list) else []), f"{now}: {event}"]}


def _list(archive: Archive, name: str) -> list[Any]:
    value = archive.metadata.get(name)
    return value if isinstance(value, list) else []


def _reached(archive: Archive) -> tuple[float, int, Mapping[str, Any]]:
    """Time in code units and steps of the last checkpoint, and what was measured where the run had ended there."""
    stored = archive.read_checkpoint()
    if stored is None:
        return 0.0, 0, {}
    arrays, counters = stored
    time, steps = number_of(archive, arrays, ".time", "time"), number_of(archive, arrays, ".step", "steps")
    return time, int(steps), counters.get("measured") or {}


def number_of(archive: Archive, arrays: Mapping[str, np.ndarray], *names: str) -> float:
    """The number of a checkpoint that models call by one of these names; ArchiveError where there is none."""
    for array in (arrays[name] for name in names if name in arrays):
        if array.shape == () and array.dtype.kind in "fiu":
            return float(array)
    raise ArchiveError(f"{archive.folder} has a checkpoint of another scene: it has no number {names[-1]!r}.")
