"""Heat that a kick brings to matter whose energy u is not linear in its entropy function A, exactly.

At fixed density A' is what u(rho, A') = u(rho, A) + q is solved for, with q = sum_e q_e the heat that effects bring
within the kick by pairs and by exchange with the surroundings; so what friction takes from the motion is what matter
has, to rounding. Where A' is held by a limit, what is missed of q is taken from the effects' heat in proportion to
its size: the ledger has what matter was given. Where u is linear in A, leapfrog and models.active do without all this.
Tests: tests/unit/test_heat_update.py.
"""

from collections.abc import Sequence
from functools import reduce
from typing import Any

from astroinertia.engines.elementwise import added, elementwise, totals
from astroinertia.integrate.exchange import Exchange, lost

Array = Any


def size_of(xp, heat):
    """|q|."""
    return (xp.abs(heat),)


def delivered(xp, mass, heat, size, missed):
    """The energy of heat that is one of several of which u has so much more than all together."""
    return (mass * (heat + missed * xp.abs(heat) / xp.where(size > 0.0, size, 1.0)),)


def heat_update(
    xp: Any, matter: Any, mass: Array, density: Array, entropy: Array, heats: Sequence[Array | None],
    exchange: Exchange | None, dt: Array, least: Any,
) -> tuple[Array, list[Array]]:  # fmt: skip
    """A after dt (N,), or all alike, and the energy that each effect has brought, scalars.

    matter: the equation of state of these particles (N,); heats: the heat per mass of the pairs of each effect, (N,);
    least: what A is not to fall below, (N,) or a number.
    """
    if exchange is not None:
        more = _exchanged(xp, matter, density, entropy, heats, exchange, dt)
        heats = [added(q, other) for q, other in zip(heats, more, strict=True)]
    total = reduce(added, heats, None)
    if total is None:
        return entropy, [xp.zeros(()) for _ in heats]
    after, missed = matter.heated(xp, density, entropy, total, least)
    size = reduce(added, [None if q is None else elementwise(xp, size_of, q)[0] for q in heats], None)
    brought = [xp.zeros(()) if q is None else totals(xp, delivered, mass, q, size, missed)[0][0] for q in heats]
    return after, brought


def _exchanged(
    xp: Any, matter: Any, density: Array, entropy: Array, heats: Sequence[Array | None], exchange: Exchange, dt: Array
) -> list[Array | None]:
    # The heat per mass that each effect exchanges, as of matter whose A is its thermal energy.
    thermal, decay = matter.state(xp, density, entropy)[3], exchange.decay
    gained = added(reduce(added, heats, None), dt * exchange.gain)
    found = []
    for gain, share in zip(exchange.gains, exchange.decays, strict=True):
        taken = None if gain is None else elementwise(xp, lost, 1.0, thermal, gained, decay, dt, 1.0, share)[0]
        found.append(None if gain is None else added(taken, dt * gain))
    return found
