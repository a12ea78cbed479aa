"""Observables from outside the package: given from Python, or offered by an installed package; and refusals."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import astroinertia
from astroinertia.accuracy.selected_observables import parsed
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.observables import REQUIRED, Dimension, Observable, positive
from astroinertia.plots import summary
from astroinertia.scene.load import loads
from astroinertia.scene.plan import plan
from tests.plugin_example import EXAMPLE, distribution, example, installed_in, stopped_at

RATE = 0.7
TURNING = f"""
name = "turning"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 2.0, 2.5]
[body.rotation]
law = "rigid"
rate = {RATE}
[effects]
[time]
end = 6.0
[output]
series_every = 0.1
"""
GAS = """
name = "gas"
[body]
kind = "uniform"
mass = "1 Msun"
radius = "1 Rsun"
particles = 100
relax = false
[body.rotation]
law = "rigid"
rate = "1e-4 rad/s"
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = "1 h"
max_steps = 32
[output]
series_every = "1 min"
checkpoint_seconds = 0.0
"""
LISTED = GAS + "[observables.quadrupole_phase]\n"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the example package is installed in."""
    return installed_in(tmp_path_factory.mktemp("installed"))


@pytest.fixture
def phase(monkeypatch: pytest.MonkeyPatch) -> Any:
    return example(monkeypatch, "quadrupole_phase", "QuadrupolePhase")


@dataclass(frozen=True)
class MassWithin(Observable):
    """Mass within a radius of the centre of mass. It is that of particles."""

    radius: Any

    kind: ClassVar[str] = "mass_within"
    long_name: ClassVar[str] = "mass within a radius"
    dimension: ClassVar[str] = "mass"
    models: ClassVar[tuple[str, ...]] = ("sph",)
    options: ClassVar = {"radius": positive("length", REQUIRED, "about the centre of mass")}

    def value(self, body):
        assert body.particles is not None and "time" not in body.particles
        distance = np.linalg.norm(body.particles["position"] - body.centre_of_mass, axis=1)
        return body.particles["mass"][distance < self.radius].sum()


@dataclass(frozen=True)
class Again(Observable):
    """What the dataset has already: the force of each effect."""

    kind: ClassVar[str] = "force_again"
    long_name: ClassVar[str] = "force of each effect"
    dims: ClassVar[tuple[str, ...]] = ("effect", "i")
    dimension: ClassVar[Any] = Dimension(1, 1, -2)
    source: ClassVar[str] = "Newton"

    def value(self, body):
        assert body.particles is None
        return body.force


# What is recorded


@pytest.mark.full
def test_the_phase_of_a_turning_body_is_its_angle(phase, tmp_path) -> None:
    found = astroinertia.open(astroinertia.run_scene(loads(TURNING), tmp_path / "run", observables=[phase()]))
    angle = RATE * found.time.values
    assert angle[-1] > np.pi  # it comes round
    assert np.exp(2j * found.quadrupole_phase.values) == pytest.approx(np.exp(2j * angle), abs=1e-12)
    assert abs(found.quadrupole_phase).max() <= np.pi / 2
    attrs = found.quadrupole_phase.attrs
    assert (attrs["units"], attrs["long_name"]) == ("rad", "phase of the quadrupole about z")
    assert attrs["comment"].startswith("the angle from x to the long axis") and "reason" not in attrs
    assert attrs["origin"] == "the class QuadrupolePhase of quadrupole_phase, given from Python"
    assert json.loads(found.attrs["own_observables"]) == {"quadrupole_phase": attrs["origin"]}
    assert "quadrupole phase (rad)" in summary(found)


