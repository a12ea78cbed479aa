"""Effects from outside the package: given from Python, or offered by an installed package; what is refused, and how."""

import sys
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import astroinertia
from astroinertia.build.effects import effects_of
from astroinertia.effects import (
    Dimension,
    Effect,
    Measure,
    Option,
    Output,
    PairTerm,
    not_negative,
    positive,
    pytree,
)
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.scene.load import load_file, loads, with_effects
from astroinertia.scene.plan import code_units, plan
from tests.plugin_example import EXAMPLE, distribution, example, installed_in, stopped_at

pytestmark = pytest.mark.usefixtures("steps_differ")

K, SPEED, END, STEP = 0.3, 1.5, 1.0, 0.02
SCENE = f"""
name = "free_fall_through_a_medium"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
particles = 100
velocity = [{SPEED}, 0.0, 0.0]
relax = false
[equation_of_state]
kind = "ideal"
[effects]
[time]
end = {END}
[output]
series_every = 0.1
checkpoint_seconds = 0.0
[numerics]
max_timestep = {STEP}
"""
LISTED = SCENE.replace("[effects]", f"[effects.cubic_drag]\nk = {K}")
SI = """
name = "in_si"
[body]
kind = "uniform"
mass = "1 Msun"
radius = "1 Rsun"
particles = 100
[equation_of_state]
kind = "ideal"
[effects.gravity]
[time]
end = "1 s"
"""


