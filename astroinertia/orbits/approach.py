"""How near companions come to a body on the orbits about it that they begin with.

Plain arrays of code units, and no REBOUND.
"""

import math

import numpy as np

from astroinertia.orbits.kepler import time_from_pericentre

_INSIDE = 1.0 - 1e-9  # of the radius: an orbit that grazes the body does not come within by a rounding
_APART = 2.0  # times S is D at least where the torque has a bound: nearer by, a mass may pass the orbit closely
_PULL = 6.0  # times m S^2/D^3 at most is the torque per mass on an orbit that reaches S, of a mass m at such a D


def pericentres_within(
    masses: np.ndarray, place: np.ndarray, velocity: np.ndarray, radius: float, end: float
) -> np.ndarray:
    """Distances (N,) of pericentres of companions that come from outside within `radius` before `end`; NaN of others.

    masses (N + 1,), of the body and its companions; place and velocity (N, 3) of these relative to the body; G is 1.
    Two-body orbits, and only those that the pull of the other companions cannot lift off the body until then, all of
    which stay twice as far out.
    """
    total = masses[0] + masses[1:]
    distance = np.linalg.norm(place, axis=1)
    turning = np.linalg.norm(np.cross(place, velocity), axis=1)
    energy = 0.5 * np.sum(velocity**2, axis=1) - total / distance
    inward = np.sum(place * velocity, axis=1) < 0.0
    orbits = zip(total, energy, turning, strict=True)
    nearest = np.array([_conic(*orbit)[0] if orbit[0] > 0.0 else math.nan for orbit in orbits])  # none without a mass
    found = np.full(len(total), math.nan)
    for k in np.flatnonzero((nearest < _INSIDE * radius) & (distance >= radius)):
        time, farthest = _way_in(total[k], energy[k], turning[k], distance[k], bool(inward[k]), radius)
        if not time <= end:
            continue
        others = (np.arange(len(total)) != k) & (masses[1:] > 0.0)
        least = np.fmax(np.where(np.isnan(nearest), distance, nearest), radius)[others]
        if np.any(least < _APART * farthest):
            continue
        torque = _PULL * farthest**2 * np.sum(masses[1:][others] / least**3)
        if _conic(total[k], energy[k], turning[k] + torque * time)[0] < _INSIDE * radius:
            found[k] = nearest[k]
    return found


def _conic(mass: float, energy: float, turning: float) -> tuple[float, float]:
    """Pericentre and eccentricity of an orbit of that energy and angular momentum per mass."""
    parameter = turning**2 / mass
    eccentricity = math.sqrt(max(0.0, 1.0 + 2.0 * energy * parameter / mass))
    return parameter / (1.0 + eccentricity), eccentricity


def _way_in(
    mass: float, energy: float, turning: float, distance: float, inward: bool, radius: float
) -> tuple[float, float]:
    """The time until a companion outside comes within the radius, infinite if never, and how far out it is before."""
    nearest = max(_conic(mass, energy, turning)[0], 1e-9 * distance)  # a fall along a line is an orbit that is narrow
    eccentricity = 1.0 + 2.0 * energy * nearest / mass
    unit = math.sqrt(nearest**3 / mass)
    here, there = (float(time_from_pericentre(np, np.float64(r / nearest), eccentricity)) for r in (distance, radius))
    if inward:
        return unit * (here - there), distance
    if energy >= 0.0:
        return math.inf, math.inf
    period = 2.0 * math.pi / (1.0 - eccentricity) ** 1.5
    return unit * (period - here - there), nearest * (1.0 + eccentricity) / (1.0 - eccentricity)
