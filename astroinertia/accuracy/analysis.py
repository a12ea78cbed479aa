"""What a table of runs says: errors, whose they are, their orders, and what is worth its cost.

Sources of error are separated by differences: two runs that differ in one knob differ by that knob's error alone,
whatever else errs in both. Tests: tests/unit/accuracy/test_tradeoff.py.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from astroinertia.accuracy import convergence, frontier
from astroinertia.accuracy.convergence import NONE, PowerLaw
from astroinertia.accuracy.exact import Exact
from astroinertia.accuracy.knobs import MODEL, Knob, Setting, Value
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.selected_observables import SelectedObservable, relative_error
from astroinertia.scene.schema import Scene

_ABOVE = 3.0  # times the floor, from which an error tells the order of one source
_STEEPER = 1.5  # times theory's order, beyond which two errors tell none: one of them is near where its sign changes
_SATURATED = 0.3  # a relative error beyond which no power law holds
_ROUND_OFF = 1e-15  # of an observable's size: differences below it are rounding


@dataclass
class Table:
    """What a tradeoff found: settings that were run with what they gave, and those that the budget left out.

    base: the setting around which single knobs are turned, the scene itself unless that is too expensive. left:
    settings that were not run, with the seconds that they would take.
    """

    scene: Scene
    knobs: tuple[Knob, ...]
    observables: tuple[SelectedObservable, ...]
    base: Setting
    exact: Exact | None
    folder: Path
    measured: dict[Setting, Measured] = field(default_factory=dict)
    left: dict[Setting, float] = field(default_factory=dict)
    interrupted: bool = False


@dataclass(frozen=True)
class Reference:
    """What an observable is measured against: values (K,), how they were come by, their own relative error.

    setting is the run that they are where nothing better is known: its own error is then unknown.
    """

    values: np.ndarray
    source: str
    accuracy: float
    setting: Setting | None = None


@dataclass(frozen=True)
class Source:
    """One knob as a source of error of one observable, at the base.

    error: what the knob contributes at the base; law: its power law; cost_order: cost ~ step^-cost_order. Of a choice,
    which has no step, error is the largest change that another choice makes, and there is no law; of another method it
    is NaN, for that has no part in the base. changes: by how much the observable differs from the base, by value.
    """

    knob: Knob
    error: float
    law: PowerLaw
    cost_order: float
    changes: Mapping[Value, float] = field(default_factory=dict)

    def at(self, value: Value) -> float:
        """The knob's error at a value: by its law, or where it has none by what was measured; NaN for neither."""
        if self.law.credible and self.knob.step is not None:
            return self.law.at(self.knob.step(value))
        return self.error if value == self.knob.default else self.error + self.changes.get(value, float("nan"))


@dataclass(frozen=True)
class Judged:
    """One observable: its reference, the error of each setting, sources of error, and the scene's own model's front."""

    observable: SelectedObservable
    reference: Reference | None
    errors: dict[Setting, float]
    sources: tuple[Source, ...]
    front: tuple[Setting, ...]
    knee: Setting | None

    @property
    def limiting(self) -> Source | None:
        """The source of error that is largest at the base, of those that can be refined."""
        refinable = [source for source in self.sources if source.knob.step is not None and np.isfinite(source.error)]
        return max(refinable, key=lambda source: source.error, default=None)


@dataclass(frozen=True)
class Analysis:
    """All observables of a table, in their order."""

    judged: tuple[Judged, ...]

    def main_error(self, value: Value) -> float:
        """The largest error, over the observables, that the first knob leaves at a value; NaN where it has no law."""
        errors = [error for judged in self.judged if np.isfinite(error := judged.sources[0].at(value))]
        return max(errors, default=float("nan"))

    def coarsest(self, knob: Knob, allowed: float) -> Value | None:
        """The coarsest value of a knob whose error in every observable is allowed; None where there is none to tell."""
        if knob.step is None or knob.alternative:
            return None
        sources = [source for judged in self.judged for source in judged.sources if source.knob == knob]
        good = []
        for value in knob.values:
            errors = [source.at(value) for source in sources]
            if errors and all(error <= allowed for error in errors):
                good.append(value)
        return max(good, key=knob.step, default=None)


