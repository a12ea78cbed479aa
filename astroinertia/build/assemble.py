"""From a validated scene to a problem in code units: the one place where all parts are put together."""

import importlib
import platform
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from astroinertia.build import companions, sinks
from astroinertia.build.effects import effects_of, refuse_in_turning_frame, refuse_without_heat
from astroinertia.build.refusals import refuse_impossible
from astroinertia.build.spheres import Sphere, Star, sphere
from astroinertia.build.structure import structure
from astroinertia.effects.doors import Door, made_of
from astroinertia.errors import ArchiveError, ArchiveWarning, SceneError
from astroinertia.models.protocol import Evolution
from astroinertia.observables.observable import Observable
from astroinertia.observables.own import quantity_of
from astroinertia.scene import load
from astroinertia.scene.dimensional import options_in_code_units
from astroinertia.scene.own import DOORS, by_door
from astroinertia.scene.plan import cadence, code_units, plan, region_descriptions, smoothing, softening
from astroinertia.scene.schema import Scene
from astroinertia.storage.archive import Archive
from astroinertia.storage.bounded import plain_text
from astroinertia.storage.manifest import Count, complaint
from astroinertia.units import CodeUnits

BRANCH = "branched_from"  # of a run's description: which run it is a branch of, and where it begins
_Seconds = Annotated[float, Field(ge=0.0, le=1e12)]


class Counters(BaseModel):
    """Where the outputs of a run stand, as its checkpoints have it; they may come from anywhere."""

    model_config = ConfigDict(strict=True)

    opening_potential: float | None = None
    series: Count = 0
    snapshot: Count = 0
    wall_time: _Seconds = 0.0
    opening_energy: float = 0.0
    measured: dict[str, int | float | str | list[float]] | None = None


@dataclass(frozen=True)
class Outputs:
    """When a run records what, in code units; None is never."""

    end: float
    max_steps: float
    series_every: float | None
    series_steps: int | None
    snapshot_every: float | None
    align: bool
    checkpoint_seconds: float
    observables: tuple[Observable, ...] = ()


@dataclass(frozen=True)
class Prepared:
    """A run about to start or go on: the body under its model, and where the outputs stand."""

    evolution: Evolution
    outputs: Outputs
    units: CodeUnits
    counters: dict[str, Any]


def prepare(scene: Scene, units: CodeUnits | None = None) -> Prepared:
    """The scene at time 0. units: the scene's own without them."""
    units = code_units(scene) if units is None else units
    return Prepared(_model(scene).evolution(scene, units), outputs_of(scene, units), units, _plain(Counters()))


def scene_of(archive: Archive, effects: Sequence[Any] = ()) -> Scene:
    """The scene that a run was made from.

    effects: those of the user's own that it was given from Python, or their classes, and its equation of state and
    observables where those were. ArchiveError names what is not here of them; SceneError, one that it was not given, or
    that has other options than it had.
    """
    metadata = archive.metadata
    if not isinstance(metadata.get("scene"), str):
        raise ArchiveError(f"{archive.folder} does not hold the scene that its run was made from.")
    for door, kind in missing(archive, effects):
        origin = plain_text(metadata[door.described][kind])
        raise ArchiveError(
            f"{archive.folder} was run with the {door.thing} '{plain_text(kind)}' ({origin}), which is not here: "
            f"install its package, or give it from Python to astroinertia.resume or branch, as {door.argument}."
        )
    classes = [made_of(effect) for effect in effects]
    scene = load.loads(metadata["scene"], origin=metadata.get("origin"), effects=classes)
    for effect in effects:
        load.refuse_other_options(scene, effect)
    return scene


def missing(archive: Archive, effects: Sequence[Any] = ()) -> list[tuple[Door, str]]:
    """Doors and kinds of what a run was given and what is neither built in nor given here nor offered by an installed
    package.
    """
    given = by_door(effects)
    return [
        (door, kind)
        for door in DOORS
        for kind in archive.metadata.get(door.described, {})
        if kind not in {*given[door], *door.offered(), *door.taken}
    ]


