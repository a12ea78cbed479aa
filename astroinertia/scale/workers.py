"""Members of a sweep, one after another in this process or side by side in workers of dask.distributed.

Tests: tests/unit/test_sweeps_of_scenes.py.
"""

import importlib.util
import logging
import math
import os
import re
import signal
import time as clock
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from astroinertia.errors import AstroinertiaError, RunInterrupted, SceneError
from astroinertia.interrupts import SIGNALS
from astroinertia.run import LIMIT
from astroinertia.scale.folder import SESSION, Failure, note_failure
from astroinertia.scale.members import PATIENCE, Outcome, Task, carry_out
from astroinertia.units import shown

NEEDS_DASK = "pip install 'astroinertia[dask]'"
_ADDRESS = re.compile(r"(?:[a-z]+://)?[^\s/]+:\d+")
_SECONDS_TO_ANSWER = 10.0
_KILLED = (
    "the process that ran it was ended from outside again and again, as a system does that is out of memory; it goes "
    "on from its last checkpoint when the sweep is resumed"
)


def has_dask() -> bool:
    """Whether members can be run side by side.

    >>> print(has_dask() in (True, False))
    True
    """
    return importlib.util.find_spec("distributed") is not None


def side_by_side(
    tasks: Sequence[Task], workers: int, address: str | None, deadline: float = math.inf
) -> Iterator[Outcome]:
    """Run members in so many processes of this machine, or on the cluster at an address; outcomes as they come.

    A worker that is killed is replaced, and what it ran is gone on with. When the iterator is closed, so is all that it
    started, once the sweep's session is over and members under way are sealed. deadline: of
    time.monotonic(), after which members are waited for no longer, such as one that still compiles: RunInterrupted.
    SceneError without dask, and where no cluster answers.
    """
    if not has_dask():
        raise SceneError(f"members on a cluster need dask: {NEEDS_DASK}.")
    import distributed  # pyright: ignore[reportMissingImports]  an extra

    with ExitStack() as opened:
        client = opened.enter_context(_client(distributed, workers, address, opened))
        futures = {
            client.submit(_in_worker, task, key=f"{task.session}-{task.number}", pure=False): task for task in tasks
        }
        try:
            for future in distributed.as_completed(list(futures), timeout=_seconds_to(deadline)):
                yield _outcome(distributed, future, futures.pop(future))
        except TimeoutError:
            raise RunInterrupted(Path(tasks[0].folder), 0.0, 1.0, LIMIT) from None
        finally:
            (Path(tasks[0].folder) / SESSION).unlink(missing_ok=True)  # by which members see that it is over
            with suppress(TimeoutError, distributed.CancelledError):
                distributed.wait(list(futures), timeout=min(PATIENCE, _seconds_to(deadline) or PATIENCE))


def _in_worker(task: Task) -> Outcome:
    """carry_out where xarray does not see that it is in a worker: else it asks the scheduler for a lock, hundreds of
    times a file, though members write none but their own.
    """
    from dask import config  # pyright: ignore[reportMissingImports]  an extra

    with config.set(scheduler="threads"):
        return carry_out(task)


def _seconds_to(deadline: float) -> float | None:
    return max(0.1, deadline - clock.monotonic()) if math.isfinite(deadline) else None


def _client(distributed: Any, workers: int, address: str | None, opened: ExitStack) -> Any:
    if address is not None:
        if not _ADDRESS.fullmatch(address):
            raise SceneError(f"'{shown(address)}' is no address of a cluster; write for example tcp://host:8786.")
        try:
            return distributed.Client(address, timeout=_SECONDS_TO_ANSWER)
        except (OSError, ValueError) as error:
            said = str(error).split("\n")[0].rstrip(".")
            raise SceneError(f"no cluster of dask answers at {shown(address)} ({said}).") from None
    threads = max(1, (os.cpu_count() or 1) // workers)
    cluster = distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,  # of dask: one member at a time, which has threads of its own
        env={"NUMBA_NUM_THREADS": str(threads)},
        memory_limit=0,  # a worker's share of the memory is no limit: few members may be large
        dashboard_address="127.0.0.1:0",  # any free port: the usual one may be taken
        silence_logs=logging.CRITICAL,  # what happens to a worker is told with its member
    )
    opened.enter_context(cluster)
    client = distributed.Client(cluster)

    class Deaf(distributed.WorkerPlugin):
        """Workers leave signals, which a terminal and `timeout` send to them, too, to the process of the sweep."""

        def setup(self, worker: Any) -> None:
            for number in SIGNALS:
                signal.signal(number, signal.SIG_IGN)

    client.register_plugin(Deaf())
    return client


def _outcome(distributed: Any, future: Any, task: Task) -> Outcome:
    if future.status == "finished":
        return future.result()
    if future.status != "error":
        raise AstroinertiaError("the cluster is gone; what is done is kept: go on with the same command.")
    error = future.exception()
    if not isinstance(error, distributed.KilledWorker):
        raise error  # a sweep that is over, or what no member can do
    found = Failure(_KILLED, lasting=False)
    note_failure(task.place, found)
    return Outcome(task.number, float("nan"), found)
