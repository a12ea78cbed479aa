"""The sphere, stretched or not, or the rotating star that a scene's body is at first, in code units."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from astroinertia.scene.schema import Scene
from astroinertia.sph.profiles import Profile
from astroinertia.sph.progenitor import Progenitor
from astroinertia.units import CodeUnits

if TYPE_CHECKING:
    from astroinertia.bodies.rotating_star import RotatingStar

_PRESSURE_NODES = 4096
_OUTERMOST = 1e-6  # of the mass: what is outside the shell where profiles are floored


@dataclass(frozen=True)
class Sphere:
    """The sphere that a body is before it is stretched: a profile with a mass and a radius."""

    profile: Profile
    mass: float
    radius: float
    shells: Progenitor | None = None
    """Those of a stellar profile, in SI."""
    tabulated: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None
    """Pressure and density at s of a stellar profile that tells pressures, or of a collapse."""
    radius_convention = "radius of the initial body before its axes stretch it"

    def density(self, s: np.ndarray) -> np.ndarray:
        """Density at s = r/R, floored where the profile ends so that particles at the surface keep a temperature."""
        inside = np.minimum(s, float(self.profile.radius(np.array(1.0 - _OUTERMOST))))
        return self.profile.density(inside) * self.mass / self.radius**3

    def pressure(self, s: np.ndarray) -> np.ndarray:
        """Pressure of hydrostatic equilibrium at s: the weight of what lies above, int_s^1 rho m / s^2 ds."""
        nodes = 1.0 - (1.0 - np.linspace(0.0, 1.0, _PRESSURE_NODES)) ** 2  # dense at the surface
        nodes[0] = 1e-6
        weight = self.profile.density(nodes) * self.profile.enclosed(nodes) / nodes**2
        slices = 0.5 * (weight[1:] + weight[:-1]) * np.diff(nodes)
        above = np.concatenate([np.cumsum(slices[::-1])[::-1], [0.0]])
        inside = np.minimum(s, float(self.profile.radius(np.array(1.0 - _OUTERMOST))))
        return np.interp(inside, nodes, above) * self.mass**2 / self.radius**4

    def hydrostatic(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pressure and density at s: those of a stellar profile or a collapse, or of equilibrium."""
        return (self.pressure(s), self.density(s)) if self.tabulated is None else self.tabulated(s)

    def densest(self) -> tuple[float, float]:
        """Pressure and density near the centre."""
        pressure, density = self.hydrostatic(np.array([1e-3]))
        return float(pressure[0]), float(density[0])


@dataclass(frozen=True)
class Star:
    """A rotating star in equilibrium, with the polytrope at rest whose glass is mapped to it."""

    star: "RotatingStar"
    profile: Profile
    radius_convention = "equatorial radius of the initial star"

    @property
    def mass(self) -> float:
        """Total mass."""
        return self.star.mass

    @property
    def radius(self) -> float:
        """Equatorial radius."""
        return self.star.equatorial_radius

    def hydrostatic(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pressure of equilibrium and density at positions (N, 3), floored at the surface."""
        star = self.star
        level = star.level(np.hypot(position[:, 0], position[:, 1]), position[:, 2])
        level = np.maximum(level, star.level_enclosing(1 - _OUTERMOST))
        matter = star.field.matter
        return star.max_density * star.max_enthalpy * matter.pressure(level), star.max_density * matter.density(level)

    def densest(self) -> tuple[float, float]:
        """The largest pressure and density."""
        return self.star.max_pressure, self.star.max_density


def stretch(body: Any) -> np.ndarray:
    """The symmetric matrix (3, 3) that makes the sphere an ellipsoid: `axes` along `axes_at_start`."""
    left, _, right = np.linalg.svd(body.rows_at_start)
    nearest = left @ right  # at right angles to round-off
    return nearest.T @ np.diag(np.asarray(body.axes, dtype=float)) @ nearest


def building(name: str) -> Any:
    """The function of that name, "module.function" of this room; no other module is imported."""
    module, _, function = name.partition(".")
    return getattr(importlib.import_module(f"astroinertia.build.{module}"), function)


def sphere(scene: Scene, units: CodeUnits) -> Any:
    """The Sphere (unstretched), Star or Planet of a scene's body; None for what is no such body."""
    made_by = scene.body.structure
    return building(made_by)(scene, units) if made_by else None


def stretched(scene: Scene, units: CodeUnits) -> Sphere:
    """The sphere of the profile that the body states."""
    body: Any = scene.body
    return Sphere(body.profile(), units.to_code(body.mass, "mass"), units.to_code(body.radius, "length"))


def homologous(scene: Scene, units: CodeUnits) -> Sphere:
    """The sphere of a homologous collapse, whose pressure is less than that of equilibrium."""
    body: Any = scene.body
    initial = stretched(scene, units)
    core = body.core(initial.mass, initial.radius)

    def tabulated(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        density = initial.density(s)
        return core.constant * density ** (4.0 / 3.0), density

    return replace(initial, tabulated=tabulated)


def rotating(scene: Scene, units: CodeUnits) -> Star:
    """The star in rotating equilibrium."""
    body: Any = scene.body
    mass, radius = units.to_code(body.mass, "mass"), units.to_code(body.radius, "length")
    star = body.equilibrium(units.gravitational_constant)
    return Star(replace(star, mass=mass, equatorial_radius=radius, gravitational_constant=1.0), body.profile())


def progenitor(scene: Scene, units: CodeUnits) -> Sphere:
    """The shells of a stellar profile."""
    body: Any = scene.body
    shells = body.shells(scene)
    mass, radius = units.to_code(shells.mass[-1], "mass"), units.to_code(shells.radius[-1], "length")
    density = units.to_code(shells.density, "density")

    def tabulated(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return shells.at(units.to_code(shells.pressure, "pressure"), s), shells.at(density, s)

    state_at = None if shells.pressure is None else tabulated
    return Sphere(shells.profile(), float(mass), float(radius), shells, state_at)
