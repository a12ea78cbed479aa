"""Scenes: what they become, what is said of them, and what the program writes of its own."""

import dataclasses
import math
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.errors import SceneError
from astroinertia.scene import schema, sweep as sweeps
from astroinertia.scene.example import example_text
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.load import KINDS, load_file, loads
from astroinertia.scene.plan import cadence, code_units, plan, records, smoothing
from astroinertia.scene.text import toml_text, with_overrides
from astroinertia.units import DIMENSIONLESS, GRAVITATIONAL_CONSTANT, LIGHT, REQUIRED, SOLAR_MASS

SIMS = Path(__file__).parents[3] / "sims"

SCENE = """\
name = "test"
[body]
kind = "polytrope"
particles = 1000   # a comment
mass = "1.5 Msun"
radius = "1500 km"
index = 3
[body.rotation]
t_over_w = 0.01
[equation_of_state]
kind = "hybrid"
nuclear_density = "2e14 g/cm3"
[effects.gravity]
[effects.pressure]
[time]
end = "0.3 s"
"""


def refusal(*overrides: str, text: str = SCENE) -> str:
    with pytest.raises(SceneError) as caught:
        loads(text, overrides)
    return str(caught.value)


def same(one: schema.Scene, other: schema.Scene) -> bool:
    record = {"source", "overrides", "origin"}
    return one.model_dump(exclude=record) == other.model_dump(exclude=record)


def test_quantities_become_si():
    scene = loads(SCENE)
    assert scene.body.mass == pytest.approx(1.5 * SOLAR_MASS, rel=1e-15)
    assert scene.body.radius == 1.5e6
    assert scene.time.end == 0.3
    assert scene.equation_of_state.nuclear_density == pytest.approx(2e17)


def test_a_scene_is_frozen_through_and_through():
    scene = loads(SCENE)
    for part, name in ((scene, "name"), (scene.body, "mass"), (scene.body.rotation, "t_over_w"), (scene.time, "end")):
        with pytest.raises(ValidationError, match="frozen"):
            setattr(part, name, 1.0)


def test_code_units_take_plain_numbers_only():
    text = SCENE.replace('"1.5 Msun"', "1.0").replace('"1500 km"', "2.0").replace('"0.3 s"', "3.0")
    text = 'units = "code"\n' + text.replace('"2e14 g/cm3"', "100.0")
    scene = loads(text)
    assert scene.dimensionless
    assert (scene.body.mass, scene.body.radius, scene.time.end) == (1.0, 2.0, 3.0)
    assert code_units(scene) == DIMENSIONLESS
    assert "plain number" in refusal('body.mass="1 Msun"', text=text)
    assert "must have a unit" in refusal("body.mass=1.0")


def test_effect_options_are_complete_and_in_si():
    scene = loads(SCENE, ["effects.damping={time_scale='20 ms'}", "effects.viscosity.alpha_max=0.7"])
    assert list(scene.effects) == ["gravity", "pressure", "damping", "viscosity"]
    assert scene.effects["damping"]["time_scale"] == pytest.approx(0.02)
    assert scene.effects["viscosity"]["alpha_max"] == 0.7
    for kind, options in scene.effects.items():
        assert set(options) == set(CATALOGUE[kind].options)


def test_defaults_of_effects_do_not_depend_on_units():
    # defaults are filled in before units are converted, so a default with a dimension must be zero or absent
    for entry in CATALOGUE.values():
        for option in entry.options.values():
            if option.dimension in ("dimensionless", "choice", "boolean") or option.default in (None, REQUIRED, LIGHT):
                continue
            values = option.default if isinstance(option.default, tuple) else (option.default,)
            assert set(values) == {0.0}


@pytest.mark.slow
def test_what_runs_effects_is_not_imported_to_read_a_scene_and_to_plan_it():
    code = (
        "import gc, sys; from astroinertia.scene.load import load_file; from astroinertia.scene.plan import plan;"
        f"plan(load_file({str(SIMS / 'pulsar_collapse.toml')!r}));"
        "assert not {'jax', 'numba', 'xarray'} & set(sys.modules);"
        "from astroinertia.effects.effect import Effect;"
        "assert not [thing for thing in gc.get_objects() if isinstance(thing, Effect)]"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=SIMS.parent)


