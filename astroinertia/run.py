"""Carries a scene from its first state to its last: steps, outputs, checkpoints, interruption and resumption."""

import signal
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np

from astroinertia import dataset
from astroinertia.archive import Archive, refuse_if_taken
from astroinertia.build import Prepared, metadata, prepare, restore
from astroinertia.errors import NumericalError, RunInterrupted
from astroinertia.models import sph
from astroinertia.models.checkpoint import flattened
from astroinertia.models.series import energy_budget, ledger_closure, series_record, snapshot_record
from astroinertia.scene.schema import Scene

# Particles are sorted anew, and checkpoints may be taken, every so many steps: a resumed run then sorts where the
# uninterrupted one did, and both compute the same bits.
STEPS_BETWEEN_SORTS = 16
# A step so much shorter than the run is no longer an evolution in time.
SMALLEST_STEP = 1e-13


@dataclass(frozen=True)
class Progress:
    """What a run tells while it goes, in code units and seconds of wall time.

    energy_error: change of the total energy over the largest of the kinetic, internal and potential energies.
    """

    time: float
    end: float
    step: int
    timestep: float
    wall_time: float
    energy_error: float
    ledger_closure: float
    density_max: float


Listener = Callable[[Progress], None]


def run_scene(scene: Scene, folder: Path, listener: Listener | None = None) -> Path:
    """Run a scene in a new run folder and return the netCDF file that it leaves.

    Raises SceneError, ArchiveError (the folder holds another run), NumericalError, and RunInterrupted after a signal,
    with everything sealed so that `resume` goes on.
    """
    described = metadata(scene)
    refuse_if_taken(folder, described)
    with jax.enable_x64(True):
        prepared = prepare(scene)  # before the folder is made: a scene that cannot be built leaves nothing behind
        with Archive.create(folder, described) as archive:
            return _Run(prepared, archive, listener).finish()


def resume(folder: Path, listener: Listener | None = None) -> Path:
    """Go on with an interrupted run, bit for bit as if it had never stopped, and return its netCDF file."""
    with jax.enable_x64(True), Archive.open(folder) as archive:
        return _Run(restore(archive), archive, listener).finish()


