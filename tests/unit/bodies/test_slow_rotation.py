"""Moments of inertia, quadrupoles and Love numbers: closed forms, limits, independent values."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.neutron_stars import star
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.bodies.slow_rotation import decaying_exterior, love_number, slow_rotation
from astroinertia.bodies.tov import structure
from astroinertia.matter.compact_stars import (
    Barotrope,
    PowerLaw,
    constant_density,
    piecewise_polytrope,
    polytrope,
)

REFERENCE = [
    entry
    for entry in json.loads((Path(__file__).parents[2] / "reference" / "neutron_stars.json").read_text())
    if entry["name"] == "tov_hartle"
]


@pytest.mark.parametrize("entry", REFERENCE, ids=lambda entry: f"{entry['inputs']['rho0_c']:g}")
def test_reference_moments(entry):
    inputs, value = entry["inputs"], {key: float(text) for key, text in entry["value"].items()}
    body = star(polytrope(inputs["K"], inputs["Gamma"]), central_rest_density=inputs["rho0_c"])
    assert body.moment_ratio == pytest.approx(value["I_MR2"], rel=6e-11)
    assert body.moment_of_inertia == pytest.approx(value["I"], rel=1e-10)
    assert body.moment_bar == pytest.approx(value["I_M3"], rel=1e-10)
    assert body.moment_of_inertia_kg_m2 / 1e38 == pytest.approx(value["I_1e45gcm2"], rel=1e-8)


@pytest.mark.parametrize("index", [0.5, 1.0, 2.0, 3.0, 4.0])
def test_newtonian_limit(index):
    """I and k2 of Newton's polytrope; Q/(Omega^2 R^5) = 2 k2/3; relativistic stars reach all three linearly in C."""
    equation = polytrope(1.0, 1 + 1 / index)
    newton = star(equation, central_enthalpy=1e-3, relativistic=False)
    assert newton.moment_ratio == pytest.approx(lane_emden(index).moment_ratio, rel=2e-10)
    assert newton.rotation.quadrupole == pytest.approx(2 / 3 * newton.tidal_love_number, rel=1e-11)
    if index == 1.0:  # 15/pi^2 - 1 is the fluid Love number
        assert newton.tidal_love_number == pytest.approx((15 / math.pi**2 - 1) / 2, rel=1e-10)
    offsets = []
    for eta in (1e-6, 2e-6):
        body = star(equation, central_enthalpy=eta)
        offsets.append((body.moment_ratio / newton.moment_ratio - 1,
                        body.tidal_love_number / newton.tidal_love_number - 1,
                        body.rotation.quadrupole / newton.rotation.quadrupole - 1))  # fmt: skip
        assert max(map(abs, offsets[-1])) < 80 * body.compactness
    for first, second in zip(*offsets, strict=True):
        assert second / first == pytest.approx(2, rel=2e-3)


def test_incompressible_stars_by_their_series():
    """I/(M R^2) = 2/5 (1 + 6/7 C + 106/105 C^2 + ...) and k2 = 3/4 (1 - 40/7 C + ...).

    6/7 follows by hand from two orders of Hartle's equation; the series are those of Chan, Chan & Leung 2015, PRD 91,
    044017. The whole k2 comes from the jump of density at the surface: without it k2 would be infinite here.
    """
    for ratio in (1e-4, 2e-4):
        body = star(constant_density(1.0), central_enthalpy=ratio)
        C = body.compactness
        third = (body.moment_ratio / 0.4 - 1 - 6 / 7 * C) / C**2
        assert third == pytest.approx(106 / 105, rel=3e-3)
        assert (body.tidal_love_number / 0.75 - 1) / C == pytest.approx(-40 / 7, rel=2e-3)
    newton = star(constant_density(1.0), central_enthalpy=1.0, relativistic=False)
    assert newton.moment_ratio == pytest.approx(0.4, rel=1e-12)
    assert newton.tidal_love_number == pytest.approx(0.75, rel=1e-11)
    assert newton.rotation.quadrupole == pytest.approx(0.5, rel=1e-11)  # Maclaurin: J2 = q/2


