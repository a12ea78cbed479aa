"""Elliptic integrals to 60 digits, and Jacobi's functions of any modulus to round-off, also far along and next to 1.

A motion that is followed for thousands of periods is known no better than its period, so the constants of a motion
are worked out once in extended precision; what depends on time is then evaluated in double precision, for whole
arrays, within an eighth of a period of a multiple of a quarter: there nothing cancels, and values next to a zero keep
all their digits. Series in the nome of the modulus serve up to k^2 = 1/2, beyond it those in the nome of the
complementary modulus k' (Jacobi's imaginary transformation), which get shorter as k goes to 1.

Source: DLMF chapters 19, 20 and 22 (https://dlmf.nist.gov).
"""

from dataclasses import dataclass
from decimal import Context, Decimal, getcontext, localcontext
from fractions import Fraction
from functools import cached_property
from numbers import Rational
from typing import Any

import numpy as np

from astroinertia.inertia.eigen import two_sum

Number = Any
"""A float, or an exact number: an int, a Fraction, a Decimal or a decimal string such as "0.1"."""

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")
_DIGITS = 60
_CONTEXT = Context(prec=_DIGITS, Emax=999_999_999, Emin=-999_999_999)
_HALF_CONVERGED = Decimal(10) ** (-_DIGITS // 2 - 1)  # quadratic convergence: the next step has all digits
_NEAR_EQUAL = Decimal(10) ** (-_DIGITS // 6)  # Carlson's series is cut off at the sixth power of this
_NEGLIGIBLE = 45.0  # terms below exp(-45) of the leading one are left out
_SPLITTER = 134217729.0  # 2^27 + 1: Dekker's, for the halves of a double


def digits(count: int = _DIGITS):
    """A context in which Decimals carry 60 digits or as many as given, whatever the caller's own is."""
    return localcontext(_CONTEXT, prec=count)


def exact(value: Number) -> Fraction:
    """The exact value of a number; a decimal string is that decimal, and a float what its bits say.

    ValueError where it is not a finite number.
    """
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        value = value.item()
    try:
        return Fraction(value if isinstance(value, str | Rational | Decimal) else float(value))
    except (ValueError, OverflowError, TypeError):
        raise ValueError(f"moments, rates and angles of a top must be finite numbers, not {value!r:.60}") from None


def decimal(value: Fraction) -> Decimal:
    """A fraction to all digits; within `digits()`."""
    return Decimal(value.numerator) / Decimal(value.denominator)


def sine_and_cosine(angle: Fraction) -> tuple[Decimal, Decimal]:
    """Sine and cosine of an angle of a few radians, to all digits of `digits()`."""
    size, term, sums, n = decimal(angle), Decimal(1), [Decimal(0), Decimal(0)], 0
    while n < 2 or (term and term.adjusted() > sums[1].adjusted() - getcontext().prec):
        sums[n % 2] += term if n % 4 < 2 else -term
        n += 1
        term = term * size / n
    return sums[1], sums[0]


def arithmetic_geometric_mean(one: Decimal, other: Decimal) -> Decimal:
    """Gauss's mean of two positive numbers; within `digits()`. Source: DLMF 19.8.1."""
    while True:
        mean, one_before = (one + other) / 2, one
        if abs(one - other) <= _HALF_CONVERGED * mean:
            return (mean + (one_before * other).sqrt()) / 2
        one, other = mean, (one * other).sqrt()


def carlson_rf(x: Decimal, y: Decimal, z: Decimal) -> Decimal:
    """Carlson's R_F of numbers that are not negative, at most one of them zero; within `digits()`.

    Source: Carlson (1995), Numer. Algorithms 10, 13, by duplication.
    """
    while True:
        mean = (x + y + z) / 3
        deviations = [1 - value / mean for value in (x, y, z)]
        if max(abs(value) for value in deviations) <= _NEAR_EQUAL:
            second = -sum((deviation**2 for deviation in deviations), Decimal(0)) / 2
            third = deviations[0] * deviations[1] * deviations[2]
            series = 1 - second / 10 + third / 14 + second**2 / 24 - 3 * second * third / 44
            return series / mean.sqrt()
        roots = [value.sqrt() for value in (x, y, z)]
        shift = roots[0] * roots[1] + roots[1] * roots[2] + roots[2] * roots[0]
        x, y, z = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4


def complete_integral(complement: Decimal, weight: Decimal, cosine_part: Decimal, sine_part: Decimal) -> Decimal:
    """The general complete elliptic integral cel(k', p, a, b), for k' > 0 and p > 0; within `digits()`.

    The integral from 0 to pi/2 of (a cos^2 + b sin^2)/((cos^2 + p sin^2) sqrt(cos^2 + k'^2 sin^2)); without
    cancellation where a and b have one sign. Source: Bulirsch (1969), Numer. Math. 13, 305; DLMF 19.2.11.
    """
    k, product, m, p = complement, complement, Decimal(1), weight.sqrt()
    a, b = cosine_part, sine_part / p
    while True:
        a, b, p, m_before = a + b / p, 2 * (b + a * product / p), p + product / p, m
        m += k
        if abs(m_before - k) <= _HALF_CONVERGED * m_before:
            return PI / 2 * (b + a * m) / (m * (m + p))
        k = 2 * product.sqrt()
        product = k * m


@dataclass(frozen=True)
class Modulus:
    """A modulus k by its square and the square of its complement k', which keeps the digits next to k = 1.

    Both of 60 digits, from 0 to 1; k' is not 0. Source: DLMF 22.2.
    """

    square: Decimal
    complement_square: Decimal

    @cached_property
    def quarter(self) -> Decimal:
        """K, a quarter of the period of sn and cn."""
        with digits():
            return PI / (2 * arithmetic_geometric_mean(Decimal(1), self.complement_square.sqrt()))

    @cached_property
    def complementary_quarter(self) -> Decimal:
        """K' = K(k'), a half of the imaginary period of sn; infinite for k = 0."""
        with digits():
            if not self.square:
                return Decimal("Infinity")
            return PI / (2 * arithmetic_geometric_mean(Decimal(1), self.square.sqrt()))

    @cached_property
    def complementary(self) -> bool:
        """Whether series are in the nome of k' and not of k."""
        return self.square > self.complement_square

    @cached_property
    def log_nome(self) -> float:
        """The logarithm of the nome of the series, at most -pi."""
        with digits():
            ratio = self.complementary_quarter / self.quarter
            return float(-PI / ratio) if self.complementary else float(-PI * ratio)

    @cached_property
    def _prefactor(self) -> float:
        """2 q^(1/4)/sqrt(k) of whichever nome and its modulus: 1 for a nome of 0."""
        with digits():
            if not self.square:
                return 1.0
            ratio = self.complementary_quarter / self.quarter
            exponent = -PI / ratio if self.complementary else -PI * ratio
            modulus = self.complement_square if self.complementary else self.square
            return float(2 * (exponent / 4).exp() / modulus.sqrt().sqrt())

    @cached_property
    def _roots(self) -> tuple[float, float]:
        """sqrt(k) and sqrt(k')."""
        with digits():
            return float(self.square.sqrt().sqrt()), float(self.complement_square.sqrt().sqrt())

    def incomplete(self, sine: Decimal, cosine_square: Decimal, delta_square: Decimal, ahead: bool) -> Decimal:
        """The u of given sn, cn^2, dn^2, all in 60 digits, from -2K to 2K; `ahead` says that cn is not negative.

        Source: DLMF 19.25.5 and 22.15.
        """
        with digits():
            argument = sine * carlson_rf(cosine_square, delta_square, Decimal(1))
            return argument if ahead else (2 * self.quarter).copy_sign(sine) - argument


def _first_terms(log_nome: float, odd: bool) -> list[tuple[int, float]]:
    """Number of each term of a theta series that counts, and its factor: q^(n(n+1)) of odd multiples, else q^(n^2).

    For arguments that lie within a quarter of the imaginary period, where a term of odd multiples 2n + 1 of the
    argument has grown by at most q^(-n/2), as has one of even multiples 2n.
    """
    terms = []
    for n in range(8):
        power = n * (n + 1) if odd else n * n
        if n and (power - 0.5 * n) * log_nome < -_NEGLIGIBLE:
            break
        terms.append((n, float(np.exp(power * log_nome)) if n else 1.0))
    return terms


def jacobi(modulus: Modulus, quarters: np.ndarray, rest: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """sn, cn and dn, each (...,), at u = 4K (quarters/4 + rest), with whole quarters and |rest| up to an eighth.

    Relative error below 3e-15 + 1e-15 K|rest|, also where a function is next to 0. Source: DLMF 22.2.4 to 22.2.6,
    20.2 and 20.7(viii).
    """
    odd, even = _first_terms(modulus.log_nome, True), _first_terms(modulus.log_nome, False)
    root, other_root = modulus._roots
    prefactor = modulus._prefactor
    if modulus.complementary:
        # theta_1 .. theta_4 of u and k go with theta_1, theta_4, theta_3, theta_2 of iu and k'
        argument = -2.0 * modulus.log_nome * rest
        one = sum((-1) ** n * factor * np.sinh((2 * n + 1) * argument) for n, factor in odd)
        four = sum(factor * np.cosh((2 * n + 1) * argument) for n, factor in odd)
        three = 1.0 + 2.0 * sum(factor * np.cosh(2 * n * argument) for n, factor in even[1:])
        two = 1.0 + 2.0 * sum((-1) ** n * factor * np.cosh(2 * n * argument) for n, factor in even[1:])
        small = other_root * prefactor  # 2 q'^(1/4)
        near = one / (root * four), two / (prefactor * root * four), three / (prefactor * four)
        beyond = two / (root * three), -other_root / root * small * one / three, other_root * small * four / three
    else:
        argument = 2.0 * np.pi * rest
        one = sum((-1) ** n * factor * np.sin((2 * n + 1) * argument) for n, factor in odd)
        two = sum(factor * np.cos((2 * n + 1) * argument) for n, factor in odd)
        three = 1.0 + 2.0 * sum(factor * np.cos(2 * n * argument) for n, factor in even[1:])
        four = 1.0 + 2.0 * sum((-1) ** n * factor * np.cos(2 * n * argument) for n, factor in even[1:])
        near = prefactor * one / four, prefactor * other_root * two / four, other_root * three / four
        beyond = prefactor * two / three, -prefactor * other_root * one / three, other_root * four / three
    shifted, turned = quarters % 2 == 1, np.where(quarters % 4 >= 2, -1.0, 1.0)
    sn, cn, dn = (np.where(shifted, b, a) for a, b in zip(near, beyond, strict=True))
    return turned * sn, turned * cn, dn


@dataclass(frozen=True)
class Clock:
    """Turns that go on at a constant rate: start + rate x time, kept to 60 digits, known to round-off of one turn."""

    start: Decimal
    rate: Decimal

    def turns(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Quarters of a turn (...,), whole numbers from -2 to 2, and the rest (...,) of a turn, up to an eighth.

        The error of the rest is 1e-16 of itself and 1e-32 of all turns.
        """
        with digits():
            start = self.start - self.start.to_integral_value()
            high, low = two_parts(self.rate, Decimal(0), times)
            start_high, start_low = _pair(start)
        high, more = two_sum(high - np.rint(high), low - np.rint(low))
        high, last = two_sum(high, np.float64(start_high))
        quarters = np.rint(4.0 * high)
        rest = (high - 0.25 * quarters) + (more + last + start_low)
        return (quarters.astype(int) + 2) % 4 - 2, rest


def hyperbolic(rate: Decimal, start: Decimal, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """sech u and tanh u (...,) at u = start + rate x time, sech to round-off of itself; Jacobi's functions for k = 1.

    Test: tests/unit/rotation/test_free_top.py.
    """
    with digits():
        high, low = two_parts(rate, start, times)
    sign = np.where(high < 0, -1.0, 1.0)
    falling = np.exp(-sign * high) * (1.0 - sign * low)
    return 2.0 * falling / (1.0 + falling**2), np.tanh(high + low)


def unit(quarters: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """exp(2 pi i (quarters/4 + rest)), (...,): a Clock's turns as a point of the circle, exact in the quarters."""
    return np.array([1.0, 1.0j, -1.0, -1.0j])[quarters % 4] * np.exp(2.0j * np.pi * rest)


def two_parts(rate: Decimal, start: Decimal, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """start + rate x times as a double (...,) and what it lacks (...,), to 1e-32; within `digits()`.

    Source: Dekker (1971), Numer. Math. 18, 224.
    """
    (rate_high, rate_low), (start_high, start_low) = _pair(rate), _pair(start)
    high, low = _product(rate_high, times)
    high, more = two_sum(high, np.float64(start_high))
    return two_sum(high, low + more + (rate_low * times + start_low))


def _pair(value: Decimal) -> tuple[float, float]:
    high = float(value)
    return high, float(value - Decimal(high))


def _product(one: Any, other: Any) -> tuple[Any, Any]:
    """Product and its rounding (Dekker)."""
    product = one * other
    (one_high, one_low), (other_high, other_low) = _halves(one), _halves(other)
    low = ((one_high * other_high - product) + one_high * other_low + one_low * other_high) + one_low * other_low
    return product, low


def _halves(value: Any) -> tuple[Any, Any]:
    large = _SPLITTER * value
    high = large - (large - value)
    return high, value - high
