"""Flattening by rotation: sequences against exact spheroids and limits, planets against hydrostatic models."""

import numpy as np
import pytest

from astroinertia.bodies import maclaurin
from astroinertia.errors import SceneError
from astroinertia.studies.flattening import flattening, flattening_sequence


def test_uniform_bodies_are_maclaurin_spheroids():
    rates = [0.0, 1e-9, 0.01, 0.1, 0.3]
    found = flattening_sequence(rates, index=0)
    for k in (2, 3, 4):
        exact = maclaurin.from_angular_velocity(np.sqrt(rates[k]))
        assert float(found["flattening"][k]) == pytest.approx(exact.flattening, rel=1e-12)
        assert float(found["zonal_harmonic_2"][k]) == pytest.approx(exact.eccentricity**2 / 5, rel=1e-12)
    np.testing.assert_allclose(found["polar_moment_ratio_equatorial"], 0.4)
    assert float(found["flattening"][0]) == 0.0
    assert float(found["flattening"][1]) == pytest.approx(1.25e-9, rel=1e-8)
    q = found["rotation_parameter"] * (1 - found["flattening"])
    np.testing.assert_allclose(q, found["small_m"], rtol=1e-12)  # q = m (a/R)^3 and (a/R)^3 = a/c


def test_spins_beyond_the_fastest_are_nan_and_just_below_are_not():
    limit = 0.75 * maclaurin.fastest().omega2
    found = flattening_sequence([limit * (1 - 1e-9), limit * (1 + 1e-9), 2.0], index=0)
    assert np.isfinite(found["flattening"]).values.tolist() == [True, False, False]


def test_layers_tend_to_clairaut_with_an_error_of_second_order():
    rates = np.array([0.004, 0.008, 0.016])
    found = flattening_sequence(rates, outer_radii=[0.5, 1.0], densities=[2.0, 1.0])
    assert found.attrs["love_number"] == pytest.approx(1.20531088082902, rel=1e-13)
    for name in ("flattening", "zonal_harmonic_2"):
        error = abs(found[name] / found[f"{name}_first_order"] - 1).values
        np.testing.assert_allclose(np.log2(error[1:] / error[:-1]), 1.0, atol=0.05)  # relative: first order


def test_layers_of_one_density_are_a_spheroid():
    layers = flattening_sequence([0.1], outer_radii=[0.4, 1.0], densities=[1.0, 1.0])
    uniform = flattening_sequence([0.1], index=0)
    for name in ("flattening", "zonal_harmonic_2", "rotational_to_gravitational"):
        assert float(layers[name][0]) == pytest.approx(float(uniform[name][0]), rel=1e-9)


def test_more_condensed_bodies_are_flattened_less():
    flat = [float(flattening_sequence([0.05], index=index)["flattening"][0]) for index in (0.0, 0.5, 1.0)]
    assert flat[0] > flat[1] > flat[2] > 0.05 / 2  # a point mass has m/2


@pytest.mark.slow
def test_earth_mars_and_jupiter_against_hydrostatic_figures():
    found = flattening(["Earth", "Mars", "Jupiter"])
    earth = found.sel(body="Earth")
    assert 1 / float(earth["flattening_layers"]) == pytest.approx(299.8, abs=0.6)  # two layers for PREM
    assert float(earth["flattening_excess"]) == pytest.approx(0.005, abs=0.003)  # measured 1/298.26
    assert float(found["flattening_excess"].sel(body="Mars")) == pytest.approx(0.18, abs=0.02)  # Tharsis
    assert abs(float(found["flattening_excess"].sel(body="Jupiter"))) < 0.01
    assert abs(float(found["zonal_harmonic_2_excess"].sel(body="Jupiter"))) < 0.02
    assert (found["flattening_uniform"] > found["flattening_measured"]).sel(body=["Earth", "Jupiter"]).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"small_m": [-0.1], "index": 0}, "not negative"),
        ({"small_m": [], "index": 0}, "finite"),
        ({"small_m": [0.1]}, "either a polytrope"),
        ({"small_m": [0.1], "index": 1.0, "outer_radii": [1.0], "densities": [1.0]}, "either a polytrope"),
        ({"small_m": [0.1], "outer_radii": [1.0]}, "either a polytrope"),
        ({"small_m": [0.1], "index": 6.0}, "index"),
        ({"small_m": [0.1], "outer_radii": [0.5, 1.0], "densities": [1.0]}, "density"),
    ],
)
def test_what_is_no_rotating_body_is_reported(arguments, words):
    with pytest.raises(SceneError, match=words):
        flattening_sequence(**arguments)


def test_moons_with_tides_are_refused():
    with pytest.raises(SceneError, match="synchronous by tides"):
        flattening(["titan"])
    with pytest.raises(SceneError, match="no body 'Pluto'"):
        flattening(["Pluto"])