@pytest.mark.parametrize("model", ["sph", pytest.param("ellipsoid", marks=pytest.mark.full), "scaling"])
def test_every_model_has_it_in_the_units_of_the_dataset(model, phase, tmp_path) -> None:
    scene = loads(GAS, [f'model="{model}"', "time.max_steps=4"], effects=[phase(), Again()])
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    assert found.force_again.dims == ("time", "effect", "i") and found.force_again.attrs["units"] == "kg m s-2"
    assert found.force_again.attrs["comment"] == "what the dataset has already: the force of each effect; Newton"
    np.testing.assert_array_equal(found.force_again.values, found.force.values)
    tensor = found.second_moment
    x, y = (tensor.sel(i="x", j="x") - tensor.sel(i="y", j="y")).values, 2 * tensor.sel(i="x", j="y").values
    if model == "sph":
        # At the start particles are placed so that the body is round about z.
        assert found.quadrupole_phase.values[1:] == pytest.approx(0.5 * np.arctan2(y, x)[1:], abs=1e-9)
        assert abs(found.force_again).max() > 0.0
    else:  # round about z
        assert "quadrupole_phase" not in found
        assert found.inertia.absent["quadrupole_phase"] == "the observable has no value for this body"


@pytest.mark.slow
def test_particles_and_options_come_in_the_units_of_the_run(tmp_path) -> None:
    scene = loads(GAS, ["time.max_steps=4"])
    own = [MassWithin("0.5 Rsun")]
    folder = tmp_path / "run"
    found = astroinertia.open(astroinertia.run_scene(scene, folder, observables=own))
    shots = astroinertia.open_tree(folder)["snapshots"].dataset.isel(snapshot_time=0)
    distance = np.linalg.norm(shots.position.values - found.centre_of_mass.values[0], axis=1)
    within = shots.mass.values[distance < 0.5 * 6.957e8].sum()
    assert 0.0 < within < found.mass.values[0]
    assert found.mass_within.values[0] == pytest.approx(within, rel=1e-12)
    assert found.mass_within.attrs["units"] == "kg"
    with pytest.raises(SceneError, match=r"\[observables.mass_within\] radius: must be more than 0"):
        loads(GAS, effects=[MassWithin(-1.0)])


@pytest.mark.full
def test_sinks_leave_their_particles_out(tmp_path) -> None:
    file = Path(__file__).parents[2] / "sims/collapse_to_sink.toml"
    scene = astroinertia.load(file, ["body.particles=300"])
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run", observables=[MassWithin(1e6)]))
    assert found.accreted_mass.values[-1] > 0.0
    assert found.mass_within.values == pytest.approx(found.mass.values, rel=1e-12)


# Going on


@pytest.mark.slow
def test_a_run_goes_on_bit_for_bit_and_names_what_is_missing(phase, tmp_path, monkeypatch) -> None:
    scene, own = loads(GAS), [phase(), MassWithin("0.5 Rsun")]
    whole = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "whole", observables=own))
    plain = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "plain"))
    both = ["quadrupole_phase", "mass_within", "wall_time"]
    assert plain.drop_vars("wall_time").equals(whole.drop_vars(both))  # it changes nothing else
    with monkeypatch.context() as patch:
        stopped_at(patch, 16)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(scene, tmp_path / "parts", observables=own)
    so_far = astroinertia.open(tmp_path / "parts")  # without its class
    assert so_far.quadrupole_phase.attrs["units"] == "rad"
    with pytest.raises(
        ArchiveError, match=r"with the observable 'quadrupole_phase' \(the class QuadrupolePhase of qua"
    ):
        astroinertia.resume(tmp_path / "parts", observables=[MassWithin])
    with pytest.raises(ArchiveError, match=r"which is not here: .*resume or branch, as observables=\[\.\.\.\]"):
        astroinertia.resume(tmp_path / "parts", observables=[phase])
    with pytest.raises(
        SceneError, match="'mass_within' is given with other options than the run began with: radius = "
    ):
        astroinertia.resume(tmp_path / "parts", observables=[phase, MassWithin("0.4 Rsun")])
    with pytest.raises(SceneError, match="the observable 'force_again' is given, but the run began without it"):
        astroinertia.resume(tmp_path / "parts", observables=[phase, MassWithin, Again])
    parts = astroinertia.resume(tmp_path / "parts", observables=[phase, MassWithin])
    assert astroinertia.open(parts).drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    assert astroinertia.resume(tmp_path / "parts") == parts  # finished: it needs nothing any more


def test_one_that_no_package_offers_is_not_known() -> None:
    sentence = r"\[observables\] quadrupole_phase is not a known observable; no installed package offers one\."
    with pytest.raises(SceneError, match=sentence):
        loads(LISTED)


