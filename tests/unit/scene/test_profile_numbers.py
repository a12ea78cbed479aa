"""Characteristic numbers of a stellar profile, against those of the polytrope that its shells were made of."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.errors import SceneError
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import loads
from astroinertia.scene.plan import plan
from astroinertia.scene.scales import code_units
from astroinertia.sph.progenitor import read_progenitor
from astroinertia.units import GRAVITATIONAL_CONSTANT as G, SOLAR_MASS

KEPLER = Path(__file__).parents[3] / "data" / "example_kepler_presn"
STAR = Polytrope(3.0, 2.0 * SOLAR_MASS, 3.0e6, G)
WEIGHT = 1.5 * G * STAR.mass**2 / STAR.radius  # |W| = 3/(5 - n) G M^2/R
SCENE = """
name = "star"
[body]
kind = "profile"
file = "FILE"
particles = 100
[equation_of_state]
kind = "ideal"
gamma = "4/3"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[time]
end = "1 s"
"""


def scene_of(*settings, file=KEPLER):
    return loads(SCENE.replace("FILE", str(file)), settings)


def balls(path, **units):
    """A ball of even density 1000 kg/m3 and radius 1e8 m in 400 shells, with columns besides."""
    radius = np.linspace(0.0, 1e8, 401)[1:]
    columns = {"radius [m]": radius, "density [kg/m3]": np.full_like(radius, 1e3), **units}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return path


def test_they_are_those_of_the_star():
    found = characteristic(scene_of())
    moment = float(STAR.moment_of_inertia)
    assert found.mass == pytest.approx(STAR.mass, rel=1e-12) and found.radius == pytest.approx(STAR.radius, rel=1e-12)
    assert found.moments == pytest.approx([moment] * 3, rel=4e-4)
    assert found.gravitational == pytest.approx(WEIGHT, rel=1e-3)
    assert found.triple_pressure == pytest.approx(WEIGHT, rel=2e-3)  # the virial theorem
    assert found.central_density == pytest.approx(STAR.central_density, rel=5e-3)
    # The shells turn at 4 rad/s / (1 + (r/1000 km)^2): L and T by Gauss's rule over the star's mass.
    nodes, weights = np.polynomial.legendre.leggauss(200)
    r = (nodes + 1.0) / 2.0 * STAR.radius
    shell = weights / 2.0 * STAR.radius * 8.0 * math.pi / 3.0 * r**4 * np.asarray(STAR.density(r))
    rate = 4.0 / (1.0 + (r / 1e6) ** 2)
    assert found.spin == pytest.approx(shell @ rate / shell.sum(), rel=1e-3)
    assert found.rotational == pytest.approx(0.5 * shell @ rate**2, rel=1e-3)


def test_settings_of_the_body_count():
    whole, twice = characteristic(scene_of()), characteristic(scene_of("body.rotation_factor=-2.0"))
    assert (twice.spin, twice.rotational) == pytest.approx((2.0 * whole.spin, 4.0 * whole.rotational))
    assert twice.spin_axis == (0.0, 0.0, -1.0)
    less = characteristic(scene_of("body.pressure_fraction=0.5"))
    assert less.triple_pressure == pytest.approx(0.5 * whole.triple_pressure)
    given = characteristic(scene_of('body.rotation={period="10 s"}'))
    assert given.spin == pytest.approx(0.2 * math.pi)
    flat = characteristic(scene_of("body.axes=[1.0, 1.0, 0.5]"))
    assert flat.moments[2] == pytest.approx(whole.moments[2]) and flat.rotational == pytest.approx(whole.rotational)
    # One constant, of the centre, at the exponent of the star itself is the star.
    hybrid = 'equation_of_state={kind="hybrid", gamma_1="4/3", nuclear_density="2e14 g/cm3"}'
    assert characteristic(scene_of(hybrid)).triple_pressure == pytest.approx(whole.triple_pressure, rel=5e-3)


def test_a_profile_without_pressure_is_in_balance_or_as_warm_as_it_says(tmp_path):
    """|W| of a ball of even density is 3/5 G M^2/R, and its central pressure 3/(8 pi) G M^2/R^4."""
    cold = balls(tmp_path / "cold.csv")
    shells, mass = read_progenitor(cold), 4.0e27 / 3.0 * math.pi
    pressure = shells.pressure_in_balance(G)
    middle = (shells.radius - 0.125e6) / 1e8
    np.testing.assert_allclose(pressure, 3.0 / (8.0 * math.pi) * G * mass**2 / 1e32 * (1.0 - middle**2), rtol=1e-9)
    found = characteristic(scene_of(file=cold))
    assert found.triple_pressure == pytest.approx(0.6 * G * mass**2 / 1e8, rel=1e-4)
    assert found.rotational == found.spin == 0.0
    warm = balls(tmp_path / "warm.csv", **{"u [J/kg]": np.full(400, 2e9)})
    assert characteristic(scene_of(file=warm)).triple_pressure == pytest.approx(mass * 2e9)
    assert "states no rotation" in plan(scene_of(file=warm)).text()


def test_a_scene_without_units_has_those_of_what_is_taken_of_the_star():
    units = code_units(scene_of('body.inner_mass="1.4 Msun"'))
    assert units.unit("mass") == pytest.approx(1.4 * SOLAR_MASS) and units.unit("length") < STAR.radius
    with pytest.raises(SceneError, match="inner_mass: the profile has"):
        scene_of('body.inner_mass="3 Msun"')
    with pytest.raises(SceneError, match="inner_mass: 'wide' is not a number and a unit"):
        scene_of('body.inner_mass="wide"')
    with pytest.raises(SceneError, match=r"nowhere.csv is not there"):
        scene_of(file="nowhere.csv")


def test_a_file_that_is_written_again_is_read_again(tmp_path):
    file = balls(tmp_path / "ball.csv")
    before = characteristic(scene_of(file=file))
    file.write_text(file.read_text().replace("[m]", "[km]"))
    os.utime(file, ns=(1, 1))
    assert characteristic(scene_of(file=file)).radius == pytest.approx(1e3 * before.radius)


def test_what_is_missing_of_cold_matter_is_named(tmp_path):
    """Matter of a table on its coldest isentrope has a pressure that only the table knows."""
    rows = [f"{rho},{u},{0.5 * rho * u + 1e3 * rho**2}" for rho in np.logspace(0, 5, 20) for u in (0, 1e6, 1e8)]
    (tmp_path / "eos.csv").write_text("density,internal_energy,pressure\n" + "\n".join(rows))
    material = f'{{name="rock", file="{tmp_path}/eos.csv", reference_density="1 g/cm3"}}'
    text = plan(scene_of(f'equation_of_state={{kind="materials", materials=[{material}]}}')).text()
    assert "does not state its pressure" in text and "zone" not in text.replace("of one zone", "")
