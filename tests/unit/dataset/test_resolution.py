"""Resolution: what is recorded of it, what is warned of, and what the plan says beforehand."""

import math

import numpy as np
import pytest

from astroinertia import dataset, plots
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.cli.main import main
from astroinertia.dataset.bounds import message
from astroinertia.dataset.resolution import resolution_warnings
from astroinertia.models.sph.resolution import jeans_mass, resolution
from astroinertia.run.loop import run_scene
from astroinertia.scene import load
from astroinertia.scene.plan import plan, smoothing
from astroinertia.scene.resolution import core_share

SCENE = """
name = "coarse"
units = "code"
[body]
kind = "polytrope"
index = 3.0
particles = 100
mass = 1.0
radius = 1.0
relax = false
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 0.02
[output]
series_every = 0.01
"""


def test_the_jeans_mass_is_that_of_a_uniform_cloud_that_its_pressure_cannot_hold():
    """3/2 M c^2 = 3/5 G M^2/(2 R) there: thermal energy is half of the gravitational one (Bate & Burkert's eq. 1)."""
    density, speed2 = 0.7, 0.3
    mass = float(jeans_mass(np.array(speed2), np.array(density)))
    radius = (3 * mass / (4 * np.pi * density)) ** (1 / 3)
    assert 1.5 * mass * speed2 == pytest.approx(0.6 * mass**2 / radius, rel=1e-12)


def test_what_is_recorded():
    mass, density = np.full(100, 0.01), np.concatenate([np.full(30, 5.0), np.full(20, 0.6), np.full(50, 0.4)])
    found = resolution(mass, density, 0.2 * density, np.full(100, 0.1), np.diag([1.0, 1.0, 0.05]), 10.0)
    assert found["core_particles"] == 50
    assert found["jeans_ratio"] == pytest.approx(float(jeans_mass(np.array(0.2), np.array(5.0))) / (20 * 0.01))
    assert found["smoothing_to_thickness"] == pytest.approx(0.1 / (5 * 0.05) ** 0.5)
    cold = resolution(mass, density, None, np.full(100, 0.1), np.diag([1.0, 1.0, 0.0]), 10.0)
    assert np.isnan(cold["jeans_ratio"]) and np.isnan(cold["smoothing_to_thickness"])


def test_a_surface_without_pressure_that_is_as_dense_as_the_rest_is_no_fragment():
    density, pressure = 1.0 + 0.01 * np.random.default_rng(2).uniform(size=400), np.full(400, 0.2)
    pressure[::4] = 1e-9
    found = resolution(np.full(400, 0.0025), density, pressure, np.full(400, 0.1), np.eye(3), 20.0)["jeans_ratio"]
    assert found == pytest.approx(float(jeans_mass(np.array(0.2), np.array(1.0))) / (40 * 0.0025), rel=0.03)


def test_each_warning_comes_where_it_should_and_says_what_to_change():
    fine = {
        "core_particles": np.full(3, 500.0),
        "jeans_ratio": np.full(3, 4.0),
        "smoothing_to_thickness": np.full(3, 0.1),
    }
    assert resolution_warnings(fine, 58.0) == []
    assert resolution_warnings(fine, None) == [] and resolution_warnings({}, 58.0) == []
    for name, value, words in (
        ("core_particles", 20.0, ("only 20 particles", "(116)", "take about 6 times as many.")),
        ("jeans_ratio", 0.3, ("Jeans mass", "0.3", "take about 4 times as many particles")),
        ("jeans_ratio", 1.91846e-6, ("Jeans mass", "take about 530000 times as many particles")),
        ("jeans_ratio", 1e-3 / 1.005, ("Jeans mass", "take about 1100 times as many particles")),
        ("smoothing_to_thickness", 1.0, ("thickness is not", "take about 8 times as many particles")),
    ):
        (sentence,) = resolution_warnings({**fine, name: np.array([fine[name][0], value, fine[name][0]])}, 58.0)
        assert all(word in sentence for word in words) and sentence.endswith(".")


