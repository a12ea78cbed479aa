"""Two and three layers for many bodies at once, and cores from the moment ratios of the table."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.inversion import TwoLayers
from astroinertia.bodies.planets import body
from astroinertia.studies.core_inversion import core_inversion
from astroinertia.studies.two_layers import (
    PARAMETERS,
    impossible,
    love_numbers,
    moment_ratio_of,
    three_layers,
    two_layers,
)

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "inverse.json").read_text())
MEAN = 4000.0
TRUE = {"core_radius_ratio": 0.55, "core_density": 7000.0}
TRUE["mantle_density"] = (MEAN - 7000 * 0.55**3) / (1 - 0.55**3)
TRUE["moment_ratio"] = 0.4 * (TRUE["mantle_density"] + (7000 - TRUE["mantle_density"]) * 0.55**5) / MEAN


@pytest.mark.parametrize("entry", [each for each in REFERENCE if each["name"] == "inverse_two_layer"])
def test_reference_inversions(entry):
    given = {name: float(value) for name, value in entry["inputs"].items()}
    found = two_layers(given["rho_mean"], moment_ratio=given["k"], mantle_density=given["rho_mantle"])
    assert found.core_radius_ratio == pytest.approx(float(entry["value"]["rc_over_R"]), rel=1e-13)
    assert found.core_density == pytest.approx(float(entry["value"]["rho_core"]), rel=1e-12)


@pytest.mark.parametrize("first", PARAMETERS)
@pytest.mark.parametrize("second", PARAMETERS)
def test_any_two_numbers_give_the_others(first, second):
    if PARAMETERS.index(first) >= PARAMETERS.index(second):
        return
    found = two_layers(MEAN, **{name: np.array([TRUE[name]] * 3) for name in (first, second)})
    for name in ("core_radius_ratio", "core_density", "mantle_density"):
        np.testing.assert_allclose(getattr(found, name), TRUE[name], rtol=1e-13)
    np.testing.assert_allclose(moment_ratio_of(MEAN, found), TRUE["moment_ratio"], rtol=1e-13)


def test_what_cannot_be_is_nan_member_by_member():
    ratio = np.array([0.45, TRUE["moment_ratio"], 0.1, 0.4])
    found = two_layers(MEAN, moment_ratio=ratio, mantle_density=3000.0)
    assert np.isfinite(found.core_density).tolist() == [False, True, False, False]
    assert np.isfinite(love_numbers(found)).tolist() == [False, True, False, False]
    inside_out = two_layers(MEAN, core_density=3000.0, mantle_density=5000.0)
    assert np.isnan(inside_out.core_radius_ratio)


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ({"moment_ratio": 0.45, "mantle_density": 3500}, "0.45 is not below 0.4"),
        ({"moment_ratio": 0.36, "core_density": 3000}, "the core is denser than the mean density 4000"),
        ({"moment_ratio": 0.36, "core_density": 4100}, "no mantle at all the moment ratio is 0.39"),
        ({"moment_ratio": 0.36, "mantle_density": 3900}, "even a point core"),
        ({"core_density": 3000, "mantle_density": 2000}, "core density 3000 .* not above the mean density 4000"),
        ({"core_density": 7000, "mantle_density": 5000}, "mantle density 5000 .* not below the mean density 4000"),
        ({"core_density": 9000, "core_radius_ratio": 0.9}, "no mantle of a positive density"),
    ],
)
def test_why_there_is_no_such_body(known, words):
    reason = impossible(MEAN, **known)
    assert reason is not None
    assert re.search(words, reason), reason
    assert impossible(MEAN, moment_ratio=TRUE["moment_ratio"], core_density=7000.0) is None


def test_too_few_or_unknown_numbers_are_refused():
    with pytest.raises(ValueError, match="two of moment_ratio"):
        two_layers(MEAN, core_density=7000.0)
    with pytest.raises(ValueError, match="two of moment_ratio"):
        two_layers(MEAN, core_density=7000.0, colour=1.0)
    for wrong in ({}, {"core_radius": 0.5}, {"core_density": 7000.0, "mantle_density": 3000.0}):
        with pytest.raises(ValueError, match="three layers need one of mantle_density"):
            three_layers(MEAN, 0.36, 0.02, 2800.0, **wrong)


def test_three_layers_have_the_mass_and_moment_asked_for():
    ratio = np.array([0.35, 0.36, 0.37])
    found = three_layers(MEAN, ratio, 0.02, 2800.0, core_density=7000.0)
    x, s = found.core_radius_ratio, found.shell_boundary_ratio
    densities = [found.core_density, found.mantle_density, found.shell_density]
    for power, expected in ((3, MEAN), (5, ratio / 0.4 * MEAN)):
        shares = np.diff([0 * x, x**power, s**power, 1 + 0 * x], axis=0)
        total = sum(rho * share for rho, share in zip(densities, shares, strict=True))
        np.testing.assert_allclose(total, expected, rtol=1e-13)


@pytest.mark.slow
def test_a_crust_like_the_mantle_changes_nothing():
    two = two_layers(MEAN, moment_ratio=TRUE["moment_ratio"], core_density=7000.0)
    three = three_layers(MEAN, TRUE["moment_ratio"], 0.03, two.mantle_density * (1 - 1e-12), core_density=7000.0)
    assert three.core_radius_ratio == pytest.approx(two.core_radius_ratio, rel=1e-9)
    assert love_numbers(three) == pytest.approx(love_numbers(two), rel=1e-9)


def test_love_numbers_of_known_bodies():
    """Reference two-layer bodies of Clairaut's equation, and a core that is nothing else than the mantle."""
    layers = TwoLayers(np.array([0.5, 0.5]), np.array([2.0, 5.0]), np.array([1.0, 1.0]))
    np.testing.assert_allclose(love_numbers(layers), [1.20531088082902, 0.748366013071895], rtol=1e-13)
    same = TwoLayers(np.array(0.5), np.array(1.0), np.array(1.0))
    assert love_numbers(same) == pytest.approx(1.5, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "low", "high", "published"),
    [
        ("Moon", 320e3, 440e3, 381e3),  # laser ranging; agrees, for the Moon is hardly compressed
        ("Mercury", 1.73e6, 1.90e6, 1.820e6),
        ("Mars", 1.91e6, 2.06e6, 1.98e6),  # 150 km above seismology: no compression
        ("Earth", 3.77e6, 3.84e6, 3.807e6),  # 330 km above seismology
    ],
)
def test_cores_from_moment_ratios(name, low, high, published):
    found = core_inversion(body(name))
    assert low < found.core_radius_low < found.core_radius < found.core_radius_high < high
    assert found.core_radius_low < published < found.core_radius_high
    assert found.possible_share > 0.99
    assert found.core_density > found.mantle_density


