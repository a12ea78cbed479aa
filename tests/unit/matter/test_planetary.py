"""Equations of state: their expansion at no pressure, thermodynamic consistency, inverses, and known limits."""

import jax
import mpmath
import numpy as np
import pytest

from astroinertia.bodies.earth import prem
from astroinertia.matter import planetary, tillotson
from astroinertia.matter.planetary import (
    FORSTERITE,
    ICE_VII,
    IRON_HCP,
    IRON_LIQUID,
    IRON_SULPHIDE,
    PEROVSKITE,
    BirchMurnaghan,
    ModifiedPolytrope,
    Murnaghan,
    Vinet,
    bulk_modulus,
    cold_energy,
    density,
    pressure,
)

MATERIALS = {
    "hcp iron": IRON_HCP,
    "liquid iron": IRON_LIQUID,
    "iron sulphide": IRON_SULPHIDE,
    "perovskite": PEROVSKITE,
    "forsterite": FORSTERITE,
    "ice VII": ICE_VII,
    "Murnaghan": Murnaghan(3000.0, 1e11, 4.5),
    "granite": tillotson.GRANITE,
    "basalt": tillotson.BASALT,
    "iron (Tillotson)": tillotson.IRON,
    "ice (Tillotson)": tillotson.ICE,
}

TILLOTSON = ("granite", "basalt", "iron (Tillotson)", "ice (Tillotson)")
# Tillotson's cold curve takes seconds to compile.
NAMES = [pytest.param(name, marks=pytest.mark.full) if name in TILLOTSON else name for name in MATERIALS]


