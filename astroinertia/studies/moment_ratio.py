"""Moment ratios of the solar system against models, in one call: a Dataset out.

Three models stand beside what is published: the polytrope with the same I/(M R^2), a uniform core in a uniform mantle
(and a crust where it is known), and hydrostatic equilibrium, which turns J2 and the spin into a ratio.
"""

import math
from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from astroinertia.bodies import apsidal
from astroinertia.bodies.clairaut import radau_darwin_moment_ratio
from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.bodies.planets import OWN, MomentRatio, Published, SolarSystemBody, body, solar_system
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.dataset.variables import of_rows
from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.storage import cache
from astroinertia.studies.core_inversion import NOTHING, core_inversion
from astroinertia.studies.core_model_error import NO_MODEL_ERROR, model_error_of
from astroinertia.studies.sweeps import Model, sweep
from astroinertia.studies.two_layers import love_numbers, moment_ratio_of, two_layers

_HOMOGENEOUS_LOVE_NUMBER = 1.5  # no fluid body whose density falls outwards responds more
_INDICES = np.linspace(0.0, 4.5, 46)
_RADAU_DARWIN_LEAST = 0.75  # fluid k2 of the polytrope n = 0.67
_ROUND_OFF = 1e-14  # of a ratio that was computed as 0.4
_CONDENSED = tuple(np.linspace(0.6, 3.5, 6))  # indices between which that of a fluid k2 is found, the ratio to 2e-5
_VERSION = 1  # part of the cache key: raise it when the solutions of polytropes change

TWO_LAYERS = Model(
    lambda mass, radius, **parameters: _two_layer_outputs(mass, radius, **parameters),
    {
        "mass": ("kg", "mass"),
        "radius": ("m", "mean radius"),
        "moment_ratio": ("1", "I/(M R^2), mean moment and mean radius"),
        "core_density": ("kg m-3", "density of the core"),
        "mantle_density": ("kg m-3", "density of the mantle"),
        "core_radius": ("m", "radius of the core"),
    },
    {
        "moment_ratio": ("1", "I/(M R^2), mean moment and mean radius"),
        "core_radius": ("m", "radius of the core"),
        "core_density": ("kg m-3", "density of the core"),
        "mantle_density": ("kg m-3", "density of the mantle"),
        "core_mass_fraction": ("1", "mass of the core over that of the body"),
        "central_condensation": ("1", "central over mean density"),
        "love_number": ("1", "fluid Love number k2"),
    },
)
"""Two uniform layers from mass, radius and two of the other inputs, for `studies.sweeps.sweep`."""


def _two_layer_outputs(mass, radius, **parameters):
    if "core_radius" in parameters:
        parameters["core_radius_ratio"] = parameters.pop("core_radius") / radius
    mean_density = 3 * mass / (4 * np.pi * radius**3)
    layers = two_layers(mean_density, **parameters)
    return {
        "moment_ratio": moment_ratio_of(mean_density, layers),
        "core_radius": layers.core_radius_ratio * radius,
        "core_density": layers.core_density,
        "mantle_density": layers.mantle_density,
        "core_mass_fraction": layers.core_mass_fraction,
        "central_condensation": layers.core_density / mean_density,
        "love_number": love_numbers(layers),
    }


@with_quantities()
def two_layer_sweep(
    name: str | SolarSystemBody, values: dict, fixed: dict | None = None, dask: bool = False
) -> xr.Dataset:
    """Return two-layer models of a body, named or as `own_body` makes it, over all combinations of `values`.

    As `studies.sweeps.sweep` does; values and fixed: of TWO_LAYERS' inputs in SI. Mass and radius are the body's unless
    given; where only one of the densities and the core radius is given, the ratio is the measured one. SceneError as
    there, and for three of them.

    >>> family = two_layer_sweep("Mars", {"core_density": [6000.0, 7000.0]})
    >>> print((family.core_radius / 1e3).values.round())  # km: a denser core is smaller
    [2007. 1737.]
    """
    one = name if isinstance(name, SolarSystemBody) else body(name)
    fixed = {} if fixed is None else dict(fixed)
    inputs = {**values, **fixed}
    for key, value in (("mass", one.mass), ("radius", one.mean_radius)):
        if key not in inputs:
            fixed[key] = value
    parameters = [key for key in inputs if key not in ("mass", "radius")]
    if len(parameters) == 1 and parameters != ["moment_ratio"]:
        fixed["moment_ratio"] = one.moment_ratio().value
        parameters.append("moment_ratio")
    if len(parameters) != 2:
        raise SceneError(
            f"two layers of {one.name} follow from two of moment_ratio, core_density, mantle_density and core_radius, "
            "or from one of the last three and the published ratio"
        )
    family = sweep(TWO_LAYERS, values, fixed, dask)
    family.attrs |= {"body": one.name, "title": f"two-layer models of {one.name}"}
    if one.has("core_radius"):
        core = one.adopted("core_radius")
        family.attrs |= {"published_core_radius": core.value, "published_core_radius_uncertainty": core.uncertainty}
    return family


