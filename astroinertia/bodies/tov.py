"""Structure of a non-rotating star of a cold equation of state, relativistic (TOV) or Newtonian, in the log-enthalpy.

With h = ln((e + P)/rho0) falling from h_c to exactly 0 at the surface, and instead of r and m(r) the variables

    U = r^2 e_c/h_c,   W = m/(r^3 e_c),   B = m_b/(r^3 e_c)   (e_c: central energy density, m_b: rest mass)

every equation is regular and of order one from white dwarfs to the most compact star, since h_c itself is the strength
of relativity (G = c = 1 below; primes are d/dln r; E = e/e_c, p = P/(e_c h_c)):

    f = 1 - 2 h_c U W = 1 - 2m/r,   q = W + 4 pi h_c p,   -d(h/h_c)/dln r = U q/f,
    U' = 2 U,   W' = 4 pi E - 3 W,   B' = 4 pi rho0/(e_c sqrt f) - 3 B.

Newton's star is the same with h_c = 0 in f and q, and h the specific enthalpy. Piece by piece of the equation of state
the independent variable is h/h_c in the inner half and its fourth root outside, so that breaks, jumps of
density and the surface are met exactly and fractional powers of the depth are smooth. Perturbations are integrated in
the same pass (slow_rotation.py).

Sources: Lindblom 1992, ApJ 398, 569; Oppenheimer & Volkoff 1939, Phys. Rev. 55, 374. Tests:
tests/unit/bodies/test_tov.py.
"""

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from scipy.integrate import solve_ivp

from astroinertia.errors import NumericalError
from astroinertia.matter.compact_stars import Barotrope, Piece
from astroinertia.process.positive import require_positive

TOLERANCE = 1e-11  # at the knee of tests/benchmarks/work_precision_tov.py
_ABSOLUTE = 1e-3  # absolute tolerance over the relative one; everything integrated is of order one
_START = 1e-5  # 1 - h/h_c of the first point: what the series drops changes the star by less than 1e-14
_MOST = 200_000  # slopes of one star; a polytrope of gamma 2 and a central eta of 1e100 takes 32,000, a usual star 2000
_SHALLOWEST = 1e-7  # least M/R over h_c: a polytrope of n = 4.9999 has 1e-5, one of n = 5 is infinite
_HANDOVER = 0.5  # h/h_c at which the fourth root takes over
_ROOT = 4  # h/h_c = t^4: rho0 ~ h^n becomes t^(4 n)


class Local(NamedTuple):
    """What a perturbation needs to know of the star at one radius, scaled as above."""

    depth: float  # 1 - h/h_c
    relativity: float  # h_c, or 0 for Newton's star
    U: float
    W: float
    E: float
    p: float
    f: float
    q: float


class Perturbation(Protocol):
    """Equations that ride along: y' = dy/dln r, linear or not, regular at the centre."""

    def start(self, here: Local) -> list[float]:
        """Values near the centre."""
        ...

    def slopes(self, here: Local, values: list[float]) -> list[float]:
        """dy/dln r."""
        ...


@dataclass(frozen=True, eq=False)
class Structure:
    """A star from the centre outwards, in geometric units (G = c = Msun = 1; without c for a Newtonian one).

    Arrays hold the points that the integrator chose, the centre first and the surface last.
    """

    relativistic: bool
    central_log_enthalpy: float  # of a Newtonian star: the specific enthalpy
    central_rest_density: float
    central_energy_density: float
    central_pressure: float
    mass: float
    rest_mass: float
    radius: float
    compactness: float  # M/R
    r: np.ndarray = field(repr=False)
    enclosed_mass: np.ndarray = field(repr=False)
    log_enthalpy: np.ndarray = field(repr=False)
    scaled_surface: tuple[float, float] = field(repr=False)  # U and W
    perturbation: np.ndarray = field(repr=False)  # (values, points); at the centre those of the first point beside it

    @property
    def relativity(self) -> float:
        """h_c of a relativistic star, 0 of a Newtonian one."""
        return self.central_log_enthalpy if self.relativistic else 0.0

    @property
    def lapse(self) -> np.ndarray:
        """exp(nu/2) = sqrt(-g_tt) at r, 1 throughout for a Newtonian star."""
        if not self.relativistic:
            return np.ones_like(self.r)
        return math.sqrt(1 - 2 * self.compactness) * np.exp(-self.log_enthalpy)


