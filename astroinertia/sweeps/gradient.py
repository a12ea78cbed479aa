"""Derivatives of a run by keys of its scene, from one pass along the run a key: forward-mode differentiation.

The body is built at the scene's value of a key and at four values near it, which is cheap; the differences of these
(engines.variational) are the derivative of the first state and of the numbers of the equations by the logarithm of
the key, whatever the key is. The linearised equations, differentiated by JAX, carry that through the run, and members
beside the run by the same small steps are recorded as runs are: sweeps.sensitivity reads the derivative of every series
off them. A scaling law, in closed form, needs no linearisation: its members are followed themselves. Tests:
tests/unit/sweeps/test_gradient.py.
"""

import importlib
import math
import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from astroinertia import dataset
from astroinertia.accuracy.selected_observables import SelectedObservable, parsed, selected
from astroinertia.build.assemble import Prepared, metadata, model_description, prepare
from astroinertia.engines.variational import SIDES
from astroinertia.errors import NumericalError, SceneError
from astroinertia.models.protocol import SAME_TIME
from astroinertia.observables.own import recorded
from astroinertia.run.branch import moment
from astroinertia.run.loop import computing, in_si
from astroinertia.scene import source
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from astroinertia.scene.sweep_values import coordinate, number_and_unit
from astroinertia.storage.outputs import stacked
from astroinertia.sweeps.combined import variable_name
from astroinertia.sweeps.sensitivity import sensitivity, sensitivity_sweep, value_of
from astroinertia.units import shown, unit_of

NEAR = 1e-4  # relative step of the members beside a run
_JUMP = 1e-5  # error of the first derivatives, over their size and that of what they are of: of order NEAR^2 if smooth
_HOW = ("time", "output", "numerics", "accuracy")  # what says how a body is followed, not what it is
_SERIES = re.compile(r"(\w+)\.(\w+)")


def gradient(scene: Scene, of: str, by: Sequence[str]) -> xr.Dataset:
    """The derivatives of a number of a run by keys of its scene, as astroinertia.gradient says.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/core_to_pulsar_scaling.toml")
    >>> answer = gradient(scene, "inertia_tensor.zz", ["body.radius"])
    >>> print(round(float(answer.gradient[0] * 1500 / answer.value), 9))  # I ~ R^2
    2.0
    """
    observable, at = _asked(scene, of)
    run = members(scene, by, None if at in ("", "end") else moment(scene, at, "the time of a gradient"))
    name = observable.variable
    value = selected(run.isel(member=0), observable).isel(time=-1)
    slopes = sensitivity(run[[name]])
    errors = slopes[[f"{name}_error"]].rename({f"{name}_error": name})
    slope, error = (selected(data, observable).isel(time=-1) for data in (slopes, errors))
    tables = source.parse(scene.to_toml(), scene.name)
    numbers, units = zip(*(number_and_unit(value_of(tables, key)) for key in by), strict=True)
    written, unit = xr.DataArray(np.array(numbers), dims="parameter"), unit_of(run[name])
    text = run[name].attrs.get("long_name", name)
    per = {"units": f"{unit} per parameter_unit", "long_name": f"derivative of {text} by the parameter"}
    result = {
        "value": value.assign_attrs(units=unit),
        "gradient": (slope / written).assign_attrs(per),
        "gradient_error": (error / abs(written)).assign_attrs(per | {"long_name": "error of gradient"}),
    }
    clean = {key: array.reset_coords(drop=True) for key, array in result.items()}
    return xr.Dataset(clean).assign_coords(
        time=float(value.time), parameter_value=("parameter", list(numbers)),
        parameter_unit=("parameter", [name or "1" for name in units]),
    )  # fmt: skip


def refusal(scene: Scene, by: Sequence[str]) -> str:
    """Why a run is not differentiated by these keys, as a sentence; empty where it is.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/core_to_pulsar_scaling.toml")
    >>> print(refusal(scene, ["body.mass"]) or "it is", "-", refusal(scene, ["time.end"]))
    it is - 'time.end' says how the body is followed, not what it is.
    """
    for key in by:
        if key.split(".")[0] in _HOW:
            return f"'{shown(key)}' says how the body is followed, not what it is."
    if scene.wants_choice:
        return "accuracy: settings that are yet to be chosen would be others for every value of a key."
    return _refused_particles(scene) if scene.model == "sph" else ""


def _refused_particles(scene: Scene) -> str:
    if scene.numerics.engine != "xla":
        return 'particles are differentiated with [numerics] engine = "xla".'
    if scene.precision != "float64":
        return 'particles are differentiated with [numerics] precision = "float64": other pairs are too coarse.'
    if scene.time.max_steps:
        return "[time] max_steps: where a run ends would jump with the lengths of its steps."
    return "regions: what is within one changes particle by particle, in jumps." if scene.regions else ""


