"""Composite polytropes against single ones, closed forms, and identities that no interface may break."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.apsidal import love_number
from astroinertia.bodies.composite_polytrope import composite_polytrope
from astroinertia.bodies.polytrope import Polytrope, lane_emden

ENTRIES = json.loads((Path(__file__).parents[2] / "reference" / "love_numbers.json").read_text())
LAYERS = [each for each in ENTRIES if each["name"] == "two_layer_clairaut" and float(each["inputs"]["rc/R"]) > 0]


@pytest.mark.parametrize("index", [0.3, 3.0])
def test_equal_indices_make_a_single_polytrope(index):
    body = composite_polytrope(index, index, pressure_ratio=0.1)
    assert body.moment_ratio == pytest.approx(lane_emden(index).moment_ratio, rel=2e-14)
    assert body.central_to_mean == pytest.approx(lane_emden(index).central_to_mean, rel=2e-14)
    assert body.gravitational_energy == pytest.approx(-3 / (5 - index), rel=2e-14)
    for degree in (2, 3, 8):
        assert body.love_number(degree) == pytest.approx(love_number(index, degree), rel=5e-14)


@pytest.mark.slow
@pytest.mark.parametrize(
    "entry",
    [LAYERS[0], *(pytest.param(each, marks=pytest.mark.full) for each in LAYERS[1:])],
    ids=lambda entry: entry["inputs"]["rc/R"] + "-" + entry["inputs"]["rho_c/rho_m"],
)
def test_two_incompressible_layers(entry):
    """Closed forms of Clairaut's equation for two homogeneous layers; the mass and W follow by hand."""
    x, ratio = float(entry["inputs"]["rc/R"]), float(entry["inputs"]["rho_c/rho_m"])
    body = composite_polytrope(0, 0, radius_fraction=x, weight_ratio=1 / ratio)
    assert body.love_number() == pytest.approx(float(entry["value"]["k_fluid"]), rel=1e-13)
    assert body.moment_ratio == pytest.approx(float(entry["value"]["I_mean_MR2"]), rel=1e-13)
    heavy = (ratio - 1) * x**3
    assert body.core_mass_fraction == pytest.approx(ratio * x**3 / (1 + heavy), rel=1e-13)
    inner, outer = ratio**2 * x**5 / 5, (heavy * (1 - x**2) / 2 + (1 - x**5) / 5)
    assert body.gravitational_energy == pytest.approx(-3 * (inner + outer) / (1 + heavy) ** 2, rel=1e-13)


def test_five_one_bipolytrope():
    """n = 5 inside n = 1 (Eggleton, Faulkner & Cannon 1998, MNRAS 298, 831): both zones in elementary functions.

    Core: theta = (1 + xi^2/3)^(-1/2), m = xi^3 theta^3/3. Envelope, 4 pi G = 1, P = K rho^2 with k^2 = 1/(2 K):
    rho = A sin(b - k r)/r ends at b = k R, with A and b from the density and mass at the interface.
    """
    ratio, xi = 0.5, 2.0
    theta = (1 + xi**2 / 3) ** -0.5
    density, mass, pressure = ratio * theta**5, xi**3 * theta**3 / 3, theta**6 / 6
    k = density / math.sqrt(2 * pressure)
    # K rho' = -m/(2 r^2), and rho' = -rho (k cot(phase) + 1/r) with phase = b - k r
    cotangent = (mass * k**2 / (density * xi**2) - 1 / xi) / k
    phase = math.atan2(1.0, cotangent)
    amplitude = density * xi / math.sin(phase)
    radius = xi + phase / k
    body = composite_polytrope(5, 1, pressure_ratio=theta**6, weight_ratio=ratio)
    assert body.core_radius_fraction == pytest.approx(xi / radius, rel=1e-13)
    # m(R) = -2 K R^2 rho'(R) = A R/k
    assert body.core_mass_fraction == pytest.approx(mass * k / (amplitude * radius), rel=1e-13)
    r = np.linspace(0.001, 0.9999, 400)
    xi_r = r * radius
    inside = xi_r < xi
    exact = np.where(inside, (1 + xi_r**2 / 3) ** -2.5, amplitude * np.sin(k * (radius - xi_r)) / xi_r)
    np.testing.assert_allclose(body.density(r), body.central_density * exact, rtol=0, atol=2e-9 * body.central_density)