def _integrate(slope, start: float, end: float, values: list[float], tolerance: float):
    # U is 2 _START/q at the centre, which is tiny where pressure outweighs density by far; from there it grows.
    sizes = np.array([min(1.0, values[0] / _START), *[1.0] * (len(values) - 1)])
    absolute = _ABSOLUTE * tolerance * sizes
    solution = solve_ivp(slope, (start, end), values, method="DOP853", rtol=tolerance, atol=absolute)
    if not solution.success or not np.all(np.isfinite(solution.y[:, -1])):
        raise NumericalError(f"the structure of the star could not be integrated: {solution.message}")
    return solution.t, solution.y


class _Equations:
    """The equations of structure of one star, by the fraction of its central log-enthalpy h_c; e_c its energy there."""

    def __init__(
        self, equation_of_state: Barotrope, central_enthalpy: float, relativistic: bool,
        perturbation: Perturbation | None,
    ) -> None:  # fmt: skip
        self.relativistic, self.perturbation = relativistic, perturbation
        self.innermost = equation_of_state.piece_at(central_enthalpy)
        self.rest_density = float(equation_of_state.rest_density(central_enthalpy))
        self.pressure = float(equation_of_state.pressure(central_enthalpy))
        heavy = float(equation_of_state.energy_density(central_enthalpy))
        self.h_c = math.log1p(central_enthalpy) if relativistic else central_enthalpy
        self.e_c, self.left = heavy if relativistic else self.rest_density, _MOST
        if self.pressure < np.finfo(float).tiny:
            raise NumericalError(
                f"equation of state {equation_of_state.name}: at a central enthalpy of {central_enthalpy:.6g} density "
                "and pressure lie beyond the digits of numbers"
            )

    def local(self, piece: Piece, fraction: float, U: float, W: float) -> tuple[Local, float]:
        """What holds at a place, and the rest density there over e_c."""
        h_c, e_c = self.h_c, self.e_c
        eta = math.expm1(h_c * fraction) if self.relativistic else h_c * fraction
        density, pressure, energy = piece.at(eta)
        p, eps = pressure / (e_c * h_c), h_c if self.relativistic else 0.0
        energy = energy if self.relativistic else density
        here = Local(1 - fraction, eps, U, W, energy / e_c, p, 1 - 2 * eps * U * W, W + 4 * math.pi * eps * p)
        return here, density / e_c

    def slopes(self, piece: Piece, fraction: float, values: np.ndarray) -> list[float]:
        """Derivatives by the depth 1 - h/h_c."""
        U, W, B, *rest = values.tolist()
        self.left -= 1
        shallow = W < 1.0 and U * W < _SHALLOWEST  # not the middle of a star of large eta, where U is as small
        if self.left < 0 or (fraction < _HANDOVER and shallow):
            raise NumericalError("the star has no surface that can be found: its equation of state is too soft")
        here, density = self.local(piece, fraction, U, W)
        if here.f <= 0:
            raise NumericalError("the star has a horizon: the equation of state or its units cannot be right")
        rate = here.f / (here.q * U)
        whole = [
            2 * U * rate,
            (4 * math.pi * here.E - 3 * W) * rate,
            (4 * math.pi * density / math.sqrt(here.f) - 3 * B) * rate,
        ]
        if self.perturbation is not None:
            whole += [rate * value for value in self.perturbation.slopes(here, rest)]
        return whole

    def near_centre(self, depth: float) -> list[float]:
        """The series there: densities are linear in r^2, so that their means lie 3/5 of the way."""
        density = self.rest_density / self.e_c
        centre, _ = self.local(self.innermost, 1.0, 0.0, 4 * math.pi / 3)
        there, density_there = self.local(self.innermost, 1 - depth, 0.0, 4 * math.pi / 3)
        W = 4 * math.pi / 3 * (centre.E + 0.6 * (there.E - centre.E))
        here, _ = self.local(self.innermost, 1 - depth, 2 * depth / centre.q, W)
        here, _ = self.local(self.innermost, 1 - depth, depth * (1 / centre.q + here.f / here.q), W)
        B = 4 * math.pi / 3 * (density + 0.6 * (density_there / math.sqrt(here.f) - density))
        return [here.U, W, B, *([] if self.perturbation is None else self.perturbation.start(here))]