@pytest.mark.parametrize(
    ("override", "hint"),
    [
        ("body.mas=1", "did you mean 'mass'"),
        ("bdy.mass=1", "did you mean 'body'"),
        ("numerics.kernal='cubic'", "did you mean 'kernel'"),
        ("numerics.kernel='cubick'", "did you mean 'cubic'"),
        ("effects.gravty={}", "did you mean 'gravity'"),
        ("effects.viscosity.alpha_maximum=1", "did you mean 'alpha_max'"),
        ("body.kind='polytropic'", "did you mean 'polytrope'"),
        ("body.exponent=1", "belongs to the kind power_law"),
        ("body.rotation.t_over_v=0.1", "did you mean 't_over_w'"),
        ("body.rotation.angular_velocity='1 rad/s'", "did you mean 'rate'"),
        ("body.spin='1 rad/s'", "did you mean 'rotation'"),
        ("body.period='1 s'", "did you mean 'rotation.period'"),
        ("body.N=500", "did you mean 'particles'"),
        ("eos.kind='ideal'", "did you mean 'equation_of_state'"),
        ("effects.time='1 h'", "it is one of the scene itself: it stands above the first [table]"),
        ("time.accuracy=1e-3", "it is one of the scene itself: it stands above the first [table]"),
    ],
)
def test_misspelt_words_name_the_nearest(override, hint):
    assert hint in refusal(override)


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("regions.a-b.bound=true", '[regions] "a-b": must be letters, digits and _, 32 at most, a letter first'),
        ('name="-star"', "name: must be letters, digits, _ and -, 64 at most, a letter or a digit first"),
        ('companions=[{name="1st",mass="1 kg",period="1 d"}]', "digits, _ and -, 64 at most, a letter first"),
    ],
)
def test_a_name_is_refused_by_what_names_are_of_there(override, says):
    assert says in refusal(override)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("units={mass='1 Msun'}", "[units] length is missing (unit of length)."),
        ("units={mas='1 Msun', length='1 km'}", "[units] mas is not a known key; did you mean 'mass'?"),
        ("units=3", 'units: must be "code", "SI" or a table with mass and length, not 3.'),
        ("body.mass='-1 Msun'", "[body] mass: must be positive, not '-1 Msun'."),
        ("time.end='0 s'", "[time] end: must be positive, not '0 s'."),
        ("body.mass='1 Msum'", "[body] mass: 'Msum' is not a unit that is known here; did you mean Msun?"),
        ("body.mass='1 talent'", "[body] mass: 'talent' is not a unit that is known here."),
        (
            "body.change={times=[], factors=[]}",
            "[body.change] times: must be a list with at least 1 entry, not with 0.",
        ),
        ("numerics.neighbours=5", "[numerics] neighbours: must be at least 20, not 5."),
        ("numerics.order=3", "[numerics] order: must be one of 2, 4, 6, 8, not 3."),
        ("numerics.order='4'", "[numerics] order: must be one of 2, 4, 6, 8, not the text '4'."),
        ("numerics.neighbours=[60]", "[numerics] neighbours: must be a number, not a list."),
        (
            "body.rotation.obliquity='400 deg'",
            "[body.rotation] obliquity: must be at most 3.14159 rad, not the text '400 deg'.",
        ),
        (
            "effects.gravity.force_error='1e-3'",
            "[effects.gravity] force_error: must be a number without quotes, not the text '1e-3'.",
        ),
    ],
)
def test_a_value_that_may_be_of_several_kinds_is_refused_in_words_of_the_scene(override, message):
    assert refusal(override).endswith(f": {message}")


