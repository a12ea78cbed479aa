"""One setting of a tradeoff, run and measured: its observables, and what it took. Finished ones are not run again.

Times are of the steps alone, on compiled code: whatever is compiled is compiled before, in a run that is thrown away.
Tests: tests/unit/accuracy/test_tradeoff.py.
"""

import math
import shutil
import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from astroinertia import dataset as datasets
from astroinertia.accuracy.knobs import Setting, overridden
from astroinertia.accuracy.selected_observables import SelectedObservable, components, value
from astroinertia.build.assemble import metadata, prepare
from astroinertia.costs import experience
from astroinertia.costs.machine import peak_memory
from astroinertia.errors import ArchiveError, NumericalError, SceneError
from astroinertia.models.protocol import Evolution
from astroinertia.run.loop import run_prepared
from astroinertia.scene.plan import gravity_method
from astroinertia.scene.schema import Scene
from astroinertia.storage.atomic import own_folder, read_json, write_json
from astroinertia.storage.cache import content_key

_RESULT = "measured.json"
_WARM_UP_STEPS = 3  # the first sorts and compiles, the second goes on, the third finds all that is compiled
_CLEAR = Path("/proc/self/clear_refs")
_warm: set[Any] = set()  # what this process has compiled

MEMORY_MENTIONED = (
    "the most that the process held while it ran, its code and libraries included (VmHWM of Linux, forgotten before "
    "each run), as one process runs them all: no less than the run needs; NaN on other systems"
)


@dataclass(frozen=True)
class Measured:
    """What a setting gave and took: values of each observable and their names, seconds, bytes.

    step_time and cpu_time are of the steps alone, wall and processor time of all threads; wall_time is from preparing
    the body to the finished file. failure is the sentence of a run that failed, whose numbers are NaN. evaluations: of
    a particle, or steps of a body without particles; 0 where an older version measured.
    """

    values: dict[str, list[float]]
    components: dict[str, list[str]]
    step_time: float
    cpu_time: float
    wall_time: float
    preparation_time: float
    peak_memory: float
    steps: int
    failure: str = ""
    evaluations: int = 0


class Clocked:
    """A body under its model whose steps are timed; all else is the body's own."""

    def __init__(self, body: Evolution) -> None:
        self.body, self.step_time, self.cpu_time = body, 0.0, 0.0

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.body, name)
        return self._clocked(value) if name == "through" else value  # which only some have

    def advance(self, until: float, most: float = math.inf) -> None:
        """Go on, and count the seconds."""
        self._clocked(self.body.advance)(until, most)

    def _clocked(self, going: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*arguments: Any) -> Any:
            wall, cpu = clock.perf_counter(), clock.process_time()
            try:
                return going(*arguments)
            finally:
                self.step_time += clock.perf_counter() - wall
                self.cpu_time += clock.process_time() - cpu

        return counted


def scene_of(scene: Scene, setting: Setting, observables: Sequence[SelectedObservable]) -> Scene:
    """The scene of a setting, recorded at its start and its end alone unless a series is asked for.

    Steps that are shortened to meet records would hide what the tolerance or a factor does; models without particles
    always shorten them. SceneError where the scene does not allow the setting.
    """
    quiet = () if any(observable.of_series for observable in observables) else _without_records(scene)
    return overridden(scene, ("output.align=false", *quiet, *setting.overrides))


def folder_of(place: Path, scene: Scene, setting: Setting) -> Path:
    """The folder of a setting's `scene_of` below that of the tradeoff, named after both; ArchiveError for a link.

    scene: what `scene_of` gave; its hash in the name tells settings of other scenes apart.
    """
    slug = "".join(letter if letter.isalnum() or letter in ".-" else "_" for letter in setting.label)
    return own_folder(place, "settings", f"{slug[:60]}-{content_key(scene=scene.to_toml())[:8]}")


def stored(folder: Path, observables: Sequence[SelectedObservable]) -> Measured | None:
    """What a finished setting gave, or None where it is not finished or was asked for other observables."""
    try:
        measured = Measured(**read_json(folder / _RESULT))
    except (OSError, ArchiveError, TypeError):
        return None
    return measured if measured.failure or all(one.name in measured.values for one in observables) else None


