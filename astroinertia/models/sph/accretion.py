"""Sinks at work: between steps, collapsing matter becomes a sink, sinks accrete what falls into them, and they merge.

The tests of matter are those of Bate, Bonnell & Price (1995, MNRAS 277, 362, section 2.2), that of two sinks is that
of Bleuler & Teyssier (2014, MNRAS 445, 4015). Mass, momentum and angular momentum go from the fluid to the
sinks, their spins included, to round-off; energy that is not found elsewhere afterwards is that within the sinks.
Checked by tests/physics/test_sinks.py.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from astroinertia.engines.pytree import mapped
from astroinertia.errors import NumericalError
from astroinertia.inertia.spin import angular_velocity
from astroinertia.inertia.tensor import inertia_from_second_moment
from astroinertia.ledger.moments import after_heating, after_removal, removed, whole
from astroinertia.models.sph.evaluate import evaluated
from astroinertia.models.sph.evolution import FEWEST, enough
from astroinertia.models.sph.limits import total_acceleration
from astroinertia.models.sph.points import with_others, without_others
from astroinertia.models.sph.record import energy_budget
from astroinertia.models.sph.sinks import Sinks, merged
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem, State, member_key
from astroinertia.sph.kernels import KERNELS

Array = Any
INNER = 0.1  # of the radius: what is this near is accreted, whatever its orbit (Bate et al. 1995: 0.01 to 0.1)
ROWS = 256  # of particles whose distances to all others are held at a time
POINT = "mass", "position", "velocity", "spin"  # of a sink, in the order of sinks.merged


def step(problem: Problem, arrangement: Any, state: State) -> tuple[State, Any]:
    """The state after one round of accretion, with rates of what is left of the fluid, and its arrangement."""
    effect: Any = next(effect for effect in problem.effects if effect.kind == "sinks")
    sinks = state.points["sinks"]
    groups = _accreted(state, sinks, effect)
    new = _new_sink(problem, state, sinks, effect)
    if not enough(problem, np.delete(state.mass, _taken(groups, new))):
        groups, new = _all_but_a_few(problem, state, sinks, groups, new)
    taken = _taken(groups, new)
    grown = _grown(state, sinks, groups)
    if new is not None:
        point = merged(state.mass[new], state.position[new], state.velocity[new], np.zeros((1, 3)))
        grown = _with(grown, point, int(effect.number), float(state.time))
    if effect.merging == "bound":
        grown = united(grown, float(effect.radius))
    if not len(taken) and len(grown.mass) == len(sinks.mass):
        return state, arrangement
    before = energy_budget(problem, state)["total"]
    state, lost = _without(problem, state, taken)
    state = replace(state, points={**state.points, "sinks": replace(grown, removed=sinks.removed + lost)})
    state, arrangement = rearranged(problem, state, np.float64(0.0))
    state = _evaluated(problem, arrangement, state)
    heat = before - energy_budget(problem, state)["total"]
    grown = state.points["sinks"]
    return replace(state, points={**state.points, "sinks": replace(grown, inner_energy=grown.inner_energy + heat)}), (
        arrangement
    )


def bound_to(sinks: Sinks, radius: float, position: Array, velocity: Array) -> Array:
    """The sink that accretes each particle, (N,); -1 where none does.

    Within the radius, a particle must be bound to the sink, most of all to this one, with less angular momentum than a
    circular orbit at the radius has.
    """
    best, least = np.full(len(position), -1), np.full(len(position), np.inf)
    for k, (mass, place, speed) in enumerate(zip(sinks.mass, sinks.position, sinks.velocity, strict=True)):
        x, v = position - place, velocity - speed
        distance = np.sqrt((x**2).sum(axis=1))
        energy = 0.5 * (v**2).sum(axis=1) - mass / np.maximum(np.sqrt(distance**2 + sinks.softening**2), 1e-300)
        turning = (np.cross(x, v) ** 2).sum(axis=1)
        falls = (distance < radius) & (energy < 0.0) & (turning < mass * radius)
        chosen = (falls | (distance < INNER * radius)) & (energy < least)
        best[chosen], least[chosen] = k, energy[chosen]
    return best


def united(sinks: Sinks, radius: float) -> Sinks:
    """Sinks of which two within the radius of each other that are bound have become the older one; the closest first.

    Bound: w^2/2 < (M + M')/(d^2 + 2 s^2)^(1/2) at a relative velocity w.
    """
    x, v = (vector[:, None] - vector for vector in (sinks.position, sinks.velocity))
    squared, mass = (x**2).sum(axis=-1), sinks.mass[:, None] + sinks.mass
    depth = mass / np.sqrt(np.maximum(squared + 2.0 * sinks.softening**2, 1e-300))
    meets = np.triu((squared < radius**2) & (0.5 * (v**2).sum(axis=-1) < depth), 1)
    if not meets.any():
        return sinks
    pair = np.array(np.unravel_index(np.where(meets, squared, np.inf).argmin(), meets.shape))
    older, younger = pair
    fields = {name: getattr(sinks, name).copy() for name in POINT}
    point = merged(*(array[pair] for array in fields.values()))
    for name, value in zip(POINT, point, strict=True):
        fields[name][older] = value
    left = {name: np.delete(array, younger, axis=0) for name, array in fields.items()}
    return united(replace(sinks, **left, identity=np.delete(sinks.identity, younger)), radius)


def collapses(mass: Array, position: Array, velocity: Array, acceleration: Array, heat: Array) -> bool:
    """Whether particles around the densest, the first of them, are bound, converge and are drawn together.

    heat: of each particle, 3/2 P/rho. With energies of heat T, rotation R, all motion K and gravity W of the particles
    alone, T <= |W|/2, T + R <= |W| and T + K < |W|.
    """
    from_first = position - position[0]
    converging = mass @ ((velocity - velocity[0]) * from_first).sum(axis=1) < 0.0
    drawn = mass @ ((acceleration - acceleration[0]) * from_first).sum(axis=1) < 0.0
    if not (converging and drawn):
        return False
    whole_mass = mass.sum()
    x, v = position - mass @ position / whole_mass, velocity - mass @ velocity / whole_mass
    gravity = binding_energy(mass, position)
    spin = (mass[:, None] * np.cross(x, v)).sum(axis=0)
    inertia = inertia_from_second_moment((mass[:, None] * x).T @ x)
    rotation = 0.5 * float(spin @ angular_velocity(inertia, spin))
    thermal, motion = mass @ heat, 0.5 * mass @ (v**2).sum(axis=1)
    return bool(thermal <= 0.5 * gravity and thermal + rotation <= gravity and thermal + motion < gravity)


def binding_energy(mass: Array, position: Array) -> float:
    """The sum of m m'/d over all pairs of particles (n,), (n, 3), without those in one place."""
    total = 0.0
    for start in range(0, len(mass), ROWS):
        distance = cdist(position[start : start + ROWS], position)
        distance[distance == 0.0] = np.inf
        total += 0.5 * float(mass[start : start + ROWS] @ ((1.0 / distance) @ mass))
    return total


def peaks(density: Array, position: Array, radius: float) -> Iterator[int]:
    """Which particles (N,), (N, 3) are the densest of all within the radius around them, the densest first."""
    order = np.argsort(-density, kind="stable")
    tree, left = KDTree(position[order]), np.ones(len(order), bool)
    for rank, particle in enumerate(order):
        if left[rank]:
            near = np.array(tree.query_ball_point(position[particle], radius))
            left[near] = False  # this one is denser
            if near.min() == rank:
                yield int(particle)


def _accreted(state: State, sinks: Sinks, effect: Any) -> dict[int, Array]:
    """{sink: particles that it accretes now}."""
    best = bound_to(sinks, float(effect.radius), state.position, state.velocity)
    return {k: np.flatnonzero(best == k) for k in range(len(sinks.mass)) if (best == k).any()}


def _taken(groups: dict[int, Array], new: Array | None) -> Array:
    return np.concatenate([np.zeros(0, int), *groups.values(), *([] if new is None else [new])])


def _all_but_a_few(
    problem: Problem, state: State, sinks: Sinks, groups: dict[int, Array], new: Array | None
) -> tuple[dict[int, Array], Array | None]:
    """The same without those that are farthest away, so that just enough particles stay."""
    distance = np.full(len(state.mass), np.inf)
    for k, chosen in groups.items():
        distance[chosen] = np.linalg.norm(state.position[chosen] - sinks.position[k], axis=1)
    if new is not None:
        distance[new] = np.linalg.norm(state.position[new] - state.position[new[0]], axis=1)
    farthest = np.argsort(distance, kind="stable")[::-1]
    number = next((n for n in range(FEWEST, len(farthest)) if enough(problem, state.mass[farthest[:n]])), len(farthest))
    stays = np.zeros(len(distance), bool)
    stays[farthest[:number]] = True
    left = {k: chosen[~stays[chosen]] for k, chosen in groups.items() if not stays[chosen].all()}
    new = None if new is None or stays[new].all() else new[~stays[new]]
    return left, new


def _new_sink(problem: Problem, state: State, sinks: Sinks, effect: Any) -> Array | None:
    """The particles that become a sink: those within the radius of a peak of density, the densest that collapses."""
    if effect.density is None:
        return None
    fluid = state.rates.fluid
    dense = np.flatnonzero(fluid.density > effect.density)
    if not len(dense):
        return None
    acceleration = total_acceleration(np, state.rates, state.velocity)
    heat = 1.5 * fluid.pressure / fluid.density
    for number in peaks(fluid.density[dense], state.position[dense], float(effect.radius)):
        peak = dense[number]
        if KERNELS[problem.kernel].support * state.smoothing_length[peak] > effect.radius:
            continue  # its neighbours would not all be within
        if (((sinks.position - state.position[peak]) ** 2).sum(axis=1) < (2.0 * effect.radius) ** 2).any():
            continue
        distance = np.sqrt(((state.position - state.position[peak]) ** 2).sum(axis=1))
        inside = np.flatnonzero(distance < effect.radius)
        inside = np.concatenate([[peak], inside[inside != peak]])
        chosen = (array[inside] for array in (state.mass, state.position, state.velocity, acceleration, heat))
        if collapses(*chosen):
            return inside
    return None


def _grown(state: State, sinks: Sinks, groups: dict[int, Array]) -> Sinks:
    """Sinks with what they accrete."""
    fields = {name: getattr(sinks, name).copy() for name in POINT}
    for k, chosen in groups.items():
        mass, place, speed = (
            np.concatenate([fields[name][k : k + 1], getattr(state, name)[chosen]])
            for name in ("mass", "position", "velocity")
        )
        point = merged(mass, place, speed, fields["spin"][k : k + 1])
        for name, value in zip(fields, point, strict=True):
            fields[name][k] = value
    return replace(sinks, **fields)


def _with(sinks: Sinks, point: tuple[Array, ...], most: int, time: float) -> Sinks:
    """One sink more."""
    if sinks.formed >= most:
        raise NumericalError(
            f"there are more than {most} sinks: raise [effects.sinks] number", effect="sinks", time=time
        )
    fields = {name: np.append(getattr(sinks, name), [value], axis=0) for name, value in zip(POINT, point, strict=True)}
    return replace(sinks, **fields, identity=np.append(sinks.identity, sinks.formed), formed=sinks.formed + 1)


def _without(problem: Problem, state: State, taken: Array) -> tuple[State, Any]:
    """The fluid without particles, its ledger with what it lost, and that."""
    count = len(state.mass)
    mass, position, velocity = state.mass[taken], state.position[taken], state.velocity[taken]
    lost = removed(whole(np, state.mass, state.position, state.velocity), mass, position, velocity)
    work = -0.5 * float(mass @ (velocity**2).sum(axis=1))
    heating = 0.0
    if "pressure" in problem.effect_names:
        eos = problem.matter(None if state.material is None else state.material[taken])
        density = state.rates.fluid.density[taken]
        heating = -float(mass @ eos.internal_energy(np, density, state.entropy[taken]))
    ledger = after_removal(state.ledger, lost, problem.effect_names.index("sinks"), work, heating)
    stays = np.ones(count, bool)
    stays[taken] = False
    regions = {}
    for name, region in state.regions.items():
        member = state.memory[member_key(name)]
        regions[name] = region.exchanged(state.mass, state.position, state.velocity, member, member * stays)
    particles, others = without_others(replace(state, regions=regions))

    def kept(array: Array) -> Array:
        return array[stays] if getattr(array, "ndim", 0) and array.shape[0] == count else array

    return replace(with_others(mapped(kept, particles), others), ledger=ledger), lost


def _evaluated(problem: Problem, arrangement: Any, state: State) -> State:
    """Densities and rates of what is left; what the densities' change does to the heat is the sinks' doing."""
    before = state.ledger.heating.total
    state = evaluated(problem, arrangement, state, np.float64(0.0))
    if "pressure" not in problem.effect_names:
        return state
    gain = (state.ledger.heating.total - before)[problem.effect_names.index("pressure")]
    moved = [gain * ((name == "sinks") - (name == "pressure")) for name in problem.effect_names]
    return replace(state, ledger=after_heating(state.ledger, np.array(moved)))
