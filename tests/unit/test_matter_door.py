"""Equations of state from outside the package: given from Python, or offered by an installed package; and refusals."""

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit

import astroinertia
from astroinertia.build.fluids import equation_of_state
from astroinertia.build.spheres import sphere
from astroinertia.errors import ArchiveError, RunInterrupted, SceneError
from astroinertia.matter import Matter, Option, positive, pytree
from astroinertia.matter.equation import disagreement
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan
from tests.plugin_example import EXAMPLE, distribution, example, installed_in, stopped_at

pytestmark = pytest.mark.usefixtures("steps_differ")

P0, RHO0, A = 0.3, 0.24, 0.2
BODY = """
name = "cloud"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
particles = 200
relax = false
"""
REST = """
[effects.pressure]
[effects.gravity]
[effects.viscosity]
[time]
end = 0.4
[output]
series_every = 0.05
checkpoint_seconds = 0.0
[numerics]
max_timestep = 0.01
"""
NAMED = f'{BODY}[equation_of_state]\nkind = "logotrope"\nreference_pressure = {P0}\nreference_density = {RHO0}\n{REST}'
IDEAL = f'{BODY}[equation_of_state]\nkind = "ideal"\n{REST}'
SI = """
name = "in_si"
[body]
kind = "uniform"
mass = "1 Msun"
radius = "0.1 pc"
particles = 100
[equation_of_state]
kind = "logotrope"
reference_pressure = "3e-12 Pa"
reference_density = "1e-17 kg/m3"
[effects.gravity]
[effects.pressure]
[time]
end = "1 kyr"
"""

