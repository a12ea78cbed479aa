"""What uniform layers leave out of a core: against the full equations, and against cores that are known."""

import math

import numpy as np
import pytest

from astroinertia.bodies.planets import body, own_body
from astroinertia.errors import SceneError
from astroinertia.studies.compressed_core import compressed_core
from astroinertia.studies.core_inversion import core_inversion
from astroinertia.studies.core_model_error import core_model_error, matter_as_dense, model_error_of
from astroinertia.studies.moment_ratio import moment_ratio
from astroinertia.studies.two_layers import two_layers


@pytest.mark.full
@pytest.mark.parametrize("name", ["Earth", "Titan", "Mars", "Mercury"])
def test_the_share_of_compression_is_that_of_the_full_equations(name):
    """Hydrostatic planets by collocation, with their own search for three unknowns, share nothing with the estimate."""
    one = body(name)
    change = compressed_core(one).core_radius - core_inversion(one).core_radius
    assert model_error_of(one).compression == pytest.approx(change, rel=0.01, abs=100.0)


@pytest.mark.parametrize(("name", "row"), [("Earth", 0), ("Mars", 0), ("Moon", 0), ("Mercury", 0), ("Mercury", 1)])
def test_the_errors_cover_the_cores_that_are_known(name, row):
    """Twice the errors of inputs and publication, with the model's beyond them, reach the published radius."""
    one = body(name)
    core, beyond, published = core_inversion(one, row), model_error_of(one, row), one.adopted("core_radius")
    error = math.hypot((core.core_radius_high - core.core_radius_low) / 2, np.nan_to_num(published.uncertainty))
    low, high = sorted((core.core_radius, core.core_radius + beyond.both))
    assert low - 2 * error <= published.value <= high + 2 * error


def test_the_error_of_the_inputs_alone_covers_neither_the_earth_nor_mars():
    """What made the figure necessary; and the estimate is no larger than what it is of."""
    for name, share in (("Earth", 0.98), ("Mars", 1.08)):
        one = body(name)
        core, off = core_inversion(one), one.adopted("core_radius").value - core_inversion(one).core_radius
        assert abs(off) > 2 * (core.core_radius - core.core_radius_low)
        assert model_error_of(one).both / off == pytest.approx(share, abs=0.01)


def test_a_step_in_the_mantle_is_one_of_three_layers():
    """The body with the step has the mass and moment, by sums over three uniform layers."""
    mean, ratio, core_density = 5513.0, 0.33071, 10990.0
    core = float(two_layers(mean, moment_ratio=ratio, core_density=core_density).core_radius_ratio)
    core += core_model_error(mean, 1.0, ratio, core_density=core_density).third_layer
    middle = (core + 1) / 2
    volumes = np.diff([0.0, core**3, middle**3, 1.0])
    upper = (mean - core_density * volumes[0]) / (1.1 * volumes[1] + volumes[2])
    density = np.array([core_density, 1.1 * upper, upper])
    moment = 0.4 * density @ np.diff([0.0, core**5, middle**5, 1.0]) / mean
    assert moment == pytest.approx(ratio, rel=1e-5)


def test_a_small_body_is_not_compressed_and_an_impossible_one_has_no_error():
    small = core_model_error(3500.0, 1e3, 0.35, mantle_density=3000.0)
    assert abs(small.compression) < 1e-3
    assert np.isnan(core_model_error(3500.0, 1e6, 0.39, core_density=3000.0).both)
    assert model_error_of(body("Moon")).third_layer == pytest.approx(-core_inversion(body("Moon")).core_radius)
    assert [matter_as_dense(density)[0] for density in (8000.0, 3300.0, 1000.0)] == [
        "liquid iron", "forsterite", "ice VII",
    ]  # fmt: skip


def test_a_planet_of_ones_own_is_like_one_of_the_table():
    earth = body("Earth")
    ratio = earth.moment_ratio()
    own = own_body(
        "own", earth.mass, earth.mean_radius, mean_moment_ratio=ratio.value,
        mean_moment_ratio_uncertainty=ratio.uncertainty, core_density=10990.0, core_density_uncertainty=100.0,
        mean_radius_uncertainty=earth.adopted("mean_radius").uncertainty,
    )  # fmt: skip
    assert core_inversion(own) == core_inversion(earth)
    assert model_error_of(own).both == pytest.approx(model_error_of(earth).both)
    table = moment_ratio([own, "Mars"])
    assert list(table["body"].values) == ["own", "Mars"]
    assert float(table["core_radius_model_error"][0]) == pytest.approx(-321e3, abs=1e3)
    assert np.isnan(float(table["angular_velocity"][0]))
    assert np.isnan(float(moment_ratio([own_body("bare", 1e24, 4e6)])["moment_ratio"][0]))
    with pytest.raises(SceneError, match="nothing is assumed"):
        compressed_core(own_body("bare", 1e24, 4e6, mean_moment_ratio=0.35))
