"""The particle model of a scene: its physics and numerics, and its particles at time 0 or from a checkpoint."""

import importlib
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from astroinertia.build import companions, sinks
from astroinertia.build.combine import check_same_fluid, places, together
from astroinertia.build.effects import effects_of, refuse_without_heat
from astroinertia.build.fluids import equation_of_state, materials_of
from astroinertia.build.placing import Particles as Body, particles
from astroinertia.build.spheres import Sphere, Star, sphere
from astroinertia.engines import mpi
from astroinertia.engines.few import FEW
from astroinertia.errors import SceneError
from astroinertia.models import checkpoint
from astroinertia.models.sph.evolution import Particles
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.record import SHOWN
from astroinertia.models.sph.sorting import arranged
from astroinertia.models.sph.state import Problem, State, member_key
from astroinertia.scene.plan import smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph.kernels import KERNELS
from astroinertia.sph.standard_volumes import DENSITY_FACTOR
from astroinertia.sph.table import MAX_PARTICLES
from astroinertia.units import CodeUnits

_BEGINS = "mass", "position", "velocity", "entropy"
_STENCIL = 64  # particles of the throw-away state that shows a checkpoint's structure


def evolution(scene: Scene, units: CodeUnits) -> Particles:
    """The particles placed, at their temperature, turning: each body by itself, then all of them together."""
    bodies, fluids = [], []
    for alone, (position, velocity) in zip(scene.alone(), places(scene, units), strict=True):
        problem, initial = problem_of(alone, units)
        bodies.append(particles(alone, units, initial, problem).moved(position, velocity))
        fluids.append(problem.equation_of_state)
    check_same_fluid(fluids)
    body = together(bodies)
    problem, _ = problem_of(scene, units, len(body.mass))  # only now it is known how many there are in a table
    points, body = companions.beside(scene, units, problem, body)
    points |= sinks.beside(scene, units, problem, body.mass)
    return _begun(scene, units, problem, **vars(body), points=points)


def refuse_branch(run: Scene, branch: Scene) -> None:
    """SceneError where a run has what is beside its particles, or its branch would have."""
    for scene in (run, branch):
        for kind in ("companions", "sinks"):
            if kind in scene.effects:
                raise SceneError(
                    f"[effects.{kind}] has bodies beside the particles, which a branch does not take over: no run with "
                    "them has branches, and no branch has them."
                )


def branched(scene: Scene, units: CodeUnits, parent: Particles) -> Particles:
    """The particles of another run where they are, in this scene, with a ledger that begins there."""
    state = parent.state
    order = np.argsort(np.asarray(state.identity))
    begins = {name: np.asarray(getattr(state, name))[order] for name in _BEGINS}
    if state.material is not None:
        begins["material"] = np.asarray(state.material)[order]
    memory = {name: np.asarray(array)[order] for name, array in state.memory.items()}
    problem, _ = problem_of(scene, units, len(order))
    return _begun(scene, units, problem, **begins, time=parent.time, memory=memory)


def of_snapshot(scene: Scene, units: CodeUnits, arrays: Mapping[str, np.ndarray]) -> Particles:
    """The particles of a snapshot; of what effects have evolved for themselves, what is not in it begins again.

    ValueError, in a sentence, where the arrays are no snapshot of this scene's.
    """
    count = checkpoint.length(arrays, "mass")
    if not 0 < count <= MAX_PARTICLES:
        raise ValueError("it has no particles, or too many")
    problem, _ = problem_of(scene, units, count)
    several = materials_of(problem.equation_of_state)
    shapes = {"mass": (count,), "position": (count, 3), "velocity": (count, 3), "entropy": (count,), "time": ()}
    if recalled := [name for name in SHOWN if name in arrays]:
        shapes |= dict.fromkeys(("density", *recalled), (count,))
    kinds: dict[str, Any] = {name: (np.dtype(np.float64), shape) for name, shape in shapes.items()}
    if several > 1:
        kinds["material"] = (arrays["material"].dtype if "material" in arrays else np.dtype(int), (count,))
    limits = {"mass": checkpoint.POSITIVE, "time": checkpoint.SIZE, "material": (0, several - 1),
              "density": checkpoint.POSITIVE, **dict.fromkeys(SHOWN, (0.0, 1.0)),
              DENSITY_FACTOR: checkpoint.POSITIVE}  # fmt: skip
    checkpoint.check(arrays, kinds, limits)
    memory: dict[str, np.ndarray] = {}
    for effect in problem.effects:
        memory |= {name: np.asarray(array) for name, array in effect.recalled(np, arrays).items()}
    begins = {name: arrays[name] for name in (*_BEGINS, "material") if name in kinds}
    return _begun(scene, units, problem, **begins, time=float(arrays["time"]), memory=memory)


