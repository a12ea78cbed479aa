"""Sampling against posteriors known in closed form, and the refusal of samples that cannot be believed."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.errors import NumericalError, SceneError
from astroinertia.studies.sampling import diagnostics, r_hat, sample, summary

pytest.importorskip("emcee")

MEAN = np.array([3.0, -2.0])
COVARIANCE = np.array([[1.0, 0.9 * 0.02], [0.9 * 0.02, 0.02**2]])  # of very different size, and correlated


def _gaussian(positions: np.ndarray) -> np.ndarray:
    away = positions - MEAN
    return -0.5 * np.einsum("ni,ij,nj->n", away, np.linalg.inv(COVARIANCE), away)


def _spread(generator: np.random.Generator, count: int) -> np.ndarray:
    return MEAN + generator.normal(size=(count, 2)) * [3.0, 0.06]


@pytest.fixture(scope="module")
def gaussian() -> xr.Dataset:
    return sample(_gaussian, _spread, ["wide", "narrow"], draws=1500, chains=3, walkers=16, seed=7)


@pytest.mark.full
def test_a_gaussian_is_recovered_within_the_sampling_error(gaussian):
    found = summary(gaussian, ["wide", "narrow"])
    deviation = np.sqrt(np.diag(COVARIANCE))
    error = 1 / np.sqrt(found["effective_samples"].values)
    assert (error < 0.03).all()
    assert (abs(found["mean"].values - MEAN) < 4 * error * deviation).all()
    np.testing.assert_allclose(found["standard_deviation"], deviation, rtol=0.05)
    together = np.corrcoef(gaussian["wide"].values.ravel(), gaussian["narrow"].values.ravel())[0, 1]
    assert together == pytest.approx(0.9, abs=0.02)
    np.testing.assert_allclose(found["quantiles"].sel(quantile=0.84), MEAN + 0.994458 * deviation, atol=0.08)


def test_the_same_seed_gives_the_same_draws():
    one, again = (sample(_gaussian, _spread, ["wide", "narrow"], draws=40, chains=2, walkers=8, seed=7) for _ in "12")
    np.testing.assert_array_equal(again["wide"], one["wide"])
    assert not np.array_equal(one["wide"].sel(chain=0), one["wide"].sel(chain=1))


def test_short_chains_are_not_summarised(gaussian):
    with pytest.raises(NumericalError, match="not converged: wide, narrow"):
        summary(gaussian.isel(draw=slice(0, 60)), ["wide", "narrow"])


def test_chains_in_different_places_are_not_summarised(gaussian):
    """Each chain looks settled by itself; only the comparison between them shows that it is not."""
    apart = gaussian.assign(wide=gaussian["wide"] + 0.5 * gaussian["chain"])
    checks = diagnostics(apart, ["wide", "narrow"])
    assert float(checks["autocorrelation_time"][0]) < 30
    assert checks["converged"].values.tolist() == [False, True]
    with pytest.raises(NumericalError, match=r"wide .*R-hat up to 1\.[01]"):
        summary(apart, ["wide", "narrow"])


def test_r_hat_of_independent_draws_and_of_drifting_ones():
    draws = np.random.default_rng(0).normal(size=(4, 8, 500))
    assert r_hat(draws) < 1.001
    drift = np.linspace(0, 1, 500)  # halves around 0.25 and 0.75, each of variance 1 + 0.5^2/12
    assert r_hat(draws + drift) == pytest.approx(np.sqrt(1 + 0.25**2 * 8 / 7 / (1 + 0.25 / 12)), abs=3e-3)
    assert r_hat(np.ones((2, 4, 10))) == 1.0


def test_what_cannot_be_sampled_is_reported():
    with pytest.raises(SceneError, match="even number of walkers, 4"):
        sample(_gaussian, _spread, ["wide", "narrow"], walkers=3)
    for wrong in ({"draws": 1}, {"draws": 10.0}, {"chains": 0}):
        with pytest.raises(SceneError, match=f"{next(iter(wrong))} must be a whole number"):
            sample(_gaussian, _spread, ["wide", "narrow"], **wrong)
    with pytest.raises(ValueError, match="two draws"):
        r_hat(np.ones((2, 4, 1)))
    with pytest.raises(SceneError, match="there is no 'zz' among the samples; there is wide, narrow"):
        summary(sample(_gaussian, _spread, ["wide", "narrow"], draws=2), ["zz"])
    with pytest.raises(NumericalError, match="posterior is zero"):
        sample(lambda positions: np.full(len(positions), -np.inf), _spread, ["wide", "narrow"], draws=10)
