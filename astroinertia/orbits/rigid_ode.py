"""A spinning rigid body among point masses inside REBOUND's interface to differential equations: an independent check.

Nothing is shared with the model `rigid`: Newton's equations relative to the body, Euler's equations in its axes and the
quaternion are one system, which REBOUND's Gragg-Bulirsch-Stoer method integrates. Its own sums lose some digits over
thousands of steps, so that the state is kept here, compensated, and REBOUND is given what a step adds, in units of the
size that each part of the state has at first: so a tolerance means the same for a near and a far body.
"""

from functools import lru_cache
from typing import Any

import numba
import numpy as np
import rebound
from numba import carray, types  # pyright: ignore[reportPrivateImportUsage]
from rebound.ode import ODEDER

from astroinertia.errors import NumericalError
from astroinertia.ledger.moments import Compensated
from astroinertia.process.quantities import with_quantities

Array = Any

TOLERANCE = 1e-14
_FIRST_STEP = 0.01  # of the shortest time of the motion
_SIGNATURE = types.void(types.voidptr, types.CPointer(types.double), types.CPointer(types.double), types.double)


class RigidBodyOde:
    """A rigid body, number 0 of masses (N,) at position and velocity (N, 3), and the others as points.

    moments (3,) are its principal moments, quaternion (4,), scalar first, what turned the inertial axes into its
    principal axes, angular_velocity (3,) that in the latter. With back_reaction its quadrupole acts on the others; each
    of these acts on all. Any consistent units with gravitational_constant. Sources: Goldstein, Poole & Safko 2002, eq.
    4.125 and 5.39; Murray & Dermott 1999, section 5.2. Checked by tests/physics/test_rebound.py.
    """

    def __init__(
        self, mass: Array, position: Array, velocity: Array, moments: Array, quaternion: Array,
        angular_velocity: Array, gravitational_constant: float = 1.0, back_reaction: bool = True,
        tolerance: float = TOLERANCE,
    ) -> None:  # fmt: skip
        self.count = len(mass)
        place, speed = (np.asarray(each, dtype=float) - np.asarray(each)[0] for each in (position, velocity))
        vectors = (place, speed, np.asarray(quaternion), np.asarray(angular_velocity))
        sizes = [np.linalg.norm(each, axis=-1, keepdims=True) * np.ones_like(each, dtype=float) for each in vectors]
        sizes = np.concatenate([np.ravel(size) for size in sizes])
        self._unit = np.exp2(np.floor(np.log2(np.where(sizes > 0.0, sizes, 1.0))))  # powers of 2 round nothing
        self._state = Compensated(
            value := np.concatenate([*map(np.ravel, vectors)]).astype(float), np.zeros_like(value)
        )
        constants = np.concatenate([mass, moments, [gravitational_constant, float(back_reaction)], self._unit])
        self._simulation: Any = rebound.Simulation()
        self._simulation.integrator = "bs"
        method: Any = self._simulation.integrator
        method.eps_abs = method.eps_rel = tolerance
        self._ode = self._simulation.create_ode(length=2 * len(value) + len(constants), needs_nbody=False)
        self._ode._derivatives = ODEDER(_rates(self.count).address)
        self._parameters()[:] = np.concatenate([np.zeros_like(value), value, constants])
        self._simulation.dt = _FIRST_STEP * self._shortest_time()

    @property
    def time(self) -> float:
        """Now."""
        return self._simulation.t

    @property
    def steps(self) -> int:
        """Steps of REBOUND's so far."""
        return self._simulation.steps_done

    @property
    def position(self) -> np.ndarray:
        """Of all bodies relative to the rigid one, (N, 3)."""
        return self._state.total[: 3 * self.count].reshape(-1, 3)

    @property
    def velocity(self) -> np.ndarray:
        """Of all bodies relative to the rigid one, (N, 3)."""
        return self._state.total[3 * self.count : -7].reshape(-1, 3)

    @property
    def quaternion(self) -> np.ndarray:
        """Of the body, (4,), of length 1."""
        parameters = self._state.total[-7:-3]
        return parameters / np.linalg.norm(parameters)

    @property
    def angular_velocity(self) -> np.ndarray:
        """In the body's principal axes, (3,)."""
        return self._state.total[-3:]

    @with_quantities(until="s")
    def integrate(self, until: float) -> None:
        """Go on to a later time; NumericalError where the state is no longer finite."""
        simulation = self._simulation
        while simulation.t < until:
            if simulation.t + simulation.dt < until:
                simulation.steps(1)
            else:
                simulation.integrate(until)
            size, parameters = len(self._state.value), self._parameters()
            self._state = self._state.add(self._unit * parameters[:size])
            self._state = Compensated(self._state.value, np.zeros(size)).add(self._state.carry)
            parameters[:size], parameters[size : 2 * size] = 0.0, self._state.value
            if not np.isfinite(self._state.value).all():
                raise NumericalError("the rigid body inside REBOUND is no longer finite", time=simulation.t)

    def _parameters(self) -> np.ndarray:
        """What REBOUND integrates: what a step adds to the state, the state before the step, and the constants."""
        return np.ctypeslib.as_array(self._ode.y, (self._ode.length,))  # it has moved after a step

    def _shortest_time(self) -> float:
        apart = np.linalg.norm(self.position[1:] - self.position[0], axis=1)
        pace = np.linalg.norm(self.velocity[1:] - self.velocity[0], axis=1)
        return 1.0 / max(np.max(pace / apart, initial=0.0), float(np.linalg.norm(self.angular_velocity)))


