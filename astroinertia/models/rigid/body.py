"""A rigid body, or one of prescribed size: its equations of motion, by L and attitude, with the torques of effects.

The state is the attitude q, the angular momentum L in inertial axes and m, the same in the principal axes, which keeps
its digits also where one moment is far smaller than the others. With omega = I^-1 L and the relative rotation s, by
which the body's axes turn beyond it (internal dissipation),

    dL/dt = sum of torques,   dm/dt = m x (omega + s) + torques in the body's axes,   dq/dt = q (0, omega + s) / 2.

That L and not omega is evolved puts the term dI/dt omega of a body that changes its size where it belongs. About the
centre of mass, or about a fixed point where the scene has a pivot. Code units. Checked by
tests/unit/models/rigid/test_evolution.py.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.models.rigid import two_way
from astroinertia.models.rigid.splitting import Kick, Rotor, in_body, in_space, turning_rates
from astroinertia.rotation.attitude import attitude_of_quaternion, quaternion_product

Array = Any

_NEWTON_STEPS = 6  # on the stiffening of a body that its rotation deforms: from 0 to round-off
# Of order 6, with seven stages (Butcher 1964, Journal of the Australian Mathematical Society 4, 179).
_STAGES = np.array([
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (1 / 3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (0.0, 2 / 3, 0.0, 0.0, 0.0, 0.0, 0.0),
    (1 / 12, 1 / 3, -1 / 12, 0.0, 0.0, 0.0, 0.0),
    (-1 / 16, 9 / 8, -3 / 16, -3 / 8, 0.0, 0.0, 0.0),
    (0.0, 9 / 8, -3 / 8, -3 / 4, 1 / 2, 0.0, 0.0),
    (9 / 44, -9 / 11, 63 / 44, 18 / 11, 0.0, -16 / 11, 0.0),
])  # fmt: skip
_WEIGHTS = np.array([11 / 120, 0.0, 27 / 40, 27 / 40, -4 / 15, -4 / 15, 11 / 120])


@pytree
@dataclass(frozen=True, eq=False)
class Rigid:
    """What a rigid body is, and what acts on it: a pytree.

    moments (3,): principal moments, ascending, about the centre of mass or the pivot, at time 0, of the body at rest
    where rotation deforms it. inverse (3,): the inverses of moments near these, with which the splitting turns the
    body: the same but for a deformation, and 0 for a rod about itself; rates (3,): what it makes of them. axes (3, 3):
    the scene's axes of the body, as rows, in the principal axes. companions: an Ephemeris, or two_way.Companions where
    the body acts on them (of the start: those of now are part of a Rotor), or None. change: an
    inertia.prescribed.Change or None. arm (3,): the centre of mass as seen from a pivot, in the principal axes, or
    None. deformability D: the inertia tensor grows by D (omega (x) omega - omega^2/3), or None.
    """

    mass: Array
    moments: Array
    inverse: Array
    rates: Array
    axes: Array
    effects: tuple
    companions: Any = None
    change: Any = None
    arm: Array | None = None
    deformability: Array | None = None


def body(mass: float, moments: Array, spin: float = 0.0, deformability: float | None = None, **rest: Any) -> Rigid:
    """A body from its mass and ascending principal moments (3,), those at rest where its spin of so much deforms it.

    The rest are fields of Rigid: axes, effects, companions, change, arm.
    """
    moments = np.asarray(moments, dtype=float)
    near = moments if deformability is None else moments + 2.0 / 3.0 * deformability * spin**2
    inverse = np.where(near > 0.0, 1.0 / np.where(near > 0.0, near, 1.0), 0.0)
    options = {"axes": np.eye(3), "effects": (), **rest}
    return Rigid(np.float64(mass), moments, inverse, turning_rates(near), deformability=deformability, **options)


def accompanied(body: Rigid, orbits: Array | None) -> Rigid:
    """The body with the companions that it acts on where they are now, (2, N, 3)."""
    return body if orbits is None else replace(body, companions=body.companions.at(orbits))


def known_orbits(body: Rigid, times: Array) -> Array:
    """Places and speeds (K, 2, N, 3) at times (K,) of companions on known orbits."""
    return jnp.stack([body.companions.position(times), body.companions.velocity(times)], axis=1)


class View(NamedTuple):
    """What an effect sees of the body: everything in inertial axes, about the centre of mass or the pivot.

    attitude (3, 3) has the body's axes as the scene gives them as rows. moments (3,) are those about them,
    principal_moments (3,), ascending, those of the body at rest, and inertia (3, 3) is the whole tensor. companions is
    the body's Ephemeris, to be asked for positions at `time`.
    """

    time: Array
    mass: Array
    attitude: Array
    moments: Array
    principal_moments: Array
    inertia: Array
    angular_momentum: Array
    angular_velocity: Array
    companions: Any


class Motion(NamedTuple):
    """Rates of change: turning (7,) of the quaternion and m, angular_momentum (3,), power of each effect (E,)."""

    turning: Array
    angular_momentum: Array
    power: Array


def size(body: Rigid, time: Array) -> Array:
    """The factor of all moments at times (...,)."""
    return jnp.ones_like(time) if body.change is None else body.change.factor(time)


def spin_in_body(body: Rigid, time: Array, m: Array) -> Array:
    """omega (3,) in the principal axes.

    Of a body that its rotation deforms, L = (I + 2/3 D omega^2) omega: one number, found by Newton's method.
    """
    if body.deformability is None:
        return m * body.inverse / size(body, time)
    return m / (body.moments + _stiffening(body.moments, body.deformability, m))


@jax.custom_jvp
def _stiffening(moments: Array, deformability: Array, m: Array) -> Array:
    """2/3 D omega^2, by which rotation raises all moments."""

    def nearer(_: int, stiffening: Array) -> Array:
        excess, slope = _excess(moments, deformability, m, stiffening)
        return stiffening - excess / slope

    return jax.lax.fori_loop(0, _NEWTON_STEPS, nearer, jnp.zeros_like(m[0]), unroll=True)


@_stiffening.defjvp
def _stiffening_rate(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    # What solves f(x, s) = 0 follows x with ds = -(df/dx) dx / (df/ds): Newton's steps need not be differentiated.
    stiffening = _stiffening(*primals)
    (_, slope), (growth, _) = jax.jvp(lambda *given: _excess(*given, stiffening), primals, tangents)  # type: ignore
    return stiffening, -growth / slope


def _excess(moments: Array, deformability: Array, m: Array, stiffening: Array) -> tuple[Array, Array]:
    """How much a stiffening exceeds that by the rotation which it allows, and the rate at which that grows with it."""
    inertia, share = moments + stiffening, 2.0 / 3.0 * deformability
    return stiffening - share * jnp.sum((m / inertia) ** 2), 1.0 + 2.0 * share * jnp.sum(m**2 / inertia**3)


def inertia_in_body(body: Rigid, time: Array, spin: Array) -> Array:
    """The inertia tensor (3, 3) in the principal axes of the body at rest, at a spin (3,)."""
    inertia = jnp.diag(body.moments) * size(body, time)
    if body.deformability is None:
        return inertia
    return inertia + body.deformability * (jnp.outer(spin, spin) - jnp.sum(spin**2) / 3.0 * jnp.eye(3))


def rotational_energy(body: Rigid, time: Array, m: Array) -> Array:
    """omega . L / 2."""
    return 0.5 * jnp.sum(spin_in_body(body, time, m) * m)


def view(body: Rigid, time: Array, quaternion: Array, m: Array) -> View:
    """The body as its effects see it: with L by m, so that it is about an axis where the angular velocity is."""
    principal = attitude_of_quaternion(quaternion)
    spin = spin_in_body(body, time, m)
    inertia, principal_moments = inertia_in_body(body, time, spin), body.moments * size(body, time)
    # The same product, which takes less where the tensor is diagonal.
    turned = principal.T * principal_moments if body.deformability is None else principal.T @ inertia
    return View(
        time=time,
        mass=body.mass,
        attitude=body.axes @ principal,
        moments=jnp.einsum("ij,jk,ik->i", body.axes, inertia, body.axes),
        principal_moments=principal_moments,
        inertia=turned @ principal,
        angular_momentum=in_space(quaternion, m),
        angular_velocity=in_space(quaternion, spin),
        companions=body.companions,
    )


def torques(body: Rigid, seen: View) -> Array:
    """The torque of each effect, (E, 3)."""
    return _of_each(body, lambda effect: effect.torque(seen))


def relative_rotations(body: Rigid, seen: View) -> Array:
    """The relative rotation s that each effect gives to the body's axes, (E, 3)."""
    return _of_each(body, lambda effect: effect.relative_rotation(seen))


