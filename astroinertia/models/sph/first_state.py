"""The first state of particles: their smoothing lengths, entropies and rates at time 0, or where a branch begins."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.effects.effect import acting
from astroinertia.engines.pytree import mapped
from astroinertia.errors import NumericalError
from astroinertia.ledger.moments import open_ledger
from astroinertia.models.sph.evaluate import densities, evaluated
from astroinertia.models.sph.points import opened
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem, Rates, State
from astroinertia.sph.density import refuse_unsolved, refuse_without_length
from astroinertia.sph.standard_volumes import DENSITY_FACTOR

_BEYOND = 1e-3  # of an energy, by which particles of single precision may miss it

Array = Any


def initial_state(
    problem: Problem,
    mass: Array,
    position: Array,
    velocity: Array,
    entropy: Array | None = None,
    internal_energy: Array | None = None,
    points: dict[str, Any] | None = None,
    material: Array | None = None,
    time: float = 0.0,
    memory: Mapping[str, Array] | None = None,
) -> tuple[State, Any]:
    """The state at a time with its rates, and the arrangement of its particles (N,), (N, 3), (N, 3), (N,).

    Entropies are given, or follow from specific internal energies and the densities found. points: those beside it.
    material: (N,), where the equation of state has several. memory: of particles that are on their way, what effects
    have evolved for themselves, (N,); what these effects do not have is left out, and what there is not, begins.
    NumericalError where some particle cannot have a smoothing length, or the energy that it is given.
    """
    xp = problem.engine.xp
    mass, position, velocity = np.asarray(mass), np.asarray(position), np.asarray(velocity)
    count = mass.shape[0]
    spread = float(((position - position.mean(axis=0)) ** 2).sum(axis=1).mean()) ** 0.5
    if problem.fixed_length is None:
        refuse_without_length(problem.kernel, problem.eta, mass, spread)
    guess = np.full(count, problem.eta * 2.0 * spread / count ** (1 / 3))
    nothing = (None,) * len(problem.effects)
    state = State(
        time=np.asarray(time, dtype=float),
        step=np.zeros((), dtype=int),
        identity=np.arange(count),
        mass=mass,
        position=position,
        remainder=np.zeros_like(position),
        velocity=velocity,
        entropy=np.asarray(internal_energy if entropy is None else entropy),
        smoothing_length=guess,
        memory={name: np.asarray(array) for name, array in (memory or {}).items()},
        ledger=open_ledger(np, mass, position, velocity, len(problem.effects)),
        rates=Rates(nothing, nothing, nothing, np.zeros(count), np.zeros(()), None),  # type: ignore[arg-type]
        points=opened(np, problem.effects, points),
        material=None if material is None else np.asarray(material, dtype=int),
    )
    state = mapped(xp.asarray, state)
    for _ in range(2):  # the first lengths are a guess; particles are sorted again by the solved ones
        state, arrangement = rearranged(problem, state)
        solved = densities(problem, arrangement.pairs, state)
        state = replace(state, smoothing_length=solved.smoothing_length)
    acts = problem.terms("neighbour_terms") or problem.terms("all_pair_terms")
    if acts and problem.fixed_length is None:  # else no density is solved for
        counted = np.asarray(state.mass * state.memory.get(DENSITY_FACTOR, 1.0))
        refuse_unsolved(problem.eta, counted, solved, np.asarray(state.identity))
    if entropy is None:
        fluid = problem.matter(state.material)
        entropy = fluid.entropy(xp, solved.density, state.entropy)
        _refuse_beyond(xp, fluid, solved.density, state.entropy, entropy)
        state = replace(state, entropy=entropy)
    return evaluated(acting(problem, time), arrangement, state, xp.zeros(())), arrangement


def _refuse_beyond(xp: Any, fluid: Any, density: Array, energy: Array, entropy: Array) -> None:
    """NumericalError where matter that is hotter than the coldest has no such energy: where tables are left too far."""
    if not fluid.thermal:
        return
    coldest, has = (np.asarray(fluid.energy(xp, density, A)) for A in (xp.zeros_like(entropy), entropy))
    wanted = np.asarray(energy)
    beyond = (wanted > coldest) & ~(np.abs(has - wanted) <= _BEYOND * np.maximum(np.abs(coldest), np.abs(wanted)))
    if beyond.any():
        where = int(np.flatnonzero(beyond)[0])
        raise NumericalError(
            f"{beyond.sum()} particles cannot have the specific energy that they are given: at the density "
            f"{float(density[where]):.3g} and the specific energy {wanted[where]:.3g} (code units) their equation of "
            "state or its table has come to its end"
        )
