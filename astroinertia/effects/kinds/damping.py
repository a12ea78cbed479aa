"""Drag towards rest or towards rigid rotation, for relaxing a body to equilibrium."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.effects.effect import affine_moments, angular_velocity_matrix, moments, rate_at
from astroinertia.effects.entries import AXIS
from astroinertia.units import REQUIRED, Option, choice, not_negative, positive


@pytree
@dataclass(frozen=True, eq=False)
class Damping(Effect):
    """a = -(v - v_frame - Omega x (x - c))/tau, with c the centre of mass, until a given time.

    v_frame is the velocity of the centre of mass, so that the damping exerts no net force, or zero (frame "inertial").
    With a target rotation rate the body relaxes to rigid rotation, by being turned from outside; without, to rest.
    Omega = rate + t rate_change: changed slowly, it leads the body through figures of equilibrium, behind it by
    tau rate_change.
    """

    time_scale: Any
    rate: Any = None
    rate_change: Any = None
    axis: Any = (0.0, 0.0, 1.0)
    until: Any = None
    frame: str = field(default="centre_of_mass", metadata={"static": True})

    kind: ClassVar[str] = "damping"
    external: ClassVar[bool] = True

    @classmethod
    def from_options(cls, options):
        """Refuses a change of no rate."""
        if options["rate_change"] is not None and options["rate"] is None:
            raise ValueError("a rate_change needs the rate at time 0, which may be zero")
        return cls(**options)

    def strength(self, fluid):
        """1/tau while the damping lasts, then 0."""
        lasts = 1.0 if self.until is None else (fluid.time < self.until)
        return lasts / self.time_scale

    def breaks(self, start, end):
        """When it ends."""
        return (self.until,) if self.until is not None and start < self.until <= end else ()

    def during(self, start, end):
        """With or without it, the ends included."""
        if self.until is None:
            return self
        return replace(self, until=math.inf if 0.5 * (start + end) < self.until else 0.0)

    def target_rotation(self, fluid):
        """The matrix [Omega] of the rotation that velocities decay to now, (3, 3)."""
        return angular_velocity_matrix(rate_at(self, fluid.time), self.axis)

    def drag(self, fluid):
        """-1/tau in every direction."""
        return -self.strength(fluid) * np.eye(3)

    def acceleration(self, xp, fluid):
        """What keeps the target velocity, (v_frame + Omega x (x - c))/tau; None where that is zero."""
        if self.rate is None and self.frame == "inertial":
            return None
        target = xp.zeros_like(fluid.position)
        if self.frame == "centre_of_mass":
            target = target + fluid.centre_velocity
        if self.rate is not None:
            target = target + (fluid.position - fluid.centre) @ self.target_rotation(fluid).T
        return self.strength(fluid) * target

    def virial(self, xp, fluid):
        """(Q [Omega]^T - P)/tau; uniform velocities have no moment about the centre of mass."""
        second, mixed = moments(fluid)
        target = 0.0 if self.rate is None else second @ self.target_rotation(fluid).T
        return self.strength(fluid) * (target - mixed)

    def timestep(self, xp, fluid):
        """The decay time tau."""
        return 1.0 / xp.maximum(self.strength(fluid), 1e-30)

    def affine_force(self, body):
        """q ([Omega] F - dF/dt)/tau."""
        target = 0.0 if self.rate is None else self.target_rotation(body) @ body.deformation
        return self.strength(body) * body.second_moment * (target - body.rate)

    def affine_push(self, body):
        """-M v/tau of the centre of mass where velocities are relative to the inertial frame."""
        return -self.strength(body) * body.mass * body.velocity if self.frame == "inertial" else None

    def affine_virial(self, body):
        """(Q [Omega]^T - P)/tau."""
        second, mixed = affine_moments(body)
        target = 0.0 if self.rate is None else second @ self.target_rotation(body).T
        return self.strength(body) * (target - mixed)


def _size(body: Characteristic, options: Options) -> Found:
    last = body.end if options["until"] is None else min(body.end, options["until"])
    gone = -math.expm1(-last / options["time_scale"])
    return last / options["time_scale"], within_all(gone)


ENTRY = Entry(
    "drag towards rest or rigid rotation, for relaxation",
    {
        "time_scale": positive("time", REQUIRED, "time over which velocities decay by a factor e"),
        "rate": Option("angular_velocity", None, "rotation rate that velocities decay to; to rest without it"),
        "rate_change": Option("angular_acceleration", None, "constant change of that rate with time, from time 0"),
        "axis": Option("dimensionless", AXIS, "axis of that rotation", shape=(3,), nonzero=True),
        "until": not_negative("time", None, "when the damping ends; never without it"),
        "frame": choice("what the velocities are relative to", "centre_of_mass", "inertial"),
    },
    "particles", "Gingold & Monaghan 1977", ("sph", "ellipsoid"), colour="purple", made=Damping, rank=7,
    size=Measure("run over time scale", "1 - exp(-t/tau)", "Gingold & Monaghan 1977", _size, (), ("time_scale",)),
    pace=lambda options: (options["time_scale"], options["until"]),
)  # fmt: skip
