"""The tide of a point mass nearby, at rest or on a prescribed orbit."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.characteristic import tidal_parameter
from astroinertia.effects.effect import affine_moments
from astroinertia.effects.entries import AXIS
from astroinertia.effects.measure import Found, Measure, Options, size, tidal_change
from astroinertia.effects.passes import time_beside
from astroinertia.gravity.point_masses import attraction, potential_energy, tidal_attraction, tidal_energy, virial
from astroinertia.orbits.kepler import eccentric_anomaly, place_on_open_orbit
from astroinertia.units import REQUIRED, Option, choice, not_negative, positive

MOST_ELLIPTIC = 0.99


@pytree
@dataclass(frozen=True, eq=False)
class Tide(Effect):
    """a = -M d/(d^2 + s^2)^(3/2) with d = x - X(t), minus the same at the origin where the frame is "tidal".

    X is fixed, or runs on a Kepler orbit about the origin: it is at `position` at the pericentre and goes round
    `normal` (Murray & Dermott 1999, Solar System Dynamics, sections 2.3 and 2.4), on an ellipse in `period` with
    `mean_anomaly` at time 0; on a parabola or hyperbola it is nearest at `pericentre_time`, with the speed that `mass`
    gives, the body's own neglected. The orbit is prescribed: the body does not act back on it. With "direct" the frame
    is inertial; with "tidal" its origin falls freely, and the body follows the difference of attractions.
    """

    mass: Any
    position: Any
    period: Any = None
    eccentricity: Any = 0.0
    normal: Any = (0.0, 0.0, 1.0)
    mean_anomaly: Any = 0.0
    pericentre_time: Any = None
    softening: Any = 0.0
    frame: str = field(default="tidal", metadata={"static": True})

    kind: ClassVar[str] = "tide"
    external: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses an orbit that its normal is not normal to, and a mixture of two orbits."""
        position, normal = options["position"], options["normal"]
        is_closed, is_open = options["period"] is not None, options["pericentre_time"] is not None
        if is_closed and is_open:
            raise ValueError("it needs a period (an ellipse) or a pericentre_time (a parabola or hyperbola), not both")
        if is_closed and options["eccentricity"] > MOST_ELLIPTIC:
            raise ValueError(f"an orbit with a period has an eccentricity of at most {MOST_ELLIPTIC}")
        if is_open and options["eccentricity"] < 1.0:
            raise ValueError("an orbit with a pericentre_time has an eccentricity of at least 1")
        if is_closed or is_open:
            along = sum(p * n for p, n in zip(position, normal, strict=True))
            if abs(along) > 1e-9 * math.hypot(*position) * math.hypot(*normal):
                raise ValueError("the normal of the orbit must be perpendicular to the position")
        return cls(**options)

    def place(self, xp, fluid):
        """X at the fluid's time, (3,)."""
        pericentre = xp.asarray(self.position)
        if not self.potential_moves:
            return pericentre
        normal = xp.asarray(self.normal)
        across = xp.cross(normal / xp.sqrt(xp.sum(normal**2)), pericentre)
        e = self.eccentricity
        if self.pericentre_time is not None:
            rate = (self.mass / xp.sum(pericentre**2) ** 1.5) ** 0.5
            along, sideways = place_on_open_orbit(xp, rate * (fluid.time - self.pericentre_time), e)
            return along * pericentre + sideways * across
        anomaly = eccentric_anomaly(xp, self.mean_anomaly + 2.0 * math.pi / self.period * fluid.time, e)
        # In units of the pericentre distance a (1 - e).
        sideways = xp.sin(anomaly) * (1.0 - e * e) ** 0.5
        return ((xp.cos(anomaly) - e) * pericentre + sideways * across) / (1.0 - e)

    def velocity(self, xp, fluid):
        """dX/dt at the fluid's time, (3,): (mu/p)^(1/2) (-sin f, e + cos f) with the true anomaly f, p = q (1 + e).

        Bate, Mueller & White 1971, Fundamentals of Astrodynamics, eq. 2.5-4.
        """
        pericentre = xp.asarray(self.position)
        if not self.potential_moves:
            return xp.zeros(3)
        normal, place, e = xp.asarray(self.normal), self.place(xp, fluid), self.eccentricity
        nearest, distance = xp.sqrt(xp.sum(pericentre**2)), xp.sqrt(xp.sum(place**2))
        along = pericentre / nearest
        across = xp.cross(normal / xp.sqrt(xp.sum(normal**2)), along)
        strength = self.mass if self.period is None else (2.0 * math.pi / self.period) ** 2 * (nearest / (1.0 - e)) ** 3
        forward = (e + xp.sum(place * along) / distance) * across - xp.sum(place * across) / distance * along
        return (strength / (nearest * (1.0 + e))) ** 0.5 * forward

    def point(self, xp, fluid):
        """Its mass (1,), its place (1, 3), and the square of its softening."""
        return xp.asarray(self.mass).reshape(1), self.place(xp, fluid)[None], self.softening**2

    def acceleration(self, xp, fluid):
        """Of the perturber alone; in the tidal frame less that of the origin."""
        pull = attraction if self.frame == "direct" else tidal_attraction
        return pull(xp, fluid.position, *self.point(xp, fluid))

    def potential_energy(self, xp, fluid):
        """-M sum m/(d^2 + s^2)^(1/2); in the tidal frame less its value and its slope at the origin."""
        energy = potential_energy if self.frame == "direct" else tidal_energy
        return energy(xp, fluid.mass, fluid.position, *self.point(xp, fluid))

    def virial(self, xp, fluid):
        """The same in both frames: the frame's acceleration is uniform over the body and has no moment."""
        return virial(xp, fluid.mass, fluid.position, fluid.centre, *self.point(xp, fluid))

    def timestep(self, xp, fluid):
        """The shortest time of a particle beside the perturber (effects.passes)."""
        mass, place, softening = self.point(xp, fluid)
        return xp.min(time_beside(xp, fluid, mass, place, self.velocity(xp, fluid)[None], softening))

    @property
    def potential_moves(self):
        """Where the perturber does."""
        return self.period is not None or self.pericentre_time is not None

    def affine_potential(self, body):
        """To second order in the body's size: about the origin in the tidal frame, about the centre of mass if direct.

        The tidal frame has 1/2 (Q + M c (x) c) : T with T the second derivatives at the origin (Chandrasekhar 1969,
        section 55: the problem of Roche); the direct one M Phi(c) + 1/2 Q : T with T and Phi at the centre c.
        """
        away, squared = self._away(body)
        second, _ = affine_moments(body)
        if self.frame == "direct":
            return -self.mass * body.mass * squared**-0.5 + 0.5 * (second * self._curvature(away, squared)).sum()
        whole = second + body.mass * jnp.outer(body.centre, body.centre)
        return 0.5 * (whole * self._curvature(away, squared)).sum()

    def affine_force(self, body):
        """-q T F."""
        return -body.second_moment * self._curvature(*self._away(body)) @ body.deformation

    def affine_push(self, body):
        """-M T c in the tidal frame; the attraction of the centre and of the body's quadrupole in the direct one."""
        away, squared = self._away(body)
        if self.frame == "tidal":
            return -body.mass * self._curvature(away, squared) @ body.centre
        second, _ = affine_moments(body)
        along = second @ away
        pull = body.mass * squared**-1.5 * away - 1.5 * squared**-2.5 * (jnp.trace(second) * away + 2.0 * along)
        return self.mass * (pull + 7.5 * squared**-3.5 * (away @ along) * away)

    def affine_virial(self, body):
        """-M (Q/D^3 - 3 (Q d) (x) d/D^5) with D^2 = d^2 + s^2, d from where the potential is expanded to X."""
        away, squared = self._away(body)
        second, _ = affine_moments(body)
        return -self.mass * squared**-1.5 * (second - 3.0 / squared * jnp.outer(second @ away, away))

    def affine_reach(self, body):
        """How near the perturber the body comes: the square of its longest semi-axis over that of the distance.

        Of the homogeneous ellipsoid with the same moments, by the norm of Q: right for a long body, up to 3^(1/2) too
        large for a round one. From 1 on the expansion means nothing.
        """
        away = self.place(jnp, body) - body.centre
        second, _ = affine_moments(body)
        return 5.0 / body.mass * jnp.sqrt((second**2).sum()) / (away @ away)

    def _away(self, body):
        """From where the potential is expanded to the perturber, (3,), and the softened square of that distance."""
        away = self.place(jnp, body) - (body.centre if self.frame == "direct" else 0.0)
        return away, away @ away + self.softening**2

    def _curvature(self, away, squared):
        """T (3, 3), the second derivatives of the potential."""
        return self.mass * squared**-1.5 * (jnp.eye(3) - 3.0 / squared * jnp.outer(away, away))


