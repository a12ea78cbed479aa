"""A planet of layers at rest, as spherical shells in balance: its density and its speed of sound, to count steps by.

Each shell is on the isentrope of its layer, at the pressure that the weight of those above it asks for. The planet that
is placed is solved for much more closely (bodies.hydrostatic, with JAX).
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from astroinertia.build.materials import equation
from astroinertia.costs.limits import Matter
from astroinertia.costs.shells import in_balance
from astroinertia.matter.isentropes import integrated
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits

SHELLS = 100
STEP = 0.02  # of ln rho
LEAST = 0.5  # of the reference density: warm matter without pressure is not much thinner
MOST_ROUNDS = 200
SETTLED = 1e-4  # of the densities, a change after which shells are in balance


@dataclass(frozen=True)
class Isentrope:
    """Densities (K,), rising, and pressures on an isentrope in compression, in code units."""

    density: np.ndarray
    pressure: np.ndarray

    def sound(self, density: np.ndarray) -> np.ndarray:
        """c at densities: c^2 = dP/d rho."""
        return np.sqrt(np.interp(density, self.density, np.gradient(self.pressure, self.density)))


def planet(scene: Scene) -> Matter | None:
    """Shells of the body of a scene of the kind layered, from the centre outwards; None where they find no balance."""
    return _planet(scene.body, scene.equation_of_state, scene.origin, code_units(scene))


@lru_cache(maxsize=4)
def _planet(body: Any, fluid: Any, origin: str | None, units: CodeUnits) -> Matter | None:
    edges = np.cumsum([layer.mass_fraction for layer in body.layers])
    edges = edges / edges[-1]
    within = np.unique(np.append(np.linspace(0.0, 1.0, SHELLS + 1), edges))  # no shell is of two layers
    mass = float(units.to_code(body.mass, "mass")) * np.diff(within)
    layer_of = np.minimum(np.searchsorted(edges, 0.5 * (within[1:] + within[:-1])), len(edges) - 1)
    curves = [_isentrope(layer, fluid, origin, units) for layer in body.layers]
    shells = [(layer_of == number, curve) for number, curve in enumerate(curves)]
    density = np.array([curves[number].density[0] for number in layer_of])
    for _ in range(MOST_ROUNDS):
        radius = np.cbrt(3.0 / (4.0 * math.pi) * np.cumsum(mass / density))
        before, pressure = density, in_balance(mass, radius)
        density, sound = np.empty_like(mass), np.empty_like(mass)
        for own, curve in shells:
            density[own] = np.interp(pressure[own], curve.pressure, curve.density)
            sound[own] = curve.sound(density[own])
        if (np.abs(density - before) < SETTLED * before).all():
            return Matter(0.0, mass, density, sound)
    return None


def _isentrope(layer: Any, fluid: Any, origin: str | None, units: CodeUnits) -> Isentrope:
    """That of a layer, from no pressure on."""
    matter = equation(next(one for one in fluid.materials if one.name == layer.material), origin)
    reference, (low, high) = matter.reference_density, matter.densities
    begun = np.array([matter.coldest + layer.isentrope])
    edges = max(low, LEAST * reference), high
    below, above = (math.ceil(abs(math.log(edge / reference)) / STEP) for edge in edges)
    x = math.log(reference)
    down = integrated(matter.pressure, x, -STEP, begun, below)
    up = integrated(matter.pressure, x, STEP, begun, above)
    energy = np.concatenate([down[::-1], begun[None], up])
    density = reference * np.exp(STEP * np.arange(-below, above + 1))
    pressure = np.array([float(matter.pressure(*state)[0]) for state in zip(density, energy, strict=True)])
    falls = np.flatnonzero(np.diff(pressure[: below + 1]) <= 0.0)
    first = falls[-1] + 1 if len(falls) else 0
    return Isentrope(units.to_code(density[first:], "density"), units.to_code(pressure[first:], "pressure"))
