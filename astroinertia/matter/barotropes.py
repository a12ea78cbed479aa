"""Laws between pressure and density for figures of equilibrium, in terms of the enthalpy e = int dP/rho.

A law has density(enthalpy), pressure(enthalpy), enthalpy(pressure), all increasing, and `surface_index`: where the
pressure is zero, the density vanishes as e^surface_index (0: it is finite there). Any consistent units. A
self-consistent field takes it scaled: as a function of x = e/e_max, in units of the largest density and of that times
e_max. Tests: tests/unit/matter/test_barotropes.py, tests/unit/bodies/test_scf.py.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities


class BarotropicLaw(Protocol):
    """What a figure needs to know of a material."""

    @property
    def surface_index(self) -> float:
        """The power of the enthalpy with which the density vanishes at zero pressure."""
        ...

    def density(self, enthalpy) -> np.ndarray:
        """Density at an enthalpy of 0 or more."""
        ...

    def pressure(self, enthalpy) -> np.ndarray:
        """Pressure at an enthalpy of 0 or more."""
        ...

    def enthalpy(self, pressure) -> np.ndarray:
        """Enthalpy at a pressure of 0 or more."""
        ...


@with_quantities(constant=None)
@dataclass(frozen=True)
class PolytropicLaw:
    """P = K rho^(1 + 1/n) with index n > 0: e = (n + 1) K rho^(1/n).

    >>> law = PolytropicLaw(1.5)
    >>> print(f"{law.pressure(law.enthalpy(2.0)):.6f} {law.pressure(2.0) / law.density(2.0) ** (5 / 3):.6f}")
    2.000000 1.000000
    """

    index: float
    constant: float = 1.0

    def __post_init__(self) -> None:
        if not (self.index > 0 and self.constant > 0):
            raise ValueError("a polytropic law needs an index and a constant above zero")

    @property
    def surface_index(self) -> float:
        """n."""
        return self.index

    def density(self, enthalpy) -> np.ndarray:
        """(e/((n + 1) K))^n."""
        return (np.asarray(enthalpy) / ((self.index + 1) * self.constant)) ** self.index

    def pressure(self, enthalpy) -> np.ndarray:
        """Rho e/(n + 1)."""
        return self.density(enthalpy) * enthalpy / (self.index + 1)

    def enthalpy(self, pressure) -> np.ndarray:
        """(n + 1) K^(n/(n + 1)) P^(1/(n + 1))."""
        n = self.index
        return (n + 1) * self.constant ** (n / (n + 1)) * np.asarray(pressure) ** (1 / (n + 1))


@with_quantities(value="kg m-3")
@dataclass(frozen=True)
class Incompressible:
    """One density at any pressure: e = P/rho.

    >>> print(Incompressible(2.0).enthalpy(np.array([0.0, 1.0])))  # P/rho
    [0.  0.5]
    """

    value: float

    def __post_init__(self) -> None:
        if not self.value > 0:
            raise ValueError("a density must be above zero")

    @property
    def surface_index(self) -> float:
        """0."""
        return 0.0

    def density(self, enthalpy) -> np.ndarray:
        """The density."""
        return np.full_like(np.asarray(enthalpy, dtype=float), self.value)

    def pressure(self, enthalpy) -> np.ndarray:
        """Rho e."""
        return self.value * np.asarray(enthalpy)

    def enthalpy(self, pressure) -> np.ndarray:
        """P/rho."""
        return np.asarray(pressure) / self.value


_ROWS = 2000  # of a condensed law's table


@dataclass(frozen=True, eq=False)
class CondensedLaw:
    """A solid or liquid with a smooth P(rho) from `zero_density` > 0, where it is zero, up to `largest_density`.

    By cubic splines of a table of 2000 densities: a figure asks a law some ten thousand times. A smooth law is kept to
    3e-10 of itself, also where its pressure vanishes. Densities beyond the largest are refused with ValueError.

    >>> law = CondensedLaw(lambda rho: rho - 1, zero_density=1.0, largest_density=3.0)  # P = rho - 1: h = ln(rho)
    >>> print(f"{law.density(np.log(2.0)):.9f}")
    2.000000000
    """

    pressure_of_density: Callable
    zero_density: float
    largest_density: float
    surface_index: float = field(default=0.0, init=False)
    _splines: dict[str, CubicSpline | CubicHermiteSpline] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not 0 < self.zero_density < self.largest_density:
            raise ValueError("a condensed law needs 0 < zero_density < largest_density")
        density = self.zero_density * np.linspace(1.0, self.largest_density / self.zero_density, _ROWS)
        pressure = np.asarray(self.pressure_of_density(density), dtype=float)
        pressure = pressure - pressure[0]
        # By parts, as slopes at the end of a spline are less exact than the values, and all there is at the surface.
        enthalpy = pressure / density + CubicSpline(density, pressure / density**2).antiderivative()(density)
        splines = {
            "density": CubicSpline(enthalpy, density),
            "pressure": CubicHermiteSpline(enthalpy, pressure, density),
            "enthalpy": CubicHermiteSpline(pressure, enthalpy, 1 / density),
        }
        object.__setattr__(self, "_splines", splines)

    def _at(self, name: str, value) -> np.ndarray:
        spline = self._splines[name]
        if np.any(np.asarray(value) > spline.x[-1]):
            raise ValueError(f"the pressure is beyond that of the largest density {self.largest_density:g} of the law")
        return spline(value)

    def density(self, enthalpy) -> np.ndarray:
        """Density at an enthalpy."""
        return self._at("density", enthalpy)

    def pressure(self, enthalpy) -> np.ndarray:
        """Pressure at an enthalpy."""
        return self._at("pressure", enthalpy)

    def enthalpy(self, pressure) -> np.ndarray:
        """Enthalpy at a pressure."""
        return self._at("enthalpy", pressure)


SOFTEST = 4.5  # index up to which the iteration converges to round-off and the virial theorem to 1e-6 (measured)
_SMALLEST = 1e-200  # of h_max: where a law is asked for nothing at all, for its logarithms' sake
_FINER = 8  # intervals between two rows of a table for the spline of its enthalpy


@dataclass(frozen=True, eq=False)
class TabulatedLaw:
    """A table of pressure and density, both above zero and ascending: a cubic spline of ln rho by ln P.

    Below the first row it goes on as the polytrope that touches it there. Beyond the last it is refused with
    ValueError. Rows of a smooth law a factor of 2 apart in pressure keep it to 3e-6, of 1.1 to 1e-10.

    >>> pressures = np.geomspace(1e-6, 1.0, 30)
    >>> law = TabulatedLaw(pressures, pressures ** (3 / 5))  # of a polytrope of n = 3/2
    >>> print(f"{law.surface_index:.6f} {law.density(2.5 * 0.25 ** (2 / 5)) / 0.25 ** (3 / 5):.6f}")
    1.500000 1.000000
    """

    pressures: np.ndarray
    densities: np.ndarray
    _log_density: CubicSpline = field(init=False, repr=False)
    _log_enthalpy: CubicHermiteSpline = field(init=False, repr=False)
    _log_pressure: CubicHermiteSpline = field(init=False, repr=False)
    _first_index: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        pressures, densities = np.asarray(self.pressures, dtype=float), np.asarray(self.densities, dtype=float)
        rows = np.array([pressures, densities])
        if pressures.ndim != 1 or len(pressures) < 4 or pressures.shape != densities.shape:
            raise ValueError("a table needs four rows or more of one pressure and one density")
        if not (np.all(np.isfinite(rows)) and np.all(rows > 0) and np.all(np.diff(rows, axis=1) > 0)):
            raise ValueError("pressures and densities of a table must be above zero and ascend")
        knots = np.log(pressures)
        spline = CubicSpline(knots, np.log(densities))
        steepness = float(spline(knots[0], 1))
        if not 0 < steepness < 1:
            raise ValueError(
                "the density of a table must rise with a power of the pressure between 0 and 1 at its start"
            )
        index = steepness / (1 - steepness)
        finer = np.interp(np.arange((len(knots) - 1) * _FINER + 1) / _FINER, np.arange(len(knots)), knots)
        points, weights = np.polynomial.legendre.leggauss(4)
        width = np.diff(finer)[:, None]
        inside = finer[:-1, None] + width * (points + 1) / 2
        steps = np.exp(inside - spline(inside)) @ weights * width[:, 0] / 2  # of de = (P/rho) dlnP
        start = (index + 1) * pressures[0] / densities[0]
        enthalpy = start + np.concatenate([[0.0], np.cumsum(steps)])
        slope = np.exp(finer - spline(finer)) / enthalpy
        object.__setattr__(self, "_log_density", spline)
        object.__setattr__(self, "_log_enthalpy", CubicHermiteSpline(finer, np.log(enthalpy), slope))
        object.__setattr__(self, "_log_pressure", CubicHermiteSpline(np.log(enthalpy), finer, 1 / slope))
        object.__setattr__(self, "_first_index", index)

    @property
    def surface_index(self) -> float:
        """The index of the polytrope that goes on below the first row."""
        return self._first_index

    def _beyond(self, value, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The logarithm of a value within the table, and by what factor it is below it."""
        value = np.asarray(value, dtype=float)
        first, last = np.exp(knots[0]), np.exp(knots[-1])
        if np.any(value > last * (1 + 1e-12)):
            raise ValueError("the body asks for more pressure than the table goes to")
        return np.log(np.clip(value, first, last)), np.minimum(value / first, 1.0)

    def density(self, enthalpy) -> np.ndarray:
        """Density at an enthalpy."""
        inside, below = self._beyond(enthalpy, self._log_pressure.x)
        return np.exp(self._log_density(self._log_pressure(inside))) * below**self._first_index

    def pressure(self, enthalpy) -> np.ndarray:
        """Pressure at an enthalpy."""
        inside, below = self._beyond(enthalpy, self._log_pressure.x)
        return np.exp(self._log_pressure(inside)) * below ** (self._first_index + 1)

    def enthalpy(self, pressure) -> np.ndarray:
        """Enthalpy at a pressure."""
        inside, below = self._beyond(pressure, self._log_enthalpy.x)
        return np.exp(self._log_enthalpy(inside)) * below ** (1 / (self._first_index + 1))


