"""Precession, wobble and spin-orbit states, by the formulae, against what is measured and published."""

import numpy as np

from astroinertia.bodies.planets import body
from astroinertia.rotation import cassini, precession, spin_orbit, wobble
from astroinertia.rotation.precession import ARCSECOND, ARCSECOND_PER_YEAR, JULIAN_YEAR
from astroinertia.rotation.wobble import DAY
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, quantity
from astroinertia.verify.comparison import Quantities

_PLANETARY = 10.556403  # chi_A, arcsec a century: Capitaine, Wallace & Chapront 2003
_MARS_ORBIT = (1.523679342, 0.0934006)  # au, eccentricity: Simon et al. 1994
_MARS_TILT, _MARS_RATE = 25.1893823, 7.6083  # deg; arcsec a year: Konopliv et al. 2016
_MERCURY_ORBIT = (87.9693496, 325513.0, 8.6, 0.2056317)  # d, a of the node, deg, eccentricity: Margot et al. 2012
_MERCURY_FIGURE, _MERCURY_TILT = (5.031e-5, 0.809e-5), 2.04  # J2, C22; arc minutes: Margot et al. 2012
_MONTH = 27.321661  # d
_RIGID_NUTATION = 17.2806, 9.2278  # arc seconds: Souchay et al. 1999
_ELASTIC = 0.298  # k2: Smith & Dahlen 1981
_LAGEOS = (12270e3, 0.0045, 109.84)  # m, eccentricity, deg
_DOUBLE_PULSAR = (0.10225156248, 1.2489, 1.3381, 0.0877775)  # d, Msun, Msun, e: Kramer et al. 2006
_HULSE_TAYLOR = (0.322997448918, 1.4398, 1.3886, 0.617134)  # Weisberg, Nice & Taylor 2010


def earth() -> Quantities:
    """Luni-solar precession less relativity, the general one, and the nutation with the Moon's node."""
    luni_solar = precession.luni_solar_precession()
    geodesic = precession.geodesic_precession(
        body("Sun").gravitational_parameter, precession.SUN_SEMI_MAJOR_AXIS, precession.SUN_ECCENTRICITY
    )
    total, tilt = luni_solar.total - float(geodesic), body("Earth").value("obliquity")
    pole = _PLANETARY / 100 * ARCSECOND_PER_YEAR * np.sin(tilt)
    return {
        "luni_solar": total / ARCSECOND_PER_YEAR,
        "general": float(precession.general_precession(total, tilt, pole)) / ARCSECOND_PER_YEAR,
        "geodesic": 100 * float(geodesic) / ARCSECOND_PER_YEAR,
        "nutation_longitude": luni_solar.nutation_longitude / ARCSECOND,
        "nutation_obliquity": luni_solar.nutation_obliquity / ARCSECOND,
    }


def core_nutation() -> Quantities:
    """The same nutation, REN-2000's of a rigid Earth, of an Earth that yields and whose core is fluid."""
    planet = body("Earth")
    ellipticity, spin, j2 = planet.value("dynamical_ellipticity"), planet.angular_velocity, planet.adopted("j2")
    secular = wobble.secular_love_number(j2.value, planet.gravitational_parameter, j2.radius, spin)
    turning = np.array([precession.MOON_NODE_RATE, -precession.MOON_NODE_RATE])
    ratios = wobble.nutation_ratio(
        turning, ellipticity, spin, wobble.elastic_love_number(), secular, 1 - wobble.mantle_share()
    )
    sine, (longitude, obliquity) = np.sin(planet.value("obliquity")), _RIGID_NUTATION
    backward, forward = ratios * (obliquity + longitude * sine, obliquity - longitude * sine) / 2
    return {
        "core_nutation_longitude": float((backward - forward) / sine),
        "core_nutation_obliquity": float(backward + forward),
    }


def mars() -> Quantities:
    """C/(M a^2) from the measured rate, relativity put back."""
    axis, eccentricity = _MARS_ORBIT
    orbit = (body("Sun").gravitational_parameter, axis * quantity("1 au", "length"), eccentricity)
    rate = _MARS_RATE * ARCSECOND_PER_YEAR + precession.geodesic_precession(*orbit)
    planet = body("Mars")
    ratio = precession.moment_ratio_from_rate(
        rate, planet.value("j2"), planet.angular_velocity, np.radians(_MARS_TILT), *orbit
    )
    return {"mars_moment_ratio": float(ratio)}


def chandler() -> Quantities:
    """The Earth's free wobble: rigid, wholly elastic, with its core, and with oceans and anelasticity."""
    periods = {share.name: share.period / DAY for share in wobble.chandler_wobble(_ELASTIC).shares}
    return {
        "euler_period": periods["rigid"] * DAY * body("Earth").angular_velocity / (2 * np.pi),
        "elastic_period": periods["elasticity"],
        "core_period": periods["fluid core"],
        "chandler_period": wobble.chandler_wobble().period / DAY,
    }


def spin_states() -> Quantities:
    """Cassini states of the Moon and Mercury, Mercury's capture, and where Hyperion's resonances overlap."""
    moon, planet = body("Moon"), body("Earth")
    share = planet.gravitational_parameter / (planet.gravitational_parameter + moon.gravitational_parameter)
    tilt = cassini.resonant_obliquity(
        moon.moment_ratio("polar", moon.adopted("j2").radius).value, moon.value("j2"), moon.value("c22"),
        2 * np.pi / (_MONTH * DAY), precession.MOON_NODE_RATE, precession.MOON_INCLINATION,
        precession.MOON_ECCENTRICITY, 1.0, share,
    )  # fmt: skip
    period, node, inclination, eccentricity = _MERCURY_ORBIT
    ratio = cassini.moment_ratio_from_obliquity(
        -np.radians(_MERCURY_TILT / 60), *_MERCURY_FIGURE, 2 * np.pi / (period * DAY),
        -2 * np.pi / (node * JULIAN_YEAR), np.radians(inclination), eccentricity, 1.5,
    )  # fmt: skip
    return {
        "moon_obliquity": float(np.degrees(tilt - precession.MOON_INCLINATION)),
        "mercury_moment_ratio": float(ratio),
        "mercury_capture": float(spin_orbit.capture_probability(1.5, eccentricity, np.sqrt(3e-4))),
        "hyperion_overlap": float(spin_orbit.overlap_asphericity(0.1)),
    }


def orbits_and_pulsars() -> Quantities:
    """A satellite's node by J2, and the geodetic precession of binary pulsars."""
    planet, (axis, eccentricity, inclination) = body("Earth"), _LAGEOS
    j2 = planet.adopted("j2")
    node = precession.nodal_precession(
        j2.value, j2.radius, planet.gravitational_parameter, axis, eccentricity, np.radians(inclination)
    )
    return {
        "lageos_node": float(np.degrees(node)) * JULIAN_YEAR,
        "double_pulsar": _degrees_a_year(*_DOUBLE_PULSAR),
        "hulse_taylor": _degrees_a_year(*_HULSE_TAYLOR),
    }


def _degrees_a_year(period: float, own: float, other: float, eccentricity: float) -> float:
    unit = GRAVITATIONAL_CONSTANT * SOLAR_MASS
    rate = precession.geodetic_precession_of_binary(period * DAY, own * unit, other * unit, eccentricity)
    return float(np.degrees(rate)) * JULIAN_YEAR


COMPUTATIONS = (earth, core_nutation, mars, chandler, spin_states, orbits_and_pulsars)
