"""The attitude of a free rigid body in closed form, and how fast it precesses about its angular momentum.

With theta the angle between the angular momentum L and the axis c that the angular velocity circles (free_top.py), and
phi the angle by which the plane of both has turned about L, d phi/dt = L (I_a w_a^2 + I_b w_b^2)/((I_a w_a)^2 +
(I_b w_b)^2). Its integral is a mean rate, which is a complete elliptic integral of the third kind, and a ripple with
the period of the wobble, which is the phase of a theta function of complex argument (Jacobi). The mean rate is known to
60 digits and the ripple is bounded, so nothing is lost over any number of turns; theta and the direction of L in the
body are those of `free_top.angular_velocity`. Any consistent units; angles in radians.

Source: Whittaker (1937), Analytical Dynamics, section 69; Landau & Lifshitz, Mechanics, section 37; DLMF 20.2, 20.7
(viii).
"""

import math
from decimal import Decimal
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from astroinertia.inertia.orthogonal import require_orthogonal
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import require_plausible, rotated
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.attitude import ROUGHLY_ORTHOGONAL, angle_between, rotation
from astroinertia.rotation.elliptic import PI, Clock, complete_integral, decimal, digits, hyperbolic, jacobi, unit
from astroinertia.rotation.free_top import FreeTop, angular_velocity as body_rates, checked_times, clock, free_top
from astroinertia.rotation.ripple import limit_ripple, phase_ripple

Array = Any

_THIN = 16 * np.finfo(float).eps  # share of the greatest moment below which the least is round-off of a tensor


@with_quantities()
def attitude(top: FreeTop, times: Array, start: Array | None = None) -> np.ndarray:
    """The attitude (..., 3, 3) at times (...,): rows are the body's axes in inertial axes, as in attitude.py.

    start (3, 3): the attitude at time 0; where none is given the axes coincide then. Every component to 2e-15, for
    any number of turns of the exact moments and angular velocity that the top was given; a relative error e in these
    turns the result by e times the angle turned through. ValueError for times that are not finite, and for a start that
    is no rotation.
    Source: Whittaker (1937), section 69.

    >>> from astroinertia.rotation.free_top import free_top
    >>> print(attitude(free_top([1, 2, 4], [0, 0, 1]), np.pi).round(12) + 0.0)  # half a turn about z
    [[-1.  0.  0.]
     [ 0. -1.  0.]
     [ 0.  0.  1.]]
    """
    times = checked_times(times)
    at_start = np.eye(3) if start is None else np.asarray(start, dtype=float)
    require_orthogonal(at_start, ROUGHLY_ORTHOGONAL, may_mirror=False)
    if top.motion == "steady":
        return _turned_steadily(top, times) @ at_start
    body, phase = _body_frame_and_phase(top, times)
    first, first_phase = _body_frame_and_phase(top, np.zeros(()))
    phase = phase / first_phase
    cosine, sine = phase.real, phase.imag
    zero, one = np.zeros_like(sine), np.ones_like(sine)
    turned = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, one], axis=-1)
    turned = turned.reshape(*times.shape, 3, 3)  # about the angular momentum, which is the third axis here
    return body @ np.swapaxes(turned, -1, -2) @ first.T @ at_start


class FreeMotion(NamedTuple):
    """A free body in inertial axes: angular_velocity (..., 3), inertia (..., 3, 3), and axes (..., 3, 3) as rows."""

    angular_velocity: np.ndarray
    inertia: np.ndarray
    axes: np.ndarray


