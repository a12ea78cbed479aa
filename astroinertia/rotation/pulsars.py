"""Pulsars: what a period and its derivative say of energy, field, age and gravitational waves, and how braking goes on.

Torque laws are Omega' = -K Omega^n with the braking index n: 3 for a magnetic dipole, 5 for the gravitational waves of
a rigid deformation, 1 for a wind. Arguments are numbers or arrays that broadcast, in SI: kg, m, s, and tesla for
fields (1 T is 1e4 G). ValueError for a period that is not above zero; it is infinite for a star at rest.
"""

import math
from typing import Any

import numpy as np
from scipy.special import exprel, inv_boxcox

from astroinertia.process.positive import positive_period, require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT, SPEED_OF_LIGHT

Array = Any

CANONICAL_MOMENT = 1e38  # kg m2, the customary 1e45 g cm2
CANONICAL_RADIUS = 1e4  # m
# mu_0/(4 pi) in SI as it was defined until 2019, so that a field is the gauss value of the literature times 1e-4; the
# measured constant differs by 6e-10 of itself.
MAGNETIC_CONSTANT = 1e-7

# L = A mu^2 Omega^4/c^3 (mu the magnetic moment, Gaussian) at inclination chi: the radiation of a dipole in vacuum
# (Pacini 1967; Ostriker & Gunn 1969, ApJ 157, 1395), and of one in a conducting magnetosphere (Spitkovsky 2006, ApJ
# 648, L51).
_POWER = {
    "vacuum": lambda inclination: 2 / 3 * np.sin(inclination) ** 2,
    "force_free": lambda inclination: 1 + np.sin(inclination) ** 2,
}
_PLACES = {"equator": 1.0, "pole": 2.0}  # field of a dipole over that at its equator


@with_quantities()
def rotational_energy(period: Array, moment_of_inertia: Array = CANONICAL_MOMENT) -> Array:
    """2 pi^2 I/P^2 in J.

    >>> print(f"{rotational_energy(0.0333924123):.2e} J")  # the Crab pulsar, I = 1e38 kg m2
    1.77e+42 J
    """
    return 2 * math.pi**2 * np.asarray(moment_of_inertia) / positive_period(period) ** 2


@with_quantities()
def spin_down_luminosity(period: Array, period_derivative: Array, moment_of_inertia: Array = CANONICAL_MOMENT) -> Array:
    """4 pi^2 I P'/P^3 in W: the rate at which the energy of rotation is lost, negative where the star spins up.

    >>> print(f"{spin_down_luminosity(0.0333924123, 4.20972e-13):.2e} W")  # the Crab pulsar: what lights its nebula
    4.46e+31 W
    """
    period = positive_period(period)
    return 4 * math.pi**2 * np.asarray(moment_of_inertia) * period_derivative / period**3


@with_quantities()
def dipole_field(
    period: Array,
    period_derivative: Array,
    moment_of_inertia: Array = CANONICAL_MOMENT,
    radius: Array = CANONICAL_RADIUS,
    place: str = "equator",
    inclination: Array = math.pi / 2,
    magnetosphere: str = "vacuum",
) -> Array:
    """The surface field in T of a dipole whose losses slow the star down so.

    place: "equator" (the custom of catalogues) or "pole", where it is twice that; inclination in radians of the dipole
    to the spin; magnetosphere: "vacuum" or "force_free". The default is the orthogonal rotator in vacuum,
    B^2 = 3 c^3 I P P'/(8 pi^2 R^6) in Gaussian units, with canonical I and R the 3.2e19 G (P P'/s)^(1/2) of catalogues.
    ValueError for other names, and for an aligned dipole in vacuum, which loses nothing. Sources: Manchester & Taylor
    1977, Pulsars, eq. 9-6; Spitkovsky 2006, ApJ 648, L51.

    >>> print(f"{dipole_field(0.0333924123, 4.20972e-13):.2e} T")  # the Crab pulsar, at its equator
    3.79e+08 T
    """
    squared = _field_factor(moment_of_inertia, radius, place, inclination, magnetosphere)
    with np.errstate(invalid="ignore"):
        return np.sqrt(squared * positive_period(period) * period_derivative)


