"""Companions that a rigid body acts on in turn: their orbits, which are evolved with its attitude.

All are point masses to each other; the body's quadrupole turns it in their field and moves them in its own (Murray &
Dermott 1999, Solar System Dynamics, section 5.2). Places and speeds are relative to the body, G = 1. The splitting has
the points beside the free rotation, and the quadrupole with the torques: it keeps the total angular momentum, for each
part does, and the energy without drift (Touma & Wisdom 1994, Astronomical Journal 107, 1189, section 4).
Tests: tests/unit/models/rigid/test_two_way.py; beside REBOUND over 1000 orbits in tests/physics/test_rebound.py.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.effects.kinds.gravity_gradient import quadrupole_attraction
from astroinertia.engines.pytree import pytree
from astroinertia.ledger.moments import Compensated
from astroinertia.models.rigid.splitting import COMPOSITIONS, plus

Array = Any

STEPS_PER_TURN = 20.0  # of points, at least, where they turn fastest about the body


@pytree
@dataclass(frozen=True, eq=False)
class Companions:
    """Companions at one moment, in the form of a `rotation.ephemeris.Ephemeris`: masses (N,), places and speeds.

    radius: that of the body, within which none may come. substeps: those of points in a stage of the splitting; None
    for one alone, which then takes no loop.
    """

    mass: Array
    orbits: Array
    radius: Array | float = 0.0
    substeps: Array | None = None

    def at(self, orbits: Array) -> "Companions":
        """The same elsewhere."""
        return replace(self, orbits=orbits)

    def position(self, time: Array) -> Array:
        """Places (N, 3), whatever the time."""
        return self.orbits[0]

    def velocity(self, time: Array) -> Array:
        """Speeds (N, 3), whatever the time."""
        return self.orbits[1]


def unit_of_orbits(body_mass: float, companions: Companions) -> np.ndarray:
    """In which errors of places and speeds count, (2, N, 1): the distance, and the speed of a circle there."""
    distance = np.linalg.norm(companions.orbits[0], axis=-1, keepdims=True)
    return np.stack([distance, np.sqrt((body_mass + companions.mass[:, None]) / distance)])


def at_pericentres(body_mass: Array, mass: Array, orbits: Array) -> Array:
    """Companions as far from the body, and turning about it as fast, as at the pericentres of their present orbits.

    Checked by tests/unit/models/rigid/test_two_way.py.
    """
    place, speed = orbits
    closer = _pericentre(body_mass + mass, place, speed) / jnp.linalg.norm(place, axis=-1)
    closer = jnp.minimum(closer, 1.0)[:, None]
    return jnp.stack([place * closer, speed / closer])


def substeps(body_mass: Array, mass: Array, orbits: Array, step: Array) -> Array:
    """How many steps of points a step of the splitting takes in each stage, not rounded."""
    place, speed = at_pericentres(body_mass, mass, orbits)
    turning = jnp.linalg.norm(jnp.cross(place, speed), axis=-1) / jnp.sum(place**2, axis=-1)
    fastest = jnp.maximum(jnp.max(turning), fastest_pair(mass, orbits))
    return STEPS_PER_TURN / (2.0 * math.pi) * fastest * step


def fastest_pair(mass: Array, orbits: Array) -> Array:
    """The largest rate at which two companions turn about each other: at their pericentre where they are bound."""
    one, other = np.triu_indices(len(mass), 1)
    if not len(one):
        return jnp.zeros(())
    place, speed = orbits[:, other] - orbits[:, one]
    attraction, distance = mass[one] + mass[other], jnp.linalg.norm(place, axis=-1)
    bound = 0.5 * jnp.sum(speed**2, axis=-1) * distance < attraction
    nearest = jnp.where(bound, _pericentre(jnp.where(bound, attraction, 1.0), place, speed), distance)
    return jnp.max(jnp.linalg.norm(jnp.cross(place, speed), axis=-1) / nearest**2)


def _pericentre(attraction: Array, place: Array, speed: Array) -> Array:
    """The least distances (N,) on the present orbits.

    q = h^2/(mu (1 + e)) with h = |r cross v| and mu = G (M + m) (Murray & Dermott 1999, Solar System Dynamics, section
    2.3), where e is the length of v cross (r cross v)/mu - r/|r| (Goldstein, Poole & Safko 2002, Classical Mechanics,
    section 3.9).
    """
    turning, distance = jnp.cross(place, speed), jnp.linalg.norm(place, axis=-1, keepdims=True)
    eccentricity = jnp.linalg.norm(jnp.cross(speed, turning) / attraction[:, None] - place / distance, axis=-1)
    return jnp.sum(turning**2, axis=-1) / (attraction * (1.0 + eccentricity))


def pulls(body_mass: Array, mass: Array, place: Array) -> Array:
    """Accelerations of companions relative to the body, (N, 3), by which all of them attract each other as points."""
    towards_body = -place / jnp.sum(place**2, axis=-1, keepdims=True) ** 1.5
    relative = body_mass * towards_body + mass @ towards_body
    if len(place) > 1:
        apart = place[None] - place[:, None]
        square = jnp.sum(apart**2, axis=-1) + jnp.eye(len(place))  # of a companion from itself there is no pull
        relative += jnp.einsum("j,ijk->ik", mass, apart / square[..., None] ** 1.5)
    return relative


def pushes(seen: Any) -> Array:
    """Those by the body's quadrupole, (N, 3), from what effects see of the body (models.rigid.body.View)."""
    attraction = quadrupole_attraction(seen)
    return attraction + (seen.companions.mass @ attraction) / seen.mass


