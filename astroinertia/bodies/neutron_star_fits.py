"""Published fits for neutron stars: moments of inertia by compactness, I-Love-Q, and the limit of rotation.

Each fit refuses arguments outside the stars that it was made from, unless check_range is False: beyond them some of
them fail badly (I/M^3 of Breu & Rezzolla is negative below C = 0.016). Compactness is C = G M/(R c^2) with R the areal
radius of the non-rotating star; arguments are floats or arrays.
"""

import math

import numpy as np

from astroinertia.matter.compact_stars import SOLAR_LENGTH
from astroinertia.process.positive import refuse_negative, require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT

# Neutron stars of realistic equations of state, taken here as the range of the fits by compactness.
LATTIMER_SCHUTZ_RANGE = (0.07 * SOLAR_LENGTH / 1e3, 0.32)  # from 0.07 Msun/km
BREU_REZZOLLA_RANGE = (0.07, 0.32)
LOVE_RANGE = (1.0, 2e4)  # the neutron stars of Yagi & Yunes 2013
QUADRUPOLE_BAR_RANGE = (1.0, 20.0)

_LATTIMER_SCHUTZ = (0.237, 4.2, 90.0)  # I/(M R^2) = a (1 + b x + c x^4), x = (M/Msun)(km/R); a to 0.008
_BREU_REZZOLLA_RATIO = (0.244, 0.638, 3.202)  # I/(M R^2) = a + b C + c C^4
_BREU_REZZOLLA_BAR = (8.134e-1, 2.101e-1, 3.175e-3, -2.717e-4)  # I/M^3 = sum a_i C^-i
_YAGI_YUNES = {  # ln y = sum a_i (ln x)^i
    "moment_bar of tidal_deformability": (1.47, 0.0817, 0.0149, 2.87e-4, -3.64e-5),
    "moment_bar of quadrupole_bar": (1.35, 0.697, -0.143, 9.94e-2, -1.24e-2),
    "quadrupole_bar of tidal_deformability": (0.194, 0.0936, 0.0474, -4.21e-3, 1.23e-4),
}

# f = factor sqrt(M/Msun) (10 km/R)^(3/2) kHz with M and R of the non-rotating star
KEPLER_FACTORS = {
    "lattimer_prakash_2004": 1.045,  # Science 304, 536
    "haensel_2009": 1.08,  # A&A 502, 605: hadronic stars of 0.5 Msun to 0.9 of the maximum mass, to a few per cent
    "haensel_2009_strange": 1.15,  # the same for strange stars with the heaviest crust
    "relativistic_roche": 1.00,  # the same paper: matter without weight around a point mass
}


def _within(name: str, value, bounds: tuple[float, float], check_range: bool) -> np.ndarray:
    value = np.asarray(value, dtype=float)
    require_positive(**{name: value})
    if check_range and not np.all((value >= bounds[0]) & (value <= bounds[1])):
        raise ValueError(
            f"the fit was made for {name} from {bounds[0]:.3g} to {bounds[1]:.3g}, not {value}; "
            "check_range=False evaluates it all the same"
        )
    return value


@with_quantities(mass="Msun", radius_km="km")
def lattimer_schutz(mass, radius_km, check_range: bool = True) -> np.ndarray:
    """I/(M R^2) of a neutron star of `mass` (solar masses) and `radius_km`, to about 3%.

    Source: Lattimer & Schutz 2005, ApJ 629, 979, Eq. (16), for equations of state with a maximum mass above 1.6 Msun.
    ValueError outside LATTIMER_SCHUTZ_RANGE of compactness.

    >>> print(f"{lattimer_schutz(1.4, 12.0):.3f}")  # I/(M R^2)
    0.357
    """
    x = np.asarray(mass, dtype=float) / np.asarray(radius_km, dtype=float)
    _within("compactness", x * SOLAR_LENGTH / 1e3, LATTIMER_SCHUTZ_RANGE, check_range)
    a, b, c = _LATTIMER_SCHUTZ
    return a * (1 + b * x + c * x**4)


@with_quantities()
def breu_rezzolla_moment_ratio(compactness, check_range: bool = True) -> np.ndarray:
    """I/(M R^2) by C: Breu & Rezzolla 2016, MNRAS 459, 646, for slow rotation; ValueError outside their range.

    >>> print(f"{breu_rezzolla_moment_ratio(0.172):.3f}")  # of 1.4 solar masses and 12 km
    0.357
    """
    C = _within("compactness", compactness, BREU_REZZOLLA_RANGE, check_range)
    a, b, c = _BREU_REZZOLLA_RATIO
    return a + b * C + c * C**4


