"""How far a body of particles reaches: radii that enclose shares of its mass, and the ellipsoid that it fills now.

From positions and masses alone, so that a body that keeps its profile and shape keeps all ratios of them to round-off.
Tests: tests/unit/models/sph/test_extent.py.
"""

from itertools import product

import numpy as np

from astroinertia.observables.quantities import ENCLOSED

_FEWEST = 4  # particles, of which an ellipsoid says anything
_LAYER = (0.90, 0.92, 0.94, 0.96, 0.98, ENCLOSED)  # shares of the mass, at whose radii the shape is taken
_ITERATIONS = 3  # of the shape: what is left of its error falls to a tenth each time
_DIRECTIONS = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if way > (0.0, 0.0, 0.0)])
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_FIT = np.linalg.pinv(
    np.stack([_DIRECTIONS[:, i] * _DIRECTIONS[:, j] * (1.0 if i == j else 2.0) for i, j in _PAIRS], axis=1)
)


def extent(mass: np.ndarray, relative: np.ndarray) -> dict[str, np.ndarray | float]:
    """What is recorded of particles (N,) at positions (N, 3) from the centre of mass; NaN where there are too few.

    half_mass_radius and radius_enclosing_99 are of spheres about the centre of mass. enclosing_ellipsoid (3, 3) is the
    matrix A of an ellipsoid x A^-1 x = 1. It is as large as the one with the shape of the second moments that holds
    ENCLOSED of the mass, and has the shape of the outermost tenth of the mass: by the radii that enclose from 0.9 to
    ENCLOSED of what lies in each of 13 directions.
    """
    radius = np.linalg.norm(relative, axis=1)
    half, most = enclosing(mass, radius, (0.5, ENCLOSED))
    return {
        "half_mass_radius": float(half),
        "radius_enclosing_99": float(most),
        "enclosing_ellipsoid": _ellipsoid(mass, relative, radius, float(most)),
    }


def enclosing(mass: np.ndarray, radius: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    """Radii within which shares of the mass lie, each particle's mass half within its own radius (N,)."""
    order = np.argsort(radius, kind="stable")
    return _at_shares(mass[order], radius[order], shares)


def _at_shares(mass: np.ndarray, radius: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    within = np.cumsum(mass) - 0.5 * mass
    return np.interp(np.asarray(shares) * mass.sum(), within, radius)


def _ellipsoid(mass: np.ndarray, relative: np.ndarray, radius: np.ndarray, most: float) -> np.ndarray:
    near = mass * np.minimum(1.0, most / np.maximum(radius, 1e-300)) ** 2  # of what flies off only the direction
    shape = _of_volume_one((near * relative.T) @ relative) if len(mass) >= _FEWEST else None
    if shape is None:
        return np.full((3, 3), np.nan)
    level = np.linalg.norm(relative @ np.linalg.inv(_root(shape)), axis=1)
    size = enclosing(mass, level, (ENCLOSED,))[0]
    for _ in range(_ITERATIONS):
        shape = _corrected(shape, mass, relative)
        if shape is None:
            return np.full((3, 3), np.nan)
    return size**2 * shape


def _corrected(shape: np.ndarray, mass: np.ndarray, relative: np.ndarray) -> np.ndarray | None:
    """The shape, corrected by what makes the body round that it is to make round."""
    root = _root(shape)
    rounded = relative @ np.linalg.inv(root)
    level = np.linalg.norm(rounded, axis=1)
    order = np.argsort(level, kind="stable")
    level, mass = level[order], mass[order]
    level = np.minimum(level, _at_shares(mass, level, (ENCLOSED,))[0])  # what flies off is no part of the surface
    toward = rounded[order] / np.maximum(np.linalg.norm(rounded[order], axis=1), 1e-300)[:, None]
    radii = [_at_shares(mass * _narrow(toward @ way), level, _LAYER).mean() for way in _DIRECTIONS]
    squares = _FIT @ np.square(radii)
    correction = np.empty((3, 3))
    for (i, j), square in zip(_PAIRS, squares, strict=True):
        correction[i, j] = correction[j, i] = square
    return _of_volume_one(root @ correction @ root)


def _narrow(cosine: np.ndarray) -> np.ndarray:
    """By how much a particle counts for a direction: the eighth power of the cosine, by products, which are quick."""
    for _ in range(3):
        cosine = cosine * cosine
    return cosine


def _root(shape: np.ndarray) -> np.ndarray:
    squares, axes = np.linalg.eigh(shape)
    return (axes * np.sqrt(squares)) @ axes.T


def _of_volume_one(tensor: np.ndarray) -> np.ndarray | None:
    """The tensor with the determinant 1; None where it is no ellipsoid's."""
    tensor = 0.5 * (tensor + tensor.T)
    squares = np.linalg.eigvalsh(tensor)
    if not squares[0] > 1e-12 * squares[2]:
        return None
    return tensor / np.exp(np.log(squares).mean())
