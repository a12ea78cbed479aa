"""Cores of compressed layers: the limit of stiff matter, what is measured of Mars, Mercury and the Moon, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from astroinertia.bodies.planets import body, own_body
from astroinertia.cli.main import main
from astroinertia.errors import NumericalError, SceneError
from astroinertia.matter.planetary import FORSTERITE, IRON_LIQUID
from astroinertia.studies.compressed_core import compressed_core
from astroinertia.studies.core_inversion import core_inversion

pytestmark = pytest.mark.slow  # the equations of hydrostatic planets are compiled first
MARS = body("Mars")


def _stiffer(factor: float) -> list:
    return [
        replace(each, bulk_modulus=factor * each.bulk_modulus, second_derivative=None)
        for each in (IRON_LIQUID, FORSTERITE)
    ]


@pytest.mark.full
def test_stiff_layers_are_the_exact_inversion_and_the_difference_goes_with_the_compressibility():
    uniform = core_inversion(MARS).core_radius
    assert compressed_core(MARS, 0, *_stiffer(1e12)).core_radius == pytest.approx(uniform, rel=1e-10)
    away = [uniform - compressed_core(MARS, 0, *_stiffer(factor)).core_radius for factor in (50.0, 100.0, 200.0)]
    np.testing.assert_allclose(np.log2(np.array(away[:-1]) / away[1:]), 1.0, atol=0.05)


@pytest.mark.full
def test_the_core_of_mars_agrees_with_seismology_and_nutation():
    found = compressed_core(MARS)
    for published in MARS.published["core_radius"][:2]:  # beneath a solid mantle
        error = np.hypot(found.core_radius_deviation, published.uncertainty)
        assert abs(found.core_radius - published.value) < 1.3 * error
    assert found.core_radius < core_inversion(MARS).core_radius - 50e3
    assert 3300 < found.mantle_reference_density < 3400  # forsterite with some iron
    assert found.core_density == pytest.approx(6000, rel=1e-9)
    assert found.central_density > found.core_density > found.core_reference_density


@pytest.mark.full
def test_the_older_ratio_of_mercury_gives_the_published_core():
    found = compressed_core(body("Mercury"), ratio_row=1)
    assert found.core_radius == pytest.approx(2020e3, abs=30e3)  # Hauck et al. 2013
    assert found.core_density == pytest.approx(6980, abs=280)
    newer = compressed_core(body("Mercury"))
    assert newer.core_density > 7800  # what Genova et al. 2019 take as a sign of a solid inner core


@pytest.mark.full
def test_the_error_of_the_core_is_that_of_draws_where_compression_is_small():
    moon = body("Moon")
    uniform = core_inversion(moon)
    found = compressed_core(moon, 0, *_stiffer(1e9))
    assert found.core_radius == pytest.approx(uniform.core_radius, rel=1e-8)
    spread = (uniform.core_radius_high - uniform.core_radius_low) / 2
    assert found.core_radius_deviation == pytest.approx(spread, rel=0.2)


def test_the_error_of_the_radius_counts():
    """Of a body whose ratio and density are exact, against uniform layers of the same mass and moment."""
    exact = {"mean_moment_ratio": 0.3661, "core_density": 6000.0}
    one = own_body("mine", 6.417e23, 3.3895e6, mean_radius_uncertainty=5e3, **exact)
    uniform, found = core_inversion(one), compressed_core(one, 0, *_stiffer(1e9))
    spread = (uniform.core_radius_high - uniform.core_radius_low) / 2
    assert found.core_radius_deviation == pytest.approx(spread, rel=0.05)  # it was 0


def test_bodies_without_assumptions_are_reported():
    with pytest.raises(SceneError, match="nothing is assumed for the layers of Jupiter"):
        compressed_core(body("Jupiter"))


@pytest.mark.full
def test_matter_that_is_too_soft_for_any_core_is_refused():
    soft = [replace(each, bulk_modulus=1e9) for each in (IRON_LIQUID, FORSTERITE)]
    with pytest.raises(NumericalError):
        compressed_core(MARS, 0, *soft)


@pytest.mark.full
def test_what_the_layers_are_taken_for_is_what_is_printed(capsys):
    planet = ["--mass", "3.22497e24 kg", "--radius", "5102.48 km", "--moment-ratio", "0.34", "--core-density", "9500"]
    assert main(["ratios", *planet, "--crust-thickness", "60", "--crust-density", "2900", "--compressed"]) == 0
    printed = capsys.readouterr().out
    assert "mantle density       4360" in printed and "mantle density       4647" in printed  # below and above 4500
    assert "bulk moduli of liquid iron and of forsterite" in printed


@pytest.mark.full
def test_the_command_shows_it_when_asked(capsys):
    assert main(["ratios", "--body", "Mars", "--compressed"]) == 0
    assert "core radius          1917 +- 66 km" in capsys.readouterr().out
    assert main(["ratios", "--compressed"]) == 2
    assert "--compressed is for one body" in capsys.readouterr().err
