"""Scenes that are written in Python: they are those of files, value for value and sentence for sentence."""

import inspect
import re
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from astropy import constants, units as u

import astroinertia
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads
from tests.plugin_example import example
from tests.sims import single_scenes

SCENE = """\
name = "core"
[body]
kind = "polytrope"
particles = 1000
mass = "1.5 Msun"
radius = "1500 km"
index = 1.5
axes = [1, 1, 0.5]
[body.rotation]
period = "12 h"
axis = [0, 1, 1]
[equation_of_state]
kind = "ideal"
gamma = "5/3"
[effects.gravity]
[effects.pressure]
[effects.damping]
time_scale = "20 ms"
[time]
end = "0.3 s"
"""
TABLES = tomllib.loads(SCENE)


def with_value(path: str, value: Any) -> dict[str, Any]:
    """The tables of the scene with a value at a dotted path."""
    *parts, key = path.split(".")
    tables = tomllib.loads(SCENE)
    inner = tables
    for part in parts:
        inner = inner.setdefault(part, {})
    inner[key] = value
    return tables


def values_of(scene: Any) -> dict[str, Any]:
    return scene.model_dump(exclude={"source", "overrides", "origin"})


def near(one: Any, other: Any) -> bool:
    """Whether tables are the same but for the last digits of their numbers."""
    if isinstance(other, dict):
        return list(one) == list(other) and all(near(one[key], other[key]) for key in other)
    if isinstance(other, tuple):
        return len(one) == len(other) and all(map(near, one, other))
    return one == (pytest.approx(other, rel=1e-12) if isinstance(other, float) else other)


def refusal(tables: Any = None, **keys: Any) -> str:
    with pytest.raises(SceneError) as caught:
        astroinertia.Scene({} if tables is None else tables, **keys)
    return str(caught.value)


@pytest.mark.parametrize("file", single_scenes(), ids=lambda path: path.stem)
def test_every_scene_of_sims_is_the_same_from_python_and_as_toml(file: Path) -> None:
    scene = astroinertia.load(file)
    assert astroinertia.Scene(**tomllib.loads(file.read_text())) == scene
    assert astroinertia.Scene.from_toml(scene.to_toml()) == scene
    again = astroinertia.Scene(tomllib.loads(scene.to_toml()))
    assert tomllib.loads(again.to_toml()) == tomllib.loads(file.read_text())


def test_a_scene_file_may_be_below_the_home_of_its_user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(Path("sims").absolute()))
    assert astroinertia.load("~/crab_pulsar.toml") == astroinertia.load("sims/crab_pulsar.toml")
    with pytest.raises(SceneError, match=r"nothing\.toml"):
        astroinertia.load("~/nothing.toml")


def test_scenes_that_ask_for_other_things_differ() -> None:
    assert loads(SCENE) != loads(SCENE, ["body.seed=2"])
    assert loads(SCENE) != loads(SCENE.replace("[effects.damping]", "[effects.viscosity]\n[effects.damping]"))
    changed = loads(SCENE, ["body.seed=2", "time.end=1 s"])
    assert astroinertia.Scene.from_toml(changed.to_toml()) == changed


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("body.mass", 1.5 * u.Msun),
        ("body.mass", 1.5 * constants.M_sun),
        ("body.mass", np.float32(1.5) * u.Msun),
        ("body.mass", xr.DataArray(1.5 * constants.M_sun.value, attrs={"units": "kg"})),
        ("body.radius", 1500 * u.km),
        ("body.radius", 1.5 * u.Unit("1000 km")),
        ("body.radius", 0.5 * u.def_unit("a_unit_of_mine", 3000 * u.km)),
        ("body.particles", 1e3),
        ("body.particles", np.int64(1000)),
        ("body.particles", np.array(1000)),
        ("body.index", Fraction(3, 2)),
        ("body.index", Decimal("1.5")),
        ("body.index", "3/2"),
        ("body.index", 150 * u.percent),
        ("body.axes", np.array([1.0, 1.0, 0.5])),
        ("body.axes", (1, 1, np.float64(0.5))),
        ("body.rotation.period", 0.5 * u.day),
        ("equation_of_state.gamma", 5 / 3),
        ("effects", ["gravity", "pressure", {"kind": "damping", "time_scale": 20 * u.ms}]),
        ("effects", ("gravity", {"pressure": {}, "damping": {"time_scale": np.array(0.02) * u.s}})),
        ("time", 0.3 * u.s),
        ("time", "300 ms"),
        ("description", None),
    ],
)
def test_what_python_has_is_what_toml_has(path: str, value: Any) -> None:
    scene = astroinertia.Scene(with_value(path, value))
    assert near(values_of(scene), values_of(loads(SCENE)))


