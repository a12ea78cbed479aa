"""How fast a body can turn: orbits at its equator, mass shedding, and the bars that T/|W| allows to grow.

A rigid body is torn at its swollen equator before the sphere it was at rest would be. How much before depends on its
structure: Roche's model, a point mass in a weightless envelope, reaches (2/3)^(3/2) = 0.544 of the orbital rate of the
sphere, polytropes 0.565, 0.550, 0.529 and 0.454 for n = 0.5, 1, 1.5 and 2.5 (`polytropic_limit`, from exact figures),
relativistic stars 0.57 to 0.63 by published fits (bodies.neutron_star_fits). Any consistent units with the G given.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from astroinertia.bodies.bar_limits import DYNAMICAL, SECULAR
from astroinertia.bodies.neutron_star_fits import KEPLER_FACTORS, kepler_period
from astroinertia.bodies.polytrope import lane_emden, polytrope_radius
from astroinertia.bodies.rotating_star import RotatingStar, end_of_sequence, rotating_star, rotating_star_with
from astroinertia.errors import NumericalError
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS

Array = Any

_KEPLER_KHZ = math.sqrt(GRAVITATIONAL_CONSTANT * SOLAR_MASS / 1e4**3) / (2e3 * math.pi)  # of 1 Msun and 10 km


@dataclass(frozen=True)
class BreakUp:
    """How near a turning sphere is to its limits; arrays where its arguments were."""

    kepler_period: Array
    shedding_period: Array
    kepler_fraction: Array  # rate over that of an orbit at the equator of the sphere
    rotational_to_gravitational: Array  # T/|W|, NaN where W was not given

    @property
    def beyond_kepler(self) -> Array:
        """Whether it turns faster than an orbit at the equator of the sphere: no such body."""
        return np.asarray(self.kepler_fraction) > 1

    @property
    def sheds_mass(self) -> Array:
        """Whether it turns faster than the limit of mass shedding that was chosen."""
        return np.asarray(self.kepler_fraction) > np.asarray(self.kepler_period) / self.shedding_period

    @property
    def secularly_unstable(self) -> Array:
        """Whether friction or gravitational waves can make a bar of it."""
        return np.asarray(self.rotational_to_gravitational) > SECULAR

    @property
    def dynamically_unstable(self) -> Array:
        """Whether it turns into a bar within a few rotations."""
        return np.asarray(self.rotational_to_gravitational) > DYNAMICAL


@with_quantities()
def break_up(
    mass: Array,
    radius: Array,
    period: Array,
    moment_of_inertia: Array | None = None,
    gravitational_energy: Array | None = None,
    shedding: str = "roche",
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> BreakUp:
    """Return the limits of a body of given mass, radius at rest and period (infinite at rest).

    T/|W| needs the moment of inertia and W. shedding: a name that `shedding_share` knows. ValueError for another.

    >>> limits = break_up(2.8e30, 1.2e4, 1e-3)  # a neutron star that turns in a millisecond
    >>> print(f"{1e3 * limits.kepler_period:.3f} ms, {limits.kepler_fraction:.2f}")
    0.604 ms, 0.60
    """
    orbit = kepler_period(mass, radius, gravitational_constant)
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = np.abs(orbit / np.asarray(period, dtype=float))
        if moment_of_inertia is None or gravitational_energy is None:
            ratio = np.full_like(fraction, math.nan)
        else:
            energy = 0.5 * np.asarray(moment_of_inertia) * (2 * math.pi / np.asarray(period, dtype=float)) ** 2
            ratio = energy / np.abs(gravitational_energy)
    return BreakUp(orbit, orbit / shedding_share(shedding), fraction, ratio)


@with_quantities()
def orbit_at_equator(
    mass: Array, equatorial_radius: Array, j2: Array = 0.0, gravitational_constant: float = GRAVITATIONAL_CONSTANT
) -> Array:
    """Return the rate in rad/s of a circular orbit at the equator a of an oblate body, n^2 = G M/a^3 (1 + 3/2 J2).

    J2 refers to that radius; harmonics beyond it are left out. Source: Murray & Dermott 1999, section 6.11.

    >>> print(f"{orbit_at_equator(5.972e24, 6.378e6, 1.0826e-3):.4e}")  # of the Earth
    1.2405e-03
    """
    radius = np.asarray(equatorial_radius, dtype=float)
    return np.sqrt(gravitational_constant * mass / radius**3 * (1 + 1.5 * np.asarray(j2)))


@with_quantities()
def shedding_share(source: str = "roche") -> float:
    """Rate of mass shedding over that of an orbit at the equator of the sphere at rest.

    source: "roche" (a point mass in a weightless envelope, Newtonian), a name of neutron_star_fits.KEPLER_FACTORS
    (relativistic stars), or "polytrope n" with an index below 3. ValueError for another.

    >>> print(f"{shedding_share():.4f}")  # (2/3)^(3/2) of the orbital rate, after Roche
    0.5443
    """
    if source == "roche":
        return (2 / 3) ** 1.5
    if source in KEPLER_FACTORS:
        return KEPLER_FACTORS[source] / _KEPLER_KHZ
    kind, _, index = source.partition(" ")
    try:
        number = float(index)
    except ValueError:
        number = None
    if kind == "polytrope" and number is not None:
        return polytropic_limit(number).rate
    raise ValueError(
        f"there is no limit of rotation {source!r}; there are roche, polytrope with an index, "
        f"{', '.join(KEPLER_FACTORS)}"
    )


@dataclass(frozen=True)
class PolytropicLimit:
    """The fastest rigid polytrope, against the same mass and constant at rest with radius R.

    rate: Omega/(G M/R^3)^(1/2); angular_momentum: L/(G M^3 R)^(1/2); swelling: equatorial radius over R;
    moment_growth: I over that at rest; rotational_to_gravitational: T/|W|.
    """

    index: float
    rate: float
    angular_momentum: float
    swelling: float
    moment_growth: float
    rotational_to_gravitational: float


@with_quantities()
def polytropic_limit(index: float) -> PolytropicLimit:
    """Return where rigid polytropes of an index shed mass; ValueError unless 0 < n < 3.

    From exact figures (bodies.rotating_star), followed at one mass and one constant K, as a body is that has been spun
    up; at n = 3 the radius at rest is not defined. Stiff bodies meet bars before: T/|W| is 0.18 at n = 0.5.
    """
    return _polytropic_limit(float(index))


@lru_cache(maxsize=32)
def _polytropic_limit(index: float) -> PolytropicLimit:
    _check(index)
    star = end_of_sequence(polytropic_matter(index))
    at_rest = _radius_at_rest(star, index)
    rest_moment = lane_emden(index).moment_ratio * at_rest**2
    return PolytropicLimit(
        index=index,
        rate=star.angular_velocity * at_rest**1.5,
        angular_momentum=star.angular_momentum / math.sqrt(at_rest),
        swelling=1 / at_rest,
        moment_growth=star.polar_moment / rest_moment,
        rotational_to_gravitational=star.rotational_to_gravitational,
    )


@with_quantities()
@lru_cache(maxsize=32)
def polytropic_rate(index: float, fraction: float) -> float:
    """Return Omega/(G M/R^3)^(1/2) of the rigid polytrope whose equator turns at a fraction of an orbit there.

    R is its radius at rest, with the same mass and constant K. ValueError unless 0 < n < 3 and 0 <= fraction < 1.

    >>> print(f"{polytropic_rate(1.5, 0.8):.4f} {polytropic_limit(1.5).rate:.4f}")  # it swells on the way
    0.5170 0.5287
    """
    _check(index)
    star = rotating_star_with("breakup_fraction", fraction, polytropic_matter(index))
    return star.angular_velocity * _radius_at_rest(star, index) ** 1.5


@with_quantities()
def spun_up_polytrope(
    index: float,
    mass: float,
    radius_at_rest: float,
    angular_momentum: float,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> RotatingStar:
    """Return the rigid polytrope that a body of given mass and radius at rest becomes with an angular momentum.

    It keeps its mass and its constant K; it swells, so that it turns more slowly than L over the moment at rest says.
    ValueError unless 0 < n < 3; NumericalError where it sheds mass before it holds so much.
    Source: Hachisu 1986, ApJS 61, 479 (the figures).
    """
    _check(index)
    wanted = abs(angular_momentum) / math.sqrt(gravitational_constant * mass**3 * radius_at_rest)
    most = polytropic_limit(float(index))
    if not wanted < most.angular_momentum:
        described = f"{wanted:.6g} (G M^3 R)^(1/2), and sheds mass at {most.angular_momentum:.6g}"
        raise NumericalError(f"a polytrope of index {index:g} cannot hold an angular momentum of {described}")
    matter = polytropic_matter(index)

    def excess(ratio: float) -> float:
        star = rotating_star(matter, ratio)
        return star.angular_momentum / math.sqrt(_radius_at_rest(star, index)) - wanted

    flattest = end_of_sequence(matter).field.axis_ratio
    ratio = 1.0 if wanted == 0 else root_between(excess, flattest, 1.0, 1e-13, 1e-12)
    equator = radius_at_rest / _radius_at_rest(rotating_star(matter, ratio), index)
    return rotating_star(matter, ratio, mass=mass, equatorial_radius=equator,
                         gravitational_constant=gravitational_constant)  # fmt: skip


def _radius_at_rest(star: RotatingStar, index: float) -> float:
    # Of the polytrope with the star's mass and K, in its unit M = R_equator = G = 1.
    constant = star.max_pressure / star.max_density ** (1 + 1 / index)
    return polytrope_radius(index, 1.0, constant)


def _check(index: float) -> None:
    if not 0 < index < 3:
        raise ValueError(f"the radius at rest that belongs to a spun-up polytrope needs 0 < n < 3, not {index}")
