"""Bodies that turn about a fixed axle: pendulums, Kater's gravity and the centre of percussion.

The axle is the line along `axis` (..., 3) through `pivot` (..., 3). Pure functions of numpy or jax arrays, any
consistent units but for the default of gravity, which is in m/s^2; angles in radians. Source: Goldstein, Poole & Safko
(2002), Classical Mechanics, section 5.3; Huygens (1673), Horologium Oscillatorium, part 4. Checked by
tests/unit/inertia/test_pivoted.py against the motion of a rigid body.
"""

from typing import Any

import numpy as np

from astroinertia.inertia.body import Body
from astroinertia.inertia.rolling import STANDARD_GRAVITY
from astroinertia.inertia.tensor import namespace
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import of_any_length

Array = Any

_MEANS = 10  # of the arithmetic-geometric mean: it doubles the digits each time, up to the last angle below pi


@with_quantities(pivot="m")
def pendulum_length(body: Body, pivot: Array, axis: Array = (0.0, 1.0, 0.0)) -> Array:
    """I/(m h) (...,): the length of the simple pendulum of the same period; h is from the axle to the centre of mass.

    It is also how far from the axle, on the line through the centre of mass, the centre of oscillation is: the body
    swings about it with the same period, and a blow there leaves the axle alone (the centre of percussion). Infinite
    for an axle through the centre of mass, about which nothing swings.

    >>> from astroinertia.inertia import shapes
    >>> print(f"{pendulum_length(shapes.rod(2.0, 3.0), (0, 0, 1.5)):.4f}")  # a rod about its end: 2/3 of its length
    2.0000
    """
    xp = namespace(*vars(body).values(), pivot, axis)
    with np.errstate(divide="ignore"):
        return body.moment(axis, pivot) / (body.mass * _arm(xp, body, pivot, axis))


@with_quantities(pivot="m", amplitude="rad")
def pendulum_period(
    body: Body, pivot: Array, axis: Array = (0.0, 1.0, 0.0), amplitude: Array = 0.0, gravity: Array = STANDARD_GRAVITY
) -> Array:
    """The period (...,) of a swing to `amplitude` (radians, below pi) on either side, about a level axle.

    2 pi sqrt(l/g)/M(1, cos(amplitude/2)), with M Gauss's arithmetic-geometric mean: exact at any amplitude. ValueError
    for one that is not below pi.

    >>> from astroinertia.inertia import shapes
    >>> rod = shapes.rod(1.0, 1.5)  # swings as a simple pendulum of 1 m
    >>> print(f"{pendulum_period(rod, (0, 0, 0.75), gravity=np.pi**2):.4f}")
    2.0000
    >>> print(f"{pendulum_period(rod, (0, 0, 0.75), amplitude=np.pi / 2, gravity=np.pi**2):.5f}")  # 1.18034 times that
    2.36068
    """
    xp = namespace(*vars(body).values(), pivot, axis, amplitude, gravity)
    if is_known(amplitude) and not (abs(np.asarray(amplitude)) < np.pi).all():
        raise ValueError("amplitude must be below pi: a pendulum does not swing further")
    low = xp.cos(0.5 * xp.asarray(amplitude))
    high = xp.ones_like(low)
    for _ in range(_MEANS):
        high, low = 0.5 * (high + low), xp.sqrt(high * low)
    return 2 * xp.pi * xp.sqrt(pendulum_length(body, pivot, axis) / gravity) / high


@with_quantities(first_arm="m", second_arm="m", first_period="s", second_period="s")
def kater_gravity(first_period: Array, second_period: Array, first_arm: Array, second_arm: Array) -> Array:
    """Gravity (...,) from the periods of a pendulum on two knife edges, at h1 and h2 from its centre of mass.

    Neither mass nor moment of inertia is needed: 8 pi^2/g = (T1^2 + T2^2)/(h1 + h2) + (T1^2 - T2^2)/(h1 - h2). With
    T1 = T2 the second term vanishes, and only the distance h1 + h2 of the edges counts. Arms that are equal say
    nothing and give NaN. Source: Bessel (1826), Untersuchungen ueber die Laenge des einfachen Secundenpendels.

    >>> print(f"{kater_gravity(2.0, 2.0, 0.6, 0.4) / np.pi**2:.4f}")  # edges 1 m apart, 2 s
    1.0000
    """
    xp = namespace(first_period, second_period, first_arm, second_arm)
    one, two = xp.asarray(first_period) ** 2, xp.asarray(second_period) ** 2
    unequal = xp.asarray(first_arm) - second_arm
    difference = xp.where(unequal == 0, xp.nan, (one - two) / xp.where(unequal == 0, 1.0, unequal))
    return 8 * xp.pi**2 / ((one + two) / (xp.asarray(first_arm) + second_arm) + difference)


@with_quantities(pivot="m", reach="m")
def pivot_impulse(body: Body, pivot: Array, reach: Array, axis: Array = (0.0, 1.0, 0.0)) -> Array:
    """What the axle has to give (...,), as a share of a blow at `reach` from it across the line to the centre of mass.

    m h b/I - 1: 0 at the centre of percussion b = `pendulum_length`; -1 for a blow at the axle, which takes it all.
    Where it is negative the axle pushes against the blow; where it is positive, along with it.

    >>> from astroinertia.inertia import shapes
    >>> print(f"{pivot_impulse(shapes.rod(2.0, 3.0), (0, 0, 1.5), 3.0):.4f}")  # a rod struck at its far end
    0.5000
    """
    xp = namespace(*vars(body).values(), pivot, axis, reach)
    return xp.asarray(reach) / pendulum_length(body, pivot, axis) - 1


def _arm(xp: Any, body: Body, pivot: Array, axis: Array) -> Array:
    """The distance (...,) of the centre of mass from the axle."""
    axis = of_any_length(xp.asarray(axis))
    across = xp.cross(axis, body.centre - xp.asarray(pivot))
    return xp.linalg.norm(across, axis=-1) / xp.linalg.norm(axis, axis=-1)