def test_arrays_of_quantities_are_lists_of_texts() -> None:
    scene = astroinertia.Scene(with_value("body.velocity", np.array([0, 3, -4]) * u.km / u.s))
    assert scene.body.velocity == (0.0, 3000.0, -4000.0)
    field = with_value("body.velocity_gradient", np.diag([1, 2, 3]) / u.ms)
    assert astroinertia.Scene(field).body.velocity_gradient[2] == (0.0, 0.0, 3000.0)


@pytest.mark.parametrize(
    ("path", "value", "written"),
    [
        ("body.mass", 3 * u.km, '"3.0 km"'),
        ("body.mass", 1.5, "1.5"),
        ("body.mass", -1 * u.kg, '"-1.0 kg"'),
        ("body.mass", np.nan * u.kg, '"nan kg"'),
        ("body.mass", 3 * u.K, '"3.0 K"'),
        ("body.mass", [1, 2] * u.kg, '["1.0 kg", "2.0 kg"]'),
        ("body.mas", 1 * u.kg, '"1.0 kg"'),
        ("body.particles", 1000.5, "1000.5"),
        ("body.particles", np.True_, "true"),
        ("body.particles", np.inf, "inf"),
        ("body.particles", 10**30, "1e30"),
        ("body.axes", np.ones(2), "[1.0, 1.0]"),
        ("body.rotation", 3, "3"),
        ("body.rotation.period", 3 * u.Hz, '"3.0 Hz"'),
        ("equation_of_state.gamma", "5/0", '"5/0"'),
        ("equation_of_state.kind", "idea", '"idea"'),
        ("effects.gravty", {}, "{}"),
        ("effects.damping", {"time_scale": 1 * u.m}, '{time_scale = "1.0 m"}'),
        ("effects.gravity", 1, "1"),
        ("time.end", 0 * u.s, '"0.0 s"'),
        ("name", "a b", '"a b"'),
        ("numerics.order", 5.0, "5.0"),
        ("units", {"mass": 1 * u.kg}, '{mass = "1.0 kg"}'),
        ("units", "code", '"code"'),
        ("sweep", {"body.mass": [1 * u.kg]}, '{"body.mass" = ["1.0 kg"]}'),
    ],
)
def test_mistakes_get_the_sentences_of_files(path: str, value: Any, written: str) -> None:
    with pytest.raises(SceneError) as caught:
        loads(SCENE, [f"{path}={written}"])
    sentence = re.sub(r"^(--set .*?|the scene(, line \d+)?): (?=\[|[a-z_]+( |:))", "the scene: ", str(caught.value))
    assert refusal(with_value(path, value)) == sentence
    assert path.split(".")[-1] in sentence


LOOP: dict[str, Any] = {}
LOOP["rotation"] = LOOP


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        (3, "a scene must be keys or a table (a dict), not 3; a file is read by astroinertia.load."),
        (with_value("body.mass", object()), "[body] mass: must be text, a number, a quantity, a list or a table, not "),
        (with_value("body.index", 1j), "[body] index: must be text, a number"),
        (with_value("body.axes", [1, None, 1]), "[body] axes[1]: must be text, a number"),
        (with_value("body.axes", {1, 2}), "[body] axes: must be text, a number"),
        (with_value("body.axes", np.zeros(10**6)), "[body] axes: 1000000 values are more than the 64 KiB"),
        (with_value("body.mass", np.datetime64("2026-01-01")), "[body] mass: must be text, a number"),
        (with_value("name", b"star"), "name: must be text, a number"),
        (with_value("name", "\ud800"), "name: must be text in Unicode"),
        (with_value("body", {3: 4}), '[body] "3": a key must be text, not 3.'),
        (with_value("body", LOOP), "[body] rotation: tables or lists are nested deeper than 6 levels."),
        (with_value("effects", [{"time_scale": 3}]), "effects[0]: must be a kind, or a table with its kind, not a tab"),
        (with_value("effects", [3]), "effects[0]: must be a kind, or a table with its kind, not 3."),
        (with_value("effects", [{"kind": []}]), "effects[0]: its kind must be text, not a list."),
        (with_value("effects", ["gravity", "gravity"]), "[effects.gravity] is listed twice."),
        (with_value("effects", "gravty"), "[effects] gravty is not a known effect; did you mean 'gravity'?"),
        (with_value("effects.gravity", None), "[effects] gravity: must be text, a number"),
        (
            with_value("body.mass", SimpleNamespace(magnitude=3.0, units="kg")),
            "[body] mass: its unit is one of types; give an astropy Quantity.",
        ),
        (
            with_value("body.mass", xr.DataArray(3.0, attrs={"units": "talent"})),
            "[body] mass: its unit 'talent' is not known here.",
        ),
    ],
)
def test_what_no_scene_can_hold_is_refused_by_its_key(tables: Any, sentence: str) -> None:
    assert refusal(tables).removeprefix("the scene: ").startswith(sentence)


