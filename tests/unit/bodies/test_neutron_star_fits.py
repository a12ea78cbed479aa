"""Published fits: their numbers, their range, and the limits of rotation."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies import neutron_star_fits as fits
from astroinertia.units import SOLAR_MASS

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "neutron_stars.json").read_text())
STARS = [entry for entry in REFERENCE if entry["name"] == "tov_hartle"]
LIMITS = [entry for entry in REFERENCE if entry["name"] == "rotation_limits"]


@pytest.mark.parametrize("entry", STARS, ids=lambda entry: f"{entry['inputs']['rho0_c']:g}")
def test_reference_values(entry):
    value = {key: float(text) for key, text in entry["value"].items()}
    found = {
        "LS2005_I_MR2": fits.lattimer_schutz(value["M"], value["R_km"], check_range=False),
        "BR2016_I_MR2": fits.breu_rezzolla_moment_ratio(value["C"], check_range=False),
        "BR2016_I_M3": fits.breu_rezzolla_moment_bar(value["C"], check_range=False),
    }
    for name, number in found.items():
        assert float(number) == pytest.approx(value[name], rel=5e-6), name


def test_outside_their_range_fits_refuse():
    """I/M^3 of Breu & Rezzolla turns negative below C = 0.016: an answer there would be nonsense."""
    assert fits.breu_rezzolla_moment_bar(2e-4, check_range=False) < 0
    for fit in (fits.breu_rezzolla_moment_bar, fits.breu_rezzolla_moment_ratio):
        for compactness in (2e-4, 0.0651, 0.35):
            with pytest.raises(ValueError, match=r"check_range=False evaluates"):
                fit(compactness)
        with pytest.raises(ValueError, match="positive and finite"):
            fit(-0.1, check_range=False)
    with pytest.raises(ValueError, match="check_range"):
        fits.lattimer_schutz(0.0025, 18.5)
    with pytest.raises(ValueError, match="check_range"):
        fits.moment_bar_of_love(np.array([300.0, 1e6]))
    with pytest.raises(ValueError, match="check_range"):
        fits.moment_bar_of_quadrupole(26.3)
    with pytest.raises(ValueError, match="check_range"):
        fits.quadrupole_bar_of_love(0.5)


def test_fits_agree_with_each_other_and_with_printed_numbers():
    # Breu & Rezzolla quote Lattimer & Schutz in C: 0.237 + 0.674 C + 4.48 C^4
    C = np.linspace(0.11, 0.3, 5)
    mass = 1.4
    quoted = 0.237 + 0.674 * C + 4.48 * C**4
    np.testing.assert_allclose(fits.lattimer_schutz(mass, mass * fits.SOLAR_LENGTH / 1e3 / C), quoted, rtol=2e-3)
    np.testing.assert_allclose(fits.breu_rezzolla_moment_bar(C) * C**2, fits.breu_rezzolla_moment_ratio(C), rtol=0.03)
    # Yagi & Yunes's three fits close on themselves to their accuracy
    love = np.geomspace(10, 5000, 6)
    around = fits.moment_bar_of_quadrupole(fits.quadrupole_bar_of_love(love))
    np.testing.assert_allclose(around, fits.moment_bar_of_love(love), rtol=0.01)


@pytest.mark.parametrize("entry", LIMITS, ids=lambda entry: f"{entry['inputs']['mass_g']:.3g}")
def test_reference_limits_of_rotation(entry):
    mass, radius = entry["inputs"]["mass_g"] / 1e3, entry["inputs"]["radius_cm"] / 100
    assert fits.kepler_period(mass, radius) == pytest.approx(float(entry["value"]["P_Kepler_s"]), rel=1e-7)
    roche = fits.roche_shedding_period(mass, radius)
    assert roche == pytest.approx(float(entry["value"]["P_massshed_newton_s"]), rel=1e-7)


def test_relativistic_limits():
    """Each is a fraction of the orbital frequency of the same sphere: 0.65 for matter with weight, 0.544 in Roche's."""
    assert fits.shedding_frequency(1.0, 10.0, "lattimer_prakash_2004") == pytest.approx(1045.0)
    assert fits.shedding_frequency(1.96, 10.0) == pytest.approx(1.4 * 1080.0)
    assert fits.shedding_frequency(1.0, 40.0) == pytest.approx(1080.0 / 8)
    orbit = 1 / fits.kepler_period(SOLAR_MASS, 1e4)
    assert fits.shedding_frequency(1.0, 10.0, "relativistic_roche") / orbit == pytest.approx((2 / 3) ** 1.5, rel=2e-3)
    assert math.isclose(float(fits.kepler_period(1.0, 1.0, 1.0)), 2 * math.pi)
    with pytest.raises(ValueError, match="there is no limit 'kepler'"):
        fits.shedding_frequency(1.4, 12.0, "kepler")


def test_limits_of_what_is_negative_are_refused():
    for limit in (fits.kepler_period, fits.roche_shedding_period, fits.shedding_frequency):
        with pytest.raises(ValueError, match="mass must not be negative, not -1"):
            limit(np.array([1.0, -1.0]), 12.0)
        with pytest.raises(ValueError, match=r"radius(_km)? must not be negative, not -12"):
            limit(1.0, -12.0)
