"""What a run is judged by: numbers of its observables at the end, or the frequency of one of their series.

They are written as a person says it: "inertia_tensor z z", "moment_ratio", "angular_velocity" (all components),
"attitude 3" (the third axis of a rigid body), "frequency of inertia_tensor z z". Tests:
tests/unit/accuracy/test_selected_observables.py.
"""

import difflib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.regions import QUANTITIES as REGIONAL
from astroinertia.errors import NumericalError, SceneError
from astroinertia.observables.quantities import DERIVED, LABELS, OF_ATTITUDE, OF_EFFECTS, RECORDED
from astroinertia.scene.schema import Scene
from astroinertia.units import shown

DEFAULTS = {
    "sph": ("inertia_tensor z z", "angular_velocity"),
    "ellipsoid": ("inertia_tensor z z", "angular_velocity"),
    "scaling": ("inertia_tensor z z", "angular_velocity"),
    "rigid": ("angular_velocity", "attitude 3"),
}
"""What a model is judged by unless something else is asked for."""
_KNOWN = RECORDED | DERIVED | OF_EFFECTS | OF_ATTITUDE | REGIONAL
_OF_SERIES = "frequency of "
_FEWEST_RECORDS = 16  # of a series whose frequency is asked for
_BETTERED = 3  # times, from 1e-8 on, each time by the square
_TRIED_A_PERIOD = 8  # trial frequencies to one over the length of the series


@dataclass(frozen=True)
class SelectedObservable:
    """Numbers of an observable (observables, or one of the user's own) that a run is judged by.

    variable: its name in the dataset; labels: for its dimensions but time; of_series: its frequency, not its end.
    """

    name: str
    variable: str
    labels: tuple[str, ...]
    of_series: bool = False


def parsed(name: str, own: Collection[str] = ()) -> SelectedObservable:
    """What a name selects; SceneError where no dataset has such a variable or label, and the run no `own` one.

    >>> print(parsed("inertia_tensor z z").labels, parsed("frequency of inertia_tensor z z").of_series)
    ('z', 'z') True
    """
    normalized = " ".join(name.split())
    of_series = normalized.startswith(_OF_SERIES)
    words = normalized.removeprefix(_OF_SERIES).split()
    if not words:
        raise SceneError("an observable is a variable of the dataset and its labels, such as inertia_tensor z z.")
    if words[0] not in _KNOWN and words[0] not in own:
        near = difflib.get_close_matches(words[0], _KNOWN, 1)
        hint = (
            f"; did you mean {near[0]}?" if near else ", such as inertia_tensor z z, angular_velocity or moment_ratio."
        )
        raise SceneError(f"'{shown(words[0])}' is no series of the dataset{hint}")
    observable = SelectedObservable(normalized, words[0], tuple(words[1:]), of_series)
    if words[0] not in own:
        dims = [dim for dim in _KNOWN[words[0]].dims if dim != "time"]
        # What effects, regions and companions there are is known of a run alone.
        _refuse_labels(observable, {dim: [str(label) for label in LABELS.get(dim, ((),))[0]] for dim in dims})
    return observable


def default_names(scene: Scene) -> tuple[str, ...]:
    """What a scene is judged by unless something else is asked for; a body at rest has no angular velocity.

    >>> from astroinertia.scene import load
    >>> print(default_names(load.load_file("sims/tennis_racket.toml")))
    ('angular_velocity', 'attitude 3')
    """
    names = DEFAULTS[scene.model]
    body = scene.body
    gradient = np.zeros((3, 3)) if body.velocity_gradient is None else np.asarray(body.velocity_gradient)
    turning = body.rotation is not None or np.any(gradient != np.diag(np.diag(gradient)))  # strain along axes does not
    still = not turning and getattr(body, "law", None) is None
    turned = still and scene.model != "rigid" and not scene.companions and not scene.bodies
    return tuple(name for name in names if not (turned and name == "angular_velocity"))


@with_absent
def value(dataset: xr.Dataset, observable: SelectedObservable) -> np.ndarray:
    """The numbers (K,) of an observable, in the dataset's units.

    SceneError where the dataset has no such variable or label, NumericalError where the run has no number for it.

    >>> print(value(ds, parsed("inertia_tensor z z")) == ds.inertia_tensor.sel(i="z", j="z").values[-1])
    [ True]
    """
    series = selected(dataset, observable)
    if observable.of_series:
        if series.ndim != 1:
            raise SceneError(f"'{observable.name}': a frequency is that of one series; add labels, as in z z.")
        return np.array([frequency(dataset["time"].values, series.values)])
    numbers = np.atleast_1d(np.asarray(series.values[-1], dtype=float)).ravel()
    if not np.isfinite(numbers).all():
        reason = dataset[observable.variable].attrs.get("reason", "the run has no number for it")
        raise NumericalError(f"'{observable.name}' is not known: {reason}")
    return numbers


