"""The effects that a scene lists, made from their options in code units: no other effect's module is imported."""

from typing import Any

from astroinertia.effects import catalogue
from astroinertia.errors import SceneError
from astroinertia.scene.apart import in_frame
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
                with entry.at_work(ValueError):
                    effect = catalogue.build(kind, options, scene.entries).in_units(units)
                built.append(in_matter(effect, scene, units))
            except ValueError as error:
                raise SceneError(f"{scene.where_listed(kind)} {error}") from None
            if kind in scene.own:
                from astroinertia.effects.own_terms import refuse_wrong_terms  # only here: what is built in is right

                refuse_wrong_terms(built[-1], scene.numerics.engine)
    return tuple(built)


def refuse_in_turning_frame(scene: Scene, effects: tuple[Any, ...]) -> None:
    """SceneError where an effect turns the frame of a scene that has what is right in inertial axes alone."""
    frame = next((effect.kind for effect in effects if effect.turns_frame), None)
    if frame is None:
        return
    for effect in effects:
        if why := in_frame(effect, frame):
            raise SceneError(f"{scene.where_listed(effect.kind)} {why}.")
    for name, region in scene.regions.items():
        if region.bound:
            raise SceneError(f"[regions.{name}] bound is judged in inertial axes, so it cannot be with {frame}.")


def refuse_without_heat(scene: Scene, effects: tuple[Any, ...]) -> None:
    """SceneError where an effect of matter whose pressure follows from the density alone changes its heat."""
    for effect in effects:
        if "exchange" in vars(type(effect)):
            raise SceneError(
                f"{scene.where_listed(effect.kind)} needs matter that can be warm, an ideal or hybrid gas."
            )
        if effect.needs_heat:
            raise SceneError(
                f"{scene.where_listed(effect.kind)} as it is set needs matter that can be warm, an ideal or hybrid gas."
            )
