"""Free and heavy tops: closed forms, and the integrators held to them."""

import math

import jax
import numpy as np

from astroinertia.models.rigid.splitting import advance, rotor, turning_rates
from astroinertia.rotation import free_attitude, free_top, heavy_top
from astroinertia.rotation.attitude import attitude_of_quaternion
from astroinertia.verify.comparison import Quantities

_MOMENTS = (1.0, 2.0, 3.0)
_RACKET = (0.1, 1.0, 0.1)  # a spin next to the axis of the middle moment
_PERIODS, _STEPS, _ORDER = 100, 400, 8  # of the integration that is held to the closed form, steps a period


def closed_forms() -> Quantities:
    """Periods near and very near the separatrix, the angular velocity on the way, and the symmetric top."""
    racket = free_top.free_top(_MOMENTS, _RACKET)
    nearly = free_top.free_top(_MOMENTS, (1e-8, 1.0, 1e-8))
    symmetric = free_top.free_top((2.0, 2.0, 3.0), (0.3, 0.0, 1.0))
    return {
        "racket_period": free_top.period(racket),
        "separatrix_period": free_top.period(nearly),
        "racket_rate": float(free_top.angular_velocity(racket, np.array([20.0]))[0, 0]),
        "symmetric_wobble": free_top.wobble_rate(symmetric),
        "symmetric_precession": free_attitude.precession_rate(symmetric),
    }


def splitting() -> Quantities:
    """A hundred flips of the racket by the splitting: distance from the closed form, and L summed again in space."""
    top, moments = free_top.free_top(_MOMENTS, _RACKET), np.array(_MOMENTS)
    end, momentum = _PERIODS * free_top.period(top), moments * np.array(_RACKET)
    with jax.enable_x64(True):
        state = advance(
            rotor([1.0, 0.0, 0.0, 0.0], momentum), turning_rates(moments),
            0.0, end, _PERIODS * _STEPS, _ORDER,
        )  # fmt: skip
        inside = np.asarray(state.momentum_in_body)
        axes = attitude_of_quaternion(np.asarray(state.quaternion))
    size = float(np.linalg.norm(momentum))
    exact = moments * free_top.angular_velocity(top, np.array([end]))[0]
    return {
        "splitting_distance": float(abs(inside - exact).max()) / size,
        "splitting_momentum": float(np.linalg.norm(axes.T @ inside - momentum)) / size,
        "splitting_energy": abs(0.5 * float(np.sum(inside**2 / moments)) / top.energy - 1.0),
        "splitting_attitude": float(abs(axes - free_attitude.attitude(top, np.array([end]))[0]).max()),
    }


def heavy() -> Quantities:
    """The heavy symmetric top with A = M = 2, C = 1: steady precession, sleep; and a pendulum, A = C = M = 1."""
    slow, fast = heavy_top.steady_precession_rates(2.0, 1.0, 2.0, math.pi / 3, 3.0)
    steady = heavy_top.heavy_top(2.0, 1.0, 2.0, math.pi / 3, (0.0, math.sin(math.pi / 3), 3.0))
    pendulum = heavy_top.heavy_top(1.0, 1.0, 1.0, math.pi / 2, (0.0, 0.0, 0.0))
    return {
        "heavy_slow": slow,
        "heavy_fast": fast,
        "heavy_steady": heavy_top.precession_rate(steady),
        "heavy_sleeping": heavy_top.least_sleeping_spin(2.0, 1.0, 2.0),
        "heavy_pendulum": 2.0 * heavy_top.nutation_period(pendulum),  # the tilt repeats on either side
    }


COMPUTATIONS = (closed_forms, splitting, heavy)
