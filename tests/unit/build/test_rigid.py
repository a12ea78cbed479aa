"""From a scene to a rigid body: its moments and axes, its spin, what is refused, and a run as a dataset."""

import subprocess
import sys

import jax
import numpy as np
import pytest

from astroinertia.bodies.break_up import polytropic_rate
from astroinertia.build import rigid as start_rigid
from astroinertia.build.assemble import prepare
from astroinertia.errors import SceneError
from astroinertia.rotation.attitude import rotation
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan
from astroinertia.scene.plan_body import unstated_wobble
from tests.sims import SIMS

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


@pytest.mark.slow
def test_a_polytrope_turns_with_its_share_of_the_energy_that_binds_it():
    """|W| = 3/(5 - n) G M^2/R."""
    found = record(POLYTROPE + "rotation = { t_over_w = 0.01 }\n[effects.gravity]\n")
    assert found["kinetic_energy"] == pytest.approx(0.01 * 0.75 * 5.0**2 / 2.0, rel=1e-9)
    assert found["angular_momentum"][2] > 0.0


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


@pytest.mark.slow
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
        (BODY + NONE + PIVOT.replace("0.5", "1e7"), "radius of gyration, where its shape is rounded away"),
        (BODY + 'rotation = { rate = 1.0, law = "j_constant", scale = 1.0 }\n' + NONE, "law must be rigid"),
        ('[body]\nkind = "rigid"\nmass = 1.0\nmoments = [1.0, 1.0, 0.0]\n'
         "rotation = { angular_momentum = 1.0 }\n" + NONE, "rod's own axis"),
        ('[body]\nkind = "rigid"\nmass = 1.0\nmoments = [1.0, 0.0, 1.0]\n'
         "rotation = { rate = 1.0, axis = [0, 1, 0] }\n" + NONE, "rod's own axis"),
    ],
)  # fmt: skip
def test_what_a_rigid_body_cannot_do_is_refused(text, message):
    with pytest.raises(SceneError, match=message):
        made(text)


ASTEROID = '[body]\nkind = "rigid"\nmass = 2.0\nmoments = [2.5, 3.0, 1.0]\n'  # the largest about y, the least about z


def angles(row):
    """Of L from z, and from the axis of the largest moment, in degrees."""
    momentum, axis = row["angular_momentum"], row["attitude"][1]
    axis = axis * np.copysign(1.0, axis @ momentum)
    sines = (np.linalg.norm(np.cross(each, momentum)) for each in (np.eye(3)[2], axis))
    return np.degrees(np.arctan2(list(sines), [momentum[2], axis @ momentum]))


@pytest.mark.parametrize(("obliquity", "wobble"), [(0.0, 30.0), (25.0, 0.0), (140.0, 75.0), (90.0, 90.0)])
def test_obliquity_and_wobble_are_angles_of_the_angular_momentum(obliquity, wobble):
    keys = f"obliquity = {np.radians(obliquity)}, wobble = {np.radians(wobble)}"
    scene = loads(HEAD + ASTEROID + f"rotation = {{ period = 4.0, {keys} }}\n" + NONE)
    row = record(ASTEROID + f"rotation = {{ period = 4.0, {keys} }}\n" + NONE)
    assert angles(row) == pytest.approx((obliquity, wobble), abs=1e-6)
    momentum, inertia = row["angular_momentum"], row["inertia_tensor"]
    assert np.linalg.norm(np.linalg.solve(inertia, momentum)) == pytest.approx(np.pi / 2.0)
    assert momentum[0] == pytest.approx(0.0, abs=1e-12) and momentum[1] >= -1e-12  # x is the equinox
    assert abs(row["attitude"][0] @ momentum) < 1e-12  # between the axes of the largest and of the least moment
    text = plan(scene).text()
    assert f"{obliquity:.6g} deg" in text and f"{wobble:.6g} deg" in text


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "wobble"), [(1.5, 0.0), (2.0, 0.0), (2.0, 0.3)])
def test_a_body_that_its_spin_deforms_has_the_moments_of_the_scene_at_the_rate_of_its_bulge(rate, wobble):
    """D = k R^5/(3 G) = 0.05: L = I Omega at 1.5, and beside that 2/3 D (Omega^2 - 1.5^2) Omega at another rate."""
    bulge = "[effects.rotational_deformation]\nlove_number = 0.15\nradius = 1.0\nrate = 1.5\n"
    shape = '[body]\nkind = "rigid"\nmass = 2.0\nmoments = [1.0, 1.0, 1.4]\n'
    row = record(f"{shape}rotation = {{ rate = {rate}, wobble = {wobble} }}\n{bulge}")
    rest = np.array([1.0, 1.0, 1.4]) + 0.05 * 1.5**2 * np.array([1.0, 1.0, -2.0]) / 3.0
    momentum = row["attitude"] @ row["angular_momentum"]
    spin = momentum / (rest + 2.0 / 3.0 * 0.05 * rate**2)
    assert np.linalg.norm(spin) == pytest.approx(rate, rel=1e-9)
    assert np.arctan2(np.hypot(momentum[0], momentum[1]), momentum[2]) == pytest.approx(wobble, abs=1e-9)
    if wobble == 0.0:
        assert momentum[2] == pytest.approx((1.4 + 2.0 / 3.0 * 0.05 * (rate**2 - 1.5**2)) * rate, rel=1e-12)


