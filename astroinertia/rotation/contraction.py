"""Slow contraction: how fast planets and young stars shrink as they radiate, for the spin-up that follows.

A body of polytropic structure in equilibrium has the energy -w G M^2/R with w = (3 gamma - 4)/((gamma - 1)(5 - n)), and
loses it at its luminosity. SI, or any consistent units with the G given. Tests:
tests/unit/rotation/test_contraction.py.
"""

import math
from typing import Any

import numpy as np

from astroinertia.process.positive import refuse_negative, require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT, STEFAN_BOLTZMANN_CONSTANT

Array = Any


@with_quantities()
def binding_factor(index: Array, gamma: Array = 5 / 3) -> Array:
    """w of the total energy -w G M^2/R: 3/7 for n = 1.5 and gamma = 5/3; 0 and below, the body does not hold together.

    Source: Chandrasekhar 1939, An Introduction to the Study of Stellar Structure, ch. IV, with the virial theorem.

    >>> print(f"{binding_factor(1.5):.4f}")  # of G M^2/R: (3 gamma - 4)/(3 gamma - 3) times 3/(5 - n)
    0.4286
    """
    index, gamma = np.asarray(index, dtype=float), np.asarray(gamma, dtype=float)
    if not ((index >= 0) & (index < 5)).all():
        raise ValueError("the index of a polytrope of finite radius must be from 0 to below 5")
    return (3 * gamma - 4) / ((gamma - 1) * (5 - index))


@with_quantities()
def kelvin_helmholtz_time(
    mass: Array,
    radius: Array,
    luminosity: Array,
    index: Array = 1.5,
    gamma: Array = 5 / 3,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Array:
    """Energy over luminosity, w G M^2/(R L). ValueError for what is negative.

    >>> print(f"{kelvin_helmholtz_time(1.989e30, 6.957e8, 3.828e26) / 3.15576e13:.0f} Myr")  # of the Sun
    13 Myr
    """
    refuse_negative(mass=mass, radius=radius, luminosity=luminosity, gravitational_constant=gravitational_constant)
    energy = binding_factor(index, gamma) * gravitational_constant * np.asarray(mass, dtype=float) ** 2
    with np.errstate(divide="ignore"):  # what does not radiate has for ever
        return energy / (np.asarray(radius, dtype=float) * luminosity)


@with_quantities()
def radius_at_luminosity(
    time: Array,
    mass: Array,
    radius: Array,
    luminosity: Array,
    index: Array = 1.5,
    gamma: Array = 5 / 3,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Array:
    """R(t) at one luminosity: 1/R grows steadily, R = R_0/(1 + t/t_KH). ValueError for what is negative but the time.

    >>> print(f"{radius_at_luminosity(0.0, 1.989e30, 6.957e8, 3.828e26) / 6.957e8:.1f}")  # now, as given
    1.0
    """
    scale = kelvin_helmholtz_time(mass, radius, luminosity, index, gamma, gravitational_constant)
    return np.asarray(radius, dtype=float) / _swollen(1 + np.asarray(time, dtype=float) / scale)


@with_quantities(effective_temperature="K")
def radius_at_temperature(
    time: Array, mass: Array, radius: Array, effective_temperature: Array, index: Array = 1.5, gamma: Array = 5 / 3
) -> Array:
    """R(t) in m at one effective temperature in K, as on a Hayashi track: R = R_0/(1 + 3 t/t_KH)^(1/3).

    ValueError for what is negative but the time.
    Source: Hayashi, Hoshi & Sugimoto 1962, Prog. Theor. Phys. Suppl. 22, 1.

    >>> print(f"{radius_at_temperature(0.0, 1.989e30, 6.957e8, 5772.0) / 6.957e8:.1f}")  # now, as given
    1.0
    """
    refuse_negative(effective_temperature=effective_temperature)
    radius, temperature = np.asarray(radius, dtype=float), np.asarray(effective_temperature, dtype=float)
    luminosity = 4 * math.pi * radius**2 * STEFAN_BOLTZMANN_CONSTANT * temperature**4
    scale = kelvin_helmholtz_time(mass, radius, luminosity, index, gamma)
    return radius / np.cbrt(_swollen(1 + 3 * np.asarray(time, dtype=float) / scale))


def _swollen(share: Array) -> Array:
    """A share of what the body was, (R_0/R)^k; ValueError before it was of infinite size."""
    if not np.all(share > 0):
        raise ValueError("time must be after the moment at which the body would have been of infinite size")
    return share


@with_quantities()
def contracted_period(period: Array, radius: Array, radius_after: Array, locked_until: Array = math.inf) -> Array:
    """The period of a body that shrinks or swells homologously: (R_after/R)^2 times it.

    locked_until: the radius down to which a disc holds the period of a young star that shrinks; from there on L stays.
    Source: Edwards et al. 1993, AJ 106, 372 (the disc); conservation of angular momentum.

    >>> print(contracted_period(9.0, 3.0, 1.0))  # as R^2
    1.0
    """
    require_positive(period=period, radius=radius, radius_after=radius_after)
    before, after = np.asarray(radius, dtype=float), np.asarray(radius_after, dtype=float)
    free_from = np.maximum(np.minimum(before, locked_until), np.minimum(before, after))
    return np.asarray(period, dtype=float) * (after / free_from) ** 2
