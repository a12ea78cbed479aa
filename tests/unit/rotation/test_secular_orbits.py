"""Planes of orbits that turn each other, and obliquities on them: exact sums, published frequencies, and REBOUND."""

import numpy as np
import pytest
import rebound
from astropy import units as u
from scipy.special import ellipe, ellipk

from astroinertia.errors import SceneError
from astroinertia.rotation.precession import ARCSECOND_PER_YEAR, JULIAN_YEAR
from astroinertia.rotation.secular_orbits import laplace_coefficient, node_modes
from astroinertia.rotation.secular_spin import orbit_normal
from astroinertia.studies.obliquity import obliquity_history, planetary_planes


def test_laplace_coefficients():
    for ratio in (1e-3, 0.5, 0.95):
        # b_(1/2)^(0) = 4 K/pi, and b_(3/2)^(1) by its recurrence on K and E.
        assert laplace_coefficient(0.5, 0, ratio) == pytest.approx(4 / np.pi * ellipk(ratio**2), rel=1e-13)
        k, e, s = ellipk(ratio**2), ellipe(ratio**2), ratio**2
        exact = 4 / np.pi / (ratio * (1 - s) ** 2) * ((1 + s) * e - (1 - s) * k)
        assert laplace_coefficient(1.5, 1, ratio) == pytest.approx(exact, rel=1e-9 / ratio**2 * 1e-3 + 1e-12)
    assert laplace_coefficient(1.5, 1, 1e-6) == pytest.approx(3e-6, rel=1e-9)
    with pytest.raises(ValueError, match="below 1"):
        laplace_coefficient(1.5, 1, 1.0)
    with pytest.raises(ValueError, match=r"whole number, not 1\.5"):  # the hypergeometric function is not that integral
        laplace_coefficient(1.5, 1.5, 0.3)


def test_the_solar_system_has_its_frequencies():
    """s1 to s8 of Brouwer & van Woerkom 1950, arc seconds a year, to the accuracy of the lowest order."""
    names, modes = planetary_planes()
    known = [-25.73, -18.74, -17.63, -6.57, -5.20, -2.90, -0.68, 0.0]
    np.testing.assert_allclose(modes.rates / ARCSECOND_PER_YEAR, known, rtol=0.015, atol=1e-5)
    # At time 0 the planes are those of J2000, and the sum of all angular momenta stays.
    start = orbit_normal(
        0.0, modes.amplitudes[names.index("Jupiter")], modes.rates, modes.phases[names.index("Jupiter")]
    )
    assert np.degrees(np.arccos(start[2])) == pytest.approx(1.304, abs=0.002)
    assert np.ptp(modes.amplitudes[:, -1]) < 1e-12


@pytest.mark.slow
def test_two_planets_turn_as_in_rebound():
    """The node regresses and the mutual inclination stays, of a pair that is far apart and light."""
    masses, axes, leans, nodes = [1e-4, 3e-4], [1.0, 4.0], [0.02, 0.01], [0.3, 2.0]
    modes = node_modes(1.0, masses, axes, leans, nodes)
    bodies = rebound.Simulation()
    bodies.add(m=1.0)
    for k in range(2):
        bodies.add(m=masses[k], a=axes[k], inc=leans[k], Omega=nodes[k], primary=bodies.particles[0])
    bodies.move_to_com()
    bodies.integrator, bodies.dt = "whfast", 2 * np.pi / 25
    slow = modes.rates[np.argmax(np.abs(modes.rates))]
    end = 1.0 / abs(slow)
    bodies.integrate(end)
    for k in range(2):
        orbit = bodies.particles[k + 1].orbit(primary=bodies.particles[0])
        found = orbit_normal(end, modes.amplitudes[k], modes.rates, modes.phases[k])[:2]
        exact = np.sin(orbit.inc) * np.array([np.sin(orbit.Omega), -np.cos(orbit.Omega)])
        np.testing.assert_allclose(found, exact, atol=3e-4)
    assert np.min(np.abs(modes.rates)) < 1e-12 * abs(slow)


