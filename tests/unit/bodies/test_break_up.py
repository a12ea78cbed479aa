"""Limits of rotation: orbits, mass shedding of exact figures, bars."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import root_scalar

from astroinertia.bodies import maclaurin
from astroinertia.bodies.bar_limits import DYNAMICAL, SECULAR
from astroinertia.bodies.break_up import (
    break_up,
    orbit_at_equator,
    polytropic_limit,
    polytropic_rate,
    shedding_share,
    spun_up_polytrope,
)
from astroinertia.bodies.ellipsoid_gravity import acceleration
from astroinertia.bodies.polytrope import Polytrope, lane_emden
from astroinertia.errors import NumericalError

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "spin_up.json").read_text())


def test_shares_of_the_orbital_rate():
    (limits,) = (entry for entry in REFERENCE if entry["name"] == "collapse_rotation_limits")
    assert "(2/3)^{3/2}=0.544" in limits["value"]
    assert shedding_share() == pytest.approx(0.544, abs=5e-4)
    # 1.08 and 1.045 kHz of Haensel et al. and of Lattimer & Prakash, against 1833.5 Hz of 1 Msun and 10 km.
    assert shedding_share("haensel_2009") == pytest.approx(1080 / 1833.5, rel=1e-4)
    assert shedding_share("lattimer_prakash_2004") == pytest.approx(1045 / 1833.5, rel=1e-4)
    assert shedding_share("polytrope 1") == polytropic_limit(1.0).rate
    for wrong in ("no such", "polytrope much", ""):
        with pytest.raises(ValueError, match="there is no limit of rotation"):
            shedding_share(wrong)
    with pytest.raises(ValueError, match="0 < n < 3, not 3"):
        shedding_share("polytrope 3")


def test_an_orbit_at_an_oblate_equator_lacks_what_higher_harmonics_pull():
    """Of a homogeneous spheroid J2 = e^2/5 exactly, and J4 goes as e^4: a half of e^2 leaves a fourth of the error."""
    assert orbit_at_equator(2.0, 3.0, gravitational_constant=1.0) == pytest.approx(math.sqrt(2.0 / 27.0), rel=1e-15)
    errors = []
    for squared in (0.02, 0.01):
        polar = math.sqrt(1.0 - squared)
        rate = math.sqrt(-acceleration((1.0, 1.0, polar), [1.0, 0.0, 0.0])[0])
        errors.append(
            orbit_at_equator(4 * math.pi / 3 * polar, 1.0, squared / 5, gravitational_constant=1.0) / rate - 1
        )
    assert abs(errors[1]) < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.03)


def test_flags_turn_where_they_should():
    star = Polytrope(1.0)
    kepler = 2 * math.pi
    periods = np.array([math.inf, 10 * kepler, kepler / 0.54, kepler / 0.55, 0.99 * kepler, -0.99 * kepler])
    found = break_up(1.0, 1.0, periods, star.moment_of_inertia, star.gravitational_energy, gravitational_constant=1.0)
    np.testing.assert_allclose(found.kepler_fraction, [0, 0.1, 0.54, 0.55, 1 / 0.99, 1 / 0.99])
    np.testing.assert_array_equal(found.sheds_mass, [False, False, False, True, True, True])
    np.testing.assert_array_equal(found.beyond_kepler, [False, False, False, False, True, True])
    # T/|W| of the sphere at the orbital rate: k/2 over 3/(5 - n) of G M^2/R.
    ratio = 0.5 * star.moment_of_inertia / 0.75
    np.testing.assert_allclose(found.rotational_to_gravitational, ratio * found.kepler_fraction**2, rtol=1e-12)
    np.testing.assert_array_equal(found.secularly_unstable, ratio * found.kepler_fraction**2 > SECULAR)
    assert not found.dynamically_unstable.any()
    assert np.isnan(break_up(1.0, 1.0, 10.0).rotational_to_gravitational)


def test_bars_grow_where_maclaurin_spheroids_bifurcate():
    assert maclaurin.bifurcation().rotational_to_gravitational == pytest.approx(SECULAR, abs=5e-5)
    assert maclaurin.dynamical_limit().rotational_to_gravitational == pytest.approx(DYNAMICAL, abs=5e-5)


@pytest.mark.full
def test_a_polytrope_at_a_share_of_break_up_is_one_that_was_spun_up():
    mass, radius, constant = 2.0, 3.0, 0.5
    rate = polytropic_rate(1.5, 0.8) * math.sqrt(constant * mass / radius**3)

    def spin(momentum: float) -> float:
        return spun_up_polytrope(1.5, mass, radius, momentum, constant).angular_velocity - rate

    unswollen = 0.2046 * mass * radius**2 * rate
    momentum = float(root_scalar(spin, bracket=(unswollen, 1.55 * unswollen)).root)
    star = spun_up_polytrope(1.5, mass, radius, momentum, constant)
    assert star.keplerian_fraction == pytest.approx(0.8, rel=1e-6)
    assert 0.8 * polytropic_limit(1.5).rate < polytropic_rate(1.5, 0.8) < polytropic_limit(1.5).rate
    for index in (0.0, 3.0):
        with pytest.raises(ValueError, match="0 < n < 3"):
            polytropic_rate(index, 0.5)


def test_a_polytrope_that_sheds_mass_has_its_grown_moment_times_its_rate_as_angular_momentum():
    limit = polytropic_limit(1.0)
    rest = lane_emden(1.0).moment_ratio
    assert rest * limit.moment_growth * limit.rate == pytest.approx(limit.angular_momentum, rel=1e-9)


@pytest.mark.full
def test_fastest_polytropes_against_published_figures():
    # Hachisu 1986, table of rigid polytropes (n = 1.5: T/|W| 0.0595 at axis ratio 0.615), and James 1964 for n = 1:
    # Omega^2/(4 pi G rho_c at rest) rises to its end; here only what both print is held.
    limit = polytropic_limit(1.5)
    assert limit.rotational_to_gravitational == pytest.approx(0.0595, abs=2e-4)
    assert 1.5 < limit.swelling < 1.6 and limit.moment_growth > 1.5
    # The more condensed a body is, the less angular momentum and the lower a rate it bears: the docstring's shares.
    rates = [polytropic_limit(index).rate for index in (0.5, 1.0, 1.5, 2.5)]
    np.testing.assert_allclose(rates, [0.565, 0.550, 0.529, 0.454], atol=6e-4)
    assert polytropic_limit(1.0).angular_momentum > limit.angular_momentum
    assert (
        polytropic_limit(0.5).rotational_to_gravitational > SECULAR > polytropic_limit(1.0).rotational_to_gravitational
    )


@pytest.mark.full
def test_a_spun_up_polytrope_swells_and_turns_more_slowly_than_its_sphere():
    mass, radius, momentum = 2.0, 3.0, 0.1 * math.sqrt(6.0 * 2.0**3 * 3.0)
    star = spun_up_polytrope(1.0, mass, radius, momentum, gravitational_constant=6.0)
    assert star.mass == mass and star.angular_momentum == pytest.approx(momentum, rel=1e-10)
    sphere = Polytrope(1.0, mass, radius, 6.0)
    assert star.equatorial_radius > radius > star.polar_radius
    assert star.angular_velocity < momentum / sphere.moment_of_inertia
    assert star.max_pressure / star.max_density**2 == pytest.approx(sphere.constant, rel=1e-6)  # the same K
    slow = spun_up_polytrope(1.0, mass, radius, 1e-3 * momentum, gravitational_constant=6.0)
    assert slow.angular_velocity == pytest.approx(1e-3 * momentum / sphere.moment_of_inertia, rel=1e-5)
    with pytest.raises(NumericalError, match="sheds mass at"):
        spun_up_polytrope(1.0, mass, radius, 3 * momentum, gravitational_constant=6.0)
    for index in (0.0, 3.0):
        with pytest.raises(ValueError, match="0 < n < 3"):
            spun_up_polytrope(index, mass, radius, momentum)


def test_an_orbit_at_an_equator_in_whole_metres():
    """n^2 = G M/a^3: a^3 of the Earth is 2.6e20 m3, beyond 64 bits."""
    expected = math.sqrt(6.6743e-11 * 5.972e24 / float(6378000**3))
    assert orbit_at_equator(5.972e24, 6378000, gravitational_constant=6.6743e-11) == pytest.approx(expected, rel=1e-14)
