"""Error bars of a run's headline series, from companion runs: pure functions of their datasets.

Where v is the run's value and w that of a run whose step is r times as long, an error of order p is |v - w|/|r^p - 1|
(Richardson 1911, Phil. Trans. R. Soc. A 210, 307). Three runs tell p; it is never taken for more than theory says, and
the estimate is doubled, so that the bar still holds where an order of 2 falls to 1.2 below the smallest step. From two
runs p is taken for half of what theory says, and the estimate for 1.25 of it, as in the grid convergence index (Roache
1994, J. Fluids Eng. 116, 405; the limits of p as in Oberkampf & Roy 2010, Verification and Validation in Scientific
Computing, ch. 8). Each component has its own bar. Errors of particles also scatter, and neither is a moment at which a
difference crosses zero an accurate one, nor a component that vanishes in both runs free of error: there no bar is below
a tenth of the largest size that the estimate, of a vector or tensor as a whole, had since half of the time. Errors of
differential equations are smooth functions of the step, and are small where the difference from a finer run is. Sources
of error add up, and what rounding leaves of so many steps is added.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from astroinertia.accuracy.companion_runs import CompanionRun
from astroinertia.accuracy.selected_observables import SelectedObservable, relative_error, value
from astroinertia.errors import SceneError
from astroinertia.observables.quantities import DERIVED, OF_ATTITUDE, RECORDED
from astroinertia.process.roots import root_between

SUFFIX = "_error"
HEADLINE = (
    "second_moment", "inertia_tensor", "principal_moments", "attitude", "angular_momentum", "angular_velocity",
    "angular_speed", "kinetic_energy", "rotational_energy", "internal_energy", "gravitational_energy", "total_energy",
    "rotational_to_gravitational", "mean_radius", "equatorial_radius", "polar_radius", "ellipsoid_flattening",
    "surface_mean_radius", "surface_flattening", "moment_ratio", "zonal_harmonic_2",
    "density_max", *OF_ATTITUDE,
)  # fmt: skip
"""The series that have error bars, where the run has a number for them."""
SAFETY_OF_THREE = 2.0
SAFETY_OF_TWO = 1.25
LOWEST_ORDER = 0.5
LEAST_SHARE = 0.1
_ALIKE = 0.5  # correlation in time of the differences on two rungs, below which they are scatter that tells no order
_FEWEST_RECORDS = 2  # of a spline, which is a line or a parabola through two or three
ORDERED = "principal_moments"
_ROUNDING = 2.0**-52

CompanionOutcome = tuple[CompanionRun, "xr.Dataset | str"]
"""A companion run, and its dataset or the sentence with which it failed."""


class Estimate(NamedTuple):
    """What one source of error does to a series: its bar (T, ...), the order taken, and whether three runs gave it."""

    bar: np.ndarray
    order: float
    judged: bool


def with_error_bars(main: xr.Dataset, companions: Sequence[CompanionOutcome]) -> xr.Dataset:
    """A run's dataset with `<variable>_error` beside every headline series that it has a number for.

    >>> run = CompanionRun("coarser", "timestep_factor", "", 2.0, 2.0, scatter=False, scene=None)
    >>> companions = [(run, ds.assign(inertia_tensor=1.02 * ds.inertia_tensor))]
    >>> print(with_error_bars(ds, companions).inertia_tensor_error.attrs["units"])
    kg m2
    """
    bars = error_bars(main, companions)
    named = {name: main[name].assign_attrs(ancillary_variables=f"{name}{SUFFIX}") for name in bars}
    return main.assign(named | {f"{name}{SUFFIX}": bar for name, bar in bars.items()})


def error_bars(main: xr.Dataset, companions: Sequence[CompanionOutcome]) -> dict[str, xr.DataArray]:
    """The error bar of each headline series, with its dimensions and unit; NaN with a reason where a companion failed.

    >>> run = CompanionRun("coarser", "timestep_factor", "", 2.0, 2.0, scatter=False, scene=None)
    >>> companions = [(run, ds.assign(inertia_tensor=1.02 * ds.inertia_tensor))]
    >>> bars = error_bars(ds, companions)["inertia_tensor"] / ds.inertia_tensor  # of half the order, times 1.25
    >>> print(f"{float(bars[0, 2, 2]):.4f}")
    0.0250
    """
    failures = [
        f"the companion run {run.name} failed: {outcome}" for run, outcome in companions if isinstance(outcome, str)
    ]
    datasets = {run.name: outcome for run, outcome in companions if not isinstance(outcome, str)}
    bars = {}
    for name in HEADLINE:
        if name not in main or not np.isfinite(main[name].values).any():
            continue
        variable = main[name].transpose("time", ...)
        values, more = np.full(variable.shape, np.nan), {"reason": "; ".join(failures)}
        if not failures:
            values, comment = _bar(main, datasets, [run for run, _ in companions], name)
            more = {"comment": comment}
        attrs = {"units": variable.attrs["units"], "long_name": f"error of: {variable.attrs['long_name']}"}
        bars[name] = xr.DataArray(values, variable.coords, variable.dims, attrs=attrs | more)
    return bars


def at_end(dataset: xr.Dataset, observable: SelectedObservable) -> float:
    """The bar of an observable at the end over its size, to be held against selected_observables.relative_error.

    SceneError where there is none: for frequencies of a series, and for what is no headline series.

    >>> from astroinertia.accuracy.selected_observables import parsed
    >>> with_error = ds.assign(mass_error=0.01 * ds.mass)
    >>> print(f"{at_end(with_error, parsed('mass')):.4f}")
    0.0100
    """
    name = f"{observable.variable}{SUFFIX}"
    if observable.of_series or name not in dataset:
        raise SceneError(f"'{observable.name}' has no error bar.")
    return relative_error(
        value(dataset, observable) + value(dataset, replace(observable, variable=name)), value(dataset, observable)
    )


def measured_order(steps: Sequence[float], first: np.ndarray, second: np.ndarray, theory: float) -> float | None:
    """The order of an error from three runs, between the lowest that is credible and theory's; None if it is scatter.

    steps: of the three, from the finest; first, second (T, ...): differences of the finest from the middle one, and of
    that from the coarsest. Sizes are taken over the whole series, so that no crossing of zero tells an order.

    >>> print(measured_order((1.0, 2.0, 4.0), np.full(9, 3.0), np.full(9, 12.0), theory=4.0))  # differences as of r^2
    2.0
    """
    fine, middle, coarse = steps
    sizes = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    if not sizes[0] * sizes[1] > 0.0 or float(np.sum(first * second)) < _ALIKE * sizes[0] * sizes[1]:
        return None

    def misfit(order: float) -> float:
        return (coarse**order - middle**order) / (middle**order - fine**order) - sizes[1] / sizes[0]

    if misfit(theory) <= 0.0:
        return theory
    lowest = min(LOWEST_ORDER, theory)
    return lowest if misfit(lowest) >= 0.0 else root_between(misfit, lowest, theory)


def largest_lately(times: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The largest of sizes (T,) between half of each time since the start and that time; those not known are NaN.

    >>> print(largest_lately(np.arange(5.0), np.array([0.0, 3.0, 1.0, 1.0, 2.0])))
    [0. 3. 3. 1. 2.]
    """
    since, largest, held = times - times[0], np.full(len(times), np.nan), deque[int]()
    for number, now in enumerate(since):
        if not np.isfinite(sizes[number]):
            continue
        while held and sizes[held[-1]] <= sizes[number]:
            held.pop()
        held.append(number)
        while since[held[0]] < 0.5 * now * (1.0 - 1e-12):
            held.popleft()
        largest[number] = sizes[held[0]]
    return largest


