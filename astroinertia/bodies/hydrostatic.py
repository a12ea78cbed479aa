"""Planets in hydrostatic equilibrium from what they are made of: layers of cold materials, from the centre outwards.

By mass, with t = x/X for the radius x that the matter below would have at the surface's pressure, where its density is
rho_0 (a smooth image of r, also around a small core), and V = (r/t)^3:

    V t^3 = 3 X^3 integral of (rho_0/rho) t^2 dt,    dP/dt = -G rho_0 X^3 (m/t^3) t V^(-4/3),

and by radius, with t = r/R and V = m/t^3,

    V t^3 = 4 pi R^3 integral of rho t^2 dt,    dP/dt = -(G/R) rho V t.

The layers' boundaries lie at known t, where P is continuous and rho jumps; the one unknown is the pressure at the
centre, found by the secant method so that the surface has its own. Each step is a Gauss-Legendre collocation of P,
solved by Picard's iteration; the integral of t^2 times a polynomial is exact, so that the centre is no singular point.

Sources: Seager et al. 2007, ApJ 669, 1279, sec. 2; Hairer, Norsett & Wanner 1993, Solving ODEs I, sec. II.7.
Tests: tests/physics/test_hydrostatic.py, tests/hard/test_layered_hard.py; cost:
tests/benchmarks/work_precision_layered.py.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.bodies.collocation import collocation
from astroinertia.bodies.layered import LayeredBody
from astroinertia.engines.pytree import pytree
from astroinertia.errors import NumericalError
from astroinertia.inertia.double_precision import double_precision
from astroinertia.matter.planetary import Material
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities

Array = Any

DEFAULT_STEPS = 6  # a layer: the knee in tests/benchmarks/results/work_precision_layered.md
_NODES = 8  # collocation nodes a step
_GRADING = 0.005  # share of the radius: steps around a small core are even well inside it, geometric well outside
_CROWDING = 3  # steps of the last layer crowd to the surface, beyond which rho(P) is singular: in tension, or at once
# Iterations a step, the first with no slope: each gains a factor of the step's share of P/K over its number.
_PICARD = 21
_SECANT_STEPS = 50
_RESOLUTION = 1e-4  # resolution error beyond which a result is refused
NARROW = 1e-6  # of the radius: a piece in which a straight line is as good as a cubic, to 1e-12 of the density
_TOLERANCE = 1e-13  # of the logarithm of the central pressure
_LARGEST_CHANGE = 1.0  # of that logarithm in a step of the secant method


@pytree
@dataclass(frozen=True)
class HydrostaticPlanet:
    """A planet in equilibrium; a JAX pytree. Rows (layers, rows) run outwards; a boundary has a row on each side.

    mass, mean_radius, mean_moment I, gravitational_energy W and central_pressure are scalars; moments and ratios use
    the mean radius. radius, enclosed_mass, pressure, density and density_slope (d rho/dr) are the profile. residual:
    the surface pressure left over as a share of the central one, or what an iteration still changed, if that is more;
    resolution_error: the last Legendre coefficient of what each step integrates, relative, with the steps' shares of
    the whole; the error of the moment ratio is about a quarter of its square.
    """

    mass: Array
    mean_radius: Array
    mean_moment: Array
    gravitational_energy: Array
    central_pressure: Array
    radius: Array
    enclosed_mass: Array
    pressure: Array
    density: Array
    density_slope: Array
    residual: Array
    resolution_error: Array
    gravitational_constant: Array

    @property
    def moment_ratio(self) -> Array:
        """I/(M R^2) with the mean radius."""
        return self.mean_moment / (self.mass * self.mean_radius**2)

    @property
    def layer_radii(self) -> Array:
        """Outer radius (layers,) of each layer."""
        return self.radius[:, -1]

    def layered(self) -> LayeredBody:
        """The same as polynomial layers, for gravity, Love numbers and figures: a cubic in r between each two rows.

        Density and its slope are met at each row; in between the error falls with the fourth power of their distance
        (1e-9 of the Love number for an Earth of 6 steps a layer). A straight line does in pieces so narrow that a cubic
        would lose more to round-off.
        """
        # In numpy where values are known: a compiler may compute the cube twice and differently; its round-off, large
        # in narrow pieces, then does not cancel (it leaves 1e-9 of the density).
        xp = np if is_known(self.radius) else jnp
        x = self.radius / self.mean_radius
        low, high = x[:, :-1].ravel(), x[:, 1:].ravel()
        width = high - low
        some = width > 0
        safe = xp.where(some, width, 1.0)
        start, end = self.density[:, :-1].ravel(), self.density[:, 1:].ravel()
        slopes = self.density_slope * self.mean_radius
        first, last = slopes[:, :-1].ravel(), slopes[:, 1:].ravel()
        mean = (end - start) / safe
        wide = width > NARROW
        square = xp.where(wide, (3 * mean - 2 * first - last) / safe, 0.0)
        cube = xp.where(wide, (first + last - 2 * mean) / safe**2, 0.0)
        first = xp.where(wide, first, xp.where(some, mean, 0.0))
        coefficients = xp.stack(
            [
                start - low * (first - low * (square - low * cube)),
                first - low * (2 * square - 3 * low * cube),
                square - 3 * low * cube,
                cube,
            ],
            axis=-1,
        )  # of powers of x rather than of x - low
        return LayeredBody(high * self.mean_radius, coefficients, self.gravitational_constant)


@with_quantities()
def planet_from_masses(
    layer_masses: Array,
    materials: Sequence[Material],
    *,
    surface_pressure: Array = 0.0,
    gravitational_constant: Array = 1.0,
    steps: int = DEFAULT_STEPS,
) -> HydrostaticPlanet:
    """The planet of layers with given masses (layers,) from the centre outwards, each of one material.

    Units: any consistent ones of masses, material parameters and G. A layer of no mass is allowed, and so is a lighter
    layer below a heavier one (an equilibrium, if an unstable one). ValueError for masses that cannot be; NumericalError
    where no equilibrium is found or a material is asked for more pressure than its equation reaches. Within a JAX
    transformation nothing is refused: see `residual`; a gradient by the mass of a core that is absent is not its own.
    Source and checks: the module.

    >>> from astroinertia.matter.planetary import FORSTERITE, IRON_HCP
    >>> planet = planet_from_masses([1.9e24, 4.1e24], [IRON_HCP, FORSTERITE], gravitational_constant=6.6743e-11)
    >>> print(f"{planet.mean_radius / 1e3:.0f} km, I/(M R^2) = {planet.moment_ratio:.3f}")  # Earth: 6371, 0.331
    6557 km, I/(M R^2) = 0.323
    """
    return _planet(layer_masses, materials, surface_pressure, gravitational_constant, steps, "mass")


@with_quantities()
def planet_from_radii(
    outer_radii: Array,
    materials: Sequence[Material],
    *,
    surface_pressure: Array = 0.0,
    gravitational_constant: Array = 1.0,
    steps: int = DEFAULT_STEPS,
) -> HydrostaticPlanet:
    """The planet of layers with given outer radii (layers,), ascending, each of one material; its mass is found.

    Arguments and errors as for `planet_from_masses`. Source and checks: the module.

    >>> from astroinertia.matter.planetary import ModifiedPolytrope
    >>> planet = planet_from_radii([1.0], [ModifiedPolytrope(3 / (4 * np.pi), 0.0)])  # incompressible
    >>> print(f"{planet.mass:.6f} {planet.moment_ratio:.6f} {planet.gravitational_energy:.6f}")  # 1, 2/5 and -3/5
    1.000000 0.400000 -0.600000
    """
    return _planet(outer_radii, materials, surface_pressure, gravitational_constant, steps, "radius")


def _planet(
    layers: Array, materials: Sequence[Material], surface_pressure: Array, g: Array, steps: int, by: str
) -> HydrostaticPlanet:
    if is_known(layers):
        layers = np.asarray(layers, dtype=float)
        widths = layers if by == "mass" else np.diff(layers, prepend=0.0)
        if layers.shape != (len(materials),):
            raise ValueError(f"{len(materials)} materials need as many layers, not {layers.shape}")
        if not (np.isfinite(layers).all() and (widths >= 0).all() and widths.sum() > 0):
            raise ValueError(
                f"each layer needs a {by} that is finite and {'not negative' if by == 'mass' else 'rises'}"
            )
    if steps < 1 or steps % 1 != 0:
        raise ValueError(f"a layer needs a whole number of steps, at least one, not {steps}")
    planet = _solve(layers, tuple(materials), surface_pressure, g, steps, by)
    if is_known(planet.residual) and not abs(float(planet.residual)) < 1e-9:
        raise NumericalError(
            f"no hydrostatic equilibrium was found with G = {float(g):.5g}: its pressure is beyond what the materials' "
            "equations of state reach"
        )
    if is_known(planet.resolution_error) and not float(planet.resolution_error) < _RESOLUTION:
        raise NumericalError(f"{steps} steps a layer are too few for a planet that is compressed so much")
    return planet


@double_precision("steps", "by")
def _solve(
    layers: Array, materials: tuple, surface_pressure: Array, gravitational_constant: Array, steps: int, by: str
) -> HydrostaticPlanet:
    layers = jnp.asarray(layers, dtype=float)
    g = jnp.asarray(gravitational_constant, dtype=float)
    surface_pressure = jnp.asarray(surface_pressure, dtype=float)
    matter = _one_of_kinds(materials)
    densities = jax.lax.map(lambda layer: layer.density(surface_pressure), matter)
    if by == "mass":
        volumes = jnp.cumsum(
            3 * layers / (_FOUR_PI * densities)
        )  # radii^3 of what is no more compressed than the surface
        mass, radius = jnp.sum(layers), jnp.cbrt(volumes[-1])
        outer = _cube_root(volumes / volumes[-1])
        full = _FOUR_PI / 3 * densities * volumes[-1]
        below = jnp.concatenate([jnp.zeros(1), jnp.cumsum(layers)[:-1]])
        equation: _ByMass | _ByRadius = _ByMass(g, full, below - full * _inner(outer) ** 3)
    else:
        radius, outer = layers[-1], layers / layers[-1]
        mass = _FOUR_PI / 3 * radius**3 * jnp.sum(densities * jnp.diff(outer**3, prepend=0.0))
        equation = _ByRadius(radius, g)
    equation = jax.tree.map(lambda part: jnp.broadcast_to(part, layers.shape), equation)
    parts = _Parts(equation, matter, _step_edges(outer, steps))
    # the uncompressed planet's, which compression raises: 3 G M^2/(8 pi R^4)
    guess = jnp.log(1.5 * 3 * g * mass**2 / (2 * _FOUR_PI * radius**4) + surface_pressure)
    log_pressure, end, rows = _equilibrium(parts, surface_pressure, jax.lax.stop_gradient(guess))
    t, content, pressure = rows[..., 0], rows[..., 1], rows[..., 2]
    r, m = equation.radius_and_mass(t, content)
    density, compressibility = jax.lax.map(
        lambda layer: jax.jvp(layer[0].density, layer[1:], (jnp.ones_like(layer[1]),)), (matter, pressure)
    )
    positive = r > 0
    gravity = jnp.where(positive, g * m / jnp.where(positive, r, 1.0) ** 2, 0.0)
    return HydrostaticPlanet(
        mass=m[-1, -1],
        mean_radius=r[-1, -1],
        mean_moment=end[2],
        gravitational_energy=end[3],
        central_pressure=jnp.exp(log_pressure),
        radius=r,
        enclosed_mass=m,
        pressure=pressure,
        density=density,
        density_slope=-compressibility * density * gravity,
        residual=jnp.maximum(jnp.abs(end[1] - surface_pressure), end[5]) * jnp.exp(-log_pressure),
        resolution_error=end[4] / end[0],
        gravitational_constant=g,
    )


@pytree
@dataclass(frozen=True)
class _OneOf:
    """The matter of a layer: which of several kinds it is, and a material of each kind."""

    which: Array
    kinds: tuple

    def density(self, pressure: Array) -> Array:
        """Density at a pressure, any shape."""
        return jax.lax.switch(self.which, [kind.density for kind in self.kinds], pressure)


def _one_of_kinds(materials: tuple) -> _OneOf:
    """Materials as one, with a first axis of layers: the program of a layer has each kind of matter in it once."""
    materials = jax.tree.map(lambda part: jnp.asarray(part, dtype=float), materials)
    kinds: dict[Any, list[int]] = {}
    for layer, one in enumerate(materials):
        leaves, structure = jax.tree.flatten(one)
        kinds.setdefault((structure, tuple(map(jnp.shape, leaves))), []).append(layer)
    which, stacks = np.empty(len(materials), dtype=int), []
    for kind, layers in enumerate(kinds.values()):
        which[layers] = kind
        own = [one if layer in layers else materials[layers[0]] for layer, one in enumerate(materials)]
        stacks.append(jax.tree.map(lambda *parts: jnp.stack(parts), *own))
    return _OneOf(jnp.asarray(which), tuple(stacks))


_FOUR_PI = 4 * math.pi


class _ByMass(NamedTuple):
    """The equations with t = x/X, the radius if no matter were more compressed than at the surface; the content is r^3.

    full: the mass of a whole sphere of the radius X of a layer's matter; excess: what the matter below the layer has
    more than that of the layer would have in its place.
    """

    g: Array
    full: Array
    excess: Array

    def content_slope(self, density: Array) -> Array:
        """Of the content over t^2."""
        return 9 * self.full / (_FOUR_PI * density)

    def pressure_slope(self, _: Array, mean_content: Array, t: Array) -> Array:
        """Of the pressure over t; mean_content is V."""
        return -3 * self.g * self.full * (self.full + self.excess / t**3) / _FOUR_PI * mean_content ** (-4 / 3)

    def moment_and_energy_slopes(self, _: Array, mean_content: Array, t: Array) -> Array:
        """Of I and W: (2/3) r^2 dm/dt and -(G m/r) dm/dt."""
        u = jnp.cbrt(mean_content)
        shell = self.full * t**4
        return jnp.stack([2 * shell * u**2, -3 * self.g * (self.full + self.excess / t**3) * shell / u])

    def radius_and_mass(self, t: Array, content: Array) -> tuple[Array, Array]:
        """At rows (layers, rows)."""
        return _cube_root(content), self.full[:, None] * t**3 + self.excess[:, None]


class _ByRadius(NamedTuple):
    """The equations with t = r/R; the content is m."""

    radius: Array
    g: Array

    def content_slope(self, density: Array) -> Array:
        """Of the content over t^2."""
        return _FOUR_PI * self.radius**3 * density

    def pressure_slope(self, density: Array, mean_content: Array, _: Array) -> Array:
        """Of the pressure over t; mean_content is V."""
        return -self.g / self.radius * density * mean_content

    def moment_and_energy_slopes(self, density: Array, mean_content: Array, t: Array) -> Array:
        """Of I and W: (2/3) r^2 dm/dt and -(G m/r) dm/dt."""
        shell = self.content_slope(density) * t**4
        return jnp.stack([2 / 3 * self.radius**2 * shell, -self.g / self.radius * mean_content * shell])

    def radius_and_mass(self, t: Array, content: Array) -> tuple[Array, Array]:
        """At rows (layers, rows)."""
        return self.radius[:, None] * t, content


def _inner(outer: Array) -> Array:
    """The t of the layers' inner boundaries (layers,) from those of their outer ones."""
    return jnp.concatenate([jnp.zeros(1), outer[:-1]])


