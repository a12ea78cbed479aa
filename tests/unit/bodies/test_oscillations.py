"""Modes of polytropes against exact and independent values, and what a mode must be whatever its numbers."""

import json
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.oscillations import nonradial_modes, nonradial_spectrum, radial_modes
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.bodies.polytrope_elements import polytrope_elements

REFERENCE = Path(__file__).parents[2] / "reference"
RADIAL = json.loads((REFERENCE / "modes.json").read_text())
NONRADIAL = json.loads((REFERENCE / "nonradial_modes.json").read_text())


G_MODES = {
    (1, "2"): 0,
    (1, "5/3"): 0,
    (1.5, "5/3"): 0,
    (2, "3/2"): 0,
    (2, "5/3"): 1,
    (3, "5/3"): 7,
}  # among those listed


def by_label(modes):
    return {mode.label: mode.squared_frequency for mode in modes}


@pytest.mark.parametrize("entry", [each for each in RADIAL if each["name"] == "polytrope.radial_mode_omega2"])
def test_radial_reference_values(entry):
    inputs = entry["inputs"]
    mode = radial_modes(inputs["n"], float(Fraction(inputs["Gamma1"])))[inputs["mode"]]
    assert mode.label == ["F", "1O", "2O"][inputs["mode"]]
    assert mode.squared_frequency == pytest.approx(float(entry["value"]), rel=5e-12)


@pytest.mark.parametrize(
    "entry", [NONRADIAL[0], *(pytest.param(each, marks=pytest.mark.slow) for each in NONRADIAL[1:])]
)
def test_nonradial_reference_values(entry):
    inputs, wanted = entry["inputs"], [float(value) for value in entry["value"]]
    stable = G_MODES[inputs["n"], inputs["Gamma1"]]
    modes = by_label(nonradial_modes(inputs["n"], float(Fraction(inputs["Gamma1"])), 2, gravity_modes=stable))
    labels = [f"g{k}" for k in range(stable, 0, -1)] + ["f", "p1", "p2", "p3", "p4"]
    assert len(wanted) >= stable + 4
    assert [modes[label] for label in labels[: len(wanted)]] == pytest.approx(wanted, rel=1.2e-10)


@pytest.mark.slow
def test_homogeneous_sphere():
    """Pekeris 1938: omega^2 = D + sqrt(D^2 + l(l + 1)) for p, - for the (unstable) g modes; Kelvin's f mode."""
    gamma = 5 / 3
    for order, mode in enumerate(radial_modes(0, gamma, 4)):
        exact = 3 * gamma - 4 + gamma * order * (2 * order + 5)
        assert mode.squared_frequency == pytest.approx(exact, rel=1e-12)
    for degree in (2, 5):
        found = nonradial_modes(0, gamma, degree)
        modes = by_label(found)
        assert modes["f"] == pytest.approx(2 * degree * (degree - 1) / (2 * degree + 1), rel=1e-12)
        for order in range(4):
            half = -2 + gamma / 2 * (order * (2 * degree + 2 * order + 5) + 2 * degree + 3)
            root = math.hypot(half, math.sqrt(degree * (degree + 1)))
            assert modes[f"p{order + 1}"] == pytest.approx(half + root, rel=2e-12)
            assert modes[f"g{order + 1}"] == pytest.approx(half - root, rel=1e-11)
        kelvin = next(mode for mode in found if mode.label == "f")
        power = kelvin.radius ** (degree - 1)
        surface = math.sqrt(degree / 3)
        np.testing.assert_allclose(kelvin.radial, surface * power, rtol=0, atol=1e-8)
        np.testing.assert_allclose(kelvin.horizontal, surface / degree * power, rtol=0, atol=1e-8)
        field = -3 / (2 * degree + 1) * surface * power * kelvin.radius
        np.testing.assert_allclose(kelvin.potential, field, rtol=0, atol=1e-8)


@pytest.mark.parametrize("gamma", [1.4, 5 / 3, 3.0])
def test_dipole_modes_of_the_homogeneous_sphere(gamma):
    """Pekeris 1938 with l = 1, where there is no f mode."""
    modes = by_label(nonradial_modes(0, gamma, 1))
    assert list(modes) == ["g1", "g2", "g3", "g4", "p1", "p2", "p3", "p4"]
    for order in range(1, 5):
        half = -2 + gamma * order * (order + 1.5)
        root = math.hypot(half, math.sqrt(2))
        assert modes[f"p{order}"] == pytest.approx(half + root, rel=2e-12)
        assert modes[f"g{order}"] == pytest.approx(half - root, rel=1e-11)


def test_dipole_modes_leave_the_centre_of_mass_at_rest():
    """The field outside has no dipole, and no mode shifts the star."""
    modes = nonradial_modes(3.0, 5 / 3, 1, 2, 2)
    assert [mode.label for mode in modes] == ["g2", "g1", "p1", "p2"]
    for mode in modes:
        assert abs(mode.mass_weights @ (mode.radial + 2 * mode.horizontal)) < 1e-9
        assert abs(mode.potential[-1]) < 1e-7 * np.abs(mode.potential).max()


@pytest.mark.parametrize("index", [0.3, 3.0])
def test_dipole_modes_of_neutral_stars_are_sound_alone(index):
    assert [mode.label for mode in nonradial_modes(index, 1 + 1 / index, 1, pressure_modes=2)] == ["p1", "p2"]