def test_the_jeans_mass_is_warned_of_only_where_a_body_can_fragment():
    """Half of a star in equilibrium, of any index, has a Jeans mass of a third of its mass: few particles or not."""
    fine = {name: np.array([1000.0]) for name in ("core_particles", "jeans_ratio")} | {
        "smoothing_to_thickness": np.array([0.1])
    }
    for index in (0.5, 1.5, 3.0, 4.5):
        star = Polytrope(index)
        radii = np.array([star.radius_enclosing(share) for share in np.linspace(0.01, 0.5, 20)])
        density = np.array([float(star.density(radius)) for radius in radii])
        pressure = np.array([float(star.pressure(radius)) for radius in radii])
        for particles in (50, 200):  # of a star of unit mass
            ratio = float(jeans_mass(pressure / density, density).min()) / (2.0 * 58.0 / particles)
            assert ratio < 1.0  # of no use by itself
            assert resolution_warnings({**fine, "jeans_ratio": np.array([ratio])}, 58.0, particles) == []
    cloud = {**fine, "jeans_ratio": np.array([0.3])}  # 35 particles, of 1000
    (sentence,) = resolution_warnings(cloud, 58.0, 1000)
    assert "Jeans mass fell to 0.3" in sentence


@pytest.mark.slow
def test_a_run_keeps_its_warnings_and_tells_them(tmp_path, capsys):
    """A central core of an n = 3 polytrope of 100 particles is coarse; run and what show prints say so."""
    scene = tmp_path / "coarse.toml"
    scene.write_text(SCENE)
    assert main(["run", str(scene), "--output", str(tmp_path / "run")]) == 0
    assert "warning: the core" in capsys.readouterr().out
    data = dataset.open(tmp_path / "run")
    assert "held only" in data.attrs["resolution_warnings"] and data.attrs["body_particles"] == "[100]"
    assert (data["jeans_ratio"] < 1.0).all() and "Jeans" not in data.attrs["resolution_warnings"]
    assert message(data.attrs, "resolution").startswith("warning: ")
    assert (data["core_particles"] > 16).all() and (data["core_particles"] < 147).all()
    assert "warning: the core" in plots.summary(data)


@pytest.mark.slow
def test_a_fine_run_is_not_warned_of(tmp_path):
    text = SCENE.replace("index = 3.0", "index = 1.0").replace("particles = 100", "particles = 800")
    data = dataset.open(run_scene(load.loads(text), tmp_path / "run"))
    assert "resolution_warnings" not in data.attrs and message(data.attrs, "resolution") == ""


def test_the_plan_counts_the_core_and_warns():
    star = Polytrope(3.0)
    scene = load.loads(SCENE)
    share = core_share(scene.body)
    assert star.density(star.radius_enclosing(share)) == pytest.approx(0.1 * star.central_density, rel=1e-6)
    text = plan(scene).text()
    assert f"core: {100 * share:.0f} particles" in text
    fewest = 2.0 * smoothing(scene)[1]
    assert f"take about {math.ceil(fewest / (100 * share))} times as many particles" in text
    many = plan(load.loads(SCENE, ["body.particles=30000"])).text()
    assert "WARNING" not in many


def test_the_plan_tells_how_dense_an_isothermal_cloud_may_become():
    text = SCENE.replace('kind = "ideal"', 'kind = "isothermal"\nsound_speed = 0.4')
    text = text.replace('kind = "polytrope"\nindex = 3.0', 'kind = "uniform"')
    scene = load.loads(text, ["body.particles=20000"])
    unit = 2 * smoothing(scene)[1] / 20000  # the mass of two neighbourhoods
    highest = (
        2.5 * 0.4**2
    ) ** 3 / unit**2  # M_J^2 = (5 c^2/2 G)^3 / (4 pi rho/3), and 4 pi rho/3 is 1 at the mean density
    assert f"resolved up to {highest:.2g} times the mean density" in plan(scene).text()
    cold = plan(load.loads(text, ["body.particles=100", "equation_of_state.sound_speed=0.1"])).text()
    assert "WARNING" in cold


