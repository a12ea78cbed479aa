"""Precession and nutation from the integrated motion of rigid planets under Sun, Moon and planets on their orbits."""

from astroinertia.rotation.precession import ARCSECOND, ARCSECOND_PER_YEAR
from astroinertia.studies.precession import precession
from astroinertia.verify.comparison import Quantities

_EARTH_YEARS, _MARS_YEARS, _STEPS = 18.7, 10.0, 2  # one turn of the Moon's node; five years of Mars; steps a day


def earth() -> Quantities:
    """Rate on the ecliptic of J2000 with what a rigid quadrupole lacks added by name, and the 18.6-year nutation."""
    motion = precession("Earth", _EARTH_YEARS, _STEPS)
    return {
        "integrated_luni_solar": float(motion["corrected_rate"]) / ARCSECOND_PER_YEAR,
        "integrated_longitude": float(motion["nutation_longitude"]) / ARCSECOND,
        "integrated_obliquity": float(motion["nutation_obliquity"]) / ARCSECOND,
    }


def mars() -> Quantities:
    """C/(M a^2) that the published rate asks for."""
    return {"integrated_mars_ratio": float(precession("Mars", _MARS_YEARS, _STEPS)["polar_moment_ratio"])}


COMPUTATIONS = (earth, mars)
