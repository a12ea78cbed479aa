"""The guide: its pages and their links, what is written from the program, the command, and what the pages show."""

import ast
import importlib
import importlib.util
import os
import pty
import re
import shlex
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from types import NoneType
from typing import get_args

import numpy as np
import pytest
from pydantic import BaseModel

import astroinertia
from astroinertia.cli.main import main
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.guide import effects_reference, pages, scene_reference
from astroinertia.scene import schema
from astroinertia.scene.fluids import OwnFluid
from astroinertia.scene.load import RECORD
from astroinertia.scene.own import DOORS
from astroinertia.scene.own_body import OwnBody
from astroinertia.units import SOLAR_MASS

ROOT = Path(__file__).parents[3]
GUIDE = ROOT / "astroinertia" / "guide"
FILES = sorted(GUIDE.glob("*.md"))
SHOWN = {"README.md": ROOT / "README.md", **{path.name: path for path in FILES}}
"""What is written by hand."""
LONGER = ("first-run.md", "own-effects.md")  # what they show to run: in the full tests
LINK = re.compile(r"\[[^\]]*\]\(([^)]*)\)")  # or a picture
RUN = [f"sims/{name}.toml" for name in ("asteroid_settles", "pulsar_births", "pulsar_collapse")]


def page(name):
    return f"astroinertia/guide/{name}"


def links(text):
    """The targets of all links and pictures of a page, outside of its code."""
    targets = []
    pages.outside_code(text, lambda line: targets.extend(LINK.findall(line)) or line)
    return targets


STAR = """
name = "star"
[body]
kind = "uniform"
mass = "1 Msun"
radius = "1 Rsun"
particles = 64
relax = false
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = "1 min"
max_steps = 5
"""


def blocks(path, *languages):
    """The blocks of code in these languages."""
    found = re.findall(r"^```(\w*)\n(.*?)^```", path.read_text(), re.MULTILINE | re.DOTALL)
    return [code for language, code in found if language in languages]


def commands(path):
    """Every command of the package that a page shows, in a block or within a line."""
    lines = [line.removeprefix("$ ") for code in blocks(path, "sh", "") for line in code.splitlines()]
    prose = re.sub(r"^```.*?^```", "", path.read_text(), flags=re.MULTILINE | re.DOTALL)
    lines += re.findall(r"`(astroinertia [^`]*)`", prose)
    return [shlex.split(line, comments=True) for line in lines if re.match(r"astroinertia [a-z-]", line)]


