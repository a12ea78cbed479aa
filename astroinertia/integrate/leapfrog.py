"""Kick-drift-kick with the ledger beside it.

Half kick, drift, forces, half kick: second order, symplectic for a fixed step, one force evaluation a step (Hernquist
& Katz 1989, ApJS 70, 419; Springel 2005, MNRAS 364, 1105). A force linear in the velocity enters through its matrix M_e
by the implicit midpoint rule, so that a Coriolis force does no work; other velocity-dependent effects see the velocity
predicted for the end of the step, which makes them time-centred.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from astroinertia.engines.elementwise import elementwise, totals
from astroinertia.engines.pytree import pytree
from astroinertia.integrate.exchange import Exchange, energies, entropy_after
from astroinertia.integrate.heat_update import heat_update
from astroinertia.ledger.moments import Ledger, after_drift, after_heating, after_kick, after_rounding
from astroinertia.ledger.regions import RegionLedger
from astroinertia.sph.fluid import Fluid

Array = Any


@pytree
@dataclass(frozen=True)
class Rates:
    """What changes a state, one entry an effect in each tuple (None where it has no such part).

    acceleration (N, 3), drag (3, 3) acting on the velocity, heating (N,) du/dt; entropy_rate (N,) is the sum of the
    heating and of the gains of `exchange`, in terms of the entropy function; timestep is the longest step allowed from
    here; total is the sum of the accelerations, (N, 3); exchange, that of heat with the surroundings, if there is any.
    """

    acceleration: tuple[Array | None, ...]
    drag: tuple[Array | None, ...]
    heating: tuple[Array | None, ...]
    entropy_rate: Array
    timestep: Array
    fluid: Fluid
    total: Array | None = None
    exchange: Exchange | None = None


@pytree
@dataclass(frozen=True)
class State:
    """Everything that a run carries from step to step, in code units; rates belong to the present positions.

    points: {effect: point masses beside the fluid}, which move with it.
    regions: the ledger of each region of the body, whose members memory holds under member_key(name), (N,).
    material (N,) numbers what particles are of, in an equation of state of several materials; None with any other.
    remainder (N, 3) is what rounding has left of the places: the sum with `position` is where particles are, to twice
    the digits. Only drifts know of it. A place that is rounded at each step alone errs the same way each time while
    its velocity stays the same, and the angular momentum with the square of the time.
    """

    time: Array
    step: Array
    identity: Array
    mass: Array
    position: Array
    remainder: Array
    velocity: Array
    entropy: Array
    smoothing_length: Array
    memory: dict[str, Array]
    ledger: Ledger
    rates: Rates
    points: dict[str, Any] = field(default_factory=dict)
    regions: dict[str, RegionLedger] = field(default_factory=dict)
    material: Array | None = None


def member_key(name: str) -> str:
    """The name in a state's memory of which particles a region holds: 1 for members, 0 for the others."""
    return f"region.{name}"


Forces = Callable[[State, Array], State]


def step(xp: Any, state: State, dt: Array, forces: Forces, matter: Any = None) -> State:
    """One step of length dt; `forces` gives a state its rates at its new positions.

    matter: the equation of state of its particles, where their energy is not linear in the entropy function.
    """
    state = kick(xp, state, dt / 2, matter)
    state = drift(xp, state, dt)
    state = forces(state, dt)
    state = kick(xp, state, dt / 2, matter)
    return replace(state, step=state.step + 1)


def carried(xp, x, remainder, v, dt):
    """x + remainder + dt v of one component, rounded, and what rounding leaves of it (Knuth's two-sum)."""
    way = dt * v + remainder
    place = x + way
    part = place - x
    return place, (x - (place - part)) + (way - part)


def moved(xp, x, remainder, v, dt):
    """The place dt later, and what rounding leaves of it."""
    x_0, left_0 = carried(xp, x[0], remainder[0], v[0], dt)
    x_1, left_1 = carried(xp, x[1], remainder[1], v[1], dt)
    x_2, left_2 = carried(xp, x[2], remainder[2], v[2], dt)
    return (x_0, x_1, x_2), (left_0, left_1, left_2)


