"""A body that falls together, as spherical shells of equal mass: what one sphere that stays similar to itself misses.

Shells of gas under gravity and pressure, with the viscosity of von Neumann & Richtmyer (1950, J. Appl. Phys. 21, 232),
which stops and heats what falls in; pressure follows the exponent of the matter, above nuclear density that of stiff
matter. What is followed serves to count steps (costs.course), and nothing else. Tests: tests/unit/costs/test_costs.py.
"""

import math
from dataclasses import dataclass

import numpy as np

SHELLS = 40
MOST_STEPS = 40_000  # a second of processor time
EVERY = 10  # steps, after which the shells are noted
COURANT = 0.3
PULLED = 0.05  # of the time in which an edge would be pulled to the centre
LEAST = 1e-300  # of what something is divided by
QUADRATIC, LINEAR = 1.0, 0.3  # viscosity, in squares of what a shell is crossed by, and in sound


@dataclass(frozen=True)
class Shells:
    """A body at rest: radii (K,) of the outer edges of shells of one mass each, and their pressures (K,); G = 1.

    gamma: exponent of the pressure; stiff: density and exponent of stiff matter, if the matter has such; thermal:
    exponent of heat from shocks, None where matter is not heated. turning (K,): square of the specific angular
    momentum.
    """

    mass: float
    radius: np.ndarray
    pressure: np.ndarray
    gamma: float
    stiff: tuple[float, float] | None
    thermal: float | None
    turning: np.ndarray


@dataclass(frozen=True)
class Moment:
    """Shells (K,) at one time: density, sound speed, rate of compression, acceleration; whether shocks heated them."""

    time: float
    density: np.ndarray
    sound: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    shocked: np.ndarray


def followed(shells: Shells, end: float) -> list[Moment]:
    """The shells from rest to the end, or to where so many steps have brought them."""
    count = len(shells.radius)
    mass, enclosed = shells.mass, shells.mass * np.arange(1, count + 1)
    carried = np.full(count, mass)  # by each edge: half of the shells on either side
    carried[-1] = 0.5 * mass
    edges, speed, heat, time = shells.radius.copy(), np.zeros(count), np.zeros(count), 0.0
    first = mass / _volumes(edges)
    moments: list[Moment] = []
    for step in range(MOST_STEPS):
        density = mass / _volumes(edges)
        cold, stiffness = _cold(shells, first, density)
        thermal = 0.0 if shells.thermal is None else (shells.thermal - 1.0) * density * heat
        pressure = cold + thermal
        sound = np.sqrt((stiffness * cold + (shells.thermal or 0.0) * thermal) / density)
        width, jump = np.diff(edges, prepend=0.0), np.diff(speed, prepend=0.0)
        squeezed = np.maximum(-jump, 0.0)
        viscous = density * squeezed * (QUADRATIC * squeezed + LINEAR * sound)
        total = pressure + viscous
        push = 4.0 * math.pi * edges**2 * (total - np.append(total[1:], 0.0)) / carried
        acceleration = push - enclosed / edges**2 + shells.turning / edges**3
        if step % EVERY == 0 or time >= end:
            shocked = heat * density > 0.1 * cold
            moments.append(Moment(time, density, sound, np.abs(jump) / width, np.abs(acceleration), shocked))
        if time >= end:
            break
        crossed = width / (sound + 4.0 * squeezed + np.abs(jump) + LEAST)
        pulled = np.sqrt(edges / np.maximum(np.abs(acceleration), LEAST))
        dt = min(end - time, COURANT * float(crossed.min()), PULLED * float(pulled.min()))
        speed = speed + dt * acceleration
        before = 1.0 / density
        edges = edges + dt * speed
        if not (np.diff(edges, prepend=0.0) > 0.0).all():
            break
        if shells.thermal is not None:
            heat = np.maximum(heat - (thermal + viscous) * (_volumes(edges) / mass - before), 0.0)
        time += dt
    return moments


def in_balance(mass: float, radius: np.ndarray) -> np.ndarray:
    """The pressures (K,) that hold shells of one mass each, with those outer edges."""
    count = len(radius)
    carried = np.full(count, mass)
    carried[-1] = 0.5 * mass
    weight = carried * mass * np.arange(1, count + 1) / (4.0 * math.pi * radius**4)
    return weight[::-1].cumsum()[::-1]


def _volumes(edges: np.ndarray) -> np.ndarray:
    return 4.0 / 3.0 * math.pi * np.diff(edges**3, prepend=0.0)


def _cold(shells: Shells, first: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The pressure without heat of shocks, and its exponent."""
    pressure = shells.pressure * (density / first) ** shells.gamma
    exponent = np.full_like(density, shells.gamma)
    if shells.stiff is not None:
        beyond, stiff = shells.stiff
        over = np.maximum(density / beyond, 1.0)
        pressure = pressure * over ** (stiff - shells.gamma)
        exponent = np.where(over > 1.0, stiff, exponent)
    return pressure, exponent
