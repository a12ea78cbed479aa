"""Stability of thin discs: Toomre's criterion, and the rate at which rings of gas oscillate or grow.

A razor-thin disc of gas with the surface density Sigma, sound speed c and epicyclic frequency kappa carries tightly
wound rings exp(i (k r - omega t)) with

    omega^2 = kappa^2 - 2 pi G Sigma |k| + c^2 k^2,    Q = c kappa/(pi G Sigma).

All are stable where Q > 1; at Q = 1 the one with k = pi G Sigma/c^2 stands still, and below it that one grows fastest.
Thick discs are more stable, and spiral arms grow up to a Q of about 2. kappa follows from the angular velocity Omega
and its slope d ln Omega/d ln r; where kappa itself is known, it is given as Omega with the slope -3/2, for which they
are the same. Numbers or arrays that broadcast, in SI or any consistent units with the G given.
Source: Toomre 1964, ApJ 139, 1217; Binney & Tremaine 2008, Galactic Dynamics, sections 3.2.3 and 6.2.3. Tests:
tests/unit/bodies/test_disc_stability.py.
"""

import math
from typing import Any

import numpy as np

from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT

Array = Any

KEPLERIAN = -1.5  # slope d ln Omega/d ln r of orbits around a point mass
_RAYLEIGH = -2.0  # the slope below which the angular momentum falls outwards


@with_quantities()
def epicyclic_frequency(angular_velocity: Array, slope: Array = KEPLERIAN) -> Array:
    """kappa = Omega (4 + 2 slope)^(1/2), with which a circular orbit oscillates in radius; slope is d ln Omega/d ln r.

    -3/2 for orbits around a point mass, -1 for a flat rotation curve, 0 for rigid rotation. ValueError below -2, where
    the angular momentum falls outwards and orbits are unstable (Rayleigh). Source: Binney & Tremaine 2008, eq. 3.80.

    >>> print(epicyclic_frequency(2.0), epicyclic_frequency(2.0, 0.0))  # around a point mass, and rigid
    2.0 4.0
    """
    steepness = np.asarray(slope, dtype=float)
    if not (steepness >= _RAYLEIGH).all():
        wrong = steepness[~(steepness >= _RAYLEIGH)].flat[0]
        raise ValueError(f"the slope d ln Omega/d ln r of orbits that are stable is -2 or more, not {wrong:g}")
    return np.abs(np.asarray(angular_velocity, dtype=float)) * np.sqrt(4 + 2 * steepness)


@with_quantities(surface_density="kg m-2")
def toomre_parameter(
    sound_speed: Array, angular_velocity: Array, surface_density: Array, slope: Array = KEPLERIAN,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Array:  # fmt: skip
    """Q = c kappa/(pi G Sigma) of a thin disc of gas: its rings are stable above 1.

    ValueError unless sound speed, surface density and G are positive and finite, and as for `epicyclic_frequency`.
    Source: Toomre 1964; Binney & Tremaine 2008, eq. 6.71.

    >>> print(f"{toomre_parameter('0.2 km/s', '1e-11 rad/s', '0.5 g/cm2'):.2f}")  # a disc around a young star
    1.91
    """
    require_positive(sound_speed=sound_speed)
    kappa = epicyclic_frequency(angular_velocity, slope)
    return np.asarray(sound_speed, dtype=float) * kappa / _pull(surface_density, gravitational_constant)


@with_quantities(wavenumber="m-1", surface_density="kg m-2")
def squared_frequency(
    wavenumber: Array, sound_speed: Array, angular_velocity: Array, surface_density: Array, slope: Array = KEPLERIAN,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Array:  # fmt: skip
    """omega^2 of rings with the radial wavenumber k; negative where they grow, at the rate (-omega^2)^(1/2).

    ValueError as for `toomre_parameter`. Source: Toomre 1964; Binney & Tremaine 2008, eq. 6.66 with m = 0.

    >>> print(squared_frequency(np.array([0.0, 1.0, 2.0]), 1.0, 1.0, 1 / np.pi, gravitational_constant=1.0))  # Q = 1
    [1. 0. 1.]
    """
    require_positive(sound_speed=sound_speed)
    kappa = epicyclic_frequency(angular_velocity, slope)
    k = np.abs(np.asarray(wavenumber, dtype=float))
    return kappa**2 - 2 * _pull(surface_density, gravitational_constant) * k + (np.asarray(sound_speed) * k) ** 2


@with_quantities(surface_density="kg m-2")
def fastest_wavenumber(
    sound_speed: Array, surface_density: Array, gravitational_constant: float = GRAVITATIONAL_CONSTANT
) -> Array:
    """The k of the least omega^2, pi G Sigma/c^2: of the rings that grow fastest, or come nearest to growing.

    ValueError unless all are positive and finite. Source: as for `squared_frequency`, whose minimum it is.

    >>> k = fastest_wavenumber(1.0, 2 / np.pi, 1.0)
    >>> print(k, squared_frequency(k, 1.0, 1.0, 2 / np.pi, gravitational_constant=1.0))  # kappa^2 (1 - 1/Q^2), Q = 1/2
    2.0 -3.0
    """
    require_positive(sound_speed=sound_speed)
    return _pull(surface_density, gravitational_constant) / np.asarray(sound_speed, dtype=float) ** 2


def _pull(surface_density: Array, gravitational_constant: float) -> Array:
    """pi G Sigma."""
    require_positive(surface_density=surface_density, gravitational_constant=gravitational_constant)
    return math.pi * gravitational_constant * np.asarray(surface_density, dtype=float)
