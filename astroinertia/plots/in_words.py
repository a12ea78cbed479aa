"""A run in words and numbers: as text for the terminal, and as tables for pages."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product, zip_longest
from textwrap import fill, wrap

import numpy as np
import xarray as xr

from astroinertia.dataset import bounds, converged
from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.picture_methods import as_drawn, missing_named
from astroinertia.dataset.radii import RATIOS
from astroinertia.dataset.rotational_share import differential, rotational_share
from astroinertia.dataset.schema import COMPUTED, INERTIAL
from astroinertia.dataset.sizes import largest_size
from astroinertia.observables.quantities import OF_ATTITUDE
from astroinertia.plots.axis_scales import angular_impulse, angular_momentum_scale, energy_scale, known_effects
from astroinertia.plots.error_bars import known_bars
from astroinertia.plots.shown_units import DIFFERENCES, beyond_round_off, cleared, scale_of, written
from astroinertia.plots.style import words
from astroinertia.units import unit_of

_largest = partial(largest_size, unknown=np.nan)
_WIDTH = 40
_NARROWEST = 12  # column of names
_ASKED = "settings chosen for an accuracy of "
*_SHAPES, _J2 = DIFFERENCES


@dataclass(frozen=True)
class Table:
    """A table of cells: its title, the heads of its columns (none where they need none), rows, and what is said below.

    widths: of the columns in text, the first set flush left; cells beyond them follow two blanks on.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    widths: tuple[int, ...]
    below: str = ""

    def text(self, columns: int = 0) -> str:
        """The table for a terminal; where that has fewer columns, names are on several lines and gaps are narrow."""
        # A long unit gets a line of its own rather than pushing the columns.
        lines = self._lines(self.widths, lambda name: [name, ""])
        if columns and max(map(len, lines)) > columns:
            cells = zip_longest(*(cells for _, *cells in (self.head or ("",), *self.rows)), fillvalue="")
            needed = [2 + max(map(len, column)) for column in cells]
            first = max(columns - sum(needed), _NARROWEST)
            lines = self._lines(
                (first, *needed[: len(self.widths) - 1]), lambda name: wrap(name, first, subsequent_indent="  ")
            )
        return "\n".join([*lines, *(_filled(self.below, columns) if self.below else ())])

    def _lines(self, widths: tuple[int, ...], broken: Callable[[str], list[str]]) -> list[str]:
        lines = [self._line(self.head, widths)] if self.head else []
        for name, *cells in self.rows:
            *above, last = broken(name) if len(name) > widths[0] else [name]
            lines += [*above, self._line((last, *cells), widths)]
        return lines

    def _line(self, cells: tuple[str, ...], widths: tuple[int, ...]) -> str:
        first, *others = (f"{cell:{'<' if k == 0 else '>'}{width}}" for k, (cell, width) in
                          enumerate(zip(cells, widths, strict=False)))  # fmt: skip
        return "".join([first, *others, *(f"  {cell}" for cell in cells[len(widths) :])])


def _filled(text: str, columns: int) -> list[str]:
    return [fill(line, columns) if columns else line for line in text.splitlines()]


@with_absent
def summary(dataset: xr.Dataset, columns: int = 0) -> str:
    """Size, spin, shape, accuracy and the effects' shares, one fact a line, for a terminal of so many columns.

    >>> print("flattening" in summary(ds), "T/|W|" in summary(ds))
    True True
    """
    dataset = as_drawn(dataset)
    with missing_named("a summary is made"):
        parts = [heading(dataset), *(table.text(columns) for table in tables(dataset))]
    parts += [f"Over before its end: {early}." if (early := dataset.attrs.get("ended_early")) else ""]
    parts += [bounds.message(dataset.attrs, of) for of in ("resolution", "ledger")]
    return "\n\n".join(part for part in parts if part)


@with_absent
def tables(dataset: xr.Dataset) -> list[Table]:
    """The body, its regions, accuracy, error bars, the distance to a converged answer and effects, as far as they go.

    >>> print([table.title for table in tables(ds)])
    ['The body', 'Accuracy and conservation', 'The ledger of effects']
    """
    kinds = (_body, _attitude, _own, _regions, _accuracy, _bars, _converged, _effects, _profile)
    drawn = [kind(dataset) for kind in kinds]
    return [table for table in drawn if table is not None and table.rows]


