"""Modes of rotating stars: a star at rest, the exact bars of liquids, and what more trial displacements change."""

import math

import numpy as np
import pytest

from astroinertia.bodies import maclaurin, rotating_modes
from astroinertia.bodies.ellipsoid_secular import viscous_modes
from astroinertia.bodies.ellipsoid_stability import spectrum as ellipsoid_spectrum
from astroinertia.bodies.maclaurin_momentum import MomentumLaw
from astroinertia.bodies.oscillations import nonradial_modes
from astroinertia.bodies.rotating_modes import bar_mode, spectrum
from astroinertia.bodies.rotating_star import rotating_star
from astroinertia.matter.barotropes import polytropic_matter

STIFF = 1e6  # adiabatic exponent of a liquid


def test_at_rest_the_bar_is_the_fundamental_mode() -> None:
    """Of degree 2, by the equations in spherical harmonics; it goes round backwards at half its frequency."""
    exact = nonradial_modes(1.5, 5 / 3, 2, 0, 0)[0].squared_frequency
    found = bar_mode(rotating_star(polytropic_matter(1.5), 1.0), 5 / 3)
    assert found.growth_rate == 0
    assert (2 * found.pattern_speed) ** 2 == pytest.approx(exact, rel=1e-9)


def test_tides_are_poissons_and_those_of_a_sphere() -> None:
    """Their trace is 4 pi times the density; at rest the force lies along the radius, everywhere in the same way."""
    star = rotating_star(polytropic_matter(1.0), 0.7)
    ww, _, zz, around = rotating_modes._tides(star)
    inside = star.field.mesh.radius < 0.5  # next to the surface harmonics leave 2e-3
    density = star.field.matter.density(star.field.level)
    assert np.abs(ww + zz + around - 4 * math.pi * density)[inside].max() < 1e-8 * 4 * math.pi
    field = (sphere := rotating_star(polytropic_matter(1.0), 1.0)).field
    ww, wz, zz, around = rotating_modes._tides(sphere)
    mu, sine = field.cosine, np.sqrt(1 - field.cosine**2)
    radial = sine**2 * ww + 2 * sine * mu * wz + mu**2 * zz
    assert np.abs(ww - (sine**2 * radial + mu**2 * around)).max() < 1e-9 * np.abs(ww).max()
    assert np.abs(wz - sine * mu * (radial - around)).max() < 1e-9 * np.abs(ww).max()


@pytest.mark.full
@pytest.mark.parametrize("eccentricity", [0.81267, 0.95, 0.96])
def test_bars_of_liquids(eccentricity: float) -> None:
    """Chandrasekhar's: at rest at 0.81267 (bifurcation), stable at 0.95, growing beyond 0.95289, then with Omega/2."""
    liquid = maclaurin.from_eccentricity(eccentricity)
    star = rotating_star(polytropic_matter(0.0), liquid.c_over_a)
    unit = star.angular_velocity / liquid.angular_velocity
    found = bar_mode(star, STIFF)
    # the field of a liquid, whose density jumps, is right to about 1e-5, and rates near their onset go as a root
    assert found.growth_rate / unit == pytest.approx(ellipsoid_spectrum(liquid).growth_rate, rel=3e-4)
    if eccentricity > 0.953:
        assert found.pattern_speed == pytest.approx(star.angular_velocity / 2, rel=1e-6)
    elif eccentricity < 0.82:
        assert found.pattern_speed == pytest.approx(0.0, abs=1e-4 * star.angular_velocity)


@pytest.mark.full
def test_more_displacements_change_less_and_less() -> None:
    """A star with the angular momentum of a liquid: the virial equations are right to 1 %, degree 2 to 3e-3."""
    star = rotating_star(polytropic_matter(0.5), 0.284, MomentumLaw())
    rates = []
    for degree in (0, 2, 4, 6):
        sigma, share = spectrum(star, 3.0, 2, degree)
        bars = sigma[share > 0.5 * share.max()]
        rates.append(bars[bars.imag.argmin()])
    errors = [abs(rate - rates[-1]) / abs(rates[-1].imag) for rate in rates]
    assert 3e-3 < errors[0] < 0.02 and errors[1] < 3e-3 and errors[2] < 1e-4
    found = bar_mode(star, 3.0)
    assert found.growth_rate == pytest.approx(-rates[-1].imag) and found.pattern_speed == -rates[-1].real / 2