@dataclass(frozen=True)
class ScaledLaw:
    """density(x)/rho_max and pressure(x)/(rho_max h_max); max_density and max_enthalpy are None where all scales do."""

    name: str
    density: Callable[[np.ndarray], np.ndarray]
    pressure: Callable[[np.ndarray], np.ndarray]
    max_density: float | None = None
    max_enthalpy: float | None = None


@with_quantities()
@lru_cache(maxsize=16)
def polytropic_matter(index: float) -> ScaledLaw:
    """Return P = K rho^(1 + 1/n): rho ~ h^n, P = rho h/(n + 1); ValueError outside 0 <= n <= 4.5. n = 0 is a liquid.

    Source: Hachisu 1986, ApJS 61, 479, eq. 6. Test: tests/unit/bodies/test_scf.py.

    >>> matter = polytropic_matter(1.5)
    >>> print(float(matter.density(np.array(0.25))), float(matter.pressure(np.array(1.0))))  # x^n, 1/(n + 1)
    0.125 0.4
    """
    n = float(index)
    if not 0 <= n <= SOFTEST:
        raise ValueError(f"a rotating polytrope needs an index 0 <= n <= {SOFTEST}, not {index}: cores get too small")
    return ScaledLaw(
        name=f"polytrope of index {n:g}",
        density=lambda x: np.where(x > 0, np.maximum(x, 0.0) ** n, 0.0),
        pressure=lambda x: np.maximum(x, 0.0) ** (n + 1) / (n + 1),
    )


def matter_of(law: BarotropicLaw, max_enthalpy: float, name: str = "barotrope") -> ScaledLaw:
    """Return the matter of a law up to a largest enthalpy, in the law's units; ValueError unless that is positive.

    Test: tests/unit/bodies/test_scf.py.

    >>> matter = matter_of(PolytropicLaw(1.5), 2.0)
    >>> print(f"{matter.max_density:.6f} {matter.density(np.array(0.25)):.6f}")  # (2/2.5)^1.5, and 0.25^1.5
    0.715542 0.125000
    """
    require_positive(max_enthalpy=max_enthalpy)
    densest = float(law.density(np.array([max_enthalpy]))[0])

    def scaled(curve, unit):
        return lambda x: np.where(x > 0, curve(np.maximum(x, _SMALLEST) * max_enthalpy), 0.0) / unit

    return ScaledLaw(
        name, scaled(law.density, densest), scaled(law.pressure, densest * max_enthalpy), densest, float(max_enthalpy)
    )