@pytest.mark.parametrize("contrast", [1.3, 2.0, 8.0])
def test_two_incompressible_layers(contrast):
    """Newton's limit with a jump inside, against the equilibrium of two displaced level surfaces in a tide."""
    edge = 0.4
    core = PowerLaw(contrast, 1.0, edge * (1 - 1 / contrast), 0.0)  # P is continuous at the edge
    equation = Barotrope("two layers", (0.0, edge, math.inf), (PowerLaw(1.0, 1.0, 0.0, 0.0), core))
    body = star(equation, central_enthalpy=1.0, relativistic=False)
    profile = body.structure
    x = float(profile.r[np.argmin(np.abs(profile.log_enthalpy - edge))]) / profile.radius
    mean = 1 + (contrast - 1) * x**3
    assert body.moment_ratio == pytest.approx(0.4 * (1 + (contrast - 1) * x**5) / mean, rel=1e-11)

    radii, jumps = np.array([x, 1.0]), np.array([contrast - 1, 1.0])
    gravity = 4 * np.pi / 3 * np.array([contrast * x, mean])
    inner, outer = np.minimum.outer(radii, radii), np.maximum.outer(radii, radii)
    response = 4 * np.pi / 5 * jumps * radii**2 * inner**2 / outer**3  # potential of each displaced surface, l = 2
    displaced = np.linalg.solve(np.diag(gravity) - response, radii**2)
    assert body.tidal_love_number == pytest.approx(float((response @ displaced)[1]) / 2, rel=1e-10)


def test_jumps_at_the_surface_and_inside_are_limits_of_steep_slopes():
    """k2, Q and I of a density jump are what ever steeper slopes tend to: first order in their width."""
    jump = piecewise_polytrope(60.0, [2.0, 2.5], [5e-4], jumps=[1.5])
    exact = star(jump, central_rest_density=1.6e-3)
    errors = []
    for width in (0.04, 0.02):  # a soft piece of gamma = width between the two densities
        top = 5e-4 * 1.5
        pressure = jump.pieces[0].at(jump.edges[1])[1]
        soft = piecewise_polytrope(60.0, [2.0, width, 2.5], [5e-4, top])
        # the soft piece ends at a slightly higher pressure, so that the core keeps its own constant only in the limit
        body = star(soft, central_rest_density=1.6e-3)
        assert soft.pieces[1].at(soft.edges[2])[1] / pressure == pytest.approx(1.5**width, rel=1e-9)
        errors.append([body.tidal_love_number / exact.tidal_love_number - 1,
                       body.rotation.quadrupole / exact.rotation.quadrupole - 1,
                       body.moment_ratio / exact.moment_ratio - 1])  # fmt: skip
    for wide, narrow in zip(*errors, strict=True):
        assert abs(narrow) < 0.02
        assert narrow / wide == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("compactness", [0.05, 0.15, 0.28])
def test_love_number_is_hinderers_formula(compactness):
    """Eq. (23) of Hinderer 2008 as corrected in the erratum, where it does not cancel."""
    C = compactness
    for y in (0.3, 1.1, 1.9):
        bracket = 2 - y + 2 * C * (y - 1)
        below = 2 * C * (6 - 3 * y + 3 * C * (5 * y - 8))
        below += 4 * C**3 * (13 - 11 * y + C * (3 * y - 2) + 2 * C**2 * (1 + y))
        below += 3 * (1 - 2 * C) ** 2 * bracket * math.log(1 - 2 * C)
        direct = 8 / 5 * C**5 * (1 - 2 * C) ** 2 * bracket / below
        assert love_number(C, y) == pytest.approx(direct, rel=1e-7)
    # Newton's limit
    assert love_number(0.0, 1.1) == pytest.approx((2 - 1.1) / (2 * (3 + 1.1)), rel=1e-15)
    assert decaying_exterior(0.0) == (1.0, -3.0)


def test_rotation_needs_its_equations():
    with pytest.raises(ValueError, match="without the equations of slow rotation"):
        slow_rotation(structure(polytrope(100.0, 2.0), 0.1))


@pytest.mark.parametrize(("equation", "dragging"), [(constant_density(1e-3), 2.0), (polytrope(100.0, 2.0), 8 / 3)])
def test_central_dragging_of_a_faint_star(equation, dragging):
    """Lense and Thirring inside a body: omega/Omega = (16 pi/3) int rho r dr at the centre, 2 C and for n = 1 8 C/3."""
    for eta in (1e-10, 1e-7):
        body = star(equation, central_enthalpy=eta)
        assert body.rotation.central_dragging / body.compactness == pytest.approx(dragging, rel=2e-10 + 3 * eta)
