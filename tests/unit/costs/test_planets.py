"""Planets of layers as shells in balance, and what follows of their steps; stars from tables."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from astroinertia.build.materials import materials
from astroinertia.build.planets import planet as solved
from astroinertia.build.spheres import progenitor
from astroinertia.costs import course
from astroinertia.costs.planets import planet
from astroinertia.scene import load
from astroinertia.scene.plan import code_units

ROOT = Path(__file__).parents[3]
SIMS = ROOT / "sims"


def scene_of(name, *settings):
    return load.load_file(SIMS / f"{name}.toml", settings)


@pytest.mark.full(inputs=["sims/rocky_planet.toml", "sims/giant_impact.toml"])
@pytest.mark.parametrize("name", ["rocky_planet", "giant_impact"])
def test_shells_are_as_dense_as_the_planet_that_is_solved_for(name):
    """Cold layers and warm ones, on the same isentropes, found with JAX and without."""
    scene = scene_of(name).alone()[0]
    exact, found = solved(scene, code_units(scene)), planet(scene)
    assert found is not None
    radius = np.cbrt(3.0 / (4.0 * np.pi) * (found.mass / found.density).sum())
    assert radius == pytest.approx(exact.radius, rel=1e-4)
    within = np.cumsum(found.mass) - 0.5 * found.mass
    np.testing.assert_allclose(found.density, exact.density_enclosing(within), rtol=1e-3)


@pytest.mark.slow
def test_sound_in_the_shells_is_that_of_the_matter():
    scene = scene_of("giant_impact").alone()[0]
    found, matter = planet(scene), materials(scene.equation_of_state, scene.origin, code_units(scene))
    assert found is not None
    within = np.cumsum(found.mass) / found.mass.sum()
    for number, (own, layer) in enumerate(zip((within < 0.3, within > 0.31), scene.body.layers, strict=True)):
        label = code_units(scene).to_code(layer.isentrope, "specific_energy")
        density = found.density[own]
        exact = matter.of(float(number)).sound_speed(np, density, np.full_like(density, label))
        np.testing.assert_allclose(found.signal[own], exact, rtol=5e-3)


@pytest.mark.slow
def test_predicting_planets_and_stars_from_tables_imports_no_engine_and_takes_little_time():
    program = (
        "import sys, time\n"
        "from astroinertia.scene import load\n"
        "from astroinertia.costs import machine\n"
        "from astroinertia.costs.prediction import predict\n"
        "for name in ('giant_impact', 'progenitor_collapse'):\n"
        f"    scene = load.load_file({str(SIMS)!r} + f'/{{name}}.toml')\n"
        "    begin = time.process_time()\n"
        "    assert predict(scene, machine.shipped()) is not None\n"
        "    print(time.process_time() - begin)\n"
        "print([name for name in ('jax', 'numba', 'astroinertia.models', 'h5py') if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT)
    *taken, imported = done.stdout.split("\n")[:3]
    assert imported == "[]"
    assert max(map(float, taken)) < 2.0


def test_nothing_is_known_of_a_planet_without_pressure_and_none_fails():
    falls = scene_of("rocky_planet").model_copy(update={"effects": {"gravity": {}}})
    assert course.counted(falls) is None
    for mass in ("1e15 kg", "1e30 kg"):  # a boulder, and one that iron cannot bear
        done = course.counted(scene_of("rocky_planet", f"body.mass='{mass}'"))
        assert done is None or done.steps > 0.0


def test_a_star_from_a_table_has_the_pressure_and_the_spin_that_its_particles_get():
    scene = scene_of("progenitor_collapse")
    units, star = code_units(scene), progenitor(scene, code_units(scene))
    shells = course.at_start(scene)
    pressure, central = star.densest()
    np.testing.assert_allclose(shells.pressure / shells.density**1.3, 0.65 * pressure / central**1.3, rtol=1e-3)
    rate = star.shells.at(units.to_code(star.shells.angular_velocity, "angular_velocity"), np.ones(1))[0]
    assert shells.turning[-1] == pytest.approx(2.0 / 3.0 * rate**2 * star.radius**4)
    assert (np.diff(np.sqrt(shells.turning) / shells.radius**2) < 0.0).all()  # it turns faster inside
    slower = course.at_start(load.load_file(SIMS / "progenitor_collapse.toml", ["body.rotation_factor=0.5"]))
    np.testing.assert_allclose(slower.turning, 0.25 * shells.turning)