@with_quantities()
def polytropes(indices: Iterable[float] = _INDICES) -> xr.Dataset:
    """Return I/(M R^2) and rho_c over the mean density of polytropes along `index`, 0 <= n < 5.

    >>> print(polytropes([0.0, 1.0]).moment_ratio.values.round(6))  # 2/5 and (2/3)(1 - 6/pi^2)
    [0.4      0.261382]
    """
    indices = np.asarray(list(indices), dtype=float)
    solutions = [lane_emden(float(index)) for index in indices]
    return xr.Dataset(
        {
            "moment_ratio": ("index", [body.moment_ratio for body in solutions], {"long_name": "I/(M R^2)"}),
            "central_condensation": (
                "index", [body.central_to_mean for body in solutions], {"long_name": "central over mean density"},
            ),
        },
        {"index": ("index", indices, {"units": "1", "long_name": "polytropic index n"})},
    )  # fmt: skip


@lru_cache(maxsize=1)
def _splines() -> tuple[CubicSpline, CubicSpline, CubicSpline]:
    """Index by moment ratio, logarithm of the central condensation by index, and moment ratio by index."""
    sequence = _sequence()
    ratio = sequence["moment_ratio"]
    by_ratio = CubicSpline(ratio[::-1], _INDICES[::-1])
    by_index = CubicSpline(_INDICES, ratio)
    return by_ratio, CubicSpline(_INDICES, np.log(sequence["central_condensation"])), by_index


@lru_cache(maxsize=1)
def _sequence() -> dict[str, np.ndarray]:
    """Moment ratio and central condensation along _INDICES, k2 along _CONDENSED; kept in the user's cache."""
    key = cache.content_key(indices=_INDICES, condensed=_CONDENSED, version=_VERSION)
    lengths = {"moment_ratio": len(_INDICES), "central_condensation": len(_INDICES), "love_number": len(_CONDENSED)}
    stored = cache.load("polytropes", key)
    if stored is not None and {name: array.size for name, array in stored.items()} == lengths:
        return stored
    sequence = {str(name): variable.values for name, variable in polytropes().data_vars.items()}
    computed = sequence | {"love_number": np.array([apsidal.love_number(index) for index in _CONDENSED])}
    cache.save("polytropes", key, computed)
    return computed


@with_quantities()
def polytropic_index(ratio) -> np.ndarray:
    """Return the index of the polytrope with this I/(M R^2), to 1e-5; NaN above 0.4 and below 0.0069 (n = 4.5).

    >>> print(f"{float(polytropic_index(0.2046)):.3f}")
    1.500
    """
    ratio = np.asarray(ratio, dtype=float)
    possible = (ratio <= UNIFORM * (1 + _ROUND_OFF)) & (ratio >= _sequence()["moment_ratio"][-1])
    return np.where(possible, _splines()[0](np.where(possible, np.minimum(ratio, UNIFORM), UNIFORM)), np.nan)


