"""How far rotation flattens a body: flattening and J2 along the rate of spin, and of the planets against measured.

Uniform bodies are Maclaurin spheroids, exact; layers and polytropes are solved by the theory of figures to round-off
(bodies.figures), with the first-order answer of Clairaut's equation beside it for layers.
"""

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import xarray as xr

from astroinertia.bodies import maclaurin
from astroinertia.bodies.clairaut import hydrostatic_figure
from astroinertia.bodies.figures import RotatingFigure, figure_of_density, figure_of_polytrope
from astroinertia.bodies.layered import constant_layers
from astroinertia.bodies.planets import SolarSystemBody, body
from astroinertia.dataset.variables import of_rows, variables
from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.studies.core_inversion import core_inversion
from astroinertia.studies.moment_ratio import polytropic_index
from astroinertia.studies.two_layers import radii_and_densities

_QUANTITIES = {
    "flattening": "1 - c/a",
    "axis_ratio": "c/a",
    "zonal_harmonic_2": "J2 for the equatorial radius",
    "polar_moment_ratio_equatorial": "C/(M a^2), a the equatorial radius",
    "rotational_to_gravitational": "T/|W|",
    "rotation_parameter": "Omega^2 a^3/(G M)",
}
FREE = ("Mercury", "Venus", "Earth", "Mars", "Jupiter", "Saturn", "Uranus", "Neptune", "Ceres", "Vesta")


@with_quantities()
def flattening_sequence(
    small_m: Iterable[float],
    index: float | None = None,
    outer_radii: Sequence[float] | None = None,
    densities: Sequence[float] | None = None,
) -> xr.Dataset:
    """Return the figure of a body along small_m = Omega^2 R^3/(G M), R the radius of the sphere of the same volume.

    index: of a polytrope, or 0 for a uniform body; else outer_radii and densities of uniform layers from the centre
    outwards, in any units. Where the body cannot rotate that fast, or its figure is not found, all is NaN. For layers
    and the uniform body `flattening_first_order` and `zonal_harmonic_2_first_order` are Clairaut's. SceneError for
    arguments that are no body, and for negative small_m.

    >>> print(flattening_sequence([0.01], index=0).flattening.values.round(4))  # about (5/4) m of a uniform body
    [0.0125]
    """
    rates = np.asarray(list(small_m), dtype=float)
    if rates.ndim != 1 or not rates.size or not (rates >= 0).all() or not np.isfinite(rates).all():
        raise SceneError(
            "small_m, the square of the rate of spin over that of a close orbit, is finite and not negative"
        )
    layered = outer_radii is not None and densities is not None
    if layered == (index is not None) or (outer_radii is None) != (densities is None):
        raise SceneError("a body is either a polytrope with its index, or layers with outer_radii and densities")
    try:
        solver = _solver(index, outer_radii, densities)
        rows = [_figure(solver, float(rate)) for rate in rates]
    except ValueError as error:
        raise SceneError(str(error)) from error
    columns = zip(_QUANTITIES.items(), np.array(rows).T, strict=True)
    dataset = xr.Dataset(
        variables("small_m", {name: (column, "1", text) for (name, text), column in columns}),
        variables("small_m", {"small_m": (rates, "1", "Omega^2 R^3/(G M)")}),
    )
    if layered or index == 0:
        one = constant_layers(*([1.0], [1.0]) if not layered else (np.array(outer_radii), np.array(densities)))
        k2 = float(hydrostatic_figure(one, 0.0).love_number)
        dataset["flattening_first_order"] = dataset["small_m"] * (1 + k2) / 2
        dataset["zonal_harmonic_2_first_order"] = dataset["small_m"] * k2 / 3
        dataset.attrs["love_number"] = k2
    return dataset


