"""Densities and smoothing lengths on the xla engine: a safeguarded Newton solve with implicit derivatives.

With s = sum_j m_j w(r/h_i) = rho h^3 and t = sum_j m_j q dw(q) < 0, both of one pass over pairs,

    h solves  s = eta^3 m;    d ln s / d ln h = -t/s = 3 Omega,

so that the pass gives Newton's step, the density and Omega (grad_h) at once, and the last pass of the iteration is the
one that counts. h^3 rho always grows with h: the root is unique, and a bracket makes the iteration safe.
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from astroinertia.engines import xla_lists, xla_places, xla_tiles
from astroinertia.engines.xla_lists import Arrangement
from astroinertia.sph.kernels import KERNELS

Array = Any
MOST_ITERATIONS = 100
LONGEST = 0.7  # change of ln h in one step
CLIPPED = 1e-6  # how near the bracket's other end a clipped step may come
# What rounding leaves of a change of ln h, for pairs in float64 and float32.
ROUNDING = {"float64": 1e-13, "mixed": 3e-6}


@partial(jax.jit, static_argnames=("kernel", "precision", "tolerance", "softening"))
def density(
    kernel: str,
    precision: str,
    tolerance: float,
    softening: bool,
    arrangement: Arrangement,
    position: Array,
    mass: Array,
    guess: Array,
    eta: Array,
) -> tuple[Array, Array, Array, Array | None]:
    """Smoothing lengths, densities, grad_h and zeta (N,), differentiable in position (N, 3), mass (N,) and eta."""
    with jax.named_scope("density"):
        guess = jax.lax.stop_gradient(guess)
        h, sums = solved(kernel, precision, tolerance, softening, arrangement, position, mass, guess, eta)
        s, t = sums[:, 0], sums[:, 1]
        zeta = h * h * sums[:, 2] / (3.0 * s) if softening else None
        return h, s / (h * h * h), -t / (3.0 * s), zeta


@partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def solved(
    kernel: str,
    precision: str,
    tolerance: float,
    softening: bool,
    arrangement: Arrangement,
    position: Array,
    mass: Array,
    guess: Array,
    eta: Array,
) -> tuple[Array, Array]:
    """Smoothing lengths (N,) with rho(h) = m (eta/h)^3 for each particle, whatever the guess, and the sums there."""
    wanted = eta**3 * mass
    rounding = ROUNDING[precision]
    enough = max(tolerance, rounding)

    def unfinished(state: tuple) -> Array:
        _, _, _, _, change, count = state
        return (count < MOST_ITERATIONS) & (jnp.abs(change) > enough).any()

    def improved(state: tuple) -> tuple:
        h, low, high, _, _, count = state
        sums = _sums(kernel, precision, False, arrangement, position, mass, h)
        excess = jnp.log(sums[:, 0] / wanted)
        slope = jnp.maximum(-sums[:, 1] / sums[:, 0], 0.3)
        low = jnp.where(excess < 0.0, h, low)
        high = jnp.where(excess > 0.0, h, high)
        step = -excess / slope
        newton = h * jnp.exp(jnp.clip(step, -LONGEST, LONGEST))
        # A clipped step onto the bracket's other end is none: two of them would go to and fro for ever.
        margin = jnp.where(jnp.abs(step) > LONGEST, CLIPPED, -rounding)
        outside = (newton < low * (1.0 + margin)) | (newton > high * (1.0 - margin))
        new = jnp.where(outside, jnp.sqrt(low * jnp.minimum(high, 1e300)), newton)
        new = jnp.minimum(new, arrangement.longest)
        change = jnp.log(new / h)
        # To first order in the change, which is below the tolerance in the end.
        sums = sums * (1.0 + slope * change)[:, None]
        return new, low, high, sums, change, count + 1

    # A guess beyond what the lists cover would send the first pass through all tiles.
    guess = jnp.minimum(guess, (1.0 + 0.5 * arrangement.reach.growth) * arrangement.smoothing_length)
    nothing = jnp.zeros_like(guess)
    start = (guess, nothing, nothing + jnp.inf, jnp.zeros((len(guess), 2)), nothing + 1.0, 0)
    h, _, _, sums, _, _ = jax.lax.while_loop(unfinished, improved, start)
    return h, _sums(kernel, precision, True, arrangement, position, mass, h) if softening else sums


@solved.defjvp
def _solved_jvp(kernel, precision, tolerance, softening, primals, tangents):
    # d ln(s/(eta^3 m)) = 0 along the solution, with d ln s / d ln h = -t/s.
    arrangement, position, mass, guess, eta = primals
    _, d_position, d_mass, _, d_eta = tangents
    h, _ = solved(kernel, precision, tolerance, False, arrangement, position, mass, guess, eta)

    def sums_at(position: Array, mass: Array, h: Array) -> Array:
        return _sums(kernel, precision, softening, arrangement, position, mass, h)

    sums, d_sums = jax.jvp(lambda x, m: sums_at(x, m, h), (position, mass), (d_position, d_mass))
    s, t = sums[:, 0], sums[:, 1]
    d_h = h * (d_sums[:, 0] / s - d_mass / mass - 3.0 * d_eta / eta) * (s / t)
    _, by_h = jax.jvp(lambda h: sums_at(position, mass, h), (h,), (d_h,))
    return (h, sums), (d_h, d_sums + by_h)


def _sums(
    kernel: str, precision: str, softening: bool, arrangement: Arrangement, position: Array, mass: Array, h: Array
) -> Array:
    # sum_j m_j [w, q dw, and with softening phi + q dphi] for each particle, (N, 2 or 3), itself included.
    shape = KERNELS[kernel]
    tiles = arrangement.neighbours
    covered = xla_lists.holds(arrangement, position, h, shape.support)
    places = xla_places.places_of(precision, {"position": position, "mass": mass, "smoothing_length": h})
    boxes = xla_tiles.boxes_of(places, shape.support, tiles, covered)

    def chunk_sums(places: xla_places.Places, target: Array, source: Array) -> dict[str, Array]:
        targets, sources, (_, masses) = places.tile(target, source)
        pairs = xla_tiles.Pairs(shape, targets, sources)
        q = pairs["r"] * pairs.inverse_length("i")
        parts = [shape.w(jnp, q), q * shape.dw(jnp, q)]
        if softening:
            # Zero beyond the support but for rounding.
            parts.append(jnp.where(q < shape.support, shape.phi(jnp, q) + q * shape.dphi(jnp, q), 0.0))
        return {"sum": jnp.stack([xla_tiles.weighted(part, masses) for part in parts], axis=2)}

    zero = {"sum": jnp.zeros((*tiles.slots.shape, 3 if softening else 2), h.dtype)}
    return xla_tiles.sum_over_tiles(tiles, covered, boxes, places, chunk_sums, zero)["sum"][tiles.row, tiles.column]