def test_a_scene_has_no_room_for_what_is_neither_path_nor_table() -> None:
    for scene in (3, None, ["gravity"]):
        with pytest.raises(
            SceneError, match=r"a scene must be a Scene, a table \(a dict\) or the path of a file, not "
        ):
            astroinertia.run_scene(scene, "nowhere")  # pyright: ignore[reportArgumentType]


STAR = {"kind": "polytrope", "index": "3/2", "mass": 1 * u.Msun, "radius": 1 * u.Rsun, "rotation": {"period": "1 d"}}
QUICK = {
    "model": "scaling",
    "body": STAR,
    "effects": [],
    "time": 1 * u.day,
    "output": {"series_every": 0.5 * u.day},
}


@pytest.mark.slow
def test_a_dict_is_run_and_its_file_holds_the_text(tmp_path: Path) -> None:
    ds = astroinertia.open(astroinertia.run_scene(QUICK, tmp_path / "run"))
    assert ds.time.values == pytest.approx([0.0, 43200.0, 86400.0])
    assert astroinertia.Scene.from_toml(ds.attrs["scene"]) == astroinertia.Scene(QUICK)
    assert astroinertia.resume(tmp_path / "run") == tmp_path / "run" / "scene.nc"


@pytest.mark.slow
def test_a_dict_may_have_a_sweep(tmp_path: Path) -> None:
    masses = {"sweep": {"body.mass": np.array([1.0, 2.0]) * u.Msun}}
    ds = astroinertia.open(astroinertia.run_scene(QUICK | masses, tmp_path / "runs"))
    assert sorted(ds.mass.isel(time=0).values / constants.M_sun.value) == pytest.approx([1.0, 2.0])


def test_settings_may_be_a_dict() -> None:
    written = ['time.end="10.0 yr"', "effects={gravity = {}, pressure = {}}"]
    settings = {"time.end": 10.0 * u.yr, "effects": {"gravity": {}, "pressure": {}}}
    assert astroinertia.load("sims/crab_pulsar.toml", settings) == astroinertia.load("sims/crab_pulsar.toml", written)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"time.end": object()}, r"settings: \[time\] end: must be text, a number, a quantity"),
        ({"time.end": 3 * u.km}, r"^--set time\.end=\"3\.0 km\": \[time\] end: '3\.0 km' is not a time"),
        (3.0, r"settings must be a dict or a list of texts, not 3\.$"),
        (["time.end='3 yr'", 3], r"settings must be a dict or a list of texts, and 3 is no text\.$"),
    ],
)
def test_wrong_settings_are_refused_by_their_key(settings: Any, sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        astroinertia.load("sims/crab_pulsar.toml", settings)


def test_tab_offers_what_the_package_has() -> None:
    assert {"Scene", "run_scene", "open"} <= set(dir(astroinertia))
    assert "Mapping" not in dir(astroinertia)


def test_effects_and_bodies_of_ones_own_stand_in_the_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    cubic_drag, torus = example(monkeypatch, "cubic_drag", "CubicDrag"), example(monkeypatch, "torus", "Torus")
    logotrope = example(monkeypatch, "logotrope", "Logotrope")
    phase = example(monkeypatch, "quadrupole_phase", "QuadrupolePhase")
    body = {"kind": torus(1 * u.Mearth, 10_000 * u.km, "2000 km"), "particles": 64}
    matter = logotrope("3e-12 Pa", 1e-17 * u.kg / u.m**3)
    rest = {"observables": [phase], "equation_of_state": matter, "time": "1 h"}
    scene = astroinertia.Scene(body=body, effects=["gravity", cubic_drag(k=2e-9 * u.s / u.m**2)], **rest)
    assert scene.effects["cubic_drag"] == {"k": 2e-9}
    assert (scene.body.name, scene.body.mass) == ("torus", pytest.approx(u.Mearth.to("kg")))
    assert (scene.equation_of_state.name, list(scene.observables)) == ("logotrope", ["quadrupole_phase"])
    by_class = [{"kind": cubic_drag, "k": "2e-9 s/m2"}, "gravity"]
    tables = {"kind": torus, "mass": 1 * u.Mearth, "major_radius": 1e4 * u.km, "minor_radius": 2e6 * u.m}
    named = astroinertia.Scene(body={**tables, "particles": 64}, effects=by_class, **rest)
    assert named.effects["cubic_drag"] == scene.effects["cubic_drag"]
    assert named.body.options == pytest.approx(scene.body.options)


def test_a_repr_of_a_scene_is_short() -> None:
    assert repr(loads(SCENE)) == "Scene(name='core', model='sph', effects=['gravity', 'pressure', 'damping'])"


def test_help_and_tab_show_the_keys_of_a_scene() -> None:
    keys = list(inspect.signature(astroinertia.Scene).parameters)
    assert {"name", "body", "effects", "time", "output"} <= set(keys) and not {"source", "own", "choice"} & set(keys)
    assert len(str(inspect.signature(astroinertia.Scene))) < 500
