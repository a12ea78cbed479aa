"""The scenes of precession, wobble and tumbling do what their heads say."""

from pathlib import Path

import numpy as np
import pytest

import astroinertia
from astroinertia.rotation.harmonic_fit import harmonic_fit
from astroinertia.rotation.precession import ARCSECOND, ARCSECOND_PER_YEAR
from astroinertia.rotation.tumbling import divergence
from astroinertia.scene import load
from astroinertia.studies import turning_planets

SIMS = Path(__file__).parents[2] / "sims"
DAY = 86400.0


def ran(name, tmp_path, *settings):
    scene = load.load_file(SIMS / f"{name}.toml", settings)
    return astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))


def directions(dataset):
    momentum = dataset["angular_momentum"].transpose("time", "i").values
    return dataset["time"].values, momentum / np.linalg.norm(momentum, axis=1, keepdims=True)


def rates_in_the_body(dataset):
    attitude, rates = dataset["attitude"].values, dataset["angular_velocity"].transpose("time", "i").values
    return np.einsum("tki,ti->tk", attitude, rates)


def nodding(dataset, planet):
    """What longitude and obliquity are made of, with time from the middle, and the longitude's unsteady part."""
    times, axes = directions(dataset)
    middle = times - times[-1] / 2
    phases = planet.phases + planet.frequencies * times[-1] / 2
    longitude = np.pi / 2 - np.unwrap(np.arctan2(axes[:, 1], axes[:, 0]))
    fits = [harmonic_fit(middle, angle, planet.frequencies, phases) for angle in (longitude, np.arccos(axes[:, 2]))]
    return *fits, longitude - fits[0].steady(middle)


@pytest.mark.full
def test_mars_goes_back(tmp_path):
    found, _, unsteady = nodding(ran("mars_precession", tmp_path), turning_planets.mars())
    assert found.rate / ARCSECOND_PER_YEAR == pytest.approx(7.604, abs=0.001)
    assert np.abs(unsteady).max() / ARCSECOND == pytest.approx(1.77, abs=0.02)


@pytest.mark.full
def test_the_earth_goes_back_and_tilts_the_moons_orbit(tmp_path):
    """Its flattening takes 0.2694 arc seconds a century off the rate: Williams 1994, AJ 108, 711. Measured: 0.268."""
    alone, coupled = (
        nodding(ran("earth_precession", tmp_path / each, f"orbits.back_reaction={each}"), turning_planets.earth())
        for each in ("false", "true")
    )
    assert alone[0].rate / ARCSECOND_PER_YEAR == pytest.approx(50.406, abs=0.001)
    assert -alone[0].sine[0] / ARCSECOND == pytest.approx(17.284, abs=0.01)
    assert alone[1].cosine[0] / ARCSECOND == pytest.approx(9.229, abs=0.01)
    change = 100 * (coupled[0].rate - alone[0].rate) / ARCSECOND_PER_YEAR
    assert change == pytest.approx(-0.26943, rel=0.03)


@pytest.mark.parametrize(
    ("love_number", "days"),
    [
        pytest.param(0.298, 445.39, marks=pytest.mark.full(inputs=["sims/chandler_wobble.toml"])),
        (1e-9, 303.62),
    ],
)
def test_the_pole_wobbles(love_number, days, tmp_path):
    settings = (f"effects.rotational_deformation.love_number={love_number}", "time.end=250 d")
    dataset = ran("chandler_wobble", tmp_path, *settings)
    rates = rates_in_the_body(dataset)
    pole = (rates[:, 0] + 1j * rates[:, 1]) / rates[:, 2]
    np.testing.assert_allclose(np.abs(pole) / ARCSECOND, 0.2, atol=1e-6)  # in a circle
    turning = np.polyfit(dataset["time"].values, np.unwrap(np.angle(pole)), 1)[0]
    assert 2 * np.pi / turning / DAY == pytest.approx(days, abs=0.01)


@pytest.mark.full
def test_hyperion_tumbles(tmp_path):
    scene = load.load_file(SIMS / "hyperion.toml")
    dataset = ran("hyperion", tmp_path)
    rates, period = rates_in_the_body(dataset), scene.companions[0].period
    spin = np.linalg.norm(rates, axis=1) * period / (2 * np.pi)
    assert (spin.min(), spin.max()) == pytest.approx((3.31, 4.50), abs=0.02)
    _, directed = directions(dataset)
    assert np.degrees(np.arccos(directed @ directed[0])).max() == pytest.approx(129, abs=2)
    about = np.unwrap(np.arctan2(rates[:, 2], rates[:, 1]))[:110]
    assert 2 * np.pi / abs(np.polyfit(dataset["time"].values[:110], about, 1)[0]) / DAY == pytest.approx(16.9, abs=0.3)
    # The same motion by other equations, and what of it is left for how long.
    body, orbit = scene.body, scene.companions[0]
    motion = 2 * np.pi / period
    along = np.array(body.rotation.axis) * body.rotation.rate
    other = divergence(body.moment_ratios, orbit.eccentricity, body.axes_at_start, along, motion, orbits=2)
    at = np.interp(2 * period, dataset["time"].values, np.linalg.norm(rates, axis=1))
    assert np.linalg.norm(other.angular_velocity) == pytest.approx(at, rel=3e-3)
    longer = divergence(body.moment_ratios, orbit.eccentricity, body.axes_at_start, along, motion, orbits=200)
    assert longer.lyapunov_time / DAY == pytest.approx(68.0, rel=0.3)
