"""Initial bodies from outside the package: given from Python, or offered by an installed package; and refusals."""

import sys
import tracemalloc
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import astroinertia
from astroinertia.build.sph import evolution
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.inertia.tensor import inertia_tensor
from astroinertia.initial import Body, positive
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan
from astroinertia.scene.sweep import loads as sweep_of
from astroinertia.sph.cells import centres
from astroinertia.sph.placed import particles
from tests.plugin_example import EXAMPLE, distribution, example, stopped_at

M, R, r, L = 2.0, 1.0, 0.3, 0.5
BODY = f"""
name = "ring"
units = "code"
[body]
kind = "torus"
mass = {M}
major_radius = {R}
minor_radius = {r}
specific_angular_momentum = {L}
particles = 300
seed = 3
"""
REST = """
[equation_of_state]
kind = "isothermal"
sound_speed = 0.2
[effects.pressure]
[effects.gravity]
[time]
end = 0.3
[output]
series_every = 0.05
checkpoint_seconds = 0.0
[numerics]
max_timestep = 0.01
"""
NAMED = BODY + REST
OTHER = NAMED.replace('kind = "torus"', 'kind = "uniform"\nradius = 1.0\nrelax = false', 1)
OTHER = "\n".join(line for line in OTHER.splitlines() if not line.startswith(("major", "minor", "specific")))
SI = """
name = "in_si"
[body]
kind = "torus"
mass = "1 Mearth"
major_radius = "10000 km"
minor_radius = "2000 km"
particles = 64
[equation_of_state]
kind = "isothermal"
sound_speed = "1 km/s"
[effects.gravity]
[effects.pressure]
[time]
end = "1 hr"
"""


@pytest.fixture
def torus(monkeypatch: pytest.MonkeyPatch) -> Any:
    return example(monkeypatch, "torus", "Torus")


@dataclass(frozen=True)
class Slab(Body):
    """A slab that states nothing of itself."""

    thickness: Any = 0.2

    kind: ClassVar[str] = "slab"
    options: ClassVar = {"thickness": positive("length", 0.2, "from face to face")}

    def density(self, position):
        """Of one density, 3."""
        return np.where(abs(position[:, 2]) < 0.5 * self.thickness, 3.0, 0.0)

    def extent(self):
        """The box."""
        return 1.0, 1.0, self.thickness


def made(**parts: Any) -> type:
    """A class of bodies with these parts."""
    return dataclass(frozen=True)(type("Made", (Slab,), {"kind": "made", "__doc__": "Made.", **parts}))


# What is placed


@pytest.mark.full
def test_moments_of_the_particles_tend_to_those_of_a_solid_torus(torus) -> None:
    """C = M (R^2 + 3/4 r^2), A = M (R^2/2 + 5/8 r^2); a particle stands for its cell, whose size falls as N^-1/3."""
    exact = np.diag([M * (R**2 / 2 + 5 / 8 * r**2)] * 2 + [M * (R**2 + 3 / 4 * r**2)])
    errors = []
    for count in (200, 1600, 12800):
        placed = particles(torus(M, R, r, L), count, 1)
        assert placed["mass"] == pytest.approx(M / count, rel=1e-14)
        errors.append(np.abs(inertia_tensor(placed["mass"], placed["position"]) - exact).max() / exact.max())
        turning = np.cross(placed["position"], placed["velocity"])[:, 2]
        assert turning == pytest.approx(L, rel=1e-12)
    assert errors[0] < 0.03 and errors[2] < 2e-3
    assert errors[0] / errors[1] > 2.5 and errors[1] / errors[2] > 2.5


@pytest.mark.slow
def test_particles_have_the_density_that_the_class_says() -> None:
    slope = made(density=lambda self, x: np.where(abs(x).max(axis=1) < 1.0, 2.0 + x[:, 0], 0.0),
                 extent=lambda self: (1.0, 1.0, 1.0))  # fmt: skip
    placed = particles(slope(), 4000, 2)
    assert placed["mass"].sum() == pytest.approx(16.0, rel=2e-3)  # of the density itself, for no mass is stated
    assert placed["position"].mean(axis=0) == pytest.approx([1 / 6, 0.0, 0.0], abs=3e-3)
    again, other = (particles(slope(), 4000, seed)["position"] for seed in (2, 3))
    assert (again == placed["position"]).all() and not (other == placed["position"]).all()