def _begun(scene: Scene, units: CodeUnits, problem: Problem, **begins: Any) -> Particles:
    """The particles of a state that begins so (models.sph.first_state), followed through the scene's regions."""
    state, arrangement = initial_state(problem, **begins)
    if scene.numerics.timesteps == "individual":
        from astroinertia.models.sph.block_step import refuse_unsaid_whole  # only here: global steps import none of it

        refuse_unsaid_whole(problem, state)
    regions = _regions(scene, units, problem)
    state = state if regions is None else regions.opened(state)
    return _under_way(scene, units, problem, state, arrangement, regions)


def resumed(scene: Scene, units: CodeUnits, arrays: Mapping[str, np.ndarray]) -> Particles:
    """The particles of a checkpoint; ValueError, in a sentence, where its arrays are none of this scene's."""
    count = checkpoint.length(arrays, ".mass")
    if not 0 < count <= MAX_PARTICLES or not (arrays[".mass"] > 0.0).all() or not np.isfinite(arrays[".mass"]).all():
        raise ValueError("its particles have no masses, or are too many")
    problem, _ = problem_of(scene, units, sinks.at_first(arrays, count))
    random = np.random.default_rng(0).normal(size=(2, _STENCIL, 3))
    mass = np.full(_STENCIL, math.fsum(arrays[".mass"]) / _STENCIL)
    stencil = Body(mass, random[0], random[1], np.ones(_STENCIL), None)
    points, _ = companions.beside(scene, units, problem, stencil)
    # Without its box: particles that only show a structure have no place in it.
    bare = replace(problem, engine=getattr(problem.engine, "inner", problem.engine))
    points |= sinks.none(scene, problem, arrays[".mass"])
    several = materials_of(problem.equation_of_state) > 1
    like, _ = initial_state(
        bare, stencil.mass, stencil.position, stencil.velocity, stencil.entropy, points=points,
        material=np.zeros(_STENCIL) if several else None,
    )  # fmt: skip
    regions = _regions(scene, units, problem)
    if regions is not None:
        like = regions.with_room(like)
    _check(arrays, like, scene, problem, _end(scene, units))
    state = checkpoint.unflattened(like, arrays, problem.engine.xp)
    pairs = problem.engine.arrange(state.position, state.smoothing_length)[1]
    return _under_way(scene, units, problem, state, arranged(problem, pairs, state), regions)


def _under_way(
    scene: Scene, units: CodeUnits, problem: Problem, state: State, arrangement: Any, regions: Any
) -> Particles:
    base_step, between = base_step_of(scene), sinks.between(problem)
    return Particles(
        problem, state, arrangement, _end(scene, units), base_step, regions, between, scene.numerics.free_fall_factor
    )


def _check(arrays: Mapping[str, np.ndarray], like: State, scene: Scene, problem: Problem, end: float) -> None:
    """ValueError where the arrays are not those of a state of this scene, which has the structure of `like`."""
    count, stored, expected = len(arrays[".mass"]), checkpoint.described(checkpoint.flattened(like)), {}
    sunk = checkpoint.length(arrays, sinks.STORED.format("mass")) if sinks.STORED.format("mass") in stored else 0
    for name, (dtype, shape) in stored.items():
        rows = {0: sunk} if ".points['sinks']" in name else {} if ".points[" in name else {_STENCIL: count}
        expected[name] = (dtype, (*(rows.get(length, length) for length in shape[:1]), *shape[1:]))
    limits = {
        ".time": (0.0, end * (1.0 + checkpoint.LATE)),
        ".step": checkpoint.COUNT,
        ".identity": checkpoint.COUNT,
        ".smoothing_length": checkpoint.POSITIVE,
        ".material": (0, materials_of(problem.equation_of_state) - 1),
        ".rates.timestep": checkpoint.POSITIVE,
        **dict.fromkeys(
            (f".rates.fluid.{name}" for name in ("mass", "density", "smoothing_length")), checkpoint.POSITIVE
        ),
        **sinks.limits(problem.effects, sunk, count),
        **{f".memory['{member_key(name)}']": (0.0, 1.0) for name in scene.regions},
        f".memory['{DENSITY_FACTOR}']": checkpoint.POSITIVE,
        ".points['companions'].mass": checkpoint.SIZE,
    }
    checkpoint.check(arrays, expected, limits)
    if len(np.unique(arrays[".identity"])) != count:
        raise ValueError("two of its particles have the same identity")


