"""Growth by viscosity and by gravitational radiation, against closed forms, published limits and Roche's limit."""

import math

import numpy as np
import pytest

from astroinertia.bodies import jacobi, maclaurin, riemann, roche
from astroinertia.bodies.ellipsoid_gravity import index_integral
from astroinertia.bodies.ellipsoid_secular import (
    bar_rates,
    radiative_modes,
    secular_growth_rate,
    secular_onset,
    viscous_modes,
)
from astroinertia.errors import NumericalError

SCALE = {"mass": 2.0, "mean_radius": 3.0, "gravitational_constant": 0.5}
FORK = 0.812670010611743


@pytest.mark.slow
def test_bifurcation_is_found_from_both_growth_rates():
    """To Jacobi's sequence by viscosity, to Dedekind's by radiation."""
    for friction in ({"kinematic_viscosity": 1.0}, {"speed_of_light": 1.0}):
        assert secular_onset(maclaurin.from_eccentricity, 0.7, 0.94, **friction) == pytest.approx(FORK, abs=3e-15)


@pytest.mark.full
@pytest.mark.parametrize("ratio", [0.0, 0.01, 1.0, 100.0])
def test_roche_limit_is_where_viscosity_makes_circulation_run_away(ratio):
    limit = roche.limit(ratio)
    share = secular_onset(
        lambda c: roche.from_axis_ratio(ratio, c), limit.c_over_a - 0.003, 0.58, kinematic_viscosity=1.0
    )
    assert share == pytest.approx(limit.c_over_a, abs=3e-15)
    if ratio == 0:
        assert roche.from_axis_ratio(ratio, share).scaled_distance == pytest.approx(2.45517564476, abs=1e-11)


@pytest.mark.parametrize("e", [0.3, 0.8, 0.83, 0.93, 0.952])
def test_bars_of_maclaurin_spheroids(e):
    """Omega +- s grow by +-(5 nu/a^2)(Omega -+ s)/s and -+(2 G M a^2/(25 c^5))(Omega +- s)^5/s, s^2 = 4 B_11 - Omega^2.

    Roberts & Stewartson 1963; Chandrasekhar 1970, ApJ 161, 561.
    """
    body = maclaurin.from_eccentricity(e, **SCALE)
    forward, backward = body.bar_mode_frequencies
    rate, root = body.angular_velocity, abs(forward - backward) / 2
    viscous, radiative = viscous_modes(body, 1e-3), radiative_modes(body, 7.0)
    radius = body.equatorial_radius
    pull = 2 / 25 * body.gravitational_constant * body.mass * radius**2 / 7.0**5
    for sign in (1, -1):
        frequency = rate + sign * root
        k = np.argmin(abs(viscous.rates + 1j * frequency))
        assert viscous.rates[k] == pytest.approx(-1j * frequency, abs=1e-13)
        assert viscous.changes[k].real == pytest.approx(5e-3 / radius**2 * (sign * rate / root - 1), rel=1e-11)
        assert radiative.changes[k].real == pytest.approx(-sign * pull * frequency**5 / root, rel=1e-10)


def test_bars_with_friction_that_is_not_small():
    """The roots of the equation in closed form, to first order those of small friction, and smooth where bars meet."""
    for body in (maclaurin.from_eccentricity(0.9, **SCALE), maclaurin.dynamical_limit().rescaled(**SCALE)):
        unit = math.pi * body.gravitational_constant * body.density
        squares = (1.0, 1.0, body.c_over_a**2)
        bound = unit * (4 * float(index_integral(squares, (0, 1), 1)) - 2 * body.omega2)
        rate, radius = body.angular_velocity, body.equatorial_radius
        for viscosity, speed in ((0.1, math.inf), (0.0, 1.2), (0.05, 1.0), (0.0, math.inf)):
            shear = 10 * viscosity / radius**2
            waves = 4 / 25 * body.gravitational_constant * body.mass * radius**2 / speed**5
            fast, slow = bar_rates(body, viscosity, speed)
            for each in (fast, slow):
                left = each**2 + 2j * rate * each + bound + shear * (each + 2j * rate) + waves * each**5
                assert abs(left) < 1e-13 * unit
            assert abs(fast) >= abs(slow)
    body = maclaurin.from_eccentricity(0.9)
    fast, slow = bar_rates(body, 1e-6, 30.0)
    first = viscous_modes(body, 1e-6).changes + radiative_modes(body, 30.0).changes
    assert sorted([fast.real, slow.real]) == pytest.approx(sorted(first[-2:].real), rel=1e-4)
    assert max(each.real for each in bar_rates(maclaurin.bifurcation(), 0.3)) == pytest.approx(0, abs=1e-15)
    with pytest.raises(NumericalError, match="so much radiation"):
        bar_rates(body, 0.0, 0.3)


