"""Tables: what they reproduce, the first law between their rows, and what they refuse."""

import numpy as np
import pytest

from astroinertia.bodies.neutron_stars import star
from astroinertia.matter.compact_stars import energy_polytrope, piecewise_polytrope, polytrope
from astroinertia.matter.compact_tables import tabulated

GAMMA_TWO = polytrope(100.0, 2.0)


def rows(equation, count, lowest=1e-5, highest=2.0):
    eta = np.geomspace(lowest, highest, count)
    return {name: getattr(equation, name)(eta) for name in ("pressure", "energy_density", "rest_density")}


@pytest.mark.parametrize("by", ["energy_density", "rest_density"])
@pytest.mark.parametrize("gamma", [1.5, 2.0, 3.0])
def test_a_power_law_is_reproduced_exactly(by, gamma):
    """Rows of energy, too, whose own logarithm is no line: interpolating that had densities off by 2e-3 for gamma 3."""
    exact = polytrope(100.0, gamma)
    table = rows(exact, 7)
    equation = tabulated(table["pressure"], **{by: table[by]})
    eta = np.geomspace(1e-8, 1.99, 50)
    for name in ("pressure", "rest_density", "energy_density"):
        np.testing.assert_allclose(getattr(equation, name)(eta), getattr(exact, name)(eta), rtol=1e-12)


def test_below_its_first_row_a_table_of_energies_is_the_power_law_of_its_rest_density():
    """The gamma is that of rho0, not of e = rho0 + n P, which had densities there off by 2e-3."""
    rest, exact = np.geomspace(1e-6, 1e-2, 17), GAMMA_TWO
    table = tabulated(100 * rest**2, energy_density=rest + 100 * rest**2)
    eta = np.array([1e-9, 1e-6, 1.9e-4])  # the first row is at 2e-4
    np.testing.assert_allclose(table.rest_density(eta), exact.rest_density(eta), rtol=1e-12)
    np.testing.assert_allclose(table.pressure(eta), exact.pressure(eta), rtol=1e-12)


def test_more_rows_are_more_accurate():
    """A power law of the energy, which of rho0 is none: from 15 to 120 rows the star converges faster than rows^-3."""
    law = energy_polytrope(100.0, 2.0)
    exact = star(law, central_pressure=1.6384e-4)
    names = ("mass", "radius", "rest_mass", "moment_of_inertia", "tidal_love_number")
    errors = []
    for count in (15, 30, 60, 120):
        table = rows(law, count)
        body = star(tabulated(table["pressure"], table["energy_density"]), central_pressure=1.6384e-4)
        errors.append([abs(getattr(body, name) / getattr(exact, name) - 1) for name in names])
    assert max(errors[-1]) < 3e-8
    assert np.all(np.array(errors[0]) / np.array(errors[-1]) > 8**3)


@pytest.mark.parametrize("by", ["energy_density", "rest_density"])
def test_first_law_between_the_rows(by):
    """Kinks, rough rows and a transition: dP = rho0 d eta still holds, and the density rises."""
    kinked = piecewise_polytrope(60.0, [1.7, 2.8, 1.6], [2e-4, 8e-4], jumps=[1.0, 1.3])
    table = rows(kinked, 31, 1e-4, 0.8)
    noise = 1 + 0.003 * np.random.default_rng(5).standard_normal(31)
    equation = tabulated(table["pressure"], **{by: np.sort(table[by] * noise)})
    for low, high in zip(equation.edges, equation.edges[1:], strict=False):
        eta = np.linspace(low, high, 203)[1:-1]
        step = 1e-6 * (high - low)
        slope = (equation.pressure(eta + step) - equation.pressure(eta - step)) / (2 * step)
        np.testing.assert_allclose(slope, equation.rest_density(eta), rtol=1e-6)
        assert np.all(np.diff(equation.rest_density(eta)) > 0)
        assert np.all(equation.sound_speed_squared(eta) > 0)
    at_rows = np.array([equation.enthalpy_of("pressure", float(value)) for value in table["pressure"][1:-1]])
    np.testing.assert_allclose(getattr(equation, by)(at_rows), np.sort(table[by] * noise)[1:-1], rtol=1e-10)


def test_two_rows_of_one_pressure_are_a_jump():
    jump = piecewise_polytrope(60.0, [2.0, 2.5], [5e-4], jumps=[1.5])
    edge = jump.edges[1]
    eta = np.concatenate([np.geomspace(1e-4, edge, 12), [edge], np.geomspace(edge, 1.0, 12)[1:]])
    density = jump.rest_density(eta)
    density[12] = jump.pieces[1].at(edge)[0]
    table = tabulated(jump.pressure(eta), rest_density=density)
    assert len(table.pieces) == 3
    assert table.edges[2] == pytest.approx(edge, rel=1e-12)
    one, other = star(jump, central_rest_density=1.5e-3), star(table, central_rest_density=1.5e-3)
    for name in ("mass", "radius", "moment_of_inertia", "tidal_love_number", "quadrupole_bar"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=2e-8), name


def test_refusals():
    table = rows(GAMMA_TWO, 12)
    P, e, rho = table["pressure"], table["energy_density"], table["rest_density"]
    equation = tabulated(P, e, rho)  # the three agree
    with pytest.raises(ValueError, match="above the largest that it covers"):
        star(equation, central_pressure=1.01 * P[-1])
    with pytest.raises(ValueError, match="lies outside 0 to"):
        star(equation, central_enthalpy=2.1)
    assert star(equation, central_pressure=float(P[-1])).mass > 0
    with pytest.raises(ValueError, match="first law"):
        tabulated(P, e, rho * np.linspace(1, 1.1, 12))
    assert tabulated(P, e, 1.008 * rho).name == "table"  # another mass of the baryon
    with pytest.raises(ValueError, match="pressure must rise from row to row; it falls after row 4"):
        tabulated(np.where(np.arange(12) == 5, P[3], P), e)
    with pytest.raises(ValueError, match="energy_density must rise"):
        tabulated(P, e[::-1])
    with pytest.raises(ValueError, match="have the same density"):
        tabulated(P, rest_density=np.where(np.arange(12) == 5, rho[4], rho))
    with pytest.raises(ValueError, match="positive and finite"):
        tabulated(P, np.where(np.arange(12) == 5, np.nan, e))
    with pytest.raises(ValueError, match="needs energy_density or rest_density"):
        tabulated(P)
    with pytest.raises(ValueError, match="whole rows"):
        tabulated(P[:3], e[:3])
    with pytest.raises(ValueError, match="whole rows"):
        tabulated(P, e[:-1])
    with pytest.raises(ValueError, match="first rows have gamma"):
        tabulated(1e-3 * rho**0.9, rest_density=rho)
    with pytest.raises(ValueError, match="two rows of the same pressure"):
        tabulated(
            np.r_[P[:4], P[4], P[4], P[4], P[5:]], rest_density=np.r_[rho[:5], 1.01 * rho[4], 1.02 * rho[4], rho[5:]]
        )


def test_acausal_tables_are_reported():
    stiff = polytrope(1e4, 3.0)
    table = rows(stiff, 40, 1e-3, 3.0)
    equation = tabulated(table["pressure"], table["energy_density"])
    assert star(equation, central_enthalpy=0.9).causal
    assert not star(equation, central_enthalpy=1.1).causal
