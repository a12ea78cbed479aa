"""A table of P(rho, u) from a file, as a function for isentropes: columns density, internal_energy and pressure.

They are in SI, or in the units that the file states of its columns (storage.columns). The rows are those of a grid in
density and either energy or another quantity, such as temperature, that the energy rises with at each density: every
density has as many rows as every other. Between them P/rho is linear in u at each of the two densities beside, and then
in ln rho, which makes an ideal gas exact; beyond the energies of a density it goes on linearly. Columns temperature and
sound_speed may be there; they follow from the rest, and are not used.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.storage.columns import READERS, Columns, check_file, check_numbers, suffix_of

Array = Any
COLUMNS = Columns(
    "equation-of-state table", ("density", "internal_energy", "pressure"), ("temperature", "sound_speed"), 1_000_000,
    {"rho": "density", "u": "internal_energy", "p": "pressure", "t": "temperature", "c": "sound_speed"},
    {"density": "density", "internal_energy": "specific_energy", "pressure": "pressure"},
)  # fmt: skip
FEWEST = 4  # densities, and energies at each


class TableEquation:
    """P(rho, u) of a grid: densities (n,), ascending, and energies and pressures (n, m), ascending in energy.

    stated: whether its file states units, in which case it is in SI.
    """

    def __init__(self, density: np.ndarray, energy: np.ndarray, pressure: np.ndarray, stated: bool = False) -> None:
        self.density, self.energy, self.pressure, self.stated = density, energy, pressure, stated

    def coldest(self, density: float) -> float:
        """The least energy at a density, of the table."""
        return float(np.interp(np.log(density), np.log(self.density), self.energy[:, 0]))

    def hottest(self, density: float) -> float:
        """The greatest."""
        return float(np.interp(np.log(density), np.log(self.density), self.energy[:, -1]))

    def function(self, tension: bool) -> Callable[[Array, Array], Array]:
        """P of a density and energies (N,), or a number; without tension none below zero."""

        def pressure(rho: Array, u: Array) -> Array:
            x, nodes = np.log(rho), np.log(self.density)
            row = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(self.density) - 2)
            share = (x - nodes[row]) / (nodes[row + 1] - nodes[row])
            below, above = (self._along(row + k, u) / self.density[row + k] for k in (0, 1))
            between = rho * ((1 - share) * below + share * above)
            return between if tension else np.maximum(between, 0.0)

        return pressure

    def _along(self, row: Array, u: Array) -> Array:
        energies, pressures = self.energy[row], self.pressure[row]
        cell = np.clip(np.searchsorted(energies, u, side="right") - 1, 0, self.energy.shape[1] - 2)
        share = (u - energies[cell]) / (energies[cell + 1] - energies[cell])
        return (1 - share) * pressures[cell] + share * pressures[cell + 1]


def read_equation(path: str | Path) -> TableEquation:
    """The table of a file (.csv, .npz, .h5, .hdf5); SceneError that says what is wrong with it."""
    path, what = Path(path), COLUMNS.what
    check_file(path, what, tuple(READERS))
    columns, stated = READERS[suffix_of(path)](path, COLUMNS)
    if columns["density"].size > COLUMNS.most:
        raise SceneError(f"{what} {path} has more than {COLUMNS.most} rows")
    check_numbers(path, what, columns, "row")
    rho, u, pressure = (columns[name] for name in COLUMNS.required)
    if not (rho > 0).all():
        raise SceneError(f"{what} {path}: density of row {int(np.argmin(rho > 0)) + 1} is not positive")
    densities, counts = np.unique(rho, return_counts=True)
    if len(densities) < FEWEST or counts.min() < FEWEST or counts.min() != counts.max():
        least, most = (int(counts.min()), int(counts.max())) if counts.size else (0, 0)
        grid = f"{len(densities)} densities with {least} to {most} rows each"
        raise SceneError(
            f"{what} {path} is no grid of at least {FEWEST} densities with {FEWEST} energies each: it has {grid}"
        )
    order = np.lexsort((u, rho))
    shape = (len(densities), counts[0])
    energy, pressure = u[order].reshape(shape), pressure[order].reshape(shape)
    flat = ~(np.diff(energy, axis=1) > 0).all(axis=1)
    if flat.any():
        raise SceneError(f"{what} {path}: at the density {densities[np.argmax(flat)]:.6g} an energy is there twice")
    return TableEquation(densities, energy, pressure, stated)
