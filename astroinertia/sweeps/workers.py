"""Members of a sweep run side by side by processes of this machine, each at the other end of a pipe.

No port is opened. A worker sees no signal, which terminals and `timeout` send to all processes of a command; the
process of the sweep says what is to be stopped.

Tests: tests/unit/sweeps/test_ensemble.py, tests/crash/test_sweep_signals.py.
"""

import signal
import subprocess
import sys
import time as clock
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import astuple
from multiprocessing import Pipe
from multiprocessing.connection import wait
from pathlib import Path

from astroinertia.errors import AstroinertiaError, RunInterrupted
from astroinertia.process import interrupts
from astroinertia.process.children import imports_as_here
from astroinertia.process.cores import cores
from astroinertia.process.interrupts import LIMIT
from astroinertia.sweeps.folder import SESSION
from astroinertia.sweeps.members import PATIENCE, Outcome, Task, given_up

TRIES = 4  # of a member whose worker is killed each time
_SECONDS_BETWEEN_LOOKS = 0.2  # at the clock and at what signals ask for
_STOP = None


def side_by_side(tasks: Sequence[Task], workers: int, deadline: float) -> Iterator[Outcome]:
    """Run members in so many processes of this machine; outcomes as they come.

    A worker that is killed is replaced, and what it ran is gone on with. When the iterator is closed, workers are gone,
    once members under way are saved. deadline: of time.monotonic(), after which members are waited for no longer:
    RunInterrupted, as after a signal.
    """
    stops: list[str] = []
    waiting, tries = deque(tasks), Counter[int]()
    threads = max(1, cores() // workers)
    pool: list[_Worker] = []
    with interrupts.noted(stops):
        try:
            while waiting or any(worker.task for worker in pool):
                while waiting and len(pool) < workers:
                    pool.append(_Worker(threads))
                for worker in pool:
                    if waiting and worker.task is None:
                        worker.give(waiting.popleft())
                for worker in _ready(pool):
                    task, outcome = worker.taken()
                    if outcome is None:
                        pool.remove(worker)
                        tries[task.number] += 1
                        outcome = given_up(task) if tries[task.number] == TRIES else waiting.appendleft(task)
                    if outcome is not None:
                        yield outcome
                if stops or clock.monotonic() > deadline:
                    raise RunInterrupted(Path(tasks[0].folder), 0.0, 1.0, (*stops, LIMIT)[0])
        finally:
            (Path(tasks[0].folder) / SESSION).unlink(missing_ok=True)
            for worker in pool:
                worker.stop()
            for worker in pool:
                worker.end(clock.monotonic() + PATIENCE)


class _Worker:
    """A process that runs members (astroinertia.sweeps.worker), and the one that it runs."""

    def __init__(self, threads: int) -> None:
        self.task: Task | None = None
        self.connection, theirs = Pipe()
        command = [sys.executable, "-P", "-m", "astroinertia.sweeps.worker", str(theirs.fileno())]
        env = imports_as_here() | {"NUMBA_NUM_THREADS": str(threads)}
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, interrupts.SIGNALS)  # what a child inherits
        try:
            with theirs:
                self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, pass_fds=[theirs.fileno()], env=env)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)

    def give(self, task: Task) -> None:
        self.task = task
        with suppress(OSError):  # of one that was killed, `taken` says so
            self.connection.send(astuple(task))

    def taken(self) -> tuple[Task, Outcome | None]:
        """The member that it ran, and the outcome; None where the process was killed. Raises what ended it."""
        task, self.task = self.task, None
        assert task is not None
        try:
            outcome = self.connection.recv()
        except (EOFError, OSError):
            self.connection.close()
            if (code := self.process.wait()) < 0:
                return task, None
            raise AstroinertiaError(
                f"a worker ended with exit code {code}; what is done is kept: go on with the same command."
            ) from None
        if isinstance(outcome, Exception):
            raise outcome
        return task, outcome

    def stop(self) -> None:
        """Ask it to save what it runs, and to end."""
        with suppress(OSError):
            self.connection.send(_STOP)

    def end(self, deadline: float) -> None:
        """Wait until it has ended, and end it where it has not by a time."""
        try:
            self.process.wait(max(0.0, deadline - clock.monotonic()))
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.connection.close()


def _ready(pool: Sequence[_Worker]) -> list[_Worker]:
    readable = wait([worker.connection for worker in pool if worker.task is not None], _SECONDS_BETWEEN_LOOKS)
    return [worker for worker in pool if worker.connection in readable]
