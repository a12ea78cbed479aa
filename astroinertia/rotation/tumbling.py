"""Chaotic tumbling of a triaxial moon on an eccentric orbit: how fast two motions that begin alike come apart.

Euler's equations with the torque of a point mass on a Kepler orbit, to the quadrupole, and the motion's own derivative
along a small difference, which is scaled back once an orbit; time is in units of 1/n. The same motion, without the
difference, is that of the `rigid` model with the effect gravity_gradient.
Sources: Wisdom, Peale & Mignard 1984, Icarus 58, 137; Benettin et al. 1980, Meccanica 15, 9.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines import adaptive
from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.attitude import attitude_of_quaternion, quaternion, quaternion_product

Array = Any

_TOLERANCE = 1e-11
_FIRST_STEP = 0.02


class Divergence(NamedTuple):
    """How two motions came apart: growth (orbits,), the natural logarithm of their distance so far at each orbit's end.

    exponent: the mean rate of growth over the second half, rad^-1 of mean anomaly; lyapunov_time: 1/(exponent n) in
    the units of 1/mean_motion, inf where they do not come apart. angular_velocity and attitude: at the end, as at the
    start.
    """

    growth: np.ndarray
    exponent: float
    lyapunov_time: float
    angular_velocity: np.ndarray
    attitude: np.ndarray


@with_quantities()
def divergence(
    moments: Array, eccentricity: float, attitude: Array, angular_velocity: Array, mean_motion: float = 1.0,
    orbits: int = 200, true_anomaly: float = 0.0,
) -> Divergence:  # fmt: skip
    """How fast motions next to that of a tumbling moon leave it, over so many orbits from a true anomaly (rad).

    moments: A, B, C about the rows of attitude (3, 3), which are the body's axes in inertial axes; angular_velocity
    (3,), in inertial axes and the units of mean_motion. The orbit is in the x-y plane, its pericentre towards x.
    ValueError for moments that are no body's, an eccentricity outside 0 <= e < 1 or fewer than two orbits;
    NumericalError where the integration fails. Source: Wisdom, Peale & Mignard 1984, section 6; Benettin et al. 1980.
    """
    inertia, axes = np.asarray(moments, dtype=float), np.asarray(attitude, dtype=float)
    largest = inertia.max()
    if not (np.all(inertia > 0) and 2 * largest <= inertia.sum() * (1 + 1e-12)):
        raise ValueError("three moments of a body are above 0, and none is above the sum of the others")
    if not 0 <= eccentricity < 1 or orbits < 2:
        raise ValueError(
            "a tumbling moon has an orbit of 0 <= eccentricity < 1 and is followed for two of them or more"
        )
    with jax.enable_x64(True):
        start = jnp.concatenate(
            [
                jnp.asarray(quaternion(axes)),
                jnp.asarray(axes @ np.asarray(angular_velocity, dtype=float) / mean_motion),
                jnp.array([true_anomaly]),
            ]
        )
        away = jnp.array([1.0, 2.0, -1.0, 0.5, 1.0, -1.0, 2.0, 0.0])  # any direction turns into the fastest
        arguments = (jnp.asarray(inertia / largest), jnp.asarray(float(eccentricity)))
        state, timestep, growth = (start, away / jnp.linalg.norm(away)), _FIRST_STEP, [0.0]
        for orbit in range(orbits):
            done = adaptive.advance(
                _with_difference, arguments, state, 2 * np.pi * orbit, 2 * np.pi * (orbit + 1), timestep,
                _TOLERANCE, _TOLERANCE,
            )  # fmt: skip
            if bool(done.failed):
                raise NumericalError("the motion of a tumbling moon takes too many steps")
            place, difference = done.state
            length = float(jnp.linalg.norm(difference))
            unit = place.at[:4].divide(jnp.linalg.norm(place[:4]))
            growth.append(growth[-1] + np.log(length))
            state, timestep = (unit, difference / length), float(done.timestep)
        place = np.asarray(state[0])
    history = np.array(growth[1:])
    half = orbits // 2
    exponent = (history[-1] - history[half - 1]) / (2 * np.pi * (orbits - half))
    now = np.asarray(attitude_of_quaternion(place[:4]))
    return Divergence(
        history, float(exponent), float(1 / (exponent * mean_motion)) if exponent > 0 else np.inf,
        now.T @ place[4:7] * mean_motion, now,
    )  # fmt: skip


def _rate(state: Array, arguments: Any) -> Array:
    inertia, eccentricity = arguments
    q, spin, anomaly = state[:4], state[4:7], state[7]
    root = jnp.sqrt(1 - eccentricity**2)
    inverse = (1 + eccentricity * jnp.cos(anomaly)) / root**2  # a/r
    towards = attitude_of_quaternion(q) @ jnp.array([jnp.cos(anomaly), jnp.sin(anomaly), 0.0])
    torque = 3 * inverse**3 * jnp.cross(towards, inertia * towards)
    acceleration = (torque - jnp.cross(spin, inertia * spin)) / inertia
    turning = 0.5 * quaternion_product(q, jnp.concatenate([jnp.zeros(1), spin]))
    return jnp.concatenate([turning, acceleration, (root * inverse**2)[None]])


def _with_difference(time: Array, state: tuple[Array, Array], arguments: Any) -> tuple[Array, Array]:
    return jax.jvp(lambda place: _rate(place, arguments), (state[0],), (state[1],))
