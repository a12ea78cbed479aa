"""Noh's implosion: cold gas that falls from all sides towards a point with speed 1 (Noh 1987, JCP 72, 78)."""

import numpy as np

from astroinertia.test_problems.matter import Matter, Solution, Standard, cells_for, centred, filled

COLD = 1e-6  # pressure at time 0
RADIUS = 1.0  # of the ball of gas


def place(count: int, lengths: np.ndarray, gamma: float) -> Matter:
    """A ball of density 1 that falls in."""
    cube = np.full(3, 2.0 * RADIUS)
    cells = cells_for(count * 6.0 / np.pi, cube)
    position = filled(cells, *centred(cube))
    mass = np.prod(cube) / len(position)
    position = position[np.linalg.norm(position, axis=1) < RADIUS]
    velocity = -position / np.linalg.norm(position, axis=1)[:, None]
    return Matter(np.full(len(position), mass), position, velocity, np.full(len(position), COLD / (gamma - 1.0)))


def exact(position: np.ndarray, time: float, lengths: np.ndarray, gamma: float) -> Solution:
    """Gas at rest behind a shock of constant speed; free fall before it, which compresses by geometry alone."""
    radius = np.linalg.norm(position, axis=1)
    jump = (gamma + 1.0) / (gamma - 1.0)
    behind = radius < 0.5 * (gamma - 1.0) * time
    density = np.where(behind, jump**3, (1.0 + time / radius) ** 2)
    pressure = np.where(behind, 0.5 * (gamma - 1.0) * jump**3, COLD * density**gamma)
    velocity = np.where(behind[:, None], 0.0, -position / radius[:, None])
    return Solution(density, velocity, pressure)


def compared(position: np.ndarray, time: float, lengths: np.ndarray) -> np.ndarray:
    """What the surface of the ball has no part in: it comes inwards with speed 1, and rarefies a shell within it."""
    return np.linalg.norm(position, axis=1) < 0.8 * (RADIUS - time)


NOH = Standard(place, exact, False, "Noh 1987, JCP 72, 78", compared)
