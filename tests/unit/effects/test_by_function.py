"""A force or a torque that is a plain function: what it does, in which units, and what is said where it fails."""

import functools
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from astropy import units as u

import astroinertia
from astroinertia.effects.own import with_functions
from astroinertia.errors import ArchiveError, AstroinertiaError, RunInterrupted, SceneError
from astroinertia.scene.load import load_file, loads
from astroinertia.scene.plan import plan
from astroinertia.units import DIMENSIONLESS
from tests.plugin_example import example, stopped_at

pytestmark = pytest.mark.usefixtures("steps_differ")

ROOT = Path(__file__).parents[3]
K, SPEED, END = 0.3, 1.5, 0.4
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
snapshot_every = 0.1
checkpoint_seconds = 0.0
[numerics]
max_timestep = 0.02
"""
SI = """
name = "a_star_in_the_wind"
[body]
kind = "uniform"
mass = "1 Msun"
radius = "1 Rsun"
particles = 100
relax = false
[equation_of_state]
kind = "ideal"
[effects]
[time]
end = "40 min"
[output]
series_every = "10 min"
"""
RIGID = """
name = "a_wheel"
model = "rigid"
[body]
kind = "rigid"
mass = "2 kg"
moments = ["1 kg m2", "2 kg m2", "2.5 kg m2"]
[body.rotation]
rate = "3 rad/s"
axis = [0.2, 0.1, 1.0]
[effects]
[time]
end = "4 s"
[output]
series_every = "1 s"
"""


def cubic(state: Any) -> Any:
    """Drag in proportion to the cube of the speed, in plain NumPy."""
    return -K * np.sum(state.velocities**2, axis=1)[:, None] * state.velocities


def upwards(state: Any) -> Any:
    """The same pull on all particles."""
    return np.full(state.positions.shape, 0.1) * (0.0, 0.0, 1.0)


def run(scene: Any, folder: Path, *effects: Any) -> Any:
    return astroinertia.open(astroinertia.run_scene(scene, folder, effects=effects))


@pytest.fixture
def drag(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The class of the example, which says the same as `cubic`."""
    return example(monkeypatch, "cubic_drag", "CubicDrag")(k=K)


# What it does


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting", ['engine="numba_cpu"', pytest.param('engine="xla"', marks=pytest.mark.full), 'timesteps="individual"']
)
def test_drag_by_a_function_is_that_of_the_class(drag, tmp_path, setting) -> None:
    scene = loads(SCENE, [f"numerics.{setting}"])
    by_class, by_function = (run(scene, tmp_path / name, effect) for name, effect in (("a", drag), ("b", cubic)))
    assert list(by_function.effect.values) == ["cubic"]
    for name in ("momentum", "work", "force", "kinetic_energy", "inertia_tensor", "impulse"):
        assert by_function[name].values == pytest.approx(by_class[name].values, rel=1e-12, abs=1e-13), name
    assert float(abs(by_function.virial_tensor - by_class.virial_tensor.values).max()) < 1e-13
    assert float(abs(by_function.ledger_closure).max()) < 1e-13
    assert float(abs(by_function.integration_energy_error).max()) < 1e-13
    assert float(by_function.virial_mismatch.max()) < 1e-13


@pytest.mark.full
def test_halving_the_step_takes_a_fourth_of_the_error(tmp_path) -> None:
    errors = []
    for step in (0.05, 0.025):  # outputs are met by whole numbers of them
        ds = run(loads(SCENE, [f"numerics.max_timestep={step}"]), tmp_path / str(step), cubic)
        errors.append(abs(float(ds.momentum.sel(i="x")[-1]) - SPEED / np.sqrt(1.0 + 2.0 * K * SPEED**2 * END)))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.slow
