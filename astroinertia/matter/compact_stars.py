"""Cold equations of state for compact stars: rest-mass density, pressure and energy density along one enthalpy.

The variable is the specific enthalpy eta = integral of dP/rho0 = (e + P)/rho0 - 1, zero at the surface, with rho0 the
rest-mass density and e = rho0 (1 + eta) - P the energy density: the first law de = (1 + eta) drho0 then holds by
construction. A Newtonian star uses eta and rho0 alone, a relativistic one the log-enthalpy ln(1 + eta). Units are
geometric, G = c = Msun = 1, in everything but the arguments that are named otherwise (`geometric_density`,
`geometric_pressure`).

Sources: Read, Lackey, Owen & Friedman 2009, PRD 79, 124032; Lindblom 1992, ApJ 398, 569.
"""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise
from typing import Protocol

import numpy as np

from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between
from astroinertia.storage.data_tables import data_rows
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SPEED_OF_LIGHT

SOLAR_LENGTH = GRAVITATIONAL_CONSTANT * SOLAR_MASS / SPEED_OF_LIGHT**2  # m; 1.4766250 km
_SOLAR_DENSITY = SOLAR_MASS / SOLAR_LENGTH**3  # kg m-3

_QUANTITIES = ("rest_density", "pressure", "energy_density")
_ROUNDING = 1e-13  # a value this close to that at an edge is the edge
_BEYOND = 709.0  # ln of what numbers hold: the density of an almost isothermal gas grows past that at once
_NEARER = 16.0  # by which a bound of eta comes down to the order of magnitude of the value looked for
_SMALLEST = math.ulp(0.0)
_CGS_DENSITY = 1e3  # kg m-3 in one g cm-3
_CGS_PRESSURE = 0.1  # Pa in one dyn cm-2

# Read et al. 2009, Table II and Eq. (B1): the crust of SLy (Douchin & Haensel 2001); only the first constant is free.
SLY_CRUST_CONSTANT = 6.80110e-9  # P/c^2 over rho0^gamma, g and cm
SLY_CRUST_GAMMAS = (1.58425, 1.28733, 0.62223, 1.35692)
SLY_CRUST_DENSITIES = (2.44034e7, 3.78358e11, 2.62780e12)  # g cm-3
READ_DENSITIES = (10**14.7, 10**15.0)  # g cm-3; the pressure p1 is that at the first


class Piece(Protocol):
    """One smooth stretch of an equation of state."""

    def at(self, enthalpy: float) -> tuple[float, float, float]:
        """Rest-mass density, pressure and energy density at eta."""
        ...

    def sound_speed_squared(self, enthalpy: float) -> float:
        """Return dP/de at eta, in c^2."""
        ...


@dataclass(frozen=True)
class PowerLaw:
    """P = K rho0^(1 + 1/index) with an offset of energy: rho0 = density ((eta - offset)/scale)^index."""

    density: float
    scale: float
    offset: float
    index: float

    def at(self, enthalpy: float) -> tuple[float, float, float]:
        """Rest-mass density, pressure and energy density at eta."""
        depth = enthalpy - self.offset
        density = self.density * (depth / self.scale) ** self.index
        pressure = density * depth / (self.index + 1)
        return density, pressure, density * (1 + self.offset) + self.index * pressure

    def sound_speed_squared(self, enthalpy: float) -> float:
        """Return dP/de at eta, in c^2; infinite for constant density."""
        depth = enthalpy - self.offset
        return math.inf if self.index == 0 else depth / (self.index * (1 + enthalpy))


@dataclass(frozen=True)
class EnergyPowerLaw:
    """P = K e^(1 + 1/index) with e the energy density: 1 + eta = (1 + K e^(1/index))^(index + 1)."""

    constant: float
    index: float

    def at(self, enthalpy: float) -> tuple[float, float, float]:
        """Rest-mass density, pressure and energy density at eta."""
        ratio = math.expm1(math.log1p(enthalpy) / (self.index + 1))  # P/e
        energy = (ratio / self.constant) ** self.index
        return energy * (1 + ratio) / (1 + enthalpy), energy * ratio, energy

    def sound_speed_squared(self, enthalpy: float) -> float:
        """Return dP/de at eta, in c^2."""
        return (1 + 1 / self.index) * math.expm1(math.log1p(enthalpy) / (self.index + 1))