def anchors(path):
    """The anchors of the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", path.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def parts(model, seen):
    """A part of the schema and all parts within it."""
    if model in seen:
        return
    seen.add(model)
    for field in model.model_fields.values():
        for inner in models(field.annotation):
            parts(inner, seen)


def models(annotation):
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        if argument is not NoneType:
            yield from models(argument)


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 250


def test_every_page_is_a_topic_and_every_topic_a_page():
    written = {path.stem for path in FILES}
    assert written | set(pages.WRITTEN_WHEN_READ) == set(pages.TOPICS)
    assert not written & set(pages.WRITTEN_WHEN_READ)  # nothing is written by hand beside what is generated


@pytest.mark.parametrize("topic", pages.TOPICS)
def test_every_topic_is_readable(topic):
    assert pages.page(topic).startswith("# ")
    text = pages.readable(topic)
    assert all("://" in target for target in links(text))
    assert text.count("```") % 2 == 0
    assert len(text.splitlines()) > 10


@pytest.mark.parametrize("name", [*SHOWN, "sims/README.md"])
def test_no_link_is_dead(name):
    path = SHOWN.get(name, ROOT / name)
    for target in links(path.read_text()):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        linked = path.parent / file if file else path
        assert linked.exists(), target
        assert not anchor or anchor in anchors(linked), target


def test_every_topic_is_in_the_readme():
    text = (ROOT / "README.md").read_text()
    for topic in pages.TOPICS:
        assert f"astroinertia/guide/{topic}.md" in text or f"`astroinertia guide {topic}`" in text


def test_every_key_of_a_scene_is_in_its_reference():
    text, known = scene_reference.text(), set()
    parts(schema.Scene, known)
    assert len(known) > 25
    for model in known - {OwnFluid, OwnBody}:  # which stands for kinds that other packages have
        for name, field in model.model_fields.items():
            if name == "kind":
                assert f'kind = "{get_args(field.annotation)[0]}"' in text
            elif not (model is schema.Scene and name in RECORD):
                assert f"| `{name}` |" in text, name
                assert (field.description or "").replace("|", r"\|") in text


def test_keys_have_their_units_defaults_and_limits():
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", scene_reference.text(), re.MULTILINE))
    assert rows["checkpoint_seconds"].startswith("number; from 0 to 1e+06 | `60.0` |")
    assert rows["end"].startswith('time, such as `"33 ms"`; positive | **required** |')
    assert rows["gammas"].startswith("list: number; above 1 to 10; from 2 to 21 entries | **required**")
    assert rows["t_over_w"].startswith("number; from 0 to below 0.5 | none |")
    assert rows["kernel"].startswith('`"cubic"`, `"quartic"`,')
    assert "| `relax` | `true` or `false` | `false` | must be false" in scene_reference.text()


def test_every_effect_and_option_is_in_their_reference():
    sections = dict(re.findall(r"^## `(\w+)`\n(.*?)(?=^## |\Z)", effects_reference.text(), re.MULTILINE | re.DOTALL))
    assert set(sections) == set(CATALOGUE)
    for kind, entry in CATALOGUE.items():
        assert f"- source: {entry.source}" in sections[kind]
        assert entry.text[1:] in sections[kind]
        for name, option in entry.options.items():
            (row,) = re.findall(rf"^\| `{name}` \|.*$", sections[kind], re.MULTILINE)
            assert option.text.replace("|", r"\|") in row
            assert all(f'"{choice}"' in row for choice in option.choices)


def test_options_have_their_units_defaults_and_limits():
    text = effects_reference.text()
    assert '| `time_scale` | time, such as `"33 ms"`; positive | **required** |' in text
    assert "| `force_error` | number; from 1e-08 to 0.03 | `0.0002` |" in text
    assert '| `quadratic` | 3 times: 3 times: inverse time squared, such as `"0.1 1/s2"` | none |' in text
    assert '| `speed_of_light` | velocity, such as `"10 km/s"`; positive | the speed of light |' in text


def test_the_command_lists_all_topics(capsys):
    assert main(["guide"]) == 0
    shown = capsys.readouterr().out
    for topic, text in pages.TOPICS.items():
        assert re.search(rf"^  {topic} +{re.escape(text)}$", shown, re.MULTILINE)


def test_a_piped_page_is_markdown(capsys):
    assert main(["guide", "ledger"]) == 0
    assert capsys.readouterr().out == pages.readable("ledger")


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("ledgr", "'ledger'?\n"),
        ("Effect", "'effects'?\n"),
        ("xarray", "'xarray-analysis'?\n"),
        ("own", "'own-effects'?\n"),
        ("nope", f"is no topic of the guide; its topics are {', '.join(pages.TOPICS)}.\n"),
    ],
)
def test_a_wrong_topic_gets_one_sentence(wrong, right, capsys):
    assert main(["guide", wrong]) == 2
    caught = capsys.readouterr()
    assert caught.out == ""
    assert caught.err.count("\n") == 1
    assert right in caught.err


def on_a_terminal(*arguments, **environment):
    """What a command writes to a terminal."""
    reader, writer = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "astroinertia", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=writer,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm", "COLUMNS": "90", **environment},
    )
    os.close(writer)
    shown = b""
    try:
        while piece := os.read(reader, 65536):
            shown += piece
    except OSError:  # the other end is closed
        pass
    finally:
        os.close(reader)
    assert process.wait() == 0
    return shown.decode()


@pytest.mark.parametrize("pager", ["tr a-z A-Z", "/nothing/here"])
def test_a_page_on_a_terminal_goes_through_a_pager_if_there_is_one(pager):
    shown = on_a_terminal("guide", "ledger", PAGER=pager)
    assert "# The" not in shown  # rendered
    assert ("IS THE" in shown.upper()) and ("is the" in shown) == (pager != "tr a-z A-Z")
    plain = re.sub(r"\x1b\[[0-9;]*[a-zA-Z]", "", shown)
    assert max(map(len, plain.splitlines())) <= 90


def test_help_and_the_list_of_topics_load_nothing_heavy():
    program = (
        "import sys; from astroinertia.cli.main import main; main(['guide']);"
        "print(*{'pydantic', 'jax', 'numba', 'rich.markdown', 'astropy'} & set(sys.modules), file=sys.stderr)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment, cwd="/"
    )
    assert done.stderr == "\n"


@pytest.fixture(scope="module")
def help_of():
    """What the help of a command says; each is asked for once."""
    known = {}

    def found(command, capsys):
        if command not in known:
            with pytest.raises(SystemExit) as ended:
                main([command, "--help"])
            known[command] = capsys.readouterr().out
            assert ended.value.code == 0, command
        return known[command]

    return found


@pytest.mark.parametrize("name", SHOWN)
def test_commands_that_pages_show_exist(name, help_of, capsys):
    for _, *words in commands(SHOWN[name]):
        if words[0].startswith("--"):
            assert words[0] in ("--help", "--version")
            continue
        options = {word.partition("=")[0] for word in words[1:] if word.startswith("--")}
        known = set(re.findall(r"--[a-z][a-z0-9-]*", help_of(words[0], capsys)))
        assert options <= known, words
        if words[0] == "guide" and len(words) > 1:
            assert words[1] in {*pages.TOPICS, "TOPIC"}
        for scene in (word for word in words if word.startswith("sims/")):
            assert (ROOT / scene).exists()


@pytest.mark.parametrize("path", [*SHOWN.values(), ROOT / "sims" / "README.md"], ids=lambda path: path.name)
def test_every_setting_that_pages_show_has_its_own_option(path):
    for shown in re.findall(r"`([^`]*--set [^`]*)`", path.read_text()):
        words = shlex.split(shown)
        settings = [word for word in words if re.match(r"[A-Za-z_]+(\.[a-z_]+)*=", word)]
        assert len(settings) == words.count("--set"), shown


def test_the_pages_show_commands_at_all():
    assert sum(len(commands(path)) for path in SHOWN.values()) > 40


@pytest.mark.parametrize("name", [name for name, path in SHOWN.items() if blocks(path, "python")])
def test_python_that_pages_show_imports_what_exists(name):
    for code in blocks(SHOWN[name], "python"):
        known = {"astroinertia": astroinertia}
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom):
                source = importlib.import_module(node.module or "")
                for alias in node.names:
                    whole = f"{node.module}.{alias.name}"
                    found = getattr(source, alias.name, None)
                    known[alias.name] = importlib.import_module(whole) if found is None else found
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in known:
                assert hasattr(known[node.value.id], node.attr), f"{node.value.id}.{node.attr}"


@pytest.mark.parametrize("name", [name for name, path in SHOWN.items() if blocks(path, "toml")])
def test_scenes_that_pages_show_have_known_keys(name):
    import tomllib

    text = scene_reference.text()
    for code in blocks(SHOWN[name], "toml"):
        for table, keys in tomllib.loads(code).items():
            if table == "sweep":
                assert keys
            elif table == "observables":
                assert set(keys) == {"quadrupole_phase"} and "| `observables` |" in text
            elif table == "regions":
                assert all(f"| `{key}` |" in text for region in keys.values() for key in region)
            elif table == "candidates":
                assert all(set(options) <= set(CATALOGUE[kind].options) for kind, options in keys.items())
            else:
                assert f"| `{table}` |" in text


@pytest.fixture(scope="module")
def workplace(tmp_path_factory):
    """A folder with the finished runs that pages speak of, of few particles."""
    folder = tmp_path_factory.mktemp("guide")
    settings = ["body.particles=64", "body.relax=false", 'output.series_every="0.5 ms"', 'output.snapshot_every="2 ms"']
    core = astroinertia.load(ROOT / "sims/pulsar_collapse.toml", [*settings, 'time.end="10 ms"'])
    astroinertia.run_scene(core, folder / "runs/pulsar_collapse")
    births = (ROOT / "sims/pulsar_births.toml").read_text()
    births = re.sub(r'^"body.index" = .*$', '"body.index" = [1.5, 3.0]', births, flags=re.MULTILINE)
    births = re.sub(r"number = \d+", "number = 2", births)
    (folder / "births.toml").write_text(births)
    astroinertia.run_scene(folder / "births.toml", folder / "runs/pulsar_births")
    (folder / "star.toml").write_text(STAR)
    asteroid = (ROOT / "sims/asteroid_settles.toml").read_text()
    (folder / "asteroid.toml").write_text(re.sub(r"^end = .*$", 'end = "2 h"', asteroid, flags=re.MULTILINE))
    cloud = STAR.replace("1 Rsun", "0.1 pc").replace("1 min", "1 kyr").replace("[effects.gravity]\n", "")
    (folder / "cloud.toml").write_text(cloud)
    (folder / "ring.toml").write_text(STAR.replace('"ideal"', '"isothermal"\nsound_speed = "1 km/s"'))
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *("README.md", "ledger.md", "xarray-analysis.md"),
        *(pytest.param(name, marks=pytest.mark.full(inputs=[*RUN, page(name)])) for name in LONGER),
    ],
)
def test_analyses_that_pages_show_run(name, workplace, monkeypatch):
    from matplotlib import pyplot

    monkeypatch.chdir(workplace)
    space = {"__name__": "__main__"}
    for code in blocks(SHOWN[name], "python"):
        if "astroinertia.bodies" not in code:  # those have tests of their own
            exec(compile(code, name, "exec"), space)
    pyplot.close("all")


@pytest.mark.slow
def test_pictures_that_the_page_of_precession_shows_are_drawn(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (code,) = [code for code in blocks(SHOWN["precession.md"], "python") if "astroinertia.plots" in code]
    exec(compile(code, "precession.md", "exec"), {})
    assert (tmp_path / "top.png").stat().st_size > 10_000


@pytest.mark.full(inputs=["sims/core_to_pulsar_scaling.toml", page("sweeps.md")])
def test_gradients_that_the_page_of_sweeps_shows_are_what_it_says(tmp_path, monkeypatch, capsys):
    """With fewer records than the scene has, on which they do not depend."""
    (tmp_path / "sims").mkdir()
    core = (ROOT / "sims" / "core_to_pulsar_scaling.toml").read_text()
    (tmp_path / "sims" / "core_to_pulsar_scaling.toml").write_text(core.replace('"1 ms"', '"10 ms"'))
    monkeypatch.chdir(tmp_path)
    space = {"astroinertia": astroinertia}
    shown = [code for code in blocks(SHOWN["sweeps.md"], "python") if "astroinertia.gradient" in code]
    for code in shown:
        exec(compile(code, "sweeps.md", "exec"), space)
        if "answer.gradient  #" in code:
            assert space["answer"].gradient.values == pytest.approx([-27.1647, 0.0], abs=1e-4)
    assert len(shown) == 2 and capsys.readouterr().out == "38.9105 s\n"


def test_the_star_that_the_page_of_collapse_writes_is_the_body_of_its_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = SHOWN["collapse.md"]
    (code,) = blocks(path, "python")[1:]
    exec(compile(code, "collapse.md", "exec"), {})
    core, star = (text for text in blocks(path, "toml") if 'mass = "1.5 Msun"' in text or "star.csv" in text)
    whole = re.sub(r"\[body\].*?\n\n", lambda _: f"{star}\n", core, flags=re.DOTALL)
    scene = astroinertia.Scene.from_toml(whole)
    assert scene.body.shells(scene).mass[-1] == pytest.approx(1.5 * SOLAR_MASS, rel=1e-3)


@pytest.mark.slow
def test_results_of_sweeps_that_pages_show_can_be_analysed(workplace, monkeypatch):
    monkeypatch.chdir(workplace)
    ds = astroinertia.open("runs/pulsar_births")
    shown = blocks(SHOWN["sweeps.md"], "python")
    for mark in ("Sobol", "rungs"):
        (code,) = [code for code in shown if mark in code]
        exec(compile(code, "sweeps.md", "exec"), {"astroinertia": astroinertia, "ds": ds})
    spins = ds.isel(body_index=0).assign(inertia_tensor_error=0.01 * ds.inertia_tensor.isel(body_index=0))
    monkeypatch.setattr(astroinertia, "open", lambda path: spins)
    (code,) = [code for code in shown if "errorbar" in code]
    exec(compile(code, "sweeps.md", "exec"), space := {})
    assert space["moment"].unit == space["error"].unit and (workplace / "moment.pdf").stat().st_size > 5000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "mark", "least"),
    [
        ("README.md", "astroinertia.bodies", 4),
        *(
            pytest.param("moment-ratios.md", *part, marks=pytest.mark.full(inputs=[page("moment-ratios.md")]))
            for part in (("apsidal", 9), ("own_body", 2))
        ),
        *(("inertia-toolbox.md", "import shapes", 1), ("inertia-toolbox.md", "mesh_field", 6)),
        *(("inertia-toolbox.md", "balancing", 3), ("inertia-toolbox.md", "realise", 2)),
        *(("precession.md", "frame_dragging", 5), ("moment-ratios.md", "resonant_obliquity", 7)),
    ],
)
def test_numbers_that_pages_show_come_out(name, mark, least):
    (code,) = [code for code in blocks(SHOWN[name], "python") if mark in code]
    space, checked, lines = {}, 0, code.splitlines()
    for statement in ast.parse(code).body:
        source = ast.unparse(statement)
        if not isinstance(statement, ast.Expr):
            exec(source, space)
            continue
        value, comment = eval(source, space), lines[statement.lineno - 1].partition("  # ")[2]
        shown = re.findall(r"\d+\.\d+", comment)
        if np.ndim(value) == 0 and shown:
            number = next(each for each in shown if abs(float(each) / float(value) - 1.0) < 0.1)
            assert abs(float(value) - float(number)) <= 0.51 * 10.0 ** -len(number.partition(".")[2]), source
            checked += 1
    assert checked >= least


@pytest.mark.slow
@pytest.mark.parametrize("path", [*SHOWN.values(), ROOT / "sims" / "README.md"], ids=lambda path: path.name)
def test_functions_that_pages_name_exist(path):
    """Names with their room, such as `studies.core_collapse.core_collapse`."""
    for name in set(re.findall(r"`([a-z_]+(?:\.\w+)+)[`(]", path.read_text())):
        room, *parts = name.split(".")
        if not (ROOT / "astroinertia" / room / "__init__.py").exists():
            continue
        thing = importlib.import_module(f"astroinertia.{room}")
        for part in parts:
            if not hasattr(thing, part):
                importlib.import_module(f"{thing.__name__}.{part}")
            thing = getattr(thing, part)


def test_rooms_of_the_overview_exist():
    text = pages.page("overview").partition("## How the parts")[2]
    rooms = re.findall(r"^    ([a-z_]+)  +\S", text, re.MULTILINE)
    assert len(rooms) > 20
    for room in rooms:
        assert importlib.util.find_spec(f"astroinertia.{room}") is not None, room
    folders = {path.parent.name for path in (ROOT / "astroinertia").glob("*/__init__.py")}
    assert folders - {"pages"} <= set(rooms)


def test_rooms_that_tables_name_exist_and_what_turns_is_found():
    """A first column names the modules: with its room, which the others of the row share, or below a heading of it."""
    named, files = set(), [path.read_text() for path in FILES]
    for row in re.findall(r"^\| (`[a-z_.]+`(?:, `[a-z_.]+`)*) \|", "\n".join(files), re.MULTILINE):
        first, *others = re.findall(r"`([a-z_.]+)`", row)
        if re.fullmatch(r"(rotation|bodies|studies)\.[a-z_]+", first):
            named |= {first, *(f"{first.split('.')[0]}.{other}" for other in others)}
    for table in re.findall(r"^\| room of `bodies` .*?\n\n", "\n".join(files), re.MULTILINE | re.DOTALL):
        for row in re.findall(r"^\| (`[^|]*`) \|", table, re.MULTILINE):
            named |= {f"bodies.{name}" for name in re.findall(r"`([a-z_]+)`", row)}
    assert len(named) > 40
    for name in named:
        assert importlib.util.find_spec(f"astroinertia.{name}") is not None, name
    inner = {"elliptic", "ephemeris", "harmonic_fit", "on_orbits", "pulsar_table", "ripple", "secular_orbits", "spice"}
    turning = {path.stem for path in (ROOT / "astroinertia" / "rotation").glob("[a-z]*.py")} - inner
    assert {f"rotation.{name}" for name in turning} - named == set()


def test_the_page_on_physics_of_your_own_has_every_door():
    text = SHOWN["own-effects.md"].read_text()
    for door in DOORS:
        (row,) = re.findall(rf"^\| an {door.thing} \|.*$", text, re.MULTILINE)
        for part in (door.base, door.argument, f"astroinertia.{door.name}`", f"[{door.table}"):
            assert f"`{part}" in row


def test_headings_of_pages_do_not_skip_a_level():
    for path in FILES:
        text = re.sub(r"^```.*?^```", "", path.read_text(), flags=re.MULTILINE | re.DOTALL)
        levels = [len(marks) for marks in re.findall(r"^(#+) ", text, re.MULTILINE)]
        assert levels[0] == 1 and levels.count(1) == 1, path.name
        assert all(later - earlier <= 1 for earlier, later in pairwise(levels)), path.name
