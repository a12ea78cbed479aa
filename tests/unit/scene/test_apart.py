"""`effects = "auto"` puts nothing on of its own accord that the scene would refuse beside what it asks for."""

import pytest

from astroinertia.build.assemble import refuse_contradictions
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads

STAR = """name = "star"
model = "{model}"
effects = "auto"
[body]
kind = "uniform"
mass = "2.8e30 kg"
radius = "13 km"
axes = [1.0, 0.7, 0.5]
rotation = {{ period = "1 ms" }}
{particles}
[equation_of_state]
kind = "ideal"
gamma = 2.0
[time]
end = "1 s"
"""
COMPANION = '[[companions]]\nname = "other"\nmass = "2.8e30 kg"\nsemi_major_axis = "50 km"\n'
LIVE = '[candidates.companions]\nmotion = "live"\n' + COMPANION
FRAME = '[candidates.rotating_frame]\nrate = "100 rad/s"\n'
SINKS = '[candidates.sinks]\ndensity = "1e14 g/cm3"\nradius = "30 km"\n'
WAVES = "radiation_reaction"


def chosen(further, model="sph"):
    particles = "particles = 1000" if model == "sph" else ""
    return loads(STAR.format(model=model, particles=particles) + further)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("further", "model", "off", "words"),
    [
        (LIVE, "sph", WAVES, "acts on the fluid alone, so it cannot be listed with live companions; G M/"),
        (SINKS, "sph", WAVES, "acts on the fluid alone, so it cannot be listed with sinks; G M/"),
        (FRAME, "sph", WAVES, "in inertial axes, so it cannot be listed with rotating_frame; G M/"),
        (FRAME, "ellipsoid", WAVES, "in inertial axes, so it cannot be listed with rotating_frame; G M/"),
        (SINKS + COMPANION, "sph", "companions", 'can be listed with sinks only if their motion is "live"; '),
    ],
)
def test_what_the_scene_does_not_name_gives_way_with_that_reason(further, model, off, words):
    alone = chosen("", model)
    assert WAVES in alone.effects, "it is large"
    scene = chosen(further, model)
    assert off not in scene.effects and words in scene.reasons[off]
    refuse_contradictions(scene)


def test_relativity_weighs_the_fluid_alone_and_is_refused_beside_sinks():
    """Around a black hole matter would feel the relativity of what is left of the star; one in a binary has its own."""
    named = "[candidates.relativistic_potential]\n"
    refuse_contradictions(chosen(LIVE + named))
    with pytest.raises(SceneError, match=r"relativistic_potential\] acts on the fluid alone, .* with sinks"):
        refuse_contradictions(chosen(SINKS + named))


def test_what_the_scene_names_itself_is_refused_and_not_left_away():
    scene = chosen(LIVE + "[candidates.radiation_reaction]\n")
    with pytest.raises(SceneError, match=r"radiation_reaction\] acts on the fluid alone"):
        refuse_contradictions(scene)