@dataclass(frozen=True)
class Barotrope:
    """A cold equation of state: smooth pieces between values of eta, at which the density may jump.

    edges has one entry more than pieces: 0, the breaks, and the largest eta that the equation covers (inf: no limit).
    """

    name: str
    edges: tuple[float, ...]
    pieces: tuple[Piece, ...]

    @property
    def largest_enthalpy(self) -> float:
        """The eta up to which the equation is given."""
        return self.edges[-1]

    def piece_at(self, enthalpy: float) -> Piece:
        """The piece that holds eta, the lower one at a break; ValueError beyond the largest eta."""
        if not 0 <= enthalpy <= self.edges[-1] or math.isinf(enthalpy):
            raise ValueError(
                f"equation of state {self.name}: an enthalpy of {enthalpy:.6g} lies outside 0 to {self.edges[-1]:.6g}"
            )
        place = int(np.searchsorted(self.edges, enthalpy, side="left")) - 1
        return self.pieces[max(place, 0)]

    def _values(self, enthalpy) -> np.ndarray:
        flat = np.atleast_1d(np.asarray(enthalpy, dtype=float))
        values = np.array([self._at(float(value)) for value in flat.ravel()])
        return values.T.reshape(3, *np.shape(enthalpy))

    def _at(self, enthalpy: float) -> tuple[float, float, float]:
        with suppress(OverflowError, ZeroDivisionError):
            values = self.piece_at(enthalpy).at(enthalpy)
            if all(map(math.isfinite, values)):
                return values
        raise ValueError(
            f"equation of state {self.name}: at an enthalpy of {enthalpy:.6g} its pressure is beyond what numbers hold"
        )

    def rest_density(self, enthalpy) -> np.ndarray:
        """rho0 at eta, of the same shape."""
        return self._values(enthalpy)[0]

    def pressure(self, enthalpy) -> np.ndarray:
        """P at eta, of the same shape."""
        return self._values(enthalpy)[1]

    def energy_density(self, enthalpy) -> np.ndarray:
        """e = rho0 (1 + eta) - P at eta, of the same shape."""
        return self._values(enthalpy)[2]

    def sound_speed_squared(self, enthalpy) -> np.ndarray:
        """dP/de at eta, in c^2, of the same shape."""
        flat = np.atleast_1d(np.asarray(enthalpy, dtype=float)).ravel()
        squares = [self.piece_at(float(value)).sound_speed_squared(float(value)) for value in flat]
        return np.array(squares).reshape(np.shape(enthalpy))

    def causal_up_to(self, enthalpy: float) -> bool:
        """Whether sound is nowhere faster than light below eta (32 points a piece)."""
        for low, high, piece in zip(self.edges, self.edges[1:], self.pieces, strict=False):
            if low < enthalpy:
                points = np.linspace(low, min(high, enthalpy), 33)[1:]
                if max(piece.sound_speed_squared(float(point)) for point in points) > 1:
                    return False
        return True

    def enthalpy_of(self, quantity: str, value: float) -> float:
        """Return eta where `rest_density`, `pressure` or `energy_density` has the value, to 1e-14.

        ValueError above the largest value, inside a jump of density, for a value that is not positive, and where eta
        is none that numbers hold.
        """
        if quantity not in _QUANTITIES:
            raise ValueError(f"eta follows from rest_density, pressure or energy_density, not from {quantity!r}")
        require_positive(**{f"the central {quantity}": value})

        def excess(enthalpy: float, piece: Piece) -> float:
            """The logarithm of the quantity over the value, or how far numbers go."""
            try:
                ratio = float(piece.at(enthalpy)[_QUANTITIES.index(quantity)]) / float(value)
            except (OverflowError, ZeroDivisionError):
                return _BEYOND
            if not math.isfinite(ratio):
                return _BEYOND
            return math.log(ratio) if ratio > 0 else -_BEYOND

        wanted = f"{quantity} = {value:.6g}"
        try:
            for low, high, piece in zip(self.edges, self.edges[1:], self.pieces, strict=False):
                of_piece = partial(excess, piece=piece)
                high = _reaching(of_piece, low, wanted) if math.isinf(high) else high
                if of_piece(high) >= -_ROUNDING:
                    return _root_within(of_piece, low, high, wanted)
            most = value * math.exp(excess(self.edges[-1], self.pieces[-1]))
            raise ValueError(f"{wanted} lies above the largest that it covers, {most:.6g}")
        except ValueError as error:
            raise ValueError(f"equation of state {self.name}: {error}") from None


