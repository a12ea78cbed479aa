"""Clairaut's equation: how the level surfaces of a slowly rotating or tidally forced fluid body are flattened.

Level surfaces r(1 + f_l P_l) of a body in hydrostatic equilibrium obey, to first order in f_l and with
D = rho/rho_mean(<r),

    r^2 f_l'' + 6 D (r f_l' + f_l) - l(l + 1) f_l = 0,    eta = r f_l'/f_l,    k_l = (l + 1 - eta)/(l + eta) at r = R.

For layered bodies it is solved in the disturbed potential psi = g r f_l = P r^l,

    P(r) = A + b (r_0/r)^(2l+1) + 3/(2l+1) integral from r_0 to r of (1 - (s/r)^(2l+1)) rho'(s)/rho_mean(s) P ds,

with A the part that comes from outside and b from inside r_0. Each step of the solution is a 2 x 2 matrix for (A, b):
exact where the density is constant and at every jump, and by Gauss-Legendre collocation of high order elsewhere.

Sources: Clairaut 1743; Radau 1885; Jeffreys 1976, The Earth, ch. IV; Kopal 1959, Close Binary Systems, ch. II; the
integral form is the Poisson equation with the density carried along by its level surfaces.
Tests: tests/unit/bodies/test_clairaut.py, tests/hard/test_layered_hard.py; cost:
tests/benchmarks/work_precision_layered.py.
"""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.bodies.collocation import collocation
from astroinertia.bodies.layered import LayeredBody, layer_bounds
from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.engines.pytree import pytree
from astroinertia.inertia.double_precision import double_precision
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities

Array = Any

_HOMOGENEOUS_LOVE_NUMBER, _LEAST_RATIO = 1.5, 2 / 15  # k_2 of a uniform fluid; the ratio that goes with k_2 = 0
_ROUND_OFF = 1e-9  # of a body solved for numerically
_NODES = 8  # collocation nodes a step
DEFAULT_STEPS = 6  # steps a layer: the knee in tests/benchmarks/results/work_precision_layered.md
_GRADING = 0.3  # share of R: steps of a layer around a small core are even well inside it, geometric well outside


@with_quantities()
@double_precision("degree", "steps")
def love_number(body: LayeredBody, degree: int = 2, steps: int = DEFAULT_STEPS) -> Array:
    """The fluid Love number k_l of a layered body, a scalar, for any degree l >= 2 (normalised with the mean radius).

    steps: collocation steps a layer; layers of constant density need none and are exact. ValueError for l < 2. Source:
    the module's integral equation; k_l is what the body adds to the potential at its surface over what disturbs it.
    Checked by tests/unit/bodies/test_clairaut.py.

    >>> from astroinertia.bodies.layered import constant_layers
    >>> print(f"{float(love_number(constant_layers([1.0], [1.0]))):.6f}")
    1.500000
    """
    from_outside, from_inside, _ = _disturbance(body, degree, steps)
    return from_inside / from_outside


@with_quantities()
@double_precision("degree")
def radau_variable(body: LayeredBody, degree: int = 2) -> Array:
    """Radau's eta at the surface, a scalar: l - 2 for a homogeneous body, l + 1 for a point mass.

    k_l = (l + 1 - eta)/(l + eta); degree and errors as for `love_number`. Source: Radau 1885. Checked by
    tests/unit/bodies/test_clairaut.py.

    >>> from astroinertia.bodies.layered import constant_layers
    >>> print(f"{abs(float(radau_variable(constant_layers([1.0], [1.0])))):.6f}")
    0.000000
    """
    from_outside, from_inside, _ = _disturbance(body, degree, DEFAULT_STEPS)
    return ((degree + 1) * from_outside - degree * from_inside) / (from_outside + from_inside)


