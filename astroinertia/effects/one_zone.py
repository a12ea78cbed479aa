"""A body as one zone that keeps its profile: how its size goes by the scalar virial theorem, with or without a force.

    tr(Q) s s'' = 2 T/s^2 - |W|/s + 3 Pi s^-(3 (gamma - 1)) - tr(Q) k s^2,    x = s(t) x_0

(Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, section 14). A rough but cheap answer to what happens when a
force is left out: small differences grow as they do in a collapse. models/scaling/homology solves the same equation to
round-off, for runs. Tests: tests/unit/effects/test_sizes.py.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

SMALLEST, LARGEST = 1e-3, 1e3  # of the size at first: what is smaller has fallen together, what is larger is gone
LONGEST = 15.0  # 1/frequency: what is slower than that is followed by what it does until then
PULSATING = 60.0  # 1/frequency: what pulsates for longer goes on alike
FASTER = 100.0  # times as fast may the motion with other forces be, before what is followed is shortened for it
MOMENTS = 400  # of a run or of a motion, at which it is looked at


@dataclass(frozen=True)
class Zone:
    """|W|, 3 Pi and 2 T over tr(Q) at first (inverse squares of times), the exponent gamma, the rate of growth, and the
    pull k of a given field over the distance.
    """

    weight: float
    pressure: float
    turning: float
    gamma: float
    expansion: float = 0.0
    field: float = 0.0

    @property
    def frequency(self) -> float:
        """The square root of the largest of the forces, and of the motion at first."""
        return math.sqrt(max(self.weight, self.pressure, self.turning, abs(self.field), self.expansion**2))

    @property
    def imbalance(self) -> float:
        """The sum of the forces over the largest of them; 0 in equilibrium."""
        largest = max(self.weight, self.pressure, self.turning, abs(self.field))
        return abs(self.force(1.0)) / largest if largest > 0.0 else 0.0

    @property
    def escapes(self) -> bool:
        """Whether it can grow without end: by its energy, or as a field or a gas of one temperature drives it out."""
        if self.field != 0.0 or (self.pressure > 0.0 and self.gamma <= 1.0):
            return self.field <= 0.0
        pressing = self.pressure / (3.0 * (self.gamma - 1.0)) if self.pressure > 0.0 else 0.0
        return 0.5 * (self.expansion**2 + self.turning) + pressing >= self.weight

    def force(self, size: Any) -> Any:
        """s'' at a size s."""
        pushing = self.turning / size**3 + self.pressure * size ** (2.0 - 3.0 * self.gamma)
        return pushing - self.weight / size**2 - self.field * size

    def stiffness(self, size: Any) -> Any:
        """-ds''/ds at a size s: the square of the rate at which small changes of it swing."""
        pushing = 3.0 * self.turning / size**4
        pushing = pushing + (3.0 * self.gamma - 2.0) * self.pressure * size ** (1.0 - 3.0 * self.gamma)
        return pushing - 2.0 * self.weight / size**3 + self.field


@dataclass(frozen=True)
class Motion:
    """Times, sizes and speeds of one zone until the end, or until it has fallen together or is gone."""

    time: np.ndarray
    size: np.ndarray
    speed: np.ndarray


def motion(zone: Zone, end: float) -> Motion:
    """The zone from size 1 until `end`."""
    # In the zone's own time, so that errors mean the same at any rate.
    rate = zone.frequency or 1.0
    forces = {name: getattr(zone, name) / rate / rate for name in ("weight", "pressure", "turning", "field")}
    own = replace(zone, **forces)

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        return np.array([state[1], own.force(max(state[0], 0.1 * SMALLEST))])

    def small(_: float, state: np.ndarray) -> float:
        return state[0] - SMALLEST

    def large(_: float, state: np.ndarray) -> float:
        return state[0] - LARGEST

    small.terminal = large.terminal = True
    from scipy.integrate import solve_ivp  # only here: the table of effects need not wait for it

    solution = solve_ivp(
        slope,
        (0.0, rate * end),
        [1.0, zone.expansion / rate],
        "DOP853",
        np.linspace(0.0, rate * end, MOMENTS),
        rtol=1e-10,
        atol=1e-13,
        events=(small, large),
    )
    return Motion(solution.t / rate, solution.y[0], rate * solution.y[1])


def spread(end: float) -> np.ndarray:
    """Times (MOMENTS,) from 0 to almost `end` that keep no time with orbits or pulsations of any period.

    In equal parts, at the fractions n^2 g of them, g of the golden ratio: squares are spread evenly, too (Weyl 1916,
    Math. Ann. 77, 313), while n g itself keeps time with 1964 turns, and others, whose phases it finds all alike.
    Units are those of `end`.

    >>> times = spread(400.0)  # a part is 1
    >>> print(times[:4].round(3), abs(np.cos(2.0 * math.pi * 4.91 * times).mean()) < 0.1)
    [0.    1.618 2.472 3.562] True
    """
    number = np.arange(MOMENTS)
    return end / MOMENTS * (number + number**2 * (0.5 * (math.sqrt(5.0) - 1.0)) % 1.0)


def lasting(zone: Zone, end: float) -> Motion:
    """The same for a run of any length: what pulsates for longer than PULSATING goes on as it did until then."""
    until = PULSATING / zone.frequency if zone.frequency > 0.0 else end
    path = motion(zone, min(end, until))
    if end <= until or zone.escapes or path.time[-1] < until * (1.0 - 1e-9):
        return path
    times = np.append(spread(end)[:-1], end)
    at = times % until
    return Motion(times, np.interp(at, path.time, path.size), np.interp(at, path.time, path.speed))


def difference(zone: Zone, end: float, **forces: float) -> float:
    """By what part s^2, and with it I, would differ at the end with these forces instead; 1 is all there is.

    Where the run is longer than the motion is followed, small differences go on growing as they did, in proportion.
    """
    other = replace(zone, **forces)
    until = min(_followed(zone, end), FASTER * _followed(other, end))
    with_it, without = motion(zone, until), motion(other, until)
    last = with_it.time[-1]
    if without.time[-1] < last * (1.0 - 1e-9) or (last < until * (1.0 - 1e-9) and with_it.speed[-1] < 0.0):
        return 1.0  # without it the body falls together, or is gone; or it falls so far that all counts
    sizes = [np.interp(with_it.time, path.time, path.size) for path in (with_it, without)]
    apart = float(np.max(np.abs((sizes[1] / sizes[0]) ** 2 - 1.0)))
    return min(1.0, apart * end / until)


def braked(zone: Zone, end: float) -> float:
    """The speed, in initial sizes over time, that a fall has lost again to what brakes it; 0 where it goes on."""
    until = _followed(zone, end)
    fall = motion(zone, until)
    inward = np.maximum(-fall.speed, 0.0)
    if fall.time[-1] < until * (1.0 - 1e-9) and inward[-1] > 0.0 and zone.pressure > 0.0:
        return float(inward[-1])  # it is braked beyond what is followed
    return float(np.max(np.maximum.accumulate(inward) - inward, initial=0.0))


def _followed(zone: Zone, end: float) -> float:
    return min(end, LONGEST / zone.frequency) if zone.frequency > 0.0 else end
