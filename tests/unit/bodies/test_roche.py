"""Roche and Darwin ellipsoids against independent and published values, and the equilibrium they have to be in."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies import darwin, ellipsoid_gravity, jacobi, maclaurin, roche

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
