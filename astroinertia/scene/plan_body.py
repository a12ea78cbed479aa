"""What the plan tells of a scene's body: its kind, size, temperature, rotation and prescribed size, in words."""

import math
from typing import Any

import numpy as np

from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.dimensional import quantity_of
from astroinertia.scene.initial_body import PlanLine, numbers
from astroinertia.scene.places import place_lines
from astroinertia.scene.schema import Scene

SEEN = 1e-6  # rad: wobbles below it are rounding of a scene's numbers


def body_lines(scene: Scene) -> list[PlanLine]:
    """The body of a scene: name, value and, if there is more to say, why."""
    body = scene.body
    placed = place_lines(body.position, body.velocity, scene.shown)
    lines = body.describe(scene)
    return [*lines, *_thermal(scene), *_motion(scene), *_change(scene), *placed]


def _change(scene: Scene) -> list[PlanLine]:
    change = scene.body.change
    if change is None:
        return []
    last = scene.shown(change.times[-1], "time")
    return [("size", "prescribed", f"inertia tensor times {change.factors[-1]:g} from {last} on")]


def _thermal(scene: Scene) -> list[PlanLine]:
    body = scene.body
    if body.pressure_fraction is not None:
        return [("pressure", f"{body.pressure_fraction:g} of that of equilibrium")]
    if body.specific_internal_energy is not None:
        return [("internal energy", f"{scene.shown(body.specific_internal_energy, 'specific_energy')}, uniform")]
    return [] if body.entropy is None else [("entropy function", f"{body.entropy:.6g}, uniform")]


def _motion(scene: Scene) -> list[PlanLine]:
    body: Any = scene.body
    lines: list[PlanLine] = []
    if body.velocity_gradient is not None:
        lines.append(("velocity", "linear in position", "velocity_gradient"))
    spin: Any = body.spin
    if spin is None:
        return (
            lines if body.rotates_itself else [*lines, ("rotation", "none" if body.kind != "table" else "none besides")]
        )
    measures = "rate", "period", "angular_momentum", "t_over_w", "axis_ratio", "breakup_fraction"
    name = next(name for name in measures if getattr(spin, name, None) is not None)
    quantity = quantity_of(type(spin).model_fields[name])
    value = scene.shown(getattr(spin, name), quantity.dimension if quantity else "dimensionless")
    along = (0.0, 0.0, 1.0) if spin is body else tuple(np.round(spin.direction, 12) + 0.0)
    about = "in equilibrium, about z" if spin is body else f"about {numbers(along)}"
    return [*lines, ("rotation", f"{spin.law}, {name} {value}", about), *_attitude(scene)]


def unstated_wobble(scene: Scene) -> str:
    """A sentence where a rigid body wobbles and the scene does not say so, because of the axis about which it turns."""
    body: Any = scene.body
    if scene.model != "rigid" or body.rotation is None or body.rotation.wobble is not None:
        return ""
    numbers_of = characteristic(scene)
    if numbers_of.momentum_axis is None or numbers_of.momentum_wobble < SEEN:
        return ""
    degrees = f"{math.degrees(numbers_of.momentum_wobble):.6g} deg"
    return f"it wobbles by {degrees}: [body.rotation] axis is not that of its largest moment of inertia"


def _attitude(scene: Scene) -> list[PlanLine]:
    """Of a rigid body that turns, how far its angular momentum is from z and from the axis of its largest moment."""
    numbers_of = characteristic(scene) if scene.model == "rigid" else None
    if numbers_of is None or numbers_of.momentum_axis is None:
        return []
    x, y, z = numbers_of.momentum_axis
    obliquity, wobble = math.atan2(math.hypot(x, y), z), numbers_of.momentum_wobble
    shown = [f"{0.0 if angle < 1e-9 else math.degrees(angle):.6g} deg" for angle in (obliquity, wobble)]
    return [
        ("obliquity", shown[0], "of the angular momentum, from z"),
        ("wobble", shown[1], "of the angular momentum, from the axis of the largest moment"),
    ]