def test_only_the_entry_point_that_a_scene_lists_is_imported(tmp_path, monkeypatch) -> None:
    (tmp_path / "unasked_for.py").write_text("raise RuntimeError('imported')")
    points = "unasked_for = unasked_for:Unasked\nmass = a:A\nturned = quadrupole_phase:QuadrupolePhase"
    distribution(tmp_path, points, group="observables")
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.syspath_prepend(tmp_path)
    loads(GAS)
    assert "unasked_for" not in sys.modules
    for kind, sentence in {
        "unasked_for": r"observable 'unasked_for' of stranger 2\.0 cannot be imported \(RuntimeError: imported",
        "mass": r"an observable 'mass' is offered by stranger 2\.0 and by this package, which has one built in",
        "turned": "offers an observable as 'turned' whose kind is 'quadrupole_phase'",
        "unasked_fro": "unasked_fro.* is not a known observable; did you mean 'unasked_for'",
        '"os:system"': r'"os:system".* is not a known observable',
    }.items():
        with pytest.raises(SceneError, match=sentence):
            loads(f"{GAS}[observables.{kind}]\n")


def test_a_plan_says_what_it_is_and_where_it_comes_from(phase) -> None:
    scene = loads(GAS, effects=[phase(), MassWithin("0.5 Rsun")])
    first, second = plan(scene).sections["observables"]
    assert (first.name, first.value) == ("quadrupole_phase", "phase of the quadrupole about z (rad)")
    assert first.why.startswith("from the class QuadrupolePhase of quadrupole_phase, given from Python; Q_22 = ")
    assert second.value == "mass within a radius (kg)" and second.why.startswith("radius 3.4785e+08 m; from the class")
    assert "quadrupole_phase: phase of the quadrupole about z (rad)" in plan(scene).text()
    assert loads(LISTED, effects=[phase]).model_dump() == loads(
        LISTED.replace("[observables.quadrupole_phase]\n", ""), effects=[phase()]
    ).model_dump() | {"source": LISTED, "overrides": ()}
    assert parsed("quadrupole_phase", scene.observables).variable == "quadrupole_phase"  # a run can be judged by it


# What is refused


def made(**parts: Any) -> type:
    """A class of an observable with these parts."""
    usual = {"kind": "made", "long_name": "made", "value": lambda self, body: 0.0}
    return dataclass(frozen=True)(type("Made", (Observable,), usual | parts))


def written(body: Any) -> float:
    body.second_moment[0, 0] = 0.0
    return 0.0


@pytest.mark.parametrize(
    ("dims", "value", "sentence"),
    [
        ((), lambda body: 1 / 0, r"'made' failed at step 0 \(ZeroDivisionError: division by zero\)"),
        ((), lambda body: body.nothing, r"'made' failed at step 0 \(AttributeError: "),
        ((), written, r"'made' failed at step 0 \(ValueError: assignment destination is read-only"),
        ((), lambda body: [1.0, [2.0]], r"'made' failed at step 0 \(ValueError"),
        ((), lambda body: 1j, r"'made' gave no real numbers at step 0, but complex128"),
        ((), lambda body: "much", r"'made' gave no real numbers at step 0, but str"),
        ((), lambda body: None, r"'made' gave no real numbers at step 0, but object"),
        ((), lambda body: np.zeros(1), r"gave an array of the shape \(1,\) at step 0; it must be a number, \(\)"),
        (("i",), lambda body: np.zeros(4), r"shape \(4,\) at step 0; it must be of its dims \(i\), \(3,\)"),
        (("effect", "i"), lambda body: np.zeros((1, 3)), r"\(1, 3\) at step 0; it must be of its dims \(effect, i\), "),
    ],
)
def test_a_value_that_is_none_ends_in_a_sentence(dims, value, sentence, tmp_path) -> None:
    own = made(dims=dims, value=lambda self, body: value(body))
    scene = loads(GAS, ['model="ellipsoid"'])
    with pytest.raises(SceneError, match=f"^the observable {sentence}" if "'made'" in sentence else sentence):
        astroinertia.run_scene(scene, tmp_path / "run", observables=[own()])


