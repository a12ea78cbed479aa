"""Uniform gravity on a body that turns about a fixed point: tops, gyroscopes, pendulums."""

from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.measure import (
    TURNS,
    Found,
    Measure,
    Options,
    angular_momentum,
    share_of_momentum,
    size,
    within_all,
)
from astroinertia.units import REQUIRED, Option


@pytree
@dataclass(frozen=True, eq=False)
class Pivot(Effect):
    """tau = l cross M g about the fixed point, with the arm l from there to the centre of mass, fixed in the body.

    The body's moments are those about its centre of mass; the model takes them to the pivot.
    """

    gravity: Any
    arm: Any

    kind: ClassVar[str] = "pivot"
    external: ClassVar[bool] = True
    follows_spin: ClassVar[bool] = False
    conservative: ClassVar[bool] = True

    def place(self, body):
        """The centre of mass from the fixed point, (3,), in inertial axes."""
        return body.attitude.T @ jnp.asarray(self.arm)

    def torque(self, body):
        """About the fixed point."""
        return body.mass * jnp.cross(self.place(body), jnp.asarray(self.gravity))

    def potential(self, body):
        """-M g . l, zero where the centre of mass is level with the fixed point."""
        return -body.mass * (self.place(body) @ jnp.asarray(self.gravity))

    def frequency(self, body):
        """Of small oscillations about the axis of the least moment."""
        strength = body.mass * jnp.linalg.norm(jnp.asarray(self.gravity)) * jnp.linalg.norm(jnp.asarray(self.arm))
        across = jnp.sort(jnp.linalg.eigvalsh(body.inertia))
        return jnp.sqrt(strength / across[1])


def _size(body: Characteristic, options: Options) -> Found:
    assert body.mass is not None and body.moments is not None
    torque = body.mass * size(options["gravity"]) * size(options["arm"])
    if not body.spin:
        swing = torque / max(body.moments[2], 1e-300) * body.end**2
        return swing, within_all(swing)
    return torque / (angular_momentum(body) * body.spin), within_all(share_of_momentum(body, torque * body.end))


ENTRY = Entry(
    "uniform gravity on a body that turns about a fixed point, such as a top or a pendulum",
    {
        "gravity": Option("acceleration", REQUIRED, "the acceleration of gravity", shape=(3,)),
        "arm": Option(
            "length", REQUIRED, "from the fixed point to the centre of mass, in body axes", shape=(3,), nonzero=True
        ),
    },
    "body", "Goldstein, Poole & Safko 2002, section 5.7", ("rigid",), colour="vermillion", made=Pivot, rank=20,
    size=Measure(
        "M g l/(L omega)", "angle of precession M g l t/L",
        "Goldstein, Poole & Safko 2002, 5.7", _size, (*TURNS, "mass"), ("gravity", "arm"),
    ),
)  # fmt: skip
