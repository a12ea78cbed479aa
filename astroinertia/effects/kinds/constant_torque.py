"""A constant torque, in space or in the body."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.entries import FRAME
from astroinertia.effects.measure import TURNS, Found, Measure, Options, share_of_momentum, size, within_all
from astroinertia.units import REQUIRED, Option, not_negative


@pytree
@dataclass(frozen=True, eq=False)
class ConstantTorque(Effect):
    """tau, from `begin` until `until`: constant in inertial axes, or along axes of the body (a thruster)."""

    vector: Any
    begin: Any = 0.0
    until: Any = None
    frame: str = field(default="inertial", metadata={"static": True})

    kind: ClassVar[str] = "constant_torque"
    external: ClassVar[bool] = True
    follows_spin: ClassVar[bool] = False

    @classmethod
    def from_options(cls, options):
        """Refuses an end before the beginning."""
        if options["until"] is not None and options["until"] <= options["begin"]:
            raise ValueError("the torque must end after it begins")
        return cls(**options)

    def torque(self, body):
        """The torque, (3,), while it acts."""
        vector = jnp.asarray(self.vector)
        vector = vector if self.frame == "inertial" else body.attitude.T @ vector
        acts = body.time >= self.begin
        if self.until is not None:
            acts = acts & (body.time < self.until)
        return jnp.where(acts, vector, 0.0)

    def breaks(self, start, end):
        """When it begins and when it ends."""
        return tuple(time for time in (self.begin, self.until) if time is not None and start < time <= end)

    def during(self, start, end):
        """With or without its torque, the ends included."""
        middle = 0.5 * (start + end)
        acts = middle > self.begin and (self.until is None or middle < self.until)
        forever = None if self.until is None else math.inf
        return replace(self, begin=-math.inf if acts else math.inf, until=forever)


def _size(body: Characteristic, options: Options) -> Found:
    last = body.end if options["until"] is None else min(body.end, options["until"])
    share = share_of_momentum(body, size(options["vector"]) * max(0.0, last - options["begin"]))
    return share, within_all(share)


ENTRY = Entry(
    "a constant torque, in space or in the body",
    {
        "vector": Option("torque", REQUIRED, "the torque", shape=(3,)),
        "frame": FRAME,
        "begin": not_negative("time", 0.0, "when it begins"),
        "until": not_negative("time", None, "when it ends; never without it"),
    },
    "body", "Goldstein, Poole & Safko 2002, section 5.5", ("rigid", "scaling"), colour="yellow",
    size=Measure(
        "torque times run over L", "torque times the time that it acts, over L",
        "Goldstein, Poole & Safko 2002, 1.1", _size, TURNS, ("vector",),
    ),
    made=ConstantTorque, rank=18,
)  # fmt: skip
