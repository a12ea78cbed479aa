"""Rotation of a rigid body in steps that keep its structure: exact turns about two of its axes, torques as kicks.

With m the angular momentum L in the principal axes, moments ascending, the energy of rotation is

    H = L^2 / (2 I_2) + alpha m_1^2 / 2 + gamma m_3^2 / 2,   alpha = 1/I_1 - 1/I_2,   gamma = 1/I_3 - 1/I_2.

Each term alone turns the body: about L, about its axis 1, about its axis 3. The first commutes with the others and is
exact. Half a turn about axis 1, one about axis 3 and half a turn about axis 1 is exact where two moments are equal, and
else errs by the product of alpha and gamma, which is smallest with the middle moment in the first term (Fasso 2003,
Journal of Computational Physics 189, 527; Touma & Wisdom 1994, Astronomical Journal 107, 1189). Symmetric compositions
raise the order (Suzuki 1990, Physics Letters A 146, 319; Kahan & Li 1997, Mathematics of Computation 66, 1089).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines.brief import brief
from astroinertia.engines.pytree import pytree
from astroinertia.ledger.moments import Compensated

Array = Any
Tree = Any

_SUZUKI = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))


def _symmetric(*half: float) -> tuple[float, ...]:
    return (*half, *half[-2::-1])


COMPOSITIONS = {
    2: (1.0,),
    4: _symmetric(_SUZUKI, _SUZUKI, 1.0 - 4.0 * _SUZUKI),
    6: _symmetric(
        0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981, 0.08221359629355080023,
        0.79854399093482996340,
    ),
    8: _symmetric(
        0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
        -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887,
        -0.60550853383003451170,
    ),
}  # fmt: skip
"""Lengths of the stages of a step, by order: Suzuki's five, and the nine and seventeen of Kahan & Li."""

# What is put right after a stage is round-off: no more than this share of L, for L may have come close to zero.
_ROUND_OFF = 1e-9
# Kicks for which what follows the time alone is asked at once, which takes little longer than for one: those of a step
# of order 8, with the one that begins it.
_KNOWN_AT_ONCE = 18
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)  # for the mean of 1/size in a stage, to order 10


class Kick(NamedTuple):
    """What torques change at one moment: L (3,), the rotor's `turning` (7,), its sums (B,) and its orbits (2, N, 3)."""

    angular_momentum: Array
    turning: Array
    sums: Array
    orbits: Array | None = None


@pytree
@dataclass(frozen=True)
class Rotor:
    """A turning body; each sum carries the rounding errors of its additions.

    turning (7,): the unit quaternion, scalar first, that turned the inertial axes into the principal axes, moments
    ascending; then the angular momentum in these axes. angular_momentum (3,) in inertial axes. sums (B,): running sums
    over kicks, such as the work of torques. Where the size is prescribed the first of them is the energy at size 1, and
    the second the work that the change of size has done. orbits (2, N, 3): places and speeds of the companions that
    the body acts on (models.rigid.two_way), else None. entered (N,): while steps are made, the times at which these
    were within the body first, infinite of those that were not.
    """

    turning: Compensated
    angular_momentum: Compensated
    sums: Compensated
    orbits: Compensated | None = None
    entered: Array | None = None

    @property
    def quaternion(self) -> Array:
        """The attitude (4,)."""
        return self.turning.value[:4]

    @property
    def momentum_in_body(self) -> Array:
        """The angular momentum in the principal axes, (3,)."""
        return self.turning.value[4:]


@brief
def rotor(quaternion: Array, momentum_in_body: Array, sums: Array = ()) -> Rotor:
    """A body with an attitude (4,), an angular momentum (3,) in its principal axes, and sums (B,) that begin so."""
    quaternion, momentum = jnp.asarray(quaternion, dtype=float), jnp.asarray(momentum_in_body, dtype=float)
    quaternion = quaternion / jnp.linalg.norm(quaternion)
    turning = jnp.concatenate([quaternion, momentum])
    parts = (turning, in_space(quaternion, momentum), jnp.asarray(sums, dtype=float))
    return Rotor(*(Compensated(value, jnp.zeros_like(value)) for value in parts))


def turning_rates(moments: Array) -> np.ndarray:
    """alpha = 1/I_1 - 1/I_2, 1/I_2 and gamma = 1/I_3 - 1/I_2 of ascending moments (3,), to round-off; (3,).

    A rod has no moment about itself and does not turn about itself: its alpha is 0.
    """
    low, middle, high = (float(moment) for moment in moments)
    alpha = (middle - low) / low / middle if low > 0.0 else 0.0
    return np.array([alpha, 1.0 / middle, (middle - high) / high / middle])


def in_body(quaternion: Array, vector: Array) -> Array:
    """Components (3,) in the body's axes of a vector (3,) in inertial axes."""
    return _turned(quaternion[0], -quaternion[1:], vector)


