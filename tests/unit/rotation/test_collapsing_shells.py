"""Collapse shell by shell: what stays, what shears, and what cannot fall."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.rotation.collapsing_shells import (
    isothermal_disc_radius,
    mass_quadrature,
    shells_from_table,
    shells_of,
)

UNIFORM = Polytrope(0.0, 2.0, 3.0)


@pytest.mark.parametrize("index", [0.0, 1.0, 1.5, 3.0, 4.5])
def test_moments_are_those_of_the_body(index):
    body = Polytrope(index, 2.0, 3.0)
    shells = shells_of(body, 0.7, gravitational_constant=1.0)
    assert shells.moment_of_inertia == pytest.approx(body.moment_of_inertia, rel=1e-10)
    assert shells.angular_momentum == pytest.approx(0.7 * body.moment_of_inertia, rel=1e-10)
    assert shells.rotational_energy == pytest.approx(0.5 * 0.49 * body.moment_of_inertia, rel=1e-10)
    assert shells.mass.sum() == pytest.approx(2.0, rel=1e-14)


def test_homologous_collapse_stays_rigid_and_another_does_not():
    before = shells_of(Polytrope(3.0, 1.4, 1500.0), 0.06, gravitational_constant=1.0)
    homologous = before.collapsed(before.radius / 100)
    np.testing.assert_allclose(homologous.angular_velocity, 600.0, rtol=1e-13)
    assert homologous.shear_energy < 1e-20 * homologous.rotational_energy
    star = Polytrope(1.0, 1.4, 12.0)
    after = before.collapsed(star.radius_enclosing(before.enclosed_mass))
    assert after.angular_momentum == pytest.approx(before.angular_momentum, rel=1e-14)
    assert np.all(np.diff(after.angular_velocity) > 0)  # the n = 3 envelope falls by more than its core
    # The mean is what the whole body would turn at by L = I omega, and shear is energy that friction can set free.
    assert after.mean_angular_velocity == pytest.approx(before.angular_momentum / star.moment_of_inertia, rel=1e-10)
    locked = after.locked()
    assert locked.angular_momentum == pytest.approx(after.angular_momentum, rel=1e-14)
    assert after.shear_energy > 0
    assert after.rotational_energy - locked.rotational_energy == pytest.approx(after.shear_energy, rel=1e-10)


def test_the_spectrum_is_mestels_and_the_same_after_any_collapse():
    before = shells_of(UNIFORM, 0.5, 400, 1.0)
    j = np.linspace(0.0, 6.0, 50)
    exact = 2.0 * (1 - (1 - np.minimum(j / 4.5, 1)) ** 1.5)
    np.testing.assert_allclose(before.spectrum(j), exact, atol=2e-7)
    errors = [np.abs(shells_of(UNIFORM, 0.5, count, 1.0).spectrum(j) - exact).max() for count in (20, 80)]
    assert errors[1] < errors[0] / 64  # third order
    # Where hardly any matter has so little, near the axis: of 160 shells.
    low = 4.5 * np.array([1e-6, 1e-3, 0.1])
    exact = 2.0 * (1 - (1 - low / 4.5) ** 1.5)
    np.testing.assert_allclose(shells_of(UNIFORM, 0.5, gravitational_constant=1.0).spectrum(low), exact, rtol=1e-5)
    after = before.collapsed(0.01 * before.radius**1.7)
    np.testing.assert_allclose(after.spectrum(j), before.spectrum(j), rtol=1e-13)
    assert before.spectrum(np.array(0.0)) == 0.0 and before.spectrum(1e9) == pytest.approx(2.0)
    backwards = shells_of(UNIFORM, -0.5, 400, 1.0)
    np.testing.assert_array_equal(backwards.spectrum(j), before.spectrum(j))


def test_the_spectrum_of_shells_that_turn_the_slower_the_farther_out():
    radius = np.linspace(0.0, 1.0, 801)[1:]
    highest = 2.0 - radius**2
    shells = shells_from_table(radius**3, radius, highest / radius**2, 1.0)
    for j in (0.3, 1.2, 1.9):
        # A sphere of uniform density, shell by shell.
        below, _ = quad(lambda r, j=j: 3 * r**2 * (1 - math.sqrt(max(0.0, 1 - j / (2 - r**2)))), 0.0, 1.0, limit=200)
        assert shells.spectrum(j) == pytest.approx(below, abs=1e-5)


def test_shells_stop_at_their_barrier():
    before = shells_of(UNIFORM, 0.05, gravitational_constant=1.0)
    barrier = before.centrifugal_radius
    np.testing.assert_allclose(barrier, 0.05**2 * before.radius**4 / before.enclosed_mass, rtol=1e-14)
    assert not before.critical.any()
    at = before.collapsed(barrier)
    np.testing.assert_allclose(at.keplerian_fraction, 1.0, rtol=1e-12)
    # Uniform density: the barrier goes as r, so that a fall by one factor meets all barriers at once.
    share = float(barrier[0] / before.radius[0])
    assert before.collapsed(0.999 * share * before.radius).critical.all()
    assert not before.collapsed(1.001 * share * before.radius).critical.any()
    # A centrally condensed body meets them from the outside inwards.
    star = shells_of(Polytrope(3.0, 2.0, 3.0), 0.05, gravitational_constant=1.0)
    fallen = star.collapsed(np.median(star.centrifugal_radius / star.radius) * star.radius)
    assert fallen.critical.any() and not fallen.critical.all()
    assert np.all(np.diff(fallen.critical.astype(int)) >= 0)


def test_the_disc_of_a_cloud():
    cloud = shells_of(UNIFORM, 0.05, 400, 1.0)
    edge = 0.05**2 * 3.0**4 / 2.0  # Omega^2 R^4/(G M)
    radius = np.linspace(0.0, 1.5, 31) * edge
    exact = 2.0 * (1 - (1 - np.minimum(np.sqrt(radius / edge), 1)) ** 1.5)  # Mestel's, with j^2 = G M R
    np.testing.assert_allclose(cloud.disc_mass_inside(radius), exact, atol=2e-7)
    # Terebey, Shu & Cassen's: 0.5 solar masses, 1e-14 /s and 0.2 km/s give some tens of au.
    expected = isothermal_disc_radius(1e30, 1e-14, 200.0)
    assert expected == pytest.approx((6.6743e-11 * 1e30) ** 3 * 1e-28 / (16 * 200.0**8), rel=1e-12)
    np.testing.assert_allclose(isothermal_disc_radius([0.0, 2e30], 1e-14, 200.0), [0.0, 8 * expected], rtol=1e-12)
    with pytest.raises(ValueError, match="mass"):
        isothermal_disc_radius(-1e30, 1e-14, 200.0)


def test_a_table_of_a_stellar_model():
    radius = np.linspace(0.0, 3.0, 2001)[1:]
    mass = 2.0 * (radius / 3.0) ** 3
    shells = shells_from_table(mass, radius, np.full(2000, 0.5), 1.0)
    assert shells.moment_of_inertia == pytest.approx(UNIFORM.moment_of_inertia, rel=1e-6)
    assert shells.mass.sum() == pytest.approx(2.0, rel=1e-14)
    np.testing.assert_array_equal(mass_quadrature(20.0), mass_quadrature(20))  # a whole number of any type
    for wrong in (mass[::-1], mass[:-1], -mass):
        with pytest.raises(ValueError, match="table of shells"):
            shells_from_table(wrong, radius, np.full(2000, 0.5))


def test_what_is_no_collapse_is_refused():
    shells = shells_of(UNIFORM, 0.5, 20, 1.0)
    for radius in (shells.radius[:-1], 0 * shells.radius, math.nan * shells.radius):
        with pytest.raises(ValueError, match="positive radius for each of the 20"):
            shells.collapsed(radius)
    with pytest.raises(ValueError, match="not negative"):
        shells.spectrum([0.1, -0.1])
    with pytest.raises(ValueError, match="at least 8 shells"):
        shells_of(UNIFORM, 0.5, 4)
    with pytest.raises(ValueError, match="whole number"):
        mass_quadrature(20.5)


def test_shells_have_the_gravitational_constant_of_their_body():
    share = shells_of(Polytrope(1.5), 0.5).keplerian_fraction
    np.testing.assert_allclose(share, shells_of(Polytrope(1.5, 2.0, 2.0, 4.0), 0.5).keplerian_fraction, rtol=1e-9)
    assert shells_of(Polytrope(1.5), 0.5, gravitational_constant=7.0).gravitational_constant == 7.0
