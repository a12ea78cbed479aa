"""Whether the acceleration of each effect is that of its potential energy, measured on a body under way."""

from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.models.sph.evaluate import evaluated, internal_energy, potential_energies
from astroinertia.models.sph.sorting import rearranged

SMALL = 1e-4  # smoothing lengths that particles are displaced by
TOLERANCE = 1e-12  # of smoothing lengths: what a scene leaves in them jumps, and these are differences


def slopes(problem: Any, state: Any) -> dict[str, float]:
    """{effect: how far dE along displacements d of all particles is from -sum m a.d, over sum |m a||d|}.

    Energies of pressure are those at fixed entropies. Central differences, so the error falls as SMALL squared.
    """
    problem = replace(problem, smoothing_tolerance=TOLERANCE)
    random = np.random.default_rng(3).normal(size=state.position.shape)
    here = _evaluated(problem, state)
    moved = random * here.smoothing_length[:, None]
    after, before = (
        _energies(problem, _evaluated(problem, replace(here, position=here.position + sign * SMALL * moved)))
        for sign in (1.0, -1.0)
    )
    found = {}
    for kind, acceleration in zip(problem.effect_names, here.rates.acceleration, strict=True):
        if kind not in after or acceleration is None or not np.any(acceleration):
            continue
        force = here.mass[:, None] * acceleration
        scale = (np.linalg.norm(force, axis=1) * np.linalg.norm(moved, axis=1)).sum()
        found[kind] = float(((after[kind] - before[kind]) / (2.0 * SMALL) + (force * moved).sum()) / scale)
    return found


def _evaluated(problem: Any, state: Any) -> Any:
    """The state with forces at its own places and entropies: within a step these are ahead of each other."""
    still = replace(state, rates=replace(state.rates, timestep=np.float64(0.0)))
    moved, arrangement = rearranged(problem, still)
    return evaluated(problem, arrangement, moved, np.float64(0.0))


def _energies(problem: Any, state: Any) -> dict[str, float]:
    found = {kind: float(energy) for kind, energy in potential_energies(problem, state).items()}
    if "pressure" in problem.effect_names:
        found["pressure"] = float(internal_energy(problem, state))
    return found
