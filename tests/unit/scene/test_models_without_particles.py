"""Scenes of the models without particles: what each needs, what it refuses, and what the plan says of it."""

import pytest

from astroinertia.errors import SceneError
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan

TOP = """\
name = "top"
model = "rigid"
[body]
kind = "rigid"
mass = "2 kg"
moments = ["1 kg m2", "2 kg m2", "3 kg m2"]
[body.rotation]
rate = "1 rad/s"
[effects]
[time]
end = "10 s"
"""
EARTH = """\
name = "earth"
model = "rigid"
[body]
kind = "rigid"
mass = "1 Mearth"
radius = "6378 km"
moment_ratios = [0.3296, 0.3296, 0.3307]
[effects]
[[companions]]
name = "sun"
mass = "1 Msun"
semi_major_axis = "1 au"
mean_anomaly = "30 deg"
[[companions]]
name = "moon"
mass = "7.35e22 kg"
position = ["384400 km", "0 km", "-3 km"]
velocity = ["0 km/s", "1 km/s", "0 km/s"]
[time]
end = "1 yr"
"""
STAR = """\
name = "star"
model = "scaling"
[body]
kind = "polytrope"
index = 1.5
mass = "1 Msun"
radius = "1 Rsun"
[effects.gravity]
[effects.viscosity]
[time]
end = "1 h"
"""


def refusal(text, *overrides):
    with pytest.raises(SceneError) as caught:
        loads(text, overrides)
    return str(caught.value)


def test_a_rigid_body_needs_no_particles_no_fluid_and_no_radius():
    scene = loads(TOP)
    assert scene.body.moments == (1.0, 2.0, 3.0) and scene.equation_of_state is None
    assert code_units(scene).length == pytest.approx(1.5**0.5)
    assert loads(scene.to_toml()) == scene


def test_companions_are_read_in_si_with_angles_in_radians():
    sun, moon = loads(EARTH).companions
    assert sun.mean_anomaly == pytest.approx(0.5235987755982988) and sun.semi_major_axis == pytest.approx(
        1.495978707e11
    )
    assert moon.position == (3.844e8, 0.0, -3000.0) and moon.around == "body"


@pytest.mark.parametrize(
    ("text", "change", "expected"),
    [
        (TOP, "body.moments=['1 kg m2', '2 kg m2', '3.1 kg m2']", "sum of the others"),
        (TOP, "body.moments=['0 kg m2', '0 kg m2', '0 kg m2']", "two at least are positive"),
        (TOP, "body.moment_ratios=[0.3, 0.3, 0.4]", "exactly one of moments and moment_ratios"),
        (TOP, "body.axes_at_start=[[1,0,0],[1,1,0],[0,0,1]]", "right angles"),
        (TOP, "body.axes_at_start=[[1,0,0],[0,1,0],[0,0,-1]]", "right-handed"),
        (TOP, "model='sph'", "equation_of_state"),
        (TOP, "model='solid'", "model"),
        (TOP, "body.change={times=['1 s'], factors=[0.5, 0.2]}", "as many times as factors"),
        (TOP, "body.change={times=['2 s', '1 s'], factors=[0.5, 0.2]}", "times that rise"),
        (TOP, "output.series_steps=3", "series_every"),
        (TOP, "effects.damping={time_scale='1 s'}", "damping] belongs to the model sph or ellipsoid; rigid has"),
        (EARTH, "orbits.integrator='leapfrog'", "ias15"),
        (STAR, "model='sph'", "equation_of_state"),
        (STAR, "model='rigid'", None),
        (
            STAR,
            "effects.tide={mass='1 Msun', position=['1 au','0 au','0 au']}",
            "[effects.tide] belongs to the model sph or ellipsoid",
        ),
    ],
)
def test_what_a_model_cannot_use_is_refused_in_one_sentence(text, change, expected):
    if expected is None:
        assert loads(text, [change]).model == "rigid"
        return
    message = refusal(text, change)
    assert expected in message and "\n" not in message


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('semi_major_axis = "1 au"', "", "one of semi_major_axis and period"),
        ('velocity = ["0 km/s", "1 km/s", "0 km/s"]', "", "both position and velocity"),
        ('name = "moon"', 'name = "sun"', "the name sun twice"),
        ('mass = "7.35e22 kg"', 'mass = "7.35e22 kg"\naround = "mars"', "mars, which is not listed"),
        ('mass = "7.35e22 kg"', 'mass = "7.35e22 kg"\neccentricity = 0.1', "eccentricity must not be given"),
        ('mean_anomaly = "30 deg"', "mean_anomaly = 30", "unit"),
    ],
)
def test_an_orbit_that_is_not_one_is_refused(old, new, expected):
    assert expected in refusal(EARTH.replace(old, new))


def test_particles_are_asked_for_by_sph_alone():
    fluid = STAR.replace("[effects.gravity]", '[equation_of_state]\nkind = "ideal"\n[effects.gravity]')
    assert "particles is missing" in refusal(fluid, "model=sph")
    assert loads(fluid, ["model=sph", "body.particles=100"]).body.particles == 100


def test_the_plan_of_a_cheap_model_speaks_of_it_and_not_of_particles():
    planned = plan(loads(STAR, ["body.particles=500"]))
    text = planned.text()
    assert "model: scaling" in text and "particles: 500" not in text and "wendland" not in text
    assert [line.kind for line in planned.effects if line.skipped] == ["viscosity"]
    assert "sun: " in plan(loads(EARTH)).text() and "ias15" in plan(loads(EARTH)).text()
