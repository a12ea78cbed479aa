"""Spin axes over billions of years: precession about an orbit that itself precesses, nothing averaged but the orbit.

    ds/dt = alpha (s.n) s x n,    n(t) from sin(I/2) exp(i node) = sum of N_j exp(i (g_j t + phase_j)).

A step turns s about the n of its middle by the exact angle, so |s| = 1 to round-off for ever and the step need only
resolve the orbit, not the precession; steps are composed to order 4 by Suzuki's fractal, all of it reversible in time.
Sources: Ward 1973, Science 181, 260; Laskar & Robutel 1993, Nature 361, 608; Suzuki 1990, Phys. Lett. A 146, 319.
Tests: tests/unit/rotation/test_secular_spin.py; a billion years: tests/hard/test_secular_spin_hard.py.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from astroinertia.process.quantities import with_quantities

Array = Any

_WEIGHT = 1 / (4 - 4 ** (1 / 3))  # Suzuki 1990: s, s, 1 - 4 s, s, s raise order 2 to 4
_STAGES = np.array([_WEIGHT, _WEIGHT, 1 - 4 * _WEIGHT, _WEIGHT, _WEIGHT])
_STEPS = 24  # steps in the shortest of the times 1/rate; the error goes as the fourth power
_MOST_STEPS = 2e9


class SpinHistory(NamedTuple):
    """Times (N,), spin axes and orbit normals (N, 3) in inertial axes, obliquities (N,) in rad, and the steps taken."""

    time: np.ndarray
    axis: np.ndarray
    normal: np.ndarray
    obliquity: np.ndarray
    steps: int


@with_quantities(amplitudes=None, rates="rad/s", phases="rad")
def orbit_normal(times: Array, amplitudes: Array, rates: Array, phases: Array) -> np.ndarray:
    """Normals (..., 3) of an orbit whose sin(I/2) exp(i node) is a sum of terms (J,): rad, rad s-1, rad.

    The reference plane is x-y and nodes are from x. ValueError where the terms add up beyond sin(I/2) = 1.
    Source: Laskar 1988, A&A 198, 341. Checked by tests/unit/rotation/test_secular_spin.py.

    >>> print(orbit_normal(0.0, np.array([np.sin(0.05)]), np.array([0.0]), np.array([0.0])).round(4))  # tilted by 0.1
    [ 0.     -0.0998  0.995 ]
    """
    amplitudes, rates, phases = _terms(amplitudes, rates, phases)
    turning = np.multiply.outer(np.asarray(times, dtype=float), rates) + phases
    x, y = (amplitudes * np.cos(turning)).sum(-1), (amplitudes * np.sin(turning)).sum(-1)
    root = np.sqrt(1 - x**2 - y**2)
    return np.stack([2 * y * root, -2 * x * root, 1 - 2 * (x**2 + y**2)], -1)


@with_quantities(precession_constant="rad/s", amplitudes=None, rates="rad/s", phases="rad")
def spin_history(
    times: Array, axis: Array, precession_constant: float, amplitudes: Array, rates: Array, phases: Array,
    growth_rate: float = 0.0, steps_per_radian: int = _STEPS,
) -> SpinHistory:  # fmt: skip
    """The spin axis at increasing times (N,), s, from `axis` (3,) at the first, on an orbit as in `orbit_normal`.

    precession_constant: alpha at time 0, rad s-1; it goes as exp(growth_rate t), slowly, as tides, moons or a shrinking
    planet change it. steps_per_radian: of the fastest of the orbit's rates and a tenth of alpha. ValueError for times
    that do not increase, an axis of zero length, less than a step a radian, and a span of more than 2e9 steps.
    A billion years take 0.3 s with one term and 5 s with the eight of the planets.
    Checked by tests/unit/rotation/test_secular_spin.py.
    """
    times, start = np.asarray(times, dtype=float), np.asarray(axis, dtype=float)
    terms = _terms(amplitudes, rates, phases)
    largest = np.abs(start).max(initial=0.0)
    if times.ndim != 1 or not np.isfinite(times).all() or np.any(np.diff(times) <= 0):
        raise ValueError("the times of a spin's history increase and are finite")
    if start.shape != (3,) or not 0 < largest < np.inf:
        raise ValueError("the axis of a spin has three components and a length")
    if not np.isfinite([precession_constant, growth_rate]).all():
        raise ValueError(
            f"a precession constant and its growth are finite, not {precession_constant} and {growth_rate}"
        )
    if not steps_per_radian >= 1:
        raise ValueError(f"a spin's history takes at least one step a radian, not {steps_per_radian}")
    last = abs(precession_constant) * max(np.exp(growth_rate * times[0]), np.exp(growth_rate * times[-1]))
    fastest = max(np.abs(terms[1]).max(), 0.1 * last, abs(growth_rate))
    spans = np.diff(times)
    counts = np.ceil(spans * fastest * steps_per_radian).astype(np.int64) if len(spans) else np.zeros(0, np.int64)
    counts = np.maximum(counts, 1)
    if counts.sum() > _MOST_STEPS:
        raise ValueError(f"{counts.sum():.1e} steps are too many: give fewer radians to follow, or a shorter time")
    unit = start / largest
    unit /= np.linalg.norm(unit)
    axes = _evolved(times, counts, unit, float(precession_constant), float(growth_rate), *terms)
    normals = orbit_normal(times, *terms)
    cross = np.linalg.norm(np.cross(axes, normals), axis=1)
    return SpinHistory(times, axes, normals, np.arctan2(cross, (axes * normals).sum(1)), int(counts.sum()))


def _terms(amplitudes: Array, rates: Array, phases: Array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    one, two, three = (np.atleast_1d(np.asarray(terms, dtype=float)) for terms in (amplitudes, rates, phases))
    if one.ndim != 1 or not one.shape == two.shape == three.shape or not one.size:
        raise ValueError("an orbit's motion is a sum of terms, each with an amplitude, a rate and a phase")
    if not np.isfinite([one, two, three]).all() or np.abs(one).sum() >= 1:
        raise ValueError("the amplitudes of sin(I/2) add up to less than 1")
    return one, two, three


@njit(cache=True, nogil=True, error_model="numpy")
def _evolved(times, counts, start, alpha, growth, amplitudes, rates, phases):
    """Axes (N, 3) at the times, with a number of steps between each of them and the next."""
    axes = np.empty((times.size, 3))
    a, b, c = start[0], start[1], start[2]
    axes[0, 0], axes[0, 1], axes[0, 2] = a, b, c
    for k in range(counts.size):
        step = (times[k + 1] - times[k]) / counts[k]
        for j in range(counts[k]):
            now = times[k] + j * step
            for stage in range(_STAGES.size):
                part = _STAGES[stage] * step
                middle = now + 0.5 * part
                now += part
                x = y = 0.0
                for m in range(amplitudes.size):
                    angle = rates[m] * middle + phases[m]
                    x += amplitudes[m] * np.cos(angle)
                    y += amplitudes[m] * np.sin(angle)
                root = np.sqrt(1.0 - x * x - y * y)
                nx, ny, nz = 2.0 * y * root, -2.0 * x * root, 1.0 - 2.0 * (x * x + y * y)
                along = a * nx + b * ny + c * nz
                turn = -alpha * np.exp(growth * middle) * along * part
                # Rodrigues' rotation about n, from (1 - cos) without cancellation.
                sine, half = np.sin(turn), np.sin(0.5 * turn)
                versine = 2.0 * half * half
                a, b, c = (
                    a + sine * (ny * c - nz * b) + versine * (along * nx - a),
                    b + sine * (nz * a - nx * c) + versine * (along * ny - b),
                    c + sine * (nx * b - ny * a) + versine * (along * nz - c),
                )
            shrink = 0.5 * (3.0 - a * a - b * b - c * c)  # what round-off made of |s|, to its first power
            a, b, c = a * shrink, b * shrink, c * shrink
        axes[k + 1, 0], axes[k + 1, 1], axes[k + 1, 2] = a, b, c
    return axes