@with_quantities(field="T")
def dipole_period_derivative(
    period: Array,
    field: Array,
    moment_of_inertia: Array = CANONICAL_MOMENT,
    radius: Array = CANONICAL_RADIUS,
    place: str = "equator",
    inclination: Array = math.pi / 2,
    magnetosphere: str = "vacuum",
) -> Array:
    """P' of a star with a dipole field in T; the inverse of `dipole_field`.

    >>> field = dipole_field(0.0333924123, 4.20972e-13)
    >>> print(f"{dipole_period_derivative(0.0333924123, field):.5e}")  # back again
    4.20972e-13
    """
    squared = _field_factor(moment_of_inertia, radius, place, inclination, magnetosphere)
    return np.asarray(field, dtype=float) ** 2 / (squared * positive_period(period))


def _field_factor(moment: Array, radius: Array, place: str, inclination: Array, magnetosphere: str) -> Array:
    # B^2/(P P'): I Omega Omega' = A mu^2 Omega^4/c^3 with mu = B R^3 at the equator, and mu_0/(4 pi) for SI.
    if place not in _PLACES:
        raise ValueError(f"a field is that at the {' or the '.join(_PLACES)}, not at {place!r}")
    if magnetosphere not in _POWER:
        raise ValueError(f"a magnetosphere is {' or '.join(_POWER)}, not {magnetosphere!r}")
    power = _POWER[magnetosphere](np.asarray(inclination, dtype=float))
    if np.any(power <= 1e-30):
        raise ValueError("a dipole along the spin axis loses nothing in vacuum: its field does not follow from P'")
    moment, radius = np.asarray(moment, dtype=float), np.asarray(radius, dtype=float)
    return _PLACES[place] ** 2 * MAGNETIC_CONSTANT * SPEED_OF_LIGHT**3 * moment / (4 * math.pi**2 * power * radius**6)


@with_quantities()
def light_cylinder_radius(period: Array) -> Array:
    """c P/(2 pi) in m: where a field line that turns along would move as fast as light.

    >>> print(f"{light_cylinder_radius(0.0333924123) / 1e3:.0f} km")  # c P / (2 pi)
    1593 km
    """
    return SPEED_OF_LIGHT * positive_period(period) / (2 * math.pi)


@with_quantities(field="T")
def light_cylinder_field(field: Array, period: Array, radius: Array = CANONICAL_RADIUS) -> Array:
    """The field in T at the light cylinder, B (R/R_lc)^3 of a dipole.

    >>> print(f"{light_cylinder_field(3.79e8, 0.0333924123):.0f} T")  # the Crab pulsar's, as r^-3
    94 T
    """
    return np.asarray(field, dtype=float) * (np.asarray(radius) / light_cylinder_radius(period)) ** 3


@with_quantities()
def characteristic_age(period: Array, period_derivative: Array, braking_index: Array = 3.0) -> Array:
    """P/((n - 1) P') in s: the age of a star that was born spinning much faster; infinite for n = 1 and below.

    A star of such an index never was infinitely fast. Source: Lorimer & Kramer 2005, Handbook of Pulsar Astronomy,
    eq. 3.11 with a period at birth of 0.

    >>> age = characteristic_age(0.0333924123, 4.20972e-13)  # of the Crab pulsar, born in 1054
    >>> print(f"{age / 3.15576e7:.0f} yr")
    1257 yr
    """
    with np.errstate(divide="ignore"):
        return positive_period(period) / (np.maximum(np.asarray(braking_index) - 1, 0.0) * period_derivative)


@with_quantities()
def true_age(period: Array, period_derivative: Array, period_at_birth: Array, braking_index: Array = 3.0) -> Array:
    """The age in s of a star of one braking index that was born with a period: P/((n-1) P') (1 - (P_0/P)^(n-1)).

    Any n, also 1 (P/P' ln(P/P_0)) and less. Source: Lorimer & Kramer 2005, Handbook of Pulsar Astronomy, eq. 3.11.

    >>> age = true_age(0.0333924123, 4.20972e-13, 0.0185, 2.51)  # of the Crab pulsar, if it was born with 18.5 ms
    >>> print(f"{age / 3.15576e7:.0f} yr")
    982 yr
    """
    period, birth = positive_period(period), positive_period(period_at_birth, "period_at_birth")
    # ln(P/P_0), also where they are nearly equal
    spread = np.sign(period - birth) * np.log1p(abs(period - birth) / np.minimum(period, birth))
    return period / period_derivative * spread * exprel(-(np.asarray(braking_index) - 1) * spread)


