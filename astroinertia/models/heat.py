"""What heats and cools a fluid of particles: by pairs, by exchange with the surroundings, and by compression."""

from dataclasses import replace
from functools import reduce
from typing import Any

from astroinertia.engines.elementwise import added, elementwise, totals
from astroinertia.integrate.exchange import Exchange, exchange_of
from astroinertia.integrate.leapfrog import Rates
from astroinertia.sph.fluid import Fluid

Array = Any


def exchange_with_surroundings(problem: Any, fluid: Fluid, entropy_per_heat: Array) -> Exchange | None:
    """The heat that effects give and take by themselves; None where none does, or nothing can be warm."""
    if not problem.equation_of_state.thermal:
        return None
    return exchange_of([effect.exchange(problem.engine.xp, fluid) for effect in problem.effects], entropy_per_heat)


def total_heating(rates: Rates) -> Array | None:
    """du/dt of all effects by their pairs, (N,); None where nothing heats."""
    return reduce(added, rates.heating, None)


def with_heat(problem: Any, rates: Rates, entropy_per_heat: Array) -> Rates:
    """The rates with the exchange of heat, and what that and the heat of pairs do to the entropy function."""
    exchange = exchange_with_surroundings(problem, rates.fluid, entropy_per_heat)
    heat = added(total_heating(rates), None if exchange is None else exchange.gain)
    if heat is None:
        return rates
    entropy_rate = elementwise(problem.engine.xp, product, entropy_per_heat, heat)[0]
    return replace(rates, exchange=exchange, entropy_rate=entropy_rate)


def compression(problem: Any, eos: Any, mass: Array, entropy: Array, before: Array, after: Array) -> Array:
    """What each effect did to the internal energy as densities changed at fixed entropy, (E,): pressure alone does."""
    xp = problem.engine.xp
    new, old = (eos.energy(xp, density, entropy) for density in (after, before))
    gain = totals(xp, change, mass, new, old)[0][0]
    return xp.asarray([gain if name == "pressure" else xp.zeros(()) for name in problem.effect_names])


def product(xp, a, b):
    """a b."""
    return (a * b,)


def change(xp, weight, new, old):
    """weight (new - old)."""
    return (weight * (new - old),)
