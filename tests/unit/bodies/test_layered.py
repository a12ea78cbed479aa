"""Layered bodies against closed forms, against quadrature of their own profile, and PREM against an exact reference."""

import json
from pathlib import Path

import jax
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

from astroinertia.bodies.earth import prem, prem_layer_names
from astroinertia.bodies.layered import constant_layers, linear_layers, polynomial_layers, tabulated_layers
from astroinertia.matter import planetary
from astroinertia.matter.planetary import IRON_HCP

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "layered.json").read_text())
PREM = next(entry for entry in REFERENCE if entry["name"] == "PREM")["value"]
GALLERY = {
    "constant": constant_layers([0.3, 0.5, 2.0], [7.0, 9.0, 2.0], 1.7),
    "linear": linear_layers([0.4, 2.0], [7.0, 3.0], [6.0, 1.0], 1.7),
    "polynomial": polynomial_layers([0.4, 1.1, 2.0], [[7.0, 0.0, -3.0, 0.5], [4.0, -1.0], [2.0]], 1.7),
}


def test_prem_has_the_reference_mass_and_moment():
    earth = prem()
    assert earth.mass == pytest.approx(float(PREM["M_kg"]), rel=1e-11)
    assert earth.mean_moment == pytest.approx(float(PREM["I_kgm2"]), rel=1e-10)
    assert earth.moment_ratio == pytest.approx(float(PREM["I_mean_MR2"]), rel=2e-12)


@pytest.mark.slow
def test_prem_has_its_published_pressure_and_gravity():
    """Dziewonski & Anderson 1981, table II: pressure to 0.1 kbar of 3638.5 at the centre, gravity 10.68 m/s2."""
    earth = prem()
    assert earth.pressure(0.0) == pytest.approx(363.85e9, rel=1e-3)
    assert earth.pressure(3480e3) == pytest.approx(135.75e9, rel=1e-3)
    assert earth.gravity(3480e3) == pytest.approx(10.6823, rel=1e-3)
    assert earth.density(np.array([0.0, 3480e3, 3480.1e3])) == pytest.approx([13088.5, 9903.49, 5566.45], rel=1e-5)
    assert len(prem_layer_names()) == len(earth.outer_radii) == 13
    assert not earth.stably_stratified  # its low-velocity zone is denser above than below


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "polynomial" else pytest.mark.full) for name in GALLERY]
)
def test_integrals_are_those_of_the_profile(name):
    body = GALLERY[name]
    surface, edges = float(body.mean_radius), [float(r) for r in body.outer_radii[:-1]]

    def integral(function, low=0.0, high=surface):
        return quad(function, low, high, points=edges, epsabs=0, epsrel=1e-12, limit=200)[0]

    mass = 4 * np.pi * integral(lambda r: float(body.density(r)) * r**2)
    assert body.mass == pytest.approx(mass, rel=1e-11)
    assert np.sum(body.layer_masses) == pytest.approx(mass, rel=1e-11)
    moment = 8 * np.pi / 3 * integral(lambda r: float(body.density(r)) * r**4)
    assert body.mean_moment == pytest.approx(moment, rel=1e-11)
    assert body.moment_ratio == pytest.approx(moment / (mass * surface**2), rel=1e-11)
    energy = integral(lambda r: -4 * np.pi * r**3 * float(body.density(r)) * float(body.gravity(r)))
    assert body.gravitational_energy == pytest.approx(energy, rel=1e-11)
    for r in (0.0, 0.2, 0.7, 1.3):
        inside = [edge for edge in edges if edge > r]
        weight = quad(lambda s: float(body.density(s) * body.gravity(s)), r, surface, points=inside, epsrel=1e-12)[0]
        assert body.pressure(r) == pytest.approx(weight, rel=1e-10)


@pytest.mark.full
@pytest.mark.parametrize("name", GALLERY)
def test_the_virial_theorem_holds(name):
    """3 times the volume integral of P is -W: pressure and energy come from different formulas."""
    body = GALLERY[name]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    total, inner = 0.0, 0.0
    for outer in np.asarray(body.outer_radii):
        r = inner + (outer - inner) * (nodes + 1) / 2
        total += (outer - inner) / 2 * weights @ (body.pressure(r) * 12 * np.pi * r**2)
        inner = outer
    assert total == pytest.approx(-float(body.gravitational_energy), rel=1e-11)


@pytest.mark.full
def test_the_homogeneous_sphere_and_its_outside():
    body = constant_layers([1.0, 3.0], [2.0, 2.0], 5.0)
    mass = 4 / 3 * np.pi * 2 * 27
    assert body.mass == pytest.approx(mass, rel=1e-15) and body.moment_ratio == pytest.approx(0.4, rel=1e-15)
    assert body.pressure(0.0) == pytest.approx(2 / 3 * np.pi * 5 * 4 * 9, rel=1e-14)
    r = np.array([0.0, 1.0, 3.0, 3.1, 6.0])
    assert body.enclosed_mass(r) == pytest.approx(mass * np.minimum(r / 3, 1) ** 3, rel=1e-14)
    assert body.gravity(r)[1:] == pytest.approx(5 * body.enclosed_mass(r)[1:] / r[1:] ** 2, rel=1e-14)
    assert body.gravity(0.0) == 0.0
    assert list(body.density(r)) == [2, 2, 2, 0, 0] and list(body.pressure(r)[2:]) == [0, 0, 0]
    assert body.stably_stratified and not constant_layers([1.0, 3.0], [2.0, 2.1]).stably_stratified


