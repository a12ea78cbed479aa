"""Heat from the wobble of a body that is not quite rigid."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import astroinertia.engines.late_jnp as jnp
from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.inertia.principal import EQUAL_MOMENTS
from astroinertia.units import REQUIRED, positive


@pytree
@dataclass(frozen=True, eq=False)
class InternalDissipation(Effect):
    """The body's axes turn relative to its matter by s = lambda L cross omega.

    L stays, and the energy falls by lambda |L cross omega|^2. This double bracket (Bloch, Krishnaprasad, Marsden &
    Ratiu 1996, Communications in Mathematical Physics 175, 1) is the simplest law that takes a body from any spin,
    through the separatrix, to one about its largest moment. lambda is such that a small wobble about that axis falls by
    a factor e in `time_scale`, at any spin, or, as a body of constant quality factor does, in
    time_scale (rate / omega)^3 with omega = L/I_3 (Burns & Safronov 1973, MNRAS 165, 403).
    """

    time_scale: Any
    rate: Any = None

    kind: ClassVar[str] = "internal_dissipation"

    def relative_rotation(self, body):
        """L cross omega by lambda = 1 / (time_scale L^2 ((1/I_1 + 1/I_2)/2 - 1/I_3)).

        In place of the mean it is 1/I_1 where I_2 is I_3: L does not circle an axis then, but leaves the long one.
        """
        moments = jnp.sort(body.principal_moments)
        square = jnp.sum(body.angular_momentum**2)
        spins = (square > 0.0) & (moments[0] > 0.0)
        inverse = 1.0 / jnp.where(moments > 0.0, moments, 1.0)
        prolate = moments[1] > (1.0 - EQUAL_MOMENTS) * moments[2]
        excess = jnp.where(prolate, inverse[0], 0.5 * (inverse[0] + inverse[1])) - inverse[2]
        spins = spins & (excess > 0.0)
        pace = 1.0 / (self.time_scale * jnp.where(spins, square * excess, 1.0))
        if self.rate is not None:
            pace = pace * (square**1.5 * (inverse[2] / self.rate) ** 3)
        return jnp.where(spins, pace * jnp.cross(body.angular_momentum, body.angular_velocity), 0.0)


def _size(body: Characteristic, options: Options) -> Found:
    assert body.spin is not None
    scale = options["time_scale"]
    if options["rate"] is not None and body.spin > 0.0:
        scale *= (options["rate"] / body.spin) ** 3
    gone = -math.expm1(-body.end / scale)
    return body.end / scale, within_all(body.wobble * gone)


ENTRY = Entry(
    "heat from the wobble of a body that is not quite rigid, which settles to its largest moment at fixed L",
    {
        "time_scale": positive("time", REQUIRED, "in which a small wobble falls by a factor e"),
        "rate": positive(
            "angular_velocity", None, "spin that this holds at, going with its power -3; at any spin without it",
        ),
    },
    "body", "Bloch, Krishnaprasad, Marsden & Ratiu 1996; Burns & Safronov 1973", ("rigid",), colour="orange",
    size=Measure(
        "run over time scale", "angle of the wobble times 1 - exp(-t/tau)",
        "Burns & Safronov 1973", _size, ("spin",), ("time_scale",),
    ),
    made=InternalDissipation, rank=22,
)  # fmt: skip
