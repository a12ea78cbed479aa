"""What a run will take before it is run: wall time with its parts, steps, memory and the size of its files.

Tests: tests/unit/costs/test_costs.py; measured against runs in tests/benchmarks/results/predictions.md.
"""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from astroinertia.build.companions import AT_FIRST
from astroinertia.costs import course, experience, piloted, processes, smooth
from astroinertia.costs.compiling import COMPILED_FOR_PLANETS, compiling
from astroinertia.costs.evaluations import EVENLY_DONE, Counts, evaluation, run_of_steps, settling_steps
from astroinertia.costs.machine import Machine
from astroinertia.process.stopwatch import Seconds, total
from astroinertia.scene.body_kinds.layered import LayeredPlanet
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.plan import cadence, records
from astroinertia.scene.schema import Scene

NUMBER = 8  # bytes
ARRAYS_OF_A_SNAPSHOT = 12  # numbers a particle
ARRAYS_OF_A_STATE = 55  # numbers a particle of a checkpoint, and for each effect
ARRAYS_OF_AN_EFFECT = 10
NUMBERS_OF_A_RECORD = {"sph": 220}  # and OF_AN_EFFECT for each
NUMBERS_WITHOUT_PARTICLES = 75
OF_AN_EFFECT = 30
IN_THE_FINAL_FILE = {"sph": 1.2}  # bytes of a record there, with what follows from it, over those it is saved with
SMOOTH = 0.6  # the same without particles: smooth series are compressed well
CHECKPOINTS = 2  # that a folder keeps (storage.archive)
COMPRESSED = 0.75  # a snapshot in the final file
PREPARATION = ("start-up", "compiling", "orbits of companions", "placing", "solving for planets", "settling")
# Of the start of a process: what one run more in it takes to begin and to finish its file (0.12 to 0.19 s of 2.7 to
# 3.4, of companion runs of Dyson's ellipsoid in particles and of a top, and of pilots of tops).
AGAIN = 0.05
INDIVIDUAL = 1.8  # times as much memory a particle: what a base step begins with is kept, for it may be given up
HEADER = 3.5e5  # bytes of the final file without any record, and of the manifest


@dataclass(frozen=True)
class Prediction:
    """What a run takes.

    parts: {what: Seconds} of which the run time is the sum; steps: how many, and `steps_by` what says so; done: share
    of their work by time, as of Counts; memory: the most bytes of the process; files: bytes of the run's folder;
    for_outputs: evaluations of particles, over those that they would take if steps met no times of outputs; received:
    bytes that each of several processes gets from the others in an evaluation of all particles; first: as of Counts.
    """

    parts: dict[str, Seconds]
    steps: float
    steps_by: str
    done: tuple[float, ...]
    memory: float
    files: float
    calibrated: bool
    for_outputs: float = 1.0
    received: float = 0.0
    first: Mapping[str, float] = field(default_factory=dict)

    @property
    def time(self) -> Seconds:
        """Of the whole run."""
        return total(self.parts.values())

    @property
    def evolution(self) -> Seconds:
        """Of what comes after the preparation: steps, records and writing."""
        return total(cost for name, cost in self.parts.items() if name not in PREPARATION)

    @property
    def again(self) -> Seconds:
        """Of a run in a process that has carried out another one, but for what it is the first to compile."""
        taken = total(cost for name, cost in self.parts.items() if name not in ("start-up", "compiling"))
        return taken + AGAIN * self.parts["start-up"]

    @property
    def compiling(self) -> Seconds:
        """Of what is compiled for it."""
        return self.parts.get("compiling", Seconds())

    @property
    def wall_time(self) -> float:
        """Of the whole run, in seconds, on a machine that does nothing else."""
        return self.time.wall


def predict(scene: Scene, machine: Machine, by: int = 1) -> Prediction | None:
    """What a scene will take on a machine; None where its number of particles or of steps is not known beforehand.

    by: how many processes share out the sums over particles, each on such a machine; memory is of one of them.
    Nor is anything known of a body at the edge of what numbers hold, which is still to be run. Imports neither an
    engine nor an effect. A pilot that was run before (costs.pilot) says the steps of particles; without one they are
    estimated.
    """
    with suppress(ArithmeticError, ValueError), np.errstate(over="raise", divide="raise", invalid="raise"):
        return _predicted(scene, machine, by)
    return None


