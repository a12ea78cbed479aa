"""Roche and Darwin ellipsoids against independent and published values, and the equilibrium they have to be in."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies import darwin, ellipsoid_gravity, jacobi, maclaurin, roche, roche_riemann

ENTRIES = json.loads((Path(__file__).parents[2] / "reference" / "ellipsoids.json").read_text())
LIMITS = [entry for entry in ENTRIES if entry["name"] == "roche_ellipsoid_limit"]


@pytest.mark.parametrize("entry", LIMITS, ids=lambda entry: f"p={entry['inputs']['p=M/Mprime']}")
def test_limits(entry):
    body, value = roche.limit(entry["inputs"]["p=M/Mprime"]), entry["value"]
    assert body.tide == pytest.approx(float(value["mu_over_piGrho"]), rel=1e-12)
    assert body.omega2 == pytest.approx(float(value["Omega2_piGrho"]), rel=1e-12)
    assert body.b_over_a == pytest.approx(float(value["b_over_a"]), abs=5.1e-11)  # ten decimals are given
    assert body.c_over_a == pytest.approx(float(value["c_over_a"]), abs=5.1e-11)
    assert body.scaled_distance == pytest.approx(float(value["d_over_Rm_times_cbrt_mass_ratio"]), rel=2e-12)


def test_published_limit_of_jeans():
    """Jeans's spheroid: tide 0.125536 at eccentricity 0.88303 (Chandrasekhar 1969, ch. 8)."""
    body = roche.limit(-1)
    assert body.tide == pytest.approx(0.125536, abs=5e-7)
    assert body.eccentricity == pytest.approx(0.88303, abs=5e-6)
    assert body.b_over_a == body.c_over_a and body.omega2 == 0


@pytest.mark.parametrize("mass_ratio", [-1.0, -0.3, 0.0, 1.0, 37.0, 1e6])
@pytest.mark.parametrize("c_over_a", [0.95, 0.55, 0.1])
def test_surface_is_level_with_the_tide(mass_ratio, c_over_a):
    body = roche.from_axis_ratio(mass_ratio, c_over_a)
    unit = math.pi * body.density
    squares = np.array([1.0, body.b_over_a**2, body.c_over_a**2])
    gravity = 2 * ellipsoid_gravity.index_symbols(body.axes)
    centrifugal = body.omega2 * np.array([1, 1, 0]) + body.tide * np.array([2, -1, -1])
    balance = (gravity - centrifugal) * squares
    np.testing.assert_allclose(balance, balance[2], rtol=2e-14)
    assert body.angular_velocity**2 == pytest.approx((1 + mass_ratio) * body.tide * unit, rel=1e-13)


def test_between_no_rotation_and_none_of_its_mass_only_the_tide_is_known():
    """p = Omega^2/mu - 1 there, and no ratio of masses: a limit between those of p = -1 and 0, and no distance."""
    slow = roche.limit(-0.5)
    assert roche.limit(-1).scaled_distance < slow.scaled_distance < roche.limit(0).scaled_distance
    assert slow.omega2 == pytest.approx(0.5 * slow.tide, rel=1e-14)
    assert math.isnan(slow.distance)
    with pytest.raises(ValueError, match=r"at least 0, or from -1 \(no rotation\) to 0 .* not -1.5"):
        roche.limit(-1.5)


def test_distance_in_the_users_units():
    body = roche.at_distance(0.5, 4.0, mass=2.0, mean_radius=3.0, gravitational_constant=0.5)
    assert body.scaled_distance == pytest.approx(4.0, rel=1e-14)
    assert body.distance == pytest.approx(4.0 * 3.0 / 0.5 ** (1 / 3), rel=1e-14)
    assert body.angular_velocity**2 == pytest.approx(0.5 * (2.0 + 4.0) / body.distance**3, rel=1e-13)
    other = roche.at_distance(0.5, 4.0, "unstable")
    assert other.scaled_distance == pytest.approx(4.0, rel=1e-13)
    assert other.c_over_a < roche.limit(0.5).c_over_a < body.c_over_a


def test_far_from_its_companion_it_is_linear_response():
    """A satellite: a - c = 2 h_2 (mu R^3/G M) R and b - c a quarter of it, with h_2 = 5/2 of a homogeneous body."""
    body = roche.at_distance(0.0, 200.0)
    strength = 1 / 200.0**3  # G M'/d^3 over G M/R^3
    assert 1 - body.c_over_a == pytest.approx(5 * strength, rel=1e-5)
    assert body.b_over_a - body.c_over_a == pytest.approx(1.25 * strength, rel=1e-5)


