"""What matter allows of a time step, as it is in the course of a run."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from astroinertia.costs.fields import Fields, effects_that, fields
from astroinertia.scene.plan import code_units, smoothing, softening
from astroinertia.scene.schema import Scene

PARTS = (np.arange(20) + 0.5) / 20  # of the matter: below which its limits are known
LEAST = 1e-300  # of what something is divided by
STILL = 1e-30  # a signal, below which nothing is


@dataclass(frozen=True)
class Matter:
    """Parts (K,) of a body at one time, in code units: mass, density, fastest signal, acceleration, and of spherical
    ones the outer radius, which is None of others, and the speed at which that grows.
    """

    time: float
    mass: np.ndarray
    density: np.ndarray
    signal: np.ndarray
    acceleration: np.ndarray | float = 0.0
    radius: np.ndarray | None = None
    speed: np.ndarray | float = 0.0


@dataclass(frozen=True)
class Limits:
    """At times (K,): the shortest limit of all matter, limits (P, K) that PARTS of it are below, the longest step.

    first: at the first time the shortest by each criterion.
    """

    times: np.ndarray
    shortest: np.ndarray
    below: np.ndarray
    longest: np.ndarray
    first: dict[str, float]


def limits(scene: Scene, course: Sequence[Matter]) -> Limits:
    """Those of a body at the times of its course."""
    factor, units = scene.numerics.free_fall_factor, code_units(scene)
    times = np.array([matter.time for matter in course])
    whole = float(course[0].mass.sum())
    effects, given = effects_that(scene, "limited_by_density"), fields(scene)
    each = [_allowed(scene, effects, given, whole, matter) for matter in course]
    shortest = (np.minimum.reduce([*of.values()]) for of in each)
    found = np.transpose([_quantiles(of, matter.mass) for of, matter in zip(shortest, course, strict=True)])
    first = {name: float(of.min()) for name, of in each[0].items()}
    densest = np.array([matter.density.max() for matter in course])
    longest = np.full_like(times, np.inf) if factor is None else factor / np.sqrt(densest)
    if scene.numerics.max_timestep is not None:
        longest = np.minimum(longest, float(units.to_code(scene.numerics.max_timestep, "time")))
    return Limits(times, found[0], found[1:], np.minimum(longest, _by_options(scene, times)), first)


def length(scene: Scene, whole: float, density: np.ndarray) -> np.ndarray:
    """Smoothing lengths (K,) at densities, of a body of that mass; all alike where gravity's softening is stated."""
    body: Any = scene.body
    if (kept := softening(scene)) is not None:
        return np.full_like(density, float(code_units(scene).to_code(kept, "length")))
    return smoothing(scene)[0] * (whole / body.placed(scene, body.particles) / density) ** (1.0 / 3.0)


def _allowed(
    scene: Scene, effects: Sequence[Any], given: Fields | None, whole: float, matter: Matter
) -> dict[str, np.ndarray]:
    """The longest step (K,) of each part of a body of that mass, by its criteria."""
    numerics, of_length = scene.numerics, length(scene, whole, matter.density)
    acceleration, of_fields = matter.acceleration, {}
    if given is not None and matter.radius is not None:
        acceleration = acceleration + given.bulk(matter.radius)
        particle = whole / scene.body.placed(scene, scene.particles)
        nearer = (0.5 * particle / matter.mass[0]) ** (1.0 / 3.0)  # than the innermost edge: half of one is within
        speed, sound = np.full_like(of_length, matter.speed), np.append(matter.signal, matter.signal[0])
        radius, speed = (np.append(edge, nearer * edge[0]) for edge in (matter.radius, speed))
        asked = given.timesteps(radius, speed, sound).items()
        of_fields = {kind: np.full_like(of_length, numerics.courant * limit) for kind, limit in asked}
    found = {"acceleration": numerics.acceleration_factor * np.sqrt(of_length / np.maximum(acceleration, LEAST))}
    if "pressure" in scene.effects:
        found["pressure"] = numerics.courant * of_length / np.maximum(matter.signal, STILL)
    fluid = SimpleNamespace(mass=matter.mass, density=matter.density, smoothing_length=of_length)
    return found | of_fields | {effect.kind: numerics.courant * effect.timestep(np, fluid) for effect in effects}


def _quantiles(of_parts: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """The least of limits (K,), and those that PARTS of the mass are below."""
    order = np.argsort(of_parts)
    return np.interp([0.0, *PARTS], np.cumsum(mass[order]) / mass.sum(), of_parts[order])


def _by_options(scene: Scene, times: np.ndarray) -> np.ndarray:
    """What effects allow at those times, (K,), whose limit follows from their options alone."""
    units, found = code_units(scene), np.full_like(times, np.inf)
    for kind, options in scene.effects.items():
        if (pace := scene.entries[kind].pace) is not None:
            steps, last = pace(options)
            until = np.inf if last is None else float(units.to_code(last, "time"))
            limit = scene.numerics.courant * float(units.to_code(steps, "time"))
            found = np.minimum(found, np.where(times < until, limit, np.inf))
    return found