@pytest.mark.full
@pytest.mark.parametrize("name", NAMES)
def test_modulus_and_its_derivative_at_no_pressure(name):
    """K = rho dP/d rho and K' = dK/dP: the numbers that a material was made with."""
    material = MATERIALS[name]
    reference = float(material.reference_density)
    assert float(pressure(material, reference)) == pytest.approx(0, abs=1e-5)
    assert bulk_modulus(material, reference) == pytest.approx(material.bulk_modulus, rel=1e-12)
    rho = reference * np.array([1 - 1e-4, 1 + 1e-4])
    moduli, pressures = bulk_modulus(material, rho), pressure(material, rho)
    assert (moduli[1] - moduli[0]) / (pressures[1] - pressures[0]) == pytest.approx(
        float(material.derivative), rel=1e-5
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_energy_modulus_and_inverse_are_consistent(name):
    material = MATERIALS[name]
    rho = float(material.reference_density) * np.array([1.01, 1.3, 1.9])
    step = 1e-5 * rho
    slope = (cold_energy(material, rho + step) - cold_energy(material, rho - step)) / (2 * step)
    assert slope == pytest.approx(pressure(material, rho) / rho**2, rel=1e-7)  # dE = P d rho/rho^2
    slope = (pressure(material, rho + step) - pressure(material, rho - step)) / (2 * step)
    assert bulk_modulus(material, rho) == pytest.approx(rho * slope, rel=1e-8)
    assert density(material, pressure(material, rho)) == pytest.approx(rho, rel=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("compression", [-1e-6, 1e-9, 1e-4, 0.1])
def test_small_compressions_have_all_digits_of_their_pressure_and_energy(compression):
    """By mpmath from the formulas: differences from 1 lost 1e-16 of K, which is 1e-7 of the pressure at 1e-9."""
    rho = 4100.0 * (1.0 + compression)
    with mpmath.workdps(40):
        reference, modulus, slope = mpmath.mpf(4100), mpmath.mpf(247e9), mpmath.mpf(5)

        def birch(at):
            strain = ((at / reference) ** (mpmath.mpf(2) / 3) - 1) / 2
            return 3 * modulus * strain * (1 + 2 * strain) ** 2.5 * (1 + 1.5 * (slope - 4) * strain)

        def vinet(at):
            x = mpmath.cbrt(reference / at)
            return 3 * modulus * (1 - x) / x**2 * mpmath.exp(1.5 * (slope - 1) * (1 - x))

        def murnaghan(at):
            return modulus / slope * ((at / reference) ** slope - 1)

        for law, exact in ((BirchMurnaghan, birch), (Vinet, vinet), (Murnaghan, murnaghan)):
            material = law(4100.0, 247e9, 5.0)
            assert float(pressure(material, rho)) == pytest.approx(float(exact(mpmath.mpf(rho))), rel=3e-15)
            energy = mpmath.quad(lambda at, law=exact: law(at) / at**2 * 1e30, [reference, rho]) / 1e30
            assert float(cold_energy(material, rho)) == pytest.approx(float(energy), rel=1e-14, abs=0.0)


def test_birch_murnaghan_of_fourth_order_contains_the_lower_ones():
    """The third order is the fourth with K K'' = -((K' - 4)(K' - 3) + 35/9), the second the third with K' = 4."""
    modulus, slope = 1.5e11, 5.2
    implied = -((slope - 4) * (slope - 3) + 35 / 9) / modulus
    rho = 4000 * np.linspace(0.95, 2.5, 20)
    third, fourth = BirchMurnaghan(4000.0, modulus, slope), BirchMurnaghan(4000.0, modulus, slope, implied)
    assert pressure(fourth, rho) == pytest.approx(pressure(third, rho), rel=1e-13, abs=1e-3)
    second = BirchMurnaghan(4000.0, modulus)
    x = (rho / 4000) ** (1 / 3)
    assert pressure(second, rho) == pytest.approx(1.5 * modulus * (x**7 - x**5), rel=1e-12, abs=1e-3)
    # K'' itself, from the modulus: the third derivative of the energy
    rho = 4000 * (1 + np.array([-2e-3, 0.0, 2e-3]))
    for material, expected in ((third, implied), (BirchMurnaghan(4000.0, modulus, slope, -3e-11), -3e-11)):
        p, k = pressure(material, rho), bulk_modulus(material, rho)
        slopes = np.diff(k) / np.diff(p)
        assert (slopes[1] - slopes[0]) / ((p[2] - p[0]) / 2) == pytest.approx(expected, rel=1e-4)


def test_the_equations_agree_to_third_order_of_compression():
    """With one K and K' they differ only in K'': by the cube of the compression."""
    made = [each(4000.0, 1e11, 4.3) for each in (BirchMurnaghan, Vinet, Murnaghan)]
    spread = []
    for compression in (1e-2, 2e-2):
        p = np.array([float(pressure(each, 4000.0 * (1 + compression))) for each in made])
        spread.append(np.ptp(p))
    assert spread[1] / spread[0] == pytest.approx(8, rel=0.1)


@pytest.mark.slow
def test_the_earth_is_made_of_what_it_is_made_of():
    """PREM at its pressures: a mantle like perovskite, and cores lighter than cold iron by heat and light elements."""
    earth = prem()
    centre, boundary = float(earth.pressure(0.0)), float(earth.pressure(3480e3))
    assert density(PEROVSKITE, boundary) == pytest.approx(5566.5, rel=0.02)
    assert 0.05 < float(density(IRON_HCP, centre)) / 13088.5 - 1 < 0.09
    assert 0.08 < float(density(IRON_LIQUID, boundary)) / 9903.5 - 1 < 0.12
    seager = ModifiedPolytrope(8300.0, 0.00349, 0.528)  # the rough fit of Seager et al. to iron
    assert density(seager, centre) == pytest.approx(float(density(IRON_HCP, centre)), rel=0.12)


def test_beyond_the_reach_of_an_equation_there_is_no_density():
    soft = BirchMurnaghan(4000.0, 1e11, 3.0)  # its pressure has a greatest value
    rho = 4000 * np.linspace(1, 10, 2000)
    greatest = np.asarray(pressure(soft, rho)).max()
    assert np.isfinite(density(soft, 0.99 * greatest)) and np.isnan(density(soft, 1.01 * greatest))
    assert density(IRON_HCP, -1e8) == pytest.approx(8300 * np.exp(-1e8 / 156.2e9), rel=1e-12)


@pytest.mark.full
def test_density_is_differentiable_by_pressure_and_parameters():
    with jax.enable_x64(True):

        def rho(modulus, p):
            return BirchMurnaghan(4000.0, modulus, 4.4).density(p)

        slopes = jax.jit(jax.grad(rho, argnums=(0, 1)))
        value = float(rho(1e11, 5e10))
        by_modulus, by_pressure = map(float, slopes(1e11, 5e10))
        second = float(jax.jit(jax.grad(jax.grad(rho, argnums=1), argnums=1))(1e11, 5e10))
        modulus_there = float(bulk_modulus(BirchMurnaghan(4000.0, 1e11, 4.4), value))
        step = 1e7
        difference = float(rho(1e11 + step, 5e10) - rho(1e11 - step, 5e10)) / (2 * step)
        by_p = [float(slopes(1e11, 5e10 + sign * step)[1]) for sign in (1, -1)]
    assert by_modulus == pytest.approx(difference, rel=1e-6)
    assert by_pressure == pytest.approx(value / modulus_there, rel=1e-12)
    assert second == pytest.approx((by_p[0] - by_p[1]) / (2 * step), rel=1e-6)


@pytest.mark.parametrize(
    ("density", "energy", "pressure"),
    [
        (2.0, 4.0, (0.5 + 1.5 / 1.25) * 8.0 + 2.0 + 3.0),  # compressed
        (0.5, 1.0, (0.5 + 1.5 / 2.0) * 0.5 - 1.0 + 0.75),  # expanded and condensed
        (0.5, 2.0, 0.5 + (1.5 / 3.0 - np.exp(-7.0)) * np.exp(-5.0)),  # vapour
        (0.5, 1.5, (0.575 + 0.375 + (0.45 - np.exp(-7.0)) * np.exp(-5.0)) / 2.0),  # half of each
        (0.5, 0.0, -1.0 + 0.75),  # in tension
    ],
)
def test_tillotson_is_the_published_formula_in_each_regime(density, energy, pressure):
    """Melosh 1989, eqs. AII.3 to 5, by hand."""
    matter = tillotson.Tillotson(1.0, 0.5, 1.5, 2.0, 3.0, 4.0, 1.0, 2.0, 5.0, 7.0)
    assert matter.pressure_at(density, energy) == pytest.approx(pressure, rel=1e-14)
    assert matter.fluid_pressure_at(density, energy) == pytest.approx(max(pressure, 0.0), rel=1e-14)


@pytest.mark.slow
def test_tillotson_regimes_join_and_its_cold_curve_is_the_isentrope():
    rock = tillotson.GRANITE
    rho = np.array([0.3, 0.7, 1 - 1e-12]) * 2680
    with jax.enable_x64(True):
        for energy in (rock.incipient_vaporisation, rock.complete_vaporisation):
            below, above = (np.asarray(rock.pressure_at(rho, energy * (1 + sign * 1e-9))) for sign in (-1, 1))
            assert below == pytest.approx(above, rel=1e-6)
        hot = rock.complete_vaporisation * 1.5
        beside = [float(rock.pressure_at(rho[-1] * factor, hot)) for factor in (1, 1 + 1e-11)]
        assert beside[0] == pytest.approx(beside[1], rel=1e-8)
        thin = float(rock.pressure_at(1e-3, hot) / (1e-3 * hot))
        assert thin == pytest.approx(rock.a, rel=1e-3)  # a gas of gamma = 1 + a
        dense = 2680 * np.array([1.2, 2.2])
        assert np.asarray(rock.energy(dense)) == pytest.approx(np.asarray(cold_energy(rock, dense)), rel=1e-12)


def test_a_density_is_found_in_single_precision_too():
    with jax.enable_x64(False):
        single = planetary.IRON_HCP.density(1e11)
    assert single.dtype == np.float32
    assert float(single) == pytest.approx(float(planetary.density(planetary.IRON_HCP, 1e11)), rel=1e-5)