def _reaching(excess: Callable[[float], float], low: float, wanted: str) -> float:
    """An enthalpy of a piece without end at which the excess is not negative; ValueError where there is none."""
    high = max(2 * low, 1.0)
    while excess(high) < 0:
        high *= 4
        if math.isinf(high):
            raise ValueError(f"it never reaches {wanted}")
    return high


def _root_within(excess: Callable[[float], float], low: float, high: float, wanted: str) -> float:
    """The enthalpy of a piece at which the excess is nothing, to 1e-14; ValueError where there is none."""
    if excess(low) > _ROUNDING:
        raise ValueError(f"{wanted} lies inside a jump of density")
    if excess(low) >= 0:
        return low
    if excess(high) <= 0:
        return high
    while excess(nearer := max(low, high / _NEARER)) > 0:
        high = nearer
    if nearer == 0.0:
        raise ValueError(f"{wanted} is that of an enthalpy below what numbers hold")
    return root_between(excess, nearer, high, _SMALLEST, 8.9e-16)


@with_quantities()
def geometric_density(density) -> np.ndarray:
    """Density in units of G = c = Msun = 1 from one in kg m-3.

    >>> print(f"{geometric_density(2.7e17):.2e}")  # of nuclear matter
    4.37e-04
    """
    return np.asarray(density, dtype=float) / _SOLAR_DENSITY


@with_quantities()
def geometric_pressure(pressure) -> np.ndarray:
    """Pressure in units of G = c = Msun = 1 from one in Pa.

    >>> print(f"{geometric_pressure(1e34):.2e}")
    1.80e-04
    """
    return np.asarray(pressure, dtype=float) / (_SOLAR_DENSITY * SPEED_OF_LIGHT**2)


def polytrope(constant: float, gamma: float) -> Barotrope:
    """P = K rho0^gamma with e = rho0 + P/(gamma - 1); ValueError unless K > 0 and gamma > 1.

    >>> print(polytrope(100.0, 2.0).name)
    polytrope of gamma 2
    """
    return piecewise_polytrope(constant, [gamma], [], name=f"polytrope of gamma {gamma:g}")


def energy_polytrope(constant: float, gamma: float) -> Barotrope:
    """P = K e^gamma of the energy density (Tooper 1964, ApJ 140, 434); ValueError unless K > 0 and gamma > 1.

    >>> print(energy_polytrope(100.0, 2.0).name)
    energy polytrope of gamma 2
    """
    require_positive(constant=constant, **{"gamma - 1": gamma - 1})
    return Barotrope(
        f"energy polytrope of gamma {gamma:g}", (0.0, math.inf), (EnergyPowerLaw(constant, 1 / (gamma - 1)),)
    )


@with_quantities(density=None)
def constant_density(density: float) -> Barotrope:
    """The incompressible star e = rho0 = density (Schwarzschild 1916); ValueError unless density > 0.

    >>> print(constant_density(1e-3).name)
    constant density
    """
    require_positive(density=density)
    return Barotrope("constant density", (0.0, math.inf), (PowerLaw(density, 1.0, 0.0, 0.0),))


@with_quantities(densities=None)
def piecewise_polytrope(
    constant: float,
    gammas: Sequence[float],
    densities: Sequence[float],
    jumps: Sequence[float] | None = None,
    name: str = "piecewise polytrope",
) -> Barotrope:
    """P = K_i rho0^gamma_i between the dividing rest densities, P and eta continuous.

    constant: K of the outermost piece; gammas: outermost first, one more than `densities` (ascending), the density at
    which each piece ends; jumps: the factor by which the density rises there (1: none). ValueError for anything else.
    Source: Read et al. 2009, Eqs. (5) to (9).

    >>> print(piecewise_polytrope(100.0, [2.0, 3.0], [1e-3]).name)
    piecewise polytrope
    """
    densities = [float(value) for value in densities]
    jumps = [1.0] * len(densities) if jumps is None else [float(value) for value in jumps]
    if len(gammas) != len(densities) + 1 or len(jumps) != len(densities):
        raise ValueError(
            f"{len(gammas)} gammas need {len(gammas) - 1} dividing densities and as many jumps, "
            f"not {len(densities)} and {len(jumps)}"
        )
    require_positive(constant=constant, gammas=gammas, densities=densities)
    if any(value < 1 or not math.isfinite(value) for value in jumps):
        raise ValueError(f"jumps are factors of 1 or more by which the density rises inwards, not {jumps}")
    if any(high <= low * jump for (low, high), jump in zip(pairwise(densities), jumps, strict=False)):
        raise ValueError("the dividing densities must ascend, each above the density after the jump before it")
    if gammas[0] <= 1 or any(value == 1 for value in gammas):
        raise ValueError(f"the outermost gamma must be above 1 and none may be 1, not {list(gammas)}")

    index = 1 / (gammas[0] - 1)
    density = densities[0] if densities else 1.0
    edges, pieces = [0.0], []
    scale, offset = (index + 1) * constant * density ** (gammas[0] - 1), 0.0
    for i, gamma in enumerate(gammas):
        index = 1 / (gamma - 1)
        if i > 0:
            pressure = pieces[-1].at(edges[-1])[1]
            density = densities[i - 1] * jumps[i - 1]
            scale = (index + 1) * pressure / density
            offset = edges[-1] - scale
        pieces.append(PowerLaw(density, scale, offset, index))
        if i < len(densities):
            edges.append(offset + scale * (densities[i] / density) ** (gamma - 1))
    largest = math.inf if gammas[-1] > 1 else pieces[-1].offset  # to which eta goes where the density has no bound
    return Barotrope(name, (*edges, largest), tuple(pieces))