@with_quantities()
def free_motion(inertia: Array, angular_velocity: Array, times: Array) -> FreeMotion:
    """The free motion of a body of any inertia tensor, at times (...,), in inertial axes.

    inertia (3, 3) about the centre of mass and angular_velocity (3,) at time 0. The axes are the principal ones, by
    ascending moment, and turn with the body. A least moment below 4e-15 of the greatest counts as 0, as a tensor does
    not tell it: give `free_top` the moments of such needles. ValueError for a tensor that no body has.
    Source: Landau & Lifshitz, Mechanics, section 37.

    >>> motion = free_motion(np.diag([2.0, 3.0, 4.0]), np.array([0.0, 0.0, 1.0]), np.pi / 2)
    >>> print(np.diag(motion.inertia).round(12))  # a quarter turn: x and y have changed places
    [3. 2. 4.]
    """
    tensor = np.asarray(inertia, dtype=float)
    require_plausible(tensor)
    moments, axes = principal_frame(tensor)
    if moments[0] <= _THIN * moments[2]:  # a thin rod, whose other moments differ by round-off
        moments = np.array([0.0, *np.full(2, moments[1:].mean())])
    top = free_top(moments.tolist(), (axes @ np.asarray(angular_velocity, dtype=float)).tolist())
    turned = attitude(top, times, axes)
    back = np.swapaxes(turned, -1, -2)
    rates = (back @ body_rates(top, times)[..., None])[..., 0]
    return FreeMotion(rates, rotated(np.diag(moments), back), turned)


@with_quantities()
def precession_rate(top: FreeTop) -> float:
    """The mean rate, in rad per time and positive, at which the axis c goes around the angular momentum.

    Exact, an average over a period; on the separatrix that of the steady rotation at both ends. NaN of a steady
    rotation. For a symmetric body L/I_a. Source: Landau & Lifshitz, Mechanics, section 37; DLMF 19.2.11 (Bulirsch).

    >>> from astroinertia.rotation.free_top import free_top
    >>> print(f"{precession_rate(free_top([1, 1, 2], [0.1, 0, 1])):.6f}")  # L/A = sqrt(0.1^2 + 2^2)
    2.002498
    """
    if top.motion == "steady":
        return math.nan
    with digits():
        return float(_mean_rate(top))


@with_quantities()
def precession_per_period(top: FreeTop) -> float:
    """The angle, in rad, by which the attitude has turned about L when the angular velocity has returned in the body.

    Between -pi and pi. By as much a body in free rotation fails to repeat itself in space: Montgomery's (1991, Am. J.
    Phys. 59, 394) phase, 2 T period/L less a solid angle. NaN where there is no period.

    >>> from astroinertia.rotation.free_top import free_top
    >>> top = free_top([1, 1, 2], [0.1, 0, 1])  # symmetric: goes about L with L/A, and returns after 2 pi
    >>> print(f"{precession_per_period(top) - 2 * np.pi * (2.0024984 - 2):.6f}")
    0.000000
    """
    if top.modulus is None:
        return math.nan
    with digits():
        turns = 4 * top.modulus.quarter / top.argument_rate * _mean_rate(top) / (2 * PI)
        return float((turns - turns.to_integral_value()) * 2 * PI)


@with_quantities()
def uncertainty(top: FreeTop, times: Array, relative: float = 2.0**-53) -> tuple[np.ndarray, np.ndarray]:
    """How well the motion is known at times (...,) when moments and angular velocity are known to `relative` only.

    The change of the angular velocity in the body (...,), over its greatest component, and the angle of that of the
    attitude (...,), in rad: the roots of the sums of squares over the six numbers, each changed by that share. It grows
    as the angle turned through, and by 1/k'^2 more where the separatrix is near, unless by two components that are
    small themselves; no method can do better with such numbers.
    Where decimals were meant, the default says what giving floats in their stead has cost.
    Test: tests/hard/test_free_tops_hard.py.

    >>> from astroinertia.rotation.free_top import free_top
    >>> rate, angle = uncertainty(free_top([1, 2, 3], [0.1, 1, 0.1]), 1e6)
    >>> print(f"{angle:.0e} rad")  # of attitude after so long, if the start is known to rounding
    2e-10 rad
    """
    times = checked_times(times)
    rates, attitudes = body_rates(top, times), attitude(top, times)
    spin, turn = np.zeros(times.shape), np.zeros(times.shape)
    moments = [top.ordered[int(np.argmax(abs(top.frame[:, k])))] for k in range(3)]
    numbers_of_top = [*moments, *top.start]
    rod = not all(moments)  # its other two moments are one number
    for numbers in [*([(0, 1, 2)] if rod else [(0,), (1,), (2,)]), (3,), (4,), (5,)]:
        changed = [value * (1 + Fraction(relative) * (k in numbers)) for k, value in enumerate(numbers_of_top)]
        if changed != numbers_of_top:
            other = free_top(changed[:3], changed[3:])
            spin += ((body_rates(other, times) - rates) ** 2).sum(-1)
            turn += angle_between(attitude(other, times), attitudes) ** 2
    size = float(np.abs(top.amplitudes).max())
    return np.sqrt(spin) / (size or 1.0), np.sqrt(turn)