def test_numbers_are_in_the_units_of_the_scene(torus) -> None:
    scene = loads(SI, effects=[torus])
    units = code_units(scene)
    assert units.length == pytest.approx(1.2e7) and units.mass == pytest.approx(5.97e24, rel=1e-2)
    placed = evolution(scene, units).state
    assert float(np.asarray(placed.mass).sum()) == pytest.approx(1.0)
    assert np.hypot(*np.asarray(placed.position)[:, :2].T).max() < 1.0
    with pytest.raises(SceneError, match=r"\[body\] major_radius: '2 kg' is not a length"):
        loads(SI, ["body.major_radius=2 kg"], effects=[torus])
    with pytest.raises(SceneError, match=r"\[body\] major_radii is not a known key; did you mean 'major_radius'"):
        loads(SI, ["body.major_radii=2 m"], effects=[torus])
    with pytest.raises(SceneError, match=r"\[body\] particles: must be at least 16"):
        loads(SI, ["body.particles=2"], effects=[torus])


# Runs


@pytest.mark.slow
def test_a_run_goes_on_bit_for_bit_and_names_what_is_missing(torus, tmp_path, monkeypatch) -> None:
    body = torus(mass=M, major_radius=R, minor_radius=r, specific_angular_momentum=L)
    file = tmp_path / "scene.toml"
    file.write_text(OTHER)  # in whose place it comes, with its particles and seed
    whole = astroinertia.open(astroinertia.run_scene(file, tmp_path / "whole", body=body))
    named = astroinertia.open(astroinertia.run_scene(loads(NAMED, effects=[torus]), tmp_path / "named"))
    assert named.drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    assert float(whole.angular_momentum.sel(i="z")[0]) == pytest.approx(M * L, rel=1e-4)  # about the centre of mass
    assert float(abs(whole.ledger_closure).max()) < 1e-13
    assert "the class Torus of torus, given from Python" in whole.attrs["own_bodies"]
    with monkeypatch.context() as patch:
        stopped_at(patch, 20)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(file, tmp_path / "parts", body=body)
    with pytest.raises(ArchiveError, match=r"with the initial body 'torus' \(the class Torus of torus, g.*body=\.\.\."):
        astroinertia.resume(tmp_path / "parts")
    with pytest.raises(SceneError, match=r"'torus' is given with other options than the run began with: mass = 2"):
        astroinertia.resume(tmp_path / "parts", body=torus(M, R, 0.2, L))
    with pytest.raises(ArchiveError, match=r"initial body 'torus' .* is not here"):
        astroinertia.resume(tmp_path / "parts", body=Slab)
    parts = astroinertia.resume(tmp_path / "parts", body=torus)
    assert astroinertia.open(parts).drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    assert astroinertia.resume(tmp_path / "parts") == parts  # finished: it needs nothing any more


@pytest.mark.full
def test_it_turns_as_a_rigid_body(torus, tmp_path) -> None:
    text = 'model = "rigid"\n' + BODY + "[effects]\n[time]\nend = 0.3\n"
    found = astroinertia.open(astroinertia.run_scene(loads(text, effects=[torus]), tmp_path / "run"))
    assert float(found.angular_momentum.sel(i="z")[-1]) == pytest.approx(M * L, rel=1e-4)
    assert float(found.inertia_tensor.sel(i="z", j="z")[-1]) == pytest.approx(M * (R**2 + 0.75 * r**2), rel=2e-2)


