"""Characteristic numbers of a particle table, against those of the uniform ball that it stands for."""

import math

import numpy as np
import pytest

from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import load_file
from astroinertia.scene.plan import plan
from astroinertia.units import GRAVITATIONAL_CONSTANT as G

MASS, RADIUS, RATE, HUBBLE, HEAT = 2e30, 7e8, 2e-4, -3e-5, 3e10


def ball(spacing: float) -> np.ndarray:
    """A lattice in the unit ball, away from its centre, (N, 3)."""
    line = np.arange(-1.0 + spacing / 2, 1.0, spacing)
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    return points[np.linalg.norm(points, axis=1) < 1.0]


def scene(folder, spacing: float, units: str, **columns):
    points = ball(spacing) * RADIUS
    velocity = np.cross([0.0, 0.0, RATE], points) + HUBBLE * points + 1e4
    table = np.column_stack(
        [np.full(len(points), MASS / len(points)), points + 3e9, velocity, np.full(len(points), HEAT)]
    )
    np.savetxt(folder / "cloud.csv", table, delimiter=",", header="m,x,y,z,vx,vy,vz,u", comments="")
    text = f"""
        name = "cloud"
        units = {units}
        body = {{kind = "table", file = "cloud.csv"}}
        equation_of_state = {{kind = "ideal", gamma = 1.4}}
        effects = {{gravity = {{}}, pressure = {{}}, viscosity = {{}}}}
        time.end = "30 min"
    """
    (folder / "cloud.toml").write_text(text)
    return load_file(folder / "cloud.toml")


@pytest.mark.parametrize("spacing", [0.2, 0.1])  # some 500 particles, and more than have all pairs summed
def test_they_are_those_of_the_ball(tmp_path, spacing):
    found = characteristic(scene(tmp_path, spacing, '"SI"'))
    moment = 0.4 * MASS * RADIUS**2
    expected = {
        "mass": MASS, "radius": RADIUS, "second_moment": 1.5 * moment, "spin": RATE, "expansion": HUBBLE,
        "gravitational": 0.6 * G * MASS**2 / RADIUS, "rotational": 0.5 * moment * RATE**2,
        "thermal_energy": MASS * HEAT, "triple_pressure": 1.2 * MASS * HEAT,
        "central_density": MASS / (4 / 3 * math.pi * RADIUS**3),
    }  # fmt: skip
    for name, value in expected.items():
        tolerance = spacing + 0.05 if name == "central_density" else 0.05
        assert getattr(found, name) == pytest.approx(value, rel=tolerance), name
    assert found.moments == pytest.approx([moment] * 3, rel=0.04)
    np.testing.assert_allclose(found.spin_axis, [0.0, 0.0, 1.0], atol=1e-9)


def test_the_plan_of_a_table_says_how_large_effects_are(tmp_path):
    text = plan(scene(tmp_path, 0.25, '"SI"')).text()
    assert "does not state its mass" not in text and "does not state its radius" not in text
    assert "|W| over 3 Pi + 2 T is" in text and "U/|W|" in text


def test_numbers_of_code_units_are_those_of_the_file(tmp_path):
    points = ball(0.25)
    np.savetxt(tmp_path / "t.csv", np.column_stack([np.full(len(points), 1 / len(points)), points]), delimiter=",",
               header="m,x,y,z", comments="")  # fmt: skip
    (tmp_path / "t.toml").write_text(
        'name = "t"\nunits = "code"\nbody = {kind = "table", file = "t.csv", specific_internal_energy = 0.2}\n'
        'equation_of_state = {kind = "ideal"}\neffects = {gravity = {}}\ntime.end = 1\n'
    )
    found = characteristic(load_file(tmp_path / "t.toml"))
    assert found.mass == pytest.approx(1.0, rel=1e-12) and found.gravitational == pytest.approx(0.6, rel=0.06)
    assert found.spin == 0.0 and found.thermal_energy is None
