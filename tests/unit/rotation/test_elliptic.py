"""Elliptic integrals and functions against mpmath, and turns that are counted without losing the last one."""

from decimal import Decimal, getcontext
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

from astroinertia.rotation import elliptic

MODULI = ["0", "1e-30", "1e-6", "0.3", "0.5", "0.5000001", "0.98", "1 - 1e-8", "1 - 1e-16", "1 - 1e-40"]


def modulus_of(text):
    square = Fraction(1) - Fraction(text[4:]) if text.startswith("1 -") else Fraction(text)
    with elliptic.digits():
        return elliptic.Modulus(elliptic.decimal(square), elliptic.decimal(1 - square)), square


def mpf(value):
    return mp.mpf(str(value)) if isinstance(value, Decimal) else mp.mpf(value.numerator) / value.denominator


@pytest.mark.parametrize("text", MODULI)
def test_quarters_of_the_period_have_sixty_digits(text):
    modulus, square = modulus_of(text)
    with mp.workdps(400):
        assert abs(mpf(modulus.quarter) / mp.ellipk(mpf(square)) - 1) < 1e-57
        if square:
            assert abs(mpf(modulus.complementary_quarter) / mp.ellipk(1 - mpf(square)) - 1) < 1e-57
    assert getcontext().prec == 28  # the caller's own


@pytest.mark.parametrize("text", MODULI)
def test_jacobis_functions_keep_all_digits_next_to_their_zeros(text):
    modulus, square = modulus_of(text)
    rest = np.array([-0.125, -1e-3, 0.0, 1e-100, 0.03, 0.125])
    for quarters in range(-1, 3):
        found = elliptic.jacobi(modulus, np.full(len(rest), quarters), rest)
        with mp.workdps(300):  # next to quarters a whole period of K hides the rest
            m = mpf(square)
            turn = 4 * mp.ellipk(m)
            expected = [
                [float(mp.ellipfun(name, turn * (mp.mpf(quarters) / 4 + mp.mpf(float(y))), m=m)) for y in rest]
                for name in ("sn", "cn", "dn")
            ]
        limit = 3e-15 + 1e-15 * float(modulus.quarter) / 8
        np.testing.assert_allclose(found, expected, rtol=limit, atol=1e-290)


@pytest.mark.parametrize("text", ["0", "0.3", "0.98", "1 - 1e-16"])
@pytest.mark.parametrize("angle", [-3.0, -1.6, -0.2, 0.0, 1e-9, 0.7, 1.5707, 1.6, 3.1])
def test_the_argument_of_an_amplitude(text, angle):
    modulus, square = modulus_of(text)
    with mp.workdps(100):
        sine, cosine = mp.sin(mp.mpf(angle)), mp.cos(mp.mpf(angle))
        delta = 1 - mpf(square) * sine**2
        found = modulus.incomplete(*(Decimal(mp.nstr(x, 60)) for x in (sine, cosine**2, delta)), ahead=cosine >= 0)
        assert abs(mpf(found) - mp.ellipf(mp.mpf(angle), mpf(square))) < mp.mpf(10) ** -50


@pytest.mark.parametrize("weight", ["1e-12", "0.4", "1", "7", "1e24"])
@pytest.mark.parametrize("complement", ["1", "0.6", "1e-8", "1e-40"])
def test_the_general_complete_integral_is_one_of_the_third_kind(weight, complement):
    with elliptic.digits():
        found = elliptic.complete_integral(Decimal(complement), Decimal(weight), Decimal("0.7"), Decimal("2"))
    with mp.workdps(250):
        p, m = mp.mpf(weight), 1 - mp.mpf(complement) ** 2
        a, b, whole = mp.mpf("0.7"), mp.mpf(2), mp.ellipk(m)
        if p == 1:
            expected = a * whole + (b - a) * mp.elliprd(0, 1 - m, 1) / 3
        else:  # a cos^2 + b sin^2 is a multiple of cos^2 + p sin^2 and a constant
            share = (b - a) / (p - 1)
            expected = share * whole + (a - share) * mp.ellippi(1 - p, m)
        assert abs(mpf(found) / expected - 1) < 1e-50


@pytest.mark.parametrize("time", [0.0, 1e-300, 0.125, 3.7, 1e6, -123456.789, 1e15])
def test_turns_are_counted_to_the_last_digit_of_one_of_them(time):
    with elliptic.digits():
        start, rate = Decimal(1) / 3 + 5, Decimal(2).sqrt()
    quarters, rest = elliptic.Clock(start, rate).turns(np.array([time]))
    exact = (Fraction(start) + Fraction(rate) * Fraction(time)) % 1
    error = (exact - Fraction(int(quarters[0]), 4) - Fraction(float(rest[0]))) % 1
    assert min(error, 1 - error) < 1e-16 * abs(rest[0]) + 1e-30 * abs(time)
    assert abs(rest[0]) <= 0.125 + 1e-15
    expected = np.exp(2j * np.pi * float(exact))
    np.testing.assert_allclose(elliptic.unit(quarters, rest), [expected], rtol=0, atol=1e-15)


@pytest.mark.parametrize("angle", ["0", "1e-40", "0.7", "-1.57", "3.2"])
def test_sines_have_sixty_digits(angle):
    with elliptic.digits():
        found = elliptic.sine_and_cosine(Fraction(angle))
    with mp.workdps(90):
        for value, expected in zip(found, (mp.sin(mp.mpf(angle)), mp.cos(mp.mpf(angle))), strict=True):
            assert abs(mpf(value) - expected) <= mp.mpf(10) ** -58 * min(1, abs(mp.mpf(angle)) + (expected > 0.9))


def test_exact_values_of_numbers():
    assert elliptic.exact("0.1") == elliptic.exact(Decimal("0.1")) == Fraction(1, 10)
    assert elliptic.exact(np.float64(0.1)) == Fraction(0.1) != Fraction(1, 10)
    assert elliptic.exact(np.int64(3)) == elliptic.exact(np.array(3.0)) == 3
    for value in (np.inf, np.nan, "a lot", None, Decimal("NaN")):
        with pytest.raises(ValueError, match="finite numbers"):
            elliptic.exact(value)
