"""What heats and cools a fluid of particles: pairs, exchange with the surroundings, and compression.

Heat that matter exchanges with its surroundings, du/dt = g - k u of each effect, is integrated exactly over a kick. u
is the thermal energy, A a multiple of it at fixed density. With the heat q of pairs, and g and k summed over effects,

    A' = A e^-x + (q + g) dt f(x) dA/du,    x = k dt,    f(x) = (1 - e^-x)/x,

so that matter which cools within a step, or to an equilibrium of heating and cooling, ends where it should. What the
exchange takes in all, u (1 - e^-x) + (q + g) dt (1 - f), is shared out by the k of each effect: the sum is exact. Laws
that are not linear have k at the present u: the half kicks at both ends of a step make that second order (the first
order exponential Rosenbrock scheme, Hochbruck & Ostermann 2010, Acta Numerica 19, 209, made symmetric).

Where u is not linear in A, A' is what u(rho, A') = u(rho, A) + q is solved for at fixed density, with q the heat that
all effects bring within the kick: what friction takes from the motion is what matter has, to rounding. Where A' is held
by a limit, what is missed of q is taken from the effects' heat in proportion to its size: the ledger has what matter
was given. Tests: tests/unit/models/sph/test_heat.py, tests/unit/models/sph/test_heat_update.py.
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


@dataclass(frozen=True)
class Heat:
    """What heats particles in a kick over span, () or (n,).

    `length` times the heat per mass of the pairs of each effect, (n,) or None, and the exchange with the surroundings;
    `length` times entropy_gain is what both together would add to the entropy function without decay.
    """

    by_pairs: Sequence[Array | None]
    exchange: Exchange | None
    entropy_gain: Array | None
    span: Array
    length: Array | float


def exchange_of(pairs: Sequence[tuple[Array, Array] | None], entropy_per_heat: Array) -> Exchange | None:
    """That of the (g, k) of each effect; None where no effect has any."""
    if all(pair is None for pair in pairs):
        return None
    gains, decays = (tuple(None if pair is None else pair[side] for pair in pairs) for side in (0, 1))
    return Exchange(gains, decays, entropy_per_heat)


def entropy_gain(per_heat: Array, by_pairs: Sequence[Array | None], more: Array | None) -> Array | None:
    """dA/du times the heat of all pairs and what comes besides, (n,); None where nothing heats."""
    heat = added(reduce(added, by_pairs, None), more)
    return None if heat is None else per_heat * heat


def after_heat(
    xp: Any, heat: Heat, mass: Array, entropy: Array, density: Array, matter: Any | None
) -> tuple[Array, list[Array]]:
    """Entropies after a kick, (n,), and the energy that each effect has brought, scalars.

    density (n,) and matter, the equation of state of these particles, where their energy is not linear in the entropy.
    A step too long for a cold particle that is pushed hard shows in the energy, not in a negative temperature:
    entropies fall by half at most.
    """
    if matter is not None:
        by_pairs = [None if q is None else heat.length * q for q in heat.by_pairs]
        least = 0.5 * entropy if heat.exchange is None else -xp.inf
        return heat_update(xp, matter, mass, density, entropy, by_pairs, heat.exchange, heat.span, least)
    gains = [xp.zeros(()) if q is None else heat.length * totals(xp, product, mass, q)[0][0] for q in heat.by_pairs]
    if heat.entropy_gain is None:
        return entropy, gains
    if heat.exchange is None:
        return elementwise(xp, heated, entropy, heat.entropy_gain, heat.length)[0], gains
    gained = heat.length * heat.entropy_gain
    taken = exchanged_energies(xp, heat.exchange, mass, entropy, gained, heat.span)
    after = entropy_after(xp, heat.exchange, entropy, gained, heat.span)
    return after, [one + other for one, other in zip(gains, taken, strict=True)]


def entropy_after(xp: Any, exchange: Exchange | None, entropy: Array, gained: Array, dt: Array) -> Array:
    """A (N,) after dt (N,) or all alike, in which heat and gains would have added `gained` (N,) to it."""
    if exchange is None:
        return added(entropy, gained)
    return elementwise(xp, exchanged, entropy, gained, exchange.decay, dt)[0]


def exchanged_energies(
    xp: Any, exchange: Exchange, mass: Array, entropy: Array, gained: Array, dt: Array
) -> list[Array]:
    """What each effect's exchange adds to the internal energy over dt, scalars; of `entropy_after`, with A before."""
    energies = []
    for gain, share in zip(exchange.gains, exchange.decays, strict=True):
        if gain is None:
            energies.append(xp.zeros(()))
            continue
        unit, decay = exchange.entropy_per_heat, exchange.decay
        taken = totals(xp, lost, mass, entropy, gained, decay, dt, unit, share)[0][0]
        energies.append(taken + totals(xp, brought, mass, gain, dt)[0][0])
    return energies


