"""What the plan tells of every effect of a scene's model: how large it is here, and what leaving it out would cost.

Tests: tests/unit/effects/test_sizes.py.
"""

import math
from typing import Any

from astroinertia.effects.characteristic import Characteristic, tidal_parameter
from astroinertia.effects.sizes import MARGIN, effect_size
from astroinertia.scene.auto import accuracy_of, settled, size_description
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.initial_body import PlanLine
from astroinertia.scene.schema import Scene

NUMBERS = {
    "run_length": "run in dynamical times",
    "turns": "run in turns",
    "thermal_to_gravitational": "U/|W|",
    "rotational_to_gravitational": "T/|W|",
    "mach_number": "Mach number of the expansion",
    "rotation_over_break_up": "spin over √(G M/R^3)",
    "compactness": "G M/(R c^2)",
}


IN_BALANCE = 0.01  # to which these estimates can tell


def size_descriptions(scene: Scene) -> dict[str, str]:
    """Of each effect of the model, by kind: its size, what leaving it out costs, and whether that is as it should."""
    body, accuracy = characteristic(scene), accuracy_of(scene)
    body = settled(body, scene.effects)
    descriptions = {}
    for kind, entry in scene.entries.items():
        listed = kind in scene.effects
        if scene.model not in entry.models:
            continue
        if kind in scene.reasons:
            descriptions[kind] = scene.reasons[kind]
            continue
        size = effect_size(entry.size, settled(body, (*scene.effects, kind)), scene.effects.get(kind))
        if size.change is None and not listed:
            continue  # without its numbers nothing can be said
        text = size_description(size, accuracy)
        boxed = scene.box is not None and entry.cost != "neighbours"
        if listed and not size.counts(accuracy):
            text = f"NEGLIGIBLE here: {text}"
        elif not listed and not boxed and size.change is not None and size.change > accuracy:
            text = f"WARNING, large and not listed: {text}"
        descriptions[kind] = text
    return descriptions


def number_lines(scene: Scene) -> list[PlanLine]:
    """The characteristic numbers that the scene tells, and what the program leaves out although it may count."""
    body = characteristic(scene)
    lines: list[PlanLine] = [
        (label, f"{value:.3g}" if math.isfinite(value) else "beyond all bounds", _rotating(scene, name))
        for name, label in NUMBERS.items()
        if (value := getattr(body, name)) is not None
    ]
    lines += _support(settled(body, scene.effects)) + [
        (f"tide of {other.name}", f"{tidal_parameter(body, other.mass, other.distance):.3g}", "(M'/M) (R/a)^3")
        for other in (body.neighbours or () if body.mass is not None and body.radius is not None else ())
    ]
    compact, accuracy = body.compactness, accuracy_of(scene)
    if compact is not None and compact > accuracy and "relativistic_potential" not in scene.effects:
        why = f"more than the accuracy of {accuracy:g}; all here is Newtonian"
        lines.append(("relativity", f"WARNING: {compact:.2g} of gravity is missing", why))
    if compact is not None and body.spin and body.radius and body.speed_of_light:
        speed = body.spin * body.radius / body.speed_of_light
        if speed**2 > max(accuracy, compact):  # gravity that holds such rotation is as relativistic, and said above
            text = f"WARNING: the surface turns at {speed:.2g} of the speed of light"
            lines.append(("relativity of the rotation", text, "all here is Newtonian"))
    origin = "" if scene.accuracy is not None else "where a scene asks for none"
    return [*lines, ("accuracy", f"{accuracy:g}, against which effects are judged", origin or f"within {MARGIN:g}")]


def _support(body: Characteristic) -> list[PlanLine]:
    """Whether the forces at the start hold each other, and what the body does where they do not."""
    if body.support is None or body.held or not body.deforms:
        return []
    swells = "it swells at first: too much pressure or rotation; body.pressure_fraction takes pressure away"
    means = "it falls at first" if body.support < 1.0 else swells
    if body.further_pressure < 0.0 and body.triple_pressure and body.support < 1.0:
        lost = -100.0 * body.further_pressure / body.triple_pressure
        means += f": {lost:.2g} % of the pressure is taken away by effects"
    if abs(body.support - 1.0) < IN_BALANCE:
        means = "in balance" if body.gamma > 4.0 / 3.0 - 1e-9 else "in balance, but not stable: gamma is below 4/3"
    return [("(3 Pi + 2 T)/|W|", f"{body.support:.3g}", means)]


def _rotating(scene: Scene, name: str) -> str:
    """Of which body a measure of the rotation is, where that is not the body of the start."""
    body: Any = scene.body
    if name not in ("turns", "rotational_to_gravitational", "rotation_over_break_up") or body.spin is None:
        return ""
    if body.spin is body:
        return "" if body.quickly_known else "estimate: as a Maclaurin spheroid's"
    settles = scene.model in ("sph", "scaling") and body.relax and body.settles
    return (
        "estimate: of the body before it settles with its rotation"
        if settles and body.rotation.t_over_w is None
        else ""
    )
