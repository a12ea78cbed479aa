"""Cold equations of state: the first law, continuity, the published parameters, and what is refused."""

import math

import numpy as np
import pytest

from astroinertia.matter.compact_stars import (
    READ_DENSITIES,
    SLY_CRUST_DENSITIES,
    SLY_CRUST_GAMMAS,
    SOLAR_LENGTH,
    constant_density,
    energy_polytrope,
    four_parameter,
    geometric_density,
    geometric_pressure,
    piecewise_polytrope,
    polytrope,
    read2009,
    read2009_table,
)
from astroinertia.units import SPEED_OF_LIGHT

JUMPING = piecewise_polytrope(50.0, [2.0, 3.0, 1.5], [4e-4, 1.5e-3], jumps=[1.4, 1.2])
EQUATIONS = [
    polytrope(100.0, 2.0),
    polytrope(0.2, 4 / 3),
    energy_polytrope(30.0, 1.8),
    constant_density(1e-3),
    read2009("SLy"),
    read2009("MS1"),
    JUMPING,
]


@pytest.mark.parametrize("equation", EQUATIONS, ids=lambda equation: equation.name)
def test_first_law(equation):
    """dP/d eta = rho0 and de = (1 + eta) drho0, by differences over every piece; sound is dP/de."""
    for low, high in zip(equation.edges, equation.edges[1:], strict=False):
        eta = np.geomspace(max(low, 1e-7) * 1.001, min(high, 1.0) * 0.999, 7)
        step = 1e-5 * (eta - low)
        up, down = eta + step, eta - step
        rise = equation.pressure(up) - equation.pressure(down)
        np.testing.assert_allclose(rise / (2 * step), equation.rest_density(eta), rtol=1e-8)
        growth = equation.energy_density(up) - equation.energy_density(down)
        if equation.name != "constant density":
            np.testing.assert_allclose(
                growth, (1 + eta) * (equation.rest_density(up) - equation.rest_density(down)), rtol=3e-5
            )
            np.testing.assert_allclose(rise / growth, equation.sound_speed_squared(eta), rtol=3e-5)


def test_a_polytrope_is_its_formula():
    eta = np.geomspace(1e-8, 3, 20)
    for equation, constant, gamma in ((EQUATIONS[0], 100.0, 2.0), (EQUATIONS[1], 0.2, 4 / 3)):
        density, pressure = equation.rest_density(eta), equation.pressure(eta)
        np.testing.assert_allclose(pressure, constant * density**gamma, rtol=1e-13)
        np.testing.assert_allclose(equation.energy_density(eta), density + pressure / (gamma - 1), rtol=1e-13)
    energy = EQUATIONS[2].energy_density(eta)
    np.testing.assert_allclose(EQUATIONS[2].pressure(eta), 30.0 * energy**1.8, rtol=1e-13)


def test_energies_of_large_enthalpies_keep_their_digits():
    """P is all but rho0 (1 + eta), as that of a stiff gas is."""
    eta = np.array([1e8, 1e12])
    stiff, tooper = polytrope(100.0, 1e6), energy_polytrope(30.0, 1.8)
    np.testing.assert_allclose(
        stiff.energy_density(eta), stiff.rest_density(eta) + stiff.pressure(eta) / (1e6 - 1), rtol=1e-13
    )
    np.testing.assert_allclose(tooper.pressure(eta), 30.0 * tooper.energy_density(eta) ** 1.8, rtol=1e-13)


@pytest.mark.parametrize(("constant", "gamma"), [(1e-3, 1.001), (100.0, 1.001), (100.0, 1.005), (1e5, 1.02)])
def test_a_polytrope_of_almost_one_temperature_is_its_formula(constant, gamma):
    """K^n and (n + 1)^-n, which such an index takes beyond the numbers, are not asked for."""
    equation = polytrope(constant, gamma)
    for rest in (1e-12, 1e-3):
        eta = equation.enthalpy_of("rest_density", rest)
        assert equation.pressure(eta) == pytest.approx(constant * rest**gamma, rel=1e-11)
        assert equation.energy_density(eta) == pytest.approx(rest + constant * rest**gamma / (gamma - 1), rel=1e-11)


