"""Sinks of a particle fluid: those that a scene begins with, and what a run does about them between its steps."""

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.build.companions import refuse_fields
from astroinertia.errors import SceneError
from astroinertia.models import checkpoint
from astroinertia.scene.apart import beside_sinks
from astroinertia.scene.plan import smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph.kernels import KERNELS
from astroinertia.sph.table import MAX_PARTICLES, read_body
from astroinertia.units import CodeUnits

STORED = ".points['sinks'].{}"  # their arrays in a checkpoint


def beside(scene: Scene, units: CodeUnits, problem: Any, mass: np.ndarray) -> dict[str, Any]:
    """The sinks that the scene begins with beside particles of those masses; nothing where it does not list them."""
    found = none(scene, problem, mass)
    count = len(scene.sinks)

    def vectors(name: str) -> np.ndarray:
        return np.array([getattr(sink, name) or (0.0, 0.0, 0.0) for sink in scene.sinks]).reshape(count, 3)

    return {
        kind: replace(
            nothing,
            mass=units.to_code(np.array([sink.mass for sink in scene.sinks]), "mass"),
            position=units.to_code(vectors("position"), "length"),
            velocity=units.to_code(vectors("velocity"), "velocity"),
            spin=np.zeros((count, 3)),
            identity=np.arange(count),
            formed=np.int64(count),
        )
        for kind, nothing in found.items()
    }


def none(scene: Scene, problem: Any, mass: np.ndarray) -> dict[str, Any]:
    """No sinks beside particles of those masses yet; nothing in a scene that does not list them."""
    refuse(scene, problem.effects, float(mass.max()))
    if (effect := _effect(problem.effects)) is None:
        return {}
    # Only here: other scenes do without them.
    from astroinertia.models.sph.sinks import no_sinks

    return {effect.kind: no_sinks(effect.softening, len(mass))}


def refuse(scene: Scene, effects: Sequence[Any], heaviest: float | None) -> None:
    """SceneError where the engine cannot drop particles, where something would move sinks as it moves the fluid, where
    particles at the density of new sinks would not fit into their radius, or where there are no sinks at all.

    heaviest: the mass of the heaviest particle, in code units; None where it is not known before there are particles.
    """
    effect = _effect(effects)
    if effect is None:
        if scene.sinks:
            raise SceneError("[[sinks]] attract and accrete by [effects.sinks], which the scene does not list.")
        return
    listed = scene.where_listed("sinks")
    if scene.numerics.engine == "xla":
        raise SceneError(f"{listed} needs the engine numba_cpu: programs of xla keep the number of particles.")
    refuse_fields(scene, "sinks")
    if "companions" in scene.effects and (why := beside_sinks(scene.effects["companions"])):
        raise SceneError(f"{scene.where_listed('companions')} {why}.")
    if scene.sinks and "companions" in scene.effects:
        raise SceneError("[[sinks]] and [[companions]] have places of their own: list all points as [[sinks]].")
    if len(scene.sinks) > int(effect.number):
        raise SceneError(f"{listed} number must be at least that of [[sinks]], {len(scene.sinks)}.")
    if effect.density is None:
        if not scene.sinks:
            raise SceneError(f"{listed} needs a density, above which sinks form, or [[sinks]] that are there.")
        return
    length = next((each.fixed_length for each in effects if each.fixed_length is not None), None)
    far = "with that softening of gravity"
    if length is None:
        if heaviest is None:
            return
        length, far = smoothing(scene)[0] * (heaviest / effect.density) ** (1.0 / 3.0), "at its density"
    reach = KERNELS[scene.numerics.kernel].support * length
    if reach > effect.radius:
        raise SceneError(
            f"{listed} radius must be at least {reach / effect.radius:.3g} times as large: "
            f"kernels reach that far {far}."
        )


def refuse_before_particles(scene: Scene, units: CodeUnits, effects: Sequence[Any]) -> None:
    """The same, as far as it is known before there are particles: those of a sphere or star have one mass."""
    known = [_heaviest(alone, units) for alone in scene.alone()] if _effect(effects) is not None else []
    refuse(scene, effects, max((mass for mass in known if mass is not None), default=None))


def _heaviest(scene: Scene, units: CodeUnits) -> float | None:
    """The mass of a body's heaviest particle, in code units; None where only a built body has it."""
    body: Any = scene.body
    if body.placing == "placing.of_table":
        return float(read_body(body.path(scene), units, body.velocity_unit).mass.max())
    known = body.structure and body.mass is not None
    return units.to_code(body.mass, "mass") / body.particles if known else None


def between(problem: Any) -> Any:
    """What is done between steps; None without sinks."""
    if _effect(problem.effects) is None:
        return None
    return importlib.import_module("astroinertia.models.sph.accretion").step


def at_first(arrays: Mapping[str, np.ndarray], count: int) -> int:
    """The number of particles that the run of a checkpoint began with, which has `count` of them now."""
    original = arrays.get(STORED.format("particles"), np.array(count))
    if original.shape != () or original.dtype.kind != "i" or not count <= original <= MAX_PARTICLES:
        raise ValueError("it does not say how many particles there were before the sinks")
    return int(original)


def limits(effects: Sequence[Any], sunk: int, count: int) -> dict[str, tuple[float, float]]:
    """The least and the largest values of the arrays of so many sinks in a checkpoint of so many particles."""
    effect = _effect(effects)
    if effect is None:
        return {}
    most = int(effect.number)
    found = {"mass": checkpoint.POSITIVE, "formed": (sunk, most), "identity": (0, most - 1),
             "particles": (count, MAX_PARTICLES)}  # fmt: skip
    return {STORED.format(name): span for name, span in found.items()}


def _effect(effects: Sequence[Any]) -> Any:
    return next((effect for effect in effects if effect.kind == "sinks"), None)
