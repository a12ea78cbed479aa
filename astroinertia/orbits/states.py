"""Where the particles of a simulation are at given times, as arrays."""

import ctypes
import math
from typing import Any

import numpy as np
import rebound

from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities


@with_quantities()
def states(bodies: rebound.Simulation, times: np.ndarray, origin: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (T, N-1, 3) of all particles but one relative to that one, at rising or falling times.

    Takes the simulation on to the last of them. WHFast goes from one time to the next in equal steps no longer than
    its own, which the times alone decide, and so stays symplectic.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> print(np.round(states(bodies, np.array([0.0, np.pi]))[0][:, 0], 9) + 0.0)  # half a circle
    [[ 1.  0.  0.]
     [-1.  0.  0.]]
    """
    times = np.asarray(times, dtype=float)
    rows, now = np.empty((len(times), bodies.N, 6)), live(bodies)
    for row, time in zip(rows, times.tolist(), strict=True):
        go_on(bodies, time)
        row[:] = now
    relative = np.delete(rows, origin, axis=1) - rows[:, [origin]]
    return relative[..., :3], relative[..., 3:]


def live(bodies: rebound.Simulation) -> np.ndarray:
    """Positions and velocities (N, 6) of all particles, which go on with the simulation.

    Read where they are: to ask for a copy takes longer than a step of few bodies.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0, vx=2.0)
    >>> now = live(bodies)
    >>> bodies.integrate(1.0)
    >>> print(now)
    [[2. 0. 0. 2. 0. 0.]]
    """
    first: Any = bodies.particles[0]
    here = (rebound.Particle * bodies.N).from_address(ctypes.addressof(first))
    return np.frombuffer(here).reshape(bodies.N, -1)[:, :6]


@with_quantities()
def go_on(bodies: rebound.Simulation, time: float) -> None:
    """Take a simulation to a time, before or after its own.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> go_on(bodies, -np.pi / 2)  # backwards
    >>> print(f"{bodies.particles[1].y:.9f}")
    -1.000000000
    """
    span = time - bodies.t
    if span == 0.0:
        return
    if str(bodies.integrator) != "whfast":
        bodies.integrate(time)
        return
    longest = abs(bodies.dt)
    steps = max(1, math.ceil(abs(span) / longest * (1.0 - 1e-9)))
    bodies.dt = span / steps
    bodies.steps(steps)
    bodies.t, bodies.dt = time, longest


def present(bodies: rebound.Simulation) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (N-1, 3) of all particles but the first relative to that one, now.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0, x=5.0)
    >>> bodies.add(x=6.0, vy=1.0)
    >>> print(*present(bodies))
    [[1. 0. 0.]] [[0. 1. 0.]]
    """
    place, speed = np.empty((bodies.N, 3)), np.empty((bodies.N, 3))
    bodies.serialize_particle_data(xyz=place, vxvyvz=speed)
    return place[1:] - place[0], speed[1:] - speed[0]


def masses(bodies: rebound.Simulation) -> np.ndarray:
    """Masses of all particles, (N,).

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(m=1e-3, a=1.0)
    >>> print(masses(bodies))
    [1.    0.001]
    """
    values = np.empty(bodies.N)
    bodies.serialize_particle_data(m=values)
    return values


def names(bodies: rebound.Simulation) -> list[str]:
    """Names of all particles; "particle 1" and so on where they have none.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0, name="star")
    >>> bodies.add(a=1.0)
    >>> print(names(bodies))
    ['star', 'particle 1']
    """
    return [particle.name or f"particle {k}" for k, particle in enumerate(bodies.particles)]


def shortest_time(bodies: rebound.Simulation) -> float:
    """The least of the times in which any two particles pass or attract each other, r/v and (r^3/GM)^(1/2).

    Infinite where there are no two. NumericalError where two of them are at one place.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> bodies.add(a=4.0)
    >>> print(f"{shortest_time(bodies):.6f}")  # r/v of the inner orbit
    1.000000
    """
    state = np.empty((bodies.N, 6))
    bodies.serialize_particle_data(xyzvxvyvz=state)
    one, other = np.triu_indices(bodies.N, 1)
    distance, speed = (np.linalg.norm(part[one] - part[other], axis=-1) for part in np.split(state, 2, axis=1))
    mass = masses(bodies)
    with np.errstate(divide="ignore", invalid="ignore"):
        orbital = distance**3 / (bodies.G * (mass[one] + mass[other]))
        shortest = min((distance / speed).min(initial=math.inf), orbital.min(initial=math.inf) ** 0.5)
    if not shortest > 0.0:
        raise NumericalError(
            "two of the bodies are at one place: they are, or what lies between them is rounded away beside the "
            "distance of another"
        )
    return float(shortest)
