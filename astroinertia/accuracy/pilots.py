"""Pilot runs of a search: each setting of a scene is run once, kept in a folder, and reported.

What they cost is counted in evaluations of a particle, or stages of steps of a body without particles: the same on
every machine, so that the same pilots are run there. Tests: tests/unit/accuracy/test_choice.py.
"""

import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from astroinertia.accuracy import measuring
from astroinertia.accuracy.estimates import Estimate, estimate, worst
from astroinertia.accuracy.knobs import Setting, Value
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.selected_observables import SelectedObservable, relative_error
from astroinertia.costs import experience, machine
from astroinertia.costs.prediction import predict
from astroinertia.errors import SceneError
from astroinertia.process.words import duration
from astroinertia.scene.plan import cadence, records
from astroinertia.scene.schema import Scene

Listener = Callable[[str], None]


@dataclass
class Pilots:
    """Runs of a scene at settings, none of them twice.

    So far: spent, seconds of wall time; work, evaluations, and `predicted`, what was predicted of each before;
    processor, seconds of the reference machine (costs.reference), of particles and of models tried beside them.
    """

    scene: Scene
    observables: tuple[SelectedObservable, ...]
    folder: Path
    listener: Listener
    spent: float = 0.0
    work: float = 0.0
    predicted: float = 0.0
    processor: float = 0.0
    done: dict[tuple[str, ...], Measured] = field(default_factory=dict)

    def run(self, label: str, overrides: Sequence[str], work: float = 0.0, stages: float = 1.0) -> Measured:
        """What the scene gives with these overrides; a setting that fails, or that the scene refuses, says so.

        work: that it is predicted to take; stages: of what is counted as an evaluation.
        """
        key = tuple(overrides)
        if key not in self.done:
            begin = clock.monotonic()
            measured = self.done[key] = self._judged(self._measured(Setting("pilot", label, key)))
            self.spent += clock.monotonic() - begin
            taken = work if measured.failure else stages * measured.evaluations
            self.work, self.predicted = self.work + taken, self.predicted + work
        return self.done[key]

    @property
    def met(self) -> int:
        """Times of records that steps of the run are to meet, each of which takes one at least."""
        scene = self.scene
        every = cadence(scene).series_every
        if every is None or (scene.model == "sph" and not scene.output.align):
            return 0
        return records(scene.time.end, every) - 1

    def _judged(self, measured: Measured) -> Measured:
        """A run, which fails where an observable is 0: no error is relative to that."""
        nothing = (name for name, values in measured.values.items() if not np.any(values))
        if (name := next(nothing, None)) is None:
            return measured
        sentence = f"'{name}' is 0, to which no error is relative; judged_by may name something else"
        return measuring.failed(sentence, self.observables)

    def _measured(self, setting: Setting) -> Measured:
        try:
            scene = measuring.scene_of(self.scene, setting, self.observables)
        except SceneError as error:
            return measuring.failed(str(error), self.observables)
        seconds, compiling = seconds_of(scene)
        first = scene.model == "sph" or not any(run.steps for run in self.done.values())
        compiled = f", and {duration(compiling)} to compile" if compiling > 0.0 and first else ""
        self.listener(f"{setting.value}, about {duration(seconds)}{compiled}" if seconds > 0.0 else str(setting.value))
        place = measuring.folder_of(self.folder, scene, setting)
        stored = measuring.stored(place, self.observables)
        if stored is not None and (stored.failure or stored.evaluations):
            return stored
        measured = measuring.measure(scene, self.observables, place, rehearsed=False)
        if not measured.failure:
            experience.note(scene)
        return measured

    def apart(self, one: Measured, other: Measured) -> float:
        """The largest relative difference of any observable; infinite where one of them failed."""
        if one.failure or other.failure:
            return float("inf")
        return max(
            relative_error(np.array(one.values[o.name]), np.array(other.values[o.name])) for o in self.observables
        )

    def estimate(
        self, ladder: Mapping[float, Measured], order: float, orders: tuple[float, float], trust: float = math.inf
    ) -> Estimate:
        """The error at the finest of some runs, by their steps: of the least certain observable."""
        return worst([*self.estimates(ladder, order, orders, trust).values()])

    def estimates(
        self, ladder: Mapping[float, Measured], order: float, orders: tuple[float, float], trust: float = math.inf
    ) -> dict[str, Estimate]:
        """The same of every observable, by its name."""
        runs = {step: run for step, run in ladder.items() if not run.failure}
        values = {one.name: np.array([run.values[one.name] for run in runs.values()]) for one in self.observables}
        return {name: estimate(list(runs), each, order, orders, trust) for name, each in values.items()}

    def limit(self, ladder: Mapping[float, Measured], order: float) -> Measured:
        """What some runs, by their steps, tend to: the two finest by Richardson's rule."""
        (fine, one), (coarse, other) = sorted((step, run) for step, run in ladder.items() if not run.failure)[:2]
        weight = 1.0 / ((coarse / fine) ** order - 1.0)
        values = {
            name: (np.array(one.values[name]) + weight * (np.array(one.values[name]) - other.values[name])).tolist()
            for name in one.values
        }
        return replace(one, values=values)


def seconds_of(scene: Scene) -> tuple[float, float]:
    """Wall time of a pilot in a process that runs, and that of compiling, which only its first takes; 0 if unknown."""
    prediction = predict(scene, machine.current())
    if prediction is None:
        return 0.0, 0.0
    return prediction.again.wall, prediction.compiling.wall


@dataclass(frozen=True)
class Settings:
    """A setting that a search settled for.

    chosen: {knob: value}; errors: {source: relative error that is expected}; seconds: of wall time that its steps and
    preparation are expected to take; reasons: a sentence each; work: that the run is expected to take, as of pilots;
    processor: seconds of the reference machine for a run of particles with its start, 0 without particles.
    """

    overrides: tuple[str, ...]
    chosen: Mapping[str, Value]
    errors: Mapping[str, float]
    seconds: float
    reasons: tuple[str, ...]
    work: float = 0.0
    processor: float = 0.0

    @property
    def error(self) -> float:
        """The sum of all sources."""
        return sum(self.errors.values())

    @property
    def bar(self) -> float:
        """The error that is stated: twice what is expected, for that is as often too small as too large."""
        return 2.0 * self.error


@dataclass(frozen=True)
class OutOfReach:
    """What an accuracy would take that the time allowed does not have; the best that it has."""

    sentence: str