def heading(dataset: xr.Dataset) -> str:
    """The run's name and description; model, engine, precision, how long it took, and where it comes from.

    >>> print(heading(ds).splitlines()[1].split(";")[0])
    sph, numba_cpu, float64
    """
    attrs = dataset.attrs
    lines = [f"{attrs.get('name', 'run')}: {attrs.get('description', '')}".rstrip(": ")]
    how = ", ".join(str(attrs[name]) for name in ("model", "engine", "precision") if name in attrs)
    time = dataset["time"]
    steps = dataset["step"].values
    counted = f"{int(steps[-1])} steps, " if np.isfinite(steps[-1]) else ""
    wall = float(dataset["wall_time"][-1])
    took = f", computed in {wall:.0f} s" if np.isfinite(wall) else ""
    lines.append(f"{how}; {_value(time[-1])} in {counted}{dataset.sizes['time']} outputs{took}")
    computed, *events = str(attrs.get("history", "")).splitlines() or [""]
    return "\n".join([*lines, *(events if computed == COMPUTED else ())])


def _body(dataset: xr.Dataset) -> Table:
    inertia = dataset.inertia
    rows = [
        ("moment of inertia about z", inertia.about_axis("z")),
        *(
            (str(dataset[name].attrs["long_name"]), dataset[name])
            for name in ("mean_radius", "density_max", *_SHAPES)
            if name in dataset
        ),
        *((_ratio_text(dataset[name]), dataset[name]) for name in RATIOS if name in dataset),
        *(("J2", dataset[name]) for name in (_J2,) if name in dataset),
    ]
    if "sink_mass" in dataset:
        rows.append(("mass of the sinks", dataset["sink_mass"].sum("sink").assign_attrs(dataset["sink_mass"].attrs)))
    below = ""
    if angular_momentum_scale(dataset)[1]:
        relative = "" if dataset.attrs.get("frame", INERTIAL) == INERTIAL else "; all relative to the rotating frame"
        below = f"({inertia.spin_rate().attrs['long_name']}{relative})"
        laws = [("1/I", inertia.spin_scaling("inertia")), ("1/R^2", inertia.spin_scaling("radius"))]
        shells, mean = rotational_share(dataset), dataset["rotational_to_gravitational"]
        rows += [
            ("mean angular velocity", inertia.spin_rate()),
            *((f"  if it went as {name}", law) for name, law in laws if np.nan_to_num(law).any()),
            ("T/|W|", mean.copy(data=shells)),
        ]
        if differential(shells, mean.values):
            rows.append(("  of the mean angular velocity", mean))
    return _course("The body", [(name, unit_of(series), beyond_round_off(series)) for name, series in rows], below)


def _attitude(dataset: xr.Dataset) -> Table | None:
    """How a rigid body stands and turns: obliquity, precession and wobble."""
    names = [name for name in OF_ATTITUDE if name in dataset]
    if not names:
        return None
    # A free body's angular momentum stays where it is.
    quiet = [name for name in names if name == "precession_rate" and not np.nan_to_num(dataset[name].values).any()]
    # Components of the attitude and of L are known to round-off, which every step adds at random to.
    round_off = float(np.sqrt(1.0 + np.nan_to_num(dataset["step"].values[-1])))
    rows = [
        (words(name), "deg", np.degrees(cleared(series.values, round_off))) if unit_of(series) == "rad"
        else (words(name), unit_of(series), series.values)
        for name, series in ((name, dataset[name]) for name in names if name not in quiet)
    ]  # fmt: skip
    numbers = [
        (text, dataset[name].attrs[key], unit)
        for name, key, text, unit in (
            ("precession_rate", "mean", "mean precession rate", "rad s-1"),
            ("obliquity", "nutation_amplitude", "nutation amplitude", "rad"),
            ("obliquity", "nutation_period", "nutation period", "s"),
            ("wobble_angle", "settling_time", "settling time", "s"),
        )
        if name in dataset and key in dataset[name].attrs
    ]
    below = []
    for text, value, unit in numbers:
        factor, readable = (np.pi / 180.0, "deg") if unit == "rad" else scale_of(unit, np.array([value]))
        below.append(f"{text} {written(value, factor, readable, 6)}{_more(value, unit)}")
    return _course("How it stands and turns", rows, "\n".join(below))


def _more(value: float, unit: str) -> str:
    """The same in the units of astronomers, where it is small enough for them."""
    seconds, year = float(np.degrees(value)) * 3600.0, 365.25 * 86400.0
    if unit == "rad" and abs(value) < 1e-3:
        return f" ({seconds:.5g} arcsec)"
    return f" ({seconds * year:.6g} arcsec/yr)" if unit == "rad s-1" and abs(value) < 1e-7 else ""


def _ratio_text(series: xr.DataArray) -> str:
    return f"I/(M R^2), {words(series.attrs.get('radius', 'reference_radius'))}"


def _own(dataset: xr.Dataset) -> Table:
    """Observables of the user's own, a row for each of their numbers."""
    rows = []
    for name, series in dataset.data_vars.items():
        if "origin" in series.attrs:
            series = series.transpose("time", ...)
            labels = product(*(series[dim].values for dim in series.dims[1:]))
            numbers = series.values.reshape(len(series), -1).T
            rows += [(" ".join(map(str, (words(str(name)), *which))), unit_of(series), values)
                     for which, values in zip(labels, numbers, strict=True)]  # fmt: skip
    return _course("Observables of your own", rows)