def restore(archive: Archive, scene: Scene) -> Prepared:
    """A run of that scene at its last checkpoint."""
    stored = archive.read_checkpoint()
    if stored is None and BRANCH in archive.metadata:
        raise ArchiveError(f"{archive.folder} ended before the state that it begins with was saved: branch it again.")
    if stored is None:
        return prepare(scene)
    units = code_units(scene)
    arrays, counters = stored
    with _of_this_scene(archive):
        if wrong := complaint(Counters, counters):
            raise ValueError(wrong)
        body = _model(scene).resumed(scene, units, arrays)
    return Prepared(body, outputs_of(scene, units), units, _plain(Counters(**counters)))


def body_of(archive: Archive, scene: Scene, arrays: Mapping[str, np.ndarray], snapshot: bool = False) -> Evolution:
    """The body of a scene in a state that its run has saved; ArchiveError where it is another's."""
    model, units = _model(scene), code_units(scene)
    with _of_this_scene(archive):
        return (model.of_snapshot if snapshot else model.resumed)(scene, units, arrays)


def branched(scene: Scene, parent: Evolution) -> Prepared:
    """A scene that begins where the body of another run is."""
    units = code_units(scene)
    return Prepared(_model(scene).branched(scene, units, parent), outputs_of(scene, units), units, _plain(Counters()))


def refuse_branch(run: Scene, branch: Scene) -> None:
    """SceneError where a run of one scene can have no branch of the other."""
    model = _model(run)
    if not hasattr(model, "branched"):
        raise SceneError(f"the model {run.model} has no states to branch from: run its scene with other settings.")
    model.refuse_branch(run, branch)


def has_snapshots(scene: Scene) -> bool:
    """Whether the model can begin with a snapshot."""
    return hasattr(_model(scene), "of_snapshot")


@contextmanager
def _of_this_scene(archive: Archive) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise ArchiveError(f"{archive.folder} has a state of another scene: {plain_text(error)}.") from error


def _plain(counters: Counters) -> dict[str, Any]:
    return counters.model_dump(exclude={"measured"} if counters.measured is None else None)


def _model(scene: Scene) -> Any:
    # Only the model that answers the scene is imported.
    return importlib.import_module(f"astroinertia.build.{scene.model}")


def outputs_of(scene: Scene, units: CodeUnits) -> Outputs:
    """When to record, in code units."""
    when = cadence(scene)
    return Outputs(
        end=units.to_code(scene.time.end, "time"),
        max_steps=scene.time.max_steps or float("inf"),
        series_every=None if when.series_every is None else units.to_code(when.series_every, "time"),
        series_steps=when.series_steps,
        snapshot_every=units.to_code(when.snapshot_every, "time") if scene.model == "sph" else None,
        align=scene.output.align,
        checkpoint_seconds=scene.output.checkpoint_seconds,
        observables=tuple(
            entry.build(options_in_code_units(scene.observables[kind], entry.options, units))
            for kind, entry in scene.observed.items()
        ),
    )


def refuse_contradictions(scene: Scene) -> None:
    """SceneError where options of an effect contradict each other, or the body cannot be, before any preparation."""
    refuse_impossible(scene)
    units = code_units(scene)
    effects = effects_of(scene, units)
    refuse_in_turning_frame(scene, effects)
    if scene.model == "sph":
        if scene.equation_of_state is not None and scene.equation_of_state.barotropic:
            refuse_without_heat(scene, effects)
        companions.refuse_with_particles(scene, effects)
        sinks.refuse_before_particles(scene, units, effects)


