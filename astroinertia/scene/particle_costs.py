"""What a particle run takes, before it is run: its memory, and what limits its time step at first."""

import math
from collections.abc import Callable
from typing import Any

from astroinertia.effects.entries import FREE_FALL_PART
from astroinertia.scene.schema import Scene

# The most that a step of Evrard's cloud held, bytes a particle, rounded up: tests/benchmarks/results/memory.md.
BYTES_A_PARTICLE = {"mixed": 2100, "float64": 2000}


def expected(
    scene: Scene, eta: float, gravitational_constant: float, shown: Callable[[Scene, float, str], str]
) -> list[tuple[str, str, str]]:
    """What the plan tells of it: name, value and why, with quantities as `shown` writes them; nothing for a table."""
    numerics, particles = scene.numerics, scene.particles
    bodies: Any = [each.body for each in scene.alone()]
    if particles is None or any(getattr(body, "radius", None) is None for body in bodies):
        return []
    limits = [
        first_limits(numerics, scene.effects, body.mass, body.radius, body.particles, eta, gravitational_constant)
        for body in bodies
    ]
    first = {name: min(each[name] for each in limits) for name in limits[0]}
    told = ", ".join(f"{name} {shown(scene, float(f'{limit:.2g}'), 'time')}" for name, limit in first.items())
    lines = [("its limits at first", told, "about, at the mean density; denser places and shocks shorten it")]
    if numerics.engine == "numba_cpu":
        share = BYTES_A_PARTICLE[numerics.precision]
        lines.append(("memory", f"{particles * share / 1e9:.2g} GB", f"{share} bytes a particle, in a step"))
    return lines


def first_limits(
    numerics: Any, effects: Any, mass: float, radius: float, particles: int, eta: float, gravitational_constant: float
) -> dict[str, float]:
    """The longest step by each criterion at the mean density of a body, where signals have the speed (G M/R)^(1/2).

    What integrate.timestep and the effects ask of each particle, in the units of what is given. Denser places, shocks
    and faster signals make steps shorter: the progress line of a run says which, and where.
    """
    density = mass / (4.0 / 3.0 * math.pi * radius**3)
    smoothing_length = eta * (mass / particles / density) ** (1.0 / 3.0)
    speed = math.sqrt(gravitational_constant * mass / radius)
    free_fall = math.sqrt(3.0 * math.pi / (32.0 * gravitational_constant * density))
    limits = {}
    if "gravity" in effects:
        limits["gravity"] = numerics.courant * FREE_FALL_PART * free_fall
    if "pressure" in effects:
        limits["pressure"] = numerics.courant * smoothing_length / speed
    limits["acceleration"] = numerics.acceleration_factor * math.sqrt(smoothing_length * radius) / speed
    return limits
