"""Cold equations of state from tables: monotone, with the first law of thermodynamics kept exactly between the rows.

Rows give the pressure and either the energy density or the rest-mass density. A monotone curve of ln rho0 by ln P goes
through them, and the specific enthalpy eta follows from the first law, d eta = dP/rho0, by quadrature; where rows are
of energy, rho0 = (e + P)/(1 + eta) there, and curve and eta are found in turns. Between the knots of the quadrature
ln P is the cubic of ln eta whose slopes are the table's own (dP/d eta = rho0), and rho0 and e are derived from it: a
power law P = K rho0^gamma is reproduced exactly. Two rows of one pressure are a phase transition, where the density
jumps.

Sources: Swesty 1996, J. Comput. Phys. 127, 118 (consistency by construction); Fritsch & Carlson 1980, SIAM J. Numer.
Anal. 17, 238 (monotone cubics).
"""

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from astroinertia.matter.compact_stars import Barotrope, Piece, PowerLaw
from astroinertia.process.quantities import with_quantities

_FEWEST_ROWS = 4
_FIRST = 16  # knots a row: tables of four rows a decade then keep pieces of power laws to 1e-8
_FINEST = 128  # by then the density must rise throughout
_SURFACE_STEPS = 40  # each gains a factor of some P/e of the first row
_FIRST_LAW = 0.02  # allowed change of the table's rho0 over that from its own P and e
_SETTLED, _MOST_TURNS = 1e-14, 200  # of ln rho0 at the rows, and far more turns than that takes
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class TablePiece:
    """A smooth stretch of a table: knots in ln eta with ln P and its slope eta rho0/P."""

    log_enthalpy: list[float] = field(repr=False)
    log_pressure: list[float] = field(repr=False)
    slope: list[float] = field(repr=False)

    def _cubic(self, enthalpy: float) -> tuple[float, float, float]:
        """P with the first and second derivative of ln P by ln eta."""
        x = math.log(enthalpy)
        cell = min(max(bisect_right(self.log_enthalpy, x) - 1, 0), len(self.log_enthalpy) - 2)
        width = self.log_enthalpy[cell + 1] - self.log_enthalpy[cell]
        s = (x - self.log_enthalpy[cell]) / width
        rise = self.log_pressure[cell + 1] - self.log_pressure[cell]
        left, right = self.slope[cell] * width, self.slope[cell + 1] * width
        second, third = 3 * rise - 2 * left - right, left + right - 2 * rise
        value = self.log_pressure[cell] + s * (left + s * (second + s * third))
        slope = (left + s * (2 * second + 3 * s * third)) / width
        return math.exp(value), slope, (2 * second + 6 * s * third) / width**2

    def at(self, enthalpy: float) -> tuple[float, float, float]:
        """Rest-mass density, pressure and energy density at eta."""
        pressure, slope, _ = self._cubic(enthalpy)
        density = pressure * slope / enthalpy
        return density, pressure, density * (1 + enthalpy) - pressure

    def sound_speed_squared(self, enthalpy: float) -> float:
        """Return dP/de at eta, in c^2."""
        _, slope, bend = self._cubic(enthalpy)
        return slope * enthalpy / ((1 + enthalpy) * (slope * (slope - 1) + bend))


def _enthalpy(curve, start: float, edges: np.ndarray) -> np.ndarray:
    """eta at edges in ln P, from `start` at the first: the integral of dP/rho0 along a curve of ln rho0 by ln P."""
    half = np.diff(edges)[:, None] / 2
    points = (edges[1:] + edges[:-1])[:, None] / 2 + half * _NODES
    rises = np.sum(half * _WEIGHTS * np.exp(points - curve(points)), axis=1)
    return start + np.concatenate([[0.0], np.cumsum(rises)])


def _finer(edges: np.ndarray, parts: int) -> np.ndarray:
    return np.concatenate([np.linspace(a, b, parts, endpoint=False) for a, b in pairwise(edges)] + [edges[-1:]])


def _through(interpolant, log_pressure: np.ndarray, log_density: np.ndarray, by_energy: bool, start: float):
    """ln rho0 by ln P through the rows; where these are of energy, rho0 is (e + P)/(1 + eta), with eta by the curve."""
    curve = interpolant(log_pressure, log_density)
    if by_energy:
        heavy, edges = np.log(np.exp(log_density) + np.exp(log_pressure)), _finer(log_pressure, _FIRST)
        for _ in range(_MOST_TURNS):
            rest = heavy - np.log1p(_enthalpy(curve, start, edges)[::_FIRST])
            change, curve = np.max(np.abs(rest - curve(log_pressure))), interpolant(log_pressure, rest)
            if change < _SETTLED:
                break
    return curve


def _curve(log_pressure: np.ndarray, *rows):
    """The cubic spline through the rows where that rises throughout, else the monotone cubic of Fritsch and Carlson."""
    if len(log_pressure) >= _FEWEST_ROWS:
        spline = _through(CubicSpline, log_pressure, *rows)
        if np.all(spline(_finer(log_pressure, _FIRST), 1) > 0):
            return spline
    return _through(PchipInterpolator, log_pressure, *rows)