@pytest.mark.slow
def test_matter_without_its_own_gravity_does_not_fragment(tmp_path):
    """No Jeans mass is recorded, warned of or planned for where gravity is not listed."""
    text = SCENE.replace("[effects.gravity]\n", "").replace(
        "index = 3.0", "index = 1.0\nspecific_internal_energy = 0.01"
    )
    kept = dataset.open(run_scene(load.loads(text), tmp_path / "run"))
    assert np.isnan(kept["jeans_ratio"]).all()
    assert "Jeans" not in kept.attrs.get("resolution_warnings", "")
    isothermal = text.replace('kind = "ideal"', 'kind = "isothermal"\nsound_speed = 0.01')
    isothermal = isothermal.replace("specific_internal_energy = 0.01\n", "")
    assert not any(line.name == "Jeans mass" for line in plan(load.loads(isothermal)).sections.get("resolution", ()))


@pytest.mark.parametrize("jeans", [0.0, 1e-320, 1e-300])
def test_a_body_that_is_as_cold_as_can_be_is_reported(jeans):
    """The share of the Jeans mass that is resolved is 0, or next to it: no number of particles is enough."""
    series = {name: np.array([1.0]) for name in ("core_particles", "jeans_ratio", "smoothing_to_thickness")}
    found = resolution_warnings({**series, "jeans_ratio": np.array([1.0, jeans])}, 50.0)
    assert any("take many times as many" in sentence for sentence in found)


@pytest.mark.full
def test_a_body_that_flies_apart_is_called_that_and_does_so_the_same_each_time(tmp_path):
    """With as much heat as a hundred times what holds it; what happens then is the same to the last bit."""
    hot = SCENE.replace("relax = false", "relax = false\nspecific_internal_energy = 100.0")
    scene = load.loads(hot.replace("end = 0.02", "end = 4.0").replace("series_every = 0.01", "series_every = 1.0"))
    one, other = (dataset.open(run_scene(scene, tmp_path / name)) for name in ("one", "other"))
    for name in one.data_vars:
        if name != "wall_time":
            np.testing.assert_array_equal(one[name], other[name], err_msg=str(name))
    (sentence,) = message(one.attrs, "resolution").splitlines()
    assert sentence.startswith("warning: the body flew apart: at the end half of its mass is ")
    grown = float(one["half_mass_radius"][-1] / one["half_mass_radius"][0])
    assert f"{grown:.3g} times" in sentence and grown > 10.0
    # One that comes together again, or is not held by gravity to begin with, is not called so.
    kept = {name: one[name].values for name in one.data_vars}
    assert not any("flew" in text for text in resolution_warnings({**kept, "total_energy": -kept["total_energy"]}, 50))
    free = {**kept, "gravitational_energy": np.full(one.sizes["time"], np.nan)}
    assert not any("flew" in text for text in resolution_warnings(free, 50))


@pytest.mark.parametrize("unit", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize(("grown", "left", "flown"), [(11.0, 1.0, True), (9.0, 1.0, False), (11.0, -1.0, False)])
def test_a_body_has_flown_apart_where_it_has_grown_tenfold_and_is_not_bound(grown, left, flown, unit):
    series = {
        "half_mass_radius": unit * np.array([2.0, 2.0 * grown]), "radius_enclosing_99": unit * np.array([3.0, 60.0]),
        "total_energy": unit * left * np.ones(2), "gravitational_energy": -unit * np.ones(2),
        "core_particles": np.array([40.0, 40.0]), "jeans_ratio": np.array([2.0, np.nan]),
        "smoothing_to_thickness": np.array([np.nan, 0.6]),
    }  # fmt: skip
    sentences = resolution_warnings(series, 25.0)
    if flown:
        (apart,) = sentences
        assert "half of its mass is 11 times as far" in apart and "99 % of it within 20 times as far" in apart
    else:
        assert [("core" in each, "smoothing length" in each) for each in sentences] == [(True, False), (False, True)]