@with_quantities()
def period_at_birth(period: Array, period_derivative: Array, age: Array, braking_index: Array = 3.0) -> Array:
    """The period in s a star had so long ago, NaN where its law says that it was infinitely fast since then.

    >>> period = period_at_birth(0.0333924123, 4.20972e-13, 958 * 3.15576e7, 2.51)  # the Crab pulsar, in 1054
    >>> print(f"{1e3 * period:.1f} ms")
    18.9 ms
    """
    return period_history(-np.asarray(age, dtype=float), period, period_derivative, braking_index)


@with_quantities()
def period_history(time: Array, period: Array, period_derivative: Array, braking_index: Array = 3.0) -> Array:
    """The period in s a time after (or, negative, before) it was `period`: P (1 + (n - 1) P' t/P)^(1/(n - 1)).

    Any n, also 1 (exponential) and close to it. NaN before the time at which the law says infinitely fast (n > 1), and
    after that at which it says rest (n < 1).

    >>> period = period_history(1e4 * 3.15576e7, 0.0333924123, 4.20972e-13, 2.51)
    >>> print(f"{1e3 * period:.0f} ms")  # the Crab pulsar in ten thousand years
    121 ms
    """
    period, index = positive_period(period), np.asarray(braking_index, dtype=float)
    change = np.asarray(time, dtype=float) * period_derivative / period
    known = (index - 1) * change > -1
    return period * np.where(known, inv_boxcox(np.where(known, change, 0.0), index - 1), math.nan)


@with_quantities()
def period_derivative_history(
    time: Array, period: Array, period_derivative: Array, braking_index: Array = 3.0
) -> Array:
    """P' at that time: P' (P(t)/P)^(2 - n).

    >>> print(f"{period_derivative_history(0.0, 0.0333924123, 4.20972e-13, 2.51):.5e}")  # now, as given
    4.20972e-13
    """
    period = positive_period(period)
    later = period_history(time, period, period_derivative, braking_index)
    return period_derivative * (later / period) ** (2 - np.asarray(braking_index))


@with_quantities(period_second_derivative="s-1")
def braking_index(period: Array, period_derivative: Array, period_second_derivative: Array) -> Array:
    """n = Omega Omega''/Omega'^2 = 2 - P P''/P'^2, as it is measured.

    >>> print(f"{braking_index(1.0, 1e-13, -1e-26):.2f}")  # n = 2 - P P''/P'^2
    3.00
    """
    return 2 - positive_period(period) * period_second_derivative / np.asarray(period_derivative) ** 2


@with_quantities(first_derivative="s-2", second_derivative="s-3")
def frequency_braking_index(frequency: Array, first_derivative: Array, second_derivative: Array) -> Array:
    """n = nu nu''/nu'^2.

    >>> print(f"{frequency_braking_index(29.9, -3.77e-10, 1.19e-20):.2f}")  # the Crab's is 2.51
    2.50
    """
    return np.asarray(frequency, dtype=float) * second_derivative / np.asarray(first_derivative) ** 2


@with_quantities(first_derivative="s-2", third_derivative="s-4")
def second_braking_index(frequency: Array, first_derivative: Array, third_derivative: Array) -> Array:
    """m = nu^2 nu'''/nu'^3, which is n (2 n - 1) where n is constant. Source: Kaspi et al. 1994, ApJ 422, L83.

    >>> print(f"{second_braking_index(1.0, -1e-10, -1.5e-29):.0f}")  # of a dipole n (2 n - 1) = 15
    15
    """
    return np.asarray(frequency, dtype=float) ** 2 * third_derivative / np.asarray(first_derivative) ** 3


@with_quantities(first_derivative="s-2", later_first_derivative="s-2")
def braking_index_between(
    time: Array, frequency: Array, first_derivative: Array, later_frequency: Array, later_first_derivative: Array
) -> Array:
    """n from nu and nu' at two times, `time` apart: 1 + (nu_1/nu_1' - nu_2/nu_2')/(-t).

    It needs no second derivative, and holds for a constant n whatever the time. Source: Johnston & Galloway 1999,
    MNRAS 306, L50.

    >>> rate = lambda t: (1 + t) ** -0.5  # nu' ~ -nu^3
    >>> print(f"{braking_index_between(1.0, rate(0.0), -0.5, rate(1.0), -0.5 * 2**-1.5):.4f}")
    3.0000
    """
    first = np.asarray(frequency, dtype=float) / first_derivative
    second = np.asarray(later_frequency, dtype=float) / later_first_derivative
    return 1 + (first - second) / np.asarray(time, dtype=float)