def measure(scene: Scene, observables: Sequence[SelectedObservable], folder: Path, rehearsed: bool = True) -> Measured:
    """Run a scene in `folder` and say what it gave and took; what an interruption left there is run again.

    rehearsed: a body without particles goes all its way before, as else its times are of compiling. A NumericalError is
    a result, and so is that the model cannot answer the scene: the sentence is kept. SceneError for an observable that
    there is not, RunInterrupted after a signal.
    """
    if folder.exists():
        shutil.rmtree(folder)
    import jax  # only here: most runs are not measured

    with jax.enable_x64(True):
        try:
            measured = _measured(scene, observables, folder, rehearsed)
        except NumericalError as error:
            measured = failed(str(error), observables)
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / _RESULT, asdict(measured))
    return measured


def failed(sentence: str, observables: Sequence[SelectedObservable]) -> Measured:
    """A setting without an answer."""
    nothing = {observable.name: [float("nan")] for observable in observables}
    return Measured(nothing, {}, *[float("nan")] * 5, steps=0, failure=sentence)


def _measured(scene: Scene, observables: Sequence[SelectedObservable], folder: Path, rehearsed: bool) -> Measured:
    try:
        _compile(scene)
        with suppress(OSError):  # the peak of memory is forgotten
            _CLEAR.write_text("5")
        begin = clock.perf_counter()
        prepared = prepare(scene)
    except SceneError as error:
        return failed(str(error), observables)
    body = Clocked(prepared.evolution)
    preparation = clock.perf_counter() - begin
    if rehearsed and prepared.evolution.meets_times and hasattr(prepared.evolution, "resume"):
        _rehearse(prepared.evolution, prepared.outputs.end)
    folder.parent.mkdir(parents=True, exist_ok=True)
    begin = clock.perf_counter()
    file = run_prepared(metadata(scene), replace(prepared, evolution=body), folder, None, clock.monotonic())
    wall = preparation + clock.perf_counter() - begin
    dataset = datasets.open(file)
    values = {observable.name: value(dataset, observable).tolist() for observable in observables}
    if float(dataset["time"][-1]) < scene.time.end * (1.0 - 1e-12):
        early = dataset.attrs["ended_early"]
        raise SceneError(f"a run is over before its end, at which the observables are taken: {early}.")
    return Measured(
        values=values, components={observable.name: components(dataset, observable) for observable in observables},
        step_time=body.step_time, cpu_time=body.cpu_time, wall_time=wall, preparation_time=preparation,
        peak_memory=peak_memory() if _CLEAR.exists() else math.nan, steps=int(prepared.evolution.steps),
        evaluations=int(getattr(prepared.evolution, "evaluations", prepared.evolution.steps)),
    )  # fmt: skip


def _compile(scene: Scene) -> None:
    """Take a few steps of a particle scene, once for whatever compiles by itself."""
    if scene.model != "sph":
        return
    needed: set[Any] = set(experience.programs(scene))
    if scene.numerics.engine == "xla":
        needed.add(("particles", scene.particles))
    if "gravity" in scene.effects and gravity_method(scene, scene.particles or 0) == "multipole":
        needed.add(("force_error", scene.effects["gravity"]["force_error"]))  # which sets the order of expansions
    if needed <= _warm:
        return
    prepared = prepare(scene)
    opening = prepared.evolution.record(None)["potential_energy"]
    for _ in range(_WARM_UP_STEPS):
        prepared.evolution.advance(prepared.outputs.end)
    prepared.evolution.record(opening)
    _warm.update(needed)


def _rehearse(body: Any, end: float) -> None:
    """Go to the end and back to the start, so that all is compiled."""
    start = body.arrays()
    with suppress(NumericalError):  # the run itself will say so
        while body.time < end:
            body.advance(end)
    body.resume(start)


def _without_records(scene: Scene) -> tuple[str, ...]:
    end = scene.time_setting(scene.time.end)
    steps = () if scene.output.series_steps is None else ("output.series_steps=1000000000",)
    return (f"output.snapshot_every={end}", *(steps or (f"output.series_every={end}",)))


AS_IT_IS = Setting("default", "", ())
"""A scene without any override."""