@pytree
@dataclass(frozen=True)
class HydrostaticFigure:
    """A layered body in slow rigid rotation, to first order in small_m; a JAX pytree of scalars but layer_flattenings.

    small_m = Omega^2 R^3/(G M) with the mean radius R; love_number k_2; flattening f = 1 - c/a; j2 (C - A)/(M R^2), to
    first order the same with the equatorial radius; mean_moment I, polar_moment C and equatorial_moment A with
    (2 A + C)/3 = I; dynamical_flattening H = (C - A)/C; equatorial_radius a and polar_radius c of the mean radius R;
    layer_flattenings (layers,) of the outer boundary of each layer.
    """

    small_m: Array
    love_number: Array
    flattening: Array
    j2: Array
    mean_moment: Array
    polar_moment: Array
    equatorial_moment: Array
    dynamical_flattening: Array
    equatorial_radius: Array
    polar_radius: Array
    layer_flattenings: Array


@with_quantities()
def hydrostatic_figure(body: LayeredBody, angular_velocity: Array) -> HydrostaticFigure:
    """Flattening, J2 and moments of a layered body that rotates rigidly at `angular_velocity` (a scalar), first order.

    With no rotation it is exactly the sphere. The neglected terms are of relative order small_m. f = m (1 + k_2)/2,
    J2 = m k_2/3 and C - A = J2 M R^2: Jeffreys 1976, ch. IV. ValueError from small_m = 1 on, where the body would turn
    as fast as an orbit at its surface (not within a JAX transformation). Checked by tests/unit/bodies/test_clairaut.py.

    >>> from astroinertia.bodies.layered import constant_layers
    >>> one = constant_layers([1.0], [3 / (4 * np.pi)])  # M = R = G = 1
    >>> print(f"{float(hydrostatic_figure(one, 0.1).flattening):.6f}")  # (5/4) Omega^2
    0.012500
    """
    figure = _first_order(body, angular_velocity)
    if is_known(figure.small_m) and np.any(np.asarray(figure.small_m) >= 1):
        raise ValueError(
            "a body with Omega^2 R^3/(G M) of 1 or more would turn as fast as an orbit at its surface, or faster: not "
            f"{float(figure.small_m):.3g}"
        )
    return figure


@double_precision()
def _first_order(body: LayeredBody, angular_velocity: Array) -> HydrostaticFigure:
    radius, mass, mean_moment = body.mean_radius, body.mass, body.mean_moment
    small_m = angular_velocity**2 * radius**3 / (body.gravitational_constant * mass)
    from_outside, from_inside, inside = _disturbance(body, 2, DEFAULT_STEPS)
    k2 = from_inside / from_outside
    mean_density = _mean_density(body, layer_bounds(body)[1])
    flattenings = small_m / 2 * mean_density[-1] / mean_density * inside / from_outside
    j2 = small_m * k2 / 3
    difference = j2 * mass * radius**2
    polar = mean_moment + 2 / 3 * difference
    flattening = flattenings[-1]
    return HydrostaticFigure(
        small_m=small_m,
        love_number=k2,
        flattening=flattening,
        j2=j2,
        mean_moment=mean_moment,
        polar_moment=polar,
        equatorial_moment=mean_moment - difference / 3,
        dynamical_flattening=difference / polar,
        equatorial_radius=radius * (1 + flattening / 3),
        polar_radius=radius * (1 - 2 / 3 * flattening),
        layer_flattenings=flattenings,
    )


@with_quantities()
def radau_darwin_moment_ratio(love_number: Array) -> Array:
    """I/(M R^2) (mean radius) from the fluid k_2 by the Radau-Darwin approximation, (2/3)(1 - (2/5) sqrt(1 + eta)).

    1 + eta = (4 - k)/(1 + k). Exact for a homogeneous body, 1e-3 off or worse for strong central condensation:
    `radau_darwin_error` says how much for a given body. k_2 = 3 J2/m = 2 f/m - 1. ValueError for a k_2 below 0, or
    above the 3/2 of a homogeneous body: no fluid has it whose density does not rise outwards. Source: Darwin 1899;
    Murray & Dermott 1999, eq. 4.112. Checked by tests/unit/bodies/test_clairaut.py.

    >>> print(f"{radau_darwin_moment_ratio(1.5):.6f}")  # of a homogeneous body, exactly
    0.400000
    """
    _refuse_beyond(love_number, 0.0, _HOMOGENEOUS_LOVE_NUMBER, "a fluid k_2 is from 0 to 3/2, that of a uniform body")
    xp = jnp if isinstance(love_number, jax.Array) else np
    return 2 / 3 * (1 - 0.4 * xp.sqrt((4 - love_number) / (1 + love_number)))


