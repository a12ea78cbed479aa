"""One row of the headline series of a rigid body: moments from attitude and spin, and the ledger that closes them.

The matter moves as x' = omega cross x + (what a change of shape adds), so Q, P and K follow from the attitude, the
angular momentum and the size; dP/dt is differentiated along the equations of motion. What the torques of effects leave
of dP/dt - K is the virial tensor of the internal forces, the row "rigidity". All about the centre of mass, also for a
body on a pivot. Checked by tests/unit/models/rigid/test_record.py.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from astroinertia.effects.effect import Effect
from astroinertia.engines.brief import brief
from astroinertia.inertia.tensor import second_moment_from_inertia
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.body import Rigid
from astroinertia.rotation.attitude import attitude_of_quaternion, cross_matrix

Array = Any

RIGIDITY = "rigidity"
"""The row of the internal forces, which hold the shape or change it as prescribed."""


class Moments(NamedTuple):
    """Second moment Q, mixed moment P and kinetic tensor K about the centre of mass, its place and its velocity."""

    second: Array
    mixed: Array
    kinetic: Array
    place: Array
    velocity: Array


class Ledger(NamedTuple):
    """Moments, virial tensors (E + 1, 3, 3), net forces (E + 1, 3) and potentials (E,).

    spin_energy is that of the rotation alone.
    """

    moments: Moments
    spin_energy: Array
    attitude: Array
    virial: Array
    force: Array
    potential: Array


@brief
def ledgers(body: Rigid, time: Array, turning: Array, orbits: Array | None, count: Array) -> Ledger:
    """What the record says of the first `count` of states (N,), (N, 7); number leading, zeros after them.

    orbits: of companions that the body acts on, in each state, else None.

    One after the other, so that the numbers of each are the same whichever it is.
    """

    def of(number: Array) -> Ledger:
        present = rigid.accompanied(body, None if orbits is None else orbits[number])
        return _ledger(present, time[number], turning[number])

    empty = jax.tree.map(lambda one: jnp.zeros((len(time), *one.shape), one.dtype), jax.eval_shape(of, 0))
    return jax.lax.fori_loop(
        0, count, lambda number, rows: jax.tree.map(lambda all, one: all.at[number].set(one), rows, of(number)), empty
    )


def _ledger(body: Rigid, time: Array, turning: Array) -> Ledger:
    moments, rates = _moments_and_rates(body, time, turning)
    seen = rigid.view(body, time, turning[:4], turning[4:])
    # From torques about the pivot to tensors about the centre of mass: the reaction acts at -place.
    force = body.mass * rates.velocity
    own = [_virial(effect, seen) for effect in body.effects]
    if body.arm is not None:
        on_pivot = [effect.kind == "pivot" for effect in body.effects].index(True)
        weight = body.mass * jnp.asarray(body.effects[on_pivot].gravity)
        own[on_pivot] = -jnp.outer(moments.place, force - weight)
    own.append(rates.mixed - moments.kinetic - sum(own, start=jnp.zeros((3, 3))))
    forces = [force if effect.kind == "pivot" else jnp.zeros(3) for effect in body.effects]
    potentials = [effect.potential(seen) for effect in body.effects]
    return Ledger(
        moments=moments,
        spin_energy=rigid.rotational_energy(body, time, turning[4:]),
        attitude=seen.attitude,
        virial=jnp.stack(own),
        force=jnp.stack([*forces, jnp.zeros(3)]),
        potential=jnp.stack([jnp.nan if one is None else one for one in (*potentials, None)])[:-1],
    )


def _moments_and_rates(body: Rigid, time: Array, turning: Array) -> tuple[Moments, Moments]:
    derivative = rigid.motion(body, time, turning)
    return jax.jvp(partial(_moments, body), (time, turning), (jnp.ones_like(time), derivative.turning))


def _moments(body: Rigid, time: Array, turning: Array) -> Moments:
    q, m = turning[:4], turning[4:]
    axes, spin = attitude_of_quaternion(q), rigid.spin_in_body(body, time, m)
    second = _second_moment(body, time, m)
    turn, swell = cross_matrix(spin), _swell(body, time, turning, second)
    mixed, kinetic = second @ turn.T, turn @ second @ turn.T
    if swell is not None:
        mixed, cross = mixed + swell, turn @ swell
        kinetic = kinetic + cross + cross.T
    if body.change is not None and swell is not None:
        # Of v = g x too; in a deformation the like of it is of second order.
        pace = jnp.trace(swell) / jnp.trace(second)
        kinetic = kinetic + pace**2 * second
    place = velocity = jnp.zeros(3)
    if body.arm is not None:
        place, velocity = jnp.asarray(body.arm), jnp.cross(spin, body.arm)
        second = second - body.mass * jnp.outer(place, place)
        mixed = mixed - body.mass * jnp.outer(place, velocity)
        kinetic = kinetic - body.mass * jnp.outer(velocity, velocity)
    second, mixed, kinetic = (axes.T @ tensor @ axes for tensor in (second, mixed, kinetic))
    return Moments(second, mixed, kinetic, axes.T @ place, axes.T @ velocity)


def _swell(body: Rigid, time: Array, turning: Array, second: Array) -> Array | None:
    """What P has besides rotation, in the principal axes: half the change of Q there, and relative rotation."""
    swell = None
    if body.change is not None or body.deformability is not None:
        rates = rigid.motion(body, time, turning)
        shape = partial(_second_moment, body)
        swell = 0.5 * jax.jvp(shape, (time, turning[4:]), (jnp.ones_like(time), rates.turning[4:]))[1]
    if any(dissipates(effect) for effect in body.effects):
        # The figure turns in matter that has no part in that turn.
        seen = rigid.view(body, time, turning[:4], turning[4:])
        relative = cross_matrix(rigid.in_body(turning[:4], rigid.relative_rotations(body, seen).sum(axis=0)))
        turned = 0.5 * (relative @ second + second @ relative.T)
        swell = turned if swell is None else swell + turned
    return swell


def dissipates(effect: Any) -> bool:
    """Whether an effect turns the axes of the body in its matter."""
    return type(effect).relative_rotation is not Effect.relative_rotation


def _second_moment(body: Rigid, time: Array, m: Array) -> Array:
    return second_moment_from_inertia(rigid.inertia_in_body(body, time, rigid.spin_in_body(body, time, m)))


def _virial(effect: Any, seen: Any) -> Array:
    whole = effect.rigid_virial(seen)
    if whole is not None:
        return whole
    torque = effect.torque(seen)
    # V_jk with eps_ijk V_jk = tau_i: a torque alone.
    return jnp.zeros((3, 3)) if torque is None else -0.5 * cross_matrix(torque)
