"""Constants and units: those of the package beside what is published, and its own tables beside astropy's."""

import math

from astroinertia.bodies.planets import body
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SPEED_OF_LIGHT, CodeUnits, quantity
from astroinertia.verify.comparison import Quantities

_DAY = 86400.0  # s


def published_constants() -> Quantities:
    """G and c as every conversion to SI uses them, and the au."""
    return {
        "gravitational_constant": GRAVITATIONAL_CONSTANT,
        "speed_of_light": SPEED_OF_LIGHT,
        "astronomical_unit": quantity("1 au", "length"),
        "solar_gravitational_parameter": GRAVITATIONAL_CONSTANT * SOLAR_MASS,
    }


def gaussian_year() -> Quantities:
    """Code units of one solar mass and one au: 2 pi units of time are the year of a body of no mass."""
    units = CodeUnits(SOLAR_MASS, quantity("1 au", "length"))
    return {"gaussian_year": 2.0 * math.pi * units.time / _DAY}


def solar_system_beside_astropy() -> Quantities:
    """Masses and radii of data/planets.csv beside astropy's nominal ones."""
    pairs: dict[str, float | tuple[float, float]] = {}
    for name, unit in (("Sun", "Msun"), ("Earth", "Mearth"), ("Jupiter", "Mjup")):
        nominal = GRAVITATIONAL_CONSTANT * quantity(f"1 {unit}", "mass")
        pairs[f"{name.lower()}_gravitational_parameter"] = (body(name).gravitational_parameter, nominal)
    for name, unit in (("Sun", "Rsun"), ("Earth", "Rearth"), ("Jupiter", "Rjup")):
        pairs[f"{name.lower()}_radius"] = (body(name).equatorial_radius, quantity(f"1 {unit}", "length"))
    return pairs


COMPUTATIONS = (published_constants, gaussian_year, solar_system_beside_astropy)
