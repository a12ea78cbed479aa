"""Where the angular velocity of a free body runs: polhodes and herpolhodes, the separatrix, flips and their dwell.

The polhode is the curve of the angular velocity in the body, the herpolhode that of its end in space, on the plane
across the angular momentum. Rotation about the axes of the least and the greatest moment is stable, that about the
intermediate one is not: a body that is set spinning about it (a tennis racket) turns over, dwells, and turns back. Any
consistent units; angles in radians.

Source: Poinsot (1834); Landau & Lifshitz, Mechanics, section 37; Ashbaugh, Chicone & Cushman (1991), J. Dyn. Differ.
Equ. 3, 67 (the tennis racket).
"""

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import Any, NamedTuple

import numpy as np

from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.elliptic import Number, decimal, digits, exact
from astroinertia.rotation.free_attitude import attitude
from astroinertia.rotation.free_top import FreeTop, angular_velocity, checked_times

Array = Any


class Stability(NamedTuple):
    """Small wobbles about a principal axis: their rate, in rad per time, or the rate at which they grow (e-folds)."""

    wobble_rate: np.ndarray
    growth_rate: np.ndarray


@with_quantities(rate="rad/s")
def stability(moments: Sequence[Number], rate: float, angular_momentum: float = 0.0) -> Stability:
    """How a small wobble about each principal axis (3,) goes on, of rotation about it at `rate`.

    moments (3,), in any order. angular_momentum: of a rotor within, along that axis and beside that of the body with
    the rotor at rest in it, as of a spacecraft with a wheel (a gyrostat): it holds any axis if it is large enough. One
    of wobble_rate (3,) and growth_rate (3,) is 0, both where another moment is equal: there, to first order, a wobble
    grows as the time. ValueError for moments that are not positive.
    Source: Landau & Lifshitz, Mechanics, section 37, eq. 37.16 and after; Hughes 1986, Spacecraft Attitude Dynamics,
    section 6.2.

    >>> print(stability([1, 2, 3], 1.0).growth_rate.round(4))  # only the middle axis is unstable: 3^(-1/2)
    [0.     0.5774 0.    ]
    >>> print(stability([1, 2, 3], 1.0, angular_momentum=1.5).wobble_rate[1].round(4))  # and is held by a wheel
    0.6455
    """
    sizes = [exact(moment) for moment in moments]
    if len(sizes) != 3 or min(sizes) <= 0:
        raise ValueError("stability needs three positive moments")
    turn, rotor = exact(rate), exact(angular_momentum)
    squares = []
    for k, about in enumerate(sizes):
        one, other = sizes[k - 1], sizes[k - 2]
        squares.append(float(((about - one) * turn + rotor) * ((about - other) * turn + rotor) / (one * other)))
    growth = np.array(squares)
    return Stability(np.sqrt(np.maximum(growth, 0.0)), np.sqrt(np.maximum(-growth, 0.0)))


@with_quantities()
def polhode(top: FreeTop, points: int = 241) -> np.ndarray:
    """The curve of the angular velocity in the body, (points, 3) in body axes, once around.

    Evenly in the angle by which it is parametrised and not in time, so that the corners next to the separatrix are
    drawn; on the separatrix from end to end; of a steady rotation the one point, repeated.
    Source: Landau & Lifshitz, Mechanics, section 37.

    >>> from astroinertia.rotation.free_top import free_top
    >>> curve = polhode(free_top([1, 2, 3], [0.1, 1, 0.1]), 5)
    >>> print((curve**2 @ [1, 2, 3]).round(12))  # all of one energy
    [2.04 2.04 2.04 2.04 2.04]
    """
    if points < 1 or points % 1 != 0:
        raise ValueError(f"points of a polhode must be a whole number and at least 1, not {points}")
    points = int(points)
    if top.motion == "steady":
        return np.tile(angular_velocity(top, 0.0), (points, 1))
    if top.modulus is None:
        turn, complement = np.linspace(-0.5 * np.pi, 0.5 * np.pi, points), 0.0
    else:
        turn, complement = np.linspace(0.0, 2.0 * np.pi, points), float(top.modulus.complement_square)
    cosine, sine = np.cos(turn), np.sin(turn)
    third = np.sqrt(cosine**2 + complement * sine**2)
    return (np.stack([cosine, sine, third], axis=-1) * top.amplitudes) @ top.frame


@with_quantities()
def herpolhode(top: FreeTop, times: Array, start: Array | None = None) -> np.ndarray:
    """The angular velocity (..., 3) in inertial axes at times (...,); start (3, 3) is the attitude at time 0.

    Source: Goldstein, Poole & Safko (2002), section 5.6.

    >>> from astroinertia.rotation.free_top import free_top
    >>> print(herpolhode(free_top([1, 2, 4], [0, 0, 3]), 7.0))  # steady
    [0. 0. 3.]
    """
    times = checked_times(times)
    turned = np.swapaxes(attitude(top, times, start), -1, -2)
    return (turned @ angular_velocity(top, times)[..., None])[..., 0]