def nearest_approach(end: float, options: Options) -> float:
    """The least distance of a perturber in the run; of an open orbit that of its pericentre, an upper estimate."""
    pericentre, e = size(options["position"]), options["eccentricity"]
    if options["period"] is None:
        return pericentre
    first = options["mean_anomaly"]
    last = first + 2.0 * math.pi * end / options["period"]
    if math.floor(last / (2.0 * math.pi)) > math.floor(first / (2.0 * math.pi)) or first == 0.0:
        return pericentre
    return min(pericentre / (1.0 - e) * (1.0 - e * float(np.cos(eccentric_anomaly(np, m, e)))) for m in (first, last))


def _size(body: Characteristic, options: Options) -> Found:
    parameter = tidal_parameter(body, options["mass"], nearest_approach(body.end, options))
    return parameter, tidal_change(body, parameter)


ENTRY = Entry(
    "a point mass nearby, fixed or on a Kepler orbit about the origin (ellipse, parabola or hyperbola)",
    {
        "mass": positive("mass", REQUIRED, "mass of the perturber"),
        "position": Option("length", REQUIRED, "where it is: fixed, or at its pericentre", shape=(3,), nonzero=True),
        "period": positive("time", None, "orbital period; without it the perturber stays where it is"),
        "eccentricity": Option(
            "dimensionless", 0.0, f"of the orbit; at most {MOST_ELLIPTIC} with a period", minimum=0.0, maximum=100.0
        ),
        "normal": Option("dimensionless", AXIS, "normal of the orbit", shape=(3,), nonzero=True),
        "mean_anomaly": Option("dimensionless", 0.0, "at time 0, in radians from the pericentre"),
        "pericentre_time": Option("time", None, "when a parabola or hyperbola (eccentricity >= 1) is nearest"),
        "softening": not_negative("length", 0.0, "Plummer softening of the perturber"),
        "frame": choice(
            "tidal: relative to the acceleration of the origin, which falls freely; direct: the whole attraction",
            "tidal", "direct",
        ),
    },
    "particles", "Murray & Dermott 1999, chapter 2", ("sph", "ellipsoid"), colour="sky", made=Tide, rank=9,
    size=Measure(
        "(M'/M) (R/d)^3 at the nearest", "five times that if bound, times (t/t_dyn)^2 at first; all beyond Roche",
        "Murray & Dermott 1999, section 4.2", _size, ("mass", "radius"), ("mass", "position"),
    ),
)  # fmt: skip
