"""Rotating equilibrium stars as particles: a mass-preserving map of a glass.

A point of the unit ball at mass fraction f of a spherical profile, in direction mu = cos(angle from the axis), goes to
the direction below which the star has as much of its mass as the ball has below mu, and there to the radius that
encloses the fraction f of the mass along that direction (the map of Knothe 1957, Michigan Math. J. 4, 39). Surfaces go
to surfaces, every piece keeps its mass, and no noise is added.
"""

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.interpolate import RectBivariateSpline

from astroinertia.bodies.rotating_star import RotatingStar
from astroinertia.process.roots import bisected
from astroinertia.sph.placement import isotropised

_DIRECTIONS, _STEPS, _FRACTIONS = 129, 513, 513  # of the tables of the map: its masses are right to 1e-5


def mapped(star: RotatingStar, fraction: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return positions (N, 3) in the star of points at mass fractions (N,) in directions (N, 3) of a sphere.

    The centre of mass is put at the origin and the second moments are made the star's own, by a small linear map, with
    the axis along z. ValueError for a ring, which no ball can be mapped to.
    """
    if star.inner_radius > 0:
        raise ValueError("a ring cannot be placed as particles: the map is from a ball")
    cosine, radius = _tables(star)
    unit = direction / np.maximum(np.linalg.norm(direction, axis=1), 1e-300)[:, None]
    share = np.linspace(0.0, 1.0, _FRACTIONS)
    # r grows as the cube root of the mass at the centre, and the star's share below a direction is smooth in it
    mu = np.interp(np.abs(unit[:, 2]), cosine[1], cosine[0])
    r = RectBivariateSpline(cosine[0], share, radius)(mu, np.cbrt(fraction), grid=False)
    across = unit[:, :2] / np.maximum(np.linalg.norm(unit[:, :2], axis=1), 1e-300)[:, None]
    x = np.column_stack([across * (r * np.sqrt(1 - mu**2))[:, None], r * mu * np.sign(unit[:, 2])])
    along = star.equatorial_moment - star.polar_moment / 2
    wanted = np.array([star.polar_moment / 2, star.polar_moment / 2, along]) / star.mass
    return isotropised(x, 1.0) * np.sqrt(wanted)


def _tables(star: RotatingStar) -> tuple[np.ndarray, np.ndarray]:
    """Directions mu with the star's share of mass below each, (2, J), and r (J, F) by cube root of mass fraction."""
    mu = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, _DIRECTIONS)))
    # Crowded at the centre, where the mass grows as r^3, and at the surface, which each direction finds by bisection.
    surface = _surface(star, mu)
    t = np.linspace(0.0, 1.0, _STEPS)
    r = surface[:, None] * (t**2 * (3 - 2 * t))
    slope = surface[:, None] * 6 * t * (1 - t)
    sine = np.sqrt(1 - mu**2)[:, None]
    mass = cumulative_simpson(star.density(r * sine, r * mu[:, None]) * r**2 * slope, x=t, axis=1, initial=0.0)
    below = cumulative_simpson(mass[:, -1], x=mu, initial=0.0)
    share = np.linspace(0.0, 1.0, _FRACTIONS)
    table = np.array([np.interp(share, np.cbrt(m / m[-1]), row) for m, row in zip(mass, r, strict=True)])
    return np.array([mu, below / below[-1]]), table


def _surface(star: RotatingStar, mu: np.ndarray) -> np.ndarray:
    def inside(r: np.ndarray) -> np.ndarray:
        return star.level(r * np.sqrt(1 - mu**2), r * mu) > 0

    return bisected(inside, np.full_like(mu, star.polar_radius), np.full_like(mu, star.equatorial_radius), 50)
