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
    index_derivatives,
    love_number,
)
from astroinertia.bodies.clairaut import love_number_from_radau, radau_slope
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
    radau = np.array([radau_slope(1.0, value, 0.4, degree) for value, degree in zip(eta, degrees, strict=True)])
    np.testing.assert_allclose(complement_slope(delta, 0.4, degrees), -radau, rtol=1e-14)
    assert love_number_from_radau(3.0 - 0.7, 2) == pytest.approx(0.7 / (5 - 0.7), rel=1e-14)


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


@pytest.mark.full
@pytest.mark.parametrize("index", [0.0, *(pytest.param(n, marks=pytest.mark.slow) for n in (0.3, 1.5, 4.0))])
def test_derivatives_by_index(index):
    """Against W = -3/(5 - n), whose derivative is exact, and against differences."""
    step = 1e-30
    zone = core_zone(complex(index, step), 0.0, 2, ())
    binding = (zone.binding[-1] * zone.r[-1] / zone.mass[-1] ** 2).imag / step
    assert binding == pytest.approx(3 / (5 - index) ** 2, rel=1e-12)
    change, low = 1e-4, max(index - 1e-4, 0.0)
    slopes = index_derivatives((index + change + low) / 2)
    for name in ("xi_1", "surface_mass", "moment_ratio", "central_to_mean"):
        difference = getattr(lane_emden(index + change), name) - getattr(lane_emden(low), name)
        assert getattr(slopes, name) == pytest.approx(difference / (index + change - low), rel=1e-6)
    for degree in (2, 8):
        difference = love_number(index + change, degree) - love_number(low, degree)
        assert slopes.love_numbers[degree] == pytest.approx(difference / (index + change - low), rel=1e-6)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="0 <= n < 5"):
        love_number(5.0)
    with pytest.raises(ValueError, match="degree of 2"):
        love_number(1.0, 1)
