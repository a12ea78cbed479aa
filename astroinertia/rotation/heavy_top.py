"""The symmetric top in uniform gravity, one point of its axis fixed, in closed form (Lagrange's top).

A is the moment about any axis across the body's own through the fixed point, C that about the body's own, and the
torque of gravity is at most M = m g l, with the axis level. The tilt theta is the angle of the axis to the vertical,
upwards. With u = cos theta, a = C w_3/A, b = L_z/A, beta = 2 M/A and alpha = (2 E - C w_3^2)/A,

    (du/dt)^2 = (1 - u^2)(alpha - beta u) - (b - a u)^2 = beta (u - u_1)(u_2 - u)(u_3 - u),
    u = u_1 + (u_2 - u_1) sn^2,    d phi/dt = (b - a u)/(1 - u^2),    d psi/dt = w_3 - u d phi/dt.

As for the free top, constants have 60 digits and what depends on time is in double precision. Angles are those of
Euler, "zxz": precession phi, nutation theta, spin psi. Any consistent units; angles in radians.

Source: Goldstein, Poole & Safko (2002), Classical Mechanics, section 5.7; Whittaker (1937), Analytical Dynamics,
sections 71 to 73.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import numpy as np

from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.elliptic import (
    PI,
    Clock,
    Modulus,
    Number,
    complete_integral,
    decimal,
    digits,
    exact,
    sine_and_cosine,
    unit,
)
from astroinertia.rotation.free_top import checked_times, clock, elliptic_functions
from astroinertia.rotation.ripple import limit_ripple, phase_ripple

Array = Any

_ROOT_DIGITS = 130
_ROUND_OFF = Decimal("1e-55")  # below it a difference of roots is round-off


@dataclass(frozen=True)
class HeavyTop:
    """A symmetric top in uniform gravity by the constants of its motion, as `heavy_top` finds them.

    `falling` and `rising` are (b - a)/2 and (b + a)/2, the parts of d phi/dt over 1 - u and 1 + u.
    """

    spin: float  # w_3, along the axis
    axial_rate: Decimal  # a
    falling: Decimal
    rising: Decimal
    lowest: Decimal  # 1 + u_1
    highest: Decimal  # 1 - u_2
    range: Decimal  # u_2 - u_1
    ratio: Decimal  # A/C
    argument_rate: Decimal
    argument_start: Decimal
    modulus: Modulus | None  # None where the top takes for ever to rise to the vertical


@with_quantities()
def heavy_top(
    transverse_moment: Number, axial_moment: Number, torque: Number, tilt: Number, angular_velocity: Sequence[Number]
) -> HeavyTop:
    """Solve the motion of a symmetric top in uniform gravity.

    transverse_moment A and axial_moment C, both about the fixed point; torque M = m g l, not negative: of the two
    directions of the axis take that towards the centre of mass. At time 0: tilt, 0 to pi, and the angular velocity
    (3,) about the line of nodes, d theta/dt, across it and the axis, sin theta d phi/dt, and about the axis, w_3.
    ValueError for other numbers. Source: Goldstein et al. section 5.7.

    >>> print(heavy_top(1, 2, 1, 0.5, [0, 0, 5]).spin)
    5.0
    """
    values = [exact(number) for number in (transverse_moment, axial_moment, torque, tilt, *angular_velocity)]
    if len(values) != 7 or min(values[:2]) <= 0 or min(values[2:4]) < 0 or values[3] > exact(math.pi):
        raise ValueError(
            "a heavy top has two positive moments, a torque that is not negative, a tilt from 0 to pi and three rates"
        )
    with digits(_ROOT_DIGITS):  # roots that nearly meet are known to the square root of this
        size, axial, moment = (decimal(number) for number in values[:3])
        sine, cosine = sine_and_cosine(values[3] / 2)
        below, above = 2 * sine**2, 2 * cosine**2  # 1 - u and 1 + u
        nodal, across, spin = (decimal(number) for number in values[4:])
        if not sine and across:
            raise ValueError("an upright top turns about its line of nodes: its rate across it must be 0")
        a, beta = axial * spin / size, 2 * moment / size
        swing = across * 2 * sine * cosine  # sin^2 theta d phi/dt = b - a u
        alpha = nodal**2 + across**2 + beta * (1 - below)
        first, second, gap, far = _roots(a, swing + a * (1 - below), alpha, beta)
        falling, rising = (swing - a * below) / 2, (swing + a * above) / 2
        common: dict[str, Any] = {"spin": float(spin), "axial_rate": a, "falling": falling, "rising": rising,
                                  "ratio": size / axial, "argument_rate": far.sqrt() / 2}  # fmt: skip
        reach = second - first
        # At rest along the vertical a top stays, though it may be one that falls at the least touch.
        if reach <= _ROUND_OFF or not (sine or nodal):
            return HeavyTop(lowest=above, highest=below, range=Decimal(0), argument_start=Decimal(0),
                            modulus=Modulus(Decimal(0), Decimal(1)), **common)  # fmt: skip
        common |= {
            "lowest": 1 + first if rising else Decimal(0),
            "highest": 1 - second if falling or gap <= _ROUND_OFF * far or 1 - second > _ROUND_OFF else Decimal(0),
            "range": reach,
        }
        sine_square = min(max((1 - below - first) / reach, Decimal(0)), Decimal(1))
        sn = sine_square.sqrt().copy_sign(-nodal)
        if gap <= _ROUND_OFF * far:
            start = ((1 + abs(sn)) / (1 - sine_square).sqrt()).ln().copy_sign(sn)
            return HeavyTop(argument_start=start, modulus=None, **common)
        modulus = Modulus(beta * reach / far, gap / far)
        start = modulus.incomplete(sn, 1 - sine_square, 1 - modulus.square * sine_square, ahead=True)
        return HeavyTop(argument_start=start, modulus=modulus, **common)


@with_quantities(precession="rad", spin="rad")
def attitude(top: HeavyTop, times: Array, precession: float = 0.0, spin: float = 0.0) -> np.ndarray:
    """The attitude (..., 3, 3) at times (...,): rows are the body's axes, the third its own, z is upwards.

    precession and spin are the angles phi and psi at time 0. Every component to 3e-15 for any number of turns of the
    exact values the top was given. ValueError for times that are not finite.
    Source: Whittaker (1937), section 73.

    >>> print(attitude(heavy_top(1, 2, 0, 0.5, [0, 0, 5]), 3.0)[2].round(6) + 0.0)  # without torque its axis stays
    [ 0.       -0.479426  0.877583]
    """
    times = checked_times(times)
    sine, cosine = _half_tilt(top, times)
    around, about = _phases(top, times)
    around, about = around * np.exp(1.0j * precession), about * np.exp(1.0j * spin)
    across, along = 2.0 * sine * cosine, (cosine - sine) * (cosine + sine)
    x, y = around, around * 1.0j * along  # where the line of nodes points, and what is across it in the equator
    first = x * about.real + y * about.imag
    second = -x * about.imag + y * about.real
    rows = [
        np.stack([first.real, first.imag, across * about.imag], axis=-1),
        np.stack([second.real, second.imag, across * about.real], axis=-1),
        np.stack([across * around.imag, -across * around.real, along], axis=-1),
    ]
    return np.stack(rows, axis=-2)


@with_quantities()
def tilt(top: HeavyTop, times: Array) -> np.ndarray:
    """The tilt theta (...,), 0 to pi, at times (...,), to round-off of itself near the vertical.

    Source: Goldstein et al. section 5.7.

    >>> print(f"{tilt(heavy_top(1, 2, 1, 0.5, [0, 0, 50]), 3.0):.4f}")  # fast: it hardly falls
    0.5001
    """
    sine, cosine = _half_tilt(top, checked_times(times))
    return 2.0 * np.arctan2(abs(sine), abs(cosine))


@with_quantities(spin="rad")
def body_angular_velocity(top: HeavyTop, times: Array, spin: float = 0.0) -> np.ndarray:
    """The angular velocity (..., 3) in body axes at times (...,), with psi = spin at time 0.

    Source: Goldstein et al. section 5.7.

    >>> print(body_angular_velocity(heavy_top(1, 2, 1, 0.5, [0, 0, 5]), 3.0)[2])  # w_3 stays
    5.0
    """
    times = checked_times(times)
    sine, cosine = _half_tilt(top, times)
    cn, sn, dn = elliptic_functions(top, times)
    with digits():
        slope, falling, rising = (float(number) for number in (top.range * top.argument_rate, top.falling, top.rising))
        passing = float((2 / top.range).sqrt()) if top.range else 0.0
    # cn over the sine of half the tilt and sn over its cosine, both of which may pass through 0 together
    over_sine = cn / sine if top.highest else passing
    over_cosine = sn / cosine if top.lowest else math.copysign(passing, top.argument_start)
    across = (falling * cosine / sine if falling else 0.0) + (rising * sine / cosine if rising else 0.0)
    turned = (1.0j * across - slope * over_sine * over_cosine * dn) * np.conj(
        _phases(top, times)[1] * np.exp(1.0j * spin)
    )
    return np.stack([turned.real, turned.imag, np.full(times.shape, top.spin)], axis=-1)


@with_quantities()
def nutation_period(top: HeavyTop) -> float:
    """The time after which the tilt repeats, 2K/(du/dt); infinite where the top rises to the vertical for ever.

    Source: Whittaker (1937), section 73.

    >>> print(f"{nutation_period(heavy_top(1, 2, 1, 0.5, [0, 0, 50])):.4f}")  # fast: 2 pi A/(C w_3)
    0.0628
    """
    if top.modulus is None:
        return math.inf
    with digits():
        return float(2 * top.modulus.quarter / top.argument_rate) if top.argument_rate else math.inf


@with_quantities()
def tilt_range(top: HeavyTop) -> tuple[float, float]:
    """The least and the greatest tilt.

    Source: Goldstein et al. section 5.7.

    >>> print([round(each, 4) for each in tilt_range(heavy_top(1, 2, 1, 0.5, [0, 0, 5]))])  # from its cusp down
    [0.5, 0.5098]
    """
    with digits():
        highest, lowest = (top.highest / 2).sqrt(), (top.lowest / 2).sqrt()
        return 2.0 * math.asin(float(highest)), 2.0 * math.acos(float(lowest))


@with_quantities()
def precession_rate(top: HeavyTop) -> float:
    """The mean rate d phi/dt, in rad per time.

    Source: Goldstein et al. section 5.7.

    >>> print(f"{precession_rate(heavy_top(1, 2, 1, 0.5, [0, 0, 50])):.4f}")  # fast: M/(C w_3)
    0.0100
    """
    with digits():
        return float(_mean_rates(top)[0])


@with_quantities(spin="rad/s")
def steady_precession_rates(
    transverse_moment: float, axial_moment: float, torque: float, tilt: float, spin: float
) -> tuple[float, float]:
    """The slow and the fast rate of precession without nutation at a tilt, in rad per time; NaN where there is none.

    Roots of A cos(theta) rate^2 - C w_3 rate + M = 0; the fast one is infinite where the axis is level. spin is w_3.
    Source: Goldstein et al. section 5.7.

    >>> slow, fast = steady_precession_rates(1.0, 2.0, 1.0, 0.5, 50.0)
    >>> print(f"{slow:.4f}")  # M/(C w_3)
    0.0100
    """
    along = transverse_moment * math.cos(tilt)
    momentum = axial_moment * spin
    square = momentum**2 - 4.0 * along * torque
    if square < 0.0 or (momentum == 0.0 and along == 0.0):
        return math.nan, math.nan
    # by the sum that does not cancel
    large = 0.5 * (momentum + math.copysign(math.sqrt(square), momentum))
    if large == 0.0:
        return (0.0, 0.0)
    return torque / large, large / along if along else math.copysign(math.inf, large)


@with_quantities()
def least_sleeping_spin(transverse_moment: float, axial_moment: float, torque: float) -> float:
    """The least w_3, 2 sqrt(A M)/C, at which an upright top sleeps; a slower one falls at the least touch.

    ValueError for moments that are not above 0 and a negative torque. Source: Goldstein et al. section 5.7.

    >>> print(least_sleeping_spin(1.0, 2.0, 1.0))  # 2 sqrt(A M)/C
    1.0
    """
    if not (transverse_moment > 0 and axial_moment > 0 and torque >= 0):
        raise ValueError("a top has two moments above 0 and a torque that is not negative; one that hangs never falls")
    return 2.0 * math.sqrt(transverse_moment * torque) / axial_moment


def _roots(a: Decimal, b: Decimal, alpha: Decimal, beta: Decimal) -> tuple[Decimal, Decimal, Decimal, Decimal]:
    """Of the cubic above u_1 and u_2, and beta times u_3 - u_2 and u_3 - u_1."""
    square, linear, constant = alpha + a * a, 2 * a * b - beta, alpha - b * b
    u = Decimal(-1)
    while True:  # Newton's method from below, where the cubic is concave and rises: it never oversteps
        value = ((beta * u - square) * u + linear) * u + constant
        slope = (3 * beta * u - 2 * square) * u + linear
        if value >= 0 or slope <= 0:
            break
        u -= value / slope
        if abs(value) <= slope * _ROUND_OFF**2:
            break
    middle = square - beta * u
    last = linear - u * middle
    root = max(middle * middle - 4 * beta * last, Decimal(0)).sqrt()
    second = 2 * last / (middle + root) if middle + root else u
    return u, max(second, u), root, (middle + root) / 2 - beta * u


def _mean_rates(top: HeavyTop) -> tuple[Decimal, Decimal]:
    """Of phi and of psi; within `digits()`."""
    if top.modulus is None:
        falling, rising = Decimal(0), top.rising / 2
    else:
        complement, quarter = top.modulus.complement_square.sqrt(), top.modulus.quarter

        def mean(part: Decimal, start: Decimal, end: Decimal) -> Decimal:
            """Of part/(start + (end - start) sn^2)."""
            if not part:
                return part
            whole = complete_integral(complement, end / start, Decimal(1), Decimal(1))
            return part / start * whole / quarter

        falling = mean(top.falling, top.highest + top.range, top.highest)
        rising = mean(top.rising, top.lowest, top.lowest + top.range)
    return falling + rising, top.axial_rate * (top.ratio - 1) - falling + rising


def _half_tilt(top: HeavyTop, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of half the tilt (...,), with a sign where the axis passes through the vertical."""
    cn, sn, _ = elliptic_functions(top, times)
    highest, lowest, reach = (float(number) for number in (top.highest, top.lowest, top.range))
    sine = np.sqrt(0.5 * (highest + reach * cn**2)) if highest else math.sqrt(0.5 * reach) * cn
    if lowest:
        return sine, np.sqrt(0.5 * (lowest + reach * sn**2))
    return sine, math.copysign(math.sqrt(0.5 * reach), top.argument_start) * sn


