"""The fixed point of shape, density and rotation of a figure of equilibrium; `figures.py` is what callers use.

Everything is in units of the mass, the mean radius and the gravitational constant.
Tests: tests/unit/bodies/test_figures.py.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from astroinertia.bodies.figure_layers import Layer
from astroinertia.bodies.figure_shapes import (
    Angles,
    Field,
    angles,
    fixed_point,
    level_surfaces,
    multipoles,
    node_ranges,
    radii_at,
)
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.bodies.scf_mesh import even_legendre
from astroinertia.errors import NumericalError
from astroinertia.matter.barotropes import BarotropicLaw
from astroinertia.process.blas import one_thread

_TOLERANCE = 1e-13  # of shape and potential between two sweeps
_MOST_SWEEPS = 120
_ROUND_OFF = 1e-16
_SURFACE = slice(-1, None)
_NEAR_SURFACE = 1e-5  # below this share of the layer's thickness differences of the potential are rough
_ASYMPTOTIC_TERMS = 10
_SCALE_TOLERANCE = 1e-12  # of the mass, after which the densities are scaled by what is left
_SCALE_STEPS = 60
_LARGEST_LOG_SCALE = 200.0  # whose cube is a number


class Material(Protocol):
    """What gives the densities at the nodes of each layer from the depths u - u(surface)."""

    @property
    def hydrostatic(self) -> bool:
        """Whether the densities depend on the depths."""
        ...

    def first_depth(self, radius: np.ndarray) -> np.ndarray:
        """A first guess of the depths, but for a factor, at mean radii."""
        ...

    def densities(self, layers: Sequence[Layer], depth: np.ndarray) -> tuple[list[np.ndarray], float]:
        """Densities with mass 1, and the mean radius in units of the reference one."""
        ...


@dataclass(frozen=True)
class Rotation:
    """How fast the body turns: m at the reference radius (and m ~ R^radius_power), or else q = Omega^2 a^3/(G M)."""

    small_m: float | None = None
    rotation_parameter: float | None = None
    radius_power: int = 0

    def at(self, scale: float, equator: float) -> float:
        """M of a body of mean radius `scale` times the reference and equatorial radius `equator` times the mean one."""
        if self.rotation_parameter is not None:
            return self.rotation_parameter / equator**3
        assert self.small_m is not None
        return self.small_m * scale**self.radius_power

    def slowed(self, share: float) -> "Rotation":
        """A share of the centrifugal force."""
        return Rotation(
            None if self.small_m is None else share * self.small_m,
            None if self.rotation_parameter is None else share * self.rotation_parameter,
            self.radius_power,
        )

    def first(self) -> float:
        """M of the first guess: that of Roche's model for q, a/c = 1 + q/2."""
        return self.at(1.0, 1.0 if self.rotation_parameter is None else (1 + self.rotation_parameter / 2) ** (1 / 3))


def volume_integral(layers: Sequence[Layer], values: Sequence[np.ndarray]) -> float:
    """4 pi int f s^2 ds, by parts within each layer, f at the nodes of each."""
    total = 0.0
    for layer, f in zip(layers, values, strict=True):
        change = layer.top**3 * (layer.inner[0, -1] @ (layer.slope @ f))
        total += layer.top**3 * f[-1] - layer.bottom**3 * f[0] - change
    return 4 * math.pi / 3 * float(total)


