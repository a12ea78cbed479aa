"""Shock tubes in three dimensions: two gases at rest that a membrane along x parts until time 0.

A periodic box holds two tubes back to back: the left state within a quarter of the box's length from its middle, the
right state outside. The solution holds until the waves of the two membranes meet, and where they have not.
The exact solution of the Riemann problem of an ideal gas: Toro 2009, Riemann Solvers, chapter 4.
"""

from dataclasses import dataclass

import numpy as np

from astroinertia.process.roots import root_between
from astroinertia.test_problems.matter import Matter, Solution, Standard, cells_for, filled, in_box


@dataclass(frozen=True)
class Side:
    """Density, velocity and pressure on one side of a membrane."""

    density: float
    velocity: float
    pressure: float

    def sound(self, gamma: float) -> float:
        """Speed of sound."""
        return (gamma * self.pressure / self.density) ** 0.5

    def shock(self, pressure: float, gamma: float) -> float:
        """Speed in this gas of a shock with that pressure behind it."""
        ratio = pressure / self.pressure
        return self.sound(gamma) * ((gamma + 1.0) / (2.0 * gamma) * ratio + (gamma - 1.0) / (2.0 * gamma)) ** 0.5


def star(left: Side, right: Side, gamma: float) -> tuple[float, float]:
    """Pressure and velocity between the two waves; ValueError where the gases part and leave a vacuum."""
    gap = 2.0 * (left.sound(gamma) + right.sound(gamma)) / (gamma - 1.0)
    if right.velocity - left.velocity >= gap:
        raise ValueError("the gases part so fast that a vacuum is left between them")

    def excess(pressure: float) -> float:
        return _change(pressure, left, gamma) + _change(pressure, right, gamma) + right.velocity - left.velocity

    high = max(left.pressure, right.pressure)
    while excess(high) < 0.0:
        high *= 4.0
    pressure = root_between(excess, 1e-14 * min(left.pressure, right.pressure), high, 1e-300, 1e-14)
    change = _change(pressure, right, gamma) - _change(pressure, left, gamma)
    return pressure, 0.5 * (left.velocity + right.velocity + change)


def _change(pressure: float, side: Side, gamma: float) -> float:
    # Of the velocity through the wave of that side: a shock where the pressure rises, else a rarefaction.
    if pressure > side.pressure:
        a, b = 2.0 / ((gamma + 1.0) * side.density), (gamma - 1.0) / (gamma + 1.0) * side.pressure
        return (pressure - side.pressure) * (a / (pressure + b)) ** 0.5
    ratio = (pressure / side.pressure) ** ((gamma - 1.0) / (2.0 * gamma))
    return 2.0 * side.sound(gamma) / (gamma - 1.0) * (ratio - 1.0)


def sampled(speed: np.ndarray, left: Side, right: Side, gamma: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Density, velocity and pressure at places x/t = speed (N,)."""
    pressure, velocity = star(left, right, gamma)
    left_wave = _beside(speed, left, pressure, velocity, gamma)
    mirrored = Side(right.density, -right.velocity, right.pressure)
    density, flow, push = _beside(-speed, mirrored, pressure, -velocity, gamma)
    behind = speed < velocity
    return tuple(np.where(behind, a, b) for a, b in zip(left_wave, (density, -flow, push), strict=True))  # type: ignore


def _beside(
    speed: np.ndarray, side: Side, pressure: float, velocity: float, gamma: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    # Left of the contact, through the wave that runs to the left.
    sound, ratio, edge = side.sound(gamma), pressure / side.pressure, (gamma - 1.0) / (gamma + 1.0)
    if ratio > 1.0:
        dense = side.density * (ratio + edge) / (edge * ratio + 1.0)
        ahead = speed < side.velocity - side.shock(pressure, gamma)
        return (
            np.where(ahead, side.density, dense),
            np.where(ahead, side.velocity, velocity),
            np.where(ahead, side.pressure, pressure),
        )
    head, tail = side.velocity - sound, velocity - sound * ratio ** ((gamma - 1.0) / (2.0 * gamma))
    within = np.clip(speed, head, tail)
    flow = 2.0 / (gamma + 1.0) * (sound + 0.5 * (gamma - 1.0) * side.velocity + within)
    local = 2.0 / (gamma + 1.0) + edge / sound * (side.velocity - within)
    density = side.density * local ** (2.0 / (gamma - 1.0))
    return density, flow, side.pressure * local ** (2.0 * gamma / (gamma - 1.0))


@dataclass(frozen=True)
class Tube:
    """Two gases; the right one's lattice is so many times as wide, which gives particles equal masses."""

    left: Side
    right: Side
    ratio: int

    def place(self, count: int, lengths: np.ndarray, gamma: float) -> Matter:
        """Particles of equal mass on two lattices."""
        length, across = lengths[0], lengths[1:]
        share = self.ratio**3 / (self.ratio**3 + 1.0)
        cells = np.array(cells_for(share * count, np.array([0.5 * length, *across]), even=True))
        low, high = np.array([-0.25 * length, *(-0.5 * across)]), np.array([0.25 * length, *(0.5 * across)])
        dense = filled(tuple(cells), low, high)
        thin = filled(tuple(cells // self.ratio), low, high)
        thin[:, 0] += np.where(thin[:, 0] > 0.0, -0.5, 0.5) * length  # the half of the box outside
        inside = np.repeat([True, False], [len(dense), len(thin)])
        volume = 0.5 * np.prod(lengths)
        mass = np.where(inside, self.left.density * volume / len(dense), self.right.density * volume / len(thin))
        pressure = np.where(inside, self.left.pressure, self.right.pressure)
        density = np.where(inside, self.left.density, self.right.density)
        position = np.concatenate([dense, thin])
        return Matter(mass, position, np.zeros_like(position), pressure / ((gamma - 1.0) * density))

    def exact(self, position: np.ndarray, time: float, lengths: np.ndarray, gamma: float) -> Solution:
        """The Riemann solution of the membrane on the particle's side of the middle."""
        x = in_box(position, lengths)[:, 0]
        way = np.where(x < 0.0, -1.0, 1.0)
        speed = (np.abs(x) - 0.25 * lengths[0]) / max(time, 1e-300)
        density, flow, pressure = sampled(speed, self.left, self.right, gamma)
        velocity = np.zeros_like(position)
        velocity[:, 0] = way * flow
        return Solution(density, velocity, pressure)

    def meeting_time(self, length: float, gamma: float) -> float:
        """When the first waves of the two membranes meet."""
        pressure, velocity = star(self.left, self.right, gamma)
        return 0.25 * length / max(self.right.shock(pressure, gamma), self.left.sound(gamma), abs(velocity))


SOD_TUBE = Tube(Side(1.0, 0.0, 1.0), Side(0.125, 0.0, 0.1), 2)
STRONG_TUBE = Tube(Side(1.0, 0.0, 1000.0), Side(1.0, 0.0, 0.1), 1)
SOD = Standard(SOD_TUBE.place, SOD_TUBE.exact, True, "Sod 1978, JCP 27, 1")
STRONG = Standard(
    STRONG_TUBE.place, STRONG_TUBE.exact, True, "Monaghan 1997, JCP 136, 298; Rosswog 2020, MNRAS 498, 4230"
)
