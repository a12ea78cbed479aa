"""What orbits of companions are predicted to take before the first step."""

import math

import pytest

from astroinertia.costs import machine
from astroinertia.costs.plan_lines import lines
from astroinertia.costs.prediction import predict, tabulating
from astroinertia.costs.probe_scenes import RIGID
from astroinertia.scene import load

TORQUE = "[effects.gravity_gradient]\n"
PERIOD = 2.0 * math.pi  # of an axis of 1
TURNS = 1e4 / PERIOD  # in a run of RIGID


def scene(*moons: str, orbits: str = "", settings: tuple[str, ...] = ()):
    text = RIGID.replace("[effects]\n", "") + orbits + TORQUE
    for number, moon in enumerate(moons):
        text += f'[[companions]]\nname = "moon_{number}"\nmass = 1e-6\n{moon}\n'
    return load.loads(text, ("numerics.integrator='splitting'", *settings))


def moon(axis: float = 1.0, eccentricity: float = 0.0) -> str:
    return f"semi_major_axis = {axis}\neccentricity = {eccentricity}"


@pytest.mark.parametrize(
    ("moons", "orbits", "measured"),
    [
        *(([moon(1.0, e)], "", ms) for e, ms in ((0.0, 0.53), (0.05, 0.82), (0.2, 1.21), (0.5, 1.85), (0.9, 3.47))),
        ([moon(1.0, 0.05), moon(2.08, 0.05)], "", 1.38),
        ([moon(1.8 ** (k / 1.5), 0.05) for k in range(5)], "", 2.68),
        ([moon(1.0, 0.05)], 'integrator = "whfast"', 1.22),
    ],
)
def test_orbits_take_as_long_as_measured(moons, orbits, measured):
    """Milliseconds of a turn of the innermost, of one thread of a Xeon."""
    found = tabulating(scene(*moons, orbits=f"[orbits]\n{orbits}\n" if orbits else ""), machine.shipped())
    assert measured / 1.35 < 1e3 * found.wall / TURNS < 1.35 * measured


def test_a_plan_says_what_orbits_take_and_what_steps_leave_of_them():
    """Those of a run that is ended by its steps are found as far as it comes, the first ones at least."""
    shipped = machine.shipped()
    whole, few, many = (
        predict(scene(moon(0.1), settings=limit), shipped)
        for limit in ((), ("time.max_steps=10",), ("time.max_steps=1000000000",))
    )
    name = "orbits of companions"
    assert whole.parts[name].wall == pytest.approx(TURNS * 0.1**-1.5 * shipped.seconds["orbit"].wall, rel=1e-5)
    assert many.parts[name] == whole.parts[name] and many.steps == whole.steps
    assert few.parts[name].wall < 0.02 * whole.parts[name].wall and few.steps == 10
    shown = {line.name: line.value for line in lines(scene(moon(0.1)), whole)}
    assert shown[name].endswith("s") and name not in shown["the rest"]


def test_orbits_that_steps_find_take_nothing_before():
    acted_on = scene(moon(), orbits="[orbits]\nback_reaction = true\n")
    assert tabulating(acted_on, machine.shipped()).wall == 0.0
    assert "orbits of companions" not in predict(acted_on, machine.shipped()).parts