@pytest.mark.full
@pytest.mark.parametrize(("indices", "ratio"), [((3, 1.5), 1.0), ((1.5, 3), 0.6), ((0.5, 0), 0.8), ((10, 4.5), 0.9)])
def test_virial_theorem(indices, ratio):
    body = composite_polytrope(*indices, pressure_ratio=0.2, weight_ratio=ratio, mass=2.0, radius=3.0,
                               gravitational_constant=5.0)  # fmt: skip
    assert body.virial_energy == pytest.approx(body.gravitational_energy, rel=2e-14)
    edge = body.core_radius_fraction * body.radius
    below, above = body.density(edge * (1 - 1e-10)), body.density(edge * (1 + 1e-10))
    assert above / below == pytest.approx(ratio, rel=1e-6)
    assert body.pressure(edge * (1 - 1e-10)) == pytest.approx(body.pressure(edge * (1 + 1e-10)), rel=1e-6)
    assert body.enclosed_mass(3.0) == pytest.approx(2.0, rel=1e-14)
    r, step = np.linspace(0.05, 2.95, 30), 1e-4
    r = r[np.abs(r - edge) > 0.01]
    slope = (body.pressure(r + step) - body.pressure(r - step)) / (2 * step)
    weight = 5.0 * body.enclosed_mass(r) * body.density(r) / r**2
    np.testing.assert_allclose(-slope, weight, rtol=1e-4, atol=1e-4 * weight.max())


@pytest.mark.full
def test_interfaces_by_radius_mass_and_pressure_agree():
    one = composite_polytrope(3, 1.5, mass_fraction=0.4, weight_ratio=0.9)
    two = composite_polytrope(3, 1.5, radius_fraction=one.core_radius_fraction, weight_ratio=0.9)
    three = composite_polytrope(3, 1.5, pressure_ratio=two.interface_pressure_ratio, weight_ratio=0.9)
    assert one.core_mass_fraction == pytest.approx(0.4, rel=1e-12)
    for body in (two, three):
        assert body.moment_ratio == pytest.approx(one.moment_ratio, rel=1e-11)
        assert body.love_number() == pytest.approx(one.love_number(), rel=1e-11)


def test_profile_units():
    """A single polytrope in disguise has the density, pressure and masses of `Polytrope`, in any units."""
    plain = Polytrope(1.5, 2.0, 3.0, 0.7)
    body = composite_polytrope(1.5, 1.5, pressure_ratio=0.3, mass=2.0, radius=3.0, gravitational_constant=0.7)
    r = np.linspace(0, 3.1, 200)
    for name in ("density", "pressure", "enclosed_mass"):
        exact = getattr(plain, name)(r)
        np.testing.assert_allclose(getattr(body, name)(r), exact, rtol=0, atol=2e-9 * exact.max())
    assert body.moment_of_inertia == pytest.approx(plain.moment_of_inertia, rel=1e-13)
    assert body.gravitational_energy == pytest.approx(plain.gravitational_energy, rel=1e-13)


@pytest.mark.full
def test_fractions_that_no_or_several_interfaces_have_are_refused():
    """Cores of index 5 in n = 1 have a largest mass if the weights differ by more than 3 (Eggleton et al. 1998)."""
    assert composite_polytrope(5, 1, mass_fraction=0.9, weight_ratio=0.34).core_mass_fraction == pytest.approx(0.9)
    with pytest.raises(ValueError, match="no interface has mass_fraction"):
        composite_polytrope(5, 1, mass_fraction=0.42, weight_ratio=0.32)
    with pytest.raises(ValueError, match="2 interfaces have mass_fraction"):
        composite_polytrope(5, 1, mass_fraction=0.38, weight_ratio=0.32)
    low, high = (composite_polytrope(5, 1, pressure_ratio=p, weight_ratio=0.32) for p in (1e-9, 0.05))
    assert low.core_mass_fraction < 0.38 > high.core_mass_fraction


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="one of"):
        composite_polytrope(1, 1)
    with pytest.raises(ValueError, match="one of"):
        composite_polytrope(1, 1, mass_fraction=0.5, radius_fraction=0.5)
    with pytest.raises(ValueError, match="between 0 and 1"):
        composite_polytrope(1, 1, mass_fraction=1.0)
    with pytest.raises(ValueError, match="envelope"):
        composite_polytrope(1, 5, mass_fraction=0.5)
    with pytest.raises(ValueError, match="core needs"):
        composite_polytrope(-1, 1, mass_fraction=0.5)
    with pytest.raises(ValueError, match="weight_ratio"):
        composite_polytrope(1, 1, mass_fraction=0.5, weight_ratio=0.0)
    with pytest.raises(ValueError, match="degrees 2 to 8"):
        composite_polytrope(1, 1, pressure_ratio=0.5).love_number(9)