def test_states_and_accelerations_are_in_si(tmp_path) -> None:
    seen: list[Any] = []

    def wind(state: Any) -> Any:
        """Wind along x."""
        seen.append(state)
        return np.broadcast_to(np.array([2.0, 0.0, 0.0]), state.positions.shape)

    def gale(state: Any) -> Any:
        return np.broadcast_to([0.2, 0.0, 0.0], state.positions.shape) * u.cm / u.ms**2 * 1e-3

    scene = loads(SI, ["output.series_every='40 min'"])
    ds = run(scene, tmp_path / "wind", wind)
    mass, end = 1.98841e30, 2400.0
    assert ds.momentum.sel(i="x").values[-1] == pytest.approx(2.0 * end * mass, rel=1e-5)
    assert ds.work.sel(effect="wind").values[-1] == pytest.approx(0.5 * mass * (2.0 * end) ** 2, rel=1e-5)
    last = seen[-1]
    assert last.time == pytest.approx(end) and last.masses.sum() == pytest.approx(mass, rel=1e-5)
    assert np.linalg.norm(last.positions - last.centre_of_mass, axis=1).max() == pytest.approx(6.957e8, rel=0.15)
    assert last.velocities[:, 0] == pytest.approx(2.0 * end)
    assert last.centre_of_mass_velocity == pytest.approx([2.0 * end, 0.0, 0.0])
    assert last.densities.max() == pytest.approx(float(ds.density_max[-1]), rel=1e-12)
    planned = loads(SI, effects=with_functions([wind]))
    assert planned.entries["wind"].text == "wind along x"
    assert "wind of tests.unit.effects.test_by_function, given from Python" in plan(planned).text()
    quantity = run(scene, tmp_path / "gale", gale)
    assert quantity.momentum.values == pytest.approx(ds.momentum.values, rel=1e-13)
    assert "the function" in ds.attrs["own_effects"] and "wind" in ds.attrs["own_effects"]


@pytest.mark.full
@pytest.mark.parametrize("integrator", ["splitting", "adaptive"])
def test_a_torque_by_a_function_is_that_of_an_effect(tmp_path, integrator) -> None:
    """By a callable object, which serves as well."""

    class Turner:
        __hash__ = None  # type: ignore[assignment]

        def __call__(self, state: Any) -> Any:
            return state.attitude.T @ np.array([0.3, 0.0, 0.5])

    chosen = [f'numerics.integrator="{integrator}"']
    listed = ["effects.constant_torque.vector=['0.3 N m', '0 N m', '0.5 N m']", "effects.constant_torque.frame='body'"]
    ds = run(loads(RIGID, chosen), tmp_path / "function", Turner())
    other = run(loads(RIGID, [*chosen, *listed]), tmp_path / "effect")
    assert list(ds.effect.values) == ["turner", "rigidity"]
    for name in ("angular_momentum", "inertia_tensor", "torque", "work"):
        assert ds[name].values == pytest.approx(other[name].values, rel=1e-8, abs=1e-8), name
    assert float(abs(ds.integration_energy_error).max()) < 1e-8


@pytest.mark.slow
def test_it_goes_on_bit_for_bit_and_only_where_it_is_given_again(tmp_path, monkeypatch) -> None:
    """Of two functions each keeps its own row of the ledger."""
    whole = run(loads(SCENE), tmp_path / "whole", upwards, cubic)
    with monkeypatch.context() as patch:
        stopped_at(patch, 16)
        with pytest.raises(RunInterrupted):
            astroinertia.run_scene(loads(SCENE), tmp_path / "parts", effects=[upwards, cubic])
    with pytest.raises(ArchiveError, match=r"with the effect 'cubic' \(the function cubic of .*, given from Python\)"):
        astroinertia.resume(tmp_path / "parts", effects=[upwards])
    parts = astroinertia.resume(tmp_path / "parts", effects=[upwards, cubic])
    assert astroinertia.open(parts).drop_vars("wall_time").equals(whole.drop_vars("wall_time"))


# What is refused


def late(value: Any) -> Any:
    """A function of a state that gives a value, or fails, once some time has passed."""

    def kick(state: Any) -> Any:
        zero = np.zeros(np.shape(getattr(state, "positions", np.zeros(3))))
        return zero if state.time < 0.2 else value(zero)

    return kick


def failing(zero: Any) -> Any:
    raise RuntimeError("no wind\ntoday")


