"""Planets in hydrostatic equilibrium against closed forms, an independent integration, and published radii."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.bodies.clairaut import love_number
from astroinertia.bodies.hydrostatic import planet_from_masses, planet_from_radii
from astroinertia.errors import NumericalError
from astroinertia.matter.planetary import ICE_VII, IRON_HCP, PEROVSKITE, ModifiedPolytrope, Murnaghan, density

G, EARTH_MASS, EARTH_RADIUS = 6.6743e-11, 5.9722e24, 6371e3


def sine_body(surface, wave_number, central_density):
    """M, I and W of rho = rho_c sin(kr)/(kr) out to a surface: n = 1, or Murnaghan's K' = 2 where rho_s > 0."""
    x = surface * wave_number
    mass = 4 * np.pi * central_density / wave_number**3 * (np.sin(x) - x * np.cos(x))
    moment = (3 * x**2 - 6) * np.sin(x) - (x**3 - 6 * x) * np.cos(x)
    return mass, 8 * np.pi / 3 * central_density / wave_number**5 * moment


@pytest.fixture(scope="module")
def murnaghan():
    """Murnaghan's material with K' = 2 is P = K (rho^2 - rho_0^2)/(2 rho_0^2): its planets are sines over r."""
    rho_0, modulus = 3000.0, 2e11
    wave_number = np.sqrt(4 * np.pi * G * rho_0**2 / modulus)
    radius = 1.3 / wave_number
    central = rho_0 * 1.3 / np.sin(1.3)
    return Murnaghan(rho_0, modulus, 2.0), radius, central, sine_body(radius, wave_number, central)


def test_the_exact_compressible_planet_is_met_and_fast(murnaghan):
    material, radius, central, (mass, moment) = murnaghan
    errors = []
    for steps in (1, 4):
        found = planet_from_masses([mass], [material], gravitational_constant=G, steps=steps)
        errors.append(abs(float(found.mean_moment / moment - 1)))
        assert found.mean_radius == pytest.approx(radius, rel=1e-11)
    assert found.mean_radius == pytest.approx(radius, rel=1e-14)
    assert found.density[0, 0] == pytest.approx(central, rel=1e-12)
    assert errors[1] < 1e-12 and errors[0] > 100 * errors[1]
    given_radius = planet_from_radii([radius], [material], gravitational_constant=G)
    assert given_radius.mass == pytest.approx(mass, rel=1e-14)
    assert given_radius.mean_moment == pytest.approx(moment, rel=1e-13)
    assert given_radius.gravitational_energy == pytest.approx(float(found.gravitational_energy), rel=1e-12)
    assert given_radius.central_pressure == pytest.approx(float(found.central_pressure), rel=1e-12)


@pytest.mark.full
def test_layers_of_one_material_are_one_layer(murnaghan):
    material, radius, _, (mass, moment) = murnaghan
    found = planet_from_masses([0.1 * mass, 0.0, 0.9 * mass], [material] * 3, gravitational_constant=G)
    assert found.mean_radius == pytest.approx(radius, rel=1e-13)
    assert found.mean_moment == pytest.approx(moment, rel=1e-13)
    assert found.layer_radii[0] == pytest.approx(found.layer_radii[1], rel=1e-14)


@pytest.mark.full
def test_the_profile_becomes_a_layered_body(murnaghan):
    """Cubic pieces: mass, moment, energy and pressure of the body agree with the integration, to their fourth order."""
    material, _, _, (mass, moment) = murnaghan
    found = planet_from_masses([mass], [material], gravitational_constant=G, steps=12)
    body = found.layered()
    assert body.mass == pytest.approx(mass, rel=1e-8) and body.mean_moment == pytest.approx(moment, rel=1e-8)
    assert body.gravitational_energy == pytest.approx(float(found.gravitational_energy), rel=1e-8)
    rows = np.asarray(found.radius)[0]
    assert body.pressure(rows) == pytest.approx(found.pressure[0], rel=1e-7, abs=1e3)
    assert body.enclosed_mass(rows) == pytest.approx(found.enclosed_mass[0], rel=1e-7, abs=1e-12 * mass)
    assert body.stably_stratified


def test_the_incompressible_planet_and_the_polytrope_of_index_one():
    homogeneous = planet_from_masses([7.0], [ModifiedPolytrope(3.0, 0.0)], gravitational_constant=2.0)
    radius = (7 / (4 * np.pi)) ** (1 / 3)
    assert homogeneous.mean_radius == pytest.approx(radius, rel=1e-14)
    assert homogeneous.moment_ratio == pytest.approx(0.4, rel=1e-14)
    assert homogeneous.gravitational_energy == pytest.approx(-0.6 * 2 * 49 / radius, rel=1e-14)
    assert homogeneous.central_pressure == pytest.approx(3 * 2 * 49 / (8 * np.pi * radius**4), rel=1e-13)
    # P = K rho^2, cut where its pressure is that of what lies above
    constant, central, x = 0.7, 5.0, 2.2
    wave_number = np.sqrt(2 * np.pi / constant)
    mass, moment = sine_body(x / wave_number, wave_number, central)
    outer = constant * (central * np.sin(x) / x) ** 2
    cut = planet_from_masses([mass], [ModifiedPolytrope(0.0, constant**-0.5, 0.5)], surface_pressure=outer, steps=8)
    assert cut.mean_radius == pytest.approx(x / wave_number, rel=1e-12)
    assert cut.mean_moment == pytest.approx(moment, rel=1e-11)


def test_the_pressure_inside_a_small_core():
    """Two layers, incompressible, of densities m and c: (2 pi G/3) (m^2 (1 - x^2) + 2 m (c - m) (x^2 - x^3) + c^2 x^2).

    With the steps that are taken unless others are asked for.
    """
    materials = [ModifiedPolytrope(8.0, 0.0), ModifiedPolytrope(1.0, 0.0)]
    for x in (0.3, 0.03, 0.003):
        exact = 2 * np.pi / 3 * (1 - x**2 + 14 * x**2 * (1 - x) + 64 * x**2)
        masses = 4 * np.pi / 3 * np.array([8 * x**3, 1 - x**3])
        for planet in (planet_from_masses(masses, materials), planet_from_radii([x, 1.0], materials)):
            assert planet.central_pressure == pytest.approx(exact, rel=2e-6), x
            assert planet.layer_radii == pytest.approx([x, 1.0], rel=1e-14)


@pytest.mark.full
def test_an_earth_of_iron_and_perovskite():
    """An adaptive integration of the textbook's equations in r from the same centre; and what the Earth is like."""
    earth = planet_from_masses(
        [0.325 * EARTH_MASS, 0.675 * EARTH_MASS], [IRON_HCP, PEROVSKITE], gravitational_constant=G
    )
    core = float(earth.layer_radii[0])

    def slope(r, y, material):
        rho = float(density(material, y[1]))
        return [4 * np.pi * r**2 * rho, -G * y[0] * rho / r**2]

    start, rho = 1e3, float(earth.density[0, 0])
    state = [4 / 3 * np.pi * rho * start**3, float(earth.central_pressure) - 2 / 3 * np.pi * G * rho**2 * start**2]
    for material, outer in ((IRON_HCP, core), (PEROVSKITE, float(earth.mean_radius))):
        run = solve_ivp(slope, (start, outer), state, args=(material,), method="DOP853", rtol=1e-9, atol=1.0)
        state, start = run.y[:, -1], outer
        if material is IRON_HCP:
            assert state[0] == pytest.approx(0.325 * EARTH_MASS, rel=1e-8)
    assert state[0] == pytest.approx(EARTH_MASS, rel=1e-8)
    assert abs(state[1]) < 1e-7 * float(earth.central_pressure)
    assert earth.mean_radius == pytest.approx(EARTH_RADIUS, rel=0.03)
    assert earth.moment_ratio == pytest.approx(0.3308, rel=0.01)
    assert core == pytest.approx(3480e3, rel=0.06)
    assert love_number(earth.layered()) == pytest.approx(0.933, rel=0.02)


