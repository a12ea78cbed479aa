"""Histories of spin: pulsars, contracting bodies, discs of clouds."""

import math

import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.rotation import pulsars
from astroinertia.studies.spin_histories import cloud_to_disc, contraction_history, pulsar_history

YEAR = 365.25 * 86400


def test_a_pulsar_of_one_index_and_of_two_torques():
    one = pulsar_history(braking_index=2.51)
    times = one["time"].values
    np.testing.assert_allclose(
        one["period"], pulsars.period_history(times, 0.0333924123, 4.20972e-13, 2.51), rtol=1e-12
    )
    np.testing.assert_allclose(one["braking_index"], 2.51, rtol=1e-12)
    lost = -np.gradient(one["rotational_energy"].values, times, edge_order=2)[60:-1]
    np.testing.assert_allclose(one["spin_down_luminosity"].values[60:-1], lost, rtol=3e-3)
    assert float(one["magnetic_field"][0]) == pytest.approx(3.793563149e8, rel=1e-9)
    # A star's age by its own index grows with time; the characteristic age of n < 3 is too small for it.
    grown = one["true_age"] - one["true_age"][0]
    np.testing.assert_allclose(grown, times, rtol=1e-9, atol=1.0)
    two = pulsar_history(torques=[(1.0, 0.245), (3.0, 0.755)], end="1e5 yr")
    assert float(two["braking_index"][0]) == pytest.approx(2.51) and float(two["braking_index"][-1]) < 1.3
    with pytest.raises(SceneError, match="torques are wrong"):
        pulsar_history(torques=[(3.0, 0.5)])
    with pytest.raises(SceneError, match="positive period_derivative"):
        pulsar_history(period_derivative=-1e-15)


def test_jupiter_spins_up_as_it_cools():
    found = contraction_history(effective_temperature=300.0)
    assert float(found["period"][0]) == pytest.approx(39.7 * 3600)
    np.testing.assert_allclose(found["angular_momentum"], float(found["angular_momentum"][0]), rtol=1e-12)
    assert float(found["radius"][-1]) < 0.6 * 1.4e8 and not found["beyond_kepler"].values.any()
    fast = contraction_history(period="17 h", effective_temperature=300.0)
    assert bool(fast["sheds_mass"][-1]) and not bool(fast["sheds_mass"][0])
    held = contraction_history(
        "0.5 Msun", "3 Rsun", "8 d", "1e7 yr", effective_temperature=3700.0, disc_until="1.5 Rsun"
    )
    locked = held["radius"].values > 1.5 * 6.957e8
    np.testing.assert_allclose(held["period"].values[locked], 8 * 86400)
    assert np.all(np.diff(held["period"].values[~locked]) < 0) and np.all(
        np.diff(held["angular_momentum"].values[locked]) < 0
    )
    steady = contraction_history(luminosity="1e18 W")
    assert np.all(np.diff(steady["radius"]) < 0)
    for wrong in ({}, {"luminosity": "1 W", "effective_temperature": 100.0}):
        with pytest.raises(SceneError, match="either a luminosity or"):
            contraction_history(**wrong)


def test_a_cloud_makes_a_disc_of_tens_of_au():
    found = cloud_to_disc()
    rate = 2 * math.pi / (2e7 * YEAR)
    size, mass = 0.05 * 3.0856775814913673e16, 1.988409870698051e30
    exact = rate**2 * size**4 / (6.6743e-11 * mass)
    assert found.attrs["disc_radius"] == pytest.approx(exact, rel=1e-6)
    assert found.attrs["disc_radius"] / 1.495978707e11 == pytest.approx(28.3, abs=0.1)
    assert float(found["mass_inside"][-1]) == pytest.approx(mass, rel=1e-3)
    share = 1 - (1 - np.sqrt(found["radius"].values / found.attrs["disc_radius"])) ** 1.5
    np.testing.assert_allclose(found["mass_inside"].values / mass, share, atol=1e-3)
    root = np.sqrt(found["radius"].values / found.attrs["disc_radius"])
    exact = mass * 0.75 * np.sqrt(1 - root) * root / (2 * math.pi * found["radius"].values ** 2)
    np.testing.assert_allclose(found["surface_density"][:-4], exact[:-4], rtol=2e-3)
    np.testing.assert_allclose(found["surface_density"][-4:], exact[-4:], rtol=0.02)
    with pytest.raises(SceneError, match="a mass must be one number"):
        cloud_to_disc(mass=[1e30, 2e30])
    with pytest.raises(SceneError, match="not a mass"):
        cloud_to_disc(mass="3 km")
