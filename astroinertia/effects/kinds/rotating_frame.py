"""The inertial forces of a rotating frame."""

from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.effects.effect import affine_moments, angular_velocity_matrix, moments, rate_at
from astroinertia.effects.entries import AXIS
from astroinertia.units import REQUIRED, Option


@pytree
@dataclass(frozen=True, eq=False)
class RotatingFrame(Effect):
    """a = -Omega x (Omega x x) - dOmega/dt x x - 2 Omega x v about the frame's origin (0, 0, 0).

    Omega = rate + t rate_change, along the axis (Landau & Lifshitz 1976, Mechanics, eq. 39.7). The Coriolis force
    enters as a drag matrix and does no work; the centrifugal force has the potential -|Omega x x|^2/2, the Euler force
    none.
    """

    rate: Any
    rate_change: Any = None
    axis: Any = (0.0, 0.0, 1.0)

    kind: ClassVar[str] = "rotating_frame"
    external: ClassVar[bool] = True
    turns_frame: ClassVar[bool] = True

    def frame_rotation(self, fluid):
        """The matrix [Omega] at the fluid's time."""
        return angular_velocity_matrix(rate_at(self, fluid.time), self.axis)

    def position_matrix(self, fluid):
        """B of the part B x of the acceleration."""
        rotation = self.frame_rotation(fluid)
        centrifugal = -rotation @ rotation
        if self.rate_change is None:
            return centrifugal
        return centrifugal - angular_velocity_matrix(self.rate_change, self.axis)

    def acceleration(self, xp, fluid):
        """Centrifugal and Euler: B x."""
        return fluid.position @ self.position_matrix(fluid).T

    def drag(self, fluid):
        """Coriolis: -2 [Omega]."""
        return -2.0 * self.frame_rotation(fluid)

    def potential_energy(self, xp, fluid):
        """Of the centrifugal force, -1/2 sum m |Omega x x|^2."""
        return -0.5 * xp.sum(fluid.mass[:, None] * (fluid.position @ self.frame_rotation(fluid).T) ** 2)

    def virial(self, xp, fluid):
        """V = Omega^2 Q - (Q Omega) (x) Omega - Omega' x Q - 2 Omega x P, cross products with the rows of Q and P.

        What is uniform over the body, from a centre away from the origin, has no moment.
        """
        second, mixed = moments(fluid)
        axis = xp.asarray(self.axis)
        axis = axis / xp.sqrt(xp.sum(axis**2))
        rate = rate_at(self, fluid.time)
        tensor = rate**2 * (second - xp.outer(second @ axis, axis)) - 2.0 * rate * xp.cross(axis, mixed)
        return tensor if self.rate_change is None else tensor - self.rate_change * xp.cross(axis, second)

    def timestep(self, xp, fluid):
        """1/|Omega|."""
        rate = xp.sqrt(0.5 * xp.sum(self.frame_rotation(fluid) ** 2))
        return 1.0 / xp.maximum(rate, 1e-30)

    @property
    def potential_moves(self):
        """Where the rate changes."""
        return self.rate_change is not None

    def affine_force(self, body):
        """q (B F - 2 [Omega] dF/dt), exact: the acceleration is linear in position and velocity."""
        return body.second_moment * (self.position_matrix(body) @ body.deformation + self.drag(body) @ body.rate)

    def affine_push(self, body):
        """The same of the centre of mass."""
        return body.mass * (self.position_matrix(body) @ body.centre + self.drag(body) @ body.velocity)

    def affine_virial(self, body):
        """Q B^T + P (-2 [Omega])^T."""
        second, mixed = affine_moments(body)
        return second @ self.position_matrix(body).T + mixed @ self.drag(body).T

    def affine_potential(self, body):
        """Of the centrifugal force."""
        rotation = self.frame_rotation(body)
        turned, carried = rotation @ body.deformation, rotation @ body.centre
        return -0.5 * (body.second_moment * jnp.sum(turned**2) + body.mass * jnp.sum(carried**2))


def _size(body: Characteristic, options: Options) -> Found:
    turn = abs(options["rate"]) * body.end
    return turn, within_all(turn)


ENTRY = Entry(
    "centrifugal, Coriolis and Euler forces of a frame that rotates about its origin",
    {
        "rate": Option("angular_velocity", REQUIRED, "rotation rate of the frame at time 0"),
        "rate_change": Option("angular_acceleration", None, "constant change of that rate with time"),
        "axis": Option("dimensionless", AXIS, "axis of the rotation", shape=(3,), nonzero=True),
    },
    "particles", "Landau & Lifshitz 1976, Mechanics, eq. 39.7", ("sph", "ellipsoid"), colour="yellow",
    size=Measure(
        "turn of the frame in the run", "the angle that it turns by",
        "Landau & Lifshitz 1976, eq. 39.7", _size, (), ("rate",),
    ),
    pace=lambda options: (1.0 / (abs(options["rate"]) or 1e-300), None),
    made=RotatingFrame, rank=8,
)  # fmt: skip
