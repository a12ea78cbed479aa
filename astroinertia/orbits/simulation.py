"""Point masses on orbits as a `rebound.Simulation`, and back: by elements, or by positions and velocities."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import rebound

from astroinertia.orbits.kepler import eccentric_anomaly
from astroinertia.orbits.states import names
from astroinertia.process.quantities import with_quantities
from astroinertia.units import CodeUnits

BODY = "body"
"""The name of the body that the others are companions of; it is particle 0."""
BARYCENTRE = "barycentre"
"""What a companion may go around: the centre of mass of the body and of all companions listed before it."""

STEPS_PER_PERIOD = 40.0  # of WHFast where no time step is given; tests/unit/rotation/test_ephemeris.py has the error
_CORRECTOR = 17  # the highest order of symplectic corrector that WHFast has
_VECTORS = ("position", "velocity")
_DIMENSIONS = {
    "mass": "mass",
    "position": "length",
    "velocity": "velocity",
    "semi_major_axis": "length",
    "period": "time",
}


@dataclass(frozen=True)
class Companion:
    """A point mass near the body, in any consistent units: position and velocity, or elements, relative to `around`.

    around is BODY, BARYCENTRE or the name of a companion listed before. Elements are those of the two bodies alone:
    semi-major axis or period, eccentricity below 1, and in radians the inclination to the x-y plane, the longitude of
    the ascending node, the argument of the pericentre and the mean anomaly at the start.
    """

    name: str
    mass: float
    around: str = BODY
    position: tuple[float, float, float] | None = None
    velocity: tuple[float, float, float] | None = None
    semi_major_axis: float | None = None
    period: float | None = None
    eccentricity: float = 0.0
    inclination: float = 0.0
    node: float = 0.0
    pericentre: float = 0.0
    mean_anomaly: float = 0.0

    def __post_init__(self) -> None:
        vectors = [getattr(self, name) is not None for name in _VECTORS]
        sizes = (self.semi_major_axis is not None) + (self.period is not None)
        if vectors not in ([True, True], [False, False]) or sizes != (0 if vectors[0] else 1):
            raise ValueError(
                f"{self.name} needs a position and a velocity, or one of semi_major_axis and period, and not both"
            )
        if not 0.0 <= self.eccentricity < 1.0:
            raise ValueError(f"{self.name} has the eccentricity {self.eccentricity:g}, which is not in 0 to 1")
        if not self.mass >= 0.0:
            raise ValueError(f"{self.name} has the mass {self.mass:g}, which is negative")


def in_code_units(companions: Sequence[Any], units: CodeUnits) -> tuple[Companion, ...]:
    """A scene's companions, in SI, as `Companion` in code units.

    >>> from astroinertia.units import CodeUnits
    >>> units = CodeUnits(mass=2.0, length=4.0, gravitational_constant=1.0)
    >>> moon = in_code_units([Companion(name="moon", mass=1.0, semi_major_axis=8.0)], units)[0]
    >>> print(moon.mass, moon.semi_major_axis)
    0.5 2.0
    """
    converted = []
    for companion in companions:
        values = {field.name: getattr(companion, field.name) for field in fields(Companion)}
        for name, dimension in _DIMENSIONS.items():
            if values[name] is not None:
                scaled = units.to_code(np.asarray(values[name], dtype=float), dimension)
                values[name] = tuple(scaled.tolist()) if name in _VECTORS else float(scaled)
        converted.append(Companion(**values))
    return tuple(converted)


@with_quantities()
def simulation(
    mass: float,
    companions: Sequence[Companion],
    gravitational_constant: float = 1.0,
    integrator: str = "ias15",
    timestep: float | None = None,
) -> rebound.Simulation:
    """The body, of that mass, and its companions as named particles, their centre of mass at rest at the origin.

    The integrator is "ias15" (adaptive, to round-off) or "whfast" (symplectic; timestep is the longest of its steps,
    a fortieth of the shortest period where none is given, which needs elements). ValueError where names contradict.
    Sources: Rein & Liu 2012, A&A 537, A128; Rein & Spiegel 2015, MNRAS 446, 1424 (IAS15); Rein & Tamayo 2015, MNRAS
    452, 376 (WHFast). Checked by tests/unit/orbits/test_simulation.py.

    >>> moon = Companion(name="moon", mass=0.0123, position=(60.3, 0.0, 0.0), velocity=(0.0, 0.13, 0.0))
    >>> print(simulation(1.0, [moon]).N)
    2
    """
    bodies: Any = rebound.Simulation()
    bodies.G = gravitational_constant
    bodies.add(m=mass, name=BODY)
    for companion in companions:
        if companion.name in names(bodies) or companion.name == BARYCENTRE:
            raise ValueError(f"there are two bodies with the name {companion.name}")
        bodies.add(_particle(bodies, companion))
    bodies.move_to_com()
    bodies.integrator = integrator
    if integrator == "whfast":
        method: Any = bodies.integrator
        method.corrector = _CORRECTOR
        bodies.dt = _shortest_period(bodies, companions) / STEPS_PER_PERIOD if timestep is None else timestep
    return bodies


def companions(bodies: rebound.Simulation, around: dict[str, str] | None = None) -> tuple[Companion, ...]:
    """The other particles of a simulation as companions of particle 0, by osculating elements.

    around gives the name of what each of them goes around; where it does not say BODY, which is particle 0 whatever its
    own name. ValueError for an orbit that is not bound. Particles without a name are called "particle 1" and so on.
    Checked by tests/unit/orbits/test_simulation.py.

    >>> moon = Companion(name="moon", mass=0.0123, semi_major_axis=60.3, eccentricity=0.055)
    >>> print(f"{companions(simulation(1.0, [moon]))[0].eccentricity:.6f}")  # to a simulation and back
    0.055000
    """
    labels = [BODY, *names(bodies)[1:]]
    return tuple(_companion(bodies, k, labels, (around or {}).get(labels[k], BODY)) for k in range(1, bodies.N))


def _companion(bodies: Any, k: int, labels: list[str], around: str) -> Companion:
    elements, _ = _orbit(bodies, k, labels, around)
    return Companion(labels[k], bodies.particles[k].m, around, **elements)


def _orbit(bodies: Any, k: int, labels: list[str], around: str) -> tuple[dict[str, Any], float]:
    """Osculating elements of a particle, and its period; ValueError where its orbit is not bound.

    Angles are arctangents: the arccosines of REBOUND's own leave half of the digits of a small inclination, and on a
    circle they may put the particle on the other side. Murray & Dermott 1999, Solar System Dynamics, section 2.8.
    """
    centre, particle = _centre(bodies, labels, around, k), bodies.particles[k]
    place, speed = np.subtract(particle.xyz, centre.xyz), np.subtract(particle.vxyz, centre.vxyz)
    strength, distance = bodies.G * (centre.m + particle.m), math.hypot(*place)
    if not (strength > 0.0 and distance > 0.0):
        raise ValueError(f"{labels[k]} has no orbit around {around}: they are at one place, or neither has a mass")
    over_axis, outward = 2.0 / distance - float(speed @ speed) / strength, float(place @ speed)
    cosine = 1.0 - distance * over_axis  # times e, of the eccentric anomaly
    eccentricity = math.sqrt(max(0.0, cosine**2 + outward**2 * over_axis / strength))
    turning = np.cross(place, speed)
    if not (over_axis > 0.0 and eccentricity < 1.0 and turning.any()):
        raise ValueError(f"{labels[k]} has no bound orbit around {around}: its eccentricity is {eccentricity:.6g}")
    anomaly = math.atan2(outward * math.sqrt(over_axis / strength), cosine)
    tilt = math.hypot(turning[0], turning[1])
    node = math.atan2(turning[0], -turning[1]) if tilt > 0.0 else 0.0
    ascending = np.array([math.cos(node), math.sin(node), 0.0])
    from_node = math.atan2(place @ np.cross(turning / math.hypot(*turning), ascending), place @ ascending)
    across = math.sqrt((1.0 - eccentricity) * (1.0 + eccentricity)) * math.sin(anomaly)
    pericentre = from_node - math.atan2(across, math.cos(anomaly) - eccentricity)
    elements = {
        "semi_major_axis": 1.0 / over_axis,
        "eccentricity": eccentricity,
        "inclination": math.atan2(tilt, turning[2]),
        "node": node % (2.0 * math.pi),
        "pericentre": pericentre % (2.0 * math.pi),
        "mean_anomaly": (anomaly - eccentricity * math.sin(anomaly)) % (2.0 * math.pi),
    }
    return elements, 2.0 * math.pi / math.sqrt(strength * over_axis**3)


def _centre(bodies: rebound.Simulation, labels: list[str], around: str, before: int) -> Any:
    if around == BARYCENTRE:
        return bodies.com(last=before)
    if around not in labels[:before]:
        raise ValueError(f"{labels[before]} goes around {around}, which is not listed before it")
    return bodies.particles[labels.index(around)]


def _particle(bodies: Any, companion: Companion) -> rebound.Particle:
    centre = _centre(bodies, [*names(bodies), companion.name], companion.around, bodies.N)
    place, speed = companion.position, companion.velocity
    if place is None or speed is None:
        if not centre.m > 0.0:
            raise ValueError(f"{companion.name} goes around {companion.around}, which has no mass")
        place, speed = _on_orbit(companion, bodies.G * (centre.m + companion.mass))
    place, speed = np.add(centre.xyz, place), np.add(centre.vxyz, speed)
    return rebound.Particle(
        bodies, m=companion.mass, name=companion.name,
        **dict(zip(("x", "y", "z", "vx", "vy", "vz"), map(float, (*place, *speed)), strict=True)),
    )  # fmt: skip


def _on_orbit(companion: Companion, strength: float) -> tuple[np.ndarray, np.ndarray]:
    """Place and velocity (3,) by a companion's elements about what it goes around; strength is G times both masses.

    1 - e is never the difference of larger numbers, of which REBOUND's own places have an error of 1e-10 at e = 0.9999.
    Murray & Dermott 1999, Solar System Dynamics, eq. 2.119 to 2.122.
    """
    e, axis = companion.eccentricity, companion.semi_major_axis
    if axis is None:
        assert companion.period is not None
        axis = (strength * (companion.period / (2.0 * math.pi)) ** 2) ** (1.0 / 3.0)
    anomaly = float(eccentric_anomaly(np, np.float64(companion.mean_anomaly), e))
    fallen, flat = 2.0 * math.sin(0.5 * anomaly) ** 2, math.sqrt((1.0 - e) * (1.0 + e))
    pace = math.sqrt(strength / axis) / ((1.0 - e) + e * fallen)
    (one, up), (cosine, sine), (tilt, level) = (
        (math.cos(angle), math.sin(angle)) for angle in (companion.node, companion.pericentre, companion.inclination)
    )
    towards = np.array([one * cosine - up * sine * tilt, up * cosine + one * sine * tilt, sine * level])
    across = np.array([-one * sine - up * cosine * tilt, -up * sine + one * cosine * tilt, cosine * level])
    return (
        axis * (((1.0 - e) - fallen) * towards + flat * math.sin(anomaly) * across),
        pace * (flat * math.cos(anomaly) * across - math.sin(anomaly) * towards),
    )


def _shortest_period(bodies: rebound.Simulation, listed: Sequence[Companion]) -> float:
    labels = names(bodies)
    return min(_orbit(bodies, k, labels, companion.around)[1] for k, companion in enumerate(listed, start=1))