def problem_of(scene: Scene, units: CodeUnits, count: int | None = None) -> tuple[Problem, Sphere | Star | None]:
    """The physics and numerics that a scene calls for, and the sphere or star that its (first) body is at first.

    count: the number of particles, where the scene's body does not tell.
    """
    numerics, initial = scene.numerics, sphere(scene, units)
    longest = _end(scene, units) if numerics.max_timestep is None else units.to_code(numerics.max_timestep, "time")
    effects = effects_of(scene, units, scene.particles or count)
    matter = equation_of_state(scene, units, initial)
    if not matter.thermal:
        refuse_without_heat(scene, effects)
    if getattr(matter, "standards", None) is not None:
        effects = tuple(_of_volumes(effect) for effect in effects)
    problem = Problem(
        effects=effects,
        equation_of_state=matter,
        eta=smoothing(scene)[0],
        courant=numerics.courant,
        acceleration_factor=numerics.acceleration_factor,
        energy_factor=numerics.energy_factor,
        max_timestep=longest,
        engine=_in_box(scene, units, engine_of(numerics.engine, scene.precision, numerics.kernel)),
        kernel=numerics.kernel,
        smoothing_tolerance=numerics.smoothing_tolerance,
    )
    return problem, initial


def _of_volumes(effect: Any) -> Any:
    try:
        return effect.of_volumes
    except ValueError as error:
        raise SceneError(f"[effects.{effect.kind}] {error}") from None


def engine_of(name: str, precision: str, kernel: str) -> Any:
    """The engine of that name, importing no other; the one that lists neighbours is given the reach of the kernel."""
    module = importlib.import_module(f"astroinertia.engines.{name}")
    if name == "numba_cpu":
        return module.Engine(precision=precision, together=mpi.together())
    if mpi.communicator() is not None:
        raise SceneError(f"processes of MPI share out the engine numba_cpu; for {name} run with --coordinator auto.")
    return module.Engine(precision=precision, support=KERNELS[kernel].support)


def _in_box(scene: Scene, units: CodeUnits, engine: Any) -> Any:
    # Without a box nothing is imported of images.
    if scene.box is None:
        return engine
    box, support = scene.box, KERNELS[scene.numerics.kernel].support
    lengths = units.to_code(np.array(box.lengths), "length")
    module = importlib.import_module("astroinertia.engines.periodic")
    if scene.particles is not None and scene.particles <= FEW:
        engine = replace(engine, images=module.IMAGES_OF_FEW)
    return module.Engine(engine, tuple(np.where(box.repeats, lengths, np.inf).tolist()), support)


def base_step_of(scene: Scene) -> Any:
    """What carries particles with time steps of their own through a base step; None with global ones."""
    # Global steps import nothing of individual ones.
    if scene.numerics.timesteps == "global":
        return None
    return importlib.import_module("astroinertia.models.sph.block_step").step


def _regions(scene: Scene, units: CodeUnits, problem: Problem) -> Any:
    # Scenes without regions import nothing of them.
    if not scene.regions:
        return None
    module = importlib.import_module("astroinertia.models.sph.regions")
    made = []
    for name, region in scene.regions.items():
        options = region.model_dump()
        for key, dimension in (("innermost_mass", "mass"), ("density_above", "density")):
            if options[key] is not None:
                options[key] = units.to_code(options[key], dimension)
        made.append(module.Region(name, **options))
    return module.Regions(problem, tuple(made))


def _end(scene: Scene, units: CodeUnits) -> float:
    return units.to_code(scene.time.end, "time")
