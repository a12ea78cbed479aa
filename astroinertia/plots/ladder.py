"""Several runs beside each other: one scene answered by several models, or one model at several costs."""

import difflib
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

from astroinertia.dataset.absent import with_absent
from astroinertia.plots import style
from astroinertia.plots.axis_scales import angular_momentum_scale
from astroinertia.plots.in_words import Table
from astroinertia.plots.shown_units import beyond_round_off, written
from astroinertia.scene.sweep_values import short_text

MODELS = ("scaling", "rigid", "ellipsoid", "sph")  # from the cheapest to the one that leaves least out
DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 2, 1, 2)))
MOST_RUNS = len(style.COLOURS)
USUAL = (
    "moment_of_inertia", "mean_angular_velocity", "mean_radius", "ellipsoid_flattening", "rotational_to_gravitational",
    "density_max",
)  # fmt: skip
"""What is compared unless something else is asked for, as far as the runs have it."""
_DERIVED = ("moment_of_inertia", "mean_angular_velocity")  # of the accessor, about the axis of the angular momentum
_COLUMN = 15
_LONGEST = 60  # letters of settings in a label
_TITLE, _ROW, _HANDLE = 50, 170, 9  # letters that fit above a panel and below the panels, and a line with its room
_FEW = 4  # times: fewer make no spline
STEADY = 1e-9  # of the largest value: what changes by less stays
_ROUND_OFF = 1e-13  # of the largest value: less is shown as 0
_FAR_APART = 1e6  # a run is so much smaller than another that no power of ten suits both


@dataclass(frozen=True)
class Line:
    """One quantity of one run; `difference` is from the finest run's, at the times `at`, and NaN where one has ended.

    These times are its own, or the finest run's where it has few within that.
    """

    times: np.ndarray
    values: np.ndarray
    at: np.ndarray
    difference: np.ndarray


@dataclass(frozen=True)
class Compared:
    """One quantity of all runs that have it, by the number of the run; size is the finest run's largest value."""

    name: str
    long_name: str
    unit: str
    size: float
    lines: dict[int, Line]


def fineness(dataset: xr.Dataset) -> tuple[int, float]:
    """By which runs are put in order: the rung of the model, then the number of particles or of steps an output.

    >>> print(fineness(ds))  # the rung of the model, and particles
    (3, 100)
    """
    model = str(dataset.attrs.get("model", ""))
    rung = MODELS.index(model) if model in MODELS else -1
    particles = _particles(dataset)
    steps = dataset["step"].values
    return rung, particles or float(np.nan_to_num(steps[-1])) / len(steps)


@with_absent
def labels(datasets: Sequence[xr.Dataset]) -> list[str]:
    """What tells the runs apart: model and particles, then name, settings, folder and file, then a number.

    Settings are those of --set or of a sweep that are not the same in all runs.

    >>> print(labels([ds, ds]))
    ['sph, 100 particles [1]', 'sph, 100 particles [2]']
    """
    names = []
    for dataset in datasets:
        particles = _particles(dataset)
        model = str(dataset.attrs.get("model", "run"))
        names.append(f"{model}, {particles} particles" if particles else model)
    files = [Path(str(dataset.encoding.get("source", ""))).resolve() for dataset in datasets]
    places = [file.parent.name for file in files], [file.stem for file in files]
    for extra in ([str(dataset.attrs.get("name", "")) for dataset in datasets], _settings(datasets), *places):
        if len(set(names)) < len(names) and len(set(extra)) > 1:
            added = [f" ({more})" if more else "" for more in extra]
            names = [text.removesuffix(more) + more for text, more in zip(names, added, strict=True)]
    if len(set(names)) < len(names):
        names = [f"{text} [{number + 1}]" for number, text in enumerate(names)]
    return names


def _settings(datasets: Sequence[xr.Dataset]) -> list[str]:
    """The settings of each run that not all runs have, as in "mass = 2 Msun"; empty where there are too many.

    A key is named by its last part, unless that is the last part of another.
    """
    given = [json.loads(dataset.attrs.get("overrides", "[]")) for dataset in datasets]
    own = [[item.split("=", 1) for item in items if any(item not in others for others in given)] for items in given]
    last = {key: key.rpartition(".")[2] for key, _ in chain.from_iterable(own)}
    names = {key: end if Counter(last.values())[end] == 1 else key for key, end in last.items()}
    texts = [", ".join(f"{names[key]} = {short_text(value)}" for key, value in items).replace('"', "") for items in own]
    return texts if max(map(len, texts)) <= _LONGEST else []


