"""How fast torques, relativity and moving orbits turn the axis of a spinning body: rates to first order, closed forms.

An axis s of dynamical ellipticity H = (C - A)/C and spin omega, under a point mass of gravitational parameter GM:

    ds/dt = -alpha (s.n) (n x s),    alpha = (3/2) (H/omega) GM / (a^3 (1 - e^2)^(3/2)),

averaged over an orbit of normal n. Rates are positive where the axis goes round against the orbital motion (a
regression, as that of the equinoxes). SI, or any consistent units; angles and rates in radians; numbers or arrays.
The integrated motion, without any of these averages, is in studies.precession.
Sources: Murray & Dermott 1999, Solar System Dynamics, chapters 5 to 7; Kinoshita 1977, Celest. Mech. 15, 277.
"""

from typing import Any, NamedTuple

import numpy as np

from astroinertia.bodies.planets import body
from astroinertia.process.positive import refuse_negative
from astroinertia.process.quantities import with_quantities
from astroinertia.units import SPEED_OF_LIGHT

Array = Any

JULIAN_YEAR = 31557600.0  # s
ARCSECOND = np.pi / 648000.0  # rad
ARCSECOND_PER_YEAR = ARCSECOND / JULIAN_YEAR  # rad s-1
# Mean orbits of Sun and Moon about the Earth: Simon et al. 1994, A&A 282, 663; the Moon's semi-major axis as in the
# NSSDCA Moon Fact Sheet, to the kilometre.
SUN_SEMI_MAJOR_AXIS, SUN_ECCENTRICITY = 1.000001018 * 149597870700.0, 0.0167086342
MOON_SEMI_MAJOR_AXIS, MOON_ECCENTRICITY, MOON_INCLINATION = 384399e3, 0.0549006, np.radians(5.1453964)
MOON_NODE_RATE = np.radians(-1934.1362608) / (100 * JULIAN_YEAR)  # rad s-1, from the equinox of date; the same


class LuniSolar(NamedTuple):
    """Precession of the Earth's equator to first order, rad s-1, and the nutation of the Moon's node, rad.

    solar, lunar and total: rates along the ecliptic; nutation_longitude and nutation_obliquity: amplitudes of the
    18.6-year term, longitude -sin(node), obliquity cos(node); period: 2 pi/total in seconds.
    """

    solar: float
    lunar: float
    total: float
    period: float
    nutation_longitude: float
    nutation_obliquity: float


@with_quantities()
def precession_constant(
    dynamical_ellipticity: Array, spin_rate: Array, gravitational_parameter: Array, semi_major_axis: Array,
    eccentricity: Array = 0.0,
) -> Array:  # fmt: skip
    """alpha = (3/2) (H/omega) GM/(a^3 (1 - e^2)^(3/2)), the rate at vanishing obliquity, rad s-1.

    GM is the perturber's (m3 s-2), the orbit that of the perturber as seen from the body (m). ValueError for an orbit
    that is no ellipse, and for a spin of 0, without which the rate has no bound. Source: Goldreich 1966, Rev. Geophys.
    4, 411.

    >>> alpha = precession_constant(1 / 305.5, 7.292115e-5, 1.32712e20, 1.495979e11)
    >>> print(f"{np.degrees(alpha) * 3600 * 3.15576e7:.1f}")  # arcsec a year, of the Earth by the Sun
    17.4
    """
    strength = _mean_tide(gravitational_parameter, semi_major_axis, eccentricity)
    _require_turning(spin_rate=spin_rate)
    return 1.5 * np.asarray(dynamical_ellipticity) / np.asarray(spin_rate) * strength


@with_quantities()
def precession_rate(
    dynamical_ellipticity: Array, spin_rate: Array, obliquity: Array, gravitational_parameter: Array,
    semi_major_axis: Array, eccentricity: Array = 0.0, inclination: Array = 0.0,
) -> Array:  # fmt: skip
    """The mean rate about a pole from which the orbit is inclined and about which its node runs fast, rad s-1.

    alpha cos(obliquity) (1 - (3/2) sin^2 i), obliquity to that pole; inclination 0 where the orbit stays where it is.
    Source: Kinoshita 1977.

    >>> rate = precession_rate(1 / 305.5, 7.292115e-5, np.radians(23.44), 1.32712e20, 1.495979e11)
    >>> print(f"{np.degrees(rate) * 3600 * 3.15576e7:.1f}")  # arcsec a year
    15.9
    """
    alpha = precession_constant(
        dynamical_ellipticity, spin_rate, gravitational_parameter, semi_major_axis, eccentricity
    )
    return alpha * np.cos(obliquity) * (1 - 1.5 * np.sin(inclination) ** 2)