@pytest.mark.full
@pytest.mark.parametrize(
    ("material", "scales"), [(IRON_HCP, (5.80, 2.52)), (PEROVSKITE, (10.55, 3.90)), (ICE_VII, (5.52, 4.43))]
)
def test_published_radii_of_planets_of_one_material(material, scales):
    """Seager et al. 2007, eq. 23 and table 3 (their materials differ above 1 TPa): 1 Earth mass to 3 per cent."""
    mass = 1 / scales[0]
    radius = scales[1] * 10 ** (-0.20945 + np.log10(mass) / 3 - 0.0804 * mass**0.394)
    found = planet_from_masses([EARTH_MASS], [material], gravitational_constant=G)
    assert found.mean_radius / EARTH_RADIUS == pytest.approx(radius, rel=0.03)


@pytest.mark.full
def test_a_strongly_compressed_planet_converges_as_its_resolution_error_tells():
    """Iron at zero pressure is close to where it would yield in tension: a singularity just outside the surface."""
    exact = planet_from_masses([EARTH_MASS], [IRON_HCP], gravitational_constant=G, steps=24)
    for steps, most in ((4, 1e-9), (6, 1e-12)):
        found = planet_from_masses([EARTH_MASS], [IRON_HCP], gravitational_constant=G, steps=steps)
        error = abs(float(found.moment_ratio / exact.moment_ratio - 1))
        assert error < most and 0.05 < error / float(found.resolution_error) ** 2 < 1