def at_times(times: np.ndarray, recorded: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (K, ...) that are known at some times, at others (T, ...), by a cubic spline; NaN beyond them.

    What was recorded at the same time is taken as it is, to the last bit.

    >>> recorded = np.arange(6.0)
    >>> print(at_times(np.array([2.5, 7.0]), recorded, recorded**3))
    [15.625    nan]
    """
    good = np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
    recorded, values = recorded[good], values[good]
    interpolated = np.full((len(times), *values.shape[1:]), np.nan)
    if len(recorded) >= _FEWEST_RECORDS:
        interpolated = np.asarray(CubicSpline(recorded, values, axis=0, extrapolate=False)(times))
    place = np.minimum(np.searchsorted(recorded, times), max(len(recorded) - 1, 0))
    if len(recorded):
        same = recorded[place] == times
        interpolated[same] = values[place[same]]
    return interpolated


def _bar(
    main: xr.Dataset, datasets: Mapping[str, xr.Dataset], runs: Sequence[CompanionRun], name: str
) -> tuple[np.ndarray, str]:
    times = main["time"].values
    values = {"": _values(main, name)}
    values |= {
        run.name: at_times(times, datasets[run.name]["time"].values, _values(datasets[run.name], name)) for run in runs
    }
    bar, words = _rounding(values[""], name, np.nan_to_num(main["step"].values)), []
    for source in dict.fromkeys(run.source for run in runs):
        estimate = _estimate(times, [run for run in runs if run.source == source], values)
        bar = bar + estimate.bar
        measured = f"measured by three runs, times {SAFETY_OF_THREE:g}"
        how = measured if estimate.judged else f"assumed, times {SAFETY_OF_TWO:g}"
        words.append(f"{source.replace('_', ' ')} (order {estimate.order:.2f}, {how})")
    if name == ORDERED:
        bar = np.take_along_axis(bar, np.argsort(np.argsort(main[name].transpose("time", ...).values)), axis=1)
    comment = f"|difference|/|ratio of steps^order - 1| of companion runs, summed over {', '.join(words)}" + (
        f"; at least {LEAST_SHARE:g} of its largest size since half of the time" if runs[0].scatter else ""
    )
    return bar, comment


def _estimate(times: np.ndarray, runs: Sequence[CompanionRun], values: Mapping[str, np.ndarray]) -> Estimate:
    """One source of error: from one companion run, or two against the run itself."""
    order, safety, judged = 0.5 * runs[0].order, SAFETY_OF_TWO, False
    nearest = min(runs, key=lambda run: abs(np.log(run.step)))
    first = values[nearest.against] - values[nearest.name]
    if len(runs) == 2:
        middle, coarse = sorted(runs, key=lambda run: run.step)
        second = values[middle.name] - values[coarse.name]
        finite = np.isfinite(first) & np.isfinite(second)
        three = (1.0, middle.step, coarse.step)
        measured = measured_order(three, np.where(finite, first, 0.0), np.where(finite, second, 0.0), middle.order)
        if measured is not None:
            order, safety, judged = measured, SAFETY_OF_THREE, True
    estimate = safety * np.abs(first) / abs(nearest.step**order - 1.0)
    if nearest.scatter:
        least = LEAST_SHARE * largest_lately(times, _size(estimate))
        estimate = np.maximum(estimate, _beside(least, estimate))
    return Estimate(estimate, order, judged)


def _values(dataset: xr.Dataset, name: str) -> np.ndarray:
    """A series (T, ...); principal moments in ascending order, since two runs may number equal ones differently."""
    series = dataset[name].transpose("time", ...).values.astype(float)
    return np.sort(series, axis=1) if name == ORDERED else series


def _size(values: np.ndarray) -> np.ndarray:
    """The size (T,) of numbers, vectors (T, n) and tensors (T, n, n): of these the norm along the worst direction."""
    if values.ndim < 3:
        return np.abs(values) if values.ndim == 1 else np.linalg.norm(values, axis=1)
    norms, finite = np.full(len(values), np.nan), np.isfinite(values).all(axis=(1, 2))
    norms[finite] = np.linalg.norm(values[finite], ord=2, axis=(1, 2))
    return norms


def _beside(sizes: np.ndarray, values: np.ndarray) -> np.ndarray:
    return sizes.reshape(-1, *(1,) * (values.ndim - 1))


def _rounding(values: np.ndarray, name: str, steps: np.ndarray) -> np.ndarray:
    """What rounding leaves after so many steps: a random walk of the last bits, of 1 at least for pure numbers."""
    least = 1.0 if (RECORDED | DERIVED | OF_ATTITUDE)[name].dimension is None else 0.0
    sizes = np.maximum(_size(values), least) * _ROUNDING * np.sqrt(1.0 + steps)
    return np.broadcast_to(_beside(sizes, values), values.shape)