def members(scene: Scene, by: Sequence[str], until: float | None = None) -> xr.Dataset:
    """A run and, of each key, four members beside it at the steps SIDES of NEAR, as the dataset of a sweep has them.

    until: in code units, when it ends; without it, as the scene says. For sensitivity; errors as of `gradient`.

    >>> from astroinertia.scene import load
    >>> scene = load.load_file("sims/core_to_pulsar_scaling.toml")
    >>> print(members(scene, ["body.mass", "body.radius"]).sizes["member"])
    9
    """
    if why := refusal(scene, by):
        raise SceneError(why)
    sweep, units = sensitivity_sweep(scene, by, NEAR), code_units(scene)
    scenes = [sweep.scene(number) for number in range(len(sweep.members))]
    series: dict[int, xr.Dataset] = {}
    with computing():
        for place, key in enumerate(by):
            numbers = range(1 + len(SIDES) * place, 1 + len(SIDES) * (place + 1))
            bodies = [prepare(scenes[number], units) for number in (0, *numbers)]
            records = _records(scene.model, bodies, key, until)
            for number, body, rows in zip((0, *numbers), bodies, records, strict=True):
                if number not in series:
                    described = metadata(scenes[number], units) | model_description(body.evolution)
                    series[number] = dataset.headline(stacked(rows, "record"), described)
    followed = [series[number] for number in range(len(scenes))]
    if len({data.sizes["frequency"] for data in followed}) > 1:  # waves of some are too faint for a spectrum
        followed = [data.drop_dims("frequency") for data in followed]
    data = xr.concat(
        followed, "member", data_vars="all", coords="minimal", compat="override", combine_attrs="override",
        join="override",
    )  # fmt: skip
    values: Any = {}
    for place, key in enumerate(by):
        numbers, unit = coordinate([member[place] for member in sweep.members])
        values[variable_name(key)] = ("member", numbers, {"long_name": key, "units": unit})
    return data.assign_coords(values).assign_attrs(sweep_parameters=", ".join(by))


def _records(model: str, bodies: Sequence[Prepared], key: str, until: float | None) -> list[list[dict[str, Any]]]:
    """The records of a body and of four members beside it, at the same times."""
    rows: list[list[dict[str, Any]]] = [[] for _ in bodies]
    for time in _times(bodies[0], until):
        try:
            _advance(model, [body.evolution for body in bodies], time)
        except NumericalError as error:
            raise in_si(error, bodies[0].units) from None
        except ValueError as error:
            raise SceneError(
                f"'{shown(key)}' does not change the run smoothly ({error}): take differences of runs."
            ) from None
        for body, mine in zip(bodies, rows, strict=True):
            record = body.evolution.record(mine[0].get("potential_energy", 0.0) if mine else None)
            mine.append(record | recorded(body.outputs.observables, record, body.evolution.snapshot))
    return rows


def _times(run: Prepared, until: float | None) -> list[float]:
    """The times that a run meets, with its end, in code units."""
    output = run.outputs
    end, meets = output.end if until is None else until, output.align or run.evolution.meets_times
    times = {0.0, end}
    for every in (output.series_every, output.snapshot_every):
        if every is not None and meets:
            times |= {number * every for number in range(1, math.ceil(end / every * (1.0 - SAME_TIME)))}
    return [time for before, time in pairwise([-math.inf, *sorted(times)]) if time - before > SAME_TIME * end]


def _advance(model: str, bodies: Sequence[Any], time: float) -> None:
    """All bodies to a time; ValueError where the members are no smooth neighbours of the first."""
    body, *four = bodies
    if model == "scaling":
        for one in bodies:
            while one.time < time:
                one.advance(time)
    elif body.time < time:
        jump = importlib.import_module(f"astroinertia.models.{model}.variation").advance(body, four, NEAR, time)
        if jump > _JUMP:
            raise ValueError("the body changes in jumps")


def _asked(scene: Scene, of: str) -> tuple[SelectedObservable, str]:
    """The observable and the time of a text such as inertia_tensor.zz@end."""
    name, _, at = (part.strip() for part in of.partition("@"))
    if dotted := _SERIES.fullmatch(name):
        labels = " ".join(dotted[2]) if set(dotted[2]) <= set("xyz") else dotted[2]
        name = f"{dotted[1]} {labels}"
    observable = parsed(name, scene.observables)
    if observable.of_series:
        raise SceneError(f"'{shown(of)}': a frequency has no gradient here; name the series itself.")
    return observable, at
