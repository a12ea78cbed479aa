"""How bodies without particles turn at the start: the one measure that a scene gives, and about which axis."""

import math

import numpy as np
import pytest

from astroinertia.build.spin import rotation_amount, rotation_axis
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units

SCENE = """
name = "ball"
model = "rigid"
units = "code"
[body]
kind = "uniform"
mass = 2.0
radius = 1.0
ROTATION
[effects]
[time]
end = 1.0
"""


@pytest.mark.parametrize(
    ("rotation", "axis", "amount"),
    [
        ("", [0.0, 0.0, 1.0], {}),
        ("rotation = { period = 4.0 }", [0.0, 0.0, 1.0], {"rate": 0.5 * math.pi}),
        ("rotation = { rate = 3.0, axis = [3.0, 0.0, 4.0] }", [0.6, 0.0, 0.8], {"rate": 3.0}),
        ("rotation = { angular_momentum = 0.5 }", [0.0, 0.0, 1.0], {"angular_momentum": 0.5}),
    ],
)
def test_a_body_turns_as_its_scene_says_and_rests_where_that_says_nothing(
    rotation: str, axis: list[float], amount: dict[str, float]
) -> None:
    scene = loads(SCENE.replace("ROTATION", rotation))
    np.testing.assert_allclose(rotation_axis(scene), axis, atol=1e-15)
    assert rotation_amount(scene, code_units(scene), weighs=False) == pytest.approx(amount, rel=1e-15)


def test_a_share_of_the_binding_energy_needs_some() -> None:
    scene = loads(SCENE.replace("ROTATION", "rotation = { t_over_w = 0.1 }"))
    assert rotation_amount(scene, code_units(scene), weighs=True) == {"t_over_w": 0.1}
    with pytest.raises(SceneError, match="t_over_w needs a self-gravitating body"):
        rotation_amount(scene, code_units(scene), weighs=False)
