"""Posterior samples in ArviZ's layout: the draws keep their chains, and what was given is there as numbers."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.errors import SceneError
from astroinertia.interop.arviz import arviz_tree
from astroinertia.studies.interior_inference import Gaussian, Uniform, infer_interior
from astroinertia.studies.sampling import sample

pytest.importorskip("emcee")

OBSERVED = {"mean_density": Gaussian(4000.0, 1.0), "love_number": Gaussian(1.2, 0.01)}


@pytest.fixture(scope="module")
def posterior() -> xr.Dataset:
    assumed = {"core_density": Uniform(7000.0, 9000.0)}
    return infer_interior(OBSERVED, assumed, small_m=0.003, draws=60, chains=2, walkers=8, seed=3)


@pytest.mark.full
def test_each_walker_is_a_chain_with_its_own_draws(posterior):
    tree = arviz_tree(posterior)
    assert list(tree) == ["posterior", "sample_stats", "observed_data", "constant_data"]
    draws, stats = tree["posterior"], tree["sample_stats"]
    assert dict(draws.sizes) == dict(stats.sizes) == {"chain": 16, "draw": 60}
    for k in (0, 7, 8, 13):
        place = {"chain": int(draws["ensemble"][k]), "walker": int(draws["walker"][k])}
        assert place == {"chain": k // 8, "walker": k % 8}
        for name in ("core_density", "moment_ratio", "love_number"):
            np.testing.assert_array_equal(draws[name][k], posterior[name].sel(place))
        np.testing.assert_array_equal(stats["lp"][k], posterior["log_probability"].sel(place))
        assert float(stats["acceptance_rate"][k]) == float(posterior["acceptance"].sel(place))
    assert set(draws.data_vars) == set(posterior.data_vars) - {"log_probability", "acceptance"}
    assert all(draws[name].dims == ("chain", "draw") for name in draws.data_vars)


@pytest.mark.parametrize("dim", ["chain", "walker", "draw"])
def test_a_dimension_that_was_selected_away_is_named(dim, posterior):
    with pytest.raises(SceneError, match=f"the draws are not along '{dim}'"):
        arviz_tree(posterior.isel({dim: 0}))
    assert set(arviz_tree(posterior.isel({dim: [0]}))) == set(arviz_tree(posterior))


def test_what_was_observed_and_assumed_is_there_as_numbers(posterior):
    tree = arviz_tree(posterior)
    observed, constants = tree["observed_data"], tree["constant_data"]
    assert {name: float(each) for name, each in observed.data_vars.items()} == {
        name: gaussian.mean for name, gaussian in OBSERVED.items()
    }
    assert {name: float(each) for name, each in constants.data_vars.items()} == {
        "mean_density_observed_deviation": 1.0,
        "love_number_observed_deviation": 0.01,
        "moment_ratio_prior_low": 0.0,
        "moment_ratio_prior_high": 0.4,
        "core_density_prior_low": 7000.0,
        "core_density_prior_high": 9000.0,
        "small_m": 0.003,
    }
    assert constants["core_density_prior_low"].attrs["units"] == observed["mean_density"].attrs["units"] == "kg m-3"
    for group in tree.values():
        assert group.attrs["inference_library"] == "emcee"
        assert group.attrs["creation_library"] == "astroinertia"
        assert group.attrs["created_at"].endswith("+00:00")


def test_a_written_tree_reads_back_alike(posterior, tmp_path):
    tree = arviz_tree(posterior)
    tree.to_netcdf(tmp_path / "posterior.nc")
    with xr.open_datatree(tmp_path / "posterior.nc", engine="netcdf4") as again:
        assert list(again) == list(tree)
        for name in tree:
            xr.testing.assert_identical(again[name].to_dataset().drop_attrs(), tree[name].to_dataset().drop_attrs())


def test_draws_without_data_have_no_groups_of_data():
    draws = sample(
        lambda at: -0.5 * (at**2).sum(-1), lambda generator, n: generator.normal(size=(n, 2)), ["a", "b"], 20, 2, 8
    )
    assert list(arviz_tree(draws)) == ["posterior", "sample_stats"]


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_arviz_summarises_it(posterior):
    """Means and deviations are ours; the effective sample size counts the walkers as chains."""
    arviz = pytest.importorskip("arviz")
    tree = arviz_tree(posterior)
    data = arviz.InferenceData.from_datatree(tree) if hasattr(arviz, "InferenceData") else tree
    found = arviz.summary(data, round_to="none")
    for name in ("core_density", "moment_ratio", "love_number"):
        assert float(found.loc[name, "mean"]) == pytest.approx(float(posterior[name].mean()), rel=1e-6)
        assert float(found.loc[name, "sd"]) == pytest.approx(float(posterior[name].std()), rel=1e-2)
        assert 1 < float(found.loc[name, "ess_bulk"]) < posterior[name].size
