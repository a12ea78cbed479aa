"""Interiors and moment ratios: PREM, the flattening of a fluid Earth, ratios from measured gravity and precession."""

from astroinertia.bodies.earth import elastic_prem, prem, prem_figure
from astroinertia.bodies.love_numbers import interior, love_numbers
from astroinertia.bodies.moment_ratios import polar_from_precession
from astroinertia.bodies.planets import body
from astroinertia.verify.comparison import Quantities

_PREM_CONSTANT = 6.6732e-11  # G of 1981, with which PREM's own table holds


def preliminary_reference_earth() -> Quantities:
    """Moment ratio, pressure and gravity of PREM from its density."""
    earth = prem(_PREM_CONSTANT)
    return {
        "prem_moment_ratio": float(earth.moment_ratio),
        "prem_central_pressure": float(earth.pressure(0.0)) / 1e9,
        "prem_core_gravity": float(earth.gravity(3480e3)),
    }


def hydrostatic_earth() -> Quantities:
    """The flattening that PREM would have as a fluid, to all orders."""
    return {"earth_flattening": 1.0 / prem_figure().flattening}


def solar_system() -> Quantities:
    """Ratios as their authors normalise them, from other numbers of the table."""
    earth = body("Earth")
    precession = polar_from_precession(earth.value("j2"), earth.value("dynamical_ellipticity"))
    return {
        "earth_polar_ratio": precession,
        "earth_mean_ratio": earth.moment_ratio().value,
        "mars_mean_ratio": body("Mars").moment_ratio().value,
        "moon_mean_ratio": body("Moon").moment_ratio().value,
    }


def yielding_planets() -> Quantities:
    """Elastic Love numbers of the Earth, and Mars's k2 by the layers that InSight heard."""
    k, h, _ = love_numbers(elastic_prem())
    return {"prem_k2": float(k), "prem_h2": float(h), "mars_k2": float(love_numbers(interior("Mars")).k)}


COMPUTATIONS = (preliminary_reference_earth, hydrostatic_earth, solar_system, yielding_planets)