@lru_cache
def _rates(count: int) -> Any:
    """The rates of change as a C function of REBOUND's, for so many bodies."""
    size = 6 * count + 7
    masses = 2 * size
    moments, gravity, reaction = masses + count, masses + count + 3, masses + count + 4
    unit = reaction + 1
    length = unit + size

    @numba.cfunc(_SIGNATURE, cache=True)
    def rates(_, pointer_to_rates, pointer_to_state, time):
        rate, parameters = carray(pointer_to_rates, length), carray(pointer_to_state, length)
        rate[:] = 0.0
        state = parameters[unit:length] * parameters[:size] + parameters[size : 2 * size]
        place, a, c = state[: 3 * count], moments, gravity
        rate[: 3 * count] = state[3 * count : 6 * count]
        pull = rate[3 * count : 6 * count]
        for i in range(count):
            for j in range(i):
                apart = place[3 * i : 3 * i + 3] - place[3 * j : 3 * j + 3]
                weight = parameters[c] / (apart[0] ** 2 + apart[1] ** 2 + apart[2] ** 2) ** 1.5
                pull[3 * i : 3 * i + 3] -= parameters[masses + j] * weight * apart
                pull[3 * j : 3 * j + 3] += parameters[masses + i] * weight * apart
        w, x, y, z = state[6 * count], state[6 * count + 1], state[6 * count + 2], state[6 * count + 3]
        square = w * w + x * x + y * y + z * z
        # Columns: the principal axes in space.
        axes = np.empty((3, 3))
        axes[0, 0], axes[0, 1], axes[0, 2] = w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
        axes[1, 0], axes[1, 1], axes[1, 2] = 2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)
        axes[2, 0], axes[2, 1], axes[2, 2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z
        axes /= square
        trace = parameters[a] + parameters[a + 1] + parameters[a + 2]
        torque, n, turned = np.zeros(3), np.empty(3), np.empty(3)
        for j in range(1, count):
            apart = place[3 * j : 3 * j + 3] - place[:3]
            distance = np.sqrt(apart[0] ** 2 + apart[1] ** 2 + apart[2] ** 2)
            for k in range(3):
                n[k] = (axes[0, k] * apart[0] + axes[1, k] * apart[1] + axes[2, k] * apart[2]) / distance
                turned[k] = parameters[a + k] * n[k]
            weight = 3.0 * parameters[c] * parameters[masses + j] / distance**3
            torque[0] += weight * (n[1] * turned[2] - n[2] * turned[1])
            torque[1] += weight * (n[2] * turned[0] - n[0] * turned[2])
            torque[2] += weight * (n[0] * turned[1] - n[1] * turned[0])
            along = n[0] * turned[0] + n[1] * turned[1] + n[2] * turned[2]
            force = 0.5 * weight / distance * ((5.0 * along - trace) * n - 2.0 * turned) * parameters[reaction]
            for k in range(3):
                push = axes[k, 0] * force[0] + axes[k, 1] * force[1] + axes[k, 2] * force[2]
                pull[3 * j + k] += push / parameters[masses + j]
                pull[k] -= push / parameters[masses]
        for j in range(count - 1, -1, -1):
            pull[3 * j : 3 * j + 3] -= pull[:3]
        p, q, r = state[6 * count + 4], state[6 * count + 5], state[6 * count + 6]
        rate[6 * count] = -0.5 * (x * p + y * q + z * r)
        rate[6 * count + 1] = 0.5 * (w * p + y * r - z * q)
        rate[6 * count + 2] = 0.5 * (w * q + z * p - x * r)
        rate[6 * count + 3] = 0.5 * (w * r + x * q - y * p)
        rate[6 * count + 4] = (torque[0] - (parameters[a + 2] - parameters[a + 1]) * q * r) / parameters[a]
        rate[6 * count + 5] = (torque[1] - (parameters[a] - parameters[a + 2]) * r * p) / parameters[a + 1]
        rate[6 * count + 6] = (torque[2] - (parameters[a + 1] - parameters[a]) * p * q) / parameters[a + 2]
        rate[:size] /= parameters[unit:length]

    return rates
