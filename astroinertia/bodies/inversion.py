"""Interiors from what is measured: mean density, moment ratio and one density or radius fix two constant layers.

With x = r_core/R, the mean density s and k = I/(M R^2) (mean radius), mass and moment say

    s = rho_m + (rho_c - rho_m) x^3,        (5/2) k s = rho_m + (rho_c - rho_m) x^5.

Exact where a body exists; where none does, the error says what forbids it. Errors propagate by the exact jacobian.
Source: elementary; Sohl & Schubert 2015, Treatise on Geophysics 10.02, sec. 2. Tests:
tests/unit/bodies/test_inversion.py.
"""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.bodies.layered import LayeredBody, constant_layers
from astroinertia.engines.pytree import pytree
from astroinertia.inertia.double_precision import double_precision
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities

Array = Any

_HOMOGENEOUS = 0.4  # I/(M R^2) of a homogeneous sphere
_NEWTON_STEPS = 60
_LAST_PLACES = 4e-16  # of a radius over R, between which Newton's steps may go back and forth for ever
_ASSUMABLE = ("mantle_density", "core_density", "core_radius_ratio")


@pytree
@dataclass(frozen=True)
class TwoLayers:
    """A core and a mantle of constant density: core_radius_ratio r_core/R and the two densities; a JAX pytree."""

    core_radius_ratio: Array
    core_density: Array
    mantle_density: Array

    @property
    def core_mass_fraction(self) -> Array:
        """Mass of the core over that of the body."""
        core = self.core_density * self.core_radius_ratio**3
        return core / (core + self.mantle_density * (1 - self.core_radius_ratio**3))

    @with_quantities()
    def body(self, mean_radius: Array = 1.0, gravitational_constant: Array = 1.0) -> LayeredBody:
        """The layered body of this structure (of scalars) with a mean radius."""
        xp = np if all(is_known(leaf) for leaf in jax.tree.leaves((self, mean_radius))) else jnp
        radii = xp.stack([self.core_radius_ratio * mean_radius, xp.asarray(mean_radius, dtype=float)])
        densities = xp.stack([xp.asarray(self.core_density), xp.asarray(self.mantle_density)])
        return constant_layers(radii, densities, gravitational_constant)


@pytree
@dataclass(frozen=True)
class TwoLayersWithErrors:
    """The structure, and the covariance (3, 3) of (core_radius_ratio, core_density, mantle_density)."""

    structure: TwoLayers
    covariance: Array

    @property
    def standard_errors(self) -> TwoLayers:
        """The standard error of each number of the structure."""
        return TwoLayers(*np.sqrt(np.diag(self.covariance)))


@pytree
@dataclass(frozen=True)
class ThreeLayers:
    """A family of bodies of core, mantle and shell, all arrays of one shape: a curve through the bodies that fit.

    core_radius_ratio and shell_boundary_ratio are radii over R; NaN where no such body exists. A JAX pytree.
    """

    core_radius_ratio: Array
    shell_boundary_ratio: Array
    core_density: Array
    mantle_density: Array
    shell_density: Array


@with_quantities()
def two_layers(
    mean_density: Array,
    moment_ratio: Array,
    *,
    mantle_density: Array | None = None,
    core_density: Array | None = None,
    core_radius_ratio: Array | None = None,
) -> TwoLayers:
    """The two-layer body of a mean density and I/(M R^2) (mean radius R), with one more number of it given; scalars.

    Exactly one of the last three is given; the body is unique. ValueError where there is none, with the reason. A core
    lighter than its mantle (moment ratio above 0.4) is found, too. Within a JAX transformation nothing is refused: a
    body that cannot be has a NaN or a negative density. Source: the module's equations.

    >>> print(f"{float(two_layers(3933.0, 0.3637, mantle_density=3500.0).core_radius_ratio):.5f}")  # of Mars
    0.41917
    """
    name, assumed = _the_assumed(mantle_density, core_density, core_radius_ratio)
    for key, value in {"mean_density": mean_density, "moment_ratio": moment_ratio, name: assumed}.items():
        if np.ndim(value) > 0:
            raise ValueError(f"{key} must be one number, not {np.size(value)}: use jax.vmap for many bodies")
    structure = _solved(mean_density, moment_ratio, assumed, name)
    if all(is_known(number) for number in (mean_density, moment_ratio, assumed)):
        _refuse_the_impossible(float(mean_density), float(moment_ratio), name, float(assumed), structure)
    return structure


