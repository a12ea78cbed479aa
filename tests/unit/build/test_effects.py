"""Effects that cannot act beside each other are refused before a run."""

import pytest

from astroinertia.build.assemble import refuse_contradictions
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads

SCENE = """name = "turning"
units = "code"
[body]
kind = "polytrope"
index = 1.5
particles = 100
mass = 1.0
radius = 1.0
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.rotating_frame]
rate = 0.3
[time]
end = 1.0
"""
COMPANION = """[effects.companions]
[[companions]]
name = "moon"
mass = 0.1
semi_major_axis = 8.0
"""


@pytest.mark.parametrize(
    ("further", "words"),
    [
        (
            "[effects.radiation_reaction]\nspeed_of_light = 10.0\n",
            "radiation_reaction. follows from how the quadrupole",
        ),
        (
            "[effects.dipole_braking]\nspeed_of_light = 9.0\nperiod = 6.0\nperiod_derivative = 0.1\n",
            "dipole_braking. follows from the spin",
        ),
        ('[effects.cooling]\nlaw = "beta"\nbeta = 3.0\n', 'cooling. by the law "beta" follows from the rotation'),
        (COMPANION, "companions. move on orbits"),
        ("[regions.core]\nbound = true\n", "regions.core. bound is judged"),
    ],
)
def test_what_is_of_inertial_axes_is_refused_in_a_rotating_frame(further: str, words: str) -> None:
    with pytest.raises(SceneError, match=f"{words}.* in inertial axes, so it cannot be .*with rotating_frame"):
        refuse_contradictions(loads(SCENE + further))


def test_what_does_not_depend_on_the_frame_is_not() -> None:
    refuse_contradictions(loads(SCENE + "[effects.cooling]\ntime_scale = 3.0\n[regions.core]\ninnermost_mass = 0.5\n"))


@pytest.mark.parametrize(
    ("listed", "further"),
    [
        ("cooling", "[effects.cooling]\ntime_scale = 3.0\n"),
        ("viscosity", '[effects.viscosity]\nstress = "trace_free"\n'),
        ("pressure", '[effects.pressure]\ngradients = "integral"\n'),
    ],
)
def test_what_changes_heat_is_refused_before_the_run_where_matter_has_none(listed: str, further: str) -> None:
    scene = SCENE.replace("[effects.rotating_frame]\nrate = 0.3\n", "").replace("[effects.pressure]\n", further)
    refuse_contradictions(loads(scene))
    cold = scene.replace('"ideal"', '"isothermal"\nsound_speed = 1.0')
    with pytest.raises(SceneError, match=rf"effects.{listed}\] .*needs matter that can be warm"):
        refuse_contradictions(loads(cold))
