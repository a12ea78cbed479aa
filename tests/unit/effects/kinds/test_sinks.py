"""What sinks that are there from the start do to a body, before any run."""

import pytest

from astroinertia.effects.kinds.sinks import ENTRY
from astroinertia.effects.measure import tidal_change
from astroinertia.effects.sizes import effect_size
from astroinertia.models.sph.record import energy_budget
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import loads
from astroinertia.scene.plan import plan
from astroinertia.scene.schema import Scene
from tests.evolve import prepared

CLOUD = """
name = "cloud"
units = "code"
[body]
kind = "uniform"
particles = 500
mass = 0.2
radius = 2.0
relax = false
specific_internal_energy = 0.06
position = [3.0, 0.0, 0.0]
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 3.0
"""
STAR = "[effects.sinks]\nradius = 0.1\n[[sinks]]\nmass = 1.0\nposition = [3.0, 0.0, 0.0]\n"


def change_of(scene: Scene) -> float:
    change = effect_size(ENTRY.size, characteristic(scene), scene.effects["sinks"]).change
    assert change is not None
    return change


def test_a_star_in_a_cloud_weighs_as_much_as_the_plan_says() -> None:
    """2.5 times |W| for each mass of the cloud's in it: what particles have as gravitational energy."""
    body = prepared(CLOUD + STAR)
    energies = energy_budget(body.problem, body.state)["potential"]
    assert energies["sinks"] / energies["gravity"] == pytest.approx(12.5, rel=0.03)
    assert characteristic(loads(CLOUD + STAR)).added_weight == pytest.approx(12.5)


def test_a_cloud_that_would_swell_falls_onto_a_star() -> None:
    """The plan counts the star among what weighs, and how large an effect it is; one outside raises a tide."""
    assert "it swells at first" in plan(loads(CLOUD)).text()
    text = plan(loads(CLOUD + STAR)).text()
    assert "it falls at first" in text
    assert "mass of the sinks that are there over the body's; of others, central density over theirs is 5" in text
    scene = loads(CLOUD + STAR)
    assert change_of(scene) > 0.5
    far = loads(CLOUD + STAR.replace("3.0, 0.0", "3.0, 40.0"))
    body = characteristic(far)
    assert body.added_weight == 0.0
    assert change_of(far) == pytest.approx(tidal_change(body, 5.0 * (2.0 / 40.0) ** 3))
    assert 0.0 < change_of(far) < 0.01
