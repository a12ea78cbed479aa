"""Structure of relativistic and Newtonian stars: closed forms, independent values, convergence."""

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.polytrope import Polytrope, lane_emden, polytrope_radius
from astroinertia.bodies.tov import structure
from astroinertia.errors import NumericalError
from astroinertia.matter.compact_stars import (
    SOLAR_LENGTH,
    constant_density,
    energy_polytrope,
    piecewise_polytrope,
    polytrope,
)

REFERENCE = [
    entry
    for entry in json.loads((Path(__file__).parents[2] / "reference" / "neutron_stars.json").read_text())
    if entry["name"] == "tov_hartle"
]


@pytest.mark.parametrize("entry", REFERENCE, ids=lambda entry: f"{entry['inputs']['rho0_c']:g}")
def test_reference_values(entry):
    """To half a unit of the reference's last (eleventh) digit and its stated 2e-12."""
    inputs, value = entry["inputs"], {key: float(text) for key, text in entry["value"].items()}
    equation = polytrope(inputs["K"], inputs["Gamma"])
    star = structure(equation, equation.enthalpy_of("rest_density", inputs["rho0_c"]))
    found = {"M": star.mass, "R": star.radius, "Mb": star.rest_mass, "C": star.compactness}
    for name, number in found.items():
        assert number == pytest.approx(value[name], rel=6e-11), name
    assert star.radius * SOLAR_LENGTH / 1e3 == pytest.approx(value["R_km"], rel=1e-8)


@pytest.mark.parametrize("compactness", [1e-5, 0.1, 0.3, 0.44])
def test_schwarzschild_interior(compactness):
    """Schwarzschild 1916: P/e, the lapse and the radius of a star of constant density."""
    root = math.sqrt(1 - 2 * compactness)
    ratio = 2 * compactness / (1 + root) / (3 * root - 1)  # (1 - root)/(3 root - 1) without cancellation
    star = structure(constant_density(1e-3), ratio)
    assert star.compactness == pytest.approx(compactness, rel=2e-11)
    assert star.radius == pytest.approx(math.sqrt(3 * compactness / (4e-3 * math.pi)), rel=2e-11)
    inner = np.sqrt(1 - 2 * compactness * (star.r / star.radius) ** 2)
    np.testing.assert_allclose(star.lapse, (3 * root - inner) / 2, rtol=0, atol=3e-11)
    np.testing.assert_allclose(star.enclosed_mass, 4e-3 * math.pi / 3 * star.r**3, rtol=1e-10, atol=1e-300)
    # all baryons lie in the proper volume: its integral is elementary, arcsin x - x sqrt(1 - x^2), x^2 = 2 C
    x = math.sqrt(2 * compactness)
    if compactness > 1e-3:
        volume = 1.5 / x**3 * (math.asin(x) - x * root)
        assert star.rest_mass / star.mass == pytest.approx(volume, rel=2e-11)


@pytest.mark.parametrize("pressure", [1e6, 1e12, 1e20, 1e30, 1e60])
def test_a_star_of_constant_density_and_any_pressure_comes_up_to_buchdahls_limit(pressure):
    """P/e = (1 - s)/(3 s - 1) with s^2 = 1 - 2 M/R (Schwarzschild 1916): s falls to 1/3, and M/R is 4/9."""
    equation = constant_density(1e-3)
    assert equation.energy_density(pressure) == pytest.approx(1e-3, rel=1e-15)
    root = (1 + pressure) / (1 + 3 * pressure)
    assert structure(equation, pressure).compactness == pytest.approx((1 - root**2) / 2, rel=1e-11)


@pytest.mark.slow
def test_a_star_whose_surface_is_never_reached_is_refused_in_finite_time():
    with pytest.raises(NumericalError, match="no surface that can be found"):
        structure(energy_polytrope(100.0, 1.01), 1e100)


@pytest.mark.parametrize("index", [0.3, 1.0, 1.5, 2.3, 3.0, 4.0, 4.5])
def test_newtonian_stars_are_lane_emden(index):
    gamma = 1 + 1 / index
    star = structure(polytrope(2.0, gamma), 0.01, relativistic=False)
    solution = lane_emden(index)
    assert star.enclosed_mass[-1] == star.mass == star.rest_mass
    mean = 3 * star.mass / (4 * math.pi * star.radius**3)
    assert star.central_rest_density / mean == pytest.approx(solution.central_to_mean, rel=3e-10)
    assert star.central_log_enthalpy == pytest.approx(0.01)
    if index != 3.0:
        assert star.radius == pytest.approx(polytrope_radius(index, star.mass, 2.0), rel=1e-9)
    body = Polytrope(index, star.mass, star.radius)
    inside = slice(1, -1)
    np.testing.assert_allclose(
        star.enclosed_mass[inside], body.enclosed_mass(star.r[inside]), rtol=0, atol=2e-10 * star.mass
    )


@pytest.mark.parametrize("index", [0.5, 1.0, 2.0])
def test_relativity_vanishes_linearly(index):
    """At C ~ 1e-6 and 2e-6 the relativistic star differs from Newton's in proportion to C."""
    equation = polytrope(1.0, 1 + 1 / index)
    offsets = []
    for eta in (1e-6, 2e-6):
        star = structure(equation, eta)
        newton = structure(equation, eta, relativistic=False)
        offsets.append(star.mass / newton.mass - 1)
        assert 0 < abs(offsets[-1]) < 20 * star.compactness
        assert 0 < star.rest_mass / star.mass - 1 < 2 * star.compactness
    assert offsets[1] / offsets[0] == pytest.approx(2, rel=1e-3)


def test_tolerance_buys_accuracy():
    """Over four settings the error falls with the tolerance, by more than it took to be lucky."""
    equation = polytrope(100.0, 2.0)
    eta = equation.enthalpy_of("rest_density", 1.28e-3)
    best = structure(equation, eta, tolerance=3e-14)
    errors = []
    for tolerance in (1e-5, 1e-7, 1e-9, 1e-11):
        star = structure(equation, eta, tolerance=tolerance)
        errors.append(abs(star.mass / best.mass - 1) + abs(star.radius / best.radius - 1))
    assert errors[-1] < 1e-11
    for coarse, fine in pairwise(errors):
        assert fine < 0.1 * coarse


def test_a_piece_too_many_changes_nothing():
    """A polytrope cut into pieces of one gamma is the same star, and its profile passes through the breaks."""
    whole, cut = polytrope(100.0, 2.0), piecewise_polytrope(100.0, [2.0, 2.0, 2.0], [2e-4, 9e-4])
    eta = whole.enthalpy_of("rest_density", 1.28e-3)
    one, other = structure(whole, eta), structure(cut, eta)
    for name in ("mass", "radius", "rest_mass"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=2e-11)
    for edge in cut.edges[1:3]:
        assert np.min(np.abs(other.log_enthalpy - math.log1p(edge))) < 1e-15


def test_refusals():
    equation = polytrope(100.0, 2.0)
    with pytest.raises(ValueError, match="central_enthalpy must be positive"):
        structure(equation, -0.1)
    for matter, enthalpy in ((equation, 1e-300), (polytrope(1.0, 1.001), 0.3)):
        with pytest.raises(NumericalError, match="lie beyond the digits of numbers"):
            structure(matter, enthalpy)
    with pytest.raises(ValueError, match="its pressure is beyond what numbers hold"):
        structure(polytrope(1.0, 1.001), 1e12)
    with pytest.raises(ValueError, match="tolerance must lie between"):
        structure(equation, 0.1, tolerance=1e-16)
