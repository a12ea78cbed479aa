"""Obliquities of planets over ages, on orbits whose planes turn each other, in one call: a Dataset out.

Planes by Laplace and Lagrange's modes from the orbits of J2000, spin by its secular equation (`rotation.secular_spin`).
Tests: tests/unit/rotation/test_secular_orbits.py, a billion years in tests/hard/test_secular_spin_hard.py.
"""

import numpy as np
import xarray as xr

from astroinertia.bodies import j2000
from astroinertia.dataset.variables import variables
from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.precession import JULIAN_YEAR
from astroinertia.rotation.secular_orbits import NodeModes, node_modes
from astroinertia.rotation.secular_spin import spin_history
from astroinertia.studies.precession import first_order_rates
from astroinertia.studies.turning_planets import PLANETS

_SAMPLES = 20001


def planetary_planes() -> tuple[tuple[str, ...], NodeModes]:
    """The names of the eight planets and the modes of their orbits' planes, from where they were at J2000."""
    planets = j2000.states("Sun")
    sun = j2000.states("Earth")["Sun"].gravitational_parameter
    axes, leans, nodes = [], [], []
    for one in planets.values():
        total = sun + one.gravitational_parameter
        axes.append(1 / (2 / np.linalg.norm(one.position) - one.velocity @ one.velocity / total))
        normal = np.cross(one.position, one.velocity)
        leans.append(np.arctan2(np.hypot(normal[0], normal[1]), normal[2]))
        nodes.append(np.arctan2(normal[0], -normal[1]))
    parameters = [one.gravitational_parameter for one in planets.values()]
    return tuple(planets), node_modes(sun, parameters, axes, leans, nodes)


@with_quantities(years="yr", precession_constant="rad/s")
def obliquity_history(
    name: str = "Mars", years: float = 1e9, precession_constant: float | None = None, samples: int = _SAMPLES
) -> xr.Dataset:
    """Return the obliquity of "Earth" or "Mars" to its own moving orbit over so many years from J2000, along `time`.

    `obliquity` and `inclination` (of the orbit to the ecliptic of J2000), rad. precession_constant: alpha in rad s-1,
    constant; that of today's moon, spin and figure unless given. The rates of the planes are constant too, so this is
    the motion that those of today give: the real ones wander, and with them Mars's obliquity is chaotic within 0 and
    60 degrees (Laskar & Robutel 1993, Nature 361, 608). SceneError for another planet, for a time that is not above 0
    and for fewer than two samples. Checked by tests/unit/rotation/test_secular_orbits.py.
    """
    name = name.capitalize()
    if name not in PLANETS:
        raise SceneError(f"the obliquity of {name} over ages is not known here; take {' or '.join(PLANETS)}")
    if not 0 < years < np.inf or not isinstance(samples, int | np.integer) or samples < 2:
        raise SceneError("an obliquity is followed for a time above 0, and recorded twice or more, a whole number")
    names, modes = planetary_planes()
    k = names.index(name)
    planet = PLANETS[name]()
    pole = j2000.ecliptic_axes() @ planet.axes.T @ [0.0, np.sin(planet.obliquity), np.cos(planet.obliquity)]
    own = float(first_order_rates(planet)["all"] / np.cos(planet.obliquity))
    alpha = own if precession_constant is None else precession_constant
    times = np.linspace(0.0, years * JULIAN_YEAR, samples)
    history = spin_history(times, pole, alpha, modes.amplitudes[k], modes.rates, modes.phases[k])
    x, y, z = history.normal.T
    angles = {
        "obliquity": (history.obliquity, "rad", "obliquity to the planet's own orbit"),
        "inclination": (np.arctan2(np.hypot(x, y), z), "rad", "of the orbit, to that of J2000"),
    }
    return xr.Dataset(
        variables("time", angles),
        variables("time", {"time": (times, "s", "time from J2000")}),
        {"title": f"obliquity of {name}", "body": name, "precession_constant": alpha, "steps": history.steps},
    )
