"""Evrard's cloud under way, with everything that a scene leaves to the defaults at its default."""

from typing import Any

import numpy as np
from point_sets import PointSet

from astroinertia.build.assemble import prepare
from astroinertia.effects.kinds.gravity import SOFTENING
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS, Particles
from astroinertia.scene import load

GAS = """\
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[effects.viscosity]
"""
SCENE = f"""
name = "evrard"
units = "code"
[body]
kind = "power_law"
exponent = 1.0
mass = 1.0
radius = 1.0
relax = false
specific_internal_energy = 0.05
{GAS}[time]
end = 3.0
"""


def cloud(particles: int, precision: str, *settings: str, placement: str = "random") -> Particles:
    """The cloud at time 0: so many particles, pair sums in that precision, more settings as `--set` takes them."""
    given = [f"body.particles={particles}", f'body.placement="{placement}"', f'numerics.precision="{precision}"']
    return prepare(load.loads(SCENE, [*given, *settings])).evolution


def between_sorts(particles: Particles) -> None:
    """As many steps as lie between two sorts, one sort among them."""
    for _ in range(STEPS_BETWEEN_SORTS):
        particles.advance(particles.end)


def gravity(particles: Particles) -> tuple[PointSet, np.ndarray]:
    """The particles as they are, and what gravity's own sums are in the next step's setting, (N, 3)."""
    state, problem = particles.state, particles.problem
    points = PointSet(state.mass, state.position, state.smoothing_length)
    arrangement, fluid = particles.arrangement, state.rates.fluid
    effect = next(each for each in problem.effects if each.kind == "gravity")
    fields = {"mass": state.mass, "position": state.position, "smoothing_length": state.smoothing_length}
    near = [term for term in effect.neighbour_terms if term is not SOFTENING]
    sums: list[Any] = [problem.engine.neighbour_sums(arrangement.pairs, problem.kernel, tuple(near), fields)]
    sums.append(problem.engine.all_pair_sums(arrangement.pairs, problem.kernel, effect.all_pair_terms, fields))
    own = arrangement.own.get("gravity")
    sums.append(
        {"gravity": effect.own_sums(problem.engine, arrangement.pairs, own, fluid, fluid.sums["gravity"], False)}
    )
    found = [each["gravity"]["acceleration"] for each in sums if each.get("gravity")]
    return points, np.sum(found, axis=0)