@pytest.mark.parametrize("constant", [1e-12, 1e-3, 100.0])
@pytest.mark.parametrize("gamma", [1.0001, 1.000001])
def test_the_centre_of_an_almost_isothermal_gas_is_that_of_its_formula(constant, gamma):
    """eta = (n + 1) K rho^(1/n) hardly changes with the density, which is soon beyond what numbers hold."""
    equation = polytrope(constant, gamma)
    for rest in (1e-30, 1e-3, 1e10):
        exact = gamma / (gamma - 1) * constant * rest ** (gamma - 1)
        assert equation.enthalpy_of("rest_density", rest) == pytest.approx(exact, rel=1e-14)
        assert equation.enthalpy_of("pressure", constant * rest**gamma) == pytest.approx(exact, rel=1e-14)


def test_pieces_meet_and_jumps_are_those_asked_for():
    for edge, low, high, jump in zip(
        JUMPING.edges[1:-1], JUMPING.pieces[:-1], JUMPING.pieces[1:], [1.4, 1.2], strict=True
    ):
        (outer, pressure, _), (inner, same, _) = low.at(edge), high.at(edge)
        assert inner / outer == pytest.approx(jump, rel=1e-13)
        assert pressure == pytest.approx(same, rel=1e-13)
    # each piece has its own gamma, and the dividing densities are those at the foot of each jump
    assert [low.at(edge)[0] for edge, low in zip(JUMPING.edges[1:-1], JUMPING.pieces, strict=False)] == pytest.approx(
        [4e-4, 1.5e-3]
    )
    eta = np.array([1.2, 1.3]) * JUMPING.edges[2]
    density, pressure = JUMPING.rest_density(eta), JUMPING.pressure(eta)
    assert math.log(pressure[1] / pressure[0]) / math.log(density[1] / density[0]) == pytest.approx(1.5, rel=1e-12)


def test_read_2009_by_its_definition():
    """Table III has 34 equations; p1 is the pressure at 10^14.7 g/cm3, the crust that of their Table II."""
    table = read2009_table()
    assert len(table) == 34
    for name, row in table.items():
        equation = read2009(name)
        divide = float(geometric_density(1e3 * READ_DENSITIES[0]))
        eta = equation.enthalpy_of("rest_density", divide)
        p1 = float(geometric_pressure(0.1 * 10 ** row["log10_p1"]))
        assert float(equation.pressure(eta)) == pytest.approx(p1, rel=1e-12)
        gammas = [1 + 1 / piece.index for piece in equation.pieces]
        assert gammas == pytest.approx([*SLY_CRUST_GAMMAS, row["gamma1"], row["gamma2"], row["gamma3"]])
    # the constants of the inner crust, printed in their Table II, follow from the first one to the digits of the gammas
    sly = read2009("SLy")
    constants = (6.80110e-9, 1.06186e-6, 5.32697e1, 3.99874e-8)
    for density, gamma, constant in zip((1e6, 1e9, 1e12, 1e13), SLY_CRUST_GAMMAS, constants, strict=True):
        eta = sly.enthalpy_of("rest_density", float(geometric_density(1e3 * density)))
        printed = constant * density**gamma * 1e3 * SPEED_OF_LIGHT**2
        assert float(sly.pressure(eta) / geometric_pressure(printed)) == pytest.approx(1, abs=2e-4)
    assert SLY_CRUST_DENSITIES[2] < 1e13


def test_units():
    assert pytest.approx(1476.62503805, rel=1e-9) == SOLAR_LENGTH  # IAU 2015 nominal GM over c^2
    # nuclear density 2.8e14 g/cm3 is 4.53e-4 in the units of most codes
    assert float(geometric_density(2.8e17)) == pytest.approx(4.533e-4, rel=1e-3)
    assert float(geometric_pressure(SPEED_OF_LIGHT**2)) == pytest.approx(float(geometric_density(1.0)), rel=1e-15)


@pytest.mark.parametrize("equation", EQUATIONS[:3] + EQUATIONS[4:], ids=lambda equation: equation.name)
@pytest.mark.parametrize("quantity", ["rest_density", "pressure", "energy_density"])
def test_the_centre_is_found_from_any_quantity(equation, quantity):
    for eta in (1e-9, 1e-3, 0.07, 0.6):
        value = float(getattr(equation, quantity)(eta))
        assert equation.enthalpy_of(quantity, value) == pytest.approx(eta, rel=1e-12)


