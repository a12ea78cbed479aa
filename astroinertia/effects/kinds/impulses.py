"""Angular momentum added at once: a blow, a landing, a thruster that fires briefly."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, pytree
from astroinertia.effects.entries import FRAME
from astroinertia.effects.measure import TURNS, Found, Measure, Options, share_of_momentum, size, within_all
from astroinertia.units import REQUIRED, Option, positive


@pytree
@dataclass(frozen=True, eq=False)
class Impulses(Effect):
    """L jumps by `angular_momentum` at `time`, and again `every` so long, `number` times at most."""

    angular_momentum: Any
    time: Any
    every: Any = None
    number: Any = 1e9
    frame: str = field(default="inertial", metadata={"static": True})

    kind: ClassVar[str] = "impulses"
    external: ClassVar[bool] = True

    def breaks(self, start, end):
        """When they come."""
        if self.every is None:
            return (self.time,) if start < self.time <= end else ()
        first = max(0, math.floor((start - self.time) / self.every))
        last = min(int(self.number) - 1, math.ceil((end - self.time) / self.every))
        times = (self.time + number * self.every for number in range(first, last + 1))
        return tuple(time for time in times if start < time <= end)

    def impulse(self, body):
        """What one of them adds, (3,)."""
        vector = jnp.asarray(self.angular_momentum)
        return vector if self.frame == "inertial" else body.attitude.T @ vector


def _size(body: Characteristic, options: Options) -> Found:
    number = 0.0
    if body.end >= options["time"]:
        every = options["every"]
        number = 1.0 if every is None else min(options["number"], 1.0 + (body.end - options["time"]) // every)
    share = share_of_momentum(body, number * size(options["angular_momentum"]))
    return share, within_all(share)


ENTRY = Entry(
    "angular momentum that is added at once, one or many times",
    {
        "angular_momentum": Option("angular_momentum", REQUIRED, "what is added each time", shape=(3,)),
        "time": positive("time", REQUIRED, "the first time"),
        "every": positive("time", None, "how long after each the next comes; only one without it"),
        "number": Option("dimensionless", 1e9, "how many come at most", minimum=1.0),
        "frame": FRAME,
    },
    "body", "Goldstein, Poole & Safko 2002, section 1.1", ("rigid",), colour="purple", made=Impulses, rank=19,
    size=Measure(
        "impulses over L", "the sum of all impulses over L",
        "Goldstein, Poole & Safko 2002, 1.1", _size, TURNS, ("angular_momentum", "time"),
    ),
)  # fmt: skip
