"""What may change of a run that goes on, and in a run that starts from one of its states: settings of its scene.

Tests: tests/unit/run/test_extend.py, tests/unit/run/test_branch.py.
"""

from collections.abc import Sequence
from typing import Any

from astroinertia.effects.doors import as_written, made_of
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads, refuse_other_options
from astroinertia.scene.plan import cadence
from astroinertia.scene.schema import Scene
from astroinertia.scene.source import key_of
from astroinertia.scene.text import toml_value
from astroinertia.units import shown

OF_A_RUN = (
    "time.end", "time.max_steps", "output.series_every", "output.series_steps", "output.snapshot_every",
    "output.align", "output.checkpoint_seconds",
)  # fmt: skip
OF_A_BRANCH = ("name", "description", "effects", "numerics", "time", "output", "regions", "observables")
_NOT_PHYSICS = {"time", "output", "source", "overrides", "origin", "reasons", "choice"}


def going_on(scene: Scene, settings: Sequence[str]) -> Scene:
    """The scene of a run with "key.path=value" settings put in, with which the run goes on.

    Where it says nothing of how often outputs are written, that stays as it was. SceneError names what must stay.
    """
    for setting in settings:
        if (key := ".".join(key_of(setting))) not in OF_A_RUN:
            raise SceneError(
                f"--set {shown(setting)}: {shown(key)} stays as it is in a run that goes on, which may change "
                f"{', '.join(OF_A_RUN)}; `astroinertia branch` starts another run from one of its states."
            )
    if scene.output.error_bars:
        raise SceneError(
            "a run with error bars goes on with no other settings, for its companion runs end where it does: run its "
            "scene again, or branch it."
        )
    changed = with_settings(scene, [*_as_often(scene, settings), *settings])
    if changed.model_dump(exclude=_NOT_PHYSICS) != scene.model_dump(exclude=_NOT_PHYSICS):
        raise SceneError('effects = "auto" chooses other effects with these settings: branch the run, and name them.')
    return changed


def branch_of(scene: Scene, settings: Sequence[str], things: Sequence[Any]) -> Scene:
    """The scene of a branch of a run, with settings put in and effects or observables of the user's own besides.

    things: those, and what of them the run was given; effects that it was given may have other options now. SceneError
    names what must stay.
    """
    for setting in settings:
        if (key := key_of(setting))[0] not in OF_A_BRANCH:
            raise SceneError(
                f"--set {shown(setting)}: {shown('.'.join(key))} stays as it is in a branch, whose body is that of the "
                f"run; it may change what is in {', '.join(OF_A_BRANCH)}."
            )
    listed = []
    for own in things:
        if made_of(own) not in scene.own_classes or isinstance(own, type):
            continue
        if own.kind in scene.own:
            table = "candidates" if own.kind in scene.candidates else "effects"
            listed.append(f"{table}.{own.kind}={toml_value(as_written(own, scene.dimensionless))}")
        else:
            refuse_other_options(scene, own)
    fresh = [own for own in things if made_of(own) not in scene.own_classes]
    changed = with_settings(scene, [*settings, *listed], fresh)
    if changed.output.error_bars:
        raise SceneError(
            "a branch has no error bars, for companion runs begin at the start: set output.error_bars=false."
        )
    return changed


def with_settings(scene: Scene, settings: Sequence[str], effects: Sequence[Any] = ()) -> Scene:
    """The scene with settings put in, and effects of the user's own besides."""
    return loads(scene.to_toml(), settings, scene.origin, effects=(*scene.own_classes, *effects))


def _as_often(scene: Scene, settings: Sequence[str]) -> list[str]:
    """Settings by which outputs are as far apart as before, where that has followed from the end."""
    said, when = set(map(key_of, settings)), cadence(scene)
    kept = []
    if scene.output.series_every is None and when.series_every is not None and ("output", "series_steps") not in said:
        kept.append(f"output.series_every={scene.time_setting(when.series_every)}")
    if scene.output.snapshot_every is None:
        kept.append(f"output.snapshot_every={scene.time_setting(when.snapshot_every)}")
    return kept