def in_space(quaternion: Array, vector: Array) -> Array:
    """Components (3,) in inertial axes of a vector (3,) in the body's axes."""
    return _turned(quaternion[0], quaternion[1:], vector)


@partial(jax.jit, static_argnames=("order", "kick", "size", "flow", "within", "known"))
def advance(
    state: Rotor,
    rates: Array,
    time: Array,
    until: Array,
    steps: Array,
    order: int,
    arguments: Tree = None,
    kick: Callable[[Tree, Array, Rotor, Array, Tree], Kick] | None = None,
    size: Callable[[Tree, Array], Array] | None = None,
    flow: Callable[[Tree, Compensated, Array], Compensated] | None = None,
    within: Callable[[Tree, Array], Array] | None = None,
    known: Callable[[Tree, Array], Tree] | None = None,
) -> Rotor:
    """The state at `until` after so many equal steps of order 2, 4, 6 or 8 from `time`.

    rates are those of `turning_rates`. kick(arguments, time, state, interval, known) is what all torques do in an
    interval that may be negative, with the time standing still; size(arguments, time) the factor of all moments;
    flow(arguments, orbits, interval) what becomes of orbits that neither torques nor the attitude move, and
    within(arguments, orbits) which companions (N,) are within the body, asked after every step. known(arguments, times)
    is what torques need that follows the time alone, at times (K,), and a kick is given the row of its time. All are
    functions of a module: each new one is compiled. Runs under jax.enable_x64. Checked by
    tests/unit/models/rigid/test_splitting.py.
    """
    stages = np.array(COMPOSITIONS[order])
    lengths, count = jnp.asarray(stages), len(stages)
    starts = jnp.asarray(np.concatenate([[0.0], np.cumsum(stages)[:-1]]))
    ends = jnp.asarray(np.cumsum(stages))
    # The kick that ends a stage is also the one that begins the next.
    kicks = jnp.asarray(0.5 * (stages + np.roll(stages, -1)))
    step = (until - time) / steps
    free = kick is None and size is None

    def kick_times(first: Array) -> Array:
        numbers = first + jnp.arange(_KNOWN_AT_ONCE)
        times = time + step * (numbers // count + ends[numbers % count])
        later = jnp.clip(times, jnp.minimum(time, until), jnp.maximum(time, until))  # also where time goes back
        return jnp.where(numbers < 0, time, later)

    def stage(index: Array, carried: tuple[Rotor, Tree]) -> tuple[Rotor, Tree]:
        state, rows = carried
        # Where there are kicks a stage of no length comes first, for the kick that begins the first step.
        opens = index < 0
        number = jnp.where(opens, 0, index % count)
        before = time + step * (jnp.maximum(index, 0) // count + starts[number])
        interval = jnp.where(opens, 0.0, step * lengths[number])
        if size is None:
            state = _drift(state, rates, interval, about_momentum=not free)
        else:
            duration, change = _shrunk(size, arguments, before, interval)
            work = jnp.zeros_like(state.sums.value).at[1].set(state.sums.value[0] * change)
            state = _drift(replace(state, sums=plus(state.sums, work)), rates, duration, about_momentum=True)
        if flow is not None:
            assert state.orbits is not None
            state = replace(state, orbits=flow(arguments, state.orbits, interval))
        if within is not None:
            assert state.orbits is not None and state.entered is not None
            there = within(arguments, state.orbits.value) & ((index + 1) % count == 0)
            state = replace(state, entered=jnp.minimum(state.entered, jnp.where(there, before + interval, jnp.inf)))
        if kick is None:
            return state, rows
        row = None
        if known is not None:
            place, at = (index + 1) % _KNOWN_AT_ONCE, partial(known, arguments)
            rows = jax.lax.cond(place == 0, lambda: at(kick_times(index)), lambda: rows)
            row = jax.tree.map(lambda each: each[place], rows)
        share = jnp.where(opens | (index == steps * count - 1), 0.5 * lengths[number], kicks[number])
        return _kicked(state, kick(arguments, before + interval, state, step * share, row)), rows

    rows = None
    if known is not None:
        sized = jax.eval_shape(known, arguments, kick_times(-1))
        rows = jax.tree.map(lambda each: jnp.zeros(each.shape, each.dtype), sized)
    state, _ = jax.lax.fori_loop(0 if kick is None else -1, steps * count, stage, (state, rows))
    if not free:
        return state
    # Without torques all turns about L are one, at the end.
    change = _product(_about_momentum(state, rates, until - time), state.quaternion)
    return replace(state, turning=plus(state.turning, jnp.concatenate([change, jnp.zeros(3)])))


def _drift(state: Rotor, rates: Array, duration: Array, about_momentum: bool) -> Rotor:
    """Half a turn about axis 1, one about axis 3, half a turn about axis 1; then the one about L."""
    m = [state.turning.value[k] for k in (4, 5, 6)]
    gain, turn = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]
    for axis, share in ((0, 0.5), (2, 1.0), (0, 0.5)):
        half = _half_turn(share * duration * rates[axis] * (m[axis] + gain[axis]))
        gain, turn = _turned_back(m, gain, axis, half), _then(turn, axis, half)
    q = state.quaternion
    change = _product(q, turn)
    if about_momentum:
        change = change + _product(_about_momentum(state, rates, duration), q + change)
    return put_right(replace(state, turning=plus(state.turning, jnp.concatenate([change, jnp.stack(gain)]))))


def _kicked(state: Rotor, kick: Kick) -> Rotor:
    return Rotor(
        plus(state.turning, kick.turning),
        plus(state.angular_momentum, kick.angular_momentum),
        plus(state.sums, kick.sums),
        None if state.orbits is None else plus(state.orbits, kick.orbits),
        state.entered,
    )


def _shrunk(size: Callable, arguments: Tree, start: Array, interval: Array) -> tuple[Array, Array]:
    """The integral of 1/size over an interval, and the change of 1/size in it."""
    inverse = 1.0 / size(arguments, start + interval * (0.5 * (1.0 + np.array([-1.0, *_NODES, 1.0]))))
    return 0.5 * interval * (_WEIGHTS @ inverse[1:-1]), inverse[-1] - inverse[0]


def _half_turn(angle: Array) -> tuple[Array, Array]:
    """sin and cos - 1 of half an angle, the latter without cancellation."""
    sine, cosine = jnp.sin(0.25 * angle), jnp.cos(0.25 * angle)
    return 2.0 * sine * cosine, -2.0 * sine * sine


def _turned_back(m: list, gain: list, axis: int, half: tuple[Array, Array]) -> list:
    """What m, having gained so much, has gained when the body has also turned about one of its axes."""
    sine, less = 2.0 * half[0] * (1.0 + half[1]), -2.0 * half[0] * half[0]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    a, b = m[i] + gain[i], m[j] + gain[j]
    gain = list(gain)
    gain[i], gain[j] = gain[i] + (less * a + sine * b), gain[j] + (less * b - sine * a)
    return gain


def _then(turn: list, axis: int, half: tuple[Array, Array]) -> list:
    """A turn, as its quaternion less 1, followed by one about the body's own axis."""
    sine, less = half
    w, v = turn[0], turn[1:]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    new = [0.0, 0.0, 0.0]
    new[axis] = v[axis] + (less * v[axis] + sine * (1.0 + w))
    new[i] = v[i] + (less * v[i] + sine * v[j])
    new[j] = v[j] + (less * v[j] - sine * v[i])
    return [w + (less * (1.0 + w) - sine * v[axis]), *new]


def _about_momentum(state: Rotor, rates: Array, duration: Array) -> Array:
    """The turn about L at the rate L/I_2, as its quaternion less 1."""
    momentum = state.angular_momentum.value
    size = jnp.sqrt(jnp.sum(momentum**2))
    sine, less = _half_turn(size * rates[1] * duration)
    return jnp.concatenate([less[None], sine * momentum / jnp.where(size > 0.0, size, 1.0)])


def put_right(state: Rotor, most: float = _ROUND_OFF) -> Rotor:
    """Takes errors of the attitude out of |q| = 1 and of the direction of m, which in space is that of L.

    To first order, the latter where they are less than `most` of L. The length of m is left alone: holding it to that
    of L in every stage makes its rounding one-sided, and the energy then drifts by 3e-12 in a million rotations.
    """
    value, momentum = state.turning.value, state.angular_momentum.value
    q, m = value[:4], value[4:]
    square = jnp.sum(momentum**2)
    tilt = 0.5 / jnp.where(square > 0.0, square, 1.0) * jnp.cross(in_space(q, m), momentum)
    turned = jnp.concatenate([-jnp.sum(tilt * q[1:])[None], q[0] * tilt + jnp.cross(tilt, q[1:])])
    right = jnp.where(jnp.sum(tilt**2) < most**2, turned, 0.0) - 0.5 * (jnp.sum(q**2) - 1.0) * q
    carry = state.turning.carry + jnp.concatenate([right, jnp.zeros(3)])
    return replace(state, turning=Compensated(value, carry))


def plus(total: Compensated, increment: Array) -> Compensated:
    """A sum whose rounding error goes into the next addition, so that its value is good to one rounding."""
    return Compensated(total.value, jnp.zeros_like(total.carry)).add(increment + total.carry)


def _product(left: Any, right: Any) -> Array:
    """The product (4,) of two quaternions of four components each."""
    a, b, c, d = (left[k] for k in range(4))
    w, x, y, z = (right[k] for k in range(4))
    return jnp.stack([
        a * w - (b * x + c * y + d * z),
        a * x + b * w + (c * z - d * y),
        a * y + c * w + (d * x - b * z),
        a * z + d * w + (b * y - c * x),
    ])  # fmt: skip


def _turned(scalar: Array, axial: Array, vector: Array) -> Array:
    twice = 2.0 * jnp.cross(axial, vector)
    return vector + scalar * twice + jnp.cross(axial, twice)
