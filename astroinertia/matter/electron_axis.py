"""What matter of a table is worth along its electron fractions: the free energy of its coldest matter as a spline.

At the table's least temperature f = u - T s is the integral of P/rho over x = ln rho, from f of the table itself at one
density. As a bicubic spline of x and Y it is differentiated,

    P = rho df/dx,   mu = df/dY = mu_e + mu_p - mu_n,

so that what captured electrons free is to rounding what the pressure lacks by them, whatever the table's errors. The
electrons of warm matter differ from cold ones by 2/3 (pi T/mu_e)^2 of their pressure, whose change along Y is left out.
Beyond its densities and fractions f goes on linearly.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from astroinertia.engines.elementwise import Table, elementwise
from astroinertia.engines.pytree import pytree
from astroinertia.errors import SceneError
from astroinertia.matter.finite_temperature import TemperatureTable, fractions_of, read_finite_temperature
from astroinertia.matter.isentropes import spline_coefficients
from astroinertia.matter.tabulated import combined, entry, rows_of, slopes, weights, within
from astroinertia.units import ATOMIC_MASS

Array = Any
DENSITIES, FRACTIONS = 1024, 25  # nodes of the spline
_MORE = 3  # nodes of the table beyond those fractions, as splines are worst at their ends
_MEV = 1.602176634e-13  # J


def along_electrons(xp, rho, fraction, table, numbers, rows, columns):
    """f, P and mu of a density and an electron fraction."""
    z = (xp.log(rho) - entry(xp, numbers, 0.0)) * entry(xp, numbers, 1.0)
    y = (fraction - entry(xp, numbers, 2.0)) * entry(xp, numbers, 3.0)
    inside, between = within(xp, z, rows - 3.0), within(xp, y, columns - 3.0)
    row, column = xp.minimum(xp.floor(inside), rows - 4.0), xp.minimum(xp.floor(between), columns - 4.0)
    first = row * columns + column
    f = rows_of(xp, table, first, columns, weights(xp, between - column))
    g = rows_of(xp, table, first, columns, slopes(xp, between - column))
    w, v = weights(xp, inside - row), slopes(xp, inside - row)
    by_fraction, twice = combined(xp, w, g), combined(xp, v, g)
    denser, more = z - inside, y - between
    slope = combined(xp, v, f) + more * twice
    value = combined(xp, w, f) + more * by_fraction + denser * slope
    per_step, per_fraction = entry(xp, numbers, 1.0), entry(xp, numbers, 3.0)
    return value, rho * slope * per_step, (by_fraction + denser * twice) * per_fraction


@pytree
@dataclass(frozen=True, eq=False, repr=False)
class ElectronAxis:
    """The spline: coefficients (rows * columns,), and the first node and 1/step in x and in Y, (4,); in SI."""

    coefficients: Array
    numbers: Array
    rows: int = field(metadata={"static": True})
    columns: int = field(metadata={"static": True})

    def worth(self, xp: Any, density: Array, fraction: Array) -> tuple[Array, Array, Array]:
        """f, P and mu, each (N,), at densities (N,) and electron fractions, (N,) or a number."""
        tables = Table(self.coefficients), Table(self.numbers), float(self.rows), float(self.columns)
        return elementwise(xp, along_electrons, density, fraction, *tables)

    def in_units(self, density: float, specific_energy: float) -> "ElectronAxis":
        """The same in units of so many kg/m^3 and J/kg."""
        first = self.numbers - np.array([np.log(density), 0.0, 0.0, 0.0])
        return replace(self, coefficients=self.coefficients / specific_energy, numbers=first)


def electron_axis(path: Path, reference_density: float, fractions: tuple[float, float]) -> ElectronAxis:
    """That of a file in the layout of stellarcollapse.org, between two electron fractions; reference_density in kg/m^3.

    SceneError where the file is none, or has not all of those fractions.
    """
    if not fractions[0] < fractions[1]:
        raise SceneError(f"electron fractions must rise, not go from {fractions[0]:g} to {fractions[1]:g}")
    there, values = fractions_of(path), np.linspace(*fractions, FRACTIONS)
    if not there[0] <= values[0] < values[-1] <= there[-1]:
        has = f"from {there[0]:.4g} to {there[-1]:.4g}"
        raise SceneError(f"{path} has electron fractions {has}, not from {fractions[0]:.4g} to {fractions[1]:.4g}")
    low, high = np.searchsorted(there, values[0], side="right") - 1, np.searchsorted(there, values[-1])
    there = there[max(low - _MORE, 0) : high + 1 + _MORE]
    planes = [read_finite_temperature(path, float(value)) for value in there]
    nodes = np.log(planes[0].density)
    if not nodes[0] <= np.log(reference_density) <= nodes[-1]:
        raise SceneError(f"a density of {reference_density:g} kg/m3 is not among those of {path}")
    x = np.linspace(nodes[0], nodes[-1], DENSITIES)
    own = np.stack([_free_energy(plane, x, float(np.log(reference_density))) for plane in planes], axis=1)
    energy = CubicSpline(there, own, axis=1)(values)
    table = spline_coefficients(spline_coefficients(energy).T).T
    numbers = np.array([x[0], 1.0 / (x[1] - x[0]), values[0], 1.0 / (values[1] - values[0])])
    return ElectronAxis(table.ravel(), numbers, *table.shape)


def _free_energy(plane: TemperatureTable, x: np.ndarray, reference: float) -> np.ndarray:
    """f at the logarithms x of densities, (n,), of the least temperature of a table of one electron fraction."""
    nodes, heat = np.log(plane.density), plane.temperature[0] * _MEV / ATOMIC_MASS
    work = CubicSpline(nodes, np.log(plane.pressure[:, 0] / plane.density))
    fine = np.unique(np.concatenate([x, [reference], 0.5 * (x[1:] + x[:-1])]))
    rising = CubicSpline(fine, np.exp(work(fine))).antiderivative()
    there = np.log(plane.energy[:, 0] + plane.shift), plane.entropy[:, 0]
    energy, entropy = (float(CubicSpline(nodes, values)(reference)) for values in there)
    return np.exp(energy) - plane.shift - heat * entropy + rising(x) - rising(reference)
