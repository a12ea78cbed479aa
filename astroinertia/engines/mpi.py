"""The processes that a starter of MPI (mpirun, srun) has started for one run; nothing else imports mpi4py.

Tests: tests/scale/test_mpi.py.
"""

import atexit
import math
import os
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any

from astroinertia.engines.together import ALONE, Alone, Together
from astroinertia.errors import SAID, RunInterrupted, SceneError
from astroinertia.process.cores import cores
from astroinertia.process.kept_programs import processor
from astroinertia.process.starters import started

_PATIENCE = 60.0  # seconds in which the others end as well where all do for the same reason
_VERSIONS = ("astroinertia", "numpy", "scipy", "numba", "jax")
_together: list[Together] = []  # while this process is one of several


def together() -> Alone:
    """The processes that share out the passes of a run."""
    return _together[0] if _together else ALONE


def communicator() -> Any:
    """That of mpi4py, of all processes of the run; None where this one is alone."""
    return _together[0].communicator if _together else None


@contextmanager
def joined() -> Iterator[None]:
    """Within it, this process does runs together with the others that MPI has started.

    SceneError where they cannot. If one of them ends by itself, all end; where all do, the errors of all but the first
    have the note errors.SAID.
    """
    try:
        from mpi4py import MPI  # pyright: ignore[reportMissingImports]  an extra
    except (ImportError, RuntimeError):
        raise SceneError(
            f"MPI has started {started()} processes of this run, which need mpi4py: pip install 'astroinertia[mpi]'."
        ) from None
    world = MPI.COMM_WORLD
    if world.Get_size() != started():
        raise SceneError(
            f"MPI has started {started()} processes, but mpi4py knows of {world.Get_size()}: it is made for another "
            "MPI than the one that they were started by."
        )
    try:
        kind = f"{processor()} {sys.version_info[:2]} {[version(name) for name in _VERSIONS]}"
        if len(set(world.allgather(kind))) > 1:
            # Each takes all steps by itself: they would go different ways.
            raise SceneError("the processes of a run need the same processors and versions of packages; theirs differ.")
        _share_cores(world.Split_type(MPI.COMM_TYPE_SHARED).Get_size())
        _together.append(Together(world))
        yield
    except BaseException as error:
        # All are interrupted at the same step, and the first saves it, which may take long.
        if _have_all_ended(world, math.inf if isinstance(error, RunInterrupted) else _PATIENCE):
            if world.Get_rank() > 0:
                error.add_note(SAID)
        else:  # one has by itself, and says why; others wait for what it does not send
            atexit.register(world.Abort, 1)
        raise
    finally:
        _together.clear()


def _share_cores(processes: int) -> None:
    """Threads for this process of so many on this machine, where no one has set their number or bound it to cores."""
    if cores() == os.cpu_count():
        os.environ.setdefault("NUMBA_NUM_THREADS", str(max(1, cores() // processes)))


def _have_all_ended(world: Any, patience: float) -> bool:
    """Whether all come here within so many seconds, which are waited for."""
    all_have, since = world.Ibarrier(), clock.monotonic()
    while not all_have.Test():
        if clock.monotonic() - since > patience:
            return False
        clock.sleep(0.01)
    return True
