"""Carries a scene from its first state to its last: steps, outputs, checkpoints, interruption and resumption."""

import signal
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax

from astroinertia import dataset
from astroinertia.archive import Archive, refuse_if_taken
from astroinertia.build import Prepared, metadata, prepare, restore, told_by
from astroinertia.errors import NumericalError, RunInterrupted
from astroinertia.scene.schema import Scene
from astroinertia.units import DIMENSIONLESS


@dataclass(frozen=True)
class Progress:
    """What a run tells while it goes, in code units and seconds of wall time.

    energy_error: change of the total energy over the largest of the kinetic, internal and potential energies; NaN, like
    the two after it, where a model has no such thing. limited_by: what sets the time step, and where; may be empty.
    """

    time: float
    end: float
    step: int
    wall_time: float
    energy_error: float
    ledger_closure: float
    density_max: float
    limited_by: str = ""


Listener = Callable[[Progress], None]


def run_scene(scene: Scene, folder: Path, listener: Listener | None = None) -> Path:
    """Run a scene in a new run folder and return the netCDF file that it leaves.

    Raises SceneError, ArchiveError (the folder holds another run), NumericalError, and RunInterrupted after a signal,
    with everything sealed so that `resume` goes on.
    """
    refuse_if_taken(folder, metadata(scene))
    with jax.enable_x64(True):
        # Prepared before the folder is made: a scene that cannot be built leaves nothing behind.
        return run_prepared(scene, prepare(scene), folder, listener)


def run_prepared(scene: Scene, prepared: Prepared, folder: Path, listener: Listener | None = None) -> Path:
    """The same for a scene at time 0 that is prepared; runs under jax.enable_x64."""
    with Archive.create(folder, metadata(scene) | told_by(prepared.evolution)) as archive:
        return _Run(prepared, archive, listener).finish()


def resume(folder: Path, listener: Listener | None = None) -> Path:
    """Go on with an interrupted run, bit for bit as if it had never stopped, and return its netCDF file."""
    with jax.enable_x64(True), Archive.open(folder) as archive:
        return _Run(restore(archive), archive, listener).finish()


class _Run:
    """The loop over steps; what it holds beside the body is what the outputs still need."""

    def __init__(self, prepared: Prepared, archive: Archive, listener: Listener | None) -> None:
        self.archive, self.listener = archive, listener
        self.body, self.output, self.units = prepared.evolution, prepared.outputs, prepared.units
        self.records: list[dict[str, Any]] = []
        self.snapshots: list[dict[str, Any]] = []
        self.counters = dict(prepared.counters)
        self.opened = clock.monotonic()
        self.told = -1e9
        self.saved, self.saved_step = self.opened, self.body.steps

    def finish(self) -> Path:
        body, output = self.body, self.output
        with _signals() as stopping:
            if not self.counters["series"]:
                self._record(force=True)
                self._checkpoint()
            while not self._ended():
                if body.resumable:
                    due = clock.monotonic() - self.saved >= output.checkpoint_seconds
                    if (due or stopping) and body.steps != self.saved_step:
                        self._checkpoint()
                    if stopping:
                        raise RunInterrupted(self.archive.folder, body.time, output.end)
                self._advance()
                self._record(force=self._ended())
            self._checkpoint()
        self._tell(force=True)
        return dataset.finish(self.archive)

    def _ended(self) -> bool:
        return self.body.time >= self.output.end * (1.0 - 1e-14) or self.body.steps >= self.output.max_steps

    def _advance(self) -> None:
        until = self.output.end
        if self.output.align or self.body.meets_times:
            until = min(until, self._next("series"))
        try:
            self.body.advance(until)
        except NumericalError as error:
            self._keep_what_there_is()
            raise self._in_si(error) from None

    def _keep_what_there_is(self) -> None:
        # What was recorded before a body left the numbers is what its user wants to look at.
        self.archive.write_segment(self.records, self.snapshots)
        self.records, self.snapshots = [], []

    def _in_si(self, error: NumericalError) -> NumericalError:
        if error.time is None or self.units == DIMENSIONLESS:
            return error
        time = self.units.to_si(error.time, "time")
        return NumericalError(error.message, error.effect, time, error.particle, "s")

    def _next(self, kind: str) -> float:
        every = getattr(self.output, f"{kind}_every")
        return float("inf") if every is None else self.counters[kind] * every

    def _due(self, kind: str) -> bool:
        # The first output is number 0 at time 0; after it, the first step at or past each multiple is recorded.
        return self.body.time >= self._next(kind) * (1.0 - 1e-12)

    def _record(self, force: bool) -> None:
        steps = self.output.series_steps
        counted = steps is not None and self.body.steps % steps == 0
        if force or counted or self._due("series"):
            opening = self.counters["opening_potential"]
            record = self.body.record(opening)
            if opening is None:
                self.counters["opening_potential"] = record.get("potential_energy", 0.0)
                self.counters["opening_energy"] = record.get("total_energy", 0.0)
            record["wall_time"] = self.counters["wall_time"] + clock.monotonic() - self.opened
            self.records.append(record)
            self._count("series")
        if force or self._due("snapshot"):
            snapshot = self.body.snapshot()
            self.snapshots += [] if snapshot is None else [snapshot]
            self._count("snapshot")
        self._tell(force=False)

    def _count(self, kind: str) -> None:
        every = getattr(self.output, f"{kind}_every")
        passed = int(self.body.time / every * (1.0 + 1e-12)) + 1 if every else 1
        self.counters[kind] = max(passed, 1)

    def _checkpoint(self) -> None:
        # Sealing writes copies only: the state goes on as it was.
        self.archive.write_segment(self.records, self.snapshots)
        wall_time = self.counters["wall_time"] + clock.monotonic() - self.opened
        self.archive.write_checkpoint(self.body.arrays(), {**self.counters, "wall_time": wall_time})
        self.records, self.snapshots = [], []
        self.saved, self.saved_step = clock.monotonic(), self.body.steps

    def _tell(self, force: bool) -> None:
        if self.listener is None or (not force and clock.monotonic() - self.told < 0.2):
            return
        self.told = clock.monotonic()
        found = self.body.figures()
        self.listener(
            Progress(
                time=self.body.time,
                end=self.output.end,
                step=self.body.steps,
                wall_time=self.counters["wall_time"] + self.told - self.opened,
                energy_error=abs(found.total_energy - self.counters["opening_energy"]) / found.energy_scale,
                ledger_closure=found.ledger_closure,
                density_max=found.density_max,
                limited_by=found.limited_by,
            )
        )


@contextmanager
def _signals() -> Iterator[list[int]]:
    """Collects SIGINT and SIGTERM while a run goes on; a second one acts as usual."""
    received: list[int] = []
    before = {}

    def note(number: int, _: Any) -> None:
        received.append(number)
        for signal_number, handler in before.items():
            signal.signal(signal_number, handler)

    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            before[number] = signal.signal(number, note)
    except ValueError:  # not the main thread: signals stay with whoever owns them
        before.clear()
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
