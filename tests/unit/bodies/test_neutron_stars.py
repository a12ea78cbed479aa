"""The star of a mass, the heaviest star, sequences, and the units of a star."""

import math

import numpy as np
import pytest

from astroinertia.bodies.neutron_stars import maximum_mass, sequence, stable_branch, star, star_of_mass
from astroinertia.matter.compact_stars import SOLAR_LENGTH, constant_density, polytrope, read2009
from astroinertia.matter.compact_tables import tabulated
from astroinertia.units import SOLAR_MASS, SPEED_OF_LIGHT

GAMMA_TWO = polytrope(100.0, 2.0)


@pytest.mark.slow
def test_the_heaviest_star_of_gamma_two():
    """Scale free: M_max = 0.1637 sqrt(K), at rho_c = 0.318/K (Cook, Shapiro & Teukolsky 1994, ApJ 422, 227: 0.164)."""
    heaviest = maximum_mass(GAMMA_TWO)
    assert heaviest.mass == pytest.approx(1.637276, abs=2e-6)
    assert heaviest.central_rest_density == pytest.approx(3.18e-3, rel=3e-3)
    for factor in (0.99, 1.01):
        other = star(GAMMA_TWO, central_rest_density=factor * heaviest.central_rest_density)
        assert 1e-7 < 1 - other.mass / heaviest.mass < 1e-4
    scaled = maximum_mass(polytrope(400.0, 2.0))
    assert scaled.mass == pytest.approx(2 * heaviest.mass, rel=1e-10)
    assert scaled.compactness == pytest.approx(heaviest.compactness, rel=3e-6)
    assert heaviest.causal


@pytest.mark.slow
def test_a_star_of_a_mass():
    heaviest = maximum_mass(GAMMA_TWO)
    for mass in (1e-3, 0.5, 1.4, heaviest.mass * (1 - 1e-9)):
        body = star_of_mass(GAMMA_TWO, mass)
        assert body.mass == pytest.approx(mass, rel=1e-11)
        assert body.central_rest_density <= heaviest.central_rest_density
    with pytest.raises(ValueError, match=r"stable stars have .* not 1\.7"):
        star_of_mass(GAMMA_TWO, 1.7)
    with pytest.raises(ValueError, match="positive and finite"):
        star_of_mass(GAMMA_TWO, math.nan)
    # constant density has no maximum, but a star of every mass up to Buchdahl's limit
    assert star_of_mass(constant_density(1e-3), 1.0).mass == pytest.approx(1.0, rel=1e-11)


@pytest.mark.full
def test_branches():
    """Newton's limits: gamma below 4/3 has no stable star, gamma above it no heaviest one."""
    with pytest.raises(ValueError, match="no stable star"):
        stable_branch(polytrope(0.1, 1.3))
    with pytest.raises(ValueError, match="no stable star"):
        stable_branch(polytrope(0.1, 4 / 3), relativistic=False)
    with pytest.raises(ValueError, match="there is no maximum"):
        maximum_mass(GAMMA_TWO, relativistic=False)
    with pytest.raises(ValueError, match="there is no maximum"):
        maximum_mass(constant_density(1e-3))
    eta = np.geomspace(1e-5, 0.3, 40)  # a table that ends before the maximum
    short = tabulated(GAMMA_TWO.pressure(eta), rest_density=GAMMA_TWO.rest_density(eta))
    with pytest.raises(ValueError, match="there is no maximum"):
        maximum_mass(short)
    assert star_of_mass(short, 1.4).radius == pytest.approx(star_of_mass(GAMMA_TWO, 1.4).radius, rel=1e-9)


@pytest.mark.full
def test_sly_has_a_least_mass():
    """The crust makes stars below 0.1 Msun unstable; the branch of neutron stars begins there."""
    sly = read2009("SLy")
    branch = stable_branch(sly)
    least = star(sly, central_enthalpy=branch.lowest)
    assert 0.08 < least.mass < 0.12
    assert least.radius_km > 100
    for factor in (0.98, 1.02):
        assert star(sly, central_enthalpy=factor * branch.lowest).mass > least.mass
    for mass in (0.05, 2.8e30):  # the latter in kilograms
        with pytest.raises(ValueError, match=r"stable stars have 0\.095\d+ to 2\.0[45]\d+ solar masses, not"):
            star_of_mass(sly, mass)


def test_sequences():
    stars = sequence(GAMMA_TWO, central_rest_densities=[6e-3, 1e-4, 1e-3, 3e-3])
    assert stars.stable.tolist() == [True, True, True, False]
    mass, radius = stars.column("mass"), stars.column("radius_km")
    assert np.all(np.diff(mass[:3]) > 0) and mass[3] < mass[2] and np.all(np.diff(radius) < 0)
    along = sequence(GAMMA_TWO, count=12)
    assert along.stable.all()
    assert along.column("mass")[-1] == pytest.approx(maximum_mass(GAMMA_TWO).mass, rel=1e-11)


def test_properties_of_a_star():
    body = star(GAMMA_TWO, central_rest_density=1.28e-3)
    assert body.mass_kg == pytest.approx(body.mass * SOLAR_MASS, rel=1e-15)
    assert body.moment_of_inertia_kg_m2 == pytest.approx(
        body.moment_ratio * body.mass_kg * (1e3 * body.radius_km) ** 2, rel=1e-14
    )
    assert body.redshift == pytest.approx((1 - 2 * body.mass / body.radius) ** -0.5 - 1, rel=1e-14)
    assert body.structure.lapse[-1] == pytest.approx(1 / (1 + body.redshift), rel=1e-15)
    assert body.tidal_deformability == pytest.approx(2 / 3 * body.tidal_love_number / body.compactness**5, rel=1e-15)
    # about 0.65 of the orbital frequency at the equator of the sphere (Haensel et al. 2009: 1.08 kHz to 1.67 kHz)
    orbit = math.sqrt(body.mass / body.radius**3) / (2 * math.pi) / SOLAR_LENGTH * SPEED_OF_LIGHT
    assert body.shedding_frequency() / orbit == pytest.approx(0.589, abs=0.001)
    # Q_bar = Q M/J^2 with J = I Omega
    assert body.quadrupole_bar == pytest.approx(body.quadrupole * body.mass / body.moment_of_inertia**2, rel=1e-13)
    same = [star(GAMMA_TWO, central_pressure=body.central_pressure), star(GAMMA_TWO, central_enthalpy=0.256),
            star(GAMMA_TWO, central_energy_density=body.structure.central_energy_density)]  # fmt: skip
    for other in same:
        assert other.mass == pytest.approx(body.mass, rel=1e-13)
    newton = star(GAMMA_TWO, central_rest_density=1.28e-3, relativistic=False)
    assert newton.redshift == 0 and math.isnan(newton.quadrupole_bar)
    assert newton.radius == pytest.approx(math.sqrt(100 * math.pi / 2), rel=1e-11)  # n = 1: R = sqrt(pi K/2)
    with pytest.raises(ValueError, match="exactly one of"):
        star(GAMMA_TWO)
    with pytest.raises(ValueError, match="exactly one of"):
        star(GAMMA_TWO, central_pressure=1e-4, central_enthalpy=0.2)
    with pytest.raises(ValueError, match="central_rest_density is that of one star, not of 2: `sequence` has many"):
        star(GAMMA_TWO, central_rest_density=np.array([1e-3, 2e-3]))  # type: ignore[arg-type]