def test_the_limit_is_the_closest_of_the_sequence():
    figures = [roche.from_axis_ratio(3.0, c) for c in np.linspace(0.98, 0.2, 40)]
    assert all(each.mass_ratio == 3.0 for each in figures)
    assert min(each.scaled_distance for each in figures) == pytest.approx(roche.limit(3.0).scaled_distance, rel=1e-3)
    assert min(each.scaled_distance for each in figures) > roche.limit(3.0).scaled_distance


def test_a_companion_without_mass_leaves_the_free_sequences():
    assert roche.from_axis_ratio(math.inf, 0.8).omega2 == pytest.approx(
        maclaurin.from_axis_ratio(0.8).omega2, rel=1e-14
    )
    body = roche.from_axis_ratio(math.inf, 0.4)
    assert body.omega2 == pytest.approx(jacobi.from_axis_ratio(body.b_over_a).omega2, rel=1e-14)
    assert body.c_over_a == 0.4 and body.b_over_a < 1
    assert roche.limit(math.inf).omega2 == pytest.approx(maclaurin.bifurcation().omega2, rel=1e-14)


def test_darwin_ellipsoids_are_in_equilibrium():
    body = darwin.from_gap(1.2, mass=2.0, mean_radius=3.0, gravitational_constant=0.5)
    mu = 0.5 * 2.0 / body.distance**3
    gravity = 2 * math.pi * 0.5 * body.density * ellipsoid_gravity.index_symbols(body.axes)
    outward = body.angular_velocity**2 * np.array([1, 1, 0]) + mu * np.array([2, -1, -1])
    balance = (gravity - outward) * body.axes**2
    np.testing.assert_allclose(balance, balance[2], rtol=1e-13)
    quadrupole = (2 * body.axes[0] ** 2 - body.axes[1] ** 2 - body.axes[2] ** 2) / 5
    assert body.angular_velocity**2 == pytest.approx(2 * mu * (1 + 3 * quadrupole / body.distance**2), rel=1e-14)
    assert darwin.contact().distance == pytest.approx(2 * darwin.contact().equatorial_radius, rel=1e-15)


@pytest.mark.parametrize("gap", [3.0, 1.3, 1.0, 0.9])
def test_energy_follows_angular_momentum(gap):
    """dE = Omega dJ along a sequence of rigid rotators: it fails if any term of the interaction is left out."""
    ahead, behind = darwin.from_gap(gap + 1e-4), darwin.from_gap(gap - 1e-4)
    momentum = ahead.orbital_angular_momentum - behind.orbital_angular_momentum
    work = (ahead.orbital_energy - behind.orbital_energy) / momentum
    assert work == pytest.approx(darwin.from_gap(gap).angular_velocity, rel=1e-6)


def test_turning_points_of_the_darwin_sequence():
    limit, closest = darwin.secular_limit(), darwin.closest()
    for body, quantity in (
        (limit, "orbital_energy"),
        (limit, "orbital_angular_momentum"),
        (closest, "scaled_distance"),
    ):
        least = getattr(body, quantity)
        for factor in (0.999, 1.001):
            assert getattr(darwin.from_gap(body.gap * factor), quantity) > least
    assert limit.scaled_distance > darwin.contact().scaled_distance > closest.scaled_distance


def test_darwin_is_roche_far_away():
    body = darwin.from_gap(50.0)
    point = roche.at_distance(1.0, body.scaled_distance)
    assert (1 - body.b_over_a) == pytest.approx(1 - point.b_over_a, rel=1e-5)


@pytest.mark.parametrize(
    "call",
    [
        lambda: roche.limit(-1.5),
        lambda: roche.limit(math.nan),
        lambda: roche.from_axis_ratio(1.0, 0.0),
        lambda: roche.at_distance(0.0, 2.4),
        lambda: roche.at_distance(0.0, 3.0, "middle"),
        lambda: roche.at_distance(math.inf, 3.0),
        lambda: darwin.from_gap(0.5),
        lambda: darwin.from_gap(math.inf),
    ],
)
def test_what_does_not_exist_is_refused(call):
    with pytest.raises(ValueError, match=r".{30,}"):
        call()


