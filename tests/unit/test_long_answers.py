"""Runs that take long are never silent, and take no more steps than they may."""

import io
import re
import time

import numpy as np
import pytest
from rich.console import Console

from astroinertia.build.assemble import prepare
from astroinertia.build.fluids import equation_of_state
from astroinertia.engines import adaptive
from astroinertia.errors import NumericalError, SceneError
from astroinertia.matter import cold_matter
from astroinertia.models.ellipsoid import evolution as ellipsoid
from astroinertia.models.scaling.homology import Kepler
from astroinertia.run import loop, meter as cli_meter
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.sph.placement import isotropised, place
from astroinertia.sph.profiles import power_law

PULSATING = """
name = "pulsating"
model = "MODEL"
units = "code"
[body]
kind = "polytrope"
index = 1.0
mass = 1.0
radius = 1.0
MORE
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 1e8
max_steps = 3
[output]
series_every = 1e8
"""
GASES = """
name = "gas"
units = "code"
[body]
kind = "uniform"
particles = 50
mass = 1.0
radius = 1.0
[equation_of_state]
EQUATION
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""


@pytest.mark.slow
def test_an_ellipsoid_takes_no_more_steps_than_it_may(tmp_path):
    """Up to its first record it would pulsate 1e7 times: it looks up after every part of them."""
    scene = load.loads(PULSATING.replace("MODEL", "ellipsoid").replace("MORE", "pressure_fraction = 0.5"))
    reports = []
    loop.run_scene(scene, tmp_path / "run", reports.append)
    assert 3 <= reports[-1].step <= ellipsoid.AT_ONCE
    assert 0.0 < reports[-1].time < 1e6


def test_what_would_take_far_too_many_steps_ends_before_it_has_taken_them():
    """Judged by the length of the first; a slow beginning and what is done before the end go on."""

    def part(time, steps):
        return adaptive.Advanced(
            {}, np.array(time), np.array(1.0), np.array(steps), *map(np.array, (False, True, True))
        )

    begun, end = 50.0, 150.0
    assert adaptive.Way().goes_on(begun, part(begun, adaptive.JUDGED - 1), end)
    assert adaptive.Way().goes_on(begun, part(51.0, adaptive.JUDGED), end)
    assert not adaptive.Way().goes_on(begun, part(50.001, adaptive.JUDGED), end)
    way = adaptive.Way()
    assert way.goes_on(begun, part(100.0, adaptive.MOST_STEPS - 1), end)
    assert not way.goes_on(100.0, part(149.0, 1), end)
    assert way.goes_on(149.0, part(149.5, 1), end)  # the way to the next record begins again


def test_options_that_contradict_each_other_are_refused_before_anything_takes_long(tmp_path, monkeypatch):
    monkeypatch.setattr(loop, "metadata", lambda scene: pytest.fail("the body was made"))
    scene = load.loads(
        GASES.replace("EQUATION", 'kind = "ideal"') + "[effects.viscosity]\nalpha_max = 0.5\nalpha_min = 0.6\n"
    )
    with pytest.raises(SceneError, match=r"\[effects.viscosity\] alpha_min must not be above alpha_max"):
        loop.run_scene(scene, tmp_path / "run")


def test_an_equilibrium_whose_entropy_no_number_holds_is_refused():
    text = GASES.replace("EQUATION", 'kind = "ideal"\ngamma = 8.9').replace("mass = 1.0", "mass = 2e-31")
    scene = load.loads(text.replace("\nradius = 1.0", "\nradius = 80.0"))
    with pytest.raises(SceneError, match="larger than any number: take a smaller gamma"):
        prepare(scene)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "mass", "message"),
    [
        ('tillotson = "iron"', "2e10", "mean density of 4.77e-06 kg m-3, too far below 0.078 kg m-3, where the table"),
        ('tillotson = "ice", tension = true', "1.3e18", "mean density of 310 kg m-3, too far below 458 kg m-3"),
    ],
)
def test_a_body_far_thinner_than_its_materials_table_is_refused(material, mass, message):
    text = GASES.replace("EQUATION", f'kind = "materials"\nmaterials = [{{ name = "matter", {material} }}]')
    text = text.replace('units = "code"\n', "").replace("mass = 1.0", f'mass = "{mass} kg"')
    with pytest.raises(SceneError, match=re.escape(message)):
        prepare(load.loads(text.replace("radius = 1.0", 'radius = "1e5 m"').replace("end = 1.0", 'end = "1 yr"')))


def test_a_star_too_stiff_to_settle_is_refused():
    star = 'kind = "rotating_star"\nindex = 5e-324\naxis_ratio = 0.8'
    scene = load.loads(
        GASES.replace("EQUATION", 'kind = "isothermal"\nsound_speed = 1.0').replace('kind = "uniform"', star)
    )
    with pytest.raises(SceneError, match=r"proportion to density\^inf, which is too steep to settle particles with"):
        prepare(scene)


@pytest.mark.slow
def test_an_energy_beyond_a_materials_table_is_refused():
    """At a hundred-millionth of its density: what was taken for it had an energy of the other sign."""
    text = GASES.replace("EQUATION", 'kind = "materials"\nmaterials = [{ name = "ice", tillotson = "ice" }]')
    text = text.replace('units = "code"\n', "").replace("mass = 1.0", 'mass = "1.78e29 kg"')
    text = text.replace("radius = 1.0", 'radius = "1.43e11 m"\nspecific_internal_energy = "8.5e7 m2 s-2"')
    with pytest.raises(NumericalError, match="50 particles cannot have the specific energy that they are given"):
        prepare(load.loads(text.replace("end = 1.0", 'end = "1 yr"')))


def test_a_body_that_flies_apart_is_followed_for_any_time():
    """At last it coasts: s = s' t, with s'^2/2 the energy."""
    free = Kepler(3.0, 1.0, 1.0, 1.0)
    for moment in (1e3, 1e8, 1e30, 1e60):
        found = free.at(moment)
        assert found.scale == pytest.approx(np.sqrt(2 * free.energy) * moment, rel=1e-2 if moment < 1e4 else 1e-6)


def test_a_scene_whose_pressures_no_numbers_hold_is_refused():
    pieces = "densities = [1e-30, 1e30]\ngammas = [10.0, 1.1, 10.0]\nconstant = 1.0"
    scene = load.loads(GASES.replace("EQUATION", f'kind = "piecewise_polytropic"\n{pieces}'))
    with pytest.raises(SceneError, match="beyond what numbers hold"):
        equation_of_state(scene, code_units(scene), None)
    assert cold_matter.piecewise_polytropic([1e-5, 1e5], [2.0, 1.5, 2.0], 1.0)


def test_particles_in_a_plane_cannot_be_spread():
    with pytest.raises(SceneError, match="lie on a line or in a plane"):
        isotropised(np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]]), 0.1)
    with pytest.raises(SceneError, match="lie on a line or in a plane"):
        place(power_law(2.999), 20, "random", 1)


def test_a_run_of_which_nothing_is_heard_says_that_it_works(monkeypatch):
    monkeypatch.setattr(cli_meter, "LONGEST_SILENCE", 0.1)
    screen = io.StringIO()
    with cli_meter.Meter(Console(file=screen)) as meter:
        while screen.getvalue().count("\n") < 2:
            time.sleep(0.01)
        meter.tell(loop.Progress(1.0, 2.0, 7, 0.1, 0.0, 0.0, 1.0))
        while "after step 7" not in screen.getvalue():
            time.sleep(0.01)
    assert not meter.voice.speaker.is_alive()
    assert screen.getvalue().startswith("0 s: preparing the body")


def test_the_ellipsoid_of_the_steepest_power_law_is_refused_in_a_sentence():
    text = PULSATING.replace("MODEL", "ellipsoid").replace("MORE", "").replace('"polytrope"', '"power_law"')
    scene = load.loads(text.replace("index = 1.0", "exponent = 2.999"))
    with pytest.raises(SceneError, match="no bound"):
        prepare(scene)
