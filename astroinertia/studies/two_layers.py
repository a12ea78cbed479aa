"""Many bodies of a uniform core, mantle and perhaps a crust at once: arrays in, arrays out, NaN where none can be.

The exact inversions are those of `bodies.inversion`; a core must be denser than its mantle, and that than its crust.
"""

from collections.abc import Callable
from dataclasses import fields
from functools import lru_cache

import jax
import numpy as np

from astroinertia.bodies import inversion
from astroinertia.bodies.clairaut import love_number
from astroinertia.bodies.inversion import ThreeLayers, TwoLayers
from astroinertia.bodies.layered import constant_layers
from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.process.quantities import with_quantities

PARAMETERS = ("moment_ratio", "mantle_density", "core_density", "core_radius_ratio")


@with_quantities()
def two_layers(mean_density, **parameters) -> TwoLayers:
    """Return the bodies with two of moment_ratio, mantle_density, core_density and core_radius_ratio as given.

    Numbers or arrays that broadcast. moment_ratio: I/(M R^2) of the mean moment and the mean radius R;
    core_radius_ratio: r_core/R. ValueError for other names, or not two of them.

    >>> print(f"{two_layers(3933.0, moment_ratio=0.3637, mantle_density=3500.0).core_radius_ratio:.4f}")  # of Mars
    0.4192
    """
    names = tuple(name for name in PARAMETERS if name in parameters)
    if len(names) != 2 or len(parameters) != 2:
        raise ValueError(
            f"two layers follow from two of {', '.join(PARAMETERS)}, not from {', '.join(parameters) or 'none'}"
        )
    mean, *values = _same(mean_density, *(parameters[name] for name in names))
    with np.errstate(all="ignore"):  # NaN where there is none
        if names[0] == "moment_ratio":
            layers = inversion.inverted(np, mean, values[0], values[1], names[1])
            ratio, core, mantle = layers.core_radius_ratio, layers.core_density, layers.mantle_density
        else:
            ratio, core, mantle = _forward(mean, **dict(zip(names, values, strict=True)))
    possible = (ratio > 0) & (ratio < 1) & (mantle > 0) & (core > mantle)
    return TwoLayers(*(np.where(possible, quantity, np.nan)[()] for quantity in (ratio, core, mantle)))


@with_quantities()
def three_layers(mean_density, moment_ratio, crust_share, crust_density, **parameter) -> ThreeLayers:
    """Return the bodies below a crust (thickness over R, density) with core_density or mantle_density as given.

    Or with core_radius_ratio, over R. Numbers or arrays that broadcast. ValueError for other names, or not one of them.

    >>> mars = three_layers(3933.0, 0.3637, 0.015, 2900.0, core_density=6000.0)  # with a crust of 50 km
    >>> print(f"{mars.core_radius_ratio:.4f}")
    0.5884
    """
    if len(parameter) != 1 or not set(parameter) <= set(PARAMETERS[1:]):
        raise ValueError(f"three layers need one of {', '.join(PARAMETERS[1:])}, not {', '.join(parameter) or 'none'}")
    ((name, value),) = parameter.items()
    mean, ratio, shell, inner, assumed = _same(
        mean_density, moment_ratio, crust_density, 1 - np.asarray(crust_share), value
    )
    with np.errstate(all="ignore"):
        bodies = inversion.inverted_below(np, mean, ratio, shell, inner, assumed, name)
    core_ratio, boundary, core, mantle, crust = layers = [getattr(bodies, each.name) for each in fields(bodies)]
    possible = (core_ratio > 0) & (core_ratio < boundary) & (boundary < 1) & (core > mantle) & (mantle > crust)
    return ThreeLayers(*(np.where(possible, quantity, np.nan)[()] for quantity in layers))


@with_quantities(crust=None)
def uniform_layers(mean_density, moment_ratio, crust: tuple | None = None, **parameter) -> TwoLayers | ThreeLayers:
    """Return `two_layers`, or `three_layers` below a crust of this thickness over R and density, of a moment ratio.

    >>> print(f"{uniform_layers(3933.0, 0.3637, (0.015, 2900.0), core_density=6000.0).core_radius_ratio:.4f}")
    0.5884
    """
    if crust is None:
        return two_layers(mean_density, moment_ratio=moment_ratio, **parameter)
    return three_layers(mean_density, moment_ratio, *crust, **parameter)


