"""An observable from outside the package: the direction of a bar, the phase of the quadrupole."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from astroinertia.observables import Observable


@dataclass(frozen=True)
class QuadrupolePhase(Observable):
    """The angle from x to the long axis of a body, seen from z: half the argument of Q_xx - Q_yy + 2i Q_xy.

    That is the phase of Q_22, taken so that a body which turns about z at the rate omega has omega t: it grows from x
    to y, within (-pi/2, pi/2]. NaN where Q_22 is zero but for round-off, as that of a body that is round about z.
    """

    kind: ClassVar[str] = "quadrupole_phase"
    long_name: ClassVar[str] = "phase of the quadrupole about z"
    dimension: ClassVar[str] = "angle"
    source: ClassVar[str] = "Q_22 = sum m (x + i y)^2 in terms of the second moment"

    def value(self, body):
        """The phase, in radians."""
        Q = body.second_moment
        wave = complex(Q[0, 0] - Q[1, 1], 2.0 * Q[0, 1])
        return 0.5 * np.angle(wave) if abs(wave) > 1e-12 * np.trace(Q) else np.nan
