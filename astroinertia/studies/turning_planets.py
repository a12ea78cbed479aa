"""The Earth and Mars as rigid bodies under Sun, Moon and planets: what they are, and how their axes move.

Orbits: REBOUND from where all were at J2000, forwards and backwards, tabulated (`rotation.ephemeris`), or those of
SPICE kernels (`rotation.spice`), which may give the pole and the rate of rotation, too. Rotation: the
`rigid` model with the effect gravity_gradient in steps by splitting. Tests: tests/physics/test_precession.py.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.bodies import j2000
from astroinertia.bodies.mean_orbits import mean_companions
from astroinertia.bodies.planets import body
from astroinertia.effects.kinds.gravity_gradient import GravityGradient
from astroinertia.engines.brief import brief
from astroinertia.models.rigid import body as rigid, splitting
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.rotation import spice
from astroinertia.rotation.attitude import quaternion
from astroinertia.rotation.ephemeris import Ephemeris, ephemeris
from astroinertia.rotation.precession import ARCSECOND, JULIAN_YEAR
from astroinertia.units import quantity

DAY = 86400.0
_CENTURY = 100 * JULIAN_YEAR
_DEGREE = np.pi / 180.0
_ORBIT_TOLERANCE = 1e-8  # of the distance, of the tabulated orbits: REBOUND's own are to round-off
_ORDER = 2

# Delaunay's l, l', F, D and the node at J2000 (degrees) and their rates (arc seconds a century): Simon et al. 1994,
# A&A 282, 663, as in IERS TN 36, (5.43).
_ARGUMENTS = np.array([134.96340251, 357.52910918, 93.27209062, 297.85019547, 125.04455501]) * _DEGREE
_ARGUMENT_RATES = (
    np.array([1717915923.2178, 129596581.0481, 1739527262.8478, 1602961601.2090, -6962890.5431]) * ARCSECOND / _CENTURY
)
# Their multiples in the largest terms of nutation, the node's first: Seidelmann 1982, Celest. Mech. 27, 79 (IAU 1980).
_EARTH_TERMS = np.array([
    (0, 0, 0, 0, 1), (0, 0, 2, -2, 2), (0, 0, 2, 0, 2), (0, 0, 0, 0, 2), (0, 1, 0, 0, 0), (1, 0, 0, 0, 0),
    (0, 1, 2, -2, 2), (0, 0, 2, 0, 1), (1, 0, 2, 0, 2), (0, -1, 2, -2, 2), (-1, 0, 0, 2, 0), (0, 0, 2, -2, 1),
    (-1, 0, 2, 0, 2), (1, 0, 0, 0, 1), (0, 0, 0, 2, 0), (-1, 0, 2, 2, 2), (-1, 0, 0, 0, 1), (1, 0, 2, 0, 1),
    (-2, 0, 2, 0, 1), (0, 0, 2, 2, 2), (2, 0, 2, 0, 2), (2, 0, 0, 0, 0), (1, 0, 2, -2, 2), (0, 0, 2, 0, 0),
    (0, 0, 2, -2, 0), (-1, 0, 2, 0, 1), (0, 2, 0, 0, 0), (0, 2, 2, -2, 2), (-1, 0, 0, 2, 1), (0, 1, 0, 0, 1),
    (1, 0, 0, -2, 1), (0, -1, 0, 0, 1),
])  # fmt: skip
_NODE_TURNS = 4  # of the Moon's node, 18.6 years each, in the record of the Earth
# The mean pole of Mars at J2000, right ascension and declination in degrees: Archinal et al. 2018, CMDA 130, 22.
_MARS_POLE = np.array([317.681429, 52.886509]) * _DEGREE
_MARS_YEAR = 686.979852 * DAY  # sidereal; Simon et al. 1994
_MARS_YEARS, _MARS_HARMONICS = 20, 6


class Planet(NamedTuple):
    """A planet that turns, SI: others are relative to it, in axes in which its pole is (0, sin, cos)(obliquity).

    orbit: GM of the Sun, mean semi-major axis and eccentricity. axes (3, 3): those axes as rows in ICRF axes. kernels:
    of SPICE, whose orbits the others follow; none: REBOUND's. parts: names of the bodies whose torque is looked at
    alone; frequencies and phases (J,) of the terms of its motion; span: the length of time in which they are separated
    well; every: time between records.
    """

    name: str
    ellipticity: float
    spin_rate: float
    obliquity: float
    parameter: float
    orbit: tuple[float, float, float]
    others: Mapping[str, j2000.State]
    parts: Mapping[str, tuple[str, ...]]
    frequencies: np.ndarray
    phases: np.ndarray
    span: float
    every: float
    axes: np.ndarray
    kernels: spice.Kernels


def earth(kernels: spice.Kernels = ()) -> Planet:
    """The Earth, on the mean ecliptic and equinox of J2000, with the H of the IERS.

    kernels: of SPICE; what they have of pole, spin and orbits takes the place of the tables'.

    >>> print(f"{np.degrees(earth().obliquity):.2f}")
    23.44
    """
    return _planet(
        "Earth",
        kernels,
        pole=np.array([0.0, 0.0, 1.0]),
        normal=j2000.ecliptic_axes()[2],
        ellipticity=body("Earth").value("dynamical_ellipticity"),
        parameter=j2000.EARTH_PARAMETER,
        frequencies=_EARTH_TERMS @ _ARGUMENT_RATES,
        phases=_EARTH_TERMS @ _ARGUMENTS,
        span=_NODE_TURNS * 2 * np.pi / abs(_ARGUMENT_RATES[-1]),
        every=5 * DAY,
    )


def mars(kernels: spice.Kernels = ()) -> Planet:
    """Mars, on its own orbit of J2000, with the published J2 and C/(M a^2), both for the radius of J2.

    kernels: as for `earth`.

    >>> print(f"{mars().ellipticity:.5f}")  # J2 over C/(M a^2)
    0.00537
    """
    planet = body("Mars")
    ratio = planet.adopted("polar_moment_ratio")
    right_ascension, declination = _MARS_POLE
    return _planet(
        "Mars",
        kernels,
        pole=np.array([
            np.cos(declination) * np.cos(right_ascension), np.cos(declination) * np.sin(right_ascension),
            np.sin(declination),
        ]),
        ellipticity=planet.zonal_harmonic(ratio.radius) / ratio.value,
        parameter=planet.gravitational_parameter,
        frequencies=2 * np.pi / _MARS_YEAR * np.arange(1, 1 + _MARS_HARMONICS),
        phases=np.zeros(_MARS_HARMONICS),
        span=_MARS_YEARS * _MARS_YEAR,
        every=10 * DAY,
    )  # fmt: skip


PLANETS = {"Earth": earth, "Mars": mars}


def _planet(
    name: str, kernels: spice.Kernels, pole: np.ndarray, normal: np.ndarray | None = None, **own: Any
) -> Planet:
    """A planet with that pole, in ICRF axes, or that of kernels; normal: of the fixed orbit, its own unless given."""
    spin_rate = body(name).angular_velocity
    if kernels and spice.has_orientation(kernels, name):
        turning = spice.orientation(kernels, name)
        pole, spin_rate = turning.pole, turning.spin_rate
    others, orbit_kernels = _others(name, kernels)
    sun, mean = others["Sun"], mean_companions(name)[0]
    axes, obliquity = _axes_between(pole, np.cross(sun.position, sun.velocity) if normal is None else normal)
    return Planet(
        name=name,
        spin_rate=spin_rate,
        obliquity=obliquity,
        orbit=(sun.gravitational_parameter, quantity(mean["semi_major_axis"], "length"), float(mean["eccentricity"])),
        others={
            other: j2000.State(one.gravitational_parameter, axes @ one.position, axes @ one.velocity)
            for other, one in others.items()
        },
        parts={one: (one,) for one in ("Sun", "Moon") if one in others}
        | {"planets": tuple(set(others) - {"Sun", "Moon"})},
        axes=axes,
        kernels=orbit_kernels,
        **own,
    )


def orbits(planet: Planet, span: float) -> Ephemeris:
    """Orbits relative to the planet over a time span (s) with J2000 in its middle; masses are GM, in m3 s-2."""
    if planet.kernels:
        masses = {name: one.gravitational_parameter for name, one in planet.others.items()}
        return spice.orbits(
            planet.kernels, planet.name, masses, (-0.5 * span, 0.5 * span), planet.axes, _ORBIT_TOLERANCE
        )
    others = [
        Companion(name, one.gravitational_parameter, position=tuple(one.position), velocity=tuple(one.velocity))
        for name, one in planet.others.items()
    ]
    bodies = simulation(planet.parameter, others)
    bodies.integrate(-0.5 * span)
    return ephemeris(bodies, 0.5 * span, _ORBIT_TOLERANCE)


def torque_of(orbits: Ephemeris, names: tuple[str, ...]) -> Ephemeris:
    """The same orbits, on which only bodies of these names exert a torque."""
    return replace(orbits, mass=np.where(np.isin(orbits.names, names), orbits.mass, 0.0))


def axis_history(
    planet: Planet, orbits: Ephemeris, obliquity: float, steps_per_day: int
) -> tuple[np.ndarray, np.ndarray]:
    """Times (N,), s from J2000, and directions of the angular momentum (N, 3), which begins along the axis of C.

    At time 0 it is (0, sin, cos)(obliquity). Between the kicks by the torques the free rotation is exact.
    Runs under jax.enable_x64.
    """
    moments = np.array([1 - planet.ellipticity, 1 - planet.ellipticity, 1.0])
    # As arrays of JAX at once: the table of the orbits is not copied for each call.
    turning = jax.tree.map(
        jnp.asarray, rigid.body(planet.parameter, moments, effects=(GravityGradient(),), companions=orbits)
    )
    axis = np.array([0.0, np.sin(obliquity), np.cos(obliquity)])
    node = np.array([1.0, 0.0, 0.0])
    attitude = quaternion(np.array([node, np.cross(axis, node), axis]))
    count = int(float(orbits.end) / planet.every)
    steps = round(planet.every / DAY * steps_per_day)
    histories = []
    for direction in (-1, 1):
        times = direction * planet.every * np.arange(count + 1)
        state = splitting.rotor(attitude, np.array([0.0, 0.0, planet.spin_rate]), jnp.zeros(1))
        momenta = np.asarray(_momenta(state, turning, times, steps))
        histories.append((times, np.concatenate([[planet.spin_rate * axis], momenta])))
    (past, before), (future, after) = histories
    momenta = np.concatenate([before[:0:-1], after])
    return np.concatenate([past[:0:-1], future]), momenta / np.linalg.norm(momenta, axis=1, keepdims=True)


def _axes_between(pole: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, float]:
    """Axes (3, 3) as rows, x the node of the equator on the plane of a normal and z the normal; and the obliquity."""
    normal = normal / np.linalg.norm(normal)
    node = np.cross(pole, normal)
    tilt = np.arctan2(np.linalg.norm(node), pole @ normal)
    node /= np.linalg.norm(node)
    return np.array([node, np.cross(normal, node), normal]), float(tilt)


def _others(name: str, kernels: spice.Kernels) -> tuple[dict[str, j2000.State], spice.Kernels]:
    """All others at J2000 in ICRF axes, and the kernels where these have the orbits."""
    others = j2000.states(name, np.eye(3))
    if not (kernels and spice.has_orbits(kernels)):
        return others, ()
    return {
        other: j2000.State(one.gravitational_parameter, *spice.state(kernels, other, name))
        for other, one in others.items()
    }, kernels


@brief
def _momenta(state: splitting.Rotor, turning: rigid.Rigid, times: jax.Array, steps: int) -> jax.Array:
    """Angular momenta (N - 1, 3) at times (N,) but the first, which is that of the state; so many steps between two."""

    def later(state: splitting.Rotor, span: tuple[jax.Array, jax.Array]) -> tuple:
        state = splitting.advance(
            state, turning.rates, *span, steps, _ORDER, turning, rigid.kick, known=rigid.known_orbits
        )
        return state, state.angular_momentum.value

    return jax.lax.scan(later, state, (times[:-1], times[1:]))[1]
