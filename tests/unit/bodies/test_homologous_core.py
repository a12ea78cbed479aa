"""Goldreich and Weber's collapse against Euler's and Poisson's equations, Lane and Emden's limit, published numbers."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from astroinertia.bodies.homologous_core import HomologousCore, critical_rate, homologous_profile
from astroinertia.bodies.polytrope import Polytrope, lane_emden

SHARES = [0.0, 0.5, 0.95, 1.0]


def test_the_critical_rate_is_the_published_one_and_its_surface_falls_freely():
    assert critical_rate() == pytest.approx(0.00654, abs=5e-6)  # Goldreich & Weber 1980, section II
    core = HomologousCore(1.0, mass=2.0, radius=3.0, gravitational_constant=0.7)
    assert core.deceleration == pytest.approx(0.7 * 2.0 / 3.0**3, rel=1e-10)
    # Without the pressure's gradient at the surface the mean density is lambda times that of the centre.
    mean = 2.0 / (4 / 3 * math.pi * 3.0**3)
    assert mean / core.central_density == pytest.approx(critical_rate(), rel=1e-10)


def test_the_critical_rate_and_its_surface_are_those_of_25_digits():
    # By Taylor series of degree 36 in steps of 1/4, with mpmath: where f and f' vanish together.
    assert critical_rate() == pytest.approx(0.0065437581239322570, rel=1e-14)
    assert homologous_profile(1.0).x_1 == pytest.approx(9.8894115041816199, rel=3e-11)


def test_the_critical_surface_is_where_an_integration_of_second_order_touches_zero():
    def slope(x, y):
        return [y[1], critical_rate() - y[0] ** 3 - 2 * y[1] / x]

    x = 1e-3
    start = [1 - (1 - critical_rate()) * x**2 / 6, -(1 - critical_rate()) * x / 3]
    end = homologous_profile(1.0).x_1
    f, df = solve_ivp(slope, (x, end), start, method="RK45", rtol=1e-10, atol=1e-13).y[:, -1]
    assert abs(f) < 1e-8 and abs(df) < 1e-8


def test_without_a_rate_it_is_the_polytrope_of_index_3():
    profile, star = homologous_profile(0.0), lane_emden(3.0)
    assert profile.x_1 == pytest.approx(star.xi_1, rel=1e-12)
    assert profile.surface_mass == pytest.approx(star.surface_mass, rel=1e-12)
    core, sphere = HomologousCore(0.0, 2.0, 3.0), Polytrope(3.0, 2.0, 3.0)
    assert core.constant == pytest.approx(sphere.constant, rel=1e-12)
    assert core.moment_of_inertia == pytest.approx(sphere.moment_of_inertia, rel=1e-12)
    assert core.internal_energy == pytest.approx(-core.gravitational_energy, rel=1e-12)


def test_the_mass_that_falls_exceeds_that_at_rest_by_a_twentieth():
    """Goldreich & Weber: cores of up to 1.0449 times the mass that the same K holds up collapse homologously."""
    masses = [1.0 / HomologousCore(share).constant ** 1.5 for share in (0.0, 1.0)]
    assert masses[1] / masses[0] == pytest.approx(1.0449, abs=1.5e-3)


@pytest.mark.parametrize("share", SHARES)
def test_its_parts_fall_in_proportion_to_their_distance(share):
    """-(1/rho) dP/dr - G m/r^2 = -k r/a^3 at any time: Euler's equation, with the mass from the density alone."""
    core = HomologousCore(share, mass=2.0, radius=3.0, gravitational_constant=0.7)
    time = 0.0 if share == 0.0 else 0.6 * core.collapse_time
    a = float(core.scale_factor(time))
    for r in np.array([0.05, 0.2, 0.4, 0.6, 0.8]) * 3.0 * a:
        h = 1e-4 * r
        push = -float(core.pressure(r + h, time) - core.pressure(r - h, time)) / (2 * h) / float(core.density(r, time))
        mass = quad(lambda s: 4 * math.pi * s**2 * float(core.density(s, time)), 0, r, epsrel=1e-10, limit=200)[0]
        assert mass == pytest.approx(float(core.enclosed_mass(r, time)), rel=1e-7)
        pull = 0.7 * mass / r**2
        assert push - pull == pytest.approx(-core.deceleration * r / a**3, abs=2e-6 * pull)


