"""Lane-Emden solutions against independent 15-digit values, and the identities that a polytrope obeys."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.polytrope import Polytrope, lane_emden, polytrope_radius
from astroinertia.errors import NumericalError

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "polytropes.json").read_text())
QUANTITIES = {
    "polytrope.xi1": lambda n: lane_emden(n).xi_1,
    "polytrope.-xi1^2theta1p": lambda n: lane_emden(n).surface_mass,
    "polytrope.I_over_MR2": lambda n: lane_emden(n).moment_ratio,
    "polytrope.rhoc_over_rhomean": lambda n: lane_emden(n).central_to_mean,
    "polytrope.W_over_GM2R": lambda n: Polytrope(n).gravitational_energy,
}
INDICES = sorted({entry["inputs"]["n"] for entry in REFERENCE})


def test_reference_table_is_whole():
    assert len(REFERENCE) == len(QUANTITIES) * len(INDICES) == 45


@pytest.mark.parametrize("entry", REFERENCE, ids=lambda entry: f"{entry['name']}-{entry['inputs']['n']}")
def test_reference_values(entry):
    value = QUANTITIES[entry["name"]](float(entry["inputs"]["n"]))
    assert value == pytest.approx(float(entry["value"]), rel=5e-14)


def test_closed_forms_inside():
    xi = np.linspace(1e-3, 3.14, 2001)
    one = lane_emden(1.0)
    np.testing.assert_allclose(one.theta_at(xi), np.sin(xi) / xi, rtol=0, atol=1e-10)
    np.testing.assert_allclose(one.mass_at(xi), np.sin(xi) - xi * np.cos(xi), rtol=0, atol=1e-9)
    xi = np.linspace(0, 2.44, 501)
    np.testing.assert_allclose(lane_emden(0.0).theta_at(xi), 1 - xi**2 / 6, rtol=0, atol=1e-10)


@pytest.mark.parametrize("index", [0.0, 0.1, 0.7, 1.0, 2.2, 3.0, 4.0])
def test_gravitational_energy_is_the_integral(index):
    """W = -3GM^2/((5-n)R) is a theorem; the integral of -G m dm/r over the profile does not know it."""
    body = Polytrope(index, mass=2.0, radius=3.0)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    depth = (nodes + 1) / 2  # r = R (1 - depth^6): the density of a small index is singular at the surface
    r, weights = body.radius * (1 - depth**6), weights / 2 * body.radius * 6 * depth**5
    integrand = body.enclosed_mass(r) * body.density(r) * 4 * np.pi * r
    assert -integrand @ weights == pytest.approx(body.gravitational_energy, rel=3e-7)
    assert (body.density(r) * 8 * np.pi / 3 * r**4) @ weights == pytest.approx(body.moment_of_inertia, rel=3e-7)
    # virial theorem: 3 times the volume integral of P is -W
    assert 3 * (body.pressure(r) * 4 * np.pi * r**2) @ weights == pytest.approx(-body.gravitational_energy, rel=3e-7)


@pytest.mark.parametrize("index", [0.5, 1.0, 1.5, 3.0, 4.5])
def test_units_and_constant(index):
    body = Polytrope(index, mass=1.7, radius=0.3, gravitational_constant=2.5)
    r = np.linspace(0, 0.29, 50)
    np.testing.assert_allclose(body.pressure(r), body.constant * body.density(r) ** body.gamma, rtol=1e-12)
    if index != 3:
        assert polytrope_radius(index, 1.7, body.constant, 2.5) == pytest.approx(0.3, rel=1e-12)


def test_the_radius_of_a_star_of_nearly_constant_density_in_si():
    """Its mass to the power of (n - 1)/n is no number in kilograms."""
    body = Polytrope(0.05, 2e30, 7e8, gravitational_constant=6.6743e-11)
    assert polytrope_radius(0.05, 2e30, body.constant, 6.6743e-11) == pytest.approx(7e8, rel=1e-12)


def test_hydrostatic_balance():
    body = Polytrope(1.5, mass=2.0, radius=3.0)
    r, step = np.linspace(0.1, 2.9, 40), 1e-4
    slope = (body.pressure(r + step) - body.pressure(r - step)) / (2 * step)
    np.testing.assert_allclose(slope, -body.enclosed_mass(r) * body.density(r) / r**2, rtol=1e-5)


@pytest.mark.parametrize("index", [0.0, 1.5, 3.0, 4.9])
def test_radius_enclosing_inverts_the_mass(index):
    body = Polytrope(index, mass=2.0, radius=3.0)
    mass = np.linspace(0, 2, 1001)
    np.testing.assert_allclose(body.enclosed_mass(body.radius_enclosing(mass)), mass, rtol=0, atol=1e-14)
    assert body.radius_enclosing(2.0) == 3.0
    assert body.radius_enclosing(0.0) == 0.0


def test_entropy_function_is_flat_for_its_own_gamma_and_rises_for_a_larger_one():
    body = Polytrope(3.0)
    mass = np.linspace(0.001, 0.999, 200)
    np.testing.assert_allclose(body.entropy_function(mass, 4 / 3), body.constant, rtol=1e-9)
    assert (np.diff(body.entropy_function(mass, 5 / 3)) > 0).all()
    r = body.radius_enclosing(mass)
    np.testing.assert_allclose(
        body.entropy_function(mass, 5 / 3) * body.density(r) ** (5 / 3), body.pressure(r), rtol=1e-12
    )


@pytest.mark.parametrize("index", [-0.1, 5.0, math.nan, math.inf])
def test_indices_without_a_surface_are_refused(index):
    with pytest.raises(ValueError, match="0 <= n < 5"):
        lane_emden(index)


def test_questions_without_an_answer_are_refused():
    with pytest.raises(TypeError, match=r"index of Polytrope must be a number, not '1.5'"):
        Polytrope("1.5")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="incompressible"):
        _ = Polytrope(0.0).constant
    with pytest.raises(ValueError, match="index 3"):
        polytrope_radius(3.0, 1.0, 0.36)


def test_a_constant_beyond_what_numbers_hold_is_refused_in_a_sentence():
    thin = Polytrope(0.05, mass=1.0, radius=1e6)
    with pytest.raises(NumericalError, match=r"index 0.05 has a pressure in proportion to density\^21, beyond what"):
        _ = thin.constant
    assert Polytrope(0.05, mass=1.0, radius=1.0).constant > 0.0


@pytest.mark.parametrize(
    "wrong", [{"mass": -1.0}, {"radius": 0.0}, {"radius": np.nan}, {"gravitational_constant": -2.0}]
)
def test_sizes_that_no_star_has_are_refused(wrong):
    (name,) = wrong
    with pytest.raises(ValueError, match=f"{name} must be positive and finite"):
        Polytrope(1.5, **wrong)
    if name == "mass":
        with pytest.raises(ValueError, match="mass must be positive"):
            polytrope_radius(1.5, -1.0, 1.0)


def test_what_is_no_number_stays_so_and_no_radius_encloses_more_than_all():
    star = Polytrope(1.5, 2.0, 3.0)
    for of in (star.density, star.enclosed_mass, star.radius_enclosing, star.pressure):
        found = of(np.array([np.nan, 1.0]))
        assert np.isnan(found[0]) and np.isfinite(found[1])
    for of in (star.density, star.enclosed_mass, star.pressure):
        with pytest.raises(ValueError, match="r must not be negative, not -1"):
            of(np.array([0.5, -1.0]))
    assert star.radius_enclosing(2.0 * (1 + 1e-12)) == 3.0  # rounding of a sum
    for mass in (2.1, -0.1):
        with pytest.raises(ValueError, match="between 0 and the whole mass of 2"):
            star.radius_enclosing(mass)
