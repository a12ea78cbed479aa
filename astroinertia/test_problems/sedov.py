"""A point explosion in a cold gas: energy 1 in density 1 (Sedov 1959; Landau & Lifshitz 1987, section 106)."""

from functools import lru_cache

import numpy as np
from scipy.special import roots_jacobi

from astroinertia.test_problems.matter import Matter, Solution, Standard, cells_for, centred, filled, in_box

COLD = 1e-6  # pressure of the gas around
NODES = 60  # of the energy integral: round-off from some 40 on, for gamma from 1.1 to 4
INJECTED = 32  # particles, about, that the energy is put into, smoothly


@lru_cache(maxsize=8)
def similarity(gamma: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """r/R from 0 to 1, density over that around, v t/r 5/2, c^2 (5 t/2 r)^2, and R/(E t^2/rho)^(1/5).

    For gamma up to 6.8, to 2e-9: of 7 or more explosions are empty inside.
    """
    above = np.linspace(0.0, 1.0, 20001)[1:] ** 8  # dense at the centre, where all changes slowly
    radius, density, v, sound, _ = _flow(gamma, above * _span(gamma))
    return radius, density, v, sound, (16.0 * np.pi / 25.0 * energy_integral(gamma)) ** -0.2


def energy_integral(gamma: float) -> float:
    """Integral of density (v^2 / 2 + c^2 / (gamma (gamma - 1))) r^4 over r from 0 to 1, in the units of `similarity`.

    Towards the centre its terms are a power of v - 1/gamma times a smooth function: Gauss-Jacobi.
    """
    power = (gamma - 4.0) / (2.0 * gamma + 1.0)
    node, weight = roots_jacobi(NODES, 0.0, power)
    above = 0.5 * _span(gamma) * (1.0 + node)
    radius, density, v, sound, slope = _flow(gamma, above)
    terms = density * (0.5 * v**2 + sound / (gamma * (gamma - 1.0))) * radius**5 * slope / above**power
    return float((0.5 * _span(gamma)) ** (power + 1.0) * weight @ terms)


def _span(gamma: float) -> float:
    """What v has at the shock over what it has at the centre, 1 / gamma."""
    return 2.0 / (gamma + 1.0) - 1.0 / gamma


def _flow(gamma: float, above: np.ndarray) -> tuple[np.ndarray, ...]:
    """r, density, v and c^2 as `similarity` gives them, and d ln r / dv, for values of v - 1/gamma."""
    v = 1.0 / gamma + above
    one = (5.0 - (3.0 * gamma - 1.0) * v) * (gamma + 1.0) / (7.0 - gamma)
    two = gamma * above * (gamma + 1.0) / (gamma - 1.0)
    first = -(13.0 * gamma**2 - 7.0 * gamma + 12.0) / ((3.0 * gamma - 1.0) * (2.0 * gamma + 1.0))
    second, third = 5.0 * (gamma - 1.0) / (2.0 * gamma + 1.0), 3.0 / (2.0 * gamma + 1.0)
    radius = ((0.5 * (gamma + 1.0) * v) ** -2.0 * one**first * two**second) ** 0.2
    # What gamma = 2 makes an exponential of.
    ratio = 3.0 * ((gamma + 1.0) * v - 2.0) / ((7.0 - gamma) * (1.0 - v))
    growth = ratio if gamma == 2.0 else np.log1p((2.0 - gamma) * ratio) / (2.0 - gamma)
    fourth = (7.0 - gamma) / ((3.0 * gamma - 1.0) * (2.0 * gamma + 1.0))
    density = (gamma + 1.0) / (gamma - 1.0) * two**third * one**fourth * np.exp(2.0 * growth)
    sound = gamma * (gamma - 1.0) * (1.0 - v) * v**2 / (2.0 * gamma * above)
    steep = (3.0 * gamma - 1.0) / (5.0 - (3.0 * gamma - 1.0) * v)
    slope = 0.2 * (second / above - 2.0 / v - first * steep)
    return radius, density, v, sound, slope


def place(count: int, lengths: np.ndarray, gamma: float) -> Matter:
    """A lattice at rest; the energy is spread over the middle of the box with a smooth weight."""
    cells = cells_for(count, lengths)
    position = filled(cells, *centred(lengths))
    mass = np.full(len(position), np.prod(lengths) / len(position))
    radius = np.linalg.norm(position, axis=1)
    weight = np.maximum(1.0 - (radius / _size(mass[0])) ** 2, 0.0)
    energy = COLD / (gamma - 1.0) + weight / (mass * weight).sum()
    return Matter(mass, position, np.zeros_like(position), energy)


def _size(mass: float) -> float:
    # Of what the energy is put into.
    return (3.0 * INJECTED * mass / (4.0 * np.pi)) ** (1 / 3)


def begins(mass: float, gamma: float) -> float:
    """When the shock leaves the middle, into which the energy is put: the explosion is that of a point from then on."""
    return (_size(mass) / similarity(gamma)[-1]) ** 2.5


def shock_radius(time: float, gamma: float) -> float:
    """How far the shock has come."""
    return similarity(gamma)[-1] * time**0.4


def exact(position: np.ndarray, time: float, lengths: np.ndarray, gamma: float) -> Solution:
    """The self-similar flow behind the shock, and gas at rest before it."""
    s, density, v, sound, _ = similarity(gamma)
    place = in_box(position, lengths)
    radius, reach = np.linalg.norm(place, axis=1), shock_radius(time, gamma)
    inside, at = radius <= reach, radius / reach
    flow = np.where(inside, 0.4 / time * np.interp(at, s, v), 0.0)
    dense = np.where(inside, np.interp(at, s, density), 1.0)
    # The pressure is smooth at the centre, where sound and density are not.
    inner = s**2 * density * sound
    pressure = np.where(inside, (0.4 * reach / time) ** 2 * np.interp(at, s, inner) / gamma, COLD)
    return Solution(dense, flow[:, None] * place, pressure)


def compared(position: np.ndarray, time: float, lengths: np.ndarray) -> np.ndarray:
    """The sphere that fits into the box."""
    return np.linalg.norm(in_box(position, lengths), axis=1) < 0.5 * lengths.min()


SEDOV = Standard(
    place, exact, True, "Sedov 1959; Landau & Lifshitz 1987, Fluid Mechanics, section 106", compared, begins
)