def exact_speed(time: Any) -> Any:
    return SPEED / np.sqrt(1.0 + 2.0 * K * SPEED**2 * time)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the example package is installed in."""
    return installed_in(tmp_path_factory.mktemp("installed"))


@pytest.fixture
def drag(installed: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    return example(monkeypatch, "cubic_drag", "CubicDrag")


def assert_the_drag_is_exact(dataset: Any, tolerance: float) -> None:
    times = dataset.time.values
    speed = dataset.momentum.sel(i="x").values
    assert speed == pytest.approx(exact_speed(times), rel=tolerance)
    lost = 0.5 * (exact_speed(times) ** 2 - SPEED**2)
    work = dataset.work.sel(effect="cubic_drag").values
    assert work == pytest.approx(lost, abs=tolerance)
    # Work is what the ledger says that kinetic energy has lost, to round-off, whatever the step.
    assert work == pytest.approx(dataset.kinetic_energy.values - dataset.kinetic_energy.values[0], abs=1e-13)
    assert float(abs(dataset.ledger_closure).max()) < 1e-13
    assert float(abs(dataset.integration_energy_error).max()) < 1e-13
    assert dataset.heating.sel(effect="cubic_drag").values == pytest.approx(0.0, abs=1e-15)


# From Python


@pytest.mark.slow
def test_an_effect_from_python_acts_as_its_equation_says_and_goes_on_bit_for_bit(drag, tmp_path, monkeypatch) -> None:
    scene = loads(SCENE)
    whole = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "whole", effects=[drag(k=K)]))
    assert_the_drag_is_exact(whole, 1e-4)
    with monkeypatch.context() as patch:
        stopped_at(patch, 20)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(scene, tmp_path / "parts", effects=[drag(k=K)])

    with pytest.raises(ArchiveError, match=r"with the effect 'cubic_drag' \(the class CubicDrag of cubic_drag, given"):
        astroinertia.resume(tmp_path / "parts")
    with pytest.raises(SceneError, match=r"'cubic_drag' is given with other options than the run began with: k = 0\.3"):
        astroinertia.resume(tmp_path / "parts", effects=[drag(k=0.4)])
    with pytest.raises(SceneError, match="'other' is given, but the run began without it"):
        astroinertia.resume(tmp_path / "parts", effects=[drag, Other()])
    parts = astroinertia.resume(tmp_path / "parts", effects=[drag(k=K)])
    assert astroinertia.open(parts).drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    assert astroinertia.resume(tmp_path / "parts") == parts  # finished: it needs no effect any more
    assert "given from Python" in whole.attrs["own_effects"]


# In xla beside a function: tests/unit/effects/test_by_function.py.
@pytest.mark.full
@pytest.mark.parametrize("setting", ['engine="xla"', 'timesteps="individual"'])
def test_it_acts_the_same_in_the_other_engine_and_with_individual_steps(drag, tmp_path, setting) -> None:
    scene = loads(SCENE, [f"numerics.{setting}"], effects=[drag(k=K)])
    assert_the_drag_is_exact(astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run")), 1e-4)


@pytest.mark.full
def test_halving_the_step_takes_a_fourth_of_the_error(drag, tmp_path) -> None:
    errors = []
    for step in (0.05, 0.025):  # outputs are met by whole numbers of them
        scene = loads(SCENE, [f"numerics.max_timestep={step}"])
        found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / str(step), effects=[drag(k=K)]))
        errors.append(abs(float(found.momentum.sel(i="x")[-1]) - exact_speed(END)))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_the_time_step_resolves_the_decay_of_the_fastest(drag, tmp_path) -> None:
    scene = loads(SCENE, ["numerics.max_timestep=1.0", "numerics.courant=0.05"])
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run", effects=[drag(k=K)]))
    first = float(found.timestep[0])
    assert first == pytest.approx(0.05 / (K * SPEED**2), rel=1e-12)


def test_numbers_are_in_the_units_of_the_scene(drag, tmp_path) -> None:
    units = code_units(loads(SI))
    wanted = 3e-9 * units.length**2 / units.time  # k has the dimension of a time over an area
    for k in (3e-9, "3e-9 s/m2", "3e-3 s/km2", np.float64(3e-9)):
        scene = loads(SI, effects=[drag(k=k)])
        (effect,) = (each for each in effects_of(scene, code_units(scene)) if each.kind == "cubic_drag")
        assert effect.k == pytest.approx(wanted, rel=1e-14), k
        assert "k 3e-09 m-2 s" in plan(scene).text()
    assert loads(SI, effects=[drag(k=1.0 / 3.0)]).effects["cubic_drag"]["k"] == 1.0 / 3.0
    with pytest.raises(SceneError, match=r"cubic_drag\] k: '3 m' is not a quantity in m-2 s"):
        loads(SI, effects=[drag(k="3 m")])
    with pytest.raises(SceneError, match=r"cubic_drag\] k: must be more than 0"):
        loads(SI, effects=[drag(k=-1.0)])


def test_the_class_alone_stands_for_what_the_scene_lists(drag, tmp_path) -> None:
    (tmp_path / "scene.toml").write_text(LISTED)
    scene = load_file(tmp_path / "scene.toml", effects=[drag])
    assert scene.effects["cubic_drag"] == {"k": K}
    assert scene.model_dump() == loads(LISTED, effects=[drag], origin=str(tmp_path)).model_dump()
    with pytest.raises(SceneError, match="is listed in the scene and given besides"):
        loads(LISTED, effects=[drag(k=K)])
    with pytest.raises(SceneError, match=r"has no \[effects.cubic_drag\]: write it there, or give CubicDrag"):
        with_effects(loads(SCENE), [drag])
    with pytest.raises(SceneError, match=r"\[effects.cubic_drag\] k is missing"):
        loads(SCENE + "[effects.cubic_drag]\n", effects=[drag])


def test_a_plan_says_where_an_effect_comes_from_and_that_its_size_is_not_stated(drag) -> None:
    found = plan(loads(SCENE, effects=[drag(k=K)]))
    (line,) = (each for each in found.effects if each.kind == "cubic_drag")
    assert line.listed and line.loop == "over particles"
    assert line.origin == "the class CubicDrag of cubic_drag, given from Python"
    assert line.size == "its size is not known: the effect states no size"
    assert "from the class CubicDrag" in found.text()
    assert all(not each.origin for each in found.effects if each.kind != "cubic_drag")


def test_an_effect_that_states_no_size_is_on_where_effects_are_chosen(drag) -> None:
    text = SCENE.replace("[effects]", "").replace("units =", 'effects = "auto"\nunits =')
    scene = loads(text, effects=[drag(k=K)])
    assert scene.reasons["cubic_drag"].startswith("on: its size is not known")
    assert scene.effects["cubic_drag"] == {"k": K}


@pytest.mark.slow
def test_a_run_that_was_chosen_to_leave_an_effect_out_goes_on_and_branches(drag, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(drag, "size", Measure("k", "none", "here", lambda body, options: (0.0, 0.0)))
    text = SCENE.replace("[effects]", "").replace("units =", 'effects = "auto"\nunits =')
    scene = loads(text, effects=[drag(k=K)])
    assert "cubic_drag" not in scene.effects and scene.reasons["cubic_drag"].startswith("off: k is 0")
    with monkeypatch.context() as patch:
        stopped_at(patch, 3)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(scene, tmp_path / "run")
    with pytest.raises(SceneError, match=r"'cubic_drag' is given with other options than the run began with: k = 0\.3"):
        astroinertia.resume(tmp_path / "run", effects=[drag(k=0.4)])
    branch = astroinertia.branch(tmp_path / "run", tmp_path / "branch", effects=[drag(k=0.4)])
    assert "cubic_drag" not in astroinertia.open(branch).effect
    assert astroinertia.open(astroinertia.resume(tmp_path / "run", effects=[drag])).time.values[-1] == END


# Pair terms


def pull(xp, r, W_i, W_j, strength_i, strength_j):
    """A pull that is symmetric in i and j."""
    return (0.5 * (strength_i + strength_j) * r * (W_i + W_j),)


@pytree
@dataclass(frozen=True, eq=False)
class Cohesion(Effect):
    """A pull between neighbours."""

    strength: Any = 1.0
    kind: ClassVar[str] = "cohesion"
    options: ClassVar = {"strength": not_negative("dimensionless", 1.0, "of the pull")}

    @property
    def neighbour_terms(self):
        """The pull."""
        return (PairTerm(self.kind, pull, (Output("acceleration", "central"),)),)

    def fields(self, xp, fluid):
        """The strength, of each particle."""
        return {"strength": xp.zeros_like(fluid.mass) + self.strength}


@pytree
@dataclass(frozen=True, eq=False)
class Other(Effect):
    """Nothing."""

    kind: ClassVar[str] = "other"

    def potential_energy(self, xp, fluid):
        """None."""
        return 0.0


@pytest.mark.slow
def test_a_pair_term_from_outside_is_compiled_and_pulls(drag, tmp_path) -> None:
    scene = loads(SCENE, ["time.end=0.2", "output.series_every=0.1"], effects=[Cohesion(), drag(k=K)])
    assert scene.entries["cohesion"].cost == "neighbours" and scene.entries["cubic_drag"].cost == "particles"
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    assert list(found.effect.values) == ["cohesion", "cubic_drag"]
    pulled = found.sel(effect="cohesion").isel(time=-1)
    assert abs(pulled.force).max() < 1e-13 and float(np.trace(pulled.virial_tensor)) < -1e-3
    assert float(abs(pulled.virial_tensor - pulled.virial_tensor.values.T).max()) < 1e-15
    assert float(abs(found.ledger_closure).max()) < 1e-13


@pytree
@dataclass(frozen=True, eq=False)
class Repulsion(Effect):
    """A push between neighbours, whose field and memory have the names of another effect's."""

    strength: Any = -5.0
    named: str = field(default="strength", metadata={"static": True})
    remembered: str = field(default="", metadata={"static": True})
    kind: ClassVar[str] = "repulsion"
    options: ClassVar = {
        "strength": Option("dimensionless", -5.0, "of the push"),
        "named": Option("choice", "strength", "its name", choices=("strength", "sound_speed", "mass")),
        "remembered": Option("choice", "", "its name", choices=("", "viscosity_alpha")),
    }

    @property
    def neighbour_terms(self):
        """The push."""
        return (PairTerm(self.kind, pull, (Output("acceleration", "central"),)),)

    def fields(self, xp, fluid):
        """The strength, of each particle."""
        return {"strength": xp.zeros_like(fluid.mass)} | {self.named: xp.zeros_like(fluid.mass) + self.strength}

    def initial_memory(self, xp, fluid):
        """Nothing of use."""
        return {self.remembered: xp.zeros_like(fluid.mass)} if self.remembered else {}