def _step_edges(outer: Array, steps: int) -> Array:
    """The t of the edges of each layer's steps, (layers, steps + 1), from those of the layers' outer boundaries.

    Those outside a core grow as its distance does, beyond it evenly in ln(t + GRADING).
    """
    ramp = 1 - np.arange(steps + 1) / steps
    ramps = np.stack([ramp ** (_CROWDING if k == len(outer) - 1 else 1) for k in range(len(outer))])
    inner, top = _inner(outer)[:, None], outer[:, None]
    even = top - (top - inner) * ramps
    graded = (top + _GRADING) * ((inner + _GRADING) / (top + _GRADING)) ** ramps - _GRADING
    graded = graded.at[:, 0].set(inner[:, 0]).at[:, -1].set(outer)
    return jnp.where(inner > 0, graded, even)


class _Parts(NamedTuple):
    """What is integrated, of each layer: the equation, its matter, and t at the edges of its steps (steps + 1,)."""

    equation: _ByMass | _ByRadius
    matter: _OneOf
    edges: Array


def _integrated(parts: _Parts, log_pressure: Array) -> tuple[Array, Array]:
    """The state at the surface from a pressure at the centre, and the rows of all layers."""

    return jax.lax.scan(
        lambda state, layer: _through_layer(*layer, state), jnp.zeros(6).at[1].set(jnp.exp(log_pressure)), parts
    )