def test_refusals():
    with pytest.raises(ValueError, match="inside a jump"):
        JUMPING.enthalpy_of("rest_density", 4.5e-4)
    with pytest.raises(ValueError, match="positive and finite"):
        JUMPING.enthalpy_of("pressure", math.nan)
    with pytest.raises(ValueError, match="never reaches rest_density = 2"):
        constant_density(1.0).enthalpy_of("rest_density", 2.0)
    with pytest.raises(ValueError, match="not from 'temperature'"):
        JUMPING.enthalpy_of("temperature", 1.0)
    with pytest.raises(ValueError, match="no equation of state 'SLY'"):
        read2009("SLY")
    with pytest.raises(ValueError, match="meets the crust at"):
        four_parameter(34.0, 1.4, 3.0, 3.0)
    with pytest.raises(ValueError, match="outermost gamma must be above 1"):
        polytrope(1.0, 1.0)
    with pytest.raises(ValueError, match="must ascend"):
        piecewise_polytrope(1.0, [2.0, 2.5, 3.0], [1e-3, 1.1e-3], jumps=[1.2, 1.0])
    with pytest.raises(ValueError, match="2 gammas need 1 dividing densities"):
        piecewise_polytrope(1.0, [2.0, 2.5], [])
    with pytest.raises(ValueError, match="constant must be positive"):
        polytrope(-1.0, 2.0)
    with pytest.raises(ValueError, match="lies outside"):
        JUMPING.pressure(-1e-3)


def test_extreme_values_have_their_enthalpy_or_a_sentence():
    law = polytrope(100.0, 2.0)  # eta = 2 K rho0
    for density in (1e-310, 1e-290, 1e-50, 1e50, 1e250):
        assert law.enthalpy_of("rest_density", density) == pytest.approx(200.0 * density, rel=1e-12)
    for pressure in (1e-300, 1e150):  # K rho0^2
        assert law.enthalpy_of("pressure", pressure) == pytest.approx(20.0 * math.sqrt(pressure), rel=1e-12)
    stiff = polytrope(1.0, 50.0)
    with pytest.raises(ValueError, match="rest_density = 1e-09 is that of an enthalpy below what numbers hold"):
        stiff.enthalpy_of("rest_density", 1e-9)  # 1e-441
    with pytest.raises(ValueError, match="never reaches rest_density = 1e\\+150"):
        stiff.enthalpy_of("rest_density", 1e150)
    for equation, enthalpy in ((polytrope(1.0, 1.001), 1e12), (law, 1e300)):
        with pytest.raises(ValueError, match="its pressure is beyond what numbers hold"):
            equation.energy_density(enthalpy)
    with pytest.raises(ValueError, match="an enthalpy of inf lies outside"):
        law.sound_speed_squared(math.inf)


def test_soft_matter_inside_has_a_largest_enthalpy():
    """P = K rho0^gamma with gamma below 1: the enthalpy comes to a bound as the density goes to infinity."""
    soft = piecewise_polytrope(1.0, [2.0, 0.5], [1e-3])
    assert soft.largest_enthalpy == pytest.approx(3e-3, rel=1e-14)
    assert soft.enthalpy_of("pressure", 1e-4) == pytest.approx(3e-3 - 1e-4 / 10.0, rel=1e-12)  # rho0 = 10
    with pytest.raises(ValueError, match=r"lies outside 0 to 0\.003"):
        soft.pressure(1.0)
    with pytest.raises(ValueError, match="beyond what numbers hold"):
        soft.rest_density(soft.largest_enthalpy)


def test_sound_faster_than_light_is_reported():
    """c_s^2 = gamma P/(e + P): a polytrope of gamma above 2 becomes acausal, one of 2 approaches c."""
    assert polytrope(100.0, 2.0).causal_up_to(100.0)
    stiff = polytrope(1e4, 3.0)  # (gamma - 1) eta/(1 + eta) = 1 at eta = 1
    assert stiff.causal_up_to(0.999)
    assert not stiff.causal_up_to(1.001)
    assert not constant_density(1.0).causal_up_to(1e-6)
