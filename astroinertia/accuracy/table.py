"""The table of a tradeoff as an xarray Dataset that explains itself, as a netCDF file, and in words.

Tests: tests/unit/accuracy/test_tradeoff.py.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.accuracy.analysis import Analysis, Judged, Source, Table, analysed
from astroinertia.accuracy.knobs import MODEL, Setting, shown
from astroinertia.accuracy.measuring import MEMORY_MENTIONED
from astroinertia.costs.machine import described
from astroinertia.dataset.schema import CONVENTIONS
from astroinertia.errors import ArchiveError
from astroinertia.process import interrupts
from astroinertia.process.words import duration
from astroinertia.storage.atomic import write_netcdf

FILE = "tradeoff.nc"
FORMAT = 1


def dataset(table: Table) -> xr.Dataset:
    """Everything that was run and found, along the dimensions setting, observable, knob and component (SI).

    >>> from astroinertia.accuracy.tradeoff import carry_out
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> table = carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print(dict(dataset(table).error.sizes))
    {'setting': 6, 'observable': 2}
    """
    analysis = analysed(table)
    settings = list(table.measured)
    names = [observable.name for observable in table.observables]
    variables = _of_runs(table, settings) | _of_errors(analysis, settings) | _of_knobs(table, analysis)
    variables |= _values(table, analysis, settings)
    coords = {
        "setting": ("setting", np.array([setting.label for setting in settings], dtype=object),
                    {"long_name": "setting"}),
        "observable": ("observable", np.array(names, dtype=object), {"long_name": "observable"}),
        "knob": ("knob", np.array([knob.name for knob in table.knobs], dtype=object), {"long_name": "accuracy knob"}),
    }  # fmt: skip
    left = {setting.label: float(f"{seconds:.3g}") for setting, seconds in table.left.items()}
    attrs = {
        "Conventions": CONVENTIONS,
        "title": f"{table.scene.name}: what accuracy costs",
        "source": f"astroinertia, model {table.scene.model}",
        "astroinertia_tradeoff_format": FORMAT,
        "name": table.scene.name,
        "scene": table.scene.to_toml(),
        "base": table.base.label,
        "left_out": json.dumps(left),
        "left_out_comment": "settings that did not fit into the budget, with the seconds that they would take",
        "interrupted": int(table.interrupted),
        "machine": machine(),
        "conclusions": "\n".join(conclusions(table, analysis)),
        "outputs_comment": "runs were recorded at their start and end alone, unless a series was asked for",
    }
    return xr.Dataset(variables, coords=coords, attrs=attrs)


def _of_runs(table: Table, settings: list[Setting]) -> dict[str, Any]:
    """What each setting is, and what its run took."""
    runs = [table.measured[setting] for setting in settings]

    def of_runs(name: str, unit: str, text: str, comment: str = "") -> tuple[str, list[Any], dict[str, str]]:
        attrs = {"units": unit, "long_name": text} | ({"comment": comment} if comment else {})
        return "setting", [getattr(run, name) for run in runs], attrs

    def words(values: list[str], text: str) -> tuple[str, np.ndarray, dict[str, str]]:
        return "setting", np.array(values, dtype=object), {"long_name": text}

    return {
        "knob_turned": words([setting.knob for setting in settings], "knob that differs from the base"),
        "value": words([shown(setting.value) for setting in settings], "its value"),
        "overrides": words(["; ".join(setting.overrides) for setting in settings], "what --set it is run with"),
        "failure": words([run.failure for run in runs], "why the run failed; empty where it did not"),
        "step_size": ("setting", [_step(table, setting) for setting in settings],
                      {"units": "1", "long_name": "what the error is a power of, in the units of its knob"}),
        "is_base": ("setting", np.array([setting == table.base for setting in settings], dtype=np.int8),
                    {"units": "1", "long_name": "1 for the setting that single knobs are turned around"}),
        "cpu_time": of_runs("cpu_time", "s", "processor time of the steps, all threads", "on compiled code"),
        "step_time": of_runs("step_time", "s", "wall time of the steps", "on compiled code"),
        "wall_time": of_runs("wall_time", "s", "wall time from preparing the body to the finished file"),
        "preparation_time": of_runs("preparation_time", "s", "wall time of preparing the body",
                                    "what was placed or settled before is taken from the cache"),
        "peak_memory": of_runs("peak_memory", "byte", "peak memory", MEMORY_MENTIONED),
        "steps": of_runs("steps", "1", "number of time steps"),
    }  # fmt: skip


def _of_errors(analysis: Analysis, settings: list[Setting]) -> dict[str, Any]:
    """How exact each observable is with each setting, against what, and which settings are worth their cost."""
    of_both, shape = ("setting", "observable"), (len(settings), len(analysis.judged))
    errors = [[judged.errors.get(setting, math.nan) for judged in analysis.judged] for setting in settings]
    front = [[setting in judged.front for judged in analysis.judged] for setting in settings]
    knee = [[setting == judged.knee for judged in analysis.judged] for setting in settings]
    return {
        "error": (of_both, np.array(errors).reshape(shape), {
            "units": "1", "long_name": "relative error at the end of the run",
            "comment": "|value - reference|/|reference| over all components of the observable"}),
        "pareto": (of_both, np.array(front, dtype=np.int8).reshape(shape), {
            "units": "1", "long_name": "1 where no cheaper setting of the scene's model is as exact",
            "comment": "cost is cpu_time"}),
        "knee": (of_both, np.array(knee, dtype=np.int8).reshape(shape), {
            "units": "1", "long_name": "1 at the knee of the front",
            "comment": "farthest below the line between its ends, in logarithms (Satopaa et al. 2011)"}),
        "reference_accuracy": ("observable", [_accuracy(judged) for judged in analysis.judged], {
            "units": "1", "long_name": "relative error of the reference itself"}),
        "reference": ("observable", np.array([_source(judged) for judged in analysis.judged], dtype=object), {
            "long_name": "what the error is measured against"}),
    }  # fmt: skip


def _of_knobs(table: Table, analysis: Analysis) -> dict[str, Any]:
    """What each knob contributes to the error of each observable, and by which powers."""
    of_knobs = ("knob", "observable")
    return {
        "knob_error": (of_knobs, _of_sources(analysis, lambda source: source.error), {
            "units": "1", "long_name": "relative error that a knob contributes at the base",
            "comment": "from runs that differ in it alone; of a choice, the largest change that another one makes"}),
        "order": (of_knobs, _of_sources(analysis, lambda source: source.law.order), {
            "units": "1", "long_name": "fitted order of the error in the step size of a knob"}),
        "order_uncertainty": (of_knobs, _of_sources(analysis, lambda source: source.law.uncertainty), {
            "units": "1", "long_name": "its standard error", "comment": "NaN where two points fix the order"}),
        "order_points": (of_knobs, _of_sources(analysis, lambda source: source.law.points), {
            "units": "1", "long_name": "number of runs that the order is fitted to"}),
        "cost_order": (of_knobs, _of_sources(analysis, lambda source: source.cost_order), {
            "units": "1", "long_name": "fitted power of 1/step size that processor time grows as"}),
        "expected_order": ("knob", [math.nan if knob.order is None else knob.order for knob in table.knobs], {
            "units": "1", "long_name": "order by theory"}),
        "knob_is_alternative": ("knob", np.array([knob.alternative for knob in table.knobs], dtype=np.int8), {
            "units": "1", "long_name": "1 for a knob of another method, which takes the place of the base's"}),
        "knob_source": ("knob", np.array([knob.source for knob in table.knobs], dtype=object), {
            "long_name": "where the order by theory is from"}),
    }  # fmt: skip


def write(table: Table) -> Path:
    """Write the table into its folder, whole or not at all, and return the file.

    >>> from astroinertia.accuracy.tradeoff import carry_out
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> table = carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print(write(table).name)
    tradeoff.nc
    """
    path = table.folder / FILE
    with interrupts.held():
        write_netcdf(path, dataset(table))
    return path


def read(path: Path) -> xr.Dataset:
    """The table in a folder or file; ArchiveError where there is none.

    >>> from astroinertia.accuracy.tradeoff import carry_out
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> table = carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print(read(write(table)).attrs["name"])
    tennis_racket
    """
    file = path / FILE if path.is_dir() else path
    try:
        table = xr.load_dataset(file, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise ArchiveError(f"{file} holds no table of a tradeoff: {error}.") from error
    if "astroinertia_tradeoff_format" not in table.attrs:
        raise ArchiveError(f"{file} is a netCDF file, but not the table of a tradeoff.")
    return table


def conclusions(table: Table, analysis: Analysis | None = None) -> list[str]:
    """What the table says, a sentence a line.

    >>> from astroinertia.accuracy.tradeoff import carry_out
    >>> scene = load.load_file("sims/tennis_racket.toml", ["time.end='1 s'"])
    >>> table = carry_out(scene, Path("runs/tradeoff"), minutes=1.0, only=["steps_per_rotation"])
    >>> print(conclusions(table)[0].split(":")[0])
    angular_velocity
    """
    analysis = analysed(table) if analysis is None else analysis
    lines = []
    for judged in analysis.judged:
        lines += [
            _conclusion(table, judged),
            *filter(None, (_whose(judged), _next_digit(table, judged), _advice(table, judged))),
            *_rungs(table, judged),
        ]
    failed = [setting for setting, run in table.measured.items() if run.failure]
    lines += [f"{setting.label} failed: {table.measured[setting].failure}" for setting in failed]
    if table.left:
        cheapest = min(table.left, key=lambda setting: table.left[setting])
        lines.append(
            f"{len(table.left)} settings did not fit into the budget; the next, {cheapest.label}, would take "
            f"{duration(table.left[cheapest])}"
        )
    return lines


def machine() -> str:
    """The machine in words.

    >>> print("Python" in machine())
    True
    """
    description = described()
    return f"{description['processor']}, {description['cores']} cores, Python {description['python']}"


def _conclusion(table: Table, judged: Judged) -> str:
    name = judged.observable.name
    if judged.reference is None:
        return f"{name}: no run to measure against"
    error, accuracy = judged.errors.get(table.base, math.nan), judged.reference.accuracy
    took = table.measured[table.base].cpu_time if table.base in table.measured else math.nan
    size = f"{error:.1e}" if math.isfinite(error) else "unknown"
    size = f"below {accuracy:.1e}, the accuracy of the reference," if error < accuracy else size
    return f"{name}: error {size} at {table.base.label}, in {duration(took)}, against the {judged.reference.source}"


def _whose(judged: Judged) -> str:
    limiting = judged.limiting
    if limiting is None:
        return ""
    rest = [
        f"{source.knob.name.replace('_', ' ')} {source.error:.1e}{f', {_order(source)}' if source.law.points else ''}"
        for source in sorted(judged.sources, key=lambda source: -np.nan_to_num(source.error))
        if source is not limiting and math.isfinite(source.error) and source.knob.step is not None
    ]
    order = "" if not limiting.law.points else f", {_order(limiting)}"
    first = f"  limited by the {limiting.knob.name.replace('_', ' ')}: {limiting.error:.1e}{order}"
    return "; ".join([first, *rest])


def _order(source: Source) -> str:
    law = source.law
    if not law.credible:
        return "no order: scatter"
    text = f"order {law.order:.2f}"
    text += f" +- {law.uncertainty:.2f}" if math.isfinite(law.uncertainty) else ""
    return f"{text} (theory {source.knob.order:g})" if source.knob.order is not None else text


def _next_digit(table: Table, judged: Judged) -> str:
    limiting = judged.limiting
    if limiting is None or not limiting.law.credible or not limiting.cost_order > 0:
        return ""
    knob = limiting.knob
    assert knob.step is not None  # what limits has a step
    is_main = knob is table.knobs[0]
    now = knob.step(table.base.value if is_main else knob.default)
    shorter = 10.0 ** (-1.0 / limiting.law.order)  # error ~ step^order, cost ~ step^-cost_order
    value, factor = knob.value_at(now * shorter), shorter**-limiting.cost_order
    took = table.measured[table.base].cpu_time if table.base in table.measured else math.nan
    return (
        f"  the next digit costs {factor:.2g} times: {knob.name.replace('_', ' ')} {value:.2g}, "
        f"{duration(factor * took)}"
    )


def _advice(table: Table, judged: Judged) -> str:
    if judged.knee is None:
        return ""
    run = table.measured[judged.knee]
    return f"  knee: {judged.knee.label}, error {judged.errors[judged.knee]:.1e} in {duration(run.cpu_time)}"


def _rungs(table: Table, judged: Judged) -> list[str]:
    """What other models of the ladder give and take."""
    accuracy = _accuracy(judged)
    rungs = [setting for setting in judged.errors if setting.knob == MODEL]
    return [
        f"  {setting.label}: error {'below ' if judged.errors[setting] < accuracy else ''}"
        f"{max(judged.errors[setting], accuracy):.1e} in {duration(table.measured[setting].cpu_time)}"
        for setting in rungs
    ]


def _of_sources(analysis: Analysis, part: Any) -> np.ndarray:
    return np.array([[float(part(source)) for source in judged.sources] for judged in analysis.judged]).T


def _accuracy(judged: Judged) -> float:
    return math.nan if judged.reference is None else judged.reference.accuracy


def _source(judged: Judged) -> str:
    return "" if judged.reference is None else judged.reference.source


def _step(table: Table, setting: Setting) -> float:
    knob = next((knob for knob in table.knobs if knob.name == setting.knob), None)
    return math.nan if knob is None or knob.step is None else knob.step(setting.value)


def _values(table: Table, analysis: Analysis, settings: list[Setting]) -> dict[str, Any]:
    """The numbers themselves, along a dimension of all components of all observables."""
    columns, labels, reference = [], [], []
    for judged in analysis.judged:
        name = judged.observable.name
        rows = [table.measured[setting].values[name] for setting in settings]
        count = max((len(row) for row in rows), default=1)
        block = np.full((len(settings), count), np.nan)
        for number, row in enumerate(rows):
            block[number, : len(row)] = row
        columns.append(block)
        named = (table.measured[setting].components.get(name) for setting in settings)
        labels += next((names for names in named if names), [name])
        reference += [math.nan] * count if judged.reference is None else list(judged.reference.values)
    attributes = {"long_name": "component of an observable"}
    return {
        "result": (("setting", "component"), np.concatenate(columns, axis=1), {
            "long_name": "what the run gave", "comment": "SI, or code units where the scene is dimensionless"}),
        "reference_result": ("component", reference, {"long_name": "what it is measured against"}),
        "component": ("component", np.array(labels, dtype=object), attributes),
    }  # fmt: skip
