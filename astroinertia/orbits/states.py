"""Where the particles of a simulation are at given times, as arrays."""

import math

import numpy as np
import rebound


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
    positions, velocities = np.empty((2, len(times), bodies.N - 1, 3))
    for k, time in enumerate(times):
        go_on(bodies, float(time))
        positions[k], velocities[k] = present(bodies, origin)
    return positions, velocities


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


def drift(bodies: rebound.Simulation, span: float, until: float) -> None:
    """Take a simulation on by a length of time, backwards if negative, and then call its time `until`.

    Many short drifts by the differences of late times would lose digits that these have not.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> drift(bodies, np.pi / 2, until=1e9)
    >>> print(f"{bodies.particles[1].y:.9f} at {bodies.t:g}")
    1.000000000 at 1e+09
    """
    bodies.t = 0.0
    go_on(bodies, span)
    bodies.t = until


def present(bodies: rebound.Simulation, origin: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (N-1, 3) of all particles but one relative to that one, now.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0, x=5.0)
    >>> bodies.add(x=6.0, vy=1.0)
    >>> print(*present(bodies))
    [[1. 0. 0.]] [[0. 1. 0.]]
    """
    others = np.arange(bodies.N) != origin
    place, speed = np.empty((bodies.N, 3)), np.empty((bodies.N, 3))
    bodies.serialize_particle_data(xyz=place, vxvyvz=speed)
    return place[others] - place[origin], speed[others] - speed[origin]


def push(bodies: rebound.Simulation, change: np.ndarray, carry: np.ndarray) -> None:
    """Add to the velocities of all particles, (N, 3); carry (N, 3) keeps what rounding loses for the next time.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(m=1.0, x=1.0)
    >>> push(bodies, np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]), np.zeros((2, 3)))
    >>> print(bodies.particles[1].vy)
    2.0
    """
    speed = np.empty((bodies.N, 3))
    bodies.serialize_particle_data(vxvyvz=speed)
    wanted = change + carry
    pushed = speed + wanted
    carry[:] = wanted - (pushed - speed)
    bodies.set_serialized_particle_data(vxvyvz=pushed)
    bodies.did_modify_particles = 1


def packed(bodies: rebound.Simulation) -> np.ndarray:
    """A simulation with all its integrator knows, as bytes (B,).

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> print(packed(bodies).dtype, unpacked(packed(bodies)) == bodies)
    uint8 True
    """
    return np.frombuffer(bodies.__reduce__()[1][0], dtype=np.uint8)


def unpacked(told: np.ndarray) -> rebound.Simulation:
    """The simulation that was packed.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> print(unpacked(packed(bodies)).N)
    2
    """
    return rebound.Simulation(told.tobytes())


def masses(bodies: rebound.Simulation) -> np.ndarray:
    """Masses of all particles, (N,).

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(m=1e-3, a=1.0)
    >>> print(masses(bodies))
    [1.    0.001]
    """
    found = np.empty(bodies.N)
    bodies.serialize_particle_data(m=found)
    return found


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
    with np.errstate(divide="ignore"):
        return float(min((distance / speed).min(), (distance**3 / (bodies.G * (mass[one] + mass[other]))).min() ** 0.5))
