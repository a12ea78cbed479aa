"""Compiles ahead what runs of a scene need, into the cache in which they look: some steps of it, whose run is dropped.

Tests: tests/unit/run/test_warm.py.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from numba.core import event

from astroinertia.build.assemble import restore
from astroinertia.costs.compiling import by_two_processes
from astroinertia.engines.double import in_double
from astroinertia.engines.mesh import shared_out
from astroinertia.errors import SceneError
from astroinertia.models.protocol import Rehearsed
from astroinertia.run import loop
from astroinertia.scene.changed import with_settings
from astroinertia.scene.schema import Scene
from astroinertia.storage.archive import Archive

STEPS = 2  # the second is the first that goes on from a step


@dataclass(frozen=True)
class Compiled:
    """What was compiled: the programs of numba by name; seconds of wall time, of these programs and of all there was.

    processor: seconds of processor time of all. beside: whether there may be more, compiled by a second process
    (run.beside), which neither these programs nor the processor time have.
    """

    programs: tuple[str, ...]
    compiling: float
    wall: float
    processor: float
    beside: bool = False


def warm(scene: Scene) -> Compiled:
    """Compile what a run of the scene needs, and leave no run.

    The body is prepared, and settled where it is to be, and two steps are taken, with records, in a temporary folder;
    from there a step of each further kind that the run may come to. Raises SceneError where settings of the scene are
    still to be chosen, and else what a run raises.

    >>> from astroinertia.scene.load import load_file
    >>> warm(load_file("sims/tennis_racket.toml")).programs
    ()
    """
    if scene.wants_choice:
        raise SceneError("a scene whose settings are still to be chosen cannot be compiled ahead: run it, or set them.")
    steps = min(STEPS, scene.time.max_steps or STEPS)
    short = with_settings(scene, [f"time.max_steps={steps}", "output.error_bars=false"])
    begun = time.perf_counter(), time.process_time()
    with event.install_recorder("numba:compile") as recorder, TemporaryDirectory() as folder:
        loop.run_scene(short, Path(folder, "run"))
        _rehearse(short, Path(folder, "run"))
    programs, compiling = _outermost(recorder.buffer)
    wall, processor = time.perf_counter() - begun[0], time.process_time() - begun[1]
    return Compiled(programs, compiling, wall, processor, bool(programs) and by_two_processes(short))


def _rehearse(scene: Scene, folder: Path) -> None:
    """What its later steps may come to, from the state that a run was left in."""
    with Archive.view(folder) as left, in_double(), shared_out(scene.numerics.devices):
        body = restore(left, scene).evolution
        if isinstance(body, Rehearsed):
            body.rehearse()


def _outermost(events: list[tuple[float, Any]]) -> tuple[tuple[str, ...], float]:
    """Names of what was compiled, without the functions compiled within, and the seconds that it took."""
    programs, seconds, depth = [], 0.0, 0
    for at, happened in events:
        if happened.is_start:
            if depth == 0:
                programs.append(happened.data["dispatcher"].py_func.__name__)
                seconds -= at
            depth += 1
        else:
            depth -= 1
            seconds += at if depth == 0 else 0.0
    return tuple(programs), seconds
