"""Sinks: point masses beside a fluid that have accreted some of it."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.gravity.point_masses import PointMasses
from astroinertia.ledger.moments import Removed

Array = Any


@pytree
@dataclass(frozen=True)
class Sinks(PointMasses):
    """Point masses with a spin (n, 3) and their identities (n,) by age, and what they have accreted together.

    formed: how many there ever were, of which some have become one with an older one. removed: what the fluid's moments
    have lost; inner_energy: of the heat, the motion and the mutual attraction of what was accreted or has merged;
    particles: how many the fluid had at first.
    """

    of_body: ClassVar[bool] = True

    spin: Array
    identity: Array
    formed: Array
    removed: Removed
    inner_energy: Array
    particles: Array


def no_sinks(softening: float, particles: int) -> Sinks:
    """A fluid of so many particles before any sink."""
    nothing = np.zeros((0, 3))
    return Sinks(
        mass=np.zeros(0),
        position=nothing,
        velocity=nothing,
        softening=np.float64(softening),
        spin=nothing,
        identity=np.zeros(0, np.int64),
        formed=np.int64(0),
        removed=Removed(np.float64(0.0), np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))),
        inner_energy=np.float64(0.0),
        particles=np.int64(particles),
    )


def merged(mass: Array, position: Array, velocity: Array, spin: Array) -> tuple[Array, Array, Array, Array]:
    """One point of several, (n,) and (n, 3): mass, centre of mass, its velocity, and all other angular momentum."""
    total = mass.sum()
    place, speed = mass @ position / total, mass @ velocity / total
    inner = mass[:, None] * np.cross(position - place, velocity - speed)
    return total, place, speed, spin.sum(axis=0) + inner.sum(axis=0)
