"""A rigid body and its companions, each acting on the other: torque on the spin, and its reaction on the orbits.

The energy has two parts that can be solved alone: point masses on orbits (REBOUND) with the free rotation, and the
body's quadrupole in the field of the companions, which leaves places and attitude and changes speeds and spin. Half a
kick, a drift and half a kick, composed as in `models.rigid.splitting`, keep the total angular momentum, for every
kick does, and the energy without drift (Touma & Wisdom 1994, Astronomical Journal 107, 1189, section 4). Code units.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.effects.kinds.gravity_gradient import quadrupole_attraction
from astroinertia.engines.pytree import pytree
from astroinertia.errors import NumericalError
from astroinertia.models import checkpoint
from astroinertia.models.protocol import Record
from astroinertia.models.rigid import body as rigid, splitting
from astroinertia.models.rigid.body import Rigid
from astroinertia.models.rigid.evolution import RigidBody, Settings, too_fast
from astroinertia.models.rigid.passage import MOST_STEPS, Met, planned, whole
from astroinertia.models.rigid.splitting import COMPOSITIONS, Rotor
from astroinertia.orbits import states

Array = Any

_ORDER_OF_DRIFT = 8  # of the free rotation between kicks, whose error then does not count


_STEPS_AT_ONCE = 1024  # some seconds of work, after which the run looks at the clock and at signals


@pytree
@dataclass(frozen=True, eq=False)
class Here:
    """Companions at one moment, in the form of a `rotation.ephemeris.Ephemeris`: mass (N,), place and speed (N, 3)."""

    mass: Array
    place: Array
    speed: Array

    def position(self, time: Array) -> Array:
        """Positions relative to the body, whatever the time."""
        return self.place

    def velocity(self, time: Array) -> Array:
        """Velocities relative to the body, whatever the time."""
        return self.speed


class CoupledRigidBody(RigidBody):
    """A rigid body under way whose quadrupole acts on the orbits of its companions (models.protocol.Evolution).

    `bodies` is a `rebound.Simulation` with G = 1 whose particle 0 is the body. Its integrator drifts; steps are those
    of `settings.steps_per_rotation` in a turn of the body, of the companions at their pericentres, or in the swing of
    one about the other, whichever is fastest. Other effects than gravity_gradient act on the body alone. Measured over
    1000 orbits in tests/physics/test_rebound.py. Runs under jax.enable_x64. Checked by
    tests/unit/models/rigid/test_two_way.py.
    """

    def __init__(self, body: Rigid, quaternion: Array, momentum: Array, settings: Settings, bodies: Any) -> None:
        self.bodies = bodies
        self._carry = np.zeros((bodies.N, 3))  # of the kicks' additions to velocities
        super().__init__(replace(body, companions=_here(bodies)), quaternion, momentum, settings)

    def total_angular_momentum(self) -> np.ndarray:
        """Of orbits and spin, (3,)."""
        return np.array(self.bodies.angular_momentum()) + np.asarray(self.state.angular_momentum.total)

    def total_energy(self) -> float:
        """Of orbits, spin and the quadrupole in the companions' field."""
        kinetic, potential = self._energies(self._ledgers(self._present()))
        return self.bodies.energy() + kinetic[0] + potential[0]

    def _records(self, met: Met) -> list[Record]:
        """As of a body alone, of the present state, with what orbits and spin keep together."""
        return [
            record
            | {
                "system_angular_momentum": self.total_angular_momentum(),
                "system_energy": self.bodies.energy() + record["kinetic_energy"] + record["potential_energy"],
            }
            for record in super()._records(met)
        ]

    def arrays(self) -> dict[str, np.ndarray]:
        """The state, with that of REBOUND to the last bit, for a checkpoint."""
        return {**super().arrays(), "orbits": states.packed(self.bodies), "carry": self._carry}

    def resume(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from a checkpoint, bit for bit as if the run had never stopped; ValueError for another body's."""
        own = {name: array for name, array in arrays.items() if name not in ("orbits", "carry")}
        super().resume(own)
        carry = {"carry": arrays.get("carry", np.zeros(()))}
        checkpoint.check(carry, checkpoint.described({"carry": self._carry}), {})
        self.bodies = states.unpacked(arrays.get("orbits", np.zeros(())), self.bodies)
        self._carry = carry["carry"].copy()
        self.body = replace(self.body, companions=_here(self.bodies))

    def _go(self, body: Rigid, times: Sequence[float] | np.ndarray, most: float = math.inf) -> Met:
        """To the first of the times, or as far towards it as so many steps go."""
        until, stages = times[0], COMPOSITIONS[self.settings.order]
        at_pericentres = replace(body, companions=_at_pericentres(self.bodies))
        pace, wanted = planned(at_pericentres, self.course(), until, self.settings.steps_per_rotation)
        if not wanted < MOST_STEPS:
            raise too_fast(float(wanted), self._time)
        self._pace, steps = float(pace), int(whole(wanted))
        step = (until - self._time) / steps
        if steps > _STEPS_AT_ONCE:
            steps, until = _STEPS_AT_ONCE, self._time + _STEPS_AT_ONCE * step
        self._kick(body, 0.0, 0.5 * step * stages[0])
        for number in range(steps):
            before = self._time + step * number
            for k, (share, following) in enumerate(zip(stages, (*stages[1:], stages[0]), strict=True)):
                last = number == steps - 1 and k == len(stages) - 1
                before += step * share
                states.drift(self.bodies, step * share, until if last else before)
                # The kick that ends a stage is also the one that begins the next.
                self._kick(body, step * share, 0.5 * step * (share if last else share + following))
        self.body = replace(self.body, companions=_here(self.bodies))
        self._time, self._timestep, self._steps = float(until), step, self._steps + steps
        if not np.isfinite(np.asarray(self.state.turning.value)).all():
            raise NumericalError("the attitude is no longer finite", time=self._time)
        met = self._present()
        return met if until == times[0] else Met(*(rows[:0] for rows in met))

    def _kick(self, body: Rigid, drift: float, interval: float) -> None:
        present = replace(body, companions=_here(self.bodies))
        self.state, pushes = _turned_and_kicked(present, self.bodies.t, self.state, drift, interval)
        states.push(self.bodies, np.asarray(pushes), self._carry)


@jax.jit
def _turned_and_kicked(body: Rigid, time: Array, state: Rotor, drift: Array, interval: Array) -> tuple[Rotor, Array]:
    """The rotor after it turned freely and was kicked, and what the kick adds to the velocities of all bodies."""
    state = splitting.advance(state, body.rates, 0.0, drift, 1, _ORDER_OF_DRIFT)
    seen = rigid.view(body, time, state.quaternion, state.momentum_in_body, state.angular_momentum.value)
    attraction = quadrupole_attraction(seen)
    reaction = -(body.companions.mass @ attraction) / body.mass
    kick = rigid.kick(body, time, state, interval)
    state = Rotor(
        state.turning.add(kick.turning),
        state.angular_momentum.add(kick.angular_momentum),
        state.sums.add(kick.sums),
    )
    return state, interval * jnp.concatenate([reaction[None], attraction])


def _here(bodies: Any) -> Here:
    place, speed = states.present(bodies)
    return Here(states.masses(bodies)[1:], place, speed)


def _at_pericentres(bodies: Any) -> Here:
    """Companions as far from the body, and turning about it as fast, as at the pericentres of their present orbits."""
    now, mass = _here(bodies), states.masses(bodies)
    distance = np.linalg.norm(now.place, axis=1, keepdims=True)
    turning = np.cross(now.place, now.speed)
    square, attraction = (turning**2).sum(axis=1, keepdims=True), (mass[0] + mass[1:, None]) * bodies.G
    eccentricity = np.linalg.norm(np.cross(now.speed, turning) / attraction - now.place / distance, axis=1)
    closer = np.minimum(square / (attraction * (1.0 + eccentricity[:, None])) / distance, 1.0)
    return Here(now.mass, now.place * closer, now.speed / closer)