def components(dataset: xr.Dataset, observable: SelectedObservable) -> list[str]:
    """Names of the numbers of an observable, in the order of `value`.

    >>> print(components(ds, parsed("angular_velocity")))
    ['angular_velocity x', 'angular_velocity y', 'angular_velocity z']
    """
    if observable.of_series:
        return [observable.name]
    series = selected(dataset, observable).isel(time=-1)
    if not series.ndim:
        return [observable.name]
    stacked = series.stack(every=series.dims)
    return [f"{observable.name} {' '.join(str(label) for label in labels)}" for labels in stacked["every"].values]


def relative_error(values: np.ndarray, reference: np.ndarray) -> float:
    """|values - reference|/|reference|, both (K,); of a direction, a unit vector, the angle in radians where small.

    >>> print(f"{relative_error(np.array([3.0, 4.0]), np.array([3.0, 4.1])):.4f}")
    0.0197
    """
    size = float(np.linalg.norm(reference))
    return float(np.linalg.norm(np.asarray(values) - reference)) / size if size > 0.0 else float("nan")


def frequency(times: np.ndarray, values: np.ndarray) -> float:
    """The angular frequency of the sinusoid that fits a series (T,) best beside a straight line.

    The residual of the linear fit is scanned over frequencies, its least one found by Brent's method, and bettered by
    Gauss and Newton's, which sees the frequency itself where the square of its error is rounding. NumericalError for a
    series that is too short to tell.

    >>> times = np.linspace(0.0, 20.0, 100)
    >>> print(f"{frequency(times, 1 + 0.1 * times + np.cos(1.7 * times)):.6f}")  # beside a drift
    1.700000
    """
    times, values = np.asarray(times, float), np.asarray(values, float)
    if len(times) < _FEWEST_RECORDS or not np.isfinite(values).all():
        raise NumericalError(f"a frequency needs {_FEWEST_RECORDS} records at least, and there are {len(times)}")
    span = times[-1] - times[0]
    share, values = (times - times[0]) / span, values - values.mean()
    values /= np.abs(values).max() or 1.0

    def fitted(omega: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        phase = omega * span * share
        columns = np.stack([np.ones_like(share), share, np.cos(phase), np.sin(phase)], axis=1)
        solution = np.linalg.lstsq(columns, values, rcond=None)[0]
        return columns, solution, values - columns @ solution

    def misfit(omega: float) -> float:
        return float(np.sum(fitted(omega)[2] ** 2))

    def bettered(omega: float) -> float:
        columns, (*_, cosine, sine), left = fitted(omega)
        by_phase = share * (sine * columns[:, 2] - cosine * columns[:, 3])  # at the end
        change = float(np.linalg.lstsq(np.column_stack([columns, by_phase]), left, rcond=None)[0][-1])
        return omega + change / float(span)

    # From one turn in all to one in four records; slower ones cannot be separated from the straight line.
    tried = np.arange(_TRIED_A_PERIOD, _TRIED_A_PERIOD * len(times) // 4 + 1) * (2 * np.pi / (_TRIED_A_PERIOD * span))
    best = tried[int(np.argmin([misfit(omega) for omega in tried]))]
    step = 2 * np.pi / (_TRIED_A_PERIOD * span)
    minimum: Any = minimize_scalar(
        misfit, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-9 * best}
    )
    found = [float(minimum.x)]
    for _ in range(_BETTERED):
        found.append(bettered(found[-1]))
    return min(found, key=misfit)


def selected(dataset: xr.Dataset, observable: SelectedObservable) -> xr.DataArray:
    """The series of an observable, time leading; SceneError where the dataset has no such variable or label.

    >>> print(selected(ds, parsed("inertia_tensor z")).dims)
    ('time', 'j')
    """
    if observable.variable not in dataset:
        raise SceneError(f"'{observable.variable}' is not in the dataset of this run.")
    series = dataset[observable.variable]
    dims = [dim for dim in series.dims if dim not in ("time", "parameter")]  # parameters: of a sensitivity
    choices = {str(dim): [str(coordinate) for coordinate in series[dim].values] for dim in dims}
    _refuse_labels(observable, choices)
    chosen = {dim: choices[dim].index(label) for dim, label in zip(choices, observable.labels, strict=False)}
    return series.isel(chosen).transpose("time", ...)


def _refuse_labels(observable: SelectedObservable, choices: Mapping[str, Sequence[str]]) -> None:
    """SceneError for more labels than there are dimensions, and for one that is none of the choices of its own."""
    if len(observable.labels) > len(choices):
        raise SceneError(
            f"'{observable.name}' has more labels than {observable.variable} has dimensions ({len(choices)})."
        )
    for (dim, known), label in zip(choices.items(), observable.labels, strict=False):
        if known and label not in known:
            raise SceneError(f"'{observable.name}': {dim} is one of {', '.join(known)}, not '{shown(label)}'.")