def test_a_scene_without_matter_is_shown_what_to_write():
    bare = SCENE.replace('[equation_of_state]\nkind = "hybrid"\nnuclear_density = "2e14 g/cm3"\n', "")
    assert refusal(text=bare).endswith('need; for a perfect gas, it has kind = "ideal".')
    assert loads(bare, ['equation_of_state.kind="ideal"'])


def test_a_refusal_names_file_line_and_section(tmp_path):
    file = tmp_path / "star.toml"
    file.write_text(SCENE.replace('"1500 km"', '"1500 kg"'))
    with pytest.raises(SceneError) as caught:
        load_file(file)
    assert (
        str(caught.value) == f"{file}, line 6: [body] radius: '1500 kg' is not a length; write for example \"1500 km\"."
    )


def test_a_refusal_of_an_override_names_it():
    assert refusal("body.mass=1 km").startswith("--set body.mass=1 km: [body] mass: ")


def test_an_unknown_key_is_reported_before_a_missing_one():
    assert "did you mean 'radius'" in refusal(text=SCENE.replace("radius =", "radios ="))
    listed = SCENE.partition("[effects")[0] + "[time]\nend = '1 s'\neffects = 'auto'\n"
    assert "[time] effects is not a known key; it is one of the scene itself" in refusal(text=listed)


def test_a_refusal_says_what_to_write_instead():
    assert '[time] is missing (when the run ends, such as end = "33 ms")' in refusal(text=SCENE.partition("[time]")[0])
    assert 'not a list: write it as a string with its unit, for example "1.4 Msun"' in refusal('body.mass=["1 Msun"]')
    unquoted = refusal(text=SCENE.replace('kind = "polytrope"', "kind = polytrope"))
    assert 'text and quantities stand in quotes, as in mass = "1.4 Msun"' in unquoted
    kinds = refusal(text=SCENE.replace('kind = "polytrope"\n', ""))
    assert "it is one of polytrope, " in kinds and "own" not in kinds


def test_overrides_are_typed_as_toml_or_taken_as_text():
    scene = loads(SCENE, ["body.particles=5000", "body.mass=2 Msun", "body.relax=false", "numerics.courant=0.1"])
    assert scene.body.particles == 5000
    assert scene.body.mass == pytest.approx(2 * SOLAR_MASS)
    assert scene.body.relax is False
    assert scene.numerics.courant == 0.1
    assert scene.overrides == ("body.particles=5000", "body.mass=2 Msun", "body.relax=false", "numerics.courant=0.1")


def test_an_override_cannot_smuggle_in_more_than_one_key():
    assert "one line" in refusal("body.particles=1000\nrelax = false")


@pytest.mark.parametrize(
    "overrides",
    [
        [],
        ["body.particles=5000"],
        ["body.mass=2 Msun", "numerics.courant=0.1", "name=other"],
        ["body.rotation={rate='1 rad/s'}"],
        ["effects.viscosity.alpha_max=0.5", "effects.conduction={}", "effects.damping.time_scale=1 s"],
        ["description=" + 'a "quoted" \\ é b ' * 50, "body.rotation={rate='1 rad/s'}"],
        ["description=a" + " " * 900 + "b", "body.rotation={rate='1 rad/s'}"],
    ],
)
def test_one_text_gives_the_scene_back(overrides):
    scene = loads(SCENE, overrides)
    again = loads(scene.to_toml())
    assert same(again, scene)
    assert again.overrides == ()


def test_comments_survive_an_override():
    text = with_overrides(SCENE, ["body.mass=2 Msun"])
    assert "# a comment" in text
    assert 'mass = "2 Msun"' in text


@pytest.mark.parametrize("header", ["", "[regions] # two of them\nb = { bound = true }\n[regions.a]\nbound = true\n"])
def test_entries_that_overrides_add_keep_their_order(header):
    """A run goes on with the text alone, and its records have a row for each entry in that order."""
    text = SCENE + header
    overrides = ["regions.d={bound=true}", "regions.c={bound=true}", "regions.e.bound=true"]
    scene, again = loads(text, overrides), loads(with_overrides(text, overrides))
    assert list(again.regions) == list(scene.regions) == [*("ba" if header else ""), "d", "c", "e"]


