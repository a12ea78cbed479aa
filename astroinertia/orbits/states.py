"""Where the particles of a simulation are at given times, as arrays."""

import ctypes
import math
import struct
from typing import Any

import numpy as np
import rebound

from astroinertia.errors import NumericalError
from astroinertia.process.quantities import with_quantities

_HEADER = 64  # bytes of the binary format that name REBOUND and its version
_PROBE = 1e-3  # of a step, after which an integrator has all its arrays
# What time changes in a simulation, by the names of the binary format.
_PARTICLES = ("particles", "integrator.whfast.p_jh")
_IAS15 = ("at", "x0", "v0", "a0", "csx", "csv", "csa0", "g", "b", "csb", "e", "br", "er")
_NUMBERS = ("t", "dt", "dt_last_done", *(f"integrator.ias15.{name}" for name in _IAS15))
_FLAGS = ("did_modify_particles", "is_synchronized")
_COUNT = "steps_done"
_SIZE = ctypes.sizeof(rebound.Particle)


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
    rows = np.empty((len(times), bodies.N, 6))
    # Read where they are: to ask for a copy takes longer than a step of few bodies.
    first: Any = bodies.particles[0]
    here = (rebound.Particle * bodies.N).from_address(ctypes.addressof(first))
    now = np.frombuffer(here).reshape(bodies.N, -1)[:, :6]
    for row, time in zip(rows, times.tolist(), strict=True):
        go_on(bodies, time)
        row[:] = now
    relative = np.delete(rows, origin, axis=1) - rows[:, [origin]]
    return relative[..., :3], relative[..., 3:]


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
    >>> print(packed(bodies).dtype)
    uint8
    """
    return np.frombuffer(bodies.__reduce__()[1][0], dtype=np.uint8)


def unpacked(packed_state: np.ndarray, begun: rebound.Simulation) -> rebound.Simulation:
    """The simulation that was packed, which `begun` became in time; ValueError where it is another.

    REBOUND trusts every length and every pointer in such bytes, which may come from anywhere. Only the numbers that
    time changes are taken from them; all else, and how it is laid out, is that of the simulation at the beginning.

    >>> bodies = rebound.Simulation()
    >>> bodies.add(m=1.0)
    >>> bodies.add(a=1.0)
    >>> later = bodies.copy()
    >>> go_on(later, 1.0)
    >>> print(unpacked(packed(later), bodies) == later)
    True
    """
    stored = _fields(packed_state.tobytes())
    stepped = begun.copy()
    drift(stepped, _PROBE * stepped.dt, 0.0)  # with what its integrator allocates at its first step
    for like in (begun, stepped):
        content = packed(like).tobytes()
        own = _fields(content)
        if [(name, len(data)) for name, _, data in own] == [(name, len(data)) for name, _, data in stored]:
            break
    else:
        raise ValueError("its orbits are not those of its scene")
    made = bytearray(content)
    for (name, place, data), (_, _, other) in zip(own, stored, strict=True):
        if name in _PARTICLES:
            if name == "particles" and (_masses_in(data) != _masses_in(other)).any():
                raise ValueError("its orbits are of bodies with other masses than those of its scene")
            made[place : place + len(data)] = _moved(data, other)
        elif name in _NUMBERS:
            if not np.isfinite(np.frombuffer(other)).all():
                raise ValueError(f"its orbits have no numbers for {name}")
            made[place : place + len(data)] = other
        elif name in _FLAGS:
            if int.from_bytes(other, "little") not in (0, 1):
                raise ValueError(f"its orbits have no truth value for {name}")
            made[place : place + len(data)] = other
        elif name == _COUNT:
            made[place : place + len(data)] = other
    return rebound.Simulation(bytes(made))


def _fields(content: bytes) -> list[tuple[str, int, bytes]]:
    """Name, place and bytes of each field of REBOUND's binary format: two lengths, then the name and the data."""
    fields, place = [], _HEADER
    while place + 16 <= len(content):
        length, size = struct.unpack_from("<QQ", content, place)
        begin = place + 16 + length
        if not 0 < length < 100 or begin + size > len(content):
            break
        fields.append(
            (content[place + 16 : begin].rstrip(b"\0").decode("ascii", "replace"), begin, content[begin : begin + size])
        )
        place = begin + size
        if fields[-1][0] == "end":
            break
    return fields


def _masses_in(particles: bytes) -> np.ndarray:
    return np.array(
        [particle.m for particle in (rebound.Particle * (len(particles) // _SIZE)).from_buffer_copy(particles)]
    )


def _moved(own: bytes, other: bytes) -> bytes:
    """The particles `own` with places, velocities and accelerations of others."""
    numbers, size = 9, _SIZE // 8
    made, moved = (np.frombuffer(particles).reshape(-1, size) for particles in (own, other))
    made = made.copy()
    if not np.isfinite(moved[:, :numbers]).all():
        raise ValueError("its orbits have particles without places or velocities")
    made[:, :numbers] = moved[:, :numbers]
    return made.tobytes()


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

    NumericalError where two of them are at one place.

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
        shortest = min((distance / speed).min(), (distance**3 / (bodies.G * (mass[one] + mass[other]))).min() ** 0.5)
    if not shortest > 0.0:
        raise NumericalError(
            "two of the bodies are at one place: they are, or what lies between them is rounded away beside the "
            "distance of another"
        )
    return float(shortest)
