"""Love numbers and flattening of layered bodies: exact two layers, n = 1, PREM, Radau's equation."""

import json
import math
from pathlib import Path

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import spherical_jn

from astroinertia.bodies.clairaut import (
    hydrostatic_figure,
    love_number,
    radau_darwin_error,
    radau_darwin_love_number,
    radau_darwin_moment_ratio,
    radau_variable,
)
from astroinertia.bodies.earth import prem
from astroinertia.bodies.layered import constant_layers, linear_layers, polynomial_layers, tabulated_layers

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "layered.json").read_text())
TWO_LAYERS = [entry for entry in REFERENCE if entry["name"] == "two_layer_clairaut"]
PREM = next(entry for entry in REFERENCE if entry["name"] == "PREM")
SOME = (2, *(pytest.param(degree, marks=pytest.mark.full) for degree in (3, 5, 8)))  # each is compiled for itself


def polytrope_of_index_one(gravitational_constant=1.0):
    """sin(pi x)/(pi x) by its series, to round-off."""
    terms = np.zeros(29)
    terms[::2] = [(-1) ** k * math.pi ** (2 * k) / math.factorial(2 * k + 1) for k in range(15)]
    return polynomial_layers([1.0], [terms], gravitational_constant)


@pytest.mark.parametrize("entry", TWO_LAYERS, ids=lambda entry: str(entry["inputs"]["rc/R"]))
def test_two_layers_have_the_exact_figure(entry):
    core, density, small_m = (float(entry["inputs"][key]) for key in ("rc/R", "rho_c/rho_m", "m=omega2R3/GM"))
    body = constant_layers([core, 1.0], [density, 1.0])
    figure = hydrostatic_figure(body, math.sqrt(small_m * float(body.mass)))
    scale = float(body.mass)
    found = {
        "I_mean_MR2": figure.mean_moment / scale,
        "eps_core": figure.layer_flattenings[0],
        "eps_surf": figure.flattening,
        "inv_flattening": 1 / figure.flattening,
        "J2": figure.j2,
        "k_fluid": figure.love_number,
        "DarwinRadau_C_MR2": radau_darwin_moment_ratio(figure.love_number),
        "C_polar_MR2": figure.polar_moment / scale,
        "H_dyn": figure.dynamical_flattening,
    }
    for name, value in found.items():
        assert value == pytest.approx(float(entry["value"][name]), rel=2e-14), name
    assert radau_darwin_error(body) == pytest.approx(float(entry["value"]["DR_error"]), abs=1e-15)
    assert (2 * figure.equatorial_moment + figure.polar_moment) / 3 == pytest.approx(figure.mean_moment, rel=1e-15)
    assert (figure.equatorial_radius - figure.polar_radius) == pytest.approx(figure.flattening, rel=1e-14)


