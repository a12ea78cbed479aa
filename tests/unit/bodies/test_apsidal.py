"""Love numbers of polytropes against closed forms, independent values and other routes."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.special import spherical_jn

from astroinertia.bodies.apsidal import (
    DEGREES,
    apsidal_constant,
    complement_slope,
    core_zone,
    love_number,
)
from astroinertia.bodies.polytrope import lane_emden

ENTRIES = json.loads((Path(__file__).parents[2] / "reference" / "love_numbers.json").read_text())


@pytest.mark.parametrize("entry", [each for each in ENTRIES if each["name"] == "polytrope.k2_fluid_Love"])
def test_reference_values(entry):
    assert love_number(entry["inputs"]["n"]) == pytest.approx(float(entry["value"]), abs=6e-10)


def test_closed_forms():
    """n = 0: 3/(2 l - 2); n = 1: (2 l + 1) j_l(pi)/(pi j_(l-1)(pi)) - 1, which is 15/pi^2 - 1 for l = 2."""
    assert love_number(1.0) == pytest.approx(15 / math.pi**2 - 1, rel=1e-13)
    for degree in (*DEGREES, 11):
        assert love_number(0.0, degree) == pytest.approx(3 / (2 * degree - 2), rel=1e-13)
        bessel = (2 * degree + 1) * spherical_jn(degree, math.pi) / (math.pi * spherical_jn(degree - 1, math.pi)) - 1
        assert love_number(1.0, degree) == pytest.approx(bessel, rel=1e-12)
        assert apsidal_constant(1.0, degree) == love_number(1.0, degree) / 2


def test_slope_is_radaus():
    eta, degrees = np.array([0.3, 1.2, 2.4]), np.array([2, 3, 4])
    delta = degrees + 1 - eta
    radau = degrees * (degrees + 1) - 6 * 0.4 * (eta + 1) - eta * (eta - 1)
    np.testing.assert_allclose(complement_slope(delta, 0.4, degrees), -radau, rtol=1e-14)


@pytest.mark.parametrize("index", [0.0, 0.3, 1.5, 2.7, 4.0])
def test_integrals_of_the_zone(index):
    """W = -3/(5 - n), by the binding and by the virial integral, and the numbers of the Lane-Emden solution."""
    zone, solution = core_zone(index, 0.0, 2, ()), lane_emden(index)
    radius, mass = zone.r[-1], zone.mass[-1]
    assert radius == pytest.approx(solution.xi_1, rel=2e-14)
    assert mass == pytest.approx(solution.surface_mass, rel=2e-14)
    assert 2 * zone.moment[-1] / (3 * mass * radius**2) == pytest.approx(solution.moment_ratio, rel=2e-14)
    assert zone.binding[-1] * radius / mass**2 == pytest.approx(3 / (5 - index), rel=2e-14)
    assert 3 * zone.volume_work[-1] * radius / mass**2 == pytest.approx(3 / (5 - index), rel=2e-14)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="0 <= n < 5"):
        love_number(5.0)
    with pytest.raises(ValueError, match="degree of 2"):
        love_number(1.0, 1)
    with pytest.raises(ValueError, match="whole degree"):
        love_number(1.0, 2.5)  # type: ignore[arg-type]
