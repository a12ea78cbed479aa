"""Heat that matter exchanges with its surroundings, du/dt = g - k u of each effect, integrated exactly over a step.

u is the thermal energy, A a multiple of it at fixed density. With the heat q of pairs, and g and k summed over effects,

    A' = A e^-x + (q + g) dt f(x) dA/du,    x = k dt,    f(x) = (1 - e^-x)/x,

so that matter which cools within a step, or to an equilibrium of heating and cooling, ends where it should. What the
exchange takes in all, u (1 - e^-x) + (q + g) dt (1 - f), is shared out by the k of each effect: the sum is exact. Laws
that are not linear have k at the present u: the half kicks at both ends of a step make that second order (the first
order exponential Rosenbrock scheme, Hochbruck & Ostermann 2010, Acta Numerica 19, 209, made symmetric).
Tests: tests/unit/test_exchange.py.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from astroinertia.engines.elementwise import added, elementwise, totals
from astroinertia.engines.pytree import pytree

Array = Any
SERIES = 1e-4  # below which f is taken from its series: the rest of it is less than rounding


@pytree
@dataclass(frozen=True)
class Exchange:
    """gain g and decay k (N,) of each effect (None where it has none), and dA/du (N,)."""

    gains: tuple[Array | None, ...]
    decays: tuple[Array | None, ...]
    entropy_per_heat: Array

    @property
    def gain(self) -> Array:
        """The sum over effects, (N,)."""
        return reduce(added, self.gains)

    @property
    def decay(self) -> Array:
        """The sum over effects, (N,)."""
        return reduce(added, self.decays)


def exchange_of(pairs: Sequence[tuple[Array, Array] | None], entropy_per_heat: Array) -> Exchange | None:
    """That of the (g, k) of each effect; None where no effect has any."""
    if all(pair is None for pair in pairs):
        return None
    gains, decays = (tuple(None if pair is None else pair[side] for pair in pairs) for side in (0, 1))
    return Exchange(gains, decays, entropy_per_heat)


def remaining(xp, x):
    """e^-x and f(x)."""
    small = xp.abs(x) < SERIES
    series = 1.0 - 0.5 * x * (1.0 - x / 3.0 * (1.0 - 0.25 * x))
    left = xp.exp(-x)
    return left, xp.where(small, series, (1.0 - left) / xp.where(small, 1.0, x))


def exchanged(xp, entropy, gained, decay, dt):
    """A after dt, of which `gained` would be new without decay."""
    left, part = remaining(xp, decay * dt)
    return (entropy * left + gained * part,)


def lost(xp, mass, entropy, gained, decay, dt, entropy_per_heat, share):
    """The energy that an effect of the decay `share` has taken."""
    left, part = remaining(xp, decay * dt)
    taken = (entropy * (1.0 - left) + gained * (1.0 - part)) / entropy_per_heat
    return (-mass * taken * share / xp.where(decay > 0.0, decay, 1.0),)


def given(xp, mass, gain, dt):
    """m g dt."""
    return (mass * gain * dt,)


def changing_time(xp, h, energy, gain, decay):
    """u/|du/dt| of matter that cools; of matter that is heated, the time in which that moves it by h, besides."""
    rate = gain - decay * energy
    size = xp.maximum(xp.abs(rate), 1e-100)
    spread = xp.where(rate > 0.0, xp.power(h * h / size, 1.0 / 3.0), 0.0)
    return (energy / size + spread,)


def entropy_after(xp: Any, exchange: Exchange, entropy: Array, gained: Array, dt: Array) -> Array:
    """A (N,) after dt (N,) or all alike, in which heat and gains would have added `gained` (N,) to it."""
    return elementwise(xp, exchanged, entropy, gained, exchange.decay, dt)[0]


def energies(xp: Any, exchange: Exchange | None, mass: Array, entropy: Array, gained: Array, dt: Array) -> list[Array]:
    """What each effect's exchange adds to the internal energy over dt, scalars; of `entropy_after`, with A before."""
    if exchange is None:
        return []
    found = []
    for gain, share in zip(exchange.gains, exchange.decays, strict=True):
        if gain is None:
            found.append(xp.zeros(()))
            continue
        unit, decay = exchange.entropy_per_heat, exchange.decay
        taken = totals(xp, lost, mass, entropy, gained, decay, dt, unit, share)[0][0]
        found.append(taken + totals(xp, given, mass, gain, dt)[0][0])
    return found
