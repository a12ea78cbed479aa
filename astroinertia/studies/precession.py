"""Precession and nutation of the Earth and of Mars from their integrated motion, in one call: a Dataset out.

A rigid planet of the dynamical ellipticity that is published turns under the torques of Sun, Moon and planets
(`studies.turning_planets`). Its axis on the fixed orbit of J2000 is taken apart into a rate, its change and periodic
terms (`rotation.harmonic_fit`), once for all torques and once for each part of them alone, beside the formulae of
`rotation.precession`. What is not in the motion (relativity, the planet's own flattening in the orbits of its moons,
higher harmonics) is added by name and source. And the Earth's free wobble, with the share of each cause.
Tests: tests/physics/test_precession.py.
"""

from pathlib import Path

import jax
import numpy as np
import xarray as xr

from astroinertia.bodies.mean_orbits import mean_companions
from astroinertia.bodies.planets import body
from astroinertia.dataset.variables import variables
from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation import precession as formulae, spice, wobble
from astroinertia.rotation.ephemeris import Ephemeris
from astroinertia.rotation.harmonic_fit import HarmonicFit, harmonic_fit
from astroinertia.rotation.precession import ARCSECOND, JULIAN_YEAR
from astroinertia.rotation.spice import Kernels
from astroinertia.studies import turning_planets
from astroinertia.studies.turning_planets import PLANETS, Planet
from astroinertia.units import GRAVITATIONAL_CONSTANT, quantity

_STEPS_PER_DAY = 6
_PER_CENTURY = ARCSECOND / (100 * JULIAN_YEAR)
_PER_YEAR = 1e-3 * ARCSECOND / JULIAN_YEAR  # of milliarcseconds
_SHORTEST = 0.25  # of a planet's span: one turn of the Moon's node, five years of Mars
_NODE = 0  # the term of 18.6 years among those of the Earth

# Of the rate on the ecliptic of J2000, arc seconds a century: Capitaine, Wallace & Chapront 2003, A&A 412, 567.
_IAU_2006, _IAU_GENERAL = 5038.481507, 5028.796195
# What a rigid quadrupole on orbits of point masses lacks, arc seconds a century (their table 3, after Williams 1994, AJ
# 108, 711, and Mathews, Herring & Buffett 2002, JGR 107, B4).
_EARTH_CORRECTIONS = {
    "flattening of the Earth in the Moon's orbit": -0.269430,
    "J4 of the Earth": 0.002600,
    "non-linear response of a deformable Earth": -0.021050,
}
_EARTH_SOURCE = "Capitaine, Wallace & Chapront 2003, A&A 412, 567, table 3"
# Rate and its standard deviation in mas a year, and C/(M a^2) from it: Konopliv et al. 2016, Icarus 274, 253; Baland et
# al. 2020, Celest. Mech. Dyn. Astron. 132, 47.
_MARS_RATE, _MARS_RATE_ERROR, _MARS_RATIO, _MARS_RATIO_ERROR = 7608.3, 2.1, 0.36367, 0.00010


