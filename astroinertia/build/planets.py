"""A planet of layers: solved for in hydrostatic equilibrium, and as the profile that particles are placed by."""

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import jax
import numpy as np

from astroinertia.bodies.hydrostatic import HydrostaticPlanet, planet_from_masses
from astroinertia.build.materials import materials
from astroinertia.errors import NumericalError, SceneError
from astroinertia.matter.interior import isentrope
from astroinertia.scene.schema import Scene
from astroinertia.sph.profiles import Profile
from astroinertia.units import CodeUnits

_NODES = 4097  # of the profile


@dataclass(frozen=True)
class Planet:
    """A planet at rest: its mass and radius, the profile of its mass, and of each layer (outwards) what it is of.

    edges: the masses enclosed by the layers over the whole, (layers,); numbers: their materials; labels: their entropy
    functions.
    """

    mass: float
    radius: float
    profile: Profile
    edges: np.ndarray
    numbers: np.ndarray
    labels: np.ndarray
    solution: HydrostaticPlanet
    radius_convention = "radius of the planet at rest in hydrostatic equilibrium"

    def density_enclosing(self, mass: np.ndarray) -> np.ndarray:
        """Density on the shell that encloses a mass."""
        return self.mass / self.radius**3 * self.profile.density(self.profile.radius(mass / self.mass))

    def layer_of(self, distance: np.ndarray) -> np.ndarray:
        """The layer of particles of equal mass at distances (N,) from the centre: as many as are its share."""
        rank = np.empty(len(distance))
        rank[np.argsort(distance, kind="stable")] = np.arange(len(distance))
        return np.minimum(np.searchsorted(self.edges, (rank + 0.5) / len(distance)), len(self.edges) - 1)


def planet(scene: Scene, units: CodeUnits) -> Planet:
    """The planet that a scene's body of the kind layered is, in code units; SceneError where there is none."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    return _planet(body, fluid, scene.origin, units)


@lru_cache(maxsize=16)
def _planet(body: Any, fluid: Any, origin: str | None, units: CodeUnits) -> Planet:
    matter, mass = materials(fluid, origin, units), units.to_code(body.mass, "mass")
    names = [material.name for material in fluid.materials]
    fractions = np.array([layer.mass_fraction for layer in body.layers])
    fractions = fractions / fractions.sum()
    numbers = np.array([names.index(layer.material) for layer in body.layers])
    labels = np.array([units.to_code(layer.isentrope, "specific_energy") for layer in body.layers])
    layers = []
    for layer, number, label in zip(body.layers, numbers, labels, strict=True):
        try:
            layers.append(isentrope(matter, int(number), float(label)))
        except ValueError as error:
            raise SceneError(f"[body] the layer of {layer.material} cannot be: {error}.") from None
    try:
        solution = planet_from_masses(mass * fractions, layers)
    except NumericalError as error:
        raise SceneError(f"[body] {error}.") from None
    return Planet(
        mass, float(solution.mean_radius), _profile(solution), np.cumsum(fractions), numbers, labels, solution
    )


def _profile(solution: HydrostaticPlanet) -> Profile:
    radius, mass = float(solution.mean_radius), float(solution.mass)
    s = np.unique(np.concatenate([np.linspace(0.0, 1.0, _NODES), np.ravel(solution.layer_radii) / radius]))
    with jax.enable_x64(True):
        layered = solution.layered()
        enclosed = np.asarray(layered.enclosed_mass(s * radius)) / mass
        density = np.asarray(layered.density(s * radius)) * radius**3 / mass
    enclosed = enclosed / enclosed[-1]
    digest = hashlib.sha256(enclosed.tobytes()).hexdigest()[:32]
    return Profile(
        name=f"layered {digest}",
        enclosed=lambda at: np.interp(at, s, enclosed),
        radius=lambda at: np.interp(at, enclosed, s),
        density=lambda at: np.interp(at, s, density),
        second_moment=float(solution.moment_ratio) / 2,
        gravitational_energy=float(solution.gravitational_energy) * radius / mass**2,
    )
