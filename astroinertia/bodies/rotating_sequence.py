"""Rigidly or differentially rotating stars of one piece of matter: what one star becomes as its angular momentum grows.

Mass and entropy stay: for P = K rho^(1 + 1/n) a star of given M and K in units of its own radius has the radius that K
asks for, R ~ (K/M^((n - 1)/n))^(n/(3 - n)). Its energy then obeys dE = Omega dL where it turns rigidly (Ostriker & Gunn
1969, ApJ 157, 1395), which nothing here uses.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from astroinertia.bodies.rotating_star import end_of_sequence, rotating_star
from astroinertia.bodies.rotation_laws import RIGID, RotationLaw
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.process.quantities import with_quantities

QUANTITIES = ("angular_velocity", "axis_ratio", "rotational_to_gravitational", "polar_moment", "energy")


@dataclass(frozen=True)
class RotatingSequence:
    """Stars along their angular momentum (S,), from rest to mass shedding, with G = M = 1 and R = 1 at rest.

    figures (S, 5), the QUANTITIES: Omega on the axis; (Q_zz/Q_xx)^(1/2) of second moments; T/|W|; C; T + W + U.
    """

    angular_momentum: np.ndarray
    figures: np.ndarray

    @with_quantities()
    def at(self, angular_momentum) -> dict[str, np.ndarray]:
        """The QUANTITIES of stars with these angular momenta; ValueError for one that no star of the sequence has."""
        wanted = np.asarray(angular_momentum, dtype=float)
        most = self.angular_momentum[-1]
        if not ((wanted >= 0) & (wanted <= most)).all():
            raise ValueError(f"stars of this sequence have angular momenta from 0 to {most:.6g}")
        return dict(zip(QUANTITIES, np.moveaxis(self._curves(wanted), -1, 0), strict=True))

    @cached_property
    def _curves(self) -> CubicSpline:
        return CubicSpline(self.angular_momentum, self.figures)


@with_quantities()
@lru_cache(maxsize=8)
def rotating_sequence(index: float, law: RotationLaw = RIGID, members: int = 31) -> RotatingSequence:
    """Return so many polytropes of one mass and entropy from rest to mass shedding, as steps of their axis ratio grow.

    The scale of the law is in equatorial radii. ValueError for an index that is not in (0, 3): an entropy does not give
    a radius to n = 0 or n = 3; and for fewer than 2 members. Source: Hachisu 1986, ApJS 61, 479.

    >>> stars = rotating_sequence(1.5, members=5)
    >>> first, last = (stars.at(each) for each in (0.0, stars.angular_momentum[-1]))
    >>> print(f"{last['rotational_to_gravitational']:.3f} {last['polar_moment'] / first['polar_moment']:.2f}")
    0.059 1.55
    """
    if not 0 < index < 3:
        raise ValueError(f"a star's mass and entropy give it a radius for an index between 0 and 3, not {index}")
    if members < 2:
        raise ValueError(f"a sequence from rest to mass shedding has 2 members or more, not {members}")
    matter = polytropic_matter(index)
    last = end_of_sequence(matter, law).field.axis_ratio
    # The axis ratio falls as the square of a small angular momentum, along which members are then spread evenly.
    ratios = 1 - (1 - last) * np.linspace(0.0, 1.0, members) ** 2
    stars = [rotating_star(matter, float(ratio), law) for ratio in ratios]
    constants = np.array([star.max_pressure / star.max_density ** (1 + 1 / index) for star in stars])
    radii = (constants[0] / constants) ** (index / (3 - index))
    rows = []
    for star, radius in zip(stars, radii, strict=True):
        across, along = star.polar_moment / 2, star.equatorial_moment - star.polar_moment / 2
        energy = star.kinetic_energy + star.gravitational_energy + index * star.pressure_integral
        rows.append([star.angular_velocity * radius**-1.5, math.sqrt(along / across), star.rotational_to_gravitational,
                     star.polar_moment * radius**2, energy / radius])  # fmt: skip
    momenta = np.array([star.angular_momentum for star in stars]) * np.sqrt(radii)
    return RotatingSequence(momenta, np.array(rows))
