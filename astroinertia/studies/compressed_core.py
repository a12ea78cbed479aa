"""The core of a body from its moment ratio, with core and mantle compressed by their own weight.

The layers of `core_inversion` with densities that follow from pressure: core and mantle have the bulk moduli of liquid
iron, forsterite or ice, and uncompressed densities that are found, together with the radius of the core, from mass,
moment and the assumed mean density. This takes away what makes uniform cores of large bodies too large. Phase changes
and temperature are left out, which the found uncompressed densities take up in part: a body as large as the Earth, with
its dense lower mantle, is beyond this model.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import root

from astroinertia.bodies.clairaut import love_number
from astroinertia.bodies.hydrostatic import HydrostaticPlanet, planet_from_radii
from astroinertia.bodies.planets import SolarSystemBody
from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.studies.core_inversion import assumed_layers, core_inversion
from astroinertia.studies.core_model_error import matter_as_dense
from astroinertia.units import GRAVITATIONAL_CONSTANT

_TOLERANCE = 1e-10  # relative, of mass, moment and assumed density
_STEP = 0.25  # standard deviations, of the differences that carry the errors


@dataclass(frozen=True)
class CompressedCore:
    """A core in SI with the standard deviation of its radius, uncompressed densities, and the fluid k2 of the body."""

    core_radius: float
    core_radius_deviation: float
    core_density: float
    mantle_density: float
    core_reference_density: float
    mantle_reference_density: float
    central_density: float
    love_number: float


@with_quantities()
def compressed_core(
    one: SolarSystemBody, ratio_row: int = 0, core_material: Any = None, mantle_material: Any = None
) -> CompressedCore:
    """Return the core of a body for which the table assumes something, from its published moment ratio.

    ratio_row: which ratio, in the order of `moment_ratio_rows`. The materials are taken with other reference densities,
    and follow from the densities of uniform layers unless given (core_model_error.matter_as_dense);
    core_density and mantle_density are means. Errors of ratio, assumed density, radius and crust are carried to first
    order.
    SceneError for a body for which nothing is assumed, NumericalError where no such body is found.
    """
    layers = assumed_layers(one)
    if layers is None:
        raise SceneError(f"nothing is assumed for the layers of {one.name}")
    name, density, crust = layers
    numbers = [one.moment_ratio_row(ratio_row), density, one.adopted("mean_radius"), *(crust or ())]
    data = np.array([number.value for number in numbers])
    spread = np.nan_to_num([number.uncertainty for number in numbers])
    uniform = core_inversion(one, ratio_row, draws=1000)
    guess = np.array([uniform.core_radius / one.mean_radius, uniform.core_density, uniform.mantle_density])
    materials = (
        core_material or matter_as_dense(uniform.core_density)[1],
        mantle_material or matter_as_dense(uniform.mantle_density)[1],
    )
    model = _Model(one, name == "core_density", *materials)
    fit = model.solve(data, guess)
    steps = np.diag(_STEP * spread)[spread > 0]
    slopes = [(model.solve(data + step, fit) - model.solve(data - step, fit))[0] / (2 * _STEP) for step in steps]
    planet = model.planet(data, fit)
    core, mantle = model.mean_densities(planet)
    return CompressedCore(
        core_radius=float(fit[0] * one.mean_radius),
        core_radius_deviation=float(np.linalg.norm(slopes) * one.mean_radius),
        core_density=core,
        mantle_density=mantle,
        core_reference_density=float(fit[1]),
        mantle_reference_density=float(fit[2]),
        central_density=float(planet.density[0, 0]),
        love_number=float(love_number(planet.layered())),
    )


@dataclass(frozen=True)
class _Model:
    """Unknown: core radius over the R of the table, and the uncompressed densities of core and mantle.

    Data: moment ratio, assumed mean density, radius, and thickness and density of a crust, if there is one. Mass and
    moment are measured themselves, so that the radius changes neither.
    """

    one: SolarSystemBody
    by_core: bool
    core_material: Any
    mantle_material: Any

    def planet(self, data: np.ndarray, unknown: np.ndarray) -> HydrostaticPlanet:
        """The planet of these numbers."""
        radius = data[2]
        radii, materials = [unknown[0] * self.one.mean_radius, radius], [
            replace(self.core_material, reference_density=unknown[1]),
            replace(self.mantle_material, reference_density=unknown[2]),
        ]  # fmt: skip
        if len(data) > 3:
            radii.insert(1, radius - data[3])
            materials.append(replace(self.mantle_material, reference_density=data[4]))
        return planet_from_radii(np.array(radii), materials, gravitational_constant=GRAVITATIONAL_CONSTANT)

    def mean_densities(self, planet: HydrostaticPlanet) -> tuple[float, float]:
        """Mean densities of core and mantle."""
        radii, masses = np.asarray(planet.radius[:, -1]), np.asarray(planet.enclosed_mass[:, -1])
        volumes = 4 / 3 * np.pi * np.diff(radii**3, prepend=0.0)
        densities = np.diff(masses, prepend=0.0) / volumes
        return float(densities[0]), float(densities[1])

    def solve(self, data: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """The unknowns for the data, from a guess."""
        size = self.one.mass * self.one.mean_radius**2

        def misfit(scaled: np.ndarray) -> list[float]:
            planet = self.planet(data, scaled * guess)
            core, mantle = self.mean_densities(planet)
            return [
                float(planet.mass) / self.one.mass - 1,
                float(planet.mean_moment) / (data[0] * size) - 1,
                (core if self.by_core else mantle) / data[1] - 1,
            ]

        try:
            solution = root(misfit, np.ones(3), tol=0.1 * _TOLERANCE)
        except ValueError as error:  # the search left what can be a body
            raise NumericalError(f"no compressed core of {self.one.name} was found: {error}") from error
        if not max(map(abs, solution.fun)) < _TOLERANCE:
            raise NumericalError(f"no compressed core of {self.one.name} was found")
        return solution.x * guess