@lru_cache(maxsize=1)
def read2009_table() -> dict[str, dict[str, float]]:
    """Table III of Read et al. 2009 by name: `log10_p1` (dyn cm-2), `gamma1`, `gamma2`, `gamma3`.

    >>> print(len(read2009_table()))
    34
    """
    rows = data_rows("read2009.csv")
    return {row["name"]: {key: float(row[key]) for key in row if key != "name"} for row in rows}


@with_quantities()
def read2009(name: str) -> Barotrope:
    """The piecewise polytrope of Read et al. 2009 for the named equation of state, on the crust of SLy.

    ValueError for a name that is not in their Table III (data/read2009.csv).

    >>> print(read2009("SLy").name)
    SLy
    """
    table = read2009_table()
    if name not in table:
        raise ValueError(f"Read et al. 2009 have no equation of state {name!r}; theirs are {', '.join(table)}")
    row = table[name]
    return four_parameter(row["log10_p1"], row["gamma1"], row["gamma2"], row["gamma3"], name=name)


def four_parameter(
    log10_p1: float, gamma1: float, gamma2: float, gamma3: float, name: str = "four parameters"
) -> Barotrope:
    """The parametrised equation of Read et al. 2009: p1 in dyn cm-2 at 10^14.7 g cm-3, three gammas, crust of SLy.

    The first core piece begins where it meets the crust; ValueError where that is not between the crust's last
    dividing density and 10^14.7 g cm-3.

    >>> print(four_parameter(34.384, 3.005, 2.988, 2.851, name="mine").name)  # these are of SLy
    mine
    """
    require_positive(log10_p1=log10_p1, gamma1=gamma1, gamma2=gamma2, gamma3=gamma3)
    crust_pressure = SLY_CRUST_CONSTANT * (100 * SPEED_OF_LIGHT) ** 2  # K rho0^gamma in dyn cm-2
    constant = crust_pressure
    for (outer, inner), density in zip(pairwise(SLY_CRUST_GAMMAS), SLY_CRUST_DENSITIES, strict=True):
        constant *= density ** (outer - inner)
    log_core = log10_p1 - gamma1 * math.log10(READ_DENSITIES[0])  # log10 K of the first core piece
    join = 10 ** ((log_core - math.log10(constant)) / (SLY_CRUST_GAMMAS[-1] - gamma1))
    if not SLY_CRUST_DENSITIES[-1] < join < READ_DENSITIES[0]:
        raise ValueError(
            f"log10 p1 = {log10_p1} with gamma1 = {gamma1} meets the crust at {join:.3g} g/cm3, "
            f"not between {SLY_CRUST_DENSITIES[-1]:.3g} and {READ_DENSITIES[0]:.3g}"
        )
    densities = geometric_density(_CGS_DENSITY * np.array([*SLY_CRUST_DENSITIES, join, *READ_DENSITIES]))
    outermost = geometric_pressure(_CGS_PRESSURE * crust_pressure * SLY_CRUST_DENSITIES[0] ** SLY_CRUST_GAMMAS[0])
    return piecewise_polytrope(
        float(outermost / densities[0] ** SLY_CRUST_GAMMAS[0]),
        [*SLY_CRUST_GAMMAS, gamma1, gamma2, gamma3],
        densities.tolist(),
        name=name,
    )