@with_quantities()
def two_layers_with_errors(
    mean_density: float,
    moment_ratio: float,
    errors: Array,
    *,
    mantle_density: float | None = None,
    core_density: float | None = None,
    core_radius_ratio: float | None = None,
) -> TwoLayersWithErrors:
    """The same with its covariance, from the errors of (mean density, moment ratio, the given number).

    errors: three standard errors, or a covariance (3, 3). Linear in the errors, by the exact jacobian: near the limits
    of what exists, sample instead. ValueError as for `two_layers`.

    >>> known = two_layers_with_errors(3933.0, 0.3637, np.array([1.0, 1e-4, 50.0]), mantle_density=3500.0)
    >>> print(f"{known.standard_errors.core_radius_ratio:.3f}")
    0.114
    """
    name, assumed = _the_assumed(mantle_density, core_density, core_radius_ratio)
    structure = two_layers(mean_density, moment_ratio, **{name: assumed})
    errors = np.asarray(errors, dtype=float)
    covariance = np.diag(errors**2) if errors.ndim == 1 else errors
    if covariance.shape != (3, 3) or not (np.linalg.eigvalsh(covariance) >= -1e-12 * np.abs(covariance).max()).all():
        raise ValueError("errors must be three standard errors or a covariance (3, 3) that is positive")
    with jax.enable_x64(True):

        def parameters(measured: Array) -> Array:
            return jnp.stack(jax.tree.leaves(_solved(measured[0], measured[1], measured[2], name)))

        jacobian = np.asarray(jax.jacfwd(parameters)(jnp.array([mean_density, moment_ratio, assumed], dtype=float)))
    return TwoLayersWithErrors(structure, jacobian @ covariance @ jacobian.T)


@with_quantities()
def three_layer_family(
    mean_density: float,
    moment_ratio: float,
    shell_density: float,
    shell_boundary_ratio: Array,
    *,
    mantle_density: float | None = None,
    core_density: float | None = None,
    core_radius_ratio: float | None = None,
) -> ThreeLayers:
    """The bodies of core, mantle and shell that fit, one for each inner radius of the shell over R (any shape).

    The shell is taken off, and the rest is a two-layer body with its own mean density and moment ratio. NaN where there
    is none; ValueError where there is none at all. Source and check as for `two_layers`.

    >>> mars = three_layer_family(3933.0, 0.3637, 2900.0, 0.985, core_density=6000.0)
    >>> print(f"{float(mars.core_radius_ratio):.4f}")  # with a crust of 50 km
    0.5884
    """
    name, assumed = _the_assumed(mantle_density, core_density, core_radius_ratio)
    family = _family(mean_density, moment_ratio, shell_density, shell_boundary_ratio, assumed, name)
    core = family.core_radius_ratio
    if is_known(core) and not np.isfinite(core).any():
        raise ValueError("no body of three layers has this mean density and moment ratio with the given numbers")
    return family


def _the_assumed(*values: Any) -> tuple[str, Any]:
    assumed = [(name, value) for name, value in zip(_ASSUMABLE, values, strict=True) if value is not None]
    if len(assumed) != 1:
        raise ValueError(f"exactly one of {', '.join(_ASSUMABLE)} must be given, not {len(assumed)}")
    return assumed[0]


@double_precision("name")
def _solved(mean_density: Array, moment_ratio: Array, assumed: Array, name: str) -> TwoLayers:
    return inverted(jnp, mean_density, moment_ratio, assumed, name)


@double_precision("name")
def _family(mean_density: Array, moment_ratio: Array, shell_density: Array, boundary: Array, assumed: Array, name: str):
    return inverted_below(jnp, mean_density, moment_ratio, shell_density, boundary, assumed, name)


@with_quantities()
def inverted(xp: Any, mean_density: Array, moment_ratio: Array, assumed: Array, name: str) -> TwoLayers:
    """What `two_layers` solves, over a namespace xp, numpy (arrays in, arrays out) or jax.numpy; nothing is refused.

    name: which of mantle_density, core_density and core_radius_ratio is assumed.

    >>> print(f"{inverted(np, 3933.0, 0.3637, 3500.0, 'mantle_density').core_radius_ratio:.5f}")
    0.41917
    """
    moment_density = moment_ratio / _HOMOGENEOUS * mean_density  # mean density that the moment would tell
    if name == "mantle_density":
        x = xp.sqrt((moment_density - assumed) / (mean_density - assumed))
        return TwoLayers(x, assumed + (mean_density - assumed) / x**3, xp.asarray(assumed, dtype=float))
    if name == "core_density":
        x = _core_radius(xp, (mean_density - moment_density) / (assumed - mean_density))
        mantle = (mean_density - assumed * x**3) / (1 - x**3)
        return TwoLayers(x, xp.asarray(assumed, dtype=float), mantle)
    excess = (mean_density - moment_density) / (assumed**3 * (1 - assumed**2))
    mantle = mean_density - excess * assumed**3
    return TwoLayers(xp.asarray(assumed, dtype=float), mantle + excess, mantle)


