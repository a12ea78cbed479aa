"""Inversions: exact reference values, round trips over the whole range, errors against sampling, and refusals."""

import json
import math
from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia.bodies.clairaut import love_number
from astroinertia.bodies.inversion import inverted, three_layer_family, two_layers, two_layers_with_errors
from astroinertia.bodies.layered import constant_layers

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "layered.json").read_text())
EXACT = [entry for entry in REFERENCE if entry["name"] == "inverse_two_layer"]
GIVEN = ("mantle_density", "core_density", "core_radius_ratio")


@pytest.mark.parametrize("entry", EXACT, ids=lambda entry: str(entry["inputs"]["rho_mean"]))
def test_reference_inversions(entry):
    inputs, value = ({key: float(number) for key, number in entry[part].items()} for part in ("inputs", "value"))
    for given in ({"mantle_density": inputs["rho_mantle"]}, {"core_density": value["rho_core"]},
                  {"core_radius_ratio": value["rc_over_R"]}):  # fmt: skip
        found = two_layers(inputs["rho_mean"], inputs["k"], **given)
        assert found.core_radius_ratio == pytest.approx(value["rc_over_R"], rel=1e-13)
        assert found.core_density == pytest.approx(value["rho_core"], rel=1e-12)
        assert found.mantle_density == pytest.approx(inputs["rho_mantle"], rel=1e-12)


@pytest.mark.parametrize("core", [0.02, 0.3, 0.7, 0.99])
@pytest.mark.parametrize("densities", [(9000.0, 3000.0), (2000.0, 3500.0), (5e6, 1.0)])
def test_every_body_is_found_again_from_each_of_its_numbers(core, densities):
    body = constant_layers([core, 1.0], densities)
    mean, ratio = float(body.mass) / (4 / 3 * np.pi), float(body.moment_ratio)
    condition = 1e-15 / abs(1 - ratio / 0.4)  # how well a moment ratio next to 0.4 can tell anything
    for given in ({"mantle_density": densities[1]}, {"core_density": densities[0]}, {"core_radius_ratio": core}):
        found = two_layers(mean, ratio, **given)
        tolerance = max(1e-11, 1e3 * condition)
        assert found.core_radius_ratio == pytest.approx(core, rel=tolerance)
        again = found.body(2.0, 3.0)
        assert again.moment_ratio == pytest.approx(ratio, rel=1e-12)
        assert again.mass == pytest.approx(8 * float(body.mass), rel=1e-12)
        share = densities[0] * core**3 / mean
        assert found.core_mass_fraction == pytest.approx(share, rel=tolerance)


@pytest.mark.parametrize("name", GIVEN)
def test_arrays_of_numpy_have_the_bodies_of_jax_one_by_one(name):
    """Newton's method runs until nothing changes in the one, and in a fixed number of steps in the other."""
    mean, ratio = np.full(200, 5515.0), np.linspace(0.25, 0.399, 200)
    assumed = {"mantle_density": 2000.0, "core_density": 12000.0, "core_radius_ratio": 0.5}[name]
    with jax.enable_x64(True), np.errstate(all="ignore"):
        batch = inverted(np, mean, ratio, np.full(200, assumed), name)
        single = jax.vmap(lambda s, k: inverted(jax.numpy, s, k, assumed, name))(mean, ratio)
    for ours, theirs in zip(jax.tree.leaves(batch), jax.tree.leaves(single), strict=True):
        np.testing.assert_allclose(ours, np.broadcast_to(theirs, ours.shape), rtol=1e-12)
    assert np.isfinite(batch.core_radius_ratio).sum() > 100


@pytest.mark.full
@pytest.mark.parametrize("name", GIVEN)
def test_errors_are_those_of_a_sample(name):
    truth = two_layers(5515.0, 0.3307, mantle_density=4400.0)
    measured = np.array([5515.0, 0.3307, float(getattr(truth, name))])
    errors = measured * np.array([1e-4, 2e-4, 3e-4])
    fit = two_layers_with_errors(*measured[:2], errors, **{name: measured[2]})
    draws = measured + errors * np.random.default_rng(1).normal(size=(20000, 3))
    with jax.enable_x64(True):
        sample = jax.vmap(lambda one: two_layers(one[0], one[1], **{name: one[2]}))(draws)
    columns = np.stack([np.asarray(each) for each in jax.tree.leaves(sample)])
    for spread, error in zip(columns.std(axis=1), jax.tree.leaves(fit.standard_errors), strict=True):
        assert error == pytest.approx(spread, rel=0.03)
    both = two_layers_with_errors(*measured[:2], np.diag(errors**2), **{name: measured[2]})
    np.testing.assert_allclose(both.covariance, fit.covariance, rtol=1e-12)