WRONG = [
    (lambda zero: zero[..., 0], r"gave an array of the shape \((100,)?\); (acceleration|torque) must have \("),
    (lambda zero: zero + np.nan, r"gave an? (acceleration|torque) that is not finite \(effect kick, time 0\.2"),
    (failing, r"at time .* failed \(RuntimeError: no wind\?today\)\.$"),
    (lambda zero: "much", r"gave no real numbers, but str"),
    (lambda zero: None, r"gave no real numbers, but object"),
    (lambda zero: zero * u.kg, r"failed \(UnitConversionError: .*\); its state has plain numbers in code units\.$"),
]


CASES = [
    *((SCENE, [], *wrong) for wrong in WRONG),
    pytest.param(SCENE, ['numerics.engine="xla"'], *WRONG[2], marks=pytest.mark.full),
    pytest.param(RIGID, ["output.series_every='0.1 s'"], *WRONG[2], marks=pytest.mark.full),
    pytest.param(
        RIGID,
        ["output.series_every='0.1 s'"],
        lambda zero: zero + 3.0 * u.km,
        r"; its state has plain numbers in SI\.$",
        marks=pytest.mark.full,
    ),
]


@pytest.mark.parametrize(("text", "settings", "value", "sentence"), CASES)
def test_what_a_function_does_wrong_is_said_in_a_sentence(tmp_path, capfd, text, settings, value, sentence) -> None:
    with pytest.raises(AstroinertiaError, match=f"the function 'kick'.*{sentence}"):
        run(loads(text, settings), tmp_path / "run", late(value))
    assert "Traceback" not in capfd.readouterr().err
    kept = astroinertia.open(tmp_path / "run").time.values  # what was recorded before
    assert kept[0] == 0.0 and 0.09 < kept[-1] < 0.21


def brake(state):
    """Of a module, as pickles need it."""
    return -0.1 * state.velocities


def test_a_scene_with_a_function_can_be_pickled() -> None:
    """As processes hand it on: the function stands for the class that is made of it."""
    body = {"kind": "uniform", "mass": 1.0, "radius": 1.0, "particles": 64}
    gas = {"kind": "ideal"}
    scene = astroinertia.Scene(name="braked", units="code", body=body, equation_of_state=gas, effects=[brake], time=1.0)
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene and again.own["brake"].made is scene.own["brake"].made
    acting = again.own["brake"].made().in_units(DIMENSIONLESS)
    assert type(pickle.loads(pickle.dumps(acting))) is type(acting)


def test_names_that_mean_something_else_are_refused(tmp_path) -> None:
    def gravity(state: Any) -> Any:
        return np.zeros((100, 3))

    with pytest.raises(SceneError, match="'gravity' is the name of a built-in one; choose another"):
        astroinertia.run_scene(loads(SCENE), tmp_path / "run", effects=[gravity])
    with pytest.raises(SceneError, match="the effect 'cubic' is given twice"):
        astroinertia.run_scene(loads(SCENE), tmp_path / "run", effects=[cubic, functools.partial(cubic)])
    _1 = lambda state: None  # noqa: E731
    _1.__name__ = "1"
    with pytest.raises(SceneError, match="the function 1 is to be named by a letter"):
        astroinertia.run_scene(loads(SCENE), tmp_path / "run", effects=[_1])
    assert not (tmp_path / "run").exists()


def test_an_ellipsoid_and_a_body_that_its_spin_deforms_take_none(tmp_path) -> None:
    scene = loads(SI, ['model="ellipsoid"'])
    with pytest.raises(SceneError, match=r"^the scene.*: \[effects\.cubic\] belongs to the model sph or rigid; "):
        astroinertia.run_scene(scene, tmp_path / "run", effects=[cubic])
    scene = load_file(ROOT / "sims" / "chandler_wobble.toml")
    with pytest.raises(SceneError, match=r"cubic\] is a function, whose change with time the effect rotational_def"):
        astroinertia.run_scene(scene, tmp_path / "run", effects=[cubic])
