"""Interiors where a formula cancels, a body stops to exist, or a sampler is fooled."""

import time

import numpy as np
import pytest

from astroinertia.bodies.planets import body
from astroinertia.errors import NumericalError
from astroinertia.studies.core_inversion import core_inversion
from astroinertia.studies.flattening import flattening_sequence
from astroinertia.studies.moment_ratio import two_layer_sweep
from astroinertia.studies.two_layers import impossible, love_numbers, moment_ratio_of, three_layers, two_layers


def test_without_rotation_every_body_is_a_sphere():
    bodies = (
        {"index": 0.0}, {"index": 1.0}, {"index": 3.0},
        {"outer_radii": [0.3, 0.9, 1.0], "densities": [9.0, 3.0, 1.0]},
    )  # fmt: skip
    for one in bodies:
        found = flattening_sequence([0.0], **one)
        for name in ("flattening", "zonal_harmonic_2", "rotational_to_gravitational", "rotation_parameter"):
            assert abs(float(found[name][0])) < 1e-13, (one, name)


def test_ten_thousand_bodies_of_any_size_of_core_are_inverted_back():
    """From a pea to nearly the whole body, and cores up to a thousand times denser: what comes back has the inputs."""
    generator = np.random.default_rng(4)
    x = np.concatenate([10 ** generator.uniform(-3, -0.1, 5000), 1 - 10 ** generator.uniform(-4, -0.7, 5000)])
    contrast = 10 ** generator.uniform(0.01, 3, 10000)
    mean = 1 + (contrast - 1) * x**3
    ratio = 0.4 * (1 + (contrast - 1) * x**5) / mean
    for known in ({"core_density": contrast}, {"mantle_density": np.ones(10000)}, {"core_radius_ratio": x}):
        found = two_layers(mean, moment_ratio=ratio, **known)
        good = np.isfinite(found.core_density)
        assert good.mean() > 0.97  # the rest differs from a uniform body by less than round-off
        np.testing.assert_allclose(moment_ratio_of(mean, found)[good], ratio[good], rtol=1e-12)
        cube = found.core_radius_ratio**3
        again = found.mantle_density * (1 - cube) + found.core_density * cube
        np.testing.assert_allclose(again[good], mean[good], rtol=1e-12)


def test_a_core_without_mantle_and_a_point_core_are_the_ends_of_what_exists():
    mean, ratio = 4000.0, 0.36
    bare = mean * (0.4 / ratio) ** 1.5  # a sphere of this density with this moment, and nothing around it
    just = two_layers(mean, moment_ratio=ratio, core_density=bare * (1 + 1e-9))
    assert just.core_radius_ratio == pytest.approx((mean / bare) ** (1 / 3), rel=1e-6)
    assert 0 < just.mantle_density < 1e-4 * mean
    assert np.isnan(two_layers(mean, moment_ratio=ratio, core_density=bare * (1 - 1e-9)).core_density)
    assert "no mantle at all" in str(impossible(mean, moment_ratio=ratio, core_density=0.99 * bare))
    point = mean * ratio / 0.4  # the mantle of a point core
    dense = two_layers(mean, moment_ratio=ratio, mantle_density=point * (1 - 1e-8))
    assert dense.core_radius_ratio < 1e-3
    assert dense.core_density > 1e8 * mean
    assert np.isnan(two_layers(mean, moment_ratio=ratio, mantle_density=point * (1 + 1e-8)).core_density)
    assert "even a point core" in str(impossible(mean, moment_ratio=ratio, mantle_density=1.01 * point))


def test_a_ratio_above_that_of_a_uniform_body_is_refused_with_the_inequality():
    for known in ({"core_density": 7000.0}, {"mantle_density": 3500.0}, {"core_radius_ratio": 0.5}):
        reason = impossible(4000.0, moment_ratio=0.45, **known)
        assert reason is not None and "0.45 is not below 0.4" in reason