@pytest.mark.slow
def test_modes_are_orthogonal_and_normalised():
    modes = nonradial_modes(2.7, 5 / 3, 3)
    x, weights = modes[0].radius, modes[0].mass_weights
    assert weights.sum() == pytest.approx(1, rel=1e-12)
    assert all(mode.radial[-1] > 0 and np.array_equal(mode.radius, x) for mode in modes)
    radial, horizontal = (np.array([getattr(mode, name) for mode in modes]) for name in ("radial", "horizontal"))
    products = (weights * radial) @ radial.T + 12 * (weights * horizontal) @ horizontal.T
    np.testing.assert_allclose(products, np.eye(len(modes)), rtol=0, atol=1e-9)


def test_displacement_solves_the_equations_of_motion():
    """omega^2 r xi_h = p'/rho + Phi' at every node: the pointwise equation, which the energy does not contain."""
    index, gamma = 2.0, 5 / 3
    for mode in nonradial_modes(index, gamma, 2, 2, 2):
        gravity, enthalpy = profile(index, mode.radius)
        pressure = gravity * mode.radial - gamma * enthalpy / (index + 1) * mode.divergence
        right = mode.squared_frequency * mode.radius * mode.horizontal
        np.testing.assert_allclose(pressure + mode.potential, right, rtol=0, atol=1e-7 * np.abs(right).max())


def profile(index, x):
    solution = lane_emden(index)
    xi = x * solution.xi_1
    theta, mass = solution.theta_at(xi), solution.mass_at(xi)
    total, radius = solution.surface_mass, solution.xi_1
    return mass / total / x**2, theta * radius / total


def test_radial_variational_principle():
    """omega^2 = int (Gamma1 P D^2 - 4 rho g xi^2/x) dV, from the fields that a mode hands out (Chandrasekhar 1964)."""
    index, gamma = 1.5, 1.9
    for mode in radial_modes(index, gamma):
        gravity, enthalpy = profile(index, mode.radius)
        energy = gamma * enthalpy / (index + 1) * mode.divergence**2 - 4 * gravity * mode.radial**2 / mode.radius
        assert mode.mass_weights @ energy == pytest.approx(mode.squared_frequency, rel=1e-9)


@pytest.mark.full
@pytest.mark.parametrize("degree", [0, 3])
def test_derivative_by_gamma(degree):
    """Hellmann-Feynman against a central difference."""

    def modes(gamma):
        return radial_modes(1.8, gamma) if degree == 0 else nonradial_modes(1.8, gamma, degree, 2, 2)

    step = 1e-4
    for mode, above, below in zip(modes(1.7), modes(1.7 + step), modes(1.7 - step), strict=True):
        difference = (above.squared_frequency - below.squared_frequency) / (2 * step)
        assert mode.gamma_derivative == pytest.approx(difference, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("index", [0.3, 1.5, 2.7])
def test_neutral_stratification_has_no_g_modes(index):
    labels = [mode.label for mode in nonradial_modes(index, 1 + 1 / index, 2, pressure_modes=2)]
    assert labels == ["f", "p1", "p2"]


@pytest.mark.slow
def test_the_f_mode_of_a_high_degree_is_a_wave_on_the_surface_among_those_of_the_core():
    """Waves of deep water have omega^2 = l g/R; g modes of n = 3.5 come to 34, too faint to be seen at the surface."""
    slower, surface, faster = nonradial_modes(3.5, 5 / 3, 40, pressure_modes=1, gravity_modes=1)
    assert surface.label == "f" and 40 < surface.squared_frequency < 48
    deep = surface.radius < 0.5
    assert abs(surface.radial[deep]).max() < 1e-6 * surface.radial[-1]
    assert abs(slower.radial[-1]) < 1e-3 * abs(slower.radial[deep]).max()
    assert faster.squared_frequency > 1.5 * surface.squared_frequency


@pytest.mark.slow
def test_no_mode_of_a_high_degree_is_passed_over():
    """Of n = 4 those of the core and of the surface alternate."""
    modes = nonradial_modes(4.0, 5 / 3, 60, pressure_modes=1, gravity_modes=1)
    coarse, fine = (nonradial_spectrum(polytrope_elements(4.0, count), 5 / 3, 60).values for count in (56, 80))
    known = [value for value in fine if abs(coarse / value - 1).min() < 1e-6]
    first, last = modes[0].squared_frequency, modes[-1].squared_frequency
    between = [value for value in known if 0.9999 * first < value < 1.0001 * last]
    assert between == pytest.approx([mode.squared_frequency for mode in modes], rel=1e-9)
    faster = [value for value in known if value > 1.0001 * last]
    assert faster[0] == pytest.approx(178.83, rel=1e-3)  # of two nodes above the core, and of none in it


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="0 <= n < 5"):
        radial_modes(5.0, 5 / 3)
    with pytest.raises(ValueError, match="gamma must be positive"):
        radial_modes(1.0, math.inf)
    for count in (0, 2.5, math.nan, math.inf):
        with pytest.raises(ValueError, match="whole one and at least 1"):
            radial_modes(1.0, 2.0, count)
    for degree in (0, 1.5, math.nan):
        with pytest.raises(ValueError, match="whole degree of 1 or more"):
            nonradial_modes(1.0, 2.0, degree)
    for numbers in ({"gravity_modes": -1}, {"pressure_modes": 1.5}):
        with pytest.raises(ValueError, match="whole and not negative"):
            nonradial_modes(1.0, 2.0, **numbers)
