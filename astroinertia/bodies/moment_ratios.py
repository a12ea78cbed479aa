"""Moment ratios: exact conversions between radii, between mean and polar moment, and from precession.

Each ratio is a moment over M R^2, and means nothing without its R. With principal moments A <= B <= C and the gravity
coefficients J2 = (C - (A + B)/2)/(M R^2) and C22 = (B - A)/(4 M R^2) for the same R, all of this is algebra without
approximation, for a body of any shape. Scalars or arrays that broadcast.

Tests: tests/unit/test_planets.py.
"""

import numpy as np

UNIFORM = 0.4
"""I/(M R^2) of a uniform sphere: the most that any sphere with a density not rising outwards can have."""


def convert_moment_ratio(value, from_radius, to_radius):
    """Return a moment ratio (or its uncertainty) of one radius for another: it goes as radius^-2."""
    return value * (from_radius / to_radius) ** 2


def mean_from_polar(polar_ratio, j2):
    """Return I/(M R^2) of the mean moment I = (A + B + C)/3 from C/(M R^2) and J2, both for the same R."""
    return polar_ratio - 2.0 / 3.0 * j2


def polar_from_mean(mean_ratio, j2):
    """Return C/(M R^2) from that of the mean moment and J2, both for the same R."""
    return mean_ratio + 2.0 / 3.0 * j2


def principal_moment_ratios(polar_ratio, j2, c22=0.0):
    """Return A, B and C over M R^2 from C/(M R^2), J2 and C22 (zero for an axisymmetric body), all for the same R."""
    middle = polar_ratio - j2
    return middle - 2.0 * c22, middle + 2.0 * c22, polar_ratio


def polar_from_precession(j2, dynamical_ellipticity):
    """Return C/(M R^2) = J2/H from J2 for R and H = (C - (A + B)/2)/C, which precession measures."""
    return j2 / dynamical_ellipticity


def volumetric_radius(first, second, third):
    """Return (a b c)^(1/3), the radius of the sphere with the volume of the ellipsoid of these semi-axes."""
    return np.cbrt(first * second * third)