def test_love_numbers_of_extreme_cores():
    """A heavy point core leaves a response that goes to zero; a core like its mantle one of 3/2."""
    point = two_layers(1.0, core_radius_ratio=1e-3, mantle_density=1e-6)
    assert 0 < love_numbers(point) < 1e-5
    same = two_layers(1.0, core_radius_ratio=0.7, mantle_density=1 - 1e-12)
    assert love_numbers(same) == pytest.approx(1.5, rel=1e-10)


def test_crusts_that_cannot_be_are_nan_and_say_nothing_else():
    common = {"mean_density": 4000.0, "moment_ratio": 0.36, "core_density": 7000.0}
    shares, densities = np.array([0.02, 0.02, 0.9, 1.0, -0.01]), np.array([2800.0, 6000.0, 2800.0, 2800.0, 2800.0])
    found = three_layers(crust_share=shares, crust_density=densities, **common)
    assert np.isfinite(found.core_density).tolist() == [True, False, False, False, False]
    assert np.isfinite(love_numbers(found)).tolist() == [True, False, False, False, False]


def test_errors_that_reach_beyond_what_exists_are_counted_not_hidden():
    venus = core_inversion(body("Venus"))  # 0.337(24): a few of a hundred draws are above 0.4 or below a bare core
    assert 0.9 < venus.possible_share < 1.0
    assert venus.core_radius_low < venus.core_radius < venus.core_radius_high < body("Venus").mean_radius


@pytest.mark.full
def test_a_hundred_thousand_models_with_their_love_numbers_take_seconds():
    values = {"core_density": np.linspace(5000, 9000, 400), "moment_ratio": np.linspace(0.33, 0.41, 250)}
    begin = time.perf_counter()
    found = two_layer_sweep("Mars", values)
    took = time.perf_counter() - begin
    assert took < 10
    possible = np.isfinite(found["love_number"])
    assert 0.5 < float(possible.mean()) < 1
    np.testing.assert_array_equal(possible, np.isfinite(found["core_radius"]))
    assert not possible.sel(moment_ratio=slice(0.4001, None)).any()
    pytest.importorskip("dask")
    np.testing.assert_array_equal(
        two_layer_sweep("Mars", values, dask=True)["love_number"].compute(), found["love_number"]
    )


@pytest.mark.full
def test_two_separate_peaks_are_not_taken_for_a_posterior():
    """Chains that each sit on one of two peaks look settled; only their disagreement tells."""
    pytest.importorskip("emcee")
    from astroinertia.studies.sampling import sample, summary

    def peaks(positions):
        return np.logaddexp(*(-0.5 * ((positions - at) ** 2).sum(-1) / 0.01 for at in (-5.0, 5.0)))

    def start(generator, count):
        return generator.choice([-5.0, 5.0]) + 0.1 * generator.normal(size=(count, 2))

    found = sample(peaks, start, ["one", "other"], draws=300, chains=4, walkers=8, seed=5)
    assert 0.2 < float((found["one"] > 0).mean()) < 0.8
    with pytest.raises(NumericalError, match="R-hat"):
        summary(found, ["one", "other"])


@pytest.mark.full
def test_a_posterior_at_the_edge_of_what_exists_stays_inside():
    """A ratio of 0.399(3): half of its errors are above 0.4, where the core would be lighter than the mantle."""
    pytest.importorskip("emcee")
    from astroinertia.studies.interior_inference import Gaussian, Uniform, infer_interior

    found = infer_interior(
        {"mean_density": Gaussian(3345.0, 0.3), "moment_ratio": Gaussian(0.399, 3e-3)},
        {"core_density": Uniform(5000.0, 8000.0)},
        draws=400, chains=2, walkers=16,
    )  # fmt: skip
    assert float(found["moment_ratio"].max()) < 0.4
    assert float((found["core_density"] - found["mantle_density"]).min()) > 0
    assert float(found["core_radius_ratio"].min()) > 0
    assert float(found["moment_ratio"].quantile(0.95)) > 0.3985