FALL = (-2.0 * np.eye(3)).tolist()


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the example package is installed in."""
    return installed_in(tmp_path_factory.mktemp("installed"))


@pytest.fixture
def logotrope(monkeypatch: pytest.MonkeyPatch) -> Any:
    return example(monkeypatch, "logotrope", "Logotrope")


@pytree
@dataclass(frozen=True)
class Warm(Matter):
    """Murnaghan's cold curve with Grueneisen's thermal pressure: P = (K/n)((rho/rho0)^n - 1) + A rho^(g + 1)."""

    bulk_modulus: Any = 1.0
    stiffness: Any = 4.0
    density: Any = 0.24
    grueneisen: Any = 0.5

    kind: ClassVar[str] = "warm"
    thermal: ClassVar[bool] = True
    options: ClassVar = {
        "bulk_modulus": positive("pressure", 1.0, "K"),
        "stiffness": positive("dimensionless", 4.0, "n"),
        "density": positive("density", 0.24, "rho0"),
        "grueneisen": positive("dimensionless", 0.5, "g"),
    }

    def cold(self, xp, rho):
        """u of the coldest matter."""
        n, x = self.stiffness, rho / self.density
        return self.bulk_modulus / (n * rho) * (x**n / (n - 1.0) + 1.0)

    def pressure(self, xp, rho, A):
        """P, (N,)."""
        x, n = rho / self.density, self.stiffness
        return self.bulk_modulus / n * (x**n - 1.0) + A * rho ** (self.grueneisen + 1.0)

    def internal_energy(self, xp, rho, A):
        """u, (N,)."""
        return self.cold(xp, rho) + A * rho**self.grueneisen / self.grueneisen

    def sound_speed(self, xp, rho, A):
        """c, (N,)."""
        cold = self.bulk_modulus / self.density * (rho / self.density) ** (self.stiffness - 1.0)
        return xp.sqrt(cold + (self.grueneisen + 1.0) * A * rho**self.grueneisen)

    def entropy(self, xp, rho, u):
        """A, (N,)."""
        return xp.maximum(u - self.cold(xp, rho), 0.0) * self.grueneisen / rho**self.grueneisen

    def entropy_rate(self, xp, rho, q):
        """dA/dt, (N,)."""
        return q * self.grueneisen / rho**self.grueneisen


# Thermodynamics


@pytest.mark.slow
@pytest.mark.parametrize("warmth", [0.0, 0.7])
def test_pressure_energy_and_sound_speed_agree(logotrope, warmth) -> None:
    with jax.enable_x64(True):
        rho = jnp.logspace(-2, 1, 40)
        for matter in (logotrope(reference_pressure=P0, reference_density=RHO0, slope=A), Warm()):
            label = matter.entropy(jnp, rho, matter.internal_energy(jnp, rho, 0.0 * rho) + warmth)

            def each(name, matter=matter, label=label):
                slope = jax.grad(lambda r, a: getattr(matter, name)(jnp, r[None], a[None])[0])
                return np.asarray(jax.vmap(slope)(rho, label))

            pressure, speed, energy, thermal, per_heat = (np.asarray(part) for part in matter.state(jnp, rho, label))
            assert np.asarray(rho) ** 2 * each("internal_energy") == pytest.approx(pressure, rel=1e-12)
            assert each("pressure") == pytest.approx(speed**2, rel=1e-12)
            assert thermal == pytest.approx(warmth if matter.thermal else 0.0, abs=1e-7)
            heated = np.asarray(matter.internal_energy(jnp, rho, label + 0.1 * per_heat))
            assert heated - energy == pytest.approx(0.1 if matter.thermal else 0.0, abs=1e-7)
            for mine, numpys in zip((pressure, speed), matter.state(np, np.array(rho), np.array(label)), strict=False):
                assert mine == pytest.approx(numpys, rel=1e-12)


def test_the_logotrope_is_what_its_paper_says(logotrope) -> None:
    matter = logotrope(reference_pressure=P0, reference_density=RHO0)
    one = np.array([RHO0])
    assert matter.pressure(np, one, 0.0) == pytest.approx(P0)
    assert matter.pressure(np, one * np.exp(-5.0), 0.0) == pytest.approx(
        0.0, abs=1e-15
    )  # where a cloud of A = 0.2 ends
    assert matter.sound_speed(np, one, 0.0) ** 2 == pytest.approx(A * P0 / RHO0)


class Wrong:
    """What goes wrong in formulas, each by itself, and how it is said."""

    def pressure(self, xp, rho, A):
        """A factor."""
        return 1.02 * Warm.pressure(self, xp, rho, A)  # type: ignore[arg-type]

    def sound_speed(self, xp, rho, A):
        """A factor."""
        return 1.02 * Warm.sound_speed(self, xp, rho, A)  # type: ignore[arg-type]

    def entropy(self, xp, rho, u):
        """Another power."""
        return Warm.entropy(self, xp, rho, u) * rho  # type: ignore[arg-type]

    def entropy_rate(self, xp, rho, q):
        """A factor."""
        return 2.0 * Warm.entropy_rate(self, xp, rho, q)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        ("pressure", "its `pressure` is not rho^2 du/drho of its `internal_energy`"),
        ("sound_speed", "its `sound_speed` is not the root of dP/drho of its `pressure`"),
        ("entropy", "its `entropy` is not the A that `internal_energy` has that energy at"),
        ("entropy_rate", "its `entropy_rate` is not dA/du of its `internal_energy`"),
    ],
)
def test_functions_that_disagree_are_refused(part, sentence, tmp_path) -> None:
    wrong = type("Faulty", (Warm,), {"kind": "faulty", part: getattr(Wrong, part), "__doc__": "A fault."})
    wrong = pytree(dataclass(frozen=True)(wrong))
    assert disagreement(Warm(), 0.24) == "" and disagreement(wrong(), 0.24) == sentence
    text = IDEAL.replace("radius = 1.0", "radius = 1.0\nspecific_internal_energy = 6.0")
    with pytest.raises(SceneError, match="equation of state faulty would not conserve energy: its `") as refused:
        astroinertia.run_scene(loads(text), tmp_path / "run", matter=wrong())
    assert sentence in str(refused.value) and not (tmp_path / "run").exists()


def test_units_of_the_scene_change_nothing_in_the_agreement(logotrope) -> None:
    for scale in (1e-25, 1e25):
        assert disagreement(logotrope(reference_pressure=scale**1.5, reference_density=scale), scale) == ""


# Exact results

WAVE = """
name = "wave"
units = "code"
[body]
kind = "table"
file = "wave.csv"
[equation_of_state]
kind = "ideal"
[box]
lengths = [1.0, {across}, {across}]
[effects.pressure]
[time]
end = 0.3
[output]
series_steps = 1
[numerics]
max_timestep = 0.02
kernel = "wendland_c6"
neighbours = 250.0
"""


def squared_frequency(folder: Path, fluid: str = "", matter: Any = None) -> float:
    """Of a standing sound wave one box long at density 1, over that of a wave with c = 1."""
    along, across = 24, 10
    axes = [(np.arange(n) + 0.5) / along for n in (along, across, across)]
    x, y, z = (each.ravel() for each in np.meshgrid(*axes, indexing="ij"))
    mass = np.full_like(x, 1.0 / along**3)
    table = np.c_[mass, x, y, z, 1e-4 * np.sin(2.0 * np.pi * x), 0.0 * x, 0.0 * x]
    folder.mkdir()
    np.savetxt(folder / "wave.csv", table, delimiter=",", header="mass,x,y,z,vx,vy,vz", comments="")
    text = WAVE.format(across=across / along)
    scene = loads(text, [f"equation_of_state={fluid}"] if fluid else (), origin=str(folder))
    found = astroinertia.open(astroinertia.run_scene(scene, folder / "run", matter=matter))
    time, kinetic = found.time.values, found.kinetic_energy.values / found.kinetic_energy.values[0]
    (omega,), _ = curve_fit(lambda t, omega: np.cos(omega * t) ** 2, time, kinetic, [2.0 * np.pi])
    assert np.cos(omega * time) ** 2 == pytest.approx(kinetic, abs=1e-4)
    return (omega / (2.0 * np.pi)) ** 2


@pytest.mark.full
def test_sound_waves_have_the_speed_of_the_equation(logotrope, tmp_path) -> None:
    """c^2 = A P0/rho0, to what particles on a lattice resolve: they add to it in proportion to P/rho."""
    isothermal = squared_frequency(tmp_path / "1", '{kind = "isothermal", sound_speed = 1.0}')
    polytropic = squared_frequency(tmp_path / "2", '{kind = "polytropic", gamma = 2.0, constant = 0.5}')
    steep = logotrope(reference_pressure=1.0, reference_density=1.0, slope=1.0)
    flat = logotrope(reference_pressure=5.0, reference_density=1.0, slope=0.2)
    # All have c = 1; P/rho is 1, 1/2, 1 and 5. The steep one is, to first order, the isothermal gas.
    found = squared_frequency(tmp_path / "3", matter=steep)
    assert found == pytest.approx(1.0, abs=0.04) and found == pytest.approx(isothermal, rel=2e-3)
    by_pressure = 2.0 * (isothermal - polytropic)
    expected = isothermal + 4.0 * by_pressure
    assert squared_frequency(tmp_path / "4", matter=flat) == pytest.approx(expected, rel=2e-3)


@pytest.mark.full
def test_an_ellipsoid_of_it_pulsates_as_its_equation_of_motion_says(logotrope, tmp_path) -> None:
    """(3/5) M R'' = -(3/5) G M^2/R^2 + 4 pi R^2 P of a sphere whose density stays uniform."""
    scene = loads(NAMED, ["model=ellipsoid", "numerics.tolerance=1e-11", "time.end=2.0"], effects=[logotrope])
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    volume = 4.0 / 3.0 * np.pi

    def rates(t, y):
        rho = 1.0 / (volume * y[0] ** 3)
        pressure = P0 * (1.0 + A * np.log(rho / RHO0))
        return y[1], -1.0 / y[0] ** 2 + 5.0 / 3.0 * 3.0 * volume * y[0] ** 2 * pressure

    exact = solve_ivp(rates, (0.0, 2.0), (1.0, 0.0), "DOP853", found.time.values, rtol=1e-12, atol=1e-12).y[0]
    radius = np.sqrt(2.5 * found.inertia_tensor.sel(i="z", j="z").values)
    assert np.ptp(exact) > 0.1 and radius == pytest.approx(exact, rel=1e-8)
    assert float(abs(found.integration_energy_error).max()) < 1e-9


# Runs


@pytest.mark.full
@pytest.mark.parametrize(
    "setting",
    [
        "numerics.precision=float64",
        "numerics.engine=xla",
        "numerics.timesteps=individual",
    ],
)
def test_energy_and_ledger_close(logotrope, tmp_path, setting) -> None:
    # Other tests have gravity and viscosity in xla, where a program is compiled for every matter.
    text = NAMED.replace("[effects.gravity]\n[effects.viscosity]\n", "") if "xla" in setting else NAMED
    scene = loads(text, [setting, "time.end=0.1"], effects=[logotrope])
    found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run"))
    assert float(abs(found.ledger_closure).max()) < 1e-13
    released = float(found.kinetic_energy[-1])
    # What viscosity heats is radiated; the rest is kept but for the error of steps.
    assert released > 0.01 and float(abs(found.integration_energy_error).max()) < 5e-3
    assert "given from Python" in found.attrs["own_matter"]


@pytest.mark.slow
@pytest.mark.parametrize("timesteps", ["global", pytest.param("individual", marks=pytest.mark.full)])
def test_matter_that_can_be_warm_keeps_what_viscosity_heats(tmp_path, timesteps) -> None:
    text = IDEAL.replace("radius = 1.0", f"radius = 1.0\nspecific_internal_energy = 6.0\nvelocity_gradient = {FALL}")
    errors = []
    for step in (0.005, 0.0025):  # outputs are met by whole numbers of them
        scene = loads(text, [f"numerics.max_timestep={step}", f"numerics.timesteps={timesteps}", "time.end=0.2"])
        found = astroinertia.open(astroinertia.run_scene(scene, tmp_path / str(step), matter=Warm()))
        errors.append(float(found.total_energy[-1] - found.total_energy[0]))
        assert float(abs(found.ledger_closure).max()) < 1e-13
        assert float(found.heating.sel(effect="viscosity")[1:].max()) > 0.01
    assert abs(errors[1]) < 1e-3 and errors[0] / errors[1] == pytest.approx(4.0, rel=0.25)


@pytest.mark.slow
def test_a_run_goes_on_bit_for_bit_and_names_what_is_missing(logotrope, tmp_path, monkeypatch) -> None:
    matter = logotrope(reference_pressure=P0, reference_density=RHO0)
    file = tmp_path / "scene.toml"
    file.write_text(IDEAL)  # in whose place it comes
    whole = astroinertia.open(astroinertia.run_scene(file, tmp_path / "whole", matter=matter))
    named = astroinertia.open(astroinertia.run_scene(loads(NAMED, effects=[logotrope]), tmp_path / "named"))
    assert named.drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    with monkeypatch.context() as patch:
        stopped_at(patch, 20)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(file, tmp_path / "parts", matter=matter)
    with pytest.raises(
        ArchiveError, match=r"with the equation of state 'logotrope' \(the class Logotrope of logotrope, g"
    ):
        astroinertia.resume(tmp_path / "parts")
    other = logotrope(reference_pressure=P0, reference_density=0.3)
    with pytest.raises(
        SceneError, match=r"other options than the run began with: reference_pressure = 0\.3, reference_d"
    ):
        astroinertia.resume(tmp_path / "parts", matter=other)
    with pytest.raises(ArchiveError, match=r"equation of state 'logotrope' .* is not here"):
        astroinertia.resume(tmp_path / "parts", matter=Warm())
    parts = astroinertia.resume(tmp_path / "parts", matter=logotrope)
    assert astroinertia.open(parts).drop_vars("wall_time").equals(whole.drop_vars("wall_time"))
    assert astroinertia.resume(tmp_path / "parts") == parts  # finished: it needs nothing any more


def test_a_plan_says_where_it_comes_from_and_measures_with_it(logotrope) -> None:
    found = plan(loads(NAMED, effects=[logotrope])).text()
    assert "kind: logotrope (P = P0 (1 + A ln(rho/rho0))" in found
    assert "from the class Logotrope of logotrope, given from Python; McLaughlin & Pudritz 1996" in found
    assert "reference density: 0.24 (rho0" in found
    # Of the sphere, 3 Pi = 3 M P/rho and |W| = 3/5.
    ratio = 0.6 / (3.0 * P0 * (1.0 + A * np.log(0.75 / np.pi / RHO0)) * 4.0 / 3.0 * np.pi)
    assert f"|W| over 3 Pi + 2 T is {ratio:.2g}" in found


def test_numbers_are_in_the_units_of_the_scene(logotrope) -> None:
    scene = loads(SI, effects=[logotrope])
    units = code_units(scene)
    made = equation_of_state(scene, units, sphere(scene, units))
    assert made.reference_pressure == pytest.approx(3e-12 / units.unit("pressure"), rel=1e-14)
    assert made.reference_density == pytest.approx(1e-17 / units.unit("density"), rel=1e-14)
    assert "reference pressure: 3e-12 kg m-1 s-2" in plan(scene).text()
    given = logotrope(reference_pressure="3e-13 J/cm3", reference_density=1e-17)
    text = SI.replace('kind = "logotrope"', 'kind = "ideal"').replace("reference_", "# ")
    other = loads(text, effects=[given])
    assert other.equation_of_state.options["reference_density"] == 1e-17  # pyright: ignore
    assert other.equation_of_state.options["reference_pressure"] == pytest.approx(3e-7)  # pyright: ignore
    for key, sentence in (
        ("reference_density=2 m", r"\[equation_of_state\] reference_density: '2 m' is not a density"),
        ("reference_density=-1 kg/m3", r"\[equation_of_state\] reference_density: must be more than 0"),
        (
            "reference_density=1e80 kg/m3",
            r"\[equation_of_state\] reference_density: must be at most 1e\+35 in the units",
        ),
        ("slop=0.1", r"\[equation_of_state\] slop is not a known key; did you mean 'slope'"),
    ):
        with pytest.raises(SceneError, match=sentence):
            loads(SI, [f"equation_of_state.{key}"], effects=[logotrope])


def test_several_bodies_are_of_one_matter(logotrope) -> None:
    body = BODY.split("[body]")[1]
    text = NAMED.replace(
        BODY, BODY.split("[body]")[0] + f"[[bodies]]{body}[[bodies]]{body}position = [3.0, 0.0, 0.0]\n"
    )
    found = plan(loads(text, effects=[logotrope])).text()
    assert "kind: logotrope" in found


# From an installed package


def test_one_that_no_package_offers_is_not_known() -> None:
    with pytest.raises(SceneError, match=r"\[equation_of_state\] kind: must be one of ideal, isothermal"):
        loads(NAMED)


def test_only_the_entry_point_that_a_scene_names_is_imported(tmp_path, monkeypatch) -> None:
    (tmp_path / "unasked_matter.py").write_text("raise RuntimeError('imported')")
    points = "unasked = unasked_matter:Unasked\nnot_there = nowhere:Nothing\nrenamed = logotrope:Logotrope"
    distribution(tmp_path, points, group="matter")
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.syspath_prepend(tmp_path)
    loads(IDEAL)
    assert "unasked_matter" not in sys.modules
    for kind, sentence in (
        ("unasked", r"equation of state 'unasked' of stranger 2\.0 cannot be imported \(RuntimeError: imported"),
        ("not_there", r"'not_there' of stranger 2\.0 cannot be imported \(ModuleNotFoundError"),
        ("renamed", "offers an equation of state as 'renamed' whose kind is 'logotrope'"),
        ("unaskde", r"\[equation_of_state\] kind: 'unaskde' is not known; did you mean 'unasked'"),
        ("idael", r"\[equation_of_state\] kind: 'idael' is not known; did you mean 'ideal'"),
        ("own", r"\[equation_of_state\] kind: must be one of ideal, .*, renamed, not the text 'own'"),
        ("os:system", r"\[equation_of_state\] kind: must be one of ideal"),
    ):
        with pytest.raises(SceneError, match=sentence):
            loads(IDEAL, [f'equation_of_state.kind="{kind}"'])


def test_a_name_that_is_built_in_is_refused(tmp_path, monkeypatch) -> None:
    distribution(tmp_path, "ideal = logotrope:Logotrope", group="matter")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(
        SceneError, match=r"state 'ideal' is offered by stranger 2\.0 and by this package, which has one"
    ):
        loads(IDEAL)


# What is refused


def made(**parts: Any) -> type:
    """A class of matter with these parts."""
    return pytree(dataclass(frozen=True)(type("Made", (Warm,), {"kind": "made", "__doc__": "Made.", **parts})))


@pytest.mark.parametrize(
    ("matter", "sentence"),
    [
        (3.0, "float is no equation of state: it must be a subclass of astroinertia.matter.Matter"),
        (type("Bare", (Warm,), {"kind": "bare"}), "Bare is no equation of state: decorate it with @pytree"),
        (made(kind="hybrid"), "'hybrid' is the name of a built-in one"),
        (made(kind="own"), "'own' is the name of a built-in one"),
        (made(curved=True), "its internal energy must be linear in A"),
        (made(entropy=Matter.entropy), "with `thermal` it must have `entropy` and `entropy_rate`"),
        (
            pytree(dataclass(frozen=True)(type("Half", (Matter,), {"kind": "half", "pressure": Warm.pressure}))),
            "Half is no equation of state: it has no `internal_energy`",
        ),
        (
            made(
                __annotations__={"law": str},
                law=field(default="a"),
                options={**Warm.options, "law": Option("choice", "a", "law", choices=("a", "b"))},
            ),
            'its field law must have the metadata {"static": True}',
        ),
    ],
)
def test_what_is_no_equation_of_state_is_refused_in_a_sentence(matter: Any, sentence: str, tmp_path) -> None:
    with pytest.raises(SceneError) as refused:
        astroinertia.run_scene(loads(IDEAL), tmp_path / "run", matter=matter)
    assert sentence in str(refused.value)


def test_what_a_scene_cannot_have_of_it_is_refused_in_a_sentence(logotrope, tmp_path) -> None:
    with pytest.raises(
        SceneError,
        match=r"state 'logotrope' is given, but the scene has no \[equation_of_state\] of kind \"logotrope\"",
    ):
        loads(IDEAL, effects=[logotrope])
    with pytest.raises(SceneError, match="the equation of state is given twice; give one"):
        loads(IDEAL, effects=[logotrope, Warm])
    with pytest.raises(
        SceneError, match=r"warm has a thermal part, which .* in the models sph and scaling, not in ellips"
    ):
        loads(IDEAL, ["model=ellipsoid"], effects=[Warm()])
    with pytest.raises(SceneError, match=r"\[body.entropy\] needs an equation of state with a thermal part"):
        loads(NAMED, ["body.entropy=1.0"], effects=[logotrope])
    with pytest.raises(SceneError, match=r"needs specific_internal_energy: how warm matter of the kind warm is"):
        astroinertia.run_scene(loads(IDEAL), tmp_path / "run", matter=Warm())
    layered = loads(NAMED, effects=[logotrope]).source.replace('"uniform"', '"layered"').replace("radius = 1.0\n", "")
    with pytest.raises(SceneError, match="layered is for the model sph with materials for equation_of_state"):
        loads(layered + '[[body.layers]]\nmaterial = "rock"\nmass_fraction = 1.0\n', effects=[logotrope])
    (tmp_path / "sweep.toml").write_text(IDEAL + '[sweep]\n"body.mass" = [1.0, 2.0]\n')
    with pytest.raises(SceneError, match=r"\[sweep\] takes no equation of state from Python"):
        astroinertia.run_scene(tmp_path / "sweep.toml", tmp_path / "sweep", matter=Warm())


def test_options_that_contradict_each_other_are_refused_in_the_class_s_own_words() -> None:
    def from_options(cls, options):
        raise ValueError("needs a stiffness above the Grueneisen parameter.")

    with pytest.raises(SceneError, match=r"\[equation_of_state\] needs a stiffness above the Grueneisen parameter"):
        loads(IDEAL, effects=[made(from_options=classmethod(from_options))()])
