"""Sets of particles that make trouble, in code units (G = 1): few, coincident, flat, far apart, fast, cold."""

from typing import Any, NamedTuple

import numpy as np

COUNT = 64  # of most sets: programs compiled for one serve all


class Cloud(NamedTuple):
    """mass (N,), position (N, 3), velocity (N, 3) and specific internal energy (N,) of particles."""

    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray


def ball(count: int = COUNT, seed: int = 1, radius: float = 1.0) -> np.ndarray:
    """Places spread at random over a ball, (count, 3)."""
    generator = np.random.default_rng(seed)
    direction = generator.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return radius * generator.uniform(size=(count, 1)) ** (1.0 / 3.0) * direction


def cloud(position: Any, velocity: Any = 0.0, internal_energy: Any = 0.1, mass: Any = None) -> Cloud:
    """A cloud of mass 1 at those places; numbers stand for all particles."""
    position = np.asarray(position, dtype=float)
    count = len(position)
    return Cloud(
        np.full(count, 1.0 / count) if mass is None else np.asarray(mass, dtype=float),
        position,
        np.zeros((count, 3)) + velocity,
        np.zeros(count) + internal_energy,
    )


def turning(position: np.ndarray, rate: Any, axis: Any = (0.0, 0.0, 1.0)) -> np.ndarray:
    """Velocities (N, 3) of a rotation at a rate, a number or one a particle, about an axis through the origin."""
    return np.reshape(rate, (-1, 1)) * np.cross(np.asarray(axis, dtype=float), position)


def two(apart: float, speed: float, offset: float = 0.0, internal_energy: float = 0.1) -> Cloud:
    """Two balls that approach each other along x, each at half the relative speed, with an impact parameter."""
    shift, rush = np.array([0.5 * apart, 0.5 * offset, 0.0]), np.array([0.5 * speed, 0.0, 0.0])
    half = COUNT // 2
    position = np.concatenate([ball(half, 1) - shift, ball(half, 2) + shift])
    velocity = np.concatenate([np.tile(rush, (half, 1)), np.tile(-rush, (half, 1))])
    return cloud(position, velocity, internal_energy)


def line(count: int = COUNT) -> np.ndarray:
    """Places on a line along x, unevenly spaced."""
    x = np.sort(np.random.default_rng(3).uniform(-1.0, 1.0, count))
    return np.stack([x, np.zeros(count), np.zeros(count)], axis=1)


def lattice() -> np.ndarray:
    """A cubic lattice: many distances are exactly equal."""
    steps = (np.arange(4) - 1.5) / 4
    return np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)


def first(count: int = COUNT) -> np.ndarray:
    """Which particle is the first, (count,) bool."""
    return np.arange(count) == 0


def every_other() -> np.ndarray:
    """Every second particle, (COUNT,) bool."""
    return np.arange(COUNT) % 2 == 1
