"""How far a body of particles reaches: radii that enclose shares of its mass, and the ellipsoid that it fills now.

From positions and masses alone, so that a body that keeps its profile and shape keeps all ratios of them to round-off.
Tests: tests/unit/models/sph/test_extent.py.
"""

from itertools import product

import numpy as np

from astroinertia.observables.quantities import ENCLOSED

_FEWEST = 4  # particles, of which an ellipsoid says anything
_LAYER = (0.90, 0.92, 0.94, 0.96, 0.98, ENCLOSED)  # shares of the mass, at whose radii the shape is taken
_BLOCK = 2048  # particles at a time, of which all directions fit into a processor's cache
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
    radius = _lengths(relative)
    half, most = enclosing(mass, radius, (0.5, ENCLOSED))
    return {
        "half_mass_radius": float(half),
        "radius_enclosing_99": float(most),
        "enclosing_ellipsoid": _ellipsoid(mass, relative, radius, float(most)),
    }


def enclosing(mass: np.ndarray, radius: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    """Radii within which shares of the mass lie, each particle's mass half within its own radius (N,)."""
    order = np.argsort(radius)
    return _at_shares(mass[order], radius[order], shares)


def _at_shares(mass: np.ndarray, radius: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    within = np.cumsum(mass) - 0.5 * mass
    return np.interp(np.asarray(shares) * mass.sum(), within, radius)


def _ellipsoid(mass: np.ndarray, relative: np.ndarray, radius: np.ndarray, most: float) -> np.ndarray:
    near = mass * np.minimum(1.0, most / np.maximum(radius, 1e-300)) ** 2  # of what flies off only the direction
    shape = _of_volume_one((near * relative.T) @ relative) if len(mass) >= _FEWEST else None
    if shape is None:
        return np.full((3, 3), np.nan)
    level = _lengths(relative @ np.linalg.inv(_root(shape)))
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
    level = _lengths(rounded)
    order = np.argsort(level)
    level, mass = level[order], mass[order]
    toward = np.stack([component[order] for component in rounded.T]) / np.maximum(level, 1e-300)
    level = np.minimum(level, _at_shares(mass, level, (ENCLOSED,))[0])  # what flies off is no part of the surface
    squares = _FIT @ np.square(_outer_radii(mass, level, toward).mean(axis=1))
    correction = np.empty((3, 3))
    for (i, j), square in zip(_PAIRS, squares, strict=True):
        correction[i, j] = correction[j, i] = square
    return _of_volume_one(root @ correction @ root)


def _outer_radii(mass: np.ndarray, level: np.ndarray, toward: np.ndarray) -> np.ndarray:
    """Radii (13, 6) with the shares _LAYER within in each direction, of sorted particles (N,) that lie `toward` (3, N).

    How much counts within is added up block by block; particle by particle it is only where the layer lies.
    """
    starts = range(0, len(mass), _BLOCK)
    blocks = [_narrow(_DIRECTIONS @ toward[:, k : k + _BLOCK]) @ mass[k : k + _BLOCK] for k in starts]
    within = np.cumsum([np.zeros(len(_DIRECTIONS)), *blocks], axis=0)
    total = within[-1]
    # A whole block of particles is before the first radius of any direction, but where that is in the first block.
    block = max(int((within <= _LAYER[0] * total).all(axis=1).sum()) - 2, 0)
    rest = slice(block * _BLOCK, None)
    radii = []
    for way, before, most in zip(_DIRECTIONS, within[block], total, strict=True):
        counted = mass[rest] * _narrow(way @ toward[:, rest])
        middle = before + np.cumsum(counted) - 0.5 * counted
        radii.append(np.interp(most * np.array(_LAYER), middle, level[rest]))
    return np.array(radii)


def _narrow(cosine: np.ndarray) -> np.ndarray:
    """By how much a particle counts for a direction: the eighth power of the cosine, by products, which are quick."""
    for _ in range(3):
        cosine = cosine * cosine
    return cosine


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Of vectors (N, 3)."""
    return np.sqrt(np.einsum("ni,ni->n", vectors, vectors))


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
