"""What a first run of particles compiles, and whether two processes do it (run.beside).

Imports no engine. Tests: tests/unit/costs/test_costs.py, tests/unit/run/test_beside.py.
"""

import os
from collections.abc import Mapping

from astroinertia.costs import experience
from astroinertia.costs.evaluations import near
from astroinertia.process.cores import cores
from astroinertia.process.stopwatch import Seconds
from astroinertia.scene.schema import Scene

# Of what more particles compile (36 s in sims/pulsar_collapse), what few do, for densities and for each effect between
# neighbours: 2.4 s for pressure alone, 4.5 s with gravity and viscosity; and what steps of their own need further. So
# is what JAX compiles to solve for a planet of layers, in every process (tests/benchmarks/results/first_runs.md).
COMPILED_BY_FEW, COMPILED_BY_INDIVIDUAL, COMPILED_FOR_PLANETS = 0.033, 0.04, 0.2
# Particles up to which a body is prepared twice in less time than half of the programs take to compile.
PREPARED_TWICE = 30_000
# Of what one process takes to compile: what two take by the clock, and of processor time, with the start of the other.
BY_TWO = 0.6, 1.15


def compiling(scene: Scene, costs: Mapping[str, Seconds]) -> Seconds:
    """Of what a run of the scene compiles: what has not been compiled before."""
    alone = experience.left_to_compile(scene) * _share(scene) * costs["compile.sph"]
    return Seconds(BY_TWO[0] * alone.wall, BY_TWO[1] * alone.processor) if by_two_processes(scene) else alone


def by_two_processes(scene: Scene) -> bool:
    """Whether a scene of particles has enough programs for few enough particles, and there are cores for two.

    The second process knows nothing that a scene was given from Python.
    """
    particles = scene.model == "sph" and scene.numerics.engine == "numba_cpu" and scene.particles is not None
    some = particles and not experience.few(scene) and scene.particles <= PREPARED_TWICE  # type: ignore[operator]
    return some and not scene.own_classes and _cores() > 1


def _cores() -> int:
    """Cores that a run computes on: those that its process may use, or as many as $NUMBA_NUM_THREADS says."""
    chosen = os.environ.get("NUMBA_NUM_THREADS", "")
    return min(cores(), int(chosen)) if chosen.isdecimal() else cores()


def _share(scene: Scene) -> float:
    """The share that a scene compiles of what more particles compile."""
    if not experience.few(scene):
        return 1.0
    further = COMPILED_BY_INDIVIDUAL if scene.numerics.timesteps == "individual" else 0.0
    return COMPILED_BY_FEW * (1 + sum(near(scene, kind) for kind in scene.effects)) + further
