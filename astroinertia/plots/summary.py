"""A run in words and numbers, for the terminal."""

import numpy as np
import xarray as xr

from astroinertia.dataset_resolution import told
from astroinertia.inertia.tensor import axial_vector
from astroinertia.plots.error_bars import known_bars
from astroinertia.plots.scales import angular_momentum_scale, energy_scale, known_effects
from astroinertia.plots.style import scale_of, unit_of, words

_WIDTH = 34


def summary(dataset: xr.Dataset) -> str:
    """Size, spin, shape, accuracy and the effects' shares, one fact a line."""
    parts = [
        _heading(dataset),
        _body(dataset),
        _regions(dataset),
        _accuracy(dataset),
        _bars(dataset),
        _effects(dataset),
    ]
    parts.append(told(dataset.attrs))
    return "\n\n".join(part for part in parts if part)


def _heading(dataset: xr.Dataset) -> str:
    attrs = dataset.attrs
    lines = [f"{attrs.get('name', 'run')}: {attrs.get('description', '')}".rstrip(": ")]
    how = ", ".join(str(attrs[name]) for name in ("model", "engine", "precision") if name in attrs)
    time = dataset["time"]
    steps = dataset["step"].values
    counted = f"{int(steps[-1])} steps, " if np.isfinite(steps[-1]) else ""
    wall = float(dataset["wall_time"][-1])
    took = f", computed in {wall:.0f} s" if np.isfinite(wall) else ""
    lines.append(f"{how}; {_value(time[-1])} in {counted}{dataset.sizes['time']} outputs{took}")
    return "\n".join(lines)


def _body(dataset: xr.Dataset) -> str:
    found = dataset.inertia
    rows = [
        ("moment of inertia about z", found.about_axis("z")),
        ("mean radius, equivalent ellipsoid", dataset["mean_radius"]),
        ("greatest density", dataset["density_max"]),
        ("flattening", dataset["flattening"]),
        ("moment ratio I/(M R^2)", dataset["moment_ratio"]),
    ]
    if angular_momentum_scale(dataset)[1]:
        rows += [
            ("mean spin", found.spin_rate()),
            ("  if it went as 1/I", found.spin_scaling("inertia")),
            ("  if it went as 1/R^2", found.spin_scaling("radius")),
            ("T/|W|", dataset["rotational_to_gravitational"]),
        ]
    lines = [f"{'':{_WIDTH}}{'start':>14}{'least':>14}{'greatest':>14}{'end':>14}"]
    for name, series in rows:
        values = series.values
        if not np.isfinite(values).any() or (name.startswith("  if") and not np.nan_to_num(values).any()):
            continue  # unknown, or the laws of a body that does not turn at the start
        factor, unit = scale_of(unit_of(series), values)
        shown = [values[0], np.nanmin(values), np.nanmax(values), values[-1]]
        text = name if unit == "1" else f"{name} ({unit})"
        cells = "".join(f"{value / factor:>14.5g}" for value in shown)
        if len(text) > _WIDTH:  # a long unit gets a line of its own rather than pushing the columns
            lines.append(text)
            text = ""
        lines.append(f"{text:{_WIDTH}}{cells}")
    return "\n".join(lines)


def _regions(dataset: xr.Dataset) -> str:
    if "region" not in dataset.dims:
        return ""
    lines = [
        f"{'region':{_WIDTH}}{'mass at end':>14}{'greatest T/|W|':>16}{'density at end':>16}{'ledger closure':>16}"
    ]
    mass, spin = dataset["region_mass"], dataset["region_rotational_to_gravitational"]
    dense, closure = dataset["region_density_max"], dataset["region_ledger_closure"]
    factors = [scale_of(unit_of(series), series.values) for series in (mass, dense)]
    for name in dataset["region"].values:
        cells = [
            f"{float(mass.sel(region=name)[-1]) / factors[0][0]:>14.5g}",
            f"{_largest(spin.sel(region=name).values):>16.5g}",
            f"{float(dense.sel(region=name)[-1]) / factors[1][0]:>16.5g}",
            f"{_largest(closure.sel(region=name).values):>16.2e}",
        ]
        lines.append(f"{name:{_WIDTH}}{''.join(cells)}")
    units = " and ".join(unit for _, unit in factors if unit != "1")
    return "\n".join([*lines, f"masses and densities in {units}"] if units else lines)


def _accuracy(dataset: xr.Dataset) -> str:
    largest = energy_scale(dataset)
    total = dataset["total_energy"].values
    momentum = dataset["angular_momentum"].transpose("time", "i").values
    size, turning = angular_momentum_scale(dataset)
    drift = _largest(np.linalg.norm(momentum - momentum[0], axis=1)) / size
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
            drift,
            "of the largest angular momentum" if turning else "of 2 (tr Q tr K)^1/2, there is no spin",
        ),
        (
            "change of the momentum",
            _largest(pushed - pushed[0]) / _largest(spread) if mass[0] > 0 else np.nan,
            "of (2 M E_kin)^1/2 at its largest",
        ),
    ]
    return "\n".join(f"{name:{_WIDTH}}{value:>14.2e}  {of}" for name, value, of in rows if np.isfinite(value))


def _bars(dataset: xr.Dataset) -> str:
    told = {name: bar for name, bar in known_bars(dataset).items() if np.isfinite(bar).any()}
    lines = [f"{'error bar':{_WIDTH}}{'at the end':>14}{'greatest':>14}  over the value"] if told else []
    lines += [f"{words(name):{_WIDTH}}{bar[-1]:>14.2e}{_largest(bar):>14.2e}" for name, bar in told.items()]
    return "\n".join(lines)


def _effects(dataset: xr.Dataset) -> str:
    names = known_effects(dataset, "virial_tensor")
    if not names:
        return ""
    dataset = dataset.sel(effect=names)
    largest = energy_scale(dataset)
    given = np.linalg.norm(axial_vector(dataset["mixed_impulse"].transpose("time", "effect", "i", "j").values), axis=-1)
    size, turning = angular_momentum_scale(dataset)
    columns = {
        "work / E": dataset["work"].transpose("time", "effect").values[-1] / largest,
        "heating / E": dataset["heating"].transpose("time", "effect").values[-1] / largest,
        "largest dL / L" if turning else "largest dL / Lmax": _largest_each(given) / size,
        "ledger mismatch": _largest_each(dataset["virial_mismatch"].transpose("time", "effect").values),
    }
    columns = {title: values for title, values in columns.items() if np.isfinite(values).any()}
    lines = [f"{'effect':20}" + "".join(f"{title:>18}" for title in columns)]
    for index, name in enumerate(names):
        lines.append(f"{name:20}" + "".join(_cell(values[index]) for values in columns.values()))
    return "\n".join(lines)


def _cell(value: float) -> str:
    return f"{value:>18.3e}" if np.isfinite(value) else f"{'-':>18}"


def _largest_each(values: np.ndarray) -> np.ndarray:
    """The largest size of each column, NaN where nothing is known of it."""
    return np.array([_largest(column) for column in values.T])


def _largest(values: np.ndarray) -> float:
    """The largest size, NaN where nothing is known."""
    sizes = abs(values[np.isfinite(values)])
    return float(sizes.max()) if len(sizes) else np.nan


def _value(variable: xr.DataArray) -> str:
    factor, unit = scale_of(unit_of(variable), variable.values)
    return f"{float(variable) / factor:.4g} {unit}".removesuffix(" 1")