@with_quantities()
def node_nutation(
    dynamical_ellipticity: Array, spin_rate: Array, obliquity: Array, gravitational_parameter: Array,
    semi_major_axis: Array, eccentricity: Array, inclination: Array, node_rate: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Amplitudes (longitude, obliquity) in rad of the nutation with the node of an inclined orbit, to first order.

    The axis moves by -longitude sin(node) along the plane and by +obliquity cos(node) in obliquity where node_rate
    (rad s-1) is negative, as the Moon's. ValueError for a node or a spin that does not turn. Source: Woolard 1953;
    Kinoshita 1977, (2 sin i cos i terms). Checked by tests/unit/rotation/test_precession.py and against the integrated
    motion by tests/physics/test_precession.py.

    >>> month, turn = (4.9028e12, 3.844e8, 0.055, np.radians(5.145)), -1.07e-8  # orbit of the Moon, rate of its node
    >>> obliquity = node_nutation(1 / 305.5, 7.292115e-5, np.radians(23.44), *month, turn)[1]
    >>> print(f"{np.degrees(obliquity) * 3600:.1f}")  # arcsec; the IAU has 9.2
    9.2
    """
    alpha = precession_constant(
        dynamical_ellipticity, spin_rate, gravitational_parameter, semi_major_axis, eccentricity
    )
    _require_turning(node_rate=node_rate)
    size = alpha * np.sin(inclination) * np.cos(inclination) / -np.asarray(node_rate)
    return size * np.cos(2 * np.asarray(obliquity)) / np.sin(obliquity), size * np.cos(obliquity)


@with_quantities()
def luni_solar_precession(
    dynamical_ellipticity: float | None = None, spin_rate: float | None = None, obliquity: float | None = None,
) -> LuniSolar:  # fmt: skip
    """The Earth's luni-solar precession and 18.6-year nutation by the formulae, on mean orbits of Sun and Moon.

    Unless given, H, spin (rad s-1) and obliquity (rad) are those of `bodies.planets`. Within 0.04 % of the IAU 2006
    rate, 5038.481507 arcsec a century and 1.92 of relativity.

    >>> print(f"{np.degrees(luni_solar_precession().total) * 3600 * 3.15576e7:.1f}")  # arcsec a year; the IAU has 50.4
    50.4
    """
    earth, sun, moon = body("Earth"), body("Sun"), body("Moon")
    ellipticity = earth.value("dynamical_ellipticity") if dynamical_ellipticity is None else dynamical_ellipticity
    spin = earth.angular_velocity if spin_rate is None else spin_rate
    tilt = earth.value("obliquity") if obliquity is None else obliquity
    solar_orbit = (sun.gravitational_parameter, SUN_SEMI_MAJOR_AXIS, SUN_ECCENTRICITY)
    lunar_orbit = (moon.gravitational_parameter, MOON_SEMI_MAJOR_AXIS, MOON_ECCENTRICITY, MOON_INCLINATION)
    solar = float(precession_rate(ellipticity, spin, tilt, *solar_orbit))
    lunar = float(precession_rate(ellipticity, spin, tilt, *lunar_orbit))
    longitude, oblique = node_nutation(ellipticity, spin, tilt, *lunar_orbit, MOON_NODE_RATE)
    total = solar + lunar
    return LuniSolar(solar, lunar, total, 2 * np.pi / total, float(longitude), float(oblique))


@with_quantities()
def geodesic_precession(
    gravitational_parameter: Array, semi_major_axis: Array, eccentricity: Array = 0.0,
    speed_of_light: float = SPEED_OF_LIGHT,
) -> Array:  # fmt: skip
    """The rate at which a spin in orbit turns with the orbital motion, (3/2) n^3 a^2/(c^2 (1 - e^2)), rad s-1.

    It is about the orbit's normal and lowers a regression: 19.2 mas a year of the Earth's, 6.7 of that of Mars.
    n^2 a^3 = GM of the central mass. Source: de Sitter 1916; Barker & O'Connell 1975, Phys. Rev. D 12, 329.

    >>> rate = geodesic_precession(1.32712e20, 1.495979e11)
    >>> print(f"{np.degrees(rate) * 3600e3 * 3.15576e7:.1f}")  # mas a year, of the Earth
    19.2
    """
    refuse_negative(gravitational_parameter=gravitational_parameter)
    a = np.asarray(semi_major_axis, dtype=float)
    mean_motion = np.sqrt(np.asarray(gravitational_parameter) / a**3)
    require_ellipse(a, eccentricity)
    return 1.5 * mean_motion**3 * a**2 / (speed_of_light**2 * (1 - np.asarray(eccentricity) ** 2))


@with_quantities(companion_parameter="m3 s-2")
def geodetic_precession_of_binary(
    orbital_period: Array, gravitational_parameter: Array, companion_parameter: Array, eccentricity: Array = 0.0
) -> Array:
    """The rate at which the spin of one of two compact bodies precesses about the orbit's normal, rad s-1.

    (2 pi/P)^(5/3) m2 (4 m1 + 3 m2)/(2 M^(4/3)) (G/c^3)^(2/3)/(1 - e^2), of the body m1 (its GM is
    `gravitational_parameter`) and its companion m2; with m1 -> 0 it is `geodesic_precession`. Source: Barker &
    O'Connell 1975, Phys. Rev. D 12, 329, (54).

    >>> sun = 1.32712e20
    >>> rate = geodetic_precession_of_binary(8834.5, 1.249 * sun, 1.338 * sun, 0.0878)
    >>> print(f"{np.degrees(rate) * 3.15576e7:.2f}")  # degrees a year, of the double pulsar
    5.07
    """
    own, other = (np.asarray(parameter, dtype=float) for parameter in (gravitational_parameter, companion_parameter))
    n = 2 * np.pi / np.asarray(orbital_period)
    require_ellipse(1.0, eccentricity)
    shape = other * (4 * own + 3 * other) / (2 * (own + other) ** (4 / 3))
    return n ** (5 / 3) * shape / (SPEED_OF_LIGHT**2 * (1 - np.asarray(eccentricity) ** 2))


@with_quantities(luni_solar_rate="rad/s", pole_rate="rad/s")
def general_precession(luni_solar_rate: Array, obliquity: Array, pole_rate: Array) -> Array:
    """The rate of the equinox along the moving ecliptic, rad s-1: psi - chi cos(obliquity), chi = P/sin(obliquity).

    luni_solar_rate: psi, of the equator on the fixed ecliptic; pole_rate: P = d(sin pi sin Pi)/dt, of the ecliptic's
    pole towards the equinox. Source: Lieske et al. 1977, A&A 58, 1; Capitaine, Wallace & Chapront 2003, A&A 412, 567.

    >>> print(general_precession(50.385, np.pi / 2, 0.0))  # the ecliptic at rest
    50.385
    """
    return np.asarray(luni_solar_rate) - np.asarray(pole_rate) * np.cos(obliquity) / np.sin(obliquity)


@with_quantities()
def rate_from_moment_ratio(
    moment_ratio: Array, j2: Array, spin_rate: Array, obliquity: Array, gravitational_parameter: Array,
    semi_major_axis: Array, eccentricity: Array = 0.0,
) -> Array:  # fmt: skip
    """The precession rate of a planet with C/(M a^2) and J2 of one reference radius, from H = J2/(C/(M a^2)), rad s-1.

    Source: Folkner et al. 1997, Science 278, 1749.

    >>> mars = 1.9566e-3, 7.0882e-5, np.radians(25.19), 1.32712e20, 2.2794e11, 0.0934
    >>> rate = rate_from_moment_ratio(0.3642, *mars)
    >>> print(f"{np.degrees(rate) * 3600 * 3.15576e7:.2f}")  # arcsec a year, which InSight measured: 7.6
    7.60
    """
    ellipticity = np.asarray(j2) / np.asarray(moment_ratio)
    return precession_rate(ellipticity, spin_rate, obliquity, gravitational_parameter, semi_major_axis, eccentricity)


@with_quantities(rate="rad/s")
def moment_ratio_from_rate(
    rate: Array, j2: Array, spin_rate: Array, obliquity: Array, gravitational_parameter: Array, semi_major_axis: Array,
    eccentricity: Array = 0.0,
) -> Array:  # fmt: skip
    """C/(M a^2), for the radius of J2, of a planet whose axis precesses at this rate under its torque alone.

    What is not of that torque (relativity, moons, planets) is taken out of the rate beforehand. ValueError for a rate
    of zero. Source and check: as for `rate_from_moment_ratio`, whose inverse it is.

    >>> mars = 1.9566e-3, 7.0882e-5, np.radians(25.19), 1.32712e20, 2.2794e11, 0.0934
    >>> print(f"{moment_ratio_from_rate(rate_from_moment_ratio(0.3642, *mars), *mars):.4f}")  # the inverse
    0.3642
    """
    if np.any(np.asarray(rate) == 0):
        raise ValueError("an axis that does not precess says nothing of C/(M a^2)")
    unit = rate_from_moment_ratio(1.0, j2, spin_rate, obliquity, gravitational_parameter, semi_major_axis, eccentricity)
    return unit / np.asarray(rate)


@with_quantities(parameter="m3 s-2", moon_parameters="m3 s-2", moon_axes="m")
def moons_of_the_equator(
    parameter: float, radius: float, spin_rate: float, moon_parameters: Array, moon_axes: Array
) -> tuple[float, float]:
    """What moons that their planet's flattening holds to its equator add to J2 and to C/(M a^2), as two numbers.

    Sum of (1/2) (m/M) (a/R)^2, and of (m/M) (a/R)^2 n/omega: planet and moons precess as one, at the rate of
    H = (J2 + first)/(C/(M R^2) + second). parameter: GM of the planet, radius R that of J2; moon_parameters and
    moon_axes (N,): GM and semi-major axes of moons well within the Laplace radius. ValueError for axes that are not
    above 0, and for a spin of 0. Source: Goldreich 1966, Rev. Geophys. 4, 411; Ward & Hamilton 2004, AJ 128, 2501, (2).

    >>> shares = moons_of_the_equator(1.267e17, 7.15e7, 1.7585e-4, np.array([9.89e12]), np.array([1.0704e9]))
    >>> print([f"{share:.1e}" for share in shares])  # of Jupiter, by Ganymede
    ['8.7e-03', '1.0e-03']
    """
    masses, axes = np.asarray(moon_parameters, dtype=float), np.asarray(moon_axes, dtype=float)
    require_ellipse(axes, 0.0)
    _require_turning(spin_rate=spin_rate)
    shares = masses / parameter * (axes / radius) ** 2
    motions = np.sqrt((parameter + masses) / axes**3)
    return float(0.5 * shares.sum()), float((shares * motions).sum() / spin_rate)


@with_quantities()
def rotational_j2(love_number: Array, spin_rate: Array, radius: Array, gravitational_parameter: Array) -> Array:
    """J2 that its spin gives a star or a fluid planet, (k2/3) omega^2 R^3/(GM), to first order in the flattening.

    k2 is twice the apsidal constant (`bodies.apsidal`, `bodies.clairaut`): 0.029 for n = 3. So a Be star turns the
    pericentres of its disc and of companions by `apsidal_precession`. Source: Sterne 1939, MNRAS 99, 451.

    >>> print(f"{rotational_j2(0.9, 7.292e-5, 6.371e6, 3.986e14):.2e}")  # of a fluid Earth
    1.03e-03
    """
    rate, radius = np.asarray(spin_rate, dtype=float), np.asarray(radius, dtype=float)
    return np.asarray(love_number) / 3 * rate**2 * radius**3 / gravitational_parameter


@with_quantities()
def nodal_precession(
    j2: Array, radius: Array, gravitational_parameter: Array, semi_major_axis: Array, eccentricity: Array = 0.0,
    inclination: Array = 0.0,
) -> Array:  # fmt: skip
    """The rate of the node on the equator, -(3/2) J2 (R/a)^2 n cos i/(1 - e^2)^2, rad s-1: negative for cos i > 0.

    radius R is that of J2, inclination to the equator. Source: Kozai 1959, AJ 64, 367; Murray & Dermott 1999, (6.250).
    Checked by tests/unit/rotation/test_precession.py and against REBOUND by tests/physics/test_precession.py.

    >>> rate = nodal_precession(1.0826e-3, 6.378e6, 3.986e14, 7.078e6, 0.0, np.radians(98.2))
    >>> print(f"{np.degrees(rate) * 86400:.2f}")  # degrees a day: it keeps pace with the Sun
    0.99
    """
    return -1.5 * _oblateness(j2, radius, gravitational_parameter, semi_major_axis, eccentricity) * np.cos(inclination)


@with_quantities()
def apsidal_precession(
    j2: Array, radius: Array, gravitational_parameter: Array, semi_major_axis: Array, eccentricity: Array = 0.0,
    inclination: Array = 0.0,
) -> Array:  # fmt: skip
    """The rate of the pericentre from the node, (3/4) J2 (R/a)^2 n (5 cos^2 i - 1)/(1 - e^2)^2, rad s-1.

    Zero at 63.43 degrees. In the plane of the equator the longitude of the pericentre, this and the node's together,
    advances by (3/2) J2 (R/a)^2 n: the precession of an eccentric disc about a flattened Be star.
    Source: Kozai 1959, AJ 64, 367; Papaloizou, Savonije & Henrichs 1992, A&A 265, L45. Checked as `nodal_precession`.

    >>> print(abs(apsidal_precession(1e-3, 1.0, 1.0, 2.0, 0.1, np.arccos(5**-0.5))) < 1e-15)  # none at 63.43 degrees
    True
    """
    size = _oblateness(j2, radius, gravitational_parameter, semi_major_axis, eccentricity)
    return 0.75 * size * (5 * np.cos(inclination) ** 2 - 1)


@with_quantities()
def mutual_precession_rate(node_rate: Array, orbital_angular_momentum: Array, spin_angular_momentum: Array,
                           inclination: Array) -> Array:  # fmt: skip
    """The rate at which orbit and spin both go round their sum, rad s-1, where neither is much the larger.

    node_rate: of the orbit on the equator of a spin that stays; the rate is that times |J|/S, with inclination between
    the two. Source: Barker & O'Connell 1975; Damour & Schaefer 1988, Nuovo Cimento B 101, 127.

    >>> print(mutual_precession_rate(1.0, 1.0, 1e12, 0.3).round(9))  # a spin that stays
    1.0
    """
    orbit, spin = np.asarray(orbital_angular_momentum, dtype=float), np.asarray(spin_angular_momentum, dtype=float)
    # By the half of the angle, so that two that nearly cancel leave what they must.
    total = np.sqrt((orbit - spin) ** 2 + 4 * orbit * spin * np.cos(np.asarray(inclination) / 2) ** 2)
    return np.asarray(node_rate) * total / spin


def _mean_tide(gravitational_parameter: Array, semi_major_axis: Array, eccentricity: Array) -> Array:
    refuse_negative(gravitational_parameter=gravitational_parameter)
    a = np.asarray(semi_major_axis, dtype=float)
    require_ellipse(a, eccentricity)
    return np.asarray(gravitational_parameter) / (a**3 * (1 - np.asarray(eccentricity) ** 2) ** 1.5)


def _oblateness(j2: Array, radius: Array, parameter: Array, semi_major_axis: Array, eccentricity: Array) -> Array:
    refuse_negative(gravitational_parameter=parameter, radius=radius)
    a = np.asarray(semi_major_axis, dtype=float)
    require_ellipse(a, eccentricity)
    mean_motion = np.sqrt(np.asarray(parameter) / a**3)
    return np.asarray(j2) * (np.asarray(radius) / a) ** 2 * mean_motion / (1 - np.asarray(eccentricity) ** 2) ** 2


def _require_turning(**rates: Array) -> None:
    for name, rate in rates.items():
        if np.any(np.asarray(rate) == 0):
            raise ValueError(f"{name} must not be 0: without it these rates have no bound")


def require_ellipse(semi_major_axis: Array, eccentricity: Array) -> None:
    """ValueError unless these are of ellipses."""
    e = np.asarray(eccentricity, dtype=float)
    if not (np.all(np.asarray(semi_major_axis) > 0) and np.all((e >= 0) & (e < 1))):
        raise ValueError("an orbit is an ellipse: semi_major_axis above 0 and 0 <= eccentricity < 1")
