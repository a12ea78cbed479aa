"""Isentropes of matter whose pressure is a function of density and energy, tabulated for the particle fluid, in SI.

du/dx = P(rho, u)/rho with x = ln rho is integrated from the reference density both ways (Runge-Kutta of order 4), for
labels A that are spaced evenly in ln(1 + A/scale); the table is then that of the bicubic spline through all nodes, with
a third derivative that is continuous at the nodes next to each edge.
Tests: tests/unit/matter/test_tabulated.py.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import solve_banded

if TYPE_CHECKING:
    from astroinertia.matter.tabulated import Tabulated

Array = Any
DENSITIES, LABELS = 1536, 160  # nodes of a table: steps of 1% in density over fifteen e-foldings
_SUBSTEPS = 2  # of the integration between two nodes
_SOUND_FLOOR = 0.01  # of the speed of sound in the coldest matter of the reference density


@dataclass(frozen=True)
class Isentropes:
    """One material's table, SI. energy (densities, labels) at x = first + step k and A = scale (exp(width j) - 1);
    the reference density is node number `reference`.
    """

    name: str
    first: float
    step: float
    scale: float
    width: float
    energy: np.ndarray
    reference: int


def isentropes(
    name: str, pressure: Callable[[Array, Array], Array], reference_density: float, energy_scale: float,
    densities: tuple[float, float], greatest_energy: float, coldest: float = 0.0,
    nodes: tuple[int, int] = (DENSITIES, LABELS),
) -> Isentropes:  # fmt: skip
    """The isentropes of matter with pressure(rho, u), of a density and of energies (labels,).

    The labels reach from 0, which is the energy `coldest` at the reference density, to greatest_energy, and are densest
    below energy_scale; the table spans `densities`, about. ValueError where isentropes meet or leave the numbers.
    """
    count, labels = nodes
    low, reference, high = np.log(densities[0]), np.log(reference_density), np.log(densities[1])
    step = (high - low) / (count - 1)
    below = min(max(round((reference - low) / step), 0), count - 1)
    width = np.log1p(greatest_energy / energy_scale) / (labels - 1)
    start = coldest + energy_scale * np.expm1(width * np.arange(labels))
    up = integrated(pressure, reference, step, start, count - 1 - below)
    down = integrated(pressure, reference, -step, start, below)
    energy = np.concatenate([down[::-1], start[None], up])
    if not np.isfinite(energy).all():
        raise ValueError(f"equation of state {name}: isentropes leave the numbers between its densities")
    if not (np.diff(energy, axis=1) > 0).all():
        raise ValueError(f"equation of state {name}: isentropes meet, so energy does not tell them apart")
    return Isentropes(name, reference - below * step, step, energy_scale, width, energy, below)


def integrated(pressure: Callable, x: float, step: float, start: np.ndarray, count: int) -> np.ndarray:
    """Energies (count, labels) of isentropes at so many steps of ln rho from x, where they are start (labels,)."""
    h = step / _SUBSTEPS

    def slope(x: float, u: np.ndarray) -> np.ndarray:
        rho = np.exp(x)
        return pressure(rho, u) / rho

    u, energy = start, np.empty((count, len(start)))
    with np.errstate(all="ignore"):
        for row in range(count):
            for _ in range(_SUBSTEPS):
                one = slope(x, u)
                two = slope(x + h / 2, u + h / 2 * one)
                three = slope(x + h / 2, u + h / 2 * two)
                four = slope(x + h, u + h * three)
                x, u = x + h, u + h / 6 * (one + 2 * two + 2 * three + four)
            energy[row] = u
    return energy


def tabulated(
    materials: Sequence[Isentropes], density_unit: float = 1.0, energy_unit: float = 1.0, sound_floor=_SOUND_FLOOR
) -> "Tabulated":
    """The equation of state of materials with tables of one size, in units of that many kg/m^3 and J/kg."""
    from astroinertia.matter.tabulated import MOST_LABELS, NUMBERS, Tabulated  # with numba, which isentropes need not

    tables, numbers = [], []
    for grid in materials:
        table = spline_coefficients(spline_coefficients(grid.energy).T).T
        top = grid.scale * np.expm1(grid.width * (grid.energy.shape[1] - 1))
        own = [grid.first - np.log(density_unit), 1 / grid.step, grid.scale / energy_unit, top / energy_unit]
        numbers += [*own, 1 / grid.width, _floor(grid, sound_floor) / energy_unit]
        tables.append(table / energy_unit)
    shapes = {table.shape for table in tables}
    if len(shapes) != 1:
        raise ValueError(f"equation of state: tables of materials must be of one size, not {sorted(shapes)}")
    (rows, columns) = shapes.pop()
    if columns - 2 > MOST_LABELS:
        raise ValueError(f"equation of state: tables must have at most {MOST_LABELS} labels, not {columns - 2}")
    assert len(numbers) == NUMBERS * len(tables)
    names = tuple(grid.name for grid in materials)
    return Tabulated(np.concatenate([t.ravel() for t in tables]), np.array(numbers), names, rows, columns)


def _floor(grid: Isentropes, share: float) -> float:
    # c^2 = u' + u'' of the coldest matter at the reference density: from above, for below it may have come apart.
    k = min(grid.reference + 1, len(grid.energy) - 2)
    below, here, above = grid.energy[k - 1 : k + 2, 0]
    squared = (above - below) / (2 * grid.step) + (above - 2 * here + below) / grid.step**2
    return share**2 * max(squared, 0.0)


def spline_coefficients(values: np.ndarray) -> np.ndarray:
    """Coefficients (n + 2, ...) of the uniform cubic B-splines through values (n, ...) at their knots.

    The third derivative is continuous at the second and the last but one.
    """
    count = len(values) + 2
    bands = np.zeros((9, count))  # diagonal k of solve_banded holds a[i, i + 4 - k]
    for shift, weight in ((-1, 1 / 6), (0, 2 / 3), (1, 1 / 6)):
        bands[4 - shift, 1 + shift : count - 1 + shift] = weight
    for shift, weight in enumerate((1.0, -4.0, 6.0, -4.0, 1.0)):
        bands[4 - shift, shift] = weight
        bands[4 + shift, count - 1 - shift] = weight
    nothing = np.zeros((1, *values.shape[1:]))
    return solve_banded((4, 4), bands, np.concatenate([nothing, values, nothing]))