@with_quantities()
def flattening(names: Iterable[str] | str | None = None) -> xr.Dataset:
    """Return measured flattening and J2 beside those of hydrostatic models that spin as fast, along `body`.

    Models: a uniform body, the uniform layers of `core_inversion`, and the polytrope with the same moment ratio; NaN
    where there is none. `*_excess` is measured over the model, less one: of layers where there are, else of the
    polytrope. Bodies that tides hold synchronous have a third axis and are refused. SceneError for these and for names
    that are not in the table.

    >>> earth = flattening(["Earth"]).isel(body=0)
    >>> print([f"{1 / float(earth[name]):.0f}" for name in ("flattening_measured", "flattening_layers")])
    ['298', '300']
    """
    chosen = [names] if isinstance(names, str) else list(FREE if names is None else names)
    bodies = [body(name) for name in chosen]
    for one in bodies:
        if one.synchronous:
            raise SceneError(f"{one.name} is held synchronous by tides, which stretch it along a third axis")
    dataset = xr.Dataset(
        of_rows("body", map(_compared, bodies), {name: ("1", text) for name, text in _COMPARED.items()}),
        {"body": [one.name for one in bodies]},
        {"title": "flattening and J2, measured and hydrostatic"},
    )
    for name in ("flattening", "zonal_harmonic_2"):
        model = dataset[f"{name}_layers"].fillna(dataset[f"{name}_polytrope"])
        dataset[f"{name}_excess"] = dataset[f"{name}_measured"] / model - 1
        dataset[f"{name}_excess"].attrs = {"units": "1", "long_name": "measured over hydrostatic, less one"}
    return dataset


_COMPARED = {
    "small_m": "Omega^2 R^3/(G M)",
    "flattening_measured": "1 - c/a of the published radii",
    "flattening_uniform": "that of a Maclaurin spheroid",
    "flattening_layers": "that of uniform layers with the published moment ratio",
    "flattening_polytrope": "that of the polytrope with the published moment ratio",
    "zonal_harmonic_2_measured": "J2 for the published equatorial radius",
    "zonal_harmonic_2_uniform": "that of a Maclaurin spheroid",
    "zonal_harmonic_2_layers": "that of uniform layers with the published moment ratio",
    "zonal_harmonic_2_polytrope": "that of the polytrope with the published moment ratio",
}


def _compared(one: SolarSystemBody) -> dict[str, float]:
    column = dict.fromkeys(_COMPARED, math.nan)
    column["small_m"] = one.small_m
    column["flattening_measured"] = one.flattening or math.nan  # radii published as equal resolve no flattening
    column["zonal_harmonic_2_measured"] = one.zonal_harmonic() if one.has("j2") else math.nan
    layers = core_inversion(one).layers
    index = float(polytropic_index(one.moment_ratio().value))
    models = {"uniform": _solver(0.0, None, None)}
    if layers is not None and math.isfinite(layers.core_density):
        models["layers"] = _solver(None, *radii_and_densities(layers))
    if math.isfinite(index):
        models["polytrope"] = _solver(index, None, None)
    for model, solver in models.items():
        shape, _, j2, *_ = _figure(solver, one.small_m)
        column |= {f"flattening_{model}": shape, f"zonal_harmonic_2_{model}": j2}
    return column


def _solver(index, outer_radii, densities) -> Callable[[float], tuple[float, ...]]:
    if index is None:
        return lambda rate: _of_figure(figure_of_density(list(outer_radii), list(densities), small_m=rate))
    if index == 0:
        return _spheroid
    return lambda rate: _of_figure(figure_of_polytrope(index, small_m=rate))


def _figure(solver: Callable[[float], tuple[float, ...]], rate: float) -> tuple[float, ...]:
    try:
        return solver(rate)
    except NumericalError:
        return (math.nan,) * len(_QUANTITIES)


def _of_figure(figure: RotatingFigure) -> tuple[float, ...]:
    return (
        figure.flattening,
        1 - figure.flattening,
        float(figure.zonal_harmonics[0]),
        figure.polar_moment_ratio_equatorial,
        figure.rotational_to_gravitational,
        figure.rotation_parameter,
    )


def _spheroid(rate: float) -> tuple[float, ...]:
    """The Maclaurin spheroid, slow branch; Omega^2/(pi G rho) is (4/3) small_m."""
    if 4 / 3 * rate > maclaurin.fastest().omega2:
        return (math.nan,) * len(_QUANTITIES)
    spheroid = maclaurin.from_angular_velocity(math.sqrt(rate), mass=1.0, mean_radius=1.0, gravitational_constant=1.0)
    a = (1 - spheroid.flattening) ** (-1 / 3)
    return (
        spheroid.flattening,
        1 - spheroid.flattening,
        spheroid.second_zonal_harmonic,
        0.4,
        spheroid.rotational_to_gravitational,
        rate * a**3,
    )