def motion(body: Rigid, time: Array, turning: Array) -> Motion:
    """All rates of change, of a state as a `Rotor` has it, with a unit quaternion."""
    m = turning[4:]
    turn = spin_in_body(body, time, m)
    return _motion(body, time, turning, turn, _euler(body, time, m, turn))


@jax.jit
def pace(body: Rigid, time: Array, turning: Array) -> Array:
    """The largest angular frequency that steps must resolve from here on, at the present size.

    Of the free body: its fastest spin on this polhode, along which the squares of m change in proportion.
    """
    m, square = turning[4:], turning[4:] ** 2
    low, middle, high = jnp.where(body.inverse > 0.0, body.inverse, body.inverse[1])
    along = jnp.stack([middle - high, high - low, low - middle])
    most = square[1] / jnp.where(along[1] < 0.0, -along[1], jnp.inf)
    least = jnp.max(jnp.where(along > 0.0, -square / jnp.where(along > 0.0, along, 1.0), -jnp.inf))
    ends = jnp.stack([most, jnp.where(jnp.isfinite(least), least, 0.0)])
    spins = (body.inverse / size(body, time)) ** 2 @ jnp.maximum(square[:, None] + along[:, None] * ends, 0.0)
    frequencies = [jnp.sqrt(jnp.max(spins))]
    seen = view(body, time, turning[:4], m)
    frequencies += [frequency for effect in body.effects if (frequency := effect.frequency(seen)) is not None]
    torque = torques(body, seen).sum(axis=0)
    frequencies.append(jnp.sqrt(jnp.sqrt(jnp.sum(torque**2)) * body.inverse[1] / size(body, time)))
    if body.companions is not None:
        place, speed = body.companions.position(time), body.companions.velocity(time)
        turns = jnp.cross(place, speed) / jnp.sum(place**2, axis=-1, keepdims=True)
        frequencies.append(jnp.sqrt(jnp.max(jnp.sum(turns**2, axis=-1))))
    return jnp.max(jnp.stack(frequencies))