@jax.custom_jvp
def _equilibrium(parts: _Parts, surface_pressure: Array, guess: Array) -> tuple[Array, Array, Array]:
    """The logarithm of the pressure at the centre with which that at the surface is met, and what follows from it.

    By the secant method with bounded steps, for the one at the surface rises with the one at the centre.
    """

    def unfinished(state: tuple) -> Array:
        count, change = state[:2]
        return (count < _SECANT_STEPS) & (jnp.abs(change) > _TOLERANCE)

    def improve(state: tuple) -> tuple:
        count, _, x, before, excess_before, slope, _ = state
        end, rows = _integrated(parts, x)
        excess = (end[1] - surface_pressure) * jnp.exp(-x)
        secant = (excess - excess_before) / (x - before)
        slope = jnp.where(jnp.isfinite(secant), secant, slope)
        change = jnp.clip(jnp.where(slope > 0, -excess / slope, 1.0), -_LARGEST_CHANGE, _LARGEST_CHANGE)
        # Too little at the centre, and no density is left below the surface: halfway back, or on.
        back = jnp.where(jnp.isfinite(excess_before), 0.5 * (before - x), 1.0)
        known = jnp.isfinite(excess)
        change = jnp.where(known, change, back)
        before, excess_before = jnp.where(known, x, before), jnp.where(known, excess, excess_before)
        return count + 1, change, x + change, before, excess_before, slope, (x, end, rows)

    shapes = jax.eval_shape(_integrated, parts, guess)
    empty = (guess, *jax.tree.map(lambda one: jnp.zeros(one.shape, one.dtype), shapes))
    # Where nothing is compressed the slope is 1.
    start = (0, jnp.inf, guess, guess, jnp.nan, jnp.ones_like(guess), empty)
    return jax.lax.while_loop(unfinished, improve, start)[-1]


