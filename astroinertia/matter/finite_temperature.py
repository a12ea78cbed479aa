"""Tables over density, temperature and electron fraction in the layout of stellarcollapse.org, as P(rho, u) in SI.

An HDF5 file holds logrho (n), logtemp (m) and ye (k), the logarithms to base 10 of density in g/cm^3 and of temperature
in MeV and the electron fraction, all ascending, and at each of their nodes, (k, m, n), logpress in dyn/cm^2, logenergy
of the specific internal energy plus energy_shift in erg/g, and entropy in Boltzmann's constants a baryon; what else is
there is passed over. Source: O'Connor & Ott 2010, CQG 27, 114103, section 2.2 and appendix.

At one electron fraction, ln P and ln(u + energy_shift) are cubic in ye and in ln rho through the four nodes around; at
one density P is a cubic of u in each cell of temperature, with the slopes of central differences. Matter hotter than
the table has P go on linearly in u, colder matter has the pressure of the coldest. isentropes.py makes of that a fluid
of exact thermodynamics, whatever the table's errors: its entropy is not asked for, but tells how large they are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from astroinertia.errors import SceneError
from astroinertia.storage.bounded import check_proportion
from astroinertia.storage.columns import check_size, check_there
from astroinertia.storage.table_hdf5 import SUFFIXES, Member, members, opened

Array = Any
WHAT = "equation-of-state table"
AXES = ("ye", "logtemp", "logrho")
FIELDS = ("logpress", "logenergy", "entropy")
SHIFT = "energy_shift"
FEWEST, MOST, MOST_NODES = 4, 4096, 20_000_000  # of nodes along an axis, and of all together
_LARGEST = 300.0  # of a logarithm to base 10, which its number is still held with
_LIFTED = 1e-3  # of P/rho: noise of a table by which its energy may fall where temperature rises
_DENSITY, _ENERGY, _PRESSURE = 1e3, 1e-4, 0.1  # kg/m^3, J/kg and Pa of one unit of cgs


class Maxwell(NamedTuple):
    """|du/dlnrho - (P - dP/dlnT)/rho| in units of P/rho over the nodes of a table: median, 99th percentile, most."""

    median: float
    almost: float
    largest: float


@dataclass(frozen=True)
class TemperatureTable:
    """A table at one electron fraction, SI: densities (n,) and, at temperatures (m,) in MeV, P, u and s, (n, m).

    shift: what is added to u before its logarithm is taken. s is in Boltzmann's constants a baryon.
    """

    density: np.ndarray
    temperature: np.ndarray
    pressure: np.ndarray
    energy: np.ndarray
    entropy: np.ndarray
    shift: float

    def coldest(self, density: float) -> float:
        """The least energy at a density, of the table."""
        return float(self._rows(np.log(density))[0][0])

    def hottest(self, density: float) -> float:
        """The greatest."""
        return float(self._rows(np.log(density))[0][-1])

    @property
    def description(self) -> str:
        """Its bounds, and how far it is from being consistent, in words."""
        limits = f"{self.density[0]:.3g} to {self.density[-1]:.3g} kg/m3, {self.temperature[0]:.3g} to "
        off = self.maxwell()
        exact = (
            f"Maxwell's relation of P and u holds to {off.median:.1g} in half of its nodes, {off.almost:.1g} in 99 %"
        )
        return f"table, {limits}{self.temperature[-1]:.3g} MeV; {exact}"

    def function(self) -> Callable[[Array, Array], Array]:
        """P of a density, a number, and energies (N,)."""

        def pressure(rho: Array, u: Array) -> Array:
            energies, pressures = self._rows(np.log(rho))
            slopes = np.gradient(pressures, edge_order=2) / np.gradient(energies, edge_order=2)
            cell = np.clip(np.searchsorted(energies, u, side="right") - 1, 0, len(self.temperature) - 2)
            width = energies[cell + 1] - energies[cell]
            t = np.clip((u - energies[cell]) / width, 0.0, 1.0)
            value = (
                (1.0 + 2.0 * t) * (1.0 - t) ** 2 * pressures[cell]
                + t**2 * (3.0 - 2.0 * t) * pressures[cell + 1]
                + width * t * (1.0 - t) * ((1.0 - t) * slopes[cell] - t * slopes[cell + 1])
            )
            return value + slopes[-1] * np.maximum(u - energies[-1], 0.0)

        return pressure

    def maxwell(self) -> Maxwell:
        """How far the table is from (du/dlnrho)_T = (P - dP/dlnT)/rho, by splines through its nodes."""
        work = self.pressure / self.density[:, None]
        by_density = CubicSpline(np.log(self.density), np.log(self.energy + self.shift))(np.log(self.density), 1)
        rise = CubicSpline(np.log(self.temperature), np.log(self.pressure), axis=1)(np.log(self.temperature), 1)
        off = np.abs((self.energy + self.shift) * by_density / work - 1.0 + rise)[1:-1, 1:-1]
        return Maxwell(*(float(np.quantile(off, share)) for share in (0.5, 0.99, 1.0)))

    def _rows(self, x: Array) -> tuple[Array, Array]:
        """u and P at one ln rho and all temperatures, (m,)."""
        first, weight = _four(np.log(self.density), x)
        near = first + np.arange(4)
        energies, pressures = self.energy[near], self.pressure[near]
        return np.exp(weight @ np.log(energies + self.shift)) - self.shift, np.exp(weight @ np.log(pressures))


def is_finite_temperature(path: Path) -> bool:
    """Whether a file is an HDF5 file with the axes of this layout; SceneError where it is none that can be read."""
    if path.suffix.lower() not in SUFFIXES:
        return False
    check_there(path, WHAT)
    name = f"{WHAT} {path}"
    with opened(path, name) as (h5py, file):
        return len(members(h5py, name, file, AXES)) == len(AXES)


def fractions_of(path: Path) -> np.ndarray:
    """The electron fractions of a file's nodes, (k,); SceneError where it has none."""
    check_there(path, WHAT)
    name = f"{WHAT} {path}"
    with opened(path, name) as (h5py, file):
        found = members(h5py, name, file, AXES[:1])
        if not found:
            raise SceneError(f"{name} lacks {AXES[0]}")
        return _axis(name, AXES[0], found[AXES[0]])