@with_quantities()
def radau_darwin_love_number(moment_ratio: Array) -> Array:
    """The fluid k_2 that the Radau-Darwin approximation gives for I/(M R^2): the inverse of the function above.

    ValueError for a ratio above 0.4, that of a uniform sphere, or below the 2/15 that it has for k_2 = 0: such a body
    is too condensed for it. Source and check as there.

    >>> print(f"{radau_darwin_love_number(0.4):.6f}")
    1.500000
    """
    limits = "Radau-Darwin holds for I/(M R^2) from 2/15 (k_2 = 0) to 0.4 (uniform)"
    _refuse_beyond(moment_ratio, _LEAST_RATIO, UNIFORM, limits)
    root_squared = (2.5 * (1 - 1.5 * moment_ratio)) ** 2
    return (4 - root_squared) / (1 + root_squared)


@with_quantities()
def radau_darwin_error(body: LayeredBody) -> Array:
    """What Radau-Darwin gives for I/(M R^2) from the body's true k_2, less its true moment ratio: a scalar.

    Source: Clairaut's equation solved without it. Checked by tests/unit/bodies/test_clairaut.py.

    >>> from astroinertia.bodies.layered import constant_layers
    >>> print(f"{float(radau_darwin_error(constant_layers([0.5, 1.0], [2.0, 1.0]))):.0e}")
    -2e-04
    """
    return radau_darwin_moment_ratio(love_number(body)) - body.moment_ratio


def _refuse_beyond(value: Array, least: float, most: float, limits: str) -> None:
    """ValueError where a known value is out of bounds by more than the round-off of its own precision.

    NaN is what was not known, and passes.
    """
    if is_known(value):
        given = np.asarray(value)
        number, own = given.astype(float), np.finfo(given.dtype).eps if given.dtype.kind == "f" else 0.0
        round_off = max(_ROUND_OFF, float(own))
        wrong = (number < least - round_off) | (number > most + round_off)
        if wrong.any():
            raise ValueError(f"{limits}, not {number[wrong].flat[0]:g}")


def _density(coefficients: Array, x: Array) -> Array:
    """The density of layers (layers, terms) at x (layers, ...)."""
    return sum(_column(coefficients[:, k], x) * x**k for k in range(coefficients.shape[1]))


def _density_slope(coefficients: Array, x: Array) -> Array:
    """Its derivative by x."""
    return sum(_column(coefficients[:, k], x) * k * x ** (k - 1) for k in range(1, coefficients.shape[1]))


def _mean_density(body: LayeredBody, x: Array) -> Array:
    """The mean density inside x (layers, ...), continuous across boundaries."""
    safe = jnp.where(x > 0, x, 1.0)  # at the centre itself the layer, or one of no thickness below, is all there is
    below = jnp.where(x > 0, _column(layer_bounds(body)[2], x) / safe**3, 0.0)
    terms = jnp.arange(body.coefficients.shape[1])
    return 3 * (below + _density(body.coefficients / (terms + 3.0), x))


def _column(values: Array, like: Array) -> Array:
    return values.reshape((-1,) + (1,) * (like.ndim - 1))


