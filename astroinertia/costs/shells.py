"""A body that falls together, as spherical shells: what one sphere that stays similar to itself misses.

Shells of gas under gravity and pressure, with the viscosity of von Neumann & Richtmyer (1950, J. Appl. Phys. 21, 232),
which stops and heats what falls in; pressure follows the exponent of the matter, above nuclear density that of stiff
matter. What is followed serves to count steps (costs.course), and nothing else. Tests: tests/unit/costs/test_costs.py.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from astroinertia.costs.signals import LEAST as STILL, fastest
from astroinertia.effects.kinds.viscosity import agreement
from astroinertia.effects.one_zone import Zone

SHELLS = 40
MOST_STEPS = 12_000  # some 0.6 s of processor time; the collapses of sims/ need up to 7,200
EVERY = 10  # steps, after which the shells are noted
COURANT = 0.3
PULLED = 0.05  # of the time in which an edge would be pulled to the centre
SQUEEZED = 1.01  # by which the exponent of the pressure is found
FARTHEST = 1e30  # of the first size, and its inverse: powers of it are still numbers
# Of the weight of shells, what rotation carries at most: 2 T/|W| of the Maclaurin spheroid that becomes a bar in its
# dynamical time (Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, section 33).
BARRED = 2.0 * 0.2738
# Of the largest force: by how much the inner half may be pushed otherwise than the whole. Of bodies of sims/ that keep
# their profiles it is within 0.16, of a gas of one temperature 0.8.
UNEVEN = 0.2
LEAST = 1e-300  # of what something is divided by
QUADRATIC, LINEAR = 1.0, 0.3  # viscosity, in squares of what a shell is crossed by, and in sound


@dataclass(frozen=True)
class Shells:
    """A body at first: masses (K,), radii (K,) of the outer edges and pressures (K,) of shells; G = 1.

    gamma: exponent of the pressure at first; pieces: densities, rising, and the exponents above each; thermal: exponent
    of heat from shocks, None where matter is not heated. turning (K,): square of the specific angular momentum. sink:
    density from which on what comes within a radius is gone. further: what effects add to the pressure at densities.
    weight: of all, over that by Newton's gravity. expansion: the rate at which all grow. field: what given fields pull
    inwards at radii.
    """

    mass: np.ndarray
    radius: np.ndarray
    pressure: np.ndarray
    gamma: float
    pieces: tuple[tuple[float, float], ...]
    thermal: float | None
    turning: np.ndarray
    sink: tuple[float, float] | None = None
    further: Callable[[np.ndarray], np.ndarray] | None = None
    weight: float = 1.0
    expansion: float = 0.0
    field: Callable[[np.ndarray], np.ndarray] | None = None

    @property
    def density(self) -> np.ndarray:
        """Of the shells, (K,)."""
        return self.mass / _volumes(self.radius)

    @property
    def sound(self) -> np.ndarray:
        """Its speed in them, (K,)."""
        pressure, exponent = _cold(self, self.density, self.density)
        return np.sqrt(exponent * pressure / self.density)

    @property
    def zone(self) -> Zone:
        """The whole as one zone: as the edges carry their masses, without any error in balance."""
        carried, edges = _carried(self.mass), self.radius
        second = float(carried @ edges**2)
        weight = self.weight * float(carried @ (np.cumsum(self.mass) / edges))
        if self.field is not None:
            weight += float(carried @ (self.field(edges) * edges))
        turning = float(carried @ (self.turning / edges**2))
        triple, gamma = self._triple_pressure(1.0), self.gamma
        beyond = self.density.max() > min((dense for dense, _ in self.pieces), default=math.inf)
        if triple > 0.0 and (self.further is not None or beyond):
            gamma = math.log(self._triple_pressure(SQUEEZED) / triple) / math.log(SQUEEZED) + 1.0
        return Zone(weight / second, triple / second, turning / second, gamma, self.expansion)

    @property
    def evenly_driven(self) -> bool:
        """Whether the inner half of the mass is pushed as the whole is: a gas of even pressure swells at its surface
        alone, and falls within. Where pressure exceeds the weight, the inside swells before it has fallen.
        """
        zone, carried, edges = self.zone, _carried(self.mass), self.radius
        push = _pushes(self.pressure, edges, carried) - self.weight * np.cumsum(self.mass) / edges**2
        push = push + self.turning / edges**3
        inner = np.cumsum(self.mass) < 0.5 * self.mass.sum()
        second = float(carried[inner] @ edges[inner] ** 2)
        apart = abs(float((carried * push)[inner] @ edges[inner]) / second - zone.force(1.0))
        return zone.pressure >= zone.weight or apart <= UNEVEN * zone.frequency**2

    def _triple_pressure(self, denser: float) -> float:
        """3 Pi, three times the volume integral of the pressure, were all of them so many times denser."""
        pressure = _cold(self, self.density, denser * self.density)[0]
        return 3.0 * float(pressure @ _volumes(self.radius)) / denser


@dataclass(frozen=True)
class Moment:
    """Shells at one time: density and sound speed (K,); radius, speed and acceleration (K,) of their outer edges."""

    time: float
    density: np.ndarray
    sound: np.ndarray
    radius: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """Radii (K,) half-way between the edges of each."""
        return self.radius - 0.5 * _differences(self.radius)


def followed(shells: Shells, end: float) -> list[Moment]:
    """The shells to the end, or to where so many steps have brought them."""
    mass, carried = shells.mass, _carried(shells.mass)
    weighs = shells.weight * np.cumsum(mass)  # within each
    edges, speed, heat, time = shells.radius, shells.expansion * shells.radius, np.zeros(len(mass)), 0.0
    volumes = _volumes(edges)
    first = mass / volumes
    opens, within = shells.sink or (math.inf, 0.0)
    turning = shells.turning
    moments: list[Moment] = []
    for step in range(MOST_STEPS):
        if (gone := int((edges < within).sum())) and (len(mass) < len(weighs) or (mass / volumes).max() > opens):
            if gone == len(mass):
                break
            edges, speed, heat, first, mass, turning = (a[gone:] for a in (edges, speed, heat, first, mass, turning))
            shells, carried = replace(shells, pressure=shells.pressure[gone:]), _carried(mass)
            volumes = _volumes(edges)
        density = mass / volumes
        cold, stiffness = _cold(shells, first, density)
        thermal = 0.0 if shells.thermal is None else (shells.thermal - 1.0) * density * heat
        pressure = cold + thermal
        sound = np.sqrt((stiffness * cold + (shells.thermal or 0.0) * thermal) / density)
        width, jump = _differences(edges), _differences(speed)
        squeezed = np.maximum(-jump, 0.0)
        viscous = density * squeezed * (QUADRATIC * squeezed + LINEAR * sound)
        total = pressure + viscous
        push = _pushes(total, edges, carried)
        acceleration = push - weighs[-len(mass) :] / edges**2 + turning / edges**3
        if shells.field is not None:
            acceleration = acceleration - shells.field(edges)
        if step % EVERY == 0 or time >= end:
            moments.append(Moment(time, density, sound, edges, speed, acceleration))
        if time >= end:
            break
        crossed = width / (sound + 4.0 * squeezed + np.abs(jump) + LEAST)
        pulled = np.sqrt(edges / np.maximum(np.abs(acceleration), LEAST))
        dt = min(end - time, COURANT * float(crossed.min()), PULLED * float(pulled.min()))
        speed = speed + dt * acceleration
        turning, brought = _with_bars(turning, carried, edges, weighs[-len(mass) :], dt)
        before = 1.0 / density
        edges = edges + dt * speed
        volumes = _volumes(edges)
        least, most = shells.radius[0] / FARTHEST, shells.radius[-1] * FARTHEST
        if not (_differences(edges) > 0.0).all() or edges[0] < least or edges[-1] > most:
            break
        if shells.thermal is not None:
            heat = np.maximum(heat + brought - (thermal + viscous) * (volumes / mass - before), 0.0)
        time += dt
    return moments


def _with_bars(
    turning: np.ndarray, carried: np.ndarray, edges: np.ndarray, weighs: np.ndarray, dt: float
) -> tuple[np.ndarray, np.ndarray | float]:
    """The squares (K,) of the specific angular momentum after a time, in which bars have carried it outwards, and the
    specific energy (K,) of rotation that is heat then.

    Shells that turn faster than BARRED become bars at the rate (Omega^2 - Omega_c^2)^(1/2), but no faster than gravity
    acts, and their torques hand angular momentum on to the next shell as fast; the outermost keeps what it gets.
    """
    excess = 1.5 * (turning / edges - BARRED * weighs)  # about the axis Omega^2 is 3/2 of the mean of j^2/r^4
    excess = np.minimum(excess, weighs)
    if not (excess > 0.0).any():
        return turning, 0.0
    momentum = np.sqrt(turning)
    lost = -np.expm1(-dt * np.sqrt(np.maximum(excess, 0.0) / edges**3)) * momentum
    lost[-1] = 0.0
    momentum = momentum - lost
    momentum[1:] += (carried * lost)[:-1] / carried[1:]
    spin = momentum / edges**2
    return momentum**2, lost * np.maximum(spin - np.append(spin[1:], 0.0), 0.0)


def signals(moment: Moment, reach: np.ndarray, viscosity: Mapping[str, Any] | None, alpha: np.ndarray) -> np.ndarray:
    """The fastest signal (K,) of particles in the shells with their neighbours along the radius, beyond the centre, and
    at the same radius. reach (K,): of the kernel; alpha (K,): the strength of viscosity.

    Particles are neighbours where one reaches the other: those of a shocked core see what falls in from afar.
    """
    middle = moment.middle
    line, flow = (np.concatenate([-a[::-1], [0.0], a]) for a in (moment.radius, moment.speed))
    speed = np.interp(middle, line, flow)
    gradient = (np.interp(middle + reach, line, flow) - np.interp(middle - reach, line, flow)) / (2.0 * reach)
    across = speed / middle * reach
    fast = np.maximum(fastest(across, moment.sound, viscosity, alpha, across), moment.sound)
    sound, strength = (0.5 * (a[:, None] + a) for a in (moment.sound, alpha))
    for side in (-1.0, 1.0):
        apart = side * middle - middle[:, None]
        rate = np.sign(apart) * (side * speed - speed[:, None])
        mine, other = gradient[:, None] * abs(apart), gradient * abs(apart)
        signal = fastest(rate, sound, viscosity, strength, 0.5 * (mine + other), agreement(np, mine, other))
        seen = abs(apart) < np.maximum(reach[:, None], reach)
        fast = np.maximum(fast, np.where(seen, signal, 0.0).max(axis=1))
    return fast


def steepening(moment: Moment, reach: np.ndarray) -> np.ndarray:
    """What viscosity's switch answers to, (K,): -reach^2 d(div v)/dt over c^2 (effects.kinds.viscosity)."""
    edge, speed = moment.radius, moment.speed
    of_push = 4.0 * math.pi * _differences(edge**2 * moment.acceleration) / _volumes(edge)
    along, across = _differences(speed) / _differences(edge), speed / edge
    return np.maximum(along**2 + 2.0 * across**2 - of_push, 0.0) * (reach / np.maximum(moment.sound, STILL)) ** 2


