"""Several processes, of one host or of many, that carry out one run together: by jax.distributed or by MPI.

All of them do the same steps, with sums shared out over the devices of all (engines.devices) or over the processes
(engines.together). What one of them decides by a clock or a signal, all must decide; the first alone writes.
Tests: tests/scale/test_hosts.py, tests/scale/test_mpi.py.
"""

import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TypeVar

import numpy as np

from astroinertia.engines import mpi
from astroinertia.errors import ArchiveError, SceneError

Made = TypeVar("Made")
_LAST_ANSWER = 0.5  # seconds in which the first process, whom the others ask, has answered what they asked last


@contextmanager
def joined(coordinator: str | None, processes: int | None, number: int | None) -> Iterator[None]:
    """Within it, this is process `number` of so many, which find each other at HOST:PORT of the first.

    Without them they are those that Slurm or MPI has started, as JAX finds out. SceneError where they do not meet.
    """
    import jax  # only here: a process by itself may do without

    try:
        jax.distributed.initialize(coordinator, processes, number)
        with suppress(ValueError):  # not the main thread
            signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGTERM))  # JAX takes it for a service of its own
    except (RuntimeError, ValueError) as error:
        raise SceneError(f"the processes of the run do not find each other: {str(error).splitlines()[0]}") from None
    try:
        yield
    finally:
        _part()


def _part() -> None:
    import jax

    # Closed while it answers, the service of the first process aborts it, after the run (gRPC of JAX 0.10.1, seldom):
    # jax.distributed.shutdown() closes it right after its last answer. What it does is done here with a pause between.
    with suppress(ImportError, AttributeError):  # parts of JAX that it promises nobody
        from jax._src.distributed import global_state

        if global_state.service is not None and global_state.client is not None:
            global_state.client.shutdown()
            global_state.client = None
            time.sleep(_LAST_ANSWER)
    jax.distributed.shutdown()


def several() -> bool:
    """Whether this process has been joined by others."""
    return mpi.communicator() is not None or _by_jax()


def _by_jax() -> bool:
    # What has not been imported has joined nobody.
    if (jax := sys.modules.get("jax")) is None:
        return False
    return jax.distributed.is_initialized() and jax.process_count() > 1


def is_first() -> bool:
    """Whether this process is the one that writes."""
    if (world := mpi.communicator()) is not None:
        return world.Get_rank() == 0
    return not _by_jax() or sys.modules["jax"].process_index() == 0


def must_be_alone(what: str) -> None:
    """Raise SceneError for what several processes cannot do together."""
    if several():
        raise SceneError(f"{what} cannot be done by several processes together; leave it out, or use one.")


def agreed(number: int) -> int:
    """The largest of the numbers that the processes have here; all of them must ask."""
    if not several():
        return number
    if (world := mpi.communicator()) is not None:
        return max(world.allgather(number))
    from jax.experimental import multihost_utils

    return int(np.max(multihost_utils.process_allgather(np.asarray(number, dtype=np.int32))))


def first_then_others(first: Callable[[], Made], others: Callable[[], Made]) -> Made:
    """What the first process makes, and the others once it has; ArchiveError in them where it failed."""
    if not is_first():
        if agreed(0):
            raise ArchiveError("the first process of the run cannot write its folder, or was stopped.")
        return others()
    try:
        made = first()
    except BaseException:
        agreed(1)
        raise
    agreed(0)
    return made
