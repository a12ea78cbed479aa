"""One isentrope of a tabulated equation of state as the material of a planet's layer (bodies/hydrostatic.py)."""

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.matter.isentropes import spline_coefficients
from astroinertia.matter.planetary import inverted
from astroinertia.matter.tabulated import NUMBERS, Tabulated, combined, curvatures, slopes

Array = Any
_NO_PRESSURE = 1e-5  # of the greatest bulk modulus: what is less is where matter has come apart
_GAS = 0.9  # of the pressure of the next node: what gas has at a node, and matter with a surface has not below it
_FEWEST = 16  # nodes in compression
_NEWTON_STEPS = 8


@pytree
@dataclass(frozen=True)
class Isentrope:
    """P(rho) on an isentrope: the spline of its energy in ln rho, and its state at no pressure.

    cells: of the spline, after which coefficients (rows,) are filled up, so that all isentropes have as many.

    A material as planetary.py has them. Test: tests/physics/test_layered_planets.py.
    """

    reference_density: Array
    bulk_modulus: Array
    derivative: Array
    first: Array
    per_step: Array
    cells: Array
    coefficients: Array

    def pressure(self, density: Array) -> Array:
        """P at densities within the table, of any shape."""
        z = (jnp.log(density) - self.first) * self.per_step
        cell = jnp.clip(jnp.floor(z), 0, self.cells - 1)
        near = [jnp.asarray(self.coefficients)[cell.astype(int) + k] for k in range(4)]
        return density * self.per_step * combined(jnp, slopes(jnp, z - cell), near)

    def density(self, pressure: Array) -> Array:
        """Density at a pressure, by Newton's method."""
        return inverted(self, pressure)


def isentrope(matter: Tabulated, number: int, label: float) -> Isentrope:
    """The isentrope of that label of one of the materials; ValueError where it has pressure at every density: a gas.

    The spline is one of the table's nodes in compression alone, for matter has a corner where it comes apart.
    """
    first, per_step, _, greatest, _, _ = matter.numbers[NUMBERS * number : NUMBERS * (number + 1)]
    if not 0 <= label <= greatest:
        raise ValueError(f"its isentropes reach from 0 to {greatest:.4g} (in code units), not to {label:.4g}")
    density = np.exp(first + np.arange(matter.rows - 2) / per_step)
    pressure, speed, energy, *_ = matter.of(float(number)).state(np, density, np.full_like(density, label))
    apart = np.flatnonzero(pressure < _NO_PRESSURE * density * (speed**2).max())
    start = apart[-1] + 1 if len(apart) else len(density)
    if len(density) - start < _FEWEST or pressure[start - 1] > _GAS * pressure[start]:
        raise ValueError("its matter has no surface: on that isentrope it is a gas")
    begins = first + start / per_step
    spline = spline_coefficients(energy[start:])
    surface, bulk = _surface(begins, per_step, spline)
    filled = np.pad(spline, (0, matter.rows - len(spline)))
    return Isentrope(surface, bulk, 4.0, begins, per_step, len(spline) - 3.0, filled)


def _surface(first: float, per_step: float, spline: np.ndarray) -> tuple[float, float]:
    """Density and bulk modulus where du/dx vanishes, in the first cells or just before them."""
    z = 0.0
    for _ in range(_NEWTON_STEPS):
        cell = max(int(np.floor(z)), 0)
        near = spline[cell : cell + 4]
        slope, curvature = combined(np, slopes(np, z - cell), near), combined(np, curvatures(np, z - cell), near)
        z -= slope / curvature
    density = float(np.exp(first + z / per_step))
    return density, float(density * curvature * per_step**2)
