"""The whole body at once: how fast it spins when it has shrunk and its angular momentum has stayed.

L = k M R^2 omega with k = I/(M R^2), so that omega goes as 1/(k M R^2): as R^-2 where the collapse is homologous and
nothing is lost. Numbers or arrays that broadcast, in SI or any consistent units with the G given. A period is infinite
at rest and negative for a retrograde spin.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.bodies.neutron_star_fits import kepler_period, roche_shedding_period
from astroinertia.process.positive import refuse_negative, require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT

Array = Any


@dataclass(frozen=True)
class SpinUp:
    """A body before and after: all that its angular momentum says of how it then spins.

    moment_ratios, masses and radii of the two ends are as given; the rest follows.
    """

    moment_before: Array
    moment_after: Array
    angular_momentum: Array  # of the body after, kept or what is left of it
    period: Array
    kepler_period: Array
    shedding_period: Array
    centrifugal_radius: Array

    @property
    def moment_fall(self) -> Array:
        """I before over I after."""
        return self.moment_before / self.moment_after

    @property
    def angular_velocity(self) -> Array:
        """2 pi over the period."""
        return self.angular_momentum / self.moment_after

    @property
    def rotational_energy(self) -> Array:
        """L^2/(2 I) after."""
        return 0.5 * self.angular_momentum * self.angular_velocity

    @property
    def period_over_kepler(self) -> Array:
        """Period over that of an orbit at the equator of the sphere; below 1 nothing holds the equator."""
        return np.abs(self.period) / self.kepler_period

    @property
    def beyond_kepler(self) -> Array:
        """Whether the equator of the sphere would turn faster than an orbit there: no such body."""
        return np.abs(self.period) < self.kepler_period

    @property
    def sheds_mass(self) -> Array:
        """Whether the body turns faster than a centrally condensed one can before its swollen equator is torn off."""
        return np.abs(self.period) < self.shedding_period


@with_quantities()
def spin_up(
    moment_ratio_before: Array,
    mass_before: Array,
    radius_before: Array,
    period_before: Array,
    moment_ratio_after: Array,
    mass_after: Array,
    radius_after: Array,
    angular_momentum_share: Array = 1.0,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> SpinUp:
    """Return the body after, with a share of the angular momentum (all of it unless said otherwise).

    moment_ratio is I/(M R^2) about the axis. A period of infinity is a body at rest. centrifugal_radius is the size at
    which a body of the later mass and moment ratio would turn as fast as an orbit at its equator: it cannot become
    smaller. ValueError for sizes that are not positive. Source: conservation of L = I omega.

    >>> star = spin_up(0.0754, 2.8e30, 1.5e6, 30.0, 0.35, 2.8e30, 1.2e4)  # an iron core, and its neutron star
    >>> print(f"{1e3 * star.period:.2f} ms")
    8.91 ms
    """
    require_positive(moment_ratio_before=moment_ratio_before, mass_before=mass_before, radius_before=radius_before)
    require_positive(moment_ratio_after=moment_ratio_after, mass_after=mass_after, radius_after=radius_after)
    period = np.asarray(period_before, dtype=float)
    if np.any(period == 0) or np.any(np.isnan(period)):
        raise ValueError("a period is not 0; it is infinite for a body at rest")
    before = moment_of_inertia(moment_ratio_before, mass_before, radius_before)
    after = moment_of_inertia(moment_ratio_after, mass_after, radius_after)
    kept = np.asarray(angular_momentum_share, dtype=float) * before * (2 * math.pi / period)
    with np.errstate(divide="ignore"):
        later = np.where(kept != 0, 2 * math.pi * after / np.where(kept != 0, kept, 1.0), math.inf)
    return SpinUp(
        before,
        after,
        kept,
        later,
        kepler_period(mass_after, radius_after, gravitational_constant),
        roche_shedding_period(mass_after, radius_after, gravitational_constant),
        centrifugal_radius(kept / (moment_ratio_after * mass_after), mass_after, gravitational_constant),
    )


@with_quantities()
def moment_of_inertia(moment_ratio: Array, mass: Array, radius: Array) -> Array:
    """k M R^2.

    >>> print(f"{moment_of_inertia(0.3307, 5.972e24, 6.371e6):.2e} kg m2")  # of the Earth
    8.02e+37 kg m2
    """
    return np.asarray(moment_ratio, dtype=float) * mass * np.asarray(radius, dtype=float) ** 2


@with_quantities()
def centrifugal_radius(
    specific_angular_momentum: Array, mass: Array, gravitational_constant: float = GRAVITATIONAL_CONSTANT
) -> Array:
    """j^2/(G M): the orbit, around the mass M, that matter of specific angular momentum j comes to rest in.

    With j = L/(k M) of a whole body it is the radius at which that body turns as fast as an orbit at its equator.
    ValueError for a negative mass. Source: the balance of centrifugal force and gravity, Omega^2 R^3 = G M with
    Omega R^2 = j.

    >>> print(f"{centrifugal_radius(4e15, 1.989e30) / 1.495979e11:.2f} au")  # j^2 / (G M)
    0.81 au
    """
    refuse_negative(mass=mass, gravitational_constant=gravitational_constant)
    return np.asarray(specific_angular_momentum, dtype=float) ** 2 / (gravitational_constant * np.asarray(mass))


@with_quantities()
def radius_of_period(moment_ratio: Array, mass: Array, angular_momentum: Array, period: Array) -> Array:
    """The radius at which a body of that angular momentum has a period: where its P(R) curve crosses a line.

    ValueError for a negative moment ratio or mass.

    >>> print(f"{radius_of_period(0.4, 1.0, 0.4 * 2 * np.pi, 1.0):.4f}")  # L = 2 pi k M R^2 / P
    1.0000
    """
    refuse_negative(moment_ratio=moment_ratio, mass=mass)
    turned = np.abs(np.asarray(angular_momentum, dtype=float) * period)
    return np.sqrt(turned / (2 * math.pi * np.asarray(moment_ratio) * mass))
