"""From a validated scene to a problem in code units: the one place where all parts are put together."""

import importlib
import platform
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from astroinertia import start
from astroinertia.archive import Archive
from astroinertia.effects import catalogue
from astroinertia.errors import SceneError
from astroinertia.integrate.leapfrog import State
from astroinertia.models.checkpoint import unflattened
from astroinertia.models.sph import Problem, initial_state
from astroinertia.scene import load
from astroinertia.scene.plan import cadence, code_units, plan, smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph.kernels import KERNELS, Kernel
from astroinertia.units import CodeUnits, Dimension

_STENCIL = 64  # particles of the throw-away state that shows a checkpoint's structure


@dataclass(frozen=True)
class Outputs:
    """When a run records what, in code units; None is never."""

    end: float
    max_steps: float
    series_every: float | None
    series_steps: int | None
    snapshot_every: float
    align: bool
    checkpoint_seconds: float


@dataclass(frozen=True)
class Prepared:
    """A run about to start or go on: the physics, the state, its arrangement, and where the outputs stand."""

    problem: Problem
    state: State
    arrangement: Any
    outputs: Outputs
    units: CodeUnits
    counters: dict[str, Any]


def prepare(scene: Scene) -> Prepared:
    """The scene at time 0."""
    units = code_units(scene)
    problem, ball = problem_of(scene, units)
    body = start.particles(scene, units, ball, problem)
    state, arrangement = initial_state(
        problem, body.mass, body.position, body.velocity, body.entropy, body.internal_energy
    )
    counters = {"series": 0, "snapshot": 0, "wall_time": 0.0, "opening_potential": None, "opening_energy": 0.0}
    return Prepared(problem, state, arrangement, outputs_of(scene, units), units, counters)


def restore(archive: Archive) -> Prepared:
    """A run at its last checkpoint."""
    told = archive.metadata
    scene = load.loads(told["scene"], origin=told["origin"])
    units = code_units(scene)
    problem, _ = problem_of(scene, units)
    stored = archive.read_checkpoint()
    if stored is None:
        return prepare(scene)
    random = np.random.default_rng(0).normal(size=(2, _STENCIL, 3))
    like, _ = initial_state(problem, np.ones(_STENCIL), random[0], random[1], np.ones(_STENCIL))
    state = unflattened(like, stored[0], problem.engine.xp)
    arrangement = problem.engine.arrange(state.position, state.smoothing_length)[1]
    return Prepared(problem, state, arrangement, outputs_of(scene, units), units, stored[1])


def problem_of(scene: Scene, units: CodeUnits) -> tuple[Problem, start.Sphere | start.Star | None]:
    """The physics and numerics that a scene calls for, and the sphere or star that its body is at first."""
    numerics, ball = scene.numerics, start.sphere(scene, units)
    longest = (
        outputs_of(scene, units).end if numerics.max_timestep is None else units.to_code(numerics.max_timestep, "time")
    )
    problem = Problem(
        effects=effects_of(scene, units),
        equation_of_state=start.equation_of_state(scene, units, ball),
        eta=smoothing(scene)[0],
        courant=numerics.courant,
        acceleration_factor=numerics.acceleration_factor,
        energy_factor=numerics.energy_factor,
        max_timestep=longest,
        engine=engine_of(numerics.engine, numerics.precision, KERNELS[numerics.kernel]),
        kernel=numerics.kernel,
        smoothing_tolerance=numerics.smoothing_tolerance,
    )
    return problem, ball


def engine_of(name: str, precision: str, kernel: Kernel) -> Any:
    """The engine of that name, importing no other; the one that lists neighbours is told how far the kernel reaches."""
    module = importlib.import_module(f"astroinertia.engines.{name}")
    if name == "xla":
        return module.Engine(precision=precision, support=kernel.support)
    return module.Engine(precision=precision)


def effects_of(scene: Scene, units: CodeUnits) -> tuple[Any, ...]:
    """The effects that a scene lists, in the catalogue's order, with options in code units."""
    built = []
    for kind, entry in catalogue.CATALOGUE.items():
        if kind in scene.effects:
            options = {
                name: _to_code(value, entry.options[name].dimension, units)
                for name, value in scene.effects[kind].items()
            }
            try:
                built.append(catalogue.build(kind, options))
            except ValueError as error:
                raise SceneError(f"[effects.{kind}] {error}") from None
    return tuple(built)


def outputs_of(scene: Scene, units: CodeUnits) -> Outputs:
    """When to record, in code units."""
    when = cadence(scene)
    return Outputs(
        end=units.to_code(scene.time.end, "time"),
        max_steps=scene.time.max_steps or float("inf"),
        series_every=None if when.series_every is None else units.to_code(when.series_every, "time"),
        series_steps=when.series_steps,
        snapshot_every=units.to_code(when.snapshot_every, "time"),
        align=scene.output.align,
        checkpoint_seconds=scene.output.checkpoint_seconds,
    )


def metadata(scene: Scene) -> dict[str, Any]:
    """What a run's file says of where it came from: enough to repeat it."""
    units = code_units(scene)
    ball = start.sphere(scene, units)
    return {
        "name": scene.name,
        "description": scene.description,
        "scene": load.resolved_text(scene),
        "plan": plan(scene).text(),
        "origin": scene.origin,
        "overrides": list(scene.overrides),
        "dimensionless": scene.dimensionless,
        "code_units": {"mass": units.mass, "length": units.length, "G": units.gravitational_constant},
        "reference_radius": None if ball is None else ball.radius,
        "reference_radius_convention": (ball or start.Sphere).radius_convention,
        "model": scene.model,
        "engine": scene.numerics.engine,
        "precision": scene.numerics.precision,
        "kernel": scene.numerics.kernel,
        "seed": scene.body.seed,
        "effects": [kind for kind in catalogue.CATALOGUE if kind in scene.effects],
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in ("numpy", "numba", "jax", "xarray", "netCDF4", "astropy")},
        },
    }


def _to_code(value: Any, dimension: str, units: CodeUnits) -> Any:
    if value is None or isinstance(value, str) or dimension == "choice":
        return value
    scale = units.unit(Dimension(*catalogue.DIMENSIONS[dimension]))
    if isinstance(value, int | float):
        return value / scale
    return (np.asarray(value, dtype=float) / scale).tolist()
