"""Factors of the densities of particles near the surface of a planet, where sums over neighbours fall short."""

from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.matter import planetary
from astroinertia.matter.interior import isentrope
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.state import Problem
from astroinertia.sph.kernels import KERNELS


def density_factors(
    problem: Problem, planet: Any, mass: np.ndarray, position: np.ndarray, layer: np.ndarray
) -> np.ndarray:
    """The density that the planet has where particles (N,), (N, 3) of its layers are put, over their sums, (N,).

    It is 1 for particles whose kernels do not reach out of the planet: what sums are short of there is noise.
    """
    entropy, material = planet.labels[layer], planet.numbers[layer]
    alone = replace(problem, effects=tuple(effect for effect in problem.effects if effect.kind == "pressure"))
    state, _ = initial_state(alone, mass, position, np.zeros_like(position), entropy, material=material)
    placed = np.argsort(np.asarray(state.identity))
    fluid = state.rates.fluid
    density, length = (np.asarray(array)[placed] for array in (fluid.density, fluid.smoothing_length))
    distance = np.minimum(np.linalg.norm(position, axis=1), planet.radius)
    pressure = np.asarray(planet.solution.layered().pressure(distance))
    exact = np.empty_like(density)
    for number, (kind, label) in enumerate(zip(planet.numbers, planet.labels, strict=True)):
        chosen = layer == number
        matter = isentrope(problem.equation_of_state, int(kind), float(label))
        # At all pressures, so that one program serves all layers.
        exact[chosen] = np.asarray(planetary.density(matter, pressure))[chosen]
    reaches_out = distance + KERNELS[problem.kernel].support * length > planet.radius
    return np.where(reaches_out, exact / density, 1.0)
