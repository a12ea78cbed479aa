"""Spins in step with an eccentric orbit: strength, width and overlap of resonances, capture, phase portrait.

A body that turns about its axis of C, normal to its orbit, by the angle theta of its long axis from the pericentre:

    d2 theta/dt2 = -(omega_0^2/2) n^2 (a/r)^3 sin 2(theta - f),    omega_0^2 = 3 (B - A)/C.

Near theta' = p n, gamma = theta - p M swings as a pendulum of strength H(p, e) (`cassini.hansen_coefficient`).
Sources: Goldreich & Peale 1966, AJ 71, 425; Wisdom, Peale & Mignard 1984, Icarus 58, 137.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.inertia.tensor import require_plausible
from astroinertia.process.positive import refuse_negative
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.cassini import hansen_coefficient

Array = Any

_STEPS = 96  # an orbit; the energy of a swing is then kept to 1e-8 at e = 0.1
# Blanes & Moan 2002, J. Comp. Appl. Math. 142, 313: order 4 for x'' = f(x, t) in six kicks, with small error terms.
_DRIFTS = (0.0792036964311957, 0.353172906049774, -0.0420650803577195)
_KICKS = (0.209515106613362, -0.143851773179818)
_NO_WIDTH = 1e-7  # the root of what round-off leaves of a strength


class Section(NamedTuple):
    """A surface of section at the pericentre: angle (orbit, start), from -pi/2 to pi/2, and rate theta'/n."""

    angle: np.ndarray
    rate: np.ndarray


@with_quantities()
def asphericity(moments: Array) -> Array:
    """omega_0 = (3 (B - A)/C)^(1/2) of principal moments (..., 3) in any order.

    ValueError where one is not above 0, or more than the other two together: no body has these. Source: Wisdom, Peale
    & Mignard 1984.

    >>> print(f"{asphericity(np.array([1.0, 1.5, 2.0])):.4f}")  # sqrt(3 (B - A) / C)
    0.8660
    """
    ordered = np.sort(np.asarray(moments, dtype=float), axis=-1)
    if not np.all(ordered[..., 0] > 0):
        raise ValueError("the principal moments are above 0")
    require_plausible(ordered[..., None] * np.eye(3))
    return np.sqrt(3 * (ordered[..., 1] - ordered[..., 0]) / ordered[..., 2])


@with_quantities()
def resonance_half_width(p: float, eccentricity: float, asphericity: float) -> float:
    """The largest |theta' - p n|/n inside the resonance of p turns an orbit, omega_0 |H(p, e)|^(1/2).

    It is also the rate of small swings over n. Source: Wisdom, Peale & Mignard 1984, (5).

    >>> print(f"{resonance_half_width(1.5, 0.2056, 0.018):.2e}")  # of Mercury's 3:2, in mean motions
    1.46e-02
    """
    refuse_negative(asphericity=asphericity)
    return asphericity * np.sqrt(abs(hansen_coefficient(eccentricity, p)))


@with_quantities()
def overlap_asphericity(eccentricity: float) -> float:
    """The omega_0 above which the resonances 1:1 and 3:2 touch and chaos is wide, by Chirikov's criterion.

    1/(2 + (14 e)^(1/2)) to first order in e; Hyperion's 0.31 is far below its own omega_0. Source: Wisdom, Peale &
    Mignard 1984, (8).

    >>> print(f"{overlap_asphericity(0.1):.2f}")  # Hyperion has 0.89: chaos
    0.32
    """
    return 0.5 / sum(np.sqrt(abs(hansen_coefficient(eccentricity, p))) for p in (1, 1.5))


@with_quantities()
def tidal_equilibrium_rate(eccentricity: float) -> float:
    """theta'/n at which a tide that grows with its frequency (constant time lag) has no mean torque.

    1 + 6 e^2 + ... Source: Goldreich & Peale 1966; Hut 1981, A&A 99, 126, (45).

    >>> print(f"{tidal_equilibrium_rate(0.2056):.3f}")  # Mercury's, in mean motions, if tides alone decided
    1.256
    """
    if not 0 <= eccentricity < 1:
        raise ValueError("an eccentricity is from 0 to below 1")
    s = eccentricity**2
    return (1 + 7.5 * s + 5.625 * s**2 + 0.3125 * s**3) / ((1 + 3 * s + 0.375 * s**2) * (1 - s) ** 1.5)