def in_balance(mass: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """The pressures (K,) that hold shells of those masses, with those outer edges."""
    weight = _carried(mass) * np.cumsum(mass) / (4.0 * math.pi * radius**4)
    return weight[::-1].cumsum()[::-1]


def _pushes(pressure: np.ndarray, edges: np.ndarray, carried: np.ndarray) -> np.ndarray:
    """The outward accelerations (K,) of edges that carry those masses, between shells at pressures (K,)."""
    return 4.0 * math.pi * edges**2 * (pressure - np.append(pressure[1:], 0.0)) / carried


def _carried(mass: np.ndarray) -> np.ndarray:
    """By each edge: half of the shells on either side."""
    return 0.5 * (mass + np.append(mass[1:], 0.0))


def _differences(at_edges: np.ndarray) -> np.ndarray:
    """Of each edge and the one within, the first from 0: np.diff with 0 before, in a fourth of its time."""
    differences = at_edges.copy()
    differences[1:] -= at_edges[:-1]
    return differences


def _volumes(edges: np.ndarray) -> np.ndarray:
    return 4.0 / 3.0 * math.pi * _differences(edges**3)


def _cold(shells: Shells, first: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The pressure without heat of shocks, and the exponent of the equation of state's."""
    pressure = shells.pressure * (density / first) ** shells.gamma
    exponent = np.full_like(density, shells.gamma)
    below = shells.gamma
    for beyond, gamma in shells.pieces:
        over = np.maximum(density / beyond, 1.0)
        pressure = pressure * over ** (gamma - below)
        exponent = np.where(over > 1.0, gamma, exponent)
        below = gamma
    if shells.further is not None:
        pressure = pressure + shells.further(density)
    return pressure, exponent
