"""The effects that a scene lists, made from their options in code units: no other effect's module is imported."""

from typing import Any

from astroinertia.effects import catalogue
from astroinertia.errors import SceneError
from astroinertia.scene.dimensional import in_code_units
from astroinertia.scene.electron_axis import in_matter
from astroinertia.scene.plan import gravity_method
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits


def effects_of(scene: Scene, units: CodeUnits, particles: int | None = None) -> tuple[Any, ...]:
    """What acts on the body, in the order of Scene.entries; what the scene's model has no use for is left out.

    particles: their number, from which gravity's method follows where the scene leaves it open. Raises SceneError where
    options contradict each other.
    """
    built = []
    for kind, entry in scene.entries.items():
        if kind in scene.effects and scene.model in entry.models:
            options = {
                name: in_code_units(value, entry.options[name].dimension, units)
                for name, value in scene.effects[kind].items()
                if scene.model in entry.options[name].models
            }
            if options.get("method") == "auto" and particles is not None:
                options["method"] = gravity_method(scene, particles)
            try:
                built.append(in_matter(catalogue.build(kind, options, scene.entries).in_units(units), scene, units))
            except ValueError as error:
                raise SceneError(f"[effects.{kind}] {error}") from None
    return tuple(built)
