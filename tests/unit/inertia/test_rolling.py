"""Rolling and flywheels against energy, the equation of motion and well-known numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

from astroinertia.inertia import rolling, shapes
from tests.scripts import run_sim

BODIES = {  # k = I/(m R^2), and the shape, of radius 0.3 and mass 2
    "hoop": (1.0, lambda m, r: shapes.hoop(m, r)),
    "spherical shell": (2 / 3, lambda m, r: shapes.spherical_shell(m, r)),
    "cylinder": (1 / 2, lambda m, r: shapes.cylinder(m, r, 3 * r)),
    "sphere": (2 / 5, lambda m, r: shapes.solid_sphere(m, r)),
}


@pytest.mark.parametrize("name", BODIES)
def test_coefficients_and_that_neither_mass_nor_size_matter(name):
    expected, shape = BODIES[name]
    mass, radius = np.array([1e-3, 2.0, 1e6]), np.array([10.0, 0.3, 1e-4])
    np.testing.assert_allclose(rolling.rolling_coefficient(shape(mass, radius), radius), expected, rtol=1e-14)


def test_a_spool_on_its_hub_rolls_with_more_than_a_hoop():
    spool = shapes.cylinder(1.0, 1.0, 0.1)
    np.testing.assert_allclose(rolling.rolling_coefficient(spool, 0.1), 50.0, rtol=1e-14)


@given(st.floats(0.0, 3.0), st.floats(0.05, 1.5), st.floats(0.1, 100.0))
def test_energy_and_the_equation_of_motion(coefficient, incline, distance):
    time = rolling.rolling_time(coefficient, distance, incline, 3.7)
    (finish,) = rolling.rolling_race({"body": coefficient}, distance, incline, 3.7)
    assert finish.time == time
    np.testing.assert_allclose((1 + coefficient) * finish.speed**2 / 2, 3.7 * distance * np.sin(incline), rtol=1e-13)
    # Newton's equation with the friction that just holds, and Euler's for the spin it makes, while it rolls.
    friction = rolling.least_friction(coefficient, incline) * 3.7 * np.cos(incline)
    acceleration = 3.7 * np.sin(incline) - friction
    np.testing.assert_allclose(friction, coefficient * acceleration, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(acceleration, rolling.rolling_acceleration(coefficient, incline, 3.7), rtol=1e-12)


def test_the_race_is_what_an_integrated_motion_says():
    coefficients = {name: k for name, (k, _) in BODIES.items()}
    found = rolling.rolling_race(coefficients, 2.0, np.radians(10))
    assert [finish.name for finish in found] == ["sphere", "cylinder", "spherical shell", "hoop"]
    for finish in found:
        body = BODIES[finish.name][1](2.0, 0.3)
        torque = np.sin(np.radians(10)) * 2.0 * 9.80665 * 0.3  # of the weight, about the line of contact
        angular = torque / body.moment([0, 0, 1], [0.3, 0, 0])
        end = solve_ivp(lambda t, y, a=angular: [y[1], 0.3 * a], (0, finish.time), [0.0, 0.0], rtol=1e-12).y[:, -1]
        np.testing.assert_allclose(end, [2.0, finish.speed], rtol=1e-12)


def test_slope_of_the_time_by_the_coefficient():
    with jax.enable_x64(True):
        slope = float(jax.grad(lambda k: rolling.rolling_time(k, 2.0, 0.2))(jnp.asarray(0.5)))
    np.testing.assert_allclose(slope, rolling.rolling_time(0.5, 2.0, 0.2) / (2 * 1.5), rtol=1e-13)


def test_the_flywheel_of_the_textbooks():
    rate = 10_000 * 2 * np.pi / 60
    joules = rolling.flywheel_energy(shapes.disc(100.0, 0.5), rate)  # 1 m in diameter
    assert joules / 3.6e6 == pytest.approx(1.904, abs=5e-4)
    # Such a disc of steel stands it only if it is of a strong kind: its rim moves at 524 m/s.
    stress = rolling.spinning_disc_stress(7850.0, 0.5, rate)
    assert 250e6 < stress < 1000e6
    assert stress == pytest.approx(3.3 / 8 * 7850 * 523.5988**2, rel=1e-6)


def test_no_disc_stores_more_than_its_material_holds():
    strength, density, radius = 900e6, 7850.0, np.array([0.01, 0.5, 20.0])
    rate = rolling.bursting_rate(strength, density, radius)
    np.testing.assert_allclose(rolling.spinning_disc_stress(density, radius, rate), strength, rtol=1e-14)
    energy = rolling.flywheel_energy(shapes.disc(3.0, radius), rate) / 3.0
    np.testing.assert_allclose(energy, 2 * strength / (3.3 * density), rtol=1e-14)


def test_the_stress_balances_the_disc():
    # d(r s_r)/dr - s_t + rho w^2 r^2 = 0 with s_r from Timoshenko & Goodier; s_r is 0 at the rim.
    density, radius, rate, nu = 3.0, 2.0, 0.7, 0.25
    factor = density * rate**2 / 8
    radial = np.polynomial.Polynomial([factor * (3 + nu) * radius**2, 0, -factor * (3 + nu)])
    hoop = np.polynomial.Polynomial([factor * (3 + nu) * radius**2, 0, -factor * (1 + 3 * nu)])
    r = np.polynomial.Polynomial([0, 1])
    residual = (r * radial).deriv() - hoop + density * rate**2 * r**2
    np.testing.assert_allclose(residual.coef, 0.0, atol=1e-14)
    assert radial(radius) == pytest.approx(0, abs=1e-14)
    assert rolling.spinning_disc_stress(density, radius, rate, nu) == pytest.approx(radial(0), rel=1e-14)


@pytest.mark.parametrize("load", [None, 3.0])
def test_a_flywheel_stores_the_work_that_the_load_does_not_take(load):
    angles = np.linspace(0.0, 4 * np.pi, 4001)
    torque = 3.0 + 40.0 * np.sin(angles) + 10.0 * np.cos(3 * angles)
    rates = rolling.flywheel_rates(torque, angles, 0.7, 30.0, load)
    work = 40.0 * (1 - np.cos(angles)) + 10.0 / 3 * np.sin(3 * angles)
    np.testing.assert_allclose(0.35 * (rates**2 - 900.0), work, atol=5e-4)
    assert rates[-1] == pytest.approx(30.0, rel=1e-12)


def test_a_flywheel_that_the_load_stops_stays_stopped():
    angles = np.linspace(0.0, 6.0, 61)
    rates = rolling.flywheel_rates(np.where(angles < 4, 0.0, 50.0), angles, 1.0, 3.0, load=2.0)
    stop = np.flatnonzero(np.isnan(rates))[0]
    assert angles[stop] == pytest.approx(9.0 / 4, abs=0.1) and np.isnan(rates[stop:]).all()


def test_the_script_of_the_race(tmp_path):
    printed = run_sim("rolling_race.py", "--incline", "30", "--output", tmp_path / "race.png")
    places = [line.split("  ")[0:3] for line in printed.splitlines()[1:9]]
    assert [" ".join(place).split(None, 1)[1].strip() for place in places] == [
        "block on ice", "solid ball", "capsule", "solid cylinder", "thin ball", "thick tube", "hoop",
        "spool on its hub",
    ]  # fmt: skip
    assert (tmp_path / "race.png").stat().st_size > 20_000
    assert "--incline" in run_sim("rolling_race.py", "--help")
    assert "between 0 and 90 degrees" in run_sim("rolling_race.py", "--incline", "90", code=2)


@pytest.mark.parametrize("incline", [0.0, -0.3, 2.0, np.nan])
def test_inclines_that_lead_nowhere_are_refused_by_name(incline):
    with pytest.raises(ValueError, match="incline must be above 0"):
        rolling.rolling_race({"ball": 0.4, "hoop": 1.0}, 2.0, incline)
    with pytest.raises(ValueError, match="distance must not be negative"):
        rolling.rolling_time(0.4, -2.0, 0.3)
