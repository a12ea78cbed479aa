"""The free rotation of a rigid body in closed form: angular velocity, periods and rates, for any moments and any spin.

Jacobi's solution of Euler's equations. Let c be the principal axis that the angular velocity circles, that of the
greatest moment where 2 T I_2 < L^2 and that of the least where 2 T I_2 > L^2, b that of the intermediate moment and a
the other. Then omega_a = P cn u, omega_b = Q sn u, omega_c = R dn u, with u - u_0 proportional to time. On the
separatrix, 2 T I_2 = L^2, the same with hyperbolic functions. All constants are worked out from the exact values of
the arguments, to 60 digits: how far a motion is from the separatrix, I_1 (I_2 - I_1) w_1^2 - I_3 (I_3 - I_2) w_3^2, and
how many turns it has made, are lost to round-off otherwise. Where a decimal is meant, such as 0.1, which no float is,
moments and angular velocity may be strings or Decimals.

Any consistent units; angles in radians. Source: Landau & Lifshitz, Mechanics, section 37; DLMF chapter 22.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.elliptic import (
    PI,
    Clock,
    Modulus,
    Number,
    decimal,
    digits,
    exact,
    hyperbolic,
    jacobi,
)

Array = Any


@dataclass(frozen=True)
class FreeTop:
    """A free rigid body by the constants of its motion, as `free_top` finds them.

    motion is "steady" (the angular velocity is constant, also in the body), "periodic" or "separatrix" (it goes from
    one end of the intermediate axis to the other, once). Lengths of time and rates are 60-digit Decimals here and
    floats in the functions of this module.
    """

    moments: np.ndarray
    start: tuple[Fraction, Fraction, Fraction]  # angular velocity at time 0, in body axes
    motion: str
    energy: float
    angular_momentum: Decimal
    separation: float  # I_1 (I_2 - I_1) w_1^2 - I_3 (I_3 - I_2) w_3^2 = 2 T I_2 - L^2
    frame: np.ndarray  # rows: the axes a, b, c in body axes, right-handed
    ordered: tuple[Fraction, Fraction, Fraction]  # moments about a, b and c
    amplitudes: np.ndarray  # P, Q, R
    sense: int  # 1 where c has the greatest moment, -1 where it has the least
    argument_rate: Decimal  # du/dt
    argument_start: Decimal  # u_0
    modulus: Modulus | None  # of periodic motion


@with_quantities()
def free_top(moments: Sequence[Number], angular_velocity: Sequence[Number]) -> FreeTop:
    """Solve the free rotation of a rigid body.

    moments: the three principal moments about the centre of mass, in the order of the body's axes, in any order of
    size; one may be 0, that of a thin rod about itself, when the others are equal. angular_velocity: its components
    along these axes at time 0. ValueError for other numbers; moments of which one exceeds the sum of the others, which
    no body has, are solved all the same.
    Source: Landau & Lifshitz, Mechanics, section 37.

    >>> top = free_top([1, 2, 3], ["0.1", "1", "0.1"])  # text keeps decimals exact
    >>> print(top.motion, float(top.energy))
    periodic 1.02
    """
    sizes, rates = _checked(moments, angular_velocity)
    order = sorted(range(3), key=lambda k: sizes[k])
    least, middle, most = (sizes[k] for k in order)
    slow, between, fast = (rates[k] for k in order)
    # d omega_i/dt is -g_1, g_2 and -g_3 times the product of the other two
    coefficients = (_share(most - middle, least), _share(most - least, middle), _share(middle - least, most))
    separation = coefficients[2] * slow**2 - coefficients[0] * fast**2
    torques = coefficients[0] * between * fast, coefficients[1] * fast * slow, coefficients[2] * slow * between
    sense = 1 if separation <= 0 else -1
    if sense < 0:
        order.reverse()
    frame = np.eye(3)[order]
    handedness = round(float(np.linalg.det(frame)))
    frame[1] *= handedness
    a, b, c = (rates[k] for k in order)
    b *= handedness
    ordered = tuple(sizes[k] for k in order)
    with digits():
        squares = [(size * rate) ** 2 for size, rate in zip(sizes, rates, strict=True)]
        common: dict[str, Any] = {
            "moments": np.array([float(size) for size in sizes]),
            "start": tuple(rates),
            "energy": float(sum(size * rate**2 for size, rate in zip(sizes, rates, strict=True)) / 2),
            "angular_momentum": decimal(sum(squares, Fraction(0))).sqrt(),
            "separation": float(separation * least * most),
            "frame": frame,
            "ordered": ordered,
            "sense": sense,
        }
        if not any(torques):
            still = np.array([float(a), float(b), float(c)])
            motion = {"motion": "steady", "amplitudes": still, "argument_rate": Decimal(0),
                      "argument_start": Decimal(0), "modulus": None}  # fmt: skip
        else:
            motion = _circling((a, b, c), coefficients[::sense], abs(separation), sense)
        return FreeTop(**common, **motion)


def _circling(
    rates: tuple[Fraction, ...], coefficients: tuple[Fraction, ...], separation: Fraction, sense: int
) -> dict[str, Any]:
    """Amplitudes and elliptic functions of motion that is not steady, from the rates about a, b and c at time 0.

    d omega/dt of each is its coefficient times the other two; within `digits()`.
    """
    a, b, c = rates
    of_a, of_b, of_c = coefficients
    around_a, around_c = of_c * b**2 + of_b * c**2, of_b * a**2 + of_a * b**2  # constants of the motion
    amplitudes = [decimal(square).sqrt() for square in (around_c / of_b, around_c / of_a, around_a / of_b)]
    amplitudes[2] = amplitudes[2].copy_sign(decimal(c))
    amplitudes[1] = amplitudes[1].copy_sign(sense * decimal(c))
    sine, cosine = decimal(b) / amplitudes[1], decimal(a) / amplitudes[0]
    if separation == 0:
        modulus, motion = None, "separatrix"
        # artanh of the sine, by what does not cancel: cn = sech u
        start = ((1 + abs(sine)) / abs(cosine)).ln().copy_sign(sine)
        if cosine < 0:  # sech is positive: the other branch, on which a and b are reversed
            amplitudes[0], amplitudes[1], start = -amplitudes[0], -amplitudes[1], -start
    else:
        motion = "periodic"
        modulus = Modulus(decimal(of_c * around_c / (of_a * around_a)), decimal(of_b * separation / (of_a * around_a)))
        start = modulus.incomplete(sine, decimal(a**2 * of_b / around_c), decimal(c**2 * of_b / around_a), ahead=a >= 0)
    return {"motion": motion, "amplitudes": np.array([float(amplitude) for amplitude in amplitudes]),
            "argument_rate": decimal(of_a * around_a).sqrt(), "argument_start": start, "modulus": modulus}  # fmt: skip


@with_quantities()
def angular_velocity(top: FreeTop, times: Array) -> np.ndarray:
    """The angular velocity (..., 3) in body axes at times (...,), before or after time 0.

    Each component to 4e-15 of itself for any number of periods, to 1e-13 where k' is below 1e-50. ValueError for times
    that are not finite. Source: Landau & Lifshitz, Mechanics, eq. 37.10.

    >>> print(angular_velocity(free_top([1, 2, 4], [0, 0, 3]), 10.0))  # steady about a principal axis
    [0. 0. 3.]
    """
    times = checked_times(times)
    if top.motion == "steady":
        return np.broadcast_to([float(rate) for rate in top.start], (*times.shape, 3)).copy()
    return (np.stack(elliptic_functions(top, times), axis=-1) * top.amplitudes) @ top.frame


@with_quantities()
def period(top: FreeTop) -> float:
    """The period 4K/(du/dt) of the angular velocity in the body: infinite on the separatrix, NaN of a steady rotation.

    omega_c, and the square of each component, repeat after half of it. Source: Landau & Lifshitz, Mechanics, eq. 37.12.

    >>> print(f"{period(free_top([1, 1, 2], [0.1, 0, 1])):.6f}")  # 2 pi A/((C - A) w_3) of a symmetric body
    6.283185
    """
    if top.modulus is None:
        return np.inf if top.motion == "separatrix" else np.nan
    with digits():
        return float(4 * top.modulus.quarter / top.argument_rate)


@with_quantities()
def wobble_rate(top: FreeTop) -> float:
    """The mean rate 2 pi/period, in rad per time, at which the angular velocity circles its axis in the body.

    Positive for the rate of omega itself about the axis c along which it points, where c has the greatest moment;
    negative where c has the least, as of a prolate body: omega circles it backwards. 0 where it does not circle.
    Source: Landau & Lifshitz, Mechanics, section 37.

    >>> print(f"{wobble_rate(free_top([1, 1, 2], [0.1, 0, 1])):.6f}")  # (C - A)/A w_3
    1.000000
    """
    if top.modulus is None:
        return 0.0
    with digits():
        return top.sense * float(PI * top.argument_rate / (2 * top.modulus.quarter))


class _Argument(Protocol):
    """What a free or a heavy top has: u = argument_start + argument_rate t, and its modulus where it is periodic."""

    @property
    def argument_rate(self) -> Decimal: ...

    @property
    def argument_start(self) -> Decimal: ...

    @property
    def modulus(self) -> Modulus | None: ...


def clock(top: _Argument) -> Clock:
    """Turns of 4K of the argument of the elliptic functions, for periodic motion."""
    assert top.modulus is not None
    with digits():
        whole = 4 * top.modulus.quarter
        return Clock(top.argument_start / whole, top.argument_rate / whole)


def elliptic_functions(top: _Argument, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """cn, sn and dn (...,) of the argument, of motion that is not steady; sech, tanh and sech on the separatrix."""
    if top.modulus is not None:
        sn, cn, dn = jacobi(top.modulus, *clock(top).turns(times))
        return cn, sn, dn
    sech, tanh = hyperbolic(top.argument_rate, top.argument_start, times)
    return sech, tanh, sech


def checked_times(times: Array) -> np.ndarray:
    """Times as an array of doubles; ValueError where one is not finite."""
    checked = np.asarray(times, dtype=float)
    if not np.isfinite(checked).all():
        raise ValueError("times of a free rotation must be finite")
    return checked


def _share(difference: Fraction, moment: Fraction) -> Fraction:
    return difference / moment if moment else Fraction(0)  # of a thin rod, whose other moments are equal


def _checked(moments: Sequence[Number], angular_velocity: Sequence[Number]) -> tuple[list[Fraction], list[Fraction]]:
    if len(moments) != 3 or len(angular_velocity) != 3:
        raise ValueError("a free top has three principal moments and three components of angular velocity")
    sizes, rates = [exact(number) for number in moments], [exact(number) for number in angular_velocity]
    least, middle, most = sorted(sizes)
    if least < 0 or (least == 0 and not (0 < middle == most)):
        listed = ", ".join(f"{float(size):g}" for size in sizes)
        raise ValueError(f"the moments of a free top are positive, or one is 0 and the others are equal, not {listed}")
    return sizes, rates
