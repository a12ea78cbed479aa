"""A ring of gas on circular orbits around a point mass 1: each particle should keep its angular momentum.

In a disc that is round, pressure turns nothing: what a particle's angular momentum changes by is the work of viscosity
and noise (Cullen & Dehnen 2010, MNRAS 408, 669, section 4.5). The ring is thick enough to be resolved.
"""

import numpy as np

from astroinertia.test_problems.matter import Matter, Standard, cells_for, centred, filled

INNER, OUTER, HALF = 0.5, 1.5, 0.1  # edges of the ring, and half of its thickness
SOUND = 0.05  # speed of sound, in units of the circular speed at 1
SOFTENING = 0.05  # of the point mass, for the few that come near it


def place(count: int, lengths: np.ndarray, gamma: float) -> Matter:
    """A lattice of density 1, cut to the ring, on circular orbits."""
    cube = 2.0 * np.array([OUTER, OUTER, HALF])
    share = np.pi * (OUTER**2 - INNER**2) / (2.0 * OUTER) ** 2
    position = filled(cells_for(count / share, cube), *centred(cube))
    mass = np.prod(cube) / len(position)
    radius = np.hypot(position[:, 0], position[:, 1])
    position = position[(radius > INNER) & (radius < OUTER)]
    radius = np.hypot(position[:, 0], position[:, 1])
    rate = ((position**2).sum(axis=1) + SOFTENING**2) ** -0.75
    velocity = rate[:, None] * np.stack([-position[:, 1], position[:, 0], 0.0 * radius], axis=1)
    energy = SOUND**2 / (gamma * (gamma - 1.0))
    return Matter(np.full(len(position), mass), position, velocity, np.full(len(position), energy))


def angular_momentum(position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Of unit mass about the axis, (N,)."""
    return position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]


KEPLERIAN_DISC = Standard(place, None, False, "Cullen & Dehnen 2010, MNRAS 408, 669")