@with_absent
def compared(datasets: Sequence[xr.Dataset], names: Sequence[str] = (), finest: int | None = None) -> list[Compared]:
    """Quantities of several runs on their own times, and their differences from the finest run's.

    names: variables of the schema, "moment_of_inertia" or "mean_angular_velocity" (both about the axis of the angular
    momentum); the usual ones without. Vectors and tensors are shown by their size. finest: number of the run that the
    others are measured against, the finest by `fineness` without. ValueError for fewer than two runs, more than can be
    distinguished, a quantity that no two runs have, or runs of which some have units and some have not.

    >>> runs = [ds, ds.assign(inertia_tensor=1.01 * ds.inertia_tensor)]
    >>> (quantity,) = compared(runs, ["inertia_tensor"], finest=0)
    >>> print(f"{quantity.lines[1].difference.max() / quantity.size:.4f}")
    0.0100
    """
    if not 2 <= len(datasets) <= MOST_RUNS:
        raise ValueError(f"two to {MOST_RUNS} runs can be compared, not {len(datasets)}")
    if len({style.unit_of(dataset["mass"]) for dataset in datasets}) > 1:
        raise ValueError("runs in SI and runs without dimension cannot be compared")
    if finest is None:
        finest = max(range(len(datasets)), key=lambda number: fineness(datasets[number]))
    comparisons = [_compared(datasets, name, finest) for name in names or USUAL]
    missing = [name for name, one in zip(names, comparisons, strict=False) if one is None]
    if missing:
        known = {*_DERIVED, *(str(name) for data in datasets for name in data.data_vars if "time" in data[name].dims)}
        close = [] if missing[0] in known else difflib.get_close_matches(missing[0], sorted(known), n=1)
        raise ValueError(
            f"no two of the runs have the quantity '{missing[0]}', or the one compared with lacks it or it is 0 in all"
            + "".join(f"; did you mean '{name}'?" for name in close)
        )
    kept = [one for one in comparisons if one is not None]
    if not kept:
        raise ValueError("the runs have no quantity in common that changes or is not zero")
    return kept