def test_toml_text_is_read_back():
    tables = {"a": 1, "b": {"c d": [1.5, 'x\n"y"\\'], "e": {}, "f": {"g": True, "h": [[1, 2], [3, 4]]}}, "i": 1e300}
    import tomllib

    assert tomllib.loads(toml_text(tables)) == tables


def test_the_example_loads_and_its_comments_are_the_descriptions():
    text = example_text()
    scene = loads(text)
    assert scene.body.kind == "polytrope"
    assert max(len(line) for line in text.splitlines()) <= 140
    words = " ".join(line.lstrip("# ") for line in text.splitlines())
    for kind, entry in CATALOGUE.items():
        assert f"[effects.{kind}]" in text
        assert all(f"{name} = " in text for name in entry.options)
    for models in KINDS.values():
        for model in models.values():
            for name in model.model_fields:
                assert f"{name} = " in text or f"[body.{name}]" in words


def test_every_commented_setting_of_the_example_is_accepted():
    # each "# key = value" of a section in use is tried alone, with what it excludes taken away
    excluded = {
        "rate": "t_over_w",
        "period": "t_over_w",
        "angular_momentum": "t_over_w",
        "breakup_fraction": "t_over_w",
    }
    text, tried = example_text(), 0
    lines = text.splitlines()
    listed = {"body", "body.rotation", "numerics", "time", "output", "effects.viscosity"}
    section = ""
    for number, line in enumerate(lines):
        if line.startswith(("[", "# [")):
            section = line.strip("# ").partition("]")[0].strip("[")
        key, equals, _ = line[2:].partition(" = ")
        model_keys = {"body": KINDS["body"]["polytrope"].model_fields}.get(section)
        if not line.startswith("# ") or not equals or section not in listed or not key.replace("_", "").isalnum():
            continue
        if model_keys is not None and key not in model_keys:
            continue
        changed = [*lines[:number], line[2:], *lines[number + 1 :]]
        drop = excluded.get(key)
        changed = [item for item in changed if not (drop and item.startswith(f"{drop} ="))]
        if key == "scale":
            changed = [item.replace('law = "rigid"', 'law = "j_constant"') for item in changed]
        if key == "wobble":  # whose comment says of which model it is
            with pytest.raises(SceneError, match="is for the model rigid"):
                loads("\n".join(changed))
            continue
        loads("\n".join(changed))
        tried += 1
    assert tried >= 30


