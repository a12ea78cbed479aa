"""Affine bodies where it is hard: collapse to pancakes, spindles and points, strong tides, needles and discs."""

import json
from pathlib import Path

import numpy as np
import pytest

from astroinertia.errors import NumericalError
from tests import affine_scenes
from tests.affine_scenes import semi_axes, started
from tests.evolve import advanced

COLD = [
    entry
    for entry in json.loads((Path(__file__).parent.parent / "reference" / "cold_spheroids.json").read_text())
    if entry["name"] == "cold_spheroid_LMS65"
]
SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
STILL = np.zeros((3, 3))
TIDE = "[effects.tide]\nmass = {mass}\nposition = [{distance}, 0.0, 0.0]\n"
# Changes no digit: whatever is incompressible here shares the program of one with a tide, which compiles long. Without
# tides: tests/physics/test_affine_families.py.
NEXT_TO_NONE = TIDE.format(mass=1e-30, distance=1e6)


def stopped(scene, until=1e3, *settings):
    body = started(scene, *settings)
    with pytest.raises(NumericalError) as caught:
        advanced(body, until)
    assert "\n" not in str(caught.value)
    return body, caught.value


@pytest.mark.full
def test_cold_spheroids_collapse_when_and_how_they_should():
    """Lin, Mestel & Shu 1965: pancakes and spindles, their times to 1e-10 and their sizes to what remains to fall."""
    for entry in COLD:
        given, wanted = entry["inputs"], entry["value"]
        axes = [given["a0"], given["a0"], given["c0"]]
        body, error = stopped(affine_scenes.cold(axes, given["Omega"] * SPIN))
        shape = "spindle" if wanted["kind"].startswith("spindle") else "pancake"
        assert f"collapsed to a {shape}" in error.message
        assert error.time == pytest.approx(float(wanted["t_collapse"]), rel=1e-10)
        assert semi_axes(body)[0] == pytest.approx(float(wanted["other_axis_at_collapse"]), rel=2e-6)


@pytest.mark.full
def test_a_cold_sphere_collapses_to_a_point():
    _, error = stopped(affine_scenes.cold([1.0, 1.0, 1.0], STILL))
    assert "a point" in error.message and error.time == pytest.approx(np.pi / 2 / 2**0.5, rel=1e-10)


@pytest.mark.full
def test_loose_steps_see_the_collapse_too():
    _, error = stopped(affine_scenes.cold([1.0, 1.0, 0.7], STILL), 1e3, "numerics.tolerance=1e-4")
    assert "pancake" in error.message and error.time == pytest.approx(0.88369577131, rel=1e-3)


@pytest.mark.full
def test_pressure_stops_a_pancake_that_is_very_thin():
    """A gas with one part in 1e5 of the pressure of equilibrium bounces, and keeps its energy through it."""
    body = started(affine_scenes.compressible([1.0, 1.0, 0.5], STILL, 5 / 3, 1e-5))
    first, thinnest = body.record(None), 1.0
    for until in np.linspace(0.69, 0.72, 31):
        advanced(body, until)
        thinnest = min(thinnest, semi_axes(body)[2])
    last = body.record(first["potential_energy"])
    assert thinnest < 3e-3
    assert abs(last["total_energy"] - first["total_energy"]) < 1e-11 * last["kinetic_energy"]


@pytest.mark.full
def test_a_strong_tide_tears_the_body_apart():
    tide = TIDE.format(mass=1000.0, distance=20.0)
    body, error = stopped(affine_scenes.incompressible([1.0, 1.0, 1.0], STILL, tide))
    assert error.effect == "tide" and "torn apart" in error.message
    long, middle, short = semi_axes(body)
    assert long > 20.0 and long * middle * short == pytest.approx(1.0, rel=1e-12)


@pytest.mark.full
def test_a_weak_tide_only_raises_a_bulge():
    tide = TIDE.format(mass=1.0, distance=20.0)
    body = started(affine_scenes.incompressible([1.0, 1.0, 1.0], STILL, tide))
    body.advance(50.0)
    # Twice the hydrostatic (5/4) (M'/M) (R/d)^3 (3 cos^2 - 1) at most, in free oscillation about it.
    assert 0.0 <= semi_axes(body)[0] - 1.0 < 2.1 * 2.5 * 20.0**-3


@pytest.mark.full
def test_needles_and_discs_of_axis_ratios_to_a_million():
    for axes, spin, until in (([1.0, 1e-6, 1e-6], 1e3, 2e-4), ([1e3, 1e3, 1e-3], 1e-2, 1e3)):
        tilted = spin * (SPIN + np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.0], [-0.3, 0.0, 0.0]]))
        body = started(affine_scenes.incompressible(axes, tilted, NEXT_TO_NONE))
        first = body.record(None)
        advanced(body, until)
        last = body.record(first["potential_energy"])
        assert np.linalg.norm(last["angular_momentum"] - first["angular_momentum"]) < 1e-11 * np.linalg.norm(
            first["angular_momentum"]
        )
        assert last["total_energy"] == pytest.approx(first["total_energy"], rel=1e-11)
        assert last["ledger_closure"] < 1e-12


def test_the_density_of_a_body_thinner_than_rounding_is_infinite():
    """Of axes 1e-34, 0.5 and 29, turned as random scenes had them: their product is 0 in double precision."""
    body = started(affine_scenes.incompressible([1.0, 1.0, 1.0], STILL))
    body.state = body.state._replace(deformation=np.ones((3, 3)))
    assert body.density_now() == np.inf


def test_a_body_at_rest_in_equilibrium_stays():
    body = started(affine_scenes.incompressible([1.0, 1.0, 1.0], STILL, NEXT_TO_NONE))
    body.advance(100.0)
    np.testing.assert_allclose(np.array(body.state.deformation), np.eye(3), atol=1e-13)
    assert body.steps < 2000
