"""A sweep from its scene to one dataset: members given out, failures kept apart, gone on with after an interruption.

Tests: tests/unit/sweeps/test_ensemble.py, test_ensemble_failures.py.
"""

import math
import time as clock
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from astroinertia.build.assemble import refuse_contradictions
from astroinertia.costs import machine
from astroinertia.costs.prediction import Prediction, predict
from astroinertia.errors import RunInterrupted, SceneError, SweepInterrupted
from astroinertia.process import interrupts
from astroinertia.process.cores import cores
from astroinertia.scene.sweep import Sweep
from astroinertia.storage.archive import locked
from astroinertia.storage.atomic import remove_leftovers, write_whole
from astroinertia.sweeps import combined, folder as folders
from astroinertia.sweeps.cluster import by_cluster, refuse_address
from astroinertia.sweeps.folder import SESSION, Failure
from astroinertia.sweeps.members import Task, carry_out
from astroinertia.sweeps.workers import side_by_side

DEFAULT_MINUTES = 60.0  # that a member may take whose settings are chosen for an accuracy
SECONDS_TO_CLOSE = 6.0  # that workers take to be gone once their members are saved
WORTH_WORKERS = 30.0  # seconds of work, below which the start of processes takes as long


@dataclass(frozen=True)
class Standing:
    """How far a sweep is: members done, of them failed, in all; seconds taken, and to go (NaN before a result)."""

    done: int
    failed: int
    members: int
    seconds: float
    to_go: float


@dataclass(frozen=True)
class Carried:
    """A sweep that is done: its file, and why members have no result, by their numbers."""

    file: Path
    failures: dict[int, Failure]


Listener = Callable[[Standing], None]


def run_sweep(
    sweep: Sweep,
    folder: Path,
    workers: int = 1,
    cluster: str | None = None,
    minutes: float = DEFAULT_MINUTES,
    listener: Listener | None = None,
    deadline: float = math.inf,
) -> Carried:
    """Run all members of a sweep in a folder, or those that are left, and put them together in one file.

    workers: processes of this machine, 1 for this one alone; cluster: the address of a cluster of dask instead, which
    sees the same files. deadline: of time.monotonic(), by which members under way are saved and no more are begun.
    Members that failed for good stay as they are. Raises SceneError, ArchiveError (the folder holds something else, or
    another process runs it), and after a signal or for the deadline SweepInterrupted, which says how far members are:
    the same call goes on.

    >>> import tempfile
    >>> from astroinertia.scene.sweep import load_file
    >>> sweep = load_file("sweep.toml")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = run_sweep(
    ...         sweep, Path(folder), listener=lambda standing: print(f"{standing.done} of {standing.members}")
    ...     )
    0 of 2
    1 of 2
    2 of 2
    >>> print(done.file.name, done.failures)
    sweep.nc {}
    """
    if workers < 1:
        raise SceneError("the number of workers must be at least 1.")
    if cluster is not None:
        refuse_address(cluster)
    if sweep.own:
        raise SceneError("a sweep takes what is built in or installed, and nothing of your own from Python.")
    folders.describe(sweep, folder)
    count = len(sweep.members)
    with closing(locked(folder)), _session(folder) as session:
        remove_leftovers(folder, (SESSION, combined.path(sweep, folder).name))
        own = deadline
        if workers > 1 or cluster is not None:
            deadline, own = deadline - SECONDS_TO_CLOSE, math.inf
        tasks = [Task(str(folder.absolute()), number, session, minutes, own) for number in left(sweep, folder)]
        try:
            _carry_out(tasks, count, workers, cluster, folder, listener, deadline)
        except SweepInterrupted as stopped:  # members are saved by now
            under_way = folders.under_way(sweep, folder)
            raise SweepInterrupted(folder, stopped.done, count, stopped.by, under_way) from None
        failures = {number: failure for number in range(count) if (failure := folders.failure(folder, number))}
        why = {number: failure.sentence for number, failure in failures.items()}
        if tasks or not combined.is_written(sweep, folder, why):
            _combine(sweep, folder, why)
    return Carried(combined.path(sweep, folder), failures)