def _predicted(scene: Scene, machine: Machine, by: int) -> Prediction | None:
    if scene.model != "sph":
        return _without_particles(scene, machine)
    if scene.particles is None or scene.numerics.engine != "numba_cpu":
        return None  # only a table knows how many there are
    particles = round(scene.body.placed(scene, scene.particles))  # which lattices round
    share = processes.share(particles, by)
    machine = processes.shared_out(machine, by) if share else machine
    own = counted(scene)
    if own is None:
        return None
    met = own.meeting(_times_to_meet(scene)) if scene.output.align else own
    counts = met.at_most(scene.time.max_steps or math.inf)
    costs = machine.seconds
    parts = {"start-up": costs["start"] + costs["prepare.sph"]}
    if experience.left_to_compile(scene) > 0.0:
        parts["compiling"] = compiling(scene, costs)
    parts |= _orbits(scene, machine)
    if any(isinstance(alone.body, LayeredPlanet) for alone in scene.alone()):
        parts["solving for planets"] = COMPILED_FOR_PLANETS * costs["compile.sph"]
    if not experience.placed(scene):
        parts |= placing(scene, particles, machine)
    steps = run_of_steps(scene, particles, counts, machine)
    written, one = written_records(scene, counts.steps), record(scene, particles, machine)
    size = files(scene, written, particles, counts.steps)
    parts |= {f"steps: {name}": cost for name, cost in steps.items()}
    if share:
        parts["steps: sending"] = counts.evaluations * processes.sending(particles, by)
    parts |= {"records": written * one, "writing": _writing(scene, size, total(parts.values()).wall, machine)}
    held = machine.memory[f"particle.{scene.precision}"]
    held *= INDIVIDUAL if scene.numerics.timesteps == "individual" else 1.0
    shortened, got = met.evaluations / own.evaluations, processes.received(particles, by) if share else 0.0
    return Prediction(
        parts, counts.steps, counts.by, counts.done, machine.memory["sph"] + particles * held, size, machine.calibrated,
        shortened, got, counts.first,
    )  # fmt: skip


def counted(scene: Scene) -> Counts | None:
    """How many steps particles take to the end, if they meet no time but that; None where that is not known.

    By a pilot where one was run, or else estimated.
    """
    assert scene.particles is not None
    pilot = piloted.kept(scene)
    return course.counted(scene) if pilot is None else pilot.counts(scene.particles)


def _times_to_meet(scene: Scene) -> float:
    """How many times of records and snapshots steps are shortened to meet; those that are the same count once."""
    when, end = cadence(scene), scene.time.end
    every = [when.snapshot_every] if when.series_every is None else [when.series_every, when.snapshot_every]
    shortest, longest = min(every), max(every)
    ratio = longest / shortest
    times = records(end, shortest) - 1.0
    return times if abs(ratio - round(ratio)) < 1e-9 * ratio else times + records(end, longest) - 1.0


def _without_particles(scene: Scene, machine: Machine) -> Prediction:
    costs, kind = machine.seconds, smooth.kind(scene)
    written = records(scene.time.end, cadence(scene).series_every or scene.time.end)
    parts = {"start-up": costs["start"]}
    steps = 0.0
    if kind != "scaling":
        parts["compiling"] = total(costs[name] for name in smooth.compiled(scene))
        whole = smooth.steps(scene, written)
        steps = min(whole, scene.time.max_steps or math.inf)
        written *= steps / whole
        parts |= _orbits(scene, machine, steps / whole)
        parts["steps"] = steps * smooth.of_step(scene) * costs[f"step.{kind}"]
    size = files(scene, written, 0, steps)
    parts |= {"records": written * costs[f"record.{kind}"]}
    parts |= {"writing": _writing(scene, size, total(parts.values()).wall, machine)}
    return Prediction(parts, steps, "an estimate", EVENLY_DONE, machine.memory[kind], size, machine.calibrated)


def _orbits(scene: Scene, machine: Machine, share: float = 1.0) -> dict[str, Seconds]:
    taken = tabulating(scene, machine, share)
    return {"orbits of companions": taken} if taken.wall > 0.0 else {}