@with_quantities(years="yr")
def precession(
    name: str = "Earth", years: float | None = None, steps_per_day: int = _STEPS_PER_DAY, kernels: Kernels = ()
) -> xr.Dataset:
    """Return the integrated precession and nutation of "Earth" or "Mars", with formulae, corrections and differences.

    Along `time` (s from J2000): `longitude` by which the equator's node has gone back, and `obliquity`, on the fixed
    orbit of J2000, rad, and both without their periodic terms, `steady_longitude` and `steady_obliquity`. Along `part`
    (all, Sun, Moon, planets): `precession_rate` of the integrated motion at J2000 and `precession_rate_formula`, rad
    s-1. Along `correction`: `correction_rate` of what is not in the motion, with `correction_source`. Then
    `corrected_rate`, `published_rate`, `difference` = corrected/published - 1, and `residual` of the fit, rad. For the
    Earth the 18.6-year `nutation_longitude` and `nutation_obliquity`, and with the moving ecliptic
    `general_precession_rate` and `general_precession_period`; for Mars, whose C/(M a^2) is that of a later analysis
    than the published rate, the `polar_moment_ratio` that this rate asks for, and its `polar_moment_ratio_error`.
    years: whole length, J2000 in its middle: 74.4 (four turns of the Moon's node) or 37.6 (twenty years of Mars) unless
    given. kernels: files of SPICE (extra `spice`); a PCK gives the pole and the rate of rotation at J2000, an SPK the
    orbits, and attributes say so. SceneError for another planet, for less than a quarter of that span, for less than a
    step a day, and for kernels without what is needed.
    """
    if name not in PLANETS:
        raise SceneError(
            f"the precession of {name} is not known here; take {' or '.join(PLANETS)}, or own_precession.precession_of"
        )
    planet = PLANETS[name](kernels)
    span, least = planet.span if years is None else years * JULIAN_YEAR, _SHORTEST * planet.span
    if not least <= span < np.inf or steps_per_day < 1:
        raise SceneError(
            f"the precession of {name} takes {least / JULIAN_YEAR:.3g} years or more, and at least one step a day"
        )
    with jax.enable_x64(True):
        orbits = turning_planets.orbits(planet, span)
        # The pole of J2000 is off the mean one by its nutation: once that is known, the mean obliquity comes out right.
        _, _, first = _followed(planet, orbits, planet.obliquity, steps_per_day)
        start = 2 * planet.obliquity - first.offset
        angles, motion, tilt = _followed(planet, orbits, start, steps_per_day)
        rates = {"all": motion.rate}
        for part, names in planet.parts.items():
            rates[part] = _followed(planet, turning_planets.torque_of(orbits, names), start, steps_per_day)[1].rate
        dataset = _dataset(planet, angles, rates, motion, tilt).assign_attrs(_origins(name, kernels))
        return (_of_the_earth if name == "Earth" else _of_mars)(dataset, planet, orbits, motion, tilt)


@with_quantities()
def chandler_wobble(love_number: float | None = None) -> xr.Dataset:
    """Return the Earth's free wobble by causes: along `cause`, `period` with it and all before it, and its `change`.

    Periods in s; `love_number_part` and `love_number_lag` are what it adds to k2, real part and minus the imaginary
    one. `period_of_all` and `quality` are those of all causes, `observed_period` beside them (433 days) and `unnamed`
    the difference that no cause here accounts for. love_number and source: as for `rotation.wobble.chandler_wobble`.

    >>> print((chandler_wobble().change.values / 86400).round(1))
    [303.6 140.3 -50.5   0.4  -0.8  29.7   1.5   9.1]
    """
    free_wobble = wobble.chandler_wobble(love_number)
    observed = 433.0 * wobble.DAY  # Vondrak, Ron & Chapanov 2017, Adv. Space Res. 59, 1395
    shares = free_wobble.shares
    of_causes = {
        "period": ([share.period for share in shares], "s", "period with it and all before it"),
        "change": ([share.change for share in shares], "s", "what it does to the period"),
        "love_number_part": ([np.real(share.love_number) for share in shares], "1", "part of k2"),
        "love_number_lag": ([-np.imag(share.love_number) for share in shares], "1", "lagging part of k2"),
    }
    of_all = {
        "period_of_all": (free_wobble.period, "s", "period with all causes"),
        "observed_period": (observed, "s", "observed period; published values are 430 to 435 d"),
        "unnamed": (observed - free_wobble.period, "s", "observed less computed"),
        "quality": (free_wobble.quality, "1", "Q of the damping by anelasticity"),
        "mantle_share": (free_wobble.mantle_share, "1", "A_m/A, the moment outside the core by PREM"),
    }
    return xr.Dataset(
        variables("cause", of_causes) | variables((), of_all),
        {"cause": [share.name for share in shares]},
        {"title": "free wobble of the Earth, by causes", "source": "Smith & Dahlen 1981, GJRAS 64, 223"},
    )


