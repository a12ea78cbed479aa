"""Layered bodies at their limits: no rotation; no core, no mantle, point cores; densities that rise outwards."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies.clairaut import hydrostatic_figure, love_number, radau_darwin_error, radau_variable
from astroinertia.bodies.hydrostatic import planet_from_masses
from astroinertia.bodies.inversion import two_layers
from astroinertia.bodies.layered import constant_layers, linear_layers, polynomial_layers, tabulated_layers
from astroinertia.matter.planetary import ModifiedPolytrope


def two_layer_love_number(x, core, mantle, degree):
    """k_l of two constant layers in closed form, from Radau's eta in the mantle as a quotient (two-term solution)."""
    power = 2 * degree + 1
    mean_core, mean = core, mantle + (core - mantle) * x**3
    rise = 3 * (mantle - core) / (power * mean_core)
    outside, inside = 1 + rise, -rise * x**power
    surface = 3 * mantle / (power * mean)
    return (inside + surface * (outside + inside)) / (outside - surface * (outside + inside))


def test_without_rotation_the_figure_is_exactly_the_sphere():
    body = linear_layers([0.4, 2.0], [7.0, 3.0], [6.0, 1.0])
    figure = hydrostatic_figure(body, 0.0)
    assert figure.flattening == 0 and figure.j2 == 0 and figure.dynamical_flattening == 0
    assert (figure.layer_flattenings == 0).all()
    assert figure.polar_moment == figure.equatorial_moment == figure.mean_moment
    assert figure.equatorial_radius == figure.polar_radius == 2.0
    with jax.enable_x64(True):
        slope = float(jax.grad(lambda rate: hydrostatic_figure(body, rate).flattening)(0.0))
    assert slope == 0  # flattening is even in the rate


@pytest.mark.full
@pytest.mark.parametrize("degree", [2, 5, 8])
@pytest.mark.parametrize("core", [0.0, 1e-9, 1e-3, 0.5, 1 - 1e-9, 1.0])
@pytest.mark.parametrize("density", [5.0, 0.2, 1.0])
def test_cores_that_vanish_or_fill_the_body(core, density, degree):
    """Down to no core and up to no mantle, lighter or heavier, against the closed form; gradients stay finite."""
    exact = two_layer_love_number(core, density, 1.0, degree)

    def found(parameters):
        return love_number(constant_layers(parameters[:1].repeat(2).at[1].set(1.0), parameters[1:]), degree)

    with jax.enable_x64(True):
        value, slopes = jax.tree.map(np.asarray, jax.value_and_grad(found)(jnp.array([core, density, 1.0])))
    assert value == pytest.approx(exact, rel=3e-14)
    assert np.isfinite(slopes).all()
    if core in (0.0, 1.0):
        assert exact == pytest.approx(3 / (2 * (degree - 1)), rel=1e-14)
    assert slopes[1] * density + slopes[2] == pytest.approx(0, abs=1e-13)  # only the ratio of densities matters


@pytest.mark.full
@pytest.mark.parametrize("degree", [2, 3, 8])
def test_a_point_core_takes_all_response_away_as_its_mass_grows(degree):
    """k_l -> 3 q/(2l + 1) with q the mantle's density over the mean one, as the core takes all the mass."""
    for share in (1e-2, 1e-6, 1e-12):  # of the mass that is not in the core
        radius = 1e-30
        body = constant_layers([radius, 1.0], [(1 - share) / radius**3, share])
        assert love_number(body, degree) == pytest.approx(3 * share / (2 * degree + 1 - 3 * share), rel=1e-10)
        assert body.moment_ratio == pytest.approx(0.4 * share, rel=1e-12)
    assert radau_variable(body, degree) == pytest.approx(degree + 1, rel=1e-10)
    assert body.pressure(0.5) == pytest.approx(share * float(body.mass), rel=1e-9)  # rho G M (1/0.5 - 1)


def test_radau_darwin_fails_for_a_point_core_and_says_by_how_much():
    """In the limit of a point core k_2 -> 0, for which Radau-Darwin has 2/15 and the truth is 0."""
    body = constant_layers([1e-8, 1.0], [1e24, 1e-9])
    assert radau_darwin_error(body) == pytest.approx(2 / 15, rel=1e-6)


