"""Torque and heat of tides, of a Love number that depends on frequency, by Kaula's sum, and the time to lock a spin.

A companion of mass m on an orbit of semi-major axis a, eccentricity e and inclination eps to the equator of a body of
radius R that turns at Omega raises tides at the rates omega = (2 - 2p + q) n - m' Omega. Each has the share
K(omega) = -Im k2(omega), odd in omega, of

    torque  = (G m^2 R^5/a^6) sum of 2 m' (2 - m')!/(2 + m')! F^2 G^2 K       along the spin, on the body
    heating = (G m^2 R^5/a^6) sum of (2 - delta_m') (2 - m')!/(2 + m')! F^2 G^2 omega K

with the inclination functions F_2mp(eps) and the eccentricity functions G_2pq(e), of degree 2 alone, averaged over
orbit, node and pericentre. Sources: Kaula 1964, Rev. Geophys. 2, 661; Boue & Efroimsky 2019, CeMDA 131, 30; for a body
in step with its orbit Segatz et al. 1988, Icarus 75, 187, and Wisdom 2004, AJ 128, 484.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from astroinertia.orbits.kepler import eccentric_anomaly
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.units import GRAVITATIONAL_CONSTANT

Array = Any

_STANDING = 1e-12  # of the mean motion: the rate of a tide that stands still
_HARMONICS = 1e-15  # of the sum of G^2, that the harmonics that are left out have at most


class Tides(NamedTuple):
    """Mean torque on the body along its spin (N m), and the heat in it (W)."""

    torque: float
    heating: float


@with_quantities()
def tides(
    love_number: Callable[[Array], Array], mass: float, radius: float, semi_major_axis: float, mean_motion: float,
    spin_rate: float, eccentricity: float = 0.0, obliquity: float = 0.0,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Tides:  # fmt: skip
    """Torque and heating by a companion of `mass`, of a function love_number(frequency) that has the complex k2.

    It is called once, with all frequencies above 0 (N,), rad/s. A mean motion below 0 is that of a companion that goes
    round backwards. ValueError for an eccentricity outside 0 <= e < 1, and for a mass, radius or axis that is not
    positive.
    Sources: those of the module.

    >>> def k2(frequency):  # of a constant quality factor
    ...     return 0.02 - 0.02j / 100 + 0 * frequency
    >>> io = tides(k2, 1.898e27, 1.8216e6, 4.218e8, 4.11e-5, 4.11e-5, 0.0041)  # in step with its orbit
    >>> print(f"{io.heating:.2e} W")
    1.24e+12 W
    """
    require_positive(mass=mass, radius=radius, semi_major_axis=semi_major_axis)
    harmonics, strength = _eccentricity_functions(eccentricity)  # (3, harmonics)
    inclination = inclination_functions(obliquity)
    order = np.arange(3)[:, None, None]
    weight = np.array([1.0, 2 / 6, 2 / 24])[:, None, None] * inclination[:, :, None] ** 2 * strength**2
    rate = np.broadcast_to(harmonics * mean_motion - order * spin_rate, weight.shape)  # (m, p, harmonic)
    size = np.abs(rate)
    moving = (weight > 0) & (size > _STANDING * abs(mean_motion))
    share = np.zeros(size.shape)
    if np.any(moving):
        share[moving] = -np.imag(love_number(size[moving]))
    scale = gravitational_constant * float(mass) ** 2 * float(radius) ** 5 / float(semi_major_axis) ** 6
    torque = scale * np.sum(order * weight * np.sign(rate) * share)
    return Tides(float(torque), float(scale * np.sum(weight * size * share)))


@with_quantities()
def despin_time(
    mass: Array, radius: Array, semi_major_axis: Array, mean_motion: Array, spin_rate: Array, moment_of_inertia: Array,
    love_number: Array, quality: Array, spin_rate_after: Array | None = None,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
) -> Array:  # fmt: skip
    """How long a companion of `mass` takes to bring a spin from `spin_rate` to `spin_rate_after`, or into step.

    Without spin_rate_after the spin ends at the mean motion n: the body is locked. The orbit is a circle in the body's
    equator and keeps its size. k2 and Q stay, so that the torque is 3/2 (k2/Q) G m^2 R^5/a^6 on either side of n, and
    the time 2 I a^6 Q/(3 G m^2 k2 R^5) times the change of the spin. The estimate of Gladman et al. 1996, Icarus 122,
    166, after Peale, is half of that with the whole spin for its change: its torque is twice as large for the same Q.
    SI; arrays broadcast. ValueError for sizes that are not positive, and for an end that is farther from n than the
    start or beyond n. Source: Goldreich & Soter 1966, Icarus 5, 375; Murray & Dermott 1999, Solar System Dynamics,
    section 4.9.

    >>> moon = (5.972e24, 1.7374e6, 3.844e8, 2.66e-6, 1.75e-4, 8.7e34)  # where it is, from a turn in 10 h
    >>> print(f"{despin_time(*moon, love_number=0.024, quality=38.0) / 3.15576e13:.0f} Myr")
    43 Myr
    """
    require_positive(mass=mass, radius=radius, semi_major_axis=semi_major_axis, moment_of_inertia=moment_of_inertia)
    require_positive(love_number=love_number, quality=quality, gravitational_constant=gravitational_constant)
    after = np.asarray(mean_motion if spin_rate_after is None else spin_rate_after, dtype=float)
    change, left = after - spin_rate, mean_motion - after
    if np.any(change * (mean_motion - np.asarray(spin_rate)) < 0) or np.any(change * left < 0):
        raise ValueError("tides of a circular orbit bring the spin nearer to the mean motion, and not beyond it")
    torque = 1.5 * love_number / np.asarray(quality) * gravitational_constant * np.asarray(mass) ** 2
    torque = torque * np.asarray(radius, dtype=float) ** 5 / np.asarray(semi_major_axis, dtype=float) ** 6
    return np.abs(change) * moment_of_inertia / torque


@with_quantities()
def inclination_functions(obliquity: float) -> np.ndarray:
    """F_2mp(eps) of Kaula, (m, p), of an angle in rad. Source: Kaula 1966, Theory of Satellite Geodesy, table 1.

    >>> print(inclination_functions(0.0)[2])  # a companion in the equator raises two bulges
    [3. 0. 0.]
    """
    s, c = np.sin(obliquity), np.cos(obliquity)
    return np.array(
        [
            [-3 / 8 * s**2, 3 / 4 * s**2 - 1 / 2, -3 / 8 * s**2],
            [3 / 4 * s * (1 + c), -3 / 2 * s * c, -3 / 4 * s * (1 - c)],
            [3 / 4 * (1 + c) ** 2, 3 / 2 * s**2, 3 / 4 * (1 - c) ** 2],
        ]
    )


def _eccentricity_functions(eccentricity: float) -> tuple[np.ndarray, np.ndarray]:
    """Multiples 2 - 2p + q of the mean motion (harmonics,), and G_2pq(e) of each (p, harmonics): Hansen's X^(-3,2-2p).

    By a fast Fourier transform over the mean anomaly, with as many points as it takes. ValueError for e outside [0, 1).
    """
    if not 0 <= eccentricity < 1:
        raise ValueError("an eccentricity is from 0 to below 1")
    points = 64
    while True:
        anomaly = 2 * np.pi * np.arange(points) / points
        eccentric = eccentric_anomaly(np, anomaly, eccentricity)
        distance = 1 - eccentricity * np.cos(eccentric)
        place = np.cos(eccentric) - eccentricity + 1j * np.sqrt(1 - eccentricity**2) * np.sin(eccentric)
        turn = (place / distance) ** np.array([[2], [0], [-2]])
        functions = np.real(np.fft.fft(turn / distance**3)) / points
        outer = functions[:, points // 4 : -(points // 4) + 1]
        if np.sum(outer**2) <= _HARMONICS * np.sum(functions**2) or points > 2**20:
            return np.round(np.fft.fftfreq(points, 1 / points)), functions
        points *= 2