def resume(
    folder: Path, workers: int = 1, cluster: str | None = None, minutes: float = DEFAULT_MINUTES,
    listener: Listener | None = None, deadline: float = math.inf,
) -> Carried:  # fmt: skip
    """Go on with the sweep that a folder holds, as run_sweep.

    >>> print(resume(Path("runs/sweep")).file.name)  # finished: it has nothing to do
    sweep.nc
    """
    return run_sweep(folders.read(folder), folder, workers, cluster, minutes, listener, deadline)


def left(sweep: Sweep, folder: Path) -> list[int]:
    """Numbers of the members that a sweep's folder, which may not be there yet, has left to run.

    ArchiveError where the folder holds something else.

    >>> sweep = folders.read(Path("runs/sweep"))
    >>> print(left(sweep, Path("runs/sweep")), left(sweep, Path("runs/another")))
    [] [0, 1]
    """
    folders.refuse_others(sweep, folder)
    return folders.waiting(folder, len(sweep.members))


def predictions(sweep: Sweep, numbers: Sequence[int]) -> list[Prediction | None]:
    """What members will take, None where that is not known.

    >>> sweep = folders.read(Path("runs/sweep"))
    >>> print([each.evolution.wall < 60.0 for each in predictions(sweep, [0, 1])])
    [True, True]
    """
    speeds = machine.current()
    return [predict(sweep.scene(number), speeds) for number in numbers]


def refused(sweep: Sweep, numbers: Sequence[int]) -> dict[int, str]:
    """Members whose body cannot be or whose effects contradict each other, and why, before anything is prepared.

    >>> sweep = folders.read(Path("runs/sweep"))
    >>> print(refused(sweep, [0, 1]))
    {}
    """
    sentences = {}
    for number in numbers:
        try:
            refuse_contradictions(sweep.scene(number))
        except SceneError as error:
            sentences[number] = str(error)
    return sentences


def usual_workers(predicted: Sequence[Prediction | None]) -> int:
    """Processes that are worth their start for what members will take: one for each core, or this one alone.

    >>> print(usual_workers([]))
    1
    """
    seconds = sum(math.inf if prediction is None else prediction.evolution.wall for prediction in predicted)
    return min(cores(), len(predicted)) if seconds > WORTH_WORKERS and len(predicted) > 1 else 1


def _carry_out(
    tasks: Sequence[Task], count: int, workers: int, cluster: str | None, folder: Path, listener: Listener | None,
    deadline: float,
) -> None:  # fmt: skip
    begun, before = clock.monotonic(), count - len(tasks)
    numbers = {task.number for task in tasks}
    failed = sum(number not in numbers and folders.failure(folder, number) is not None for number in range(count))
    outcomes: Any = (carry_out(task) for task in tasks)
    if tasks and cluster is not None:
        outcomes = by_cluster(tasks, cluster, deadline)
    elif tasks and workers > 1:
        outcomes = side_by_side(tasks, min(workers, len(tasks)), deadline)
    done, tell = 0, listener or (lambda standing: None)
    spent, results, on_results = 0.0, 0, 0.0  # seconds of members, side by side too; those that failed may take none

    def stopped(by: str) -> SweepInterrupted:
        return SweepInterrupted(folder, before + done, count, by)

    with interrupts.under_way(stopped), closing(outcomes):
        try:
            tell(Standing(before, failed, count, 0.0, math.nan))
            for done, outcome in enumerate(outcomes, 1):
                failed += outcome.failure is not None
                seconds = clock.monotonic() - begun
                spent += outcome.seconds
                if outcome.failure is None:
                    results, on_results = results + 1, on_results + outcome.seconds
                each = on_results / results * seconds / spent if on_results else math.nan
                tell(Standing(before + done, failed, count, seconds, each * (len(tasks) - done)))
        except RunInterrupted as one:
            raise stopped(one.by) from None


def _combine(sweep: Sweep, folder: Path, failures: Mapping[int, str]) -> None:
    count = len(sweep.members)
    with interrupts.under_way(lambda by: SweepInterrupted(folder, count, count, by)):
        combined.write(sweep, folder, failures)


@contextmanager
def _session(folder: Path) -> Iterator[str]:
    """The text by which members know that they are still wanted; without its file they stop."""
    session = uuid.uuid4().hex
    path = folder / SESSION
    write_whole(path, lambda aside: aside.write_text(session))
    try:
        with interrupts.leaving(path.unlink):
            yield session
    finally:
        path.unlink(missing_ok=True)
