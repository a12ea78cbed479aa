"""[sweep] in a scene: which members it makes, and what is refused before anything is run."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.scene import load, sweep
from astroinertia.scene.sweep_values import MOST_MEMBERS, coordinate, short_text
from astroinertia.scene.text import without_table
from astroinertia.units import SOLAR_MASS, any_quantity

BASE = """\
name = "core"
model = "scaling"
[sweep]
{sweep}
[body]  # what varies
kind = "polytrope"
index = 1.5
mass = "1.4 Msun"
radius = "1500 km"
[body.rotation]
period = "30 s"
[effects.gravity]
[time]
end = "0.3 s"
"""
MASSES = '"body.mass" = ["1 Msun", "2 Msun"]'


def made(text, overrides=()):
    found = sweep.loads(BASE.replace("{sweep}", text), overrides)
    assert found is not None
    return found


def refusal(text, overrides=()):
    with pytest.raises(SceneError) as caught:
        made(text, overrides)
    message = str(caught.value)
    assert message.endswith((".", "?")) and "\n" not in message
    return message


def test_a_grid_has_every_combination_the_last_key_fastest():
    found = made(f'{MASSES}\nbody.radius = {{start = "1000 km", stop = "2000 km", number = 3}}')
    assert (found.kind, found.keys) == ("grid", ("body.mass", "body.radius"))
    radii = ("1000.0 km", "1500.0 km", "2000.0 km")
    assert found.members == tuple((mass, radius) for mass in ("1 Msun", "2 Msun") for radius in radii)
    scene = found.scene(4)
    assert scene.body.mass == pytest.approx(2 * SOLAR_MASS, rel=1e-15)
    assert scene.body.radius == 1.5e6
    assert scene.body.index == 1.5  # what does not vary is as the scene has it


def test_values_are_shown_with_six_digits_of_their_numbers_and_nothing_else_changed():
    given = ("-3.16227766016838 s", 100.0, "rigid", "1.4999999999e5 km", "G15.25", True, [0.5, 1.25e-7])
    assert list(map(short_text, given)) == [
        "-3.16228 s",
        "100",
        "rigid",
        "150000 km",
        "G15.25",
        "True",
        "[0.5, 1.25e-07]",
    ]


def test_a_logarithmic_range_keeps_its_ends_and_whole_numbers_stay_whole():
    ratio = made('"body.rotation.period" = {start = "3 s", stop = "300 s", number = 5, scale = "log"}')
    values = [float(value.split()[0]) for (value,) in ratio.members]
    assert values[0] == 3.0 and values[-1] == 300.0
    np.testing.assert_allclose(np.diff(np.log(values)), math.log(100.0) / 4, rtol=1e-12)
    steps = made('"time.max_steps" = {start = 10, stop = 40, number = 4}')
    assert [type(value) for (value,) in steps.members] == [int] * 4
    assert steps.scene(2).time.max_steps == 30


def test_a_hypercube_has_one_member_in_each_stratum_of_every_parameter():
    samples = 16
    found = made(
        f'samples = {samples}\nseed = 5\n"body.index" = {{uniform = [1.0, 2.0]}}\n'
        '"body.radius" = {log_uniform = ["10 km", "1000 km"]}\n"time.max_steps" = {integers = [1, 4]}'
    )
    assert (found.kind, len(found.members)) == ("Latin hypercube", samples)
    index, radius, steps = zip(*found.members, strict=True)
    strata = np.arange(samples)
    np.testing.assert_array_equal(np.sort(np.floor((np.array(index) - 1.0) * samples)), strata)
    shares = np.log10([float(each.split()[0]) / 10.0 for each in radius]) / 2.0
    np.testing.assert_array_equal(np.sort(np.floor(shares * samples)), strata)
    assert [steps.count(value) for value in (1, 2, 3, 4)] == [4, 4, 4, 4]
    assert found == made(
        f'samples = {samples}\nseed = 5\n"body.index" = {{uniform = [1.0, 2.0]}}\n'
        '"body.radius" = {log_uniform = ["10 km", "1000 km"]}\n"time.max_steps" = {integers = [1, 4]}'
    )
    assert found.members != made('samples = 16\nseed = 6\n"body.index" = {uniform = [1.0, 2.0]}').members


def test_a_normal_distribution_has_its_mean_and_width():
    found = made('samples = 400\n"body.index" = {normal = [1.5, 0.1]}')
    values = np.array([value for (value,) in found.members])
    assert values.mean() == pytest.approx(1.5, abs=1e-3)  # strata leave 1/sqrt(400) of the scatter of plain samples
    assert values.std() == pytest.approx(0.1, rel=0.02)


def test_a_list_varies_keys_together():
    found = made(
        'members = [{"body.mass" = "1 Msun", body.radius = "9 km"}, {body = {radius = "8 km", mass = "2 Msun"}}]'
    )
    assert found.kind == "list"
    assert found.members == (("1 Msun", "9 km"), ("2 Msun", "8 km"))


def test_a_key_that_only_the_sweep_gives_need_not_stand_in_the_scene():
    text = BASE.replace('mass = "1.4 Msun"\n', "").replace("{sweep}", MASSES)
    found = sweep.loads(text)
    assert found is not None and found.scene(1).body.mass == pytest.approx(2 * SOLAR_MASS)


def test_overrides_reach_members_and_the_sweep_itself():
    found = made(MASSES, ["body.index=2.5"])
    assert found.scene(0).body.index == 2.5 and "body.index=2.5" in found.scene(0).overrides
    resized = made('samples = 4\n"body.index" = {uniform = [1.0, 2.0]}', ["sweep.samples=9"])
    assert len(resized.members) == 9
    again = sweep.loads(resized.source)
    assert again is not None and again.members == resized.members


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "needs a parameter"),
        ('"body.mas" = ["1 Msun"]', "[body] mas is not a known key; did you mean 'mass'? (member-0000"),
        ('"body.mass" = ["1 Msun", "3 km"]', "'3 km' is not a mass; write for example \"1.4 Msun\" (member-0001: b"),
        ('model = ["scaling", "sph"]', 'sph and ellipsoid need; for a perfect gas, it has kind = "ideal" (member-0001'),
        ("sampels = 3", "did you mean 'samples'"),
        ('bodi.mass = ["1 Msun"]', "is not a known key; did you mean 'bodies'"),
        ("index = [1, 2]", "is not a known key; a key of a table has the table before it, as body.mass has"),
        ('name = ["a", "b"]', "line 4: [sweep] name cannot vary"),
        ('"body.mass" = ["1 Msun", "1 Msun"]', "twice"),
        ('"body.radius" = ["1 km", "1000 m"]', "has the value"),
        ('"body.index" = [1.5, "3/2"]', "twice"),
        ('"body.index" = [1, 1.0]', "twice"),
        ('"body.mass" = []', "at least one value"),
        ('"body.mass" = "1 Msun"', "must be a list of values, a range"),
        ('"body.mass" = {start = "1 Msun", stop = "2e33 kg", number = 4}', "give both in the same unit"),
        ('"body.mass" = {strat = "1 Msun", stop = "2 Msun", number = 4}', "did you mean 'start'"),
        ('"body.mass" = {start = "1 Msun", stop = "2 Msun"}', "number is missing"),
        ('"body.index" = {start = 0, stop = 1, number = 10, scale = "lin"}', "one of linear, log"),
        ('"body.index" = {start = 0, stop = 1, number = 10, scale = "log"}', "ends must be positive"),
        ('"body.index" = {start = 0, stop = 1, number = 1000000000}', "from 2 to 10000"),
        ('"body.index" = {start = 0, stop = inf, number = 10}', "finite"),
        ('"body.mass" = {uniform = ["1 Msun", "2 Msun"]}', "needs samples"),
        ('samples = 1000000000\n"body.index" = {uniform = [0, 1]}', "from 1 to 10000"),
        ('samples = 3\n"body.index" = [0, 1]', "must be a distribution"),
        ('samples = 3\n"body.index" = {unifrm = [0, 1]}', "did you mean 'uniform'"),
        ('samples = 3\n"body.index" = {uniform = [1, 0]}', "less than its second"),
        ('samples = 3\n"body.index" = {normal = [1, 0]}', "standard deviation"),
        ('samples = 3\n"body.index" = {integers = [1, 2.5]}', "whole numbers"),
        ('seed = 3\n"body.index" = [0, 1]', "needs samples"),
        ('members = [{"body.mass" = "1 Msun"}, {"body.index" = 1}]', "member-0001 and member-0000 differ"),
        ("members = []", "list of tables"),
        ('members = [{"body.mass" = "1 Msun"}]\n"body.index" = [1]', "nothing else may stand beside it"),
        ('"body.index" = [2026-01-01]', "date or time"),
        ('"body..mass" = ["1 Msun"]', "names joined by dots"),
    ],
)
def test_what_is_wrong_is_reported_before_anything_is_run(text, words):
    assert words in refusal(text)


def test_too_many_members_are_refused_before_they_are_made():
    axes = [f'"body.rotation.axis{k}" = {{start = 0, stop = 1, number = {MOST_MEMBERS}}}' for k in range(4)]
    assert f"has {MOST_MEMBERS**4} members" in refusal("\n".join(axes))


def test_an_override_of_what_varies_is_refused():
    assert "--set body.mass=3" in refusal(MASSES, ["body.mass=3 Msun"])
    assert "varies" in refusal(MASSES, ["body={}"])
    assert refusal(MASSES, ["body.index=9"]).startswith("--set body.index=9: ")


def test_a_scene_of_one_run_is_no_sweep_and_a_sweep_no_scene():
    one = BASE.replace("[sweep]\n{sweep}\n", "")
    assert sweep.loads(one) is None
    with pytest.raises(
        SceneError,
        match=r"\[sweep\] makes several runs of a scene: `run` and `plan` take its file, and run_scene a dict",
    ):
        load.loads(BASE.replace("{sweep}", MASSES))
    with pytest.raises(SceneError, match="did you mean 'sweep'"):
        load.loads(one + "[sweeps]\n")


def test_the_text_without_a_table_keeps_its_lines_and_comments():
    text = BASE.replace("{sweep}", '"body.mass" = [\n"1 Msun"]\n[sweep.body]\nindex = [1]')
    cut = without_table(text, "sweep")
    assert cut.split("\n").index("[body]  # what varies") == text.split("\n").index("[body]  # what varies")
    assert "sweep" not in cut and "Msun" in cut
    inline = 'sweep = {"body.mass" = ["1 kg"]}\nname = "a"  # b\n'
    assert without_table(inline, "sweep") == 'name = "a"\n'


def test_coordinates_are_in_si_or_texts():
    values, unit = coordinate(["500 km", "1 Mm"])
    assert unit == "m" and values.tolist() == [5e5, 1e6]
    values, unit = coordinate([1, 2.5])
    assert unit == "1" and values.tolist() == [1.0, 2.5]
    values, unit = coordinate(["3/2", 2])
    assert unit == "1" and values.tolist() == [1.5, 2.0]
    values, unit = coordinate(["rigid", "scaling"])
    assert unit is None and values.tolist() == ["rigid", "scaling"]
    values, unit = coordinate([[1, 2], [3, 4]])
    assert unit is None and values.tolist() == ["[1, 2]", "[3, 4]"]
    assert coordinate(["1 m", "1 s"])[1] is None
    value, unit = any_quantity("1 cycle/s")
    assert unit == "rad s-1" and value == pytest.approx(2 * math.pi)


def test_a_sweep_is_read_without_engines():
    script = (
        "import sys, json; from astroinertia.scene import sweep\n"
        f"found = sweep.loads({BASE.replace('{sweep}', MASSES)!r})\n"
        "heavy = [name for name in ('jax', 'numba', 'distributed') if name in sys.modules]\n"
        "print(json.dumps([len(found.members), heavy]))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=120)
    assert json.loads(done.stdout) == [2, []]