def _course(title: str, rows: list[tuple[str, str, np.ndarray]], below: str = "") -> Table:
    """Numbers through time, of which name, unit and values are given, at the start, minimum, maximum and at the end."""
    lines = []
    for name, unit, values in rows:
        if not np.isfinite(values).any() or (name.startswith("  if") and not np.nan_to_num(values).any()):
            continue  # unknown, or the laws of a body that does not turn at the start
        factor, scaled_unit = scale_of(unit, values)
        shown = [values[0], np.nanmin(values), np.nanmax(values), values[-1]]
        text = name if scaled_unit == "1" else f"{name} ({scaled_unit})"
        lines.append((text, *(f"{value / factor + 0.0:.5g}" if np.isfinite(value) else "-" for value in shown)))
    return Table(title, ("", "start", "minimum", "maximum", "end"), tuple(lines), (_WIDTH, 14, 14, 14, 14), below)


def _regions(dataset: xr.Dataset) -> Table | None:
    if "region" not in dataset.dims:
        return None
    mass, spin = dataset["region_mass"], dataset["region_rotational_to_gravitational"]
    dense, closure = dataset["region_density_max"], dataset["region_ledger_closure"]
    turning = dataset["region_angular_velocity"]
    rate = (turning**2).sum("i", skipna=False) ** 0.5
    factors = [scale_of(unit_of(series), series.values) for series in (mass, turning, dense)]
    rows = tuple(
        (
            str(name),
            f"{float(mass.sel(region=name)[-1]) / factors[0][0]:.5g}",
            f"{float(rate.sel(region=name)[-1]) / factors[1][0]:.5g}",
            f"{_largest(spin.sel(region=name).values):.5g}",
            f"{float(dense.sel(region=name)[-1]) / factors[2][0]:.5g}",
            f"{_largest(closure.sel(region=name).values):.2e}",
        )
        for name in dataset["region"].values
    )
    units = [unit for _, unit in factors]
    below = "masses in {}, mean angular velocities in {}, densities in {}".format(*units) if set(units) != {"1"} else ""
    head = ("region", "mass at end", "spin at end", "maximum T/|W|", "density at end", "ledger closure")
    return Table("Regions", head, rows, (_WIDTH - 14, 14, 14, 16, 16, 16), below)


def _accuracy(dataset: xr.Dataset) -> Table:
    largest = energy_scale(dataset)
    total = dataset["total_energy"].values
    size, turning = angular_momentum_scale(dataset)
    drift = _drift(dataset["angular_momentum"])
    mass, spread = dataset["mass"].values, np.sqrt(2.0 * dataset["mass"].values * abs(dataset["kinetic_energy"].values))
    pushed = np.linalg.norm(dataset["momentum"].transpose("time", "i").values, axis=1)
    rows = [
        ("ledger closure", _largest(dataset["ledger_closure"].values), "of the largest inertia tensor"),
        ("change of the total energy", _largest(total - total[0]) / largest, "of the largest energy"),
        (
            "integration error of the energy",
            _largest(dataset["integration_energy_error"].values) / largest,
            "of the largest energy",
        ),
        (
            "change of the angular momentum",
            drift / (size or np.nan),
            of_size := "of the largest angular momentum" if turning else "of √(tr Q tr K), there is no spin",
        ),
        (
            "change of the momentum",
            _largest(pushed - pushed[0]) / (_largest(spread) or np.nan) if mass[0] > 0 else np.nan,
            "of √(2 M E_kin) at its largest",
        ),
    ]
    if "system_angular_momentum" in dataset:  # which what the body accretes, or what is beside it, has a part in
        whole = dataset["system_angular_momentum"]
        most = float(np.linalg.norm(whole, axis=whole.get_axis_num("i")).max())
        share = _drift(whole) / (max(most, size) or np.nan)  # what they exchange may add up to nothing
        rows.insert(4, ("  and of all bodies together", share, "of its largest" if most >= size else of_size))
    finite = tuple((name, f"{value:.2e}", of) for name, value, of in rows if np.isfinite(value))
    below = (_chosen_for(str(dataset.attrs.get("choice", ""))), "" if known_bars(dataset) else _of_bars(dataset))
    return Table("Accuracy and conservation", (), finite, (_WIDTH, 14), "\n".join(filter(None, below)))


def _drift(momentum: xr.DataArray) -> float:
    """The largest change of a vector since the start."""
    values = momentum.transpose("time", "i").values
    return _largest(np.linalg.norm(values - values[0], axis=1))