def _followed(
    planet: Planet, orbits: Ephemeris, obliquity: float, steps_per_day: int
) -> tuple[tuple[np.ndarray, ...], HarmonicFit, HarmonicFit]:
    """Times, longitudes and obliquities, and what the two of them are made of."""
    times, axes = turning_planets.axis_history(planet, orbits, obliquity, steps_per_day)
    longitude = np.pi / 2 - np.unwrap(np.arctan2(axes[:, 1], axes[:, 0]))
    tilt = np.arctan2(np.hypot(axes[:, 0], axes[:, 1]), axes[:, 2])
    along, nodding = (harmonic_fit(times, angle, planet.frequencies, planet.phases) for angle in (longitude, tilt))
    return (times, longitude, tilt), along, nodding


def _dataset(
    planet: Planet, angles: tuple[np.ndarray, ...], rates: dict[str, float], motion: HarmonicFit, tilting: HarmonicFit
) -> xr.Dataset:
    times, longitude, tilt = angles
    formula = first_order_rates(planet)
    along_time = {
        "longitude": (longitude, "rad", "how far the node of the equator has gone back"),
        "obliquity": (tilt, "rad", "obliquity to the orbit of J2000"),
        "steady_longitude": (motion.steady(times), "rad", "longitude without its periodic terms"),
        "steady_obliquity": (tilting.steady(times), "rad", "obliquity without its periodic terms"),
    }
    of_parts = {
        "precession_rate": (list(rates.values()), "rad s-1", "rate of the motion at J2000"),
        "precession_rate_formula": (
            [formula.get(part, np.nan) for part in rates], "rad s-1", "rate by first-order formula",
        ),
    }  # fmt: skip
    left = {"residual": (motion.residual, "rad", "root mean square of the longitude that the fit leaves")}
    return xr.Dataset(
        variables("time", along_time) | variables("part", of_parts) | variables((), left),
        variables("time", {"time": (times, "s", "time from J2000")}) | {"part": list(rates)},
        {"title": f"precession of {planet.name}, integrated", "body": planet.name},
    )


def _origins(name: str, kernels: Kernels) -> dict[str, str]:
    """What of the motion is from kernels, with the files' names; nothing without any."""
    if not kernels:
        return {}
    files = [kernels] if isinstance(kernels, str | Path) else kernels
    said = f"SPICE: {', '.join(Path(file).name for file in files)}"
    found = {"orientation": spice.has_orientation(kernels, name), "orbits": spice.has_orbits(kernels)}
    return {key: said for key, there in found.items() if there}


def first_order_rates(planet: Planet) -> dict[str, float]:
    """Rates by first-order formulae, rad s-1, of all torques and of each part of them that such a formula knows.

    >>> rates = first_order_rates(turning_planets.earth())
    >>> print(f"{rates['Moon'] / rates['Sun']:.2f}")  # the Moon's torque is twice the Sun's
    2.16
    """
    if planet.name == "Earth":
        luni_solar = formulae.luni_solar_precession(planet.ellipticity, planet.spin_rate, planet.obliquity)
        return {"all": luni_solar.total, "Sun": luni_solar.solar, "Moon": luni_solar.lunar}
    rate = float(formulae.precession_rate(planet.ellipticity, planet.spin_rate, planet.obliquity, *planet.orbit))
    return {"all": rate, "Sun": rate}


def _corrected(dataset: xr.Dataset, corrections: dict[str, float], sources: list[str], published: float) -> xr.Dataset:
    corrected = float(dataset["precession_rate"].sel(part="all")) + sum(corrections.values())
    rates = {"correction_rate": (list(corrections.values()), "rad s-1", "rate of what is not in the motion")}
    numbers = {
        "corrected_rate": (corrected, "rad s-1", "rate with all corrections"),
        "published_rate": (published, "rad s-1", "published rate"),
        "difference": (corrected / published - 1, "1", "corrected over published, less one"),
    }
    return dataset.assign_coords(correction=list(corrections)).assign(
        variables("correction", rates) | {"correction_source": ("correction", sources)} | variables((), numbers)
    )