def read_finite_temperature(path: Path, electron_fraction: float) -> TemperatureTable:
    """The table of a file at an electron fraction; SceneError that says what is wrong with either."""
    check_size(path, WHAT)
    name = f"{WHAT} {path}"
    with opened(path, name) as (h5py, file):
        found = members(h5py, name, file, (*AXES, *FIELDS, SHIFT))
        if missing := [key for key in (*AXES, *FIELDS, SHIFT) if key not in found]:
            raise SceneError(f"{name} lacks {', '.join(missing)}")
        axes = [_axis(name, key, found[key]) for key in AXES]
        shape = tuple(len(axis) for axis in axes)
        if np.prod(shape, dtype=float) > MOST_NODES:
            raise SceneError(f"{name} has more than {MOST_NODES} nodes")
        for key in FIELDS:
            _check(name, key, found[key], shape, path)
        _check(name, SHIFT, found[SHIFT], (1,), path)
        shift = float(found[SHIFT][0][0])
        fractions, temperature, density = axes
        low, high = fractions[0], fractions[-1]
        if not low <= electron_fraction <= high:
            raise SceneError(f"{name} has electron fractions from {low:.4g} to {high:.4g}, not {electron_fraction:.4g}")
        first, weight = _four(fractions, electron_fraction)
        planes = [np.asarray(found[key][0][first : first + 4], dtype=float) for key in FIELDS]
    for key, values in zip(FIELDS, planes, strict=True):
        size = _LARGEST if key.startswith("log") else np.inf
        if not (np.abs(values) < size).all():  # false for what is no number, too
            raise SceneError(f"{name}: {key} has values that are not finite numbers")
    if not np.isfinite(shift):
        raise SceneError(f"{name}: {SHIFT} is not a finite number")
    pressure, energy, entropy = (np.tensordot(weight, plane, 1).T for plane in planes)
    table = TemperatureTable(
        _DENSITY * 10.0**density, 10.0**temperature, _PRESSURE * 10.0**pressure, _ENERGY * (10.0**energy - shift),
        entropy, _ENERGY * shift,
    )  # fmt: skip
    return _rising(name, table)


def _axis(name: str, key: str, member: Member) -> np.ndarray:
    dataset = member[0]
    if dataset.dtype.kind not in "fiu" or dataset.ndim != 1 or not FEWEST <= len(dataset) <= MOST:
        raise SceneError(f"{name}: {key} is not a row of {FEWEST} to {MOST} numbers")
    if dataset.is_virtual or dataset.external:
        raise SceneError(f"{name}: {key} is kept in another file, which is not read")
    values = np.asarray(dataset[:], dtype=float)
    if not ((np.abs(values) < _LARGEST).all() and (np.diff(values) > 0.0).all()):
        raise SceneError(f"{name}: {key} does not rise from number to number")
    return values


def _check(name: str, key: str, member: Member, shape: tuple[int, ...], path: Path) -> None:
    """SceneError unless a dataset is of numbers, of that shape and its file's own; before any of it is read."""
    dataset = member[0]
    if dataset.dtype.kind not in "fiu" or tuple(dataset.shape or ()) != shape:
        raise SceneError(f"{name}: {key} is not of {' x '.join(map(str, shape))} numbers ({', '.join(AXES)})")
    if dataset.is_virtual or dataset.external:
        raise SceneError(f"{name}: {key} is kept in another file, which is not read")
    chunk = np.prod(dataset.chunks or (), dtype=float)
    check_proportion(key, dataset.dtype.itemsize * (np.prod(shape, dtype=float) + chunk), path)


def _rising(name: str, table: TemperatureTable) -> TemperatureTable:
    """The table with energies that rise with temperature; SceneError where they fall by more than noise."""
    energy = np.maximum.accumulate(table.energy, axis=1)
    lifted = (energy - table.energy) * table.density[:, None] / table.pressure
    row, column = np.unravel_index(np.argmax(lifted), lifted.shape)
    if lifted[row, column] > _LIFTED or not (energy[:, -1] > energy[:, 0]).all():
        where = f"{table.density[row] / _DENSITY:.4g} g/cm3 and {table.temperature[column]:.4g} MeV"
        raise SceneError(f"{name}: its energy falls where temperature rises, at {where}")
    least = np.finfo(float).eps * (np.abs(energy) + table.shift)  # so that no cell is without width
    energy = energy + np.cumsum(np.where(np.diff(energy, axis=1, prepend=-np.inf) > 0.0, 0.0, 2.0 * least), axis=1)
    return TemperatureTable(table.density, table.temperature, table.pressure, energy, table.entropy, table.shift)


def _four(nodes: np.ndarray, x: Array) -> tuple[Array, Array]:
    """The first of the four nodes around x, and the weights of the cubic through them, (4,)."""
    index = np.clip(np.searchsorted(nodes, x, side="right") - 2, 0, len(nodes) - 4)
    near = nodes[index + np.arange(4)]
    weights = []
    for k in range(4):
        others = [j for j in range(4) if j != k]
        weights.append(np.prod(np.stack([(x - near[j]) / (near[k] - near[j]) for j in others])))
    return index, np.stack(weights)
