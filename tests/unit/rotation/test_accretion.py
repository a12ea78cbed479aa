"""Spin-up by accretion: radii, equilibrium, the way there and the line that recycled pulsars keep to."""

import math

import numpy as np
import pytest

from astroinertia.rotation import accretion, pulsars
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS

YEAR = 365.25 * 86400
FIELD, RATE = 1e5, 1e-9 * SOLAR_MASS / YEAR  # 1e9 G


def test_published_numbers():
    # Ghosh & Lamb 1979: 3.2e8 cm for 1e17 g/s, 1 Msun and mu = 1e30 G cm3. (Others balance the ram pressure of the
    # flow with B^2/(8 pi), which leaves 4^(-1/7) of it: 5.1e8 cm at 1e16 g/s in Frank, King & Raine 2002, eq. 6.18.)
    radius = accretion.magnetospheric_radius(1e8, 1e14, mass=SOLAR_MASS, coefficient=1.0)
    assert radius == pytest.approx(3.2e6, rel=0.02)
    slower = accretion.magnetospheric_radius(1e8, 1e13, mass=SOLAR_MASS, coefficient=4 ** (-1 / 7))
    assert slower == pytest.approx(5.1e6, rel=0.01)
    assert accretion.eddington_rate() / SOLAR_MASS * YEAR == pytest.approx(1.5e-8, rel=0.01)
    # Bhattacharya & van den Heuvel 1991: P' = 1.1e-15 P^(4/3) with the whole Alfven radius.
    period = np.array([2e-3, 1e-2, 0.1])
    line = accretion.spin_up_line(period, coefficient=1.0)
    np.testing.assert_allclose(line / period ** (4 / 3), line[0] / period[0] ** (4 / 3), rtol=1e-12)
    np.testing.assert_allclose(line, 1.1e-15 * period ** (4 / 3), rtol=0.2)
    assert 0.1 < accretion.mass_to_spin_up(1e-3, FIELD, RATE) / SOLAR_MASS < 0.25


def test_eddingtons_rate_is_that_of_the_constants():
    # G M Mdot/R is Eddington's luminosity 4 pi G M m_p c/sigma_T, here from astropy's constants.
    from astropy import constants

    rate = (4 * math.pi * constants.m_p * constants.c / constants.sigma_T).si.value * 1.234e4
    assert accretion.eddington_rate(1.234e4) == pytest.approx(rate, rel=1e-6)


def test_equilibrium_is_corotation():
    period = accretion.equilibrium_period(FIELD, RATE)
    edge = accretion.magnetospheric_radius(FIELD, RATE)
    assert edge > 1e4
    assert accretion.corotation_radius(period) == pytest.approx(edge, rel=1e-13)
    assert accretion.equilibrium_period(FIELD, RATE, fastness=0.5) == pytest.approx(2 * period)
    # P ~ B^(6/7) Mdot^(-3/7) until the disc reaches the star, then that of an orbit at its surface.
    assert accretion.equilibrium_period(2 * FIELD, RATE) == pytest.approx(2 ** (6 / 7) * period)
    assert accretion.equilibrium_period(FIELD, RATE / 2) == pytest.approx(2 ** (3 / 7) * period)
    bare = accretion.equilibrium_period(1e-3, RATE)
    assert bare == pytest.approx(2 * math.pi * math.sqrt(1e12 / (GRAVITATIONAL_CONSTANT * accretion.MASS)))
    # The spin-up line is where dipoles in equilibrium are.
    field = pulsars.dipole_field(5e-3, accretion.spin_up_line(5e-3))
    assert accretion.equilibrium_period(field, accretion.eddington_rate()) == pytest.approx(5e-3, rel=1e-12)


def test_spin_goes_to_equilibrium_from_both_sides():
    end = 2 * math.pi / accretion.equilibrium_period(FIELD, RATE)
    times = np.linspace(0.0, 3e9 * YEAR, 6)
    for start in (0.0, 3 * end):
        rates = accretion.spun_up_rate(times, start, FIELD, RATE)
        assert rates[0] == start
        assert np.all(np.diff(np.abs(rates - end)) <= 0)
        assert rates[-1] == pytest.approx(end, rel=1e-3)
    # At rest the whole torque acts: I Omega' = N.
    slope = accretion.spun_up_rate(1e3 * YEAR, 0.0, FIELD, RATE) / (1e3 * YEAR)
    torque = accretion.accretion_torque(FIELD, RATE)
    assert slope * pulsars.CANONICAL_MOMENT == pytest.approx(torque, rel=1e-4)


@pytest.mark.parametrize("name", ["accretion_rate", "mass", "radius"])
def test_stars_that_take_nothing_in_are_refused_by_name(name):
    star = {"field": 1e8, "accretion_rate": 1e13, "mass": accretion.MASS, "radius": 1e4, name: -1.0}
    for function in (accretion.magnetospheric_radius, accretion.equilibrium_period, accretion.accretion_torque):
        with pytest.raises(ValueError, match=f"^{name} must be positive and finite, not -1"):
            function(**star)
    with pytest.raises(ValueError, match=f"^{name} must be positive and finite, not -1"):
        accretion.spin_up_line(0.005, **{key: value for key, value in star.items() if key != "field"})
    with pytest.raises(ValueError, match="mass must be positive and finite, not -1"):
        accretion.corotation_radius(1.0, -1.0)
    with pytest.raises(ValueError, match="radius must be positive"):
        accretion.eddington_rate(0.0)


def test_whole_numbers_of_the_spin_up_line_do_not_overflow():
    """R^6 of 10 km is 1e24 m6 and the square of 1e14 kg/s 1e28, beyond 64 bits."""
    exact = accretion.spin_up_line(5e-3, 1e14, radius=1e4)
    assert accretion.spin_up_line(5e-3, 10**14, radius=10**4) / exact == pytest.approx(1, rel=1e-14)