def radii_and_densities(layers: TwoLayers | ThreeLayers) -> tuple[list, list]:
    """Return outer radii over R, of the whole last, and densities of the layers from the centre outwards.

    >>> print(radii_and_densities(TwoLayers(0.5, 8000.0, 3000.0)))
    ([0.5, 1.0], [8000.0, 3000.0])
    """
    if isinstance(layers, ThreeLayers):
        radii = [layers.core_radius_ratio, layers.shell_boundary_ratio, 1.0]
        return radii, [layers.core_density, layers.mantle_density, layers.shell_density]
    return [layers.core_radius_ratio, 1.0], [layers.core_density, layers.mantle_density]


@with_quantities()
def moment_ratio_of(mean_density, layers: TwoLayers):
    """Return I/(M R^2), of the mean moment and the mean radius.

    >>> print(f"{moment_ratio_of(3933.0, two_layers(3933.0, moment_ratio=0.3637, core_density=6000.0)):.4f}")
    0.3637
    """
    excess = (layers.core_density - layers.mantle_density) * layers.core_radius_ratio**5
    return UNIFORM * (layers.mantle_density + excess) / mean_density


def love_numbers(layers: TwoLayers | ThreeLayers):
    """Return the fluid k_2 of each body, exact; NaN where there is none.

    >>> print(f"{love_numbers(two_layers(3933.0, moment_ratio=0.3637, core_density=6000.0)):.3f}")
    1.181
    """
    (*inner, _), densities = radii_and_densities(layers)
    same = _same(*inner, *densities)
    good = np.isfinite(same).all(axis=0)
    stand_in = [*np.linspace(0.5, 0.8, len(inner)), *np.ones(len(densities))]
    filled = [np.where(good, values, other) for values, other in zip(same, stand_in, strict=True)]
    return np.where(good, _batch(_love_number(len(inner)), *filled)[0], np.nan)[()]


@with_quantities()
def impossible(mean_density: float, **parameters: float) -> str | None:
    """Return why no body of two layers has these two numbers, with the inequality broken; None if one does.

    >>> print(impossible(3933.0, moment_ratio=0.41, core_density=6000.0))
    moment ratio 0.41 is not below 0.4, that of a body with a core no denser than its mantle
    """
    if np.isfinite(two_layers(mean_density, **parameters).core_density):
        return None
    stated = {name: f"{name.replace('_', ' ')} {value:g}" for name, value in parameters.items()}
    if "moment_ratio" in parameters:
        rest = {name: value for name, value in parameters.items() if name != "moment_ratio"}
        if parameters["moment_ratio"] >= UNIFORM:
            limit = f"{UNIFORM:g}, that of a body with a core no denser than its mantle"
            return f"{stated['moment_ratio']} is not below {limit}"
        try:
            inversion.two_layers(mean_density, parameters["moment_ratio"], **rest)
        except ValueError as error:
            return str(error)
        return f"with {' and '.join(stated.values())} the core would not be denser than the mantle"
    if not parameters.get("mantle_density", 0.5 * mean_density) < mean_density:
        return f"{stated['mantle_density']} kg/m3 is not below the mean density {mean_density:.5g} kg/m3"
    if not parameters.get("core_density", 2 * mean_density) > mean_density:
        return f"{stated['core_density']} kg/m3 is not above the mean density {mean_density:.5g} kg/m3"
    if not 0 < parameters.get("core_radius_ratio", 0.5) < 1:
        return f"{stated['core_radius_ratio']} is not between 0 and 1"
    return f"with {' and '.join(stated.values())} no mantle of a positive density is left"


def _same(*values) -> list[np.ndarray]:
    return list(np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values)))


def _forward(mean: np.ndarray, **parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    if "core_radius_ratio" not in parameters:
        mantle, core = parameters["mantle_density"], parameters["core_density"]
        return np.cbrt((mean - mantle) / (core - mantle)), core, mantle
    fraction = parameters["core_radius_ratio"]
    cube = fraction**3
    if "mantle_density" in parameters:
        mantle = parameters["mantle_density"]
        return fraction, mantle + (mean - mantle) / cube, mantle
    core = parameters["core_density"]
    return fraction, core, (mean - core * cube) / (1 - cube)


def _batch(function: Callable, *arrays: np.ndarray) -> list[np.ndarray]:
    """What a function of JAX gives for each member of arrays of one shape, in 64 bits."""
    with jax.enable_x64(True):
        outputs = function(*(array.ravel() for array in arrays))
    return [np.asarray(array).reshape(arrays[0].shape) for array in jax.tree.leaves(outputs)]


@lru_cache(maxsize=8)
def _love_number(boundaries: int) -> Callable:
    def one(*values):
        radii = jax.numpy.stack([*values[:boundaries], jax.numpy.ones_like(values[0])])
        return love_number(constant_layers(radii, jax.numpy.stack(values[boundaries:])))

    return jax.jit(jax.vmap(one))
