"""Contracting planets and young stars."""

import math

import numpy as np
import pytest

from astroinertia.rotation import contraction
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SOLAR_RADIUS, STEFAN_BOLTZMANN_CONSTANT

SUN = 3.828e26  # W, IAU 2015 nominal
YEAR = 365.25 * 86400


def test_binding():
    assert contraction.binding_factor(1.5) == pytest.approx(3 / 7)
    assert contraction.binding_factor(3.0, 4 / 3) == pytest.approx(0.0, abs=1e-15)
    assert contraction.binding_factor(0.0) == pytest.approx(0.3)
    time = contraction.kelvin_helmholtz_time(SOLAR_MASS, SOLAR_RADIUS, SUN, 3.0)
    assert time / YEAR == pytest.approx(0.75 * 31.4e6, rel=0.01)  # G M^2/(R L) is 31.4 Myr


@pytest.mark.parametrize("track", ["luminosity", "temperature"])
def test_what_is_radiated_is_what_is_lost(track):
    mass, radius, warm = 1e27, 1.4e8, 500.0
    luminosity = 4 * math.pi * radius**2 * STEFAN_BOLTZMANN_CONSTANT * warm**4
    times = np.linspace(0.0, 3e6 * YEAR, 20001)
    if track == "luminosity":
        radii = contraction.radius_at_luminosity(times, mass, radius, luminosity)
        power = np.full_like(times, luminosity)
    else:
        radii = contraction.radius_at_temperature(times, mass, radius, warm)
        power = luminosity * (radii / radius) ** 2
    assert radii[0] == radius and radii[-1] < 0.8 * radius
    lost = 3 / 7 * GRAVITATIONAL_CONSTANT * mass**2 * (1 / radii[-1] - 1 / radius)
    assert np.trapezoid(power, times) == pytest.approx(lost, rel=1e-6)


def test_what_does_not_radiate_keeps_its_size():
    assert contraction.kelvin_helmholtz_time(1e27, 1.4e8, 0.0) == math.inf
    for law in (contraction.radius_at_luminosity, contraction.radius_at_temperature):
        np.testing.assert_array_equal(law([0.0, 1e9 * YEAR], 1e27, 1.4e8, 0.0), [1.4e8, 1.4e8])


def test_a_disc_holds_the_period_until_it_is_gone():
    radii = np.array([5.0, 3.0, 2.0, 1.0])
    np.testing.assert_allclose(contraction.contracted_period(8.0, 5.0, radii), 8.0 * (radii / 5) ** 2)
    np.testing.assert_allclose(contraction.contracted_period(8.0, 5.0, radii, 2.0), [8.0, 8.0, 8.0, 2.0])


def test_a_body_that_swells_slows_down():
    """Angular momentum is kept either way; a disc holds only what shrinks."""
    np.testing.assert_allclose(contraction.contracted_period(1.0, 1.0, [0.5, 1.0, 2.0, 4.0]), [0.25, 1.0, 4.0, 16.0])
    np.testing.assert_allclose(contraction.contracted_period(8.0, 5.0, [10.0], 2.0), [32.0])


def test_sizes_that_no_body_has_are_refused():
    with pytest.raises(ValueError, match="radius_after must be positive"):
        contraction.contracted_period(9.0, 1.0, -3.0)
    scale = contraction.kelvin_helmholtz_time(SOLAR_MASS, SOLAR_RADIUS, 3.828e26)
    for law, last in ((contraction.radius_at_luminosity, 3.828e26), (contraction.radius_at_temperature, 5772.0)):
        with pytest.raises(ValueError, match="infinite size"):
            law(-1.1 * scale, SOLAR_MASS, SOLAR_RADIUS, last)


def test_what_is_negative_is_refused():
    """Of a negative mass the time was positive, and of a negative radius the body swelled with time."""
    sun = {"mass": 1.989e30, "radius": 6.957e8}
    for name in ("mass", "radius", "luminosity"):
        wrong = {**sun, "luminosity": 3.8e26, name: -1.0}
        with pytest.raises(ValueError, match=f"{name} must not be negative, not -1"):
            contraction.kelvin_helmholtz_time(**wrong)
        with pytest.raises(ValueError, match=f"{name} must not be negative, not -1"):
            contraction.radius_at_luminosity(1e14, **wrong)
    with pytest.raises(ValueError, match="effective_temperature must not be negative"):
        contraction.radius_at_temperature(1e14, **sun, effective_temperature=-5772.0)


def test_a_temperature_in_whole_kelvin():
    """(1e5 K)^4 is 1e20 K4, beyond 64 bits."""
    hot = (1e9 * YEAR, SOLAR_MASS, SOLAR_RADIUS)
    assert contraction.radius_at_temperature(*hot, 10**5) == contraction.radius_at_temperature(*hot, 1e5)
