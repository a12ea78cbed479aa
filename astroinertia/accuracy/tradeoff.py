"""A scene over its accuracy knobs: what is run, in which order, within a budget, and what is found.

First the ladder of the knob that sets the resolution, from its coarsest value; then every other knob by itself around
the base; then some settings along the balanced line, where no source of error is smaller than it need be. The cheapest
comes first. Tests: tests/unit/accuracy/test_tradeoff.py, tests/physics/test_tradeoff_orders.py.
"""

import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from astroinertia.accuracy import knobs, measuring
from astroinertia.accuracy.analysis import Table, analysed
from astroinertia.accuracy.exact import Exact, exact
from astroinertia.accuracy.knobs import BALANCED, Knob, Setting, Value
from astroinertia.accuracy.selected_observables import SelectedObservable, default_names, parsed
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.scene.schema import Scene
from astroinertia.storage.atomic import made_folder, read_json, write_json
from astroinertia.storage.cache import content_key

DEFAULT_MINUTES = 5.0
_EXACT = "exact.json"
_SHARE_OF_BASE = 1 / 20  # of the budget, that one run of the base may take: it is repeated for every value of a knob
_SHARE_OF_OTHERS = 0.3  # of the main knob's error, that each other source may have on the balanced line

Listener = Callable[["Standing"], None]


@dataclass(frozen=True)
class Standing:
    """How far a tradeoff is: settings done and in all, seconds spent of so many, and what is run now."""

    done: int
    settings: int
    spent: float
    budget: float
    now: str


def carry_out(
    scene: Scene,
    folder: Path,
    minutes: float = DEFAULT_MINUTES,
    observables: Sequence[str] = (),
    only: Sequence[str] = (),
    listener: Listener | None = None,
) -> Table:
    """Run a scene over its knobs below `folder`, as many settings as fit into so many minutes of wall time.

    only: names of knobs, all without; the first, which sets the resolution, is always among them. What was run before
    in the folder is taken as it is and costs nothing. After a signal in a run the table holds what is done, and says
    that it was interrupted. SceneError for a scene without knobs, an unknown knob or observable.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> table = carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print(len(table.measured), table.exact.source.split(",")[0])
    6 free top in closed form
    """
    all_knobs = knobs.knobs(scene)
    if not all_knobs:
        raise SceneError(f"the model {scene.model} has no accuracy knobs: its answers are closed forms.")
    chosen_observables = tuple(parsed(name, scene.observables) for name in (observables or default_names(scene)))
    chosen = _chosen(all_knobs, only)
    study = _Study(scene, chosen, chosen_observables, folder, 60.0 * minutes, listener)
    made_folder(folder)
    try:
        study.run()
    except RunInterrupted:
        study.table.interrupted = True
    return study.table


class _Study:
    """One tradeoff under way."""

    def __init__(
        self, scene: Scene, chosen_knobs: tuple[Knob, ...], observables: tuple[SelectedObservable, ...], folder: Path,
        seconds: float, listener: Listener | None,
    ) -> None:  # fmt: skip
        self.seconds, self.listener, self.spent = seconds, listener, 0.0
        self.table = Table(scene, chosen_knobs, observables, measuring.AS_IT_IS, None, folder)
        self.waiting: dict[Setting, tuple[Scene, Path]] = {}

    def run(self) -> None:
        table = self.table
        begin = clock.monotonic()
        table.exact = stored_exact(table.scene, table.folder)
        self.spent += clock.monotonic() - begin
        main = table.knobs[0]
        # The ladder up to the default: its cost says which base the budget allows.
        ladder = [_alone(main, value) for value in main.values]
        self._spend_on(ladder[: 1 + ladder.index(_alone(main, main.default))])
        table.base = self._affordable_base(main)
        self._spend_on([*ladder, *self._single_knobs(main)])
        self._spend_on(self._balanced(main))
        table.left = self._predictions()

    def _spend_on(self, settings: Sequence[Setting]) -> None:
        """Take up settings that were run before; run the others, and those that wait, while the cheapest fits."""
        table = self.table
        for setting in settings:
            if setting in table.measured or setting in self.waiting:
                continue
            try:
                scene = measuring.scene_of(table.scene, setting, table.observables)
            except SceneError as error:
                # Knobs that contradict each other, such as an engine that has no individual steps.
                table.measured[setting] = measuring.failed(str(error), table.observables)
                continue
            place = measuring.folder_of(table.folder, scene, setting)
            if (done := measuring.stored(place, table.observables)) is not None:
                table.measured[setting] = done
            else:
                self.waiting[setting] = scene, place
        while self.waiting:
            seconds = self._predictions()
            cheapest = min(seconds, key=lambda setting: seconds[setting])
            if seconds[cheapest] > self.seconds - self.spent:
                return
            self._measure(cheapest)

    def _measure(self, setting: Setting) -> None:
        table = self.table
        scene, place = self.waiting.pop(setting)
        if self.listener is not None:
            total = len(table.measured) + 1 + len(self.waiting)
            self.listener(Standing(len(table.measured), total, self.spent, self.seconds, setting.label))
        begin = clock.monotonic()
        table.measured[setting] = measuring.measure(scene, table.observables, place)
        self.spent += clock.monotonic() - begin

    def _predictions(self) -> dict[Setting, float]:
        """Seconds that each setting which waits will take."""
        table, main = self.table, self.table.knobs[0]
        by_name = {knob.name: knob for knob in table.knobs}
        taken = {(setting.knob, setting.value): run.wall_time for setting, run in table.measured.items()}
        at_base = table.measured.get(table.base)
        base = float("nan") if at_base is None else at_base.wall_time

        def seconds(setting: Setting) -> float:
            if setting.knob != BALANCED:
                return predicted(setting, by_name[setting.knob], base, taken)
            share = 1.0
            for name, value in setting.chosen.items():
                if name != main.name:
                    share *= by_name[name].cost(value) / by_name[name].cost(by_name[name].default)
            return share * predicted(_alone(main, setting.chosen[main.name]), main, base, taken)

        return {setting: seconds(setting) for setting in self.waiting}

    def _affordable_base(self, main: Knob) -> Setting:
        """The finest setting up to the default whose run takes no more than its share of the budget."""
        run = [
            (setting, measured)
            for setting, measured in self.table.measured.items()
            if setting.knob == main.name and not measured.failure
        ]
        if not run:
            return _alone(main, main.default)
        cheap = [setting for setting, measured in run if measured.wall_time <= _SHARE_OF_BASE * self.seconds]
        return max(cheap or [run[0][0]], key=lambda setting: main.values.index(setting.value))

    def _single_knobs(self, main: Knob) -> list[Setting]:
        base = self.table.base
        return [
            Setting(knob.name, value, (*base.overrides, *knob.overrides(value)), {main.name: base.value})
            for knob in self.table.knobs[1:]
            for value in knob.values
            if value != knob.default or knob.alternative
        ]

    def _balanced(self, main: Knob) -> list[Setting]:
        """For each value of the main knob, all others as coarse as keeps them below their share of its error."""
        analysis, settings = analysed(self.table), []
        run_before = {setting.overrides for setting in self.table.measured}
        for value in main.values:
            error = analysis.main_error(value)
            if not np.isfinite(error):
                continue
            overrides, turned = main.overrides(value), {}
            for knob in self.table.knobs[1:]:
                best = analysis.coarsest(knob, _SHARE_OF_OTHERS * error)
                if best is not None and best != knob.default:
                    overrides, turned[knob.name] = (*overrides, *knob.overrides(best)), best
            if not turned or overrides in run_before:
                continue
            words = ", ".join(f"{name.replace('_', ' ')} {knobs.shown(coarse)}" for name, coarse in turned.items())
            label = f"{main.name} {knobs.shown(value)}, {words}"
            settings.append(Setting(BALANCED, label, overrides, {main.name: value, **turned}))
        return settings