def test_an_obliquity_turns_the_body_with_its_axis():
    """The Earth of sims/earth_precession.toml, which gives the directions of its axes; a stretched sphere, too."""
    directions = "axes_at_start = [[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]\n"
    earth = '[body]\nkind = "rigid"\nmass = 2.0\nmoments = [2.0, 2.2, 2.5]\n'
    turned = "obliquity = 0.6435011087932844"
    by_key = record(earth + f"rotation = {{ rate = 1.0, {turned} }}\n" + NONE)
    by_axes = record(earth + directions + "rotation = { rate = 1.0, axis = [0, 0.6, 0.8] }\n" + NONE)
    for name in ("attitude", "angular_momentum", "inertia_tensor"):
        assert by_key[name] == pytest.approx(by_axes[name], abs=1e-14)
    sphere = '[body]\nkind = "uniform"\nmass = 5.0\nradius = 1.0\naxes = [1.0, 1.0, 0.5]\n'
    found = record(sphere + f"rotation = {{ rate = 1.0, {turned} }}\n" + NONE)
    assert found["angular_momentum"] == pytest.approx([0.0, 1.2, 1.6], abs=1e-14)
    assert found["inertia_tensor"] @ [0.0, 0.6, 0.8] == pytest.approx(2.0 * np.array([0.0, 0.6, 0.8]), abs=1e-14)


def test_a_tilted_axis_alone_is_a_wobble_of_which_the_plan_says_how_much():
    tilted = BODY + "rotation = { rate = 1.0, axis = [0.3, 0.0, 1.0] }\n" + NONE
    momentum = np.array([0.9, 0.0, 2.5])
    degrees = np.degrees(np.arccos(momentum[0] / np.linalg.norm(momentum)))  # from x, of the largest moment
    assert f"{degrees:.6g} deg" in plan(loads(HEAD + tilted)).text()
    assert unstated_wobble(loads(HEAD + tilted)).startswith(f"it wobbles by {degrees:.6g} deg: [body.rotation] axis")


@pytest.mark.parametrize("stated", ["axis = [1.0, 0.0, 0.0]", "wobble = 0.1"])
def test_a_wobble_that_is_stated_or_none_needs_no_sentence(stated):
    assert unstated_wobble(loads(HEAD + BODY + f"rotation = {{ rate = 1.0, {stated} }}\n" + NONE)) == ""


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            BODY.replace("2.5", "3.0") + "rotation = { rate = 1.0, wobble = 0.08726646259971647 }\n",
            "one moment that is larger",
        ),
        (BODY + "rotation = { rate = 1.0, wobble = 1.6580627893946132 }\n", "wobble"),
        (BODY + "rotation = { rate = 1.0, obliquity = -0.08726646259971647 }\n", "obliquity"),
    ],
)
def test_an_angle_that_is_none_is_refused(text, problem):
    with pytest.raises(SceneError, match=problem):
        plan(loads(HEAD + text + NONE))


@pytest.mark.parametrize(("model", "key"), [("ellipsoid", "wobble"), ("scaling", "wobble"), ("sph", "wobble")])
def test_a_wobble_of_other_models_is_refused(model, key):
    sphere = '[body]\nkind = "uniform"\nmass = 5.0\nradius = 1.0\n' + "particles = 100\n" * (model == "sph")
    rest = '[equation_of_state]\nkind = "polytropic"\ngamma = 2.0\nconstant = 1.0\n' * (model != "rigid")
    with pytest.raises(SceneError, match="wobble is for the model rigid"):
        loads(
            HEAD.replace("rigid", model)
            + sphere
            + f"rotation = {{ rate = 1.0, {key} = 0.08726646259971647 }}\n"
            + rest
            + NONE
        )


@pytest.mark.parametrize("model", ["ellipsoid", "sph"])
def test_an_obliquity_turns_a_fluid_with_its_axis(model):
    sphere = '[body]\nkind = "uniform"\nmass = 5.0\nradius = 1.0\naxes = [1.0, 1.0, 0.5]\n'
    sphere += "particles = 100\n" * (model == "sph")
    rest = '[equation_of_state]\nkind = "ideal"\ngamma = 2.0\n[effects.gravity]\n[effects.pressure]\n'
    rows = []
    for keys in ("obliquity = 0.6981317007977318", "axis = [0.0, 0.0, 1.0]"):
        scene = loads(HEAD.replace("rigid", model) + sphere + f"rotation = {{ rate = 0.1, {keys} }}\n" + rest)
        with jax.enable_x64(True):
            rows.append(prepare(scene).evolution.record(None))
    turn = rotation(np.array([-np.radians(40.0), 0.0, 0.0]))
    tilted, upright = rows
    assert tilted["angular_momentum"] == pytest.approx(turn @ upright["angular_momentum"], rel=1e-6, abs=1e-8)
    expected = turn @ upright["inertia_tensor"] @ turn.T
    assert tilted["inertia_tensor"] == pytest.approx(expected, rel=0.05, abs=0.05 if model == "sph" else 1e-12)


@pytest.mark.full(inputs=["sims/tennis_racket.toml"])
def test_a_body_that_a_splitting_follows_is_run_without_numba_and_diffrax(tmp_path):
    """To import them takes longer than to follow it."""
    program = (
        "import sys; from astroinertia.cli.main import main; "
        f"code = main(['run', {str(SIMS / 'tennis_racket.toml')!r}, '--output', {str(tmp_path / 'run')!r}]); "
        "print(code, sorted({'numba', 'diffrax'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "0 []"
