"""Moment ratios: exact conversions between radii, between mean and polar moment, and from precession.

Each ratio is a moment over M R^2, and means nothing without its R. With principal moments A <= B <= C and the gravity
coefficients J2 = (C - (A + B)/2)/(M R^2) and C22 = (B - A)/(4 M R^2) for the same R, all of this is algebra without
approximation, for a body of any shape. Scalars or arrays, NumPy or JAX, that broadcast.

Tests: tests/unit/bodies/test_planets.py.
"""

from typing import Any

import numpy as np

from astroinertia.inertia.tensor import namespace, require_plausible
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities

Array = Any

UNIFORM = 0.4
"""I/(M R^2) of a uniform sphere: the most that any sphere with a density not rising outwards can have."""


@with_quantities(from_radius="m", to_radius="m")
def convert_moment_ratio(value: Array, from_radius: Array, to_radius: Array) -> Array:
    """Return a moment ratio (or its uncertainty) of one radius for another: it goes as radius^-2.

    >>> print(f"{convert_moment_ratio(0.36419, 3396.0, 3389.5):.5f}")  # of Mars, from its equatorial radius
    0.36559
    """
    if not all(np.all(np.asarray(radius) > 0) for radius in (from_radius, to_radius) if is_known(radius)):
        raise ValueError("from_radius and to_radius must be positive")
    return value * (from_radius / to_radius) ** 2


@with_quantities()
def mean_from_polar(polar_ratio: Array, j2: Array) -> Array:
    """Return I/(M R^2) of the mean moment I = (A + B + C)/3 from C/(M R^2) and J2, both for the same R.

    >>> print(f"{mean_from_polar(0.3307, 1.0826e-3):.5f}")  # less (2/3) J2
    0.32998
    """
    return polar_ratio - 2.0 / 3.0 * j2


@with_quantities()
def polar_from_mean(mean_ratio: Array, j2: Array) -> Array:
    """Return C/(M R^2) from that of the mean moment and J2, both for the same R.

    >>> print(f"{polar_from_mean(0.32998, 1.0826e-3):.4f}")
    0.3307
    """
    return mean_ratio + 2.0 / 3.0 * j2


@with_quantities()
def principal_moment_ratios(polar_ratio: Array, j2: Array, c22: Array = 0.0) -> tuple[Array, Array, Array]:
    """Return A, B and C over M R^2 from C/(M R^2), J2 and C22 (zero for an axisymmetric body), all for the same R.

    ValueError where no body has these: one is negative, or more than the other two together.

    >>> print([f"{each:.5f}" for each in principal_moment_ratios(0.3307, 1.0826e-3)])
    ['0.32962', '0.32962', '0.33070']
    """
    middle = polar_ratio - j2
    ratios = middle - 2.0 * c22, middle + 2.0 * c22, polar_ratio
    if all(map(is_known, ratios)):
        require_plausible(np.stack(np.broadcast_arrays(*ratios), axis=-1)[..., None] * np.eye(3))
    return ratios


@with_quantities()
def polar_from_precession(j2: Array, dynamical_ellipticity: Array) -> Array:
    """Return C/(M R^2) = J2/H from J2 for R and H = (C - (A + B)/2)/C, which precession measures.

    >>> print(f"{polar_from_precession(1.0826359e-3, 3.2737949e-3):.4f}")  # of the Earth
    0.3307
    """
    return j2 / dynamical_ellipticity


@with_quantities(first="m", second="m", third="m")
def volumetric_radius(first: Array, second: Array, third: Array) -> Array:
    """Return (a b c)^(1/3), the radius of the sphere with the volume of the ellipsoid of these semi-axes.

    ValueError where one of them is negative.

    >>> print(f"{volumetric_radius(1.0, 2.0, 4.0):.6f}")
    2.000000
    """
    if any(np.any(np.asarray(axis) < 0) for axis in (first, second, third) if is_known(axis)):
        raise ValueError("semi-axes must not be negative")
    xp = namespace(first, second, third)
    return xp.cbrt(1.0 * xp.asarray(first) * second * third)  # 1.0: products of whole numbers overflow