@with_quantities(proper_motion="rad/s")
def shklovskii_effect(period: Array, proper_motion: Array, distance: Array) -> Array:
    """P mu^2 d/c: what motion across the line of sight adds to the P' that is observed.

    proper_motion mu in rad/s, distance d in m; most of what is seen of a nearby recycled pulsar may be this.
    Source: Shklovskii 1970, Sov. Astron. 13, 562.

    >>> print(f"{shklovskii_effect('5.757451936 ms', '140.9 mas/yr', '156.8 pc'):.2e}")  # of 5.73e-20, J0437-4715
    4.35e-20
    """
    return positive_period(period) * np.asarray(proper_motion, dtype=float) ** 2 * distance / SPEED_OF_LIGHT


@with_quantities()
def spin_down_strain(
    period: Array, period_derivative: Array, distance: Array, moment_of_inertia: Array = CANONICAL_MOMENT
) -> Array:
    """The spin-down limit h0 of a pulsar's gravitational waves: all the energy that it loses goes into them.

    (5 G I P'/(2 c^3 P))^(1/2)/d, with the distance d in m and I about the spin axis; NaN where P' is negative. h0 is
    the amplitude of either polarization at twice the rate of rotation, seen along the axis. Of fast pulsars P' is to
    be without their `shklovskii_effect`. ValueError for a distance that is not positive and finite.
    Source: Abbott et al. 2007, PRD 76, 042001; Aasi et al. 2014, ApJ 785, 119.

    >>> print(f"{spin_down_strain(0.0333924123, 4.20972e-13, '2 kpc'):.1e}")  # the Crab pulsar
    1.4e-24
    """
    require_positive(distance=distance)
    with np.errstate(invalid="ignore"):
        spent = np.sqrt(2.5 * GRAVITATIONAL_CONSTANT * moment_of_inertia * period_derivative / positive_period(period))
    return spent / (SPEED_OF_LIGHT**1.5 * np.asarray(distance, dtype=float))


@with_quantities()
def strain_of_ellipticity(
    ellipticity: Array, period: Array, distance: Array, moment_of_inertia: Array = CANONICAL_MOMENT
) -> Array:
    """h0 = 16 pi^2 G I eps/(c^4 d P^2) of a star of the equatorial ellipticity eps = (B - A)/C, with I = C.

    A <= B are its moments across the spin axis. ValueError for a distance that is not positive and finite.
    Source: Jaranowski, Krolak & Schutz 1998, PRD 58, 063001; Aasi et al. 2014, ApJ 785, 119.

    >>> print(f"{strain_of_ellipticity(1e-6, 0.01, '1 kpc'):.1e}")
    4.2e-26
    """
    return np.asarray(ellipticity, dtype=float) * _strain_per_ellipticity(period, distance, moment_of_inertia)


@with_quantities()
def ellipticity_of_strain(
    strain: Array, period: Array, distance: Array, moment_of_inertia: Array = CANONICAL_MOMENT
) -> Array:
    """The ellipticity that an amplitude h0 stands for; the inverse of `strain_of_ellipticity`.

    An upper limit of h0 gives one of the ellipticity, and `spin_down_strain` the one that its spin-down allows.

    >>> print(f"{ellipticity_of_strain(1.6e-25, 0.0333924123, '2 kpc'):.1e}")  # of the Crab pulsar
    8.4e-05
    """
    return np.asarray(strain, dtype=float) / _strain_per_ellipticity(period, distance, moment_of_inertia)


def _strain_per_ellipticity(period: Array, distance: Array, moment: Array) -> Array:
    require_positive(distance=distance)
    scale = 16 * math.pi**2 * GRAVITATIONAL_CONSTANT * np.asarray(moment, dtype=float) / SPEED_OF_LIGHT**4
    return scale / (np.asarray(distance, dtype=float) * positive_period(period) ** 2)