class _Run:
    """The loop over steps; what it holds beside the state is what the outputs still need."""

    def __init__(self, prepared: Prepared, archive: Archive, listener: Listener | None) -> None:
        self.prepared, self.archive, self.listener = prepared, archive, listener
        self.problem, self.output = prepared.problem, prepared.outputs
        self.state, self.arrangement = prepared.state, prepared.arrangement
        self.records: list[dict[str, Any]] = []
        self.snapshots: list[dict[str, Any]] = []
        self.counters = dict(prepared.counters)
        self.opened = clock.monotonic()
        self.told = -1e9
        self.saved, self.saved_step = self.opened, int(self.state.step)
        xla = self.problem.engine.name == "xla"
        self.step = jax.jit(sph.step) if xla else sph.step

    def finish(self) -> Path:
        output, counters = self.output, self.counters
        with _signals() as stopping:
            if not counters["series"]:
                self._record(force=True)
                self._checkpoint()
            while not self._ended():
                number = int(self.state.step)
                if number % STEPS_BETWEEN_SORTS == 0:
                    due = clock.monotonic() - self.saved >= output.checkpoint_seconds
                    if (due or stopping) and number != self.saved_step:
                        self._checkpoint()
                    if stopping:
                        raise RunInterrupted(self.archive.folder, float(self.state.time), output.end)
                    self._sort()
                elif self._stale():
                    self._sort()
                self._advance()
                self._record(force=self._ended())
            self._checkpoint()
        self._tell(force=True)
        return dataset.finish(self.archive)

    def _ended(self) -> bool:
        time, end = float(self.state.time), self.output.end
        return time >= end * (1.0 - 1e-14) or int(self.state.step) >= self.output.max_steps

    def _stale(self) -> bool:
        coming = sph.coming_position(self.problem, self.state)
        return self.problem.engine.stale(self.arrangement, coming, self.state.smoothing_length)

    def _sort(self) -> None:
        self.state, self.arrangement = sph.rearranged(self.problem, self.state)

    def _advance(self) -> None:
        time, end = float(self.state.time), self.output.end
        dt = float(self.state.rates.timestep)
        if not dt > SMALLEST_STEP * end:
            raise self._diagnosis(f"the time step fell to {dt:.2e} of a run of {end:.2e}")
        dt = min(dt, end - time)
        if self.output.align:
            dt = min(dt, self._next("series") - time)
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            self.state = self.step(self.problem, self.arrangement, self.state, np.float64(dt))
        if not np.isfinite(float(self.state.rates.timestep)) or not np.isfinite(
            float(self.state.ledger.kinetic_tensor.value.sum())
        ):
            raise self._diagnosis("the state is no longer finite")

    def _diagnosis(self, what: str) -> NumericalError:
        rates, time = self.state.rates, float(self.state.time)
        for name, acceleration in zip(
            self.problem.effect_names, sph.effect_accelerations(np, jax.tree.map(np.asarray, rates)), strict=True
        ):
            bad = np.flatnonzero(~np.isfinite(acceleration).all(axis=1))
            if len(bad):
                return NumericalError(what, effect=name, time=time, particle=int(self.state.identity[bad[0]]))
        total = np.asarray(
            sph.total_acceleration(np, jax.tree.map(np.asarray, rates), np.asarray(rates.fluid.velocity))
        )
        worst = int(np.argmax(np.linalg.norm(total, axis=1)))
        return NumericalError(what, effect=None, time=time, particle=int(self.state.identity[worst]))

    def _next(self, kind: str) -> float:
        return self.counters[kind] * getattr(self.output, f"{kind}_every")

    def _due(self, kind: str) -> bool:
        # The first output is number 0 at time 0; after it, the first step at or past each multiple is recorded.
        every = getattr(self.output, f"{kind}_every")
        return every is not None and float(self.state.time) >= self._next(kind) * (1.0 - 1e-12)

    def _record(self, force: bool) -> None:
        steps = self.output.series_steps
        counted = steps is not None and int(self.state.step) % steps == 0
        if force or counted or self._due("series"):
            opening = self.counters["opening_potential"]
            record = series_record(self.problem, self.arrangement, self.state, opening)
            if opening is None:
                self.counters["opening_potential"] = record["potential_energy"]
                self.counters["opening_energy"] = record["total_energy"]
            record["wall_time"] = self.counters["wall_time"] + clock.monotonic() - self.opened
            self.records.append(record)
            self._count("series")
        if force or self._due("snapshot"):
            self.snapshots.append(snapshot_record(self.state))
            self._count("snapshot")
        self._tell(force=False)

    def _count(self, kind: str) -> None:
        every = getattr(self.output, f"{kind}_every")
        passed = int(float(self.state.time) / every * (1.0 + 1e-12)) + 1 if every else 1
        self.counters[kind] = max(passed, 1)

    def _checkpoint(self) -> None:
        # Sealing writes copies only: the state goes on as it was.
        self.archive.write_segment(self.records, self.snapshots)
        wall_time = self.counters["wall_time"] + clock.monotonic() - self.opened
        self.archive.write_checkpoint(flattened(self.state), {**self.counters, "wall_time": wall_time})
        self.records, self.snapshots = [], []
        self.saved, self.saved_step = clock.monotonic(), int(self.state.step)

    def _tell(self, force: bool) -> None:
        if self.listener is None or (not force and clock.monotonic() - self.told < 0.2):
            return
        self.told = clock.monotonic()
        energy = energy_budget(self.problem, self.state)
        largest = max(energy["kinetic"], abs(energy["internal"]), *map(abs, energy["potential"].values()), 1e-300)
        self.listener(
            Progress(
                time=float(self.state.time),
                end=self.output.end,
                step=int(self.state.step),
                timestep=float(self.state.rates.timestep),
                wall_time=self.counters["wall_time"] + self.told - self.opened,
                energy_error=abs(energy["total"] - self.counters["opening_energy"]) / largest,
                ledger_closure=ledger_closure(self.problem, self.state),
                density_max=float(np.max(self.state.rates.fluid.density)),
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