def test_sphere_decays_as_lamb_says():
    """nu (l - 1)(2 l + 1)/R^2 = 5 nu/R^2 (Lamb 1932, section 355), for all five modes."""
    body = maclaurin.from_eccentricity(0.0, **SCALE)
    np.testing.assert_allclose(viscous_modes(body, 0.01).changes.real, -0.05 / 9, rtol=1e-6)
    decay = radiative_modes(body, 5.0).changes.real
    # power of an oscillating quadrupole: (2/25) (G M R^2/c^5) sigma^4 (Chandrasekhar 1970)
    sigma2 = 16 / 15 * math.pi * body.gravitational_constant * body.density
    np.testing.assert_allclose(decay, -2 / 25 * 0.5 * 2.0 * 9.0 / 5.0**5 * sigma2**2, rtol=1e-6)


def test_viscosity_and_radiation_save_a_spheroid_from_each_other():
    """Lindblom & Detweiler 1977: each drives the bar that the other damps, and where neither prevails it is stable."""
    body, speed = maclaurin.from_eccentricity(0.9), 10.0
    assert secular_growth_rate(body, 1e-11) > 0 and secular_growth_rate(body, 0.0, speed) > 0
    growth = [secular_growth_rate(body, viscosity, speed) for viscosity in (1e-11, 1e-8, 1e-4)]
    assert growth[0] > 0 > growth[1] and growth[2] > 0
    saved = secular_onset(maclaurin.from_eccentricity, 0.82, 0.95, 1e-8, speed)
    assert 0.9 < saved < 0.95


def test_jacobi_and_dedekind_ellipsoids_are_secularly_stable():
    for ratio in (0.999, 0.6, 0.2):
        slow = viscous_modes(jacobi.from_axis_ratio(ratio), 1.0)
        assert slow.changes.real.max() < 0
        # Weak friction on the mode of no frequency vanishes at the fork like the square of the distance to it.
        assert slow.rates[-1] == 0
        assert radiative_modes(riemann.dedekind(ratio), 3.0).changes.real.max() < 0
    near = [viscous_modes(jacobi.from_axis_ratio(1 - step), 1.0).changes[-1].real for step in (1e-3, 2e-3)]
    assert near[1] / near[0] == pytest.approx(4.0, rel=5e-3)


def test_what_has_no_secular_modes_is_refused():
    for call, reason in (
        (lambda: viscous_modes(riemann.dedekind(0.5), 1.0), "internal motion"),
        (lambda: viscous_modes(jacobi.from_axis_ratio(0.5), -1.0), "not negative"),
        (lambda: viscous_modes(roche.from_axis_ratio(-1.0, 0.8), 1.0), "does not turn"),
        (lambda: radiative_modes(jacobi.from_axis_ratio(0.5), 1.0), "sends out waves"),
        (lambda: bar_rates(jacobi.from_axis_ratio(0.5)), "of a spheroid"),  # type: ignore[arg-type]
        (lambda: radiative_modes(maclaurin.from_eccentricity(0.5), 0.0), "speed of light"),
        (lambda: secular_growth_rate(maclaurin.from_eccentricity(0.5)), "needs friction"),
    ):
        with pytest.raises(ValueError, match=reason):
            call()
