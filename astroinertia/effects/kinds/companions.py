"""The companions of a scene as point masses beside the fluid: on the orbits of point masses, or moved by the fluid."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.characteristic import tidal_parameter
from astroinertia.effects.measure import Found, Measure, Options, tidal_change, within_all
from astroinertia.effects.passes import time_beside
from astroinertia.gravity.point_masses import (
    attraction,
    potential_energy,
    reaction,
    tidal_attraction,
    tidal_energy,
    virial,
)
from astroinertia.units import choice, not_negative


@pytree
@dataclass(frozen=True, eq=False)
class Companions(Effect):
    """a = -sum over companions of M d/(d^2 + s^2)^(3/2), less the same at the origin where the frame is "tidal".

    Where they are is in fluid.points: with the motion "orbit", on the orbits that REBOUND finds with the body as a
    point mass among them, or that an archive holds; with "live", where the attraction of the fluid and of each other
    takes them, in the same kicks and drifts as the fluid. With "direct" the frame is inertial and the centre of mass
    of all is at rest at its origin; with "tidal" the origin is the body as a point mass, which falls freely.
    Checked by tests/physics/test_companions.py.
    """

    motion: str = field(default="orbit", metadata={"static": True})
    frame: str = field(default="direct", metadata={"static": True})
    softening: Any = 0.0

    kind: ClassVar[str] = "companions"
    external: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses live companions in a frame that falls with a point mass."""
        if options["motion"] == "live" and options["frame"] == "tidal":
            raise ValueError('live companions move in an inertial frame: frame must be "direct"')
        return cls(**options)

    @property
    def inertial(self):
        """Where orbits are given; what moves by itself is refused beside all that acts on the fluid alone."""
        return "move on orbits in inertial axes" if self.motion == "orbit" else ""

    def points(self, fluid):
        """Masses (n,), places (n, 3), and the square of the softening."""
        points = fluid.points[self.kind]
        return points.mass, points.position, self.softening**2

    def acceleration(self, xp, fluid):
        """By all companions; in the tidal frame less that of the origin."""
        pull = attraction if self.frame == "direct" else tidal_attraction
        return pull(xp, fluid.position, *self.points(fluid))

    def reaction(self, xp, fluid, weight):
        """Of live companions."""
        if self.motion == "orbit":
            return None
        _, place, softening = self.points(fluid)
        return reaction(xp, weight, fluid.position, place, softening)

    def potential_energy(self, xp, fluid):
        """-sum m M/(d^2 + s^2)^(1/2); less its value and slope at the origin where that falls.

        With live companions, all energy that they have by themselves.
        """
        energy = potential_energy if self.frame == "direct" else tidal_energy
        total = energy(xp, fluid.mass, fluid.position, *self.points(fluid))
        if self.motion == "live":
            total = total + fluid.points[self.kind].energy(xp, fluid.point_masses)
        return total

    def virial(self, xp, fluid):
        """The same in both frames: the frame's acceleration is uniform over the body and has no moment."""
        return virial(xp, fluid.mass, fluid.position, fluid.centre, *self.points(fluid))

    def timestep(self, xp, fluid):
        """The time beside the companions of each particle (effects.passes), or the orbital time of two companions."""
        mass, place, softening = self.points(fluid)
        times = time_beside(xp, fluid, mass, place, fluid.points[self.kind].velocity, softening)
        if self.motion == "orbit":
            return times
        return xp.minimum(
            times, fluid.points[self.kind].meeting_time(xp, fluid.point_masses, xp.min(fluid.sound_speed))
        )

    def recorded(self, state):
        """The companions' own orbits, and those of each about the body as two points, m = M_k M/(M_k + M)."""
        points, mass, body = state.points[self.kind], state.mass, state.mass.sum()
        place, speed = points.position, points.velocity
        away, pace = place - mass @ state.position / body, speed - mass @ state.velocity / body
        distance = np.sqrt((away**2).sum(axis=1))
        reduced = points.mass * body / (points.mass + body)
        return {
            "companion_position": np.asarray(place),
            "companion_velocity": np.asarray(speed),
            "companion_angular_momentum": np.asarray(reduced[:, None] * np.cross(away, pace)),
            "companion_energy": np.asarray(0.5 * reduced * (pace**2).sum(axis=1) - points.mass * body / distance),
        }

    @property
    def potential_moves(self):
        """On prescribed orbits; the energy of live companions is in the potential, with all that they take."""
        return self.motion != "live"


def _size(body: Characteristic, options: Options) -> Found:
    parameters = [tidal_parameter(body, other.mass, other.nearest) for other in body.neighbours or ()]
    return max(parameters, default=0.0), within_all(sum(tidal_change(body, parameter) for parameter in parameters))


ENTRY = Entry(
    "the scene's [[companions]] as point masses beside the fluid",
    {
        "motion": choice(
            "orbit: on the orbits that REBOUND finds, where the body is a point mass; live: they feel the fluid's "
            "gravity, and move with it",
            "orbit", "live",
        ),
        "frame": choice(
            "direct: inertial, with the centre of mass of all at rest; tidal: the body is at the origin, which "
            "falls freely",
            "tidal", "direct", default="direct",
        ),
        "softening": not_negative("length", 0.0, "Plummer softening of the companions"),
    },
    "particles", "Rein & Liu 2012; Hernquist & Katz 1989", auto="companions", made=Companions, rank=10,
    size=Measure(
        "(M'/M) (R/d)^3 at the nearest", "five times that if bound, times (t/t_dyn)^2 at first; all beyond Roche",
        "Murray & Dermott 1999, section 4.2", _size, ("mass", "radius", "neighbours"),
    ),
)  # fmt: skip