def changed(xp, v, a, length, entropy, entropy_rate, dt):
    """v + length a, and the entropy dt later."""
    return (v[0] + length * a[0], v[1] + length * a[1], v[2] + length * a[2]), entropy + dt * entropy_rate


def power(xp, mass, heating):
    """m du/dt."""
    return (mass * heating,)


def drift(xp: Any, state: State, dt: Array) -> State:
    """Free motion over dt."""
    mass, velocity = state.mass, state.velocity
    position, remainder = elementwise(xp, moved, state.position, state.remainder, velocity, dt)
    ways = state.position, position, velocity, dt
    return replace(
        state,
        time=state.time + dt,
        position=position,
        remainder=remainder,
        ledger=after_rounding(xp, after_drift(xp, state.ledger, dt), mass, *ways),
        points={kind: each.drifted(dt, state.time + dt) for kind, each in state.points.items()},
        regions={
            name: region.drifted(xp, dt).rounded(xp, mass * state.memory[member_key(name)], *ways)
            for name, region in state.regions.items()
        },
    )


def kick(xp: Any, state: State, dt: Array, matter: Any = None) -> State:
    """Change velocities and entropies by the present rates over dt, at fixed positions; matter as for a step."""
    rates, mass, before = state.rates, state.mass, state.velocity
    after, entropy = predicted(xp, state, dt)
    increments, length = rates.acceleration, dt
    if any(matrix is not None for matrix in rates.drag):
        increments, length = velocity_increments(xp, rates, before, dt), 1.0
    ledger = after_kick(xp, state.ledger, mass, state.position, before, after, increments, length)
    if matter is None:
        heat = [xp.zeros(()) if q is None else dt * totals(xp, power, mass, q)[0][0] for q in rates.heating]
        gained = dt * rates.entropy_rate
        for k, energy in enumerate(energies(xp, rates.exchange, mass, state.entropy, gained, dt)):
            heat[k] = heat[k] + energy
    else:
        given = [None if q is None else dt * q for q in rates.heating]
        density = rates.fluid.density
        entropy, heat = heat_update(xp, matter, mass, density, state.entropy, given, rates.exchange, dt, -xp.inf)
    points = {kind: each.kicked(dt) for kind, each in state.points.items()}
    regions = {
        name: region.kicked(
            xp, mass * state.memory[member_key(name)], state.position, before, after, increments, length
        )
        for name, region in state.regions.items()
    }
    ledger = after_heating(ledger, xp.asarray(heat))
    return replace(state, velocity=after, entropy=entropy, ledger=ledger, points=points, regions=regions)


def predicted(xp: Any, state: State, dt: Array) -> tuple[Array, Array]:
    """Velocities (N, 3) and entropies (N,) dt later, from the last rates.

    A kick makes them so, but for the entropies of matter whose energy is not linear in them, which here are right to
    first order; velocity-dependent effects are evaluated with those in the middle of a step.
    """
    rates = state.rates
    total, length = rates.total, dt
    if any(matrix is not None for matrix in rates.drag):
        increments = velocity_increments(xp, rates, state.velocity, dt)
        total, length = sum(increments[1:], start=increments[0]), 1.0
    velocity, entropy = elementwise(xp, changed, state.velocity, total, length, state.entropy, rates.entropy_rate, dt)
    if rates.exchange is not None:
        entropy = entropy_after(xp, rates.exchange, state.entropy, dt * rates.entropy_rate, dt)
    return velocity, entropy


def velocity_increments(xp: Any, rates: Rates, velocity: Array, dt: Array) -> list[Array]:
    """dv_e = dt a_e + dt M_e (v + v')/2 of each effect, (N, 3), with v' = v + sum_e dv_e solved for exactly."""
    free = [xp.zeros_like(velocity) if a is None else dt * a for a in rates.acceleration]
    matrices = [matrix for matrix in rates.drag if matrix is not None]
    if not matrices:
        return free
    half = 0.5 * dt * sum(matrices[1:], start=matrices[0])
    known = velocity @ (xp.eye(3) + half).T + sum(free[1:], start=free[0])
    middle = 0.5 * (velocity + known @ xp.linalg.inv(xp.eye(3) - half).T)
    return [part if m is None else part + dt * middle @ m.T for part, m in zip(free, rates.drag, strict=True)]