@with_quantities()
def capture_probability(
    p: float, eccentricity: float, asphericity: float, equilibrium_rate: float | None = None
) -> float:
    """The chance that a spin slowed through the resonance p is held, under a torque linear in the rate.

    2/(1 + pi V/(2 nu)): V = p - equilibrium_rate, where the torque vanishes (theta'/n; that of `tidal_equilibrium_rate`
    unless given), and nu the resonance's half width; 1 where that is above 1, 0 where the resonance has no strength.
    ValueError where V < 0: the spin is then driven away from the resonance. Source: Goldreich & Peale 1966, (28).
    Checked by tests/unit/rotation/test_spin_orbit.py, and by the motion itself.

    >>> print(f"{capture_probability(1.5, 0.2056, 0.018):.2f}")
    0.07
    """
    rate = tidal_equilibrium_rate(eccentricity) if equilibrium_rate is None else equilibrium_rate
    width, away = resonance_half_width(p, eccentricity, asphericity), p - rate
    if away < 0:
        raise ValueError(f"the torque vanishes at {rate:.6g} n, above the resonance, through which it slows no spin")
    return 0.0 if width < _NO_WIDTH else float(np.minimum(1.0, 2 / (1 + np.pi * away / (2 * width))))


@with_quantities()
def surface_of_section(
    eccentricity: float, asphericity: float, angle: Array, rate: Array, orbits: int, steps: int = _STEPS,
    damping: float = 0.0, equilibrium_rate: float = 1.0,
) -> Section:  # fmt: skip
    """Angles and rates (orbits + 1, starts) at each pericentre, from angle (rad) and rate (theta'/n) of each start.

    steps: an orbit, even in the eccentric anomaly and symplectic; after three orbits the rate is off by about 1e-8 at
    e = 0.5 and 1e-5 at 0.9, and by less with more steps, as their fourth power. damping: of theta' towards
    equilibrium_rate, over n, taken exactly at each pericentre. ValueError for an eccentricity outside 0 <= e < 1, and
    counts below 1 or not whole.
    Source: Wisdom, Peale & Mignard 1984, figure 2; Blanes & Moan 2002.

    >>> section = surface_of_section(0.0, 0.2, np.array([0.1]), np.array([1.0]), 20)
    >>> print(f"{abs(section.rate - 1).max():.3f}")  # a pendulum: at most asphericity times angle
    0.019
    """
    if not 0 <= eccentricity < 1 or any(count < 1 or count % 1 != 0 for count in (orbits, steps)):
        raise ValueError("a section needs 0 <= eccentricity < 1, and whole orbits and steps, at least one of each")
    orbits, steps = int(orbits), int(steps)
    starts = np.broadcast_arrays(np.asarray(angle, dtype=float), np.asarray(rate, dtype=float))
    drifts = np.array([*_DRIFTS, 1 - 2 * sum(_DRIFTS), *_DRIFTS[::-1]]) * 2 * np.pi / steps
    kicks = np.array([*_KICKS, 0.5 - sum(_KICKS), 0.5 - sum(_KICKS), *_KICKS[::-1]]) * 2 * np.pi / steps
    # The time goes with the eccentric anomaly, as r dE: steps are short where the torque is strong.
    ends = 2 * np.pi / steps * np.arange(steps)[:, None] + np.cumsum([0.0, *drifts])
    times = np.diff(ends - eccentricity * np.sin(ends))
    eccentric = ends[:, 1:-1]
    distance = 1 - eccentricity * np.cos(eccentric)
    true = np.arctan2(np.sqrt(1 - eccentricity**2) * np.sin(eccentric), np.cos(eccentric) - eccentricity)
    strength = -0.5 * asphericity**2 * kicks / distance**2
    decay = np.exp(-2 * np.pi * damping)
    with jax.enable_x64(True):
        begin = jnp.ravel(starts[0]), jnp.ravel(starts[1])
        orbit = jnp.asarray(times), jnp.asarray(strength), jnp.asarray(true)
        angles, rates = _mapped(begin, orbit, decay, equilibrium_rate, orbits)
    folded = np.remainder(np.asarray(angles) + np.pi / 2, np.pi) - np.pi / 2
    shape = (orbits + 1, *starts[0].shape)
    return Section(folded.reshape(shape), np.asarray(rates).reshape(shape))


@partial(jax.jit, static_argnames="orbits")
def _mapped(begin, orbit, decay, equilibrium_rate, orbits):
    def step(state, now):
        (angle, rate), (times, strength, true) = state, now
        for k in range(6):
            angle = angle + times[k] * rate
            rate = rate + strength[k] * jnp.sin(2 * (angle - true[k]))
        return (angle + times[6] * rate, rate), None

    def whole_orbit(state, _):
        (angle, rate), _ = jax.lax.scan(step, state, orbit)
        state = jnp.remainder(angle, 2 * jnp.pi), equilibrium_rate + (rate - equilibrium_rate) * decay
        return state, state

    _, (angles, rates) = jax.lax.scan(whole_orbit, begin, length=orbits)
    return jnp.concatenate([begin[0][None], angles]), jnp.concatenate([begin[1][None], rates])
