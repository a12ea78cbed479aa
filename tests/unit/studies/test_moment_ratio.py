"""Moment ratios of the solar system against models: the sequence of polytropes, fluid figures, two-layer sweeps."""

import subprocess
import sys

import numpy as np
import pytest

from astroinertia.bodies import apsidal
from astroinertia.bodies.clairaut import radau_darwin_moment_ratio
from astroinertia.bodies.planets import body, own_body
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.errors import SceneError
from astroinertia.studies.core_inversion import core_inversion
from astroinertia.studies.moment_ratio import (
    fluid_love_number,
    hydrostatic_moment_ratio,
    moment_ratio,
    polytropes,
    polytropic_index,
    two_layer_sweep,
)
from astroinertia.units import GRAVITATIONAL_CONSTANT


def test_one_call_compares_published_ratios_with_models():
    found = moment_ratio(["Mars", "earth", "Jupiter"])
    assert found["body"].values.tolist() == ["Mars", "Earth", "Jupiter"]
    mars = found.sel(body="Mars")
    assert float(mars["moment_ratio"]) == pytest.approx(0.36428, abs=5e-6)
    assert float(mars["published_moment_ratio"]) == 0.36419
    assert float(mars["published_radius"]) == 3396e3
    assert str(mars["published_kind"].values) == "polar"
    assert str(found["status"].sel(body="Jupiter").values) == "model"
    mine = own_body("mine", 6e24, 6.371e6, mean_moment_ratio=0.33)
    assert str(moment_ratio([mine])["published_kind"].values[0]) == ""  # nobody has published it
    assert found["central_condensation_source"].values.tolist() == ["two layers", "published", "polytrope"]
    for name, variable in found.variables.items():
        if name != "body":
            assert {"units", "long_name"} <= set(variable.attrs), name
    with pytest.raises(SceneError, match="no body 'Pluto'"):
        moment_ratio(["Pluto"])


def test_a_synchronous_moon_of_ones_own_is_inverted_from_what_tides_and_spin_make_of_it():
    """J2 = 5/6 k2 m and C22 = k2 m/4 of a fluid in step with its orbit: k2 comes back, and its ratio with it."""
    k2, rate, mass, radius = 1.1, 2e-5, 9e22, 1.7e6
    m = rate**2 * radius**3 / (GRAVITATIONAL_CONSTANT * mass)
    given = {"rotation_rate": rate, "j2": 5 / 6 * k2 * m, "c22": k2 * m / 4, "mantle_density": 3300.0}
    moon = own_body("Zephyr", mass, radius, synchronous=True, **given)
    found = moment_ratio(moon).isel(body=0)
    assert float(found["fluid_love_number"]) == pytest.approx(k2, rel=1e-12)
    assert float(found["hydrostatic_moment_ratio"]) == pytest.approx(float(radau_darwin_moment_ratio(k2)), rel=1e-12)
    assert np.isnan(found["moment_ratio"]) and np.isnan(found["core_radius"])  # none is stated
    assert np.isnan(fluid_love_number(own_body("Zephyr", mass, radius, j2=1e-3)))  # a figure without a spin
    with pytest.raises(KeyError, match="no moment ratio of Zephyr is known"):
        core_inversion(moon)


@pytest.mark.parametrize("index", [0.0, 0.05, 0.333, 1.0, 1.77, 3.0, 3.25, 4.4])
def test_the_index_of_a_ratio_is_found_between_the_nodes(index):
    assert polytropic_index(lane_emden(index).moment_ratio) == pytest.approx(index, abs=1e-5)


def test_ratios_of_no_polytrope_have_no_index():
    assert np.isnan(polytropic_index([0.41, 0.0, -0.1, np.nan])).all()


def test_polytropes_are_a_dataset_along_the_index():
    found = polytropes([0.0, 1.0, 3.0])
    np.testing.assert_allclose(found["moment_ratio"], [0.4, 2 / 3 - 4 / np.pi**2, 0.07535763996], rtol=1e-9)
    np.testing.assert_allclose(found["central_condensation"], [1.0, np.pi**2 / 3, 54.18248], rtol=1e-6)


