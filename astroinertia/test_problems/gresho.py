"""The Gresho-Chan vortex: a flow that turns in circles, held by its pressure, and should stay as it is.

Gresho & Chan 1990, Int. J. Numer. Methods Fluids 11, 621; as a test of particles, Springel 2010, MNRAS 401, 791.
"""

import numpy as np

from astroinertia.test_problems.matter import Matter, Solution, Standard, cells_for, centred, filled, in_box


def speed(radius: np.ndarray) -> np.ndarray:
    """Circular speed: 5 r, then 2 - 5 r, then nothing."""
    return np.maximum(np.minimum(5.0 * radius, 2.0 - 5.0 * radius), 0.0)


def pressure(radius: np.ndarray) -> np.ndarray:
    """What holds it."""
    r = np.maximum(radius, 1e-12)
    middle = 9.0 + 12.5 * r**2 - 20.0 * r + 4.0 * np.log(r / 0.2)
    return np.where(r < 0.2, 5.0 + 12.5 * r**2, np.where(r < 0.4, middle, 3.0 + 4.0 * np.log(2.0)))


def place(count: int, lengths: np.ndarray, gamma: float) -> Matter:
    """A lattice of density 1."""
    position = filled(cells_for(count, lengths), *centred(lengths))
    mass = np.full(len(position), np.prod(lengths) / len(position))
    flow = exact(position, 0.0, lengths, gamma)
    return Matter(mass, position, flow.velocity, flow.pressure / (gamma - 1.0))


def exact(position: np.ndarray, time: float, lengths: np.ndarray, gamma: float) -> Solution:
    """The same at all times."""
    x, y, _ = in_box(position, lengths).T
    radius = np.hypot(x, y)
    rate = speed(radius) / np.maximum(radius, 1e-12)
    velocity = np.stack([-rate * y, rate * x, 0.0 * x], axis=1)
    return Solution(np.ones_like(radius), velocity, pressure(radius))


GRESHO = Standard(place, exact, True, "Gresho & Chan 1990; Springel 2010, MNRAS 401, 791")