def structure(
    equation_of_state: Barotrope,
    central_enthalpy: float,
    relativistic: bool = True,
    tolerance: float = TOLERANCE,
    perturbation: Perturbation | None = None,
) -> Structure:
    """Return the star whose centre has the specific enthalpy eta = (e + P)/rho0 - 1.

    tolerance is the relative one of each step (DOP853). ValueError where the equation of state does not cover the
    centre; NumericalError where the integration fails or finds no surface (gamma of 6/5 and below, for relativistic
    stars of large eta below about 1.25).
    """
    require_positive(central_enthalpy=central_enthalpy)
    if not 3e-14 <= tolerance <= 1e-3:
        raise ValueError(f"the tolerance must lie between 3e-14 and 1e-3, not {tolerance}")
    equations = _Equations(equation_of_state, central_enthalpy, relativistic, perturbation)
    h_c, e_c = equations.h_c, equations.e_c
    inside = [edge for edge in equation_of_state.edges[1:] if edge < central_enthalpy]
    breaks = [(math.log1p(edge) if relativistic else edge) / h_c for edge in inside]
    fractions = [1.0, *breaks[::-1], 0.0]  # of h_c, from the centre to the surface
    pieces = equation_of_state.pieces[: len(inside) + 1][::-1]
    depth = min(_START, 0.5 * (1 - fractions[1]))
    values = equations.near_centre(depth)
    trail = [(np.array([1 - depth]), np.array(values)[:, None])]
    for piece, (high, low) in zip(pieces, pairwise(fractions), strict=True):
        for begin, end, power in ((min(high, 1 - depth), max(low, _HANDOVER), 1), (min(high, _HANDOVER), low, _ROOT)):
            if not begin > end:
                continue

            def slopes(t, y, piece=piece, power=power):
                return [-power * t ** (power - 1) * value for value in equations.slopes(piece, t**power, y)]

            places, states = _integrate(slopes, begin ** (1 / power), end ** (1 / power), values, tolerance)
            trail.append((places[1:] ** power, states[:, 1:]))
            values = states[:, -1]

    fraction = np.concatenate([[1.0], *(part for part, _ in trail)])
    centre = [0.0, 4 * math.pi / 3, 0.0, *trail[0][1][3:, 0]]
    U, W, B, *perturbed = np.column_stack([centre, *(part for _, part in trail)])
    r = np.sqrt(U * h_c / e_c)
    mass_scale = e_c * r**3
    compactness = float(h_c * U[-1] * W[-1])
    return Structure(
        relativistic=relativistic,
        central_log_enthalpy=h_c,
        central_rest_density=equations.rest_density,
        central_energy_density=e_c,
        central_pressure=equations.pressure,
        mass=float(W[-1] * mass_scale[-1]),
        rest_mass=float(B[-1] * mass_scale[-1]),
        radius=float(r[-1]),
        compactness=compactness,
        r=r,
        enclosed_mass=W * mass_scale,
        log_enthalpy=fraction * h_c,
        scaled_surface=(float(U[-1]), float(W[-1])),
        perturbation=np.array(perturbed),
    )
