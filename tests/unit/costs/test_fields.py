"""What given fields do to bodies, and the steps that they are predicted to take in them."""

import numpy as np
import pytest

from astroinertia.costs import course, machine, piloted
from astroinertia.costs.fields import fields
from astroinertia.costs.prediction import predict
from astroinertia.scene import load

CLOUD = """
name = "cloud"
units = "code"
body = {kind = "uniform", particles = 300, mass = 1, radius = 1, relax = false}
effects = {gravity = {}, pressure = {}, viscosity = {}, external_field = {FIELD}}
equation_of_state = {kind = "ideal", gamma = 1.6666666666666667}
time = {end = 2}
output = {series_every = 0.02, snapshot_every = 0.2}
"""
POINT = "point_mass = 1, softening = 0.1"
QUADRATIC = "quadratic = [[4, 0, 0], [0, 4, 0], [0, 0, 4]]"
LOGARITHMIC = "circular_speed = 2, core = 0.3"
RADIUS = np.array([0.3, 1.0])


def scene(field, *settings):
    return load.loads(CLOUD.replace("FIELD", field), settings)


@pytest.fixture(autouse=True)
def no_pilots(monkeypatch):
    monkeypatch.setattr(piloted, "kept", lambda scene: None)


@pytest.mark.parametrize(
    ("field", "inward"),
    [
        (POINT, RADIUS / (RADIUS**2 + 0.01) ** 1.5),
        (LOGARITHMIC, 4.0 * RADIUS / (RADIUS**2 + 0.09)),
        ("quadratic = [[1, 0, 0], [0, 2, 0], [0, 0, 6]]", 3.0 * RADIUS),  # a third of the trace
        ("quadratic = [[-2, 0, 0], [0, 1, 0], [0, 0, 1]], uniform = [0, 0, 9]", 0.0 * RADIUS),
    ],
)
def test_a_field_pulls_spheres_inwards_as_its_mean_over_them(field, inward):
    assert fields(scene(field)).inward(RADIUS) == pytest.approx(inward, abs=1e-14)


def test_a_field_that_is_alike_everywhere_carries_all_along():
    given = fields(scene("uniform = [0, 3, -4]"))
    assert given.bulk(RADIUS) == pytest.approx([5.0, 5.0])
    assert given.timesteps(RADIUS, RADIUS, RADIUS) == {}
    assert fields(load.loads(CLOUD.replace(", external_field = {FIELD}", ""))) is None


def test_shells_fall_to_a_mass_in_their_middle_as_on_a_cycloid():
    """The edge of a cloud without pressure, with M within it: r = cos^2(y/2), t = (y + sin y)/(8 M)^(1/2)."""
    start = course.at_start(scene("point_mass = 3, softening = 1e-3", "body.specific_internal_energy=1e-9"))
    y = 2.0 * np.arccos(np.sqrt(0.7))
    last = course.shells.followed(start, float((y + np.sin(y)) / np.sqrt(8.0 * 4.0)))[-1]
    assert last.radius[-1] == pytest.approx(0.7, rel=0.01)


@pytest.mark.parametrize(("field", "taken"), [(POINT, 488), (QUADRATIC, 213), (LOGARITHMIC, 337)])
def test_a_cloud_about_a_mass_takes_the_steps_that_are_predicted(field, taken):
    """Of what runs of the scene took; without the field it is 100, what its records ask for."""
    found = predict(scene(field), machine.shipped())
    assert taken / 1.8 < found.steps < 1.8 * taken