def _phases(top: HeavyTop, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """exp(i phi) and exp(i psi), (...,), from 1 at time 0."""
    with digits():
        clocks = [Clock(Decimal(0), rate / (2 * PI)) for rate in _mean_rates(top)]
    (falling, rising), (falling_start, rising_start) = _ripples(top, times), _ripples(top, np.zeros(()))
    falling, rising = falling / falling_start, rising / rising_start
    around, about = (unit(*each.turns(times)) for each in clocks)
    return around * falling * rising, about * np.conj(falling) * rising


def _ripples(top: HeavyTop, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ripples of the parts over 1 - u and 1 + u, as phases (...,)."""
    one = np.ones(times.shape, dtype=complex)
    falling = rising = one
    with digits():
        up = (top.lowest + top.range) / top.lowest if top.rising else Decimal(1)
        down = top.highest / (top.highest + top.range) if top.falling else Decimal(1)
    if top.modulus is None:
        rising = limit_ripple(up, elliptic_functions(top, times)[1]) if top.rising else one
    else:
        quarters, rest = clock(top).turns(times)
        if top.rising:
            rising = phase_ripple(top.modulus, up, quarters, rest)
        if top.falling:  # its greatest rate is at the other end, a quarter later
            with digits():
                weight = top.modulus.complement_square / down
            falling = phase_ripple(top.modulus, weight, quarters + 1, rest)
    return falling if top.falling > 0 else np.conj(falling), rising if top.rising > 0 else np.conj(rising)
