"""Members of a sweep run by the workers of a cluster of dask, which its user has started and keeps safe.

Tests: tests/unit/sweeps/test_ensemble.py.
"""

import importlib.util
import re
import time as clock
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from astroinertia.errors import AstroinertiaError, RunInterrupted, SceneError
from astroinertia.process import interrupts
from astroinertia.process.interrupts import LIMIT
from astroinertia.sweeps.folder import SESSION
from astroinertia.sweeps.members import PATIENCE, Outcome, Task, carry_out, given_up
from astroinertia.units import shown

_ADDRESS = re.compile(r"(?:[a-z]+://)?[^\s/]+:\d+")
_SECONDS_TO_ANSWER = 10.0
_SECONDS_BETWEEN_LOOKS = 0.5  # at the clock and at what signals ask for


def refuse_address(address: str) -> None:
    """SceneError for what is no address of a cluster, before anything is written.

    >>> refuse_address("tcp://host:8786")
    """
    if not _ADDRESS.fullmatch(address):
        raise SceneError(f"'{shown(address)}' is no address of a cluster; write for example tcp://host:8786.")


def by_cluster(tasks: Sequence[Task], address: str, deadline: float) -> Iterator[Outcome]:
    """Run members on the cluster at an address; outcomes as they come.

    When the iterator is closed, the sweep's session is over, by which members under way see that they are to be saved.
    deadline: of time.monotonic(), after which members are waited for no longer: RunInterrupted, as after a signal.
    SceneError without dask, and where no cluster answers.
    """
    if importlib.util.find_spec("distributed") is None:
        raise SceneError("members on a cluster need dask: pip install 'astroinertia[dask]'.")
    import distributed  # pyright: ignore[reportMissingImports]  an extra

    stops: list[str] = []
    with interrupts.noted(stops), _client(distributed, address) as client:
        futures = {
            client.submit(_in_worker, task, key=f"{task.session}-{task.number}", pure=False): task for task in tasks
        }
        try:
            while futures:
                for future in _done(distributed, futures):
                    yield _outcome(distributed, future, futures.pop(future))
                if stops or clock.monotonic() > deadline:
                    raise RunInterrupted(Path(tasks[0].folder), 0.0, 1.0, (*stops, LIMIT)[0])
        finally:
            (Path(tasks[0].folder) / SESSION).unlink(missing_ok=True)
            with suppress(TimeoutError, distributed.CancelledError):
                distributed.wait(list(futures), timeout=min(PATIENCE, max(0.1, deadline - clock.monotonic())))


def _done(distributed: Any, futures: Any) -> list[Any]:
    try:
        states = distributed.wait(list(futures), _SECONDS_BETWEEN_LOOKS, return_when="FIRST_COMPLETED")
    except TimeoutError:
        return []
    return list(states.done)


def _in_worker(task: Task) -> Outcome:
    """carry_out where xarray does not see that it is in a worker: else it asks the scheduler for a lock, hundreds of
    times a file, though members write none but their own.
    """
    from dask import config  # pyright: ignore[reportMissingImports]  an extra

    with config.set(scheduler="threads"):
        return carry_out(task)


def _client(distributed: Any, address: str) -> Any:
    try:
        return distributed.Client(address, timeout=_SECONDS_TO_ANSWER)
    except (OSError, ValueError) as error:
        said = str(error).split("\n")[0].rstrip(".")
        raise SceneError(f"no cluster of dask answers at {shown(address)} ({said}).") from None


def _outcome(distributed: Any, future: Any, task: Task) -> Outcome:
    if future.status == "finished":
        return future.result()
    if future.status != "error":
        raise AstroinertiaError("the cluster is gone; what is done is kept: go on with the same command.")
    error = future.exception()
    if not isinstance(error, distributed.KilledWorker):
        raise error  # a sweep that is over, or what no member can do
    return given_up(task)