@pytest.mark.slow
@pytest.mark.parametrize("file", sorted(SIMS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_scene_of_sims_loads_and_can_be_planned(file):
    sweep = sweeps.load_file(file)
    scene = load_file(file) if sweep is None else sweep.scene(0)
    assert scene.name == file.stem
    assert plan(scene).text()


def test_plan_tells_what_is_listed_and_what_is_not():
    planned = plan(loads(SCENE))
    assert {line.kind for line in planned.effects if line.listed} == {"gravity", "pressure"}
    assert {line.kind for line in planned.effects} == {
        kind for kind, entry in CATALOGUE.items() if "sph" in entry.models
    }
    assert dataclasses.asdict(planned)["name"] == "test"
    values = {line.name: line.value for lines in planned.sections.values() for line in lines}
    density = 1.5 * SOLAR_MASS / (4.0 / 3.0 * math.pi * 1.5e6**3)
    fall = math.sqrt(3.0 * math.pi / (32.0 * GRAVITATIONAL_CONSTANT * density))
    assert float(values["free-fall time"].split()[0]) == pytest.approx(fall, rel=1e-5)


def test_plan_and_build_agree():
    from astroinertia.build import assemble

    for scene in (loads(SCENE), loads(SCENE, ["output={series_every='1 ms', snapshot_every='2 ms'}"])):
        units = code_units(scene)
        assert assemble.code_units(scene) == units
        planned, built = cadence(scene), assemble.outputs_of(scene, units)
        assert built.series_every == pytest.approx(units.to_code(planned.series_every, "time"), rel=1e-14)
        assert built.snapshot_every == pytest.approx(units.to_code(planned.snapshot_every, "time"), rel=1e-14)


def test_number_of_records():
    assert records(1.0, 0.1) == 11
    assert records(1.0, 0.3) == 5  # 0, 0.3, 0.6, 0.9 and the end
    assert records(1.0, 2.0) == 2


def test_neighbours_and_eta_are_two_ways_to_say_one_thing():
    eta, _ = smoothing(loads(SCENE, ["numerics.neighbours=100"]))
    assert smoothing(loads(SCENE, [f"numerics.eta={eta!r}"]))[1] == pytest.approx(100.0)
    assert "keep one" in refusal("numerics={eta=1.2, neighbours=60}")


def test_neighbours_rise_with_the_root_of_the_number_of_particles():
    """Four times the particles have twice the neighbours; few particles keep the kernel's own number."""
    numbers = [
        smoothing(loads(SCENE, ["numerics.neighbours=rising", f"body.particles={count}"]))[1]
        for count in (400, 1000, 4000, 16_000, 10_000_000)
    ]
    own = smoothing(loads(SCENE))[1]
    assert numbers == pytest.approx([own, own, 2 * own, 4 * own, 1000.0])
    assert "rising" in refusal("numerics.neighbours=growing")
    assert "20" in refusal("numerics.neighbours=5")


def test_entropy_has_the_dimension_of_its_equation_of_state():
    ideal = ["equation_of_state={kind='ideal', gamma=2}"]
    scene = loads(SCENE, [*ideal, "body.entropy=3 m5 kg-1 s-2"])
    assert scene.body.entropy == 3.0
    assert "m2 s-2" not in refusal(*ideal, "body.entropy=3 m4 kg^(-2/3) s-2")
    barotropic = ["equation_of_state={kind='polytropic', gamma=2}"]
    assert "thermal part" in refusal(*barotropic, "body.entropy=3 m5 kg-1 s-2")


def test_constants_of_equations_of_state():
    scene = loads(SCENE, ["equation_of_state={kind='polytropic', gamma=2, constant='3 m5 kg-1 s-2'}"])
    assert scene.equation_of_state.constant == 3.0
    assert loads(SCENE).equation_of_state.constant == FROM_BODY


COLLAPSE = (SIMS / "homologous_collapse.toml").read_text()


@pytest.mark.parametrize(
    ("override", "why"),
    [
        ("body.collapse_rate=1.01", "must be at most 1"),
        ("equation_of_state.gamma=1.4", "has another equation_of_state"),
        ("body.entropy=0.3", "has entropy: change that"),
        ("body.rotation.rate=0.1", "settles without rotation"),
    ],
)
def test_a_homologous_core_is_refused_what_it_cannot_settle_with(override, why):
    assert why in refusal(override, text=COLLAPSE)
    if "rate=1.01" not in override:
        loads(COLLAPSE, [override, "body.relax=false"])


def test_a_plan_tells_when_a_homologous_core_has_collapsed():
    text = COLLAPSE.replace('units = "code"\n', "").replace("mass = 1.0", 'mass = "1.4 Msun"')
    text = text.replace("radius = 1.0", 'radius = "1500 km"').replace("end = 0.45649740094", 'end = "0.06 s"')
    scene = loads(text.replace("every = 0.01", 'every = "1 ms"').replace("every = 0.1", 'every = "0.1 s"'))
    units = math.sqrt(1.5e6**3 / (GRAVITATIONAL_CONSTANT * 1.4 * SOLAR_MASS))
    assert scene.body.expansion(scene.body.mass, scene.body.radius, GRAVITATIONAL_CONSTANT) == pytest.approx(
        -math.sqrt(2.0) / units, rel=1e-9
    )
    (line,) = (line for lines in plan(scene).sections.values() for line in lines if line.name == "collapse")
    assert line.why == f"over at {math.sqrt(2.0) / 3.0 * units:.6g} s"
