"""Sets of points that gravity codes are compared on, of unit mass and size, with a smoothing length for each point.

Smoothing lengths follow from the set's own density, h = eta (m/rho)^(1/3): no code's neighbour search is in them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

ETA = 1.2  # smoothing length over particle spacing
PLUMMER_MASS = 0.999  # of the whole is kept: the last thousandth reaches out for ever
DISC_HEIGHT = 0.02  # of an exponential disc of scale length 1/4, whose points end at r = 1
DISC_LENGTH = 0.25


@dataclass(frozen=True)
class PointSet:
    """Masses (N,), positions (N, 3) and smoothing lengths (N,)."""

    mass: np.ndarray
    position: np.ndarray
    smoothing_length: np.ndarray


def point_set(name: str, points: int, seed: int = 1) -> PointSet:
    """One of SETS, of random points of equal mass."""
    position, density = SETS[name](points, np.random.default_rng(seed))
    return PointSet(np.full(points, 1.0 / points), position, ETA * np.cbrt(1.0 / points / density))


def uniform(points: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A ball of one density."""
    position = directions(points, random) * np.cbrt(random.uniform(size=points))[:, None]
    return position, np.full(points, 3.0 / (4.0 * np.pi))


def evrard(points: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Evrard's cloud: rho = 1/(2 pi r) (Evrard 1988, MNRAS 235, 911)."""
    radius = np.sqrt(random.uniform(size=points))
    return directions(points, random) * radius[:, None], 1.0 / (2.0 * np.pi * radius)


def plummer(points: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Plummer's sphere of scale radius 1 (Aarseth, Henon & Wielen 1974, A&A 37, 183)."""
    inside = PLUMMER_MASS * random.uniform(size=points)
    radius = 1.0 / np.sqrt(inside ** (-2.0 / 3.0) - 1.0)
    density = 3.0 / (4.0 * np.pi) * (1.0 + radius**2) ** -2.5
    return directions(points, random) * radius[:, None], density


def disc(points: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A thin exponential disc, sech^2 in height: as flat as trees meet."""
    grid = np.linspace(0.0, 1.0 / DISC_LENGTH, 4096)
    inside = 1.0 - (1.0 + grid) * np.exp(-grid)
    whole = inside[-1]
    radius = DISC_LENGTH * np.interp(whole * random.uniform(size=points), inside, grid)
    angle = random.uniform(0.0, 2.0 * np.pi, size=points)
    height = DISC_HEIGHT * np.arctanh(random.uniform(-1.0, 1.0, size=points) * (1.0 - 1e-9))
    position = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    surface = np.exp(-radius / DISC_LENGTH) / (2.0 * np.pi * DISC_LENGTH**2 * whole)
    return position, surface / (2.0 * DISC_HEIGHT) / np.cosh(height / DISC_HEIGHT) ** 2


def directions(points: int, random: np.random.Generator) -> np.ndarray:
    """Random unit vectors (N, 3)."""
    vectors = random.normal(size=(points, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


SETS: dict[str, Callable[[int, np.random.Generator], tuple[np.ndarray, np.ndarray]]] = {
    "uniform": uniform,
    "Evrard": evrard,
    "Plummer": plummer,
    "disc": disc,
}
