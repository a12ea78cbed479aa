"""Particles of equal mass from a density: the centres of mass of as many cells of equal mass.

A lattice of points, each moved at random within its own place, is halved again and again by mass across its longest
side, so that particles have little noise and no grid. Tests: tests/unit/test_body_door.py.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

_POINTS = 16  # of the lattice inside the body, a particle
_PROBE = 32  # points along a side, by which the share of the box that the body fills is found
_MOST = 1 << 15  # points of the whole lattice, a particle: what takes more has an extent that is not its own
_AT_ONCE = 1 << 16  # points that are looked at together, of which those inside are kept: memory goes as the particles
_EMPTY = "its density is zero in almost all of its extent"


def centres(
    density: Callable[[np.ndarray], np.ndarray], extent: Any, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Positions (count, 3) in a box of half sides `extent` (3,) about the origin, and the mass of the whole.

    density: (N,) at positions (N, 3). ValueError where it is negative, not finite, or zero almost everywhere, and where
    the box is so large or so long for the body that too many points would be looked at. Memory goes as `count`.
    """
    half = np.asarray(extent, dtype=float)
    if half.shape != (3,) or not np.isfinite(half).all() or not (half > 0.0).all():
        raise ValueError("its extent must be three positive lengths")
    filled = _points(density, half, np.full(3, _PROBE), rng)[1]
    if not len(filled):
        raise ValueError(_EMPTY)
    wanted = _POINTS * count * _PROBE**3 / len(filled)
    sides = np.maximum(2, np.ceil(half * (wanted / half.prod()) ** (1.0 / 3.0))).astype(int)
    if (points := math.prod(map(int, sides))) > _MOST * count:
        lengths = ", ".join(f"{side:.3g}" for side in half)
        raise ValueError(
            f"its extent, {lengths} to either side of the origin, is so large or so long for it that {points:.1e} "
            f"points would be looked at, more than {_MOST} for each of {count} particles: make the extent fit the body"
        )
    position, mass = _points(density, half, sides, rng)
    if len(mass) < count:
        raise ValueError(_EMPTY)
    places, cells = np.empty((count, 3)), [(np.arange(len(mass)), 0, count)]
    while cells:
        cell, first, shared = cells.pop()
        if shared == 1:
            places[first] = mass[cell] @ position[cell] / mass[cell].sum()
            continue
        side = np.argmax(np.ptp(position[cell], axis=0))
        cell = cell[np.argsort(position[cell, side])]
        part = shared // 2
        enclosed = np.cumsum(mass[cell])
        middle = int(np.searchsorted(enclosed, enclosed[-1] * part / shared))
        middle = min(max(middle, part), len(cell) - (shared - part))  # each particle keeps a point of its own
        cells += [(cell[:middle], first, part), (cell[middle:], first + part, shared - part)]
    return places, float(mass.sum())


def _points(density: Any, half: np.ndarray, sides: np.ndarray, rng: np.random.Generator) -> tuple[Any, np.ndarray]:
    """Points of the lattice inside the body, (M, 3), and the mass that each stands for, (M,)."""
    count = math.prod(map(int, sides))
    kept, densities = [], []
    for first in range(0, count, _AT_ONCE):
        lattice = np.stack(np.unravel_index(np.arange(first, min(first + _AT_ONCE, count)), sides), axis=-1)
        position = (2.0 * (lattice + rng.random(lattice.shape)) / sides - 1.0) * half
        rho = np.asarray(density(position), dtype=float)
        if rho.shape != (len(position),) or not np.isfinite(rho).all() or (rho < 0.0).any():
            raise ValueError("its density must be a finite number that is not negative, one for each position")
        inside = rho > 0.0
        kept.append(position[inside])
        densities.append(rho[inside])
    return np.concatenate(kept), np.concatenate(densities) * (8.0 * half.prod() / count)