def _alone(knob: Knob, value: knobs.Value) -> Setting:
    return Setting(knob.name, value, knob.overrides(value), {knob.name: value})


def _chosen(all_knobs: tuple[Knob, ...], only: Sequence[str]) -> tuple[Knob, ...]:
    names = [knob.name for knob in all_knobs]
    for name in only:
        if name not in names:
            raise SceneError(f"there is no knob '{name}'; this scene has {', '.join(names)}.")
    return tuple(knob for knob in all_knobs if not only or knob.name in (*only, names[0]))


def stored_exact(scene: Scene, folder: Path) -> Exact | None:
    """The exact answer, kept in the folder, for some take a while to find."""
    path, key = folder / _EXACT, content_key(scene=scene.to_toml())
    try:
        stored = read_json(path)
        if stored["scene"] == key:
            if stored["values"] is None:
                return None
            values = {name: np.array(value) for name, value in stored["values"].items()}
            return Exact(values, stored["source"], stored["accuracy"])
    except (OSError, ArchiveError, ValueError, KeyError, TypeError, AttributeError):
        pass  # another made the folder, or it is damaged: computed again
    answer = exact(scene)
    if answer is None:
        write_json(path, {"scene": key, "values": None})
    else:
        values = {name: np.asarray(value).tolist() for name, value in answer.values.items()}
        write_json(path, {**asdict(answer), "scene": key, "values": values})
    return answer


_UNKNOWN = 1.0  # s, of a setting before any other was run
_LEAST = 1e-3  # s, that every setting takes


def predicted(setting: Setting, knob: Knob, base: float, taken: Mapping[tuple[str, Value], float]) -> float:
    """Seconds that a setting will take.

    taken: seconds by (knob, value) of what was run; base: those of the base, NaN before it was run. Along a knob whose
    two most expensive settings are known their power law goes on; else the knob's own guess is scaled.
    """
    timed = [(knob.cost(value), taken[knob.name, value]) for value in knob.values if (knob.name, value) in taken]
    timed = sorted((guess, seconds) for guess, seconds in timed if math.isfinite(seconds))
    wanted = knob.cost(setting.value)
    if not timed:
        return max(_LEAST, base * wanted / knob.cost(knob.default)) if math.isfinite(base) else _UNKNOWN
    guess, seconds = (
        timed[-1] if wanted >= timed[-1][0] else min(timed, key=lambda pair: abs(math.log(pair[0] / wanted)))
    )
    growth = 1.0
    if len(timed) > 1 and timed[-1][0] > timed[0][0] and wanted > timed[-1][0]:
        (first, low), (last, high) = timed[-2], timed[-1]
        growth = math.log(max(high, _LEAST) / max(low, _LEAST)) / math.log(last / first) if last > first else 1.0
    return max(_LEAST, seconds * (wanted / guess) ** min(max(growth, 0.0), 2.0))
