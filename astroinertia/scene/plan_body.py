"""What the plan tells of a scene's body: its kind, size, temperature, rotation and prescribed size, in words."""

import math
from collections.abc import Callable
from typing import Any

from astroinertia.scene.bodies import LayeredBody, ProfileBody, RigidBody
from astroinertia.scene.places import place_lines
from astroinertia.scene.schema import Scene

PlanLine = tuple[str, ...]
Shown = Callable[[float, str], str]
"""How a quantity of a dimension is written."""


def body_lines(scene: Scene, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
    """The body of a scene: name, value and, if there is more to say, why."""
    body, lines = scene.body, list[PlanLine]()
    placed = place_lines(body.position, body.velocity, shown)
    if body.kind == "table":
        lines = [("particles", f"from the table {body.file}")]
    elif body.kind == "profile":
        lines = _profile(body, shown)
    elif body.kind == "rigid":
        lines = _rigid_body(body, shown)
    elif body.kind == "layered":
        lines = _layers(body, shown)
    elif body.kind == "standard":
        lines = [("problem", body.problem), ("particles", f"about {body.particles}", "on lattices")]
    else:
        lines = _sphere(scene, body, gravitational_constant, shown)
    return [*lines, *_thermal(scene, shown), *_motion(scene, shown), *_change(scene, shown), *placed]


def _profile(body: ProfileBody, shown: Shown) -> list[PlanLine]:
    part = "all of it"
    if body.inner_mass is not None:
        part = f"the inner {shown(body.inner_mass, 'mass')}"
    lines: list[PlanLine] = [("kind", f"profile from {body.file}", part), ("particles", f"{body.particles}")]
    if body.rotation is None:
        lines.append(("shells turn", f"{body.rotation_factor:g} times as fast as the file says", "about z"))
    return [*lines, ("placement", body.placement, f"seed {body.seed}, not settled first")]


def _rigid_body(body: RigidBody, shown: Shown) -> list[PlanLine]:
    lines: list[PlanLine] = [("kind", "rigid"), ("mass", shown(body.mass, "mass"))]
    if body.radius is not None:
        lines.append(("radius", shown(body.radius, "length")))
    if body.moments is not None:
        moments = ", ".join(shown(moment, "moment_of_inertia") for moment in body.moments)
        return [*lines, ("principal moments", moments)]
    assert body.moment_ratios is not None
    return [*lines, ("principal moments", numbers(body.moment_ratios), "over mass radius^2")]


def _layers(body: LayeredBody, shown: Shown) -> list[PlanLine]:
    each = shown(body.mass / (body.particles or 1), "mass")
    lines: list[PlanLine] = [
        ("kind", "layered"),
        ("particles", f"{body.particles}", f"of {each} each"),
        ("mass", shown(body.mass, "mass")),
    ]
    for layer in body.layers:
        label = shown(layer.isentrope, "specific_energy")
        lines.append((f"layer of {layer.material}", f"{layer.mass_fraction:g} of the mass", f"isentrope {label}"))
    return lines


def _sphere(scene: Scene, body: Any, gravitational_constant: float, shown: Shown) -> list[PlanLine]:
    shape = {"polytrope": "index", "power_law": "exponent", "dyson": "gamma", "rotating_star": "index"}.get(body.kind)
    kind = f"{body.kind.replace('_', ' ')}{f' of {shape} {getattr(body, shape):g}' if shape else ''}"
    axes = getattr(body, "axes", (1.0, 1.0, 1.0))
    density = body.mass / (4.0 / 3.0 * math.pi * body.radius**3 * math.prod(axes))
    fall = math.sqrt(3.0 * math.pi / (32.0 * gravitational_constant * density))
    sphere = " in the equatorial sphere" if body.kind == "rotating_star" else ""
    lines: list[PlanLine] = [("kind", kind, "" if axes == (1.0, 1.0, 1.0) else f"axes {numbers(axes)}")]
    if scene.model == "sph":
        lines.append(("particles", f"{body.particles}", f"of {shown(body.mass / body.particles, 'mass')} each"))
    lines += [
        ("mass", shown(body.mass, "mass")),
        ("equatorial radius" if sphere else "radius", shown(body.radius, "length")),
        ("mean density", shown(density, "density"), sphere.strip()),
        ("free-fall time", shown(fall, "time"), "of the mean density"),
    ]
    if scene.model == "sph":
        settles = body.relax and {"gravity", "pressure"} <= set(scene.effects)
        why = "settled to equilibrium first" if settles else "not settled first"
        lines.append(("placement", body.placement, f"seed {body.seed}, {why}"))
    return lines


def _change(scene: Scene, shown: Shown) -> list[PlanLine]:
    change = scene.body.change
    if change is None:
        return []
    last = shown(change.times[-1], "time")
    return [("size", "prescribed", f"inertia tensor times {change.factors[-1]:g} from {last} on")]


def _thermal(scene: Scene, shown: Shown) -> list[PlanLine]:
    body = scene.body
    if body.pressure_fraction is not None:
        return [("pressure", f"{body.pressure_fraction:g} of that of equilibrium")]
    if body.specific_internal_energy is not None:
        return [("internal energy", f"{shown(body.specific_internal_energy, 'specific_energy')}, uniform")]
    return [] if body.entropy is None else [("entropy function", f"{body.entropy:.6g}, uniform")]


def _motion(scene: Scene, shown: Shown) -> list[PlanLine]:
    body: Any = scene.body
    lines: list[PlanLine] = []
    if body.velocity_gradient is not None:
        lines.append(("velocity", "linear in position", "velocity_gradient"))
    spin: Any = body if body.kind == "rotating_star" else body.rotation
    if spin is None:
        return lines if body.kind == "profile" else [*lines, ("rotation", "none")]
    dimensions = {
        "rate": "angular_velocity",
        "period": "time",
        "angular_momentum": "angular_momentum",
        "t_over_w": "dimensionless",
        "axis_ratio": "dimensionless",
    }
    name = next(name for name in dimensions if getattr(spin, name, None) is not None)
    value = shown(getattr(spin, name), dimensions[name])
    about = "in equilibrium, about z" if spin is body else f"about {numbers(spin.axis)}"
    return [*lines, ("rotation", f"{spin.law}, {name} {value}", about)]


def numbers(values: tuple[float, ...]) -> str:
    """Plain numbers in brackets."""
    return f"({', '.join(f'{value:g}' for value in values)})"
