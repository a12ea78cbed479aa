"""Fluid Love numbers and apsidal constants of polytropes: Clairaut's equation along the Lane-Emden solution.

With eta = d ln(flattening)/d ln r of degree l and D the density over the mean density inside, delta = l + 1 - eta obeys

    r delta' = delta^2 - (2l + 1) delta + 6 D (l + 2 - delta),    delta = 3 at the centre,
    k_l = delta/(2l + 1 - delta) at the surface.

This is Radau's equation for the difference from the eta of a point mass: so k_l keeps its
digits in condensed stars, where it is small. The apsidal constant of a star in a binary is k_l/2.
Units of the zones: 4 pi G = central density = central enthalpy = 1, so that r = xi and m = -xi^2 theta' in a core.
Sources: Radau 1885; Sterne 1939, MNRAS 99, 451; Brooker & Olle 1955, MNRAS 115, 101. Tests:
tests/unit/bodies/test_apsidal.py.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp

from astroinertia.bodies.polytrope import central_series, lane_emden
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities

DEGREES = (2, 3, 4, 5, 6, 7, 8)
CORE_START = 1e-3  # xi up to which two terms of the series at the centre are exact to round-off of the totals
ROUND_OFF = 2.3e-14  # relative tolerance of the integration: about the smallest that it takes
_ABSOLUTE = 1e-40
_STEPS = 64  # least number of steps through a zone at that tolerance
_INTEGRALS = 5


@dataclass(frozen=True, eq=False)
class Zone:
    """A layer with P ~ rho^(1 + 1/n) at nodes of t, density ~ t^(4 n) and enthalpy ~ t^4, from below upwards.

    m = int rho r^2 dr, moment = int rho r^4 dr, binding = int rho m r dr, volume_work = int P r^2 dr, and delta of each
    degree (degree, node).
    """

    index: float
    t: np.ndarray
    r: np.ndarray
    mass: np.ndarray
    moment: np.ndarray
    binding: np.ndarray
    volume_work: np.ndarray
    delta: np.ndarray

    @property
    def end(self) -> np.ndarray:
        """The state at the top, with which the next zone begins."""
        parts = (self.r, self.mass, self.moment, self.binding, self.volume_work, *self.delta)
        return np.array([part[-1] for part in parts])


def complement_slope(delta: np.ndarray, density_over_mean, degrees: np.ndarray) -> np.ndarray:
    """Return r d delta/dr of delta = l + 1 - eta, one for each degree l; delta never jumps, and is 3 at a centre.

    Source: Radau 1885, with l + 1 - delta put for eta.
    """
    return delta**2 - (2 * degrees + 1) * delta + 6 * density_over_mean * (degrees + 2 - delta)


def integrate_zone(
    index: float,
    density: float,
    enthalpy: float,
    state: np.ndarray,
    t: np.ndarray,
    degrees: tuple[int, ...],
    tolerance: float = ROUND_OFF,
) -> Zone:
    """Integrate a zone of given density and enthalpy at t = 1 along the descending nodes t from `state` at t[0].

    NumericalError where the mass or radius grows beyond all bounds.
    """
    l_values = np.asarray(degrees, dtype=float)

    def slope(t, y):
        r, mass, delta = y[0], y[1], y[_INTEGRALS:]
        dr = -4 * t**3 * enthalpy * r**2 / mass
        rho = density * t ** (4 * index)
        pressure = rho * enthalpy * t**4 / (index + 1)
        rates = [1.0, rho * r**2, rho * r**4, rho * mass * r, pressure * r**2]
        if not degrees:  # several times as fast, for searches
            return [dr * rate for rate in rates]
        return dr * np.concatenate([rates, complement_slope(delta, rho * r**3 / (3 * mass), l_values) / r])

    longest = (t[0] - t[-1]) / _STEPS if tolerance == ROUND_OFF else np.inf
    solution = solve_ivp(slope, (t[0], t[-1]), state, method="DOP853", t_eval=t, rtol=tolerance, atol=_ABSOLUTE,
                         max_step=longest)  # fmt: skip
    if not (solution.success and np.all(np.isfinite(solution.y))):
        raise NumericalError(f"a polytropic zone of index {index:g} has no surface within reach: {solution.message}")
    return Zone(index, t, *solution.y[:_INTEGRALS], delta=solution.y[_INTEGRALS:])


def core_zone(index: float, t_end: float, nodes: int, degrees: tuple[int, ...], tolerance: float = ROUND_OFF) -> Zone:
    """Return the core from xi = CORE_START to theta = t_end^4, with nodes about equally far apart in radius."""
    n, xi = index, CORE_START
    theta, mass, moment = central_series(n, xi)
    t_start = float(theta) ** 0.25
    l_values = np.asarray(degrees, dtype=float)
    work = xi**3 / (3 * (n + 1)) - xi**5 / 30
    delta = 3 - 2 * n * (l_values - 1) / (5 * (2 * l_values + 3)) * xi**2
    state = np.concatenate([[xi, mass, moment, xi**5 / 15, work], delta])
    t = t_start + (t_end - t_start) * np.linspace(0.0, 1.0, nodes) ** 2
    return integrate_zone(n, 1.0, 1.0, state, t, degrees, tolerance)


def love_from_complement(delta: float, degree: int) -> float:
    """The fluid Love number k_l = delta/(2 l + 1 - delta) from delta at the surface.

    >>> print(f"{love_from_complement(3.0, 2):.2f}")  # 3/2 of a homogeneous body
    1.50
    """
    return delta / (2 * degree + 1 - delta)


@lru_cache(maxsize=64)
def _surface(index: float, degrees: tuple[int, ...]) -> np.ndarray:
    return core_zone(index, 0.0, 2, degrees).delta[:, -1]


@with_quantities()
def love_number(index: float, degree: int = 2) -> float:
    """Return the fluid Love number k_l of the polytrope of `index`, 3/(2 l - 2) for n = 0.

    Measured: 1e-14 relative against the closed forms of n = 0 and 1 for l = 2 to 8, and 3e-12 against 32-digit
    integrations up to n = 4.999. ValueError for an index outside 0 <= n < 5 or a degree below 2.
    Source: Brooker & Olle 1955.

    >>> print(f"{love_number(0.0):.6f} {love_number(1.0):.6f}")  # 3/2, and 15/pi^2 - 1
    1.500000 0.519818
    """
    lane_emden(float(index))  # says what is wrong with an index
    if not (degree >= 2 and degree % 1 == 0):
        raise ValueError(f"Love numbers need a whole degree of 2 or more, not {degree!r}")
    degrees = DEGREES if degree in DEGREES else (int(degree),)
    return float(love_from_complement(_surface(float(index), degrees)[degrees.index(degree)], degree))


@with_quantities()
def apsidal_constant(index: float, degree: int = 2) -> float:
    """Return the apsidal constant k_l/2 of the polytrope of `index`: what tables of binaries call k_l.

    Errors, source and tests: those of `love_number`.

    >>> print(f"{apsidal_constant(3.0):.6f}")  # as tables of binaries have it
    0.014443
    """
    return love_number(index, degree) / 2