@pytest.mark.parametrize("share", SHARES)
def test_integrals_are_those_of_the_density(share):
    core = HomologousCore(share, mass=2.0, radius=3.0, gravitational_constant=0.7)

    def integral(function):
        return quad(function, 0, 3.0, epsrel=1e-11, limit=400)[0]

    assert integral(lambda r: 4 * math.pi * r**2 * float(core.density(r))) == pytest.approx(2.0, rel=1e-9)
    moment = integral(lambda r: 8 / 3 * math.pi * r**4 * float(core.density(r)))
    assert core.moment_of_inertia == pytest.approx(moment, rel=1e-9)
    weight = integral(lambda r: 4 * math.pi * r * 0.7 * float(core.enclosed_mass(r) * core.density(r)))
    assert core.gravitational_energy == pytest.approx(-weight, rel=1e-9)
    heat = integral(lambda r: 12 * math.pi * r**2 * float(core.pressure(r)))
    assert core.internal_energy == pytest.approx(heat, rel=1e-9)


@pytest.mark.parametrize("share", SHARES)
def test_the_virial_theorem_leaves_what_decelerates(share):
    core = HomologousCore(share, mass=2.0, radius=3.0, gravitational_constant=0.7)
    left = core.deceleration * 1.5 * core.moment_of_inertia
    sum_ = core.internal_energy + core.gravitational_energy
    assert sum_ == pytest.approx(-left, abs=1e-12 * core.internal_energy)


@pytest.mark.parametrize("start", ["rest", "parabolic"])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_the_size_obeys_its_equation_of_motion(start, share):
    core = HomologousCore(share, mass=2.0, radius=3.0, start=start, gravitational_constant=0.7)
    k = core.deceleration

    def slope(_, y):
        return [y[1], -k / y[0] ** 2]

    times = core.collapse_time * np.array([0.0, 0.3, 0.7, 0.95, 0.99])
    found = solve_ivp(slope, (0, times[-1]), [1.0, core.starting_rate], method="DOP853", t_eval=times, rtol=1e-12,
                      atol=1e-14)  # fmt: skip
    np.testing.assert_allclose(core.scale_factor(times), found.y[0], rtol=1e-9)
    np.testing.assert_allclose(core.expansion_rate(times), found.y[1] / found.y[0], rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(core.moment_at(times), core.moment_of_inertia * found.y[0] ** 2, rtol=1e-8)
    np.testing.assert_allclose(core.time_of(core.scale_factor(times)), times, rtol=1e-12, atol=1e-12)


def test_from_rest_the_critical_surface_takes_the_time_of_free_fall():
    core = HomologousCore(1.0, mass=2.0, radius=3.0, start="rest")
    assert core.collapse_time == pytest.approx(math.pi / 2 * math.sqrt(3.0**3 / (2 * 2.0)), rel=1e-10)


@pytest.mark.parametrize("share", SHARES)
def test_radius_enclosing_inverts_the_mass(share):
    core = HomologousCore(share, mass=2.0, radius=3.0)
    mass = np.linspace(0, 2, 501)
    np.testing.assert_allclose(core.enclosed_mass(core.radius_enclosing(mass)), mass, rtol=0, atol=1e-12)
    assert core.radius_enclosing(2.0) == 3.0 and core.radius_enclosing(0.0) == 0.0


def test_what_has_no_answer_is_refused():
    for share in (-0.1, 1.0001, math.nan):
        with pytest.raises(ValueError, match="between 0 and 1 times the critical one"):
            homologous_profile(share)
    core = HomologousCore(1.0)
    for time in (-1e-9, core.collapse_time):
        with pytest.raises(ValueError, match=r"is known from t = 0 to 0\.471405"):
            core.scale_factor(time)
    with pytest.raises(ValueError, match="needs a rate"):
        HomologousCore(0.0).time_of(0.5)
    with pytest.raises(ValueError, match="between 0 and 1"):
        core.time_of(1.1)
    assert HomologousCore(0.0).scale_factor(1e6) == 1.0


def test_a_start_of_another_name_is_refused():
    for start in ("Rest", "at rest", None):
        with pytest.raises(ValueError, match="start must be rest or parabolic, not"):
            HomologousCore(0.5, start=start)
    with pytest.raises(ValueError, match="mass must be positive and finite, not -1"):
        HomologousCore(0.5, mass=-1.0)
