"""Spin-up by accretion: where the field holds the disc off, the period in balance with it, and how long that takes.

SI throughout: kg, m, s, and the field at the magnetic equator in T. ValueError for a period, a rate of accretion, a
mass and a radius that are not above zero.
"""

import math
from typing import Any

import numpy as np

from astroinertia.process.positive import positive_period, require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.pulsars import (
    CANONICAL_MOMENT,
    CANONICAL_RADIUS,
    MAGNETIC_CONSTANT,
    dipole_period_derivative,
)
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SPEED_OF_LIGHT

Array = Any

MASS = 1.4 * SOLAR_MASS
# Inner edge of the disc over the Alfven radius of spherical inflow. Source: Ghosh & Lamb 1979, ApJ 234, 296: 0.52.
DISC_COEFFICIENT = 0.52
ELECTRON_OPACITY = 0.0397726  # m2 kg-1 of ionised hydrogen, Thomson cross section over proton mass, CODATA 2022


@with_quantities(field="T")
def magnetospheric_radius(
    field: Array,
    accretion_rate: Array,
    mass: Array = MASS,
    radius: Array = CANONICAL_RADIUS,
    coefficient: Array = DISC_COEFFICIENT,
) -> Array:
    """coefficient times the Alfven radius (mu^4/(2 G M Mdot^2))^(1/7) in m, mu = B R^3 (Gaussian).

    Source: Davidson & Ostriker 1973, ApJ 179, 585; Ghosh & Lamb 1979, ApJ 234, 296.

    >>> print(f"{magnetospheric_radius(1e8, 1e13) / 1e3:.0f} km")  # an X-ray pulsar
    3102 km
    """
    require_positive(accretion_rate=accretion_rate, mass=mass, radius=radius)
    squared = np.asarray(field, dtype=float) ** 2 * np.asarray(radius, dtype=float) ** 6 / MAGNETIC_CONSTANT
    flow = 2 * GRAVITATIONAL_CONSTANT * np.asarray(mass) * np.asarray(accretion_rate, dtype=float) ** 2
    return coefficient * (squared**2 / flow) ** (1 / 7)


@with_quantities()
def corotation_radius(period: Array, mass: Array = MASS) -> Array:
    """Radius in m of the orbit with the star's period; a disc held off farther out is flung away (propeller).

    >>> print(f"{corotation_radius(1.0) / 1e3:.0f} km")  # where an orbit takes a second
    1676 km
    """
    require_positive(mass=mass)
    return (GRAVITATIONAL_CONSTANT * np.asarray(mass) * (positive_period(period) / (2 * math.pi)) ** 2) ** (1 / 3)


@with_quantities(field="T")
def equilibrium_period(
    field: Array,
    accretion_rate: Array,
    mass: Array = MASS,
    radius: Array = CANONICAL_RADIUS,
    coefficient: Array = DISC_COEFFICIENT,
    fastness: Array = 1.0,
) -> Array:
    """The period in s at which accretion spins the star neither up nor down.

    That of an orbit at the inner edge of the disc, which is not inside the star, over the critical fastness (rate of
    the star over that orbit's, 0.35 to 1 by the author). Source: Ghosh & Lamb 1979; Bhattacharya & van den Heuvel
    1991, Phys. Rep. 203, 1.

    >>> print(f"{equilibrium_period(1e8, 1e13):.2f} s")
    2.52 s
    """
    edge = np.maximum(magnetospheric_radius(field, accretion_rate, mass, radius, coefficient), radius)
    return 2 * math.pi * np.sqrt(edge**3 / (GRAVITATIONAL_CONSTANT * np.asarray(mass))) / fastness


@with_quantities(field="T")
def accretion_torque(
    field: Array,
    accretion_rate: Array,
    mass: Array = MASS,
    radius: Array = CANONICAL_RADIUS,
    coefficient: Array = DISC_COEFFICIENT,
) -> Array:
    """Mdot (G M r)^(1/2) in N m: the angular momentum that matter brings from the inner edge of the disc.

    >>> print(f"{accretion_torque(1e8, 1e13):.1e} N m")
    2.4e+26 N m
    """
    edge = np.maximum(magnetospheric_radius(field, accretion_rate, mass, radius, coefficient), radius)
    return np.asarray(accretion_rate) * np.sqrt(GRAVITATIONAL_CONSTANT * np.asarray(mass) * edge)


