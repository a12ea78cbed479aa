"""Spin-down by several torques at once, and with a field that decays: braking indices that change.

    Omega' = -sum_k s_k |Omega_0'| (Omega/Omega_0)^(n_k),   sum s_k = 1

Any consistent units of time.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.integrate import solve_ivp

from astroinertia.errors import NumericalError
from astroinertia.process.positive import positive_period
from astroinertia.process.quantities import with_quantities

Array = Any

_RELATIVE = 1e-13
_NODES, _WEIGHTS = leggauss(40)


@with_quantities(angular_acceleration="rad s-2")
@dataclass(frozen=True)
class Braking:
    """Torques of several braking indices, with the share that each has in the spin-down at the start.

    angular_velocity and its derivative (negative) are those at the start; shares add up to 1. ValueError otherwise.
    """

    angular_velocity: float
    angular_acceleration: float
    indices: tuple[float, ...]
    shares: tuple[float, ...]

    def __post_init__(self) -> None:
        if not (self.angular_velocity > 0 > self.angular_acceleration):
            raise ValueError("a star that brakes has a positive angular velocity and a negative derivative of it")
        if len(self.indices) != len(self.shares) or not self.indices:
            raise ValueError(f"{len(self.indices)} braking indices need as many shares, not {len(self.shares)}")
        if min(self.shares) < 0 or abs(sum(self.shares) - 1) > 1e-9:
            raise ValueError(f"the shares of the torques must add up to 1, none negative, not {self.shares}")

    @with_quantities()
    def rate(self, angular_velocity: Array) -> Array:
        """Omega' at a rate, negative."""
        return self.angular_acceleration * self._moment(angular_velocity, 0)

    @with_quantities()
    def index(self, angular_velocity: Array) -> Array:
        """The braking index that is measured at a rate: the mean of the indices, weighted with their torques."""
        return self._moment(angular_velocity, 1) / self._moment(angular_velocity, 0)

    @with_quantities()
    def time_to(self, angular_velocity: Array) -> np.ndarray:
        """The time from the start until the rate is that (negative: how long before it was), by quadrature.

        ValueError for a rate that is not positive.
        """
        reached, start = np.asarray(angular_velocity, dtype=float), self.angular_velocity
        if not (np.isfinite(reached).all() and (reached > 0).all()):
            raise ValueError(f"a rate that is reached must be positive and finite, not {angular_velocity}")
        # ln(reached/start), also where they are nearly equal
        end = np.sign(reached - start) * np.log1p(abs(reached - start) / np.minimum(reached, start))
        # In ln Omega the integrand is smooth and monotone: panels of less than half an e-fold of it.
        panels = max(1, math.ceil(2 * float(np.max(np.abs(end))) * max(1.0, *map(abs, self.indices))))
        edges = np.linspace(0.0, 1.0, panels + 1)
        middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 / panels
        places = (middle[:, None] + half * _NODES).ravel()
        log = end[..., None] * places
        integrand = np.exp(log) / self._moment(self.angular_velocity * np.exp(log), 0)
        scale = self.angular_velocity / self.angular_acceleration
        return scale * end * (integrand @ np.tile(half * _WEIGHTS, panels))

    @with_quantities()
    def history(self, times: Array) -> np.ndarray:
        """The rate at times (rising, not negative) after the start, to 1e-12; NumericalError where that fails."""
        times = np.asarray(times, dtype=float)
        if times.ndim != 1 or not len(times) or times[0] < 0 or np.any(np.diff(times) < 0):
            raise ValueError("times must be a rising sequence of numbers that are not negative")
        if times[-1] == 0:
            return np.full_like(times, self.angular_velocity)
        scale = -self.angular_acceleration / self.angular_velocity

        def slope(_: float, log: np.ndarray) -> np.ndarray:
            omega = self.angular_velocity * np.exp(log)
            return -scale * self._moment(omega, 0) / np.exp(log)

        solution = solve_ivp(slope, (0.0, times[-1]), [0.0], "DOP853", t_eval=times, rtol=_RELATIVE, atol=1e-14)
        if not solution.success or not np.isfinite(solution.y).all():
            rests = min(index for index, share in zip(self.indices, self.shares, strict=True) if share > 0) < 1.0
            why = "it comes to rest before" if rests else solution.message
            raise NumericalError(f"the spin-down could not be followed to the time {times[-1]:.6g}: {why}")
        return self.angular_velocity * np.exp(solution.y[0])

    def _moment(self, angular_velocity: Array, power: int) -> Array:
        ratio = np.asarray(angular_velocity, dtype=float)[..., None] / self.angular_velocity
        indices = np.array(self.indices)
        return (np.array(self.shares) * indices**power * ratio**indices).sum(axis=-1)


@with_quantities()
def shares_of_index(braking_index: Array, lower: float = 1.0, upper: float = 3.0) -> tuple[Array, Array]:
    """The shares of two torques, of a lower and an upper index, that give a measured index between them.

    With 1 and 3 (a wind beside a dipole) the Crab's 2.51 is a quarter wind. ValueError where n is not between them.

    >>> print([f"{share:.3f}" for share in shares_of_index(2.51)])  # of a wind (n = 1) and a dipole: the Crab's
    ['0.245', '0.755']
    """
    index = np.asarray(braking_index, dtype=float)
    if not lower < upper or np.any(index < lower) or np.any(index > upper):
        raise ValueError(f"a braking index between {lower:g} and {upper:g} is needed, not {braking_index}")
    share = (index - lower) / (upper - lower)
    return 1 - share, share


@with_quantities()
def decaying_field_period(time: Array, period: Array, period_derivative: Array, decay_time: Array) -> Array:
    """P(t) of a dipole whose field decays as exp(-t/tau): P^2 = P_0^2 + tau P_0 P_0' (1 - exp(-2 t/tau)).

    It ends at a last period; decay_time may be infinite. Source: Ostriker & Gunn 1969, ApJ 157, 1395.

    >>> print(f"{decaying_field_period(1e30, 0.1, 1e-15, 1e13):.4f}")  # it stops at sqrt(P^2 + P dP/dt tau)
    0.1049
    """
    period = positive_period(period)
    time = np.asarray(time, dtype=float)
    decays = 2 * time / decay_time
    still = decays == 0
    twice = np.where(still, 2 * time, -np.expm1(-decays) * np.where(still, 0.0, decay_time))  # the time that counts
    return np.sqrt(period**2 + period * period_derivative * twice)


@with_quantities()
def decaying_field_index(period: Array, period_derivative: Array, decay_time: Array) -> Array:
    """n = 3 + 2 P/(P' tau), which a decaying dipole has: more than 3, and very much more for old pulsars.

    >>> print(f"{decaying_field_index(0.1, 1e-15, 1e13):.1f}")  # beyond 3, as P / (P' tau) counts
    23.0
    """
    return 3 + 2 * positive_period(period) / (np.asarray(period_derivative) * decay_time)