@with_absent
def ladder_figure(datasets: Sequence[xr.Dataset], quantities: Sequence[Compared], finest: int) -> Figure:
    """Each quantity of all runs in one panel, and beside it how far they are from the finest.

    >>> runs = [ds, ds.assign(inertia_tensor=1.01 * ds.inertia_tensor)]
    >>> figure = ladder_figure(runs, compared(runs, ["inertia_tensor"], finest=0), 0)
    >>> print(len(figure.axes))  # the quantity, and how far the runs are apart
    2
    """
    names = labels(datasets)
    with style.styled():
        figure = style.begin(datasets[finest], "runs beside each other", (12.0, 1.4 + 2.15 * len(quantities)))
        grid = figure.subplots(len(quantities), 2, width_ratios=[1.35, 1.0], squeeze=False)
        factor, unit = style.scale_of(
            style.unit_of(datasets[0]["time"]), np.concatenate([dataset["time"].values for dataset in datasets])
        )
        common = max(_reaches(line) for one in quantities for number, line in one.lines.items() if number != finest)
        for (left, right), one in zip(grid, quantities, strict=True):
            _overlaid(left, one, names, factor)
            _differences(right, one, factor, finest)
            end = float(max(line.times[-1] for line in one.lines.values()))
            for axes, reach, more in ((left, end, ""), (right, min(end, common), _common(common, end))):
                axes.set_xlim(0, reach / factor if reach > 0.0 else None)
                axes.tick_params(labelbottom=one is quantities[-1])
                if one is quantities[-1]:
                    axes.set_xlabel(style.label("time", unit) + more)
        title = f"Difference from: {names[finest]}"
        grid[0, 1].set_title(title if len(title) <= _TITLE else f"Difference from:\n{fill(names[finest], _TITLE)}")
        handles, texts = grid[0, 0].get_legend_handles_labels()
        columns = max(1, _ROW // (max(map(len, texts)) + _HANDLE))
        figure.legend(handles, texts, loc="outside lower center", ncols=min(len(texts), 4, columns))
        return figure


@with_absent
def ladder_table(
    datasets: Sequence[xr.Dataset], quantities: Sequence[Compared], finest: int, columns: int = 0
) -> str:  # fmt: skip
    """The same in words: what each run costs, and start, extremes, end and differences of every quantity.

    columns: of the terminal that it is for; without, it is as wide as it needs.

    >>> runs = [ds, ds.assign(inertia_tensor=1.01 * ds.inertia_tensor)]
    >>> text = ladder_table(runs, compared(runs, ["inertia_tensor"], finest=0), 0)
    >>> print(text.splitlines()[-3].split()[-1])  # the largest difference
    1.00e-02
    """
    names = labels(datasets)
    width = max(max(map(len, names)), 18) + 2
    rows: list[tuple[str, ...]] = []
    for name, dataset in zip(names, datasets, strict=True):
        wall, outputs = float(dataset["wall_time"][-1]), dataset.sizes["time"]
        took = f"{wall:.3g} s" if np.isfinite(wall) else "-"
        factor, unit = style.scale_of(style.unit_of(dataset["time"]), dataset["time"].values)
        end = written(float(dataset["time"][-1]), factor, unit)
        rows.append((name, took, str(outputs), end))
    widths = (width, *[_COLUMN] * 6)
    lines = [Table("", ("run", "computed in", "outputs", "to"), tuple(rows), widths[:4]).text(columns)]
    heads = ("", "start", "minimum", "maximum", "end", "rms diff.", "largest")
    for one in quantities:
        factor, unit = _shared_scale(one)
        title = one.long_name if unit == "1" else f"{one.long_name} ({unit})"
        rows = []
        for number, line in one.lines.items():
            values = line.values[np.isfinite(line.values)]
            # Runs may be of bodies of very different sizes; a plain number is one beside 1.
            size = one.size if one.unit == "1" else float(abs(values).max())
            values = np.where(abs(values) > _ROUND_OFF * size, values, 0.0)
            shown = [values[0], values.min(), values.max(), values[-1]]
            differences = _difference_cells(one, line, number == finest)
            rows.append((names[number], *(f"{value / factor:.5g}" for value in shown), *differences))
        lines += ["", title, Table(title, heads, tuple(rows), widths).text(columns)]
    ends = [float(dataset["time"][-1]) for dataset in datasets]
    more = _common(min(ends), max(ends))
    said = [f"differences are from '{names[finest]}', over its largest value{more}"]
    said += [f"'{names[number]}' is the same to the last bit" for number in _same(quantities, finest)]
    return "\n".join([*lines, "", *(fill(line, columns) if columns else line for line in said)])


def _shared_scale(one: Compared) -> tuple[float, str]:
    """What the numbers of all runs are divided by, and their unit then: the plain one where they are far apart."""
    sizes = [float(np.nanmax(abs(line.values))) for line in one.lines.values()]
    if max(sizes) > _FAR_APART * min((size for size in sizes if size > 0.0), default=np.inf):
        return 1.0, one.unit
    return style.scale_of(one.unit, *sizes)


def _same(quantities: Sequence[Compared], finest: int) -> list[int]:
    """Numbers of the runs that nothing compared tells from the finest."""
    others = sorted({number for one in quantities for number in one.lines} - {finest})
    return [number for number in others if all(_identical(one, number, finest) for one in quantities)]


def _identical(one: Compared, number: int, finest: int) -> bool:
    line, reference = one.lines.get(number), one.lines[finest]
    return line is not None and all(
        np.array_equal(mine, theirs, equal_nan=True)
        for mine, theirs in ((line.times, reference.times), (line.values, reference.values))
    )


def _difference_cells(one: Compared, line: Line, itself: bool) -> tuple[str, str]:
    sizes = abs(line.difference[np.isfinite(line.difference)]) / one.size
    if itself or not len(sizes):
        return "-", "-"
    return f"{np.sqrt(np.mean(sizes**2)):.2e}", f"{sizes.max():.2e}"


def _compared(datasets: Sequence[xr.Dataset], name: str, finest: int) -> Compared | None:
    as_size = name in _DERIVED and any(dataset.inertia.axis_moves() for dataset in datasets)
    found = {number: _series(dataset, name, as_size) for number, dataset in enumerate(datasets)}
    series = {number: one for number, one in found.items() if one is not None}
    if len(series) < 2 or finest not in series:
        return None
    reference, size = series[finest], float(abs(series[finest]).max())
    lines = {}
    for number, one in series.items():
        times, values = one["time"].values, one.values
        apart = (times, np.zeros(len(one))) if number == finest else _apart(one, reference)
        lines[number] = Line(times, values, *apart)
    if not any(line.values.any() for line in lines.values()):
        return None
    return Compared(name, str(reference.attrs["long_name"]), style.unit_of(reference), size or 1.0, lines)


def _series(dataset: xr.Dataset, name: str, as_size: bool = False) -> xr.DataArray | None:
    """A quantity against time, or None where the run has no number for it at two times or more."""
    if name in (*_DERIVED, "rotational_to_gravitational") and not angular_momentum_scale(dataset)[1]:
        return None
    if name in _DERIVED:
        of_inertia, inertia = name == "moment_of_inertia", dataset.inertia
        series = inertia.about_axis("spin") if of_inertia else inertia.spin_rate(as_size)
        text = "moment of inertia about the spin axis" if of_inertia else "mean angular velocity"
        series = series.assign_attrs(long_name=text)
    elif name in dataset and "time" in dataset[name].dims and dataset[name].dtype.kind == "f":
        variable = dataset[name].copy(data=beyond_round_off(dataset[name]))
        others = [dim for dim in variable.dims if dim != "time"]
        size = (variable**2).sum(others, skipna=True, min_count=1) ** 0.5 if others else variable
        text = f"{'size of: ' if others else ''}{variable.attrs['long_name']}"
        series = size.assign_attrs(units=style.unit_of(variable), long_name=text)
    else:
        return None
    return series if int(series.notnull().sum()) > 1 else None


def _apart(one: xr.DataArray, reference: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Times, and how far a run is from the reference then."""
    own, theirs = one["time"].values, reference["time"].values
    mine, other = one.values - _at(reference, own), _at(one, theirs) - reference.values
    few = np.isfinite(mine).sum() < min(_FEW, np.isfinite(other).sum())
    return (theirs, other) if few else (own, mine)


def _common(reach: float, end: float) -> str:
    """What is said of differences that reach less far than runs do."""
    return "" if reach > end * (1.0 - STEADY) else ", as far as both runs go"


def _reaches(line: Line) -> float:
    """The last time at which a run has a difference; 0 without any."""
    return float(max(line.at[np.isfinite(line.difference)], default=0.0))


def _at(series: xr.DataArray, times: np.ndarray) -> np.ndarray:
    """A quantity at other times, by a cubic spline; NaN beyond its own."""
    if np.array_equal(times, series["time"].values):
        return series.values
    finite = series.dropna("time")
    if finite.sizes["time"] < _FEW:
        return np.interp(times, finite["time"].values, finite.values, left=np.nan, right=np.nan)
    return CubicSpline(finite["time"].values, finite.values)(times, extrapolate=False)


def _overlaid(axes, one: Compared, names: list[str], factor: float) -> None:
    finite = np.concatenate([line.values[np.isfinite(line.values)] for line in one.lines.values()])
    logarithmic = bool((finite > 0).all() and finite.max() > 20 * finite.min())
    scale, unit = style.scale_of(one.unit, finite)
    if logarithmic and unit.startswith("10^"):  # the axis has powers of ten itself
        scale, unit = 1.0, one.unit
    for place, (number, line) in enumerate(one.lines.items()):
        axes.plot(
            line.times / factor, line.values / scale, color=style.COLOURS[number], label=names[number],
            linestyle=DASHES[place % len(DASHES)], linewidth=1.7,
        )  # fmt: skip
    if logarithmic:
        axes.set_yscale("log")
        style.plain_log(axes.yaxis, finite.min() / scale, finite.max() / scale)
    elif np.ptp(finite) < STEADY * abs(finite).max():  # what stays is drawn as a level, not as its rounding
        axes.set_ylim(*np.sort(finite[0] / scale * np.array([0.99, 1.01])))
    axes.set_title(f"{one.long_name[:1].upper()}{one.long_name[1:]}")
    if unit != "1":
        axes.set_ylabel(style.raised(unit))


def _differences(axes, one: Compared, factor: float, finest: int) -> None:
    drawn = []
    for place, (number, line) in enumerate(one.lines.items()):
        sizes = abs(line.difference) / one.size
        if number == finest or not (sizes > 0).any():
            continue
        shown = np.where(sizes > 0, sizes, np.nan)
        axes.semilogy(
            line.at / factor, shown, color=style.COLOURS[number], linestyle=DASHES[place % len(DASHES)], linewidth=1.4
        )
        drawn.append(shown)
    if not drawn:
        style.note(axes, "the same to the last bit")
        return
    everything = np.concatenate(drawn)
    low, high = style.robust_limits(everything, 1e-17)
    axes.set_ylim(max(low, float(np.nanmax(everything)) * 1e-6), high)
    style.plain_log(axes.yaxis, *axes.get_ylim())
    axes.set_ylabel("over the largest")


def _particles(dataset: xr.Dataset) -> int:
    """Number of particles of the run, 0 where the model has none."""
    if dataset.attrs.get("model") != "sph":
        return 0
    counts = dataset.attrs.get("body_particles")
    return sum(json.loads(str(counts))) if counts else 0
