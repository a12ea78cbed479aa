"""Processor time of runs on the machine that the package's own figures are of: the same numbers on every machine.

What is chosen by them is the same everywhere.
"""

from contextlib import suppress

from astroinertia.costs.evaluations import EVENLY_DONE, Counts, run_of_steps
from astroinertia.costs.machine import shipped
from astroinertia.costs.prediction import AGAIN, counted, placing, predict, record, written_records
from astroinertia.process.stopwatch import total
from astroinertia.scene.schema import Scene

EVENLY = Counts(1.0, 1.0, 1.0, "nothing", EVENLY_DONE)


def estimated(scene: Scene) -> Counts:
    """How steps of particles follow from each other; all alike where nothing is known of the flow."""
    with suppress(ArithmeticError, ValueError):
        return counted(scene) or EVENLY
    return EVENLY


def of_particles(scene: Scene, evaluations: float, counts: Counts, placed: bool = False, alone: bool = False) -> float:
    """Processor seconds of a run of particles that takes so many evaluations of one, all programs compiled.

    counts: of the same flow, for what steps are made up of; placed: its bodies are placed and settled already; alone:
    in a process of its own, whose start is part of it.
    """
    machine, particles = shipped(), scene.particles or 1
    share = evaluations / (particles * counts.evaluations)
    parts = [share * cost for cost in run_of_steps(scene, particles, counts, machine).values()]
    parts.append(written_records(scene, share * counts.steps) * record(scene, particles, machine))
    if not placed:
        parts += placing(scene, particles, machine).values()
    start = machine.seconds["start"]
    return total([*parts, start + machine.seconds["prepare.sph"] if alone else AGAIN * start]).processor


def without_particles(scene: Scene, runs: int) -> float:
    """Processor seconds of so many runs without particles in a process that runs, and of what they compile."""
    prediction = predict(scene, shipped())
    assert prediction is not None  # only particles may be of unknown number
    return (prediction.compiling + runs * prediction.again).processor