def test_fluid_love_numbers_of_free_and_of_synchronous_bodies():
    """Of Io: 1.2924 (Anderson et al. 2001) from C22; of Titan 1.0097 (Iess et al. 2010), both for the IAU radius."""
    assert fluid_love_number(body("Io")) == pytest.approx(1.2924, abs=1e-3)
    assert fluid_love_number(body("Titan")) == pytest.approx(1.0097, abs=1e-3)
    assert fluid_love_number(body("Earth")) == pytest.approx(0.9383, abs=6e-3)  # 3 J2/q, with the other radius
    for name in ("Moon", "Mercury", "Venus", "Vesta"):
        assert np.isnan(fluid_love_number(body(name)))


@pytest.mark.parametrize(
    "index",
    [
        pytest.param(0.1, marks=pytest.mark.full),
        0.5,
        pytest.param(0.72, marks=pytest.mark.full),
        1.0,
        pytest.param(1.42, marks=pytest.mark.full),
        2.2,
        pytest.param(3.1, marks=pytest.mark.full),
    ],
)
def test_hydrostatic_ratio_of_polytropes(index):
    found = hydrostatic_moment_ratio(apsidal.love_number(index))
    assert found == pytest.approx(lane_emden(index).moment_ratio, abs=2e-4)


def test_hydrostatic_ratio_ends():
    assert hydrostatic_moment_ratio(1.5) == pytest.approx(0.4, rel=1e-12)
    assert np.isnan(hydrostatic_moment_ratio(np.nan))
    assert np.isnan(hydrostatic_moment_ratio(1e-6))


def test_the_sweep_of_a_body_takes_its_mass_radius_and_ratio():
    found = two_layer_sweep("Mars", {"core_density": np.linspace(6000, 9000, 4), "radius": [3.3e6, 3.3895e6]})
    assert found["core_radius"].dims == ("core_density", "radius")
    assert found.attrs["moment_ratio"] == pytest.approx(0.364279, abs=1e-6)
    one = found.sel(core_density=7000.0, radius=3.3895e6)
    assert float(one["core_radius"]) == pytest.approx(1737e3, rel=1e-3)
    mass = 4 / 3 * np.pi * (
        float(one["core_radius"]) ** 3 * (7000 - float(one["mantle_density"]))
        + 3.3895e6**3 * float(one["mantle_density"])
    )  # fmt: skip
    assert mass == pytest.approx(body("Mars").mass, rel=1e-12)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"moment_ratio": [0.36]}, "two layers of Mars follow from two of"),
        ({"core_density": [7e3], "mantle_density": [3e3], "core_radius": [1e6]}, "follow from two of"),
        ({"colour": [1.0]}, "follow from two of|no parameter"),
    ],
)
def test_sweeps_that_are_no_body_are_reported(values, words):
    with pytest.raises(SceneError, match=words):
        two_layer_sweep("Mars", values)


def test_a_body_without_a_ratio_cannot_be_inverted(monkeypatch):
    from dataclasses import replace

    from astroinertia.bodies import planets
    from astroinertia.studies import moment_ratio as study

    mars = body("Mars")
    without = {name: rows for name, rows in mars.published.items() if not name.endswith("moment_ratio")}
    monkeypatch.setattr(study, "body", lambda _: replace(mars, published=without))
    with pytest.raises(SceneError, match="no moment ratio of Mars"):
        two_layer_sweep("Mars", {"core_density": [7000.0]})
    assert planets.body("Mars") is mars


@pytest.mark.full
def test_the_package_and_its_studies_import_no_extras():
    code = (
        "import sys, astroinertia, astroinertia.cli.main, astroinertia.studies.interior_inference, "
        "astroinertia.studies.moment_ratio, astroinertia.plots.interior_posterior\n"
        "print([name for name in ('emcee', 'corner', 'dask') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