def _chosen_for(choice: str) -> str:
    """The accuracy that settings were chosen for, and why a larger error is stated; `choice` as the file has it."""
    try:
        kept = json.loads(choice)
    except (ValueError, RecursionError):
        return ""
    said = [kept.get(name) for name in ("accuracy", "stated")] if isinstance(kept, dict) else []
    lines = [" ".join(text.split()) for text in said if isinstance(text, str)]
    return "\n".join(f"{start}{line}." for start, line in zip((_ASKED, ""), lines, strict=False))


def _bars(dataset: xr.Dataset) -> Table:
    bars = {name: bar for name, bar in known_bars(dataset).items() if np.isfinite(bar).any()}
    rows = tuple((words(name), f"{bar[-1]:.2e}", f"{_largest(bar):.2e}") for name, bar in bars.items())
    head = ("error bar", "at the end", "maximum", "over the value")
    return Table("Error bars", head, rows, (_WIDTH, 14, 14), _of_bars(dataset))


def _of_bars(dataset: xr.Dataset) -> str:
    """What the file says of its error bars, or why it has none."""
    comment = " ".join(str(dataset.attrs.get("error_bars_comment", "")).split())
    return f"{comment}." if comment else ""


def _converged(dataset: xr.Dataset) -> Table | None:
    answer = converged.reference(dataset)
    if answer is None:
        return None
    lines = []
    for row in converged.distances(dataset):
        factor, unit = scale_of(row.unit, [row.converged])
        name = row.name if unit == "1" else f"{row.name} ({unit})"
        numbers = (f"{row.converged / factor:.4g}", f"{row.run / factor:.4g}", f"{100.0 * row.distance:+.2f} %")
        lines.append((name, *numbers, f"{100.0 * row.error:.2g} %"))
    head = ("distance to the converged answer", "converged", "this run", "distance", "uncertainty")
    return Table("Distance to the converged answer", head, tuple(lines), (_WIDTH, 14, 14, 14, 14), answer.source)


def _effects(dataset: xr.Dataset) -> Table | None:
    names = known_effects(dataset, "virial_tensor")
    if not names:
        return None
    dataset = dataset.sel(effect=names)
    largest = energy_scale(dataset)
    impulse = angular_impulse(dataset)
    size, turning = angular_momentum_scale(dataset)
    columns = {
        "work / E": dataset["work"].transpose("time", "effect").values[-1] / largest,
        "heating / E": dataset["heating"].transpose("time", "effect").values[-1] / largest,
        "largest dL / L" if turning else "largest dL / Lmax": _largest_each(np.linalg.norm(impulse, axis=-1)) / size,
        "ledger mismatch": _largest_each(dataset["virial_mismatch"].transpose("time", "effect").values),
    }
    columns = {title: values for title, values in columns.items() if np.isfinite(values).any()}
    rows = tuple((name, *(_cell(values[k]) for values in columns.values())) for k, name in enumerate(names))
    below = "E: largest energy of the run"
    if any(title.startswith("largest dL") for title in columns):
        scale = "its angular momentum" if turning else "the largest it could have"
        below += f"; dL: angular momentum that an effect has given, over {scale}"
    return Table("The ledger of effects", ("effect", *columns), rows, (20, *(18 for _ in columns)), below)


def _profile(dataset: xr.Dataset) -> Table | None:
    attrs = dataset.attrs
    if "profile_parts" not in attrs:
        return None
    parts = str(attrs["profile_parts"]).split(", ")
    threads = int(attrs["profile_threads"])
    wall, processor = (np.atleast_1d(attrs[f"profile_{clock}_time"]).astype(float) for clock in ("wall", "processor"))
    parts, wall, processor = [*parts, "all"], np.append(wall, wall.sum()), np.append(processor, processor.sum())
    idle = np.clip(1.0 - processor / np.maximum(threads * wall, 1e-300), 0.0, 1.0)
    rows = tuple(
        (part, f"{seconds:.3g}", f"{share:.1%}", f"{used:.3g}", f"{waiting:.0%}")
        for part, seconds, share, used, waiting in zip(parts, wall, wall / wall[-1], processor, idle, strict=True)
    )
    below = (
        f"idle: share of {threads} threads for that long which is no processor time, waiting for other work included"
    )
    return Table(
        "Where the time went", ("part", "s", "share", "processor s", "idle"), rows, (20, 10, 10, 14, 10), below
    )


def _cell(value: float) -> str:
    return f"{value:.3e}" if np.isfinite(value) else "-"


def _largest_each(values: np.ndarray) -> np.ndarray:
    """The largest size of each column, NaN where nothing is known of it."""
    return np.array([_largest(column) for column in values.T])


def _value(variable: xr.DataArray) -> str:
    factor, unit = scale_of(unit_of(variable), variable.values)
    return written(float(variable), factor, unit)