def rate(time: Array, state: dict[str, Array], arguments: tuple) -> dict[str, Array]:
    """The same for engines.adaptive: of turning, momentum, work, and orbits where the body acts on its companions.

    The arguments are the body and the units of L, m (3,), energy and orbits. Each component of m has its own unit, so
    that a needle's spin about itself is known as well as the others.
    """
    body, momentum_unit, body_unit, energy_unit, orbit_unit = arguments
    if orbit_unit is not None:
        body = accompanied(body, orbit_unit * state["orbits"])
    q = state["turning"][:4]
    turning = jnp.concatenate([q / jnp.sqrt(jnp.sum(q**2)), body_unit * state["turning"][4:]])
    change = motion(body, time, turning)
    work = change.power
    if body.change is not None:
        growth = jax.jvp(body.change.factor, (time,), (jnp.ones_like(time),))[1] / size(body, time)
        energy = rotational_energy(body, time, turning[4:])
        gain = size(body, time) * jnp.sum(work)
        work = jnp.concatenate([jnp.stack([gain, -energy * growth]), work])
    rates = jnp.concatenate([change.turning[:4], change.turning[4:] / body_unit])
    found = {"turning": rates, "momentum": change.angular_momentum / momentum_unit, "accumulated": work / energy_unit}
    if orbit_unit is not None:
        seen = view(body, time, turning[:4], turning[4:])
        place, speed = body.companions.orbits
        change = two_way.pulls(body.mass, body.companions.mass, place) + two_way.pushes(seen)
        found["orbits"] = jnp.stack([speed, change]) / orbit_unit
    return found


def entered(time: Array, state: dict[str, Array], arguments: tuple) -> Array:
    """Whether a companion is within the body that acts on it; time, state and arguments as for `rate`."""
    body, orbit_unit = arguments[0], arguments[-1]
    return jnp.any(two_way.within(body, orbit_unit * state["orbits"]))


