"""Laws of matter in terms of the enthalpy: their functions belong together, and figures made of them are right."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from astroinertia.bodies.figures import figure_of_barotropes, figure_of_polytrope
from astroinertia.matter.barotropes import CondensedLaw, Incompressible, PolytropicLaw, TabulatedLaw

ROWS = np.geomspace(1e-6, 10.0, 120)
LAWS = {
    "polytropic": PolytropicLaw(1.5, 0.7),
    "condensed": CondensedLaw(lambda rho: (rho**4 - 1) / 4, 1.0, 3.0),
    "tabulated": TabulatedLaw(0.5 * ROWS**2 + 0.1 * ROWS**2.6, ROWS),
    "incompressible": Incompressible(2.5),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
def test_enthalpy_is_the_integral_of_dp_over_rho(law):
    pressure = np.array([0.2, 1.0, 5.0])
    enthalpy = law.enthalpy(pressure)
    np.testing.assert_allclose(law.pressure(enthalpy), pressure, rtol=1e-8)
    steps = [quad(lambda p: 1 / float(law.density(law.enthalpy(p))), a, b)[0] for a, b in ((0.2, 1.0), (1.0, 5.0))]
    np.testing.assert_allclose(np.diff(enthalpy), steps, rtol=1e-7)
    first = float(law.enthalpy(1e-7))
    assert float(law.pressure(first)) == pytest.approx(1e-7, rel=1e-6)


def test_a_condensed_law_is_its_formula_down_to_where_its_pressure_vanishes():
    """P = (rho^4 - 1)/4 has h = (rho^3 - 1)/3: slopes taken from a spline had P and h there off by 8e-9."""
    excess = np.geomspace(1e-12, 1.99, 60)  # rho - 1
    enthalpy, pressure = (np.expm1(n * np.log1p(excess)) / n for n in (3, 4))
    law = LAWS["condensed"]
    np.testing.assert_allclose(law.enthalpy(pressure), enthalpy, rtol=3e-10)
    np.testing.assert_allclose(law.pressure(enthalpy), pressure, rtol=3e-10)
    np.testing.assert_allclose(law.density(enthalpy), 1 + excess, rtol=3e-12)


@pytest.mark.parametrize("constant", [1e5, 1e-5])
def test_a_polytropic_law_of_large_index_is_its_formula(constant):
    law, density = PolytropicLaw(100.0, constant), 0.7  # K^n is beyond the numbers
    enthalpy = 101.0 * constant * density**0.01
    assert law.enthalpy(constant * density**1.01) == pytest.approx(enthalpy, rel=1e-14)
    assert law.density(enthalpy) == pytest.approx(density, rel=1e-12)


def test_a_table_goes_on_as_the_polytrope_that_touches_it():
    exact = PolytropicLaw(1.5, 0.7)
    density = np.geomspace(1e-3, 10.0, 60)
    table = TabulatedLaw(0.7 * density ** (5 / 3), density)
    assert table.surface_index == pytest.approx(1.5, rel=1e-10)
    enthalpy = np.array([1e-6, 1e-3, 0.1, 3.0])
    np.testing.assert_allclose(table.density(enthalpy), exact.density(enthalpy), rtol=1e-7)
    np.testing.assert_allclose(table.pressure(enthalpy), exact.pressure(enthalpy), rtol=1e-7)
    np.testing.assert_allclose(table.enthalpy(exact.pressure(enthalpy)), enthalpy, rtol=1e-7)


def test_a_figure_from_a_table_is_that_of_the_law():
    density = np.geomspace(1e-4, 10.0, 200)
    table = TabulatedLaw(0.4 * density**2, density)
    figure = figure_of_barotropes([1.0], [table], rotation_parameter=0.1)
    exact = figure_of_polytrope(1.0, rotation_parameter=0.1)
    np.testing.assert_allclose(figure.zonal_harmonics[:3], exact.zonal_harmonics[:3], rtol=1e-7)
    assert figure.pressure[0] == pytest.approx(0.4 * figure.density[0] ** 2, rel=1e-7)


def test_what_is_no_law_is_refused():
    with pytest.raises(ValueError, match="above zero"):
        PolytropicLaw(0.0)
    with pytest.raises(ValueError, match="above zero"):
        Incompressible(-1.0)
    with pytest.raises(ValueError, match="zero_density"):
        CondensedLaw(lambda rho: rho - 2.0, 2.0, 1.0)
    with pytest.raises(ValueError, match="four rows"):
        TabulatedLaw(np.array([1.0, 2.0]), np.array([1.0, 2.0]))
    with pytest.raises(ValueError, match="ascend"):
        TabulatedLaw(np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 3.0, 2.0, 4.0]))
    with pytest.raises(ValueError, match="more pressure"):
        LAWS["tabulated"].density(1e6)
    with pytest.raises(ValueError, match="largest density"):
        LAWS["condensed"].density(1e6)


def test_a_solid_of_the_murnaghan_form_has_its_closed_enthalpy():
    """P = (rho^4 - 1)/4: e = (rho^3 - 1)/3."""
    law = LAWS["condensed"]
    for density in (1.0, 1.3, 2.9):
        assert law.density((density**3 - 1) / 3) == pytest.approx(density, rel=1e-13)
    assert math.isclose(float(law.enthalpy(0.0)), 0.0, abs_tol=1e-13)
