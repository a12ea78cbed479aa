"""A square of dense gas in pressure equilibrium with thin gas around: it should stay as it is.

Saitoh & Makino 2013, ApJ 768, 44; here the ratio of densities is 8, which lattices of equal particles have exactly.
"""

import numpy as np

from astroinertia.test_problems.matter import Matter, Solution, Standard, cells_for, centred, filled, in_box

PRESSURE = 2.5
DENSITY = 8.0  # of the square; 1 around


def inside(position: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """The middle half of the box along x and y, (N,) bool."""
    return np.all(np.abs(in_box(position, lengths)[:, :2]) < 0.25 * lengths[:2], axis=1)


def place(count: int, lengths: np.ndarray, gamma: float) -> Matter:
    """Two lattices at rest, one twice as wide as the other."""
    thin = np.array(cells_for(count / (0.25 * DENSITY + 0.75), lengths, even=True))
    wide, fine = (filled(tuple(cells), *centred(lengths)) for cells in (thin, 2 * thin))
    position = np.concatenate([wide[~inside(wide, lengths)], fine[inside(fine, lengths)]])
    dense = np.where(inside(position, lengths), DENSITY, 1.0)
    mass = np.full(len(position), np.prod(lengths) / len(wide))
    return Matter(mass, position, np.zeros_like(position), PRESSURE / ((gamma - 1.0) * dense))


def exact(position: np.ndarray, time: float, lengths: np.ndarray, gamma: float) -> Solution:
    """The same at all times."""
    dense = np.where(inside(position, lengths), DENSITY, 1.0)
    return Solution(dense, np.zeros_like(position), np.full(len(position), PRESSURE))


SQUARE = Standard(place, exact, True, "Saitoh & Makino 2013, ApJ 768, 44")
