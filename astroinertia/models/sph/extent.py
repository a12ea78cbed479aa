"""How far a body of particles reaches: radii that enclose shares of its mass, and the ellipsoid that it fills now.

From positions and masses alone, so that a body that keeps its profile and shape keeps all ratios of them to round-off.
Tests: tests/unit/models/sph/test_extent.py.
"""

import numpy as np

from astroinertia.observables.quantities import ENCLOSED

_FEWEST = 4  # particles, of which an ellipsoid says anything
_INNER = 0.90  # share of the mass that lies within the layer whose shape is taken; ENCLOSED lies within its outer edge
_CORE = 0.1  # of the outer edge: within it, as of a sink at the centre, a direction means little and the layer ends
_ITERATIONS = 4  # of the shape: what is left of its error falls to a quarter each time
_PART = 0.75  # of the correction that is right near the answer: all of it goes too far where the shape is far off
_MOST = 1.0  # of the logarithm of a semi-axis squared, by which a step changes it: bodies without a surface take leaps


def extent(mass: np.ndarray, relative: np.ndarray) -> dict[str, np.ndarray | float]:
    """What is recorded of particles (N,) at positions (N, 3) from the centre of mass; NaN where there are too few.

    half_mass_radius and radius_enclosing_99 are of spheres about the centre of mass. enclosing_ellipsoid (3, 3) is the
    matrix A of an ellipsoid x A^-1 x = 1. It is as large as the one with the shape of the second moments that holds
    ENCLOSED of the mass, and has the shape of the outermost tenth of the mass: the levels of its particles between
    those that enclose 0.9 and ENCLOSED of the mass do not depend on where they lie, to the second degree in direction.
    No directions in space are preferred, so that it turns with the body.
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
    """The shape, corrected by what makes the body round that it is to make round.

    Where surfaces lie at levels 1 + u.B u toward u, with B small and without a trace, the mean over the mass in the
    layer of u u log(level), less that of both apart, is 2/15 B.
    """
    root = _root(shape)
    rounded = relative @ np.linalg.inv(root)
    level = _lengths(rounded)
    order = np.argsort(level)
    inner, outer = _at_shares(mass[order], level[order], (_INNER, ENCLOSED))
    if not outer > 0.0:  # all at one place
        return shape
    total, core = mass.sum(), _CORE * outer
    inner = max(inner, core)
    toward = rounded / np.maximum(level, core)[:, None]
    everywhere = (mass * toward.T) @ toward / total
    everywhere += (1.0 - np.trace(everywhere)) / 3.0 * np.eye(3)
    layer = level > inner
    raised = mass[layer] * np.log(np.minimum(level[layer], outer) / inner)  # what flies off is no part of the surface
    toward = toward[layer]
    together = (raised * toward.T) @ toward - raised.sum() * everywhere
    logs, axes = np.linalg.eigh(2.0 * _PART * 7.5 / ((ENCLOSED - _INNER) * total) * together)
    return _of_volume_one(root @ (axes * np.exp(np.clip(logs, -_MOST, _MOST))) @ axes.T @ root)


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
