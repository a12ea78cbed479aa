"""How long a step may be beside point masses: they turn what is near them, and they pass it."""

from typing import Any

from astroinertia.gravity.point_masses import NEVER, orbital_time

Array = Any
UNNOTICED = 1e-3  # of the speed of sound: a pass that changes a velocity by less need not be resolved


def time_beside(xp: Any, fluid: Any, mass: Array, place: Array, velocity: Array, softening_squared: Array) -> Array:
    """The shorter of the orbital time and the time of a pass, of each particle by the point it is shortest for, (N,).

    A point at the distance d that passes a particle with the relative velocity w takes (d^2 + s^2)^(1/2)/w to do so.
    On a straight line it comes as near as b = |d x w|/w, or is there already and goes away, and changes the particle's
    velocity by M/(b w) or so (Binney & Tremaine 2008, eq. 1.30). Where that is below UNNOTICED of the sound speed, the
    time is longer by as much: no step gives a particle more than that share. Masses (n,), places and velocities (n, 3)
    in the frame of the fluid. Test: tests/unit/effects/test_passes.py.
    """
    rate = xp.zeros(fluid.position.shape[0])
    for k in range(mass.shape[0]):
        away, relative = fluid.position - place[k], fluid.velocity - velocity[k]
        squared = xp.sum(away**2, axis=1) + softening_squared
        speed_squared = xp.sum(relative**2, axis=1)
        approach = xp.minimum(xp.sum(away * relative, axis=1), 0.0)
        moment = xp.maximum(squared * speed_squared - approach**2, 0.0)  # (b w)^2
        strength = mass[k] ** 2
        unnoticed = xp.maximum(strength, (UNNOTICED * fluid.sound_speed) ** 2 * moment)
        rate = xp.maximum(rate, speed_squared / squared * strength / (unnoticed + NEVER))
    orbital = orbital_time(xp, fluid.position, mass, place, softening_squared)
    return xp.minimum(orbital, 1.0 / xp.sqrt(rate + NEVER))
