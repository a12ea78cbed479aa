"""`effects = "auto"`: those effects are on whose absence would cost the accuracy that is asked for, each with a reason.

Considered are what the model has that needs no numbers, and the scene's [candidates]; of the former none that cannot be
listed beside what is on. Tests:
tests/unit/effects/test_sizes.py, tests/physics/test_effects_auto.py.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.characteristic import Characteristic
from astroinertia.effects.sizes import MARGIN, Size, effect_size
from astroinertia.scene.apart import apart
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.options import effect_options
from astroinertia.scene.schema import Scene
from astroinertia.units import LIGHT

AUTO = "auto"
FIRST = ("gravity", "pressure")
ACCURACY = 1e-3  # where a scene asks for none


@dataclass(frozen=True)
class Choice:
    """The effects that are on, with their options, why each is on or off, and whether companions are kept."""

    effects: dict[str, dict[str, Any]]
    reasons: dict[str, str]
    companions: bool


def accuracy_of(scene: Scene) -> float:
    """The accuracy that a scene asks for."""
    return ACCURACY if scene.accuracy is None else scene.accuracy


def choose(scene: Scene) -> Choice:
    """The effects of a scene, of which `candidates` are those that it gives numbers for."""
    body, accuracy = characteristic(scene), accuracy_of(scene)
    considered = _considered(scene, body)
    effects: dict[str, dict[str, Any]] = {}
    reasons, sizes = {}, {}
    for kind in (name for name in scene.entries if name in considered):
        needed = _needed(kind, scene, body)
        # gravity and pressure, which come first, are judged against each other; the others beside what of them is on
        measure = scene.entries[kind].size
        sizes[kind] = effect_size(measure, body if kind in FIRST else settled(body, effects), considered[kind])
        on = bool(needed) or sizes[kind].counts(accuracy)
        if on:
            effects[kind] = considered[kind]
        reasons[kind] = f"{'on' if on else 'off'}: {needed or size_description(sizes[kind], accuracy)}"
    for kind in [kind for kind in effects if kind not in scene.candidates]:  # which the scene does not ask for
        if why := apart(kind, effects, scene.entries):
            del effects[kind]
            reasons[kind] = f"off: {why}; {size_description(sizes[kind], accuracy)}"
    kept = scene.model != "sph" or "companions" in effects
    return Choice(effects, reasons, kept)


def size_description(size: Size, accuracy: float) -> str:
    """What a size means, in words."""
    if size.change is None:
        return f"its size is not known: {size.unknown}"
    if size.number is None:
        return size.formula
    against = "more" if size.change > accuracy else "less"
    if not size.change > accuracy and size.counts(accuracy):
        against = f"within a factor {MARGIN:g} of"
    than = "" if against.startswith("within") else " than"
    change = "all" if size.change >= 1.0 else f"{size.change:.2g}"
    number = f"{size.number:.2g}" if math.isfinite(size.number) else "beyond all bounds"
    return (
        f"{size.name} is {number}; without it observables would change by {change}, {against}{than} the accuracy of "
        f"{accuracy:g} ({size.formula}; {size.source})"
    )


def settled(body: Characteristic, effects: Collection[str]) -> Characteristic:
    """The body where gravity and pressure act only if they are among these effects."""
    return replace(body, weighs="gravity" in effects, presses="pressure" in effects)


def _considered(scene: Scene, body: Characteristic) -> dict[str, dict[str, Any]]:
    """What the scene has among its candidates, and the effects without an option that must be given."""
    considered = dict(scene.candidates)
    where = {"always"} | ({"touching"} if body.touching else set())
    where |= {"companions"} if scene.has_companions else set()
    for kind, entry in CATALOGUE.items():
        unlit = scene.dimensionless and any(option.default is LIGHT for option in entry.options.values())
        boxed = scene.box is not None and entry.cost != "neighbours"
        if entry.auto in where and kind not in considered and scene.model in entry.models and not (unlit or boxed):
            considered[kind] = effect_options({kind: {}}, scene.dimensionless)[kind]
    return considered


def _needed(kind: str, scene: Scene, body: Characteristic) -> str:
    """Why an effect is on whatever its size; empty for most."""
    if kind != "gravity":
        return ""
    if any(region.bound for region in scene.regions.values()):
        return "a region is what gravity binds"
    return "the rotation is given as T/|W|" if body.rate_needs_gravity else ""
