"""Shell by shell: a collapse in which each keeps its own angular momentum, and what of it can fall how far.

A shell turns as one (shellular rotation) and keeps the angle of its matter to the axis, so that its specific angular
momentum at latitude theta stays Omega r^2 sin^2 theta: Omega goes as r^-2 on each shell, rigid rotation becomes
differential where the collapse is not homologous, and the spectrum of j is the same before and after. Any consistent
units with the G given; arrays (N,) run from the centre outwards.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from scipy.special import expit, logit

from astroinertia.process.positive import refuse_negative
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.spin_scaling import centrifugal_radius
from astroinertia.units import GRAVITATIONAL_CONSTANT

Array = Any

_NODES = 160
_FINE = 4096  # places in the mass, at least, at which the spectrum of j knows it
_REACH = 3.0  # of the double exponential rule: its last nodes are 2e-14 of the mass from the ends


class MassProfile(Protocol):
    """A sphere that says where its mass is, such as bodies.polytrope.Polytrope."""

    @property
    def mass(self) -> float:
        """Total mass."""
        ...

    @with_quantities()
    def radius_enclosing(self, mass: Any) -> np.ndarray:
        """Radius inside which a mass lies."""
        ...


@dataclass(frozen=True)
class Shells:
    """Spherical shells (N,): the mass of each, the mass inside its middle, its radius and its angular velocity."""

    mass: np.ndarray
    enclosed_mass: np.ndarray
    radius: np.ndarray
    angular_velocity: np.ndarray
    gravitational_constant: float = GRAVITATIONAL_CONSTANT

    @property
    def moment_of_inertia(self) -> float:
        """Sum of (2/3) m r^2."""
        return float(2 / 3 * self.mass @ self.radius**2)

    @property
    def equatorial_specific_angular_momentum(self) -> np.ndarray:
        """j = Omega r^2 at the equator of each shell, the largest that it has; its mean is 2/3 of this."""
        return self.angular_velocity * self.radius**2

    @property
    def angular_momentum(self) -> float:
        """Sum of (2/3) m Omega r^2."""
        return float(2 / 3 * self.mass @ self.equatorial_specific_angular_momentum)

    @property
    def rotational_energy(self) -> float:
        """Sum of (1/3) m Omega^2 r^2."""
        return float(self.mass @ (self.angular_velocity * self.radius) ** 2 / 3)

    @property
    def mean_angular_velocity(self) -> float:
        """L/I: the rate if the shells were locked together as they stand, by viscosity or a magnetic field."""
        return self.angular_momentum / self.moment_of_inertia

    @property
    def shear_energy(self) -> float:
        """Energy that locking the shells together at their radii would set free: T - L^2/(2 I), never negative."""
        # As a variance, which does not cancel.
        away = self.angular_velocity - self.mean_angular_velocity
        return float(self.mass @ (away * self.radius) ** 2 / 3)

    @property
    def centrifugal_radius(self) -> np.ndarray:
        """j^2/(G m) of each shell's equator, m the mass inside it: it cannot fall below this as it is."""
        return centrifugal_radius(
            self.equatorial_specific_angular_momentum, self.enclosed_mass, self.gravitational_constant
        )

    @property
    def keplerian_fraction(self) -> np.ndarray:
        """Omega over that of an orbit at each shell."""
        return np.sqrt(self.centrifugal_radius / self.radius)

    @property
    def critical(self) -> np.ndarray:
        """Which shells turn at their equator as fast as an orbit there, or faster: they cannot stand where they are."""
        return self.keplerian_fraction >= 1

    @with_quantities()
    def collapsed(self, radius: Array) -> "Shells":
        """The same shells at other radii (N,), each with its angular momentum; ValueError unless these are positive."""
        radius = np.asarray(radius, dtype=float)
        if radius.shape != self.radius.shape or not np.all(np.isfinite(radius) & (radius > 0)):
            raise ValueError(f"a collapse needs a positive radius for each of the {len(self.radius)} shells")
        return replace(self, radius=radius, angular_velocity=self.angular_velocity * (self.radius / radius) ** 2)

    def locked(self) -> "Shells":
        """The shells where they are, turning rigidly with the same angular momentum."""
        return replace(self, angular_velocity=np.full_like(self.radius, self.mean_angular_velocity))

    @with_quantities()
    def spectrum(self, specific_angular_momentum: Array) -> np.ndarray:
        """Mass whose specific angular momentum about the axis is below each given value (not negative).

        On a shell that turns at Omega, j = Omega r^2 sin^2 theta, and a share 1 - (1 - j/(Omega r^2))^(1/2) of its
        mass lies below j. Source: Mestel 1963, MNRAS 126, 553 (the sphere of uniform density).
        """
        bound = np.asarray(specific_angular_momentum, dtype=float)[..., None]
        if (bound < 0).any():
            raise ValueError("the spectrum is of specific angular momenta that are not negative")
        share, highest = self._spread()
        low, high = np.minimum(highest[1:], highest[:-1]), np.maximum(highest[1:], highest[:-1])
        # In between the highest j is linear in the mass, so that the square root is integrated in closed form.
        wide = high - low > 1e-9 * high
        width = np.where(wide, high - low, 1.0)
        above = (_root_integral(high, bound) - _root_integral(low, bound)) / width
        with np.errstate(divide="ignore", invalid="ignore"):
            narrow = np.sqrt(np.clip(1 - bound / high, 0.0, 1.0))
        narrow = np.where(high > 0, narrow, 0.0)
        return (1 - np.where(wide, above, narrow)) @ (self.mass.sum() * np.diff(share))

    def _spread(self) -> tuple[np.ndarray, np.ndarray]:
        """Shares of the mass, from 0 to 1, and the highest j of the shell that holds each inside, (K,).

        Between the given shells by monotone cubics in ln(m/(M - m)): in that the j of a sphere is smooth, also where it
        goes as m^(2/3) at the centre, and as a power of M - m at the surface.
        """
        from scipy.interpolate import PchipInterpolator  # only here: who builds a run need not wait for it

        share, at = np.unique(self.enclosed_mass / self.mass.sum(), return_index=True)
        at, share = at[share < 1], share[share < 1]  # the last shells may be no more than a rounding of the mass
        place, highest = logit(share), np.abs(self.equatorial_specific_angular_momentum)[at]
        if len(place) > 1:
            parts = -(-_FINE // len(place))
            fine = np.interp(np.arange((len(place) - 1) * parts + 1) / parts, np.arange(len(place)), place)
            share, highest = expit(fine), PchipInterpolator(place, highest)(fine)
        return np.concatenate([[0.0], share, [1.0]]), np.concatenate([highest[:1], highest, highest[-1:]])

    @with_quantities()
    def disc_mass_inside(self, radius: Array) -> np.ndarray:
        """Mass that comes to rest inside each radius of a thin disc around a centre that holds the whole mass.

        Matter goes to where its j is that of an orbit, j^2 = G M R. Source: Cassen & Moosman 1981, Icarus 48, 353.
        """
        total = float(self.mass.sum())
        return self.spectrum(np.sqrt(self.gravitational_constant * total * np.asarray(radius, dtype=float)))


@with_quantities()
def shells_of(
    body: MassProfile,
    angular_velocity: Array,
    count: int = _NODES,
    gravitational_constant: float | None = None,
) -> Shells:
    """Return `count` shells of a sphere that turns at one rate, or at rates (count,) from the centre outwards.

    The masses are the weights of a double exponential quadrature in the mass, which does not mind how the radius
    depends on it at the centre and at the surface: moments of smooth spheres come out to about 1e-10 with 160 shells,
    as exact as a polytrope's radius by mass. The gravitational constant is that of the body, of SI where it has none,
    unless it is given. Source: Takahasi & Mori 1974, Publ. RIMS 9, 721.

    >>> from astroinertia.bodies.polytrope import Polytrope
    >>> shells = shells_of(Polytrope(1.5), 1.0)
    >>> print(f"{2 / 3 * (shells.mass * shells.radius**2).sum():.6f}")  # I/(M R^2)
    0.204600
    """
    if count < 8:
        raise ValueError(f"a body needs at least 8 shells, not {count}")
    own = getattr(body, "gravitational_constant", GRAVITATIONAL_CONSTANT)
    constant = own if gravitational_constant is None else gravitational_constant
    share, weight = mass_quadrature(count)
    radius = np.asarray(body.radius_enclosing(share * body.mass), dtype=float)
    rates = np.broadcast_to(np.asarray(angular_velocity, dtype=float), radius.shape).copy()
    return Shells(weight * body.mass, share * body.mass, radius, rates, constant)


@with_quantities()
def shells_from_table(
    enclosed_mass: Array,
    radius: Array,
    angular_velocity: Array,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Shells:
    """Return shells from a stellar model's table: enclosed mass, radius and angular velocity at N rising radii.

    A shell lies between two neighbours, at the mean square of their radii; the first reaches to the centre. ValueError
    unless masses and radii are positive and rise.

    >>> print(shells_from_table(np.array([1.0, 8.0]), np.array([1.0, 2.0]), np.array([1.0, 1.0])).mass)
    [1. 7.]
    """
    mass, radius = np.asarray(enclosed_mass, dtype=float), np.asarray(radius, dtype=float)
    rates = np.asarray(angular_velocity, dtype=float)
    if not (mass.ndim == 1 and mass.shape == radius.shape == rates.shape and len(mass) > 1):
        raise ValueError("a table of shells needs as many masses, radii and angular velocities, two at least")
    if not (mass[0] > 0 and radius[0] > 0 and (np.diff(mass) > 0).all() and (np.diff(radius) > 0).all()):
        raise ValueError("the masses and radii of a table of shells must be positive and rise")
    inner_mass, inner = np.concatenate([[0.0], mass[:-1]]), np.concatenate([[0.0], radius[:-1]])
    inner_rate = np.concatenate([rates[:1], rates[:-1]])
    squared = np.where(inner > 0, 0.5 * (inner**2 + radius**2), 0.6 * radius**2)  # the innermost ball is uniform
    return Shells(
        mass - inner_mass, 0.5 * (mass + inner_mass), np.sqrt(squared), 0.5 * (rates + inner_rate),
        gravitational_constant,
    )  # fmt: skip


@with_quantities()
def mass_quadrature(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Shares of the mass inside `count` shells, rising in (0, 1), and the share that each has; they add up to 1.

    >>> print(f"{mass_quadrature(80)[1].sum():.12f}")
    1.000000000000
    """
    if count < 1 or count % 1 != 0:
        raise ValueError(f"the count of shells must be a whole number and at least 1, not {count}")
    at = np.linspace(-_REACH, _REACH, int(count))
    inner = 0.5 * math.pi * np.sinh(at)
    # 1/(1 + e^-2x), written so that neither tail is rounded away.
    share = np.where(inner < 0, np.exp(2 * np.minimum(inner, 0)), 1.0) / (1 + np.exp(-2 * np.abs(inner)))
    weight = 0.5 * math.pi * np.cosh(at) / np.cosh(inner) ** 2
    return share, weight / weight.sum()


def _root_integral(highest: np.ndarray, j: np.ndarray) -> np.ndarray:
    # Integral of (1 - j/h)^(1/2) dh from j to h, 0 below j.
    h = np.maximum(highest, j)
    excess = h - j
    safe = np.where(j > 0, j, 1.0)
    logarithm = np.where(j > 0, 2 * np.arcsinh(np.sqrt(excess / safe)), 0.0)
    return np.sqrt(h * excess) - 0.5 * j * logarithm


@with_quantities()
def isothermal_disc_radius(
    mass: Array, angular_velocity: Array, sound_speed: Array, gravitational_constant: float = GRAVITATIONAL_CONSTANT
) -> Array:
    """G^3 M^3 Omega^2/(16 a^8): how far out the disc reaches when the mass M of an isothermal cloud has fallen in.

    The singular isothermal sphere has M = 2 a^2 r/G, and the equator of that shell brings j = Omega r^2.
    Source: Terebey, Shu & Cassen 1984, ApJ 286, 529.

    >>> print(f"{isothermal_disc_radius(1.989e30, 1e-14, 200.0) / 1.495979e11:.0f} au")  # after one solar mass
    38 au
    """
    refuse_negative(mass=mass, gravitational_constant=gravitational_constant)
    squared = np.asarray(sound_speed, dtype=float) ** 2
    outer = gravitational_constant * np.asarray(mass, dtype=float) / (2 * squared)
    return np.asarray(angular_velocity, dtype=float) ** 2 * outer**3 / (2 * squared)  # j^2/(G M), also before any fell