@pytest.mark.full
def test_gradients_by_composition_and_by_material():
    def moment_ratio(parameters):
        share, modulus, mass = parameters
        materials = [Murnaghan(8000.0, 1.5e11, 5.0), Murnaghan(3500.0, modulus, 4.2)]
        masses = jnp.stack([share * mass, (1 - share) * mass]) * EARTH_MASS
        return planet_from_masses(masses, materials, gravitational_constant=G).moment_ratio

    at = np.array([0.3, 1.6e11, 0.8])
    with jax.enable_x64(True):
        value = jax.jit(moment_ratio)
        forward = np.asarray(jax.jit(jax.jacfwd(moment_ratio))(at))
        backward = np.asarray(jax.jit(jax.grad(moment_ratio))(at))
        measured = []
        for k in range(3):
            shift = 1e-3 * at * np.eye(3)[k]
            one, two = ((float(value(at + n * shift)) - float(value(at - n * shift))) / (2 * n) for n in (1, 2))
            measured.append((4 * one - two) / 3 / shift[k])
    np.testing.assert_allclose(forward, measured, rtol=1e-6)
    np.testing.assert_allclose(backward, forward, rtol=1e-10)


def test_what_cannot_be_is_refused():
    soft = Murnaghan(3000.0, 1e11, 4.0)
    with pytest.raises(ValueError, match="as many layers"):
        planet_from_masses([1.0, 2.0], [soft])
    with pytest.raises(ValueError, match="not negative"):
        planet_from_masses([-1.0, 2.0], [soft, soft])
    with pytest.raises(ValueError, match="rises"):
        planet_from_radii([2.0, 1.0], [soft, soft])
    for steps in (0, 2.5):  # by two and a half the mass of iron below rock was 30 % too large
        with pytest.raises(ValueError, match=f"a whole number of steps, at least one, not {steps}"):
            planet_from_radii([1.0], [soft], steps=steps)
    with pytest.raises(NumericalError, match="2 steps a layer are too few"):
        planet_from_masses([10 * EARTH_MASS], [IRON_HCP], gravitational_constant=G, steps=2)
    with pytest.raises(NumericalError, match="beyond what the materials"):
        planet_from_masses([100 * EARTH_MASS], [PEROVSKITE], gravitational_constant=G)
