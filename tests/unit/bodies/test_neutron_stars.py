"""The star of a mass, the heaviest star, sequences, and the units of a star."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.bodies.neutron_stars import (
    crust_moment_share,
    maximum_mass,
    sequence,
    stable_branch,
    star,
    star_of_mass,
)
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


def test_the_crust_of_newtons_star_of_one_density():
    """1 - (r/R)^5, with 1 - (r/R)^2 the pressure over that of the centre."""
    body = star(constant_density(2.0), central_enthalpy=0.5, relativistic=False)
    for share in (0.9, 0.3, 1e-6):
        found = crust_moment_share(body, share * body.central_pressure)
        assert found == pytest.approx(1 - (1 - share) ** 2.5, rel=1e-9)
    for pressure in (0.0, body.central_pressure, -1.0):
        with pytest.raises(ValueError, match="a crust ends at a pressure from 0 to below"):
            crust_moment_share(body, pressure)


def test_the_crust_of_a_relativistic_star_against_the_integral_of_its_angular_momentum():
    """8 pi/3 int r^4 (e + P) exp(-nu/2) omega_bar/(1 - 2m/r)^(1/2) dr, of TOV and Hartle's equations in the radius."""
    body = star(GAMMA_TWO, central_rest_density=1.28e-3)

    def slopes(r, y):
        m, pressure, nu, rate, slope, _ = y
        density = math.sqrt(max(pressure, 0.0) / 100)
        weight = density + 2 * pressure  # e + P
        f = 1 - 2 * m / r
        pull = (m + 4 * math.pi * r**3 * pressure) / (r**2 * f)
        # omega_bar'' = (4 pi r (e + P)/f - 4/r) omega_bar' + 16 pi (e + P) omega_bar/f
        bend = (4 * math.pi * r * weight / f - 4 / r) * slope + 16 * math.pi * weight * rate / f
        momentum = r**4 * weight * math.exp(-nu / 2) * rate / math.sqrt(f)
        return [4 * math.pi * r**2 * (weight - pressure), -weight * pull, 2 * pull, slope, bend, momentum]

    edge = 0.02 * body.central_pressure
    ends = [lambda r, y: y[1] - edge, lambda r, y: y[1] - 1e-14 * body.central_pressure]
    ends[1].terminal = True
    start = [1e-20, body.central_pressure, 0.0, 1.0, 0.0, 0.0]
    found = solve_ivp(slopes, (1e-6, 20.0), start, "DOP853", events=ends, rtol=1e-11, atol=1e-20)
    inside, whole = found.y_events[0][0][5], found.y_events[1][0][5]
    assert found.t_events[1][0] == pytest.approx(body.radius, rel=1e-6)
    assert crust_moment_share(body, edge) == pytest.approx(1 - inside / whole, rel=1e-7)


def test_the_crust_that_velas_glitches_ask_for():
    """Of SLy, near the estimate of Lattimer & Prakash 2001, ApJ 550, 426, and above Vela's 1.4 %."""
    body = star(read2009("SLy"), central_rest_density="8.7e17 kg/m3")
    assert body.mass == pytest.approx(1.4, abs=0.05)
    pressure, density = 0.337, 0.076  # MeV/fm3 and fm-3, Douchin & Haensel 2001
    c, mass = body.compactness, body.mass_kg * SPEED_OF_LIGHT**2 / 1.602176634e-13
    scale = 28 * math.pi / 3 * pressure * (1e18 * body.radius_km) ** 3 / mass * (1 - 1.67 * c - 0.6 * c**2) / c
    estimate = scale / (1 + 2 * pressure * (1 + 5 * c - 14 * c**2) / (density * 939.0 * c**2))
    share = crust_moment_share(body, "0.337 MeV/fm3")
    assert share == pytest.approx(estimate, rel=0.1) and share > 0.014
    # a break of the equation of state is an edge as good as any
    broken = body.equation_of_state.pressure(body.equation_of_state.edges[3])
    at, deeper = (crust_moment_share(body, float(broken) * factor) for factor in (1.0, 1 + 1e-7))
    assert at < deeper < at * (1 + 1e-6)
