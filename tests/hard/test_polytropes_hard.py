"""Polytropes where they are hardest: n near 5, gamma near 4/3, almost neutral stratification, many modes at once."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.apsidal import core_zone, love_number
from astroinertia.bodies.composite_polytrope import composite_polytrope
from astroinertia.bodies.oscillations import nonradial_modes, radial_modes
from astroinertia.bodies.polytrope import Polytrope, lane_emden
from astroinertia.errors import NumericalError

STEEP = json.loads((Path(__file__).parents[1] / "reference" / "steep_polytropes.json").read_text())
QUANTITIES = {
    "polytrope.xi1": lambda n: lane_emden(n).xi_1,
    "polytrope.-xi1^2theta1p": lambda n: lane_emden(n).surface_mass,
    "polytrope.I_over_MR2": lambda n: lane_emden(n).moment_ratio,
    "polytrope.k2_fluid_Love": lambda n: love_number(n, 2),
    "polytrope.k8_fluid_Love": lambda n: love_number(n, 8),
}


@pytest.mark.full
@pytest.mark.parametrize("entry", STEEP, ids=lambda entry: f"{entry['name']}-{entry['inputs']['n']}")
def test_indices_near_five(entry):
    """Radii of thousands of core radii, k_8 of 1e-13: against 32-digit values (tolerance: 1e-9 is asked)."""
    assert QUANTITIES[entry["name"]](entry["inputs"]["n"]) == pytest.approx(float(entry["value"]), rel=2e-11)


@pytest.mark.parametrize("index", [4.9, 4.99, 4.999])
def test_errors_near_five_are_those_that_are_stated(index):
    """1e-14/(5 - n) of xi_1 and twice that of the moment ratio, within a factor of 2."""
    exact = {entry["name"]: float(entry["value"]) for entry in STEEP if entry["inputs"]["n"] == index}
    for name, size in (("polytrope.xi1", 1.0), ("polytrope.I_over_MR2", 2.0)):
        assert QUANTITIES[name](index) == pytest.approx(exact[name], rel=2 * size * 1e-14 / (5 - index))


def test_the_limit_of_index_five():
    """xi_1 -> 32 sqrt(3)/(pi (5 - n)) and the mass -> sqrt(3); W = -3/(5 - n) by both integrals; n = 5 is refused."""
    departure = []
    for index in (4.9, 4.99, 4.999):
        solution, zone = lane_emden(index), core_zone(index, 0.0, 2, ())
        departure.append(solution.xi_1 * math.pi * (5 - index) / (32 * math.sqrt(3)) - 1)
        scale = zone.r[-1] / zone.mass[-1] ** 2 * (5 - index) / 3
        assert zone.binding[-1] * scale == pytest.approx(1, rel=1e-10)
        assert 3 * zone.volume_work[-1] * scale == pytest.approx(1, rel=1e-10)
        assert solution.surface_mass == pytest.approx(math.sqrt(3), rel=0.1 * (5 - index))
    assert departure[0] / departure[1] == pytest.approx(departure[1] / departure[2], rel=0.25)
    assert abs(departure[2]) < 4e-4
    for action in (lane_emden, love_number, lambda index: radial_modes(index, 5 / 3)):
        with pytest.raises(ValueError, match="0 <= n < 5"):
            action(5.0)


@pytest.mark.parametrize(
    "index",
    [
        pytest.param(0.0, marks=pytest.mark.full),
        pytest.param(0.3, marks=pytest.mark.full),
        1.5,
        3.0,
        pytest.param(4.0, marks=pytest.mark.full),
        pytest.param(4.9, marks=pytest.mark.full),
    ],
)
def test_radial_fundamental_at_four_thirds(index):
    """Zero at Gamma1 = 4/3, with a uniform expansion; near it (3 Gamma1 - 4)|W|/int r^2 dm, also below: unstable."""
    mode = radial_modes(index, 4 / 3, 1)[0]
    # What cancels is of the size of the slope: a hundredth of its rounding, where that is more.
    assert abs(mode.squared_frequency) < 1e-14 + 1e-18 * mode.gamma_derivative
    expansion = mode.radial / mode.radius
    uneven = np.abs(expansion / expansion[0] - 1)
    # Round-off is even in the norm of modes: near n = 5 shells of 1e-12 of the mass have a million times more of it.
    assert np.max(uneven * np.sqrt(mode.mass_weights / mode.mass_weights.sum())) < 2e-9
    if index <= 4.0:
        assert np.max(uneven[mode.mass_weights > 1e-12]) < 2e-8
    slope = 3 * abs(Polytrope(index).gravitational_energy) / (1.5 * Polytrope(index).moment_of_inertia)
    assert mode.gamma_derivative == pytest.approx(slope, rel=1e-8)
    for step in (1e-8, -1e-8):  # the second order is slope x step over the gap to the next mode
        near = radial_modes(index, 4 / 3 + step, 1)[0].squared_frequency
        assert near == pytest.approx((3 * (4 / 3 + step) - 4) / 3 * slope, rel=1e-6 + 1e-8 * slope / 100)
    assert radial_modes(index, 1.1, 1)[0].squared_frequency < -0.1


@pytest.mark.full
@pytest.mark.parametrize(("index", "degree"), [(0.3, 2), (1.5, 3), (3.0, 2)])
def test_almost_neutral_stratification(index, degree):
    """g modes of omega^2 proportional to the stratification, to all digits, of its sign, down to 1e-8 of the f mode."""

    def share(stratification):
        gamma = (1 + 1 / index) * (1 + stratification)
        modes = {mode.label: mode.squared_frequency for mode in nonradial_modes(index, gamma, degree, 1, 3)}
        exact = gamma * index / (index + 1) - 1  # what is left of it in floating point
        return np.array([modes[f"g{k}"] for k in (1, 2, 3)]) / exact, modes["f"]

    stable, stable_f = share(1e-7)
    unstable, unstable_f = share(-1e-7)
    far, _ = share(1e-5)
    assert (stable > 0).all()
    np.testing.assert_allclose(stable, unstable, rtol=2e-6)
    np.testing.assert_allclose(far, stable, rtol=1e-4)
    assert (np.diff(stable) < 0).all()
    assert stable_f == pytest.approx(unstable_f, rel=1e-6)


@pytest.mark.full
def test_many_gravity_modes_are_evenly_spaced_in_period():
    """Tassoul 1980, ApJS 43, 469: periods 2 pi^2/(sqrt(l(l + 1)) int N dr/r) apart; a label left out would show."""
    index, gamma, degree = 3.0, 5 / 3, 2
    modes = nonradial_modes(index, gamma, degree, pressure_modes=1, gravity_modes=24)
    labels = [mode.label for mode in modes]
    assert labels == [f"g{k}" for k in range(24, 0, -1)] + ["f", "p1"]
    solution = lane_emden(index)
    depth = np.linspace(0, 1, 4001)[1:-1]
    x = 1 - depth**2  # N is singular at the surface
    gravity = solution.mass_at(x * solution.xi_1) / solution.surface_mass / x**2
    enthalpy = solution.theta_at(x * solution.xi_1) * solution.xi_1 / solution.surface_mass
    frequency = gravity * np.sqrt((index - (index + 1) / gamma) / enthalpy)
    spacing = 2 * math.pi**2 / (math.sqrt(6) * np.trapezoid(frequency / x * 2 * depth, depth))
    periods = np.array([2 * math.pi / math.sqrt(mode.squared_frequency) for mode in modes[:24]])
    steps = -np.diff(periods)
    np.testing.assert_allclose(steps, spacing, rtol=0.03)
    assert (np.diff(steps[:15]) > 0).all()  # closer and closer to it
    assert steps[0] > spacing


def test_many_overtones():
    modes = radial_modes(2.7, 5 / 3, 30)
    steps = np.diff([math.sqrt(mode.squared_frequency) for mode in modes])
    assert all(np.sum(np.diff(np.sign(mode.radial)) != 0) == order for order, mode in enumerate(modes))
    np.testing.assert_allclose(np.diff(steps[15:]), 0, atol=2e-3)


@pytest.mark.full
def test_what_does_not_converge_is_not_returned():
    with pytest.raises(NumericalError, match="do not converge"):
        radial_modes(3.0, 5 / 3, 300)
    with pytest.raises(NumericalError, match="do not converge"):
        nonradial_modes(3.0, 5 / 3, 2, gravity_modes=300)


@pytest.mark.full
def test_the_softest_bodies_join_the_homogeneous_one():
    for degree in (2, 5):
        kelvin = 2 * degree * (degree - 1) / (2 * degree + 1)
        shift = []
        for index in (1e-2, 1e-3, 1e-6):
            modes = {mode.label: mode.squared_frequency for mode in nonradial_modes(index, 5 / 3, degree, 1, 1)}
            shift.append(modes["f"] / kelvin - 1)
        assert 0 < shift[1] < 0.01
        assert shift[0] / shift[1] == pytest.approx(10, rel=0.05)
        assert shift[1] / shift[2] == pytest.approx(1000, rel=0.005)


@pytest.mark.full
def test_extreme_interfaces():
    """A core that is nearly nothing or everything leaves the other polytrope; a density inversion keeps the virial."""
    little = composite_polytrope(1.5, 3, pressure_ratio=1 - 1e-5)
    assert little.love_number() == pytest.approx(love_number(3.0), rel=1e-4)
    assert little.moment_ratio == pytest.approx(lane_emden(3.0).moment_ratio, rel=1e-4)
    much = composite_polytrope(1.5, 3, pressure_ratio=1e-9)
    assert much.moment_ratio == pytest.approx(lane_emden(1.5).moment_ratio, rel=2e-3)
    inverted = composite_polytrope(1, 1, pressure_ratio=0.5, weight_ratio=3.0)
    assert inverted.virial_energy == pytest.approx(inverted.gravitational_energy, rel=1e-13)
    assert inverted.central_to_mean < lane_emden(1.0).central_to_mean
    steep = composite_polytrope(1.5, 4.99, pressure_ratio=0.5)
    assert steep.virial_energy == pytest.approx(steep.gravitational_energy, rel=1e-10)
