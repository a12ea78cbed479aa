"""What a spinning mass does to orbits and gyroscopes about it, and what mass alone does to an orbit's pericentre.

Relativity to first order in 1/c^2, averaged over an orbit, with J the angular momentum of the central body:

    node          2 G J/(c^2 a^3 (1 - e^2)^(3/2)),     pericentre from the node  -6 G J cos i/(c^2 a^3 (1 - e^2)^(3/2)),
    gyroscope     (G/(2 c^2 a^3 (1 - e^2)^(3/2))) (J - 3 (J.n) n)  for the normal n of its orbit,
    pericentre    3 n G M/(c^2 a (1 - e^2)),  by mass.

What mass does to a gyroscope is `precession.geodesic_precession`, and to the spins of a binary
`precession.geodetic_precession_of_binary`. SI; angles and rates in radians; numbers or arrays.
Sources: Lense & Thirring 1918, Phys. Z. 19, 156; Schiff 1960, PRL 4, 215; Einstein 1915.
"""

from typing import Any

import numpy as np

from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import of_any_length, require_components
from astroinertia.rotation.precession import require_ellipse
from astroinertia.units import GRAVITATIONAL_CONSTANT, SPEED_OF_LIGHT

Array = Any


@with_quantities()
def dragged_node(angular_momentum: Array, semi_major_axis: Array, eccentricity: Array = 0.0) -> Array:
    """The rate of the node on the equator of a body with the angular momentum J (kg m2 s-1), rad s-1.

    Positive: it goes with the spin, whatever the inclination. Source: Lense & Thirring 1918.

    >>> rate = dragged_node(5.86e33, 1.227e7, 0.0044)
    >>> print(f"{np.degrees(rate) * 3600e3 * 3.15576e7:.1f}")  # mas a year, of LAGEOS
    30.7
    """
    return 2 * _dragging(angular_momentum, semi_major_axis, eccentricity)


@with_quantities()
def dragged_pericentre(
    angular_momentum: Array, semi_major_axis: Array, eccentricity: Array = 0.0, inclination: Array = 0.0
) -> Array:
    """The rate of the pericentre from the node by the same, -6 G J cos i/(c^2 a^3 (1 - e^2)^(3/2)), rad s-1.

    inclination to the equator. Source: Lense & Thirring 1918.

    >>> rate = dragged_pericentre(5.86e33, 1.2163e7, 0.0135, np.radians(52.64))
    >>> print(f"{np.degrees(rate) * 3600e3 * 3.15576e7:.0f}")  # mas a year, of LAGEOS 2
    -57
    """
    return -6 * _dragging(angular_momentum, semi_major_axis, eccentricity) * np.cos(inclination)


@with_quantities()
def dragged_gyroscope(
    angular_momentum: Array, orbit_normal: Array, semi_major_axis: Array, eccentricity: Array = 0.0
) -> Array:
    """The angular velocity (..., 3) with which a gyroscope's axis turns, averaged over its orbit, rad s-1.

    angular_momentum (..., 3) of the central body and orbit_normal (..., 3), of any length, in the same axes. On a polar
    orbit it is along J, G J/(2 c^2 a^3), and above the equator against it, twice as fast. ValueError for a normal of 0.
    Source: Schiff 1960, averaged.

    >>> turning = dragged_gyroscope([0.0, 0.0, 5.86e33], [1.0, 0.0, 0.0], 7.0274e6, 0.0014)
    >>> print(f"{np.degrees(turning[2]) * np.cos(np.radians(16.84)) * 3600e3 * 3.15576e7:.1f}")  # mas, Gravity Probe B
    39.1
    """
    require_components(angular_momentum=angular_momentum, orbit_normal=orbit_normal)
    momentum, normal = np.asarray(angular_momentum, dtype=float), of_any_length(np.asarray(orbit_normal, dtype=float))
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    if not np.all(size > 0):
        raise ValueError("orbit_normal must not be the vector 0")
    along = normal / size
    strength = _dragging(1.0, semi_major_axis, eccentricity)[..., None]
    return 0.5 * strength * (momentum - 3 * (momentum * along).sum(-1, keepdims=True) * along)


@with_quantities()
def relativistic_pericentre(gravitational_parameter: Array, semi_major_axis: Array, eccentricity: Array = 0.0) -> Array:
    """The rate at which mass alone advances a pericentre, 3 n G M/(c^2 a (1 - e^2)), rad s-1.

    gravitational_parameter: of both bodies together, n^2 a^3 = G M. Source: Einstein 1915; Robertson 1938, Ann. Math.
    39, 101.

    >>> rate = relativistic_pericentre(1.32712440041e20, 5.790905e10, 0.20563)
    >>> print(f"{np.degrees(rate) * 3600 * 3.15576e9:.2f}")  # arcsec a century, of Mercury
    42.98
    """
    a = np.asarray(semi_major_axis, dtype=float)
    require_ellipse(a, eccentricity)
    parameter = np.asarray(gravitational_parameter, dtype=float)
    return 3 * np.sqrt(parameter**3 / a**5) / (SPEED_OF_LIGHT**2 * (1 - np.asarray(eccentricity) ** 2))


def _dragging(angular_momentum: Array, semi_major_axis: Array, eccentricity: Array) -> Array:
    """G J/(c^2 a^3 (1 - e^2)^(3/2))."""
    a = np.asarray(semi_major_axis, dtype=float)
    require_ellipse(a, eccentricity)
    shape = SPEED_OF_LIGHT**2 * a**3 * (1 - np.asarray(eccentricity, dtype=float) ** 2) ** 1.5
    return GRAVITATIONAL_CONSTANT * np.asarray(angular_momentum) / shape
