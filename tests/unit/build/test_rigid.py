"""From a scene to a rigid body: its moments and axes, its spin, what is refused, and a run as a dataset."""

import jax
import numpy as np
import pytest

from astroinertia.build import rigid as start_rigid
from astroinertia.errors import SceneError
from astroinertia.rotation.break_up import polytropic_rate
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan

HEAD = 'name = "it"\nmodel = "rigid"\nunits = "code"\n[time]\nend = 1.0\n'
BODY = '[body]\nkind = "rigid"\nmass = 2.0\nmoments = [3.0, 1.0, 2.5]\n'
NONE = "[effects]\n"
PIVOT = "[effects.pivot]\ngravity = [0.0, 0.0, -1.0]\narm = [0.0, 0.0, 0.5]\n"


def made(text):
    scene = loads(HEAD + text)
    with jax.enable_x64(True):
        return start_rigid.evolution(scene, code_units(scene))


def record(text):
    with jax.enable_x64(True):
        return made(text).record(None)


def test_moments_come_in_the_order_of_the_scene_and_about_its_axes():
    found = record(BODY + "axes_at_start = [[0, 1, 0], [0, 0, 2], [1, 0, 0]]\nrotation = { rate = 2.0 }\n" + NONE)
    assert found["inertia_tensor"] == pytest.approx(np.diag([2.5, 3.0, 1.0]), abs=1e-14)
    assert found["attitude"] == pytest.approx(np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]), abs=1e-15)
    assert found["angular_momentum"] == pytest.approx([0.0, 0.0, 2.0], abs=1e-14)
    assert found["kinetic_energy"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("given", "rate"), [("period = 4.0", np.pi / 2.0), ("angular_momentum = 5.0", 2.0), ("rate = -1.5", -1.5)]
)
def test_every_measure_of_rotation(given, rate):
    found = record(BODY + f"rotation = {{ {given} }}\n" + NONE)
    assert found["angular_momentum"] == pytest.approx([0.0, 0.0, 2.5 * rate], abs=1e-14)


def test_a_polytrope_may_be_rigid():
    text = '[body]\nkind = "uniform"\nmass = 5.0\nradius = 1.0\naxes = [1.0, 1.0, 0.5]\nrotation = { rate = 1.0 }\n'
    assert record(text + NONE)["angular_momentum"][2] == pytest.approx(2.0)


POLYTROPE = '[body]\nkind = "polytrope"\nindex = 1.0\nmass = 5.0\nradius = 2.0\n'


def test_a_polytrope_turns_at_its_share_of_break_up():
    found = record(POLYTROPE + "rotation = { breakup_fraction = 0.8 }\n" + NONE)
    rate = found["angular_momentum"][2] / found["inertia_tensor"][2, 2]
    assert rate == pytest.approx(polytropic_rate(1.0, 0.8) * (5.0 / 2.0**3) ** 0.5, rel=1e-12)
    scene = loads(HEAD + POLYTROPE + "rotation = { breakup_fraction = 0.8 }\n" + NONE)
    assert characteristic(scene).spin == pytest.approx(rate, rel=1e-6)  # the plan's
    assert "breakup_fraction 0.8" in plan(scene).text()


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (POLYTROPE + "rotation = { breakup_fraction = 1.0 }\n", "less than 1"),
        (POLYTROPE + "rotation = { breakup_fraction = 0.5, rate = 1.0 }\n", "exactly one of"),
        (POLYTROPE + 'rotation = { breakup_fraction = 0.5, law = "j_constant", scale = 1.0 }\n', "is of the law rigid"),
        (POLYTROPE.replace("1.0", "3.0", 1) + "rotation = { breakup_fraction = 0.5 }\n", "between 0 and 3"),
        (BODY + "rotation = { breakup_fraction = 0.5 }\n", "between 0 and 3"),
    ],
)
def test_a_share_of_break_up_that_is_none_is_refused(text, problem):
    with pytest.raises(SceneError, match=problem):
        loads(HEAD + text + NONE)


def test_a_pivot_takes_the_moments_to_the_fixed_point():
    found = made(BODY + "rotation = { rate = 1.0, axis = [1, 0, 0] }\n" + PIVOT)
    assert np.asarray(found.body.moments) == pytest.approx([1.5, 2.5, 3.5])
    with jax.enable_x64(True):
        record = found.record(None)
    assert record["centre_of_mass"] == pytest.approx([0.0, 0.0, 0.5])
    assert record["momentum"] == pytest.approx([0.0, -1.0, 0.0])
    assert record["inertia_tensor"] == pytest.approx(np.diag([3.0, 1.0, 2.5]), abs=1e-14)
    assert record["potential_energy"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BODY + "axes_at_start = [[0, 1, 0], [1, 0, 0], [0, 0, 1]]\n" + NONE, "right-handed"),
        (BODY + "change = { times = [0.5], factors = [2.0] }\n" + PIVOT, "prescribes the size"),
        (BODY + 'rotation = { rate = 1.0, law = "j_constant", scale = 1.0 }\n' + NONE, "law must be rigid"),
        ('[body]\nkind = "rigid"\nmass = 1.0\nmoments = [1.0, 1.0, 0.0]\n'
         "rotation = { angular_momentum = 1.0 }\n" + NONE, "rod's own axis"),
    ],
)  # fmt: skip
def test_what_a_rigid_body_cannot_do_is_refused(text, message):
    with pytest.raises(SceneError, match=message):
        made(text)
