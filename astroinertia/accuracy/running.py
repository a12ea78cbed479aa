"""Runs with the error bars that their scenes ask for: the run first, then its companion runs, then one file.

Companion runs are ordinary runs in `companion_runs/NAME` below the run's own folder. After an interruption `resume`
takes up whichever was going; those that are finished stay. Tests: tests/unit/accuracy/test_error_bars.py.
"""

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import xarray as xr

from astroinertia import dataset as datasets
from astroinertia.accuracy.companion_runs import CompanionRun, companion_runs
from astroinertia.build.assemble import missing, scene_of
from astroinertia.engines import hosts
from astroinertia.errors import ArchiveError, CompanionInterrupted, NumericalError, RunInterrupted, SceneError
from astroinertia.models.protocol import SAME_TIME
from astroinertia.run import loop
from astroinertia.run.callback import STOPPED, Callback, callback_of
from astroinertia.run.loop import Completion, Listener, Progress
from astroinertia.scene.changed import going_on
from astroinertia.scene.schema import Scene
from astroinertia.storage.archive import MANIFEST, Archive
from astroinertia.storage.atomic import own_folder

FOLDER = "companion_runs"
BESIDE_CHOICE = (
    "error bars may be larger than the error that the choice of settings states: they have the noise of sums over "
    "neighbours, too, and of each source twice what three runs give, or what two give if its order is half of theory's"
)


def run_scene(
    scene: Scene,
    folder: Path,
    listener: Listener | None = None,
    begun: float | None = None,
    deadline: float = math.inf,
    callback: Callback | None = None,
    profile: Any = None,
) -> Path:
    """Run a scene in a new run folder, with its companion runs where it asks for error bars; returns the netCDF file.

    callback, profile: of the run itself, not of its companions. Otherwise as run.loop.run_scene; SceneError, too, for a
    scene that cannot have error bars.

    >>> import tempfile
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'", "output.error_bars=true"])
    >>> with tempfile.TemporaryDirectory() as folder, xr.open_dataset(run_scene(scene, Path(folder, "run"))) as dataset:
    ...     print("angular_velocity_error" in dataset, dataset.attrs["error_bars_companion_runs"])
    True steps_per_rotation-80
    """
    completion = _completion(scene, folder, listener, deadline)
    return loop.run_scene(scene, folder, listener, begun, completion, deadline, callback, profile)


def unless_stopped(folder: Path, run: Callable[[], Path]) -> Path:
    """The file that a run leaves, or its folder where its callback stopped it.

    >>> print(unless_stopped(Path("runs/star"), lambda: resume(Path("runs/star"))).name)
    one_star_three_models.nc
    """
    try:
        return run()
    except RunInterrupted as stopped:
        if stopped.by != STOPPED:
            raise
        return folder


def resume(
    folder: Path,
    listener: Listener | None = None,
    deadline: float = math.inf,
    effects: Sequence[Any] = (),
    callback: Any = None,
    every: Any = None,
    settings: Sequence[str] = (),
) -> Path:
    """Go on with an interrupted run or its companion runs, bit for bit, and return the netCDF file.

    effects: those of the user's own that it was given from Python, or their classes, and its equation of state; a
    finished run needs none. callback, every: as for run.callback.callback_of; companion runs call none. settings:
    with which it goes on, also where it is finished (run.loop.resume).

    >>> print(resume(Path("runs/star")).name)  # finished: it has nothing to do
    one_star_three_models.nc
    """
    archive = Archive.view(folder)
    if archive.finished is not None and not settings and missing(archive, effects):
        return archive.finished  # nothing is left for them to do
    scene = scene_of(archive, effects)
    called = callback_of(callback, every, going_on(scene, settings) if settings else scene)
    completed = _completion(scene, folder, listener, deadline)
    return loop.resume(folder, listener, completed, deadline, effects, called, settings)


def _completion(scene: Scene, folder: Path, listener: Listener | None, deadline: float) -> Completion | None:
    if not scene.output.error_bars:
        return None
    hosts.must_be_alone("a run with error bars")
    runs = companion_runs(scene)  # now, so that a scene that cannot have them is refused before it is run

    def completed(main: xr.Dataset) -> xr.Dataset:
        # Only here: other runs do without what it imports.
        from astroinertia.accuracy.error_bars import with_error_bars

        outcomes, seconds = [], 0.0
        for number, run in enumerate(runs):
            begin = clock.monotonic()
            try:
                labelled = _labelled(listener, run, number, len(runs))
                outcome = _carried_out(run, own_folder(folder, FOLDER, run.name), labelled, deadline)
                seconds += float(outcome.attrs["measured_wall_time"])
            except (NumericalError, SceneError) as error:
                outcome = str(error)
                seconds += clock.monotonic() - begin
            except RunInterrupted as stopped:
                share = stopped.share
                raise CompanionInterrupted(folder, _words(run), number + 1, len(runs), share, stopped.by) from None
            outcomes.append((run, outcome))
        chosen = main.attrs.get("model") == "sph" and "choice" in main.attrs
        comment = _without_bars(outcomes) or _shorter(main, outcomes) or (BESIDE_CHOICE if chosen else "")
        return with_error_bars(main, outcomes).assign_attrs(
            {"error_bars_comment": comment} if comment else {},
            error_bars_companion_runs=", ".join(run.name for run in runs),
            error_bars_wall_time=seconds,
        )

    return completed


def _without_bars(outcomes: Sequence[tuple[CompanionRun, xr.Dataset | str]]) -> str:
    """Why there are no error bars; empty where there are."""
    failed = ((_words(run), outcome) for run, outcome in outcomes if isinstance(outcome, str))
    return next((f"no error bars: the companion run {words} failed: {why.rstrip('.')}" for words, why in failed), "")


def _shorter(main: xr.Dataset, outcomes: Sequence[tuple[CompanionRun, xr.Dataset | str]]) -> str:
    """Why error bars end before the run; empty where they do not."""
    ends = ((float(outcome["time"][-1]), run, outcome) for run, outcome in outcomes if not isinstance(outcome, str))
    end, run, outcome = min(ends, key=lambda found: found[0])
    if not end < float(main["time"][-1]) * (1.0 - SAME_TIME):
        return ""
    at = f"{end:.6g} {main['time'].attrs['units'].removeprefix('1')}".rstrip()
    why = outcome.attrs.get("ended_early", "")
    return f"no error bars after time {at}, where the companion run {_words(run)} is over: {why}"


def _carried_out(companion: CompanionRun, folder: Path, listener: Listener | None, deadline: float) -> xr.Dataset:
    """The dataset of a companion run: as it is, gone on with, or run."""
    if not (folder / MANIFEST).exists():
        return datasets.open(loop.run_scene(companion.scene, folder, listener, deadline=deadline))
    archive = Archive.view(folder)
    if archive.metadata["scene"] != companion.scene.to_toml():
        raise ArchiveError(f"{folder} holds a companion run of another scene; remove it, or choose another folder.")
    return datasets.open(
        archive.finished or loop.resume(folder, listener, deadline=deadline, effects=companion.scene.own_classes)
    )


def _labelled(listener: Listener | None, companion: CompanionRun, number: int, count: int) -> Listener | None:
    if listener is None:
        return None
    tell: Callable[[Progress], None] = listener
    part = f"companion run {number + 1} of {count}, {_words(companion)}"
    return lambda progress: tell(replace(progress, part=part))


def _words(companion: CompanionRun) -> str:
    return companion.name.replace("_", " ").replace("-", " ")