@pytest.mark.slow
def test_prem_has_its_reference_figure():
    """The first-order values: a body of PREM's layers that turns like the Earth, G such that G M is the Earth's."""
    inputs, value = PREM["inputs"], {key: float(number) for key, number in PREM["value"].items()}
    figure = hydrostatic_figure(prem(inputs["GM"] / float(prem().mass)), inputs["omega"])
    assert 1 / figure.flattening == pytest.approx(value["inv_flattening_first_order"], rel=2e-9)
    assert figure.love_number == pytest.approx(value["k_fluid"], rel=1e-8)
    assert figure.j2 == pytest.approx(value["J2_hydrostatic_first_order"], rel=1e-9)
    assert figure.dynamical_flattening == pytest.approx(value["H_hydrostatic_first_order"], rel=1e-9)
    assert figure.small_m == pytest.approx(value["m"], rel=1e-12)
    assert radau_variable(prem()) == pytest.approx(value["radau_eta_surface"], rel=2e-9)
    assert radau_darwin_moment_ratio(figure.love_number) == pytest.approx(value["DarwinRadau_from_eta"], rel=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("degree", SOME)
def test_the_polytrope_of_index_one_has_its_closed_form(degree):
    """psi = j_l(pi x) for n = 1, so that k_l follows from Bessel functions; k_2 = 15/pi^2 - 1."""
    slope = math.pi * spherical_jn(degree, math.pi, derivative=True) / spherical_jn(degree, math.pi)
    exact = (degree - slope) / (degree + 1 + slope)
    assert love_number(polytrope_of_index_one(), degree) == pytest.approx(exact, rel=1e-12)
    if degree == 2:
        assert exact == pytest.approx(15 / math.pi**2 - 1, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("degree", SOME)
def test_a_homogeneous_body_and_shells_of_one_density(degree):
    exact = 3 / (2 * (degree - 1))
    assert love_number(constant_layers([0.2, 0.7, 3.0], [5.0] * 3), degree) == pytest.approx(exact, rel=1e-15)
    assert radau_variable(linear_layers([0.2, 3.0], [5.0] * 2, [5.0] * 2), degree) == pytest.approx(
        degree - 2, abs=1e-14
    )


@pytest.mark.full
@pytest.mark.parametrize("degree", [2, 6])
def test_collocation_agrees_with_radaus_equation(degree):
    """An adaptive integration of eta, which knows neither potentials nor jumps."""
    body = polynomial_layers([0.4, 0.7, 2.0], [[9.0, 0.0, -5.0], [5.0, -2.0], [2.0, 0.0, -1.0, -0.5]])
    start = 1e-3

    def slope(r, eta):
        mean = float(body.enclosed_mass(r)) / (4 / 3 * np.pi * r**3)
        return (degree * (degree + 1) - 6 * float(body.density(r)) / mean * (eta + 1) - eta * (eta - 1)) / r

    eta, inner = degree - 2.0, start  # the density is even at the centre: eta departs from l - 2 with r^2
    for outer in (0.4, 0.7, 2.0):
        run = solve_ivp(slope, (inner + 1e-14, outer), [eta], method="DOP853", rtol=1e-9, atol=1e-9)
        eta, inner = run.y[0, -1], outer
    assert radau_variable(body, degree) == pytest.approx(eta, abs=1e-7)


@pytest.mark.full
def test_more_steps_converge_with_the_order_of_gauss():
    body = linear_layers([1.0], [1.0], [0.0])
    exact = love_number(body, 8, 40)
    errors = [abs(float(love_number(body, 8, steps) / exact - 1)) for steps in (2, 4)]
    assert errors[0] > 1e-9 and abs(float(love_number(body, 8) / exact - 1)) < 1e-12
    assert math.log(errors[0] / errors[1]) / math.log(2) > 10  # 8 nodes: order 16 in the end


@pytest.mark.full
@pytest.mark.parametrize("degree", SOME)
def test_constant_layers_are_exact_by_either_way(degree):
    radii, densities = [0.1, 0.4, 0.9, 1.0], [9.0, 3.0, 5.0, 1.0]
    by_matrix = constant_layers(radii, densities)
    by_collocation = linear_layers(radii, densities, densities)
    assert love_number(by_matrix, degree) == pytest.approx(love_number(by_collocation, degree, 1), rel=1e-14)


@pytest.mark.full
def test_a_fine_table_tends_to_the_smooth_body():
    x = np.linspace(0, 1, 401)
    exact = love_number(polytrope_of_index_one())
    errors = []
    for stride in (4, 2):
        at = x[::stride]
        rows = tabulated_layers(at, np.where(at < 1, np.sinc(at), 0.0))
        errors.append(float(love_number(rows, 2, 1) / exact - 1))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.02) and abs(errors[1]) < 1e-4


def test_radau_darwin_inverts_and_is_exact_where_it_should_be():
    assert radau_darwin_moment_ratio(1.5) == pytest.approx(0.4, rel=1e-15)
    ratios = np.linspace(2 / 15, 0.4, 7)
    assert radau_darwin_moment_ratio(radau_darwin_love_number(ratios)) == pytest.approx(ratios, rel=1e-14)
    assert radau_darwin_love_number(np.float32(0.4)) == pytest.approx(1.5, rel=1e-6)
    assert radau_darwin_moment_ratio(np.float32(1.5)) == pytest.approx(0.4, rel=1e-6)
    with pytest.raises(ValueError, match=r"not 0\.40001"):
        radau_darwin_love_number(np.float32(0.40001))
    assert abs(radau_darwin_error(prem())) == pytest.approx(1.84e-5, rel=0.01)
    for k2 in (1.5 + 1e-6, -1e-6, [1.0, 2.0]):
        with pytest.raises(ValueError, match="fluid k_2 is from 0 to 3/2"):
            radau_darwin_moment_ratio(k2)
    for ratio in (0.13, 0.4001):
        with pytest.raises(ValueError, match=r"from 2/15 .* to 0\.4"):
            radau_darwin_love_number(ratio)


@pytest.mark.parametrize("degree", [1, 2.5, np.inf, np.nan])
def test_degrees_without_meaning_are_refused(degree):
    with pytest.raises(ValueError, match="degree of 2 or more"):
        love_number(constant_layers([1.0], [1.0]), degree)


def test_a_body_faster_than_an_orbit_at_its_surface_is_refused():
    """It had a flattening of 62; within a transformation nothing can be refused."""
    one = constant_layers([1.0], [3 / (4 * np.pi)])  # M = R = G = 1
    assert float(hydrostatic_figure(one, 0.999).flattening) == pytest.approx(1.25 * 0.999**2)
    for rate in (1.001, -8.0):
        with pytest.raises(ValueError, match=r"as fast as an orbit at its surface, or faster: not (1|64)"):
            hydrostatic_figure(one, rate)
    with jax.enable_x64(True):
        rates = jax.numpy.array([0.1, 2.0])
        flat = jax.vmap(lambda rate: hydrostatic_figure(one, rate).flattening)(rates)
    np.testing.assert_allclose(flat, 1.25 * np.array([0.01, 4.0]), rtol=1e-12)
