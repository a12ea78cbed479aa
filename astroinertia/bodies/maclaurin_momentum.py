"""Stars with the angular momentum of a Maclaurin spheroid: rings of equal mass have what those of a liquid would have.

    j(m) = 5/2 (L/M) [1 - (1 - m)^(2/3)],   m the fraction of the mass nearer to the axis,

what a uniform sphere in rigid rotation keeps, ring by ring, when it contracts into a star. Such stars exist up to and
beyond T/|W| = 0.27, where liquids, and these too, turn into bars: the models of most work on that instability. The law
follows from the star, and is found with it: Omega(w) = j(m(w))/w^2 depends on the distance w from the axis alone.

Source: Stoeckly 1965, ApJ 142, 208; Ostriker & Mark 1968, ApJ 151, 1075; Bodenheimer & Ostriker 1973, ApJ 180, 159
(n' = 0).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from astroinertia.bodies.rotating_star import RotatingStar
from astroinertia.bodies.scf import Field
from astroinertia.process.roots import bisected

_RINGS = 65  # distances from the axis at which the law is tabulated, crowded at the axis and at the edge
_HEIGHTS = 24  # Gauss-Legendre points along each line parallel to the axis
_ANGLE = 0.5 * math.pi * np.linspace(0.0, 1.0, _RINGS)
_DISTANCE = np.sin(_ANGLE)


@dataclass(frozen=True)
class MomentumLaw:
    """Omega/Omega_0 by its values (65,) at distances sin(0 ... pi/2) of `edge`, beyond which w^2 Omega is constant.

    As it is made, rigid, it is where the search for a star begins: rotating_star(matter, axis_ratio, MomentumLaw()).
    It answers like rotation_laws.RotationLaw.
    """

    rates: tuple[float, ...] = (1.0,) * _RINGS
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
        return MomentumLaw(self.rates, self.edge * length)

    def with_rates(self, rates: np.ndarray) -> "MomentumLaw":
        """Return the law with other values."""
        return MomentumLaw(tuple(rates), self.edge)

    def followed(self, field: Field) -> np.ndarray:
        """j(m)/w^2 over its value on the axis, with the star's own distribution of mass over distances, (65,)."""
        star, w = RotatingStar(field), _DISTANCE
        heights, weights = np.polynomial.legendre.leggauss(_HEIGHTS)
        top = _top(star, w)
        left = 1 - (heights + 1) / 2
        z = top[:, None] * (1 - left**2)  # crowded at the surface, where the density vanishes
        column = (star.density(np.broadcast_to(w[:, None], z.shape), z) * left * weights).sum(axis=1) * 2 * top
        ring = CubicSpline(_ANGLE, 2 * math.pi * w * column * np.cos(_ANGLE)).antiderivative()(_ANGLE)
        outside = np.maximum(ring[-1] - ring, 0.0) / ring[-1]
        axis = 2 / 3 * math.pi * column[0] / ring[-1]  # of [1 - (1 - m)^(2/3)]/w^2 on the axis
        return np.append(axis, (1 - outside[1:] ** (2 / 3)) / w[1:] ** 2) / axis

    @cached_property
    def _curve(self) -> CubicSpline:
        return CubicSpline(_DISTANCE**2, self.rates)

    @cached_property
    def _integral(self) -> CubicSpline:
        squares = _DISTANCE**2
        fine = np.sort(np.concatenate([squares, 0.5 * (squares[1:] + squares[:-1])]))
        return CubicSpline(fine, self._curve(fine) ** 2).antiderivative()


def _top(star: RotatingStar, w: np.ndarray) -> np.ndarray:
    """Height of the surface above the equator at distance w from the axis, in equatorial radii."""
    return bisected(lambda z: star.level(w, z) > 0, np.zeros_like(w), np.sqrt(np.maximum(1 - w**2, 0.0)), 45)
