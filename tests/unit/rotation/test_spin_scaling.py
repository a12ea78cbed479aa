"""Whole bodies that shrink: the table of collapses, and the limits that it is held to."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.rotation import spin_scaling
from astroinertia.rotation.spin_scaling import spin_up

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "spin_up.json").read_text())
COLLAPSES = [entry for entry in REFERENCE if entry["name"] == "collapse_spinup"]
CGS = {"gravitational_constant": 6.6743e-8}
PRINTED = 1e-7  # eight digits are printed


@pytest.mark.parametrize("entry", COLLAPSES, ids=lambda entry: entry["inputs"]["case"][:24])
def test_the_table_of_collapses(entry):
    value = {name: float(text) for name, text in entry["value"].items()}
    found = spin_up(*entry["inputs"]["args(k1,M1,R1,P1,k2,M2,R2)"], **CGS)
    expected = {
        "I1": found.moment_before,
        "I2": found.moment_after,
        "I_ratio": found.moment_fall,
        "P2_s": found.period,
        "P_Kepler_s": found.kepler_period,
        "P2_over_PK": found.period_over_kepler,
        "P_massshed_newton_s": found.shedding_period,
        "J": found.angular_momentum,
        "R_centrifugal_barrier_cm": found.centrifugal_radius,
    }
    assert set(expected) == set(value)
    for name, number in expected.items():
        assert float(number) == pytest.approx(value[name], rel=PRINTED), name


def test_the_claim_of_a_fall_by_1e10_ends_past_break_up():
    (claim,) = (entry for entry in REFERENCE if entry["name"].endswith("claim_1e10_30d"))
    period, fall = claim["inputs"]["P0_d"] * 86400, claim["inputs"]["I_ratio"]
    found = spin_up(0.4, 1.0, math.sqrt(fall), period, 0.4, 1.0, 1.0)
    assert float(found.period) == pytest.approx(float(claim["value"]["P_if_I_ratio_1e10_s"]), rel=1e-12)
    star = spin_up(0.4, 2e30, 12e3 * math.sqrt(fall), period, 0.4, 2e30, 12e3)
    assert star.beyond_kepler and star.sheds_mass
    assert star.centrifugal_radius > 12e3  # it cannot become so small


def test_what_shrinks_to_its_centrifugal_radius_turns_like_an_orbit():
    core = (0.1, 2.8e30, 1.5e6, 100.0)
    radius = float(spin_up(*core, 0.35, 2.5e30, 1.2e4).centrifugal_radius)
    there = spin_up(*core, 0.35, 2.5e30, radius)
    assert float(there.period_over_kepler) == pytest.approx(1.0, rel=1e-12)
    assert there.period == pytest.approx(there.kepler_period)
    assert not spin_up(*core, 0.35, 2.5e30, 1.001 * radius).beyond_kepler
    assert spin_up(*core, 0.35, 2.5e30, 0.999 * radius).beyond_kepler


def test_energy_and_lost_angular_momentum():
    whole = spin_up(0.1, 2.0, 10.0, 7.0, 0.3, 2.0, 1.0, gravitational_constant=1.0)
    half = spin_up(0.1, 2.0, 10.0, 7.0, 0.3, 1.0, 1.0, angular_momentum_share=0.5, gravitational_constant=1.0)
    assert whole.rotational_energy == pytest.approx(0.5 * 0.6 * (2 * math.pi / float(whole.period)) ** 2)
    assert half.period == pytest.approx(whole.period)  # half of L in half of the mass
    crossing = spin_scaling.radius_of_period(0.3, 2.0, whole.angular_momentum, whole.period)
    assert crossing == pytest.approx(1.0, rel=1e-14)


def test_rest_retrograde_spin_and_arrays():
    periods = np.array([math.inf, -10.0, 10.0])
    found = spin_up(0.2, 1.0, 3.0, periods, 0.2, 1.0, np.array([1.0, 1.0, 1.5]), gravitational_constant=1.0)
    assert found.period[0] == math.inf and found.angular_velocity[0] == 0 and found.centrifugal_radius[0] == 0
    assert not found.beyond_kepler[0]
    assert found.period[1] == pytest.approx(-10 / 9) and found.beyond_kepler[1]
    assert found.period[2] == pytest.approx(2.5)


@pytest.mark.parametrize(("place", "value"), [(0, 0.0), (2, -1.0), (3, 0.0), (3, math.nan), (5, math.inf), (6, 0.0)])
def test_what_is_no_body_is_refused(place, value):
    arguments = [0.1, 1.0, 10.0, 5.0, 0.3, 1.0, 1.0]
    arguments[place] = value
    with pytest.raises(ValueError, match=r"must be positive|a period is not 0"):
        spin_up(*arguments)


def test_radii_of_a_negative_mass_are_refused():
    with pytest.raises(ValueError, match="mass must not be negative, not -2e"):
        spin_scaling.centrifugal_radius(4e15, -2e30)
    with pytest.raises(ValueError, match="mass must not be negative, not -1"):
        spin_scaling.radius_of_period(0.4, -1.0, 1.0, 1.0)


def test_an_angular_momentum_in_whole_numbers():
    """R^2 = L P/(2 pi k M), L P = 1e21 beyond 64 bits."""
    radius = spin_scaling.radius_of_period(0.4, 10**12, 10**15, 10**6)
    assert radius == pytest.approx(math.sqrt(1e21 / (2 * math.pi * 0.4 * 1e12)), rel=1e-14)
