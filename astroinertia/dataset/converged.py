"""How far a run is from the converged answer of its problem, where one is known: `data/references.toml`.

A run is recognised by the physics of its scene: bodies, matter, effects, companions, sinks and box. Numerical devices
and choices, such as the number of particles, the kernel, steps, seed, end and outputs, are what the distance is about.
"""

import math
import tomllib
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from astroinertia.errors import SceneError
from astroinertia.scene import load
from astroinertia.scene.schema import Scene
from astroinertia.scene.text import toml_text
from astroinertia.storage.data_tables import data_path
from astroinertia.units import unit_of

_PLACING = {"particles", "placement", "seed", "relax"}  # of a body: how it is made of particles
_SUMMING = {"method", "force_error", "softening", "order", "gradients"}  # of an effect: how its sums are carried out
_SAME = 1e-6  # relative: numbers of a scene that mean the same
_SIZES = {"moment": "mean moment of inertia", "moment_z": "moment of inertia about z"}


class Distance(NamedTuple):
    """A quantity of a run beside its converged value.

    unit: SI, or "1"; both numbers are in it. distance: relative, run / converged - 1. error: of the converged value,
    relative, as its source estimates it.
    """

    name: str
    unit: str
    converged: float
    run: float
    distance: float
    error: float


class Reference(NamedTuple):
    """The converged answer of a problem: its name, where the numbers come from, its scene, and its quantities."""

    name: str
    source: str
    scene: dict[str, Any]
    values: tuple[dict[str, Any], ...]


@cache
def references() -> tuple[Reference, ...]:
    """All converged answers, in the order of data/references.toml; FileNotFoundError where that is not there."""
    tables = tomllib.loads(data_path("references.toml").read_text(encoding="utf-8"))
    return tuple(
        Reference(name, table["source"], table["scene"], tuple(table["values"])) for name, table in tables.items()
    )


def physics(scene: Scene) -> dict[str, Any]:
    """What of a scene decides what happens, in SI or code units: the same for runs of one problem."""
    several = scene.bodies or (scene.body,)
    physical = {kind: options for kind, options in scene.effects.items() if not scene.entries[kind].numerical}
    return {
        "dimensionless": scene.dimensionless,
        "bodies": [body.model_dump(exclude=_PLACING | {"entry"}) for body in several],
        "orbit": _dumped(scene.orbit),
        "matter": _dumped(scene.equation_of_state),
        "companions": [_dumped(companion) for companion in scene.companions],
        "sinks": [_dumped(sink) for sink in scene.sinks],
        "box": _dumped(scene.box),
        "effects": {
            kind: {name: value for name, value in options.items() if name not in _SUMMING}
            for kind, options in physical.items()
        },
    }


def reference(dataset: xr.Dataset) -> Reference | None:
    """The converged answer of the problem that a run solves; None where there is none, or the run keeps no scene.

    None of a branch either, whose first part was another run's.

    >>> print(reference(ds))  # of a small star that falls together
    None
    """
    text = dataset.attrs.get("scene")
    return _answer(text) if isinstance(text, str) and "branched_from" not in dataset.attrs else None


def distances(dataset: xr.Dataset) -> list[Distance]:
    """The quantities of a run that its problem has converged values of; empty where it has none.

    What the run has not come to is left out: a quantity whose time is past its end, and an extreme in its last record.

    >>> print(distances(ds))  # of a small star that falls together
    []
    """
    answer = reference(dataset)
    rows = [_distance(dataset, value) for value in answer.values] if answer else []
    return [row for row in rows if row is not None]


@lru_cache(maxsize=16)
def _answer(text: str) -> Reference | None:
    alike = [one for one in references() if f'"{one.scene["body"]["kind"]}"' in text]
    if not alike:
        return None  # without a look at files that other scenes name
    try:
        solved = physics(load.loads(text))
    except SceneError:  # of an effect or a body that is not here
        return None
    stated = ((one, load.loads(toml_text({"name": one.name, **one.scene}))) for one in alike)
    return next((one for one, scene in stated if _same(physics(scene), solved)), None)


def _distance(dataset: xr.Dataset, value: Mapping[str, Any]) -> Distance | None:
    times = dataset["time"].values
    when = _when(dataset, value["at"]) if value["time"] <= times[-1] else None
    if when is None:
        return None
    series, unit = _series(dataset, value["quantity"])
    run = _at(times, series, when)
    if value.get("fall", False):
        run, unit = float(series[0]) / run, "1"
    converged = float(value["value"])
    if not math.isfinite(run):
        return None
    return Distance(value["name"], unit, converged, run, run / converged - 1.0, float(value["error"]))


def _when(dataset: xr.Dataset, at: str | float) -> float | None:
    """The time of "maximum density_max", "minimum moment", or a time itself; None for an extreme that is not over."""
    if not isinstance(at, str):
        return float(at)
    extreme, name = at.split()
    series = _series(dataset, name)[0] * (-1.0 if extreme == "minimum" else 1.0)
    if not np.isfinite(series).any():
        return None
    place, times = int(np.nanargmax(series)), dataset["time"].values
    if place in (0, len(series) - 1):
        return None
    if name == "density_max":  # a cusp at a bounce, which no parabola goes through
        return float(times[place])
    return _vertex(times[place - 1 : place + 2], series[place - 1 : place + 2])


def _vertex(x: np.ndarray, y: np.ndarray) -> float:
    """Where the parabola through three points has its vertex; the point in the middle is the highest of them."""
    before, after = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    if not before - after > 0.0:
        return float(x[1])
    return float(0.5 * (x[0] + x[1]) + 0.5 * (x[2] - x[0]) * before / (before - after))


def _at(times: np.ndarray, series: np.ndarray, when: float) -> float:
    """The value at a time, by the parabola through the record next to it and the two beside that."""
    middle = min(max(int(np.abs(times - when).argmin()), 1), len(times) - 2)
    if times[middle] == when or len(times) < 3:
        return float(np.interp(when, times, series))
    from scipy.interpolate import krogh_interpolate  # only here: most runs have no converged answer

    beside = slice(middle - 1, middle + 2)
    return float(krogh_interpolate(times[beside], series[beside], when))


def _series(dataset: xr.Dataset, name: str) -> tuple[np.ndarray, str]:
    """A quantity along time (T,), and its unit."""
    if name in _SIZES:
        tensor = dataset["inertia_tensor"].transpose("time", "i", "j")
        values = tensor.values[:, 2, 2] if name == "moment_z" else np.trace(tensor.values, axis1=1, axis2=2) / 3.0
        return values, unit_of(tensor)
    variable = dataset[name]
    return variable.values, unit_of(variable)


def _dumped(part: Any) -> Any:
    return None if part is None else part.model_dump()


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float | int) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=_SAME)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_same(value, other[name]) for name, value in one.items())
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return one == other