@pytest.mark.full
@pytest.mark.parametrize("degree", [2, 8])
def test_small_dense_cores_under_a_changing_mantle(degree):
    """No exact value, but a body to which only a tiny core is added must keep its Love number."""
    mantle = [1.0, -0.99]
    alone = float(love_number(polynomial_layers([1.0], [mantle]), degree, 24))
    for radius, density in ((1e-8, 2.0), (1e-6, 50.0), (1e-4, 3.0)):
        with_core = love_number(polynomial_layers([radius, 1.0], [[density], mantle]), degree)
        assert with_core == pytest.approx(alone, rel=20 * density * radius**3 + 2e-11)


def test_a_lighter_core_raises_the_moment_ratio_and_is_reported():
    body = constant_layers([0.6, 1.0], [1e-3, 1.0])
    assert not body.stably_stratified
    assert 0.4 < body.moment_ratio < 2 / 3
    assert love_number(body) == pytest.approx(two_layer_love_number(0.6, 1e-3, 1.0, 2), rel=1e-13)
    assert love_number(body) > 1.5
    thin = constant_layers([1 - 1e-7, 1.0], [1e-12, 1.0])  # all but hollow
    assert thin.moment_ratio == pytest.approx(2 / 3, rel=1e-4)
    assert np.isfinite(love_number(thin))
    found = two_layers(float(body.mass) / (4 / 3 * math.pi), float(body.moment_ratio), mantle_density=1.0)
    assert found.core_density == pytest.approx(1e-3, rel=1e-9)


def test_an_empty_core_is_refused():
    with pytest.raises(ValueError, match="an empty one has no level surfaces"):
        constant_layers([0.5, 1.0], [0.0, 1.0])


@pytest.mark.full
def test_a_table_with_a_step_of_no_width_and_one_of_almost_none():
    radii = [0.0, 0.5, 0.5, 0.5 + 1e-13, 1.0]
    table = tabulated_layers(radii, [5.0, 5.0, 2.0, 2.0, 2.0])
    exact = constant_layers([0.5, 1.0], [5.0, 2.0])
    assert love_number(table) == pytest.approx(float(love_number(exact)), rel=1e-12)
    assert table.moment_ratio == pytest.approx(float(exact.moment_ratio), rel=1e-13)


@pytest.mark.full
@pytest.mark.parametrize("share", [1e-9, 1e-11])
def test_a_crust_of_next_to_no_mass_changes_nothing(share):
    """Cubics in r of so narrow a piece lost all digits of what it encloses."""
    rock = ModifiedPolytrope(8.0, 0.05)
    bare, crusted = planet_from_masses([3.0], [rock]), planet_from_masses([3.0, 3.0 * share], [rock, rock])
    within = np.array([0.2, 0.5, 0.9]) * float(bare.mean_radius)
    one, other = (np.asarray(planet.layered().enclosed_mass(within)) for planet in (bare, crusted))
    assert np.abs(other / one - 1.0).max() < 1e-7  # the steps through the layers lie elsewhere


@pytest.mark.full
def test_planets_with_layers_of_no_mass_and_with_iron_above_water():
    heavy, light = ModifiedPolytrope(8.0, 0.05), ModifiedPolytrope(1.0, 0.02)
    one = planet_from_masses([3.0], [heavy])
    for masses, materials in (([0.0, 3.0], [light, heavy]), ([3.0, 0.0], [heavy, light])):
        found = planet_from_masses(masses, materials)
        assert found.mean_radius == pytest.approx(float(one.mean_radius), rel=1e-12)
        assert found.mean_moment == pytest.approx(float(one.mean_moment), rel=1e-11)
    inverted = planet_from_masses([1.5, 1.5], [light, heavy]).layered()
    assert inverted.moment_ratio > 0.4 and not inverted.stably_stratified
    assert np.isfinite(love_number(inverted))
    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(lambda m: planet_from_masses(jnp.stack([m, 3.0 - m]), [heavy, light]).moment_ratio))
        slopes = [float(slope(m)) for m in (1e-12, 3.0 - 1e-12)]
    assert np.isfinite(slopes).all()