def _disturbance(body: LayeredBody, degree: int, steps: int) -> tuple[Array, Array, Array]:
    """(A, b) outside the surface, and P at the outer boundary of each layer, for a disturbance of any one size."""
    if not degree >= 2 or degree % 1 != 0:
        raise ValueError(f"Clairaut's equation needs a whole degree of 2 or more, not {degree!r}")
    if steps < 1:
        raise ValueError(f"the steps of Clairaut's equation must be at least 1 a layer, not {steps!r}")
    power = 2 * degree + 1
    x_in, x_out, _ = layer_bounds(body)
    above = jnp.concatenate([_density(body.coefficients[1:], x_out[:-1]), jnp.zeros(1)])
    rise = 3 * (above - _density(body.coefficients, x_out)) / (power * _mean_density(body, x_out))
    across = jnp.eye(2) + rise[:, None, None] * jnp.array([[1.0, 1.0], [-1.0, -1.0]])
    through = _through_layers(body, x_in, x_out, power, steps)

    def pass_layer(state: Array, matrices: tuple[Array, Array]) -> tuple[Array, Array]:
        at_boundary = matrices[0] @ state
        return matrices[1] @ at_boundary, jnp.sum(at_boundary)

    end, at_boundary = jax.lax.scan(pass_layer, jnp.array([1.0, 0.0]), (through, across))
    return end[0], end[1], at_boundary


def _through_layers(body: LayeredBody, x_in: Array, x_out: Array, power: int, steps: int) -> Array:
    """The matrix (layers, 2, 2) that carries (A, b) from the inner to the outer boundary of each layer."""
    if body.coefficients.shape[1] == 1:
        unchanged, none = jnp.ones_like(x_in), jnp.zeros_like(x_in)
        ratio = jnp.where(x_out > 0, x_in / jnp.where(x_out > 0, x_out, 1.0), 1.0)
        return jnp.stack([unchanged, none, none, ratio**power], axis=-1).reshape(-1, 2, 2)
    share = jnp.arange(1, steps) / steps
    start, end = x_in[:, None] + _GRADING, x_out[:, None] + _GRADING
    graded = start * (end / start) ** share - _GRADING
    central = jnp.arange(len(x_in))[:, None] == 0
    inner = jnp.where(central, x_out[:, None] * share, graded)
    edges = jnp.concatenate([x_in[:, None], inner, x_out[:, None]], axis=1)
    matrices = _through_steps(body, edges[:, :-1], edges[:, 1:], power)
    whole = matrices[:, 0]
    for step in range(1, steps):
        whole = matrices[:, step] @ whole
    return whole


def _through_steps(body: LayeredBody, x_in: Array, x_out: Array, power: int) -> Array:
    """The same for steps (layers, steps) -> (layers, steps, 2, 2), by collocation of P at Gauss's nodes.

    The integral of the kernel times an interpolating polynomial is exact, so that a step may begin at the centre.
    """
    c, weights, tau, inner_weights, to_node, to_end = collocation(_NODES, power)
    width = x_out - x_in
    x = x_in[..., None] + width[..., None] * c
    safe = jnp.where(x > 0, x, 1.0)
    drop = -3 / power * _density_slope(body.coefficients, x) / _mean_density(body, x)  # with P: dA/dx = -drop P
    ratio = jnp.where(x > 0, x_in[..., None] / safe, 1.0)
    reach = ratio[..., None] + (1 - ratio[..., None]) * tau  # s/x in the inner integral from x_in to each node
    kernel = jnp.einsum("...iq,q,iqj->...ij", 1 - reach**power, inner_weights, to_node)
    system = jnp.eye(_NODES) + (x - x_in[..., None])[..., None] * kernel * drop[..., None, :]
    sources = jnp.stack([jnp.ones_like(x), ratio**power], axis=-1)
    disturbance = jnp.linalg.solve(system, sources)  # P at the nodes for (A, b) = (1, 0) and (0, 1)
    moved = width[..., None, None] * drop[..., None] * disturbance
    last = jnp.where(x_out > 0, x_in / jnp.where(x_out > 0, x_out, 1.0), 1.0)
    weight_of_inside = (last[..., None] + (1 - last[..., None]) * tau) ** power * inner_weights @ to_end
    lost = jnp.einsum("i,...is->...s", weights, moved)
    gained = jnp.einsum("...i,...is->...s", weight_of_inside, moved)
    return jnp.stack([jnp.array([1.0, 0.0]) - lost, gained + last[..., None] ** power * jnp.array([0.0, 1.0])], -2)