@pytest.mark.slow
def test_what_was_recorded_is_kept_where_it_fails_later_and_goes_on_once_it_is_right(tmp_path) -> None:
    failing = made(value=lambda self, body: 1.0 if body.time < 0.5 else 1 / 0)
    with pytest.raises(SceneError, match="failed at step"):
        astroinertia.run_scene(loads(TURNING), tmp_path / "run", observables=[failing()])
    assert astroinertia.open(tmp_path / "run").made.values == pytest.approx(1.0)
    right = made(value=lambda self, body: np.nan if body.time < 0.5 else 2)
    found = astroinertia.open(astroinertia.resume(tmp_path / "run", observables=[right]))
    assert found.made.values[-1] == 2.0 and found.made.dtype == np.float64 and found.sizes["time"] == 61


@pytest.mark.parametrize(
    ("own", "sentence"),
    [
        (3.0, "float is no observable: it must be a subclass of astroinertia.observables.Observable"),
        (type("Bare", (Observable,), {"kind": "bare", "value": lambda *_: 0.0}), "decorate it with @dataclass(frozen"),
        (dataclass(frozen=True)(type("Empty", (Observable,), {"kind": "empty"})), "Empty is no observable: it has no "),
        (made(kind="mass"), "its kind 'mass' is the name of a built-in one"),
        (made(kind="bar_phase"), "'bar_phase' is the name of a built-in one"),
        (made(kind="sink_mass"), "'sink_mass' is the name of a built-in one"),
        (made(kind="time"), "'time' is the name of a built-in one"),
        (made(kind="region_mass"), "a kind that begins with region_ is of regions"),
        (made(long_name=" "), "its `long_name` must say what it is"),
        (made(dims=("radius_bin",)), "its `dims` must be a tuple of some of effect, i, j, principal, mode, each once"),
        (made(dims=("i", "effect")), "effect first"),
        (made(dims=("i", "i")), "each once"),
        (made(dims="ij"), "its `dims` must be a tuple"),
        (made(dimension="colour"), "its `dimension` must be a name or Dimension(mass, length, time)"),
    ],
)
def test_what_is_no_observable_is_refused_in_a_sentence(own: Any, sentence: str, tmp_path) -> None:
    with pytest.raises(SceneError) as refused:
        astroinertia.run_scene(loads(GAS), tmp_path / "run", observables=[own])
    assert sentence in str(refused.value)


def test_what_a_scene_cannot_have_of_it_is_refused_in_a_sentence(phase, tmp_path) -> None:
    with pytest.raises(SceneError, match=r"\[observables.mass_within\] belongs to the model sph, not ellipsoid"):
        loads(GAS, ['model="ellipsoid"'], effects=[MassWithin(1.0)])
    with pytest.raises(SceneError, match="'quadrupole_phase' is listed in the scene and given besides"):
        loads(LISTED, effects=[phase()])
    with pytest.raises(SceneError, match="the observable 'quadrupole_phase' is given twice"):
        loads(GAS, effects=[phase, phase()])
    with pytest.raises(SceneError, match=r"observables: must be a table with a table for each observable, not "):
        loads('observables = ["quadrupole_phase"]\n' + GAS)
    with pytest.raises(SceneError, match=r"\[observables.quadrupole_phase\] width is not a known key"):
        loads(LISTED + "width = 1\n", effects=[phase])
    file = tmp_path / "sweep.toml"
    file.write_text(GAS + '[sweep]\n"body.mass" = ["1 Msun", "2 Msun"]\n')
    with pytest.raises(SceneError, match=r"\[sweep\] takes no observable from Python"):
        astroinertia.run_scene(file, tmp_path / "run", observables=[phase()])


@pytest.mark.slow
def test_a_description_from_elsewhere_is_checked(phase, tmp_path) -> None:
    astroinertia.run_scene(loads(TURNING), tmp_path / "run", observables=[phase()])
    (tmp_path / "run" / "turning.nc").unlink()
    for name in ("manifest.json", "manifest-copy.json"):
        file = tmp_path / "run" / name
        written = json.loads(file.read_text())
        written["metadata"]["observables"]["quadrupole_phase"]["dims"] = ["time", "time", "nowhere"]
        file.write_text(json.dumps(written))
    with pytest.raises(ArchiveError):
        astroinertia.open(tmp_path / "run")