def within(body: Any, orbits: Array) -> Array:
    """Which companions are nearer to the body's centre than its radius, (N,)."""
    return jnp.sum(orbits[0] ** 2, axis=-1) < body.companions.radius**2


def flow(body: Any, orbits: Compensated, interval: Array) -> Compensated:
    """Orbits (2, N, 3) of points after an interval, in so many steps of order 2 as companions.substeps says."""
    return _flow(body, orbits, interval, COMPOSITIONS[2])


def fine_flow(body: Any, orbits: Compensated, interval: Array) -> Compensated:
    """The same by order 8."""
    return _flow(body, orbits, interval, COMPOSITIONS[8])


def _flow(body: Any, orbits: Compensated, interval: Array, stages: tuple[float, ...]) -> Compensated:
    mass, substeps = body.companions.mass, body.companions.substeps
    substeps = 1 if substeps is None else substeps
    lengths = interval / substeps * jnp.asarray(stages)

    def stage(number: Array, orbits: Compensated) -> Compensated:
        length = lengths[number % len(stages)]

        def drifted(orbits: Compensated) -> Compensated:
            speed = orbits.value[1]
            return plus(orbits, 0.5 * length * jnp.stack([speed, jnp.zeros_like(speed)]))

        orbits = drifted(orbits)
        kick = length * pulls(body.mass, mass, orbits.value[0])
        return drifted(plus(orbits, jnp.stack([jnp.zeros_like(kick), kick])))

    return jax.lax.fori_loop(0, substeps * len(stages), stage, orbits)


def totals(body_mass: float, mass: np.ndarray, orbits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular momentum (T, 3) and energy (T,) of point masses about their centre of mass, at orbits (T, 2, N, 3)."""
    every = np.concatenate([[body_mass], mass])
    place, speed = np.moveaxis(np.concatenate([np.zeros_like(orbits[:, :, :1]), orbits], axis=2), 1, 0)
    place, speed = (each - np.einsum("j,tjk->tk", every, each)[:, None] / every.sum() for each in (place, speed))
    momentum = np.einsum("j,tjk->tk", every, np.cross(place, speed))
    energy = 0.5 * (speed**2).sum(axis=-1) @ every
    for i in range(len(every)):
        for j in range(i):
            energy -= every[i] * every[j] / np.linalg.norm(place[:, i] - place[:, j], axis=-1)
    return momentum, energy
