"""Shear flow whose two smooth layers roll up (McNally, Lyra & Passy 2012, ApJS 201, 18), in a box of lengths 1 x 1.

What is known exactly is how the mode that is put in grows while it is small: the linear equations of compressible flow
about the layers, by Fourier collocation across them and Runge-Kutta in time.
"""

from functools import lru_cache

import numpy as np

from astroinertia.test_problems.lattices import cells_for, centred, filled
from astroinertia.test_problems.matter import Matter, Standard

RAMP = 0.025  # thickness of the layers
WAVE = 4.0 * np.pi  # wave number of the mode
PUSH = 0.01  # its velocity at time 0
PRESSURE = 2.5
NODES = 512  # of the collocation


def ramp(y: np.ndarray) -> np.ndarray:
    """0 outside, 1 in the stream 1/4 < y < 3/4, with smooth layers; y in [0, 1)."""
    down = np.minimum(y, 1.0 - y)  # symmetric about the middle
    away = 0.5 * np.exp(-np.abs(down - 0.25) / RAMP)
    return np.where(down < 0.25, away, 1.0 - away)


def background(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Density, 1 and 2, and velocity along x, 1/2 and -1/2."""
    part = ramp(np.mod(y, 1.0))
    return 1.0 + part, 0.5 - part


def place(count: int, lengths: np.ndarray, gamma: float) -> Matter:
    """Equal masses on a lattice that is squeezed along y until it carries the density."""
    cells = cells_for(count, lengths)
    position = filled(cells, *centred(lengths))
    position[:, 1] = _carrying(position[:, 1] + 0.5) - 0.5
    density, stream = background(position[:, 1] + 0.5)
    mass = np.full(len(position), 1.5 * np.prod(lengths) / len(position))
    velocity = np.zeros_like(position)
    velocity[:, 0], velocity[:, 1] = stream, PUSH * np.sin(WAVE * position[:, 0])
    return Matter(mass, position, velocity, PRESSURE / ((gamma - 1.0) * density))


def _carrying(share: np.ndarray) -> np.ndarray:
    # Where the mass from y = 0 on is that share of all.
    y = np.linspace(0.0, 1.0, 100001)
    density = background(np.minimum(y, 1.0 - 1e-12))[0]
    mass = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp(share, mass / mass[-1], y)


def amplitude(position: np.ndarray, velocity: np.ndarray, volume: np.ndarray) -> float:
    """Size of the mode in the velocity along y, near the layers (McNally et al. 2012, equations 10 to 13)."""
    x, y = np.mod(position[:, 0], 1.0), np.mod(position[:, 1] + 0.5, 1.0)
    weight = volume * np.exp(-WAVE * np.abs(np.minimum(y, 1.0 - y) - 0.25))
    wave = (weight * velocity[:, 1] * np.exp(1j * WAVE * x)).sum() / weight.sum()
    return float(2.0 * np.abs(wave))


@lru_cache(maxsize=4)
def _linear(gamma: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the size of the mode: density, both velocities and pressure change as exp(i WAVE x)."""
    y = np.arange(NODES) / NODES
    density, stream = background(y)
    wave = 2j * np.pi * np.fft.rfftfreq(NODES, 1.0 / NODES)
    part = ramp(y)
    rise = np.where(y < 0.5, 1.0, -1.0) * np.minimum(part, 1.0 - part) / RAMP  # of the density; the stream falls so
    weight = np.exp(-WAVE * np.abs(np.minimum(y, 1.0 - y) - 0.25))

    def slope(f: np.ndarray) -> np.ndarray:
        real, imaginary = (np.fft.irfft(wave * np.fft.rfft(part), NODES) for part in (np.real(f), np.imag(f)))
        return real + 1j * imaginary

    def rates(state: np.ndarray) -> np.ndarray:
        _, along, across, pressure = state
        spread = 1j * WAVE * along + slope(across)
        change = np.stack([
            -across * rise - density * spread,
            across * rise - 1j * WAVE * pressure / density,
            -slope(pressure) / density,
            -gamma * PRESSURE * spread,
        ])  # fmt: skip
        return change - 1j * WAVE * stream * state

    state = np.zeros((4, NODES), dtype=complex)
    state[2] = PUSH / 1j
    step = 0.5 / (NODES * np.sqrt(gamma * PRESSURE))  # somewhat less than classical Runge-Kutta is stable with
    count = int(np.ceil(end / step))
    step, sizes = end / count, [PUSH]
    for _ in range(count):
        one = rates(state)
        two = rates(state + 0.5 * step * one)
        three = rates(state + 0.5 * step * two)
        four = rates(state + step * three)
        state = state + step / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        sizes.append(float(np.abs(weight @ state[2]) / weight.sum()))
    return np.linspace(0.0, end, count + 1), np.array(sizes)


def exact_amplitude(times: np.ndarray, gamma: float, end: float = 1.5) -> np.ndarray:
    """The size of the mode at times (T,) up to `end`, as long as it is small."""
    return np.interp(times, *_linear(gamma, end))


def compared(position: np.ndarray, time: float, lengths: np.ndarray) -> np.ndarray:
    """Everywhere."""
    return np.ones(len(position), bool)


KELVIN_HELMHOLTZ = Standard(place, None, compared, True, "McNally, Lyra & Passy 2012, ApJS 201, 18")