@with_quantities()
def fluid_love_number(one: SolarSystemBody) -> float:
    """Return the fluid k2 that J2 (and C22, where tides act) of a body stands for if it is in equilibrium, else NaN.

    3 J2/m for a free body, 4 C22/m for a synchronous one (its J2 is 5/6 k2 m), m = Omega^2 R^3/(GM), first order in m.
    NaN where no coefficient or no spin is known, and where k2 is above that of a homogeneous fluid: the figure is not a
    fluid's.
    Source: Murray & Dermott 1999, Solar System Dynamics, sect. 4.7; Hubbard & Anderson 1978, Icarus 33, 336.

    >>> print(f"{fluid_love_number(body('Earth')):.3f}")  # 3 J2/m
    0.944
    """
    if not one.has("rotation_rate") or not one.has("c22" if one.synchronous else "j2"):
        return np.nan
    if one.synchronous:
        c22 = one.adopted("c22")
        love = 4 * c22.value * (c22.radius / one.mean_radius) ** 2 / one.small_m
    else:
        love = 3 * one.zonal_harmonic(one.mean_radius) / one.small_m
    return love if love <= _HOMOGENEOUS_LOVE_NUMBER else np.nan


@with_quantities()
def hydrostatic_moment_ratio(love_number: float) -> float:
    """Return I/(M R^2) of a fluid body with this k2: Radau-Darwin down to 0.75, below the polytrope with this k2.

    Both agree to 2e-4 above; below, Radau-Darwin leaves every condensed body (0.005 off at n = 1.3, 0.07 at n = 3),
    while the answer depends on the profile: two layers with the same k2 have another ratio. NaN for NaN and for k2
    below that of n = 3.5.

    >>> print(f"{hydrostatic_moment_ratio(1.5):.4f}")  # k2 of a homogeneous fluid
    0.4000
    """
    if love_number >= _RADAU_DARWIN_LEAST:
        return float(radau_darwin_moment_ratio(np.float64(love_number)))
    if not love_number >= _sequence()["love_number"][-1]:
        return math.nan
    index = _index_by_love_number()(math.log(love_number))
    return float(_splines()[2](index))


@lru_cache(maxsize=1)
def _index_by_love_number() -> CubicSpline:
    logs = np.log(_sequence()["love_number"])
    return CubicSpline(logs[::-1], np.array(_CONDENSED)[::-1])


@with_quantities()
def synchronous_share(one: SolarSystemBody) -> float:
    """Return 5/2 for a synchronous moon, whose J2 tides make that much larger than its spin alone would, else 1.

    >>> print(synchronous_share(body("Io")))
    2.5
    """
    return 2.5 if one.synchronous else 1.0


@with_quantities()
def moment_ratio(names: Iterable[str | SolarSystemBody] | str | SolarSystemBody | None = None) -> xr.Dataset:
    """Return published moment ratios of bodies (all of the table unless named) beside those of models, along `body`.

    A name may be a body itself, as `own_body` makes one; a single one need not be in a list.

    All ratios are of the mean moment for the mean radius; `published_*` is what the source says, for its own radius and
    moment. SI units. Lows and highs are the 16th and 84th percentile of the errors carried through the inversion.
    SceneError for a name that is not in the table.

    >>> print(moment_ratio(["Earth", "Mars"]).moment_ratio.values.round(4))  # that of Mars is the larger one
    [0.3307 0.3643]
    """
    listed = [names] if isinstance(names, str | SolarSystemBody) else solar_system() if names is None else names
    bodies = [one if isinstance(one, SolarSystemBody) else body(one) for one in listed]
    return xr.Dataset(
        of_rows("body", map(_column, bodies), _VARIABLES),
        {"body": [one.name for one in bodies]},
        {"title": "moment ratios of the solar system", "ratios": "mean moment over M R^2, R the mean radius"},
    )


