"""What it takes to find the orbits of companions, which are in a table before the first step (rotation.ephemeris)."""

import math

from astroinertia.build.companions import AT_FIRST
from astroinertia.costs.machine import Machine
from astroinertia.process.stopwatch import Seconds
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.schema import Scene

# Of a turn on a circle, 0.53 ms: what eccentricity adds (0.8, 1.2, 1.9 and 3.5 ms of eccentricities 0.05, 0.2, 0.5 and
# 0.9), what each further companion does (1.4 ms of two, 2.7 ms of five), and what a turn takes with WHFast.
ECCENTRIC, FURTHER, WHFAST = 5.5, 0.85, 2.0


def tabulating(scene: Scene, machine: Machine, share: float = 1.0) -> Seconds:
    """The time that it takes for a run of which steps leave so large a share; none where it is not known beforehand."""
    others = (characteristic(scene).neighbours or ()) if _on_known_orbits(scene) else ()
    bound = [other for other in others if other.eccentricity < 1.0]  # what passes by needs next to none
    if not bound:
        return Seconds()
    radians = scene.time.end * max(other.rate for other in bound)
    bends = scene.time.end * max(other.rate * (1.0 + ECCENTRIC * other.eccentricity) for other in bound)
    turns = (bends + FURTHER * (len(bound) - 1) * radians) / (2.0 * math.pi)
    if scene.model == "rigid" and share < 1.0 and share * radians < AT_FIRST:
        turns *= min(1.0, AT_FIRST / radians)
    return (WHFAST if scene.orbits.integrator == "whfast" else 1.0) * turns * machine.seconds["orbit"]


def _on_known_orbits(scene: Scene) -> bool:
    """Whether companions keep to orbits that are known beforehand."""
    if scene.model == "rigid":
        return not scene.orbits.back_reaction
    return scene.effects.get("companions", {}).get("motion") == "orbit"
