"""An initial body from outside the package: a torus whose matter has one specific angular momentum."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from astroinertia.initial import REQUIRED, Body, Dimension, not_negative, positive


@dataclass(frozen=True)
class Torus(Body):
    """A torus of uniform density about the z axis, whose matter has one angular momentum per mass.

    Its moments are M (R^2 + 3/4 r^2) about the axis and M (R^2/2 + 5/8 r^2) across it.
    """

    mass: Any
    major_radius: Any
    minor_radius: Any
    specific_angular_momentum: Any = 0.0

    kind: ClassVar[str] = "torus"
    source: ClassVar[str] = "Papaloizou & Pringle 1984, MNRAS 208, 721"
    options: ClassVar = {
        "mass": positive("mass", REQUIRED, "M"),
        "major_radius": positive("length", REQUIRED, "R, of the circle in its middle"),
        "minor_radius": positive("length", REQUIRED, "r, of its section"),
        "specific_angular_momentum": not_negative(Dimension(0, 2, -1), 0.0, "about the axis"),
    }

    @property
    def radius(self):
        """The largest distance from the axis."""
        return self.major_radius + self.minor_radius

    def density(self, position):
        """(N,); its scale is that of the mass."""
        across = np.hypot(position[:, 0], position[:, 1]) - self.major_radius
        return (across**2 + position[:, 2] ** 2 < self.minor_radius**2).astype(float)

    def extent(self):
        """Half sides of the box about it."""
        return self.radius, self.radius, self.minor_radius

    def velocity(self, position):
        """l/s about the axis, (N, 3)."""
        x, y, _ = position.T
        return np.stack([-y, x, 0.0 * x], axis=1) * (self.specific_angular_momentum / (x**2 + y**2))[:, None]

    def characteristic(self):
        """Its principal moments, ascending."""
        across = self.mass * (0.5 * self.major_radius**2 + 0.625 * self.minor_radius**2)
        return {"moments": (across, across, self.mass * (self.major_radius**2 + 0.75 * self.minor_radius**2))}