def metadata(scene: Scene, units: CodeUnits | None = None) -> dict[str, Any]:
    """What a run's file says of where it came from: enough to repeat it. units: the scene's own without them."""
    units = code_units(scene) if units is None else units
    initial = sphere(scene, units)
    return {
        "name": scene.name,
        "description": scene.description,
        "scene": scene.to_toml(),
        "plan": plan(scene).text(),
        "origin": scene.origin,
        "overrides": list(scene.overrides),
        "dimensionless": scene.dimensionless,
        "code_units": {"mass": units.mass, "length": units.length, "G": units.gravitational_constant},
        "reference_radius": _reference_radius(scene, units, initial),
        "reference_radius_convention": "radius that the scene gives" if initial is None else initial.radius_convention,
        "structure": structure(scene, units, initial),
        "model": scene.model,
        **_numerics(scene),
        "effects": [kind for kind in scene.entries if kind in scene.effects],
        **({"box": _sides(scene)} if scene.box else {}),
        "companions": companions.names(scene, units),
        "skipped_effects": {
            kind: f"a numerical device of particles, which the model {scene.model} does not need"
            for kind, entry in scene.entries.items()
            if kind in scene.effects and scene.model not in entry.models
        },
        **_outside(scene),
        **({"regions": region_descriptions(scene)} if scene.regions else {}),
        **({"choice": dict(scene.choice)} if scene.choice else {}),
        "versions": versions(scene),
    }


def _outside(scene: Scene) -> dict[str, Any]:
    """Where what is not of this package comes from; and what observables are, for results that lack their classes."""
    origins = {
        door.described: {each.kind: each.entry.origin for each in scene.outside if each.table == door.table}
        for door in DOORS
    }
    said = {kind: quantity_of(entry).described() for kind, entry in scene.observed.items()}
    return {name: value for name, value in {**origins, "observables": said}.items() if value}


def versions(scene: Scene) -> dict[str, str]:
    """Of Python and of what decides a run's numbers, here and now, packages of its own among them."""
    names = ("numpy", "numba", "jax", "diffrax", "rebound", "xarray", "netCDF4", "astropy")
    own = dict(each.entry.package.rsplit(" ", 1) for each in scene.outside if each.entry.package)
    return {"python": platform.python_version(), **{name: version(name) for name in names}, **own}


def note_versions(archive: Archive, scene: Scene) -> None:
    """Where a run of that scene goes on with other versions than so far, say so and add them to its description.

    ArchiveWarning names what has changed; `resumed_versions` lists what the run went on with, one after the other.
    """
    metadata = archive.metadata
    since = metadata.get("resumed_versions")
    since = since if isinstance(since, list) else []
    before, now = ([metadata.get("versions"), *since])[-1], versions(scene)
    if archive.finished is not None or not isinstance(before, dict) or before == now:
        return
    changed = [f"{name} {before.get(name, 'unknown')} to {now[name]}" for name in now if before.get(name) != now[name]]
    archive.describe({"resumed_versions": [*since, now]})
    warnings.warn(
        f"{archive.folder} goes on with other versions than so far ({', '.join(changed)}): from here on it is not bit "
        "for bit what it would have been; both are recorded.",
        ArchiveWarning,
        stacklevel=2,
    )


def _reference_radius(scene: Scene, units: CodeUnits, initial: Sphere | Star | None) -> float | None:
    if initial is not None:
        return initial.radius
    return None if scene.body.radius is None else units.to_code(scene.body.radius, "length")


def model_description(evolution: Evolution) -> dict[str, Any]:
    """What a file says of the model itself: the rows of its ledger, what it lacks, and what it approximates."""
    return {
        "effects": list(evolution.effects),
        "absent": dict(evolution.absent),
        "approximation": evolution.approximation,
    }


def _sides(scene: Scene) -> list[float | None]:
    """Lengths of the box along x, y and z, None where it does not repeat itself."""
    assert scene.box is not None
    return [length if there else None for length, there in zip(scene.box.lengths, scene.box.repeats, strict=True)]


def _numerics(scene: Scene) -> dict[str, Any]:
    chosen = scene.numerics
    if scene.model == "sph":
        body: Any = scene.body
        bodies: Any = scene.bodies or (body,)
        counts = [round(each.placed(scene, each.particles)) for each in bodies] if scene.particles else []
        return {
            "engine": chosen.engine, "precision": scene.precision, "kernel": chosen.kernel, "seed": body.seed,
            **({"neighbours": smoothing(scene)[1]} if softening(scene) is None else {}),
            **({"body_particles": counts} if counts else {}),
        }  # fmt: skip
    return {"engine": chosen.integrator, "precision": "float64", "tolerance": chosen.tolerance}