@with_quantities(field="T")
def spun_up_rate(
    time: Array,
    angular_velocity: Array,
    field: Array,
    accretion_rate: Array,
    moment_of_inertia: Array = CANONICAL_MOMENT,
    mass: Array = MASS,
    radius: Array = CANONICAL_RADIUS,
    coefficient: Array = DISC_COEFFICIENT,
    fastness: Array = 1.0,
) -> Array:
    """Omega in rad/s after a time of steady accretion, with the torque N (1 - Omega/Omega_eq).

    It goes exponentially to the equilibrium, from either side, on the time I Omega_eq/N; mass and moment are held.
    Source: the torque linear in the fastness, as Ghosh & Lamb 1979 near equilibrium.

    >>> print(spun_up_rate(0.0, 1.0, 1e8, 1e13))  # at first, as given
    1.0
    """
    arguments = (field, accretion_rate, mass, radius, coefficient)
    end = 2 * math.pi / equilibrium_period(*arguments, fastness)
    scale = np.asarray(moment_of_inertia) * end / accretion_torque(*arguments)
    return end + (np.asarray(angular_velocity) - end) * np.exp(-np.asarray(time, dtype=float) / scale)


@with_quantities(field="T")
def mass_to_spin_up(
    period: Array,
    field: Array,
    accretion_rate: Array,
    moment_of_inertia: Array = CANONICAL_MOMENT,
    mass: Array = MASS,
    radius: Array = CANONICAL_RADIUS,
    coefficient: Array = DISC_COEFFICIENT,
) -> Array:
    """The mass in kg to be accreted from rest to a period, at the full torque: I Omega/(G M r)^(1/2).

    One to two tenths of a solar mass for a millisecond. Source: Alpar, Cheng, Ruderman & Shaham 1982, Nature 300, 728.

    >>> print(f"{mass_to_spin_up(2e-3, 1e4, 1e14) / 1.989e30:.2f} Msun")  # to make a millisecond pulsar
    0.12 Msun
    """
    torque = accretion_torque(field, accretion_rate, mass, radius, coefficient)
    rate = 2 * math.pi / positive_period(period)
    return np.asarray(moment_of_inertia) * rate * accretion_rate / torque


@with_quantities()
def eddington_rate(radius: Array = CANONICAL_RADIUS) -> Array:
    """4 pi c R/kappa in kg/s, at which the light of accreting hydrogen holds it off. It does not depend on the mass.

    >>> print(f"{eddington_rate() * 3.15576e7 / 1.989e30:.1e} Msun/yr")
    1.5e-08 Msun/yr
    """
    require_positive(radius=radius)
    return 4 * math.pi * SPEED_OF_LIGHT * np.asarray(radius, dtype=float) / ELECTRON_OPACITY


@with_quantities()
def spin_up_line(
    period: Array,
    accretion_rate: Array | None = None,
    moment_of_inertia: Array = CANONICAL_MOMENT,
    mass: Array = MASS,
    radius: Array = CANONICAL_RADIUS,
    coefficient: Array = DISC_COEFFICIENT,
    fastness: Array = 1.0,
) -> Array:
    """P' of pulsars whose period is that of equilibrium with accretion, Eddington's rate unless another is given.

    Recycled pulsars begin on or right of this line of the P-P' diagram, P' ~ P^(4/3). Source: Bhattacharya & van den
    Heuvel 1991, Phys. Rep. 203, 1.

    >>> print(f"{spin_up_line(0.005):.1e}")  # the greatest dP/dt of a pulsar spun up to 5 ms
    9.2e-18
    """
    rate = eddington_rate(radius) if accretion_rate is None else accretion_rate
    require_positive(accretion_rate=rate, mass=mass, radius=radius)
    period = positive_period(period)
    edge = (GRAVITATIONAL_CONSTANT * np.asarray(mass) * (period * fastness / (2 * math.pi)) ** 2) ** (1 / 3)
    flow = 2 * GRAVITATIONAL_CONSTANT * np.asarray(mass) * np.asarray(rate, dtype=float) ** 2
    squared = np.sqrt((edge / coefficient) ** 7 * flow) * MAGNETIC_CONSTANT / np.asarray(radius, dtype=float) ** 6
    return dipole_period_derivative(period, np.sqrt(squared), moment_of_inertia, radius)
