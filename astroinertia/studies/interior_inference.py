"""Which interiors of two or three uniform layers agree with what is measured: posteriors as xarray.

The layers are solved exactly from mean density, moment ratio and one more number (`studies.two_layers`), so
that what is measured best is a coordinate of the sampling and not a thin curved sheet in it. The prior is flat in those
coordinates but for what `assumed` says. Fluid responses (love_number, zonal_harmonic_2, flattening) come from
Clairaut's equation for the layers: an elastic tidal k2 is not one of them and must not be given as such.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.bodies.planets import SolarSystemBody, body
from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.studies.core_inversion import assumed_layers
from astroinertia.studies.moment_ratio import fluid_love_number, synchronous_share
from astroinertia.studies.sampling import sample
from astroinertia.studies.two_layers import love_numbers, three_layers, two_layers
from astroinertia.units import in_unit, stated

CHOICES = ("core_density", "mantle_density", "core_radius_ratio")
CRUST = ("crust_share", "crust_density")
DERIVED = {
    "mean_density": ("kg m-3", "mean density"),
    "moment_ratio": ("1", "I/(M R^2), mean moment and mean radius"),
    "core_radius_ratio": ("1", "core radius over that of the body"),
    "core_density": ("kg m-3", "density of the core"),
    "mantle_density": ("kg m-3", "density of the mantle"),
    "crust_share": ("1", "thickness of the crust over the radius"),
    "crust_density": ("kg m-3", "density of the crust"),
    "love_number": ("1", "fluid Love number k2"),
    "zonal_harmonic_2": ("1", "hydrostatic J2 for the mean radius, to first order"),
    "flattening": ("1", "hydrostatic flattening, to first order"),
}
_FLUID = ("love_number", "zonal_harmonic_2", "flattening")
_TRIES = 400  # of positions for each walker to begin at


@dataclass(frozen=True)
class Gaussian:
    """A number known with a standard deviation."""

    mean: float
    deviation: float

    def log_density(self, values: np.ndarray) -> np.ndarray:
        """Logarithm of the density, but for a constant."""
        return -0.5 * ((values - self.mean) / self.deviation) ** 2

    def draw(self, generator: np.random.Generator, count: int) -> np.ndarray:
        """Random values."""
        return generator.normal(self.mean, self.deviation, count)

    def check(self) -> str:
        """What is wrong with it, or nothing."""
        good = math.isfinite(self.mean) and 0.0 < self.deviation < math.inf
        return "" if good else "a finite mean and a deviation above 0"


@dataclass(frozen=True)
class Uniform:
    """A number somewhere between two, none more likely than another."""

    low: float
    high: float

    def log_density(self, values: np.ndarray) -> np.ndarray:
        """Zero inside, -inf outside."""
        return np.where((values >= self.low) & (values <= self.high), 0.0, -np.inf)

    def draw(self, generator: np.random.Generator, count: int) -> np.ndarray:
        """Random values."""
        return generator.uniform(self.low, self.high, count)

    def check(self) -> str:
        """What is wrong with it, or nothing."""
        return "" if -math.inf < self.low < self.high < math.inf else "a finite low below a finite high"


@with_quantities(observed=None, assumed=None)
def infer_interior(
    observed: Mapping[str, Gaussian],
    assumed: Mapping[str, Gaussian | Uniform],
    small_m: float = 0.0,
    draws: int = 2000,
    chains: int = 4,
    walkers: int = 32,
    seed: int = 0,
) -> xr.Dataset:
    """Return the posterior of two uniform layers, or three with a crust, in (chain, walker, draw).

    observed: mean_density and any more of DERIVED. assumed: exactly one of core_density, mantle_density and
    core_radius_ratio (core radius over R), and crust_share with crust_density for three layers;
    moment_ratio where it is not observed (uniform up to 0.4 otherwise). small_m: Omega^2 R^3/(GM), for what depends on
    the rotation. Numbers of distributions are in SI, or have units. Attributes of each variable have the distribution
    that was given for it: `observed_mean` and `observed_deviation`, `prior_mean` and `prior_deviation`, or `prior_low`
    and `prior_high`. Whether it has converged: `sampling.summary`, which refuses otherwise. SceneError for what is
    missing or unknown, NumericalError where no interior agrees.
    """
    observed = {name: _plain(name, given, (Gaussian,)) for name, given in observed.items()}
    assumed = {name: _plain(name, given, (Gaussian, Uniform)) for name, given in assumed.items()}
    choice, crust = _checked(observed, assumed, small_m)
    coordinates: dict[str, Gaussian | Uniform] = {
        "mean_density": observed["mean_density"],
        "moment_ratio": assumed.get("moment_ratio") or observed.get("moment_ratio") or Uniform(0.0, UNIFORM),
        choice: assumed[choice],
        **{name: assumed[name] for name in crust},
    }
    names = list(coordinates)
    likelihoods = {name: gaussian for name, gaussian in observed.items() if coordinates.get(name) is not gaussian}
    fluid = any(name in _FLUID for name in likelihoods)

    def log_probability(positions: np.ndarray) -> np.ndarray:
        values = dict(zip(names, positions.T, strict=True))
        total = sum(coordinates[name].log_density(values[name]) for name in names)
        interior = _interior(values, choice, small_m, fluid)
        for name, gaussian in likelihoods.items():
            total = total + gaussian.log_density(interior[name])
        possible = np.isfinite(interior["core_density"])
        return np.where(possible & np.isfinite(total), total, -np.inf)

    def start(generator: np.random.Generator, count: int) -> np.ndarray:
        tried = np.stack([coordinates[name].draw(generator, _TRIES * count) for name in names], axis=-1)
        heights = log_probability(tried)
        best = np.argsort(-heights)[: 4 * count]
        best = best[np.isfinite(heights[best])]
        if len(best) < count:
            raise NumericalError(f"no interior of {2 + bool(crust)} uniform layers agrees with what is given")
        return tried[generator.choice(best, count, replace=False)]

    posterior = sample(log_probability, start, names, draws, chains, walkers, seed)
    flat = {name: posterior[name].values.ravel() for name in names}
    dims, shape = posterior[names[0]].dims, posterior[names[0]].shape
    for name, values in _interior(flat, choice, small_m, True).items():
        posterior[name] = dims, np.broadcast_to(values, flat[choice].shape).reshape(shape)
    for name, (unit, text) in DERIVED.items():
        if name in posterior:
            posterior[name].attrs = {"units": unit, "long_name": text}
    priors = {name: prior for name, prior in coordinates.items() if observed.get(name) is not prior}
    for kind, given in (("observed", observed), ("prior", priors)):
        for name, distribution in given.items():
            posterior[name].attrs |= {f"{kind}_{key}": float(value) for key, value in vars(distribution).items()}
    posterior.attrs |= {
        "title": f"interiors of {2 + bool(crust)} uniform layers",
        "sampled": names,
        "observed": list(observed),
        "assumed": list(priors),
        "small_m": small_m,
    }
    return posterior


@with_quantities()
def infer_body(name: str | SolarSystemBody, use: tuple[str, ...] = ("moment_ratio",), **settings) -> xr.Dataset:
    """Return the posterior of a body of the table from its mass, radius and `use`, with what the table assumes.

    name: or the body itself, as `own_body` makes one, with what that assumes.
    use: "moment_ratio" (the adopted one), "love_number" (the fluid k2 that J2 or C22 stands for in equilibrium), or
    both. settings: as for `infer_interior`. SceneError for a body without these, or for which nothing is assumed.

    The usual 4 chains of 2000 draws take most of a minute; for a quick look, `draws=200, chains=2` take a few seconds.
    """
    if isinstance(use, str):
        raise SceneError(f"use must be a list of quantities, such as [{use!r:.60}], not text")
    one = name if isinstance(name, SolarSystemBody) else body(name)
    assumed = _assumptions(one)
    observed = {"mean_density": Gaussian(one.mean_density, _density_deviation(one))}
    observed |= {quantity: _observation(one, quantity) for quantity in use}
    share = synchronous_share(one)
    posterior = infer_interior(observed, assumed, one.small_m * share, **settings)
    posterior["core_radius"] = posterior["core_radius_ratio"] * one.mean_radius
    posterior["core_radius"].attrs = {"units": "m", "long_name": "radius of the core"}
    posterior.attrs |= {"body": one.name, "small_m": one.small_m, "synchronous_share": share}
    return posterior


def _observation(one, name: str) -> Gaussian:
    if name == "moment_ratio":
        ratio = one.moment_ratio()
        if not math.isfinite(ratio.uncertainty):
            raise SceneError(f"the moment ratio of {one.name} has no published uncertainty")
        return Gaussian(ratio.value, ratio.uncertainty)
    if name != "love_number":
        raise SceneError(f'"{name}" is not to be inferred from; "moment_ratio" and "love_number" are')
    love = fluid_love_number(one)
    row = one.adopted("c22" if one.has("c22") else "j2")
    if not (math.isfinite(love) and math.isfinite(row.uncertainty)):
        raise SceneError(f"{one.name} has no figure of a fluid with a published uncertainty")
    return Gaussian(love, love * row.uncertainty / abs(row.value))


def _assumptions(one) -> dict[str, Gaussian | Uniform]:
    layers = assumed_layers(one)
    if layers is None:
        raise SceneError(f"nothing is assumed for the layers of {one.name}")
    name, density, crust = layers
    assumed: dict[str, Gaussian | Uniform] = {name: Gaussian(density.value, density.uncertainty)}
    if crust is not None:
        thickness, density = crust
        assumed["crust_share"] = Gaussian(thickness.value / one.mean_radius, thickness.uncertainty / one.mean_radius)
        assumed["crust_density"] = Gaussian(density.value, density.uncertainty)
    return assumed


def _density_deviation(one) -> float:
    radius = one.adopted("mean_radius")
    least = 1e-6  # relative; G is no better known than 2e-5, but is common to all densities
    relative = 3 * radius.uncertainty / radius.value if math.isfinite(radius.uncertainty) else least
    return one.mean_density * max(relative, least)


def _interior(values: Mapping[str, np.ndarray], choice: str, small_m: float, fluid: bool) -> dict[str, np.ndarray]:
    """Everything of DERIVED for the coordinates, NaN where they have no layers."""
    mean, ratio, chosen = values["mean_density"], values["moment_ratio"], {choice: values[choice]}
    crust = {name: values[name] for name in CRUST if name in values}
    layers = three_layers(mean, ratio, **crust, **chosen) if crust else two_layers(mean, moment_ratio=ratio, **chosen)
    interior = {
        "mean_density": mean,
        "moment_ratio": ratio,
        "core_radius_ratio": layers.core_radius_ratio,
        "core_density": layers.core_density,
        "mantle_density": layers.mantle_density,
        **crust,
    }
    if fluid:
        k2 = love_numbers(layers)
        interior |= {"love_number": k2, "zonal_harmonic_2": small_m * k2 / 3, "flattening": small_m * (1 + k2) / 2}
    return interior


def _plain(name: str, given: Any, kinds: tuple[type, ...]) -> Any:
    """A distribution with its numbers in SI; SceneError where it is none."""
    if not isinstance(given, kinds):
        raise SceneError(f"{name} must be a {' or a '.join(kind.__name__ for kind in kinds)}, not {given!r:.60}")
    unit = DERIVED.get(name, ("1", ""))[0]
    try:
        numbers = {key: float(_in_unit(value, unit)) for key, value in vars(given).items()}
    except (SceneError, TypeError, ValueError) as error:
        raise SceneError(f"{name}: {error}") from None
    made = replace(given, **numbers)
    if wanted := made.check():
        raise SceneError(f"{name} needs {wanted}, not {given}")
    return made


def _in_unit(value: Any, unit: str) -> Any:
    own = stated(value)
    return value if own is None else in_unit(own, unit)


def _checked(observed: Mapping, assumed: Mapping, small_m: float) -> tuple[str, tuple[str, ...]]:
    if "mean_density" not in observed:
        raise SceneError("an interior needs the observed mean_density: mass over the volume of the mean radius")
    for name in observed:
        if name not in DERIVED:
            raise SceneError(f"there is no observation '{name}' here; there is {', '.join(DERIVED)}")
    if small_m == 0.0 and any(name in observed for name in _FLUID[1:]):
        raise SceneError("without small_m, the measure of rotation, J2 and flattening say nothing")
    for name in assumed:
        if name not in (*CHOICES, *CRUST, "moment_ratio"):
            raise SceneError(f"'{name}' is not to be assumed; {', '.join((*CHOICES, *CRUST, 'moment_ratio'))} are")
    chosen = [name for name in CHOICES if name in assumed]
    if len(chosen) != 1:
        raise SceneError(f"exactly one of {', '.join(CHOICES)} has to be assumed, not {', '.join(chosen) or 'none'}")
    crust = tuple(name for name in CRUST if name in assumed)
    if len(crust) == 1:
        raise SceneError(f"a crust needs both of {' and '.join(CRUST)}")
    return chosen[0], crust