def _of_the_earth(
    dataset: xr.Dataset, planet: Planet, orbits: Ephemeris, motion: HarmonicFit, tilt: HarmonicFit
) -> xr.Dataset:
    relativity = formulae.geodesic_precession(*planet.orbit)
    corrections = {"geodesic precession": -float(relativity)}
    corrections |= {name: value * _PER_CENTURY for name, value in _EARTH_CORRECTIONS.items()}
    sources = ["de Sitter 1916", *[_EARTH_SOURCE] * len(_EARTH_CORRECTIONS)]
    dataset = _corrected(dataset, corrections, sources, _IAU_2006 * _PER_CENTURY)
    pole = _pole_rate(planet, orbits)
    general = float(formulae.general_precession(dataset["corrected_rate"], planet.obliquity, pole))
    numbers = {
        "nutation_longitude": (-motion.sine[_NODE], "rad", "amplitude of the 18.6-year term in longitude"),
        "nutation_obliquity": (tilt.cosine[_NODE], "rad", "amplitude of the 18.6-year term in obliquity"),
        "ecliptic_pole_rate": (pole, "rad s-1", "of the ecliptic's pole towards the equinox"),
        "general_precession_rate": (general, "rad s-1", "rate of the equinox on the moving ecliptic"),
        "general_precession_period": (2 * np.pi / general, "s", "period of the general precession"),
        "published_general_rate": (_IAU_GENERAL * _PER_CENTURY, "rad s-1", "published general precession"),
    }
    return dataset.assign(variables((), numbers))


def _of_mars(
    dataset: xr.Dataset, planet: Planet, orbits: Ephemeris, motion: HarmonicFit, tilt: HarmonicFit
) -> xr.Dataset:
    mars, rate = body("Mars"), float(dataset["precession_rate"].sel(part="all"))
    j2, ratio = mars.adopted("j2"), mars.adopted("polar_moment_ratio").value
    satellites = mean_companions("Mars")[1:]
    bulge, momentum = formulae.moons_of_the_equator(
        mars.gravitational_parameter,
        j2.radius,
        planet.spin_rate,
        [GRAVITATIONAL_CONSTANT * one["mass"] for one in satellites],
        [quantity(one["semi_major_axis"], "length") for one in satellites],
    )
    moons = (1 + bulge / j2.value) / (1 + momentum / ratio) - 1
    relativity = formulae.geodesic_precession(*planet.orbit)
    corrections = {"geodesic precession": -float(relativity), "Phobos and Deimos, held to the equator": rate * moons}
    sources = ["de Sitter 1916", "Goldreich 1966, Rev. Geophys. 4, 411; orbits of Jacobson & Lainey 2014"]
    dataset = _corrected(dataset, corrections, sources, _MARS_RATE * _PER_YEAR)
    # The torque, and that on the moons with it, goes as 1/C; relativity does not.
    needed_ratio = ratio * rate * (1 + moons) / (_MARS_RATE * _PER_YEAR + float(relativity))
    numbers = {
        "polar_moment_ratio": (needed_ratio, "1", "C/(M a^2) of the published rate, a = 3396 km"),
        "polar_moment_ratio_error": (needed_ratio * _MARS_RATE_ERROR / _MARS_RATE, "1", "one sigma, from the rate"),
        "published_polar_moment_ratio": (_MARS_RATIO, "1", "C/(M a^2) published with that rate"),
        "published_polar_moment_ratio_error": (_MARS_RATIO_ERROR, "1", "one sigma"),
    }
    return dataset.assign(variables((), numbers))


def _pole_rate(planet: Planet, orbits: Ephemeris) -> float:
    """Rate of the ecliptic's pole towards the equinox: of the orbit of Earth and Moon together about the Sun."""
    times = np.linspace(float(orbits.start), float(orbits.end), 4096)
    moon, sun = orbits.names.index("Moon"), orbits.names.index("Sun")
    share = orbits.mass[moon] / (orbits.mass[moon] + planet.parameter)
    place, speed = np.asarray(orbits.position(times)), np.asarray(orbits.velocity(times))
    place, speed = (states[:, sun] - share * states[:, moon] for states in (place, speed))
    normal = np.cross(place, speed)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return harmonic_fit(times, normal[:, 0], planet.frequencies[planet.frequencies > 0][[3]] * np.arange(1, 3)).rate
