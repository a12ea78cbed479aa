"""Complex compliances against the creep of the same solids in time, and how much heat they make."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad

from astroinertia.matter import rheology


def transformed(creep, frequency):
    """i omega times the integral of J(t) exp(-i omega t) over all t, with t = s/(i omega), over s."""
    parts = [
        quad(lambda s, f=f: f(creep(s / (1j * frequency)) * np.exp(-s)), 0, 80, epsabs=1e-12)[0]
        for f in (np.real, np.imag)
    ]
    return complex(*parts)


@pytest.mark.parametrize("frequency", [0.05, 1.0, 30.0])
def test_compliances_are_those_of_the_creep_in_time(frequency):
    for found, creep in (
        (rheology.maxwell(frequency, 3.0), lambda t: 1 + t / 3.0),
        (rheology.andrade(frequency, 3.0, 0.3), lambda t: 1 + t / 3.0 + (t / 3.0) ** 0.3),
        (rheology.andrade(frequency, 3.0, 0.4, 0.5), lambda t: 1 + t / 3.0 + (t / 0.5) ** 0.4),
        (rheology.andrade(frequency, 0.5, 0.3), lambda t: 1 + t / 0.5 + (t / 0.5) ** 0.3),
    ):
        assert found == pytest.approx(transformed(creep, frequency), rel=1e-7)


def test_a_dashpot_beside_a_spring_delays_it():
    # its creep 1 - exp(-t/tau), whose integral over all t is (1/(i omega) - 1/(i omega + 1/tau))
    frequency, late = 0.7, 2.0
    exact = 1 - 1j * frequency / (1j * frequency + 1 / late)
    assert rheology.kelvin_voigt(frequency, late) == pytest.approx(exact, rel=1e-15)
    both = rheology.burgers(frequency, 3.0, 0.5, late)
    assert both == pytest.approx(1 + 1 / (3j * frequency) + 0.5 * exact, rel=1e-15)
    with pytest.raises(ValueError, match="between 0 and 1"):
        rheology.andrade(1.0, 1.0, 1.0)


@pytest.mark.parametrize(("exponent", "frequency"), [(0.15, 1e-5), (0.3, 1e-3), (0.5, 7.0)])
def test_an_absorption_band_is_creep_by_a_power_of_time(exponent, frequency):
    quality, reference = 80.0, 2.0
    found = rheology.absorption_band(frequency, quality, reference, exponent)
    # the same with the elastic compliance that is left at high frequencies, and Andrade's creep without Maxwell's
    at_once = 1 - 1 / (quality * np.tan(exponent * np.pi / 2))
    assert rheology.absorption_band(1e40, quality, reference, exponent) == pytest.approx(at_once, rel=1e-4)
    decay = (math.gamma(1 + exponent) * np.sin(exponent * np.pi / 2) * quality * at_once) ** (1 / exponent) / reference
    assert found == pytest.approx(at_once * rheology.andrade(frequency, np.inf, exponent, decay), rel=1e-12)
    own = rheology.absorption_band(reference, quality, reference, exponent)
    assert own == pytest.approx(1 - 1j / quality, rel=1e-14)
    ratio = rheology.absorption_band(2 * frequency, quality, reference, exponent).imag / found.imag
    assert ratio == pytest.approx(0.5**exponent, rel=1e-13)


def test_an_absorption_band_of_constant_quality_disperses_by_the_logarithm():
    found = rheology.absorption_band(np.array([1e-4, 1.0, 10.0]), 200.0, 1.0, 1e-7)
    np.testing.assert_allclose(found, 1 + (2 / np.pi * np.log([1e4, 1.0, 0.1]) - 1j) / 200.0, rtol=3e-8)
    for exponent in (0.0, 1.0, -0.2):
        with pytest.raises(ValueError, match="between 0 and 1"):
            rheology.absorption_band(1.0, 100.0, 1.0, exponent)


@pytest.mark.parametrize("frequency", [1e-4, 0.5, 1.0 - 1e-6])
def test_a_band_of_almost_constant_quality_keeps_the_digits_of_its_dispersion(frequency):
    exponent, quality = 1e-6, 100.0  # cot(alpha pi/2) (x - 1) by mpmath, of which x - 1 by itself loses 1e-10 and more
    with mpmath.workdps(40):
        growth = (1 / mpmath.mpf(frequency)) ** mpmath.mpf(exponent) - 1
        wanted = float(growth * mpmath.cot(mpmath.mpf(exponent) * mpmath.pi / 2)) / quality
    found = rheology.absorption_band(frequency, quality, 1.0, exponent)
    assert found.real - 1.0 == pytest.approx(wanted, rel=1e-14, abs=3e-16)


def test_heat_is_greatest_at_the_relaxation_time_of_the_whole_body():
    rates = np.logspace(-2, 2, 4001)
    heat = rheology.dissipation(0.3, 1.5, rates, 4.0)
    assert heat.max() == pytest.approx((1.5 - 0.3) / 2, rel=1e-6)  # a Debye peak
    assert rates[heat.argmax()] == pytest.approx(0.3 / 1.5 / 4.0, rel=2e-3)
    creeping = rheology.dissipation(0.3, 1.5, rates, 4.0, 0.3)
    fast = np.polyfit(np.log(rates[-400:]), np.log([heat[-400:], creeping[-400:]]).T, 1)[0]
    assert (
        fast[0] == pytest.approx(-1, abs=0.01) and -0.5 < fast[1] < -0.3
    )  # Andrade's falls as omega^-alpha in the end


@pytest.mark.parametrize("exponent", [1e-6, 0.15, 0.9])
def test_at_negative_frequencies_every_law_is_its_conjugate(exponent):
    rates = np.array([1e-6, 1e-4, 3.0])
    for law in (
        lambda w: rheology.absorption_band(w, 100.0, 1.0, exponent),
        lambda w: rheology.maxwell(w, 2e4),
        lambda w: rheology.andrade(w, 2e4, exponent),
    ):
        np.testing.assert_allclose(law(-rates), np.conj(law(rates)), rtol=1e-12)