def kick(body: Rigid, time: Array, state: Rotor, interval: Array, orbits: Array | None) -> Kick:
    """The same for models.rigid.splitting: what effects do in an interval while the rest stands still.

    orbits are what known_orbits has for this time, where companions follow them. Exact where torques depend on time and
    attitude alone. Where they follow the spin, or the body's axes turn in its matter, the equations of the effects
    alone are solved to order 6.
    """
    turning, pushed = state.turning.value, None
    if orbits is not None:
        body = replace(body, companions=two_way.Companions(body.companions.mass, orbits))
    if state.orbits is not None:
        body = accompanied(body, state.orbits.value)
    q, m = turning[:4], turning[4:]
    seen = view(body, time, q, m)
    if state.orbits is not None:
        push = interval * two_way.pushes(seen)
        pushed = jnp.stack([jnp.zeros_like(push), push])
    if body.deformability is None and not any(effect.follows_spin for effect in body.effects):
        impulses = interval * torques(body, seen)
        gain = in_body(q, impulses.sum(axis=0))
        work = impulses @ in_space(q, spin_in_body(body, time, m + 0.5 * gain))
        return Kick(impulses.sum(axis=0), jnp.concatenate([jnp.zeros(4), gain]), _entered(body, time, work), pushed)

    def stage(number: Array, slopes: Array) -> Array:
        done = interval * (jnp.asarray(_STAGES)[number] @ slopes)
        derivative = _besides_free(body, time, turning + done[:7])
        return slopes.at[number].set(jnp.concatenate(derivative))

    slopes = jax.lax.fori_loop(0, len(_STAGES), stage, jnp.zeros((len(_STAGES), 10 + len(body.effects))))
    done = interval * (_WEIGHTS @ slopes)
    return Kick(done[7:10], done[:7], _entered(body, time, done[10:]), pushed)


def _besides_free(body: Rigid, time: Array, turning: Array) -> Motion:
    """The rates of change without those of the free body of fixed shape, which the splitting turns by itself."""
    m = turning[4:]
    beyond = jnp.zeros(3) if body.deformability is None else spin_in_body(body, time, m) - body.inverse * m
    return _motion(body, time, turning, beyond, jnp.cross(m, beyond))


def _euler(body: Rigid, time: Array, m: Array, turn: Array) -> Array:
    """m x omega: by the differences of inverse moments, in which a needle's small component keeps its digits."""
    if body.deformability is not None:
        return jnp.cross(m, turn)
    alpha, gamma = body.rates[0], body.rates[2]
    return jnp.stack([gamma * m[1] * m[2], (alpha - gamma) * m[2] * m[0], -alpha * m[0] * m[1]]) / size(body, time)


def _entered(body: Rigid, time: Array, work: Array) -> Array:
    return work if body.change is None else jnp.concatenate([jnp.stack([size(body, time) * work.sum(), 0.0]), work])


def _motion(body: Rigid, time: Array, turning: Array, turn: Array, rate: Array) -> Motion:
    """Rates of a body whose axes turn by `turn` (3,), in themselves, which gives m the rate, and by its effects."""
    q, m = turning[:4], turning[4:]
    seen = view(body, time, q, m)
    torque, relative = torques(body, seen), relative_rotations(body, seen)
    beyond = in_body(q, relative.sum(axis=0))
    # A relative rotation does omega . (m x s) to the energy.
    power = torque @ seen.angular_velocity + relative @ jnp.cross(seen.angular_velocity, seen.angular_momentum)
    rates = rate + jnp.cross(m, beyond) + in_body(q, torque.sum(axis=0))
    half = 0.5 * quaternion_product(q, jnp.concatenate([jnp.zeros(1), turn + beyond]))
    return Motion(jnp.concatenate([half, rates]), torque.sum(axis=0), power)


def _of_each(body: Rigid, part: Any) -> Array:
    vectors = [part(effect) for effect in body.effects]
    return jnp.stack([jnp.zeros(3) if one is None else one for one in vectors]) if vectors else jnp.zeros((0, 3))
