"""One member of a sweep, run, gone on with or found finished, wherever it is called: here or in a worker.

Tests: tests/unit/sweeps/test_ensemble.py.
"""

import functools
import math
import time as clock
from dataclasses import dataclass
from pathlib import Path

from astroinertia.accuracy import running
from astroinertia.errors import ArchiveError, AstroinertiaError, NumericalError, RunInterrupted, SceneError
from astroinertia.process.interrupts import LIMIT
from astroinertia.run.loop import Listener, Progress
from astroinertia.scene.sweep import Sweep, member
from astroinertia.storage.archive import LOCK, MANIFEST, locked
from astroinertia.storage.atomic import own_folder
from astroinertia.storage.manifest import FAILURE
from astroinertia.sweeps import folder as folders
from astroinertia.sweeps.folder import SESSION, Failure

PATIENCE = 30.0  # seconds that another process may still hold a member after its worker was given up
SECONDS_BETWEEN_LOOKS = 1.0  # at the session's file
KILLED = (
    "the process that ran it was ended from outside again and again, as a system does that is out of memory; it goes "
    "on from its last checkpoint when the sweep is resumed"
)


@dataclass(frozen=True)
class Task:
    """A member to be run, of the sweep whose folder has this absolute path.

    session: the text that the sweep's session file has as long as members are wanted. minutes: that a run may take
    where its settings are chosen for an accuracy. deadline: of this process's time.monotonic(), by which the member is
    to be saved. Other processes, whose clocks may be others, are asked to stop by the end of the session.
    """

    folder: str
    number: int
    session: str
    minutes: float
    deadline: float = math.inf

    @property
    def place(self) -> Path:
        """The member's own run folder."""
        return Path(self.folder) / member(self.number)


@dataclass(frozen=True)
class Outcome:
    """A member that was run: the seconds it took, and why it failed, if it did."""

    number: int
    seconds: float
    failure: Failure | None = None


def carry_out(task: Task, listener: Listener | None = None) -> Outcome:
    """Run a member, or go on with it from its last checkpoint; what goes wrong is its outcome.

    RunInterrupted where the sweep wants no more members, its time is over, or a signal asks to stop; what is under way
    is saved then.
    """
    if not _is_wanted(task):
        raise RunInterrupted(task.place, 0.0, 1.0)
    if clock.monotonic() >= task.deadline:
        raise RunInterrupted(task.place, 0.0, 1.0, LIMIT)
    begun, place = clock.monotonic(), task.place
    failure: Failure | None = None
    try:
        _run(task, place, _watchful(task, listener))
    except RunInterrupted:
        raise
    except (NumericalError, SceneError) as error:
        failure = Failure(str(error), lasting=True)
    except AstroinertiaError as error:
        failure = Failure(str(error), lasting=False)
    except Exception as error:  # whatever it is, it is this member's: others go on
        failure = Failure(f"{type(error).__name__}: {error}", lasting=False)
    if failure is not None:
        folders.note_failure(place, failure)
    return Outcome(task.number, clock.monotonic() - begun, failure)


def given_up(task: Task) -> Outcome:
    """Of a member whose process was ended again and again."""
    failure = Failure(KILLED, lasting=False)
    folders.note_failure(task.place, failure)
    return Outcome(task.number, math.nan, failure)


def _run(task: Task, place: Path, listener: Listener) -> None:
    _wait_for_lock(own_folder(place.parent, place.name))
    if (place / MANIFEST).exists():
        if folders.finished(place.parent, task.number) is None:
            running.resume(place, listener, task.deadline)
    else:
        scene = _sweep(task.folder, task.session).scene(task.number)
        if scene.wants_choice:
            # only here: other members do without what it imports
            from astroinertia.accuracy.choice import choose, pilots_beside

            pilots = own_folder(place.parent, pilots_beside(place).name)
            scene = choose(scene, pilots, task.minutes).scene
        running.run_scene(scene, place, listener, deadline=task.deadline)
    (place / FAILURE).unlink(missing_ok=True)


@functools.lru_cache(maxsize=2)
def _sweep(folder: str, session: str) -> Sweep:
    # The same for all members of a session, and perhaps long.
    assert session
    return folders.read(Path(folder))


def _watchful(task: Task, listener: Listener | None) -> Listener:
    """What tells a run's progress, and ends the run once the sweep is over or another process has taken it up."""
    looked = clock.monotonic()

    def tell(progress: Progress) -> None:
        nonlocal looked
        if clock.monotonic() - looked >= SECONDS_BETWEEN_LOOKS:
            looked = clock.monotonic()
            if not _is_wanted(task):
                raise RunInterrupted(task.place, progress.time, progress.end)
        if listener is not None:
            listener(progress)

    return tell


def _is_wanted(task: Task) -> bool:
    try:
        return (Path(task.folder) / SESSION).read_text() == task.session
    except FileNotFoundError:
        return False


def _wait_for_lock(place: Path) -> None:
    """Wait for another process to let go of the member: a worker that was given up, but has not noticed yet."""
    if not (place / LOCK).exists():
        return
    end = clock.monotonic() + PATIENCE
    while True:
        try:
            locked(place).close()
            return
        except ArchiveError:
            if clock.monotonic() > end:
                raise
            clock.sleep(0.2)
