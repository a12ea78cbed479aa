"""Which particles a region holds: the innermost mass, what is dense, or what is bound (numpy, code units).

Each function returns (N,), 1.0 for members and 0.0 for the others. Tests: tests/unit/ledger/test_regions.py.
"""

from collections.abc import Callable

import numpy as np

NEAREST = 32  # particles about the densest one whose mean place is the densest point: one particle's is noise
DEEPEST = 0.1  # of the particles: those whose velocity what is bound is at first judged by
MOST_ROUNDS = 50  # of taking away what is not bound; each takes away some

Potential = Callable[[np.ndarray], np.ndarray]
Points = tuple[np.ndarray, np.ndarray]
NO_POINTS: Points = (np.zeros(0), np.zeros((0, 3)))


def densest_point(mass: np.ndarray, position: np.ndarray, density: np.ndarray) -> np.ndarray:
    """The place of the greatest density, (3,): the mean of its surroundings weighted by density.

    The weights are those of the density centre of Casertano & Hut (1985, ApJ 298, 80), of the NEAREST particles about
    the densest one.
    """
    peak = position[int(np.argmax(density))]
    away = ((position - peak) ** 2).sum(axis=1)
    near = np.argsort(away, kind="stable")[:NEAREST]
    weight = mass[near] * density[near]
    return (weight @ position[near]) / weight.sum()


def innermost(mass: np.ndarray, position: np.ndarray, centre: np.ndarray, wanted: float) -> np.ndarray:
    """The nearest particles to a centre that together have, as nearly as can be, the mass that is wanted."""
    order = np.argsort(((position - centre) ** 2).sum(axis=1), kind="stable")
    enclosed = np.cumsum(mass[order])
    count = int(np.searchsorted(enclosed, wanted, side="right"))
    if count < len(mass) and enclosed[count] - wanted < wanted - (enclosed[count - 1] if count else 0.0):
        count += 1
    member = np.zeros(len(mass))
    member[order[:count]] = 1.0
    return member


def dense(density: np.ndarray, least: float) -> np.ndarray:
    """What is at least as dense as that."""
    return (density >= least).astype(float)


def bound(
    mass: np.ndarray, velocity: np.ndarray, energy: np.ndarray | float, potential: Potential, of_all: np.ndarray,
    points: Points = NO_POINTS,
) -> np.ndarray:  # fmt: skip
    """What is bound to itself: |v - u|^2 / 2 + energy + phi < 0, with u and phi of what is bound, found in rounds.

    energy (N,): further specific energy, such as the internal one; potential(chosen) is phi, (n,), of the particles
    `chosen` (n,) by themselves, of_all (N,) that of all. points: masses (n,) and velocities (n, 3) of what is bound in
    any case, whose potential both have. Each round takes away what is not bound to the rest, as
    Springel, White, Tormen & Kauffmann (2001, MNRAS 328, 726, section 3.2) do for substructure; the first takes u of
    the particles deepest in the potential, so that what flies off, however heavy, does not carry the frame away.
    """
    energy = np.broadcast_to(np.asarray(energy, dtype=float), mass.shape)
    chosen, phi = np.arange(len(mass)), of_all
    for number in range(MOST_ROUNDS):
        depth = np.quantile(phi, DEEPEST if number == 0 else 1.0)
        inner = chosen[phi <= depth]
        momentum = mass[inner] @ velocity[inner] + points[0] @ points[1]
        frame = momentum / (mass[inner].sum() + points[0].sum())
        specific = 0.5 * ((velocity[chosen] - frame) ** 2).sum(axis=1) + energy[chosen] + phi
        stays = specific < 0.0
        if stays.all() or not stays.any():
            chosen = chosen[stays]
            break
        chosen = chosen[stays]
        phi = potential(chosen)
    member = np.zeros(len(mass))
    member[chosen] = 1.0
    return member
