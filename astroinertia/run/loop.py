"""Carries a scene from its first state to its last: steps, outputs, checkpoints, interruption and resumption."""

import math
import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from astroinertia import dataset
from astroinertia.build.assemble import (
    Prepared,
    metadata,
    model_description,
    note_versions,
    prepare,
    refuse_contradictions,
    restore,
    scene_of,
)
from astroinertia.build.structure import as_begun
from astroinertia.costs import experience, machine
from astroinertia.costs.prediction import predict
from astroinertia.dataset.schema import code_units
from astroinertia.effects.failures import failures_said, raise_failure
from astroinertia.engines import hosts
from astroinertia.engines.double import in_double
from astroinertia.engines.mesh import shared_out
from astroinertia.errors import NumericalError, RunInterrupted, SceneError
from astroinertia.models.protocol import SAME_TIME, Figures, GivenUp, GivesUp, RunsOut, Through
from astroinertia.observables.own import recorded
from astroinertia.process import interrupts
from astroinertia.process.interrupts import LIMIT
from astroinertia.run.beside import compiled_beside
from astroinertia.run.callback import STOPPED, Callback
from astroinertia.run.extend import go_on_with
from astroinertia.run.remaining import Pace
from astroinertia.run.state import RunState
from astroinertia.scene.changed import going_on
from astroinertia.scene.schema import Scene
from astroinertia.storage.archive import Archive, final_name, refuse_if_taken
from astroinertia.storage.outputs import Unwritten
from astroinertia.units import DIMENSIONLESS, CodeUnits, si_unit

if TYPE_CHECKING:
    from astroinertia.run.profile import Profile

OUTPUTS_AT_ONCE = 256  # that a model is asked for in one call, if it can do so
CAUSES = (None, LIMIT, STOPPED, interrupts.CTRL_C, *(number.name for number in interrupts.SIGNALS[1:]))
MARGIN = 1.5  # steps and saves take their time unevenly: so much of what the last ones took is left for the next


@dataclass(frozen=True)
class Progress:
    """What a run tells while it goes: time and end in code units, wall_time and to_go in seconds of it.

    density_max: in density_unit, which is empty where the scene is in code units.
    energy_error: change of the total energy over the largest of the kinetic, internal and potential energies; NaN, like
    the two after it, where a model has no such thing. limited_by: what sets the time step, and where; may be empty.
    to_go: seconds of wall time that are left, as predicted and as seen so far; NaN while nothing is known. part: which
    of several runs this is, empty where there is one. planned_steps: of the whole run, where it has taken so many times
    more by now that its plan has proved wrong; NaN else.
    """

    time: float
    end: float
    step: int
    wall_time: float
    energy_error: float
    ledger_closure: float
    density_max: float
    limited_by: str = ""
    to_go: float = math.nan
    part: str = ""
    planned_steps: float = math.nan
    density_unit: str = ""


TELLING = 0.05  # share of a run's time that goes into saying how far it is, at most, as long as the pauses allow it
PAUSES = (0.2, 5.0)  # seconds of silence between two times that it is said: at least, and at most whatever that costs
HELD = 1 << 26  # bytes of snapshots that wait in memory for the next checkpoint
OFF_PLAN = 10.0  # times the steps that were planned for the whole run, from which on a run says so
Listener = Callable[[Progress], None]
"""What hears how a run goes; if it raises RunInterrupted, the run is saved and stops, as after a signal."""
Completion = Callable[[xr.Dataset], xr.Dataset]
"""What adds to a run's dataset before its file is written; where it was interrupted, a resumed run calls it again."""


@contextmanager
def computing(devices: int = 1) -> Iterator[None]:
    """Within it JAX computes in 64 bits, on so many devices, and what functions of a user's own did wrong is said."""
    with in_double(), shared_out(devices), failures_said():
        yield