@pytest.mark.slow
def test_bars_grow_from_where_they_do_in_liquids_nearly() -> None:
    """T/|W| of onset 0.274 in a liquid: stable at 0.2707, growing at 0.2768."""
    matter = polytropic_matter(0.5)
    slower, faster = (rotating_star(matter, ratio, MomentumLaw()) for ratio in (0.3, 0.29))
    assert slower.rotational_to_gravitational < 0.2738 < faster.rotational_to_gravitational
    assert bar_mode(slower, 3.0).growth_rate == 0 < bar_mode(faster, 3.0).growth_rate


@pytest.mark.full
@pytest.mark.parametrize("eccentricity", [0.7, 0.9])
def test_viscosity_drives_bars_of_liquids(eccentricity: float) -> None:
    """As Rosenkilde's equations say of motions linear in position: the bar that becomes Jacobi's grows beyond 0.81267.

    All motions together make it slower by a layer at the surface as thick as nu^(1/2).
    """
    liquid, viscosity = maclaurin.from_eccentricity(eccentricity), 1e-3
    star = rotating_star(polytropic_matter(0.0), liquid.c_over_a)
    length = star.mean_radius  # the liquid has its mean radius for a unit, the star its equatorial one
    exact = viscous_modes(liquid, viscosity / math.sqrt(length))
    sigma, share = spectrum(star, STIFF, 2, 0, viscosity)
    growth = -np.imag(sigma[share > 0.5 * share.max()]).min()
    assert growth * length**1.5 == pytest.approx(exact.changes.real.max(), rel=1e-3)
    assert bar_mode(star, STIFF, viscosity).growth_rate == pytest.approx(growth, rel=0.05)


def test_viscosity_asks_for_rigid_rotation() -> None:
    star = rotating_star(polytropic_matter(1.0), 0.9, MomentumLaw())
    with pytest.raises(ValueError, match="turn rigidly"):
        bar_mode(star, 2.0, 0.01)


def test_units_are_the_stars() -> None:
    star = rotating_star(polytropic_matter(1.0), 0.8)
    other = rotating_star(polytropic_matter(1.0), 0.8, mass=3.0, equatorial_radius=2.0, gravitational_constant=5.0)
    rates = (abs(spectrum(each, 2.0, 2, 1)[0]).max() for each in (other, star))
    assert next(rates) == pytest.approx(math.sqrt(15 / 8) * next(rates))


@pytest.mark.parametrize("mode", [1, 3])
def test_at_rest_odd_modes_have_the_frequencies_of_spherical_harmonics(mode: int) -> None:
    """Of degree 3, whatever the order; moved as a whole (mode 1) a star stays where it is."""
    exact = nonradial_modes(1.5, 5 / 3, 3, 0, 0)[0].squared_frequency
    sigma, share = spectrum(rotating_star(polytropic_matter(1.5), 1.0), 5 / 3, mode, 4)
    assert np.abs(sigma.real**2 / exact - 1).min() < 1e-7
    if mode == 1:
        assert np.abs(sigma).min() < 1e-6 * math.sqrt(exact)
    else:
        assert sigma[np.argmax(share)].real ** 2 == pytest.approx(exact, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "t_over_w"), [(2, 0.1375), (3, 0.0991), (4, 0.0771)])
def test_modes_of_liquids_stand_still_where_gravitational_waves_begin_to_drive_them(mode, t_over_w) -> None:
    """Comins 1979, MNRAS 189, 233: the mode that goes round backwards in the liquid is at rest seen from outside."""
    patterns = []
    for at in (0.99 * t_over_w, 1.01 * t_over_w):
        liquid = maclaurin.from_energy_ratio(at)
        sigma, share = spectrum(rotating_star(polytropic_matter(0.0), liquid.c_over_a), STIFF, mode, 2)
        patterns.append((-sigma[np.argsort(share)[-2:]].real).min())  # of the two that go round either way
    low, high = patterns
    assert low < 0 < high
    assert 0.99 + 0.02 * low / (low - high) == pytest.approx(1.0, abs=1e-3)


def test_modes_without_number_are_refused() -> None:
    with pytest.raises(ValueError, match=r"1, 2"):
        spectrum(rotating_star(polytropic_matter(1.0), 0.8), 2.0, 0, 2)
