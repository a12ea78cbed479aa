"""Orbits between the steps of REBOUND's IAS15, which then need not be cut where they are wanted.

IAS15 takes steps so short that the polynomial of degree 9 which has the place and its first four derivatives at both
ends of a step follows the orbit to some 1e-14 of the distance. Derivatives of the attraction: Nitadori & Makino 2008,
New Astronomy 13, 498, eqs. 10 to 16. Checked by tests/unit/orbits/test_dense.py.
"""

import math
import sys
from typing import Any

import numpy as np
import rebound

from astroinertia.orbits.states import live
from astroinertia.process.quantities import with_quantities

_KNOWN = 5  # derivatives at each end, the place itself among them
_ORDERS = np.arange(2 * _KNOWN)
# What so many derivatives make of share^order where the share is 1: (derivatives, orders).
_AT_END = np.array([[math.perm(order, n) for order in _ORDERS] for n in range(_KNOWN)], dtype=float)
# What the lower terms, which the beginning of a step gives, miss at its end gives the higher ones.
_FROM_END = np.linalg.inv(_AT_END[:, _KNOWN:])
EPSILON = 1e-10  # of IAS15, a tenth of the usual: steps are 0.7 times as long, and the polynomial misses 30 times less
_AHEAD = 4.0  # times as far as is asked for, orbits are followed


class DenseOrbits:
    """Particles of a simulation relative to particle 0; its time is the time 0 here, and runs forwards.

    They attract each other as point masses, and IAS15 follows them, whatever the simulation's own integrator is. The
    simulation itself stays as it is.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> print(np.round(DenseOrbits(bodies).at(np.array([0.0, np.pi]))[0][:, 0], 9) + 0.0)  # half a circle
    [[ 1.  0.  0.]
     [-1.  0.  0.]]
    """

    def __init__(self, bodies: rebound.Simulation) -> None:
        self._bodies = bodies.copy()
        if str(bodies.integrator) != "ias15":
            self._bodies.integrator = "ias15"
        integrator: Any = self._bodies.integrator
        integrator.epsilon = min(integrator.epsilon, EPSILON)
        self._strength = np.empty(bodies.N)
        bodies.serialize_particle_data(m=self._strength)
        self._strength *= bodies.G
        self._begin, self._length, self._reached = np.empty(0), np.empty(0), 0.0
        self._terms = np.empty((0, 2 * _KNOWN, bodies.N - 1, 3))

    @with_quantities()
    def at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities (T, N-1, 3) at rising times (T,), none before that of the last `leave`."""
        if times[-1] > self._reached or not len(self._begin):
            self._follow(_AHEAD * float(times[-1]))
        step = np.clip(np.searchsorted(self._begin, times, side="right") - 1, 0, None)
        length, terms = self._length[step], self._terms[step]
        powers = ((times - self._begin[step]) / length)[:, None] ** _ORDERS
        slopes = _ORDERS[1:] * powers[:, :-1] / length[:, None]
        return np.einsum("tk,tkpi->tpi", powers, terms), np.einsum("tk,tkpi->tpi", slopes, terms[:, 1:])

    def leave(self, time: float) -> None:
        """Call a time 0 from now on, and forget what lies before it."""
        kept = max(0, int(np.searchsorted(self._begin, time, side="right")) - 1)
        self._begin, self._length, self._terms = self._begin[kept:] - time, self._length[kept:], self._terms[kept:]
        self._reached -= time

    def _follow(self, until: float) -> None:
        times, states = _steps(self._bodies, until - self._reached)
        place, speed = np.split(states, 2, axis=2)
        data = np.stack([place, speed, *_bending(place, speed, self._strength)], axis=1)
        data = data[:, :, 1:] - data[:, :, :1]
        length = np.diff(times)
        powers = length[:, None] ** np.arange(_KNOWN)
        begin, end = (part * powers[..., None, None] for part in (data[:-1], data[1:]))
        low = begin / np.array([math.factorial(n) for n in range(_KNOWN)])[:, None, None]
        missed = end - np.einsum("nk,skpi->snpi", _AT_END[:, :_KNOWN], low)
        high = np.einsum("kn,snpi->skpi", _FROM_END, missed)
        self._begin = np.concatenate([self._begin, self._reached + times[:-1]])
        self._length = np.concatenate([self._length, length])
        self._terms = np.concatenate([self._terms, np.concatenate([low, high], axis=1)])
        self._reached += times[-1]


def _steps(bodies: rebound.Simulation, span: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (K,) from 0 on and states (K, N, 6) at the ends of the steps in which a simulation passes a time."""
    present = live(bodies)
    bodies.t = 0.0  # late times are too coarse for short steps
    times, states = [0.0], [present.copy()]

    def note(_: Any) -> None:
        if bodies.t > times[-1]:
            times.append(bodies.t)
            states.append(present.copy())

    bodies.heartbeat = note
    bodies.integrate(max(span, sys.float_info.min), exact_finish_time=0)  # one step at least
    return np.array(times), np.array(states)


def _bending(place: np.ndarray, speed: np.ndarray, strength: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Accelerations and their first two rates of change (K, N, 3) of point masses of such G m (N,)."""

    def between(part: np.ndarray) -> np.ndarray:
        return part[:, None, :] - part[:, :, None]

    def product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return (one * other).sum(axis=-1, keepdims=True) / square

    apart, passing = between(place), between(speed)
    square = (apart**2).sum(axis=-1, keepdims=True)
    square[:, *np.diag_indices(len(strength))] = np.inf
    weight = strength[:, None] / square**1.5
    pull = weight * apart
    acceleration = pull.sum(axis=2)
    closing = product(apart, passing)
    change = weight * passing - 3.0 * closing * pull
    pulling = between(acceleration)
    bend = product(passing, passing) + product(apart, pulling) + closing**2
    second = weight * pulling - 6.0 * closing * change - 3.0 * bend * pull
    return acceleration, change.sum(axis=2), second.sum(axis=2)
