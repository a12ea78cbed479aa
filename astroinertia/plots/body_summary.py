"""The inertia of a body in words and numbers, for the terminal, and as plain values for other programs."""

import math
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.inertia.tensor import require_plausible
from astroinertia.plots.shown_units import cleared
from astroinertia.units import unit_of

_WIDTH, _COLUMN = 30, 15


def body_summary(dataset: xr.Dataset) -> str:
    """All that studies.moments found, one fact a line; an axis without a direction of its own says so.

    >>> from astroinertia.studies.moments import moments, read_matter
    >>> print(body_summary(moments(read_matter("runs/star"))).splitlines()[3])
    mass (kg)                         1.98841e+30
    """
    whole = [
        _title(dataset),
        "\n".join([_row("mass", dataset["mass"]), _row("centre of mass  (x y z)", dataset["centre_of_mass"])]),
        _tensor(dataset),
        _principal(dataset),
        _rest(dataset),
        *([_gravity_field(dataset)] if "harmonic_coefficient" in dataset else []),
    ]
    return "\n\n".join(whole)


def plain_values(dataset: xr.Dataset) -> dict[str, Any]:
    """The dataset as numbers, lists and texts that JSON can hold; what is undefined is None.

    >>> from astroinertia.studies.moments import moments, read_matter
    >>> print(plain_values(moments(read_matter("runs/star")))["mass"]["units"])
    kg
    """
    return {str(name): str(text) for name, text in dataset.attrs.items()} | {
        str(name): {"value": _plain(variable.values.tolist()), "units": unit_of(variable)}
        for name, variable in dataset.data_vars.items()
    }


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(element) for element in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _title(dataset: xr.Dataset) -> str:
    point = ", ".join(f"{value:.7g}" for value in dataset["origin"].values)
    where = "centre of mass" if _about_centre(dataset) else f"point ({point})"
    return f"{dataset.attrs['title']}\nall about the {where}" + (", in SI" if unit_of(dataset["mass"]) != "1" else "")


def _about_centre(dataset: xr.Dataset) -> bool:
    return dataset.attrs["about"] == "centre of mass"


def _tensor(dataset: xr.Dataset) -> str:
    inertia = dataset["inertia_tensor"]
    rows = inertia.transpose("i", "j").values
    rows = cleared(rows, abs(rows).max())
    lines = [_name("inertia tensor", inertia) + "".join(f"{letter:>{_COLUMN}}" for letter in "xyz")]
    return "\n".join(lines + [f"{letter:>{_WIDTH}}" + _numbers(row) for letter, row in zip("xyz", rows, strict=True)])


def _principal(dataset: xr.Dataset) -> str:
    defined = dataset["axis_defined"].values.astype(bool)
    axes = dataset["principal_axes"].transpose("principal", "i").values
    lines = [f"{'principal axis':{_WIDTH}}" + "".join(f"{number:>{_COLUMN}}" for number in (1, 2, 3))]
    lines.append(_row("moment", dataset["principal_moments"]))
    for component, letter in enumerate("xyz"):
        cells = [
            f"{axes[k, component] + 0.0:>{_COLUMN}.7f}" if defined[k] else f"{'undefined':>{_COLUMN}}" for k in range(3)
        ]
        lines.append(f"{'direction  ' + letter:{_WIDTH}}" + "".join(cells))
    lines.append(_row("gap to the nearest moment", dataset["principal_gap"]))
    lines.append(_row("radius of gyration", dataset["radius_of_gyration"]))
    lines.append(_row("I/(M R^2)", dataset["moment_ratio"]))
    if _about_centre(dataset):
        lines.append(_row("equivalent semi-axis", dataset["semi_axes"]))
    return "\n".join(lines)


def _rest(dataset: xr.Dataset) -> str:
    own = [] if _about_centre(dataset) else [_row("equivalent semi-axes", dataset["semi_axes"]) + "   about the centre"]
    lines = [
        *own,
        _row("R", dataset["reference_radius"]) + f"   {dataset.attrs['radius_convention']}",
        _row("triaxiality", dataset["triaxiality"]) + "   0 oblate, 1 prolate; of the equivalent ellipsoid",
    ]
    if "axis" in dataset:
        lines += [
            "",
            _row("chosen axis  (x y z)", dataset["axis"]),
            _row("moment about it", dataset["axis_moment"]),
            _row("radius of gyration about it", dataset["axis_radius_of_gyration"]),
        ]
    try:
        require_plausible(dataset["inertia_tensor"].values)
    except ValueError as error:
        lines += ["", f"not the tensor of a body of positive mass: {error}"]
    if not dataset["axis_defined"].values.all():
        tolerance = float(dataset.attrs["gap_tolerance"])
        lines += ["", f"undefined: moments equal to {tolerance:g} of the largest; any direction in their plane will do"]
    return "\n".join(lines)


def _gravity_field(dataset: xr.Dataset) -> str:
    coefficients, zonal = dataset["harmonic_coefficient"], dataset["zonal_harmonic"].values
    cosine, sine = coefficients.transpose("part", "degree", "order").values
    # What is nothing but round-off is shown as 0.
    cosine, sine, zonal = (np.where(abs(values) > 1e-15, values, 0.0) for values in (cosine, sine, zonal))
    lines = [
        f"gravity field with that R; {coefficients.attrs['comment']}",
        f"{'l':>4}{'m':>4}{'C':>18}{'S':>18}{'J, not normalised':>22}",
    ]
    for degree, order in zip(*np.tril_indices(len(zonal)), strict=True):
        last = f"{zonal[degree]:>22.9g}" if order == 0 and degree > 1 else ""
        lines.append(f"{degree:>4}{order:>4}{cosine[degree, order]:>18.9g}{sine[degree, order]:>18.9g}{last}")
    return "\n".join(lines)


def _name(text: str, variable: xr.DataArray) -> str:
    unit = unit_of(variable)
    return f"{text if unit == '1' else f'{text} ({unit})':{_WIDTH}}"


def _row(text: str, variable: xr.DataArray) -> str:
    return _name(text, variable) + _numbers(np.atleast_1d(variable.values))


def _numbers(values: np.ndarray) -> str:
    return "".join(
        f"{value + 0.0:>{_COLUMN}.7g}" if np.isfinite(value) else f"{'undefined':>{_COLUMN}}" for value in values
    )