def placing(scene: Scene, particles: int, machine: Machine) -> dict[str, Seconds]:
    """What it takes to place bodies, and to settle those that are, by parts."""
    parts = {}
    bodies: Any = [alone.body for alone in scene.alone()]
    if any(body.placement == "glass" and body.laid_out for body in bodies):
        parts["placing"] = particles * machine.seconds["place.particle"]
    settling = [alone for alone in scene.alone() if alone.settles]
    if settling:
        parts["settling"] = total(_settling(alone, machine) for alone in settling)
    return parts


def _settling(scene: Scene, machine: Machine) -> Seconds:
    # Bodies settle under gravity and pressure alone.
    effects = {kind: scene.effects[kind] for kind in ("gravity", "pressure")}
    body: Any = scene.body
    still = scene.model_copy(update={"effects": effects})
    return settling_steps(body.particles) * total(evaluation(still, body.particles, machine).values())


def record(scene: Scene, particles: int, machine: Machine) -> Seconds:
    """What a record of so many particles takes."""
    costs, once = machine.seconds, evaluation(scene, particles, machine)
    again = total(cost for name, cost in once.items() if name in scene.effects)  # once more, for the virials
    return costs["record"] + particles * costs["record.particle"] + again


def written_records(scene: Scene, steps: float) -> float:
    """How many records a run of particles leaves: no more than it takes steps."""
    when = cadence(scene)
    if when.series_every is None:
        return 1.0 + steps / (when.series_steps or 1)
    return min(float(records(scene.time.end, when.series_every)), steps + 1.0)


def files(scene: Scene, written: float, particles: int, steps: float) -> float:
    """Bytes of a run's folder: records and snapshots as they are saved and in the final file, and two checkpoints."""
    effects = len(scene.effects)
    numbers = NUMBERS_OF_A_RECORD.get(scene.model, NUMBERS_WITHOUT_PARTICLES) + OF_AN_EFFECT * effects
    series = written * NUMBER * numbers * (1.0 + IN_THE_FINAL_FILE.get(scene.model, SMOOTH))
    snapshots = 0.0
    if particles:
        count = records(scene.time.end, cadence(scene).snapshot_every)
        snapshots = min(count, steps + 1.0) * particles * NUMBER * ARRAYS_OF_A_SNAPSHOT
    state = particles * NUMBER * (ARRAYS_OF_A_STATE + ARRAYS_OF_AN_EFFECT * effects)
    return HEADER + series + snapshots * (1.0 + COMPRESSED) + CHECKPOINTS * state


def _writing(scene: Scene, size: float, before: float, machine: Machine) -> Seconds:
    pauses = 2.0 + before / max(scene.output.checkpoint_seconds, 1.0)
    return pauses * machine.seconds["write"] + size * machine.seconds["write.byte"]


# Of a turn on a circle, 0.53 ms: what eccentricity adds (0.8, 1.2, 1.9 and 3.5 ms of eccentricities 0.05, 0.2, 0.5 and
# 0.9), what each further companion does (1.4 ms of two, 2.7 ms of five), and what a turn takes with WHFast.
ECCENTRIC, FURTHER, WHFAST = 5.5, 0.85, 2.0


def tabulating(scene: Scene, machine: Machine, share: float = 1.0) -> Seconds:
    """The time that it takes for a run of which steps leave so large a share; none where it is not known beforehand."""
    others = (characteristic(scene).neighbours or ()) if _on_known_orbits(scene) else ()
    bound = [other for other in others if other.eccentricity < 1.0]  # what passes by needs next to none
    if not bound:
        return Seconds()
    radians = scene.time.end * max(other.rate for other in bound)
    bends = scene.time.end * max(other.rate * (1.0 + ECCENTRIC * other.eccentricity) for other in bound)
    turns = (bends + FURTHER * (len(bound) - 1) * radians) / (2.0 * math.pi)
    if scene.model == "rigid" and share < 1.0 and share * radians < AT_FIRST:
        turns *= min(1.0, AT_FIRST / radians)
    return (WHFAST if scene.orbits.integrator == "whfast" else 1.0) * turns * machine.seconds["orbit"]


def _on_known_orbits(scene: Scene) -> bool:
    """Whether companions keep to orbits that are known beforehand."""
    if scene.model == "rigid":
        return not scene.orbits.back_reaction
    return scene.effects.get("companions", {}).get("motion") == "orbit"