def run_scene(
    scene: Scene,
    folder: Path,
    listener: Listener | None = None,
    begun: float | None = None,
    completed: Completion | None = None,
    deadline: float = math.inf,
    callback: Callback | None = None,
    profile: "Profile | None" = None,
) -> Path:
    """Run a scene in a new run folder and return the netCDF file that it leaves.

    begun: of time.monotonic(), from when on the run's time is counted; from now on without it. The scene's error bars
    are added by `completed`: accuracy.companion_runs. deadline: of time.monotonic(), too, by which the run is saved
    and stopped if it has not ended. callback: what is called with the state as the run goes. profile: what times the
    parts of the run, for its file. Raises SceneError, ArchiveError (the folder holds another run), NumericalError, and
    RunInterrupted after a signal, for the deadline or by the callback, with everything saved so that `resume` goes on;
    and what the callback raises, likewise.
    """
    begun = clock.monotonic() if begun is None else begun
    refuse_before(scene, folder)
    timed = profile.preparing if profile else _untimed
    described = timed(lambda: metadata(scene) | predicted(scene))
    with computing(scene.numerics.devices), compiled_beside(scene):
        # Prepared before the folder is made: a scene that cannot be built leaves nothing behind.
        prepared = timed(lambda: prepare(scene))
        described["structure"] = as_begun(described["structure"], prepared.evolution)
        finished = run_prepared(described, prepared, folder, listener, begun, completed, deadline, callback, profile)
    if hosts.is_first():
        experience.note(scene)
    return finished


def _untimed(action: Callable[[], Any]) -> Any:
    return action()


def refuse_before(scene: Scene, folder: Path) -> None:
    """Refuse what would fail later: ArchiveError for a folder that holds another run, SceneError as for the scene."""
    hosts.first_then_others(lambda: refuse_if_taken(folder, {"name": scene.name}), lambda: None)
    refuse_contradictions(scene)


def run_prepared(
    described: Mapping[str, Any], prepared: Prepared, folder: Path, listener: Listener | None, begun: float,
    completed: Completion | None = None, deadline: float = math.inf, callback: Callback | None = None,
    profile: "Profile | None" = None,
) -> Path:  # fmt: skip
    """The same for a scene at time 0 that is prepared and described (build.assemble.metadata); under jax.enable_x64."""
    description = {**described, **model_description(prepared.evolution)}
    with hosts.first_then_others(
        lambda: Archive.create(folder, description), lambda: Unwritten(folder, description)
    ) as archive:
        if profile:
            profile.attend(prepared, type(archive))
        return _Run(prepared, archive, listener, begun, deadline, callback, profile).finish(completed)


def predicted(scene: Scene) -> dict[str, Any]:
    """What the run is expected to take, for its file: seconds, those of them after its preparation, bytes, steps.

    And the share of its work that is done after equal parts of its time (costs.evaluations.SHARES).
    """
    prediction = predict(scene, machine.current())
    if prediction is None:
        return {}
    figures = {
        "predicted_wall_time": prediction.wall_time,
        "predicted_evolution_time": prediction.evolution.wall,
        "predicted_memory": prediction.memory,
        "predicted_steps": prediction.steps,
    }
    return {name: value for name, value in figures.items() if math.isfinite(value)} | {
        "predicted_course": list(prediction.done)
    }


def resume(
    folder: Path,
    listener: Listener | None = None,
    completed: Completion | None = None,
    deadline: float = math.inf,
    effects: Sequence[Any] = (),
    callback: Callback | None = None,
    settings: Sequence[str] = (),
) -> Path:
    """Go on with an interrupted run, bit for bit as if it had never stopped, and return its netCDF file.

    effects: those of the user's own that it was given from Python, or their classes. settings: "key.path=value" with
    which it goes on from now on, a later end or other outputs (scene.changed); one that has ended does so, too. Where a
    disk has damaged files of the run: Archive.open. Otherwise as run_scene. Tests: tests/crash,
    tests/unit/run/test_extend.py.
    """
    begun = clock.monotonic()
    opened = hosts.first_then_others(lambda: Archive.open(folder), lambda: Archive.view(folder))
    with opened:
        scene = scene_of(opened, effects)
        if settings:
            hosts.must_be_alone("to go on with other settings")
            before, scene = scene, going_on(scene, settings)
            go_on_with(opened, scene, settings, predicted(scene), before)
        with computing(scene.numerics.devices):
            if hosts.is_first():
                note_versions(opened, scene)
            archive = opened if hosts.is_first() else Unwritten(folder, opened.metadata)
            return _Run(restore(opened, scene), archive, listener, begun, deadline, callback).finish(completed)


