"""What limits the time step of a particle run at first, before it is run."""

import math
from typing import Any

from astroinertia.effects.entries import FREE_FALL_PART
from astroinertia.scene.schema import Scene


def expected(scene: Scene, eta: float) -> list[tuple[str, str, str]]:
    """What the plan tells of it: name, value and why; nothing for a table."""
    numerics = scene.numerics
    bodies: Any = [alone.body for alone in scene.alone()]
    if scene.particles is None or any(body.mass is None or body.radius is None for body in bodies):
        return []
    limits = [
        first_limits(numerics, scene.effects, body.mass, body.radius, body.particles, eta, scene.gravitational_constant)
        for body in bodies
    ]
    first = {name: min(of_body[name] for of_body in limits) for name in limits[0]}
    listed = ", ".join(f"{name} {scene.shown(float(f'{limit:.2g}'), 'time')}" for name, limit in first.items())
    return [("its limits at first", listed, "about, at the mean density; denser places and shocks shorten it")]


def first_limits(
    numerics: Any, effects: Any, mass: float, radius: float, particles: int, eta: float, gravitational_constant: float
) -> dict[str, float]:
    """The longest step by each criterion at the mean density of a body, where signals have the speed (G M/R)^(1/2).

    What models.sph.limits and the effects ask of each particle, in the units of what is given. Denser places, shocks
    and faster signals make steps shorter: the progress line of a run says which, and where.
    """
    density = mass / (4.0 / 3.0 * math.pi * radius**3)
    kept = effects.get("gravity", {}).get("softening")
    smoothing_length = eta * (mass / particles / density) ** (1.0 / 3.0) if kept is None else kept
    speed = math.sqrt(gravitational_constant * mass / radius)
    free_fall = math.sqrt(3.0 * math.pi / (32.0 * gravitational_constant * density))
    limits = {}
    if "gravity" in effects:
        limits["gravity"] = numerics.courant * FREE_FALL_PART * free_fall
    if "pressure" in effects:
        limits["pressure"] = numerics.courant * smoothing_length / speed
    limits["acceleration"] = numerics.acceleration_factor * math.sqrt(smoothing_length * radius) / speed
    return limits