def test_obliquities_of_today_and_of_a_million_years():
    earth = obliquity_history("Earth", 1e6, samples=4001)
    low, high = np.degrees([earth["obliquity"].min(), earth["obliquity"].max()])
    assert np.degrees(float(earth["obliquity"][0])) == pytest.approx(23.439, abs=2e-3)
    # Laskar, Joutel & Robutel 1993: between 22 and 24.5 degrees.
    assert 22.0 < low < 22.4 and 24.3 < high < 24.7
    # Its beat with the planes, 41 000 years: alpha cos(obliquity) = 50.4 against 18.8 arc seconds a year.
    swing = earth["obliquity"].values - earth["obliquity"].values.mean()
    spectrum = np.abs(np.fft.rfft(swing * np.hanning(len(swing))))
    period = 1e6 / (1 + np.argmax(spectrum[1:]))
    assert period == pytest.approx(41000, rel=0.03)
    mars = obliquity_history("Mars", 2e6, samples=2001)
    assert np.degrees(float(mars["obliquity"][0])) == pytest.approx(25.19, abs=5e-3)
    assert mars["obliquity"].max() - mars["obliquity"].min() > np.radians(15)
    assert float(mars["time"][-1]) == pytest.approx(2e6 * JULIAN_YEAR)


def test_rates_and_angles_of_planes_and_histories_may_have_units():
    plain = node_modes(1.0e20, [1.0e17], [1.0e12], [0.1], [np.pi / 2])
    with_units = node_modes(1.0e11 * u.km**3 / u.s**2, [1.0e17], [1.0e9] * u.km, [0.1], [90.0] * u.deg)
    np.testing.assert_allclose(with_units.phases, plain.phases, rtol=1e-14)
    slow = obliquity_history("mars", 1e5, 8.0 * u.arcsec / u.yr, samples=3)
    assert slow.attrs["precession_constant"] == pytest.approx(8.0 / 206264.806247 / JULIAN_YEAR)


def test_what_makes_no_planes_or_history_is_refused():
    with pytest.raises(ValueError, match="one of each"):
        node_modes(1.0, [1.0, 1.0], [1.0], [0.1, 0.1], [0.0, 0.0])
    for s in (np.nan, np.inf):
        with pytest.raises(ValueError, match="s of a Laplace coefficient must be a finite number"):
            laplace_coefficient(s, 0, 0.0)
    for arguments in (("Pluto",), ("Mars", 0.0), ("Mars", 1e6, None, 1), ("Mars", 1e6, None, 3.5)):
        with pytest.raises(SceneError, match="obliquity"):
            obliquity_history(*arguments)


@pytest.mark.parametrize(
    ("s", "j", "ratio", "exact"),
    [
        (0.5, 64, 0.1, 1.414758729877842e-65),
        (0.5, 128, 0.2, 3.460148441432118e-91),
        (1.5, 6, 0.05, 9.20137271224587e-8),
        (1.5, 128, 0.9, 4.402495483217484e-4),
        (0.5, 2, 1e-4, 7.50000003125e-9),
    ],
)
def test_laplace_coefficients_of_high_order_and_small_ratios(s, j, ratio, exact):
    """Values of mpmath's hypergeometric function to 40 digits: sums over few angles have none of these digits."""
    assert laplace_coefficient(s, j, ratio) == pytest.approx(exact, rel=1e-11)
    assert laplace_coefficient(s, -j, ratio) == laplace_coefficient(s, j, ratio)


@pytest.mark.parametrize(
    ("s", "j", "ratio", "exact"),
    [
        (1.5, 1, 0.999999, 636620090637.4977),
        (2.5, 2, 0.9999, 4244343998498652.0),
        (1.5, 0, 1 - 1e-10, 6.366196670511131e19),
    ],
)
def test_laplace_coefficients_of_orbits_that_nearly_touch(s, j, ratio, exact):
    """Values of mpmath to 40 digits at the doubles that the ratios are."""
    assert laplace_coefficient(s, j, ratio) == pytest.approx(exact, rel=1e-12)