@with_quantities()
def inverted_below(
    xp: Any, mean_density: Array, moment_ratio: Array, shell_density: Array, boundary: Array, assumed: Array, name: str
) -> ThreeLayers:
    """What `three_layer_family` solves, as `inverted` does; NaN where there is no such body.

    >>> mars = inverted_below(np, 3933.0, 0.3637, 2900.0, 0.985, 6000.0, "core_density")
    >>> print(f"{mars.core_radius_ratio:.4f}")
    0.5884
    """
    boundary = xp.asarray(boundary, dtype=float)
    inner_density = (mean_density - shell_density * (1 - boundary**3)) / boundary**3
    moment_density = moment_ratio / _HOMOGENEOUS * mean_density
    inner_moment = (moment_density - shell_density * (1 - boundary**5)) / boundary**5
    within = assumed / boundary if name == "core_radius_ratio" else assumed
    inner = inverted(xp, inner_density, _HOMOGENEOUS * inner_moment / inner_density, within, name)
    exists = (inner.core_radius_ratio > 0) & (inner.core_radius_ratio < 1) & (boundary <= 1) & (boundary > 0)
    exists = exists & (inner.core_density > 0) & (inner.mantle_density > 0) & (shell_density > 0)
    values = (inner.core_radius_ratio * boundary, boundary, inner.core_density, inner.mantle_density, shell_density)
    return ThreeLayers(*(xp.where(exists, value, xp.nan) for value in values))


def _core_radius(xp: Any, share: Array) -> Array:
    """The x of x^3 (1 + x)/(1 + x + x^2) = share, unique from 0 at 0 to 1 at 2/3; NaN beyond.

    What follows for x when the mantle's density is eliminated.
    """
    inside = (share >= 0) & (share <= 2 / 3)
    wanted = xp.where(inside, share, 0.1)

    def excess(x: Array) -> Array:
        return x**3 * (1 + x) / (1 + x + x**2) - wanted

    def improve(_: int, x: Array) -> Array:
        slope = x**2 * (3 + 6 * x + 4 * x**2 + 2 * x**3) / (1 + x + x**2) ** 2
        return xp.clip(x - excess(x) / xp.where(slope > 0, slope, 1.0), 0.0, 1.0)

    guess = xp.minimum(xp.cbrt(wanted * 1.5), 1.0)
    if xp is np:
        x = guess
        for step in range(_NEWTON_STEPS):
            x, before = improve(step, x), x
            if np.all(np.abs(x - before) <= _LAST_PLACES):
                break
        return np.where(inside, x, np.nan)
    x = jax.lax.custom_root(
        excess, jax.lax.stop_gradient(guess), lambda _, start: jax.lax.fori_loop(0, _NEWTON_STEPS, improve, start),
        lambda linear, y: y / linear(jnp.ones_like(y)),
    )  # fmt: skip
    return jnp.where(inside, x, jnp.nan)


def _refuse_out_of_range(s: float, k: float, name: str, assumed: float) -> None:
    if not (s > 0 and np.isfinite(s)):
        raise ValueError(f"a mean density must be positive, not {s:g}")
    if not 0 < k < 2 / 3:
        raise ValueError(f"a moment ratio lies between 0 and 2/3 (a hollow shell), not at {k:g}")
    if name == "core_radius_ratio":
        if not 0 < assumed < 1:
            raise ValueError(f"a core radius ratio lies between 0 and 1, not at {assumed:g}")
    elif not assumed > 0:
        raise ValueError(f"a density must be positive, not {assumed:g}")


def _refuse_the_impossible(s: float, k: float, name: str, assumed: float, body: TwoLayers) -> None:
    assumption = f"{name.replace('_', ' ')} {assumed:g}"
    _refuse_out_of_range(s, k, name, assumed)
    if name != "core_radius_ratio" and assumed == s and k != _HOMOGENEOUS:
        raise ValueError(
            f"with {assumption} equal to the mean density the body is homogeneous: its moment ratio is 0.4"
        )
    x, core, mantle = (float(value) for value in (body.core_radius_ratio, body.core_density, body.mantle_density))
    if k == _HOMOGENEOUS and name != "core_radius_ratio":
        raise ValueError("a moment ratio of 0.4 is that of a homogeneous body: the size of its core is undefined")
    if name != "core_radius_ratio" and (assumed > s) != ((name == "core_density") == (k < _HOMOGENEOUS)):
        side = "lighter" if assumed > s else "denser"
        raise ValueError(
            f"with a moment ratio {'below' if k < _HOMOGENEOUS else 'above'} 0.4, {k:g}, the "
            f"{name.removesuffix('_density')} is {side} than the mean density {s:g}, and {assumption} is not"
        )
    if name == "mantle_density" and not x > 0:
        limit = _HOMOGENEOUS * assumed / s
        raise ValueError(f"with {assumption} even a point core leaves a moment ratio of {limit:g}: {k:g} cannot be")
    if name == "core_density" and not mantle > 0:
        limit = _HOMOGENEOUS * (s / assumed) ** (2 / 3)
        raise ValueError(f"with {assumption} and no mantle at all the moment ratio is {limit:.6g}: {k:g} cannot be")
    if not core > 0:
        raise ValueError(f"with {assumption} the core would need a negative density, {core:g}")
    if not mantle > 0:
        raise ValueError(f"with {assumption} the mantle would need a negative density, {mantle:g}")