def _mean_rate(top: FreeTop) -> Decimal:
    """Of phi; within `digits()`."""
    of_a, of_b, _ = top.ordered
    if top.modulus is None:
        return top.angular_momentum / decimal(of_b)
    weight, sine_part = _shares(top)
    complement = top.modulus.complement_square.sqrt()
    whole = complete_integral(complement, decimal(weight), Decimal(1), decimal(sine_part))
    return top.angular_momentum / decimal(of_a) * whole / top.modulus.quarter


def _shares(top: FreeTop) -> tuple[Fraction, Fraction]:
    """Of (I_b w_b)^2 in (I_a w_a)^2 where the sine and the cosine of u have the same square, and likewise of I w^2."""
    of_a, of_b, of_c = top.ordered
    energy = abs(of_c - of_a) / abs(of_c - of_b)
    return of_b / of_a * energy, energy


def _body_frame_and_phase(top: FreeTop, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A frame with L as third axis as columns (..., 3, 3) in body axes, and exp(i phi) of its first axis (...,)."""
    with digits():
        weight = decimal(_shares(top)[0])
        mean = Clock(Decimal(0), _mean_rate(top) / (2 * PI))
        tilt = float(weight.sqrt()) * math.copysign(1.0, top.amplitudes[0] * top.amplitudes[1])
        of_axes = np.array([float(decimal(moment)) for moment in top.ordered])
    swing = of_axes * top.amplitudes / float(top.angular_momentum)
    if top.modulus is None:
        sech, tanh = hyperbolic(top.argument_rate, top.argument_start, times)
        sn, cn, dn = tanh, sech, sech
        ripple = limit_ripple(weight, tanh)
    else:
        quarters, rest = clock(top).turns(times)
        sn, cn, dn = jacobi(top.modulus, quarters, rest)
        ripple = phase_ripple(top.modulus, weight, quarters, rest)
    quarters, rest = mean.turns(times)
    phase = unit(quarters, rest) * (ripple if top.sense > 0 else np.conj(ripple))
    return _frame_of(top, swing[0] * cn, swing[1] * sn, swing[2] * dn, cn, tilt * sn), phase


def _frame_of(top: FreeTop, a: Array, b: Array, c: Array, towards: Array, aside: Array) -> np.ndarray:
    """The frame of L/|L| = (a, b, c), whose part across the axis c is along (towards, aside)."""
    across, size = np.hypot(a, b), np.hypot(towards, aside) * math.copysign(1.0, top.amplitudes[0])
    whole = np.hypot(across, c)
    sine, cosine = across / whole, c / whole
    x, y = towards / size, aside / size
    columns = [
        np.stack([cosine * x, cosine * y, -sine], axis=-1),
        np.stack([-y, x, np.zeros_like(x)], axis=-1),
        np.stack([sine * x, sine * y, cosine], axis=-1),
    ]
    return top.frame.T @ np.stack(columns, axis=-1)


def _turned_steadily(top: FreeTop, times: np.ndarray) -> np.ndarray:
    """The attitude (..., 3, 3) of a constant angular velocity, its turns counted to the last digit."""
    if not any(top.start):
        return np.broadcast_to(np.eye(3), (*times.shape, 3, 3))
    with digits():
        rate = decimal(sum((component**2 for component in top.start), Fraction(0))).sqrt()
        axis = np.array([float(decimal(component) / rate) for component in top.start])
        quarters, rest = Clock(Decimal(0), rate / (2 * PI)).turns(times)
    # From the body, the world is seen to turn the other way.
    return rotation(-0.5 * np.pi * quarters[..., None] * axis) @ rotation(-2.0 * np.pi * rest[..., None] * axis)