def test_the_older_ratio_of_mercury_gives_the_core_that_was_published_for_it():
    """Margot et al. 2012: 1998 km with two layers; Hauck et al. 2013: 2020(30) km and 6980(280) kg/m3."""
    found = core_inversion(body("Mercury"), ratio_row=1)
    assert found.core_radius_low < 1998e3 < 2020e3 < found.core_radius_high
    assert found.core_radius == pytest.approx(1998e3, rel=0.025)
    assert abs(found.core_density - 6980) < found.core_density_deviation


def test_an_uncertain_radius_changes_density_and_ratio_together():
    """The moment is measured, its ratio to M R^2 follows: that of a Mars 1 % larger is 2 % smaller."""
    mars = body("Mars")
    exact = {name: tuple(replace(row, uncertainty=np.nan) for row in rows) for name, rows in mars.published.items()}
    exact["mean_radius"] = (replace(mars.adopted("mean_radius"), uncertainty=0.01 * mars.mean_radius),)
    del exact["crust_density"]
    found = core_inversion(replace(mars, published=exact))
    ends = []
    for sign in (-0.994458, 0.994458):  # the 16th and 84th percentile of a Gaussian
        radius = (1 + 0.01 * sign) * mars.mean_radius
        density = 3 * mars.mass / (4 * np.pi * radius**3)
        ratio = mars.moment_ratio().value * (mars.mean_radius / radius) ** 2
        layers = two_layers(density, moment_ratio=ratio, core_density=mars.adopted("core_density").value)
        ends.append(layers.core_radius_ratio * radius)
    np.testing.assert_allclose(sorted(ends), [found.core_radius_low, found.core_radius_high], rtol=2e-3)


def test_nothing_is_inverted_where_nothing_is_assumed():
    found = core_inversion(body("Jupiter"))
    assert np.isnan(found.core_radius)
    assert found.assumed == ""