_VARIABLES = {
    "mass": ("kg", "mass"),
    "mean_radius": ("m", "mean radius"),
    "mean_density": ("kg m-3", "mean density"),
    "angular_velocity": ("rad s-1", "sidereal rate of spin"),
    "small_m": ("1", "Omega^2 R^3/(G M)"),
    "zonal_harmonic_2": ("1", "J2 for the mean radius"),
    "published_moment_ratio": ("1", "moment ratio as published"),
    "published_radius": ("m", "radius that it is normalised with"),
    "published_kind": ("", "moment that it is of: mean or polar; nothing without a published ratio"),
    "status": ("", "how it is known"),
    "source": ("", "source of the ratio"),
    "moment_ratio": ("1", "I/(M R^2)"),
    "moment_ratio_uncertainty": ("1", "standard deviation of I/(M R^2)"),
    "polytropic_index": ("1", "index of the polytrope with this I/(M R^2)"),
    "fluid_love_number": ("1", "k2 that J2 or C22 stands for in hydrostatic equilibrium"),
    "hydrostatic_moment_ratio": ("1", "I/(M R^2) from it (Radau-Darwin; of condensed bodies that of the polytrope)"),
    "core_radius": ("m", "radius of a uniform core in a uniform mantle"),
    "core_radius_low": ("m", "16th percentile of it"),
    "core_radius_high": ("m", "84th percentile of it"),
    "core_radius_model_error": ("m", "change of it by compression and a third layer, which uniform layers leave out"),
    "core_radius_compression": ("m", "change of it by compression alone"),
    "core_radius_third_layer": ("m", "change of it by a third layer alone"),
    "core_density": ("kg m-3", "density of the core"),
    "mantle_density": ("kg m-3", "density of the mantle"),
    "assumed": ("", "what the inversion to a core assumes"),
    "published_core_radius": ("m", "published core radius"),
    "published_core_radius_uncertainty": ("m", "standard deviation of it"),
    "central_condensation": ("1", "central over mean density"),
    "central_condensation_uncertainty": ("1", "standard deviation of it"),
    "central_condensation_source": ("", "where the central density is from"),
}


_NO_RATIO = Published(np.nan, np.nan, "1", OWN, True, np.nan, "", "")


def _column(one: SolarSystemBody) -> dict:
    rows = [row for name in ("polar_moment_ratio", "mean_moment_ratio") for row in one.published.get(name, ())]
    row = next((published for published in rows if published.adopted), _NO_RATIO)
    published = _NO_RATIO if row.status == OWN else row
    ratio = one.moment_ratio() if rows else MomentRatio(np.nan, np.nan, "mean", one.mean_radius, OWN, "")
    love = fluid_love_number(one)
    inversion, beyond = (core_inversion(one), model_error_of(one)) if rows else (NOTHING, NO_MODEL_ERROR)
    index = float(polytropic_index(ratio.value))
    core = one.adopted("core_radius") if one.has("core_radius") else None
    inverted = np.isfinite(inversion.core_density)
    condensation, spread, source = np.nan, np.nan, ""
    if one.has("central_density"):
        condensation, source = one.value("central_density") / one.mean_density, "published"
    elif inverted:
        condensation, source = inversion.core_density / one.mean_density, "two layers"
        spread = inversion.core_density_deviation / one.mean_density
    elif row.status == "model":
        condensation, source = float(np.exp(_splines()[1](index))), "polytrope"
    return {
        "mass": one.mass,
        "mean_radius": one.mean_radius,
        "mean_density": one.mean_density,
        "angular_velocity": one.value("rotation_rate"),
        "small_m": one.small_m if one.has("rotation_rate") else np.nan,
        "zonal_harmonic_2": one.zonal_harmonic(one.mean_radius) if one.has("j2") else np.nan,
        "published_moment_ratio": published.value,
        "published_radius": published.radius,
        "published_kind": _kind(one, published),
        "status": row.status,
        "source": row.source,
        "moment_ratio": ratio.value,
        "moment_ratio_uncertainty": ratio.uncertainty,
        "polytropic_index": index,
        "fluid_love_number": love,
        "hydrostatic_moment_ratio": hydrostatic_moment_ratio(love),
        "core_radius": inversion.core_radius,
        "core_radius_low": inversion.core_radius_low,
        "core_radius_high": inversion.core_radius_high,
        "core_radius_model_error": beyond.both,
        "core_radius_compression": beyond.compression,
        "core_radius_third_layer": beyond.third_layer,
        "core_density": inversion.core_density,
        "mantle_density": inversion.mantle_density,
        "assumed": inversion.assumed,
        "published_core_radius": np.nan if core is None else core.value,
        "published_core_radius_uncertainty": np.nan if core is None else core.uncertainty,
        "central_condensation": condensation,
        "central_condensation_uncertainty": spread,
        "central_condensation_source": source,
    }


def _kind(one: SolarSystemBody, ratio: Published) -> str:
    """Of which moment a published ratio is; nothing where none is published."""
    kinds = {"polar_moment_ratio": "polar", "mean_moment_ratio": "mean"}
    return next((kind for name, kind in kinds.items() if ratio in one.published.get(name, ())), "")