def _piece(log_pressure: np.ndarray, log_density: np.ndarray, by_energy: bool, start: float):
    """The stretch from eta = start, and the eta at its end; knots are added until the density rises everywhere."""
    curve, parts = _curve(log_pressure, log_density, by_energy, start), _FIRST
    while parts <= _FINEST:
        fine = _finer(log_pressure, parts)
        eta = _enthalpy(curve, start, fine)
        x, slope = np.log(eta), eta * np.exp(curve(fine) - fine)
        piece = TablePiece(x.tolist(), fine.tolist(), slope.tolist())
        inside = np.exp(np.linspace(x[:-1], x[1:], 9)[1:-1].ravel())
        rise, bend = np.array([piece._cubic(float(value))[1:] for value in inside]).T
        if np.all(rise > 1) and np.all(rise * (rise - 1) + bend > 0):
            return piece, float(eta[-1])
        parts *= 2
    raise ValueError("the table is too rough: no smooth curve with a rising density passes through its rows")


def _rows(name: str, values, count: int) -> np.ndarray:
    rows = np.asarray(values, dtype=float)
    if rows.shape != (count,) or count < _FEWEST_ROWS:
        raise ValueError(f"a table needs {_FEWEST_ROWS} or more whole rows, not {count} with {name} of {rows.shape}")
    if not np.all(np.isfinite(rows) & (rows > 0)):
        raise ValueError(f"every {name} of a table must be positive and finite")
    wrong = np.flatnonzero(np.diff(rows) < 0)
    if wrong.size:
        raise ValueError(f"{name} must rise from row to row; it falls after row {wrong[0]}: {rows[wrong[0]]:.6g}, "
                         f"then {rows[wrong[0] + 1]:.6g}")  # fmt: skip
    return rows


@with_quantities(pressure=None)
def tabulated(pressure, energy_density=None, rest_density=None, name: str = "table") -> Barotrope:
    """The equation of state of a table: rows of pressure with energy density or rest-mass density, or both.

    Arrays of one length, rising, in geometric units (G = c = Msun = 1). With both densities the energy density counts
    and the rest-mass density is checked against the first law (to 2%, up to a constant factor: the mass of a baryon).
    A power law P = K rho0^gamma is kept exactly, another smooth law to 2e-5 by four rows a decade of pressure and to
    1e-6 by ten. Below the first row the pressure falls to zero as a power of rho0 with the gamma of the first two rows;
    beyond the last one the equation is not given. ValueError for tables that are not monotone, too short, or not those
    of matter. Sound faster than light is allowed (`Barotrope.causal_up_to` tells).

    >>> rest = np.geomspace(1e-6, 1e-2, 30)
    >>> table = tabulated(100 * rest**2, rest_density=rest)  # a polytrope of gamma = 2
    >>> print(f"{table.enthalpy_of('pressure', 1e-4):.6f}")  # 2 K rho
    0.200000
    """
    if energy_density is None and rest_density is None:
        raise ValueError("a table needs energy_density or rest_density beside the pressure")
    by_energy = energy_density is not None
    P = _rows("pressure", pressure, np.size(pressure))
    density = (
        _rows("energy_density", energy_density, len(P)) if by_energy else _rows("rest_density", rest_density, len(P))
    )
    still = np.flatnonzero(np.diff(density) == 0)
    if still.size:
        raise ValueError(f"rows {still[0]} and {still[0] + 1} of the table have the same density")

    surface_density, index = _surface(P[:2], density[:2], by_energy)
    start = (index + 1) * P[0] / surface_density
    edges = [0.0, start]
    pieces: list[Piece] = [PowerLaw(float(surface_density), float(start), 0.0, index)]
    transitions = np.flatnonzero(np.diff(P) == 0)
    if np.any(np.diff(transitions) == 1):
        raise ValueError("a phase transition is two rows of the same pressure, not more")
    for low, high in zip([0, *(transitions + 1)], [*(transitions + 1), len(P)], strict=True):
        if high - low < 2:
            raise ValueError("between two phase transitions a table needs two or more rows")
        piece, end = _piece(np.log(P[low:high]), np.log(density[low:high]), by_energy, edges[-1])
        pieces.append(piece)
        edges.append(end)
    equation = Barotrope(name, tuple(edges), tuple(pieces))
    if by_energy and rest_density is not None:
        _check_first_law(equation, P, _rows("rest_density", rest_density, len(P)))
    return equation


def _surface(pressure: np.ndarray, density: np.ndarray, by_energy: bool) -> tuple[float, float]:
    """Rest-mass density at the first of two rows, and n of P ~ rho0^(1 + 1/n) through both: rho0 is e - n P."""
    rest, index = density, 0.0
    for _ in range(_SURFACE_STEPS if by_energy else 1):
        rise = math.log(rest[1] / rest[0]) if rest[1] > rest[0] > 0 else math.inf
        gamma = math.log(pressure[1] / pressure[0]) / rise
        if gamma <= 1:
            raise ValueError(
                f"the table's first rows have gamma {gamma:.3g}: a surface of zero pressure needs one above 1"
            )
        index = 1 / (gamma - 1)
        rest = density - index * pressure if by_energy else density
        if rest[0] <= 0:
            raise ValueError("the table begins at too high a pressure for its density to end at a surface")
    return float(rest[0]), index


def _check_first_law(equation: Barotrope, pressure: np.ndarray, rest_density: np.ndarray) -> None:
    distinct = np.concatenate([[True], np.diff(pressure) > 0])
    eta = [equation.enthalpy_of("pressure", float(value)) for value in pressure[distinct][:-1]]
    factor = rest_density[distinct][:-1] / equation.rest_density(eta)
    spread = float(np.max(np.abs(factor / factor[0] - 1)))
    if spread > _FIRST_LAW:
        raise ValueError(f"the table's rest densities differ by {100 * spread:.2g}% from those of the first law")
