"""Shock tubes in three dimensions: two gases at rest that a membrane along x parts until time 0.

A periodic box holds two tubes back to back: the left state within a quarter of the box's length from its middle, the
right state outside. The solution holds until the waves of the two membranes meet, and where they have not.
"""

from dataclasses import dataclass

import numpy as np

from astroinertia.test_problems.lattices import cells_for, filled, in_box
from astroinertia.test_problems.matter import Matter, Solution, Standard
from astroinertia.test_problems.riemann import Side, sampled, star


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
