"""How long a step may be beside point masses: they turn what is near them, and they pass it."""

from typing import Any

from astroinertia.gravity.point_masses import NEVER, UNNOTICED, orbital_time, passing_rate

Array = Any
# Over 0.3 times the distance to a point and the speed of free fall, a step that begins and ends with half a kick gains
# 12 % too much energy, over half of it 2 %; on the way out of an orbit that is lost again, but not by what is accreted.
FALLING = 0.5


def time_beside(xp: Any, fluid: Any, mass: Array, place: Array, velocity: Array, softening_squared: Array) -> Array:
    """The shorter of the orbital time and the time of a pass, of each particle by the point it is shortest for, (N,).

    A point at the distance d that passes a particle with the relative velocity w takes (d^2 + s^2)^(1/2)/w to do so.
    Where that changes the particle's velocity by less than UNNOTICED of the sound speed, the time is longer by as much:
    no step gives a particle more than that share. Masses (n,), places and velocities (n, 3) in the frame of the fluid.
    Test: tests/unit/effects/test_passes.py.
    """
    rate, noticed = xp.zeros(fluid.position.shape[0]), (UNNOTICED * fluid.sound_speed) ** 2
    for k in range(mass.shape[0]):
        away, relative = fluid.position - place[k], fluid.velocity - velocity[k]
        squared = xp.sum(away**2, axis=1) + softening_squared
        rate = xp.maximum(rate, passing_rate(xp, away, relative, squared, mass[k], noticed))
    orbital = orbital_time(xp, fluid.position, mass, place, softening_squared)
    return xp.minimum(orbital, 1.0 / xp.sqrt(rate + NEVER))


def falling_time(xp: Any, fluid: Any, mass: Array, place: Array, velocity: Array, softening_squared: Array) -> Array:
    """FALLING times the distance over the speed towards a point, of each particle that falls, (N,); long of all others.

    What is faster than the square root of two times the speed of escape passes by. Arguments as of time_beside.
    """
    rate = xp.zeros(fluid.position.shape[0])
    for k in range(mass.shape[0]):
        away, relative = fluid.position - place[k], fluid.velocity - velocity[k]
        squared = xp.sum(away**2, axis=1) + softening_squared
        falls = xp.sum(relative**2, axis=1) * xp.sqrt(squared) < 4.0 * mass[k]
        approach = -xp.sum(away * relative, axis=1) / squared
        rate = xp.maximum(rate, xp.where(falls, approach, 0.0))
    return FALLING / (rate + NEVER**0.5)