def analysed(table: Table) -> Analysis:
    """Everything that the table says so far.

    >>> from pathlib import Path
    >>> from astroinertia.accuracy.tradeoff import carry_out
    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> table = carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print([f"{source.knob.name} {source.law.order:.0f}" for source in analysed(table).judged[0].sources])
    ['steps_per_rotation 8']
    """

    def values(setting: Setting, observable: SelectedObservable) -> np.ndarray | None:
        run = table.measured.get(setting)
        if run is None or run.failure:
            return None
        return np.asarray(run.values[observable.name], dtype=float)

    return Analysis(tuple(_judged(table, observable, values) for observable in table.observables))


def reference_of(answer: Exact | None, observable: SelectedObservable) -> Reference | None:
    """The exact value of an observable, if the exact answer has it."""
    if answer is None:
        return None
    variable = f"frequency of {observable.variable}" if observable.of_series else observable.variable
    values = answer.values.get(variable)
    if values is None:
        return None
    values = np.asarray(values, dtype=float)
    for label in () if observable.of_series else observable.labels:
        values = values[int(label) - 1 if label.isdecimal() else "xyz".index(label)]
    return Reference(np.atleast_1d(values).ravel(), answer.source, answer.accuracy)


def _judged(table: Table, observable: SelectedObservable, values: Callable) -> Judged:
    main = table.knobs[0]
    results = {setting: result for setting in table.measured if (result := values(setting, observable)) is not None}
    reference = reference_of(table.exact, observable) or _finest(main, results)
    errors: dict[Setting, float] = {}
    if reference is not None:
        errors = {setting: relative_error(result, reference.values) for setting, result in results.items()}
        if reference.setting is not None:
            errors[reference.setting] = float("nan")
    size = float(np.linalg.norm(reference.values)) if reference is not None else 0.0
    floor = _ROUND_OFF if reference is None else max(_ROUND_OFF, reference.accuracy)
    others = [
        _other_method(table, knob, results, errors, size, floor)
        if knob.alternative
        else _source(table, knob, results, size)
        for knob in table.knobs[1:]
    ]
    among = [source.error for source in others if source.knob.step is not None and np.isfinite(source.error)]
    first = _main_source(table, main, results, errors, size, max([floor, *among]))
    # Other rungs of the ladder of models are judged apart: they may be exact, and then nothing else is worth it.
    ranked = [setting for setting in errors if setting.knob != MODEL]
    cost = np.array([table.measured[setting].cpu_time for setting in ranked])
    bounded = np.array([max(errors[setting], floor) for setting in ranked])  # nothing is known below the floor
    front = [ranked[number] for number in np.flatnonzero(frontier.pareto(cost, bounded))]
    number = frontier.knee(cost, bounded)
    front.sort(key=lambda setting: table.measured[setting].cpu_time)
    return Judged(
        observable, reference, errors, (first, *others), tuple(front), None if number is None else ranked[number]
    )


def _finest(main: Knob, results: dict[Setting, np.ndarray]) -> Reference | None:
    """The finest run along the first knob, extrapolated where three of them converge as they should."""
    ladder = [setting for setting in results if setting.knob == main.name]
    if main.step is None or not ladder:
        return None
    steps = np.array([main.step(setting.value) for setting in ladder])
    values = np.stack([results[setting] for setting in ladder])
    best = int(np.argmin(steps))
    if len(ladder) > 2 and main.order is not None:
        limit = convergence.extrapolated(steps, values, main.order)
        if limit is not None:
            left = relative_error(values[best], limit)
            description = (
                f"extrapolation of the finest runs by Richardson along {main.name}, with the order {main.order:g}"
            )
            return Reference(limit, description, 0.3 * left)
    description = f"finest run, {ladder[best].label}"
    second = (
        relative_error(np.delete(values, best, 0)[np.argmin(np.delete(steps, best))], values[best])
        if len(ladder) > 1
        else np.nan
    )
    return Reference(values[best], description, second / 3.0, ladder[best])