@pytest.mark.parametrize(
    ("effects", "sentence"),
    [
        ([Cohesion(), Repulsion()], "'repulsion' has a field 'strength' of pairs, and 'cohesion' another: rename one"),
        ([Repulsion(named="sound_speed")], "'repulsion' has a field 'sound_speed' of pairs, and 'pressure' another"),
        ([Repulsion(named="mass")], "'repulsion' has a field 'mass' of pairs, and every fluid another"),
        (
            [Repulsion(remembered="viscosity_alpha")],
            "'repulsion' and another have a memory 'viscosity_alpha': rename one",
        ),
    ],
)
def test_a_name_of_a_field_or_a_memory_means_one_array(effects: Any, sentence: str, tmp_path: Path) -> None:
    text = SCENE.replace("[effects]", "[effects.pressure]\n[effects.viscosity]")
    text = text.replace("particles = 100", "particles = 100\nspecific_internal_energy = 0.1")
    with pytest.raises(SceneError, match=sentence):
        astroinertia.run_scene(loads(text), tmp_path / "run", effects=effects)


@pytree
@dataclass(frozen=True, eq=False)
class Spring(Effect):
    """A pull a = -k x to the origin, and a turn, without a virial tensor of its own."""

    k: Any = 2.0
    kind: ClassVar[str] = "spring"
    external: ClassVar[bool] = True
    options: ClassVar = {"k": positive(Dimension(0, 0, -2), 2.0, "over the distance")}

    def acceleration(self, xp, fluid):
        """-k x."""
        return -self.k * fluid.position

    def drag(self, fluid):
        """A turn of velocities about z."""
        return np.array([[0.0, 3.0, 0.0], [-3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def test_the_virial_tensor_of_an_effect_that_states_none_is_that_of_its_forces(tmp_path) -> None:
    found = astroinertia.open(
        astroinertia.run_scene(loads(SCENE, ["time.end=0.2"]), tmp_path / "run", effects=[Spring()])
    )
    turn = found.mixed_moment.values @ np.asarray(Spring().drag(None)).T
    expected = turn - 2.0 * found.second_moment.values  # V = sum m x (x) (-k x + M v) = -k Q + P M^T
    assert found.virial_tensor.sel(effect="spring").values == pytest.approx(expected, abs=2e-3)
    assert found.virial_tensor.values[0, 0] == pytest.approx(expected[0], abs=1e-14)  # later v is that of a kick's end
    assert float(found.virial_mismatch.max()) < 1e-14


@pytree
@dataclass(frozen=True, eq=False)
class Herd(Effect):
    """A pull to the centre that goes with the mean distance of all."""

    kind: ClassVar[str] = "herd"

    def acceleration(self, xp, fluid):
        """-R x, R the mean distance."""
        place = fluid.position - fluid.centre
        return -(fluid.mass * xp.sqrt((place**2).sum(axis=1))).sum() / fluid.mass.sum() * place


@pytree
@dataclass(frozen=True, eq=False)
class WholeHerd(Herd):
    """The same, which says so."""

    kind: ClassVar[str] = "whole_herd"
    whole_body: ClassVar[bool] = True


@pytest.mark.slow
def test_what_depends_on_particles_that_are_not_due_says_so_or_is_refused(tmp_path) -> None:
    scene = loads(SCENE.replace("[numerics]", '[numerics]\ntimesteps = "individual"').replace("end = 1.0", "end = 0.1"))
    with pytest.raises(SceneError, match=r"'herd' gives to a particle depends on others, .* whole_body = True"):
        astroinertia.run_scene(scene, tmp_path / "refused", effects=[Herd()])
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run", effects=[WholeHerd()]))
    assert float(found.work.sel(effect="whole_herd")[-1]) > 1e-3


# Parts that are not as they must be


def with_part(**parts: Any) -> Any:
    """An effect with these parts."""
    return pytree(dataclass(frozen=True, eq=False)(type("Odd", (Effect,), {"kind": "odd", **parts})))()


def with_term(pair: Any, *outputs: Output, of: str = "odd") -> Any:
    """An effect with this pair term over neighbours."""
    return with_part(neighbour_terms=property(lambda self: (PairTerm(of, pair, outputs),)))


def near(xp, r, W_i):
    """One number."""
    return (r * W_i,)


def screened(xp, r):
    """What no engine compiles."""
    return (xp.exp(-r),)


CENTRAL = Output("acceleration", "central")
ANOTHER: Any = "mean"  # no way to gather


@pytest.mark.parametrize(
    ("effect", "sentence"),
    [
        (with_term(near, CENTRAL, of="gravity"), "a pair term is of the effect 'gravity', and not of its own"),
        (with_term(near, CENTRAL, Output("heating", "sum")), "near must return a tuple of 2, a number an output"),
        (with_term(near, Output("acceleration", "sum")), "acceleration is gathered as 'sum', and must be as 'central'"),
        (with_term(near, Output("push", "central")), "push is gathered as 'central', and would move nothing: call it"),
        (with_term(near, Output("rate", ANOTHER)), "rate is gathered as 'mean', not as central, sum, max, outer"),
        (
            with_term(screened, CENTRAL),
            "neighbour_terms of the effect 'odd': .* xp.exp cannot stand in a pair function",
        ),
        (
            with_part(all_pair_terms=property(lambda self: {}["k"])),
            r"part all_pair_terms of .* 'odd' failed \(KeyError: 'k'\)",
        ),
        (with_part(neighbour_terms=property(lambda self: [near])), "<function near .* is no PairTerm"),
        (with_part(virial=lambda self, xp, fluid: xp.zeros(3)), r"gave a virial of the shape \(3,\), not \(3, 3\)"),
        (with_part(drag=lambda self, fluid: -0.1), r"gave a drag of the shape \(\), not \(3, 3\)"),
        (
            with_part(potential_energy=lambda self, xp, fluid: fluid.mass),
            r"gave a potential_energy of the shape \(100,\), not \(\)",
        ),
        (
            with_part(timestep=lambda self, xp, fluid: fluid.position),
            r"gave a timestep of the shape \(100, 3\), not \(100,\)",
        ),
        (
            with_part(exchange=lambda self, xp, fluid: fluid.mass),
            "gave an exchange that is not a tuple of two, gain and decay",
        ),
    ],
)
def test_a_part_that_is_not_as_it_must_be_is_said_in_a_sentence(effect: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=sentence):
        astroinertia.run_scene(loads(SCENE), tmp_path / "run", effects=[effect])


# From an installed package


def test_only_the_entry_point_that_a_scene_lists_is_imported(tmp_path, monkeypatch) -> None:
    (tmp_path / "unasked_for.py").write_text("raise RuntimeError('imported')")
    distribution(
        tmp_path, "unasked_for = unasked_for:Unasked\nnot_there = nowhere:Nothing\nrenamed = cubic_drag:CubicDrag"
    )
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.syspath_prepend(tmp_path)
    loads(SI)
    assert "unasked_for" not in sys.modules
    with pytest.raises(SceneError, match=r"'unasked_for' of stranger 2\.0 cannot be imported \(RuntimeError: imported"):
        loads(SCENE + "[effects.unasked_for]\n")
    with pytest.raises(SceneError, match=r"'not_there' of stranger 2\.0 cannot be imported \(ModuleNotFoundError"):
        loads(SCENE + "[effects.not_there]\n")
    with pytest.raises(SceneError, match="offers an effect as 'renamed' whose kind is 'cubic_drag'"):
        loads(SCENE + "[effects.renamed]\n")
    with pytest.raises(SceneError, match="unasked_fro is not a known effect; did you mean 'unasked_for'"):
        loads(SCENE + "[effects.unasked_fro]\n")
    with pytest.raises(SceneError, match="dampign is not a known effect; did you mean 'damping'"):
        loads(SCENE + "[effects.dampign]\n")
    with pytest.raises(SceneError, match=r'"os:system" is not a known effect'):
        loads(SCENE + '[effects."os:system"]\n')


def test_a_name_that_two_offer_is_refused(tmp_path, monkeypatch) -> None:
    distribution(tmp_path, "gravity = cubic_drag:CubicDrag\nslow = a:A")
    distribution(tmp_path, "slow = b:B", "another")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(SceneError, match=r"'gravity' is offered by stranger 2\.0 and by this package"):
        loads(SI)
    with pytest.raises(
        SceneError, match=r"'slow' is offered by (stranger|another) 2\.0 and by (another|stranger) 2\.0"
    ):
        loads(SCENE + "[effects.slow]\n")


# What is no effect


def made(**parts: Any) -> type:
    """A class of an effect with these parts."""
    return pytree(dataclass(frozen=True, eq=False)(type("Made", (Effect,), {"kind": "made", **parts})))


@pytest.mark.parametrize(
    ("effect", "sentence"),
    [
        (3.0, "float is no effect: it must be a subclass of astroinertia.effects.Effect"),
        (dataclass(frozen=True, eq=False)(type("Bare", (Effect,), {"kind": "bare"})), "decorate it with @pytree"),
        (made(kind="damping"), "'damping' is the name of a built-in one"),
        (made(kind="motion"), "'motion' is the name of a built-in one"),
        (
            made(torque=lambda self, body: body.angular_momentum),
            'it has parts for rigid and none for sph, which its `models` name; say `models: ClassVar = ("rigid",)`',
        ),
        (
            made(acceleration=lambda self, xp, fluid: fluid.velocity, time_step=lambda self, xp, fluid: 1.0),
            "nothing would call one of its functions (time_step is not among them; did you mean 'timestep'?)",
        ),
        (
            made(acceleration=lambda self, xp, fluid: fluid.velocity, heating=lambda self, xp, fluid: fluid.density),
            "nothing would call one of its functions (heating is not among them; did you mean 'exchange'?)",
        ),
        (
            made(models=("ellipsoid", "rigid"), affine_push=lambda self, body: body.velocity),
            "it has parts for ellipsoid and none for rigid",
        ),
        (
            made(
                __annotations__={"law": str},
                law=field(default="a"),
                options={"law": Option("choice", "a", "law", choices=("a", "b"))},
            ),
            'its field law must have the metadata {"static": True}',
        ),
    ],
)
def test_what_is_no_effect_is_refused_in_a_sentence(effect: Any, sentence: str) -> None:
    with pytest.raises(SceneError) as refused:
        loads(SCENE, effects=[effect])
    assert sentence in str(refused.value)


@pytree
@dataclass(frozen=True, eq=False)
class Flat(Effect):
    """An acceleration of the wrong shape."""

    kind: ClassVar[str] = "flat"

    def acceleration(self, xp: Any, fluid: Any) -> Any:
        """One number a particle."""
        return fluid.velocity[:, 0]


@pytree
@dataclass(frozen=True, eq=False)
class Lost(Effect):
    """A field that no fluid has."""

    kind: ClassVar[str] = "lost"

    def acceleration(self, xp: Any, fluid: Any) -> Any:
        """None such."""
        return fluid.nothing


@pytest.mark.parametrize(
    ("effect", "sentence"),
    [
        (Flat(), r"the effect 'flat' gave an acceleration of the shape \(100,\), not \(100, 3\)"),
        (Lost(), r"the part acceleration of the effect 'lost' failed \(AttributeError: .* no attribute 'nothing'\)"),
    ],
)
def test_what_a_class_does_wrong_is_said_in_a_sentence(effect: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=sentence):
        astroinertia.run_scene(loads(SCENE), tmp_path / "run", effects=[effect])


def test_an_effect_of_another_model_is_refused(drag) -> None:
    text = SI.replace('name = "in_si"', 'name = "in_si"\nmodel = "ellipsoid"')
    with pytest.raises(SceneError, match=r"\[effects.cubic_drag\] belongs to the model sph; ellipsoid has gravity"):
        loads(text, effects=[drag(k="1 s/m2")])


def test_a_sweep_takes_no_effect_from_python(drag, tmp_path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(SCENE + '[sweep]\n"body.mass" = [1.0, 2.0]\n')
    with pytest.raises(SceneError, match=r"\[sweep\] takes no effect from Python"):
        astroinertia.run_scene(file, tmp_path / "run", effects=[drag(k=K)])


def test_the_example_is_small() -> None:
    for name in ("pyproject.toml", "cubic_drag.py", "logotrope.py", "quadrupole_phase.py", "torus.py"):
        assert len((EXAMPLE / name).read_text().splitlines()) < 60
    points = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]["entry-points"]
    assert points == {
        "astroinertia.effects": {"cubic_drag": "cubic_drag:CubicDrag"},
        "astroinertia.matter": {"logotrope": "logotrope:Logotrope"},
        "astroinertia.observables": {"quadrupole_phase": "quadrupole_phase:QuadrupolePhase"},
        "astroinertia.bodies": {"torus": "torus:Torus"},
    }
