"""Jupiter and Saturn as composite polytropes, against what Juno and Cassini measured and what full models give."""

from functools import lru_cache

import numpy as np
import pytest

from astroinertia.bodies import planets
from astroinertia.bodies.giant_planets import giant_planet, measured_field

fitted = lru_cache(giant_planet)
JUPITER, SATURN = measured_field("Jupiter"), measured_field("Saturn")


def deviation(planet, degree):
    number = degree // 2 - 1
    return planet.figure.zonal_harmonics[number] / planet.field.zonal_harmonics[number] - 1


def test_the_measured_fields_belong_to_the_equatorial_radius():
    assert JUPITER.zonal_harmonics[0] == pytest.approx(14696.5735e-6, rel=1e-12)
    assert SATURN.zonal_harmonics[0] == pytest.approx(16290.573e-6 * (60330 / 60268) ** 2, rel=1e-12)
    assert SATURN.zonal_harmonics[0] == pytest.approx(planets.body("Saturn").zonal_harmonic(), rel=1e-12)
    assert JUPITER.rotation_parameter == pytest.approx(0.089195487, rel=2e-6)  # Wisdom & Hubbard 2016
    with pytest.raises(KeyError, match="Mars"):
        measured_field("Mars")


@pytest.mark.parametrize("field", [JUPITER, pytest.param(SATURN, marks=pytest.mark.full)], ids=["Jupiter", "Saturn"])
def test_the_fit_has_what_it_was_fitted_to(field):
    planet = fitted(field)
    np.testing.assert_allclose(planet.figure.zonal_harmonics[:2], field.zonal_harmonics[:2], rtol=1e-9)
    assert planet.figure.equatorial_radius == pytest.approx(field.equatorial_radius, rel=1e-11)
    assert planet.figure.angular_velocity == pytest.approx(field.angular_velocity, rel=1e-9)
    assert planet.figure.enclosed_mass[-1] == pytest.approx(planets.body(field.name).mass, rel=1e-11)
    assert abs(planet.figure.virial_error) < 1e-8


def test_jupiter():
    """Published models: C/(M a^2) = 0.26393 +- 0.00001 and -0.8 % of J6 from winds (Militzer & Hubbard 2023)."""
    planet = fitted(JUPITER)
    assert planet.figure.polar_moment_ratio_equatorial == pytest.approx(0.26393, abs=5e-5)
    assert deviation(planet, 6) == pytest.approx(0.008, abs=0.003)
    assert deviation(planet, 8) == pytest.approx(0.0, abs=0.06)
    assert planet.figure.polar_radius == pytest.approx(66854e3, abs=10e3)  # measured; Archinal et al. 2018
    earth_masses = planet.core_mass_fraction * planets.body("Jupiter").mass / planets.body("Earth").mass
    assert 3 < earth_masses < 12


@pytest.mark.full
def test_saturn():
    """Published: C/(M a^2) = 0.2181 +- 0.0002; J6 to J10 of models in rigid rotation (Iess et al. 2019, table 2)."""
    planet = fitted(SATURN)
    assert planet.figure.polar_moment_ratio_equatorial == pytest.approx(0.2181, abs=3e-4)
    harmonics = 1e6 * planet.figure.zonal_harmonics * (60268 / 60330) ** (2.0 * np.arange(1, 13))
    assert harmonics[2] == pytest.approx(81.25, rel=0.03)
    assert 75.69 < harmonics[2] < 90.42
    assert -10.26 < harmonics[3] < -7.97
    assert 0.97 < harmonics[4] < 1.33
    earth_masses = planet.core_mass_fraction * planets.body("Saturn").mass / planets.body("Earth").mass
    assert 8 < earth_masses < 20


@pytest.mark.full
def test_the_size_of_the_core_is_left_open_and_hardly_matters():
    models = [fitted(JUPITER), giant_planet(JUPITER, core_fraction=0.4)]
    ratios = [planet.figure.polar_moment_ratio_equatorial for planet in models]
    assert abs(ratios[1] - ratios[0]) < 3e-5
    with pytest.raises(ValueError, match="between 0 and 1"):
        giant_planet(JUPITER, core_fraction=1.0)