def test_a_plan_says_where_it_comes_from_and_what_it_does_not_state(torus) -> None:
    found = plan(loads(NAMED, effects=[torus])).text()
    assert "kind: torus (A torus of uniform density about the z axis" in found
    assert "from the class Torus of torus, given from Python; Papaloizou & Pringle 1984" in found
    assert "major radius: 1 (R, of" in found and "radius: 1.3\n" in found and "not stated" not in found
    bare = loads(NAMED.split("[body]")[0] + '[body]\nkind = "slab"\nparticles = 64\n' + REST, effects=[Slab])
    found = plan(bare).text()
    assert "mass and radius: not stated (so no sizes of effects follow from them)" in found
    assert "slab" in repr(bare.body) and "gravity" in found
    with pytest.raises(SceneError, match=r"\[units\] with mass and length .* kind slab, which does not state mass and"):
        loads(bare.source.replace('units = "code"', ""), ['time.end="1 s"', 'equation_of_state.sound_speed="1 m/s"',
                                                       'numerics={}', 'output={}'], effects=[Slab])  # fmt: skip


def test_one_of_several_bodies(torus, tmp_path) -> None:
    head, table = NAMED.split(REST)[0].split("[body]")
    text = f'{head}[[bodies]]{table}[[bodies]]\nkind = "uniform"\nmass = 1.0\nradius = 0.3\nparticles = 64\n' + \
        f"relax = false\n{REST}"  # fmt: skip
    scene = loads(text, effects=[torus])
    assert [body.title for body in scene.bodies] == ["torus", "uniform"] and "bodies.0" in plan(scene).text()
    assert float(np.asarray(evolution(scene, code_units(scene)).state.mass).sum()) == pytest.approx(M + 1.0)
    with pytest.raises(SceneError, match="an initial body is given, but the scene has several"):
        loads(text, effects=[torus(M, R, r)])


# From an installed package


def test_a_sweep_varies_the_options_of_an_installed_one(tmp_path, monkeypatch) -> None:
    distribution(tmp_path, "torus = torus:Torus", group="bodies")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(EXAMPLE)
    sweep = sweep_of(NAMED + '[sweep]\n"body.minor_radius" = [0.2, 0.3]\n')
    assert sweep is not None
    bodies: list[Any] = [sweep.scene(number).body for number in range(2)]
    assert [body.options["minor_radius"] for body in bodies] == [0.2, 0.3]


def test_only_the_entry_point_that_a_scene_names_is_imported(tmp_path, monkeypatch) -> None:
    (tmp_path / "unasked_body.py").write_text("raise RuntimeError('imported')")
    points = "unasked = unasked_body:Unasked\nnot_there = nowhere:Nothing\nrenamed = torus:Torus\nuniform = torus:Torus"
    distribution(tmp_path, points, group="bodies")
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.syspath_prepend(tmp_path)
    loads(OTHER.replace('"uniform"', '"polytrope"\nindex = 1.0'))
    assert "unasked_body" not in sys.modules
    for kind, sentence in (
        ("unasked", r"initial body 'unasked' of stranger 2\.0 cannot be imported \(RuntimeError: imported"),
        ("not_there", r"'not_there' of stranger 2\.0 cannot be imported \(ModuleNotFoundError"),
        ("renamed", "offers an initial body as 'renamed' whose kind is 'torus'"),
        ("uniform", r"initial body 'uniform' is offered by stranger 2\.0 and by this package, which has one"),
        ("unaskde", r"\[body\] kind: 'unaskde' is not known; did you mean 'unasked'"),
        ("own", r"\[body\] kind: must be one of polytrope, .*, renamed.*, not the text 'own'"),
        ("os:system", r"\[body\] kind: must be one of polytrope"),
    ):
        with pytest.raises(SceneError, match=sentence):
            loads(OTHER, [f'body.kind="{kind}"'])


