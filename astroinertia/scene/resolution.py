"""How well the particles of a scene resolve its body, before it is run: lines of the plan, and warnings.

Tests: tests/unit/dataset/test_resolution.py.
"""

import math
from typing import Any

import numpy as np

from astroinertia.process.roots import bisected
from astroinertia.process.words import times_as_many
from astroinertia.scene.schema import Scene
from astroinertia.sph.profiles import CORE

COARSEST = 0.25  # smoothing length over the smallest semi-axis, at the mean density


def resolved(scene: Scene, eta: float, neighbours: float) -> list[tuple[str, str, str]]:
    """Name, value and what to change, of the smoothing length, the core and the Jeans mass; nothing for a table."""
    lines = []
    for alone in scene.alone():
        body: Any = alone.body
        if body.profile() is None or body.particles is None:
            continue
        axes = getattr(body, "axes", (1.0, 1.0, 1.0))
        spacing = body.radius * (4.0 / 3.0 * math.pi * math.prod(axes) / body.particles) ** (1.0 / 3.0)
        share = eta * spacing / (body.radius * min(axes))
        lines.append(_line("smoothing length", f"{share:.2g} of the smallest semi-axis", share > COARSEST,
                           "at the mean density", (share / COARSEST) ** 3))  # fmt: skip
        core = core_share(body) * body.particles
        fewest = 2.0 * neighbours
        if core > 0.0:
            why = f"denser than a tenth of the greatest density; two neighbourhoods are {fewest:.0f}"
            lines.append(_line("core", f"{core:.0f} particles", core < fewest, why, fewest / core))
        fluid = scene.equation_of_state
        if fluid is not None and fluid.kind == "isothermal" and scene.has_equilibrium:
            lines.append(_isothermal(scene, body, neighbours))
    return lines


def core_share(body: Any) -> float:
    """The share of the mass that is denser than a tenth of the greatest density; 0 where that is not known."""
    if not body.has_core:
        return 0.0
    profile = body.profile()
    least = CORE * float(profile.density(np.array(0.0)))
    edge = bisected(lambda radius: profile.density(radius) > least, np.array(0.0), np.array(1.0), 60)
    return float(profile.enclosed(edge))


def _isothermal(scene: Scene, body: Any, neighbours: float) -> tuple[str, str, str]:
    # The Jeans mass of Bate & Burkert (1997) falls with density; below that of two neighbourhoods it is not resolved.
    chosen: Any = scene.equation_of_state
    unit = 2.0 * neighbours * body.mass / body.particles
    energy = 2.5 * chosen.sound_speed**2 / scene.gravitational_constant
    highest = energy**3 / (4.0 / 3.0 * math.pi * unit**2)
    volume = 4.0 / 3.0 * math.pi * body.radius**3 * body.volume_ratio
    mean = body.mass / volume
    why = "denser fragments may be artificial (Bate & Burkert 1997)"
    return _line("Jeans mass", f"resolved up to {highest / mean:.2g} times the mean density", highest < mean, why,
                 (mean / highest) ** 0.5)  # fmt: skip


def _line(name: str, value: str, poor: bool, why: str, factor: float) -> tuple[str, str, str]:
    return name, value, f"{why}; WARNING: too few, take {times_as_many(factor)} particles" if poor else why
