"""What two uniform layers leave out of the core that a moment ratio asks for: compression, and more layers.

The error of the inputs says nothing of the model: matter is compressed with depth, and mantles have steps of density.
Both put mass inwards within a layer of the same mean density, which a uniform layer makes up for with another core. It
is found by the same inversion, with the ratio that uniform layers of the same means would have.

Compression: each layer follows its pressure with the bulk modulus of liquid iron (a mean density above 4500 kg/m3), of
forsterite (above 2000) or of ice VII; a crust stays uniform. A third layer: the lower half of the mantle, by radius, is
denser by a tenth, as across 660 km in PREM (Dziewonski & Anderson 1981, PEPI 25, 297). Neither is known of a body of
which only a ratio is known: the sum of both is how wrong uniform layers may be. It is the whole error for the Earth
(-321 of -327 km), and with the errors of the inputs covers the published cores of Mars, the Moon and Mercury.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.bodies.planets import SolarSystemBody
from astroinertia.matter import planetary
from astroinertia.process.quantities import with_quantities
from astroinertia.studies.core_inversion import assumed_layers
from astroinertia.studies.two_layers import radii_and_densities, uniform_layers
from astroinertia.units import GRAVITATIONAL_CONSTANT

_CELLS = 60  # of a layer: the change of the radius to 0.2 %
_STEP = 0.1  # of the density of the mantle, across its middle
_MATTER = (  # from which mean density on
    (4500.0, "liquid iron", planetary.IRON_LIQUID),
    (2000.0, "forsterite", planetary.FORSTERITE),
    (-np.inf, "ice VII", planetary.ICE_VII),
)
_COMPRESSIONS = np.linspace(1.0, 6.0, 2001)
_ITERATIONS = 60
_TOLERANCE = 1e-6

Cells = list[np.ndarray]
Profile = Callable[[Cells, list[float]], Cells]


@dataclass(frozen=True)
class CoreModelError:
    """Changes of the core's radius (m) by what uniform layers leave out, each alone and both at once.

    A mantle with a step that leaves no core with this ratio takes away the whole radius. NaN where uniform layers have
    no core, or the search does not end.
    """

    compression: float
    third_layer: float
    both: float


NO_MODEL_ERROR = CoreModelError(np.nan, np.nan, np.nan)


@with_quantities(crust=None)
def core_model_error(
    mean_density: float,
    mean_radius: float,
    moment_ratio: float,
    crust: tuple[float, float] | None = None,
    **assumed: float,
) -> CoreModelError:
    """Return how the core of uniform layers changes with compression and with a third layer, in the unit of the radius.

    SI, or with units; crust: thickness over R and density, two plain numbers; assumed: the mean core_density or
    mantle_density, which stays.

    >>> earth = core_model_error(5513.0, 6371e3, 0.33071, core_density=10990.0)
    >>> print(f"{earth.compression / 1e3:.0f} {earth.third_layer / 1e3:.0f} {earth.both / 1e3:.0f}")
    -232 -60 -321
    """

    solved = partial(uniform_layers, mean_density, crust=crust, **assumed)

    def compressed(edges: Cells, means: list[float]) -> Cells:
        return _compressed(edges, means, mean_radius)

    def both(edges: Cells, means: list[float]) -> Cells:
        pairs = zip(_stepped(edges, means), compressed(edges, means), means, strict=True)
        return [step * squeezed / mean for step, squeezed, mean in pairs]

    uniform = float(solved(moment_ratio).core_radius_ratio)
    if not np.isfinite(uniform):
        return NO_MODEL_ERROR
    cores = [_core(solved, moment_ratio, profile) for profile in (compressed, _stepped, both)]
    return CoreModelError(*(mean_radius * (core - uniform) for core in cores))


@with_quantities()
def model_error_of(one: SolarSystemBody, ratio_row: int = 0) -> CoreModelError:
    """Return the same for what the table assumes of a body and one of its published ratios, the adopted one first.

    >>> from astroinertia.bodies.planets import body
    >>> print(f"{model_error_of(body('Mars')).both / 1e3:.0f} km")
    -164 km
    """
    assumed = assumed_layers(one)
    if assumed is None:
        return NO_MODEL_ERROR
    name, density, crust = assumed
    layer = None if crust is None else (crust[0].value / one.mean_radius, crust[1].value)
    ratio = one.moment_ratio_row(ratio_row).value
    return core_model_error(one.mean_density, one.mean_radius, ratio, layer, **{name: density.value})


@with_quantities()
def matter_as_dense(mean_density: float) -> tuple[str, planetary.BirchMurnaghan]:
    """Return what a layer of a mean density is taken for, with its name: liquid iron, forsterite or ice VII.

    >>> print(matter_as_dense(3300.0)[0])
    forsterite
    """
    return next((name, matter) for least, name, matter in _MATTER if mean_density > least)


def _core(solved: Callable[[float], Any], ratio: float, profile: Profile) -> float:
    """The core radius over R with a profile in each layer; 0 where there is none."""
    layers = solved(ratio)
    for _ in range(_ITERATIONS):
        radii, means = radii_and_densities(layers)
        edges = [np.linspace(low, high, _CELLS + 1) for low, high in pairwise([0.0, *radii])]
        uniform = [np.full(_CELLS, mean) for mean in means]
        before = float(layers.core_radius_ratio)
        layers = solved(ratio + _ratio(edges, uniform) - _ratio(edges, profile(edges, means)))
        after = float(layers.core_radius_ratio)
        if not np.isfinite(after):
            return 0.0
        if abs(after - before) < _TOLERANCE:
            return after
    return np.nan


def _ratio(edges: Cells, density: Cells) -> float:
    """I/(M R^2) of cells of constant density."""
    moment = sum(rho @ np.diff(edge**5) for rho, edge in zip(density, edges, strict=True))
    return float(UNIFORM * moment / sum(rho @ np.diff(edge**3) for rho, edge in zip(density, edges, strict=True)))


def _scaled(shape: np.ndarray, edges: np.ndarray, mean: float) -> np.ndarray:
    return shape * mean * (edges[-1] ** 3 - edges[0] ** 3) / (shape @ np.diff(edges**3))


def _stepped(edges: Cells, means: list[float]) -> Cells:
    density = [np.full(_CELLS, mean) for mean in means]
    inner = np.arange(_CELLS) < _CELLS // 2
    return [density[0], _scaled(1.0 + _STEP * inner, edges[1], means[1]), *density[2:]]


def _compressed(edges: Cells, means: list[float], radius: float) -> Cells:
    density = [np.full(_CELLS, mean) for mean in means]
    below, above = np.concatenate([edge[:-1] for edge in edges]), np.concatenate([edge[1:] for edge in edges])
    for _ in range(_ITERATIONS):
        rho = np.concatenate(density)
        mass = rho * (above**3 - below**3)
        inside = np.cumsum(mass) - mass / 2
        weight = 4 * np.pi / 3 * GRAVITATIONAL_CONSTANT * radius**2 * inside / ((below + above) / 2) ** 2
        weight = weight * rho * (above - below)
        pressure = np.split(np.cumsum(weight[::-1])[::-1] - weight / 2, len(edges))
        squeezed = [
            _scaled(np.interp(each, *_compression(matter_as_dense(mean)[1])), edge, mean)
            for each, edge, mean in zip(pressure[:2], edges[:2], means[:2], strict=True)
        ]
        change = max(float(abs(new / old - 1).max()) for new, old in zip(squeezed, density[:2], strict=True))
        density = [*squeezed, *density[2:]]
        if change < _TOLERANCE:
            break
    return density


@cache
def _compression(matter: planetary.BirchMurnaghan) -> tuple[np.ndarray, np.ndarray]:
    """Pressures, and the density over that at no pressure."""
    return planetary.pressure(matter, _COMPRESSIONS * matter.reference_density), _COMPRESSIONS
