"""Stars with the angular momentum of a Maclaurin spheroid: rings of equal mass have what those of a liquid would have.

    j(m) = 5/2 (L/M) [1 - (1 - m)^(2/3)],   m the fraction of the mass nearer to the axis,

what a uniform sphere in rigid rotation keeps, ring by ring, when it contracts into a star. Such stars exist up to and
beyond T/|W| = 0.27, where liquids, and these too, turn into bars: the models of most work on that instability. The law
is found with the star, of which Omega(w) = j(m(w))/w^2 is a function of the distance w from the axis.

Source: Stoeckly 1965, ApJ 142, 208; Ostriker & Mark 1968, ApJ 151, 1075; Bodenheimer & Ostriker 1973, ApJ 180, 159
(n' = 0). Tests: tests/unit/test_maclaurin_momentum.py.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import root_scalar

from astroinertia.bodies.anderson import Anderson
from astroinertia.bodies.rotating_star import RESOLUTIONS, RotatingStar
from astroinertia.bodies.scf import Resolution, check_field, solve_field
from astroinertia.bodies.scf_matter import Matter
from astroinertia.errors import NumericalError

_RINGS = 65  # distances from the axis at which the law is tabulated, crowded at the axis and at the edge
_HEIGHTS = 24  # Gauss-Legendre points along each line parallel to the axis
_TOLERANCE = 1e-8  # of Omega/Omega_0
_MOST_ITERATIONS = 40
_HISTORY = 4
_ROUNDEST = 0.99
_STEP, _SHORTEST = 0.06, 2e-3  # of the axis ratio, in the search for a value


@dataclass(frozen=True)
class MomentumLaw:
    """Omega(w)/Omega_0 by its values (K,) at the squares (K,) of w over `edge`; beyond the edge w^2 Omega is constant.

    It answers like rotation_laws.RotationLaw. Test: tests/unit/test_maclaurin_momentum.py.
    """

    squares: tuple[float, ...]
    rates: tuple[float, ...]
    edge: float = 1.0
    kind: str = "maclaurin"
    scale: float | None = None

    def rate(self, w) -> np.ndarray:
        """Omega/Omega_0 at distance w from the axis."""
        square = (np.asarray(w, dtype=float) / self.edge) ** 2
        return self._curve(np.minimum(square, 1.0)) / np.maximum(square, 1.0)

    def potential(self, w) -> np.ndarray:
        """Integral from 0 to w of (Omega/Omega_0)^2 w dw, in the unit of length squared: minus the potential."""
        square = (np.asarray(w, dtype=float) / self.edge) ** 2
        beyond = self.rates[-1] ** 2 * (1 - 1 / np.maximum(square, 1.0))
        return 0.5 * self.edge**2 * (self._integral(np.minimum(square, 1.0)) + beyond)

    def scaled(self, length: float) -> "MomentumLaw":
        """Return the law with its edge times `length`: from radii of a star to another unit."""
        return MomentumLaw(self.squares, self.rates, self.edge * length)

    @cached_property
    def _curve(self) -> CubicSpline:
        return CubicSpline(self.squares, self.rates)

    @cached_property
    def _integral(self) -> CubicSpline:
        fine = np.sort(np.concatenate([self.squares, 0.5 * (np.array(self.squares[1:]) + self.squares[:-1])]))
        return CubicSpline(fine, self._curve(fine) ** 2).antiderivative()  # type: ignore[return-value]


def maclaurin_momentum_star(
    matter: Matter, axis_ratio: float, near: RotatingStar | None = None, resolution: Resolution = RESOLUTIONS[0]
) -> RotatingStar:
    """Return the star of polar/equatorial radius axis_ratio whose rings have the angular momentum of a liquid's.

    Mass, equatorial radius and G are 1. near: a star with an axis ratio not far from this one, to begin with.
    NumericalError where the iteration does not converge. Source: Bodenheimer & Ostriker 1973, ApJ 180, 159.
    Test: tests/unit/test_maclaurin_momentum.py.
    """
    field = near.field if near is not None else solve_field(matter, 1.0, resolution=resolution)
    given: Any = field.law
    law: MomentumLaw = given if isinstance(given, MomentumLaw) else _law_of(RotatingStar(field))
    moments, mixed = (field.moments if near is not None and axis_ratio < 1 else None), Anderson(_HISTORY)
    for _ in range(_MOST_ITERATIONS):
        field = solve_field(matter, axis_ratio, law, resolution, moments)
        found, moments = _law_of(RotatingStar(field)), field.moments
        if np.abs(np.array(found.rates) - law.rates).max() < _TOLERANCE:
            check_field(field)
            return RotatingStar(field)
        law = MomentumLaw(law.squares, tuple(mixed.next(np.array(law.rates), np.array(found.rates))))
    told = f"a {matter.name} with axis ratio {axis_ratio:g} and the angular momentum of a Maclaurin spheroid"
    raise NumericalError(f"{told} was not found: there may be no such body")


def maclaurin_momentum_star_with(quantity: str, value: float, matter: Matter) -> RotatingStar:
    """Return the first such star, from rest on, of which a number, say "rotational_to_gravitational", has a value.

    ValueError for a value below that at rest. NumericalError where the iteration converges no longer before: at T/|W| =
    0.29 for an index of 0.5 and at 0.22 for 1.5, though stars exist beyond (measured).
    Test: tests/unit/test_maclaurin_momentum.py.
    """
    star, step = maclaurin_momentum_star(matter, _ROUNDEST), _STEP
    if not math.isfinite(value) or getattr(star, quantity) > value:
        raise ValueError(f"{quantity} must be finite and at least {getattr(star, quantity):g}, not {value!r}")
    while step > _SHORTEST:
        try:
            flatter = maclaurin_momentum_star(matter, star.field.axis_ratio - step, near=star)
        except (NumericalError, ValueError):
            step /= 2
            continue
        if getattr(flatter, quantity) >= value:
            bracket = (flatter.field.axis_ratio, star.field.axis_ratio)
            return _between(quantity, value, matter, star, bracket)
        star = flatter
    most = f"down to axis ratio {star.field.axis_ratio:.4g} it reaches {getattr(star, quantity):.4g}"
    raise NumericalError(f"no {matter.name} with maclaurin rotation was found with a {quantity} of {value:g}: {most}")


def _between(
    quantity: str, value: float, matter: Matter, near: RotatingStar, bracket: tuple[float, float]
) -> RotatingStar:
    def excess(ratio: float) -> float:
        return getattr(maclaurin_momentum_star(matter, ratio, near=near), quantity) - value

    root = float(root_scalar(excess, bracket=bracket, method="brentq", xtol=1e-7, rtol=1e-9).root)
    return maclaurin_momentum_star(matter, root, near=near)


def _distances() -> np.ndarray:
    return np.sin(0.5 * math.pi * np.linspace(0.0, 1.0, _RINGS))


def _law_of(star: RotatingStar) -> MomentumLaw:
    """j(m) of the star's own distribution of mass over distances from the axis, in equatorial radii."""
    w = _distances()
    heights, weights = np.polynomial.legendre.leggauss(_HEIGHTS)
    top = _top(star, w)
    left = 1 - (heights + 1) / 2
    z = top[:, None] * (1 - left**2)  # crowded at the surface, where the density vanishes
    surface_density = (star.density(np.broadcast_to(w[:, None], z.shape), z) * left * weights).sum(axis=1) * 2 * top
    angle = 0.5 * math.pi * np.linspace(0.0, 1.0, _RINGS)
    ring = CubicSpline(angle, 2 * math.pi * w * surface_density * np.cos(angle)).antiderivative()
    outside = np.maximum(ring(angle[-1]) - ring(angle), 0.0) / ring(angle[-1])
    outside[0] = 1.0
    axis = 2 / 3 * math.pi * surface_density[0] / float(ring(angle[-1]))  # of [1 - (1 - m)^(2/3)]/w^2 on the axis
    rates = np.append(axis, (1 - outside[1:] ** (2 / 3)) / w[1:] ** 2) / axis
    return MomentumLaw(tuple(w**2), tuple(rates))


def _top(star: RotatingStar, w: np.ndarray) -> np.ndarray:
    """Height of the surface above the equator at distance w from the axis, in equatorial radii."""
    low, high = np.zeros_like(w), np.sqrt(np.maximum(1 - w**2, 0.0))
    for _ in range(45):
        middle = 0.5 * (low + high)
        inside = star.level(w, middle) > 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return 0.5 * (low + high)