def heat_update(
    xp: Any, matter: Any, mass: Array, density: Array, entropy: Array, by_pairs: Sequence[Array | None],
    exchange: Exchange | None, dt: Array, least: Any,
) -> tuple[Array, list[Array]]:  # fmt: skip
    """A after dt (N,), or all alike, of matter whose energy is not linear in it, and what each effect brings of it.

    matter: the equation of state of these particles (N,); by_pairs: the heat per mass of each effect's pairs, (N,);
    least: what A is not to fall below, (N,) or a number.
    """
    heats = by_pairs
    if exchange is not None:
        more = _exchanged_heats(xp, matter, density, entropy, by_pairs, exchange, dt)
        heats = [added(q, other) for q, other in zip(by_pairs, more, strict=True)]
    total = reduce(added, heats, None)
    if total is None:
        return entropy, [xp.zeros(()) for _ in heats]
    after, missed = matter.heated(xp, density, entropy, total, least)
    size = reduce(added, [None if q is None else elementwise(xp, size_of, q)[0] for q in heats], None)
    return after, [xp.zeros(()) if q is None else totals(xp, delivered, mass, q, size, missed)[0][0] for q in heats]


def compression(problem: Any, eos: Any, mass: Array, entropy: Array, before: Array, after: Array) -> Array:
    """What each effect did to the internal energy as densities changed at fixed entropy, (E,): pressure alone does."""
    xp = problem.engine.xp
    new, old = (eos.energy(xp, density, entropy) for density in (after, before))
    gain = totals(xp, change, mass, new, old)[0][0]
    return xp.asarray([gain if name == "pressure" else xp.zeros(()) for name in problem.effect_names])


def _exchanged_heats(
    xp: Any, matter: Any, density: Array, entropy: Array, by_pairs: Sequence[Array | None], exchange: Exchange,
    dt: Array,
) -> list[Array | None]:  # fmt: skip
    # The heat per mass that each effect exchanges, as of matter whose A is its thermal energy.
    thermal, decay = matter.state(xp, density, entropy)[3], exchange.decay
    gained = added(reduce(added, by_pairs, None), dt * exchange.gain)
    heats = []
    for gain, share in zip(exchange.gains, exchange.decays, strict=True):
        taken = None if gain is None else elementwise(xp, lost, 1.0, thermal, gained, decay, dt, 1.0, share)[0]
        heats.append(None if gain is None else added(taken, dt * gain))
    return heats


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


def brought(xp, mass, gain, dt):
    """m g dt."""
    return (mass * gain * dt,)


def heated(xp, entropy, gain, length):
    """The entropy with length times the gain; at least half of what it was."""
    return (xp.maximum(entropy + length * gain, 0.5 * entropy),)


def size_of(xp, heat):
    """|q|."""
    return (xp.abs(heat),)


def delivered(xp, mass, heat, size, missed):
    """The energy of heat that is one of several of which u has so much more than all together."""
    return (mass * (heat + missed * xp.abs(heat) / xp.where(size > 0.0, size, 1.0)),)


def product(xp, a, b):
    """a b."""
    return (a * b,)


def change(xp, weight, new, old):
    """weight (new - old)."""
    return (weight * (new - old),)