def test_a_table_is_the_linear_layers_between_its_rows():
    table = tabulated_layers([0.0, 0.4, 0.4, 2.0], [7.0, 6.0, 3.0, 1.0], 1.7)
    assert table.moment_ratio == pytest.approx(GALLERY["linear"].moment_ratio, rel=1e-15)
    assert table.gravitational_energy == pytest.approx(GALLERY["linear"].gravitational_energy, rel=1e-14)
    assert tabulated_layers([0.5, 1.0], [2.0, 2.0]).moment_ratio == pytest.approx(0.4, rel=1e-15)
    r = np.linspace(0, 1, 2001)  # a smooth profile: linear interpolation converges with the square of the spacing
    exact = polynomial_layers([1.0], [[3.0, 0.0, -2.0]]).moment_ratio
    errors = [abs(float(tabulated_layers(r[::n], 3 - 2 * r[::n] ** 2).moment_ratio - exact)) for n in (50, 25)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)


def test_results_are_64_bit_with_and_without_the_switch():
    body = GALLERY["linear"]
    assert isinstance(body.mass, np.ndarray) and body.mass.dtype == np.float64
    with jax.enable_x64(True):
        assert isinstance(body.mass, jax.Array) and body.mass.dtype == np.float64
    with pytest.raises(ValueError, match=r"within jax\.enable_x64"):
        jax.grad(lambda rho: constant_layers([0.5, 1.0], jax.numpy.stack([rho, 1.0])).moment_ratio)(2.0)


@pytest.mark.slow
def test_a_list_of_densities_may_hold_traced_numbers():
    exact = 0.4 * (1.125 / 32 - (1 + 1 / 32) / 8) / 1.125**2  # of 0.4 (1 + (rho - 1)/32)/(1 + (rho - 1)/8)
    for body in (
        lambda rho: constant_layers([0.5, 1.0], [rho, 1.0]),
        lambda rho: polynomial_layers([0.5, 1.0], [[rho], [1.0, 0.0]]),
        lambda rho: linear_layers([0.5, 1.0], [rho, 1.0], [rho, 1.0]),
    ):
        with jax.enable_x64(True):
            slope = jax.grad(lambda rho, body=body: body(rho).moment_ratio)(2.0)
        assert slope == pytest.approx(exact, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("switch", [False, True])
def test_series_of_xarray_are_arrays_to_functions_of_jax(switch):
    body, radii = GALLERY["linear"], np.array([[0.1, 0.2], [0.3, 0.9]])
    series = xr.DataArray(radii, dims=("time", "shell"))
    with jax.enable_x64(switch):
        for of_radius in (body.density, body.gravity, body.pressure, body.enclosed_mass):
            np.testing.assert_array_equal(of_radius(series), of_radius(radii))
        dense = 9000.0 * (1.0 + radii)
        of_dense = xr.DataArray(dense, dims=("time", "shell"), attrs={"units": "kg m-3"})
        np.testing.assert_array_equal(planetary.pressure(IRON_HCP, of_dense), planetary.pressure(IRON_HCP, dense))


@pytest.mark.parametrize(
    ("radii", "densities", "message"),
    [([1.0, 0.5], [1, 1], "ascend"), ([0.0], [1], "positive surface"), ([0.5, 1.0], [0.0, 1.0], "positive in every"),
     ([0.5, 1.0], [1.0], "as many radii"), ([0.5, np.nan], [1.0, 2.0], "ascend"), ([1.0], [np.inf], "positive in"),
     ([-0.5, 1.0], [1.0, 2.0], "ascend")],
)  # fmt: skip
def test_bodies_that_cannot_be_are_refused(radii, densities, message):
    with pytest.raises(ValueError, match=message):
        constant_layers(radii, densities)


def test_a_table_from_the_surface_down_is_refused_without_a_warning():
    with pytest.raises(ValueError, match="ascend from the centre"):
        tabulated_layers([1.0, 0.5, 0.0], [1.0, 2.0, 3.0])


def test_a_table_is_of_as_many_densities_as_radii_and_ends_somewhere():
    with pytest.raises(ValueError, match=r"1 and 1 densities need as many radii in one list, not \(2,\)"):
        tabulated_layers([1.0, 2.0], [1.0])
    for radii in ([1.0, np.inf], [np.inf, np.inf]):
        with pytest.raises(ValueError, match="ascend from the centre"):
            tabulated_layers(radii, [1.0, 1.0])


def test_a_density_that_falls_below_zero_inside_a_layer_is_refused():
    with pytest.raises(ValueError, match="positive in every layer"):
        polynomial_layers([1.0], [[1.0, -4.0, 3.9]])


def test_a_density_at_no_number_is_none():
    found = GALLERY["linear"].density(np.array([np.nan, 0.1, 3.0]))
    assert np.isnan(found[0]) and found[1] > 0.0 and found[2] == 0.0