@with_quantities()
def breu_rezzolla_moment_bar(compactness, check_range: bool = True) -> np.ndarray:
    """I/M^3 (G = c = 1) by C: Breu & Rezzolla 2016, MNRAS 459, 646, Eq. (20); ValueError outside their range.

    >>> print(f"{breu_rezzolla_moment_bar(0.172):.1f}")
    12.1
    """
    C = _within("compactness", compactness, BREU_REZZOLLA_RANGE, check_range)
    return sum((a / C ** (i + 1) for i, a in enumerate(_BREU_REZZOLLA_BAR)), start=np.zeros_like(C))


def _yagi_yunes(name: str, x: np.ndarray) -> np.ndarray:
    return np.exp(np.polynomial.polynomial.polyval(np.log(x), _YAGI_YUNES[name]))


@with_quantities()
def moment_bar_of_love(tidal_deformability, check_range: bool = True) -> np.ndarray:
    """I/M^3 by Lambda, to 1%: Yagi & Yunes 2013, PRD 88, 023009, Table I; ValueError outside LOVE_RANGE.

    >>> print(f"{moment_bar_of_love(300.0):.1f}")  # I-Love
    11.4
    """
    x = _within("tidal_deformability", tidal_deformability, LOVE_RANGE, check_range)
    return _yagi_yunes("moment_bar of tidal_deformability", x)


@with_quantities()
def moment_bar_of_quadrupole(quadrupole_bar, check_range: bool = True) -> np.ndarray:
    """I/M^3 by Q M/J^2, to 1%: Yagi & Yunes 2013, Table I; ValueError outside QUADRUPOLE_BAR_RANGE.

    >>> print(f"{moment_bar_of_quadrupole(5.0):.1f}")  # I-Q
    11.4
    """
    x = _within("quadrupole_bar", quadrupole_bar, QUADRUPOLE_BAR_RANGE, check_range)
    return _yagi_yunes("moment_bar of quadrupole_bar", x)


@with_quantities()
def quadrupole_bar_of_love(tidal_deformability, check_range: bool = True) -> np.ndarray:
    """Q M/J^2 by Lambda, to 1%: Yagi & Yunes 2013, Table I; ValueError outside LOVE_RANGE.

    >>> print(f"{quadrupole_bar_of_love(300.0):.1f}")  # Q-Love
    5.0
    """
    x = _within("tidal_deformability", tidal_deformability, LOVE_RANGE, check_range)
    return _yagi_yunes("quadrupole_bar of tidal_deformability", x)


@with_quantities()
def kepler_period(mass, radius, gravitational_constant: float = GRAVITATIONAL_CONSTANT) -> np.ndarray:
    """2 pi sqrt(R^3/(G M)): the period of a circular orbit at the equator of a sphere (SI, or with the G given).

    No body rotates as fast as this: its equator has swollen before (`roche_shedding_period`). ValueError for what is
    negative.

    >>> print(f"{1e3 * kepler_period(2.8e30, 1.2e4):.3f} ms")
    0.604 ms
    """
    refuse_negative(mass=mass, radius=radius, gravitational_constant=gravitational_constant)
    return 2 * math.pi * np.sqrt(np.asarray(radius, dtype=float) ** 3 / (gravitational_constant * np.asarray(mass)))


@with_quantities()
def roche_shedding_period(mass, radius, gravitational_constant: float = GRAVITATIONAL_CONSTANT) -> np.ndarray:
    """(3/2)^(3/2) times the Kepler period of the non-rotating sphere: Newtonian mass shedding in Roche's model.

    The mass is a point, the polar radius stays R, and the equator reaches 3R/2 where it orbits freely.

    >>> print(f"{roche_shedding_period(1.0, 1.0, 1.0) / kepler_period(1.0, 1.0, 1.0):.4f}")  # (3/2)^(3/2)
    1.8371
    """
    return 1.5**1.5 * kepler_period(mass, radius, gravitational_constant)


@with_quantities(mass="Msun", radius_km="km")
def shedding_frequency(mass, radius_km, source: str = "haensel_2009") -> np.ndarray:
    """Fastest rigid rotation in Hz of a relativistic star, from M (solar masses) and R of its non-rotating fellow.

    source: a name of KEPLER_FACTORS; ValueError for another, and for what is negative.

    >>> print(f"{shedding_frequency(1.4, 12.0):.0f} Hz")
    972 Hz
    """
    if source not in KEPLER_FACTORS:
        raise ValueError(f"there is no limit {source!r}; there are {', '.join(KEPLER_FACTORS)}")
    refuse_negative(mass=mass, radius_km=radius_km)
    radius = np.asarray(radius_km, dtype=float)
    return 1e3 * KEPLER_FACTORS[source] * np.sqrt(np.asarray(mass, dtype=float)) * (10 / radius) ** 1.5