@with_quantities()
def herpolhode_radii(top: FreeTop) -> tuple[float, float]:
    """The least and the greatest component of the angular velocity across L, in rad per time.

    Between them runs the herpolhode; that of a symmetric body is a circle, on the separatrix it spirals into 0.
    Source: Goldstein et al. section 5.6.

    >>> from astroinertia.rotation.free_top import free_top
    >>> least, most = herpolhode_radii(free_top([1, 1, 2], [0.1, 0, 1]))
    >>> print(f"{most - least:.6f}")  # of a symmetric body a circle
    0.000000
    """
    ends = [top.amplitudes * np.array([1.0, 0.0, 1.0])]
    complement = 0.0 if top.modulus is None else math.sqrt(float(top.modulus.complement_square))
    if top.motion == "steady":
        ends = [top.amplitudes]
    else:
        ends.append(top.amplitudes * np.array([0.0, 1.0, complement]))
    with digits():
        sizes = np.array([float(decimal(size)) for size in top.ordered])
    radii = []
    for end in ends:
        momentum = sizes * end
        size = np.linalg.norm(momentum)
        radii.append(float(np.linalg.norm(np.cross(momentum, end)) / size) if size else float(np.linalg.norm(end)))
    return min(radii), max(radii)


@with_quantities()
def separatrix_angle(top: FreeTop, times: Array = 0.0) -> np.ndarray:
    """The angle (...,) in the body from L to the nearer of the two separatrices, at times (...,), with all digits.

    In the body the directions of L on the separatrices are two great circles through the intermediate axis. NaN where
    two moments are equal, as there is none. Source: Landau & Lifshitz, Mechanics, section 37.

    >>> from astroinertia.rotation.free_top import free_top
    >>> print(f"{np.degrees(separatrix_angle(free_top([1, 2, 3], [0, 0, 1]))):.1f}")  # tan^2 = (1/2 - 1/3)/(1 - 1/2)
    30.0
    """
    times = checked_times(times)
    least, middle, most = sorted(top.ordered)
    if least == middle or middle == most:
        return np.full(times.shape, math.nan)
    with digits():
        slow, fast = (
            float(decimal(square).sqrt())
            for square in (least * (middle - least) / middle, most * (most - middle) / middle)
        )
        whole = float(top.angular_momentum * (decimal((most - least) / (least * most))).sqrt())
    rates = angular_velocity(top, times)[..., np.argsort(top.moments, kind="stable")]
    if whole == 0.0:
        return np.full(times.shape, math.nan)
    # The difference of two squares is a constant of the motion, known exactly; their roots are not.
    total = slow * abs(rates[..., 0]) + fast * abs(rates[..., 2])
    distance = abs(top.separation) / float(middle) / np.where(total > 0.0, total, 1.0)
    return np.arcsin(np.minimum(distance / whole, 1.0))


@with_quantities(end="s")
def flip_times(top: FreeTop, end: float) -> np.ndarray:
    """The times from 0 to `end` at which the component along the intermediate axis passes through 0.

    ValueError for an end that is not finite.
    Source: Landau & Lifshitz, Mechanics, section 37.

    >>> from astroinertia.rotation.free_top import free_top, period
    >>> top = free_top([1, 2, 3], [0.1, 1, 0.1])
    >>> print((np.diff(flip_times(top, 40.0)) / period(top)).round(9))  # twice in each period
    [0.5 0.5]
    """
    if not math.isfinite(end := float(end)):
        raise ValueError(f"the time up to which flips are counted must be finite, not {end}")
    if top.motion == "steady":
        return np.empty(0)
    with digits():
        first = -top.argument_start / top.argument_rate
        if top.modulus is None:
            return np.array([float(first)] if 0 <= first <= Decimal(end) else [])
        interval = 2 * top.modulus.quarter / top.argument_rate
        number = (-first / interval).to_integral_value(rounding="ROUND_CEILING")
        times = []
        while first + number * interval <= Decimal(end):
            times.append(float(first + number * interval))
            number += 1
    return np.array(times)


@with_quantities()
def dwell(top: FreeTop, angle: float) -> float:
    """The time, between one flip and the next, for which L stays within `angle` of the body's intermediate axis.

    0 where it never comes so near, infinite on the separatrix, NaN of a steady rotation. ValueError unless the angle is
    between 0 and pi/2. Source: Landau & Lifshitz, Mechanics, section 37.

    >>> from astroinertia.rotation.free_top import free_top, period
    >>> top = free_top([1, 2, 3], ["1e-6", 1, "1e-6"])
    >>> print(f"{dwell(top, np.radians(10.0)) / (period(top) / 2):.2f}")  # most of the time upright
    0.84
    """
    if not 0.0 < angle < 0.5 * math.pi:
        raise ValueError("the angle of a dwell is between 0 and pi/2")
    if top.modulus is None:
        return math.inf if top.motion == "separatrix" else math.nan
    with digits():
        amplitude = decimal(top.ordered[1]) * abs(Decimal(float(top.amplitudes[1]))) / top.angular_momentum
        sine = Decimal(math.cos(angle)) / amplitude
        if sine >= 1:
            return 0.0
        square = sine * sine
        away = top.modulus.incomplete(sine, 1 - square, 1 - top.modulus.square * square, ahead=True)
        return float(2 * (top.modulus.quarter - away) / top.argument_rate)
