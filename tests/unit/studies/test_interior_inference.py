"""Posteriors of interiors against exact inversion with propagated errors, and what must be refused."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from astropy import units as u

from astroinertia.bodies.inversion import two_layers_with_errors
from astroinertia.bodies.planets import body, own_body
from astroinertia.errors import NumericalError, SceneError
from astroinertia.studies.core_inversion import core_inversion
from astroinertia.studies.interior_inference import Gaussian, Uniform, infer_body, infer_interior
from astroinertia.studies.sampling import summary
from astroinertia.studies.two_layers import love_numbers, moment_ratio_of, two_layers

pytest.importorskip("emcee")

MEAN = Gaussian(4000.0, 1.0)
TRUTH = two_layers(4000.0, core_density=8000.0, mantle_density=3300.0)
RATIO = float(moment_ratio_of(4000.0, TRUTH))
LOVE = float(love_numbers(TRUTH))
QUICK = {"draws": 1300, "chains": 2, "walkers": 16}


@pytest.fixture(scope="module")
def posterior():
    observed = {"mean_density": MEAN, "moment_ratio": Gaussian(RATIO, 2e-4)}
    return infer_interior(observed, {"core_density": Gaussian(8000.0, 60.0)}, seed=1, **QUICK)


@pytest.fixture(scope="module")
def few_draws():
    """The same posterior by too few draws to have converged, each of which is an interior all the same."""
    observed = {"mean_density": MEAN, "moment_ratio": Gaussian(RATIO, 2e-4)}
    return infer_interior(observed, {"core_density": Gaussian(8000.0, 60.0)}, seed=1, draws=100, chains=2, walkers=16)


@pytest.mark.full
def test_the_posterior_is_the_exact_inversion_with_its_propagated_errors(posterior):
    """With Gaussian inputs and small errors the posterior is Gaussian with the covariance of the exact jacobian."""
    exact = two_layers_with_errors(4000.0, RATIO, [1.0, 2e-4, 60.0], core_density=8000.0)
    names = ["core_radius_ratio", "mantle_density"]
    found = summary(posterior, names)
    assert bool(found["converged"].all())
    expected = np.array([exact.structure.core_radius_ratio, exact.structure.mantle_density])
    deviation = np.sqrt(np.diag(exact.covariance))[[0, 2]]
    error = 1 / np.sqrt(found["effective_samples"].values)
    assert (error < 0.05).all()
    # the means differ by the curvature, too, which is below 0.05 standard deviations here
    assert (abs(found["mean"].values - expected) < (4 * error + 0.05) * deviation).all()
    np.testing.assert_allclose(found["standard_deviation"], deviation, rtol=0.1)


@pytest.mark.slow
def test_every_draw_has_the_mass_and_moment_of_its_coordinates(few_draws):
    posterior = few_draws
    x, core = posterior["core_radius_ratio"], posterior["core_density"]
    mantle = posterior["mantle_density"]
    np.testing.assert_allclose(mantle + (core - mantle) * x**3, posterior["mean_density"], rtol=1e-12)
    moment = 0.4 * (mantle + (core - mantle) * x**5) / posterior["mean_density"]
    np.testing.assert_allclose(moment, posterior["moment_ratio"], rtol=1e-12)
    assert posterior["core_density"].attrs["units"] == "kg m-3"
    assert posterior.attrs["sampled"] == ["mean_density", "moment_ratio", "core_density"]


@pytest.mark.full
def test_a_fluid_love_number_alone_finds_the_ratio():
    observed = {"mean_density": MEAN, "love_number": Gaussian(LOVE, 2e-3)}
    found = summary(
        infer_interior(observed, {"core_density": Gaussian(8000.0, 30.0)}, seed=2, **QUICK),
        ["moment_ratio", "core_radius_ratio", "love_number"],
    )
    for name, truth in (("moment_ratio", RATIO), ("love_number", LOVE)):
        one = found.sel(parameter=name)
        assert abs(float(one["mean"]) - truth) < 0.2 * float(one["standard_deviation"])
    assert float(found["standard_deviation"].sel(parameter="love_number")) == pytest.approx(2e-3, rel=0.1)
    assert float(found["mean"].sel(parameter="core_radius_ratio")) == pytest.approx(TRUTH.core_radius_ratio, rel=0.01)


@pytest.mark.full
def test_j2_and_flattening_are_the_love_number_times_the_rotation():
    small_m = 0.004
    observed = {"mean_density": MEAN, "zonal_harmonic_2": Gaussian(small_m * LOVE / 3, 1e-6)}
    found = infer_interior(observed, {"core_density": Gaussian(8000.0, 30.0)}, small_m, seed=3, **QUICK)
    np.testing.assert_allclose(found["zonal_harmonic_2"], small_m * found["love_number"] / 3, rtol=1e-13)
    np.testing.assert_allclose(found["flattening"], small_m * (1 + found["love_number"]) / 2, rtol=1e-13)
    assert float(found["love_number"].std()) == pytest.approx(3e-6 / small_m, rel=0.1)


@pytest.mark.full
def test_three_layers_of_the_moon_agree_with_the_inversion_draw_by_draw():
    """The same distribution by two roads: sampling, and exact inversion of draws from the errors."""
    found = summary(infer_body("Moon", draws=2000, chains=3), ["core_radius", "mantle_density"])
    exact = core_inversion(body("Moon"))
    low, high = (float(found["quantiles"].sel(parameter="core_radius", quantile=each)) for each in (0.16, 0.84))
    assert low == pytest.approx(exact.core_radius_low, rel=0.02)
    assert high == pytest.approx(exact.core_radius_high, rel=0.02)
    assert low < 381e3 < high  # Viswanathan et al. 2019


@pytest.mark.slow
def test_the_picture_shows_every_pair(few_draws, tmp_path):
    pytest.importorskip("corner")
    from astroinertia.plots.interior_posterior import posterior_figure
    from astroinertia.plots.style import save

    names = ["core_radius_ratio", "core_density", "mantle_density"]
    figure = posterior_figure(few_draws, names, {"core_density": 8000.0})
    assert len(figure.axes) == 9
    assert figure.axes[6].get_xlabel() == "core radius ratio"
    shown = float(figure.axes[4].get_title().strip("$").partition("^")[0])
    assert shown == pytest.approx(float(few_draws["core_density"].median()), abs=1)
    assert save(figure, tmp_path / "corner.png").stat().st_size > 20_000


def test_numbers_of_neighbouring_panels_do_not_touch():
    pytest.importorskip("corner")
    from astroinertia.plots.interior_posterior import posterior_figure

    rng = np.random.default_rng(1)
    given = {"core_radius": (1.983e6, 6.5e4), "core_density": (5999.0, 172.0), "mantle_density": (3446.0, 27.0)}
    given |= {"moment_ratio": (0.36428, 0.00011), "love_number": (1.18582, 0.0009)}
    draws = {name: ("draw", rng.normal(*numbers, 4000)) for name, numbers in given.items()}
    figure = posterior_figure(xr.Dataset(draws))
    figure.canvas.draw()
    below = [axes.get_xticklabels() for axes in figure.axes[-5:]]
    beside = [axes.get_yticklabels() for axes in figure.axes[20:0:-5]]
    for panels in (below, beside):
        boxes = [[label.get_window_extent() for label in labels if label.get_visible()] for labels in panels]
        assert all(len(each) >= 2 for each in boxes)
        assert not any(one[-1].overlaps(other[0]) for one, other in pairwise(boxes))


def test_what_no_picture_can_be_drawn_of_is_refused():
    pytest.importorskip("corner")
    from astroinertia.plots.interior_posterior import posterior_figure

    posterior = xr.Dataset({"core_density": ("draw", np.arange(5.0)), "moment_ratio": ("draw", np.arange(5.0))})
    with pytest.raises(SceneError, match="has no 'colour'; it has core_density, moment_ratio"):
        posterior_figure(posterior, ["colour"])
    for part, names in ((posterior.isel(draw=[]), None), (posterior.isel(draw=[0, 1]), None), (posterior, [])):
        with pytest.raises(SceneError, match="more draws than parameters"):
            posterior_figure(part, names)


ASSUMED = {"core_density": Gaussian(8000.0, 60.0)}


@pytest.mark.parametrize(
    ("observed", "assumed", "words"),
    [
        ({}, ASSUMED, "needs the observed mean_density"),
        ({"mean_density": MEAN, "k2": MEAN}, ASSUMED, "no observation 'k2'"),
        ({"mean_density": MEAN}, {}, "exactly one of .* not none"),
        ({"mean_density": MEAN}, {**ASSUMED, "mantle_density": MEAN}, "exactly one of"),
        ({"mean_density": MEAN}, {**ASSUMED, "crust_share": Gaussian(0.01, 0.001)}, "both of crust_share and"),
        ({"mean_density": MEAN}, {**ASSUMED, "colour": MEAN}, "'colour' is not to be assumed"),
        ({"mean_density": MEAN, "zonal_harmonic_2": MEAN}, ASSUMED, "without small_m"),
        ({"mean_density": (4000.0, 1.0)}, ASSUMED, "mean_density must be a Gaussian, not"),
        ({"mean_density": Gaussian(4000.0, 0.0)}, ASSUMED, "mean_density needs a finite mean and a deviation above 0"),
        ({"mean_density": Gaussian("4 km", 1.0)}, ASSUMED, "mean_density: must be in kg m-3"),
        ({"mean_density": MEAN}, {"core_density": Uniform(9.0, 8.0)}, "core_density needs a finite low below"),
    ],
)
def test_incomplete_questions_are_refused(observed, assumed, words):
    with pytest.raises(SceneError, match=words):
        infer_interior(observed, assumed, **QUICK)


def test_distributions_may_have_units():
    few = {"draws": 20, "chains": 1, "walkers": 16}
    plain, with_units = (
        infer_interior({"mean_density": mean, "moment_ratio": Gaussian(RATIO, 2e-4)}, {"core_density": core}, **few)
        for mean, core in (
            (MEAN, Gaussian(8000.0, 60.0)),
            (Gaussian(4 * u.g / u.cm**3, "1 kg/m3"), Gaussian("8 g/cm3", 60 * u.kg / u.m**3)),
        )
    )
    np.testing.assert_allclose(with_units["core_radius_ratio"], plain["core_radius_ratio"], rtol=1e-9)
    assert with_units["core_density"].attrs["prior_mean"] == pytest.approx(8000.0)


def test_a_synchronous_moon_keeps_its_own_rotation():
    io = infer_body("Io", draws=2, chains=1)
    assert io.attrs["small_m"] == body("Io").small_m
    np.testing.assert_allclose(io["zonal_harmonic_2"], 2.5 * io.attrs["small_m"] * io["love_number"] / 3)


def test_a_body_of_ones_own_is_inferred_as_one_of_the_table_is():
    layers = {"mantle_density": 3300.0, "mantle_density_uncertainty": 50.0}
    ratio = {"mean_moment_ratio": 0.37, "mean_moment_ratio_uncertainty": 0.003, "rotation_rate": 2e-5}
    moon = own_body("Zephyr", 9e22, 1.7e6, synchronous=True, **ratio, **layers)
    found = infer_body(moon, draws=2, chains=1)
    assert found.attrs["body"] == "Zephyr" and found.attrs["synchronous_share"] == 2.5
    assert found["mantle_density"].attrs["prior_mean"] == 3300.0
    assert (found["core_radius"] < 1.7e6).all()


def test_what_no_interior_agrees_with_is_reported():
    impossible = {"mean_density": MEAN, "moment_ratio": Gaussian(0.45, 1e-3)}
    with pytest.raises(NumericalError, match="no interior of 2 uniform layers"):
        infer_interior(impossible, ASSUMED, **QUICK)
    light = {"core_density": Uniform(1000.0, 3000.0)}
    with pytest.raises(NumericalError, match="no interior"):
        infer_interior({"mean_density": MEAN, "moment_ratio": Gaussian(0.35, 1e-3)}, light, **QUICK)


def test_bodies_without_errors_or_assumptions_are_reported():
    with pytest.raises(SceneError, match="nothing is assumed for the layers of Jupiter"):
        infer_body("Jupiter")
    with pytest.raises(SceneError, match="Ceres has no published uncertainty"):
        infer_body("Ceres")
    with pytest.raises(SceneError, match="Moon has no figure of a fluid"):
        infer_body("Moon", ("love_number",))
    with pytest.raises(SceneError, match="no body 'Pluto'"):
        infer_body("Pluto")
    with pytest.raises(SceneError, match="not to be inferred from"):
        infer_body("Mars", ("colour",))