def _sweep(table: Table, knob: Knob, results: dict[Setting, np.ndarray]) -> dict[Value, tuple[Setting, np.ndarray]]:
    """What was run along a knob, by its value; the base stands at the knob's default."""
    sweep = {setting.value: (setting, result) for setting, result in results.items() if setting.knob == knob.name}
    if knob is not table.knobs[0] and not knob.alternative and table.base in results:
        sweep[knob.default] = (table.base, results[table.base])
    return sweep


def _source(table: Table, knob: Knob, results: dict[Setting, np.ndarray], size: float) -> Source:
    sweep = _sweep(table, knob, results)
    if knob.default not in sweep or len(sweep) < 2 or not size > 0.0:
        return Source(knob, float("nan"), NONE, float("nan"))
    at_base = sweep[knob.default][1]
    apart = {value: float(np.linalg.norm(result - at_base)) / size for value, (_, result) in sweep.items()}
    if knob.step is None:
        return Source(knob, max(apart.values()), NONE, float("nan"))
    steps = np.array([knob.step(value) for value in sweep])
    law = convergence.self_convergence(steps, np.stack([result for _, result in sweep.values()]), size, _ROUND_OFF)
    others = {value: knob.step(value) for value in sweep if value != knob.default}
    if law.points and not law.credible:
        error = max(apart.values())  # scatter, which no step makes smaller: it is as large as it is seen to be
    else:
        # The difference from the finest of the others, less what that errs itself or the default errs beyond it.
        finest = min(others, key=lambda value: others[value])
        ratio = (others[finest] / knob.step(knob.default)) ** (law.order if law.points else knob.order or 1.0)
        error = apart[finest] / max(abs(1.0 - ratio), 0.1)
    seconds = _cost_order(table, steps, [setting for setting, _ in sweep.values()])
    return Source(knob, error, law, seconds, apart)


def _main_source(
    table: Table, main: Knob, results: dict[Setting, np.ndarray], errors: dict[Setting, float], size: float,
    floor: float,
) -> Source:  # fmt: skip
    """The first knob: by its errors where these stand above all else that errs, else by its own differences."""
    source = _other_method(table, main, results, errors, size, floor)
    error = errors.get(table.base, float("nan"))
    if not error > _ABOVE * floor and source.law.credible and main.step is not None:
        error = max(source.law.at(main.step(table.base.value)), _ROUND_OFF)
    return replace(source, error=error)


def _other_method(
    table: Table, knob: Knob, results: dict[Setting, np.ndarray], errors: dict[Setting, float], size: float,
    floor: float,
) -> Source:  # fmt: skip
    sweep = _sweep(table, knob, results)
    if knob.step is None or not sweep:
        return Source(knob, float("nan"), NONE, float("nan"))
    steps = np.array([knob.step(value) for value in sweep])
    ladder = [setting for setting, _ in sweep.values()]
    ladder_errors = np.array([errors.get(setting, np.nan) for setting in ladder])
    ladder_errors = np.where(ladder_errors < _SATURATED, ladder_errors, np.nan)
    if knob.order is not None:
        ladder_errors = np.where(convergence.converging(steps, ladder_errors, knob.order), ladder_errors, np.nan)
    law = convergence.power_law(steps, ladder_errors, _ABOVE * floor)
    by_chance = law.points == 2 and knob.order is not None and law.order > _STEEPER * knob.order
    if not law.credible or by_chance:
        law = convergence.self_convergence(steps, np.stack([result for _, result in sweep.values()]), size, _ROUND_OFF)
    return Source(knob, float("nan"), law, _cost_order(table, steps, ladder))


def _cost_order(table: Table, steps: np.ndarray, settings: list[Setting]) -> float:
    seconds = np.array([table.measured[setting].cpu_time for setting in settings])
    return -convergence.power_law(steps, seconds).order
