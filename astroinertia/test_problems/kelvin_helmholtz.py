"""Shear flow whose two smooth layers roll up (McNally, Lyra & Passy 2012, ApJS 201, 18), in a box of lengths 1 x 1.

What is known is how the mode that is put in grows, while the flow is smooth: the equations of compressible flow without
viscosity, by Fourier collocation in the plane and Runge-Kutta in time.
"""

from functools import lru_cache

import numpy as np
from scipy.integrate import cumulative_trapezoid

from astroinertia.test_problems.matter import Matter, Standard, cells_for, centred, filled

RAMP = 0.025  # thickness of the layers
WAVE = 4.0 * np.pi  # wave number of the mode
PUSH = 0.01  # its velocity at time 0
PRESSURE = 2.5
NODES = (16, 256)  # of the collocation, along one wave and across the layers


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
    mass = cumulative_trapezoid(density, initial=0.0)
    return np.interp(share, mass / mass[-1], y)


def amplitude(position: np.ndarray, velocity: np.ndarray, volume: np.ndarray) -> float:
    """Size of the mode in the velocity along y, near the layers (McNally et al. 2012, equations 10 to 13)."""
    x, y = np.mod(position[:, 0], 1.0), np.mod(position[:, 1] + 0.5, 1.0)
    weight = volume * np.exp(-WAVE * np.abs(np.minimum(y, 1.0 - y) - 0.25))
    wave = (weight * velocity[:, 1] * np.exp(1j * WAVE * x)).sum() / weight.sum()
    return float(2.0 * np.abs(wave))


@lru_cache(maxsize=4)
def _rolling(gamma: float, end: float, push: float, nodes: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the size of the mode, of the flow in one of its waves, by as many collocation points along x and y."""
    x, y = 0.5 * np.arange(nodes[0]) / nodes[0], np.arange(nodes[1]) / nodes[1]
    along = 2j * np.pi * np.fft.fftfreq(nodes[0], 0.5 / nodes[0])[:, None]
    across = 2j * np.pi * np.fft.rfftfreq(nodes[1], 1.0 / nodes[1])
    # Products of waves beyond two thirds of the shortest would come back as others.
    kept = (np.abs(along) < abs(along).max() / 1.5) & (np.abs(across) < abs(across).max() / 1.5)
    weight = np.exp(1j * WAVE * x)[:, None] * np.exp(-WAVE * np.abs(np.minimum(y, 1.0 - y) - 0.25))

    def smooth(flow: np.ndarray) -> np.ndarray:
        return np.fft.irfft2(kept * np.fft.rfft2(flow), nodes)

    def rates(flow: np.ndarray) -> np.ndarray:
        waves = np.fft.rfft2(flow)
        density, u, v, pressure = flow
        slopes, rises = np.fft.irfft2(along * waves, nodes), np.fft.irfft2(across * waves, nodes)
        spread = slopes[1] + rises[2]
        forces = density * spread, slopes[3] / density, rises[3] / density, gamma * pressure * spread
        return smooth(-u * slopes - v * rises - np.stack(forces))

    density, stream = background(y)
    flow = np.empty((4, *nodes))
    flow[0], flow[1], flow[2], flow[3] = density, stream, push * np.sin(WAVE * x)[:, None], PRESSURE
    flow = smooth(flow)
    count = int(np.ceil(end / (0.45 * min(0.5 / nodes[0], 1.0 / nodes[1]) / (0.5 + np.sqrt(gamma * PRESSURE)))))
    step, sizes = end / count, [push]
    for _ in range(count):
        one = rates(flow)
        two = rates(flow + 0.5 * step * one)
        three = rates(flow + 0.5 * step * two)
        four = rates(flow + step * three)
        flow = flow + step / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        sizes.append(float(2.0 * np.abs((weight * flow[2]).sum()) / np.abs(weight).sum()))
    return np.linspace(0.0, end, count + 1), np.array(sizes)


def exact_amplitude(
    times: np.ndarray, gamma: float, end: float = 1.5, push: float = PUSH, nodes: tuple[int, int] = NODES
) -> np.ndarray:
    """The size of the mode at times (T,) up to `end`, to 1e-4 of the largest up to 1.5.

    push: velocity of the mode at time 0. nodes: collocation points along one wave and across the layers.
    """
    return np.interp(times, *_rolling(gamma, end, push, nodes))


KELVIN_HELMHOLTZ = Standard(place, None, True, "McNally, Lyra & Passy 2012, ApJS 201, 18")
