"""Gravity, orbits and spins beside REBOUND: direct sums, Kepler's equation, a tumbling moon as ODE inside it."""

import jax
import numpy as np

from astroinertia.build.assemble import prepare
from astroinertia.build.sph import engine_of
from astroinertia.gravity.direct import DIRECT_GRAVITY
from astroinertia.orbits.kepler import eccentric_anomaly
from astroinertia.orbits.particles import accelerations, of_particles
from astroinertia.orbits.rigid_ode import RigidBodyOde
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.orbits.states import states
from astroinertia.rotation.attitude import attitude_of_quaternion
from astroinertia.scene.load import loads
from astroinertia.verify.comparison import Quantities

_ECCENTRICITY, _ORBITS, _TUMBLES = 0.3, 20, 5  # orbits of Kepler and of torque
_PARTICLES, _KERNEL, _POINT = 1000, "wendland_c2", 1e-9  # and smoothing lengths, so that no two kernels overlap
_MASS, _DISTANCE = 3.0, 10.0  # of the companion, M = G = 1
_MOMENTS, _SPIN = (0.02, 0.03, 0.04), (0.1, 0.02, 0.4)
_TUMBLING = f"""
name = "cross_check"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = {list(_MOMENTS)}
[body.rotation]
rate = {float(np.linalg.norm(_SPIN))!r}
axis = {list(_SPIN)}
[[companions]]
name = "planet"
mass = {_MASS}
semi_major_axis = {_DISTANCE}
eccentricity = {_ECCENTRICITY}
[effects.gravity_gradient]
[numerics]
integrator = "splitting"
order = 8
steps_per_rotation = 60
[time]
end = 1e4
"""


def _planet() -> Companion:
    return Companion("planet", _MASS, semi_major_axis=_DISTANCE, eccentricity=_ECCENTRICITY)


def _period() -> float:
    return 2 * np.pi * float(np.sqrt(_DISTANCE**3 / (1 + _MASS)))


def orbit() -> Quantities:
    """Where a companion is after many orbits, by Kepler's equation and by IAS15."""
    time = (_ORBITS + 0.3) * _period()
    anomaly = float(eccentric_anomaly(np, np.float64(2 * np.pi * time / _period()), _ECCENTRICITY))
    here = _DISTANCE * np.array([np.cos(anomaly) - _ECCENTRICITY, np.sqrt(1 - _ECCENTRICITY**2) * np.sin(anomaly)])
    there = states(simulation(1.0, [_planet()]), np.array([time]))[0][0, 0, :2]
    return {"orbit_x": (here[0], there[0]), "orbit_y": (here[1], there[1])}


def tumbling_moon() -> Quantities:
    """Attitude and spin of a triaxial body after five orbits' worth of torque, here and inside REBOUND."""
    bodies, end = simulation(1.0, [_planet()]), _TUMBLES * _period()
    place, speed = (np.array([getattr(particle, name) for particle in bodies.particles]) for name in ("xyz", "vxyz"))
    there = RigidBodyOde([1.0, _MASS], place, speed, _MOMENTS, [1.0, 0, 0, 0], _SPIN, back_reaction=False)
    there.integrate(end)
    with jax.enable_x64(True):
        evolution = prepare(loads(_TUMBLING, [f"time.end={end!r}"])).evolution
        opening = evolution.record(None)["potential_energy"]
        while evolution.time < end:
            evolution.advance(end)
        here = evolution.record(opening)
    attitude = attitude_of_quaternion(there.quaternion)
    momentum = attitude.T @ (np.array(_MOMENTS) * there.angular_velocity)
    size = float(np.linalg.norm(momentum))
    return {
        "tumbling_attitude": float(abs(here["attitude"] - attitude).max()),
        "tumbling_momentum": float(np.linalg.norm(here["angular_momentum"] - momentum)) / size,
    }


def direct_gravity() -> Quantities:
    """The pull on each of a thousand particles, over the sum of the sizes of all pulls on it."""
    random = np.random.default_rng(1)
    mass, position = random.uniform(0.5, 1.5, _PARTICLES) / _PARTICLES, random.normal(size=(_PARTICLES, 3))
    there = accelerations(of_particles(mass, position))
    engine, size = engine_of("numba_cpu", "float64", _KERNEL), np.full(_PARTICLES, _POINT)
    order, arrangement = engine.arrange(position, size)
    fields = {"mass": mass[order], "position": position[order], "velocity": np.zeros_like(position)}
    sums = engine.all_pair_sums(arrangement, _KERNEL, (DIRECT_GRAVITY,), fields | {"smoothing_length": size})
    separation = np.linalg.norm(position[order, None] - position[None], axis=-1)
    pulls = np.divide(mass, separation**2, out=np.zeros_like(separation), where=separation > 0).sum(axis=1)
    apart = np.linalg.norm(sums["gravity"]["acceleration"] - there[order], axis=1)
    return {"direct_gravity": float((apart / pulls).max())}


COMPUTATIONS = (direct_gravity, orbit, tumbling_moon)