def _smooth_at_surface(below_top: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Replace depths that are differences near round-off, by a cubic of depth/below_top through the nodes beneath."""
    count = int(np.sum(below_top < _NEAR_SURFACE * below_top[0]))
    if count < 2 or len(depth) < count + 4:
        return depth
    beneath = slice(-count - 4, -count)
    unit = below_top[-count - 4]
    cubic = np.polyfit(below_top[beneath] / unit, depth[beneath] / below_top[beneath], 3)
    smooth = below_top[-count:] * np.polyval(cubic, below_top[-count:] / unit)
    return np.concatenate([depth[:-count], smooth])


@dataclass(frozen=True, eq=False)
class GivenDensity:
    """Densities that belong to surfaces of given mean radius."""

    nodes: list[np.ndarray]
    hydrostatic: bool = False

    def first_depth(self, radius: np.ndarray) -> np.ndarray:
        """Nothing that depends on it."""
        return np.zeros_like(radius)

    def densities(self, layers: Sequence[Layer], depth: np.ndarray) -> tuple[list[np.ndarray], float]:
        """Densities as given."""
        return self.nodes, 1.0


@dataclass(frozen=True, eq=False)
class Hydrostatic:
    """Barotropes, one a layer from the centre; a factor of their pressures or the mean radius is fitted to the mass.

    unit_density = M/R^3 and unit_enthalpy = G M/R, in the units of the laws, at the reference radius.
    """

    laws: Sequence[BarotropicLaw]
    unit_density: float
    unit_enthalpy: float
    free_radius: bool
    hydrostatic: bool = True

    def first_depth(self, radius: np.ndarray) -> np.ndarray:
        """That of the outermost law in a sphere: Lane-Emden for polytropes, the homogeneous body otherwise.

        Below 2.5 an index near by does, lest a fit that changes the index integrate Lane-Emden each time.
        """
        index = self.laws[-1].surface_index
        if not 0 < index < 5:
            return 0.5 * (1 - radius**2)
        nearby = lane_emden(max(round(2 * index), 1) / 2 if index < 2.5 else index)
        return nearby.theta_at(radius * nearby.xi_1)

    def _at_scale(self, layers, parts, log_scale: float) -> tuple[list[np.ndarray], float]:
        scale = math.exp(log_scale)
        unit_density = self.unit_density / scale**3 if self.free_radius else self.unit_density
        densities: list[np.ndarray] = []
        top_pressure, top_depth = 0.0, 0.0
        for law, depth in zip(reversed(self.laws), reversed(parts), strict=True):
            start = law.enthalpy(top_pressure) if top_pressure > 0 else 0.0
            enthalpy = start + np.maximum(depth - top_depth, 0.0) * (self.unit_enthalpy / scale)
            densities.append(law.density(enthalpy) / unit_density)
            top_pressure, top_depth = float(law.pressure(enthalpy[0])), depth[0]
        densities.reverse()
        return densities, volume_integral(layers, densities)

    def densities(self, layers: Sequence[Layer], depth: np.ndarray) -> tuple[list[np.ndarray], float]:
        """Secant steps in the logarithms of scale and mass: straight lines for a polytrope."""
        parts = [depth[part] for part in node_ranges(layers)]
        parts[-1] = _smooth_at_surface(layers[-1].below_top, parts[-1])
        before, now, longest = 0.0, 0.05, 1.0
        _, mass_before = self._at_scale(layers, parts, before)
        for _ in range(_SCALE_STEPS):
            if abs(now) > _LARGEST_LOG_SCALE:
                break
            densities, mass = self._at_scale(layers, parts, now)
            if abs(mass - 1) < _SCALE_TOLERANCE:
                return [density / mass for density in densities], math.exp(now) if self.free_radius else 1.0
            if not (mass > 0 and mass_before > 0):
                break
            change = math.log(mass) - math.log(mass_before)
            if change == 0:
                break
            step = -math.log(mass) * (now - before) / change
            before, now, mass_before = now, now + float(np.clip(step, -longest, longest)), mass
            longest *= 2
        raise NumericalError("no scale of the barotropes gives the mass: there is no such body in equilibrium")


@dataclass(frozen=True, eq=False)
class Solution:
    """A converged figure: shape (node, point); potential u, equator and pole r/s of the surfaces; m; R/reference."""

    layers: Sequence[Layer]
    sphere: Angles
    field: Field
    densities: list[np.ndarray]
    shape: np.ndarray
    potential: np.ndarray
    small_m: float
    scale: float
    equator: np.ndarray
    pole: np.ndarray
    truncation: float
    sweeps: int


def _share_left_out(field: Field, equator: float, pole: float) -> float:
    """What harmonics left out have of the potential at pole and equator of the surface, in units of G M/R.

    The sum of a geometric series that goes on from the last harmonics; where they no longer fall, as round-off and
    asymptotic series do, it stops after `_ASYMPTOTIC_TERMS`.
    """
    powers = 2.0 * np.arange(len(field.outer))
    left_out = 0.0
    for terms in (np.abs(field.outer[:, -1]) * pole**-powers, np.abs(field.inner[:, -1]) * equator**powers):
        terms = np.maximum(terms, _ROUND_OFF)
        last = np.maximum(terms[-1], terms[-2])  # every other harmonic may be small by chance
        ratio = np.sqrt(last / np.maximum(terms[-3], terms[-4]))
        left_out += last * min(ratio / (1 - ratio) if ratio < 1 else math.inf, _ASYMPTOTIC_TERMS)
    return float(left_out)


def on_points(start: Solution, sphere: Angles) -> np.ndarray:
    """Return the shape of a solution at other points of mu, by its Legendre series."""
    count = len(start.sphere.mu)
    terms = even_legendre(start.sphere.mu, 2 * count - 2) * start.sphere.weights
    series = start.shape @ terms.T * (4 * np.arange(count) + 1)
    return series @ even_legendre(sphere.mu, 2 * count - 2)


@one_thread
def solve(
    layers: Sequence[Layer], material: Material, rotation: Rotation, harmonics: int, start: Solution | None = None
) -> Solution:
    """Sweep density, field and surfaces to their fixed point, from a sphere or from a solution with other harmonics."""
    sphere = angles(2 * harmonics + 8, harmonics)
    radius = np.concatenate([layer.radius for layer in layers])
    shapes = len(radius) * len(sphere.mu)

    def state(x, u, small_m):
        return np.concatenate([x.ravel(), u - u[-1] if material.hydrostatic else [], [small_m]])

    def one_sweep(z):
        densities, scale = material.densities(layers, z[shapes:-1])
        field = multipoles(layers, z[:shapes].reshape(len(radius), -1), densities, sphere)
        x, level = level_surfaces(field, z[:shapes].reshape(len(radius), -1), float(z[-1]), sphere)
        equator = float(radii_at(field, _SURFACE, level[_SURFACE], 0.0, float(z[-1]), x[_SURFACE, 0])[0])
        return densities, scale, field, x, level, radius**2 * level + field.constant, equator

    def sweep(z):
        _, scale, _, x, _, u, equator = one_sweep(z)
        return state(x, u, rotation.at(scale, equator))

    if start is None:
        first_shape = np.ones((len(radius), len(sphere.mu)))
        first = state(first_shape, material.first_depth(radius), rotation.first())
    else:
        first = state(on_points(start, sphere), start.potential, start.small_m)
    z, sweeps = fixed_point(sweep, first, _TOLERANCE, _MOST_SWEEPS)
    small_m = float(z[-1])
    densities, scale, field, x, level, u, _ = one_sweep(z)
    everywhere = slice(None)
    equator = radii_at(field, everywhere, level, 0.0, small_m, x[:, 0])
    pole = radii_at(field, everywhere, level, 1.0, small_m, x[:, -1])
    truncation = _share_left_out(field, float(equator[-1]), float(pole[-1]))
    return Solution(layers, sphere, field, densities, x, u, small_m, scale, equator, pole, truncation, sweeps)