@_equilibrium.defjvp
def _equilibrium_jvp(at: tuple, along: tuple) -> tuple[tuple, tuple]:
    """By the implicit function theorem; the guess has no part in it."""
    parts, of_surface = at[0], along[1]
    found = _equilibrium(*at)
    by_parts = jax.jvp(lambda own: _integrated(own, found[0]), (parts,), along[:1])[1]
    by_centre = jax.jvp(partial(_integrated, parts), found[:1], (jnp.ones_like(found[0]),))[1]
    moved = (of_surface - by_parts[0][1]) / by_centre[0][1]
    return found, (moved, *jax.tree.map(lambda own, other: own + moved * other, by_parts, by_centre))


def _through_layer(equation: _ByMass | _ByRadius, matter: _OneOf, edges: Array, state: Array) -> tuple[Array, Array]:
    """The state at the outer boundary, and rows (steps * (1 + nodes) + 1, 3) of t, content and P, ending with it.

    edges: (steps + 1,) of t. state: content, P, I, W, the sum for the resolution error, and the largest change of P by
    a last iteration.
    """
    c, weights, tau, inner_weights, to_node, to_end = collocation(_NODES, 2)
    last_coefficient = np.linalg.inv(np.polynomial.legendre.legvander(2 * c - 1, _NODES - 1))[-1]
    # Integrals from the step's beginning to each node, and to its end, times powers 0, 1 and 2 of where it is there.
    to_nodes = [np.einsum("i,iq,q,iqj->ij", c, (c[:, None] * tau) ** k, inner_weights, to_node) for k in range(3)]
    to_ends = [(tau**k * inner_weights) @ to_end for k in range(3)]

    def step(carried: Array, limits: tuple[Array, Array]) -> tuple[Array, Array]:
        before, width = limits[0], limits[1] - limits[0]
        content, pressure = carried[0], carried[1]
        t = before + width * c
        some = t > 0  # not so only in a layer of no width at the centre
        safe = jnp.where(some, t, 1.0)
        fall, whole_fall = (width * (before * zero + width * one) for zero, one, _ in (to_nodes, to_ends))
        growth, whole_growth = (
            width * (before**2 * zero + 2 * before * width * one + width**2 * two)
            for zero, one, two in (to_nodes, to_ends)
        )

        def improved(carry: _AtNodes, _: None) -> tuple[_AtNodes, Array]:
            nodes = pressure + fall @ carry.pressure_slope
            density = matter.density(nodes)
            filled = content + growth @ equation.content_slope(density)
            mean = jnp.where(some, filled / safe**3, 1.0)
            new = _AtNodes(nodes, density, mean, equation.pressure_slope(density, mean, safe))
            return new, jnp.max(jnp.abs(nodes - carry.pressure))

        nothing = jnp.zeros(_NODES)
        nodes, changes = jax.lax.scan(improved, _AtNodes(*[nothing] * 4), length=_PICARD)
        filling = equation.content_slope(nodes.density)
        grown = whole_growth @ filling
        increment = jnp.concatenate([
            jnp.stack([grown, whole_fall @ nodes.pressure_slope]),
            width * equation.moment_and_energy_slopes(nodes.density, nodes.mean_content, safe) @ weights,
            jnp.atleast_1d(jnp.abs(last_coefficient @ filling / jnp.mean(filling)) * grown),
        ])  # fmt: skip
        unsettled = jnp.maximum(carried[5], changes[-1])
        rows = jnp.stack([t, nodes.mean_content * t**3, nodes.pressure], axis=-1)
        first = jnp.stack([before, content, pressure])
        return jnp.append(carried[:5] + increment, unsettled), jnp.concatenate([first[None], rows])

    last, rows = jax.lax.scan(step, state, (edges[:-1], edges[1:]))
    return last, jnp.concatenate([rows.reshape(-1, 3), jnp.stack([edges[-1], last[0], last[1]])[None]])


class _AtNodes(NamedTuple):
    """Pressure, density, mean content V and pressure slope over t at the nodes of a step."""

    pressure: Array
    density: Array
    mean_content: Array
    pressure_slope: Array


def _cube_root(value: Array) -> Array:
    """The cube root, with a derivative of zero at zero."""
    positive = value > 0
    return jnp.where(positive, jnp.cbrt(jnp.where(positive, value, 1.0)), 0.0)
