"""What is said of a scene before it is run is said of every scene: rotating stars, axes of any length, fast zones."""

import math

import numpy as np
import pytest

from astroinertia.build.sph import problem_of
from astroinertia.effects.one_zone import Zone, difference, motion
from astroinertia.scene import load
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.plan import plan
from astroinertia.scene.scales import code_units

SCENE = """
name = "scene"
[body]
kind = "uniform"
particles = 100
mass = "1 kg"
radius = "1 m"
rotation = { rate = "1 rad/s", axis = [0, LENGTH, LENGTH] }
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = "1 s"
"""
STAR = """
name = "star"
units = "code"
[body]
kind = "rotating_star"
particles = 100
mass = 2.0
radius = 3.0
index = 1.0
MORE
[equation_of_state]
kind = "isothermal"
sound_speed = 0.1
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""


def test_an_axis_of_any_length_gives_the_same_rotation():
    short, long = (characteristic(load.loads(SCENE.replace("LENGTH", length))) for length in ("1e-30", "1e30"))
    assert np.allclose(short.spin_axis, [0, math.sqrt(0.5), math.sqrt(0.5)], rtol=1e-14)
    assert np.allclose(long.spin_axis, short.spin_axis, rtol=1e-14)
    assert long.rotational == pytest.approx(short.rotational, rel=1e-14)


def test_a_rotating_star_with_a_flow_besides_turns_about_its_own_axis():
    """With G antisymmetric about z the two rates add up, or cancel where the star turns the other way."""
    turning = "velocity_gradient = [[0.0, -0.05, 0.0], [0.05, 0.0, 0.0], [0.0, 0.0, 0.0]]"
    alone = characteristic(load.loads(STAR.replace("MORE", "rate = 0.1")))
    forwards = characteristic(load.loads(STAR.replace("MORE", f"rate = 0.1\n{turning}")))
    backwards = characteristic(load.loads(STAR.replace("MORE", f"rate = -0.1\n{turning}")))
    assert alone.spin == pytest.approx(0.1)
    assert forwards.spin == pytest.approx(0.15) and forwards.spin_axis == pytest.approx((0.0, 0.0, 1.0))
    assert backwards.spin == pytest.approx(0.05) and backwards.spin_axis == pytest.approx((0.0, 0.0, -1.0))


@pytest.mark.parametrize("axis_ratio", [1.0 - 1e-6, 1.0 - 1e-9])
def test_a_nearly_round_star_turns_as_little_as_its_axes_say(axis_ratio):
    """T/|W| of Maclaurin's spheroids is 2 e^2/15 of the axes' e: the difference of large terms has no digits there."""
    star = characteristic(load.loads(STAR.replace("MORE", f'law = "maclaurin"\naxis_ratio = {axis_ratio!r}')))
    assert star.rotational == pytest.approx(2.0 / 15.0 * (1.0 - axis_ratio**2) * star.gravitational, rel=1e-5)


@pytest.mark.parametrize(("rate", "share"), [("1e9 rad/s", "3.3"), ("1e7 rad/s", "0.033"), ("1e6 rad/s", None)])
def test_a_plan_warns_of_rotation_near_or_beyond_the_speed_of_light(rate, share):
    """A surface at 1 m turns at rate/(3e8 s-1) of c; relativity changes what counts by the square of that."""
    text = plan(load.loads(SCENE.replace("LENGTH", "1").replace("1 rad/s", rate))).text()
    assert ("WARNING: the surface turns" in text) == (share is not None)
    assert share is None or f"turns at {share} of the speed of light" in text


def test_a_rotating_star_of_isothermal_gas_is_planned():
    assert "Jeans mass" in plan(load.loads(STAR.replace("MORE", "rate = 0.1"))).text()


@pytest.mark.parametrize("rate", [1e-60, 1e-8, 1e8, 1e60])
def test_a_zone_moves_the_same_in_its_own_time_whatever_that_is(rate):
    """Errors allowed in plain numbers leave nothing of the motion where rates are far from 1."""
    slow, fast = (Zone(each**2, 0.7 * each**2, 0.1 * each**2, 1.5, 0.1 * each) for each in (1.0, rate))
    one, other = motion(slow, 5.0), motion(fast, 5.0 / rate)
    assert np.allclose(other.size, one.size, rtol=1e-9)
    assert np.allclose(other.speed / rate, one.speed, rtol=1e-9, atol=1e-12)


def test_a_much_faster_motion_with_other_forces_is_not_followed_for_ever():
    """It pulsates 1e20 times while the zone itself moves once."""
    assert difference(Zone(1.0, 1.0, 0.0, 5 / 3), 10.0, weight=1e40, pressure=1.1e40) == 1.0


@pytest.mark.parametrize(
    ("asked", "particles", "taken", "words"),
    [
        ("auto", 1000, "float64", "float64, for no more than 1000 particles"),
        ("auto", 1001, "mixed", "mixed, for more than 1000 particles"),
        ("mixed", 100, "mixed", "mixed"),
        ("float64", 5000, "float64", "float64"),
    ],
)
def test_the_precision_of_few_particles_is_one_where_it_may_be_chosen(asked, particles, taken, words):
    """What is planned is what the engine gets, which says it in its results."""
    settings = [f'numerics.precision="{asked}"', f"body.particles={particles}", "body.relax=false"]
    scene = load.loads(SCENE.replace("LENGTH", "1"), settings)
    engine = next(line for line in plan(scene).sections["model and numerics"] if line.name == "engine")
    assert (engine.value, engine.why) == ("numba_cpu", words)
    problem, _ = problem_of(scene, code_units(scene))
    assert problem.engine.precision == scene.precision == taken


@pytest.mark.parametrize(
    ("end", "said", "every"),
    [
        ("180 kyr", "180 kyr", "900 yr"),
        ("6 h", "6 h", "1.8 min"),
        ("90 ms", "90 ms", "450 µs"),
        ("1 d", "1 d", "7.2 min"),
    ],
)
def test_times_of_a_plan_are_in_units_that_people_read(end, said, every):
    lines = {
        line.name: line.value
        for line in plan(load.loads(SCENE.replace("LENGTH", "1"), [f"time.end='{end}'"])).sections["time and output"]
    }
    assert lines["end"] == said and lines["series"] == f"every {every}"


def test_a_spin_over_that_of_keplers_law_is_not_called_the_fraction_of_break_up():
    star = STAR.replace("MORE", "breakup_fraction = 0.8")
    lines = {line.name: line.value for line in plan(load.loads(star)).sections["characteristic numbers"]}
    assert float(lines["spin over √(G M/R^3)"]) > 0.8  # the star's own gravity is larger at its equator