@pytest.mark.parametrize(
    ("mean", "ratio", "given", "message"),
    [
        (
            5515,
            0.33,
            {"mantle_density": 6000},
            "below 0.4, 0.33, the mantle is lighter than the mean density 5515, and",
        ),
        (5515, 0.33, {"mantle_density": 5000}, "even a point core leaves a moment ratio of 0.36"),
        (5515, 0.33, {"core_density": 5000}, "the core is denser than the mean density 5515, and core density 5000 is"),
        (5515, 0.33, {"core_density": 6000}, "no mantle at all the moment ratio is 0.378"),
        (5515, 0.45, {"core_density": 9000}, "above 0.4, 0.45, the core is lighter than"),
        (5515, 0.01, {"core_radius_ratio": 0.9}, "mantle would need a negative density"),
        (5515, 0.6, {"core_radius_ratio": 0.3}, "core would need a negative density"),
        (5515, 0.7, {"core_density": 9000}, "between 0 and 2/3"),
        (5515, 0.4, {"core_density": 9000}, "homogeneous"),
        (5515, 0.33, {"core_density": 5515}, "homogeneous"),
        (5515, 0.33, {"core_radius_ratio": 1.0}, "between 0 and 1"),
        (5515, 0.33, {"core_density": -1.0}, "density must be positive"),
        (-1, 0.33, {"core_density": 9000}, "mean density must be positive"),
        (5515, float("nan"), {"core_density": 9000}, "between 0 and 2/3"),
        (5515, 0.33, {}, "exactly one of"),
        (5515, 0.33, {"core_density": 9000, "mantle_density": 3000}, "exactly one of"),
    ],
)
def test_bodies_that_do_not_exist_are_refused_with_the_reason(mean, ratio, given, message):
    with pytest.raises(ValueError, match=message):
        two_layers(mean, ratio, **given)


@pytest.mark.parametrize("name", GIVEN)
def test_a_family_of_three_layers_fits_all_along_and_contains_its_parent(name):
    parent = constant_layers([0.45, 0.93, 1.0], [7000.0, 3400.0, 1000.0])
    mean, ratio = float(parent.mass) / (4 / 3 * np.pi), float(parent.moment_ratio)
    given = {"mantle_density": 3400.0, "core_density": 7000.0, "core_radius_ratio": 0.45}[name]
    boundaries = np.array([0.5, 0.9, 0.93, 0.95, 0.99])
    family = three_layer_family(mean, ratio, 1000.0, boundaries, **{name: given})
    assert family.core_radius_ratio[2] == pytest.approx(0.45, rel=1e-11)
    assert family.core_density[2] == pytest.approx(7000, rel=1e-10)
    assert family.mantle_density[2] == pytest.approx(3400, rel=1e-11)
    exists = np.isfinite(family.core_radius_ratio)
    assert exists[2] and exists.sum() >= 2
    for k in np.flatnonzero(exists):
        one = jax.tree.map(lambda each, k=k: float(each[k]), family)
        radii = [one.core_radius_ratio, one.shell_boundary_ratio, 1.0]
        body = constant_layers(radii, [one.core_density, one.mantle_density, one.shell_density])
        assert body.moment_ratio == pytest.approx(ratio, rel=1e-12)
        assert body.mass == pytest.approx(float(parent.mass), rel=1e-12)
    with pytest.raises(ValueError, match="no body of three layers"):
        three_layer_family(mean, 0.01, 1000.0, boundaries, **{name: given})


@pytest.mark.full
def test_an_inversion_is_differentiable_through_to_the_love_number():
    with jax.enable_x64(True):

        def love(ratio):
            return love_number(two_layers(5515.0, ratio, mantle_density=4400.0).body())

        slope, step = float(jax.grad(love)(0.3307)), 1e-5
        difference = float(love(0.3307 + step) - love(0.3307 - step)) / (2 * step)
    assert slope == pytest.approx(difference, rel=1e-6)


def test_errors_of_no_number_are_named():
    for errors in ([1.0, math.nan, 50.0], np.full((3, 3), math.inf)):
        with pytest.raises(ValueError, match="errors of two_layers_with_errors must be finite, not"):
            two_layers_with_errors(3933.0, 0.3637, errors, mantle_density=3500.0)