# What is refused


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        (3.0, "float is no initial body: it must be a subclass of astroinertia.initial.Body"),
        (type("Bare", (Body,), {"kind": "bare"}), "Bare is no initial body: decorate it with @dataclass(frozen=True)"),
        (made(kind="dyson"), "'dyson' is the name of a built-in one"),
        (made(models=("ellipsoid",)), "its `models` must be some of sph, rigid"),
        (made(extent=Body.extent), "it must have `density` and `extent`, or `particles`"),
    ],
)
def test_what_is_no_body_is_refused_in_a_sentence(body: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as refused:
        astroinertia.run_scene(loads(OTHER), tmp_path / "run", body=body)
    assert sentence in str(refused.value)


def result(**arrays: Any) -> Any:
    """A `particles` that returns those arrays besides what is right."""

    def found(self, count, rng):
        return {"mass": np.ones(count), "position": rng.normal(size=(count, 3)), **arrays}

    return found


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ({"particles": result(mass=np.ones(3))}, "has a mass of the shape (3,) for 300 particles, not (300,)"),
        ({"particles": result(mass=np.zeros(300))}, "has a mass that is not positive"),
        ({"particles": result(velocity=np.full((300, 3), np.nan))}, "has a velocity that is not finite"),
        ({"particles": result(internal_energy=-np.ones(300))}, "has an internal_energy that is negative"),
        ({"particles": result(colour=np.ones(300))}, "they need mass and position"),
        ({"density": lambda self, x: -np.ones(len(x))}, "its density must be a finite number that is not negative"),
        ({"density": lambda self, x: np.zeros(len(x))}, "its density is zero in almost all of its extent"),
        # Points that the first lattice happened to meet, and no other.
        ({"density": lambda self, x: np.full(len(x), len(x) == 32**3)}, "its density is zero in almost all of its"),
        ({"extent": lambda self: (1.0, 0.0, 1.0)}, "its extent must be three positive lengths"),
        (
            {"density": lambda self, x: 1.0 * ((x - 0.5) ** 2).sum(axis=1) < 0.04, "extent": lambda self: 3 * (3.0,)},
            "its extent, 3, 3, 3 to either side of the origin, is so large or so long for it that",
        ),
        ({"extent": lambda self: (1e9, 1.0, 1.0)}, "its extent, 1e+09, 1, 1 to either side of the origin, is so large"),
        ({"velocity": lambda self, x: 1 / 0}, "cannot be placed (ZeroDivisionError"),
        ({"mass": -1.0}, "states a mass that is no positive number"),
        (
            {"characteristic": lambda self: {"colour": 1.0}},
            "states colour, which is none of the characteristic",
        ),
    ],
)
def test_what_its_functions_return_is_checked(parts: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as refused:
        astroinertia.run_scene(loads(OTHER), tmp_path / "run", body=made(**parts)())
    assert sentence in str(refused.value) and "the made of the class Made of" in str(refused.value)


@pytest.mark.parametrize("far", [2.0, 6.0])
def test_memory_goes_as_the_particles_however_far_the_extent_reaches(far: float) -> None:
    """A ball of radius 1 in a cube of 250 times as many points as it holds takes little more than in its own."""
    count = 200
    tracemalloc.start()
    place, mass = centres(lambda x: 1.0 * ((x**2).sum(axis=1) < 1.0), 3 * (far,), count, np.random.default_rng(1))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert mass == pytest.approx(4.0 * np.pi / 3.0, rel=0.15)
    assert np.abs(place.mean(axis=0)).max() < 0.03 and (np.linalg.norm(place, axis=1) < 1.0).all()
    assert most < 10e6  # all points of the larger cube at once take 100 MB


def test_what_a_scene_cannot_have_of_it_is_refused_in_a_sentence(torus) -> None:
    for settings, sentence in (
        (["model=scaling"], "of the kind torus is for the models sph and rigid, not for scaling"),
        (["body.relax=true"], r"\[body\] has relax, but its class places its particles"),
        (["body.placement=random"], r"\[body\] has a placement, but its class places its particles"),
        (["body.pressure_fraction=0.5"], r"\[body\] has a pressure_fraction, but no equilibrium"),
    ):
        with pytest.raises(SceneError, match=sentence):
            loads(NAMED, settings, effects=[torus])
    with pytest.raises(SceneError, match=r"initial body 'torus' is given, but the scene has no \[body\] of kind"):
        loads(OTHER, effects=[torus])
    with pytest.raises(SceneError, match="the initial body is given twice; give one"):
        loads(NAMED, effects=[torus, Slab])
    with pytest.raises(SceneError, match=r"\[sweep\] takes no initial body from Python"):
        loads(NAMED + '[sweep]\n"body.mass" = [1.0, 2.0]\n', effects=[torus])
    warm = loads(NAMED, ['equation_of_state={kind = "ideal"}'], effects=[torus])
    with pytest.raises(SceneError, match="of the kind torus, which has no `internal_energy`, needs specific_"):
        evolution(warm, code_units(warm))
