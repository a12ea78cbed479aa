"""What a run without particles is predicted to take."""

import math

import numpy as np
import pytest

from astroinertia.costs import machine, smooth
from astroinertia.costs.prediction import predict
from astroinertia.costs.probe_scenes import COMPANION, ELLIPSOID, RIGID
from astroinertia.effects.characteristic import Neighbour
from astroinertia.models.ellipsoid import evolution
from astroinertia.models.rigid import passage
from astroinertia.models.rigid.splitting import COMPOSITIONS
from astroinertia.scene import load
from tests.sims import SIMS


@pytest.mark.full
def test_a_top_is_fastest_where_its_polhode_says():
    text = """
name = "top"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 2.0, 2.5]
[body.rotation]
rate = 1.0
axis = [0.1, 1.0, 0.1]
[effects]
[time]
end = 10.0
"""
    inertia, spin = np.array([1.0, 2.0, 2.5]), np.array([0.1, 1.0, 0.1]) / math.sqrt(1.02)
    fastest = 0.0
    for _ in range(40_000):  # Euler's equations, by a step of the midpoint
        middle = spin + 5e-4 * np.cross(inertia * spin, spin) / inertia
        spin = spin + 1e-3 * np.cross(inertia * middle, middle) / inertia
        fastest = max(fastest, float(np.linalg.norm(spin)))
    assert smooth.fastest_spin(load.loads(text)) == pytest.approx(fastest, rel=1e-3)


@pytest.mark.parametrize("order", COMPOSITIONS)
def test_steps_of_a_splitting_take_as_long_as_their_stages(order):
    """Measured for orders 2, 4, 6 and 8: 0.2, 1.9, 3.4 and 6.4 us a step, of 1, 5, 9 and 17 stages."""
    own, default = (
        predict(load.loads(RIGID, ["numerics.integrator='splitting'", f"numerics.order={each}"]), machine.shipped())
        for each in (order, 8)
    )
    assert own is not None and default is not None
    stages = len(COMPOSITIONS[order]) / len(COMPOSITIONS[8])
    assert own.parts["steps"].processor == pytest.approx(stages * default.parts["steps"].processor)


@pytest.mark.parametrize(("integrator", "times"), [("splitting", 7.8), ("adaptive", 2.6)])
def test_steps_of_a_rigid_body_with_companions_take_longer(integrator, times):
    """As measured: 57.5 in place of 7.6 us, of a top, and 56.0 in place of 21.4, of the Earth."""
    free = load.loads(RIGID, (f"numerics.integrator='{integrator}'",))
    moon = load.loads(RIGID + COMPANION.replace("splitting", integrator))
    one, other = (predict(scene, machine.shipped()) for scene in (free, moon))
    assert other.steps == one.steps
    assert other.parts["steps"].processor == pytest.approx(times * one.parts["steps"].processor)


@pytest.mark.parametrize(
    ("integrator", "tide", "moons", "measured"),
    [
        *(("splitting", False, 1, 2.7), ("splitting", False, 5, 4.2), ("splitting", True, 1, 20.0)),
        *(("adaptive", False, 1, 3.9), ("adaptive", False, 5, 5.2), ("adaptive", True, 1, 4.15)),
    ],
)
def test_steps_with_moons_that_the_body_moves_take_as_long_as_measured(integrator, tide, moons, measured):
    """Over those of a free top: their places are not looked up in orbits that are known."""
    text = RIGID.replace("[effects]\n", "") + "[orbits]\nback_reaction = true\n[effects.gravity_gradient]\n"
    for number in range(moons):
        text += f'[[companions]]\nname = "moon_{number}"\nmass = 0.1\nsemi_major_axis = {20.0 * 2.0**number}\n'
    setting = (f"numerics.integrator='{integrator}'",)
    scene = load.loads(text + TIDE if tide else text, setting)
    free = load.loads(RIGID, setting)
    assert smooth.of_step(free) == 1.0
    assert measured / 1.3 < smooth.of_step(scene) < 1.3 * measured


@pytest.mark.parametrize("integrator", ["splitting", "adaptive"])
def test_a_top_takes_as_many_steps_however_its_spin_is_said(integrator):
    """About its largest moment, 2.5, at a rate of 0.5."""
    settings = (f"numerics.integrator='{integrator}'", "body.rotation.axis=[0.0, 0.0, 1.0]")
    said = (RIGID.replace("rate = 1.0", text) for text in ("rate = 0.5", "angular_momentum = 1.25"))
    one, other = (predict(load.loads(text, settings), machine.shipped()) for text in said)
    assert other.steps == one.steps


FRICTION = "[effects.internal_dissipation]\ntime_scale = 1e5\n"
TIDE = "[effects.tidal_torque]\nlove_number = 0.3\nradius = 1.0\ntime_lag = 0.01\n"


@pytest.mark.parametrize(
    ("integrator", "more", "measured"),
    [
        ("splitting", FRICTION, (14.6, 15.9)),
        ("splitting", COMPANION + TIDE, (19.5, 23.3)),
        ("adaptive", FRICTION, (2.7, 3.5)),
    ],
)
def test_steps_with_what_follows_the_spin_take_as_long_as_measured(integrator, more, measured):
    """Over those of a free top, twice; a torque that does not follow the spin takes no such step."""
    setting = (f"numerics.integrator='{integrator}'",)
    plain = RIGID.replace("[effects]\n", "")
    free, found = (predict(load.loads(text, setting), machine.shipped()) for text in (RIGID, plain + more))
    assert found.steps == pytest.approx(free.steps, rel=0.05)  # friction slows it a little
    assert measured[0] / 1.25 < found.parts["steps"].processor / free.parts["steps"].processor < 1.25 * measured[1]
    pushed = plain + "[effects.constant_torque]\nvector = [0.0, 0.0, 1e-6]\n"
    assert predict(load.loads(pushed, setting), machine.shipped()).parts["steps"] == free.parts["steps"]


