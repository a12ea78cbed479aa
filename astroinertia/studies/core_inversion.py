"""From a measured moment ratio to the size of a core: exact for uniform layers, with every error carried through.

Which density is assumed, and which crust, is in data/planets.csv with the status "assumed". Uniform layers leave out
that matter is compressed with depth: that makes the core of a large planet come out too large (of Earth 3810 km for
3480 km, of Mars about 1980 km for 1830 km), and a mantle density assumed for one would be worse; `compressed_core`
takes compression into account. For the Moon, which is hardly compressed but has a light crust, three layers agree with
seismology and laser ranging.
Tests: tests/unit/studies/test_two_layers.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from astroinertia.bodies.inversion import ThreeLayers, TwoLayers
from astroinertia.bodies.planets import Published, SolarSystemBody, own_body
from astroinertia.process.quantities import with_quantities
from astroinertia.studies.two_layers import love_numbers, uniform_layers

DRAWS = 20000
_SEED = 20260701
_ASSUMABLE = ("core_density", "mantle_density")
_LAYERS = (*_ASSUMABLE, "crust_thickness", "crust_density")
_RATIOS = ("polar_moment_ratio", "mean_moment_ratio")


@dataclass(frozen=True)
class CoreInversion:
    """A core in SI from the published ratio; lows and highs are the 16th and 84th percentile of the draws.

    possible_share: of the draws from the errors of all inputs, those for which such layers exist at all. NaN throughout
    where nothing is assumed for the body.
    """

    core_radius: float
    core_radius_low: float
    core_radius_high: float
    core_density: float
    core_density_deviation: float
    mantle_density: float
    mantle_density_deviation: float
    possible_share: float
    assumed: str
    layers: TwoLayers | ThreeLayers | None = None

    @property
    def love_number(self) -> float:
        """Return the fluid k2 of the layers, computed when it is read; NaN where there are none."""
        return np.nan if self.layers is None else float(love_numbers(self.layers))


NOTHING = CoreInversion(*[np.nan] * 8, assumed="")


@with_quantities()
def core_inversion(one: SolarSystemBody, ratio_row: int = 0, draws: int = DRAWS) -> CoreInversion:
    """Return the core of a body from its published moment ratio and what the table assumes for it.

    ratio_row: which of the published ratios, in the order of `moment_ratio_rows`; 0 is the adopted one. Draws have a
    fixed seed. Numbers without a published uncertainty count as exact.

    >>> from astroinertia.bodies.planets import body
    >>> print(f"{core_inversion(body('Mars')).core_radius / 1e3:.0f} km")
    1982 km
    """
    if draws < 1:
        raise ValueError(f"at least one draw is needed, not {draws}")
    assumed = assumed_layers(one)
    if assumed is None:
        return NOTHING
    name, density, crust = assumed
    generator = np.random.default_rng(_SEED)
    normal = generator.normal(size=(5, draws))
    radius = _drawn(one.adopted("mean_radius"), normal[0])
    ratio = one.moment_ratio_row(ratio_row)
    shrunk = (one.mean_radius / radius) ** 2  # the moment itself is measured, not its ratio to this radius
    layers = uniform_layers(
        3 * one.mass / (4 * np.pi * radius**3),
        _spread(ratio.value, ratio.uncertainty, normal[1]) * shrunk,
        None if crust is None else (_drawn(crust[0], normal[3]) / radius, _drawn(crust[1], normal[4])),
        **{name: _drawn(density, normal[2])},
    )
    central = uniform_layers(
        one.mean_density,
        ratio.value,
        None if crust is None else (crust[0].value / one.mean_radius, crust[1].value),
        **{name: density.value},
    )
    core_radius = layers.core_radius_ratio * radius
    good = np.isfinite(core_radius)
    deviations = {layer: _deviation(getattr(layers, layer)) for layer in _ASSUMABLE}
    deviations[name] = float(np.nan_to_num(density.uncertainty))
    text = f"{name.replace('_', ' ')} {_with_error(density)} kg/m3"
    if crust is not None:
        text += f"; crust {_with_error(crust[0], 1e3)} km of {_with_error(crust[1])} kg/m3"
    low, high = np.quantile(core_radius[good], [0.16, 0.84]) if good.any() else (np.nan, np.nan)
    return CoreInversion(
        core_radius=float(central.core_radius_ratio * one.mean_radius),
        core_radius_low=float(low),
        core_radius_high=float(high),
        core_density=float(central.core_density),
        core_density_deviation=deviations["core_density"],
        mantle_density=float(central.mantle_density),
        mantle_density_deviation=deviations["mantle_density"],
        possible_share=float(good.mean()),
        assumed=text,
        layers=central,
    )


@with_quantities()
def assumed_layers(one: SolarSystemBody) -> tuple[str, Published, tuple[Published, Published] | None] | None:
    """Return which density the table assumes for a body, that density, and thickness and density of a crust, if any.

    >>> from astroinertia.bodies.planets import body
    >>> name, density, crust = assumed_layers(body("Earth"))
    >>> print(name, density.value, crust)
    core_density 10990.0 None
    """
    for name in _ASSUMABLE:
        if one.has(name) and one.adopted(name).status == "assumed":
            crust = (one.adopted("crust_thickness"), one.adopted("crust_density")) if one.has("crust_density") else None
            return name, one.adopted(name), crust
    return None


@with_quantities()
def restated(one: SolarSystemBody, stated: Mapping[str, float]) -> SolarSystemBody:
    """Return the body with a ratio or a density of one's own, as exact, in place of those of the table.

    stated: moment_ratio (mean moment and mean radius), and core_density or mantle_density, which is then all that is
    assumed of two layers; in SI.

    >>> from astroinertia.bodies.planets import body
    >>> print(f"{core_inversion(restated(body('Mars'), {'core_density': 7000.0})).core_radius / 1e3:.0f} km")
    1737 km
    """
    numbers = {"mean_moment_ratio" if name == "moment_ratio" else name: value for name, value in stated.items()}
    own = own_body(one.name, one.mass, one.mean_radius, synchronous=False, **numbers).published
    replaced = (*(_RATIOS if "moment_ratio" in stated else ()), *(_LAYERS if {*_ASSUMABLE} & {*stated} else ()))
    kept = {name: rows for name, rows in one.published.items() if name not in replaced}
    return SolarSystemBody(one.name, MappingProxyType({**kept, **{name: own[name] for name in numbers}}))


def _drawn(number: Published, normal: np.ndarray) -> np.ndarray:
    return _spread(number.value, number.uncertainty, normal)


def _spread(value: float, deviation: float, normal: np.ndarray) -> np.ndarray:
    return value + (deviation if np.isfinite(deviation) else 0.0) * normal


def _deviation(values: np.ndarray) -> float:
    low, high = np.nanquantile(values, [0.16, 0.84]) if np.isfinite(values).any() else (np.nan, np.nan)
    return float(high - low) / 2


def _with_error(number: Published, unit: float = 1.0) -> str:
    error = f"({number.uncertainty / unit:.3g})" if np.isfinite(number.uncertainty) else ""
    return f"{number.value / unit:.6g}{error}"
