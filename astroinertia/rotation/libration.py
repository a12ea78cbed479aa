"""Librations of a body that its orbit holds: forced ones of a spin in resonance, and free ones about a circular orbit.

gamma, the angle of the long axis beyond p times the mean anomaly M, follows the pendulum of `spin_orbit`; linear in
gamma, and of the torque's terms those of one turn an orbit,

    gamma'' + omega_0^2 H(p, e) gamma = -(omega_0^2/2) (H(p - 1/2, e) - H(p + 1/2, e)) sin M,

primes by M. A body at rest against the vertical of a circular orbit swings about it in pitch by itself, and in roll and
yaw together; moments are about the axes along the orbit (roll), along its normal (pitch) and vertical (yaw).
Sources: Goldreich & Peale 1966, AJ 71, 425; Margot et al. 2007, Science 316, 710; Hughes 1986, Spacecraft Attitude
Dynamics, sections 9.1 and 9.2.
"""

from typing import Any, NamedTuple

import numpy as np

from astroinertia.inertia.tensor import require_plausible
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.cassini import hansen_coefficient

Array = Any


class FreeLibrations(NamedTuple):
    """Frequencies in rad s-1: pitch, and (2,) of roll with yaw; imaginary parts below 0 are growth rates."""

    pitch: complex
    roll_yaw: np.ndarray


@with_quantities()
def forced_libration(p: float, eccentricity: float, asphericity: float) -> float:
    """The amplitude in rad of the libration in longitude, once an orbit, of a rigid body that turns p times an orbit.

    gamma = amplitude sin M; below 0 where the free libration is slower than the orbit. asphericity is omega_0 =
    (3 (B - A)/C)^(1/2), C that of what swings: of Mercury without its fluid core. 1:1 and small e: 2 e omega_0^2/
    (omega_0^2 - 1). ValueError where the two are in resonance, or the rate p is not held. Source: Goldreich & Peale
    1966; Margot et al. 2007.

    >>> swing = forced_libration(1.5, 0.20563, np.sqrt(3 * 2.18e-4))  # Mercury, (B - A)/C of the mantle
    >>> print(f"{np.degrees(swing) * 3600:.1f}")  # arcsec
    38.4
    """
    square = float(asphericity) ** 2
    stiffness = square * float(hansen_coefficient(eccentricity, p))
    if not stiffness > 0:
        raise ValueError(
            f"an orbit with eccentricity {eccentricity:g} does not hold a body at {p:g} turns with this axis"
        )
    if stiffness == 1:
        raise ValueError("the free libration is as fast as the orbit: this libration has no bound")
    before, beyond = (float(hansen_coefficient(eccentricity, p + step)) for step in (-0.5, 0.5))
    return 0.5 * square * (before - beyond) / (1 - stiffness)


@with_quantities()
def free_librations(moments: Array, mean_motion: float) -> FreeLibrations:
    """How a rigid body swings that a circular orbit of this mean motion (rad s-1) holds, to first order.

    moments (3,): principal ones about the axes of roll, pitch and yaw. Pitch: n (3 (A_roll - A_yaw)/A_pitch)^(1/2);
    roll and yaw: roots of s^4 - (1 + 3 k_1 + k_1 k_3) s^2 + 4 k_1 k_3 with k_1 = (A_pitch - A_yaw)/A_roll and k_3 =
    (A_pitch - A_roll)/A_yaw. Stable where all are real: the largest moment about the normal and the least about the
    vertical, or in the region of DeBra & Delp. ValueError for moments that no body has. Source: Hughes 1986, (9.2.16).

    >>> swings = free_librations([2.0, 3.0, 1.5], 1.0)  # in orbital rates
    >>> print(f"{swings.pitch.real:.4f}", swings.roll_yaw.real.round(4))
    0.7071 [0.8024 1.7624]
    """
    sizes = np.asarray(moments, dtype=float)
    if sizes.shape != (3,) or not (sizes > 0).all():
        raise ValueError("three principal moments above 0 are needed: of roll, pitch and yaw")
    require_plausible(np.diag(sizes))
    roll, pitch, yaw = sizes
    first, third = (pitch - yaw) / roll, (pitch - roll) / yaw
    half, product = 0.5 * (1 + 3 * first + first * third), 4 * first * third
    apart = np.emath.sqrt(half**2 - product)
    # One root by the sum that does not cancel, as it does in the other of nearly round bodies, and that by the product.
    large = half + apart if half > 0 else half - apart
    small = product / large if large else large
    slow, fast = (small, large) if half > 0 else (large, small)
    # Frequencies come with both signs: those below the axis grow, exp(i s t).
    roots = [np.emath.sqrt(square) for square in (3 * (roll - yaw) / pitch, slow, fast)]
    pitching, *others = (mean_motion * (root.conjugate() if np.imag(root) > 0 else root) for root in roots)
    return FreeLibrations(complex(pitching), np.array(others, dtype=complex))