@pytest.mark.parametrize("eccentricity", [0.0, 0.6, 0.95])
def test_a_companion_turns_by_its_longitude_in_each_orbit(eccentricity):
    """By 2 pi; and at the pericentre (1 + e)^(1/2)/(1 - e)^(3/2) times as fast as on average."""
    other = Neighbour("moon", 1.0, 1.0, 1.0 - eccentricity, eccentricity, rate=3.0)
    times = 2.0 * math.pi / 3.0 * np.arange(4000) / 4000
    assert smooth.turning_rate(other, 0.4, times).mean() == pytest.approx(3.0)
    nearest = 3.0 * math.sqrt(1.0 + eccentricity) / (1.0 - eccentricity) ** 1.5
    assert smooth.turning_rate(other, 0.0, np.zeros(1)) == pytest.approx([nearest])


def test_first_steps_are_those_of_the_models():
    assert smooth.FIRST == {"ellipsoid": evolution.FIRST_STEP, "adaptive": passage.FIRST_STEP}


TOP = RIGID.replace("[effects]\n", "").replace("end = 1e4", "end = 100.0")
ALONG = "body.rotation.axis=[0.0, 0.0, 1.0]"
CHANGE = "[effects]\n[body.change]\ntimes = [10.0, 50.0]\nfactors = [1.0, 0.1]\n"
PUSHED = "[effects.constant_torque]\nvector = [0.0, 0.0, 1.0]\n"


@pytest.mark.parametrize(
    ("more", "settings", "taken"),
    [
        ("[effects]\n", ("output.series_every=0.1",), 2000),
        (CHANGE, (), 2170),
        (CHANGE, ("numerics.integrator='splitting'",), 4511),
        (CHANGE.replace("0.1]", "10.0]"), ("body.rotation.rate=10.0",), 734),
        (PUSHED, (ALONG,), 4143),
        (PUSHED.replace("1.0]", "0.1]"), ("body.rotation.rate=0.0",), 453),
        (PUSHED.replace("1.0]", "-0.2]"), ("body.rotation.rate=10.0", ALONG, "numerics.integrator='splitting'"), 4311),
    ],
)
def test_tops_that_change_take_the_steps_that_are_predicted(more, settings, taken):
    """Of what their runs took; by the spin at first, it would be up to ten times fewer, or five times more."""
    adaptive = ("numerics.integrator='adaptive'", "output.series_every=1.0")
    found = predict(load.loads(TOP + more, (*adaptive, *settings)), machine.shipped())
    assert taken / 1.8 < found.steps < 1.8 * taken


@pytest.mark.parametrize(("settings", "taken"), [((), 4845), (("numerics.steps_per_rotation=200",), None)])
def test_an_asteroid_that_settles_slows_down_as_its_wobble_dies(settings, taken):
    """4845 steps, as its run took, not 8768 at its first spin; and with short steps as its mean spin asks for."""
    scene = load.load_file(SIMS / "asteroid_settles.toml", settings)
    found = predict(scene, machine.shipped()).steps
    last = 2.0 * math.pi / (10.7 * 86400.0)  # rad/s, when it has settled
    taken = taken or 200 * last * scene.time.end / (2.0 * math.pi)
    assert found == pytest.approx(taken, rel=0.15)


ROUND = "body.axes=[1.0, 1.0, 1.0]"


def test_a_needle_that_is_pushed_about_itself_has_a_plan():
    needle = TOP.replace("[1.0, 2.0, 2.5]", "[0.0, 1.0, 1.0]") + PUSHED.replace("[0.0, 0.0, 1.0]", "[1.0, 0.0, 0.0]")
    assert predict(load.loads(needle, ("body.rotation.rate=0",)), machine.shipped()).steps >= 200


def test_a_body_that_turns_by_its_velocity_gradient_has_a_plan_of_its_torques():
    """About z at a rate of 1; the torque doubles its angular momentum."""
    text = (
        TOP[: TOP.index("[body]")]
        + """[body]
kind = "uniform"
mass = 1.0
radius = 1.0
velocity_gradient = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
[effects.constant_torque]
vector = [0.0, 0.0, 0.004]
[time]
end = 100.0
[numerics]
integrator = "splitting"
steps_per_rotation = 40
"""
    )
    turns = 100.0 * 1.5 / (2.0 * math.pi)
    found = predict(load.loads(text, ("output.series_every=100.0",)), machine.shipped())
    assert found.steps == pytest.approx(40 * turns, rel=0.01)


GAS = ("equation_of_state.kind='polytropic'", "equation_of_state.gamma=1.6666666666666667", ROUND)


@pytest.mark.parametrize(
    ("effect", "settings", "taken"),
    [
        (
            "external_field]\nquadratic = [[100, 0, 0], [0, 120, 0], [0, 0, 150]]",
            (*GAS, "body.rotation.rate=0"),
            22_463,
        ),
        ("external_field]\npoint_mass = 100\nsoftening = 0.5", (*GAS, "body.rotation.rate=0"), 52_336),
        ("rotating_frame]\nrate = 5", (ROUND, "body.rotation.rate=0"), 1465),
    ],
)
def test_ellipsoids_in_fields_take_the_steps_that_are_predicted(effect, settings, taken):
    """Of what their runs took, which fall and swing at the pace of the field: their own gravity would ask for 400."""
    text = ELLIPSOID.replace("[time]", f"[effects.{effect}\n[time]")
    scene = load.loads(text, ("time.end=50", "output.series_every=0.5", *settings))
    assert taken / 1.8 < predict(scene, machine.shipped()).steps < 1.8 * taken