class _Run:
    """The loop over steps; what it holds beside the body is what the outputs still need."""

    def __init__(
        self, prepared: Prepared, archive: Archive | Unwritten, listener: Listener | None, begun: float,
        deadline: float, callback: Callback | None, profile: "Profile | None" = None,
    ) -> None:  # fmt: skip
        self.profile = profile
        self.archive, self.listener, self.begun, self.deadline = archive, listener, begun, deadline
        self.body, self.output, self.units = prepared.evolution, prepared.outputs, prepared.units
        self.records: list[dict[str, Any]] = []
        self.snapshots: list[dict[str, Any]] = []
        self.counters = dict(prepared.counters)
        self.opened = clock.monotonic()
        self.pace = Pace()
        self.reported_at, self.telling = -1e9, 0.0  # up to when, and how long it took
        self.saved, self.saved_step = self.opened, self.body.steps
        self.could_stop, self.saving = self.opened, 0.0
        self.stopping: list[str] = []
        self.several, self.callback = hosts.several(), callback
        if isinstance(self.body, GivesUp) and not self.several:
            self.body.to_give_up = self._gives_up
        if callback is not None and self.counters["series"]:
            callback.begin(self.body.time, self.body.steps)
        for kind in ("series", "snapshot"):
            if self.counters[kind]:
                self._count(kind)  # a run that goes on may have other outputs than when it was saved

    def finish(self, completed: Completion | None) -> Path:
        with interrupts.under_way(self._stopped):
            with interrupts.noted(self.stopping, self._unsaved):
                self._evolve()
            self._tell(force=True)
            # Of several processes the first alone can leave here: the others wait for it, and learn of it.
            return hosts.first_then_others(lambda: self._written(completed), lambda: self._written(completed))

    def _evolve(self) -> None:
        """Take steps to the end, all of it saved; RunInterrupted where it is to stop, which is saved, too."""
        body, output = self.body, self.output
        raise_failure()  # in the first evaluation
        if not self.counters["series"]:
            self._record(force=True)
            self._checkpoint()
        if not self._ended():
            self.counters.pop("measured", None)
        while not self._ended():
            if body.resumable:
                due = clock.monotonic() - self.saved >= output.checkpoint_seconds
                cause = self._cause()
                if (due or cause) and body.steps != self.saved_step:
                    self._checkpoint()
                if cause:
                    raise self._failure() or self._stopped(cause)
            if not self._through():
                try:
                    self._advance()
                except GivenUp:
                    continue
                self._record(force=self._ended())
            if self.pace.due(now := clock.monotonic()):
                self.pace.note(now, self._done())
        raise_failure()  # in the last record
        if "measured" not in self.counters:  # a run that is resumed after its end leaves the same file
            taken = self.counters["wall_time"] + clock.monotonic() - self.begun
            self.counters["measured"] = {
                "measured_wall_time": taken, "measured_memory": machine.peak_memory(),
                **(self.profile.attributes() if self.profile else {}),
                **({"ended_early": why} if (why := self._over()) else {}),
            }  # fmt: skip
        self._checkpoint()
        if cause := self._agreed(self._asked()):  # in the last step
            raise self._failure() or self._stopped(cause)

    def _failure(self) -> BaseException | None:
        """What the callback raised."""
        return None if self.callback is None else self.callback.failure

    def _stopped(self, by: str) -> RunInterrupted:
        return RunInterrupted(self.archive.folder, self.body.time, self.output.end, by)

    def _unsaved(self) -> bool:
        """Whether steps were taken that no checkpoint has; of several processes none may leave the others waiting."""
        return self.several or self.body.steps != self.saved_step

    def _written(self, completed: Completion | None) -> Path:
        if isinstance(self.archive, Unwritten):
            return self.archive.folder / final_name(self.archive.metadata)
        return dataset.finish(self.archive, self.counters["measured"], completed)

    def _ended(self) -> bool:
        return self._at_end() or bool(self._over())

    def _at_end(self) -> bool:
        return self.body.time >= self.output.end * (1.0 - 1e-14)

    def _over(self) -> str:
        """Why the run is over before its end; else empty."""
        if self._at_end():
            return ""
        if self.body.steps >= self.output.max_steps:
            return f"time.max_steps is reached, after {self.body.steps} steps"
        return self.body.over if isinstance(self.body, RunsOut) else ""

    def _cause(self) -> str | None:
        """What stops the run now, in any of its processes: all of them stop after the same step."""
        return self._agreed(self._asked() or (LIMIT if self._late() else None))

    def _asked(self) -> str | None:
        return self.stopping[0] if self.stopping else None

    def _agreed(self, cause: str | None) -> str | None:
        return CAUSES[hosts.agreed(CAUSES.index(cause))] if self.several else cause

    def _late(self) -> bool:
        """Whether the deadline could pass before the run can be stopped and saved the next time."""
        now = clock.monotonic()
        lately, self.could_stop = now - self.could_stop, now
        return now + MARGIN * (lately + self.saving) >= self.deadline

    def _gives_up(self) -> bool:
        """Whether a step under way, which may take hours, is given up for the run to be stopped; who listens hears."""
        self._tell(force=False)
        if not self.stopping and self._late():
            self.stopping.append(LIMIT)
        return bool(self.stopping)

    def _advance(self) -> None:
        with self._said_in_si():
            self.body.advance(self._until(), self.output.max_steps)
            raise_failure()

    def _through(self) -> bool:
        """Go through the next outputs in one call, where the model offers it; whether that came on."""
        body, output, number = self.body, self.output, self.counters["series"]
        if not isinstance(body, Through) or output.series_every is None or output.series_steps is not None:
            return False
        at_once = OUTPUTS_AT_ONCE if output.checkpoint_seconds > 0.0 and self.callback is None else 1
        begun, times = body.time, output.series_every * np.arange(number, number + at_once)
        before = times < output.end * (1.0 - 1e-14)
        times = np.append(times[before], np.minimum(times[~before], output.end)[:1])
        with self._said_in_si():
            records = body.through(times, self.counters["opening_potential"], output.max_steps)
        for record in records:
            self._keep(record)
            self._call_back(record, self._ended())
        with self._said_in_si():
            raise_failure()
        self._count("series")
        if self._ended() and not (records and records[-1]["time"] == body.time):
            self._record(force=True)
        self._tell(force=False)
        return body.time > begun

    @contextmanager
    def _said_in_si(self) -> Iterator[None]:
        try:
            with failures_said():
                yield
        except NumericalError as error:
            self._keep_what_there_is()
            raise in_si(error, self.units) from None
        except SceneError:  # of a function of the user's own
            self._keep_what_there_is()
            raise

    def _until(self) -> float:
        """The next time to be met: that of a record or a snapshot, or the end."""
        end = self.output.end
        if not (self.output.align or self.body.meets_times):
            return end
        until = min(self._next("series"), self._next("snapshot"))
        return until if until < end * (1.0 - SAME_TIME) else end

    def _keep_what_there_is(self) -> None:
        # What was recorded before a body left the numbers is what its user wants to look at. A run that goes on from a
        # checkpoint makes again what was saved after it.
        self.archive.write_segment(self.records, self.snapshots)
        self.records, self.snapshots = [], []

    def _next(self, kind: str) -> float:
        every = getattr(self.output, f"{kind}_every")
        return float("inf") if every is None else self.counters[kind] * every

    def _due(self, kind: str) -> bool:
        # The first output is number 0 at time 0; after it, the first step at or past each multiple is recorded, which
        # is at it where steps meet the times of outputs.
        return self.body.time >= self._next(kind) * (1.0 - SAME_TIME)

    def _record(self, force: bool) -> None:
        steps = self.output.series_steps
        counted = steps is not None and self.body.steps % steps == 0
        record = None
        if force or counted or self._due("series"):
            opening = self.counters["opening_potential"]
            record = self.body.record(opening)
            if opening is None:
                self.counters["opening_potential"] = record.get("potential_energy", 0.0)
                self.counters["opening_energy"] = record.get("total_energy", 0.0)
            self._keep(record)
            self._count("series")
        if force or self._due("snapshot"):
            snapshot = self.body.snapshot()
            if snapshot is not None:
                self.snapshots.append(snapshot)
                if len(self.snapshots) * sum(np.asarray(array).nbytes for array in snapshot.values()) > HELD:
                    self._keep_what_there_is()
            self._count("snapshot")
        self._call_back(record, force)
        self._tell(force=False)

    def _keep(self, record: dict[str, Any]) -> None:
        record |= self._observed(record)
        record["wall_time"] = self.counters["wall_time"] + clock.monotonic() - self.opened
        self.records.append(record)

    def _call_back(self, record: Mapping[str, Any] | None, force: bool) -> None:
        """Give the callback the state where it is due; `record` is that of now, if one was made."""
        body, callback = self.body, self.callback
        if callback is None or self.stopping:
            return
        if not (callback.due(body.time, body.steps, record is not None) or force):
            return
        record = body.look(self.counters["opening_potential"]) if record is None else record
        state = RunState(body.time, body.steps, record, body.snapshot(), self.archive.metadata)
        goes_on = callback.goes_on(state)
        if callback.failure is not None or not (goes_on or self._ended()):
            self.stopping.append(STOPPED)

    def _observed(self, record: dict[str, Any]) -> dict[str, Any]:
        try:
            return recorded(self.output.observables, record, self.body.snapshot)
        except SceneError:
            self._keep_what_there_is()
            raise

    def _count(self, kind: str) -> None:
        every = getattr(self.output, f"{kind}_every")
        passed = int(self.body.time / every * (1.0 + SAME_TIME)) + 1 if every else 1
        self.counters[kind] = max(passed, 1)

    def _checkpoint(self) -> None:
        # Saving writes copies only: the state goes on as it was.
        begin = clock.monotonic()
        self._keep_what_there_is()
        wall_time = self.counters["wall_time"] + clock.monotonic() - self.opened
        self.archive.write_checkpoint(self.body.arrays(), {**self.counters, "wall_time": wall_time})
        self.saved, self.saved_step = clock.monotonic(), self.body.steps
        self.saving = self.saved - begin

    def _tell(self, force: bool) -> None:
        pause = min(max(PAUSES[0], self.telling / TELLING), PAUSES[1])
        if self.listener is None or (not force and clock.monotonic() - self.reported_at < pause):
            return
        now = clock.monotonic()
        figures, units = self.body.figures(), code_units(self.archive.metadata)
        progress = Progress(
            time=self.body.time,
            end=self.output.end,
            step=self.body.steps,
            wall_time=self.counters["wall_time"] + now - self.opened,
            energy_error=abs(figures.total_energy - self.counters["opening_energy"]) / figures.energy_scale,
            ledger_closure=figures.ledger_closure,
            density_max=float(units.to_si(figures.density_max, "density")),
            density_unit="" if units == DIMENSIONLESS else si_unit("density"),
            limited_by=_limited_by(figures, units),
            to_go=self._to_go(now),
            planned_steps=self.archive.metadata["predicted_steps"] if self._off_plan() else math.nan,
        )
        try:
            self.listener(progress)
        except RunInterrupted as stopped:
            self.stopping.append(stopped.by)
        self.reported_at = clock.monotonic()
        self.telling = self.reported_at - now

    def _done(self) -> float:
        """The share of the run's work that is done, as it was predicted to go on with time."""
        course = self.archive.metadata.get("predicted_course", [0.0, 1.0])
        worked = np.interp(self.body.time / self.output.end, np.linspace(0.0, 1.0, len(course)), course)
        return min(1.0, max(float(worked), self.body.steps / self.output.max_steps))

    def _off_plan(self) -> bool:
        planned = self.archive.metadata.get("predicted_steps", math.inf)
        return planned > 0.0 and self.body.steps > OFF_PLAN * planned

    def _to_go(self, now: float) -> float:
        if "predicted_evolution_time" not in self.archive.metadata:
            return math.nan  # most steps of a collapse lie in a small part of its time: its pace says little
        predicted = math.nan if self._off_plan() else self.archive.metadata["predicted_evolution_time"]
        return self.pace.left(now, self._done(), predicted)


def in_si(error: NumericalError, units: CodeUnits) -> NumericalError:
    """The error with its time, which is in code units, in seconds; as it is where the scene is dimensionless."""
    if error.time is None or units == DIMENSIONLESS:
        return error
    return NumericalError(error.message, error.effect, units.to_si(error.time, "time"), error.particle, "s")


def _limited_by(figures: Figures, units: CodeUnits) -> str:
    """What sets the time step, and where, in units that people read."""
    where = ""
    if figures.limited_at is not None:
        distance, density = figures.limited_at
        if units == DIMENSIONLESS:
            where = f" at radius {distance:.3g}, density {density:.3g}"
        else:
            metres = units.to_si(distance, "length")
            size, unit = (1e3, "km") if metres >= 1e3 else (1.0, "m")
            in_si = f"{units.to_si(density, 'density'):.3g} {si_unit('density')}"
            where = f" at radius {metres / size:.3g} {unit}, density {in_si}"
    return ", ".join(filter(None, [figures.limited_by + where, figures.note]))