@pytest.mark.parametrize("mass_ratio", [0.0, 1.0, 37.0, 1e4])
def test_a_roche_riemann_ellipsoid_without_flow_is_roches(mass_ratio):
    for c_over_a in (0.3, 0.6, 0.95):
        found, known = (kind.from_axis_ratio(mass_ratio, *more, c_over_a) for kind, more in
                        ((roche_riemann, (0.0,)), (roche, ())))  # fmt: skip
        assert found.b_over_a == pytest.approx(known.b_over_a, rel=1e-13)
        assert found.tide == pytest.approx(known.tide, rel=1e-13)
    limit = roche_riemann.limit(mass_ratio, 0.0, mass=2.0, mean_radius=3.0, gravitational_constant=0.5)
    known = roche.limit(mass_ratio, mass=2.0, mean_radius=3.0, gravitational_constant=0.5)
    assert limit.tide == pytest.approx(known.tide, rel=1e-13) and limit.c_over_a == pytest.approx(known.c_over_a)
    assert limit.angular_velocity == pytest.approx(known.angular_velocity, rel=1e-13)


@pytest.mark.parametrize("vorticity", [-4.0, -2.0, -0.7, 1.0])
@pytest.mark.parametrize("mass_ratio", [0.0, 2.0, 100.0])
def test_the_flow_of_a_roche_riemann_ellipsoid_is_steady(mass_ratio, vorticity):
    """Dirichlet's equation of x = F X, F = R(Omega t) diag(a, b, c) S(lambda t)^T, in space: pressure is what is left.

    F'' F^-1 + gravity - tide is P (F F^T)^-1. Lambda turns matter within the figure, at -f Omega a b/(a^2 + b^2).
    """
    body = roche_riemann.from_axis_ratio(mass_ratio, vorticity, 0.7)
    unit = math.pi * body.density
    a, b, _ = axes = body.axes
    orbit = math.sqrt(body.omega2 * unit)
    inside = -vorticity * orbit * a * b / (a**2 + b**2)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    shape = np.diag(axes)
    second = orbit**2 * turn @ turn @ shape - 2 * orbit * inside * turn @ shape @ turn + inside**2 * shape @ turn @ turn
    gravity = 2 * unit * np.diag(ellipsoid_gravity.index_symbols(axes))
    tide = body.tide * unit * np.diag([2.0, -1.0, -1.0])
    pressure = (second @ np.linalg.inv(shape) + gravity - tide) @ shape @ shape
    np.testing.assert_allclose(pressure, np.eye(3) * pressure[2, 2], atol=1e-13 * pressure[2, 2])
    # The vorticity in the axes of the figure, of u = R^T F' F^-1 R less the turn of the figure.
    flow = -inside * shape @ turn @ np.linalg.inv(shape)
    assert flow[1, 0] - flow[0, 1] == pytest.approx(vorticity * orbit, rel=1e-13)


def test_without_vorticity_a_far_companion_only_pulls():
    """Linear response to 2, -1, -1 as of Jeans's spheroid, whatever the mass ratio: a - c = (15/4) mu R^3/(G M) R."""
    for mass_ratio in (0.0, 5.0):
        body = roche_riemann.from_axis_ratio(mass_ratio, -2.0, 1 - 1e-5)
        strength = 0.75 * body.tide  # G M'/d^3 over G M/R^3
        assert 1 - body.c_over_a == pytest.approx(3.75 * strength, rel=1e-4)
        assert body.b_over_a == pytest.approx(body.c_over_a, abs=1e-8)


def test_the_roche_riemann_limit_is_the_closest_of_its_sequence():
    for vorticity in (-3.0, -2.0, 0.5):
        closest = roche_riemann.limit(0.5, vorticity)
        around = [roche_riemann.from_axis_ratio(0.5, vorticity, closest.c_over_a + by) for by in (-1e-3, 1e-3)]
        others = [roche_riemann.from_axis_ratio(0.5, vorticity, c) for c in np.linspace(0.25, 0.99, 12)]
        assert all(other.distance > closest.distance for other in others + around)
        assert max(each.distance for each in around) == pytest.approx(closest.distance, rel=1e-5)
    assert roche_riemann.limit(0.5, -2).vorticity_ratio == -2.0
    for given in ((-1.0, 0.0, 0.7), (math.inf, 0.0, 0.7), (1.0, -4.5, 0.7), (1.0, 0.0, 1.0), (1.0, 0.0, 0.1)):
        with pytest.raises(ValueError, match="Roche-Riemann ellipsoid"):
            roche_riemann.from_axis_ratio(*given)
