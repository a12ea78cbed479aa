"""A second process that compiles beside a run, where the run compiles at all and there are cores enough.

Numba compiles one program at a time in a process. The other one (run.ahead) begins with what the run needs last, and
each program is compiled by one of the two; the results are the same bits. It is started by the first program that is
not found on disk, says nothing, computes on one core, and ends when there is nothing left for it to do or the run ends,
also where that is killed. No signal of a terminal reaches it.
"""

import functools
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from typing import Any

from astroinertia.costs.compiling import by_two_processes
from astroinertia.engines import hosts
from astroinertia.scene.schema import Scene

PATIENCE = 2.0  # s, for the other process to end
ONE_THREAD = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def compiled_beside(scene: Scene) -> Any:
    """A context within which what a run of the scene needs is compiled by two processes, where that is worth while."""
    return _helped(scene) if by_two_processes(scene) and not hosts.several() else nullcontext()


@contextmanager
def _helped(scene: Scene) -> Iterator[None]:
    from astroinertia.engines.numba_claims import shared

    with tempfile.TemporaryFile() as file, ExitStack() as stack:

        @functools.cache  # one process for all that is missed
        def missed() -> None:
            with suppress(OSError):  # where no process can be started, this one compiles everything
                stack.enter_context(_process(scene, file))

        with shared(file.fileno(), missed):
            yield


@contextmanager
def _process(scene: Scene, file: Any) -> Iterator[None]:
    import subprocess  # only here: where something is compiled

    from astroinertia.process.children import imports_as_here

    file.write(json.dumps([scene.to_toml(), scene.origin]).encode())
    file.flush()
    command = [sys.executable, "-P", "-m", "astroinertia.run.ahead", str(file.fileno())]
    env = imports_as_here() | ONE_THREAD
    nothing, pipe = subprocess.DEVNULL, subprocess.PIPE
    with subprocess.Popen(
        command, stdin=pipe, stdout=nothing, stderr=nothing, pass_fds=[file.fileno()], env=env, process_group=0
    ) as child:
        try:
            yield
        finally:
            assert child.stdin is not None
            child.stdin.close()  # which ends it
            with suppress(subprocess.TimeoutExpired):
                child.wait(PATIENCE)
            child.kill()
